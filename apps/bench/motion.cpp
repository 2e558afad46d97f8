// sightline-bench motion: what the images of a moving camera lack, and what they take. The camera walks at 1.5 m/s,
// flies at 15 m/s, and orbits the model in four seconds; a frame shows where it is a 30th of a second later, whatever
// the frame before took. Some frames are compared with the complete image of their view, and so is the next one, since
// an error that changes between them flickers.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/moving_engine.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/drawn_variant.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/paged_model.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/item_bounds.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/engine/tour.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::bench::motion_bench {
namespace {

using Json = json::Value;
using apps::DrawnImage;
using apps::need;
using engine::Engine;

constexpr double kFrameSeconds = 1.0 / 30.0;
constexpr double kOrbitSeconds = 4.0;
constexpr int kStretches = 4;  // of the tour, evenly spaced, that a flight along it consists of
constexpr int kNear = 2;       // pixels within which an item counts as shown

struct Options {
  ModelOrPlant model;
  int frames = 40, every = 10;
  double budget_ms = 33.0, lod_error = 0.0;
  gl::ContextPlatform platform = {};
  std::string size = "1280x720", memory, json, plot, images, strip;
  std::vector<std::string> ways{"traced", "drawn", "complete"};
};

/// A way to make a moving image. On a GPU none is traced.
struct Way {
  const char *name, *title;
  bool budget = true, traced = true;
};
constexpr Way kComplete{"complete", "complete", false};
constexpr Way kWays[] = {
    {"traced", "traced within the budget"},
    {"drawn", "drawn within the budget", true, false},
    kComplete,
};

std::vector<std::string> way_names() {
  std::vector<std::string> names;
  for (const Way& way : kWays) names.emplace_back(way.name);
  return names;
}

void add_options(apps::CommandLine& line, Options& o) {
  add_model_or_plant_options(line, o.model);
  add_frames_option(line, o.frames, kStretches);
  line.add("--every", o.every, "Compare every so-manieth frame and the next with the complete image")
      .in_range(2, 1000)
      .shows_default();
  line.add("--budget", o.budget_ms, "Milliseconds for a frame").shows_default().positive();
  line.add("--lod-error", o.lod_error, "Pixels within which meshes are drawn by levels of detail")
      .accepted_by(apps::parse_finite)
      .in_range(0.0, 64.0);
  line.add("--size", o.size, "Pixels").shows_default().accepted_by(apps::parse_size);
  line.add("--ways", o.ways, "Ways to draw moving images, beside each other")
      .separated_by(',')
      .one_value_each()
      .one_of(way_names())
      .shows_default();
  line.add("--memory", o.memory, "Fly with a paged engine that has so much memory beside the bench's own")
      .metavar("LIMIT")
      .accepted_by(apps::parse_bytes);
  line.check([&o]() -> core::Expected<void> {
    if (o.memory.empty() || o.model.model.files.size() == 1) return {};
    return core::fail("--memory: expected one scene cache");
  });
  line.add("--images", o.images, "Write compared frames and their complete images to this folder").metavar("FOLDER");
  line.add("--strip", o.strip,
           "Write frames of the first flight in a row, a row for each way and one of complete images")
      .metavar("FILE");
  line.add("--plot", o.plot, "Write a plot of error against time to FILE.svg").metavar("FILE");
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench motion plant.rvm --plot motion.svg\n"
      "  sightline-bench motion --items 1000000 --budget 33 --images frames");
}

// --- flights ---------------------------------------------------------------------------------------------------------

struct Flight {
  std::string name;
  std::vector<core::View> views;
  std::vector<bool> begins;  // a stretch of the flight: the view jumps
};

class Flights {
 public:
  Flights(const core::Snapshot& snapshot, double aspect, int frames)
      : fitted_(snapshot.bounds().fitted_bounds()),
        path_(engine::make_tour(snapshot.bounds(), fitted_)),
        aspect_(aspect),
        frames_(frames) {}

