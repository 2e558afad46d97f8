#include "sightline/engine/plan.h"

namespace sightline::engine {
namespace {

using core::Kind;

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

void plan_batches(Plan& plan, const core::Snapshot& snapshot, bool draw) {
  struct Row {
    const char* feature;
    std::vector<Kind> kinds;
  };
  const Row rows[] = {
      {"cylinder program (ray-cast)", {Kind::kCylinder}},
      {"snout program (ray-cast)", {Kind::kSnout}},
      {"circular torus program (ray-cast)", {Kind::kCircularTorus}},
      {"sphere and dish program (ray-cast)", {Kind::kSphere, Kind::kEllipticalDish, Kind::kSphericalDish}},
      {"box program", {Kind::kBox}},
      {"line program", {Kind::kLine}},
      {"mesh program and mesh pool", {Kind::kPyramid, Kind::kRectangularTorus, Kind::kFacetGroup, Kind::kMesh}},
  };
  for (const Row& row : rows) {
    std::size_t n = 0;
    for (const Kind kind : row.kinds) n += snapshot.of_kind(kind).size();
    plan.entries.push_back(
        {row.feature, draw && n > 0, draw ? (n > 0 ? items(n) : "none in the scene") : "drawing is off"});
  }
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
