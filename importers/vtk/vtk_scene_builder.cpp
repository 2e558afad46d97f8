#include "sightline/importers/vtk/internal/vtk_scene_builder.h"

#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>

#include "sightline/importers/internal/face_colours.h"
#include "sightline/importers/vtk/vtk_import.h"

namespace sightline::importers {

/// An object still to be added. `depth` guards against composites that hold themselves.
struct VtkSceneBuilder::Pending {
  core::NodeId node;
  vtkSmartPointer<vtkDataObject> data;
  int depth;
};

namespace {

constexpr int kDeepestBlocks = 1000;

PackedColour colour_at(vtkUnsignedCharArray& colours, vtkIdType i) {
  const unsigned char* c = colours.GetPointer(i * colours.GetNumberOfComponents());
  return pack_colour(c[0], c[1], c[2], colours.GetNumberOfComponents() == 4 ? c[3] : 255);
}

/// The faces of one data set, and the colour of each if cells have any.
struct Faces {
  PolygonMesh mesh;
  std::vector<PackedColour> colours;
};

/// Collects polygons, and converts strips to triangles.
class FaceCollector {
 public:
  explicit FaceCollector(vtkPolyData& from)
      : points_(from.GetNumberOfPoints()), colours_(colours_of(*from.GetCellData())) {
    if (colours_ && colours_->GetNumberOfTuples() < from.GetNumberOfCells()) colours_ = nullptr;
  }

  /// `first_cell`: the data set's index of the first of `cells`. False when the array is damaged as a whole.
  bool collect(vtkCellArray* cells, vtkIdType first_cell, bool strips) {
    if (!cells || cells->GetNumberOfCells() == 0) return true;
    if (!cells->IsValid()) return false;
    const auto cell = vtk::TakeSmartPointer(cells->NewIterator());
    vtkIdType size = 0;
    const vtkIdType* ids = nullptr;
    for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
      cell->GetCurrentCell(size, ids);
      const vtkIdType id = first_cell + cell->GetCurrentCellId();
      const auto* beyond = std::find_if(ids, ids + size, [&](vtkIdType p) { return p < 0 || p >= points_; });
      if (beyond != ids + size) {
        if (bad_++ == 0) first_bad_ = fmt::format("cell {}: expected a point below {}, found {}", id, points_, *beyond);
      } else if (!strips) {
        add(id, {ids, std::size_t(size)});
      } else {
        for (vtkIdType i = 0; i + 2 < size; ++i)  // every other triangle runs the other way
          add(id, std::array{ids[i], ids[i + 1 + i % 2], ids[i + 2 - i % 2]});
      }
    }
    return true;
  }

  Faces faces;
  std::size_t bad() const { return bad_; }
  const std::string& first_bad() const { return first_bad_; }

 private:
  void add(vtkIdType cell, std::span<const vtkIdType> ids) {
    for (const vtkIdType id : ids) faces.mesh.corners.push_back(std::uint32_t(id));
    end_face(faces.mesh, std::uint32_t(ids.size()));
    if (colours_) faces.colours.push_back(colour_at(*colours_, cell));
  }

  const vtkIdType points_;
  vtkUnsignedCharArray* colours_;
  std::size_t bad_ = 0;
  std::string first_bad_;
};

void copy_points(vtkPolyData& from, PolygonMesh& to) {
  const vtkIdType points = from.GetNumberOfPoints();
  to.positions.resize(std::size_t(points));
  for (vtkIdType i = 0; i < points; ++i) from.GetPoint(i, &to.positions[std::size_t(i)].x);
  vtkDataArray* normals = from.GetPointData()->GetNormals();
  if (!normals || normals->GetNumberOfComponents() != 3 || normals->GetNumberOfTuples() < points) return;
  to.normals.reserve(std::size_t(points));
  std::array<double, 3> n{};
  for (vtkIdType i = 0; i < points; ++i) {
    normals->GetTuple(i, n.data());
    to.normals.emplace_back(float(n[0]), float(n[1]), float(n[2]));
  }
}

/// One for each point, or none.
std::vector<PackedColour> colours_of_points(vtkPolyData& from) {
  std::vector<PackedColour> all;
  auto* colours = colours_of(*from.GetPointData());
  if (!colours || colours->GetNumberOfTuples() < from.GetNumberOfPoints()) return all;
  all.reserve(std::size_t(from.GetNumberOfPoints()));
  for (vtkIdType i = 0; i < from.GetNumberOfPoints(); ++i) all.push_back(colour_at(*colours, i));
  return all;
}

}  // namespace

std::string VtkSceneBuilder::text_of(const char* text) {
  return text ? names_.decode(text, 0) : std::string();
}

void VtkSceneBuilder::set_attributes(core::NodeId node, vtkFieldData* fields) {
  if (!fields) return;
  for (int a = 0; a < fields->GetNumberOfArrays(); ++a) {
    auto* strings = vtkStringArray::SafeDownCast(fields->GetAbstractArray(a));
    if (!strings) continue;
    const std::string name = text_of(strings->GetName());
    for (vtkIdType i = 0; i < strings->GetNumberOfValues(); ++i) {
      if (attributes_++ == kMaxVtkAttributes) job_.warn(0, "attributes beyond the first thousand left out");
      if (attributes_ > kMaxVtkAttributes) return;
      const bool single = strings->GetNumberOfValues() == 1;
      job_.scene().set_attribute(node, single ? name : fmt::format("{}[{}]", name, i),
                                 text_of(strings->GetValue(i).c_str()));
    }
  }
}

