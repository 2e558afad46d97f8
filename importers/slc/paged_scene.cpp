#include "sightline/importers/slc/paged_scene.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <utility>

#include <fmt/format.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "sightline/core/internal/platform/memory.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/core/mesh_extras.h"
#include "sightline/importers/import.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/slc/internal/page_table.h"
#include "sightline/importers/slc/internal/slc_levels.h"
#include "sightline/importers/slc/internal/slc_scene.h"

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;
using core::LargeArray;
using core::Page;
using core::PagedScene;

constexpr std::size_t kLine = 64;

std::size_t in_lines(std::size_t bytes) {
  return (bytes + kLine - 1) / kLine * kLine;
}

/// Memory for arrays that go back to the system together, at once.
class Arena {
 public:
  /// Null where the system has no more.
  static std::unique_ptr<Arena> create(std::size_t bytes) {
    const std::size_t size = std::max(bytes, kLine);
    void* const memory = core::platform::reserve_pages(size);
    if (!memory) return nullptr;
    const auto release = [size](void* m) { core::platform::release_pages(m, size); };
    return std::unique_ptr<Arena>(new Arena(std::shared_ptr<void>(memory, release), static_cast<std::byte*>(memory)));
  }
  template <class T>
  void take(std::size_t count, LargeArray<T>& array) {
    array = LargeArray<T>::kept(memory_, reinterpret_cast<T*>(next_), count);
    next_ += in_lines(count * sizeof(T));
  }

 private:
  Arena(std::shared_ptr<void> memory, std::byte* next) : memory_(std::move(memory)), next_(next) {}
  std::shared_ptr<void> memory_;
  std::byte* next_;
};

class Checksum {
 public:
  Checksum() : state_(XXH3_createState()) { XXH3_64bits_reset(state_.get()); }
  void add(std::span<const std::byte> bytes) { XXH3_64bits_update(state_.get(), bytes.data(), bytes.size()); }
  std::uint64_t value() const { return XXH3_64bits_digest(state_.get()); }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_;
};

/// One file.
class PagedPart {
 public:
  /// `verified`: checksums are compared.
  static SlcExpected<std::shared_ptr<const PagedPart>> open(SlcExpected<std::shared_ptr<const SlcFile>> file,
                                                            core::ItemId first_item, bool verified = true) {
    if (!file) return tl::unexpected(file.error());
    const std::shared_ptr<PagedPart> part(new PagedPart);
    part->file_ = std::move(*file);
    part->first_item_ = first_item;
    part->verified_ = verified;
    if (auto done = part->read_resident(); !done) return tl::unexpected(done.error());
    return part;
  }

  std::size_t item_slots() const { return count(storage::kItemSlots); }
  std::size_t slots() const { return count(storage::kKinds); }
  core::FittedBounds fitted() const {
    const double* const f = state_.fitted;
    return {{{f[0], f[1], f[2]}, {f[3], f[4], f[5]}}, std::size_t(state_.outliers)};
  }
  std::span<const SlcPage> pages() const { return pages_; }
  std::span<const std::array<float, 6>> boxes() const { return boxes_; }
  std::span<const std::uint32_t> colours() const { return colours_; }
  core::dvec3 origin() const { return {state_.origin[0], state_.origin[1], state_.origin[2]}; }
  /// What only opening needs. Vectors that `= {}` is assigned to would keep their memory.
  void drop_leaves() const { boxes_ = decltype(boxes_)(), colours_ = decltype(colours_)(); }

  PagedScene::PageInfo info(std::uint32_t number) const {
    PagedScene::PageInfo made = info(pages_[number]);
    if (has_coarse()) made.level_indices = coarse_[number].level_indices;
    return made;
  }
  PagedScene::PageInfo info(const SlcPage& row) const {
    PagedScene::PageInfo info;
    info.slot_count = row.count;
    info.material_rows = std::uint32_t(materials_->snapshot.materials().size());
    std::copy(std::begin(row.kind_count), std::end(row.kind_count), info.of_kind.begin());
    info.mesh_positions = row.mesh_positions;
    info.mesh_indices = row.mesh_indices;
    // Chunks and internal end caps are small beside the rest: a word per slot is more than they take.
    info.memory_bytes = kept_bytes(row) + record_bytes(row) + row.mesh_bytes + row.count * sizeof(std::uint64_t);
    return info;
  }

