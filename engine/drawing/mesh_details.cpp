#include "sightline/engine/drawing/internal/mesh_details.h"

#include <algorithm>
#include <utility>

#include "sightline/gpuscene/internal/batch_kinds.h"

namespace sightline::engine {
namespace {

constexpr std::size_t kMostAtOnce = 256;             // meshes that the thread takes at a time
constexpr std::size_t kLargeMesh = 300'000;          // indices: worth several threads
constexpr std::size_t kUploadedIndices = 1'000'000;  // at a time

bool has_mesh(const core::Snapshot& snapshot, core::Slot slot) {
  return int(snapshot.kind(slot)) >= core::kPrimitiveKindCount;
}

}  // namespace

core::Expected<void> MeshDetails::advance(const core::Snapshot& snapshot, gpuscene::GpuScene& scene,
                                          core::Deadline deadline) {
  if (known_slots_ == 0) begin(snapshot);
  take_built();
  while (!given_.empty()) {
    std::size_t count = 0, indices = 0;
    while (count < given_.size() && indices < kUploadedIndices)
      indices += given_[given_.size() - ++count].levels->indices.size();
    if (auto done = scene.add_levels(std::span(given_).last(count)); !done) return done;
    given_.resize(given_.size() - count);
    if (core::over(deadline)) break;
  }
  return {};
}

void MeshDetails::begin(const core::Snapshot& snapshot) {
  const std::vector<core::Slot> slots = gpuscene::GpuScene::slots_of(snapshot, gpuscene::BatchKind::kMesh);
  take_built();
  given_.clear();
  auto former = std::exchange(known_, {});
  for (const core::Slot slot : slots) {
    const std::shared_ptr<const core::Mesh> mesh = snapshot.share_mesh(slot);
    const auto present = former.find(mesh.get());
    if (present == former.end()) continue;
    if (present->second.levels) given_.push_back(present->second);
    known_.insert(former.extract(present));
  }
  for (const core::Slot slot : slots) want(snapshot, slot);
  known_slots_ = core::Slot(snapshot.size());
}

void MeshDetails::follow(const core::Snapshot& snapshot, std::span<const core::Slot> touched) {
  if (known_slots_ == 0) return;
  for (const core::Slot slot : touched)
    if (has_mesh(snapshot, slot)) want(snapshot, slot);
  for (; known_slots_ < snapshot.size(); ++known_slots_)
    if (has_mesh(snapshot, known_slots_)) want(snapshot, known_slots_);
}

void MeshDetails::want(const core::Snapshot& snapshot, core::Slot slot) {
  std::shared_ptr<const core::Mesh> mesh = snapshot.share_mesh(slot);
  if (!mesh || !lod::needs_levels(*mesh) || !known_.try_emplace(mesh.get(), Levels{mesh, nullptr}).second) return;
  const std::lock_guard lock(mutex_);
  wanted_.push_back(std::move(mesh));
  if (!thread_.joinable()) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  changed_.notify_all();
}

void MeshDetails::take_built() {
  const std::lock_guard lock(mutex_);
  for (Levels& made : built_) {
    const auto known = known_.find(made.mesh.get());
    if (known == known_.end()) continue;
    known->second.levels = made.levels;
    given_.push_back(std::move(made));
  }
  built_.clear();
}

void MeshDetails::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return wanted_.empty() && !works_; });
}

std::size_t MeshDetails::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& [mesh, of] : known_)
    if (of.levels) bytes += of.levels->memory_bytes();
  return bytes;
}

void MeshDetails::run(const std::stop_token& stop) {
  std::vector<Levels> work;
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !wanted_.empty(); })) {
    work.clear();
    for (std::size_t i = std::min(kMostAtOnce, wanted_.size()); i-- > 0; wanted_.pop_back())
      work.push_back({std::move(wanted_.back()), nullptr});
    works_ = true;
    lock.unlock();
    build(work, stop);
    lock.lock();
    if (stop.stop_requested()) return;
    std::ranges::move(work, std::back_inserter(built_));
    works_ = false;
    changed_.notify_all();
  }
}

/// Small meshes side by side, and each large one by several threads.
void MeshDetails::build(std::vector<Levels>& work, const std::stop_token& stop) {
  const auto is_small = [](const Levels& of) { return of.mesh->indices.size() < kLargeMesh; };
  const auto build_one = [&](Levels& of, int threads) {
    if (!stop.stop_requested())
      of.levels = std::make_shared<const lod::MeshLevels>(lod::build_levels(*of.mesh, threads));
  };
  const auto small = std::partition(work.begin(), work.end(), is_small) - work.begin();
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic)
#endif
  for (std::ptrdiff_t i = 0; i < small; ++i) build_one(work[std::size_t(i)], 1);
  for (auto large = work.begin() + small; large != work.end(); ++large) build_one(*large, 0);
}

}  // namespace sightline::engine
