// Scene caches in a folder: found by the names of the files, used while these are what they were.
#include "sightline/importers/internal/scene_cache.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/slc/internal/slc_rows.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/importers/slc/slc_writer.h"
#include "sightline/lod/stored_levels.h"

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

/// Raised when a reader makes something else of the same file.
constexpr int kReaders = 2;
/// The share of reading in an import with levels of detail, which take the rest.
constexpr double kReadingShare = 0.2;

/// Size and time of a file that may be missing: then both are -1.
struct Stamp {
  std::int64_t size = -1, time = -1;
};

Stamp stamp_of(const fs::path& path) {
  std::error_code code;
  const auto size = fs::file_size(path, code);
  if (code) return {};
  const std::int64_t time = core::platform::write_time(path, code);
  if (code) return {};
  return {std::int64_t(size), time};
}

/// Absolute, so that the cache is found from any directory.
fs::path whole_path(const fs::path& path) {
  std::error_code code;
  fs::path whole = fs::weakly_canonical(path, code);
  return code ? fs::absolute(path, code) : whole;
}

Json entry_of(const fs::path& path) {
  const Stamp stamp = stamp_of(path);
  return {{"path", whole_path(path).string()},
          {"size", stamp.size},
          {"time", stamp.time},
          {"hash", stamp.size < 0 ? 0 : slc_checksum(path)}};
}

/// A file that was touched or copied back is the same when its content is.
bool is_unchanged(const Json& entry) {
  const fs::path path = core::platform::path_of(entry.at("path").get<std::string>());
  const Stamp stamp = stamp_of(path);
  if (stamp.size != entry.at("size").get<std::int64_t>()) return false;
  if (stamp.time == entry.at("time").get<std::int64_t>()) return true;
  return slc_checksum(path) == entry.at("hash").get<std::uint64_t>();
}

/// What beside the files decides what an import gives.
Json settings_of(const ImportOptions& options) {
  return {{"lenient", options.lenient},
          {"metres_per_unit", options.metres_per_unit},
          {"up", int(options.up)},
          {"crease_angle", options.crease_angle},
          {"chord_tolerance", options.chord_tolerance},
          {"chord_angle", options.chord_angle},
          {"copies", int(options.copies)},
          {"recognise", options.recognise},
          {"recognise_tolerance", options.recognise ? options.recognise_tolerance : 0.0},
          {"readers", kReaders}};
}

class SceneCache {
 public:
  SceneCache(std::span<const fs::path> paths, const ImportOptions& options) : paths_(paths), options_(options) {
    Json key = settings_of(options);
    for (const fs::path& path : paths) key["files"].push_back(whole_path(path).string());
    const std::string text = to_text(key);
    const std::uint64_t hash = slc_checksum(std::as_bytes(std::span(text)));
    file_ = options.cache_folder /
            core::platform::path_of(fmt::format("{}-{:016x}.slc", paths.front().stem().string(), hash));
  }

  /// What the cache has, if it may be used. Otherwise `warning` is set when that needs telling.
  std::optional<SlcScene> read(std::optional<ImportWarning>& warning) const {
    auto loaded = read_fresh();
    if (loaded) return std::move(*loaded);
    if (loaded.error().kind == SlcProblem::Kind::kDamaged)
      warning = ImportWarning{file_.string(), 0, fmt::format("scene cache made anew: {}", loaded.error().message)};
    return std::nullopt;
  }

  /// Before the files are read, so that a change meanwhile is found later.
  Json sources() const {
    Json files = Json::array();
    for (const fs::path& path : paths_) files.push_back(entry_of(path));
    return files;
  }

  /// Writes the scene and gives it the snapshot that was written.
  core::Expected<void> write(Json files, core::Scene& scene, const ImportReport& report) const {
    std::error_code code;
    fs::create_directories(options_.cache_folder, code);  // a failure shows in writing
    remove_leftovers();
    const std::size_t models = files.size();
    for (const fs::path& side : report.side_files) {
      const std::string name = whole_path(side).string();
      if (std::none_of(files.begin(), files.end(), [&](const Json& f) { return f.at("path") == name; }))
        files.push_back(entry_of(side));
    }
    const Json sources = {{"files", std::move(files)}, {"models", models}, {"settings", settings_of(options_)}};
    if (auto done = write_slc(scene, file_, {.report = &report}, to_text(sources)); !done) return done;
    if (auto file = SlcFile::open(file_)) (void)attach_snapshot(*file, scene);  // else it is built when needed
    return {};
  }

  /// Whether meshes of the cache should have levels of detail and have none.
  bool lacks_levels(const SlcScene& cached) const {
    return options_.cached_levels && lod::builds_levels() && !cached.has_levels;
  }

  /// Builds levels into the cache, which holds this scene, and reads it anew. Fails as write_slc() does.
  core::Expected<void> add_levels(SlcScene& cached, const std::function<bool(double)>& progress) const {
    const auto file = SlcFile::open(file_);
    if (!file) return core::fail(file.error().message);
    const auto sources = sources_of(**file);
    if (!sources) return core::fail(sources.error().message);
    const SlcWriteOptions options{.report = &cached.report, .levels = true, .progress = progress};
    if (auto done = write_slc(cached.scene, file_, options, *sources); !done) return done;
    if (auto again = read_fresh()) cached = std::move(*again);
    return {};
  }

