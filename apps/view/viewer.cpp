#include "sightline/apps/view/viewer.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/blank.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/named_parts.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/view_options.h"
#include "sightline/apps/view/views.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/view_json.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

constexpr core::vec3 kCulledColour{0.85f, 0.1f, 0.55f};
constexpr engine::Hatching kHatching{0.6f, 6.0f};
constexpr double kMotionError = 0.5;                           // pixels
constexpr double kExportSlice = 0.05;                          // seconds between images of the window
constexpr double kIdleWait = 10.0, kLoadingWait = 0.05;        // seconds
constexpr double kContextPatience = 20.0, kContextWait = 0.5;  // seconds: for a driver that resets its GPU

}  // namespace

const char* name_of(Dialog dialog) {
  constexpr const char* kNames[] = {"none",       "help",          "driver",       "open",
                                    "compare",    "quit",          "image",        "path",
                                    "read-path",  "save-path",     "frames",       "views-load",
                                    "views-save", "save-and-quit", "export-model", "export-selection"};
  return kNames[int(dialog)];
}

const char* name_of(Tool tool) {
  constexpr const char* kNames[] = {"select", "measure", "section"};
  return kNames[int(tool)];
}

std::string free_name(const std::string& stem, const std::string& extension) {
  for (int i = 1;; ++i)
    if (std::string name = stem + "-" + std::to_string(i) + extension; !std::filesystem::exists(name)) return name;
}

Viewer::Viewer(const ViewerOptions& options, Window& window, Gui gui, SettingsFile settings)
    : options_(options),
      window_(window),
      gui_(std::move(gui)),
      file_states_(&glfwGetTime),
      settings_(std::move(settings)) {
  shown.panels = options.panels && options.frames == 0;
  shown.smooth = options.smooth && (options.script.empty() || !options.settings.empty());
  now_ = settings_.settings();
  shown.triad = now_.triad;
  shown.lower = now_.lower;
  shown.tree_width = now_.tree_width;
  shown.side_width = now_.side_width;
  looks_ = options.shown.all_looks();
  const bool asked = options.shown.depth_shading || options.shown.edge_lines || !options.remembers();
  shown.depth_shading = looks_.depth_shading.any() && (now_.depth_shading || asked);
  if (!looks_.depth_shading.any()) looks_.depth_shading = engine::Looks::standard().depth_shading;
  shown.hatching = looks_.hatching.any() || (now_.hatching && options.remembers());
  if (!looks_.hatching.any()) looks_.hatching = kHatching;
  looks_.hatching.spacing = float(kHatching.spacing * std::max(1.0, gui_.scale()));
  shown.levels = options.shown.lod_error > 0.0 || (now_.levels && options.remembers());
  if (options.shown.lod_error == 0.0) options_.shown.lod_error = kMotionError;
  shown.recognise = options.model.import.recognise;
  shown.diagnostics = now_.diagnostics;
  for (const Units units : {Units::kMillimetres, Units::kMetres, Units::kFeet})
    if (now_.units == kUnitsNames[int(units)]) shown.units = units;
  take_settings();
  settings_.begin(now_);
  if (options.remembers()) thumbnails_ = Thumbnails(Thumbnails::default_place());
  if (!options.model.files.empty()) open(options.model.files);
}

// --- the loop --------------------------------------------------------------------------------------------------------

