#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <utility>

#include <imgui.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/blank.h"
#include "sightline/apps/common/colour_file.h"
#include "sightline/apps/common/html_page.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/view_options.h"
#include "sightline/apps/common/write_model.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/image_marks.h"
#include "sightline/apps/view/needs.h"
#include "sightline/apps/view/widgets.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/view_json.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

constexpr double kFps = 25.0;
constexpr float kChoiceLines = 12.0f;  // in lines of text
constexpr std::array kSizes{std::pair{"4K", std::array{3840, 2160}}, std::pair{"8K", std::array{7680, 4320}},
                            std::pair{"16K", std::array{15360, 8640}}};

/// The last word of a text, if `wanted` holds of it; it is then taken away.
std::optional<std::string> take_last_word(std::string& text, bool (*wanted)(const std::string&)) {
  const std::size_t space = text.find_last_of(' ');
  const std::string word = space == std::string::npos ? text : text.substr(space + 1);
  if (!wanted(word)) return std::nullopt;
  text = space == std::string::npos ? "" : text.substr(0, text.find_last_not_of(' ', space) + 1);
  return word;
}

bool looks_like_size(const std::string& word) {
  const std::size_t x = word.find('x');
  const auto digits = [](const std::string& text) {
    return !text.empty() && text.find_first_not_of("-.0123456789") == std::string::npos;
  };
  return x != std::string::npos && digits(word.substr(0, x)) && digits(word.substr(x + 1));
}

bool looks_like_number(const std::string& word) {
  return parse_finite(word).has_value();
}

/// Tiles and frames are of one revision.
Done without_slider(const Session& session) {
  if (!session.slider.at()) return {};
  return core::fail("end the slider of the comparison first: Esc");
}

Done begin_export(core::Expected<std::unique_ptr<Export>> made, Exports& exports) {
  if (!made) return tl::unexpected(made.error());
  exports.begin(std::move(*made));
  return {};
}

/// Answers of dialogs that are no files; they stay from time to time.
struct Asked {
  std::array<int, 2> image_size = kSizes[0].second, video_size = {1920, 1080};
  double fps = kFps;
};
Asked asked;

void size_fields(const Session& session, std::array<int, 2>& size) {
  if (ImGui::Button("Window")) size = session.image.size();
  ImGui::SameLine();
  for (const auto& [name, preset] : kSizes) {
    if (ImGui::Button(name)) size = preset;
    ImGui::SameLine();
  }
  ImGui::SetNextItemWidth(10.0f * ImGui::GetFontSize());
  ImGui::InputInt2("pixels", size.data());
}

std::string size_text(const std::array<int, 2>& size) {
  return std::to_string(size[0]) + "x" + std::to_string(size[1]);
}

/// Writes a path in the model's own frame.
Done write_path(const std::string& file, const Session& session, const core::CameraPath& seen, Messages& messages) {
  const auto path = importers::translated(seen, -session.offset());
  if (!path) return tl::unexpected(path.error());
  if (auto done = importers::write_path(file, *path); !done) return done;
  messages.tell("path: " + file);
  return {};
}

Done begin_model_export(Workspace& work, core::Expected<ModelExport::Job> job) {
  if (!job) return tl::unexpected(job.error());
  if (auto free = work.scene_is_free(); !free) return free;
  if (auto done = work.show_own_meshes(); !done) return done;
  work.exports.begin(std::move(*job), work.messages);
  return {};
}

void tell_of_export(const std::string& what) {
  wrapped_text(what);
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  wrapped_text(
      ".rvm and .slc keep primitives and all layers; the others get triangles, without obstruction and insulation "
      "volumes. .slc, .glb and .gltf keep attributes.");
  ImGui::PopStyleColor();
}

}  // namespace

namespace {

core::Expected<Export::Options> export_options(const Workspace& work, const std::array<int, 2>& size) {
  Export::Options options{size, work.shown.smooth, image_marks(work)};
  if (work.shown.image_background.empty()) return options;
  return DrawnOptions::parse_background(work.shown.image_background).map([&](const auto& background) {
    options.background = background;
    return options;
  });
}

}  // namespace

Done image_background(Workspace& work, const std::string& colours) {
  const bool as_shown = colours.empty() || colours == "shown";
  if (auto good = DrawnOptions::parse_background(as_shown ? "white" : colours); !good)
    return core::fail("image-background: " + good.error().message);
  work.shown.image_background = as_shown ? "" : colours;
  return {};
}

Done write_image(Workspace& work, const std::string& argument) {
  std::string file = argument;
  const auto word = take_last_word(file, looks_like_size);
  if (!word && work.shown.image_background.empty()) return write_screenshot(work, file);
  const auto size = word ? parse_size(*word) : core::Expected<std::array<int, 2>>(work.session->image.size());
  if (!size) return tl::unexpected(size.error());
  if (auto good = without_slider(*work.session); !good) return good;
  if (file.empty()) file = free_name("screenshot", ".png");
  const auto options = export_options(work, *size);
  if (!options) return tl::unexpected(options.error());
  return begin_export(Export::image(*work.session, *options, file), work.exports);
}

