#include "sightline/apps/view/viewer.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/view/actions.h"
#include "sightline/importers/import.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;

constexpr double kIdleWait = 10.0, kLoadingWait = 0.05;        // seconds
constexpr double kContextPatience = 20.0, kContextWait = 0.5;  // seconds: for a driver that resets its GPU

bool is_of_mouse(const Event& event) {
  return event.type == Event::Type::kCursor || event.type == Event::Type::kButton || event.type == Event::Type::kWheel;
}

/// The text of the bottom line; all of the report is in the tab Item.
std::string recognised_items(const importers::RecognitionReport& report) {
  if (report.meshes == 0) return "";
  const std::uint64_t items = std::accumulate(report.items.begin(), report.items.end(), std::uint64_t{0});
  return ", " + std::to_string(items) + " of them recognised in meshes";
}

std::string what_was_lost(const std::vector<importers::ImportWarning>& warnings) {
  const auto lost =
      std::ranges::count_if(warnings, [](const auto& one) { return one.message != importers::kSeemsYUp; });
  return lost == 0
             ? "; nothing was lost"
             : "; " + grouped(lost) + (lost == 1 ? " warning says" : " warnings say") + " what was lost: tab Item";
}

void print_error(const std::string& error) {
  std::fprintf(stderr, "sightline-view: %s\n", error.c_str());
}

}  // namespace

Viewer::Viewer(const ViewerOptions& options, Window& window, Gui gui, SettingsFile settings)
    : work_(options, window, std::move(gui), settings.settings()), settings_(std::move(settings)) {
  settings_.begin(work_.shown);
  if (!options.model.files.empty()) work_.open(options.model.files);
}

core::Expected<int> Viewer::run() {
  if (auto done = begin(); !done) return tl::unexpected(done.error());
  double last = glfwGetTime(), looked = 0.0;
  while (!closing() && (work_.options.frames == 0 || work_.image.frames() < work_.options.frames)) {
    const bool was_busy = busy();
    if (!was_busy) keep_settings();
    if (thumbnail_due_ && settled()) keep_thumbnail();
    script_.follow(work_);
    if (script_.ended() && !work_.exports.busy()) {
      work_.window.close();
      continue;
    }
    if (looked > 0.0) work_.pace.pause_ms = std::max(work_.pace.pause_ms, 1e3 * (glfwGetTime() - looked));
    std::vector<Event> fresh = work_.window.poll(patience());
    if (!work_.options.script.empty()) std::erase_if(fresh, is_of_mouse);  // which is the script's alone
    work_.gui.push(std::move(fresh));
    looked = glfwGetTime();
    if (closing()) break;
    if (lost()) {
      if (auto done = recover(); !done) return tl::unexpected(done.error());
      continue;
    }
    if (!was_busy && !work_.gui.has_events()) continue;  // nothing to draw
    const auto alone = draws_alone();
    if (!alone) return tl::unexpected(alone.error());
    if (*alone) continue;
    const double now = glfwGetTime();
    if (auto done = frame(now - std::exchange(last, now)); !done && !lost()) return tl::unexpected(done.error());
  }
  keep_settings();
  keep_session();
  if (auto done = finish(); !done) return tl::unexpected(done.error());
  return kExitOk;
}

Done Viewer::begin() {
  if (auto done = read_path(); !done) return done;
  if (auto done = script_.read(work_.options.script); !done) return done;
  if (std::error_code none; !settings_.file().empty() && fs::exists(last_session(), none))
    if (auto last = read_session(last_session())) work_.last = std::move(*last);  // files may be no longer there
  if (settings_.damage().empty()) return {};
  print_error(settings_.damage());
  if (!work_.opening.active()) work_.messages.tell(settings_.damage(), true);
  return {};
}

/// Goes on with what needs no frame of the window. True where none is to be drawn after that.
core::Expected<bool> Viewer::draws_alone() {
  if (auto done = step_exports(); !done) return tl::unexpected(done.error());
  if (auto done = land(); !done) return tl::unexpected(done.error());
  if (work_.opening.swapping_in() && !work_.gui.has_events() && glfwGetTime() < work_.pace.next_frame) return true;
  if (auto done = refine_meshes(); !done && !lost()) return tl::unexpected(done.error());
  if (settled() && script_.has_steps())
    if (auto done = script_.step(work_); !done) return tl::unexpected(done.error());
  if (work_.gui.has_events() && work_.pace.asked_at < 0.0) work_.pace.asked_at = glfwGetTime();
  if (!settled_but_for_edges() || !refining() || work_.finer.active()) return false;
  if (auto done = work_.session->image.refine(); !done && !lost()) return tl::unexpected(done.error());
  work_.pace.redraws = work_.session->image.refining() ? 0 : 1;
  return work_.pace.redraws == 0;
}

