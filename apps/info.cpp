// sightline-info: the content of a model, and its errors; or what OpenGL offers here.

#include <cstdio>

#include "sightline/apps/common/command_line.h"
#if SIGHTLINE_HAS_GL
#include "sightline/apps/common/gl_page.h"
#endif
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/named_parts.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/report_json.h"
#include "sightline/core/internal/clock.h"
#include "sightline/importers/json/internal/json.h"

namespace {

using namespace sightline;
using apps::need;
using Json = json::Value;

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
        for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item)) {
          facts.bounds.grow(scene.bounds_under(item, world * scene.placement(item)));
          if (int(scene.kind(item)) >= core::kPrimitiveKindCount)
            facts.triangles += scene.mesh(scene.mesh_of(item)).indices.size() / 3;
        }
      });
  return facts;
}

/// Bounds on all layers: items count whether they are hidden by default or not.
core::AabbD bounds_of(const core::Scene& scene, core::NodeId node) {
  return scene.bounds(node, ~std::uint32_t{0});
}

Json to_json(const core::AabbD& bounds) {
  if (bounds.empty()) return nullptr;
  const auto corner = [](const core::dvec3& v) { return Json::array({v.x, v.y, v.z}); };
  return {{"min", corner(bounds.min)}, {"max", corner(bounds.max)}};
}

Json to_json(const core::Scene& scene, std::span<const core::NodeId> found) {
  Json out = Json::array();
  for (const core::NodeId node : found) {
    Json attributes = Json::object();
    for (const auto& [key, value] : scene.attributes(node)) attributes[key] = value;
    out.push_back(
        {{"path", scene.path(node)}, {"attributes", attributes}, {"bounds", to_json(bounds_of(scene, node))}});
  }
  return out;
}

/// Prints lines for people to read and scripts to cut: path, centre, attributes.
void print(const core::Scene& scene, const core::FoundNodes& found) {
  for (const core::NodeId node : found.nodes) {
    const core::AabbD bounds = bounds_of(scene, node);
    std::printf("%s", scene.path(node).c_str());
    if (!bounds.empty()) {
      const core::dvec3 c = bounds.centre();
      std::printf("  (at %.3f %.3f %.3f)", c.x, c.y, c.z);
    }
    std::printf("\n");
    for (const auto& [key, value] : scene.attributes(node)) std::printf("    %s: %s\n", key.c_str(), value.c_str());
  }
  std::printf("%zu found %s\n", found.nodes.size(), words_of(found.match).data());
}

Json to_json(const importers::ImportReport& report, const Facts& facts) {
  Json out;
  out["items"] = apps::items_json(report.items);
  out["degenerate"] = report.degenerate;
  out["nodes"] = facts.nodes;
  out["max_depth"] = facts.max_depth;
  out["triangles"] = facts.triangles;
  out["bounds"] = to_json(facts.bounds);
  out["metres_per_unit"] = report.metres_per_unit;
  out["attributed"] = report.attributed;
  out["shared_meshes"] = report.shared_meshes;
  out["sharing_error"] = report.sharing_error;
  if (report.recognition.meshes > 0) out["recognition"] = apps::recognition_json(report.recognition);
  if (report.surfaces.parts > 0) out["surfaces"] = apps::surfaces_json(report.surfaces);
  out["warnings"] = apps::warnings_json(report.warnings);
  return out;
}

void print(const importers::ImportReport& report, const Facts& facts) {
  std::uint64_t total = 0;
  for (int k = 0; k < core::kKindCount; ++k) {
    if (report.items[k])
      std::printf("%-18s %12llu\n", std::string(core::name_of(core::Kind(k))).c_str(),
                  (unsigned long long)report.items[k]);
    total += report.items[k];
  }
  std::printf("%-18s %12llu  (%llu without volume)\n", "items", (unsigned long long)total,
              (unsigned long long)report.degenerate);
  std::printf("%-18s %12llu  (depth %llu)\n", "nodes", (unsigned long long)facts.nodes,
              (unsigned long long)facts.max_depth);
  std::printf("%-18s %12llu\n", "mesh triangles", (unsigned long long)facts.triangles);
  if (report.attributed > 0) std::printf("%-18s %12llu\n", "with attributes", (unsigned long long)report.attributed);
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
  if (report.surfaces.parts > 0) std::printf("%s\n", apps::surface_words(report.surfaces).c_str());
  if (report.recognition.meshes > 0) std::printf("%s\n", apps::recognition_words(report.recognition).c_str());
}

