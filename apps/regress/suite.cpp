#include "sightline/apps/regress/suite.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/need.h"
#include "sightline/core/internal/hash.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/core/internal/platform/process.h"
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
  return read_bytes(file);
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
  std::string colour_by;
  Limits limits;
};

/// A value of the suite and where it stands, for errors.
struct Place {
  const Json& value;
  std::string pointer;

  [[noreturn]] void refuse(const std::string& why) const { fail(pointer + ": " + why); }
  [[noreturn]] void expected(const std::string& what) const {
    refuse("expected " + what + ", found " + importers::describe(value));
  }
  /// The result that the library made of the value.
  template <class T>
  T accepted(core::Expected<T> made) const {
    if (!made) refuse(made.error().message);
    return std::move(*made);
  }
  bool has(const char* key) const { return value.contains(key); }
  Place at(const std::string& key) const { return {value.at(key), pointer + "/" + key}; }

  std::string text() const {
    if (!value.is_string() || value.string().empty()) expected("a text");
    return value.get<std::string>();
  }
  bool flag() const {
    if (!value.is_boolean()) expected("true or false");
    return value.get<bool>();
  }
  int count(int least, int most) const {
    if (!value.is_number_integer() || value < least || value > most)
      expected("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
    return value.get<int>();
  }
  /// Whether the text is the first one.
  bool first_of(const char* first, const char* second) const {
    if (value != first && value != second) expected(std::string(first) + " or " + second);
    return value == first;
  }
  std::vector<Place> list(const std::string& key, const std::string& of) const {
    if (!has(key.c_str()) || !value[key].is_array() || value[key].empty())
      fail(pointer + "/" + key + ": expected an array of at least one " + of);
    std::vector<Place> all;
    for (std::size_t i = 0; i < value[key].size(); ++i)
      all.push_back({value[key].at(i), pointer + "/" + key + "/" + std::to_string(i)});
    return all;
  }
};

/// A misspelt limit must not pass for none.
void check_keys(const Place& at, const std::set<std::string>& known) {
  if (!at.value.is_object()) at.expected("an object");
  std::string names;
  for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
  for (const auto& [key, value] : at.value.items())
    if (!known.contains(key)) fail(at.pointer + "/" + key + ": unknown; expected " + names);
}

std::string name_at(const Place& at) {
  if (!at.has("name")) at.refuse("expected a \"name\"");
  const Place name = at.at("name");
  if (!is_name(name.text())) name.expected("at most 100 letters, digits, - and _");
  return name.text();
}

void read_limits(const Place& at, Limits& limits) {
  check_keys(at, {"max", "mean", "flip", "ids"});
  const auto read = [&](const char* key, double most, auto& limit) {
    if (!at.has(key)) return;
    const Place place = at.at(key);
    limit.reset();
    if (place.value.is_null()) return;  // none here, whatever stands above
    if (!place.value.is_number() || !(place.value >= 0.0 && place.value <= most))
      place.expected("null or a number from 0 to " + std::to_string(std::llround(most)));
    limit = place.value.get<typename std::decay_t<decltype(limit)>::value_type>();
  };
  read("max", 255.0, limits.max);
  read("mean", 255.0, limits.mean);
  read("flip", 1.0, limits.flip);
  if (at.has("ids") && at.value["ids"].is_number_float()) at.at("ids").expected("a whole number");
  read("ids", 16384.0 * 16384.0, limits.ids);
}

void read_settings(const Place& at, Settings& settings) {
  if (at.has("size")) settings.size = at.at("size").accepted(parse_size(at.at("size").text()));
  if (at.has("samples")) settings.samples = at.at("samples").count(1, 32);
  if (at.has("looks")) settings.standard_looks = !at.at("looks").first_of("plain", "standard");
  if (at.has("colour_by")) settings.colour_by = at.value["colour_by"].is_null() ? "" : at.at("colour_by").text();
  if (at.has("limits")) read_limits(at.at("limits"), settings.limits);
}

void override_limits(Limits& limits, const Limits& instead) {
  if (instead.max) limits.max = instead.max;
  if (instead.mean) limits.mean = instead.mean;
  if (instead.flip) limits.flip = instead.flip;
  if (instead.ids && limits.ids) limits.ids = instead.ids;  // others have no ids to compare
  if (!limits.any()) limits.max = 0.0;
}

/// Throws a Failure that names file and place.
class SuiteReader {
 public:
  SuiteReader(const fs::path& file, const Limits& instead) : folder_(file.parent_path()), instead_(instead) {
    suite_.name = file.stem().string();
  }

