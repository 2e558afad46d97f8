#include <algorithm>
#include <cstring>
#include <mutex>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "sightline/importers/slc/internal/slc_levels.h"
#include "sightline/importers/slc/internal/slc_rows.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/importers/slc/internal/slc_surfaces.h"

namespace sightline::importers {
namespace {

using core::LargeArray;

bool is_of_snapshot(const SlcFile::Section& section) {
  return (section.number >= storage::kCoordinates && section.number < 1000) || section.number == kSlcSnapshotState ||
         section.number == kSlcChunkOrigins || (section.number >= kSlcJointBits && section.number <= kSlcJointOpaque);
}

SlcExpected<void> verify_where(const SlcFile& file, const SlcFile::Mapping& mapping, bool of_snapshot) {
  std::vector<SlcFile::Verified> what;
  for (const SlcFile::Section& section : file.sections())
    if (is_of_snapshot(section) == of_snapshot && section.number != kSlcLevelValues)
      what.push_back({&section, &mapping});
  return file.verify(what);
}

/// Takes arrays off the values of a mesh.
template <class T>
bool take(const LargeArray<std::byte>& values, std::uint64_t& at, std::uint32_t count, std::vector<T>& out) {
  if (at > values.size() || count > (values.size() - at) / sizeof(T)) return false;
  out.resize(count);
  if (count > 0) std::memcpy(static_cast<void*>(out.data()), values.data() + at, count * sizeof(T));
  at += count * sizeof(T);
  return true;
}

SlcExpected<void> read_meshes(const std::shared_ptr<const SlcFile>& shared, const SlcFile::Mapping& mapping,
                              core::Scene& scene) {
  const SlcFile& file = *shared;
  LargeArray<SlcMesh> rows;
  LargeArray<char> names;
  LargeArray<std::byte> values;
  if (!file.adopt(mapping, kSlcMeshes, rows) || !file.adopt(mapping, kSlcMeshNames, names) ||
      !file.adopt(mapping, kSlcMeshValues, values))
    return damaged("its meshes have another size");
  auto levels = read_levels(shared, mapping, rows.size());
  if (!levels) return tl::unexpected(levels.error());
  auto surfaces = read_surfaces(file, mapping, rows.size());
  if (!surfaces) return tl::unexpected(surfaces.error());
  std::uint64_t begin = 0, used = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SlcMesh& row = rows[i];
    if (row.name_end < begin || row.name_end > names.size()) return damaged("the names of its meshes are inconsistent");
    core::Mesh mesh;
    mesh.name.assign(names.begin() + begin, names.begin() + row.name_end);
    begin = row.name_end;
    if (row.removed != 0) {
      storage::add_removed_mesh(scene);
      continue;
    }
    std::uint64_t at = row.first;
    if (!take(values, at, row.positions, mesh.positions) || !take(values, at, row.normals, mesh.normals) ||
        !take(values, at, row.indices, mesh.indices) || !take(values, at, row.contours, mesh.contour_sizes) ||
        !take(values, at, row.polygons, mesh.polygon_contours))
      return damaged("a mesh lies outside its values");
    // Each mesh has values of its own: a small file cannot ask for much memory.
    used += at - row.first;
    if (used > values.size()) return damaged("its meshes overlap");
    mesh.extras = core::MeshExtrasSlot(
        {levels->empty() ? nullptr : std::move((*levels)[i]), surfaces->empty() ? nullptr : std::move((*surfaces)[i])});
    if (auto added = scene.add_mesh(std::move(mesh)); !added) return damaged("a mesh: " + added.error().message);
  }
  return {};
}

/// The snapshot in a file, for Snapshot(scene).
class StoredSnapshot {
 public:
  StoredSnapshot(std::shared_ptr<const SlcFile> file, SlcFile::Mapping mapping)
      : file_(std::move(file)), mapping_(std::move(mapping)) {}

  /// The first gets the mapping that is there: its pages are in memory already.
  bool fill(core::Snapshot& snapshot) {
    SlcFile::Mapping mapping;
    {
      const std::lock_guard held(mutex_);
      std::swap(mapping, mapping_);
    }
    if (mapping.data == nullptr) {
      auto fresh = file_->map();
      if (!fresh) return false;
      mapping = std::move(*fresh);
    }
    return fill(*file_, mapping, snapshot);
  }

