// Culling and frame times along the tour: what the culler keeps and what of it is seen, cullers beside each other,
// and what the tests for items that cannot be seen cost and save.
#include <algorithm>

#include "sightline/apps/common/drawn_variant.h"
#include "sightline/apps/common/flight.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/report/report.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::apps {
namespace {

using engine::CullerChoice;
using engine::OcclusionChoice;
using Style = PanelSeries::Style;

Json summary_json(const std::vector<double>& values) {
  return {{"median", median(values)}, {"p95", percentile(values, 0.95)}, {"max", percentile(values, 1.0)}};
}

/// name, median, 95th percentile, maximum
std::vector<std::string> summary_row(std::string name, const std::vector<double>& values) {
  return {std::move(name), number(median(values)), number(percentile(values, 0.95)), number(percentile(values, 1.0))};
}

Flight fly_tour(const Report& report, const engine::EngineConfig& config,
                const std::function<void(engine::Engine&)>& after_frame) {
  auto engine = need(engine::Engine::create(report.scene(), config));
  const auto after = [&](Flight&) -> core::Expected<void> {
    after_frame(engine);
    return {};
  };
  return need(fly(engine, report.tour(), {report.options().frames, report.aspect(), true}, after));
}

/// Flies views[first] … views[end - 1]. Frames of the first view come before, so that as many frames are in flight as
/// later, and one after ends the last; neither counts. A frame's time is known when the next one begins.
void fly_block(engine::Engine& engine, std::span<const core::View> views, std::size_t first, std::size_t end,
               Flight& flight) {
  constexpr std::size_t kInFlight = 2;
  engine.paused();
  for (std::size_t k = 0; k < kInFlight + end - first + 1; ++k) {
    const std::size_t i = std::clamp(first + k, first + kInFlight, end + kInFlight - 1) - kInFlight;
    const auto frame = need(engine.frame(views[i]));
    if (!frame.drawn) fail("frame " + std::to_string(i) + ": the GL context was lost");
    if (k > kInFlight) flight.frames.back().report.frame_ms = frame.frame_ms;
    if (k >= kInFlight && k < kInFlight + end - first) flight.frames.push_back({0.0, frame});
  }
  engine.finish();
}

/// Flies the tour with an engine for each configuration, block by block in turns, so that other load of the machine
/// affects all equally.
std::vector<Flight> fly_in_turns(const Report& report, const std::vector<engine::EngineConfig>& configs,
                                 const SectionProgress& progress) {
  constexpr std::size_t kBlock = 20;
  const auto views = report.tour_views(report.options().frames);
  std::vector<engine::Engine> engines;
  for (const engine::EngineConfig& config : configs) {
    engines.push_back(need(engine::Engine::create(report.scene(), config)));
  }
  std::vector<Flight> flights(engines.size());
  for (std::size_t first = 0; first < views.size(); first += kBlock) {
    const std::size_t end = std::min(first + kBlock, views.size());
    for (std::size_t k = 0; k < engines.size(); ++k) {
      const std::size_t turn = (k + first / kBlock) % engines.size();
      fly_block(engines[turn], views, first, end, flights[turn]);
    }
    progress(double(end) / double(views.size()));
  }
  return flights;
}

std::vector<double> frame_times(const Flight& flight) {
  return flight.collect([](const engine::FrameReport& r) { return r.frame_ms; });
}

// --- what the culler keeps -------------------------------------------------------------------------------------------

/// Milliseconds of each view of the tour, on one thread: the median of some passes.
std::vector<double> time_culler(const Report& report) {
  constexpr int kPasses = 7;
  const auto views = report.tour_views(report.options().frames);
  const culling::CpuCuller culler(report.snapshot().bounds());
  core::VisibleSet set;
  std::vector<double> times;
  for (const core::View& view : views) {
    std::vector<double> passes;
    for (int pass = 0; pass < kPasses; ++pass) {
      const double begin = now_ms();
      culler.cull(view, set);
      passes.push_back(now_ms() - begin);
    }
    times.push_back(median(std::move(passes)));
  }
  return times;
}

/// By frame: items in the view volume, items that may cover a sample, items drawn with the occlusion test, and items
/// that are visible in the id image.
struct Shares {
  std::vector<double> visible, sampled, items_drawn, visible_in_ids;
};

Shares measure_shares(const Report& report, const SectionProgress& progress) {
  Shares shares;
  engine::EngineConfig config = report.engine_config();
  config.culling.culler = CullerChoice::kCpu;
  config.drawing.ids = true;
  config.culling.occlusion = OcclusionChoice::kOff;
  const Flight flight = fly_tour(report, config, [&](engine::Engine& engine) {
    shares.visible_in_ids.push_back(double(visible_in_ids(need(engine.read_ids())).size()));
    progress(0.5 * double(shares.visible_in_ids.size()) / report.options().frames);
  });
  shares.visible = flight.visible(), shares.sampled = flight.sampled();
  config.culling.occlusion = OcclusionChoice::kOn;
  shares.items_drawn = fly_tour(report, config, [](engine::Engine&) {}).items_drawn();
  return shares;
}

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

// --- frames of the tour ----------------------------------------------------------------------------------------------

/// A way to draw the tour. The first is the reference of the tests: everything in the view volume is drawn. The fourth
/// is the CPU culler as by default.
struct Way {
  const char *test, *culler_name;  ///< rows of the two tables; null: in none
  const char* colour;              ///< of the culler
  CullerChoice culler;
  bool sample_test;
  OcclusionChoice occlusion;
  const char* options;
};
constexpr Way kWays[] = {
    {"neither test", nullptr, nullptr, CullerChoice::kCpu, false, OcclusionChoice::kOff,
     "--culler cpu --sample-test off --occlusion off"},
    {"sample test", nullptr, nullptr, CullerChoice::kCpu, true, OcclusionChoice::kOff,
     "--culler cpu --sample-test on --occlusion off"},
    {"sample and occlusion test", nullptr, nullptr, CullerChoice::kCpu, true, OcclusionChoice::kOn,
     "--culler cpu --sample-test on --occlusion on"},
    {"occlusion test while it pays, as by default", "cpu", colours::kCpu, CullerChoice::kCpu, true,
     OcclusionChoice::kAutomatic, "--culler cpu"},
    {nullptr, "gpu", colours::kGpu, CullerChoice::kGpu, true, OcclusionChoice::kAutomatic, "--culler gpu"},
    {nullptr, "hybrid", colours::kHybrid, CullerChoice::kHybrid, true, OcclusionChoice::kAutomatic, "--culler hybrid"},
};
constexpr std::size_t kTests = 4;  // the first of them

engine::EngineConfig config_of(const Report& report, const Way& way) {
  engine::EngineConfig config = report.engine_config();
  config.culling.culler = way.culler;
  config.culling.sample_test = way.sample_test;
  config.culling.occlusion = way.occlusion;
  return config;
}

/// Pixels of all compared frames, and the frame in which most have another colour.
struct Differences {
  std::uint64_t pixels = 0, wrong = 0, ties = 0;
  std::uint64_t worst = 0;  ///< pixels of another colour; 0: there is no such frame
  std::vector<LabelledImage> worst_images;
};

void compare(const DrawnImage& reference, const DrawnImage& image, const std::string& label, Differences& differences) {
  const auto wrong = need(wrong_items(reference, image));
  differences.pixels += reference.ids.ids.size();
  differences.wrong += wrong.wrong_ids;
  differences.ties += wrong.ties;
  const auto colours = need(image::compare(reference.colour, image.colour));
  if (colours.pixels <= differences.worst) return;
  differences.worst = colours.pixels;
  differences.worst_images = {{"neither test, " + label, reference.colour},
                              {kDifferenceLabel, differences_on_white(reference.colour, image.colour)}};
}

int compared_frames(const Report& report) {
  return std::min(8, report.options().frames);
}

/// Draws some frames of the tour with each choice of tests, and compares the images with those of the first.
std::vector<Differences> compare_tests(const Report& report, const SectionProgress& progress) {
  const auto views = report.tour_views(compared_frames(report));
  const std::shared_ptr<core::Scene> scene = report.shared_scene();
  std::vector<DrawnVariant> variants;
  for (const Way& way : std::span(kWays).first(kTests)) {
    variants.push_back(need(DrawnVariant::create(scene, config_of(report, way))));
  }
  std::vector<Differences> differences(variants.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    DrawnImage reference;
    for (std::size_t i = 0; i < variants.size(); ++i) {
      need(variants[i].draw(views[v]));
      auto image = need(variants[i].image(views[v]));
      if (i == 0)
        reference = std::move(image);
      else
        compare(reference, image, "frame " + std::to_string(v), differences[i]);
    }
    progress(0.5 + 0.5 * double(v + 1) / double(views.size()));
  }
  return differences;
}

std::string commands_of(const Report& report, bool (*chosen)(const Way&)) {
  std::string commands;
  for (const Way& way : kWays)
    if (chosen(way))
      commands +=
          (commands.empty() ? "" : "\n") +
          report.command("replay", std::string(way.options) + " " + report.tour_option() + " " + report.size_option());
  return commands;
}

/// CPU, GPU and hybrid culling.
void show_cullers(const Report& report, const std::vector<Flight>& flights, Section& section) {
  Rows rows;
  Panel panel;
  std::string headline;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const Way& way = kWays[i];
    if (!way.culler_name) continue;
    const std::vector<double> frame = frame_times(flights[i]);
    std::vector<std::string> row = summary_row(way.culler_name, frame);
    row.push_back(std::to_string(flights[i].on_gpu()) + " of " + std::to_string(flights[i].frames.size()));
    rows.push_back(std::move(row));
    panel.series.push_back(line_over_frames(way.culler_name, frame, Style::kLine, way.colour));
    section.results[way.culler_name] = {
        {"frame_ms", summary_json(frame)}, {"frames_on_gpu", flights[i].on_gpu()}, {"trace_ms", frame}};
    headline += (headline.empty() ? "" : ", ") + std::string(way.culler_name) + " " + number(median(frame));
  }
  const std::string commands = commands_of(report, [](const Way& way) { return way.culler_name != nullptr; });
  section.html.table(
      {"culler", "frame, median, ms", "95th percentile", "maximum", "culled on the GPU"}, rows,
      {"Whole frames along the tour, culling and drawing, two in flight; twenty frames of each culler in "
       "turns. A hybrid of a small scene has no GPU path.",
       commands});
  section.html.plot(plot_over_frames("Frame time along the tour", "ms a frame", {std::move(panel)}, false),
                    {"The same frame by frame.", commands});
  section.headline = "median frame, ms: " + headline + ".";
}