core::Expected<int> Viewer::run() {
  if (auto done = read_path(); !done) return tl::unexpected(done.error());
  if (!options_.script.empty()) {
    auto script = read_script(options_.script);
    if (!script) return tl::unexpected(script.error());
    script_ = std::move(*script);
  }
  if (!settings_.damage().empty()) std::fprintf(stderr, "sightline-view: %s\n", settings_.damage().c_str());
  if (!settings_.damage().empty() && !loader_) tell(settings_.damage(), true);
  double last = glfwGetTime(), looked = 0.0;
  while (!closing() && (options_.frames == 0 || frames_ < options_.frames)) {
    const bool busy = !settled() || player_.playing() || next_step_ < script_.size();
    if (!busy) keep_settings();
    if (thumbnail_due_ && settled()) keep_thumbnail();
    if (release_ && glfwGetTime() >= wait_until_) gui_.push({*std::exchange(release_, std::nullopt)});
    if (script_ended()) {
      quit();
      continue;
    }
    if (looked > 0.0) pause_ms_ = std::max(pause_ms_, 1e3 * (glfwGetTime() - looked));
    gui_.push(window_.poll(patience()));
    looked = glfwGetTime();
    if (closing()) break;
    if (lost()) {
      if (auto done = recover(); !done) return tl::unexpected(done.error());
      continue;
    }
    if (!busy && !gui_.has_events()) continue;  // nothing to draw
    if (auto done = land_model_export(); !done) return tl::unexpected(done.error());
    if (auto done = land(); !done) return tl::unexpected(done.error());
    if (swapping_in_ && !gui_.has_events() && glfwGetTime() < next_frame_) continue;
    if (auto done = step_export(); !done && !lost()) return tl::unexpected(done.error());
    if (settled() && next_step_ < script_.size())
      if (auto done = step_script(); !done) return tl::unexpected(done.error());
    if (gui_.has_events() && asked_at_ < 0.0) asked_at_ = glfwGetTime();
    if (settled_but_for_edges() && refining()) {
      if (auto done = session_->refine(); !done && !lost()) return tl::unexpected(done.error());
      redraws_ = session_->refining() ? 0 : 1;
      if (redraws_ == 0) continue;
    }
    const double now = glfwGetTime();
    if (auto done = frame(now - std::exchange(last, now)); !done && !lost()) return tl::unexpected(done.error());
  }
  keep_settings();
  if (auto done = finish(); !done) return tl::unexpected(done.error());
  return kExitOk;
}

/// Seconds to wait for events before the loop goes on without.
double Viewer::patience() const {
  if (swapping_in_ || (preview_ && preview_->drawing())) return 0.0;
  if (loader_ || model_export_) return std::max(kLoadingWait, kBetweenFrames * frame_seconds_);
  if (!at_rest() || refining() || player_.playing() || next_step_ < script_.size()) return 0.0;
  return waits_for_picks() ? kLoadingWait : kIdleWait;
}

bool Viewer::script_ended() const {
  return !script_.empty() && next_step_ == script_.size() && !export_ && !model_export_ && window_shot_.empty() &&
         glfwGetTime() >= wait_until_;
}

/// Whether the window is to be closed. Asks once, where views would be lost that no file has.
bool Viewer::closing() {
  if (!window_.closing()) return false;
  if (shown.dialog == Dialog::kQuit || !options_.script.empty() || options_.frames > 0 || views_.unsaved() == 0)
    return true;
  window_.keep_open();
  shown.dialog = Dialog::kQuit;
  redraws_ = kSettlingFrames;
  return false;
}

/// Makes the window and all that lay in its context anew. Model, camera, sections and selection stay.
core::Expected<void> Viewer::recover() {
  export_.reset();
  textures_.clear();
  gui_.drop_context();
  auto opened = window_.reopen();
  for (const double end = glfwGetTime() + kContextPatience; !opened && glfwGetTime() < end && !window_.closing();) {
    window_.poll(kContextWait);
    opened = window_.reopen();
  }
  if (opened) opened = gui_.use_context();
  if (opened && session_) opened = session_->use_context(window_.context());
  if (!opened) return core::fail("the graphics driver has lost the window's context: " + opened.error().message);
  context_lost_ = false;
  ++recovered_;
  held_.clear();  // their releases went to the former window
  drag_.reset();
  section_handles_.forget();
  tell("the lost graphics context was made anew");
  return {};
}

/// The pointer has moved or clicked, and what is below it is not known yet.
bool Viewer::waits_for_picks() const {
  return session_ && (cursor_moved_ || click_) && !drag_ && session_->engine().preparing_picks();
}

/// Nothing will change by itself.
bool Viewer::settled() const {
  return settled_but_for_edges() && !refining();
}

bool Viewer::refining() const {
  return shown.smooth && options_.frames == 0 && !player_.playing() && !export_ && session_ && session_->refining();
}

bool Viewer::settled_but_for_edges() const {
  return at_rest() && !waits_for_picks();
}

