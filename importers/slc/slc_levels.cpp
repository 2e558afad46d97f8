#include "sightline/importers/slc/internal/slc_levels.h"

#include <algorithm>
#include <new>

#include "sightline/core/mesh_extras.h"
#include "sightline/lod/coarse_mesh.h"
#include "sightline/lod/internal/each_mesh.h"

namespace sightline::importers {
namespace {

constexpr std::size_t kTrianglesAtOnce = 1 << 20;  // of meshes whose levels are in memory together

/// Levels of one mesh, which stay in the file.
class LevelsInFile : public core::StoredBytes {
 public:
  LevelsInFile(std::shared_ptr<const SlcFile> file, std::uint64_t offset, const SlcLevels& row)
      : file_(std::move(file)), offset_(offset), row_(row) {}

  core::Expected<std::vector<std::byte>> bytes() const override {
    std::vector<std::byte> bytes(std::size_t(row_.bytes));
    if (auto done = file_->read(offset_ + row_.first, bytes); !done) return core::fail(done.error().message);
    if (slc_checksum(bytes) != row_.checksum) return core::fail("levels of a mesh do not match their checksum");
    return bytes;
  }

 private:
  std::shared_ptr<const SlcFile> file_;
  std::uint64_t offset_;
  SlcLevels row_;
};

struct Written {
  std::vector<std::byte> bytes;  // empty: it has no levels
  std::size_t indices = 0;
  lod::CoarseMesh coarse;
};

Written levels_of(const core::Mesh& mesh, bool build, int threads) {
  if (const core::StoredBytes* stored = core::bytes_stored_with(mesh))
    if (auto bytes = stored->bytes())
      if (const auto levels = lod::decode(*bytes, mesh))
        return {std::move(*bytes), levels->indices.size(), lod::coarsest(mesh, *levels)};
  if (!build) return {};
  const lod::MeshLevels levels = lod::build_levels(mesh, threads);
  return levels.empty() ? Written() : Written{lod::encode(levels), levels.indices.size(), lod::coarsest(mesh, levels)};
}

void append(CoarseMeshes& to, std::uint32_t number, const lod::CoarseMesh& coarse) {
  const core::Mesh& mesh = coarse.mesh;
  if (coarse.deviations.empty()) return;  // the mesh itself
  to.rows[number] = {to.values.size(), std::uint32_t(mesh.positions.size()), std::uint32_t(mesh.normals.size()),
                     std::uint32_t(mesh.indices.size()), std::uint32_t(coarse.deviations.size())};
  const auto put = [&](const auto& values) {
    const auto bytes = std::as_bytes(std::span(values));
    to.values.insert(to.values.end(), bytes.begin(), bytes.end());
  };
  put(mesh.positions), put(mesh.normals), put(mesh.indices), put(coarse.deviations);
}

}  // namespace

bool write_levels(const core::Scene& scene, std::span<const std::uint32_t> meshes, bool build,
                  const std::function<bool(double)>& progress, SlcWriter& out, CoarseMeshes& coarse) {
  std::vector<const core::Mesh*> wanted;
  std::vector<std::uint32_t> numbers;  // of these
  std::vector<SlcLevels> rows(scene.mesh_slots());
  std::uint64_t triangles = 0, done = 0, at = 0;
  for (const std::uint32_t number : meshes) {
    const core::MeshId id = scene.mesh_at(number);
    if (!id.valid()) continue;
    const core::Mesh& mesh = scene.mesh(id);
    if (!core::bytes_stored_with(mesh) && !(build && lod::needs_levels(mesh))) continue;
    wanted.push_back(&mesh);
    numbers.push_back(number);
    triangles += wanted.back()->indices.size() / 3;
  }
  if (wanted.empty() && !build) return true;
  out.begin(kSlcLevelValues, 1);
  coarse.rows.resize(scene.mesh_slots());
  coarse.level_indices.resize(scene.mesh_slots());
  std::vector<Written> written;
  for (std::size_t first = 0, end = 0; first < wanted.size(); first = end) {
    if (progress && !progress(double(done) / double(std::max<std::uint64_t>(triangles, 1)))) return false;
    for (std::size_t some = 0; end < wanted.size() && some < kTrianglesAtOnce; ++end)
      some += wanted[end]->indices.size() / 3, done += wanted[end]->indices.size() / 3;
    const auto part = std::span<const core::Mesh* const>(wanted).subspan(first, end - first);
    written.assign(part.size(), {});
    lod::for_each_mesh(part, [&](std::size_t i, int threads) { written[i] = levels_of(*part[i], build, threads); });
    for (std::size_t i = 0; i < written.size(); ++i) {
      const std::vector<std::byte>& bytes = written[i].bytes;
      if (bytes.empty()) continue;
      rows[numbers[first + i]] = {at, bytes.size(), slc_checksum(bytes)};
      out.append(bytes);
      coarse.level_indices[numbers[first + i]] = std::uint32_t(written[i].indices);
      at += bytes.size();
      // What tells facet groups from other meshes are their polygons, which a coarse one has not.
      if (!part[i]->is_facet_group()) append(coarse, numbers[first + i], written[i].coarse);
    }
  }
  out.end();
  out.add(kSlcLevels, rows);
  out.add(kSlcLevelsVersion, std::span(&lod::kLevelsVersion, 1));
  return true;
}

bool has_levels(const SlcFile& file, const SlcFile::Mapping& mapping) {
  core::LargeArray<std::uint32_t> version;
  return file.adopt(mapping, kSlcLevelsVersion, version) && version.size() == 1 && version[0] == lod::kLevelsVersion;
}

SlcExpected<std::vector<std::shared_ptr<const core::StoredBytes>>> read_levels(
    const std::shared_ptr<const SlcFile>& file, const SlcFile::Mapping& mapping, std::size_t mesh_count) {
  std::vector<std::shared_ptr<const core::StoredBytes>> levels;
  if (!has_levels(*file, mapping)) return levels;
  core::LargeArray<SlcLevels> rows;
  const SlcFile::Section* values = file->find(kSlcLevelValues);
  if (!file->adopt(mapping, kSlcLevels, rows) || rows.size() != mesh_count || !values || values->element_size != 1)
    return damaged("its levels of detail have another size");
  levels.resize(mesh_count);
  std::uint64_t used = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SlcLevels& row = rows[i];
    if (row.bytes == 0) continue;
    if (row.bytes > values->count || row.first > values->count - row.bytes)
      return damaged("its levels of detail are inconsistent");
    // Each has bytes of its own: a small file cannot ask for much memory.
    if ((used += row.bytes) > values->count) return damaged("its levels of detail overlap");
    levels[i] = levels_in_file(file, *values, row);
  }
  return levels;
}

std::shared_ptr<const core::StoredBytes> levels_in_file(std::shared_ptr<const SlcFile> file,
                                                        const SlcFile::Section& values, const SlcLevels& row) {
  return std::make_shared<LevelsInFile>(std::move(file), values.offset, row);
}

}  // namespace sightline::importers
