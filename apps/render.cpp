// sightline-render: one image of a model, and a comparison that makes it a regression test.

#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/blank.h"
#include "sightline/apps/common/colour_file.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/finer_meshes.h"
#include "sightline/apps/common/legend.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/paged_model.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/style_options.h"
#include "sightline/apps/common/tiled_image.h"
#include "sightline/apps/common/view_options.h"
#include "sightline/apps/mpi/session.h"
#if SIGHTLINE_HAS_MPI
#include "sightline/apps/mpi/composer.h"
#endif
#include "sightline/core/internal/platform/memory.h"
#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/view_json.h"
#include "sightline/render/image/image_metrics.h"

namespace {

using namespace sightline;
using apps::need, apps::fail;
using apps::OptionGroup;
using Json = json::Value;

constexpr int kLargestWhole = 4096;  // pixels

struct Options {
  apps::ModelOptions model;
  apps::ViewOptions view;
  std::string memory;
  std::string out, ids, ids_json, depth, reference, reference_ids, reference_depth, diff, json_file, frames_folder;
  double fps = 25.0;
  int tile = 0;

  bool transparent() const { return shown.background && shown.background->transparent; }
  bool wants_ids() const { return !ids.empty() || !ids_json.empty() || !reference_ids.empty(); }
  bool wants_depth() const { return !depth.empty() || !reference_depth.empty(); }
  std::vector<core::dvec2> shifts() const { return apps::sample_shifts(int(samples.value_or(shown.plain ? 1 : 4))); }
  int tile_side(const std::array<int, 2>& size) const {
    if (tile > 0) return tile;
    return std::max(size[0], size[1]) > kLargestWhole ? apps::kTileSide : kLargestWhole;
  }
  engine::CullerChoice culler = engine::CullerChoice::kAutomatic;
  std::optional<culling::GpuVariant> gpu_variant;
  std::optional<std::uint64_t> samples;
  apps::DrawnOptions shown{.looks = engine::Looks::standard()};
  apps::StyleOptions styles;
  struct {
    engine::Renderer renderer = {};
    gl::ContextPlatform platform = {};
    bool gl_debug = false;
  } means;
  bool mpi = false;
  struct {
    double max = -1.0, mean = -1.0;  // of 0 to 255; negative: not stated
  } allowed;
  double pixels_per_degree = image::kPixelsPerDegree;
};

void add_output_options(apps::CommandLine& line, Options& o) {
  apps::CommandLine general = line.group(OptionGroup::kGeneral);
  general.add("--out", o.out, "Colour image, PNG or JPEG").metavar("FILE").accepted_by(apps::parse_image_name);
  general.add("--ids", o.ids, "Item-id image, PNG: item + 1 in 24 bits, R lowest, 0 background")
      .metavar("FILE")
      .accepted_by(apps::parse_png_name);
  line.group(OptionGroup::kEngine)
      .add("--ids-json", o.ids_json, "Node path and kind of each item in the id image, JSON")
      .advanced();
  general.add("--depth", o.depth, "Depth image, PFM: metres along the view axis")
      .metavar("FILE")
      .accepted_by(apps::parse_pfm_name);
}

void add_comparison_options(apps::CommandLine& line, Options& o) {
  apps::CommandLine general = line.group(OptionGroup::kGeneral);
  const apps::Option compare =
      general.add("--compare", o.reference, "Reference PNG; exit 1 when the image differs by more than:")
          .metavar("FILE");
  general.add("--max", o.allowed.max, "… this in any channel, 0 to 255 (default 0, or any with --mean)")
      .needs(compare)
      .in_range(0.0, 255.0)
      .accepted_by(apps::parse_finite);
  general.add("--mean", o.allowed.mean, "… this in the mean, 0 to 255 (default 0, or any with --max)")
      .needs(compare)
      .in_range(0.0, 255.0)
      .accepted_by(apps::parse_finite);
  general.add("--pixels-per-degree", o.pixels_per_degree, "Of the visual field, for FLIP")
      .needs(compare)
      .shows_default()
      .in_range(1.0, 1000.0)
      .advanced();
  const apps::Option compare_ids =
      general
          .add("--compare-ids", o.reference_ids,
               "Reference of --ids, PNG: counts the pixels that show another item, and those of them that lie at no "
               "silhouette of the reference")
          .advanced();
  line.add("--compare-depth", o.reference_depth,
           "Reference of --depth, PFM: counts the pixels beyond the bounds that docs/reference/accuracy.md sets, at no "
           "silhouette")
      .needs(compare_ids)
      .advanced();
  general.add("--diff", o.diff, "Image of the difference, PNG, four times amplified")
      .needs(compare)
      .accepted_by(apps::parse_png_name)
      .advanced();
}

void add_frames_options(apps::CommandLine& line, Options& o) {
  const apps::Option frames = line.add("--write-frames", o.frames_folder,
                                       "Write the whole --path as numbered images to this folder, which must be empty")
                                  .needs("--path")
                                  .advanced();
  frames.excludes(
      {"--out", "--ids", "--ids-json", "--depth", "--compare", "--compare-ids", "--compare-depth", "--frame"});
  line.add("--fps", o.fps, "Frames of --write-frames per second of the path")
      .needs(frames)
      .shows_default()
      .in_range(1e-3, apps::PathFrames::kMostPerSecond)
      .accepted_by(apps::parse_finite)
      .advanced();
}

void add_engine_options(apps::CommandLine& line, Options& o) {
  line.group(OptionGroup::kEngine)
      .add("--tile", o.tile,
           "Draw in tiles of at most so many pixels a side, for GPUs with little memory; without it images of "
           "more than 4096 are drawn in tiles of 1024")
      .in_range(2 * engine::kLeastTileSide, 16384)
      .advanced();
  apps::add_culler_option(line, o.culler);
  apps::add_gpu_variant_option(line, o.gpu_variant);
  apps::add_drawn_options(line, o.shown);
  apps::add_style_options(line, o.styles);
  apps::add_plain_option(line, o.shown);
  apps::add_background_option(line.group(OptionGroup::kPaged), o.shown);
  line.group(OptionGroup::kEngine)
      .add("--samples", o.samples,
           "Samples of each pixel, for smooth edges: so many images; ids and depth are those of pixel centres")
      .default_text("4")
      .in_range(1, 64);
  apps::add_renderer_option(line, o.means.renderer);
  apps::add_context_option(line, o.means.platform);
}

core::Expected<void> check_outputs(const Options& o) {
  if (o.model.explain) return {};
  return apps::expect_output(
      {&o.out, &o.ids, &o.ids_json, &o.depth, &o.reference, &o.reference_ids, &o.json_file, &o.frames_folder});
}

void add_options(apps::CommandLine& line, Options& o) {
  apps::CommandLine general = line.group(OptionGroup::kGeneral);
  o.model.import.crease_angle = apps::kCreaseAngle;
  apps::add_model_options(line, o.model);
  apps::add_view_options(line, o.view);
  add_output_options(line, o);
  add_comparison_options(line, o);
  add_frames_options(line, o);
  add_engine_options(line, o);
  general.add_flag("--gl-debug", o.means.gl_debug, "Fail on any message of the GL driver").advanced();
  general.add("--json", o.json_file, "Write figures as JSON to FILE, or - for stdout").metavar("FILE");
  const apps::Option mpi =
      line.add_flag("--mpi", o.mpi,
                    "Under mpirun: each process draws a part of the model, and rank 0 writes the image of all")
          .advanced();
  line.mode(mpi, {OptionGroup::kGeneral, OptionGroup::kImport, OptionGroup::kEngine});
  apps::add_memory_option(line, o.memory);
  line.check([&o] { return check_outputs(o); });
  line.check([&o]() -> core::Expected<void> {
    if (o.memory.empty() || o.shown.budget_ms == 0.0) return {};
    return core::fail("--budget-ms: with --memory an image is always complete");
  });
  line.check([&o]() -> core::Expected<void> {
    if (!o.transparent() || (!o.mpi && o.memory.empty() && o.reference.empty())) return {};
    return core::fail("--background transparent: not with --mpi, --memory or --compare");
  });
}

core::Expected<void> write_id_names(const std::string& file, const std::set<std::uint32_t>& seen,
                                    const core::Scene& scene) {
  Json out = Json::object();
  for (const std::uint32_t id : seen) {
    if (id == 0) continue;
    const core::ItemId item{id - 1};
    out[std::to_string(to_index(item))] = {{"node", scene.path(scene.node_of(item))},
                                           {"kind", std::string(core::name_of(scene.kind(item)))}};
  }
  return apps::write_text(file, apps::to_text(json::sorted(std::move(out))));
}

/// Adds measures of how visible the difference is. Images that are too small have none.
void add_metrics(const Options& o, const image::Image& reference, const image::Image& image, Json& results) {
  const auto metrics = image::image_metrics(reference, image, o.pixels_per_degree);
  if (!metrics) return;
  results["psnr"] = metrics->psnr;
  results["ssim"] = metrics->ssim;
  results["flip"] = {{"mean", metrics->flip_mean}, {"p99", metrics->flip_p99}};
  std::fprintf(apps::table_stream(o.json_file), "PSNR %.2f dB  SSIM %.5f  FLIP mean %.5f, p99 %.4f\n", metrics->psnr,
               metrics->ssim, metrics->flip_mean, metrics->flip_p99);
}

bool compare(const Options& o, const image::Image& image, Json& results) {
  auto reference = need(image::read_png(o.reference));
  auto difference = image::compare(image, reference);
  if (!difference) fail(o.reference + ": " + difference.error().message);
  if (!o.diff.empty()) need(image::write_png(image::difference_image(image, reference), o.diff));
  const bool only_mean = o.allowed.max < 0.0 && o.allowed.mean >= 0.0,
             only_max = o.allowed.mean < 0.0 && o.allowed.max >= 0.0;
  const bool same = (only_mean || difference->max <= std::max(0.0, o.allowed.max)) &&
                    (only_max || difference->mean <= std::max(0.0, o.allowed.mean));
  results["compare"] = {
      {"max", difference->max}, {"mean", difference->mean}, {"pixels", difference->pixels}, {"ok", same}};
  add_metrics(o, reference, image, results["compare"]);
  std::fprintf(apps::table_stream(o.json_file), "max %d  mean %.4f  differing pixels %llu  %s\n", difference->max,
               difference->mean, (unsigned long long)difference->pixels, same ? "ok" : "DIFFERS");
  return same;
}

void compare_ids(const Options& o, const image::IdImage& ids, Json& results) {
  auto reference = need(image::read_png(o.reference_ids));
  const auto wrong = image::id_difference(image::ids_of_colours(reference), ids);
  if (!wrong) fail(o.reference_ids + ": " + wrong.error().message);
  const std::uint64_t all = wrong->silhouettes + wrong->elsewhere;
  results["wrong_ids"] = all;
  results["wrong_ids_elsewhere"] = wrong->elsewhere;
  std::fprintf(apps::table_stream(o.json_file), "pixels of another item %llu, at no silhouette %llu\n",
               (unsigned long long)all, (unsigned long long)wrong->elsewhere);
}

/// Half the diagonal of an item's box: it stands for the radius of all kinds of items.
double item_radius(const core::Scene& scene, core::ItemId item) {
  const core::AabbD box = scene.bounds_under(item, scene.world_from_node(scene.node_of(item)) * scene.placement(item));
  return box.empty() ? 0.0 : 0.5 * glm::length(box.max - box.min);
}

/// The depths of two renderers may differ by twice what the stability suite allows each of them in whole images: 1e-4
/// radii and two units in the last place of the distance.
void compare_depth(const Options& o, const image::ItemDepths& drawn, const core::Scene& scene, Json& results) {
  const auto colours = need(image::read_png(o.reference_ids));
  auto depth = need(image::read_pfm(o.reference_depth));
  const image::ItemDepths reference{image::ids_of_colours(colours), std::move(depth)};
  std::map<std::uint32_t, double> radii;  // boxes of meshes take long
  const auto bound = [&](std::uint32_t id, double metres) {
    const auto [radius, added] = radii.try_emplace(id, 0.0);
    if (added && scene.contains_item(core::ItemId{id - 1})) radius->second = item_radius(scene, core::ItemId{id - 1});
    return 2.0 * (1e-4 * radius->second + 0x1p-22 * metres);
  };
  const auto difference = image::depth_difference(reference, drawn, bound);
  if (!difference) fail(o.reference_depth + ": " + difference.error().message);
  results["compare_depth"] = {{"pixels", difference->pixels},
                              {"beyond", difference->beyond},
                              {"max", difference->max},
                              {"worst", difference->worst},
                              {"ties", difference->ties}};
  std::fprintf(apps::table_stream(o.json_file),
               "depth: %llu pixels, largest difference %.3g m, %.3g of its bound at most, beyond it %llu, ties %llu\n",
               (unsigned long long)difference->pixels, difference->max, difference->worst,
               (unsigned long long)difference->beyond, (unsigned long long)difference->ties);
}

/// Takes the rows of an image: writes them to files, and keeps in memory those that comparisons need whole.
class Outputs {
 public:
  static Outputs open(const Options& o, const std::array<int, 2>& size) {
    Outputs made(o, size);
    if (!o.out.empty()) made.colours_ = need(apps::ColourFile::create(o.out, size[0], size[1], o.transparent()));
    if (!o.ids.empty()) made.ids_ = need(image::PngWriter::create(o.ids, size[0], size[1]));
    return made;
  }

