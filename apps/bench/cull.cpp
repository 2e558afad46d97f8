// sightline-bench cull: culling only, on boxes and views from files.
//
// --boxes: little-endian float32, (min x y z, max x y z) per item, no header. --views: little-endian float64, 16 per
// frame, column-major clip_from_world, clip space -1 ... 1. Ids are the items' places in the boxes file.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/bench/brute_force.h"
#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/core/block_order.h"
#include "sightline/core/error.h"
#include "sightline/core/internal/instruction_set.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/frustum/internal/slot_list.h"
#include "sightline/culling/frustum/linear_culler.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench::cull_bench {
namespace {

using apps::need;
using Json = json::Value;

struct Options {
  Input input;
  std::string culler = "cpu", output = "ranges", ids_out, json, simd = "best";
  int threads = 1;
  bool verify = false, baseline = false;
};

void add_options(apps::CommandLine& line, Options& options) {
  add_input_options(line, options.input);
  line.add("--culler", options.culler, "which culler").one_of({"linear", "cpu"}).shows_default();
  line.add("--threads", options.threads, "threads of the hierarchy's build; culling runs on one")
      .in_range(1, 1024)
      .shows_default();
  line.add("--simd", options.simd, "instruction set of the cullers")
      .one_of({"best", "scalar", "neon", "avx2", "avx512"})
      .shows_default();
  line.add("--output", options.output, "time ranges and items, or the full list of ids, or of slots")
      .one_of({"ranges", "ids", "slots"})
      .shows_default();
  line.add("--ids-out", options.ids_out, "write frame_%05d.bin (sorted uint32) per frame into this directory");
  line.add_flag("--verify", options.verify, "compare every frame with the linear culler; exit 1 on a difference");
  line.add_flag("--baseline", options.baseline, "also time brute force over all boxes, and print the ratio");
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-bench cull --boxes boxes.f32 --views views.f64 --verify\n"
      "  sightline-bench cull --boxes boxes.f32 --views views.f64 --output ids --ids-out ids --json out.json");
}

// --- what is measured ------------------------------------------------------------------------------------------------

/// One of the cullers with its data, and the mapping from slots back to the file's order.
struct Subject {
  Subject(std::span<const core::Aabb> boxes, const Options& options);
  Subject(const Subject&) = delete;  // the culler points into the bounds
  Subject& operator=(const Subject&) = delete;

  core::ItemBounds bounds;
  std::vector<std::uint32_t> order;  // empty: slots are ids
  std::optional<culling::CpuCuller> cpu;
  double build_ms = 0.0;

  void cull(const core::View& view, core::VisibleSet& set) const {
    if (cpu)
      cpu->cull(view, set);
    else
      culling::LinearCuller(bounds).cull(view, set);
  }

  /// All visible ids (or slots), in no particular order.
  void list(const core::VisibleSet& set, bool as_slots, std::vector<std::uint32_t>& ids) const {
    const bool same = as_slots || order.empty();
    ids.resize(set.count());
    if (same)
      culling::list_slots(set, ids);
    else
      culling::list_ids(set, order, ids);
  }

  double bytes_per_item() const {
    const std::size_t bytes =
        bounds.memory_bytes() + order.size() * sizeof(std::uint32_t) + (cpu ? cpu->memory_bytes() : 0);
    return bounds.size() == 0 ? 0.0 : double(bytes) / double(bounds.size());
  }
};

Subject::Subject(std::span<const core::Aabb> boxes, const Options& options) {
  const double start = milliseconds();
  if (options.culler == "cpu") {
    order = core::block_order(boxes, {.smallest_block = culling::kLeafSize, .threads = options.threads});
    fill(bounds, boxes, order);
    cpu.emplace(bounds);
  } else {
    fill(bounds, boxes, {});
  }
  build_ms = milliseconds() - start;
}

// --- runs ------------------------------------------------------------------------------------------------------------

void write_ids(const std::string& directory, std::size_t frame, std::span<const std::uint32_t> ids) {
  char name[32];
  std::snprintf(name, sizeof(name), "frame_%05zu.bin", frame);
  const std::filesystem::path path = core::platform::path_of(directory) / name;
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(ids.data()), std::streamsize(ids.size_bytes()));
  if (!file.flush()) apps::fail(path.string() + ": cannot be written");
}

Json summary(const std::vector<double>& times) {
  return apps::to_json(apps::summarise(times));
}

struct Frames {
  std::vector<std::uint64_t> visible;
  std::uint64_t nodes_tested = 0, boxes_tested = 0;
};

double time_refit(Subject& subject) {
  std::vector<double> times;
  for (std::size_t pass = 0; subject.cpu && pass < kPasses; ++pass) {
    const double start = milliseconds();
    subject.cpu->refit();
    times.push_back(milliseconds() - start);
  }
  return apps::median(times);
}

void choose_instructions(const std::string& name) {
  for (const auto set : core::kInstructionSets) {
    if (name != core::name_of(set)) continue;
    if (!core::supported(set)) apps::fail("--simd " + name + ": this processor or build does not have it");
    core::force_instruction_set(set);
  }
}