Done write_screenshot(Workspace& work, const std::string& file) {
  Session& session = *work.session;
  const std::string name = file.empty() ? free_name("screenshot", ".png") : file;
  if (const auto good = parse_image_name(name); !good) return tl::unexpected(good.error());
  const auto view = session.image.view();
  if (!view) return tl::unexpected(view.error());
  if (auto kept = check_sections(*view, session.engine.snapshot().bounds(), session.offset()); !kept) return kept;
  auto image = session.image.read(work.shown.smooth);
  if (!image) return tl::unexpected(image.error());
  if (const Painter marks = image_marks(work)) marks(*view, {image->width, image->height}).paint(*image);
  if (auto done = write_colours(*image, name); !done) return done;
  warn_if_blank(session.engine, session.image.visible(), name);
  std::error_code none;
  const auto place = std::filesystem::absolute(core::platform::path_of(name), none);
  work.messages.tell("image: " + core::platform::name_of(place));
  return {};
}

Done toggle_recording(Workspace& work, const std::string&) {
  Session& session = *work.session;
  if (!work.recorder) {
    work.recorder.emplace();
    session.image.changed();  // its first place
    return {};
  }
  const auto seen = work.recorder->path(session.camera.near(), session.camera.far());
  work.recorder.reset();
  if (!seen) return tl::unexpected(seen.error());
  work.player.set_path(*seen);
  return write_path(work.options.save_path, session, *seen, work.messages);
}

Done play_path(const std::string& file, Session& session, PathPlayer& player, Gestures& gestures, Messages& messages) {
  if (!file.empty()) {
    auto path = importers::read_path(file);
    if (path) path = importers::translated(*path, session.offset());
    if (!path) return tl::unexpected(path.error());
    player.set_path(std::move(*path));
  } else if (player.playing()) {
    return player.stop(), Done();
  }
  if (!player.path()) return core::fail(needs::kPath.missing);
  gestures.set_walking(false);
  session.camera.remember();
  session.camera.set_orthographic(false);
  session.camera.set_planes(player.path()->near, player.path()->far);
  player.play();
  messages.tell("playing; Esc or any motion stops");
  return {};
}

Done save_path(const std::string& file, Session& session, PathPlayer& player, Shown& shown, Messages& messages) {
  if (!player.path()) return core::fail(needs::kPath.missing);
  if (file.empty()) return shown.dialog = Dialog::kSavePath, Done();
  return write_path(file, session, *player.path(), messages);
}

Done set_path_speed(const std::string& factor, PathPlayer& player) {
  const auto speed = parse_finite(factor);
  if (!speed) return tl::unexpected(speed.error());
  if (!(*speed >= PathPlayer::kSlowest && *speed <= PathPlayer::kFastest))
    return core::fail("path-speed: expected a number between 0.01 and 100, found \"" + factor + "\"");
  player.speed = *speed;
  return {};
}

Done write_frames(Workspace& work, const std::string& argument) {
  Session& session = *work.session;
  std::string folder = argument;
  const auto size_word = take_last_word(folder, looks_like_size), fps_word = take_last_word(folder, looks_like_number);
  const auto size = size_word ? parse_size(*size_word) : core::Expected<std::array<int, 2>>(session.image.size());
  if (!size) return tl::unexpected(size.error());
  if (folder.empty()) return core::fail("write-frames: expected FOLDER [FPS] [WIDTHxHEIGHT]");
  const auto& path = work.player.path();
  if (!path) return core::fail("record or play a camera path first");
  if (auto good = without_slider(session); !good) return good;
  work.player.stop();
  const auto options = export_options(work, *size);
  if (!options) return tl::unexpected(options.error());
  return begin_export(Export::frames(session, *options, *path, fps_word ? *parse_finite(*fps_word) : kFps, folder),
                      work.exports);
}

namespace {

/// What is behind everything in the image: as shown, or of a colour, or nothing.
void background_choice(std::string& chosen) {
  constexpr std::pair<const char*, const char*> kChoices[] = {
      {"", "as shown"}, {"white", "white"}, {"black", "black"}, {"transparent", "transparent (PNG)"}};
  const auto known = std::find_if(std::begin(kChoices), std::end(kChoices),
                                  [&](const auto& choice) { return chosen == choice.first; });
  const std::string shown = known == std::end(kChoices) ? "a colour" : known->second;
  ImGui::SetNextItemWidth(kChoiceLines * ImGui::GetFontSize());
  if (ImGui::BeginCombo("background", shown.c_str())) {
    for (const auto& [value, words] : kChoices)
      if (ImGui::Selectable(words, chosen == value)) chosen = value;
    ImGui::EndCombo();
  }
  core::vec3 colour(1.0f);
  if (const auto parsed =
          chosen.empty() ? DrawnOptions::parse_background("white") : DrawnOptions::parse_background(chosen))
    colour = parsed->colours.top;
  ImGui::SameLine();
  if (ImGui::ColorEdit3("##colour", &colour.x, ImGuiColorEditFlags_NoInputs)) chosen = hex_of(colour).substr(1);
}

}  // namespace

