#include "sightline/apps/paged_replay.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/paged_model.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/core/internal/clock.h"
#include "sightline/core/internal/platform/memory.h"
#include "sightline/engine/tour.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/view_json.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

using Json = json::Value;

struct Flown {
  double time = 0.0;       // on the path
  double settle_ms = 0.0;  // until the image was complete; 0 where nobody waited for that
  engine::PagedReport report;
};

core::CameraPath choose_path(const PagedReplayOptions& o, const core::PagedScene& scene) {
  if (!o.path.empty()) return need(importers::read_path(o.path));
  if (!o.model.quiet) warn_of_outliers(scene.fitted);
  return engine::make_tour(scene.leaves, scene.fitted);
}

void save_image(const PagedReplayOptions& o, const engine::PagedEngine& engine, std::size_t frame) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%05zu.png", frame);
  need(image::write_png(engine.read_colour(), std::filesystem::path(o.images) / name));
}

Flown draw(engine::PagedEngine& engine, const core::View& view, double time, bool settle) {
  const double began = core::now_seconds();
  const auto report = need(settle ? engine.settle(view) : engine.frame(view));
  return Flown{time, settle ? 1e3 * (core::now_seconds() - began) : 0.0, report};
}

std::vector<Flown> fly(const PagedReplayOptions& o, engine::PagedEngine& engine, const core::CameraPath& path,
                       double aspect) {
  Progress progress("flying", std::size_t(o.frames));
  std::vector<Flown> flight;
  for (int frame = 0; frame < o.frames; ++frame) {
    const double time = path.time_of(frame, o.frames);
    const auto view = need(path.view(time, aspect));
    flight.push_back(draw(engine, view, time, o.settle));
    if (!o.images.empty() && frame % o.every == 0) save_image(o, engine, std::size_t(frame));
    progress.advance(std::size_t(frame) + 1);
  }
  return flight;
}

std::vector<double> collect(const std::vector<Flown>& flight, double (*pick)(const Flown&)) {
  std::vector<double> values;
  for (const Flown& f : flight) values.push_back(pick(f));
  return values;
}

struct Row {
  const char *name, *key;
  double (*pick)(const Flown&);
  int decimals;
};
constexpr Row kRows[] = {
    {"frame ms", "frame_ms", [](const Flown& f) { return f.report.frame_ms; }, 3},
    {"settle ms", "settle_ms", [](const Flown& f) { return f.settle_ms; }, 3},
    {"leaves", "leaves", [](const Flown& f) { return double(f.report.leaves); }, 0},
    {"pending leaves", "pending", [](const Flown& f) { return double(f.report.pending); }, 0},
    {"placeholders", "placeholders", [](const Flown& f) { return double(f.report.placeholders); }, 0},
    {"drawn items", "items_drawn", [](const Flown& f) { return double(f.report.items_drawn); }, 0},
    {"memory MiB", "memory_mib", [](const Flown& f) { return double(f.report.memory) / (1 << 20); }, 1},
};

std::size_t complete(const std::vector<Flown>& flight) {
  return std::size_t(std::count_if(flight.begin(), flight.end(), [](const Flown& f) { return f.report.complete; }));
}

Json to_json(const PagedReplayOptions& o, const engine::PagedEngine& engine, const std::vector<Flown>& flight,
             const Flown& rest, const std::array<int, 2>& size) {
  Json out = {{"model", o.model.files},
              {"items", engine.scene().items},
              {"pages", engine.scene().pages.size()},
              {"renderer", engine.renderer()},
              {"size", size},
              {"complete_frames", complete(flight)},
              {"settle_ms_at_the_end", rest.settle_ms},
              {"loaded", rest.report.loaded},
              {"evicted", rest.report.evicted},
              {"prefetched_in_vain", rest.report.prefetched},
              {"memory",
               {{"limit", *parse_bytes(o.memory)},
                {"pages", engine.memory().limit},
                {"scene", engine.scene().memory_bytes()},
                {"peak", core::platform::peak_memory()}}}};
  out["frames"] = Json::array();
  for (const Flown& f : flight) {
    Json row = {{"t", f.time}, {"complete", f.report.complete}, {"resident", f.report.resident}};
    for (const Row& r : kRows) row[r.key] = r.pick(f);
    out["frames"].push_back(std::move(row));
  }
  for (const Row& r : kRows) out["summary"][r.key] = apps::to_json(summarise(collect(flight, r.pick)));
  return out;
}

void print_table(const PagedReplayOptions& o, const engine::PagedEngine& engine, const std::vector<Flown>& flight,
                 const Flown& rest) {
  std::FILE* const out = table_stream(o.json_file);
  std::fprintf(out, "%zu frames, %llu items in %zu pages, renderer %s\n\n", flight.size(),
               (unsigned long long)engine.scene().items, engine.scene().pages.size(), engine.renderer().c_str());
  std::fprintf(out, "%-16s %12s %12s %12s %12s\n", "", "mean", "median", "p99", "max");
  for (const Row& r : kRows) {
    if (std::string_view(r.key) == "settle_ms" && !o.settle) continue;
    const Summary s = summarise(collect(flight, r.pick));
    std::fprintf(out, "%-16s %12.*f %12.*f %12.*f %12.*f\n", r.name, r.decimals, s.mean, r.decimals, s.median,
                 r.decimals, s.p99, r.decimals, s.max);
  }
  constexpr double kMiB = 1024.0 * 1024.0;
  std::fprintf(out, "\n%zu frames complete; the last view took %.0f ms more\n", complete(flight), rest.settle_ms);
  std::fprintf(out,
               "pages: %llu read, %llu given up, %llu of those read ahead not needed; %llu read by coarsest levels\n",
               (unsigned long long)rest.report.loaded, (unsigned long long)rest.report.evicted,
               (unsigned long long)rest.report.prefetched, (unsigned long long)rest.report.coarse_loaded);
  std::fprintf(out, "memory MiB: peak %.1f of %.1f, boxes of all leaves %.1f, pages at most %.1f\n",
               double(core::platform::peak_memory()) / kMiB, double(*parse_bytes(o.memory)) / kMiB,
               double(engine.scene().memory_bytes()) / kMiB, double(engine.memory().limit) / kMiB);
}

}  // namespace

core::Expected<int> replay_paged(const PagedReplayOptions& o) {
  const auto size = need(parse_size(o.size));
  if (!o.images.empty()) need(make_directory(o.images));
  auto engine = need(open_paged(o.model, o.memory,
                                {.width = size[0],
                                 .height = size[1],
                                 .losses = {.budget_ms = o.budget_ms, .lod_error = o.lod_error},
                                 .context = {.platform = o.platform}}));
  const auto path = choose_path(o, engine.scene());
  if (!o.save_path.empty()) need(importers::write_path(o.save_path, path));
  const double aspect = double(size[0]) / size[1];
  const auto flight = fly(o, engine, path, aspect);
  const double last = flight.back().time;
  const auto view = need(path.view(last, aspect));
  const auto rest = draw(engine, view, last, true);
  if (!o.images.empty()) save_image(o, engine, flight.size());
  need(page_errors(engine));
  need(write_json(o.json_file, json::sorted(to_json(o, engine, flight, rest, size))));
  print_table(o, engine, flight, rest);
  return kExitOk;
}

}  // namespace sightline::apps