  /// False when an array has elements of another size.
  static bool fill(const SlcFile& file, const SlcFile::Mapping& mapping, core::Snapshot& snapshot) {
    bool good = true;
    storage::for_each_snapshot_array(
        snapshot, [&](std::uint64_t number, auto& array) { good = good && file.adopt(mapping, number, array); });
    LargeArray<SlcSnapshotState> rows;
    LargeArray<core::dvec3> origins;
    good = good && file.adopt(mapping, kSlcSnapshotState, rows) && file.adopt(mapping, kSlcChunkOrigins, origins);
    const auto joints = std::make_shared<gpuprims::StoredJoints>();
    good = good && file.adopt(mapping, kSlcJointBits, joints->bits) &&
           file.adopt(mapping, kSlcJointCovers, joints->covers) && file.adopt(mapping, kSlcJointFirst, joints->first) &&
           file.adopt(mapping, kSlcJointOpaque, joints->opaque);
    if (!good || rows.size() != 1) return false;
    const SlcSnapshotState& row = rows[0];
    storage::set_state(snapshot,
                       {{row.origin[0], row.origin[1], row.origin[2]},
                        {{row.extent[0], row.extent[1], row.extent[2]}, {row.extent[3], row.extent[4], row.extent[5]}},
                        row.chunk_size,
                        {origins.begin(), origins.end()}},
                       joints);
    return true;
  }

 private:
  std::shared_ptr<const SlcFile> file_;
  std::mutex mutex_;
  SlcFile::Mapping mapping_;
};

/// Removes those that commit() would not accept.
void drop_what_cannot_be_committed(core::Scene& scene, std::span<const core::ItemId> items, ImportReport& report) {
  std::vector<core::ItemId> bad;
  scene.for_each_state(items, [&](core::ItemId item, const core::Scene::ItemState& state) {
    if (!scene.can_commit(item, state.world_from_item)) bad.push_back(item);
  });
  for (const core::ItemId item : bad) {
    if (report.warnings.size() < kMaxWarnings)
      report.warnings.push_back({{},
                                 0,
                                 fmt::format("{}: item dropped: its place or size is not finite or beyond any site",
                                             scene.path(scene.node_of(item)))});
    scene.remove_item(item);
  }
}

SlcExpected<SlcScene> load_all(const std::shared_ptr<const SlcFile>& file, bool verified) {
  const auto mapping = file->map();
  if (!mapping) return tl::unexpected(mapping.error());
  if (verified)
    if (auto good = verify_where(*file, *mapping, false); !good) return tl::unexpected(good.error());
  SlcScene loaded;
  LargeArray<char> report;
  if (!file->adopt(*mapping, kSlcReport, report)) return damaged("its report has another size");
  auto told = report_from({report.data(), report.size()});
  if (!told) return damaged(told.error().message);
  loaded.report = std::move(*told);

  core::Scene& scene = loaded.scene;
  if (auto done = read_materials(*file, *mapping, scene); !done) return tl::unexpected(done.error());
  if (auto done = read_meshes(file, *mapping, scene); !done) return tl::unexpected(done.error());
  loaded.has_levels = has_levels(*file, *mapping);
  bool good = true;
  storage::for_each_scene_array(
      scene, [&](std::uint64_t number, auto& array) { good = good && file->adopt(*mapping, number, array); });
  const auto attributes = std::make_shared<core::StoredAttributes>();
  good = good && file->adopt(*mapping, kSlcAttributeNodes, attributes->nodes) &&
         file->adopt(*mapping, kSlcAttributeEnds, attributes->ends) &&
         file->adopt(*mapping, kSlcAttributeText, attributes->text);
  if (!good) return damaged("an array has elements of another size");
  if (auto done = storage::finish(scene, attributes); !done) return damaged(done.error().message);
  if (auto done = attach_snapshot(file, scene, verified); !done) return tl::unexpected(done.error());
  if (const auto open = storage::not_surely_fit(scene); !open.empty()) {
    drop_what_cannot_be_committed(scene, open, loaded.report);
  } else {
    // Read for the checks alone.
    for (const std::uint64_t number : {std::uint64_t(storage::kItems), std::uint64_t(storage::kNames),
                                       std::uint64_t(kSlcMeshValues), std::uint64_t(kSlcAttributeText)})
      file->set_aside(*mapping, number);
  }
  return loaded;
}

core::Expected<ImportReport> read(const std::string& name, SlcExpected<std::shared_ptr<const SlcFile>> file,
                                  core::Scene& scene, core::NodeId parent, const ImportOptions& options,
                                  bool verified) {
  const auto failed = [&](const SlcProblem& problem) {
    return core::fail(fmt::format("{}: {}", name, problem.message));
  };
  if (options.progress && !options.progress(0.0)) return core::fail(std::string(kCancelled));
  if (!file) return failed(file.error());
  auto loaded = load(*file, verified);
  if (!loaded) return failed(loaded.error());
  if (options.progress && !options.progress(0.5)) return core::fail(std::string(kCancelled));
  ImportReport report = std::move(loaded->report);
  report.bytes = (*file)->size();
  const core::Scene::Mark mark = scene.mark();  // so that all its items come after those that there are
  const auto first = core::ItemId(mark.items);
  const bool moved = !is_unmoved(scene, parent);
  report.nodes = scene.append(parent, std::move(loaded->scene));
  if (moved) {
    std::vector<core::ItemId> added;
    for (core::ItemId item = first; to_index(item) < scene.item_slots(); ++item) added.push_back(item);
    drop_what_cannot_be_committed(scene, added, report);
  }
  if (options.progress) (void)options.progress(1.0);
  return report;
}

}  // namespace