void image_options(Workspace& work) {
  size_fields(*work.session, asked.image_size);
  background_choice(work.shown.image_background);
  ImGui::Checkbox("with marks", &work.shown.image_marks);
  ImGui::SameLine();
  wrapped_text("up to 16384x16384, drawn in tiles");
}

Done write_sized_image(Workspace& work, const std::string& file) {
  return write_image(work, file + " " + size_text(asked.image_size));
}

Done write_sized_frames(Workspace& work, const std::string& folder) {
  return write_frames(work, folder + " " + std::to_string(asked.fps) + " " + size_text(asked.video_size));
}

void path_window(Workspace& work) {
  PathPlayer& player = work.player;
  const bool has_path = player.path().has_value();
  begin_dialog(work, "Camera path", 34.0f);
  wrapped_text(has_path ? "The path that was played or recorded last:"
                        : "There is no path yet: record one (R), or play one of a file.");
  ImGui::BeginDisabled(!has_path);
  if (ImGui::Button(player.playing() ? "Stop" : "Play")) work.messages.tell_outcome(with<play_path>(work, ""));
  ImGui::SameLine();
  if (ImGui::Button("Save…")) work.shown.dialog = Dialog::kSavePath;
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (ImGui::Button("Play a file…")) work.shown.dialog = Dialog::kReadPath;
  ImGui::Checkbox("again and again", &player.loop);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(6.0f * ImGui::GetFontSize());
  float speed = float(player.speed);
  if (ImGui::SliderFloat("speed", &speed, 0.1f, 10.0f, "%.2f", ImGuiSliderFlags_Logarithmic)) player.speed = speed;
  ImGui::Separator();
  ImGui::BeginDisabled(!has_path);
  ImGui::TextUnformatted("Frames of a video, in a folder:");
  size_fields(*work.session, asked.video_size);
  ImGui::SetNextItemWidth(6.0f * ImGui::GetFontSize());
  ImGui::InputDouble("frames per second", &asked.fps, 0.0, 0.0, "%g");
  ImGui::SameLine();
  if (ImGui::Button("Write frames…")) work.shown.dialog = Dialog::kFrames;
  ImGui::EndDisabled();
  ImGui::End();
}

void exporting_window(Exports& exports) {
  constexpr const char* kName = "Writing";
  if (!exports.image()) return;
  const Export& running = *exports.image();
  if (!ImGui::IsPopupOpen(kName)) ImGui::OpenPopup(kName);  // nothing else takes clicks and keys meanwhile
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * screen.x, 0.5f * screen.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(30.0f * ImGui::GetFontSize(), 0.95f * screen.x), 0.0f});
  if (!ImGui::BeginPopupModal(kName, nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings)) return;
  std::string words = running.target() + ", " + size_text(running.size());
  if (running.count() > 1)
    words += ", frame " + std::to_string(running.frame() + 1) + " of " + std::to_string(running.count());
  ImGui::TextWrapped("%s", words.c_str());
  ImGui::ProgressBar(float(running.progress()));
  if (ImGui::Button("Cancel")) exports.cancel_image();
  ImGui::EndPopup();
}

Done export_model(Workspace& work, const std::string& file) {
  if (file.empty()) return work.shown.dialog = Dialog::kExportModel, Done();
  return begin_model_export(work, ModelExport::model(*work.session, file));
}

Done export_selection(Workspace& work, const std::string& file) {
  if (const char* why = missing(needs::kSelection, work)) return core::fail(why);
  if (file.empty()) return work.shown.dialog = Dialog::kExportSelection, Done();
  return begin_model_export(work, ModelExport::selection(*work.session, file));
}

void export_model_options(Workspace&) {
  tell_of_export("All of the model is written, with what is hidden.");
}

void export_selection_options(Workspace& work) {
  const std::size_t count = work.session ? work.session->document.selection().size() : 0;
  tell_of_export(grouped(std::int64_t(count)) + (count == 1 ? " selected item is" : " selected items are") +
                 " written, with the groups above.");
}

std::string export_name(const Workspace& work, const char* stem) {
  const std::string extension = work.files().empty() ? "" : importers::lower_case_extension(work.files().front());
  return std::string(stem) + (check_output("x" + extension, {}) ? extension : ".glb");
}

}  // namespace sightline::apps