/// The tests for items that cannot be seen.
void show_tests(const Report& report, const std::vector<Flight>& flights, const std::vector<Differences>& differences,
                Section& section) {
  Rows rows;
  std::size_t worst = 1;
  for (std::size_t i = 0; i < kTests; ++i) {
    const std::vector<double> frame = frame_times(flights[i]);
    const Differences& d = differences[i];
    std::vector<std::string> row = summary_row(kWays[i].test, frame);
    row.push_back(number(sum(flights[i].items_drawn()) / double(flights[i].frames.size())));
    row.push_back(i == 0 ? "reference" : grouped(d.wrong - d.ties));
    row.push_back(i == 0 ? "" : grouped(d.ties));
    rows.push_back(std::move(row));
    section.results["tests"].push_back({{"label", kWays[i].test},
                                        {"frame_ms", summary_json(frame)},
                                        {"wrong_ids", d.wrong - d.ties},
                                        {"ties", d.ties}});
    if (i > 1 && d.worst > differences[worst].worst) worst = i;
  }
  const Differences& shown = differences[worst];
  section.results["pixels"] = shown.pixels;
  section.html.heading("Leaving out what cannot be seen");
  section.html.table({"CPU culler, with", "frame, median, ms", "95th percentile", "maximum", "items drawn, mean",
                      "pixels with another item", "ties"},
                     rows,
                     {"The same frames of the tour with what cannot be seen left out of drawing, and " +
                          grouped(shown.pixels) + " pixels of " + std::to_string(compared_frames(report)) +
                          " frames against drawing everything. A tie: two items at one depth, "
                          "either of which may be drawn.",
                      commands_of(report, [](const Way& way) { return way.test != nullptr; })});
  if (shown.worst == 0) {
    section.html.paragraph("All pixels of these frames have equal colours.");
    return;
  }
  need(section.html.images(shown.worst_images,
                           {"The frame with most differences, with the " + std::string(kWays[worst].test) + ": " +
                                grouped(shown.worst) + " pixels have another colour.",
                            report.section_command("frames")}));
}

}  // namespace