bool Viewer::at_rest() const {
  const bool flies = std::any_of(held_.begin(), held_.end(), [](int key) {
    return key == GLFW_KEY_W || key == GLFW_KEY_A || key == GLFW_KEY_S || key == GLFW_KEY_D || key == GLFW_KEY_Q ||
           key == GLFW_KEY_E;
  });
  if (loader_ || model_export_ || redraws_ > 0 || gui_.has_events() || export_ ||
      (player_.playing() && !player_.loop) || flies || (walker_ && walker_->falling()) || !window_shot_.empty())
    return false;
  if (options_.frames > 0 || glfwGetTime() < wait_until_) return false;
  if (session_ && session_->lowered() && !player_.playing()) return false;
  return !session_ || !session_->stale();
}

/// The configuration of the images; their context and size come later.
engine::EngineConfig Viewer::image_config() const {
  engine::EngineConfig config;
  config.draw = true;
  config.culling.culler = options_.culler;
  config.culling.gpu_variant = options_.gpu_variant;
  config.drawing.samples = options_.samples;
  options_.shown.apply(config);
  config.drawing.looks = looks_;
  if (!shown.levels) config.losses.lod_error = 0.0;
  if (!shown.depth_shading) config.drawing.looks.depth_shading = {};
  if (!shown.hatching) config.drawing.looks.hatching = {};
  config.drawing.culled_colour = kCulledColour;
  config.context.later = true;
  return config;
}

// --- what moves by itself --------------------------------------------------------------------------------------------

void Viewer::play() {
  if (!session_ || export_) return;
  Camera& camera = session_->camera();
  const auto sample =
      options_.frames > 0 ? player_.next_frame(frames_, options_.frames) : player_.next(glfwGetTime(), camera.pose());
  if (!sample) return;
  camera.set_pose(sample->pose);
  camera.set_fovy(sample->fovy);
}

// --- what commands do ------------------------------------------------------------------------------------------------

void Viewer::begin_export(std::unique_ptr<Export> work) {
  export_ = std::move(work);
  export_cancelled_ = false;
  held_.clear();
  drag_.reset();
}

/// A failure ends scripts; otherwise it is told.
core::Expected<void> Viewer::step_export() {
  if (!export_) return {};
  core::Expected<void> done;
  for (const double end = glfwGetTime() + kExportSlice;
       done && !export_cancelled_ && !export_->complete() && glfwGetTime() < end;)
    done = export_->step();
  if (done && !export_cancelled_ && !export_->complete()) return {};
  const std::string frames = export_->count() > 1 ? std::to_string(export_->frame()) + " frames: " : "image: ";
  const std::string target = export_->target();
  const bool blank = export_->blank(), complete = export_->complete();
  export_.reset();
  if (!done && !script_.empty()) return done;
  if (!done)
    tell(done.error().message, true);
  else if (!complete)
    tell("cancelled, " + frames + target);
  else
    tell(frames + target + (blank ? " (no pixel shows any item)" : ""));
  return {};
}

void Viewer::begin_model_export(ModelExport::Job job) {
  tell("writing " + std::filesystem::path(job.file).filename().string());
  model_export_ = std::make_unique<ModelExport>(std::move(job), &Window::wake);
}

/// A failure ends scripts; otherwise it is told.
core::Expected<void> Viewer::land_model_export() {
  auto done = model_export_ ? model_export_->take() : std::nullopt;
  if (!done) return {};
  model_export_.reset();
  if (!*done && !script_.empty()) return tl::unexpected(done->error());
  tell(*done ? **done : done->error().message, !*done);
  return {};
}

core::Expected<void> Viewer::scene_is_free() const {
  if (loader_ && found_) return core::fail("wait until the older revision is read, or cancel that");
  if (model_export_) return core::fail("wait until the model is written, or cancel that");
  return {};
}

void Viewer::tell(std::string message, bool error) {
  message_ = std::move(message);
  message_is_error_ = error;
  message_is_new_ = true;
  redraws_ = kSettlingFrames;
}

void Viewer::tell_outcome(const core::Expected<void>& done) {
  if (!done)
    tell(done.error().message, true);
  else if (message_is_error_ && !message_is_new_)
    tell("");
}

