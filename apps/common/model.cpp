#include "sightline/apps/common/model.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string_view>

#include <fmt/format.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/setting_options.h"
#include "sightline/core/internal/platform/environment.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/core/mesh_extras.h"
#if SIGHTLINE_HAS_GL
#include "sightline/gl/context.h"
#endif
#include "sightline/importers/slc/paged_scene.h"

namespace sightline::apps {

namespace {

const std::map<std::string, double>& lengths() {
  static const std::map<std::string, double> metres = {{"mm", 1e-3}, {"cm", 1e-2},   {"m", 1.0},
                                                       {"km", 1e3},  {"in", 0.0254}, {"ft", 0.3048}};
  return metres;
}

}  // namespace

core::Expected<double> parse_tolerance(const std::string& text) {
  auto tolerance = parse_finite(text);
  if (tolerance && *tolerance <= 0.0) return core::fail("expected a tolerance above 0, found \"" + text + "\"");
  return tolerance;
}

std::optional<double> metres_of(const std::string& unit) {
  const auto found = lengths().find(unit);
  return found == lengths().end() ? std::nullopt : std::optional(found->second);
}

core::Expected<double> parse_degrees(const std::string& text) {
  const auto degrees = parse_finite(text);
  if (!degrees || *degrees < 0.0 || *degrees > 180.0)
    return core::fail("expected 0 to 180 degrees, found \"" + text + "\"");
  return *degrees * std::numbers::pi / 180.0;
}

/// As parse_degrees(), but for 0.
core::Expected<double> parse_chord_angle(const std::string& text) {
  auto radians = parse_degrees(text);
  if (radians && *radians == 0.0) return core::fail("expected more than 0 degrees, found \"" + text + "\"");
  return radians;
}

void add_import_options(CommandLine& to, importers::ImportOptions& options) {
  CommandLine line = to.group(OptionGroup::kImport);
  line.add_flag("--lenient", options.lenient, "Keep what can be read of damaged files and list the damage").advanced();
  line.add_choice("--units", options.metres_per_unit, lengths(),
                  "Unit of files that name none (OBJ, PLY, STL, VTK): mm, cm, m, km, in or ft")
      .usage_text("UNIT (m)");
  line.add_choice("--up", options.up,
                  {{"y", importers::UpAxis::kY}, {"z", importers::UpAxis::kZ}, {"auto", importers::UpAxis::kAutomatic}},
                  "Axis that points up in files of formats that do not say; auto: by a comment, or by what meshes "
                  "stand on (OBJ, PLY, STL)")
      .shows_default();
  line.add_flag(
          "--recognise", options.recognise,
          "Take cylinders, snouts, tori, dishes, spheres, boxes and pyramids out of meshes that are the triangles of "
          "some")
      .advanced();
  line.add_parsed(
          "--recognise-tolerance", options.recognise_tolerance, parse_tolerance,
          "How far vertices may lie from a recognised surface, metres; without it, what each mesh's own tessellation "
          "and rounding tell")
      .needs("--recognise")
      .advanced();
  line.add_parsed(
          "--chord-tolerance", options.chord_tolerance, parse_tolerance,
          "How far triangles may lie from exact surfaces (STEP, IGES, BREP), metres; without it, 0.05 % of each part's "
          "diagonal")
      .advanced();
  line.add_parsed("--chord-angle", options.chord_angle, parse_chord_angle,
                  "Degrees: the largest angle between neighbouring facets of such a surface's curves")
      .default_text("12")
      .advanced();
  line.add_flag("--in-process", options.in_process,
                "Read STEP, IGES and BREP in this process, which a hostile file then may crash")
      .advanced();
  line.add("--cache", options.cache_folder, "Keep scene caches in this folder, for fast starts").metavar("FOLDER");
}

std::string import_arguments(const importers::ImportOptions& options) {
  std::string arguments = options.lenient ? " --lenient" : "";
  for (const auto& [name, metres] : lengths())
    if (metres == options.metres_per_unit && metres != 1.0) arguments += " --units " + name;
  const auto add = [&](const char* name, double value) { arguments += fmt::format(" {} {:.17g}", name, value); };
  if (options.recognise) arguments += " --recognise";
  if (options.recognise && options.recognise_tolerance > 0.0) add("--recognise-tolerance", options.recognise_tolerance);
  if (options.chord_tolerance > 0.0) add("--chord-tolerance", options.chord_tolerance);
  if (options.chord_angle != importers::ImportOptions().chord_angle)
    add("--chord-angle", options.chord_angle * 180.0 / std::numbers::pi);
  if (options.in_process) arguments += " --in-process";
  if (options.up == importers::UpAxis::kAutomatic) return arguments;
  return arguments + (options.up == importers::UpAxis::kY ? " --up y" : " --up z");
}

void add_model_options(CommandLine& line, ModelOptions& options) {
  std::string extensions;
  for (const std::string_view extension : importers::known_extensions())
    extensions.append(extensions.empty() ? "" : ", ").append(extension);
  line.group(OptionGroup::kGeneral)
      .add("MODEL", options.files, "Model files (" + extensions + "), loaded into one scene")
      .required();
  line.group(OptionGroup::kImport)
      .add_parsed(
          "--crease-angle", options.import.crease_angle, parse_degrees,
          "Degrees: meshes without normals (OBJ, PLY, STL, VTK) look smooth but for edges bent by more; 0: facet "
          "by facet")
      .default_text(options.import.crease_angle > 0.0 ? "30" : "0")
      .advanced();
  line.group(OptionGroup::kImport)
      .add("--translate", options.translate, "Move the model by X,Y,Z metres (root transform)")
      .accepted_by(parse_vector)
      .advanced();
  add_import_options(line, options.import);
  line.group(OptionGroup::kEngine)
      .add_flag("--explain", options.explain, "Print which features the scene needs and which are left out, and why")
      .advanced();
}

void print_warnings(const std::vector<importers::ImportWarning>& warnings) {
  constexpr std::size_t kShown = 5;
  std::size_t count = 0;
  for (const importers::ImportWarning& warning : warnings) {
    if (warning.message == importers::kSeemsYUp)
      std::fprintf(stderr, "note: %s seems to have y up and is turned; --up z keeps it\n", warning.file.c_str());
    else if (count++ < kShown)
      std::fprintf(stderr, "warning: %s: byte %llu: %s\n", warning.file.c_str(), (unsigned long long)warning.offset,
                   warning.message.c_str());
  }
  if (count > kShown) std::fprintf(stderr, "warning: and %zu more\n", count - kShown);
}

namespace {

/// A folder of scene caches stands for them, in the order in which --memory reads them.
core::Expected<std::vector<std::filesystem::path>> with_caches_of_folders(const std::vector<std::string>& files) {
  std::vector<std::filesystem::path> paths;
  for (const std::string& file : files) {
    const auto caches = importers::scene_caches_of(core::platform::path_of(file));
    if (!caches) return tl::unexpected(caches.error());
    paths.insert(paths.end(), caches->begin(), caches->end());
  }
  return paths;
}

}  // namespace

std::string recognition_words(const importers::RecognitionReport& report) {
  std::string kinds, refused;
  const auto add = [](std::string& to, std::uint64_t count, std::string_view name) {
    if (count > 0) to.append(to.empty() ? "" : ", ").append(std::to_string(count)).append(" ").append(name);
  };
  for (int k = 0; k < core::kPrimitiveKindCount; ++k)
    add(kinds, report.items[std::size_t(k)], core::name_of(core::Kind(k)));
  for (std::size_t k = 0; k < importers::kRefusalCount; ++k)
    add(refused, report.refused[k], name_of(importers::Refusal(k)));
  return fmt::format(
      "recognised {}; {} of {} triangles of distinct meshes left, {:.1f} of {:.1f} kB, at most {:.3g} m off{}{}",
      kinds.empty() ? "nothing" : kinds, report.triangles_after, report.triangles_before,
      1e-3 * double(report.bytes_after), 1e-3 * double(report.bytes_before), report.largest_deviation,
      refused.empty() ? "" : "; refused: ", refused);
}

std::string surface_words(const importers::ExactSurfaceReport& report) {
  return fmt::format(
      "{} parts in {} places: {} solids as primitives (at most {:.2g} m off), {} bodies as {} triangles (at most "
      "{:.2g} "
      "m off, {:.2g} m asked for)",
      report.parts, report.instances, report.analytic_solids, report.analytic_deviation, report.meshed_bodies,
      report.triangles, report.deviation, report.largest_tolerance);
}

core::Expected<Model> load_model(const ModelOptions& options) {
  Model model;
  model.scene = std::make_unique<core::Scene>();
  const auto paths = with_caches_of_folders(options.files);
  if (!paths) return tl::unexpected(paths.error());
  importers::ImportOptions reading = options.import;
  {
    std::optional<Progress> progress;
    if (!options.quiet) reading.progress = progress.emplace("reading").callback();
    if (options.follow)
      reading.progress = [&, told = reading.progress](double share) {
        options.follow(*model.scene);
        return !told || told(share);
      };
    auto report = importers::import_files(*paths, *model.scene, model.scene->root(), reading);
    if (!report) return tl::unexpected(report.error());
    model.report = std::move(*report);
  }
  if (!options.quiet) print_warnings(model.report.warnings);
  model.seems_y_up = std::ranges::any_of(model.report.warnings, [](const importers::ImportWarning& warning) {
    return warning.message == importers::kSeemsYUp;
  });
  // Only after the import: if an absurd offset moves items out of range, that is an error of the offset, and no item is
  // dropped.
  if (!options.translate.empty()) {
    const auto offset = parse_vector(options.translate);
    if (!offset) return tl::unexpected(offset.error());
    model.offset = *offset;
    model.scene->set_transform(model.scene->root(), core::translation(*offset));
  }
  return model;
}

core::Expected<Model> load_model(ModelOptions options, const DrawnOptions& shown) {
  options.import.cached_levels = shown.lod_error > 0.0;
  return load_model(options);
}

void warn_of_outliers(const core::FittedBounds& fitted) {
  if (fitted.outliers == 0) return;
  std::fprintf(stderr, "warning: %zu item%s too far from all others: fitted views and tours leave %s out\n",
               fitted.outliers, fitted.outliers == 1 ? " lies" : "s lie", fitted.outliers == 1 ? "it" : "them");
}

void add_culler_option(CommandLine& line, engine::CullerChoice& choice) {
  add_setting(line.group(OptionGroup::kEngine), "culler", choice).advanced();
}

void add_gpu_variant_option(CommandLine& line, std::optional<culling::GpuVariant>& variant) {
  add_setting(line.group(OptionGroup::kEngine), "gpu_variant", variant).advanced();
}

void add_renderer_option(CommandLine& line, engine::Renderer& renderer) {
  const char* const named = std::getenv("SIGHTLINE_RENDERER");
  renderer = engine::Renderer::kAutomatic;
  for (const auto one : {engine::Renderer::kGl, engine::Renderer::kRays})
    if (named && named == engine::name_of(one)) renderer = one;
  add_setting(line.group(OptionGroup::kEngine), "renderer", renderer)
      .default_text("what the environment variable SIGHTLINE_RENDERER names, or auto")
      .advanced();
}

void note_rays(engine::Engine& engine) {
  if (engine.config().drawing.renderer == engine::Renderer::kAutomatic && engine.renderer().starts_with("rays"))
    std::fprintf(stderr, "note: there is no OpenGL, so rays draw; --explain says why\n");
}

void add_context_option([[maybe_unused]] CommandLine& line, [[maybe_unused]] gl::ContextPlatform& platform) {
#if SIGHTLINE_HAS_GL
  add_setting(line.group(OptionGroup::kGeneral), "context_platform", platform).advanced();
  const auto switches = std::make_shared<std::vector<std::string>>();
  line.group(OptionGroup::kGeneral)
      .add("--gl-workaround", *switches,
           "Force a workaround for faults of GL drivers on or off: NAME=on or NAME=off; sightline-info --gl lists them")
      .one_value_each()
      .advanced();
  line.check([switches]() -> core::Expected<void> {
    std::string all;
    for (const std::string& one : *switches) all += (all.empty() ? "" : ",") + one;
    if (auto parsed = gl::WorkaroundSwitches::parse(all); !parsed) return tl::unexpected(parsed.error());
    if (switches->empty()) return {};
    const std::string before = core::platform::environment("SIGHTLINE_GL_WORKAROUNDS").value_or("");
    const std::string both = before.empty() ? all : before + "," + all;
    core::platform::set_environment("SIGHTLINE_GL_WORKAROUNDS",
                                    both);  // for every context, of processes that are started, too
    return {};
  });
#endif
}

void add_samples_option(CommandLine& line, int& samples) {
  add_setting(line, "samples", samples).in_range(1, 32);
}

void DrawnOptions::apply(engine::EngineConfig& config) const {
  config.culling.sample_test = sample_test;
  config.culling.occlusion = occlusion;
  config.losses.min_projected_area = min_projected_area;
  config.losses.budget_ms = budget_ms;
  config.losses.lod_error = lod_error;
  config.losses.contribution_mode = contribution_mode;
  config.drawing.looks = all_looks();
}

engine::Looks DrawnOptions::all_looks() const {
  engine::Looks all = plain ? engine::Looks() : looks;
  all.edges = looks.edges;
  all.edges.which = edges.value_or(engine::EdgeChoice::kOff);
  if (depth_shading) all.depth_shading.strength = float(*depth_shading);
  if (edge_lines) all.depth_shading.edge_lines = float(*edge_lines);
  if (hatching) all.hatching.strength = float(*hatching);
  if (background && !background->transparent) all.background = background->colours;
  if (sun) {
    all.lighting = gpuprims::Lighting::kSun;
    all.sun = *sun;
  }
  return all;
}

engine::Looks DrawnOptions::looks_of(const core::Scene& scene) const {
  engine::Looks all = all_looks();
  for (std::size_t i = 0; !edges && !plain && !all.edges.any() && i < scene.mesh_slots(); ++i)
    if (const core::MeshId mesh = scene.mesh_at(i);
        scene.contains(mesh) && !core::surfaces_stored_with(scene.mesh(mesh)).empty())
      all.edges.which = engine::EdgeChoice::kFeature;
  return all;
}

namespace {

/// One of the looks, which is that of the tool unless it is given.
Option add_look(CommandLine line, const std::string& name, std::optional<double>& value, double otherwise) {
  const SettingWords& words = words_of_setting(name);
  return line.add(words.option, value, words.help)
      .default_text(fmt::format("{:g}", otherwise))
      .in_range(words.low, words.high)
      .accepted_by(parse_finite);
}

}  // namespace

void add_drawn_options(CommandLine& line, DrawnOptions& options) {
  const CommandLine engine = line.group(OptionGroup::kEngine);
  add_setting(engine, "sample_test", options.sample_test).advanced();
  add_setting(engine, "occlusion", options.occlusion).advanced();
  add_setting(line, "min_projected_area", options.min_projected_area).advanced();
  add_setting(line.group(OptionGroup::kPaged), "budget_ms", options.budget_ms).advanced();
  add_setting(line.group(OptionGroup::kPaged), "lod_error", options.lod_error).advanced();
  add_setting(line, "contribution_mode", options.contribution_mode).advanced();
  engine::Looks& looks = options.looks;
  add_look(line, "depth_shading", options.depth_shading, looks.depth_shading.strength);
  add_look(line, "edge_lines", options.edge_lines, looks.depth_shading.edge_lines).advanced();
  add_setting(engine, "edges", options.edges).metavar("WHICH");
  add_setting(engine, "edge_width", looks.edges.width).advanced();
  add_look(engine, "hatching", options.hatching, looks.hatching.strength).advanced();
  line.add_parsed("--sun", options.sun, parse_direction, "One light from the direction X,Y,Z, far away")
      .metavar("X,Y,Z")
      .advanced();
}

namespace {

core::Expected<core::vec3> parse_colour(std::string_view text) {
  if (text == "white") return core::vec3(1.0f);
  if (text == "black") return core::vec3(0.0f);
  if (text.starts_with('#')) text.remove_prefix(1);
  std::uint32_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.size() != 6 || read.ec != std::errc() || read.ptr != text.data() + text.size())
    return core::fail("expected a colour as RRGGBB in hexadecimal, white or black, found " + std::string(text));
  return core::vec3(value >> 16, value >> 8 & 255u, value & 255u) / 255.0f;
}

}  // namespace