  Suite read(const Place& at) {
    check_keys(at, {"name", "references", "size", "samples", "looks", "colour_by", "limits", "models"});
    if (at.has("name")) suite_.name = name_at(at);
    suite_.references = folder_ / (at.has("references") ? at.at("references").text() : "references");
    Settings settings;
    read_settings(at, settings);
    for (const Place& model : at.list("models", "model")) read_model(model, settings);
    return std::move(suite_);
  }

 private:
  void read_model(const Place& at, Settings settings) {
    check_keys(at, {"name", "files", "translate", "units", "up", "lenient", "recognise", "size", "samples", "looks",
                    "colour_by", "limits", "views"});
    const std::string name = name_at(at);
    for (const SuiteModel& other : suite_.models)
      if (other.name == name) at.at("name").expected("another name than that of the models before");
    suite_.models.push_back({name, model_options(at)});
    read_settings(at, settings);
    for (const Place& view : at.list("views", "view")) read_view(view, settings);
  }

  ModelOptions model_options(const Place& at) const {
    ModelOptions options;
    options.quiet = true;
    for (const Place& file : at.list("files", "model file")) options.files.push_back((folder_ / file.text()).string());
    if (at.has("translate")) {
      options.translate = at.at("translate").text();
      at.at("translate").accepted(parse_vector(options.translate));
    }
    if (at.has("units")) {
      const auto metres =
          at.value["units"].is_string() ? metres_of(at.value["units"].get<std::string>()) : std::nullopt;
      if (!metres) at.at("units").expected("mm, cm, m, km, in or ft");
      options.import.metres_per_unit = *metres;
    }
    if (at.has("up"))
      options.import.up = at.at("up").first_of("y", "z") ? importers::UpAxis::kY : importers::UpAxis::kZ;
    if (at.has("lenient")) options.import.lenient = at.at("lenient").flag();
    if (at.has("recognise")) options.import.recognise = at.at("recognise").flag();
    return options;
  }

  void read_view(const Place& at, Settings settings) {
    check_keys(at, {"name", "view", "path", "frame", "frames", "size", "samples", "looks", "colour_by", "limits",
                    "allow_empty"});
    const std::string name = name_at(at);
    read_settings(at, settings);
    if (at.has("view") && at.has("path")) at.refuse("has a view and a path; expected one");
    if (at.has("path")) return read_path_frames(at, name, settings);
    for (const char* key : {"frame", "frames"})
      if (at.has(key)) fail(at.pointer + "/" + key + ": has no meaning without a path");
    if (!at.has("view")) return add(at, name, settings, std::nullopt, "whole");
    const Place view = at.at("view");
    std::string text = view.value.dump(), source = view.pointer;
    if (view.value.is_string()) {
      source = (folder_ / view.value.get<std::string>()).string();
      text = view.accepted(read_text(source));
    } else if (!view.value.is_object()) {
      view.expected("the name of a file or a view");
    }
    add(at, name, settings, need(importers::parse_view(text, double(settings.size[0]) / settings.size[1], source)),
        text);
  }