  bool has_coarse() const { return !coarse_.empty(); }
  PagedScene::PageInfo coarse_info(std::uint32_t number) const {
    if (coarse_[number].mesh_bytes == 0) return {};
    PagedScene::PageInfo made = info(coarse_row(number));
    made.memory_bytes += coarse_[number].deviations * sizeof(core::MeshDeviation);
    return made;
  }

  SlcExpected<std::unique_ptr<Page>> load(std::uint32_t number, bool coarse) const {
    const SlcPage row = coarse ? coarse_row(number) : pages_[number];
    auto page = std::make_unique<Page>();
    Checksum sum;
    if (auto done = read_arrays(row, *page, sum); !done) return tl::unexpected(done.error());
    if (auto done = read_meshes(row, *page, sum, coarse); !done) return tl::unexpected(done.error());
    if (verified_ && sum.value() != row.checksum) return damaged("it does not match its checksum");
    storage::SnapshotState state = snapshot_state();
    if (auto done = keep_used_chunks(*page, state.chunk_origins); !done) return tl::unexpected(done.error());
    if (auto done = storage::finish_page(*page, std::move(state), materials_->snapshot); !done)
      return damaged(done.error().message);
    if (!number_items(*page)) return damaged("its items are inconsistent");
    return page;
  }

 private:
  struct Materials {
    core::Scene scene;
    core::Snapshot snapshot{scene};
  };

  std::size_t count(std::uint64_t number) const {
    const SlcFile::Section* section = file_->find(number);
    return section ? std::size_t(section->count) : 0;
  }

  template <class T>
  bool copy(const SlcFile::Mapping& mapping, std::uint64_t number, std::vector<T>& out) {
    LargeArray<T> mapped;
    if (!file_->adopt(mapping, number, mapped)) return false;
    out.assign(mapped.begin(), mapped.end());
    return true;
  }

  /// A page where each mesh is the coarsest.
  SlcPage coarse_row(std::uint32_t number) const {
    SlcPage row = pages_[number];
    const SlcCoarsePage& coarse = coarse_[number];
    row.mesh_positions = coarse.mesh_positions, row.mesh_indices = coarse.mesh_indices;
    row.mesh_bytes = coarse.mesh_bytes, row.checksum = coarse.checksum;
    return row;
  }

  SlcExpected<void> read_resident() {
    const auto mapping = file_->map_to_read();
    if (!mapping) return tl::unexpected(mapping.error());
    std::vector<SlcFile::Verified> what;
    for (const std::uint64_t number : {kSlcSnapshotState, kSlcChunkOrigins, kSlcMaterials, kSlcMaterialNames,
                                       kSlcLeafBoxes, kSlcLeafColours, kSlcPages, kSlcLevelsVersion, kSlcCoarsePages})
      if (const SlcFile::Section* section = file_->find(number)) what.push_back({section, &*mapping});
    if (verified_)
      if (auto good = file_->verify(what); !good) return good;
    std::vector<SlcSnapshotState> state;
    if (!copy(*mapping, kSlcSnapshotState, state) || state.size() != 1 ||
        !copy(*mapping, kSlcChunkOrigins, chunk_origins_) || !copy(*mapping, kSlcLeafBoxes, boxes_) ||
        !copy(*mapping, kSlcLeafColours, colours_) || !copy(*mapping, kSlcPages, pages_))
      return damaged("its pages have another size");
    if (has_levels(*file_, *mapping))
      if (!copy(*mapping, kSlcCoarsePages, coarse_) || (!coarse_.empty() && coarse_.size() != pages_.size()))
        return damaged("its coarse pages have another size");
    state_ = state[0];
    core::Scene scene;
    if (auto done = read_materials(*file_, *mapping, scene); !done) return done;
    materials_ = std::make_unique<Materials>();
    materials_->scene = std::move(scene);
    materials_->snapshot = core::Snapshot(materials_->scene);
    return check();
  }

