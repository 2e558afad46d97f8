// Internal to the importers: VTK data objects to nodes and mesh items (vtk_import.h says what becomes what).
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include <vtkSmartPointer.h>

#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/vtk/internal/vtk_surface.h"

class vtkDataObject;
class vtkDataSet;
class vtkFieldData;
class vtkPolyData;

namespace sightline::importers {

class VtkSceneBuilder {
 public:
  explicit VtkSceneBuilder(ImportJob& job) : job_(job), names_(job) {}

  /// Items begin to end - 1.
  struct Items {
    core::ItemId begin{0}, end{0};
  };
  /// Hangs what `data` holds on `node`. Keeps data sets, to recognise them again, until the builder is destroyed or
  /// forget() is called.
  core::Expected<Items> add(core::NodeId node, vtkDataObject& data, const Share& share);
  /// Hangs instances of the same meshes on another node.
  void add_again(core::NodeId node, Items items);
  void forget() { known_.clear(), kept_.clear(); }
  /// What decodes names and attributes.
  NameDecoder& names() { return names_; }

 private:
  struct Pending;

  core::Expected<void> add_data_set(core::NodeId node, vtkDataSet& data, const Share& share);
  core::Expected<void> add_faces(core::NodeId node, vtkPolyData& surface);
  void expand(const Pending& composite, std::vector<Pending>& pending);
  void set_attributes(core::NodeId node, vtkFieldData* fields);
  std::string text_of(const char* text);  ///< null: empty

  ImportJob& job_;
  NameDecoder names_;
  std::unordered_map<vtkDataSet*, Items> known_;
  std::vector<vtkSmartPointer<vtkDataSet>> kept_;  // keeps the keys of known_ alive
  std::size_t attributes_ = 0;
};

}  // namespace sightline::importers
