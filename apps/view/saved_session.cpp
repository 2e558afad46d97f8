#include "sightline/apps/view/saved_session.h"

#include <fstream>
#include <sstream>
#include <utility>

#include "sightline/apps/common/output.h"
#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

constexpr std::uintmax_t kMostBytes = std::uintmax_t(64) << 20;
constexpr int kDeepest = 64;

/// Views as text are JSON.
Json json_of_views(const std::string& views) {
  return json::parse(views).value();
}

core::Expected<std::string> model_of(const Json& json, const char* key, const fs::path& folder) {
  if (!json.is_object() || !json.contains("path") || !json["path"].is_string())
    return core::fail(std::string("/") + key + ": expected objects with a \"path\"");
  const std::string path = json["path"].get<std::string>();
  std::error_code none;
  if (fs::exists(core::platform::path_of(path), none)) return path;
  if (json.contains("beside") && json["beside"].is_string()) {
    const fs::path beside = folder / core::platform::path_of(json["beside"].get<std::string>());
    if (fs::exists(beside, none)) return core::platform::name_of(beside.lexically_normal());
  }
  return core::fail(path + ": is no longer there");
}

Json json_of(const std::string& model, const fs::path& folder) {
  std::error_code none;
  const fs::path path = fs::absolute(core::platform::path_of(model), none).lexically_normal();
  return {{"path", core::platform::name_of(path)},
          {"beside", core::platform::name_of(path.lexically_relative(folder))}};
}

bool switch_of(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_boolean() && json[key].get<bool>();
}

core::Expected<SavedSession> session_of(const Json& json, const fs::path& folder) {
  if (!json.is_object() || !json.contains("sightline_session") || !json.contains("files") ||
      !json["files"].is_array() || json["files"].empty() || !json.contains("view"))
    return core::fail("expected a session with files and a view");
  SavedSession session;
  for (const Json& file : json["files"]) {
    auto model = model_of(file, "files", folder);
    if (!model) return tl::unexpected(model.error());
    session.files.push_back(std::move(*model));
  }
  session.y_up = switch_of(json, "y_up");
  session.reading = {switch_of(json, "recognise"), switch_of(json, "lenient")};
  if (json.contains("older")) session.older = model_of(json["older"], "older", folder).value_or("");
  auto now = parse_viewpoints(json["view"].dump(), "/view");
  if (!now) return tl::unexpected(now.error());
  session.now = std::move(now->front());
  if (!json.contains("views")) return session;
  auto views = parse_viewpoints(json["views"].dump(), "/views");
  if (!views) return tl::unexpected(views.error());
  session.views = std::move(*views);
  if (json.contains("current") && json["current"].is_number_integer()) session.current = json["current"].get<int>();
  return session;
}

}  // namespace

core::Expected<void> write_session(const SavedSession& session, const fs::path& file) {
  std::error_code none;
  const fs::path folder = fs::absolute(file, none).parent_path();
  Json json{{"sightline_session", 1},
            {"files", Json::array()},
            {"y_up", session.y_up},
            {"recognise", session.reading.recognise},
            {"lenient", session.reading.lenient}};
  for (const std::string& model : session.files) json["files"].push_back(json_of(model, folder));
  if (!session.older.empty()) json["older"] = json_of(session.older, folder);
  json["view"] = json_of_views(format_viewpoint(session.now));
  if (!session.views.empty()) {
    json["views"] = json_of_views(format_viewpoints(session.views));
    json["current"] = session.current;
  }
  const std::string text = to_text(json);
  return core::write_file(file, {std::as_bytes(std::span(text))});
}

core::Expected<SavedSession> read_session(const fs::path& file) {
  const auto failed = [&](const std::string& why) { return core::fail(core::platform::name_of(file) + ": " + why); };
  std::error_code error;
  if (const auto size = fs::file_size(file, error); error || size > kMostBytes)
    return failed(error ? "cannot be read: " + error.message() : "larger than sessions are");
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return failed("cannot be read");
  const auto json = json::parse(text.str(), {.max_depth = kDeepest});
  if (!json) return failed("byte " + std::to_string(json.error().byte) + ": expected JSON: " + json.error().reason);
  auto session = session_of(*json, fs::absolute(file, error).parent_path());
  return session ? session : failed(session.error().message);
}

FileFormat session_format() {
  return {"Session", {".sightline"}};
}

}  // namespace sightline::apps
