#include "sightline/apps/view/viewer.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <nlohmann/json.hpp>

#include "sightline/apps/common/blank.h"
#include "sightline/apps/common/frame_words.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/view/commands.h"
#include "sightline/apps/view/comparing.h"
#include "sightline/apps/view/exporting.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/views.h"
#include "sightline/image/image.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps {
namespace {

using Json = nlohmann::ordered_json;
using Type = Event::Type;

constexpr core::vec3 kHiddenColour{0.85f, 0.1f, 0.55f};
constexpr core::vec3 kEmptyDark{0.11f, 0.12f, 0.13f}, kEmptyLight{0.86f, 0.88f, 0.9f};
constexpr engine::Relief kRelief{0.6f, 0.4f};
constexpr engine::Hatching kHatching{0.6f, 6.0f};
constexpr double kLongestStep = 0.25;                          // seconds: a hitch must not make the camera jump
constexpr int kSettlingFrames = 3;                             // after an event: widgets take some to come to rest
constexpr double kExportSlice = 0.05;                          // seconds between pictures of the window
constexpr double kShareOfEngine = 0.9;                         // of the progress after reading; the rest is landing
constexpr double kIdleWait = 10.0, kLoadingWait = 0.05;        // seconds
constexpr double kContextPatience = 20.0, kContextWait = 0.5;  // seconds: for a driver that resets its GPU

std::string name_of_files(const std::vector<std::string>& files) {
  std::string name = files.empty() ? "" : std::filesystem::path(files[0]).filename().string();
  if (files.size() > 1) name += " and " + std::to_string(files.size() - 1) + " more";
  return name;
}

Json vector_json(const core::dvec3& v) {
  return Json::array({v.x, v.y, v.z});
}

Json measure_json(const Measuring& measuring) {
  Json json{{"marks", measuring.marks().size()}, {"rows", Json::object()}};
  for (const auto& [what, value] : measuring.rows()) json["rows"][what] = value;
  if (measuring.distance()) json["distance"] = measuring.distance()->distance;
  return json;
}

/// Items by what a frozen camera's culling makes of them, and its boxes.
Json culling_json(Session& session, const CullingBoxes& boxes) {
  Json json = Json::object();
  if (const auto loss = session.loss()) json["loss"] = {{"items", loss->items}, {"pixels", loss->pixels}};
  const culling::CullStates* states = session.frozen() ? session.frozen()->states() : nullptr;
  if (!states) return json;
  for (int i = 0; i < culling::kCullStateCount; ++i)
    json[std::string(name_of(culling::CullState(i)))] = states->items[std::size_t(i)];
  json.update({{"boxes", boxes.wanted()}, {"drawn", boxes.drawn()}});
  return json;
}

Json sections_json(const Sections& sections) {
  Json json = Json::array();
  for (const Sections::Section& section : sections.all())
    json.push_back({{"on", section.on},
                    {"at", vector_json(section.place())},
                    {"normal", vector_json(section.normal)},
                    {"moved", section.offset}});
  return json;
}

Json views_json(const ViewList& views) {
  Json json{{"count", views.size()}, {"current", views.current_index() + 1}};
  if (const Viewpoint* view = views.current())
    json.update({{"name", view->name}, {"comment", view->comment}, {"guid", view->guid}});
  return json;
}

}  // namespace

std::string free_name(const std::string& stem, const std::string& extension) {
  for (int i = 1;; ++i)
    if (std::string name = stem + "-" + std::to_string(i) + extension; !std::filesystem::exists(name)) return name;
}

