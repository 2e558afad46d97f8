// sightline-study overrides: what it costs to override items of a model, or to hide them, until the GPU has it.
//
// Each call overrides a number of random items and is then undone. The time is that of the call, and of glFinish after
// it, with nothing drawn in between.
#include <algorithm>
#include <cstdio>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/engine.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/parts/parts.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/engine/pick.h"
#endif

namespace sightline::bench::overrides_bench {
namespace {

using Json = json::Value;
using core::ItemId;
using engine::Engine;

struct Options {
  apps::ModelOptions model;
  engine::CullerChoice culler = engine::CullerChoice::kAutomatic;
  int repeats = 9;
  bool picks = false;
  std::string json;
};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_model_options(line, o.model);
  apps::add_culler_option(line, o.culler);
  line.add("--repeats", o.repeats, "Of each call, with other items; the median counts")
      .in_range(1, 1000)
      .shows_default();
#if SIGHTLINE_HAS_RAYTRACE
  line.add_flag("--picks", o.picks, "The application has picked: the tracer follows, too");
#endif
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-study overrides plant.rvm\n"
      "  sightline-study overrides plant.rvm --culler gpu --json overrides.json");
}

using Items = std::span<const ItemId>;
struct Call {
  const char* name;
  core::Expected<void> (*apply)(Engine&, Items);
  const char* undo_name;
  core::Expected<void> (*undo)(Engine&, Items);
};
core::Expected<void> clear(Engine& engine, Items items) {
  return engine.clear_override(items);
}
const Call kCalls[] = {
    {"colour", [](Engine& e, Items i) { return e.set_override(i, {.colour = core::vec3(1, 0.5f, 0)}); }, "clear colour",
     clear},
    {"alpha", [](Engine& e, Items i) { return e.set_override(i, {.alpha = 0.5f}); }, "clear alpha", clear},
    {"ghost", [](Engine& e, Items i) { return e.set_override(i, {.ghost = true}); }, "clear ghost", clear},
    {"hide", [](Engine& e, Items i) { return e.hide(i); }, "show", [](Engine& e, Items i) { return e.show(i); }},
};

/// The medians of both calls, milliseconds.
core::Expected<std::pair<double, double>> measure(Engine& engine, const Call& call, std::vector<ItemId>& items,
                                                  std::size_t count, int repeats) {
  std::mt19937_64 random(1);
  const gl::Functions& gl = engine.drawing()->context().functions();
  const auto timed = [&](auto apply, Items some, std::vector<double>& times) -> core::Expected<void> {
    gl.Finish();
    const double start = milliseconds();
    if (auto done = apply(engine, some); !done) return done;
    gl.Finish();
    times.push_back(milliseconds() - start);
    return {};
  };
  std::vector<double> there, back;
  for (int i = 0; i <= repeats; ++i) {  // the first warms up
    for (std::size_t k = 0; k < count; ++k) std::swap(items[k], items[k + random() % (items.size() - k)]);
    const Items some = std::span(items).first(count);
    if (auto done = timed(call.apply, some, there); !done) return tl::unexpected(done.error());
    if (auto done = timed(call.undo, some, back); !done) return tl::unexpected(done.error());
  }
  there.erase(there.begin());
  back.erase(back.begin());
  return std::pair(apps::median(there), apps::median(back));
}

void print(const Json& json, std::FILE* out) {
  std::fprintf(out, "%-13s %10s %12s %14s\n", "call", "items", "ms", "us per item");
  for (const Json& row : json["calls"])
    std::fprintf(out, "%-13s %10zu %12.3f %14.3f\n", row["call"].get<std::string>().c_str(),
                 row["items"].get<std::size_t>(), row["ms"].get<double>(),
                 1e3 * row["ms"].get<double>() / double(row["items"].get<std::size_t>()));
}

core::Expected<int> run(const Options& o) {
  auto model = apps::load_model(o.model);
  if (!model) return tl::unexpected(model.error());
  auto engine =
      Engine::create(*model->scene, {.draw = true, .width = 640, .height = 360, .culling = {.culler = o.culler}});
  if (!engine) return tl::unexpected(engine.error());
  std::vector<ItemId> items;
  for (core::Slot slot = 0; slot < engine->snapshot().size(); ++slot) items.push_back(engine->snapshot().item(slot));
#if SIGHTLINE_HAS_RAYTRACE
  if (o.picks)
    if (auto picked = engine->pick(core::Ray{}); !picked) return tl::unexpected(picked.error());
#endif
  const gl::Context& context = engine->drawing()->context();
  Json json = renderer_json(context);
  json.update({{"model", o.model.files}, {"items", items.size()}, {"repeats", o.repeats}});
  std::fprintf(apps::table_stream(o.json), "%s, %s\n\n", engine::count_text(items.size()).c_str(),
               renderer_line(context).c_str());
  for (const std::size_t count : {std::size_t(1), std::max<std::size_t>(1, items.size() / 100), items.size()}) {
    for (const Call& call : kCalls) {
      const auto ms = measure(*engine, call, items, count, count == items.size() ? std::min(3, o.repeats) : o.repeats);
      if (!ms) return tl::unexpected(ms.error());
      json["calls"].push_back({{"call", call.name}, {"items", count}, {"ms", ms->first}});
      json["calls"].push_back({{"call", call.undo_name}, {"items", count}, {"ms", ms->second}});
    }
  }
  return finish(o.json, json, print);
}

}  // namespace
}  // namespace sightline::bench::overrides_bench

sightline::bench::Run sightline::bench::add_overrides(apps::CommandLine& line) {
  using namespace overrides_bench;
  return add_subcommand<Options>(line, add_options, run);
}
