#include "sightline/apps/view/exporting.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <imgui.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/view/obstacles.h"
#include "sightline/apps/view/widgets.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps {
namespace {

using Done = core::Expected<void>;

constexpr double kFps = 25.0;
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

Export::Options options_of(const Viewer& viewer, const std::array<int, 2>& size) {
  return {size, viewer.shown.smooth};
}

/// Tiles and frames are of one revision.
Done without_slider(Viewer& viewer) {
  if (!viewer.session()->slider()) return {};
  return core::fail("end the slider of the comparison first: Esc");
}

Done begin(Viewer& viewer, core::Expected<std::unique_ptr<Export>> made) {
  if (!made) return tl::unexpected(made.error());
  viewer.begin_export(std::move(*made));
  return {};
}

/// Answers of dialogs that are no files; they stay from time to time.
struct Asked {
  std::array<int, 2> image_size = kSizes[0].second, video_size = {1920, 1080};
  double fps = kFps;
};
Asked asked;

void size_fields(Viewer& viewer, std::array<int, 2>& size) {
  if (ImGui::Button("Window")) size = viewer.session()->size();
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

}  // namespace

Done write_image(Viewer& viewer, const std::string& argument) {
  std::string file = argument;
  const auto word = take_last_word(file, looks_like_size);
  if (!word) return viewer.write_screenshot(file);
  const auto size = parse_size(*word);
  if (!size) return tl::unexpected(size.error());
  if (auto good = without_slider(viewer); !good) return good;
  if (file.empty()) file = free_name("screenshot", ".png");
  return begin(viewer, Export::image(*viewer.session(), options_of(viewer, *size), file));
}

Done play_path(Viewer& viewer, const std::string& file) {
  PathPlayer& player = viewer.player();
  if (!file.empty()) {
    auto path = importers::read_path(file);
    if (path) path = importers::translated(*path, viewer.session()->offset());
    if (!path) return tl::unexpected(path.error());
    player.set_path(std::move(*path));
  } else if (player.playing()) {
    return player.stop(), Done();
  }
  if (!player.path()) return core::fail("record a camera path first, or name a file of one");
  Session& session = *viewer.session();
  viewer.set_walking(false);
  session.remember();
  session.camera().set_orthographic(false);
  session.camera().set_planes(player.path()->near, player.path()->far);
  player.play();
  viewer.tell("playing; Esc or any motion stops");
  return {};
}

Done save_path(Viewer& viewer, const std::string& file) {
  if (const char* why = without_path(viewer)) return core::fail(why);
  if (file.empty()) return viewer.shown.dialog = Dialog::kSavePath, Done();
  const auto path = importers::translated(*viewer.player().path(), -viewer.session()->offset());
  if (!path) return tl::unexpected(path.error());
  if (auto done = importers::write_path(file, *path); !done) return done;
  viewer.tell("path: " + file);
  return {};
}

Done set_path_speed(Viewer& viewer, const std::string& factor) {
  const auto speed = parse_finite(factor);
  if (!speed) return tl::unexpected(speed.error());
  if (!(*speed >= PathPlayer::kSlowest && *speed <= PathPlayer::kFastest))
    return core::fail("path-speed: expected a number between 0.01 and 100, found \"" + factor + "\"");
  viewer.player().speed = *speed;
  return {};
}

Done write_frames(Viewer& viewer, const std::string& argument) {
  std::string folder = argument;
  const auto size_word = take_last_word(folder, looks_like_size), fps_word = take_last_word(folder, looks_like_number);
  const auto size = size_word ? parse_size(*size_word) : core::Expected<std::array<int, 2>>(viewer.session()->size());
  if (!size) return tl::unexpected(size.error());
  if (folder.empty()) return core::fail("write-frames: expected FOLDER [FPS] [WIDTHxHEIGHT]");
  const auto& path = viewer.player().path();
  if (!path) return core::fail("record or play a camera path first");
  if (auto good = without_slider(viewer); !good) return good;
  viewer.player().stop();
  return begin(viewer, Export::frames(*viewer.session(), options_of(viewer, *size), *path,
                                      fps_word ? *parse_finite(*fps_word) : kFps, folder));
}

void image_options(Viewer& viewer) {
  size_fields(viewer, asked.image_size);
  wrapped_text("up to 16384x16384, drawn in tiles");
}

Done write_sized_image(Viewer& viewer, const std::string& file) {
  return write_image(viewer, file + " " + size_text(asked.image_size));
}

Done write_sized_frames(Viewer& viewer, const std::string& folder) {
  return write_frames(viewer, folder + " " + std::to_string(asked.fps) + " " + size_text(asked.video_size));
}

void path_window(Viewer& viewer) {
  PathPlayer& player = viewer.player();
  const bool has_path = player.path().has_value();
  begin_dialog(viewer, "Camera path", 34.0f);
  wrapped_text(has_path ? "The path that was played or recorded last:"
                        : "There is no path yet: record one (R), or play one of a file.");
  ImGui::BeginDisabled(!has_path);
  if (ImGui::Button(player.playing() ? "Stop" : "Play")) viewer.tell_outcome(play_path(viewer, ""));
  ImGui::SameLine();
  if (ImGui::Button("Save…")) viewer.shown.dialog = Dialog::kSavePath;
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (ImGui::Button("Play a file…")) viewer.shown.dialog = Dialog::kReadPath;
  ImGui::Checkbox("again and again", &player.loop);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(6.0f * ImGui::GetFontSize());
  float speed = float(player.speed);
  if (ImGui::SliderFloat("speed", &speed, 0.1f, 10.0f, "%.2f", ImGuiSliderFlags_Logarithmic)) player.speed = speed;
  ImGui::Separator();
  ImGui::BeginDisabled(!has_path);
  ImGui::TextUnformatted("Frames of a video, in a folder:");
  size_fields(viewer, asked.video_size);
  ImGui::SetNextItemWidth(6.0f * ImGui::GetFontSize());
  ImGui::InputDouble("frames per second", &asked.fps, 0.0, 0.0, "%g");
  ImGui::SameLine();
  if (ImGui::Button("Write frames…")) viewer.shown.dialog = Dialog::kFrames;
  ImGui::EndDisabled();
  ImGui::End();
}

void exporting_window(Viewer& viewer) {
  constexpr const char* kName = "Writing";
  if (!viewer.exporting()) return;
  const Export& running = *viewer.exporting();
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
  if (ImGui::Button("Cancel")) viewer.cancel_export();
  ImGui::EndPopup();
}

}  // namespace sightline::apps