SlcExpected<void> read_materials(const SlcFile& file, const SlcFile::Mapping& mapping, core::Scene& scene) {
  LargeArray<SlcMaterial> rows;
  LargeArray<char> names;
  if (!file.adopt(mapping, kSlcMaterials, rows) || !file.adopt(mapping, kSlcMaterialNames, names))
    return damaged("its materials have another size");
  std::uint64_t begin = 0;
  for (const SlcMaterial& row : rows) {
    if (row.name_end < begin || row.name_end > names.size())
      return damaged("the names of its materials are inconsistent");
    if (row.removed != 0)
      storage::add_removed_material(scene);
    else
      scene.add_material({std::string(names.begin() + begin, names.begin() + row.name_end),
                          {row.red, row.green, row.blue},
                          row.alpha,
                          row.code});
    begin = row.name_end;
  }
  return {};
}

SlcExpected<SlcScene> load(std::shared_ptr<const SlcFile> file, bool verified) {
  try {
    return load_all(file, verified);
  } catch (const std::bad_alloc&) {
    return damaged("not enough memory");
  }
}

SlcExpected<void> attach_snapshot(std::shared_ptr<const SlcFile> file, core::Scene& scene, bool verified) {
  auto mapping = file->map();
  if (!mapping) return tl::unexpected(mapping.error());
  if (verified)
    if (auto good = verify_where(*file, *mapping, true); !good) return good;
  const auto fill = [&](core::Snapshot& snapshot) { return StoredSnapshot::fill(*file, *mapping, snapshot); };
  if (auto good = storage::try_snapshot(scene, fill); !good) return damaged(good.error().message);
  const auto stored = std::make_shared<StoredSnapshot>(std::move(file), std::move(*mapping));
  storage::set_snapshot(scene, [stored](core::Snapshot& snapshot) { return stored->fill(snapshot); });
  return {};
}

bool is_unmoved(const core::Scene& scene, core::NodeId node) {
  const core::Affine world = scene.world_from_node(node), none;
  return world.linear == none.linear && world.origin == none.origin;
}

SlcExpected<std::string> sources_of(const SlcFile& file) {
  const SlcFile::Section* section = file.find(kSlcSources);
  const auto mapping = file.map();
  if (!mapping) return tl::unexpected(mapping.error());
  if (!section || section->element_size != 1) return damaged("its sources are missing");
  const SlcFile::Verified what{section, &*mapping};
  if (auto good = file.verify(std::span(&what, 1)); !good) return tl::unexpected(good.error());
  return std::string(reinterpret_cast<const char*>(mapping->data + section->offset), std::size_t(section->count));
}

core::Expected<ImportReport> read_slc(const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
                                      const ImportOptions& options) {
  return read(path.string(), SlcFile::open(path), scene, parent, options, true);
}

core::Expected<ImportReport> read_slc(std::span<const std::byte> bytes, const std::filesystem::path& name,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  // Without checksums, so that a fuzzer's changes get past them.
  return read(name.string(), SlcFile::of_bytes(bytes), scene, parent, options, false);
}

}  // namespace sightline::importers