  /// That pages, arrays and leaves agree, so that all slices lie within their arrays.
  SlcExpected<void> check() const {
    const std::size_t n = slots(), leaves = (n + core::kBlockSlots - 1) / core::kBlockSlots;
    if (n > item_slots() || n >= core::kNone || boxes_.size() != leaves || colours_.size() != leaves)
      return damaged("its leaves are inconsistent");
    for (const auto& box : boxes_)
      for (const float x : box)
        if (!std::isfinite(x)) return damaged("its leaves are inconsistent");
    std::uint64_t slot = 0;
    std::array<std::uint64_t, core::kKindCount> rank{};
    for (const SlcPage& page : pages_) {
      std::uint64_t members = 0;
      bool good = page.first == slot && page.first % kPageStep == 0 && page.count > 0;
      for (std::size_t k = 0; k < rank.size(); ++k) {
        good = good && page.kind_first[k] == rank[k];
        rank[k] += page.kind_count[k];
        members += page.kind_count[k];
      }
      if (!good || members != page.count || !has_values_of(page, 0)) return damaged("its pages are inconsistent");
      slot += page.count;
    }
    for (std::uint32_t i = 0; i < coarse_.size(); ++i)
      if (!has_values_of(coarse_row(i), coarse_[i].deviations) || coarse_[i].level_indices > count(kSlcLevelValues))
        return damaged("its coarse pages are inconsistent");
    const SlcPage all = whole(slot, rank);
    bool good = slot == n;
    for (const SlcSlice& slice : slices(all, has_layers())) {
      const SlcFile::Section* section = file_->find(slice.number);
      good = good && (slice.count == 0 || (section && section->count >= slice.count &&
                                           section->element_size == element_size(slice.number)));
    }
    if (!good) return damaged("its pages are inconsistent");
    if (!core::is_finite(origin()) || !(state_.chunk_size >= 0.0)) return damaged("its origin is not finite");
    for (const core::dvec3& chunk : chunk_origins_)
      if (!core::is_finite(chunk)) return damaged("its chunks are not finite");
    return {};
  }

  /// Limits on memory count on what a page says of its meshes: it must be in the file.
  bool has_values_of(const SlcPage& page, std::uint64_t deviations) const {
    const std::uint64_t present = count(kSlcMeshValues) + count(kSlcCoarseValues);
    const std::uint64_t most = std::min<std::uint64_t>(page.mesh_bytes, present);
    return page.mesh_bytes == most && page.mesh_positions <= most / sizeof(core::vec3) &&
           page.mesh_indices <= most / sizeof(std::uint32_t) && deviations <= most / sizeof(core::MeshDeviation);
  }

  static SlcPage whole(std::uint64_t slots, const std::array<std::uint64_t, core::kKindCount>& rank) {
    SlcPage all{};
    all.count = std::uint32_t(slots);
    for (std::size_t k = 0; k < rank.size(); ++k) all.kind_count[k] = std::uint32_t(rank[k]);
    return all;
  }

  static std::size_t element_size(std::uint64_t number) {
    if (number == kSlcSlotEnds) return sizeof(std::uint64_t);
    std::size_t size = 0;
    core::Scene none;
    core::Snapshot empty(none);
    storage::for_each_snapshot_array(empty, [&](std::uint64_t of, const auto& array) {
      if (of == number) size = sizeof(array.data()[0]);
    });
    return size;
  }

  bool has_layers() const { return count(storage::kLayers) > 0; }

  /// Bytes that stay until the page goes.
  std::size_t kept_bytes(const SlcPage& row) const {
    const std::size_t n = row.count;
    std::size_t bytes = 6 * in_lines((n + core::ItemBounds::kPadding) * sizeof(float)) + in_lines(n) +
                        in_lines((n / 64 + 1) * sizeof(std::array<std::uint32_t, core::kKindCount>));
    bytes += (has_layers() ? 4 : 3) * in_lines(n * sizeof(std::uint32_t));  // layers, items, materials, indices
    for (int kind = 0; kind < core::kKindCount; ++kind) {
      const std::size_t members = row.kind_count[kind];
      bytes += in_lines(members * sizeof(core::Slot));
      if (kind >= core::kPrimitiveKindCount)
        bytes += in_lines(members * sizeof(core::Placement)) + in_lines(members * sizeof(std::uint32_t));
    }
    return bytes;
  }
  /// Bytes that go after uploading.
  static std::size_t record_bytes(const SlcPage& row) {
    std::size_t bytes = 0;
    for (int kind = 0; kind < core::kPrimitiveKindCount; ++kind) {
      const std::size_t members = row.kind_count[kind];
      bytes += in_lines(members * sizeof(core::Placement)) +
               in_lines(members * std::size_t(core::parameter_count(core::Kind(kind))) * sizeof(float));
    }
    return bytes;
  }