core::Expected<void> Viewer::toggle_depth_shading() {
  shown.depth_shading = !shown.depth_shading;
  return apply_styles();
}

core::Expected<void> Viewer::toggle_hatching() {
  shown.hatching = !shown.hatching;
  return apply_styles();
}

core::Expected<void> Viewer::toggle_levels() {
  shown.levels = !shown.levels;
  return session_ ? session_->set_motion_error(shown.levels ? options_.shown.lod_error : 0.0) : core::Expected<void>();
}

core::Expected<void> Viewer::set_motion_error(double pixels) {
  if (!(pixels >= 0.0)) return core::fail("lod-error: expected 0 or more pixels");
  shown.levels = pixels > 0.0;
  if (shown.levels) options_.shown.lod_error = pixels;
  return session_ ? session_->set_motion_error(pixels) : core::Expected<void>();
}

core::Expected<void> Viewer::apply_styles() {
  redraws_ = kSettlingFrames;
  if (!session_) return {};
  return session_->configure([&](engine::EngineConfig& config) {
    config.drawing.looks.depth_shading = shown.depth_shading ? looks_.depth_shading : engine::DepthShading();
    config.drawing.looks.hatching = shown.hatching ? looks_.hatching : engine::Hatching();
  });
}

core::Expected<std::optional<engine::Pick>> Viewer::under(const core::dvec2& at) {
  if (!in_viewport(at)) return std::optional<engine::Pick>();
  return session_->pick(in_image(at));
}

std::vector<core::ItemId> Viewer::items_below(const std::vector<core::NodeId>& nodes) const {
  std::vector<core::ItemId> items;
  for (const core::NodeId node : nodes) {
    const std::vector<core::ItemId> below = session_->document().items_below(node);
    items.insert(items.end(), below.begin(), below.end());
  }
  core::sort_unique(items);
  return items;
}

core::Expected<void> Viewer::find(const std::string& text) {
  const auto found = session_->tree().find_named({text});
  if (!found) return tl::unexpected(found.error());
  tell(words_of_parts(session_->scene(), text, *found));
  return {};
}

core::Expected<void> Viewer::select_found() {
  ModelTree& tree = session_->tree();
  if (!tree.named()) {
    const NameQuery query = tree.query();
    const auto found = tree.find_named(query);
    if (!found) return tl::unexpected(found.error());
    tell(words_of_parts(session_->scene(), query.text, *found));
  }
  return session_->document().select(items_below(tree.matches()));
}

core::Expected<std::vector<core::ItemId>> Viewer::items_named(const std::string& text) {
  const auto found = session_->tree().nodes_named(text);
  if (!found) return tl::unexpected(found.error());
  if (found->nodes.size() > 1) tell(words_of_parts(session_->scene(), text, *found));
  std::vector<core::ItemId> items = items_below(found->nodes);
  if (items.empty()) return core::fail("there are no items below \"" + text + "\"");
  return items;
}

core::Expected<void> Viewer::toggle_part(const std::string& text) {
  Document& document = session_->document();
  const PartName part = part_of(text);
  const bool numbered = text.empty() || part.node != text;  // as views have it
  const auto items = numbered ? core::Expected<std::vector<core::ItemId>>(session_->items_of(part)) : items_named(text);
  if (!items) return tl::unexpected(items.error());
  if (items->empty()) return core::fail("the model has no items below \"" + text + "\"");
  const auto hidden = [&](core::ItemId item) { return document.is(item, Document::kHidden); };
  return std::all_of(items->begin(), items->end(), hidden) ? document.show(*items) : document.hide(*items);
}

core::Expected<void> Viewer::write_screenshot(const std::string& file) {
  const std::string name = file.empty() ? free_name("screenshot", ".png") : file;
  if (const auto good = parse_png_name(name); !good) return tl::unexpected(good.error());
  const auto view = session_->view();
  if (!view) return tl::unexpected(view.error());
  const core::ItemBounds& items = session_->engine().snapshot().bounds();
  if (auto kept = check_sections(*view, items, session_->offset()); !kept) return kept;
  const auto image = session_->image(shown.smooth);
  if (!image) return tl::unexpected(image.error());
  if (auto done = image::write_png(*image, name); !done) return done;
  warn_if_blank(session_->engine(), session_->visible(), name);
  tell("image: " + name);
  return {};
}

