#include "sightline/apps/report/report.h"

#include <algorithm>
#include <cmath>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/common/svg_canvas.h"
#include "sightline/apps/common/view_options.h"
#include "sightline/core/internal/platform/console.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/engine/tour.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/apps/report/tour.h"
#endif

namespace sightline::apps {
namespace {

/// Runs `step` and returns how long it took.
template <class Step>
double timed(const Step& step) {
  const double begin = now_ms();
  step();
  return now_ms() - begin;
}

/// One interrupted frame must not flatten all others: cuts lines far above most of their values, and says so.
void cut_outliers(PanelPlot& plot) {
  constexpr double kOutlier = 2.0, kMost = 0.95;
  double top = 0.0, highest = 0.0;
  for (const Panel& panel : plot.panels)
    for (const PanelSeries& series : panel.series) {
      std::vector<double> values;
      for (const PanelSeries::Point& point : series.points) values.push_back(point.y);
      top = std::max(top, kOutlier * percentile(values, kMost));
      highest = std::max(highest, percentile(std::move(values), 1.0));
    }
  if (highest <= top) return;
  plot.y_label += ", cut at " + number(top) + "; most " + number(highest);
  for (Panel& panel : plot.panels)
    for (PanelSeries& series : panel.series)
      for (PanelSeries::Point& point : series.points) point.y = std::min(point.y, top);
}

}  // namespace

Report::Report(const ReportOptions& options) : options_(options), size_(need(parse_size(options.size))) {
  load();
  make_tour();
  find_views();
}

void Report::load() {
  double begin = now_ms();
  const auto lap = [&begin] {
    const double end = now_ms();
    return end - std::exchange(begin, end);
  };
  model_ = need(load_model(options_.model));
  times_.read = lap();
  need(scene().commit());
  times_.commit = lap();
  {
    const core::Snapshot snapshot(scene());
    times_.snapshot = lap();
    times_.hierarchy = timed([&] { const culling::CpuCuller culler(snapshot.bounds()); });
    fitted_ = snapshot.bounds().fitted_bounds();
  }
  lap();
  auto context = need(gl::Context::create_offscreen({.platform = options_.platform}));
  context_ = std::make_unique<gl::Context>(std::move(context));
  times_.context = lap();
  engine::EngineConfig config = engine_config();
  config.drawing.ids = true;
  auto engine = need(engine::Engine::create(scene(), config));
  engine_ = std::make_unique<engine::Engine>(std::move(engine));
  times_.engine = lap();
  const auto view = overview();
  need(engine_->frame(view));
  engine_->finish();
  times_.first_frame = lap();
}

void Report::make_tour() {
#if SIGHTLINE_HAS_RAYTRACE
  tracer_ = std::make_shared<const raytrace::Tracer>(need(raytrace::Tracer::create(snapshot())));
  tour_ = need(tour_in_sight(*tracer_, fitted_, aspect()));
#else
  tour_ = engine::make_tour(snapshot().bounds(), fitted_);
#endif
}

core::View Report::overview() const {
  ViewOptions options;
  options.quiet = true;
  return need(choose_view(options, model_, snapshot(), aspect()));
}

void Report::find_views() {
  const auto whole = overview();
  views_.push_back({"overview", whole, "--fit"});
  if (empty()) return;
  struct Candidate {
    int frame;
    core::View view;
    std::size_t items, pixels;
  };
  constexpr int kStep = 5;
  std::vector<Candidate> candidates;
  for (int frame = kStep; frame < kTourFrames - 1; frame += kStep) {
    auto view = need(tour_.view(tour_.time_of(frame, kTourFrames), aspect()));
    need(engine_->frame(view));
    const auto ids = need(engine_->read_ids());
    const auto background = std::size_t(std::count(ids.ids.begin(), ids.ids.end(), 0u));
    candidates.push_back({frame, view, visible_in_ids(ids).size(), ids.ids.size() - background});
  }
  // One place that shows many items, and one where some of them fill the image, but not a single one.
  const auto most = std::max_element(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
                      return a.items < b.items;
                    })->items;
  std::erase_if(candidates, [&](const Candidate& c) { return 20 * c.items < most; });
  for (std::size_t Candidate::*value : {&Candidate::items, &Candidate::pixels}) {
    if (candidates.empty()) break;
    const auto best = std::max_element(candidates.begin(), candidates.end(),
                                       [&](const auto& a, const auto& b) { return a.*value < b.*value; });
    const int frame = best->frame;
    views_.push_back({"tour at " + std::to_string(frame) + " %", best->view,
                      std::string("--path ") + kTourFile + " --frames " + std::to_string(kTourFrames) + " --frame " +
                          std::to_string(frame)});
    std::erase_if(candidates, [&](const Candidate& c) { return std::abs(c.frame - frame) < 3 * kStep; });
  }
}

