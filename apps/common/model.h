// Loads models, in the same way for every tool.
#pragma once

#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "sightline/core/camera_path.h"
#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/engine/engine.h"
#include "sightline/importers/import.h"

namespace sightline::apps {

class CommandLine;

struct ModelOptions {
  std::vector<std::string> files;
  std::string translate;  ///< "X,Y,Z" metres, empty for none
  importers::ImportOptions import;
  bool explain = false;
  bool quiet = false;  ///< load_model() prints nothing
  /// Called now and then while files are read, with what has been read of them.
  std::function<void(const core::Scene&)> follow = {};
};

/// Metres of mm, cm, m, km, in or ft; nothing for other names.
std::optional<double> metres_of(const std::string& unit);

/// A finite number above 0.
core::Expected<double> parse_tolerance(const std::string& text);
/// 0 to 180 degrees, as radians.
core::Expected<double> parse_degrees(const std::string& text);

/// ImportOptions::crease_angle of tools that make images for people: 30 degrees.
inline constexpr double kCreaseAngle = std::numbers::pi / 6;

/// --lenient, --units, --up, --recognise, --recognise-tolerance, --chord-tolerance, --chord-angle, --in-process,
/// --cache: how files are read.
void add_import_options(CommandLine& line, importers::ImportOptions& options);
/// The arguments that give these options, each after a space.
std::string import_arguments(const importers::ImportOptions& options);

struct DrawnOptions;

/// MODEL…, --translate, --explain and the import options.
void add_model_options(CommandLine& line, ModelOptions& options);

struct Model {
  std::unique_ptr<core::Scene> scene;
  importers::ImportReport report;
  core::dvec3 offset{0.0};  ///< --translate
  bool seems_y_up = false;  ///< a file that does not say was turned for it (importers::kSeemsYUp)
};

/// Prints the first few in full to stderr.
void print_warnings(const std::vector<importers::ImportWarning>& warnings);

/// One line for people: what was recognised, and what was not, why.
std::string recognition_words(const importers::RecognitionReport& report);

/// One line for people: what became of exact surfaces.
std::string surface_words(const importers::ExactSurfaceReport& report);

/// Imports all files below the root, whose transform is --translate. Prints warnings and progress to stderr
/// unless ModelOptions::quiet.
core::Expected<Model> load_model(const ModelOptions& options);
/// Loads as above for a tool that waits for the levels of detail which `shown` asks for. Scene caches hold them, too.
core::Expected<Model> load_model(ModelOptions options, const DrawnOptions& shown);

/// Prints one line to stderr if views and tours of the whole leave out items.
void warn_of_outliers(const core::FittedBounds& fitted);

/// Default field of view of a camera, radians.
inline constexpr double kFovy = std::numbers::pi / 4;

/// --culler, into `choice`.
void add_culler_option(CommandLine& line, engine::CullerChoice& choice);

/// --gpu-variant, into `variant`.
void add_gpu_variant_option(CommandLine& line, std::optional<culling::GpuVariant>& variant);

/// --renderer. Without it what the environment variable SIGHTLINE_RENDERER names, else automatic.
void add_renderer_option(CommandLine& line, engine::Renderer& renderer);
/// Tells on stderr that rays draw since no context could be made.
void note_rays(engine::Engine& engine);
/// --context-platform, into `platform`, and --gl-workaround. Builds without GL have no such options.
void add_context_option(CommandLine& line, gl::ContextPlatform& platform);

/// --samples
void add_samples_option(CommandLine& line, int& samples);

/// What of the view volume is drawn.
struct DrawnOptions {
  bool sample_test = true;
  engine::OcclusionChoice occlusion = engine::OcclusionChoice::kAutomatic;
  float min_projected_area = 0.0f;
  engine::ContributionMode contribution_mode = engine::ContributionMode::kDrop;
  double budget_ms = 0.0, lod_error = 0.0;
  engine::Looks looks;  ///< where the others say nothing
  bool plain = false;   ///< begins with Looks() instead
  std::optional<double> depth_shading = {}, edge_lines = {}, hatching = {};
  std::optional<engine::EdgeChoice> edges = {};
  struct Background {
    bool transparent = false;
    gpuprims::Background colours;
  };
  std::optional<Background> background = {};
  /// "transparent", a colour or two: what --background takes.
  static core::Expected<Background> parse_background(const std::string& text);
  std::optional<core::dvec3> sun = {};

  engine::Looks all_looks() const;
  /// The looks for people of a model: where they are not asked for otherwise, edges of meshes that came with faces, as
  /// those of STEP files do, are drawn.
  engine::Looks looks_of(const core::Scene& scene) const;
  void apply(engine::EngineConfig& config) const;
};

/// --sample-test on|off, --occlusion on|off|auto, --min-projected-area PX, --contribution-mode drop|points|stochastic,
/// --budget-ms MS, --depth-shading X, --edge-lines X, --edges off|feature|all, --edge-width PX, --hatching X,
/// --sun X,Y,Z
void add_drawn_options(CommandLine& line, DrawnOptions& options);

/// --background transparent|COLOUR|TOP,BOTTOM, for tools that write images
void add_background_option(CommandLine line, DrawnOptions& options);

/// --plain, for tools whose images have other looks without it
void add_plain_option(CommandLine& line, DrawnOptions& options);

/// Prints to stderr which features are used and which are left out.
void explain(const engine::Plan& plan);

/// For tools that draw nothing: prints the plan for drawing the committed scene.
void explain(const core::Scene& scene);

}  // namespace sightline::apps