  /// One frame of a path, or all of them.
  void read_path_frames(const Place& at, const std::string& name, const Settings& settings) {
    const fs::path file = folder_ / at.at("path").text();
    const std::string text = at.at("path").accepted(read_text(file));
    const auto path = need(importers::parse_path(text, file.string()));
    if (!at.has("frames")) at.refuse("expected \"frames\", into how many the path is sampled");
    const int frames = at.at("frames").count(1, kMostFrames);
    const bool one = at.has("frame");
    const int first = one ? at.at("frame").count(0, frames - 1) : 0, last = one ? first : frames - 1;
    for (int frame = first; frame <= last; ++frame) {
      const auto view = path.view(path.time_of(frame, frames), double(settings.size[0]) / settings.size[1]);
      if (!view) fail(file.string() + ": " + view.error().message);
      char number[16] = "";
      if (!one) std::snprintf(number, sizeof number, "-%05d", frame);
      add(at, name + number, settings, *view, text + "@" + std::to_string(frame) + "/" + std::to_string(frames));
    }
  }

  /// `what`: text that stands for the view in the task's key.
  void add(const Place& at, const std::string& name, const Settings& settings, std::optional<core::View> view,
           const std::string& what) {
    const SuiteModel& model = suite_.models.back();
    Task task{.name = model.name + "/" + name,
              .model = suite_.models.size() - 1,
              .view = std::move(view),
              .size = settings.size,
              .samples = settings.samples,
              .standard_looks = settings.standard_looks,
              .colour_by = settings.colour_by,
              .allow_empty = at.has("allow_empty") && at.at("allow_empty").flag(),
              .limits = settings.limits,
              .key = ""};
    if (!names_.insert(task.name).second) at.refuse("two views of a model have the name " + name);
    override_limits(task.limits, instead_);
    if (task.limits.flip && std::min(task.size[0], task.size[1]) < 11)
      at.refuse("FLIP needs images of at least 11 pixels a side");
    if (task.view && !model.options.translate.empty())
      task.view = at.accepted(importers::translated(*task.view, parse_vector(model.options.translate).value()));
    const ModelOptions& options = model.options;
    std::ostringstream text;
    for (const std::string& file : options.files) text << fs::path(file).filename().string() << '\n';
    text << options.translate << import_arguments(options.import) << '\n'
         << what << '\n'
         << task.size[0] << 'x' << task.size[1] << ' ' << task.samples << ' ' << task.limits.ids.has_value()
         << (task.standard_looks ? " standard" : "") << (task.allow_empty ? " empty" : "")
         << (task.colour_by.empty() ? "" : "\ncolours " + task.colour_by);
    task.key = hash_of(text.str());
    suite_.tasks.push_back(std::move(task));
  }

  fs::path folder_;
  const Limits& instead_;
  Suite suite_;
  std::set<std::string> names_;
};

}  // namespace

core::Expected<Suite> read_suite(const fs::path& file, const Limits& instead) {
  return attempt([&] {
    const Json parsed = need(importers::parse_json(need(read_text(file)), file.string(), kDeepest));
    const Place whole{parsed, file.string() + ": "};
    if (!parsed.is_object()) fail(file.string() + ": expected an object, found " + importers::describe(parsed));
    return SuiteReader(file, instead).read(whole);
  });
}

core::Expected<std::string> read_bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return core::fail(file.string() + ": cannot be read");
  return text.str();
}

std::string Suite::files_key(const Task& task) const {
  std::vector<fs::path> files(models[task.model].options.files.begin(), models[task.model].options.files.end());
  files.push_back(core::platform::program_image());  // another build draws otherwise
  files.push_back(reference(task));
  if (task.limits.ids) files.push_back(id_reference(task));
  std::string text = drawn_by + "\n";
  for (const fs::path& file : files) {
    std::error_code none;
    const auto size = fs::file_size(file, none);
    const auto time = core::platform::write_time(file, none);
    text += none ? "none\n" : std::to_string(size) + " " + std::to_string(time) + "\n";
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
