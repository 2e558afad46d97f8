// sightline-info: what a model holds, and what is wrong with it.

#include <cstdio>

#include <nlohmann/json.hpp>

#include "sightline/apps/common/model.h"

namespace {

using namespace sightline;
using nlohmann::json;

struct Facts {
  std::uint64_t nodes = 0, max_depth = 0, triangles = 0;
  core::AabbD bounds;
};

Facts gather(const core::Scene& scene) {
  Facts facts;
  std::vector<std::uint32_t> depth_of;  // by node index
  scene.for_each_node(
      scene.root(), [&](core::NodeId node, const core::Affine& world, bool, std::uint32_t, core::MaterialId) {
        const core::NodeId parent = scene.parent(node);
        if (depth_of.size() <= node.index) depth_of.resize(node.index + 1, 0);
        depth_of[node.index] = parent.valid() ? depth_of[parent.index] + 1 : 0;
        facts.max_depth = std::max<std::uint64_t>(facts.max_depth, depth_of[node.index]);
        ++facts.nodes;
        for (core::ItemId item = scene.first_item(node); item != core::kNone; item = scene.next_item(item)) {
          facts.bounds.grow(scene.bounds_under(item, world * scene.placement(item)));
          if (int(scene.kind(item)) >= core::kPrimitiveKindCount)
            facts.triangles += scene.mesh(scene.mesh_of(item)).indices.size() / 3;
        }
      });
  return facts;
}

json to_json(const importers::ImportReport& report, const Facts& facts) {
  json out;
  for (int k = 0; k < core::kKindCount; ++k)
    out["items"][std::string(core::kind_name(core::Kind(k)))] = report.items[k];
  out["degenerate"] = report.degenerate;
  out["nodes"] = facts.nodes;
  out["max_depth"] = facts.max_depth;
  out["triangles"] = facts.triangles;
  const auto corner = [](const core::dvec3& v) { return json::array({v.x, v.y, v.z}); };
  out["bounds"] =
      facts.bounds.empty() ? json(nullptr) : json{{"min", corner(facts.bounds.min)}, {"max", corner(facts.bounds.max)}};
  out["metres_per_unit"] = report.metres_per_unit;
  out["shared_meshes"] = report.shared_meshes;
  out["sharing_error"] = report.sharing_error;
  out["warnings"] = json::array();
  for (const auto& w : report.warnings)
    out["warnings"].push_back({{"file", w.file}, {"offset", w.offset}, {"message", w.message}});
  return out;
}

void print(const importers::ImportReport& report, const Facts& facts) {
  std::uint64_t total = 0;
  for (int k = 0; k < core::kKindCount; ++k) {
    if (report.items[k])
      std::printf("%-18s %12llu\n", std::string(core::kind_name(core::Kind(k))).c_str(),
                  (unsigned long long)report.items[k]);
    total += report.items[k];
  }
  std::printf("%-18s %12llu  (%llu without volume)\n", "items", (unsigned long long)total,
              (unsigned long long)report.degenerate);
  std::printf("%-18s %12llu  (depth %llu)\n", "nodes", (unsigned long long)facts.nodes,
              (unsigned long long)facts.max_depth);
  std::printf("%-18s %12llu\n", "mesh triangles", (unsigned long long)facts.triangles);
  if (report.shared_meshes > 0)
    std::printf("%-18s %12llu  (moved by at most %.2g m)\n", "shared meshes", (unsigned long long)report.shared_meshes,
                report.sharing_error);
  if (facts.bounds.empty()) {
    std::printf("%-18s empty\n", "bounds");
  } else {
    const auto &a = facts.bounds.min, &b = facts.bounds.max;
    std::printf("%-18s %.3f %.3f %.3f  to  %.3f %.3f %.3f m\n", "bounds", a.x, a.y, a.z, b.x, b.y, b.z);
  }
  std::printf("%-18s %g m\n", "file unit", report.metres_per_unit);
  std::printf("%-18s %zu\n", "warnings", report.warnings.size());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Counts, bounds, units, tree depth and problems of model files", "sightline-info");
  apps::describe(
      app, "  sightline-info plant.rvm\n  sightline-info --json - a.rvm b.rvm\n  sightline-info --lenient damaged.rvm");
  apps::ModelOptions options;
  std::string json_file;
  apps::add_model_options(app, options);
  app.add_option("--json", json_file, "Write the facts as JSON to FILE, or - for stdout");
  return apps::run(app, argc, argv, [&]() -> core::Expected<int> {
    auto model = apps::load_model(options);
    if (!model) return tl::unexpected(model.error());
    if (auto delta = model->scene->commit(); !delta) return tl::unexpected(delta.error());
    if (options.explain) {
      core::Snapshot snapshot(*model->scene);
      snapshot.find_joints();
      apps::explain(engine::make_plan(snapshot, engine::CullerChoice::kAutomatic, true, false));
    }
    const Facts facts = gather(*model->scene);
    if (json_file != "-") print(model->report, facts);
    if (json_file.empty()) return apps::kExitOk;
    if (auto done = apps::write_text(json_file, apps::to_text(to_json(model->report, facts))); !done)
      return tl::unexpected(done.error());
    return apps::kExitOk;
  });
}
