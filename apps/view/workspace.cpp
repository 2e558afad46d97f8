#include "sightline/apps/view/workspace.h"

#include <algorithm>
#include <filesystem>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/view/panels.h"
#include "sightline/core/internal/platform/files.h"

namespace sightline::apps {
namespace {

/// What the settings and the command line say.
Shown shown_at_first(const ViewerOptions& options, const Settings& settings) {
  Shown shown{settings};
  const engine::Looks looks = options.shown.all_looks();
  const bool asked = options.shown.depth_shading || options.shown.edge_lines || !options.remembers();
  shown.light = options.theme == "light";
  shown.panels = options.panels && options.frames == 0;
  shown.smooth = options.smooth && (options.script.empty() || !options.settings.empty());
  shown.depth_shading = looks.depth_shading.any() && (settings.depth_shading || asked);
  shown.hatching = looks.hatching.any() || (settings.hatching && options.remembers());
  shown.levels = options.shown.lod_error > 0.0 || (settings.levels && options.remembers());
  shown.recognise = options.model.import.recognise;
  return shown;
}

}  // namespace

const char* name_of(Dialog dialog) {
  constexpr const char* kNames[] = {"none",         "help",          "driver",       "open",
                                    "compare",      "quit",          "image",        "path",
                                    "read-path",    "save-path",     "frames",       "views-load",
                                    "views-save",   "save-and-quit", "export-model", "export-selection",
                                    "session-save", "append"};
  return kNames[int(dialog)];
}

const char* name_of(Tool tool) {
  constexpr const char* kNames[] = {"select", "measure", "section", "mark"};
  return kNames[int(tool)];
}

Workspace::Workspace(const ViewerOptions& asked_for, Window& in, Gui widgets, const Settings& settings)
    : options(asked_for),
      window(in),
      gui(std::move(widgets)),
      shown(shown_at_first(options, settings)),
      opening(options.model, window.context().capabilities().software ? options.default_budget_ms : 0.0),
      image(options, window, gui.scale()),
      gestures(*this),
      file_states(&glfwGetTime) {
  shown.window = window.screen_size();
  if (options.remembers()) thumbnails = Thumbnails(Thumbnails::default_place());
}

Part Workspace::viewport() const {
  const std::array<int, 2> size = window.size();
  if (!shown.panels) return {0, 0, size[0], size[1]};
  const Margins m = margins(shown);
  return {m.left, m.bottom, std::max(1, size[0] - m.left - m.right), std::max(1, size[1] - m.top - m.bottom)};
}

/// RVM files are of plants, however small the part is.
LengthFormat Workspace::lengths() const {
  if (!session) return length_format(shown.units, 1.0, false);
  const core::AabbD& bounds = session->bounds().bounds;
  const core::dvec3 size = bounds.empty() ? core::dvec3(1.0) : bounds.size();
  const bool plant = std::any_of(session->files.begin(), session->files.end(), [](const std::string& file) {
    const std::string extension = std::filesystem::path(file).extension().string();
    return extension == ".rvm" || extension == ".RVM";
  });
  return length_format(shown.units, std::max({size.x, size.y, size.z}), plant);
}

void Workspace::open(const std::vector<std::string>& files, bool lenient) {
  returning.reset();
  if (files.size() == 1 && session_format().has(core::platform::path_of(files[0]))) {
    auto read = read_session(core::platform::path_of(files[0]));
    if (!read) return messages.tell(read.error().message, true);
    read->reading.lenient |= lenient;
    read->file = files[0];
    return open(std::move(*read));
  }
  open_models(files, lenient);
}

void Workspace::open(SavedSession saved) {
  if (opening.y_is_up(nullptr) != saved.y_up) opening.toggle_up(nullptr);
  shown.recognise = saved.reading.recognise;
  returning = std::move(saved);
  open_models(returning->files, returning->reading.lenient);
}

/// A session that they are of is shown as it says.
void Workspace::open_damaged() {
  const std::vector<std::string> files = damaged.files;
  open_models(files, true);
}

void Workspace::read_again() {
  returning.reset();
  if (session) open_models(session->files, session->reading.lenient);
}

std::optional<SavedSession> Workspace::to_save() const {
  if (!session) return std::nullopt;
  SavedSession saved{session->files, opening.y_is_up(nullptr), session->reading, session->viewpoint(),
                     views.all(),    views.current_index()};
  const auto absolute = [](const std::string& file) {
    std::error_code none;
    return core::platform::name_of(std::filesystem::absolute(core::platform::path_of(file), none).lexically_normal());
  };
  for (std::string& file : saved.files) file = absolute(file);
  if (const ChangeList* changes = session->changes()) saved.older = absolute(changes->file());
  return saved;
}

void Workspace::open_models(const std::vector<std::string>& files, bool lenient) {
  damaged = {};
  opening.open(files, image.config(shown), {shown.recognise, lenient}, !session);
  if (shown.dialog == Dialog::kOpen) shown.dialog = Dialog::kNone;
  messages.tell("reading " + name_of_files(files));
}

Done Workspace::apply_styles() {
  pace.redraw();
  return session ? image.apply_styles(*session, shown) : Done();
}

Done Workspace::set_motion_error(double pixels) {
  if (!(pixels >= 0.0)) return core::fail("lod-error: expected 0 or more pixels");
  shown.levels = pixels > 0.0;
  if (shown.levels) image.motion_error = pixels;
  return session ? session->image.set_motion_error(pixels) : Done();
}

Done Workspace::show_own_meshes() {
  return session ? session->exchange_meshes([&](core::Scene& scene) {
    const bool finished = finer.finish(scene);
    return finer.coarse_again(scene) || finished;
  })
                 : Done();
}

Done Workspace::scene_is_free() const {
  if (opening.comparing()) return core::fail("wait until the older revision is read, or cancel that");
  if (exports.model()) return core::fail("wait until the model is written, or cancel that");
  return {};
}

}  // namespace sightline::apps
