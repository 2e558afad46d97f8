#include "sightline/engine/drawing/internal/mesh_details.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "sightline/lod/internal/each_mesh.h"
#include "sightline/lod/stored_levels.h"

namespace sightline::engine {
namespace {

constexpr std::size_t kMostAtOnce = 256;             // meshes that the thread takes at a time
constexpr std::size_t kUploadedIndices = 1'000'000;  // at a time

}  // namespace

core::Expected<void> MeshDetails::advance(gpuscene::GpuScene& scene, bool levels, core::Deadline deadline) {
  const std::vector<std::shared_ptr<const core::Mesh>> added = scene.take_new_meshes();
  if (levels) want_levels(scene);
  if (scene_known_)
    want(added);
  else
    begin(scene);
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

void MeshDetails::want_levels(const gpuscene::GpuScene& scene) {
  if (std::exchange(levels_wanted_, true)) return;
  begin(scene);
}

/// Learns which meshes a scene has, and keeps what is known of these.
void MeshDetails::begin(const gpuscene::GpuScene& scene) {
  const std::vector<std::shared_ptr<const core::Mesh>> meshes = scene.meshes().meshes();
  take_built();
  given_.clear();
  auto former = std::exchange(known_, {});
  for (const auto& mesh : meshes) {
    const auto present = former.find(mesh.get());
    if (present == former.end()) continue;
    if (present->second.of.levels) given_.push_back(present->second.of);
    known_.insert(former.extract(present));
  }
  want(meshes);
  scene_known_ = true;
}

void MeshDetails::want(std::span<const std::shared_ptr<const core::Mesh>> meshes) {
  for (const std::shared_ptr<const core::Mesh>& mesh : meshes) {
    if (!(levels_wanted_ ? lod::needs_levels(*mesh) : lod::is_large(*mesh))) continue;
    Wanted& known = known_[mesh.get()];
    if (known.of.mesh && known.levels >= levels_wanted_) continue;
    known.of.mesh = mesh;
    known.levels = levels_wanted_;
    const std::lock_guard lock(mutex_);
    wanted_.push_back({{mesh, nullptr}, levels_wanted_});
    if (!thread_.joinable()) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
    changed_.notify_all();
  }
}

void MeshDetails::take_built() {
  const std::lock_guard lock(mutex_);
  for (Wanted& made : built_) {
    const auto known = known_.find(made.of.mesh.get());
    if (known == known_.end() || made.levels < known->second.levels) continue;  // gone, or better ones are to come
    known->second.of = made.of;
    given_.push_back(std::move(made.of));
  }
  built_.clear();
}

void MeshDetails::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return wanted_.empty() && !works_; });
}

std::size_t MeshDetails::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& [mesh, known] : known_)
    if (known.of.levels) bytes += known.of.levels->memory_bytes();
  return bytes;
}

void MeshDetails::run(const std::stop_token& stop) {
  std::vector<Wanted> work;
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !wanted_.empty(); })) {
    const std::size_t count = std::min(kMostAtOnce, wanted_.size());
    work.assign(std::make_move_iterator(wanted_.end() - std::ptrdiff_t(count)), std::make_move_iterator(wanted_.end()));
    wanted_.resize(wanted_.size() - count);
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

void MeshDetails::build(std::vector<Wanted>& work, const std::stop_token& stop) {
  std::vector<const core::Mesh*> meshes;
  for (const Wanted& one : work) meshes.push_back(one.of.mesh.get());
  lod::for_each_mesh(meshes, [&](std::size_t i, int threads) {
    if (stop.stop_requested()) return;
    work[i].of.levels = std::make_shared<const lod::MeshLevels>(
        lod::levels_of(*meshes[i], work[i].levels ? lod::LevelRange::kAll : lod::LevelRange::kClusters, threads));
  });
}

}  // namespace sightline::engine