  /// Gives the arrays of a page their sizes.
  bool allocate(const SlcPage& row, core::Snapshot& snapshot) const {
    const auto kept = Arena::create(kept_bytes(row)), records = Arena::create(record_bytes(row));
    if (!kept || !records) return false;
    const std::size_t n = row.count;
    storage::for_each_snapshot_array(snapshot, [&](std::uint64_t number, auto& array) {
      if (number >= storage::kKindArrays) {
        const std::uint64_t kind = (number - storage::kKindArrays) / 4, which = (number - storage::kKindArrays) % 4;
        const std::size_t members = row.kind_count[kind];
        const bool primitive = int(kind) < core::kPrimitiveKindCount;
        const std::size_t values = primitive ? std::size_t(core::parameter_count(core::Kind(kind))) : 0;
        const std::size_t sizes[] = {members, members, members * values, primitive ? 0 : members};
        if (sizes[which] > 0) (primitive && which != 0 ? records : kept)->take(sizes[which], array);
      } else if (number < storage::kLayers) {
        kept->take(n + core::ItemBounds::kPadding, array);
      } else if (number == storage::kRanks) {
        kept->take(n / 64 + 1, array);
      } else if (number == storage::kKinds || number == storage::kIndexInKind || number == storage::kSlotItems ||
                 number == storage::kSlotMaterials || (number == storage::kLayers && has_layers())) {
        kept->take(n, array);
      }
    });
    return true;
  }

  SlcExpected<void> read(std::uint64_t number, std::uint64_t first, std::span<std::byte> to, std::size_t element,
                         Checksum& sum) const {
    if (to.empty()) return {};
    if (auto done = file_->read(file_->find(number)->offset + first * element, to); !done) return done;
    sum.add(to);
    return {};
  }

  SlcExpected<void> read_arrays(const SlcPage& row, Page& page, Checksum& sum) const {
    if (!allocate(row, page.snapshot)) return damaged("not enough memory");
    SlcExpected<void> done;
    for (const SlcSlice& slice : slices(row, has_layers())) {
      if (slice.number == kSlcSlotEnds) {
        page.internal_end_caps.resize(std::size_t(slice.count));
        done = read(slice.number, slice.first, std::as_writable_bytes(std::span(page.internal_end_caps)),
                    sizeof(std::uint64_t), sum);
      }
      storage::for_each_snapshot_array(page.snapshot, [&](std::uint64_t number, auto& array) {
        if (number != slice.number || !done) return;
        const auto bytes = std::as_writable_bytes(std::span(array.data(), std::size_t(slice.count)));
        done = read(number, slice.first, bytes, sizeof(array.data()[0]), sum);
      });
      if (!done) return done;
    }
    return done;
  }

  /// The page's meshes, numbered anew in the order in which the file numbers them.
  SlcExpected<void> read_meshes(const SlcPage& row, Page& page, Checksum& sum, bool coarse) const {
    std::vector<std::uint32_t> used;
    for_each_mesh(page, [&](std::uint32_t& mesh) { used.push_back(mesh); });
    if (used.empty()) return {};
    core::sort_unique(used);
    // What the page says of its size bounds what a damaged file may ask for.
    MeshesLeft left{row.mesh_bytes, row.mesh_positions, row.mesh_indices};
    for (const std::uint32_t number : used) {
      bool has_own = false;
      if (coarse)
        if (auto done = read_coarse_mesh(number, page, left, sum, has_own); !done) return done;
      if (!has_own)
        if (auto done = read_mesh(number, page, left, sum); !done) return done;
      if (coarse) page.deviation_ends.push_back(std::uint32_t(page.deviations.size()));
    }
    for_each_mesh(page, [&](std::uint32_t& mesh) {
      mesh = std::uint32_t(std::lower_bound(used.begin(), used.end(), mesh) - used.begin());
    });
    return {};
  }

  struct MeshesLeft {
    std::uint64_t bytes, positions, indices;
    bool take(std::uint64_t b, std::uint64_t p, std::uint64_t i) {
      if (b > bytes || p > positions || i > indices) return false;
      bytes -= b, positions -= p, indices -= i;
      return true;
    }
  };