Viewer::Viewer(const ViewerOptions& options, Window& window, Gui gui, SettingsFile settings)
    : options_(options), window_(window), gui_(std::move(gui)), settings_(std::move(settings)) {
  shown.panels = options.panels && options.frames == 0;
  shown.smooth = options.smooth && (options.script.empty() || !options.settings.empty());
  now_ = settings_.settings();
  shown.triad = now_.triad;
  shown.lower = now_.lower;
  shown.tree_width = now_.tree_width;
  shown.side_width = now_.side_width;
  shown.relief = options.shown.relief.any() || (now_.relief && options.remembers());
  if (!options.shown.relief.any()) options_.shown.relief = kRelief;
  shown.hatching = options.shown.hatching.any() || (now_.hatching && options.remembers());
  if (!options.shown.hatching.any()) options_.shown.hatching = kHatching;
  options_.shown.hatching.spacing = float(kHatching.spacing * std::max(1.0, gui_.scale()));
  take_settings();
  settings_.begin(now_);
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
    if (auto done = land(); !done) return tl::unexpected(done.error());
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
  if (landing_ || (preview_ && preview_->drawing())) return 0.0;
  if (loader_) return kLoadingWait;
  if (!at_rest() || refining() || player_.playing() || next_step_ < script_.size()) return 0.0;
  return waits_for_picks() ? kLoadingWait : kIdleWait;
}

bool Viewer::script_ended() const {
  return !script_.empty() && next_step_ == script_.size() && !export_ && window_shot_.empty() &&
         glfwGetTime() >= wait_until_;
}

/// Whether the window is to be closed. Asks once, where views would be lost that no file has.
bool Viewer::closing() {
  if (!window_.closing()) return false;
  if (shown.quit || !options_.script.empty() || options_.frames > 0 || views_.unsaved() == 0) return true;
  window_.keep_open();
  shown.quit = true;
  redraws_ = kSettlingFrames;
  return false;
}

/// Makes the window and all that lay in its context anew. Model, camera, sections and selection stay.
core::Expected<void> Viewer::recover() {
  export_.reset();
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
  if (loader_ || redraws_ > 0 || gui_.has_events() || export_ || (player_.playing() && !player_.loop) || flies ||
      (walker_ && walker_->falling()) || !window_shot_.empty())
    return false;
  if (options_.frames > 0 || glfwGetTime() < wait_until_) return false;
  if (session_ && session_->coarse() && !player_.playing()) return false;
  return !session_ || !session_->stale();
}

/// Of the pictures; their context and size come later.
engine::EngineConfig Viewer::picture_config() const {
  engine::EngineConfig config;
  config.draw = true;
  config.culler = options_.culler;
  config.gpu_culler = options_.gpu_culler;
  config.samples = options_.samples;
  options_.shown.apply(config);
  if (!shown.relief) config.relief = {};
  if (!shown.hatching) config.hatching = {};
  config.hidden_colour = kHiddenColour;
  config.context_later = true;
  return config;
}

void Viewer::open(const std::vector<std::string>& files) {
  drop_loading();
  ModelOptions model = options_.model;
  model.files = files;
  if (!session_) {
    preview_ = std::make_unique<Preview>(picture_config());
    model.follow = [preview = preview_.get()](const core::Scene& scene) {
      if (preview->follow(scene)) Window::wake();
    };
  }
  // The window goes on while the engine is made.
  const auto make_session = [this, config = picture_config()](Model& read, const auto& go_on) -> core::Expected<void> {
    const auto part = [&](double share) { return go_on(kShareOfEngine * share); };
    if (!part(0.0)) return core::fail(std::string(importers::kCancelled));
    auto session = Session::open(std::move(read), config, part);
    if (!part(1.0)) return core::fail(std::string(importers::kCancelled));
    if (!session) return tl::unexpected(session.error());
    opened_ = std::move(*session);
    return {};
  };
  loader_ = std::make_unique<Loader>(model, &Window::wake, make_session);
  found_.reset();
  shown.open = false;
  tell("reading " + name_of_files(files));
}

void Viewer::drop_loading() {
  loader_.reset();  // first: its thread uses preview and model
  opened_.reset();
  landing_ = false;
}

void Viewer::cancel_loading() {
  if (loader_) loader_->cancel();
}

