// sightline-study calls: what a call takes that does little: a frame that is only culled, a pick, a query of boxes.
// study/parts/python_calls.py makes the same calls from Python.

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/culling/box_culler.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/pick.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::calls_bench {
namespace {

using Json = json::Value;

struct Options {
  std::uint64_t items = 100'000;
  int frames = 200, rounds = 20;
  std::string json_file;
};

void add_options(apps::CommandLine& line, Options& o) {
  line.add("--items", o.items, "Of the generated plant").shows_default().in_range(1000, 10000000);
  line.add("--frames", o.frames, "Views of the tour").shows_default().in_range(2, 100000);
  line.add("--rounds", o.rounds, "Over all views; the median counts").shows_default().in_range(1, 1000);
  line.add("--json", o.json_file, "Write figures as JSON to FILE, or - for stdout");
}

/// Microseconds that call(i) takes on average for i below `count`: the median of the rounds.
template <class Call>
double microseconds(const Options& o, const Call& call) {
  std::vector<double> rounds;
  for (int round = 0; round < o.rounds; ++round) {
    const double begin = milliseconds();
    for (int i = 0; i < o.frames; ++i) call(std::size_t(i));
    rounds.push_back(1e3 * (milliseconds() - begin) / o.frames);
  }
  return apps::median(std::move(rounds));
}

core::Expected<int> measure(const Options& o) {
  core::Scene scene;
  if (auto made = importers::generate_plant({o.items, 1}, scene); !made) return tl::unexpected(made.error());
  auto engine = engine::Engine::create(scene);
  if (!engine) return tl::unexpected(engine.error());
  const auto tour = tour_views(engine->snapshot(), o.frames, 1280.0 / 720.0);
  if (!tour) return tl::unexpected(tour.error());
  const std::vector<core::View>& views = *tour;
  std::vector<core::AabbD> boxes;
  boxes.reserve(scene.item_slots());
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    boxes.push_back(scene.bounds_under(item, scene.state(item).world_from_item));
  const auto culler = culling::BoxCuller::create(boxes);
  if (!culler) return tl::unexpected(culler.error());
  if (auto first = engine->pick(views[0], 640, 360); !first) return tl::unexpected(first.error());

  std::int64_t visible = 0, hits = 0, found = 0;
  std::vector<std::uint32_t> indices;
  Json figures = {{"items", o.items}, {"views", o.frames}};
  figures["frame_us"] = microseconds(o, [&](std::size_t i) { visible += engine->frame(views[i])->visible; });
  figures["pick_us"] = microseconds(o, [&](std::size_t i) { hits += engine->pick(views[i], 640, 360)->has_value(); });
  figures["boxes_us"] = microseconds(o, [&](std::size_t i) {
    culler->visible(views[i], indices);
    found += std::int64_t(indices.size());
  });
  figures["visible"] = visible / o.rounds;
  figures["hits"] = hits / o.rounds;
  figures["boxes"] = found / o.rounds;
  return finish(o.json_file, json::sorted(std::move(figures)), [](const Json& f, std::FILE* out) {
    for (const auto& [name, value] : f.items()) std::fprintf(out, "%-10s %s\n", name.c_str(), value.dump().c_str());
  });
}

}  // namespace
}  // namespace sightline::bench::calls_bench

sightline::bench::Run sightline::bench::add_calls(apps::CommandLine& line) {
  using namespace calls_bench;
  line.describe("  sightline-study calls --items 1000000 --json -");
  return add_subcommand<Options>(line, add_options, measure);
}
