// Files as VTK's own writers make them, in every form: tests read them, and damage them.
#pragma once

#include <map>
#include <string>

#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyDataWriter.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "sightline/tests/importers/vtk_samples.h"

namespace sightline::tests {

inline constexpr double kVtkFarAway = 1e7;

/// Adds one of everything that a file can hold beside its cells.
inline void decorate(vtkDataSet& data) {
  vtkNew<vtkFloatArray> normals, pressure;
  vtkNew<vtkUnsignedCharArray> colours;
  vtkNew<vtkIntArray> material;
  normals->SetName("normals");
  normals->SetNumberOfComponents(3);
  pressure->SetName("pressure");
  colours->SetName("Colors");
  colours->SetNumberOfComponents(3);
  for (vtkIdType i = 0; i < data.GetNumberOfPoints(); ++i) {
    normals->InsertNextTuple3(0, 0.6, 0.8);
    pressure->InsertNextValue(0.1f * float(i));
    colours->InsertNextTuple3(255, 51, 0);
  }
  material->SetName("material");
  for (vtkIdType i = 0; i < data.GetNumberOfCells(); ++i) material->InsertNextValue(int(i) % 3);
  data.GetPointData()->SetNormals(normals);
  data.GetPointData()->SetScalars(colours);
  data.GetPointData()->AddArray(pressure);
  data.GetCellData()->AddArray(material);
  vtkNew<vtkStringArray> maker;
  maker->SetName("made by");
  maker->InsertNextValue("us, 100%");
  maker->InsertNextValue("them");
  data.GetFieldData()->AddArray(maker);
}

template <class Writer>
std::string written(Writer& writer) {
  writer.WriteToOutputStringOn();
  writer.Write();
  if constexpr (requires { writer.GetOutputStdString(); })  // the other one ends with the first 0
    return writer.GetOutputStdString();
  else
    return writer.GetOutputString();
}

template <class Writer>
void add_legacy(std::map<std::string, std::string>& files, const std::string& stem, vtkDataSet& data) {
  for (const bool binary : {false, true}) {
    for (const int version : {42, 51}) {
      vtkNew<Writer> writer;
      writer->SetInputData(&data);
      if (binary) writer->SetFileTypeToBinary();
      writer->SetFileVersion(version);
      files[stem + (binary ? "_binary" : "_ascii") + std::to_string(version) + ".vtk"] = written(*writer);
    }
  }
}

template <class Writer>
void add_xml(std::map<std::string, std::string>& files, const std::string& stem, const std::string& extension,
             vtkDataSet& data) {
  const auto add = [&](const std::string& form, auto&& set) {
    vtkNew<Writer> writer;
    writer->SetInputData(&data);
    writer->SetCompressorTypeToNone();
    set(*writer);
    files[stem + "_" + form + extension] = written(*writer);
  };
  add("ascii", [](Writer& w) { w.SetDataModeToAscii(); });
  add("inline", [](Writer& w) { w.SetDataModeToBinary(); });
  add("base64", [](Writer& w) { w.SetDataModeToAppended(); });
  add("raw", [](Writer& w) { w.SetDataModeToAppended(), w.EncodeAppendedDataOff(); });
  add("zlib", [](Writer& w) { w.SetDataModeToAppended(), w.EncodeAppendedDataOff(), w.SetCompressorTypeToZLib(); });
  add("inline_zlib", [](Writer& w) { w.SetDataModeToBinary(), w.SetCompressorTypeToZLib(); });
  add("lz4", [](Writer& w) { w.SetDataModeToAppended(), w.SetCompressorTypeToLZ4(); });
  add("small_blocks", [](Writer& w) { w.SetDataModeToBinary(), w.SetCompressorTypeToZLib(), w.SetBlockSize(64); });
  add("big_endian", [](Writer& w) { w.SetDataModeToBinary(), w.SetByteOrderToBigEndian(); });
  add("wide", [](Writer& w) { w.SetDataModeToBinary(), w.SetHeaderTypeToUInt64(), w.SetCompressorTypeToZLib(); });
}

/// By name; those of grids begin with "grid". The square has lines beside it.
inline const std::map<std::string, std::string>& vtk_files() {
  static const std::map<std::string, std::string> made = [] {
    std::map<std::string, std::string> files;
    const auto cube = vtk_cube(2.0, core::dvec3(kVtkFarAway));
    decorate(*cube);
    add_legacy<vtkPolyDataWriter>(files, "poly", *cube);
    add_xml<vtkXMLPolyDataWriter>(files, "poly", ".vtp", *cube);
    const auto grid = vtk_cells(kVtkFarAway);
    decorate(*grid);
    add_legacy<vtkUnstructuredGridWriter>(files, "grid", *grid);
    add_xml<vtkXMLUnstructuredGridWriter>(files, "grid", ".vtu", *grid);
    return files;
  }();
  return made;
}

}  // namespace sightline::tests