/// Shows the model that was being read, once it is there: portion by portion, while the window goes on. What is open
/// stays where the file cannot be read.
core::Expected<void> Viewer::land() {
  if (!loader_ || export_) return {};
  if (!landing_) {
    auto model = loader_->take();
    if (!model) return {};
    if (found_) {
      const std::string file = loader_->options().files.front();
      loader_.reset();
      redraws_ = kSettlingFrames;
      return land_comparison(std::move(*model), file), core::Expected<void>();
    }
    if (!*model) return not_landed(model->error());
    landing_ = true;
  }
  if (loader_->cancelled()) return not_landed({std::string(importers::kCancelled)});
  part_ = viewport();
  const auto done = opened_->begin(window_.context(), {part_.width, part_.height});
  if (!done) return lost() ? core::Expected<void>() : not_landed(done.error());
  return *done ? landed() : core::Expected<void>();
}

core::Expected<void> Viewer::not_landed(const core::Error& error) {
  const bool first = !session_ && loader_->options().files == options_.model.files;
  drop_loading();
  preview_.reset();
  redraws_ = kSettlingFrames;
  if (first && (options_.frames > 0 || !options_.script.empty())) return tl::unexpected(error);
  tell(error.message, true);
  if (first) std::fprintf(stderr, "sightline-view: %s\n", error.message.c_str());
  return {};
}

core::Expected<void> Viewer::landed() {
  const std::vector<std::string> files = loader_->options().files;
  const bool another = session_ != nullptr, first = !another && files == options_.model.files;
  loader_.reset();
  preview_.reset();
  landing_ = false;
  redraws_ = kSettlingFrames;
  print_warnings(opened_->model().report.warnings);
  set_walking(false);
  section_handles_.forget();
  session_ = std::move(opened_);
  shown_view_.reset();
  if (const engine::EngineConfig& config = session_->engine().config();
      shown.relief != config.relief.any() || shown.hatching != config.hatching.any())  // switched meanwhile
    if (auto done = apply_looks(); !done) return done;
  files_ = files;
  for (const std::string& file : files) now_.add_recent(file);
  warn_of_outliers(session_->bounds());
  if (options_.model.explain) explain(session_->engine().plan());
  if (const auto& path = player_.path(); path && !another) {
    session_->camera().set_planes(path->near, path->far);
    player_.play();
  }
  window_.set_title(name_of_files(files) + " - Sightline");
  if (first && !settings_.damage().empty())
    tell(settings_.damage(), true);
  else
    tell(std::to_string(session_->scene().item_count()) + " items");
  return {};
}

core::Expected<void> Viewer::read_path() {
  if (options_.path.empty()) return {};
  auto path = importers::read_path(options_.path);
  if (path && !options_.model.translate.empty())
    path = importers::translated(*path, *parse_vector(options_.model.translate));
  if (!path) return tl::unexpected(path.error());
  player_.set_path(std::move(*path));
  return {};
}

core::Expected<void> Viewer::frame(double seconds) {
  const double began = glfwGetTime();
  for (const Event& event : gui_.take_events()) {
    redraws_ = kSettlingFrames;
    if (export_) {
      export_cancelled_ |= event.type == Type::kKey && event.down && event.key == GLFW_KEY_ESCAPE;
      continue;
    }
    if (!gui_.uses(event) || event.type == Type::kDrop || (event.type == Type::kButton && !event.down) ||
        (event.type == Type::kKey && !event.down) || event.type == Type::kCursor)
      handle(event);
  }
  fly(std::min(seconds, kLongestStep));
  play();
  hover();
  const std::array<int, 2> size = window_.size();
  gui_.begin(size, seconds);
  if (shown.panels) {
    menu_bar(*this);
    splitters(*this);  // first: of windows that stay in their order, the one that was made first lies in front
    tree_panel(*this);
    side_panel(*this);
    status_bar(*this);
  }
  if (shown.help) help_window(*this);
  if (shown.open) open_window(*this);
  if (shown.compare) compare_window(*this);
  if (shown.quit) quit_window(*this);
  if (shown.picture && session_) picture_window(*this);
  if (shown.path && session_) path_window(*this);
  if (loader_) loading_window(*this);
  exporting_window(*this);
  if (session_ && session_->document().hovered() && !drag_ && !shown.measure && !ImGui::GetIO().WantCaptureMouse &&
      !section_target())
    item_tip(*this, *session_->document().hovered());
  draw_rectangle();
  measure_overlay(*this, viewport());
  section_overlay(*this, viewport());
  window_.clear(gui_.theme() == Theme::kDark ? kEmptyDark : kEmptyLight);
  const auto drawn = draw_model(viewport());
  if (session_) culling_.draw(*session_, viewport());
  triad_overlay(*this);
  gui_.end();
  if (!drawn) return drawn;
  if (!window_shot_.empty()) {
    auto written = image::write_png(window_.read(), std::exchange(window_shot_, {}));
    if (!written) return written;
  }
  window_.present();
  const double now = glfwGetTime();
  frame_seconds_ = now - began;
  if (asked_at_ > 0.0) response_ms_ = 1e3 * (now - std::exchange(asked_at_, 0.0));
  if (!gui_.has_events()) asked_at_ = -1.0;
  redraws_ = std::max(0, redraws_ - 1);
  return {};
}