  Flight along_tour(const std::string& name, double metres_per_second) const {
    Flight flight{name, {}, {}};
    const int each = std::max(1, frames_ / kStretches);
    for (int stretch = 0; stretch < kStretches; ++stretch) {
      double time = path_.time_of(stretch, kStretches + 1);
      for (int i = 0; i < each; ++i) {
        add(flight, path_.sample(time), i == 0);
        time += std::min(kFrameSeconds, kFrameSeconds * metres_per_second / std::max(speed(time), 1e-3));
      }
    }
    return flight;
  }

  /// Round the model, in so many frames as the four seconds have, from one place on.
  Flight orbit() const {
    Flight flight{"orbit in 4 s", {}, {}};
    const core::CameraSample first = path_.sample(path_.begin());
    const core::dvec3 centre = fitted_.bounds.centre(), arm = first.pose.eye - centre;
    for (int i = 0; i < frames_; ++i) {
      const double angle = 2.0 * std::numbers::pi * double(i) * kFrameSeconds / kOrbitSeconds;
      const double c = std::cos(angle), s = std::sin(angle);
      core::CameraSample sample = first;
      sample.pose.eye = centre + core::dvec3(c * arm.x - s * arm.y, s * arm.x + c * arm.y, arm.z);
      sample.pose.target = centre;
      add(flight, sample, i == 0);
    }
    return flight;
  }

 private:
  /// Speed of the eye on the tour, metres a second.
  double speed(double time) const {
    constexpr double kStep = 1e-3;
    return glm::length(path_.sample(time + kStep).pose.eye - path_.sample(time).pose.eye) / kStep;
  }
  void add(Flight& flight, const core::CameraSample& at, bool begins) const {
    flight.views.push_back(need(core::View::perspective(at.pose, at.fovy, aspect_, path_.near)));
    flight.begins.push_back(begins);
  }

  core::FittedBounds fitted_;
  core::CameraPath path_;
  double aspect_;
  int frames_;
};

// --- errors ----------------------------------------------------------------------------------------------------------

/// How far a moving image is from the complete one.
struct Errors {
  double covered = 1.0;     // share of the pixels with an item that show any
  double right_item = 1.0;  // share of them whose item the moving image shows within kNear pixels
  double flip = 0.0;        // mean
};

bool shows_near(const image::IdImage& ids, std::uint32_t id, int x, int y) {
  for (int v = std::max(0, y - kNear); v <= std::min(ids.height - 1, y + kNear); ++v)
    for (int u = std::max(0, x - kNear); u <= std::min(ids.width - 1, x + kNear); ++u)
      if (ids.ids[std::size_t(v) * std::size_t(ids.width) + std::size_t(u)] == id) return true;
  return false;
}

Errors errors_of(const DrawnImage& complete, const DrawnImage& moving) {
  std::uint64_t pixels = 0, covered = 0, right = 0;
  for (int y = 0; y < complete.ids.height; ++y)
    for (int x = 0; x < complete.ids.width; ++x) {
      const std::size_t at = std::size_t(y) * std::size_t(complete.ids.width) + std::size_t(x);
      const std::uint32_t id = complete.ids.ids[at];
      if (id == 0) continue;
      ++pixels;
      covered += std::uint64_t(std::isfinite(moving.depth.metres[at]));  // boxes of pages to come have no id
      right += std::uint64_t(moving.ids.ids[at] == id || shows_near(moving.ids, id, x, y));
    }
  Errors errors;
  if (pixels > 0) errors = {double(covered) / double(pixels), double(right) / double(pixels), 0.0};
  const std::vector<float> map = image::flip(complete.colour, moving.colour);
  for (const float error : map) errors.flip += double(error) / double(map.size());
  return errors;
}

/// A moving image and the complete one of its view.
struct Pair {
  DrawnImage moving, complete;
};