 private:
  SlcExpected<SlcScene> read_fresh() const {
    auto file = SlcFile::open(file_);
    if (!file) return tl::unexpected(file.error());
    const auto text = sources_of(**file);
    if (!text) return tl::unexpected(text.error());
    const auto parsed = json::parse(*text);
    if (!parsed) return damaged("its sources cannot be read: " + parsed.error().reason);
    try {
      const Json& sources = *parsed;
      const Json& files = sources.at("files");
      bool fresh = sources.at("settings") == settings_of(options_) && sources.at("models") == paths_.size();
      for (std::size_t i = 0; fresh && i < files.size(); ++i)
        fresh = (i >= paths_.size() || files[i].at("path") == whole_path(paths_[i]).string()) && is_unchanged(files[i]);
      if (!fresh)
        return tl::unexpected<SlcProblem>(SlcProblem{SlcProblem::Kind::kOtherVersion, "its files have changed"});
    } catch (const std::exception& wrong) {
      return damaged(fmt::format("its sources cannot be read: {}", wrong.what()));
    }
    return load(*file);
  }

  /// Removes what writers of this cache left that were ended an hour ago or more.
  void remove_leftovers() const {
    std::error_code code;
    const std::string begin = file_.filename().string() + ".";
    for (const auto& entry : fs::directory_iterator(options_.cache_folder, code)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with(begin) || !name.ends_with(".part")) continue;
      const auto time = entry.last_write_time(code);
      if (!code && fs::file_time_type::clock::now() - time > std::chrono::hours(1)) fs::remove(entry.path(), code);
    }
  }

  std::span<const fs::path> paths_;
  const ImportOptions& options_;
  fs::path file_;
};

bool is_bare(const core::Scene& scene) {
  return scene.node_count() == 1 && scene.item_slots() == 0 && scene.mesh_slots() == 0 && scene.material_slots() == 0;
}

bool can_be_cached(std::span<const fs::path> paths, const core::Scene& scene, core::NodeId parent) {
  if (paths.empty() || !is_unmoved(scene, parent)) return false;
  const auto of_others = [&](const fs::path& path) {
    const std::string extension = lower_case_extension(path);
    return extension == ".slc" || extension == ".vtm" || extension == ".vtmb" ||
           (is_attribute_file(path) && scene.node_count() > 1);
  };
  return std::none_of(paths.begin(), paths.end(), of_others);
}

/// Progress of a part of the whole.
std::function<bool(double)> part_of(const std::function<bool(double)>& progress, double from, double to) {
  if (!progress) return {};
  return [=](double share) { return progress(from + share * (to - from)); };
}

bool is_cancelled(const core::Expected<void>& done) {
  return !done && done.error().message == kCancelled;
}

void warn_if_failed(const core::Expected<void>& written, const ImportOptions& options, ImportReport& report) {
  if (!written)
    report.warnings.push_back({options.cache_folder.string(), 0, "scene cache: " + written.error().message});
}

}  // namespace

core::Expected<ImportReport> import_with_cache(std::span<const fs::path> paths, core::Scene& scene, core::NodeId parent,
                                               const ImportOptions& options) {
  if (!can_be_cached(paths, scene, parent)) return read_files(paths, scene, parent, options);
  const SceneCache cache(paths, options);
  std::optional<ImportWarning> warning;
  if (auto found = cache.read(warning)) {
    core::Expected<void> written;
    if (cache.lacks_levels(*found)) written = cache.add_levels(*found, part_of(options.progress, 0.0, 0.9));
    if (is_cancelled(written) || (options.progress && !options.progress(0.9)))
      return core::fail(std::string(kCancelled));
    ImportReport report = std::move(found->report);
    report.nodes = scene.append(parent, std::move(found->scene));
    report.from_cache = true;
    warn_if_failed(written, options, report);
    if (options.progress) (void)options.progress(1.0);
    return report;
  }
  Json sources = cache.sources();
  // Into the scene itself where nothing else is in it, so that progress can show what has been read. With levels the
  // scene is what is read from the cache in the end.
  const bool levels = options.cached_levels && lod::builds_levels();
  const bool bare = !levels && is_bare(scene) && parent == scene.root() && scene.name(parent).empty();
  SlcScene apart;
  core::Scene& into = bare ? scene : apart.scene;
  ImportOptions reading = options;
  if (levels) reading.progress = part_of(options.progress, 0.0, kReadingShare);
  auto report = read_files(paths, into, into.root(), reading);
  if (!report) return report;
  auto written = cache.write(std::move(sources), into, *report);
  if (written && levels) {
    apart.report = *report;
    written = cache.add_levels(apart, part_of(options.progress, kReadingShare, 1.0));
    if (is_cancelled(written)) return tl::unexpected(written.error());
  }
  if (!bare) report->nodes = scene.append(parent, std::move(apart.scene));
  if (warning) report->warnings.push_back(std::move(*warning));
  warn_if_failed(written, options, *report);
  return report;
}

}  // namespace sightline::importers