core::Expected<void> VtkSceneBuilder::add_faces(core::NodeId node, vtkPolyData& surface) {
  const std::string name(job_.scene().name(node));
  const auto count = [](vtkCellArray* cells) { return cells ? cells->GetNumberOfCells() : 0; };
  const vtkIdType verts = count(surface.GetVerts()), lines = count(surface.GetLines()),
                  polys = count(surface.GetPolys());
  if (verts + lines > 0) job_.warn(0, fmt::format("{}: {} vertices and {} lines left out", name, verts, lines));
  FaceCollector collector(surface);
  if (surface.GetNumberOfPoints() >= vtkIdType(core::kNone))
    return job_.damage(0, fmt::format("{}: expected fewer than 2^32 points in a data set, found {}", name,
                                      surface.GetNumberOfPoints()));
  if (!collector.collect(surface.GetPolys(), verts + lines, false) ||
      !collector.collect(surface.GetStrips(), verts + lines + polys, true))
    return job_.damage(0, fmt::format("{}: expected offsets of cells that rise to their number of points", name));
  if (collector.bad() > 0) {
    auto told = job_.damage(
        0, fmt::format("{}: {} polygons or strips left out: {}", name, collector.bad(), collector.first_bad()));
    if (!told) return told;
  }
  Faces& faces = collector.faces;
  copy_points(surface, faces.mesh);
  if (faces.mesh.face_count() == 0) return {};
  if (faces.colours.empty())
    if (const auto of_points = colours_of_points(surface); !of_points.empty())
      faces.colours = colours_from_vertices(faces.mesh, of_points);
  add_coloured_meshes(job_, node, faces.mesh, faces.colours, name);
  return {};
}

void VtkSceneBuilder::add_again(core::NodeId node, Items items) {
  core::Scene& scene = job_.scene();
  for (core::ItemId item = items.begin; item < items.end; ++item) {
    scene.add_mesh_instance(node, scene.mesh_of(item), scene.placement(item), scene.item_material(item));
    ++job_.report().items[std::size_t(core::Kind::kMesh)];
    ++job_.report().shared_meshes;
  }
}

core::Expected<void> VtkSceneBuilder::add_data_set(core::NodeId node, vtkDataSet& data, const Share& share) {
  if (const auto known = known_.find(&data); known != known_.end()) {
    add_again(node, known->second);
    return {};
  }
  const auto first = core::ItemId(job_.scene().item_slots());
  vtkSmartPointer<vtkPolyData> surface = vtkPolyData::SafeDownCast(&data);
  if (!surface) {
    auto outer = outer_surface(data, share);
    if (!outer) return tl::unexpected(outer.error());
    surface = *outer;
  }
  if (auto added = add_faces(node, *surface); !added) return added;
  known_[&data] = {first, core::ItemId(job_.scene().item_slots())};
  kept_.emplace_back(&data);
  return share.progress(1.0);
}

void VtkSceneBuilder::expand(const Pending& composite, std::vector<Pending>& pending) {
  const std::size_t first = pending.size();
  vtkSmartPointer<vtkCompositeDataIterator> it;
  if (auto* tree = vtkDataObjectTree::SafeDownCast(composite.data)) {
    vtkSmartPointer<vtkDataObjectTreeIterator> children;
    children.TakeReference(tree->NewTreeIterator());
    children->VisitOnlyLeavesOff();
    children->TraverseSubTreeOff();
    it = children;
  } else {
    it.TakeReference(static_cast<vtkCompositeDataSet*>(composite.data.Get())->NewIterator());
  }
  const bool pieces = vtkPartitionedDataSet::SafeDownCast(composite.data) != nullptr;
  for (it->InitTraversal(); !it->IsDoneWithTraversal(); it->GoToNextItem()) {
    const char* name = it->HasCurrentMetaData() ? it->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME()) : nullptr;
    const core::NodeId node = pieces ? composite.node : job_.scene().add_node(composite.node, text_of(name));
    pending.push_back({node, it->GetCurrentDataObject(), composite.depth + 1});
  }
  std::reverse(pending.begin() + std::ptrdiff_t(first), pending.end());  // taken from the back
}

core::Expected<VtkSceneBuilder::Items> VtkSceneBuilder::add(core::NodeId node, vtkDataObject& data,
                                                            const Share& share) {
  const auto first = core::ItemId(job_.scene().item_slots());
  std::vector<Pending> pending{{node, &data, 0}};
  std::size_t done = 0;
  while (!pending.empty()) {
    const Pending next = std::move(pending.back());
    pending.pop_back();
    if (next.depth > kDeepestBlocks)
      return core::fail(fmt::format("{}: expected at most {} levels of blocks", job_.file(), kDeepestBlocks));
    set_attributes(next.node, next.data->GetFieldData());
    if (vtkCompositeDataSet::SafeDownCast(next.data)) {
      expand(next, pending);
    } else if (auto* data_set = vtkDataSet::SafeDownCast(next.data)) {
      const double all = double(done + 1 + pending.size());
      auto added = add_data_set(next.node, *data_set, share.part(double(done) / all, double(done + 1) / all));
      if (!added) return tl::unexpected(added.error());
      ++done;
    } else {
      job_.warn(0, fmt::format("{}: a {} holds no surface: left out", job_.scene().path(next.node),
                               next.data->GetClassName()));
    }
  }
  return Items{first, core::ItemId(job_.scene().item_slots())};
}

}  // namespace sightline::importers