/// Not timed: counts, id files, and the comparison with the linear culler.
Frames inspect(const Subject& subject, std::span<const core::Aabb> boxes, const std::vector<core::View>& views,
               const Options& options) {
  core::ItemBounds plain;
  if (options.verify) fill(plain, boxes, {});
  const culling::LinearCuller linear(plain);
  Frames frames;
  core::VisibleSet set, expected;
  std::vector<std::uint32_t> ids;
  for (std::size_t i = 0; i < views.size(); ++i) {
    subject.cull(views[i], set);
    frames.visible.push_back(set.count());
    frames.nodes_tested += set.counters.nodes_tested;
    frames.boxes_tested += set.counters.boxes_tested;
    if (options.ids_out.empty() && !options.verify) continue;
    subject.list(set, false, ids);
    std::sort(ids.begin(), ids.end());
    if (!options.ids_out.empty()) write_ids(options.ids_out, i, ids);
    if (!options.verify) continue;
    linear.cull(views[i], expected);
    if (ids != expected.sorted_slots())
      apps::fail("frame " + std::to_string(i) + ": " + std::to_string(ids.size()) +
                 " visible, but the linear culler finds another set of " + std::to_string(expected.count()));
  }
  return frames;
}

Json measure(const Options& options) {
  choose_instructions(options.simd);
  const auto boxes = need(boxes_of(options.input));
  const auto views = need(read_views(options.input.views));
  if (!options.ids_out.empty()) need(apps::make_directory(options.ids_out));
  Subject subject(boxes, options);
  const Frames frames = inspect(subject, boxes, views, options);

  core::VisibleSet set;
  std::vector<std::uint32_t> ids;
  const double refit_ms = time_refit(subject);
  const bool list_ids = options.output != "ranges", as_slots = options.output == "slots";
  const std::vector<double> times = time_path(views.size(), [&](std::size_t i) {
    subject.cull(views[i], set);
    if (list_ids) subject.list(set, as_slots, ids);
  });

  const double count = std::max(1.0, double(views.size()));
  Json json{
      {"items", boxes.size()},
      {"culler", options.culler},
      {"output", options.output},
      {"instructions", core::name_of(core::instruction_set())},
      {"build_ms", subject.build_ms},
      {"refit_ms", refit_ms},
      {"bytes_per_item", subject.bytes_per_item()},
      {"mean_visible", double(std::accumulate(frames.visible.begin(), frames.visible.end(), std::uint64_t(0))) / count},
      {"mean_nodes_tested", double(frames.nodes_tested) / count},
      {"mean_boxes_tested", double(frames.boxes_tested) / count}};
  Json& list = json["frames"] = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i)
    list.push_back({{"cull_ms", times[i]}, {"visible", frames.visible[i]}});
  json["summary"] = summary(times);
  if (options.verify) json["verified"] = true;
  if (options.baseline) {
    BruteForce baseline(boxes);
    const Json base = summary(time_path(views.size(), [&](std::size_t i) { baseline.cull(views[i]); }));
    const auto mean = json["summary"]["mean"].get<double>();
    json["baseline"] = {{"method", BruteForce::name()}, {"summary", base}};
    json["baseline_over_culler"] = mean > 0.0 ? base["mean"].get<double>() / mean : 0.0;
  }
  return json;
}

// --- output ----------------------------------------------------------------------------------------------------------

void print_table(const Json& json, std::FILE* out) {
  const auto ms = [&](const Json& s) {
    std::fprintf(out, "mean %.4f  median %.4f  p99 %.4f  max %.4f ms per frame\n", s["mean"].get<double>(),
                 s["median"].get<double>(), s["p99"].get<double>(), s["max"].get<double>());
  };
  std::fprintf(out, "%zu items, %zu frames, culler %s, output %s\n", json["items"].get<std::size_t>(),
               json["frames"].size(), json["culler"].get<std::string>().c_str(),
               json["output"].get<std::string>().c_str());
  std::fprintf(out, "%s, build %.1f ms, refit %.2f ms, %.1f bytes per item\n",
               json["instructions"].get<std::string>().c_str(), json["build_ms"].get<double>(),
               json["refit_ms"].get<double>(), json["bytes_per_item"].get<double>());
  std::fprintf(out, "visible %.0f, nodes tested %.0f, boxes tested %.0f (means)\n", json["mean_visible"].get<double>(),
               json["mean_nodes_tested"].get<double>(), json["mean_boxes_tested"].get<double>());
  ms(json["summary"]);
  if (json.contains("verified")) std::fprintf(out, "same set as the linear culler on every frame\n");
  if (!json.contains("baseline")) return;
  std::fprintf(out, "baseline (%s): ", json["baseline"]["method"].get<std::string>().c_str());
  ms(json["baseline"]["summary"]);
  std::fprintf(out, "baseline / culler: %.2f (ratio of means)\n", json["baseline_over_culler"].get<double>());
}

core::Expected<int> run(const Options& options) {
  return finish(options.json, measure(options), print_table);
}

}  // namespace
}  // namespace sightline::bench::cull_bench

sightline::bench::Run sightline::bench::add_cull(apps::CommandLine& line) {
  using namespace cull_bench;
  return add_subcommand<Options>(line, add_options, run);
}