/// By how much the error of a channel changes from one frame to the next, mean, in 255ths.
double flicker(const Pair& before, const Pair& after) {
  double sum = 0.0;
  const std::size_t channels = before.complete.colour.pixels.size();
  for (std::size_t i = 0; i < channels; ++i) {
    const auto error = [&](const Pair& pair) {
      return int(pair.moving.colour.pixels[i]) - int(pair.complete.colour.pixels[i]);
    };
    sum += std::abs(error(after) - error(before));
  }
  return sum / double(channels);
}

// --- a strip of images -----------------------------------------------------------------------------------------------

constexpr int kStripImages = 6, kSmaller = 4;  // times along either axis

image::Image smaller(const image::Image& of) {
  image::Image out{of.width / kSmaller, of.height / kSmaller, {}};
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int v = y * kSmaller; v < (y + 1) * kSmaller; ++v)
          for (int u = x * kSmaller; u < (x + 1) * kSmaller; ++u)
            sum += of.pixels[3 * (std::size_t(v) * std::size_t(of.width) + std::size_t(u)) + std::size_t(c)];
        out.pixels.push_back(std::uint8_t(sum / (kSmaller * kSmaller)));
      }
  return out;
}

/// Evenly spaced images of each row.
image::Image side_by_side(const std::vector<std::vector<image::Image>>& rows) {
  const image::Image& first = rows.front().front();
  const std::size_t row_bytes = 3 * std::size_t(first.width);
  image::Image strip{kStripImages * first.width, int(rows.size()) * first.height, {}};
  for (const std::vector<image::Image>& images : rows)
    for (int y = 0; y < first.height; ++y)
      for (std::size_t i = 0; i < kStripImages; ++i) {
        const auto from =
            images[i * images.size() / kStripImages].pixels.begin() + std::ptrdiff_t(std::size_t(y) * row_bytes);
        strip.pixels.insert(strip.pixels.end(), from, from + std::ptrdiff_t(row_bytes));
      }
  return strip;
}

// --- measuring -------------------------------------------------------------------------------------------------------

struct Measured {
  std::vector<double> ms, pending, coarseness, earlier, covered, right_item, flip, flicker;
  double rest_ms = 0.0;  // until the image is complete once the camera stands
};

class Bench {
 public:
  /// `strip_of`: the flight whose frames the strip shows.
  Bench(core::Scene& scene, const Options& o, Engine complete, std::string strip_of)
      : scene_(scene), options_(o), complete_(std::move(complete)), strip_of_(std::move(strip_of)) {}

  /// Flies once against the clock and once to compare, since what a comparison reads and frees slows the next frames.
  Measured fly(const Flight& flight, const Way& way) {
    Measured measured;
    time(flight, way, measured);
    compare(flight, way, measured);
    return measured;
  }

  /// Evenly spaced frames of the flight.
  image::Image strip() const {
    std::vector<std::vector<image::Image>> rows;
    for (const auto& [way, images] : strip_) rows.push_back(images);
    if (!complete_strip_.empty()) rows.push_back(complete_strip_.begin()->second);
    return side_by_side(rows);
  }

  static engine::EngineConfig config_of(const Options& o, const Way& way) {
    const auto [width, height] = *apps::parse_size(o.size);
    engine::EngineConfig config = drawing_config(width, height, o.platform);
    if (way.budget) config.losses = {.budget_ms = o.budget_ms, .lod_error = o.lod_error};
    return config;
  }
  static Engine make_engine(core::Scene& scene, const Options& o, const Way& way) {
    return need(Engine::create(scene, config_of(o, way)));
  }

