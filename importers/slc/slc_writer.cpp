#include "sightline/importers/slc/slc_writer.h"

#include <optional>
#include <string>
#include <type_traits>

#include <fmt/format.h>

#include "sightline/gpuprims/internal/joints.h"
#include "sightline/importers/slc/internal/page_table.h"
#include "sightline/importers/slc/internal/slc_levels.h"
#include "sightline/importers/slc/internal/slc_rows.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/importers/slc/internal/slc_surfaces.h"

namespace sightline::importers {
namespace {

bool is_plain(const core::Scene& scene, core::NodeId node) {
  const core::Affine& t = scene.transform(node);
  const core::Affine none;
  return t.linear == none.linear && t.origin == none.origin && scene.layers(node) == core::kLayerModel &&
         scene.visible(node) && !scene.material(node).valid();
}

/// A copy whose root has nothing that its children would inherit.
core::Scene with_plain_root(const core::Scene& scene) {
  core::Scene copy = scene;
  const core::NodeId root = copy.root();
  for (core::NodeId top = copy.first_child(root); top.valid(); top = copy.next_sibling(top)) {
    copy.set_transform(top, copy.transform(root) * copy.transform(top));
    if (copy.layers(top) == 0) copy.set_layers(top, copy.layers(root));
    if (!copy.material(top).valid()) copy.set_material(top, copy.material(root));
    if (!copy.visible(root)) copy.set_visible(top, false);
  }
  copy.set_transform(root, {});
  copy.set_layers(root, core::kLayerModel);
  copy.set_material(root, {});
  copy.set_visible(root, true);
  return copy;
}

ImportReport report_of(const core::Scene& scene) {
  ImportReport report;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
    if (!scene.contains_item(item)) continue;
    const core::Kind kind = scene.kind(item);
    ++report.items[std::size_t(kind)];
    report.degenerate += int(kind) < core::kPrimitiveKindCount ? core::is_degenerate(scene.primitive(item))
                                                               : scene.mesh(scene.mesh_of(item)).indices.empty();
  }
  return report;
}

class SceneWriter {
 public:
  SceneWriter(const core::Scene& scene, core::AtomicFile& file, const SlcWriteOptions& options)
      : scene_(scene), snapshot_(scene), options_(options), out_(file) {}

  /// False when cancelled.
  bool run(const ImportReport& report, std::string_view sources) {
    text(kSlcReport, to_text(report));
    text(kSlcSources, sources);
    materials();
    meshes();
    if (!tell(0.1)) return false;
    // The arrays that an image needs come first, and the names last.
    storage::for_each_snapshot_array(snapshot_, [&](std::uint64_t number, const auto& array) { add(number, array); });
    snapshot_state();
    joints_and_pages();
    if (!tell(0.5)) return false;
    storage::for_each_scene_array(scene_, [&](std::uint64_t number, const auto& array) { add(number, array); });
    attributes();
    write_surfaces(scene_, out_);
    const auto levels_progress = [&](double share) { return tell(1.0 + share * (1.0 / before_levels() - 1.0)); };
    CoarseMeshes coarse;
    if (!write_levels(scene_, meshes_by_slot(), options_.levels, levels_progress, out_, coarse)) return false;
    if (!coarse.values.empty()) coarse_meshes(coarse);
    out_.finish();
    return true;
  }

 private:
  /// `share`: of all but the levels.
  bool tell(double share) { return !options_.progress || options_.progress(0.99 * share * before_levels()); }
  double before_levels() const { return options_.levels ? 0.05 : 1.0; }

  void text(std::uint64_t number, std::string_view bytes) {
    out_.begin(number, 1);
    out_.append(std::as_bytes(std::span(bytes)));
    out_.end();
  }

  template <class Array>
  void add(std::uint64_t number, const Array& array) {
    using T = typename Array::value_type;
    constexpr std::size_t kPiece = 1 << 14;
    out_.begin(number, sizeof(T));
    piece_.resize(std::min(array.size(), kPiece) * sizeof(T));
    for (std::size_t i = 0; i < array.size(); i += kPiece) {
      const std::size_t count = std::min(kPiece, array.size() - i);
      storage::copy_clean(array.data() + i, count, piece_.data());
      out_.append(std::span<const std::byte>(piece_).first(count * sizeof(T)));
    }
    out_.end();
  }

  void materials() {
    std::vector<SlcMaterial> rows;
    std::string names;
    for (std::size_t i = 0; i < scene_.material_slots(); ++i) {
      const core::MaterialId id = scene_.material_at(i);
      const core::Material m = id.valid() ? scene_.material(id) : core::Material();
      names += m.name;
      rows.push_back({m.colour.x, m.colour.y, m.colour.z, m.alpha, m.code, !id.valid(), names.size()});
    }
    out_.add(kSlcMaterials, rows);
    text(kSlcMaterialNames, names);
  }

  /// Values lie in the order in which the slots use them, so that a range of slots needs few ranges of the file.
  std::vector<std::uint32_t> meshes_by_slot() const {
    std::vector<std::uint32_t> order;
    std::vector<bool> taken(scene_.mesh_slots());
    const auto take = [&](std::uint32_t mesh) {
      if (!taken[mesh]) order.push_back(mesh);
      taken[mesh] = true;
    };
    for (core::Slot slot = 0; slot < snapshot_.size(); ++slot)
      if (int(snapshot_.kind(slot)) >= core::kPrimitiveKindCount)
        take(snapshot_.of_kind(snapshot_.kind(slot)).meshes[snapshot_.index_in_kind(slot)]);
    for (std::uint32_t mesh = 0; mesh < scene_.mesh_slots(); ++mesh) take(mesh);
    return order;
  }