  /// An element of an array of rows.
  template <class Row>
  SlcExpected<void> read_row(std::uint64_t array, std::uint32_t number, Row& row, Checksum& sum) const {
    const SlcFile::Section* rows = file_->find(array);
    if (!rows || rows->element_size != sizeof row || number >= rows->count)
      return damaged("its meshes are inconsistent");
    return read(array, number, std::as_writable_bytes(std::span(&row, 1)), sizeof row, sum);
  }
  SlcExpected<void> read_values(std::uint64_t array, std::uint64_t first, std::uint64_t size,
                                std::vector<std::byte>& bytes, Checksum& sum) const {
    const SlcFile::Section* values = file_->find(array);
    if (!values || values->element_size != 1 || size > values->count || first > values->count - size)
      return damaged("its meshes are inconsistent");
    bytes.resize(std::size_t(size));
    return read(array, first, bytes, 1, sum);
  }

  SlcExpected<void> read_mesh(std::uint32_t number, Page& page, MeshesLeft& left, Checksum& sum) const {
    SlcMesh mesh;
    if (auto done = read_row(kSlcMeshes, number, mesh, sum); !done) return done;
    if (mesh.removed != 0 || !left.take(value_bytes(mesh), mesh.positions, mesh.indices))
      return damaged("its meshes are inconsistent");
    std::vector<std::byte> bytes;
    if (auto done = read_values(kSlcMeshValues, mesh.first, value_bytes(mesh), bytes, sum); !done) return done;
    core::Mesh made = mesh_of(mesh, bytes);
    if (has_coarse()) made.extras = core::MeshExtrasSlot({levels_of(number), nullptr});
    return add_mesh(std::move(made), page);
  }

  /// Null where it has none that can be used.
  std::shared_ptr<const core::StoredBytes> levels_of(std::uint32_t number) const {
    const SlcFile::Section *rows = file_->find(kSlcLevels), *values = file_->find(kSlcLevelValues);
    SlcLevels row;
    if (!rows || !values || rows->element_size != sizeof row || number >= rows->count ||
        !file_->read(rows->offset + number * sizeof row, std::as_writable_bytes(std::span(&row, 1))) ||
        row.bytes == 0 || row.bytes > values->count || row.first > values->count - row.bytes)
      return nullptr;
    return levels_in_file(file_, *values, row);
  }

  /// `has_own`: whether there is one beside the mesh itself.
  SlcExpected<void> read_coarse_mesh(std::uint32_t number, Page& page, MeshesLeft& left, Checksum& sum,
                                     bool& has_own) const {
    SlcCoarseMesh row;
    if (auto done = read_row(kSlcCoarseMeshes, number, row, sum); !done) return done;
    has_own = row.positions > 0;
    if (!has_own) return {};
    if (!left.take(value_bytes(row), row.positions, row.indices)) return damaged("its coarse meshes are inconsistent");
    std::vector<std::byte> bytes;
    if (auto done = read_values(kSlcCoarseValues, row.first, value_bytes(row), bytes, sum); !done) return done;
    const std::size_t deviations = row.deviations * sizeof(core::MeshDeviation), before = page.deviations.size();
    page.deviations.resize(before + row.deviations);
    if (deviations > 0)
      std::memcpy(static_cast<void*>(page.deviations.data() + before), bytes.data() + bytes.size() - deviations,
                  deviations);
    return add_mesh(mesh_of({0, 0, row.positions, row.normals, row.indices, 0, 0, 0}, bytes), page);
  }

  static SlcExpected<void> add_mesh(core::Mesh mesh, Page& page) {
    if (auto added = page.meshes.add_mesh(std::move(mesh)); !added) return damaged("a mesh: " + added.error().message);
    return {};
  }

  static core::Mesh mesh_of(const SlcMesh& row, const std::vector<std::byte>& bytes) {
    core::Mesh mesh;
    const std::byte* at = bytes.data();
    const auto take = [&at](auto& to, std::uint32_t count) {
      to.resize(count);
      if (count > 0) std::memcpy(static_cast<void*>(to.data()), at, count * sizeof(to[0]));
      at += count * sizeof(to[0]);
    };
    take(mesh.positions, row.positions);
    take(mesh.normals, row.normals);
    take(mesh.indices, row.indices);
    take(mesh.contour_sizes, row.contours);
    take(mesh.polygon_contours, row.polygons);
    return mesh;
  }

  template <class Visit>
  static void for_each_mesh(Page& page, const Visit& visit) {
    storage::for_each_snapshot_array(page.snapshot, [&](std::uint64_t number, auto& array) {
      if constexpr (std::is_same_v<std::remove_reference_t<decltype(array.data()[0])>, std::uint32_t>)
        if (number >= storage::kKindArrays && (number - storage::kKindArrays) % 4 == 3)
          for (std::uint32_t& mesh : array) visit(mesh);
    });
  }