engine::EngineConfig Report::engine_config() const {
  engine::EngineConfig config;
  config.draw = true;
  config.width = width();
  config.height = height();
  config.context.application = context_.get();
  return config;
}

std::vector<core::View> Report::tour_views(int frames) const {
  std::vector<core::View> views;
  for (int i = 0; i < frames; ++i) {
    auto view = need(tour_.view(tour_.time_of(i, frames), aspect()));
    views.push_back(view);
  }
  return views;
}

std::string Report::command(const std::string& tool, const std::string& arguments) const {
  std::string line = "sightline-" + tool;
  for (const std::string& file : options_.model.files) line += " " + core::platform::shell_word(file);
  if (!options_.model.translate.empty()) line += " --translate " + core::platform::shell_word(options_.model.translate);
  line += import_arguments(options_.model.import);
  // It is of shading alone, which other tools do not show.
  if (options_.model.import.crease_angle != kCreaseAngle && (tool == "render" || tool == "report"))
    line += " --crease-angle " + short_number(glm::degrees(options_.model.import.crease_angle), 17);
  return arguments.empty() ? line : line + " " + arguments;
}

std::string Report::tour_option() const {
  return std::string("--path ") + kTourFile + " --frames " + std::to_string(options_.frames);
}

std::string Report::section_command(const std::string& section) const {
  return command("report", size_option() + " --frames " + std::to_string(options_.frames) + " --sections " + section +
                               " --out report.html");
}

std::vector<core::ItemId> visible_in_ids(const image::IdImage& image) {
  std::vector<core::ItemId> visible_in_ids;
  for (const std::uint32_t id : image.ids)
    if (id != 0) visible_in_ids.push_back(core::ItemId{id - 1});
  core::sort_unique(visible_in_ids);
  return visible_in_ids;
}

core::Expected<std::array<int, 2>> parse_report_size(const std::string& text) {
  auto size = parse_size(text);
  if (size && ((*size)[0] < 64 || (*size)[1] < 36))
    return core::fail("expected 64x36 at least, found \"" + text + "\"");
  return size;
}

std::string number(double value) {
  if (std::abs(value) >= 1000.0 && std::abs(value) < 1e7) return grouped(std::llround(value));
  std::string text = short_number(value);
  const std::size_t exponent = text.find('e');
  if (exponent == std::string::npos) return text;
  const int power = std::stoi(text.substr(exponent + 1));
  constexpr const char* kSuperscripts[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = text.substr(0, exponent) + "·10" + (power < 0 ? "⁻" : "");
  for (const char digit : std::to_string(std::abs(power))) out += kSuperscripts[digit - '0'];
  return out;
}

std::string kind_words(core::Kind kind) {
  std::string name(core::name_of(kind));
  std::ranges::replace(name, '_', ' ');
  return name;
}

std::string percent(double share) {
  return number(100.0 * share) + " %";
}

PanelSeries line_over_frames(std::string label, const std::vector<double>& values, PanelSeries::Style style,
                             const char* colour) {
  PanelSeries series{std::move(label), {}, style, colour};
  for (std::size_t i = 0; i < values.size(); ++i) series.points.push_back({double(i), values[i], ""});
  return series;
}

std::string plot_over_frames(std::string title, std::string quantity, std::vector<Panel> panels, bool logarithmic) {
  PanelPlot plot{std::move(title), "frame of the tour", std::move(quantity), std::move(panels)};
  plot.log_x = false;
  plot.log_y = logarithmic;
  plot.large = plot.panels.size() == 1;
  if (!logarithmic) cut_outliers(plot);
  return svg_panels(plot);
}

image::Image differences_on_white(const image::Image& a, const image::Image& b) {
  image::Image out = image::difference_image(a, b);
  for (std::uint8_t& value : out.pixels) value = std::uint8_t(255 - value);
  return out;
}

std::string bytes_words(std::size_t bytes) {
  constexpr const char* kUnits[] = {" bytes", " KiB", " MiB", " GiB"};
  double value = double(bytes);
  std::size_t unit = 0;
  for (; value >= 1024.0 && unit + 1 < std::size(kUnits); ++unit) value /= 1024.0;
  return number(value) + kUnits[unit];
}

}  // namespace sightline::apps