/// Where a view at rest has come so near to exact surfaces that facets show, they become finer. A comparison has the
/// meshes that were read.
Done Viewer::refine_meshes() {
  Session* session = work_.session.get();
  if (!session || !settled_but_for_edges() || work_.player.playing() || session->changes() || !work_.scene_is_free())
    return {};
  if (work_.finer.ready()) {
    work_.pace.redraw();
    return session->exchange_meshes([&](core::Scene& scene) { return work_.finer.finish(scene); });
  }
  const auto& view = session->image.drawn();
  const std::array<int, 2>& size = session->image.size();
  if (work_.shown.smooth && work_.options.frames == 0 && view)
    work_.finer.begin(session->engine.snapshot(), *view, size[0], size[1]);
  return {};
}

/// A failure ends scripts; otherwise it is told.
Done Viewer::step_exports() {
  auto done = work_.exports.step(work_.messages);
  if (done || lost()) return {};
  if (!work_.options.script.empty()) return done;
  work_.messages.tell(done.error().message, true);
  return {};
}

bool Viewer::busy() const {
  return !settled() || work_.player.playing() || script_.has_steps();
}

/// Seconds to wait for events before the loop goes on without.
double Viewer::patience() const {
  const Preview* preview = work_.opening.preview();
  if (work_.opening.swapping_in() || (preview && preview->drawing())) return 0.0;
  if (work_.opening.active() || work_.exports.model() || work_.finer.active())
    return std::max(kLoadingWait, Pace::kBetweenFrames * work_.pace.frame_seconds);
  if (!at_rest() || refining() || work_.player.playing() || script_.has_steps()) return 0.0;
  return work_.gestures.waits_for_picks() ? kLoadingWait : kIdleWait;
}

/// Nothing will change by itself, but for smooth edges and what the cursor is over.
bool Viewer::at_rest() const {
  const bool plays = work_.player.playing();
  if (work_.opening.active() || work_.exports.busy() || work_.pace.redraws > 0 || work_.messages.is_new() ||
      work_.gui.has_events() || (plays && !work_.player.loop) || work_.gestures.moves() || script_.waits() ||
      work_.options.frames > 0)
    return false;
  if (work_.session && work_.session->image.lowered() && !plays) return false;
  return !work_.session || !work_.session->image.stale();
}

bool Viewer::refining() const {
  return work_.shown.smooth && work_.options.frames == 0 && !work_.player.playing() && !work_.exports.image() &&
         work_.session && work_.session->image.refining();
}

/// Whether the window is to be closed. Asks once, where views would be lost that no file has.
bool Viewer::closing() {
  if (!work_.window.closing()) return false;
  if (work_.shown.dialog == Dialog::kQuit || !work_.options.script.empty() || work_.options.frames > 0 ||
      work_.views.unsaved() == 0)
    return true;
  work_.window.keep_open();
  work_.shown.dialog = Dialog::kQuit;
  work_.pace.redraw();
  return false;
}

/// Makes the window and all that lay in its context anew. Model, camera, sections and selection stay.
Done Viewer::recover() {
  work_.exports.drop_image();
  work_.textures.clear();
  work_.gui.drop_context();
  auto opened = work_.window.reopen();
  for (const double end = glfwGetTime() + kContextPatience;
       !opened && glfwGetTime() < end && !work_.window.closing();) {
    work_.window.poll(kContextWait);
    opened = work_.window.reopen();
  }
  if (opened) opened = work_.gui.use_context();
  if (opened && work_.session) opened = work_.session->image.use_context(work_.window.context());
  if (!opened) return core::fail("the graphics driver has lost the window's context: " + opened.error().message);
  work_.pace.context_lost = false;
  ++work_.pace.recovered;
  work_.gestures.let_go();  // ends of drags and keys went to the former window
  work_.messages.tell("the lost graphics context was made anew");
  return {};
}

/// Shows the model that was being read, or what has changed since it, once that is there. What is open stays where a
/// file cannot be read.
Done Viewer::land() {
  if (!work_.opening.active() || work_.exports.busy()) return {};
  const std::vector<std::string> files = work_.opening.files();
  const bool lenient = work_.opening.lenient(), comparing = work_.opening.comparing();
  work_.image.place(work_.viewport());
  auto opened = work_.opening.step(work_.window.context(), {work_.image.part().width, work_.image.part().height});
  if (!opened) {
    if (!lenient && !comparing && opened.error().message != importers::kCancelled && readable_in_part(files))
      work_.damaged = {files, opened.error().message};
    return not_landed(opened.error(), files);
  }
  if (opened->session) return landed(std::move(opened->session), lenient);
  if (!opened->changes) return {};
  work_.pace.redraw();
  if (auto done = work_.session->begin_comparison(std::move(opened->changes)); !done)
    work_.messages.tell(done.error().message, true);
  else
    work_.messages.tell(summary(*work_.session->changes()));
  return {};
}