core::Expected<DrawnOptions::Background> DrawnOptions::parse_background(const std::string& text) {
  if (text == "transparent") return DrawnOptions::Background{true, {}};
  const std::size_t comma = text.find(',');
  const auto top = parse_colour(std::string_view(text).substr(0, comma));
  const auto bottom = comma == std::string::npos ? top : parse_colour(std::string_view(text).substr(comma + 1));
  if (!top || !bottom) return tl::unexpected((top ? bottom : top).error());
  return DrawnOptions::Background{false, {*bottom, *top}};
}

void add_background_option(CommandLine line, DrawnOptions& options) {
  line.add_parsed("--background", options.background, DrawnOptions::parse_background,
                  "What is behind everything: transparent (PNG), a colour such as FFFFFF or white, or two, TOP,BOTTOM")
      .metavar("COLOUR")
      .advanced();
}

void add_plain_option(CommandLine& line, DrawnOptions& options) {
  line.group(OptionGroup::kGeneral)
      .add_flag("--plain", options.plain,
                "One sample a pixel, light from the eye, one background, no shading by depth, no lines: for tests")
      .advanced();
}

void explain(const engine::Plan& plan) {
  for (const engine::PlanEntry& e : plan.entries)
    std::fprintf(stderr, "%-9s %-36s %s\n", e.used ? "used" : "left out", e.feature.c_str(), e.why.c_str());
}

void explain(const core::Scene& scene) {
  explain(engine::make_plan(core::Snapshot(scene), engine::CullerChoice::kAutomatic, true, false));
}

}  // namespace sightline::apps
