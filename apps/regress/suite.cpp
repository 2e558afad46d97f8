#include "sightline/apps/regress/suite.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "sightline/apps/common/arguments.h"
#include "sightline/core/internal/hash.h"
#include "sightline/importers/internal/json_text.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

constexpr std::uintmax_t kMostBytes = 64u << 20;
constexpr int kDeepest = 64;
constexpr int kMostFrames = 100'000;  // of one path

core::Expected<std::string> read_text(const fs::path& file) {
  std::error_code none;
  if (fs::is_directory(file, none)) return core::fail(file.string() + ": is a folder");
  if (fs::file_size(file, none) > kMostBytes && !none) return core::fail(file.string() + ": larger than 64 MiB");
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return core::fail(file.string() + ": cannot be read");
  return text.str();
}

/// FNV-1a of 64 bits, as 16 hexadecimal digits: keys tell tasks apart, they keep nobody out.
std::string hash_of(std::string_view text) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", (unsigned long long)core::fnv1a(text));
  return digits;
}

bool is_name(const std::string& text) {
  return !text.empty() && text.size() <= 100 && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_';
  });
}

/// What views take from their model, and models from the suite.
struct Settings {
  std::array<int, 2> size{640, 360};
  int samples = 1;
  bool standard_looks = false;
  Limits limits;
};

/// A value of the suite and where it stands, for errors.
struct Place {
  const Json& value;
  std::string pointer;

  tl::unexpected<core::Error> expected(const std::string& what) const {
    return core::fail(pointer + ": expected " + what + ", found " + importers::describe(value));
  }
  bool has(const char* key) const { return value.contains(key); }
  Place at(const std::string& key) const { return {value.at(key), pointer + "/" + key}; }
  Place at(std::size_t index) const { return {value.at(index), pointer + "/" + std::to_string(index)}; }
};

/// A misspelt limit must not pass for none.
core::Expected<void> check_keys(const Place& at, const std::set<std::string>& known) {
  if (!at.value.is_object()) return at.expected("an object");
  for (const auto& [key, value] : at.value.items())
    if (!known.contains(key)) {
      std::string names;
      for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
      return core::fail(at.pointer + "/" + key + ": unknown; expected " + names);
    }
  return {};
}

core::Expected<std::string> text_at(const Place& at) {
  if (!at.value.is_string() || at.value.string().empty()) return at.expected("a text");
  return at.value.get<std::string>();
}