  storage::SnapshotState snapshot_state() const {
    const float* const e = state_.extent;
    return {origin(), {{e[0], e[1], e[2]}, {e[3], e[4], e[5]}}, state_.chunk_size, {}};
  }

  /// Each draw uploads the origins of its chunks: a page has those alone that it uses.
  SlcExpected<void> keep_used_chunks(Page& page, std::vector<core::dvec3>& origins) const {
    std::vector<std::uint32_t> own(chunk_origins_.size(), core::kNone);
    bool good = true;
    storage::for_each_snapshot_array(page.snapshot, [&](std::uint64_t, auto& array) {
      if constexpr (std::is_same_v<std::remove_reference_t<decltype(array.data()[0])>, core::Placement>)
        for (core::Placement& p : array) {
          if (p.chunk >= own.size()) {
            good = false;
            return;
          }
          if (own[p.chunk] == core::kNone) {
            own[p.chunk] = std::uint32_t(origins.size());
            origins.push_back(chunk_origins_[p.chunk]);
          }
          p.chunk = own[p.chunk];
        }
    });
    if (!good) return damaged("its placements are inconsistent");
    return {};
  }

  /// Makes ids unique among parts. False where the file has no such items.
  bool number_items(Page& page) const {
    const std::size_t known = item_slots();
    bool good = true;
    storage::for_each_snapshot_array(page.snapshot, [&](std::uint64_t number, auto& array) {
      if constexpr (std::is_same_v<std::remove_reference_t<decltype(array.data()[0])>, core::ItemId>)
        if (number == storage::kSlotItems)
          for (core::ItemId& item : array) {
            good = good && to_index(item) < known;
            item = core::ItemId{to_index(item) + to_index(first_item_)};
          }
    });
    return good;
  }

  std::shared_ptr<const SlcFile> file_;
  core::ItemId first_item_{0};
  bool verified_ = true;
  SlcSnapshotState state_{};
  std::vector<core::dvec3> chunk_origins_;
  std::vector<SlcPage> pages_;
  std::vector<SlcCoarsePage> coarse_;  // by page; or none at all
  mutable std::vector<std::array<float, 6>> boxes_;
  mutable std::vector<std::uint32_t> colours_;
  std::unique_ptr<Materials> materials_;
};

using PagedParts = std::vector<std::pair<fs::path, std::shared_ptr<const PagedPart>>>;

core::Expected<PagedParts> open_parts(const std::vector<fs::path>& files, const std::function<bool(double)>& progress) {
  PagedParts parts;
  std::uint64_t items = 0;
  for (const fs::path& file : files) {
    if (progress && !progress(double(parts.size()) / double(files.size()))) return core::fail(std::string(kCancelled));
    auto part = PagedPart::open(SlcFile::open(file), core::ItemId(items));
    if (!part) return core::fail(fmt::format("{}: {}", file.string(), part.error().message));
    items += (*part)->item_slots();
    if (items >= core::kNone) return core::fail(fmt::format("{}: more items than ids", file.string()));
    parts.emplace_back(file, std::move(*part));
  }
  return parts;
}

/// Where leaves are relative to. That of a single part is kept: its boxes then are as they are.
core::dvec3 common_origin(const PagedParts& parts) {
  if (parts.size() == 1) return parts[0].second->origin();
  core::AabbD all;
  for (const auto& [file, part] : parts) all.grow(part->origin());
  return glm::round(all.centre());
}

core::Aabb moved(const std::array<float, 6>& c, const core::dvec3& from, const core::dvec3& to) {
  const core::Aabb box{{c[0], c[1], c[2]}, {c[3], c[4], c[5]}};
  if (box.empty() || from == to) return box;
  return core::round_outwards({core::dvec3(box.min) + from, core::dvec3(box.max) + from}, to);
}