 private:
  /// An engine of its own, so that a flight knows nothing of others.
  MovingEngine engine_for(const Flight& flight, const Way& way) const {
    MovingEngine moving = options_.memory.empty() ? whole_engine(way) : paged_engine(way);
    // A first frame, of another view, compiles programs.
    need(moving.frame(flight.views[flight.views.size() / 2]));
    moving.wait_for_preparations();
    return moving;
  }
  MovingEngine whole_engine(const Way& way) const {
    Engine engine = make_engine(scene_, options_, way);
    engine::EngineParts::set_traces_motion(engine, way.traced);
    return MovingEngine(std::move(engine));
  }
  MovingEngine paged_engine(const Way& way) const {
    const engine::EngineConfig like = config_of(options_, way);
    return need(MovingEngine::paged(options_.model.model.files.front(), *apps::parse_bytes(options_.memory),
                                    {.width = like.width,
                                     .height = like.height,
                                     .drawing = like.drawing,
                                     .losses = like.losses,
                                     .context = {.platform = like.context.platform},
                                     .loading_bar = false}));
  }

  void time(const Flight& flight, const Way& way, Measured& measured) const {
    MovingEngine moving = engine_for(flight, way);
    for (const core::View& view : flight.views) {
      const double begin = milliseconds();
      const MovingEngine::Report report = need(moving.frame(view));
      measured.ms.push_back(milliseconds() - begin);
      measured.pending.push_back(double(report.pending));
      measured.coarseness.push_back(report.coarseness);
      measured.earlier.push_back(report.earlier);
    }
    measured.rest_ms = rest(moving, flight.views.back());
  }
  static double rest(MovingEngine& engine, const core::View& view) {
    const double begin = milliseconds();
    while (need(engine.frame(view)).pending > 0) {
    }
    return milliseconds() - begin;
  }

  void compare(const Flight& flight, const Way& way, Measured& measured) {
    MovingEngine moving = engine_for(flight, way);
    Pair before;
    for (std::size_t i = 0; i < flight.views.size(); ++i) {
      need(moving.frame(flight.views[i]));
      const std::size_t phase = i % std::size_t(options_.every);
      if (phase > 1) continue;
      Pair pair = compare(moving, flight.views[i], measured);
      if (phase == 1 && !flight.begins[i]) measured.flicker.push_back(flicker(before, pair));
      if (phase == 1 && flight.name == strip_of_) add_to_strip(pair, way);
      if (!options_.images.empty()) write(pair, flight.name.substr(0, flight.name.find(' ')), i, way);
      before = std::move(pair);
    }
  }
  Pair compare(MovingEngine& moving, const core::View& view, Measured& measured) {
    need(complete_.frame(view));
    complete_.finish();
    Pair pair{need(moving.image(view)), need(apps::read_image(complete_, view))};
    const Errors errors = errors_of(pair.complete, pair.moving);
    measured.covered.push_back(errors.covered);
    measured.right_item.push_back(errors.right_item);
    measured.flip.push_back(errors.flip);
    return pair;
  }
  void write(const Pair& pair, const std::string& flight, std::size_t frame, const Way& way) const {
    need(apps::make_directory(options_.images));
    const std::string stem = options_.images + "/" + flight + "-" + std::to_string(frame) + "-";
    need(image::write_png(pair.moving.colour, stem + way.name + ".png"));
    need(image::write_png(pair.complete.colour, stem + "whole.png"));
  }

  void add_to_strip(const Pair& pair, const Way& way) {
    if (way.budget) strip_[way.name].push_back(smaller(pair.moving.colour));
    complete_strip_[way.name].push_back(smaller(pair.complete.colour));
  }

  core::Scene& scene_;
  const Options& options_;
  Engine complete_;
  std::string strip_of_;
  std::map<std::string, std::vector<image::Image>> strip_, complete_strip_;  // by way, small
};

double least(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::min_element(values.begin(), values.end());
}