core::Expected<int> count_at(const Place& at, int least, int most) {
  if (!at.value.is_number_integer() || at.value < least || at.value > most)
    return at.expected("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  return at.value.get<int>();
}

core::Expected<std::string> name_at(const Place& at) {
  if (!at.has("name")) return core::fail(at.pointer + ": expected a \"name\"");
  auto name = text_at(at.at("name"));
  if (name && !is_name(*name)) return at.at("name").expected("at most 100 letters, digits, - and _");
  return name;
}

core::Expected<void> read_limits(const Place& at, Limits& limits) {
  if (auto done = check_keys(at, {"max", "mean", "flip", "ids"}); !done) return done;
  const auto read = [&](const char* key, double most, auto& limit) -> core::Expected<void> {
    if (!at.has(key)) return {};
    const Place place = at.at(key);
    limit.reset();
    if (place.value.is_null()) return {};  // none here, whatever stands above
    if (!place.value.is_number() || !(place.value >= 0.0 && place.value <= most))
      return place.expected("null or a number from 0 to " + std::to_string(std::llround(most)));
    limit = place.value.get<typename std::decay_t<decltype(limit)>::value_type>();
    return {};
  };
  auto done = read("max", 255.0, limits.max);
  if (done) done = read("mean", 255.0, limits.mean);
  if (done) done = read("flip", 1.0, limits.flip);
  if (done && at.has("ids") && at.value["ids"].is_number_float()) return at.at("ids").expected("a whole number");
  if (done) done = read("ids", 16384.0 * 16384.0, limits.ids);
  return done;
}

core::Expected<void> read_settings(const Place& at, Settings& settings) {
  if (at.has("size")) {
    const auto text = text_at(at.at("size"));
    if (!text) return tl::unexpected(text.error());
    const auto size = parse_size(*text);
    if (!size) return core::fail(at.pointer + "/size: " + size.error().message);
    settings.size = *size;
  }
  if (at.has("samples")) {
    const auto samples = count_at(at.at("samples"), 1, 32);
    if (!samples) return tl::unexpected(samples.error());
    settings.samples = *samples;
  }
  if (at.has("looks")) {
    const Place looks = at.at("looks");
    if (looks.value != "plain" && looks.value != "standard") return looks.expected("plain or standard");
    settings.standard_looks = looks.value == "standard";
  }
  return at.has("limits") ? read_limits(at.at("limits"), settings.limits) : core::Expected<void>();
}

void override_limits(Limits& limits, const Limits& instead) {
  if (instead.max) limits.max = instead.max;
  if (instead.mean) limits.mean = instead.mean;
  if (instead.flip) limits.flip = instead.flip;
  if (instead.ids && limits.ids) limits.ids = instead.ids;  // others have no ids to compare
  if (!limits.any()) limits.max = 0.0;
}

class SuiteReader {
 public:
  SuiteReader(const fs::path& file, const Limits& instead) : folder_(file.parent_path()), instead_(instead) {
    suite_.name = file.stem().string();
  }

  core::Expected<Suite> read(const Place& at) {
    if (auto done = check_keys(at, {"name", "references", "size", "samples", "looks", "limits", "models"}); !done)
      return tl::unexpected(done.error());
    if (at.has("name")) {
      auto name = name_at(at);
      if (!name) return tl::unexpected(name.error());
      suite_.name = *name;
    }
    suite_.references = folder_ / "references";
    if (at.has("references")) {
      const auto folder = text_at(at.at("references"));
      if (!folder) return tl::unexpected(folder.error());
      suite_.references = folder_ / *folder;
    }
    Settings settings;
    if (auto done = read_settings(at, settings); !done) return tl::unexpected(done.error());
    if (!at.has("models") || !at.value["models"].is_array() || at.value["models"].empty())
      return core::fail(at.pointer + "/models: expected an array of at least one model");
    for (std::size_t i = 0; i < at.value["models"].size(); ++i)
      if (auto done = read_model(at.at("models").at(i), settings); !done) return tl::unexpected(done.error());
    return std::move(suite_);
  }

 private:
  core::Expected<void> read_model(const Place& at, Settings settings) {
    if (auto done = check_keys(at, {"name", "files", "translate", "units", "up", "lenient", "recognise", "size",
                                    "samples", "looks", "limits", "views"});
        !done)
      return done;
    const auto name = name_at(at);
    if (!name) return tl::unexpected(name.error());
    for (const SuiteModel& other : suite_.models)
      if (other.name == *name) return at.at("name").expected("another name than that of the models before");
    SuiteModel model{*name, {}};
    if (auto done = read_model_options(at, model.options); !done) return done;
    suite_.models.push_back(std::move(model));
    if (auto done = read_settings(at, settings); !done) return done;
    if (!at.has("views") || !at.value["views"].is_array() || at.value["views"].empty())
      return core::fail(at.pointer + "/views: expected an array of at least one view");
    for (std::size_t i = 0; i < at.value["views"].size(); ++i)
      if (auto done = read_view(at.at("views").at(i), settings); !done) return done;
    return {};
  }

  core::Expected<void> read_model_options(const Place& at, ModelOptions& options) {
    options.quiet = true;
    if (!at.has("files") || !at.value["files"].is_array() || at.value["files"].empty())
      return core::fail(at.pointer + "/files: expected an array of at least one model file");
    for (std::size_t i = 0; i < at.value["files"].size(); ++i) {
      const auto file = text_at(at.at("files").at(i));
      if (!file) return tl::unexpected(file.error());
      options.files.push_back((folder_ / *file).string());
    }
    if (at.has("translate")) {
      const auto text = text_at(at.at("translate"));
      if (!text) return tl::unexpected(text.error());
      if (const auto offset = parse_vector(*text); !offset)
        return core::fail(at.pointer + "/translate: " + offset.error().message);
      options.translate = *text;
    }
    if (at.has("units")) {
      const auto metres =
          at.value["units"].is_string() ? metres_of(at.value["units"].get<std::string>()) : std::nullopt;
      if (!metres) return at.at("units").expected("mm, cm, m, km, in or ft");
      options.import.metres_per_unit = *metres;
    }
    if (at.has("up")) {
      if (at.value["up"] != "y" && at.value["up"] != "z") return at.at("up").expected("y or z");
      options.import.up = at.value["up"] == "y" ? importers::UpAxis::kY : importers::UpAxis::kZ;
    }
    if (at.has("lenient")) {
      if (!at.value["lenient"].is_boolean()) return at.at("lenient").expected("true or false");
      options.import.lenient = at.value["lenient"].get<bool>();
    }
    if (at.has("recognise")) {
      if (!at.value["recognise"].is_boolean()) return at.at("recognise").expected("true or false");
      options.import.recognise = at.value["recognise"].get<bool>();
    }
    return {};
  }

  core::Expected<void> read_view(const Place& at, Settings settings) {
    if (auto done = check_keys(
            at, {"name", "view", "path", "frame", "frames", "size", "samples", "looks", "limits", "allow_empty"});
        !done)
      return done;
    const auto name = name_at(at);
    if (!name) return tl::unexpected(name.error());
    if (auto done = read_settings(at, settings); !done) return done;
    if (at.has("view") && at.has("path")) return core::fail(at.pointer + ": has a view and a path; expected one");
    if (at.has("path")) return read_path_frames(at, *name, settings);
    for (const char* key : {"frame", "frames"})
      if (at.has(key)) return core::fail(at.pointer + "/" + key + ": has no meaning without a path");
    if (!at.has("view")) return add(at, *name, settings, std::nullopt, "whole");
    const Place view = at.at("view");
    std::string text = view.value.dump(), source = view.pointer;
    if (view.value.is_string()) {
      const fs::path file = folder_ / view.value.get<std::string>();
      auto read = read_text(file);
      if (!read) return core::fail(view.pointer + ": " + read.error().message);
      text = std::move(*read);
      source = file.string();
    } else if (!view.value.is_object()) {
      return view.expected("the name of a file or a view");
    }
    auto parsed = importers::parse_view(text, double(settings.size[0]) / settings.size[1], source);
    if (!parsed) return tl::unexpected(parsed.error());
    return add(at, *name, settings, *parsed, text);
  }

  /// One frame of a path, or all of them.
  core::Expected<void> read_path_frames(const Place& at, const std::string& name, const Settings& settings) {
    const auto path_name = text_at(at.at("path"));
    if (!path_name) return tl::unexpected(path_name.error());
    const fs::path file = folder_ / *path_name;
    const auto text = read_text(file);
    if (!text) return core::fail(at.pointer + "/path: " + text.error().message);
    const auto path = importers::parse_path(*text, file.string());
    if (!path) return tl::unexpected(path.error());
    if (!at.has("frames")) return core::fail(at.pointer + ": expected \"frames\", into how many the path is sampled");
    const auto frames = count_at(at.at("frames"), 1, kMostFrames);
    if (!frames) return tl::unexpected(frames.error());
    int first = 0, last = *frames - 1;
    if (at.has("frame")) {
      const auto frame = count_at(at.at("frame"), 0, *frames - 1);
      if (!frame) return tl::unexpected(frame.error());
      first = last = *frame;
    }
    for (int frame = first; frame <= last; ++frame) {
      const double time = path->time_of(frame, *frames);
      const auto view = path->view(time, double(settings.size[0]) / settings.size[1]);
      if (!view) return core::fail(file.string() + ": " + view.error().message);
      char number[16] = "";
      if (!at.has("frame")) std::snprintf(number, sizeof number, "-%05d", frame);
      const std::string what = *text + "@" + std::to_string(frame) + "/" + std::to_string(*frames);
      if (auto done = add(at, name + number, settings, *view, what); !done) return done;
    }
    return {};
  }

  /// `what`: text that stands for the view in the task's key.
  core::Expected<void> add(const Place& at, const std::string& name, const Settings& settings,
                           std::optional<core::View> view, const std::string& what) {
    const SuiteModel& model = suite_.models.back();
    Task task{.name = model.name + "/" + name,
              .model = suite_.models.size() - 1,
              .view = std::move(view),
              .size = settings.size,
              .samples = settings.samples,
              .standard_looks = settings.standard_looks,
              .limits = settings.limits,
              .key = ""};
    if (at.has("allow_empty")) {
      if (!at.value["allow_empty"].is_boolean()) return at.at("allow_empty").expected("true or false");
      task.allow_empty = at.value["allow_empty"].get<bool>();
    }
    if (!names_.insert(task.name).second)
      return core::fail(at.pointer + ": two views of a model have the name " + name);
    override_limits(task.limits, instead_);
    if (task.limits.flip && std::min(task.size[0], task.size[1]) < 11)
      return core::fail(at.pointer + ": FLIP needs images of at least 11 pixels a side");
    if (task.view && !model.options.translate.empty()) {
      auto moved = importers::translated(*task.view, parse_vector(model.options.translate).value());
      if (!moved) return core::fail(at.pointer + ": " + moved.error().message);
      task.view = *moved;
    }
    const ModelOptions& options = model.options;
    std::ostringstream text;
    for (const std::string& file : options.files) text << fs::path(file).filename().string() << '\n';
    text << options.translate << import_arguments(options.import) << '\n'
         << what << '\n'
         << task.size[0] << 'x' << task.size[1] << ' ' << task.samples << ' ' << task.limits.ids.has_value()
         << (task.standard_looks ? " standard" : "") << (task.allow_empty ? " empty" : "");
    task.key = hash_of(text.str());
    suite_.tasks.push_back(std::move(task));
    return {};
  }

  fs::path folder_;
  const Limits& instead_;
  Suite suite_;
  std::set<std::string> names_;
};

}  // namespace