Section culling_section(const Report& report, const SectionProgress& progress) {
  Section section;
  const auto times = time_culler(report);
  const std::string along = "along " + std::to_string(report.options().frames) + " frames of the tour";
  const std::string command = report.command("replay", "--culler cpu --no-render " + report.tour_option());
  section.html.table({"", "median", "95th percentile", "maximum"}, {summary_row("time to cull, ms", times)},
                     {"The CPU culler " + along + ", one thread; median of seven culls a view.", command});
  section.results["cull_ms"] = summary_json(times);

  const auto shares = measure_shares(report, progress);
  const double all = double(report.scene().item_count()), frames = double(report.options().frames);
  const double visible = sum(shares.visible), visible_in_ids = sum(shares.visible_in_ids);
  Rows rows;
  const auto row = [&](const char* name, const char* key, const std::vector<double>& counts) {
    const double total = sum(counts);
    rows.push_back({name, number(total / frames), percent(total / frames / all),
                    visible > 0.0 ? percent(total / visible) : "-",
                    total > 0.0 ? percent(1.0 - visible_in_ids / total) : "-"});
    section.results[key] = {{"mean", total / frames},
                            {"false_positives", total > 0.0 ? 1.0 - visible_in_ids / total : 0.0}};
  };
  row("in the view volume (frustum culling)", "visible", shares.visible);
  row("and may cover a sample (sample test)", "sampled", shares.sampled);
  row("and not found hidden (occlusion test): drawn", "items_drawn", shares.items_drawn);
  row("are visible in the id image", "visible_in_ids", shares.visible_in_ids);
  section.html.table({"items", "mean of a frame", "of all items", "of those in the view volume",
                      "of these, are not visible in the id image"},
                     rows,
                     {"What each step keeps, and its false positives: items that are not visible in the id image at " +
                          report.options().size + ". No step leaves out a visible item.",
                      report.command("replay", "--culler cpu --occlusion on " + report.tour_option() + " " +
                                                   report.size_option() + " --json -") +
                          "\n" + report.section_command("culling")});
  section.html.plot(
      plot_over_frames(
          "Items kept by each step", "items",
          {{"",
            {line_over_frames("in the view volume", shares.visible, Style::kHeavyLine, colours::kInView),
             line_over_frames("may cover a sample", shares.sampled, Style::kHeavyLine, colours::kSampled),
             line_over_frames("drawn with the occlusion test", shares.items_drawn, Style::kLine, colours::kUnoccluded),
             line_over_frames("are visible in the id image", shares.visible_in_ids, Style::kDashes, colours::kSeen)}}},
          true),
      {"The same frame by frame.", report.section_command("culling")});
  const double unseen = sum(shares.sampled) - visible_in_ids, found = sum(shares.sampled) - sum(shares.items_drawn);
  if (unseen > 0.0)
    section.html.paragraph(
        "Of the items that may cover a sample but are not visible in the id image, the occlusion test leaves out " +
        percent(found / unseen) + ".");
  section.results["occluded_found"] = unseen > 0.0 ? found / unseen : 1.0;
  section.headline = number(median(times)) + " ms a view; " +
                     (visible > 0.0 ? percent(visible_in_ids / visible) : std::string("none")) +
                     " of the items in the view volume are visible in the id image.";
  return section;
}

Section frames_section(const Report& report, const SectionProgress& progress) {
  Section section;
  std::vector<engine::EngineConfig> configs;
  for (const Way& way : kWays) configs.push_back(config_of(report, way));
  const auto flights = fly_in_turns(report, configs, [&](double share) { progress(0.5 * share); });
  const auto differences = compare_tests(report, progress);
  show_cullers(report, flights, section);
  show_tests(report, flights, differences, section);
  return section;
}

}  // namespace sightline::apps
