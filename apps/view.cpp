// sightline-view: a window to walk through a model in.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#define GLFW_INCLUDE_NONE
#include <CLI/CLI.hpp>
#include <GLFW/glfw3.h>
#include <nlohmann/json.hpp>

#include "sightline/apps/common/blank.h"
#include "sightline/apps/common/frame_words.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/view_window.h"
#include "sightline/engine/engine.h"
#include "sightline/image/image.h"
#include "sightline/importers/view_json.h"

namespace {

using namespace sightline;
using engine::CullerChoice;
using nlohmann::json;

constexpr double kTitleInterval = 0.25;  // seconds
constexpr core::vec3 kHiddenColour{0.85f, 0.1f, 0.55f};
constexpr double kNearShare = 1e-4;  // of the model's size; reverse-Z float depth stays precise with a small share

struct Options {
  apps::ModelOptions model;
  std::string size = "1280x720", path, save_path = "path.json", screenshot, json_file;
  CullerChoice culler = CullerChoice::kAutomatic;
  culling::GpuCullerConfig gpu_culler;
  int samples = 1;
  apps::ShownOptions shown;
  int frames = 0;
};

void add_options(CLI::App& app, Options& o) {
  apps::add_model_options(app, o.model);
  app.add_option("--size", o.size, "Of the window, in the screen's units")
      ->capture_default_str()
      ->check(apps::accepted_by(apps::parse_size));
  apps::add_culler_option(app, o.culler);
  apps::add_gpu_pass_option(app, o.gpu_culler);
  apps::add_shown_options(app, o.shown);
  apps::add_samples_option(app, o.samples);
  app.add_option("--path", o.path,
                 "Play this camera path first; with --frames as so many evenly spaced frames, else in its own time");
  app.add_option("--save-path", o.save_path, "Where R writes what it has recorded")->capture_default_str();
  app.add_option("--frames", o.frames, "Quit after so many frames, drawn as fast as they come")
      ->check(CLI::PositiveNumber);
  app.add_option("--screenshot", o.screenshot, "Write the last frame, PNG");
  app.add_option("--json", o.json_file, "Write figures as JSON to FILE, or - for stdout, at the end");
}

/// Cost of the frames since the title was last written.
struct TitleFigures {
  double since = 0.0, cull_ms = 0.0, frame_ms = 0.0;
  int frames = 0, timed = 0;  // timed: all except those after a pause
};

struct Camera {
  apps::CameraControl control;
  double fovy = apps::kFovy, near = 0.1, far = core::kInfiniteFar;

  core::Expected<core::View> view(const std::array<int, 2>& size) const {
    return core::View::perspective(control.pose(), fovy, double(size[0]) / size[1], near, far);
  }
};

class Viewer {
 public:
  Viewer(const Options& options, const apps::Model& model, apps::Window& window, engine::Engine& engine,
         const std::optional<core::CameraPath>& path)
      : options_(options), model_(model), window_(window), engine_(engine), path_(path), camera_{first_camera()} {
    playing_ = path_.has_value();
  }

  core::Expected<int> run();

  void cull_on_cpu() { choose(CullerChoice::kCpu); }
  void cull_on_gpu() { choose(CullerChoice::kGpu); }
  void cull_on_either() { choose(CullerChoice::kHybrid); }
  void cull_as_fits() { choose(CullerChoice::kAutomatic); }
  void fit() { camera_.control.fit(camera_.fovy, aspect()); }
  void toggle_orbit();
  void toggle_freeze();
  void toggle_recording();
  void take_screenshot();
  core::Expected<void> write_screenshot(const std::string& file);
  void print_keys();
  void quit() { window_.close(); }

 private:
  Camera first_camera() const;
  double aspect() const { return double(size_[0]) / size_[1]; }
  core::Expected<void> follow_size();
  core::Expected<void> frame();
  void press(int key);
  void choose(CullerChoice culler);
  void play();
  void centre_on_picture();
  void note(const engine::FrameReport& report);
  void write_title();
  core::Expected<void> finish();
  json to_json() const;

