#include "sightline/engine/paged/internal/page_store.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <new>

#include "sightline/core/internal/platform/process.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/gpuprims/internal/joints.h"
#include "sightline/lod/stored_levels.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/raytrace/tracer.h"
#endif

namespace sightline::engine {
namespace {

/// What draw lists take for a record, and for a mesh item: single ids of three frames, or commands of three frames, of
/// the pool and of the list that is written.
constexpr std::size_t kListBytes = 16, kMeshListBytes = 128;
/// And for an index of levels: in main memory, on the GPU, on its way there, with what clusters and groups come to.
constexpr std::size_t kLevelIndexBytes = 16;
constexpr double kLongestWaitSeconds = 1e6;  // seconds; clocks cannot count to infinity

/// Levels of detail of the page's meshes.
std::vector<gpuscene::MeshPool::LevelsOfMesh> levels_of(const core::Page& page) {
  std::vector<gpuscene::MeshPool::LevelsOfMesh> levels;
  std::vector<bool> taken(page.meshes.mesh_slots());
  for (int kind = core::kPrimitiveKindCount; kind < core::kKindCount; ++kind) {
    const core::KindItems& items = page.snapshot.of_kind(core::Kind(kind));
    for (std::size_t i = 0; i < items.members.size(); ++i) {
      if (taken[items.meshes[i]]) continue;
      taken[items.meshes[i]] = true;
      auto mesh = page.snapshot.share_mesh(items.members[i]);
      if (lod::MeshLevels stored = lod::stored_levels_of(*mesh); !stored.empty())
        levels.push_back({std::move(mesh), std::make_shared<const lod::MeshLevels>(std::move(stored))});
    }
  }
  return levels;
}

}  // namespace

// --- reading ---------------------------------------------------------------------------------------------------------

PageLoader::PageLoader(const core::PagedScene& scene, bool traced)
    : scene_(scene), traced_(traced), thread_([this] { run(); }) {}

PageLoader::~PageLoader() {
  {
    const std::lock_guard held(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void PageLoader::ask_for(std::uint32_t page) {
  {
    const std::lock_guard held(mutex_);
    loaded_.reserve(on_their_way_ + 1);  // so that the thread need not
    asked_.push_back(page);
  }
  ++on_their_way_;
  changed_.notify_all();
}

std::vector<PageLoader::Loaded> PageLoader::take() {
  std::vector<Loaded> taken;
  taken.reserve(on_their_way_);
  const std::lock_guard held(mutex_);
  taken.swap(loaded_);
  on_their_way_ -= taken.size();
  return taken;
}

bool PageLoader::wait(double seconds) {
  if (on_their_way_ == 0) return false;
  const std::chrono::duration<double> most(seconds > 0.0 ? std::min(seconds, kLongestWaitSeconds) : 0.0);
  std::unique_lock held(mutex_);
  changed_.wait_for(held, most, [this] { return !loaded_.empty(); });
  return true;
}

/// Nobody above this thread would catch what a loader throws.
PageLoader::Loaded PageLoader::load(std::uint32_t page) const {
  try {
    return prepared(page);
  } catch (const std::bad_alloc&) {
    return {page, core::fail("out of memory")};  // short enough to need none
  } catch (const std::exception& error) {
    return {page, core::fail(error.what())};
  }
}

PageLoader::Loaded PageLoader::prepared(std::uint32_t page) const {
  Loaded loaded{page, scene_.load(page)};
  if (!loaded.content) return loaded;
  if (scene_.pages[page].level_indices > 0) loaded.levels = levels_of(**loaded.content);
#if SIGHTLINE_HAS_RAYTRACE
  if (traced_) {
    auto tracer = raytrace::Tracer::create((*loaded.content)->snapshot, 1);
    if (!tracer) return {page, tl::unexpected(tracer.error())};
    loaded.tracer = std::make_shared<const raytrace::Tracer>(std::move(*tracer));
  }
#endif
  return loaded;
}

void PageLoader::run() {
  if (traced_) core::platform::lower_priority_of_this_thread();  // where frames have a budget they come first
  std::unique_lock held(mutex_);
  while (true) {
    changed_.wait(held, [this] { return stop_ || !asked_.empty(); });
    if (stop_) return;
    const std::uint32_t page = asked_.front();
    asked_.pop_front();
    held.unlock();
    Loaded loaded = load(page);
    held.lock();
    loaded_.push_back(std::move(loaded));
    changed_.notify_all();
  }
}

// --- pages in memory -------------------------------------------------------------------------------------------------

std::size_t ResidentPage::memory_bytes() const {
  std::size_t meshes = 0;
  for (std::size_t i = 0; i < content->meshes.mesh_slots(); ++i) {
    const core::Mesh& mesh = content->meshes.mesh(content->meshes.mesh_at(i));
    meshes += (mesh.positions.size() + mesh.normals.size()) * sizeof(core::vec3) +
              (mesh.indices.size() + mesh.contour_sizes.size() + mesh.polygon_contours.size()) * sizeof(std::uint32_t);
  }
#if SIGHTLINE_HAS_RAYTRACE
  const std::size_t traced = tracer ? tracer->memory().total() : 0;
#else
  const std::size_t traced = 0;
#endif
  const std::size_t in_main_memory = meshes + level_bytes + traced + content->snapshot.memory_bytes();
  if (!uploaded) return in_main_memory;
  const auto& [scene, lists] = *uploaded;
  const std::size_t mesh_items = scene.meshes().records();
  const std::size_t list_bytes = std::max(lists.memory_bytes(), gpuscene::DrawLists::first_update_bytes());
  return in_main_memory + scene.memory_bytes() + list_bytes + mesh_items * kMeshListBytes +
         content->snapshot.size() * kListBytes;
}

PageStore::PageStore(const core::PagedScene& scene, std::size_t limit, bool traced)
    : scene_(scene),
      largest_page_(largest_page(scene)),
      limit_(std::max(limit, largest_page_)),
      pages_(scene.pages.size()),
      asked_(scene.pages.size()),
      failed_(scene.pages.size()),
      loader_(scene, traced) {}

/// Meshes are gathered once more before they are uploaded.
std::size_t PageStore::bytes_of(const core::PagedScene::PageInfo& info) {
  std::array<std::size_t, gpuscene::kBatchKindCount> records{};
  for (int kind = 0; kind < core::kKindCount; ++kind)
    records[std::size_t(gpuscene::batch_of(core::Kind(kind)))] += info.of_kind[std::size_t(kind)];
  std::size_t bytes = info.memory_bytes + (std::size_t(info.material_rows) + 64) * 9 / 8 * sizeof(glm::vec4);
  for (std::size_t batch = 0; batch < records.size(); ++batch) {
    if (records[batch] == 0) continue;
    bytes += (records[batch] * 9 / 8 + 64) * gpuscene::record_bytes(gpuscene::BatchKind(batch)) +
             records[batch] * kListBytes;
  }
  bytes += records[std::size_t(gpuscene::BatchKind::kMesh)] * kMeshListBytes;
  return bytes + gpuscene::DrawLists::first_update_bytes() + info.level_indices * kLevelIndexBytes +
         2 * (info.mesh_positions * gpuscene::MeshPool::kVertexBytes + info.mesh_indices * sizeof(std::uint32_t));
}

/// More than most: nodes above items and triangles, blocks of these, and boxes to sort.
std::size_t PageStore::tracer_bytes(const core::PagedScene::PageInfo& info) {
  constexpr std::size_t kOfItem = 110, kOfTriangle = 110;
  return info.slot_count * kOfItem + info.mesh_indices / 3 * kOfTriangle;
}

std::size_t PageStore::largest_page(const core::PagedScene& scene) {
  std::size_t most = 0;
  for (const auto& info : scene.pages) most = std::max(most, bytes_of(info));
  return most;
}

void PageStore::take_loaded(std::uint64_t frame) {
  for (PageLoader::Loaded& loaded : loader_.take()) {
    ++counts_.loaded;
    const std::uint32_t page = loaded.page;
    asked_[page] = false;
    if (!loaded.content) {
      bytes_ -= bytes_of(scene_.pages[page]);
      failed_[page] = true;
      ++counts_.failed;
      errors_.push_back(loaded.content.error().message);
      continue;
    }
    pages_[page] = std::make_unique<ResidentPage>();
    ResidentPage& resident = *pages_[page];
    resident.content = std::move(*loaded.content);
    resident.levels = std::move(loaded.levels);
    for (const auto& of : resident.levels) resident.level_bytes += of.levels->memory_bytes();
    resident.tracer = std::move(loaded.tracer);
    if (const auto& lines = resident.content->snapshot.of_kind(core::Kind::kLine).members; !lines.empty()) {
      resident.lines.resize(culling::bit_words(resident.content->snapshot.size()));
      for (const core::Slot slot : lines) resident.lines[slot / 64] |= std::uint64_t(1) << slot % 64;
    }
    bytes_ -= bytes_of(scene_.pages[page]);
    recount(resident);
    resident.used = frame;
    resident_.push_back(page);
    ++counts_.prefetched;  // until an image needs it
  }
  counts_.resident = std::uint32_t(resident_.size());
}

core::Expected<void> PageStore::upload(const gl::Context& context) {
  std::vector<std::uint32_t> waiting;
  std::copy_if(resident_.begin(), resident_.end(), std::back_inserter(waiting),
               [&](std::uint32_t page) { return !pages_[page]->uploaded; });
  std::sort(waiting.begin(), waiting.end(), [&](std::uint32_t a, std::uint32_t b) { return rank(b) < rank(a); });
  core::Expected<void> done;
  for (const std::uint32_t page : waiting) {
    if (!pages_[page]) continue;  // it has made room
    ResidentPage& resident = *pages_[page];
    const std::size_t more = bytes_of(scene_.pages[page]) - std::min(resident.bytes, bytes_of(scene_.pages[page]));
    while (bytes_ + more > limit_ && first_to_go() != page) evict(first_to_go());
    if (done) done = upload(context, resident);
    resident.uploaded ? recount(resident) : evict(page);
  }
  return done;
}

core::Expected<void> PageStore::upload(const gl::Context& context, ResidentPage& page) {
  const auto joints = gpuprims::Joints::of_slots(std::exchange(page.content->internal_end_caps, {}));
  auto scene = gpuscene::GpuScene::create(context, page.content->snapshot, joints);
  if (!scene) return tl::unexpected(scene.error());
  scene->meshes().add_levels(std::exchange(page.levels, {}));
  if (auto done = scene->upload_meshes(core::kNoDeadline, true); !done) return tl::unexpected(done.error());
  auto lists = gpuscene::DrawLists::create(context, *scene);
  if (!lists) return tl::unexpected(lists.error());
  if (!page.tracer) page.content->drop_records();
  page.uploaded.emplace(UploadedPage{std::move(*scene), std::move(*lists)});
  return {};
}

void PageStore::recount(ResidentPage& page) {
  const std::size_t before = std::exchange(page.bytes, page.memory_bytes());
  bytes_ += page.bytes - before;
  resident_bytes_ += page.bytes - before;
}

void PageStore::count_again(std::uint32_t page) {
  recount(*pages_[page]);
  need(page);
}

void PageStore::need(std::uint32_t page) {
  if (!std::exchange(pages_[page]->needed, true)) --counts_.prefetched;
}

void PageStore::ask_for(std::span<const Wanted> wanted, std::uint64_t frame, bool stays) {
  for (const Wanted& next : wanted) {
    if (loader_.on_their_way() >= kMostAsked) return;
    if (pages_[next.page] || asked_[next.page] || failed_[next.page]) continue;
    const std::size_t bytes = bytes_of(scene_.pages[next.page]);
    if (!make_room(bytes, next, frame, stays)) return;
    bytes_ += bytes;
    asked_[next.page] = true;
    loader_.ask_for(next.page);
  }
}

bool PageStore::make_room(std::size_t bytes, const Wanted& wanted, std::uint64_t frame, bool stays) {
  while (bytes_ + bytes > limit_) {
    const std::uint32_t page = first_to_go();
    if (page == core::kNone) return false;
    const ResidentPage& victim = *pages_[page];
    if (victim.used >= frame && !(wanted.now && (stays || victim.area < wanted.area))) return false;
    evict(page);
  }
  return true;
}

std::uint32_t PageStore::first_to_go() const {
  std::uint32_t found = core::kNone;
  for (const std::uint32_t page : resident_) {
    if (found == core::kNone || rank(page) < rank(found)) found = page;
  }
  return found;
}

void PageStore::evict(std::uint32_t page) {
  bytes_ -= pages_[page]->bytes;
  resident_bytes_ -= pages_[page]->bytes;
  pages_[page].reset();
  std::erase(resident_, page);
  counts_.resident = std::uint32_t(resident_.size());
  ++counts_.evicted;
}

void PageStore::set_limit(std::size_t limit) {
  limit_ = std::max(limit, largest_page_);
  while (bytes_ > limit_ && !resident_.empty()) evict(first_to_go());
}

}  // namespace sightline::engine