core::Expected<Suite> read_suite(const fs::path& file, const Limits& instead) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  const auto parsed = importers::parse_json(*text, file.string(), kDeepest);
  if (!parsed) return tl::unexpected(parsed.error());
  if (!parsed->is_object())
    return core::fail(file.string() + ": expected an object, found " + importers::describe(*parsed));
  return SuiteReader(file, instead).read({*parsed, file.string() + ": "});
}

std::string Suite::files_key(const Task& task) const {
  std::vector<fs::path> files(models[task.model].options.files.begin(), models[task.model].options.files.end());
  files.push_back("/proc/self/exe");  // another build draws otherwise
  files.push_back(reference(task));
  if (task.limits.ids) files.push_back(id_reference(task));
  std::string text;
  for (const fs::path& file : files) {
    std::error_code none;
    const auto size = fs::file_size(file, none);
    const auto time = fs::last_write_time(file, none);
    text += none ? "none\n" : std::to_string(size) + " " + std::to_string(time.time_since_epoch().count()) + "\n";
  }
  return hash_of(text);
}

Json limits_json(const Limits& limits) {
  Json out = Json::object();
  if (limits.flip) out["flip"] = *limits.flip;
  if (limits.ids) out["ids"] = *limits.ids;
  if (limits.max) out["max"] = *limits.max;
  if (limits.mean) out["mean"] = *limits.mean;
  return out;
}

bool fits(std::string_view name, std::string_view pattern) {
  // Where the last * was, and how much of the name it stands for so far.
  std::size_t star = std::string_view::npos, taken = 0, n = 0, p = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      taken = n;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p;
      ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++taken;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

}  // namespace sightline::apps