  core::Expected<void> add(const apps::ImageRows& rows) {
    const auto append = [](const auto& part, auto& all) { all.insert(all.end(), part.begin(), part.end()); };
    if (!o_->reference.empty()) append(rows.colours, image.pixels);
    if (!o_->reference_ids.empty()) append(rows.ids, drawn.ids.ids);
    append(rows.metres, drawn.depth.metres);
    if (!o_->ids_json.empty()) seen_.insert(rows.ids.begin(), rows.ids.end());
    if (colours_)
      if (auto done = colours_->write_rows(rows.colours); !done) return done;
    if (!ids_) return {};
    const auto colours = image::id_colours({rows.width, rows.count, rows.ids});
    return colours ? ids_->write_rows(colours->pixels) : tl::unexpected(colours.error());
  }

  core::Expected<void> finish(const core::Scene& scene) {
    core::Expected<void> done;
    if (colours_) done = colours_->finish();
    if (done && !o_->depth.empty()) done = image::write_pfm(drawn.depth, o_->depth);
    if (done && ids_) done = ids_->finish();
    if (done && !o_->ids_json.empty()) done = write_id_names(o_->ids_json, seen_, scene);
    return done;
  }

  image::Image image;       // of --compare
  image::ItemDepths drawn;  // ids of --compare-ids; depth of --depth and --compare-depth

