#include "sightline/importers/slc/internal/page_table.h"

#include <algorithm>
#include <map>
#include <memory>

#include "sightline/core/internal/sort_unique.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace sightline::importers {
namespace {

constexpr std::uint32_t kMostSlots = 1 << 15;
constexpr std::uint64_t kMostMeshBytes = 8 << 20;  // a page with more ends at the next step

struct FreeState {
  void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

/// Sums up what pages hold.
class PageSums {
 public:
  PageSums(const core::Scene& scene, const core::Snapshot& snapshot, std::span<const std::uint64_t> ends,
           std::span<const SlcMesh> meshes)
      : scene_(scene), snapshot_(snapshot), meshes_(meshes), state_(XXH3_createState()) {
    storage::for_each_snapshot_array(snapshot, [&](std::uint64_t number, const auto& array) {
      arrays_[number] = {std::as_bytes(std::span(array.data(), array.size())), sizeof(array.data()[0])};
    });
    arrays_[kSlcSlotEnds] = {std::as_bytes(ends), sizeof(ends[0])};
  }

  /// Numbers of the meshes of a page.
  std::vector<std::uint32_t> meshes_of(const SlcPage& page) const {
    std::vector<std::uint32_t> used;
    for (int kind = core::kPrimitiveKindCount; kind < core::kKindCount; ++kind) {
      const auto& meshes = snapshot_.of_kind(core::Kind(kind)).meshes;
      const auto first = meshes.begin() + page.kind_first[kind];
      used.insert(used.end(), first, first + page.kind_count[kind]);
    }
    core::sort_unique(used);
    return used;
  }

  void begin(const SlcPage& page) {
    XXH3_64bits_reset(state_.get());
    for (const SlcSlice& slice : slices(page, snapshot_.bounds().uses_layers())) {
      const auto& [bytes, size] = arrays_.at(slice.number);
      add(bytes.subspan(slice.first * size, std::size_t(slice.count) * size));
    }
  }
  void add(std::span<const std::byte> bytes) { XXH3_64bits_update(state_.get(), bytes.data(), bytes.size()); }
  void add_mesh(std::uint32_t number) {
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_at(number));
    add(std::as_bytes(meshes_.subspan(number, 1)));
    const auto values = [&](const auto& of) { add(std::as_bytes(std::span(of))); };
    values(mesh.positions), values(mesh.normals), values(mesh.indices);
    values(mesh.contour_sizes), values(mesh.polygon_contours);
  }
  std::uint64_t end() const { return XXH3_64bits_digest(state_.get()); }

 private:
  const core::Scene& scene_;
  const core::Snapshot& snapshot_;
  std::span<const SlcMesh> meshes_;
  std::map<std::uint64_t, std::pair<std::span<const std::byte>, std::size_t>> arrays_;
  std::unique_ptr<XXH3_state_t, FreeState> state_;
};

/// Lays out the pages of one scene.
class TableMaker {
 public:
  TableMaker(const core::Scene& scene, const core::Snapshot& snapshot, const gpuprims::StoredJoints& joints,
             std::span<const SlcMesh> meshes)
      : scene_(scene), snapshot_(snapshot), joints_(joints), meshes_(meshes), last_page_(meshes.size()) {}

  PageTable run() {
    for (core::Slot first = 0; first < snapshot_.size(); first += core::kBlockSlots) add_leaf(first);
    cut();
    PageSums sums(scene_, snapshot_, table_.ends, meshes_);
    for (SlcPage& page : table_.pages) {
      sums.begin(page);
      for (const std::uint32_t mesh : sums.meshes_of(page)) sums.add_mesh(mesh);
      page.checksum = sums.end();
    }
    return std::move(table_);
  }

 private:
  core::Slot leaf_end(core::Slot first) const {
    return std::min(core::Slot(snapshot_.size()), first + core::kBlockSlots);
  }

  void add_leaf(core::Slot first) {
    core::Aabb box;
    std::uint64_t ends = 0;
    std::uint32_t lines = 0;
    glm::dvec3 sum(0.0);
    double weight = 0.0;
    for (core::Slot slot = first; slot < leaf_end(first); ++slot) {
      const core::ItemId item = snapshot_.item(slot);
      if (to_index(item) / 32 < joints_.bits.size())
        ends |= (joints_.bits[to_index(item) / 32] >> 2 * (to_index(item) % 32) & 3u) << 2 * (slot - first);
      if (snapshot_.vacant(slot)) continue;
      const core::Aabb own = snapshot_.bounds().box(slot);
      box.grow(own);
      if (snapshot_.kind(slot) == core::Kind::kLine) lines = core::PagedScene::kHasLines;
      const glm::dvec3 size(own.max - own.min);
      const double area = size.x * size.y + size.y * size.z + size.z * size.x + 1e-9;
      const std::uint32_t material = snapshot_.material(slot);
      sum += area * glm::dvec3(material == core::kNone ? core::Material().colour
                                                       : core::vec3(snapshot_.materials()[material]));
      weight += area;
    }
    const glm::uvec3 colour =
        weight > 0.0 ? glm::uvec3(glm::clamp(sum / weight, 0.0, 1.0) * 255.0 + 0.5) : glm::uvec3(0);
    table_.boxes.push_back({box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z});
    table_.colours.push_back(colour.r | colour.g << 8 | colour.b << 16 | lines);
    table_.ends.push_back(ends);
  }