  const Options& options_;
  const apps::Model& model_;
  apps::Window& window_;
  engine::Engine& engine_;
  const std::optional<core::CameraPath>& path_;
  std::array<int, 2> size_ = window_.size();
  Camera camera_;
  std::optional<core::View> drawn_, frozen_;  // the last view; the view that culls
  bool playing_ = false;
  double play_began_ = -1.0;  // GLFW's time
  std::optional<apps::PathRecorder> recorder_;
  TitleFigures title_;
  engine::FrameReport last_;
  std::int64_t visible_ = 0;                // as last known
  std::vector<double> cull_ms_, frame_ms_;  // of every frame, with --json
  int frames_ = 0;
};

constexpr int kNone = 0;  // no key; actions without a key are held or dragged, see Window::poll

struct Binding {
  int key, also;  // GLFW's numbers
  const char* names;
  const char* help;
  void (Viewer::*press)();
};

constexpr Binding kBindings[] = {
    {kNone, kNone, "W A S D", "fly forward, left, back, right", nullptr},
    {kNone, kNone, "Q E", "fly down, up", nullptr},
    {kNone, kNone, "left drag", "look about", nullptr},
    {kNone, kNone, "right drag", "orbit about what is in the middle of the picture", nullptr},
    {kNone, kNone, "wheel", "change the speed; zoom while O is on", nullptr},
    {GLFW_KEY_O, kNone, "O", "left drag orbits, too, and the wheel zooms; again: as before", &Viewer::toggle_orbit},
    {GLFW_KEY_F, kNone, "F", "fit the whole model", &Viewer::fit},
    {GLFW_KEY_1, GLFW_KEY_KP_1, "1", "cull on the CPU", &Viewer::cull_on_cpu},
    {GLFW_KEY_2, GLFW_KEY_KP_2, "2", "cull on the GPU", &Viewer::cull_on_gpu},
    {GLFW_KEY_3, GLFW_KEY_KP_3, "3", "cull where it costs less (hybrid)", &Viewer::cull_on_either},
    {GLFW_KEY_0, GLFW_KEY_KP_0, "0", "cull as the scene's size suggests", &Viewer::cull_as_fits},
    {GLFW_KEY_SPACE, GLFW_KEY_C, "Space C",
     "freeze the culling camera, or let it go; what it sees nothing of is magenta", &Viewer::toggle_freeze},
    {GLFW_KEY_R, kNone, "R", "begin to record a camera path; write it (--save-path)", &Viewer::toggle_recording},
    {GLFW_KEY_P, GLFW_KEY_F12, "P F12", "write a screenshot, PNG", &Viewer::take_screenshot},
    {GLFW_KEY_H, kNone, "H", "print these keys", &Viewer::print_keys},
    {GLFW_KEY_ESCAPE, kNone, "Esc", "quit", &Viewer::quit},
};

std::string key_list() {
  std::string text;
  for (const Binding& b : kBindings) {
    char line[120];
    std::snprintf(line, sizeof line, "  %-12s%s\n", b.names, b.help);
    text += line;
  }
  return text;
}

/// "screenshot-1.png", or the next number that no file has.
std::string free_name() {
  for (int i = 1;; ++i)
    if (std::string name = "screenshot-" + std::to_string(i) + ".png"; !std::filesystem::exists(name)) return name;
}

/// Prints the result of a key press. The walk goes on after an error.
void tell(const core::Expected<void>& done, const std::string& success) {
  if (done)
    std::printf("%s\n", success.c_str());
  else
    std::fprintf(stderr, "sightline-view: %s\n", done.error().message.c_str());
  std::fflush(stdout);
}

Camera Viewer::first_camera() const {
  const core::FittedBounds fitted = engine_.snapshot().bounds().fitted_bounds();
  const core::AabbD& bounds = fitted.bounds;
  apps::warn_of_outliers(fitted);
  Camera camera{apps::CameraControl(bounds, apps::kFovy, aspect())};
  camera.near = path_ ? path_->near : kNearShare * std::max(1.0, bounds.empty() ? 0.0 : glm::length(bounds.size()));
  if (path_) camera.far = path_->far;
  return camera;
}

core::Expected<int> Viewer::run() {
  while (!window_.closing() && (options_.frames == 0 || frames_ < options_.frames)) {
    const apps::WindowInput input = window_.poll();
    if (window_.closing()) break;
    if (auto done = follow_size(); !done) return tl::unexpected(done.error());
    for (const int key : input.pressed) press(key);
    if (input.orbit_begins) centre_on_picture();
    // Writing files, making cullers and reading pictures are no cost of a frame.
    if (input.waited || input.orbit_begins || !input.pressed.empty()) engine_.paused();
    if (!input.camera.idle()) playing_ = false;  // the user has taken over
    play();
    camera_.control.apply(input.camera);
    if (auto done = frame(); !done) return tl::unexpected(done.error());
  }
  if (auto done = finish(); !done) return tl::unexpected(done.error());
  return apps::kExitOk;
}

core::Expected<void> Viewer::follow_size() {
  if (window_.size() == size_) return {};
  size_ = window_.size();
  drawn_.reset();  // its picture is lost
  return engine_.resize(size_[0], size_[1]);
}

core::Expected<void> Viewer::frame() {
  auto view = camera_.view(size_);
  if (!view) return tl::unexpected(view.error());
  drawn_ = *view;
  const auto report = engine_.frame(*view, frozen_.value_or(*view));
  if (!report) return tl::unexpected(report.error());
  if (!report->drawn) return core::fail("the GL context was lost");
  window_.present(engine_.framebuffer().value_or(0), size_);
  ++frames_;
  if (recorder_) recorder_->add(glfwGetTime(), {camera_.control.pose(), camera_.fovy});
  note(*report);
  return {};
}

void Viewer::press(int key) {
  for (const Binding& b : kBindings)
    if (b.press && (key == b.key || key == b.also)) (this->*b.press)();
}

void Viewer::choose(CullerChoice culler) {
  const core::Expected<void> done = engine_.set_culler(culler);
  tell(done, "culler: " + std::string(name_of(engine_.plan().culler)));
  if (done && options_.model.explain) apps::explain(engine_.plan());
}

void Viewer::toggle_orbit() {
  camera_.control.set_orbiting(!camera_.control.orbiting());
  if (camera_.control.orbiting()) centre_on_picture();
}

void Viewer::toggle_freeze() {
  if (frozen_)
    frozen_.reset();
  else
    frozen_ = drawn_;
}

void Viewer::toggle_recording() {
  if (!recorder_) {
    recorder_.emplace();
    return;
  }
  const auto seen = recorder_->path(camera_.near, camera_.far);
  recorder_.reset();
  const auto path = seen ? importers::translated(*seen, -model_.offset) : seen;  // in the model's own frame
  tell(path ? importers::write_path(options_.save_path, *path) : tl::unexpected(path.error()),
       "path: " + options_.save_path);
}

void Viewer::take_screenshot() {
  const std::string file = free_name();
  tell(write_screenshot(file), "screenshot: " + file);
}

core::Expected<void> Viewer::write_screenshot(const std::string& file) {
  const auto picture = engine_.read_colour();
  if (!picture) return tl::unexpected(picture.error());
  auto done = image::write_png(*picture, file);
  while (const auto late = engine_.take_late_report()) visible_ = late->visible;
  apps::warn_if_blank(engine_, visible_, file);
  return done;
}

void Viewer::print_keys() {
  std::printf("%s", key_list().c_str());
  std::fflush(stdout);
}

/// Makes the point in the middle of the picture, if there is any, the centre of orbits.
void Viewer::centre_on_picture() {
  if (!drawn_) return;
  const auto read = engine_.read_depth(*drawn_);
  if (!read) return;
  const image::DepthImage& depth = *read;
  const std::size_t row = std::size_t(depth.height / 2) * std::size_t(depth.width);
  const float metres = depth.metres[row + std::size_t(depth.width / 2)];
  if (std::isfinite(metres) && metres > 0.0f) camera_.control.set_centre(metres);
}

void Viewer::play() {
  if (!playing_) return;
  double share = 1.0;
  if (options_.frames > 0) {
    share = options_.frames > 1 ? double(frames_) / (options_.frames - 1) : 0.0;
  } else if (path_->end() > path_->begin()) {
    if (play_began_ < 0.0) play_began_ = glfwGetTime();
    share = std::min(1.0, (glfwGetTime() - play_began_) / (path_->end() - path_->begin()));
  }
  const core::CameraSample sample = path_->sample(path_->begin() + share * (path_->end() - path_->begin()));
  camera_.control.set_pose(sample.pose);
  camera_.fovy = sample.fovy;
  playing_ = share < 1.0;
}

void Viewer::note(const engine::FrameReport& report) {
  if (report.visible >= 0) visible_ = report.visible;
  while (const auto late = engine_.take_late_report()) visible_ = late->visible;
  last_ = report;
  title_.cull_ms += report.cull_ms;
  title_.frame_ms += report.frame_ms;
  ++title_.frames;
  title_.timed += report.frame_ms > 0.0;
  if (!options_.json_file.empty()) {
    cull_ms_.push_back(report.cull_ms);
    if (report.frame_ms > 0.0) frame_ms_.push_back(report.frame_ms);
  }
  const double now = glfwGetTime();
  if (now - title_.since < kTitleInterval) return;
  write_title();
  title_ = {.since = now};
}

void Viewer::write_title() {
  char text[200];
  std::snprintf(text, sizeof text, "%s: %s (%s) | cull %.3f ms | frame %.1f ms | %lld of %zu items visible%s%s%s",
                name_of(engine_.plan().culler).data(), name_of(last_.culler).data(), apps::state_name(last_).data(),
                title_.cull_ms / title_.frames, title_.frame_ms / std::max(1, title_.timed), (long long)visible_,
                engine_.snapshot().size(), camera_.control.orbiting() ? " | orbit" : "",
                frozen_ ? " | culling camera frozen" : "", recorder_ ? " | recording" : "");
  window_.set_title(text);
}

core::Expected<void> Viewer::finish() {
  engine_.finish();
  if (recorder_) toggle_recording();
  for (const std::string& error : engine_.take_gl_errors()) return core::fail("GL: " + error);
  core::Expected<void> done;
  if (!options_.screenshot.empty()) done = write_screenshot(options_.screenshot);
  if (done && !options_.json_file.empty()) done = apps::write_text(options_.json_file, apps::to_text(to_json()));
  return done;
}

json Viewer::to_json() const {
  return {{"model", options_.model.files},
          {"items", engine_.snapshot().size()},
          {"renderer", window_.context().renderer()},
          {"culler", name_of(engine_.plan().culler)},
          {"size", size_},
          {"frames", frames_},
          {"visible", visible_},
          {"summary",
           {{"cull_ms", apps::to_json<json>(apps::summarise(cull_ms_))},
            {"frame_ms", apps::to_json<json>(apps::summarise(frame_ms_))}}}};
}

core::Expected<int> view_model(const Options& o) {
  const auto size = apps::parse_size(o.size);
  if (!size) return tl::unexpected(size.error());
  auto model = apps::load_model(o.model);
  if (!model) return tl::unexpected(model.error());
  if (auto good = model->scene->commit(); !good) return tl::unexpected(good.error());  // before a window opens
  std::optional<core::CameraPath> path;
  if (!o.path.empty()) {
    auto read = importers::read_path(o.path);
    if (read) read = importers::translated(*read, model->offset);
    if (!read) return tl::unexpected(read.error());
    path = std::move(*read);
  }
  auto window = apps::Window::open("sightline-view", *size, o.frames == 0);
  if (!window) return tl::unexpected(window.error());
  engine::EngineConfig config;
  config.draw = true;
  config.width = window->size()[0];
  config.height = window->size()[1];
  config.culler = o.culler;
  config.gpu_culler = o.gpu_culler;
  config.samples = o.samples;
  o.shown.apply(config);
  config.hidden_colour = kHiddenColour;
  config.context = &window->context();
  auto engine = engine::Engine::create(*model->scene, config);
  if (!engine) return tl::unexpected(engine.error());
  if (o.model.explain) apps::explain(engine->plan());
  return Viewer(o, *model, *window, *engine, path).run();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Opens a window to walk through a model in", "sightline-view");
  apps::describe(app,
                 "  sightline-view plant.rvm\n"
                 "  sightline-view a.rvm b.rvm --culler hybrid --size 1920x1080\n"
                 "  sightline-view plant.rvm --path flight.json --frames 300 --screenshot last.png --json -\n"
                 "Keys:\n" +
                     key_list());
  Options options;
  add_options(app, options);
  return apps::run(app, argc, argv, [&] { return view_model(options); });
}
