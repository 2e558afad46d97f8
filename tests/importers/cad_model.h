// Documents of parts and assemblies that Open CASCADE writes as STEP, IGES and BREP, for tests of their reader.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepTools.hxx>
#include <IGESCAFControl_Writer.hxx>
#include <IGESControl_Controller.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <TDF_Label.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_LayerTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <unistd.h>

namespace sightline::tests {

/// A folder that is empty at first and gone afterwards.
class CadFolder {
 public:
  CadFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sightline_cad_test_XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~CadFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  CadFolder(const CadFolder&) = delete;
  CadFolder& operator=(const CadFolder&) = delete;
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
inline void write_text(const std::filesystem::path& path, std::string_view text) {
  std::ofstream(path, std::ios::binary) << text;
}
/// Replaces what must be there; all of it.
inline std::string replaced(std::string text, std::string_view from, std::string_view to) {
  std::size_t at = text.find(from);
  if (at == std::string::npos) std::abort();
  for (; at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
  return text;
}

inline gp_Trsf moved(double x, double y, double z) {
  gp_Trsf by;
  by.SetTranslation(gp_Vec(x, y, z));
  return by;
}
inline TopoDS_Shape cad_box(double x, double y, double z) {
  return BRepPrimAPI_MakeBox(x, y, z).Solid();
}
/// No primitive: 20 x 20 x `height` with a hole.
inline TopoDS_Shape cad_drilled_box(double height = 10.0, double radius = 5.0) {
  const gp_Ax2 axis(gp_Pnt(10, 10, -1), gp_Dir(0, 0, 1));
  return BRepAlgoAPI_Cut(cad_box(20, 20, height), BRepPrimAPI_MakeCylinder(axis, radius, height + 2).Solid()).Shape();
}

class CadModel {
 public:
  CadModel() {
    Message::DefaultMessenger()->ChangePrinters().Clear();  // writers would tell what they do
    XCAFApp_Application::GetApplication()->NewDocument("BinXCAF", document);
    shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
    colours = XCAFDoc_DocumentTool::ColorTool(document->Main());
    layers = XCAFDoc_DocumentTool::LayerTool(document->Main());
  }
  ~CadModel() { XCAFApp_Application::GetApplication()->Close(document); }
  CadModel(const CadModel&) = delete;
  CadModel& operator=(const CadModel&) = delete;

  static void name(const TDF_Label& label, const char* utf8) {
    TDataStd_Name::Set(label, TCollection_ExtendedString(utf8, Standard_True));
  }
  TDF_Label part(const TopoDS_Shape& shape, const char* utf8) const {
    const TDF_Label label = shapes->AddShape(shape, Standard_False);
    name(label, utf8);
    return label;
  }
  TDF_Label assembly(const char* utf8) const {
    const TDF_Label label = shapes->NewShape();
    name(label, utf8);
    return label;
  }
  TDF_Label use(const TDF_Label& in, const TDF_Label& part, const char* utf8, const gp_Trsf& at = {}) const {
    const TDF_Label label = shapes->AddComponent(in, part, TopLoc_Location(at));
    name(label, utf8);
    return label;
  }
  /// sRGB.
  void colour(const TDF_Label& of, double r, double g, double b, float alpha = 1.0f) const {
    colours->SetColor(of, Quantity_ColorRGBA(Quantity_Color(r, g, b, Quantity_TOC_sRGB), alpha), XCAFDoc_ColorSurf);
  }
  void face_colour(const TDF_Label& part, const TopoDS_Shape& face, double r, double g, double b) const {
    TDF_Label label;
    shapes->AddSubShape(part, face, label);
    colour(label, r, g, b);
  }

  void write_step(const std::filesystem::path& path, const char* unit = "MM", const char* schema = "AP214IS") const {
    shapes->UpdateAssemblies();
    STEPCAFControl_Controller::Init();
    Interface_Static::SetCVal("write.step.schema", schema);
    Interface_Static::SetCVal("write.step.unit", unit);
    STEPCAFControl_Writer writer;
    writer.SetSHUOMode(Standard_True);
    if (!writer.Transfer(document) || writer.Write(path.c_str()) != IFSelect_RetDone) std::abort();
  }
  void write_iges(const std::filesystem::path& path, const char* unit = "MM") const {
    shapes->UpdateAssemblies();
    IGESControl_Controller::Init();
    Interface_Static::SetCVal("write.iges.unit", unit);
    Interface_Static::SetIVal("write.iges.brep.mode", 1);
    IGESCAFControl_Writer writer;
    if (!writer.Transfer(document) || !writer.Write(path.c_str())) std::abort();
  }

  Handle(TDocStd_Document) document;
  Handle(XCAFDoc_ShapeTool) shapes;
  Handle(XCAFDoc_ColorTool) colours;
  Handle(XCAFDoc_LayerTool) layers;
};

}  // namespace sightline::tests