  /// Pages of up to kMostSlots, fewer where their meshes are large.
  void cut() {
    std::array<std::uint32_t, core::kKindCount> rank{};
    const core::Slot n = core::Slot(snapshot_.size());
    for (core::Slot first = 0; first < n;) {
      SlcPage page{};
      page.first = first;
      std::copy(rank.begin(), rank.end(), page.kind_first);
      const auto number = std::uint32_t(table_.pages.size());
      core::Slot end = first;
      while (end < n && end - first < kMostSlots && page.mesh_bytes < kMostMeshBytes)
        for (const core::Slot stop = std::min(n, end + kPageStep); end < stop; ++end) add_slot(end, number, page);
      page.count = end - first;
      for (std::size_t k = 0; k < rank.size(); ++k) rank[k] += page.kind_count[k];
      table_.pages.push_back(page);
      first = end;
    }
  }

  void add_slot(core::Slot slot, std::uint32_t number, SlcPage& page) {
    const core::Kind kind = snapshot_.kind(slot);
    ++page.kind_count[std::size_t(kind)];
    if (int(kind) < core::kPrimitiveKindCount) return;
    const std::uint32_t mesh = snapshot_.of_kind(kind).meshes[snapshot_.index_in_kind(slot)];
    if (std::exchange(last_page_[mesh], number + 1) == number + 1) return;
    page.mesh_positions += meshes_[mesh].positions;
    page.mesh_indices += meshes_[mesh].indices;
    page.mesh_bytes += value_bytes(meshes_[mesh]);
  }

  const core::Scene& scene_;
  const core::Snapshot& snapshot_;
  const gpuprims::StoredJoints& joints_;
  std::span<const SlcMesh> meshes_;
  std::vector<std::uint32_t> last_page_;  // by mesh: one more than the last page that uses it
  PageTable table_;
};

}  // namespace

std::uint64_t value_bytes(const SlcMesh& mesh) {
  return (std::uint64_t(mesh.positions) + mesh.normals) * sizeof(core::vec3) +
         (std::uint64_t(mesh.indices) + mesh.contours + mesh.polygons) * sizeof(std::uint32_t);
}

std::uint64_t value_bytes(const SlcCoarseMesh& mesh) {
  return (std::uint64_t(mesh.positions) + mesh.normals) * sizeof(core::vec3) +
         std::uint64_t(mesh.indices) * sizeof(std::uint32_t) +
         std::uint64_t(mesh.deviations) * sizeof(core::MeshDeviation);
}

std::vector<SlcSlice> slices(const SlcPage& page, bool layers) {
  std::vector<SlcSlice> all;
  for (const std::uint64_t number : storage::kPageArrays)
    if (number != storage::kLayers || layers) all.push_back({number, page.first, page.count});
  all.push_back(
      {kSlcSlotEnds, page.first / core::kBlockSlots, (page.count + core::kBlockSlots - 1) / core::kBlockSlots});
  for (int kind = 0; kind < core::kKindCount; ++kind) {
    const std::uint64_t first = page.kind_first[kind], count = page.kind_count[kind];
    if (count == 0) continue;
    const std::uint64_t arrays = storage::kKindArrays + 4 * std::uint64_t(kind);
    all.push_back({arrays + 1, first, count});
    if (kind < core::kPrimitiveKindCount) {
      const auto values = std::uint64_t(core::parameter_count(core::Kind(kind)));
      all.push_back({arrays + 2, first * values, count * values});
    } else {
      all.push_back({arrays + 3, first, count});
    }
  }
  return all;
}

PageTable make_page_table(const core::Scene& scene, const core::Snapshot& snapshot,
                          const gpuprims::StoredJoints& joints, std::span<const SlcMesh> meshes) {
  return TableMaker(scene, snapshot, joints, meshes).run();
}

std::vector<SlcCoarsePage> coarse_pages(const core::Scene& scene, const core::Snapshot& snapshot,
                                        const PageTable& table, std::span<const SlcMesh> meshes,
                                        const CoarseMeshes& coarse) {
  PageSums sums(scene, snapshot, table.ends, meshes);
  std::vector<SlcCoarsePage> pages;
  for (const SlcPage& page : table.pages) {
    SlcCoarsePage& made = pages.emplace_back();
    const std::vector<std::uint32_t> used = sums.meshes_of(page);
    for (const std::uint32_t i : used) {
      const SlcCoarseMesh& row = coarse.rows[i];
      const bool own = row.positions > 0;
      made.mesh_positions += own ? row.positions : meshes[i].positions;
      made.mesh_indices += own ? row.indices : meshes[i].indices;
      made.mesh_bytes += own ? value_bytes(row) : value_bytes(meshes[i]);
      made.deviations += row.deviations;
      made.level_indices += coarse.level_indices[i];
    }
    if (made.mesh_bytes > page.mesh_bytes / 2) made = {0, 0, 0, 0, made.level_indices, 0};
    if (made.mesh_bytes == 0) continue;
    sums.begin(page);
    for (const std::uint32_t i : used) {
      const SlcCoarseMesh& row = coarse.rows[i];
      sums.add(std::as_bytes(std::span(&row, 1)));
      if (row.positions == 0) sums.add_mesh(i);
      sums.add(std::span(coarse.values).subspan(row.first, row.positions > 0 ? value_bytes(row) : 0));
    }
    made.checksum = sums.end();
  }
  return pages;
}

}  // namespace sightline::importers