void add_part(const PagedPart& part, PagedScene& scene, std::size_t& leaf) {
  for (std::uint32_t page = 0; page < part.pages().size(); ++page) {
    scene.pages.push_back(part.info(page));
    scene.pages.back().first_leaf = std::uint32_t(leaf + part.pages()[page].first / core::kBlockSlots);
  }
  for (std::size_t i = 0; i < part.boxes().size(); ++i)
    scene.leaves.set(leaf + i, moved(part.boxes()[i], part.origin(), scene.leaves.origin));
  scene.colours.insert(scene.colours.end(), part.colours().begin(), part.colours().end());
  leaf += part.boxes().size();
  scene.items += part.slots();
  const core::FittedBounds fitted = part.fitted();
  if (!fitted.bounds.empty()) {
    scene.fitted.bounds.grow(fitted.bounds.min);
    scene.fitted.bounds.grow(fitted.bounds.max);
  }
  scene.fitted.outliers += fitted.outliers;
  part.drop_leaves();
}

/// `first_page`: of each part.
auto loader(const PagedParts& parts, const std::vector<std::uint32_t>& first_page, bool coarse) {
  return [parts, first_page, coarse](std::uint32_t page) -> core::Expected<std::unique_ptr<Page>> {
    const auto after = std::upper_bound(first_page.begin(), first_page.end(), page);
    const std::size_t i = std::size_t(after - first_page.begin()) - 1;
    const auto& [file, part] = parts[i];
    try {
      auto loaded = part->load(page - first_page[i], coarse);
      if (loaded) return std::move(*loaded);
      return core::fail(fmt::format("{}: page {}: {}", file.string(), page - first_page[i], loaded.error().message));
    } catch (const std::bad_alloc&) {
      return core::fail(fmt::format("{}: page {}: not enough memory", file.string(), page - first_page[i]));
    }
  };
}

core::Expected<PagedScene> join(const PagedParts& parts) {
  PagedScene scene;
  scene.leaves.origin = common_origin(parts);
  std::size_t leaves = 0, leaf = 0;
  for (const auto& [file, part] : parts) leaves += part->boxes().size();
  scene.leaves.resize(leaves);
  scene.colours.reserve(leaves);
  std::vector<std::uint32_t> first_page;
  for (const auto& [file, part] : parts) {
    first_page.push_back(std::uint32_t(scene.pages.size()));
    add_part(*part, scene, leaf);
  }
  scene.load = loader(parts, first_page, false);
  if (std::any_of(parts.begin(), parts.end(), [](const auto& part) { return part.second->has_coarse(); })) {
    PagedScene coarse;
    for (const auto& [file, part] : parts)
      for (std::uint32_t page = 0; page < part->pages().size(); ++page)
        coarse.pages.push_back(part->has_coarse() ? part->coarse_info(page) : PagedScene::PageInfo());
    for (std::size_t i = 0; i < coarse.pages.size(); ++i) coarse.pages[i].first_leaf = scene.pages[i].first_leaf;
    coarse.load = loader(parts, first_page, true);
    scene.coarse = std::make_shared<const PagedScene>(std::move(coarse));
  }
  return scene;
}

core::Expected<std::vector<fs::path>> caches_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error, unknown;
  // What cannot be looked at stays in the list, such as a link that leads nowhere: no part may be missing in silence.
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    if (lower_case_extension(at->path()) == ".slc" && !at->is_directory(unknown)) files.push_back(at->path());
  if (error) return core::fail(fmt::format("{}: {}", folder.string(), error.message()));
  if (files.empty())
    return core::fail(fmt::format("{}: expected .slc files in this folder, found none", folder.string()));
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

core::Expected<std::vector<fs::path>> scene_caches_of(const fs::path& path) {
  try {
    std::error_code unknown;
    if (fs::is_directory(path, unknown)) return caches_in(path);
    return std::vector<fs::path>{path};
  } catch (const std::bad_alloc&) {
    return core::fail(fmt::format("{}: not enough memory", path.string()));
  }
}

core::Expected<PagedScene> open_paged_scene(std::shared_ptr<const SlcFile> file, const fs::path& name, bool verified) {
  auto part = PagedPart::open(std::move(file), core::ItemId{0}, verified);
  if (!part) return core::fail(fmt::format("{}: {}", name.string(), part.error().message));
  return join({{name, std::move(*part)}});
}

core::Expected<PagedScene> open_paged_scene(const fs::path& path, const std::function<bool(double)>& progress) {
  try {
    const auto files = scene_caches_of(path);
    if (!files) return tl::unexpected(files.error());
    const auto parts = open_parts(*files, progress);
    if (!parts) return tl::unexpected(parts.error());
    return join(*parts);
  } catch (const std::bad_alloc&) {
    return core::fail(fmt::format("{}: not enough memory", path.string()));
  }
}

}  // namespace sightline::importers
