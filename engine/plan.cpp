#include "sightline/engine/plan.h"

#include <algorithm>
#include <array>

#if SIGHTLINE_HAS_GL
#include "sightline/gpuscene/gpu_scene.h"
#endif

namespace sightline::engine {
namespace {

std::string items(std::size_t n) {
  return std::to_string(n) + (n == 1 ? " item" : " items");
}

void plan_culling(Plan& plan, const core::Snapshot& snapshot, CullerChoice choice) {
  const std::size_t n = snapshot.size();
  const std::string limit = std::to_string(kSmallScene);
  std::string why;
  std::string gpu_why = "not asked for";
  if (choice == CullerChoice::kHybrid && n < kSmallHybridScene) {
    choice = CullerChoice::kAutomatic;
    gpu_why = items(n) + ", fewer than " + std::to_string(kSmallHybridScene) + ": too few to profit";
  }
  if (choice != CullerChoice::kAutomatic) {
    plan.culler = choice;
    why = "asked for";
  } else {
    plan.culler = n < kSmallScene ? CullerChoice::kLinear : CullerChoice::kCpu;
    why = items(n) + (n < kSmallScene ? ", fewer than " : ", at least ") + limit;
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

/// One row for each program there is; a build without GL has none.
void plan_batches([[maybe_unused]] Plan& plan, [[maybe_unused]] const core::Snapshot& snapshot,
                  [[maybe_unused]] bool draw) {
#if SIGHTLINE_HAS_GL
  std::array<std::size_t, gpuscene::kBatchKindCount> counts{};
  for (int kind = 0; kind < core::kKindCount; ++kind)
    counts[std::size_t(gpuscene::batch_of(core::Kind(kind)))] += snapshot.of_kind(core::Kind(kind)).size();
  for (int i = 0; i < gpuscene::kBatchKindCount; ++i) {
    const auto batch = gpuscene::BatchKind(i);
    const std::size_t n = counts[std::size_t(i)];
    std::string feature(gpuscene::batch_name(batch));
    std::replace(feature.begin(), feature.end(), '_', ' ');
    feature += gpuscene::is_ray_cast(batch) ? " program (ray-cast)" : " program";
    plan.entries.push_back(
        {std::move(feature), draw && n > 0, draw ? (n > 0 ? items(n) : "none in the scene") : "drawing is off"});
  }
#endif
}

}  // namespace

void add_gpu_form(Plan& plan, culling::GpuForm form, const std::string& why) {
  const auto note = [&](const char* feature, culling::GpuForm named) {
    std::erase_if(plan.entries, [&](const PlanEntry& entry) { return entry.feature == feature; });
    plan.entries.push_back({feature, form == named, why});
  };
  note("GPU culling in geometry shaders", culling::GpuForm::kGeometry);
  note("GPU culling in compute shaders", culling::GpuForm::kCompute);
}

Plan make_plan(const core::Snapshot& snapshot, CullerChoice choice, bool draw, bool ids) {
  Plan plan;
  plan_culling(plan, snapshot, choice);
  plan_batches(plan, snapshot, draw);
  const std::size_t hidden = snapshot.joints().count();
  plan.entries.push_back({"hidden ends at joints", hidden > 0, std::to_string(hidden) + " ends lie on a neighbour's"});
  plan.entries.push_back({"item-id target", draw && ids, ids ? "asked for" : "not asked for"});
  return plan;
}

}  // namespace sightline::engine