/// Parts by the rule of core/find_nodes.h. To list is also to search: where the rule finds none, those that hold the
/// texts anywhere in a name or value, with a note.
core::Expected<core::FoundNodes> listed_parts(const core::Scene& scene, const std::vector<std::string>& texts) {
  std::vector<core::NodeCondition> exact, within;
  for (const std::string& text : texts) {
    exact.push_back({"", text});
    const std::size_t value = text.find('=') + 1;  // 0: there is none
    within.push_back(core::is_pattern(text)
                         ? exact.back()
                         : core::NodeCondition{"", text.substr(0, value) + "*" + text.substr(value) + "*"});
  }
  auto found = apps::find_parts(scene, exact);
  if (found) return found;
  const auto holding = apps::find_parts(scene, within);
  if (!holding) return found;
  std::fprintf(stderr, "note: %s; listed is what holds it\n", found.error().message.c_str());
  return holding;
}

void tell_of_model(const apps::ModelOptions& options, const std::string& json_file,
                   const std::vector<std::string>& find) {
  auto model = need(apps::load_model(options));
  need(model.scene->commit());
  if (options.explain) apps::explain(*model.scene);
  const auto found = find.empty() ? core::FoundNodes() : need(listed_parts(*model.scene, find));
  const Facts facts = gather(*model.scene);
  if (json_file != "-" && find.empty()) print(model.report, facts);
  if (json_file != "-" && !find.empty()) print(*model.scene, found);
  Json out = to_json(model.report, facts);
  if (!find.empty()) out["found"] = to_json(*model.scene, found.nodes);
  need(apps::write_json(json_file, json::sorted(std::move(out))));
}

#if SIGHTLINE_HAS_GL
void tell_of_gl(gl::ContextPlatform platform, const std::string& json_file) {
  const double begin = core::now_seconds();
  auto context = need(gl::Context::create_offscreen({.platform = platform}));
  const double made = 1e3 * (core::now_seconds() - begin);
  context.test_driver();
  Json page = apps::gl_page(context, made);
  if (json_file != "-") apps::print_gl_page(page, stdout);
  need(apps::write_json(json_file, json::sorted(std::move(page))));
}
#endif

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line(
      "Counts, bounds, units, tree depth and problems of model files", "sightline-info",
      "  sightline-info plant.rvm\n  sightline-info --json - a.rvm b.rvm\n  sightline-info --lenient damaged.rvm\n"
      "  sightline-info plant.rvm plant.txt --list Type=VALVE --list PS-100\n"
      "  sightline-info --gl                                       # for bug reports");
  apps::ModelOptions options;
  std::string json_file;
  std::vector<std::string> find;
  apps::add_model_options(line, options);
  apps::add_part_option(line, "--list", find,
                        "List parts instead: " + apps::kPartForms + "; given several times, all hold");
  line.add("--json", json_file, "Write the facts as JSON to FILE, or - for stdout");
#if SIGHTLINE_HAS_GL
  bool gl_page = false;
  gl::ContextPlatform platform = {};
  const auto flag = line.add_flag("--gl", gl_page,
                                  "Tell of OpenGL on this machine instead: driver, limits, self-test and workarounds");
  apps::add_context_option(line, platform);
  const auto files = line.option("MODEL").required(false);
  line.check([flag, files]() -> core::Expected<void> {
    if (flag.given() == files.given()) return core::fail("MODEL is required, or --gl alone");
    return {};
  });
#endif
  return line.run(argc, argv, [&]() -> core::Expected<int> {
#if SIGHTLINE_HAS_GL
    if (gl_page) {
      tell_of_gl(platform, json_file);
      return apps::kExitOk;
    }
#endif
    tell_of_model(options, json_file, find);
    return apps::kExitOk;
  });
}
