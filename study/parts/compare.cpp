// sightline-study compare: what it takes to tell two revisions of a plant apart.
//
// The later revision is the same plant with an edit that makes one step of the matching do all the work, or a bit of
// everything.
#include "sightline/analysis/compare/compare.h"

#include <algorithm>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::compare_bench {
namespace {

using Json = json::Value;

struct Options {
  std::uint64_t items = 1'000'000;
  int rounds = 3;
  std::string json;
};

using Edit = void (*)(core::Scene&, std::mt19937_64&);

template <class Call>
void for_each_item(core::Scene& scene, const Call& call) {
  for (core::ItemId item{0}, end = core::ItemId(scene.item_slots()); item < end; ++item)
    if (scene.contains_item(item)) call(item);
}

void move(core::Scene& scene, core::ItemId item, const core::dvec3& offset) {
  core::Affine placement = scene.placement(item);
  placement.origin += offset;
  scene.set_placement(item, placement);
}

void edit_nothing(core::Scene&, std::mt19937_64&) {}

/// 1 % of all items: moved, removed, of another shape, or copied beside.
void edit_some(core::Scene& scene, std::mt19937_64& random) {
  for_each_item(scene, [&](core::ItemId item) {
    if (random() % 100 != 0) return;
    const core::NodeId node = scene.node_of(item);
    const core::Affine placement = scene.placement(item);
    switch (random() % 4) {
      case 0:
        return move(scene, item, {0.5, 0, 0});
      case 1:
        return scene.remove_item(item);
      case 2:
        scene.remove_item(item);
        scene.add_primitive(node, core::Box{100, 200, 300}, placement);
        return;
      default:
        if (int(scene.kind(item)) < core::kPrimitiveKindCount)
          scene.add_primitive(node, scene.primitive(item), core::translation({0, 0, 0.3}) * placement);
    }
  });
}

void rename_all(core::Scene& scene, std::mt19937_64&) {
  std::vector<core::NodeId> nodes;
  scene.for_each_node(scene.root(), [&](core::NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
    nodes.push_back(node);
  });
  for (const core::NodeId node : nodes) scene.set_name(node, std::string(scene.name(node)) + "-B");
}

void move_all(core::Scene& scene, std::mt19937_64&) {
  scene.set_transform(scene.root(), core::translation({10, 0, 0}));
}

void remove_all(core::Scene& scene, std::mt19937_64&) {
  for (core::NodeId child = scene.first_child(scene.root()); child.valid(); child = scene.first_child(scene.root()))
    scene.remove_node(child);
}

core::Expected<Json> measure(const core::Scene& before, const Options& options, const char* name, Edit edit) {
  core::Scene after;
  if (auto done = importers::generate_plant({options.items, 1}, after); !done) return tl::unexpected(done.error());
  std::mt19937_64 random(1);
  edit(after, random);
  std::vector<double> times;
  core::Expected<compare::Comparison> found;
  for (int round = 0; round < options.rounds; ++round) {
    const double start = milliseconds();
    found = compare::revisions({&before, before.root()}, {&after, after.root()});
    times.push_back(milliseconds() - start);
    if (!found) return tl::unexpected(found.error());
  }
  Json row{{"edit", name}, {"ms", apps::median(times)}};
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    row[std::string(compare::name_of(compare::State(i)))] = found->counts[i];
  row["renamed"] = found->renamed;
  return row;
}

void print(const Json& json, std::FILE* out) {
  std::fprintf(out, "%zu items\n%-22s %9s %10s %9s %9s %9s %9s %9s\n", json["items"].get<std::size_t>(),
               "later revision", "ms", "unchanged", "added", "removed", "moved", "changed", "renamed");
  for (const Json& row : json["rows"]) {
    std::fprintf(out, "%-22s %9.0f", row["edit"].get<std::string>().c_str(), row["ms"].get<double>());
    std::fprintf(out, " %10zu", row["unchanged"].get<std::size_t>());
    for (const char* key : {"added", "removed", "moved", "changed", "renamed"})
      std::fprintf(out, " %9zu", row[key].get<std::size_t>());
    std::fprintf(out, "\n");
  }
}

core::Expected<int> run(const Options& options) {
  core::Scene before;
  if (auto done = importers::generate_plant({options.items, 1}, before); !done) return tl::unexpected(done.error());
  Json json{{"items", options.items}, {"rounds", options.rounds}, {"rows", Json::array()}};
  constexpr std::pair<const char*, Edit> kEdits[] = {{"the same", edit_nothing},
                                                     {"1 % edited", edit_some},
                                                     {"all nodes renamed", rename_all},
                                                     {"all moved by 10 m", move_all},
                                                     {"empty", remove_all}};
  for (const auto& [name, edit] : kEdits) {
    auto row = measure(before, options, name, edit);
    if (!row) return tl::unexpected(row.error());
    json["rows"].push_back(std::move(*row));
  }
  return finish(options.json, json, print);
}

void add_options(apps::CommandLine& line, Options& options) {
  line.add("--items", options.items, "Items of the generated plant").in_range(1000, 10'000'000).shows_default();
  line.add("--rounds", options.rounds, "Of each comparison; the median counts").in_range(1, 1000).shows_default();
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-study compare\n"
      "  sightline-study compare --items 100000 --json compare.json");
}

}  // namespace
}  // namespace sightline::bench::compare_bench

sightline::bench::Run sightline::bench::add_compare(apps::CommandLine& line) {
  using namespace compare_bench;
  return add_subcommand<Options>(line, add_options, run);
}
