// sightline-study tree: what the viewer's tree panel and search take per operation, on a model or on a made-up tree.
//
// The operations are those between a key or click and the next image: the rows of a window, expanding, revealing, and
// a search with the filter of the tree for each text. A search uses several threads, so processor time is given, too.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/view/name_search.h"
#include "sightline/apps/view/tree_rows.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::tree_bench {
namespace {

using Json = json::Value;
using core::NodeId;

constexpr std::size_t kWindow = 50;  // rows

struct Options {
  apps::ModelOptions model;
  std::size_t nodes = 1'000'000;
  std::vector<std::string> texts{"p", "pi", "pipe", "pipe-77", "no such text", "type:valv"};
  std::vector<std::string> expressions{"pipe-\\d*7$", "^(valv|elbo).*3"};
  int repeats = 15;
  std::string json;
};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_model_options(line, o.model);
  line.option("MODEL").required(false);
  line.add("--nodes", o.nodes, "Without MODEL: nodes of a made-up tree, each with a name of its own and a type")
      .in_range(1, 100'000'000)
      .shows_default();
  line.add("--text", o.texts, "Texts to search for").shows_default();
  line.add("--expression", o.expressions, "Regular expressions to search for").shows_default();
  line.add("--repeats", o.repeats, "Of each operation; the median counts").in_range(1, 1000).shows_default();
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-study tree plant.rvm\n"
      "  sightline-study tree --nodes 5000000 --text pump --json tree.json");
}

/// Zones of 40 pipes of 3 branches of 12 parts, until there are `count` nodes.
void grow(core::Scene& scene, std::size_t count) {
  const char* const parts[] = {"ELBOW", "VALVE", "FLANGE", "GASKET", "REDUCER", "TUBE"};
  const auto full = [&] { return scene.node_count() >= count; };
  const auto add = [&](NodeId parent, const std::string& name, const std::string& type) {
    if (full()) return parent;
    const NodeId node = scene.add_node(parent, name);
    scene.set_attribute(node, "Type", type.substr(0, 4));
    return node;
  };
  for (int zone = 1, pipe = 1; !full(); ++zone) {
    const NodeId of_zone = add(scene.root(), "ZONE-A" + std::to_string(zone), "ZONE");
    for (int i = 0; i < 40 && !full(); ++i, ++pipe) {
      const std::string pipe_name = "PIPE-" + std::to_string(pipe);
      const NodeId of_pipe = add(of_zone, pipe_name, "PIPE");
      for (int branch = 1; branch <= 3; ++branch) {
        const std::string branch_name = pipe_name + "-B" + std::to_string(branch);
        const NodeId of_branch = add(of_pipe, branch_name, "BRANCH");
        for (int k = 1; k <= 12; ++k) {
          const char* const part = parts[std::size_t(pipe + branch + k) % std::size(parts)];
          std::string name = part;
          add(of_branch, name.append(" ").append(std::to_string(k)).append(" of BRANCH /").append(branch_name), part);
        }
      }
    }
  }
}

std::vector<NodeId> nodes_of(const core::Scene& scene) {
  std::vector<NodeId> nodes;
  nodes.reserve(scene.node_count());
  scene.for_each_node(scene.root(), [&](NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
    nodes.push_back(node);
  });
  return nodes;
}

/// Medians over several calls, milliseconds.
struct Times {
  double wall, processor;  // processor: the sum of all threads
};
template <class Prepare, class Call>
Times measured(int repeats, const Prepare& prepare, const Call& call) {
  std::vector<double> wall, processor;
  for (int i = 0; i < repeats; ++i) {
    prepare();
    const double start = milliseconds(), used = processor_milliseconds();
    call();
    wall.push_back(milliseconds() - start);
    processor.push_back(processor_milliseconds() - used);
  }
  return {apps::median(std::move(wall)), apps::median(std::move(processor))};
}
constexpr auto kNothing = [] {};