 private:
  Outputs(const Options& o, const std::array<int, 2>& size)
      : image{size[0], size[1], {}}, drawn{{size[0], size[1], {}}, {size[0], size[1], {}}}, o_(&o) {}

  const Options* o_;
  std::optional<apps::ColourFile> colours_;
  std::optional<image::PngWriter> ids_;
  std::set<std::uint32_t> seen_;
};

/// Draws to the end even where rows cannot be written: other processes may wait for the parts of this one.
core::Expected<void> draw(engine::Engine& engine, apps::TiledImage& image, Outputs& outputs,
                          const std::function<void()>& after_step) {
  core::Expected<void> written;
  while (!image.complete()) {
    const auto more = image.step(engine);
    if (!more) return tl::unexpected(more.error());
    if (*more && written) written = outputs.add(image.rows());
    after_step();
  }
  for (const std::string& error : engine.take_gl_errors()) return core::fail("GL: " + error);
  return written;
}

void warn_if_blank(const apps::TiledImage& image, const std::string& name) {
  if (image.covered()) return;
  if (image.found() && !image.in_one_tile())
    apps::warn_of_blank({}, name);
  else
    apps::warn_of_blank(image.found() ? image.report().visible : 0, name);
}

/// The model and the engine that draws images of it.
struct Studio {
  apps::Model model;
  std::optional<engine::Engine> engine;
  std::array<int, 2> size{};
  engine::ImageTiles tiles;
  query::Colouring colours;
};

/// An image that is about to be drawn.
struct Begun {
  core::View view;
  Outputs outputs;
};

Begun begin_image(const Options& o, const Studio& studio) {
  // A part of a model is fitted as the whole is.
  std::optional<core::Snapshot> whole;
  if (o.mpi) whole.emplace(*studio.model.scene);
  auto view = need(apps::choose_view(o.view, studio.model, whole ? *whole : studio.engine->snapshot(),
                                     double(studio.size[0]) / studio.size[1]));
  return Begun{view, Outputs::open(o, studio.size)};
}

Json results_of(Studio& studio) {
  Json results = {{"renderer", studio.engine->renderer()},
                  {"size", studio.size},
                  {"tiles", studio.tiles.tiles.size()},
                  {"items", studio.engine->snapshot().size()},
                  {"culler", name_of(studio.engine->plan().culler)}};
  if (!studio.colours.groups.empty()) results["colours"] = apps::legend_json(studio.colours);
  return results;
}

/// Writes and compares what was drawn.
core::Expected<int> finish_image(const Options& o, const core::Scene& scene, Outputs& outputs, Json results) {
  need(outputs.finish(scene));
  if (!o.reference_ids.empty()) compare_ids(o, outputs.drawn.ids, results);
  if (!o.reference_depth.empty()) compare_depth(o, outputs.drawn, scene, results);
  const bool same = o.reference.empty() || compare(o, outputs.image, results);
  need(apps::write_json(o.json_file, json::sorted(results)));
  return same ? apps::kExitOk : apps::kExitFailure;
}

core::Expected<void> draw_with_bar(Studio& studio, apps::TiledImage& image, Outputs& outputs) {
  apps::Progress progress("drawing", image.steps());
  return draw(*studio.engine, image, outputs, [&] { progress.advance(image.steps_done()); });
}

/// Exact surfaces get finer meshes where the image would show their facets.
void refine_meshes(Studio& studio, const core::View& view) {
  apps::FinerMeshes finer;
  finer.begin(studio.engine->snapshot(), view, studio.size[0], studio.size[1]);
  if (!finer.finish(*studio.model.scene)) return;
  need(studio.engine->commit());
  need(studio.engine->finish_levels());
}

core::Expected<int> render_image(const Options& o, Studio& studio) {
  auto begun = begin_image(o, studio);
  if (!o.shown.plain && !o.mpi) refine_meshes(studio, begun.view);
  const bool complete = studio.tiles.tiles.size() > 1;  // a budget shows in an image that is drawn at once
  apps::TiledImage image(begun.view, studio.tiles,
                         {.ids = o.wants_ids(),
                          .depth = o.wants_depth(),
                          .transparent = o.transparent(),
                          .complete = complete,
                          .shifts = o.shifts()});
  need(draw_with_bar(studio, image, begun.outputs));
  warn_if_blank(image, "the image");
  Json results = results_of(studio);
  const engine::FrameReport& report = image.report();
  if (studio.tiles.tiles.size() == 1)
    results.update({{"visible", report.visible},
                    {"sampled", report.sampled},
                    {"items_drawn", report.items_drawn},
                    {"triangles", report.triangles},
                    {"below_min_area", report.below_min_area},
                    {"pending", report.pending},
                    {"splats", report.splats},
                    {"tested", report.tested}});
  return finish_image(o, *studio.model.scene, begun.outputs, std::move(results));
}

core::Expected<int> render_frames(const Options& o, Studio& studio) {
  const apps::Model& model = studio.model;
  engine::Engine& engine = *studio.engine;
  const auto& [width, height] = studio.size;
  const auto path = need(importers::translated(need(importers::read_path(o.view.path)), model.offset));
  const auto frames = need(apps::PathFrames::create(path, o.fps));
  need(apps::take_empty_folder(o.frames_folder));
  apps::Progress progress("writing frames", std::size_t(frames.count()));
  for (int frame = 0; frame < frames.count(); ++frame) {
    const auto view = need(apps::with_sections(need(path.view(frames.time(frame), double(width) / height)), o.view,
                                               model.offset, engine.snapshot().bounds()));
    Options file = o;
    file.out = (std::filesystem::path(o.frames_folder) / apps::PathFrames::file_name(frame)).string();
    auto outputs = Outputs::open(file, studio.size);
    apps::TiledImage image(view, studio.tiles, {.transparent = o.transparent(), .shifts = o.shifts()});
    need(draw(engine, image, outputs, [] {}));
    need(outputs.finish(*model.scene));
    warn_if_blank(image, apps::PathFrames::file_name(frame));
    progress.advance(std::size_t(frame) + 1);
  }
  const Json results = {{"renderer", engine.renderer()},
                        {"size", studio.size},
                        {"items", engine.snapshot().size()},
                        {"frames", frames.count()},
                        {"fps", o.fps}};
  need(apps::write_json(o.json_file, json::sorted(results)));
  return apps::kExitOk;
}

/// Rays make images sooner than a software rasteriser. Where what is asked for is about GL, or only GL has it, and for
/// plain images, which are those of engines, rays draw only where there is no GL.
engine::Renderer choose_renderer(const Options& o, const engine::EngineConfig& config) {
  using engine::CullerChoice;
  if (o.means.renderer != engine::Renderer::kAutomatic) return o.means.renderer;
  const bool culls_on_gpu = o.culler == CullerChoice::kGpu || o.culler == CullerChoice::kHybrid || o.gpu_variant;
  const bool about_gl = o.means.platform != gl::ContextPlatform{} || std::getenv("SIGHTLINE_CONTEXT") ||
                        std::getenv("SIGHTLINE_GL_WORKAROUNDS") || o.means.gl_debug;
  const bool loses = config.losses.min_projected_area > 0.0f || config.losses.budget_ms > 0.0;
  const bool only_gl =
      config.drawing.looks.hatching.any() || config.drawing.transparency == engine::Transparency::kBlended;
  const bool gl_first = o.mpi || o.shown.plain || culls_on_gpu || about_gl || loses || only_gl || gl::has_gpu();
  return gl_first ? engine::Renderer::kAutomatic : engine::Renderer::kRays;
}

Studio make_studio(const Options& o, const engine::ScenePart& part) {
  const auto size = need(apps::parse_size(o.view.size));
  engine::EngineConfig config;
  config.draw = true;
  o.shown.apply(config);
  config.drawing.transparency = o.styles.transparency;
  config.drawing.ids = o.wants_ids() || o.mpi;
  config.culling.part = part;
  config.context.platform = o.means.platform;
  config.context.gl_debug = o.means.gl_debug;
  config.context.gl_state = engine::GlState::kLeave;  // no other context is current here
  config.culling.culler = o.culler;
  config.culling.gpu_variant = o.gpu_variant;
  config.drawing.renderer = choose_renderer(o, config);
  auto tiles = need(apps::tiles_for(size, o.tile_side(size), config));
  config.width = tiles.width;
  config.height = tiles.height;
  auto model = need(apps::load_model(o.model, o.shown));
  config.drawing.looks = o.shown.looks_of(*model.scene);
  auto engine = need(engine::Engine::create(*model.scene, config));
  need(engine.finish_levels());
  apps::note_rays(engine);
  if (o.model.explain) apps::explain(engine.plan());
  auto colours = need(apps::apply_styles(o.styles, *model.scene, engine));
  std::fputs(apps::legend_text(colours).c_str(), apps::table_stream(o.json_file));
  return Studio{std::move(model), std::move(engine), size, std::move(tiles), std::move(colours)};
}

core::Expected<int> render_alone(const Options& o) {
  auto studio = make_studio(o, {});
  return (o.frames_folder.empty() ? render_image : render_frames)(o, studio);
}

apps::ImageRows rows_of(const Options& o, const engine::PagedEngine& engine) {
  image::Image colours = engine.read_colour();
  apps::ImageRows rows{colours.width, 0, colours.height, std::move(colours.pixels), {}, {}};
  if (o.wants_ids()) rows.ids = engine.read_ids().ids;
  if (!o.depth.empty()) rows.metres = engine.read_depth().metres;
  return rows;
}

engine::PagedReport settle(engine::PagedEngine& engine, const core::View& view) {
  apps::Progress progress("drawing", 1000);
  return need(engine.settle(view, [&](const engine::PagedReport& report) {
    progress.advance(std::size_t(1000 * (report.leaves - report.pending) / std::max<std::int64_t>(1, report.leaves)));
    return true;
  }));
}

struct PagedImage {
  Outputs outputs;
  apps::ImageRows rows;
  Json results;
};

/// The engine is gone when its image is written and compared: that takes memory, too.
PagedImage draw_paged(const Options& o) {
  const auto size = need(apps::parse_size(o.view.size));
  auto engine = need(apps::open_paged(o.model, o.memory,
                                      {.width = size[0],
                                       .height = size[1],
                                       .drawing = {.ids = o.wants_ids(), .looks = o.shown.all_looks()},
                                       .losses = {.lod_error = o.shown.lod_error},
                                       .context = {.platform = o.means.platform, .gl_debug = o.means.gl_debug}}));
  const auto view = need(apps::choose_view(o.view, core::dvec3(0.0), engine.scene().leaves, engine.scene().fitted,
                                           double(size[0]) / size[1]));
  auto outputs = Outputs::open(o, size);
  const auto report = settle(engine, view);
  if (report.items_drawn == 0) std::fprintf(stderr, "warning: the image shows nothing\n");
  need(apps::page_errors(engine));
  for (const std::string& error : engine.take_gl_errors()) fail("GL: " + error);
  Json results = {{"renderer", engine.renderer()},
                  {"size", size},
                  {"items", engine.scene().items},
                  {"pages", engine.scene().pages.size()},
                  {"leaves", report.leaves},
                  {"items_drawn", report.items_drawn},
                  {"frames", report.frame + 1},
                  {"loaded", report.loaded},
                  {"evicted", report.evicted},
                  {"memory",
                   {{"limit", *apps::parse_bytes(o.memory)},
                    {"pages", engine.memory().limit},
                    {"scene", engine.scene().memory_bytes()}}}};
  return PagedImage{std::move(outputs), rows_of(o, engine), std::move(results)};
}

core::Expected<int> render_paged(const Options& o) {
  auto drawn = draw_paged(o);
  need(drawn.outputs.add(drawn.rows));
  drawn.rows = {};
  drawn.results["memory"]["peak"] = core::platform::peak_memory();
  return finish_image(o, core::Scene(), drawn.outputs, std::move(drawn.results));
}

/// One of the processes that draw an image together. Rank 0 writes it.
core::Expected<int> render_parts([[maybe_unused]] Options o) {
  const auto session = apps::MpiSession::begin();
  if (!session) return tl::unexpected(session.error());
#if SIGHTLINE_HAS_MPI
  const bool root = session->rank() == 0;
  if (!root) {
    o.out = o.ids = o.ids_json = o.depth = o.reference = o.reference_ids = o.diff = o.json_file = "";
    o.model.quiet = o.view.quiet = o.styles.quiet = true;
    o.model.explain = false;
  }
  o.shown.edges = engine::EdgeChoice::kOff;
  o.shown.depth_shading = o.shown.edge_lines = 0.0;  // a process knows the depth of its own part alone
  apps::Composer composer(*session);
  auto studio = session->agreed(apps::attempt([&] { return make_studio(o, composer.part()); }));
  if (!studio) return tl::unexpected(studio.error());
  auto begun = session->agreed(apps::attempt([&] { return begin_image(o, *studio); }));
  if (!begun) return tl::unexpected(begun.error());
  const auto read = [&](auto&... drawn) { return composer.read(drawn...); };
  apps::TiledImage image(begun->view, studio->tiles,
                         {.ids = o.wants_ids(), .depth = !o.depth.empty(), .shifts = o.shifts(), .read = read});
  auto drawn =
      root ? draw_with_bar(*studio, image, begun->outputs) : draw(*studio->engine, image, begun->outputs, [] {});
  if (drawn = session->agreed(std::move(drawn)); !drawn) return tl::unexpected(drawn.error());
  Json results = results_of(*studio);
  const engine::Engine& engine = *studio->engine;
  const double own = double(engine.snapshot().size() - engine.snapshot().vacant_count());
  results.update({{"processes", session->size()},
                  {"drawing", composer.drawing()},
                  {"visible", composer.visible()},
                  {"part_items", composer.gather(own)},
                  {"part_gpu_bytes", composer.gather(double(engine.memory().gpu))}});
  if (!root) return apps::kExitOk;
  warn_if_blank(image, "the image");
  return finish_image(o, *studio->model.scene, begun->outputs, std::move(results));
#else
  return apps::kExitFailure;
#endif
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line("Renders one image of a model offscreen; with --compare a regression test", "sightline-render",
                         "  sightline-render plant.rvm --out plant.png\n"
                         "  sightline-render plant.rvm --from front --ortho --section 'y>12.5' --out front.png\n"
                         "  sightline-render plant.rvm --isolate PS-100 --size 1920x1080 --samples 4 --out part.png\n"
                         "  sightline-render plant.rvm --view view.json --compare reference.png --max 8 --mean 0.1");
  line.appendix(
      "\n  sightline-render plant.slc --memory 2G --out plant.png\n"
      "  sightline-render plant.rvm --size 16384x9216 --samples 4 --out poster.png\n"
      "  mpirun -np 4 sightline-render plant.rvm --mpi --out plant.png\n"
      "  sightline-render plant.rvm --path flight.json --write-frames frames --fps 25 --size 1920x1080\n");
  Options options;
  add_options(line, options);
  return line.run(argc, argv, [&] {
    return !options.memory.empty() ? render_paged(options)
           : options.mpi           ? render_parts(options)
                                   : render_alone(options);
  });
}