Json to_json(const Flight& flight, const Way& way, const Measured& m) {
  return {{"flight", flight.name},
          {"way", way.name},
          {"title", way.title},
          {"ms", apps::to_json(apps::summarise(m.ms))},
          {"first_ms", m.ms.front()},
          {"coarseness", apps::summarise(m.coarseness).mean},
          {"earlier", apps::summarise(m.earlier).mean},
          {"covered", apps::summarise(m.covered).mean},
          {"covered_least", least(m.covered)},
          {"right_item", apps::summarise(m.right_item).mean},
          {"flip", apps::summarise(m.flip).mean},
          {"flicker", apps::summarise(m.flicker).mean},
          {"pending", apps::summarise(m.pending).mean},
          {"rest_ms", m.rest_ms}};
}

constexpr apps::Column kColumns[] = {{"flight", "flight"},
                                     {"way", "way"},
                                     {"ms, median", "ms/median", "{:.1f}"},
                                     {"99 %", "ms/p99", "{:.1f}"},
                                     {"first", "first_ms", "{:.1f}"},
                                     {"coarseness", "coarseness", "{:.1f}"},
                                     {"earlier", "earlier", "{:.2f}"},
                                     {"covered, mean", "covered", "{:.4f}"},
                                     {"least", "covered_least", "{:.4f}"},
                                     {"right item", "right_item", "{:.3f}"},
                                     {"FLIP", "flip", "{:.3f}"},
                                     {"flicker", "flicker", "{:.2f}"},
                                     {"rest", "rest_ms", "{:.0f}"}};

core::Expected<void> plot(const std::string& file, const Json& rows) {
  apps::PanelPlot plot{.title = "Moving images",
                       .x_label = "milliseconds a frame, median",
                       .y_label = "mean FLIP against the complete image"};
  for (const Json& row : rows) {
    const std::string flight = row["flight"].get<std::string>();
    if (plot.panels.empty() || plot.panels.back().title != flight) plot.panels.push_back({flight, {}});
    plot.panels.back().series.push_back(
        {row["title"].get<std::string>(),
         {{row["ms"]["median"].get<double>(), row["flip"].get<double>(), row["way"].get<std::string>()}}});
  }
  return apps::write_text(file, apps::svg_panels(plot));
}

core::Expected<int> run(const Options& o) {
  const auto scene = need(model_or_plant(o.model.model, o.model.items));
  Engine complete = Bench::make_engine(*scene, o, kComplete);
  const core::Snapshot& snapshot = complete.snapshot();
  const auto [width, height] = *apps::parse_size(o.size);
  const Flights from(snapshot, double(width) / height, o.frames);
  const std::vector<Flight> flights = {from.along_tour("walk at 1.5 m/s", 1.5),
                                       from.along_tour("flight at 15 m/s", 15.0), from.orbit()};
  const gl::Context& context = engine::EngineParts::drawing(complete)->context();
  Json json = renderer_json(context);
  json.update({{"items", snapshot.size()}, {"size", o.size}, {"budget_ms", o.budget_ms}, {"rows", Json::array()}});
  std::fprintf(apps::table_stream(o.json), "%s, %s, budget %g ms, %s\n\n", engine::count_text(snapshot.size()).c_str(),
               o.size.c_str(), o.budget_ms, renderer_line(context).c_str());
  Bench bench(*scene, o, std::move(complete), flights.front().name);
  apps::Progress progress("measuring", flights.size() * o.ways.size());
  for (const Flight& flight : flights)
    for (const Way& way : kWays) {
      if (std::ranges::count(o.ways, way.name) == 0) continue;
      json["rows"].push_back(to_json(flight, way, bench.fly(flight, way)));
      progress.advance(json["rows"].size());
    }
  if (!o.strip.empty()) need(image::write_png(bench.strip(), o.strip));
  if (!o.plot.empty()) need(plot(o.plot, json["rows"]));
  return finish(o.json, json, [](const Json& all, std::FILE* out) { apps::print_table(all["rows"], kColumns, out); });
}

}  // namespace
}  // namespace sightline::bench::motion_bench

sightline::bench::Run sightline::bench::add_motion(apps::CommandLine& line) {
  using namespace motion_bench;
  return add_subcommand<Options>(line, add_options, run);
}
