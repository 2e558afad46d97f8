#include "sightline/apps/common/finer_meshes.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "sightline/lod/finer_mesh.h"
#include "sightline/lod/internal/cut.h"

namespace sightline::apps {
namespace {

constexpr std::size_t kMostOfMesh = std::size_t(1) << 19, kMostOfAll = std::size_t(1) << 23;  // triangles
constexpr double kLeastShare = 1e-6;  // of a mesh's size: gaps below that are those of rounded corners

}  // namespace

bool FinerMeshes::begin(const core::Snapshot& snapshot, const core::View& view, int width, int height) {
  if (active() || (view_ && height_ == height && core::same_image(*view_, view))) return false;
  view_ = view;
  height_ = height;
  core::View whole = view;
  whole.sections.clear();  // a cut face has facets, too
  const lod::ImageError image(whole, width, height, kShownGap);
  const core::KindItems& meshes = snapshot.of_kind(core::Kind::kMesh);
  std::unordered_map<std::uint32_t, Job> jobs_of;  // by mesh
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const std::uint32_t mesh = meshes.meshes[i];
    const core::Slot slot = meshes.members[i];
    if (snapshot.vacant(slot)) continue;
    const auto known = gaps_.find(mesh);
    if (known == gaps_.end() ? !lod::has_curved_faces(snapshot.mesh(slot)) : known->second == 0.0) continue;
    const core::AabbD& bounds = snapshot.scene().mesh_bounds(snapshot.scene().mesh_at(mesh));
    const core::Aabb box{core::vec3(bounds.min), core::vec3(bounds.max)};
    const lod::MeshError error(image, snapshot.world_from_item(slot));
    if (error.outside(box)) continue;
    const double least = std::max(double(error.allowed(box)), kLeastShare * glm::length(bounds.size()));
    if (known != gaps_.end() && known->second <= least) continue;
    const auto [place, fresh] = jobs_of.try_emplace(mesh);
    Job& job = place->second;
    if (fresh) job = {mesh, snapshot.share_mesh(slot), least};
    job.shown = std::min(job.shown, least);
  }
  std::vector<Job> jobs;
  for (auto& [mesh, job] : jobs_of) jobs.push_back(std::move(job));
  std::ranges::sort(jobs, {}, &Job::mesh);
  if (jobs.empty()) return false;
  stop_ = {};
  made_ = std::async(std::launch::async, make, std::move(jobs), stop_.get_token());
  return true;
}

std::vector<FinerMeshes::Job> FinerMeshes::make(std::vector<Job> jobs, const std::stop_token& stop) {
  for (Job& job : jobs) {
    if (stop.stop_requested()) return {};
    job.gap = lod::facet_gap(*job.coarse);
    if (job.gap <= job.shown) continue;
    auto finer = lod::finer_mesh(*job.coarse, kWantedGap / kShownGap * job.shown, kMostOfMesh);
    if (!finer) continue;
    job.gap = lod::facet_gap(*finer);
    job.finer = std::make_shared<core::Mesh>(std::move(*finer));
  }
  return jobs;
}

bool FinerMeshes::ready() const {
  return active() && made_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

bool FinerMeshes::finish(core::Scene& scene) {
  if (!active()) return false;
  std::unordered_map<std::uint32_t, core::MeshId> finer_of;
  for (Job& job : made_.get()) {
    const core::MeshId coarse = scene.mesh_at(job.mesh);
    if (!coarse.valid()) continue;
    if (!job.finer || triangles_ + job.finer->indices.size() / 3 > kMostOfAll) {
      gaps_[job.mesh] = job.gap > job.shown ? 0.0 : job.gap;
      continue;
    }
    triangles_ += job.finer->indices.size() / 3;
    const auto added = scene.add_mesh(std::move(*job.finer));
    if (!added) continue;
    finer_of[job.mesh] = *added;
    gaps_[added->index] = job.gap > job.shown ? 0.0 : job.gap;
    const auto first = coarse_of_.find(job.mesh);
    coarse_of_[added->index] = first == coarse_of_.end() ? coarse : first->second;
  }
  return give(scene, finer_of);
}

bool FinerMeshes::coarse_again(core::Scene& scene) {
  triangles_ = 0;
  view_.reset();
  return give(scene, std::unordered_map<std::uint32_t, core::MeshId>(coarse_of_));
}

/// Gives items other meshes, by those that they have. Finer ones that no item has then are removed.
bool FinerMeshes::give(core::Scene& scene, const std::unordered_map<std::uint32_t, core::MeshId>& others) {
  if (others.empty()) return false;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
    if (!scene.contains_item(item) || scene.kind(item) != core::Kind::kMesh) continue;
    if (const auto other = others.find(scene.mesh_of(item).index); other != others.end())
      scene.set_mesh(item, other->second);
  }
  for (const auto& [mesh, other] : others) {
    if (!coarse_of_.contains(mesh)) continue;
    scene.remove_mesh(scene.mesh_at(mesh));
    coarse_of_.erase(mesh);
    gaps_.erase(mesh);
  }
  return true;
}

void FinerMeshes::forget() {
  stop_.request_stop();
  if (active()) made_.wait();
  made_ = {};
  gaps_.clear();
  coarse_of_.clear();
  view_.reset();
  triangles_ = 0;
}

}  // namespace sightline::apps
