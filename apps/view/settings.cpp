#include "sightline/apps/view/settings.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

constexpr std::uintmax_t kMostSettingsBytes = 1u << 20;
constexpr int kDeepestNesting = 64;  // writing JSON takes stack for each level
constexpr int kSmallestWindow = 100, kLargestWindow = 1 << 14;

constexpr std::pair<const char*, bool Settings::*> kSwitches[] = {
    {"smooth", &Settings::smooth},
    {"panels", &Settings::panels},
    {"triad", &Settings::triad},
    {"depth_shading", &Settings::depth_shading},
    {"hatching", &Settings::hatching},
    {"lower-resolution", &Settings::lower},
    {"levels", &Settings::levels},
    {"recognise", &Settings::recognise},
    {"diagnostics", &Settings::diagnostics},
};

/// The object in a file; empty where there is no file.
core::Expected<Json> read_object(const fs::path& file) {
  std::error_code none;
  if (!fs::exists(file, none)) return Json::object();
  if (!fs::is_regular_file(file, none)) return core::fail(file.string() + ": expected a file");
  if (fs::file_size(file, none) > kMostSettingsBytes) return core::fail(file.string() + ": larger than settings are");
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return core::fail(file.string() + ": cannot be read");
  auto parsed = json::parse(text.str(), {.max_depth = kDeepestNesting});
  if (!parsed || !parsed->is_object()) return core::fail(file.string() + ": expected a JSON object");
  return std::move(*parsed);
}

std::optional<bool> flag_of(const Json& json) {
  return json.is_boolean() ? std::optional(json.get<bool>()) : std::nullopt;
}

std::optional<bool> light_of(const Json& json) {
  if (json == "light") return true;
  return json == "dark" ? std::optional(false) : std::nullopt;
}

/// The value of an enumeration that a text names.
template <class Value>
std::optional<Value> named(const Json& json, std::span<const char* const> names) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (json == names[i]) return Value(i);
  return std::nullopt;
}
std::optional<Units> units_of(const Json& json) {
  return named<Units>(json, kUnitsNames);
}
std::optional<SelectionLevel> level_of(const Json& json) {
  return named<SelectionLevel>(json, kLevelNames);
}

template <std::size_t kMost>
std::optional<std::vector<std::string>> texts_of(const Json& json) {
  const auto is_text = [](const Json& text) { return text.is_string(); };
  if (!json.is_array() || !std::all_of(json.begin(), json.end(), is_text)) return std::nullopt;
  auto texts = json.get<std::vector<std::string>>();
  texts.resize(std::min(texts.size(), kMost));
  return texts;
}

std::optional<std::array<int, 2>> window_size_of(const Json& json) {
  const auto fits = [](const Json& number) {
    return number.is_number_integer() && number >= kSmallestWindow && number <= kLargestWindow;
  };
  if (!json.is_array() || json.size() != 2 || !fits(json[0]) || !fits(json[1])) return std::nullopt;
  return std::array{json[0].get<int>(), json[1].get<int>()};
}

std::optional<std::string> folder_of(const Json& json) {
  if (!json.is_string()) return std::nullopt;
  auto folder = json.get<std::string>();
  return folder.empty() || fs::path(folder).is_absolute() ? std::optional(std::move(folder)) : std::nullopt;
}

/// Reads a panel's width.
std::optional<float> lines_of(const Json& json) {
  constexpr float kMostLines = 1000.0f;
  if (!json.is_number() || json < 0.0f || json > kMostLines) return std::nullopt;
  return json.get<float>();
}

std::optional<double> density_of(const Json& json) {
  if (!json.is_number() || !(json > 0.0) || json > Settings::kLargestDensity) return std::nullopt;
  return json.get<double>();
}

/// What an object says; keys whose values cannot be are in `bad`.
Settings settings_of(const Json& json, std::string& bad) {
  Settings settings;
  const auto take = [&](const char* key, auto& value, auto read) {
    const auto found = json.find(key);
    if (found == json.end()) return;
    if (auto good = read(*found))
      value = std::move(*good);
    else
      bad += (bad.empty() ? "" : ", ") + std::string(key);
  };
  for (const auto& [key, flag] : kSwitches) take(key, settings.*flag, flag_of);
  take("theme", settings.light, light_of);
  take("tree-width", settings.tree_width, lines_of);
  take("side-width", settings.side_width, lines_of);
  take("recent", settings.recent, texts_of<Settings::kMostRecent>);
  take("window", settings.window, window_size_of);
  take("cache", settings.cache, folder_of);
  take("units", settings.units, units_of);
  take("clicks-select", settings.level, level_of);
  take("density", settings.density, density_of);
  take("sets", settings.sets, texts_of<Settings::kMostSets>);
  return settings;
}

/// Files of another viewer stay below our own.
std::vector<std::string> merged(std::vector<std::string> ours, const std::vector<std::string>& theirs) {
  for (const std::string& file : theirs)
    if (std::find(ours.begin(), ours.end(), file) == ours.end()) ours.push_back(file);
  ours.resize(std::min(ours.size(), Settings::kMostRecent));
  return ours;
}

void put_changes(const Settings& before, const Settings& now, Json& json) {
  std::string bad;
  for (const auto& [key, flag] : kSwitches)
    if (now.*flag != before.*flag) json[key] = now.*flag;
  if (now.light != before.light) json["theme"] = now.light ? "light" : "dark";
  if (now.tree_width != before.tree_width) json["tree-width"] = now.tree_width;
  if (now.side_width != before.side_width) json["side-width"] = now.side_width;
  if (now.recent != before.recent) json["recent"] = merged(now.recent, settings_of(json, bad).recent);
  if (now.window != before.window && window_size_of(now.window)) json["window"] = now.window;
  if (now.cache != before.cache) json["cache"] = now.cache;
  if (now.units != before.units) json["units"] = kUnitsNames[int(now.units)];
  if (now.density != before.density) json["density"] = now.density;
  if (now.sets != before.sets) json["sets"] = now.sets;
  if (now.level != before.level) json["clicks-select"] = name_of(now.level);
}

}  // namespace

void Settings::add_recent(const std::string& file) {
  std::error_code none;
  const fs::path place = fs::absolute(file, none);
  std::string name = none ? file : place.lexically_normal().string();
  std::erase(recent, name);
  recent.insert(recent.begin(), std::move(name));
  recent.resize(std::min(recent.size(), kMostRecent));
}

SettingsFile::SettingsFile(fs::path file) : file_(std::move(file)) {
  const auto json = read_object(file_);
  if (!json) {
    damage_ = json.error().message;
    return;
  }
  std::string bad;
  kept_ = settings_of(*json, bad);
  if (!bad.empty()) damage_ = file_.string() + ": cannot use the value of " + bad;
}

fs::path SettingsFile::default_place() {
  const fs::path folder = core::platform::settings_folder();
  return folder.empty() ? fs::path() : folder / "sightline" / "view.json";
}

core::Expected<void> SettingsFile::keep(Settings settings) {
  const Settings before = std::exchange(kept_, settings);
  if (file_.empty() || settings == before) return {};
  Json json = read_object(file_).value_or(Json::object());
  const Json found = json;
  put_changes(before, settings, json);
  if (json == found) return {};
  if (std::error_code none; fs::create_directories(file_.parent_path(), none))
    fs::permissions(file_.parent_path(), fs::perms::owner_all, none);  // as the XDG base directory specification asks
  const std::string text = json.dump(1) + "\n";
  return core::write_file(file_, {std::as_bytes(std::span(text))});
}

}  // namespace sightline::apps