Json tree_times(const core::Scene& scene, const Options& o) {
  const std::vector<NodeId> nodes = nodes_of(scene);
  std::mt19937_64 random(1);
  const auto any = [&] { return nodes[random() % nodes.size()]; };
  apps::TreeRows tree;
  Json rows;
  const auto row = [&](const char* name, const auto& prepare, const auto& call) {
    const Times times = measured(o.repeats, prepare, call);
    rows.push_back({{"operation", name}, {"ms", times.wall}, {"processor_ms", times.processor}});
  };
  const auto expand_all = [&] { tree.expand_all_below(scene.root()); };
  const auto collapse_root = [&] { tree.collapse(scene.root()); };
  std::size_t sum = 0;  // so that no compiler leaves the calls out
  const auto window = [&](const auto& use) {
    const std::size_t first = random() % tree.row_count(), end = std::min(first + kWindow, tree.row_count());
    for (std::size_t i = first; i < end; ++i) use(tree.row(i));
  };
  NodeId node;
  const auto reveal = [&] { sum += tree.reveal(node).value_or(0); };

  row("copy the scene's tree", kNothing, [&] { tree.reset(scene); });
  row(
      "expand all", [&] { tree.reset(scene), collapse_root(); }, expand_all);
  row("50 rows of all", expand_all, [&] { window([&](const apps::TreeRow& r) { sum += r.depth; }); });
  row("50 rows with labels", expand_all,
      [&] { window([&](const apps::TreeRow& r) { sum += apps::label(scene, r.node).size(); }); });
  row(
      "row of a random node", [&] { node = any(); }, reveal);
  row("collapse the root", expand_all, collapse_root);
  row("expand the root", collapse_root, [&] { tree.expand(scene.root()); });
  row(
      "collapse a random node", [&] { node = any(); }, [&] { tree.collapse(node); });
  row(
      "reveal a random node", [&] { collapse_root(), node = any(); }, reveal);
  apps::TreeRows closed;
  row(
      "reveal in a closed tree", [&] { closed = {}, closed.reset(scene), node = any(); },
      [&] { sum += closed.reveal(node).value_or(0); });
  return {{"rows", rows}, {"memory_bytes", tree.memory_bytes()}, {"checksum", sum}};
}

/// Times of searches, and of filters of the tree with what they found.
core::Expected<Json> search_times(const core::Scene& scene, const Options& o) {
  apps::NameIndex index;
  const Times build = measured(std::min(o.repeats, 3), kNothing, [&] { index = apps::NameIndex(scene); });
  apps::TreeRows tree;
  tree.reset(scene);
  std::vector<apps::NameQuery> queries;
  for (const std::string& text : o.texts) queries.push_back({text});
  for (const std::string& text : o.expressions) queries.push_back({text, true});
  Json rows;
  for (const apps::NameQuery& query : queries) {
    core::Expected<apps::NameMatches> found;
    const Times search = measured(o.repeats, kNothing, [&] { found = index.find(query, index.node_count()); });
    if (!found) return tl::unexpected(found.error());
    const Times filter = measured(o.repeats, kNothing, [&] { tree.set_filter(found->nodes); });
    rows.push_back({{"text", query.text},
                    {"expression", query.regular_expression},
                    {"found", found->count},
                    {"search_ms", search.wall},
                    {"search_processor_ms", search.processor},
                    {"filter_ms", filter.wall},
                    {"filter_processor_ms", filter.processor}});
  }
  return Json{{"build_ms", build.wall}, {"memory_bytes", index.memory_bytes()}, {"rows", rows}};
}

void print(const Json& json, std::FILE* out) {
  std::fprintf(out, "%zu nodes, tree %.1f MB, index of names %.1f MB, made in %.0f ms\n\n",
               json["nodes"].get<std::size_t>(), 1e-6 * json["tree"]["memory_bytes"].get<double>(),
               1e-6 * json["search"]["memory_bytes"].get<double>(), json["search"]["build_ms"].get<double>());
  std::fprintf(out, "%-26s %10s %10s\n", "tree", "ms", "processor");
  for (const Json& row : json["tree"]["rows"])
    std::fprintf(out, "%-26s %10.4f %10.3f\n", row["operation"].get<std::string>().c_str(), row["ms"].get<double>(),
                 row["processor_ms"].get<double>());
  std::fprintf(out, "\n%-26s %10s %10s %10s %10s %10s\n", "search", "found", "ms", "processor", "filter ms",
               "processor");
  for (const Json& row : json["search"]["rows"]) {
    const std::string text = row["text"].get<std::string>();
    std::fprintf(out, "%-26s %10zu", (row["expression"].get<bool>() ? "/" + text + "/" : text).c_str(),
                 row["found"].get<std::size_t>());
    for (const char* key : {"search_ms", "search_processor_ms", "filter_ms", "filter_processor_ms"})
      std::fprintf(out, " %10.2f", row[key].get<double>());
    std::fprintf(out, "\n");
  }
}

core::Expected<int> run(const Options& o) {
  apps::Model model;
  if (o.model.files.empty()) {
    model.scene = std::make_unique<core::Scene>();
    grow(*model.scene, o.nodes);
  } else {
    auto loaded = apps::load_model(o.model);
    if (!loaded) return tl::unexpected(loaded.error());
    model = std::move(*loaded);
  }
  Json json = {{"model", o.model.files},
               {"nodes", model.scene->node_count()},
               {"repeats", o.repeats},
               {"tree", tree_times(*model.scene, o)}};
  auto search = search_times(*model.scene, o);
  if (!search) return tl::unexpected(search.error());
  json["search"] = std::move(*search);
  return finish(o.json, json, print);
}

}  // namespace
}  // namespace sightline::bench::tree_bench

sightline::bench::Run sightline::bench::add_tree(apps::CommandLine& line) {
  using namespace tree_bench;
  return add_subcommand<Options>(line, add_options, run);
}