core::Expected<void> Viewer::draw_model(const Part& part) {
  if (part.width <= 0 || part.height <= 0) return {};
  if (!session_ && preview_) {
    const auto framebuffer = preview_->draw(window_.context(), {part.width, part.height});
    if (framebuffer) window_.copy(*framebuffer, {part.width, part.height}, part);
  }
  if (!session_) return {};
  if (export_) {
    if (!window_.keeps_picture())
      if (auto done = window_.keep(&export_->before()); !done) return done;
    return window_.copy_kept(part), core::Expected<void>();
  }
  part_ = part;
  if (auto done = session_->resize({part.width, part.height}); !done) return done;
  if (auto done = adapt_resolution(); !done) return done;
  const bool shifted = session_->partly_refined() || (session_->smooth() && !shown.smooth);
  if (options_.frames > 0 || shifted) session_->changed();
  const auto drawn = session_->draw();
  if (!drawn) return tl::unexpected(drawn.error());
  if (*drawn) note_picture();
  const image::Image* smooth = shown.smooth ? session_->smooth() : nullptr;
  core::Expected<void> copied;
  if (!smooth || !window_.keeps_picture()) copied = window_.keep(smooth);
  if (smooth && copied)
    window_.copy_kept(part);
  else
    window_.copy(session_->engine().framebuffer().value_or(0), session_->drawn_size(), part);
  if (!copied || drag_) return copied;
  return session_->outline_hovered({0, part.x, part.y, part.width, part.height});
}

/// Fewer pixels while the view moves and frames come late.
core::Expected<void> Viewer::adapt_resolution() {
  const auto view = session_->view();
  const bool moves = view && shown_view_ && !core::same_picture(*view, *shown_view_);
  if (view) shown_view_ = *view;
  const bool coarse = motion_.next(moves, glfwGetTime(), frame_seconds_) && shown.lower && options_.frames == 0;
  return session_->set_coarse(coarse);
}

void Viewer::note_picture() {
  const engine::FrameReport& report = session_->report();
  ++frames_;
  if (recorder_) recorder_->add(glfwGetTime(), {session_->camera().pose(), session_->camera().fovy()});
  if (!options_.json_file.empty()) {
    cull_ms_.push_back(report.cull_ms);
    if (report.frame_ms > 0.0) frame_ms_.push_back(report.frame_ms);
  }
  history_.add(report, session_->visible());
}

/// Where the model is drawn: between the panels.
Part Viewer::viewport() const {
  const std::array<int, 2> size = window_.size();
  if (!shown.panels) return {0, 0, size[0], size[1]};
  const Margins m = margins(*this);
  return {m.left, m.bottom, std::max(1, size[0] - m.left - m.right), std::max(1, size[1] - m.top - m.bottom)};
}

// --- the script ------------------------------------------------------------------------------------------------------

core::Expected<void> Viewer::step_script() {
  const ScriptStep& step = script_[next_step_];
  const bool at_point = step.name == "wheel" || step.name == "drag";  // of the model, where picks do not wait
  if (at_point && session_ && session_->engine().preparing_picks()) return {};
  ++next_step_;
  if (auto done = carry_out(step); !done)
    return core::fail(options_.script + ":" + std::to_string(step.line) + ": " + done.error().message);
  redraws_ = kSettlingFrames;
  return {};
}