  void meshes() {
    std::vector<SlcMesh>& rows = mesh_rows_;
    rows.resize(scene_.mesh_slots());
    std::string names;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const core::MeshId id = scene_.mesh_at(i);
      if (id.valid()) names += scene_.mesh(id).name;
      rows[i].name_end = names.size();
      rows[i].removed = !id.valid();
    }
    std::uint64_t at = 0;
    out_.begin(kSlcMeshValues, 1);
    const auto put = [&](const auto& values) {
      out_.append(std::as_bytes(std::span(values)));
      at += std::as_bytes(std::span(values)).size();
      return std::uint32_t(values.size());
    };
    for (const std::uint32_t i : meshes_by_slot()) {
      const core::MeshId id = scene_.mesh_at(i);
      if (!id.valid()) continue;
      const core::Mesh& mesh = scene_.mesh(id);
      rows[i].first = at;
      rows[i].positions = put(mesh.positions);
      rows[i].normals = put(mesh.normals);
      rows[i].indices = put(mesh.indices);
      rows[i].contours = put(mesh.contour_sizes);
      rows[i].polygons = put(mesh.polygon_contours);
    }
    out_.end();
    out_.add(kSlcMeshes, rows);
    text(kSlcMeshNames, names);
  }

  void snapshot_state() {
    const storage::SnapshotState s = storage::state(snapshot_);
    const core::FittedBounds fitted = snapshot_.bounds().fitted_bounds();
    const SlcSnapshotState row{
        {s.origin.x, s.origin.y, s.origin.z},
        {s.extent.min.x, s.extent.min.y, s.extent.min.z, s.extent.max.x, s.extent.max.y, s.extent.max.z},
        s.chunk_size,
        {fitted.bounds.min.x, fitted.bounds.min.y, fitted.bounds.min.z, fitted.bounds.max.x, fitted.bounds.max.y,
         fitted.bounds.max.z},
        fitted.outliers};
    out_.add(kSlcSnapshotState, std::span(&row, 1));
    out_.add(kSlcChunkOrigins, s.chunk_origins);
  }

  void joints_and_pages() {
    const gpuprims::StoredJoints all = gpuprims::Joints(snapshot_).stored(snapshot_);
    out_.add(kSlcJointBits, all.bits);
    out_.add(kSlcJointCovers, all.covers);
    out_.add(kSlcJointFirst, all.first);
    out_.add(kSlcJointOpaque, all.opaque);
    pages_ = make_page_table(scene_, snapshot_, all, mesh_rows_);
    out_.add(kSlcLeafBoxes, pages_.boxes);
    out_.add(kSlcLeafColours, pages_.colours);
    out_.add(kSlcSlotEnds, pages_.ends);
    out_.add(kSlcPages, pages_.pages);
  }

  void coarse_meshes(const CoarseMeshes& coarse) {
    out_.add(kSlcCoarseMeshes, coarse.rows);
    out_.add(kSlcCoarseValues, coarse.values);
    out_.add(kSlcCoarsePages, coarse_pages(scene_, snapshot_, pages_, mesh_rows_, coarse));
  }

  void attributes() {
    const core::StoredAttributes all = storage::attributes(scene_);
    out_.add(kSlcAttributeNodes, all.nodes);
    out_.add(kSlcAttributeEnds, all.ends);
    out_.add(kSlcAttributeText, all.text);
  }

  const core::Scene& scene_;
  const core::Snapshot snapshot_;
  const SlcWriteOptions& options_;
  SlcWriter out_;
  std::vector<std::byte> piece_;
  std::vector<SlcMesh> mesh_rows_;
  PageTable pages_;
};

}  // namespace

core::Expected<void> write_slc(const core::Scene& scene, const std::filesystem::path& path,
                               const SlcWriteOptions& options, std::string_view sources) {
  if (scene.first_item(scene.root()) != core::kNoItem)
    return core::fail(fmt::format("{}: the root has items, which a scene cache cannot hold: expected them below a node",
                                  path.string()));
  if (options.levels && !lod::builds_levels())
    return core::fail(fmt::format("{}: this build makes no levels of detail (SIGHTLINE_LOD is off)", path.string()));
  try {
    std::optional<core::Scene> plain;
    if (!is_plain(scene, scene.root())) plain = with_plain_root(scene);
    const core::Scene& all = plain ? *plain : scene;
    auto file = core::AtomicFile::create(path);
    if (!file) return tl::unexpected(file.error());
    const ImportReport report = options.report ? *options.report : report_of(all);
    if (!SceneWriter(all, *file, options).run(report, sources)) return core::fail(std::string(kCancelled));
    return file->commit();
  } catch (const std::bad_alloc&) {
    return core::fail(fmt::format("{}: not enough memory", path.string()));
  }
}

core::Expected<void> write_slc(const core::Scene& scene, const std::filesystem::path& path,
                               const SlcWriteOptions& options) {
  return write_slc(scene, path, options, {});
}

}  // namespace sightline::importers
