#include "sightline/apps/regress/task_result.h"

#include "sightline/apps/common/output.h"
#include "sightline/core/internal/atomic_file.h"

namespace sightline::apps {

namespace fs = std::filesystem;
using Json = json::Value;

std::string number(double value, const char* format) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string_view name_of(Status status) {
  constexpr std::string_view kNames[] = {"passed", "failed", "error", "accepted", "missing"};
  return kNames[std::size_t(status)];
}

std::string reason(const std::optional<TaskResult>& result, const Limits& limits) {
  if (!result) return "no result: nobody has drawn it";
  if (!result->error.empty()) return result->error;
  if (!result->unlike.empty()) return result->unlike;
  std::string text;
  const auto check = [&](const char* what, double value, const auto& limit, const char* format = "%.4g") {
    if (!limit || value <= double(*limit)) return;
    text += (text.empty() ? "" : ", ") + std::string(what) + " " + number(value, format) + " above " +
            number(double(*limit), format);
  };
  check("max", result->difference.max, limits.max);
  check("mean", result->difference.mean, limits.mean);
  check("FLIP", result->flip, limits.flip);
  check("pixels of another item", double(result->wrong_ids), limits.ids, "%.0f");
  return text;
}

Status judge(const std::optional<TaskResult>& result, const Limits& limits) {
  if (!result) return Status::kMissing;
  if (!result->error.empty()) return Status::kError;
  return reason(result, limits).empty() ? Status::kPassed : Status::kFailed;
}

std::optional<TaskResult> ResultFolder::read(const Task& task) const {
  const auto text = read_bytes(result(task));
  if (!text) return std::nullopt;
  const Json in = json::parse(*text).value_or(Json());
  if (!in.is_object()) return std::nullopt;
  try {
    TaskResult r;
    in.at("key").get_to(r.key);
    in.at("files").get_to(r.files_key);
    in.at("error").get_to(r.error);
    in.at("unlike").get_to(r.unlike);
    in.at("max").get_to(r.difference.max);
    in.at("mean").get_to(r.difference.mean);
    in.at("pixels").get_to(r.difference.pixels);
    in.at("flip").get_to(r.flip);
    in.at("wrong_ids").get_to(r.wrong_ids);
    in.at("renderer").get_to(r.renderer);
    in.at("seconds").get_to(r.seconds);
    return r.key == task.key ? std::optional(std::move(r)) : std::nullopt;
  } catch (const json::TypeError&) {
    return std::nullopt;
  }
}

core::Expected<void> ResultFolder::write(const Task& task, const TaskResult& r) const {
  if (auto done = make_place(task); !done) return done;
  const Json out = {{"task", task.name},
                    {"key", r.key},
                    {"files", r.files_key},
                    {"error", r.error},
                    {"unlike", r.unlike},
                    {"max", r.difference.max},
                    {"mean", r.difference.mean},
                    {"pixels", r.difference.pixels},
                    {"flip", r.flip},
                    {"wrong_ids", r.wrong_ids},
                    {"renderer", r.renderer},
                    {"seconds", r.seconds}};
  return write_text(result(task).string(), to_text(json::sorted(out)));
}

core::Expected<void> ResultFolder::remove(const Task& task) const {
  std::error_code error;
  fs::remove(result(task), error);
  if (error && error != std::errc::not_a_directory) return core::fail(result(task).string() + ": " + error.message());
  return {};
}

core::Expected<void> ResultFolder::make_place(const Task& task) const {
  return make_directory((folder_ / task.name).string());
}

core::Expected<bool> ResultFolder::take(const Task& task, const ResultFolder& from) const {
  if (!from.read(task)) return false;
  std::error_code none;
  if (fs::equivalent(from.folder_, folder_, none)) return true;
  if (auto done = remove(task); !done) return tl::unexpected(done.error());
  for (const auto& file : {&ResultFolder::image, &ResultFolder::ids})
    if (fs::exists((from.*file)(task), none))
      if (auto done = copy_whole((from.*file)(task), (this->*file)(task)); !done) return tl::unexpected(done.error());
  if (auto done = copy_whole(from.result(task), result(task)); !done) return tl::unexpected(done.error());
  return true;
}

core::Expected<void> copy_whole(const fs::path& from, const fs::path& to) {
  const auto bytes = read_bytes(from);
  if (!bytes) return tl::unexpected(bytes.error());
  if (auto made = make_directory(to.parent_path().string()); !made) return made;
  return core::write_file(to, {std::as_bytes(std::span(*bytes))});
}

}  // namespace sightline::apps