core::Expected<void> Viewer::carry_out(const ScriptStep& step) {
  auto events = events_of(step);
  if (!events) return tl::unexpected(events.error());
  if (!events->empty()) {
    if (step.name == "wheel") events->front().at = cursor_;
    gui_.push(std::move(*events));
    return {};
  }
  if (step.name == "expect") return expect(step.argument);
  if (step.name == "window-shot") {
    window_shot_ = step.argument;
    return {};
  }
  if (step.name == "resize") {
    const auto size = parse_size(step.argument);
    if (!size) return tl::unexpected(size.error());
    window_.resize(*size);
    wait_until_ = glfwGetTime() + 0.2;  // the window system answers later
    return {};
  }
  if (step.name == "hold") {
    const std::size_t space = step.argument.rfind(' ');
    const auto seconds = parse_finite(space == std::string::npos ? "" : step.argument.substr(space + 1));
    if (!seconds) return core::fail("hold: expected a key and seconds, found \"" + step.argument + "\"");
    auto pressed = events_of({step.line, "press", step.argument.substr(0, space)});
    if (!pressed) return tl::unexpected(pressed.error());
    release_ = pressed->back();
    gui_.push({pressed->front()});
    wait_until_ = glfwGetTime() + *seconds;
    return {};
  }
  if (step.name == "wait") {
    const auto seconds = parse_finite(step.argument);
    if (!seconds) return tl::unexpected(seconds.error());
    wait_until_ = glfwGetTime() + *seconds;
    return {};
  }
  const Command* command = find_command(step.name);
  if (!command) return core::fail("no command " + step.name);
  if (command->needs_model && !session_) return core::fail(step.name + ": no model is open");
  return command->run(*this, step.argument);
}