core::Expected<void> Viewer::save_view(const std::string& file) {
  const std::string name = file.empty() ? free_name("view", ".json") : file;
  auto done = write_text(name, format_viewpoint(session_->viewpoint()));
  if (done) tell("view: " + name);
  return done;
}

core::Expected<void> Viewer::load_view(const std::string& file) {
  const auto read = read_views(file);
  if (!read) return tl::unexpected(read.error());
  if (is_bcf(file) || read->views.size() != 1) return load_views(*this, file);
  const auto missing = session_->show(read->views.front());
  return missing ? core::Expected<void>() : tl::unexpected(missing.error());
}

core::Expected<void> Viewer::toggle_recording() {
  if (!recorder_) {
    recorder_.emplace();
    session_->changed();  // its first place
    return {};
  }
  const auto seen = recorder_->path(session_->camera().near(), session_->camera().far());
  recorder_.reset();
  const auto path = seen ? importers::translated(*seen, -session_->offset()) : seen;  // in the model's own frame
  if (!path) return tl::unexpected(path.error());
  player_.set_path(*seen);
  if (auto done = importers::write_path(options_.save_path, *path); !done) return done;
  tell("path: " + options_.save_path);
  return {};
}

/// RVM files are of plants, however small the part is.
LengthFormat Viewer::lengths() const {
  if (!session_) return length_format(shown.units, 1.0, false);
  const core::AabbD& bounds = session_->bounds().bounds;
  const core::dvec3 size = bounds.empty() ? core::dvec3(1.0) : bounds.size();
  const bool plant = std::any_of(files_.begin(), files_.end(), [](const std::string& file) {
    const std::string extension = std::filesystem::path(file).extension().string();
    return extension == ".rvm" || extension == ".RVM";
  });
  return length_format(shown.units, std::max({size.x, size.y, size.z}), plant);
}

void Viewer::take_settings() {
  now_.light = gui_.theme() == Theme::kLight;
  now_.smooth = shown.smooth;
  now_.panels = shown.panels;
  now_.triad = shown.triad;
  now_.depth_shading = shown.depth_shading;
  now_.hatching = shown.hatching;
  now_.lower = shown.lower;
  now_.levels = shown.levels;
  now_.recognise = shown.recognise;
  now_.diagnostics = shown.diagnostics;
  now_.units = kUnitsNames[int(shown.units)];
  now_.tree_width = shown.tree_width;
  now_.side_width = shown.side_width;
  now_.window = window_.screen_size();
}

void Viewer::keep_settings() {
  take_settings();
  const auto done = settings_.keep(now_);
  if (done) return;
  tell("settings are not kept: " + done.error().message, true);
  std::fprintf(stderr, "sightline-view: %s\n", message_.c_str());
}

/// Keeps the thumbnail of a model that is one file, with attributes or without: an image of several shows none of them.
/// Without a folder that takes files there are no thumbnails.
void Viewer::keep_thumbnail() {
  thumbnail_due_ = false;
  std::vector<std::string> models;
  std::copy_if(files_.begin(), files_.end(), std::back_inserter(models),
               [](const std::string& file) { return !importers::is_attribute_file(file); });
  if (models.size() != 1) return;
  const FileState now = state_of(models[0]);
  if (!thumbnails_.lacks(models[0], now)) return;
  if (const auto image = session_->image(shown.smooth)) (void)thumbnails_.keep(models[0], now, *image);
}

core::Expected<void> Viewer::finish() {
  export_.reset();
  model_export_.reset();
  if (!session_) return options_.frames > 0 ? core::fail("no model was drawn") : core::Expected<void>();
  session_->engine().finish();
  core::Expected<void> done;
  if (recorder_) done = toggle_recording();
  for (const std::string& error : session_->engine().take_gl_errors()) return core::fail("GL: " + error);
  if (done && !options_.screenshot.empty()) done = write_screenshot(options_.screenshot);
  if (done && !options_.json_file.empty()) done = write_text(options_.json_file, to_text(state()));
  return done;
}

}  // namespace sightline::apps
