// State that the sections of a report share: the loaded model, the views that it is drawn from, and how values are
// written.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sightline/apps/common/html_images.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/numbers.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/internal/clock.h"
#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::raytrace {
class Tracer;
}

namespace sightline::apps {

using Json = json::Value;

struct ReportOptions {
  ModelOptions model;
  std::string out, size = "640x360", json, save_path;
  std::vector<std::string> sections;  ///< ids; empty: all
  std::string colour_by;              ///< of the first image; as query::colour_by() has it, empty: the model's own
  int frames = 16;                    ///< of the tour
  gl::ContextPlatform platform = {};
};

/// Milliseconds of wall clock.
struct LoadTimes {
  double read = 0.0, commit = 0.0, snapshot = 0.0, hierarchy = 0.0;
  double context = 0.0, engine = 0.0, first_frame = 0.0;

  /// From the files to the first image. The engine makes its own snapshot and hierarchy.
  double first_image() const { return read + commit + context + engine + first_frame; }
};

/// A place from which images are taken.
struct ReportView {
  std::string name;
  core::View view;
  std::string options;  ///< that make sightline-render show it
};

/// Frames that the tour is divided into for single images, so that a frame's number is per cent; and the file with
/// the tour in commands, which --save-path writes.
inline constexpr int kTourFrames = 101;
inline constexpr const char* kTourFile = "tour.json";

/// The model with everything that several sections need.
class Report {
 public:
  /// Loads the model and draws a first frame.
  explicit Report(const ReportOptions& options);

  const ReportOptions& options() const { return options_; }
  const Model& model() const { return model_; }
  core::Scene& scene() const { return *model_.scene; }
  /// For what keeps its scene alive, which the report does already.
  std::shared_ptr<core::Scene> shared_scene() const {
    return {&scene(), [](core::Scene*) {}};
  }
  const LoadTimes& times() const { return times_; }
  gl::Context& context() const { return *context_; }
  /// With ids, and otherwise as engines are by default.
  engine::Engine& engine() const { return *engine_; }
  const core::Snapshot& snapshot() const { return engine_->snapshot(); }
  const core::FittedBounds& fitted() const { return fitted_; }
  const core::CameraPath& tour() const { return tour_; }
  /// The tracer of snapshot(), in double precision; null in builds without ray tracing.
  const raytrace::Tracer* tracer() const { return tracer_.get(); }
  const std::vector<ReportView>& views() const { return views_; }
  int width() const { return size_[0]; }
  int height() const { return size_[1]; }
  double aspect() const { return double(size_[0]) / size_[1]; }
  /// Nothing that could be drawn.
  bool empty() const { return snapshot().size() == snapshot().vacant_count(); }

  /// For an engine of its own in the shared context.
  engine::EngineConfig engine_config() const;
  /// The views of `frames` evenly spaced frames of the tour.
  std::vector<core::View> tour_views(int frames) const;
  /// A command line of a tool for the same model: "sightline-TOOL MODEL… ARGUMENTS".
  std::string command(const std::string& tool, const std::string& arguments) const;
  /// "--size 640x360"
  std::string size_option() const { return "--size " + options_.size; }
  /// "--path tour.json --frames 60"
  std::string tour_option() const;
  /// This tool with one section, which measures the figures again.
  std::string section_command(const std::string& section) const;

 private:
  void load();
  void make_tour();
  void find_views();
  /// The default view of sightline-render.
  core::View overview() const;

  ReportOptions options_;
  std::array<int, 2> size_{};
  Model model_;
  LoadTimes times_;
  std::unique_ptr<gl::Context> context_;            // before the engine, which uses it
  std::unique_ptr<engine::Engine> engine_;          // after the scene
  std::shared_ptr<const raytrace::Tracer> tracer_;  // of the engine's snapshot
  core::FittedBounds fitted_;
  core::CameraPath tour_;
  std::vector<ReportView> views_;
};

struct Section {
  HtmlBody opening;  ///< for the top of the page, above the sections that a click opens
  HtmlBody html;
  Json results = Json::object();
  std::string headline;
  std::string left_out;  ///< why, when there is nothing to show
};

/// Called with the share of the section's work that is done.
using SectionProgress = std::function<void(double)>;

using Rows = std::vector<std::vector<std::string>>;

struct SectionMaker {
  const char *id, *title;
  Section (*make)(const Report& report, const SectionProgress& progress);
  bool of_images = true;  ///< left out where the scene has nothing to draw
};
Section glance_section(const Report& report, const SectionProgress& progress);
Section model_section(const Report& report, const SectionProgress& progress);
Section plan_section(const Report& report, const SectionProgress& progress);
Section images_section(const Report& report, const SectionProgress& progress);
Section culling_section(const Report& report, const SectionProgress& progress);
Section visibility_section(const Report& report, const SectionProgress& progress);
Section frames_section(const Report& report, const SectionProgress& progress);
Section error_section(const Report& report, const SectionProgress& progress);
Section stability_section(const Report& report, const SectionProgress& progress);

/// One colour for one thing in all plots of the page.
namespace colours {
inline constexpr const char *kExact = "#1f6fb4", *kTriangles = "#d9731a", *kLevels = "#2c9c3f";
inline constexpr const char *kSamples = "#a67c00", *kContribution = "#d6409f";
inline constexpr const char *kInView = "#7b52ab", *kSampled = "#0097a7", *kUnoccluded = "#c62828", *kSeen = "#222222";
inline constexpr const char *kCpu = "#795548", *kGpu = "#689f00", *kHybrid = "#f9a825";
}  // namespace colours

// --- how values are written -----------------------------------------------------------------------------------------

/// Items that are visible in the id image, in rising order.
std::vector<core::ItemId> visible_in_ids(const image::IdImage& image);
/// WIDTHxHEIGHT, large enough for the measures of errors.
core::Expected<std::array<int, 2>> parse_report_size(const std::string& text);
/// Steady clock, milliseconds.
inline double now_ms() {
  return 1e3 * core::now_seconds();
}
/// Three significant digits or a whole number: "0.0123", "4.56", "12,345", "2.1·10⁻⁷".
std::string number(double value);
/// "circular torus"
std::string kind_words(core::Kind kind);
/// "12.3 %" of a share.
std::string percent(double share);
/// "1.2 MiB", with the unit that fits.
std::string bytes_words(std::size_t bytes);

/// A value of each frame of the tour.
PanelSeries line_over_frames(std::string label, const std::vector<double>& values, PanelSeries::Style style,
                             const char* colour);
/// A plot of several such; counts on a logarithmic axis, times on a linear one.
std::string plot_over_frames(std::string title, std::string quantity, std::vector<Panel> panels, bool logarithmic);

/// Absolute differences, four times amplified; white where there are none. Sizes must be equal.
image::Image differences_on_white(const image::Image& a, const image::Image& b);
inline constexpr const char* kDifferenceLabel = "their difference, four times amplified; white: none";

}  // namespace sightline::apps