Done Viewer::not_landed(const core::Error& error, const std::vector<std::string>& files) {
  const bool first = !work_.session && files == work_.options.model.files;
  if (first && (work_.options.frames > 0 || !work_.options.script.empty())) return tl::unexpected(error);
  if (work_.damaged.files.empty()) work_.returning.reset();
  work_.messages.tell(error.message, true);
  if (first) print_error(error.message);
  return {};
}

Done Viewer::landed(std::unique_ptr<Session> session, bool lenient) {
  const bool another = work_.session != nullptr, first = !another && session->files == work_.options.model.files;
  print_warnings(session->model().report.warnings);
  work_.gestures.forget_model();
  work_.finer.forget();
  work_.session = std::move(session);
  work_.pace.redraw();
  thumbnail_due_ = true;
  const Session& open = *work_.session;
  const DrawnOptions& drawn = work_.options.shown;
  work_.shown.edges = (work_.options.remembers() ? drawn.looks_of(open.scene()) : drawn.all_looks()).edges.any();
  if (auto done = work_.image.begin(*work_.session, work_.shown); !done) return done;
  for (const std::string& file : open.files)  // attributes alone open nothing
    if (!importers::is_attribute_file(file)) work_.shown.add_recent(file);
  work_.last.reset();
  work_.session_file.clear();
  Done shown;
  if (work_.returning) shown = show_returning(work_);
  warn_of_outliers(open.bounds());
  if (work_.options.model.explain) explain(open.engine.plan());
  if (const auto& path = work_.player.path(); path && !another) {
    work_.session->camera.set_planes(path->near, path->far);
    work_.player.play();
  }
  work_.window.set_title(name_of_files(open.files) + " - Sightline");
  if (!shown || work_.messages.is_new())
    work_.messages.tell_outcome(shown);
  else if (first && !settings_.damage().empty())
    work_.messages.tell(settings_.damage(), true);
  else
    work_.messages.tell(grouped(std::int64_t(open.scene().item_count())) + " items" +
                        recognised_items(open.model().report.recognition) +
                        (lenient ? what_was_lost(open.model().report.warnings) : "") +
                        (open.model().seems_y_up ? "; y seems to point up, so it is turned: File, Y is up" : ""));
  return {};
}

Done Viewer::read_path() {
  const ViewerOptions& options = work_.options;
  if (options.path.empty()) return {};
  auto path = importers::read_path(options.path);
  if (path && !options.model.translate.empty())
    path = importers::translated(*path, *parse_vector(options.model.translate));
  if (!path) return tl::unexpected(path.error());
  work_.player.set_path(std::move(*path));
  return {};
}

void Viewer::keep_settings() {
  work_.shown.window = work_.window.screen_size();
  const auto done = settings_.keep(work_.shown);
  if (done) return;
  work_.messages.tell("settings are not kept: " + done.error().message, true);
  print_error(work_.messages.text());
}

/// For the next run, which offers it. A run that shows nothing leaves what was kept before.
void Viewer::keep_session() {
  const auto saved = work_.to_save();
  if (!saved || settings_.file().empty()) return;
  if (const auto done = write_session(*saved, last_session()); !done) print_error(done.error().message);
}

/// Keeps the thumbnail of a model that is one file, with attributes or without: an image of several shows none of them.
/// Without a folder that takes files there are no thumbnails.
void Viewer::keep_thumbnail() {
  thumbnail_due_ = false;
  std::vector<std::string> models = work_.session->files;
  std::erase_if(models, [](const std::string& file) { return importers::is_attribute_file(file); });
  if (models.size() != 1) return;
  const FileState now = state_of(models[0]);
  if (!work_.thumbnails.lacks(models[0], now)) return;
  if (const auto image = work_.session->image.read(work_.shown.smooth))
    (void)work_.thumbnails.keep(models[0], now, *image);
}

Done Viewer::finish() {
  const ViewerOptions& options = work_.options;
  work_.exports.drop();
  if (!work_.session) return options.frames > 0 ? core::fail("no model was drawn") : Done();
  work_.session->engine.finish();
  Done done;
  if (work_.recorder) done = toggle_recording(work_, "");
  for (const std::string& error : work_.session->engine.take_gl_errors()) return core::fail("GL: " + error);
  if (done && !options.screenshot.empty()) done = write_screenshot(work_, options.screenshot);
  if (done && !options.json_file.empty()) done = write_text(options.json_file, to_text(state_json(work_)));
  return done;
}

}  // namespace sightline::apps
