#include "sightline/engine/drawing/internal/mesh_details.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "sightline/lod/internal/each_mesh.h"
#include "sightline/lod/stored_levels.h"

namespace sightline::engine {
namespace {

constexpr std::size_t kMostAtOnce = 256;  // meshes that the thread takes at a time
constexpr std::size_t kFollowed = 512;    // new meshes that are looked at at a time

}  // namespace

MeshDetails::~MeshDetails() {
  for (auto& [mesh, known] : known_) known.stop.request_stop();
  core::request_stop(thread_, mutex_, changed_);
}

void MeshDetails::follow(gpuscene::GpuScene& scene, bool levels) {
  if (levels) want_levels(scene);
  levels_wanted_ = levels;
  for (const auto& mesh : scene.meshes().take_gone_meshes()) forget(*mesh);
  drop_cancelled();
  want(scene, scene.meshes().take_new_meshes(kFollowed));
  give_built(scene);
}

core::Expected<void> MeshDetails::advance(gpuscene::GpuScene& scene, bool levels, core::Deadline deadline) {
  while (scene.meshes().has_new_meshes() && !core::over(deadline)) follow(scene, levels);
  if (auto done = scene.upload_meshes(deadline, true); !done) return tl::unexpected(done.error());
  return {};
}

void MeshDetails::want_levels(gpuscene::GpuScene& scene) {
  if (!std::exchange(levels_wanted_, true)) want(scene, scene.meshes().meshes());
}

void MeshDetails::keep_only(const gpuscene::GpuScene& scene, bool levels) {
  std::vector<const core::Mesh*> others;
  for (const auto& [mesh, known] : known_)
    if (!scene.meshes().has(*mesh) || (known.levels && !levels)) others.push_back(mesh);
  for (const core::Mesh* mesh : others) forget(*mesh);
  drop_cancelled();
}

/// Meshes that are known already get what is known: the scene may be another one.
void MeshDetails::want(gpuscene::GpuScene& scene, Meshes meshes) {
  std::vector<Wanted> fresh;
  for (const std::shared_ptr<const core::Mesh>& mesh : meshes) {
    if (!(levels_wanted_ ? lod::needs_levels(*mesh) : lod::is_large(*mesh))) continue;
    const auto [place, is_new] = known_.try_emplace(mesh.get());
    Wanted& known = place->second;
    if (known.of.levels) scene.meshes().add_levels({&known.of, 1});
    if (!is_new && known.levels >= levels_wanted_) continue;
    known.stop.request_stop();
    known.stop = {};
    known.of.mesh = mesh;
    known.levels = levels_wanted_;
    fresh.push_back({{mesh, nullptr}, known.levels, known.stop});
  }
  if (fresh.empty()) return;
  const std::lock_guard lock(mutex_);
  std::ranges::move(fresh, std::back_inserter(wanted_));
  if (!thread_.joinable()) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  changed_.notify_all();
}

void MeshDetails::forget(const core::Mesh& mesh) {
  const auto known = known_.find(&mesh);
  if (known == known_.end()) return;
  known->second.stop.request_stop();
  known_.erase(known);
  ++cancelled_;
}

/// Lets go of meshes that wait in vain, once they may be half of all that wait.
void MeshDetails::drop_cancelled() {
  if (cancelled_ == 0) return;
  const std::lock_guard lock(mutex_);
  if (2 * cancelled_ < wanted_.size()) return;
  std::erase_if(wanted_, [](const Wanted& wanted) { return wanted.stop.stop_requested(); });
  cancelled_ = 0;
}

void MeshDetails::give_built(gpuscene::GpuScene& scene) {
  std::vector<Wanted> built;
  {
    const std::lock_guard lock(mutex_);
    built.swap(built_);
  }
  for (Wanted& made : built) {
    const auto known = known_.find(made.of.mesh.get());
    if (known == known_.end() || made.stop != known->second.stop) continue;  // gone, or better ones are to come
    known->second.of = std::move(made.of);
    scene.meshes().add_levels({&known->second.of, 1});
  }
}

void MeshDetails::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return wanted_.empty() && !works_; });
}

std::size_t MeshDetails::memory_bytes() const {
  std::size_t bytes = 0;
  const auto add = [&](const Wanted& wanted) { bytes += wanted.of.levels ? wanted.of.levels->memory_bytes() : 0; };
  for (const auto& [mesh, known] : known_) add(known);
  const std::lock_guard lock(mutex_);
  for (const Wanted& made : built_) add(made);
  return bytes;
}

void MeshDetails::run(const std::stop_token& stop) {
  std::vector<Wanted> work;
  std::unique_lock lock(mutex_);
  while (core::wait_until(changed_, lock, stop, [&] { return !wanted_.empty(); })) {
    const std::size_t count = std::min(kMostAtOnce, wanted_.size());
    work.assign(std::make_move_iterator(wanted_.end() - std::ptrdiff_t(count)), std::make_move_iterator(wanted_.end()));
    wanted_.resize(wanted_.size() - count);
    works_ = true;
    lock.unlock();
    build(work);
    lock.lock();
    if (stop.stop_requested()) return;
    for (Wanted& made : work)
      if (!made.stop.stop_requested()) built_.push_back(std::move(made));
    work.clear();
    works_ = false;
    changed_.notify_all();
  }
}

void MeshDetails::build(std::vector<Wanted>& work) {
  std::vector<const core::Mesh*> meshes;
  for (const Wanted& one : work) meshes.push_back(one.of.mesh.get());
  lod::for_each_mesh(meshes, [&](std::size_t i, int threads) {
    const std::stop_token stop = work[i].stop.get_token();
    const auto range = work[i].levels ? lod::LevelRange::kAll : lod::LevelRange::kClusters;
    if (!stop.stop_requested())
      work[i].of.levels = std::make_shared<const lod::MeshLevels>(lod::levels_of(*meshes[i], range, threads, stop));
  });
}

}  // namespace sightline::engine