core::Expected<void> Viewer::expect(const std::string& argument) {
  const std::size_t space = argument.find(' ');
  const std::string pointer = argument.substr(0, space),
                    demand = space == std::string::npos ? "" : argument.substr(space + 1);
  const Json all = state();
  Json value;
  try {
    value = all.at(Json::json_pointer(pointer));
  } catch (const Json::exception&) {
    return core::fail("expect: the state has no " + pointer);
  }
  const auto good = fulfils(value.dump(), demand);
  if (!good) return tl::unexpected(good.error());
  if (!*good) return core::fail("expected " + argument + ", found " + value.dump());
  return {};
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
  const std::string frames = export_->count() > 1 ? std::to_string(export_->frame()) + " frames: " : "picture: ";
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

void Viewer::tell(std::string message, bool error) {
  message_ = std::move(message);
  message_is_error_ = error;
  redraws_ = kSettlingFrames;
}

core::Expected<void> Viewer::toggle_relief() {
  shown.relief = !shown.relief;
  return apply_looks();
}

core::Expected<void> Viewer::toggle_hatching() {
  shown.hatching = !shown.hatching;
  return apply_looks();
}

core::Expected<void> Viewer::apply_looks() {
  redraws_ = kSettlingFrames;
  if (!session_) return {};
  return session_->configure([&](engine::EngineConfig& config) {
    config.relief = shown.relief ? options_.shown.relief : engine::Relief();
    config.hatching = shown.hatching ? options_.shown.hatching : engine::Hatching();
  });
}

core::Expected<std::optional<engine::Pick>> Viewer::under_cursor() {
  if (!in_viewport(cursor_)) return std::optional<engine::Pick>();
  return session_->pick(in_picture(cursor_));
}

core::Expected<void> Viewer::select_nodes(const std::vector<core::NodeId>& nodes) {
  std::vector<core::ItemId> items;
  for (const core::NodeId node : nodes) {
    const std::vector<core::ItemId> below = session_->document().items_below(node);
    items.insert(items.end(), below.begin(), below.end());
  }
  return session_->document().select(items);
}

core::Expected<void> Viewer::write_screenshot(const std::string& file) {
  const std::string name = file.empty() ? free_name("screenshot", ".png") : file;
  const auto picture = session_->picture(shown.smooth);
  if (!picture) return tl::unexpected(picture.error());
  if (auto done = image::write_png(*picture, name); !done) return done;
  warn_if_blank(session_->engine(), session_->visible(), name);
  tell("picture: " + name);
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

void Viewer::take_settings() {
  now_.light = gui_.theme() == Theme::kLight;
  now_.smooth = shown.smooth;
  now_.panels = shown.panels;
  now_.triad = shown.triad;
  now_.relief = shown.relief;
  now_.hatching = shown.hatching;
  now_.lower = shown.lower;
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

core::Expected<void> Viewer::finish() {
  export_.reset();
  if (!session_) return options_.frames > 0 ? core::fail("no model was drawn") : core::Expected<void>();
  session_->engine().finish();
  core::Expected<void> done;
  if (recorder_) done = toggle_recording();
  for (const std::string& error : session_->engine().take_gl_errors()) return core::fail("GL: " + error);
  if (done && !options_.screenshot.empty()) done = write_screenshot(options_.screenshot);
  if (done && !options_.json_file.empty()) done = write_text(options_.json_file, to_text(state()));
  return done;
}

nlohmann::ordered_json Viewer::state() const {
  Json json{{"model", files_},
            {"renderer", window_.context().renderer()},
            {"size", {part_.width, part_.height}},
            {"window", window_.size()},
            {"frames", frames_},
            {"message", message_},
            {"panels", shown.panels},
            {"help", shown.help},
            {"theme", gui_.theme() == Theme::kLight ? "light" : "dark"},
            {"recent", now_.recent},
            {"walk", walking()},
            {"triad", shown.triad},
            {"smooth", shown.smooth},
            {"relief", shown.relief},
            {"hatching", shown.hatching},
            {"lower", shown.lower},
            {"picture", {{"width", part_.width}, {"height", part_.height}}},
            {"response_ms", response_ms_},
            {"pause_ms", pause_ms_},
            {"recording", recording()},
            {"playing", player_.playing()},
            {"recovered", recovered_},
            {"views", views_json(views_)}};
  if (!session_) return json;
  const Document& document = session_->document();
  const core::Pose& pose = session_->camera().pose();
  const Sections& sections = session_->sections();
  json["section_list"] = sections_json(sections);
  if (shows_section_handles())
    for (const SectionHandles::Shown& one : SectionHandles::shown(*session_, gui_.scale()))
      for (const SectionGizmo::Handle& handle : one.gizmo.handles()) {
        const core::dvec2 at = handle.at - in_picture({0.0, 0.0});
        json["section_list"][one.section]["handles"][SectionGizmo::name_of(handle.part)] = {at.x, at.y};
      }
  json["section_selected"] = sections.selected() ? *sections.selected() + 1 : 0;
  json.update({{"items", session_->scene().item_count()},
               {"culler", name_of(session_->engine().plan().culler)},
               {"culled_by", name_of(session_->report().culler)},
               {"visible", session_->visible()},
               {"drawn", session_->report().shown},
               {"selection", {{"count", document.selection().size()}}},
               {"hidden", document.hidden()},
               {"ghosts", document.ghosts()},
               {"hovered", document.hovered() ? std::int64_t(*document.hovered()) : -1},
               {"sections", session_->sections().planes().size()},
               {"measure", measure_json(session_->measuring())},
               {"found", session_->tree().match_count()},
               {"rows", session_->tree().rows().row_count()},
               {"undo_steps", document.undo_steps()},
               {"redo_steps", document.redo_steps()},
               {"frozen", session_->frozen() != nullptr},
               {"compare", compare_json(session_->changes())},
               {"culling", culling_json(*session_, culling_.boxes())},
               {"budget_ms", session_->engine().config().budget_ms},
               {"contribution", session_->engine().config().contribution},
               {"camera",
                {{"eye", vector_json(pose.eye)},
                 {"target", vector_json(pose.target)},
                 {"orthographic", session_->camera().orthographic()}}},
               {"summary",
                {{"cull_ms", to_json<Json>(summarise(cull_ms_))}, {"frame_ms", to_json<Json>(summarise(frame_ms_))}}}});
  return json;
}

}  // namespace sightline::apps
