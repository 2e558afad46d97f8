#include "sightline/engine/plan.h"

#include <algorithm>

#include "sightline/engine/internal/backend.h"
#include "sightline/engine/internal/rebuild.h"

namespace sightline::engine {
namespace {

void plan_culling(Plan& plan, const core::Snapshot& snapshot, const PlanRequest& request) {
  const std::size_t n = snapshot.size();
  CullerChoice choice = request.culler;
  const std::string limit = std::to_string(kSmallScene);
  std::string why;
  std::string gpu_why = "not asked for";
  if (choice == CullerChoice::kHybrid && request.needs_cpu()) {
    choice = CullerChoice::kAutomatic;
    gpu_why =
        std::string(request.budget ? "a frame budget" : "a contribution threshold") + " needs a culler on the CPU";
  } else if (choice == CullerChoice::kHybrid && n < kSmallHybridScene) {
    choice = CullerChoice::kAutomatic;
    gpu_why = count_text(n) + ", fewer than " + std::to_string(kSmallHybridScene) + ": too few to profit";
  }
  if (choice != CullerChoice::kAutomatic) {
    plan.culler = choice;
    why = "asked for";
  } else {
    plan.culler = n < kSmallScene ? CullerChoice::kLinear : CullerChoice::kCpu;
    why = count_text(n) + (n < kSmallScene ? ", fewer than " : ", at least ") + limit;
  }
  const bool hybrid = plan.culler == CullerChoice::kHybrid;
  const bool tree = plan.has_tree(), gpu = plan.gpu_culls();
  plan.entries.push_back({"linear culler", !tree && !gpu, why});
  plan.entries.push_back({"CPU culling hierarchy", tree, why});
  plan.entries.push_back({"GPU culler", gpu, gpu ? why : gpu_why});
  plan.entries.push_back({"hybrid controller", hybrid, hybrid ? why : gpu ? "the GPU alone was asked for" : gpu_why});
  const bool layers = snapshot.bounds().uses_layers();
  plan.entries.push_back(
      {"layers in the culler", layers, layers ? "items on several layers" : "all items on the model layer"});
}

/// Why nothing of GL is used.
const char* without_gl(const PlanRequest& request) {
  return request.draw ? "rays need none" : "drawing is off";
}

/// Unless it is asked for or switched off, a culler on the GPU tests occlusion in scenes of many items, and one on the
/// CPU while that is found to pay.
void plan_occlusion(Plan& plan, std::size_t items, const PlanRequest& request) {
  const auto note = [&](bool used, std::string why) {
    plan.entries.push_back({"occlusion test", request.draws_by_gl() && used, std::move(why)});
  };
  if (request.draw && request.rays) return note(false, without_gl(request));
  if (request.occlusion == OcclusionChoice::kOff) return note(false, "switched off");
  if (request.occlusion == OcclusionChoice::kOn) return note(true, "asked for");
  const bool gpu_alone = plan.culler == CullerChoice::kGpu;
  const std::size_t least = gpu_alone ? kGpuOcclusionScene : kSmallOcclusionScene;
  const std::string limit = std::to_string(least);
  if (items < least) return note(false, count_text(items) + ", fewer than " + limit + ": too few to profit");
  if (gpu_alone) return note(true, count_text(items) + ", at least " + limit);
  std::string why = "while it pays";
  if (plan.gpu_culls())
    why.insert(0, items < kGpuOcclusionScene ? "where the CPU culls: " : "where a GPU culls; elsewhere ");
  note(true, std::move(why));
}

void plan_losses(Plan& plan, const PlanRequest& request) {
  const auto note = [&](const char* feature, bool asked_for, const char* used) {
    plan.entries.push_back({feature, request.draws_by_gl() && asked_for,
                            !asked_for               ? "not asked for"
                            : !request.draws_by_gl() ? without_gl(request)
                                                     : used});
  };
  note("contribution threshold", request.contribution, "asked for; the CPU culls");
  note("frame budget", request.budget, "asked for; the CPU culls");
  note("levels of detail", request.levels, "asked for");
}

void plan_tracer(Plan& plan, [[maybe_unused]] bool picks) {
#if SIGHTLINE_HAS_RAYTRACE
  plan.entries.push_back(
      {"ray tracer", picks,
       picks
           ? "made for picks, for images by rays, or for moving images within a budget"
           : "made with the first pick, or in the background with the first frame within a budget where no GPU draws; "
             "then about 78 bytes an item, and 68 a triangle of a mesh"});
#else
  plan.entries.push_back({"ray tracer", false, "this build has none"});
#endif
}

}  // namespace

void set_entry(Plan& plan, PlanEntry entry) {
  const auto same = [&](const PlanEntry& present) { return present.feature == entry.feature; };
  const auto present = std::find_if(plan.entries.begin(), plan.entries.end(), same);
  if (present == plan.entries.end())
    plan.entries.push_back(std::move(entry));
  else
    *present = std::move(entry);
}

void add_gpu_variant(Plan& plan, culling::GpuVariant variant, const std::string& why) {
  set_entry(plan, {"GPU culling in geometry shaders", variant == culling::GpuVariant::kGeometry, why});
  set_entry(plan, {"GPU culling in compute shaders", variant == culling::GpuVariant::kCompute, why});
}

void add_context(Plan& plan, bool own, const std::string& platform) {
  set_entry(plan, {"offscreen context", own, own ? platform : "the application's is used"});
}

Plan make_plan(const core::Snapshot& snapshot, CullerChoice choice, bool draw, bool ids) {
  return make_plan(snapshot, draw ? gpuprims::Joints(snapshot) : gpuprims::Joints(), {choice, draw, ids});
}

Plan make_plan(const core::Snapshot& snapshot, const gpuprims::Joints& joints, const PlanRequest& request) {
  Plan plan;
  plan_culling(plan, snapshot, request);
  plan_programs(plan, snapshot, request.draws_by_gl(), without_gl(request));
  const std::size_t hidden = joints.count();
  plan.entries.push_back(
      {"internal end caps at joints", hidden > 0, std::to_string(hidden) + " ends lie on a neighbour's"});
  plan_occlusion(plan, snapshot.size(), request);
  plan_losses(plan, request);
  plan.entries.push_back(
      {"depth shading", request.draw && request.depth_shading, request.depth_shading ? "asked for" : "not asked for"});
  plan.entries.push_back(
      {"hatching", request.draw && request.hatching, request.hatching ? "asked for" : "not asked for"});
  plan.entries.push_back({"edges", request.draw && request.edges, request.edges ? "asked for" : "not asked for"});
  plan.entries.push_back({"item-id target", request.draw && request.ids, request.ids ? "asked for" : "not asked for"});
  plan_tracer(plan, request.pick);
  return plan;
}

}  // namespace sightline::engine
