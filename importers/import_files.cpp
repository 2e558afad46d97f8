// Reads several files in parallel. Each becomes a scene of its own; the calling thread appends these in order.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <iterator>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/internal/scene_cache.h"

namespace sightline::importers {
namespace {

void append(RecognitionReport& total, const RecognitionReport& one) {
  total.meshes += one.meshes;
  for (std::size_t k = 0; k < total.items.size(); ++k) total.items[k] += one.items[k];
  total.triangles_before += one.triangles_before, total.triangles_after += one.triangles_after;
  total.bytes_before += one.bytes_before, total.bytes_after += one.bytes_after;
  total.largest_deviation = std::max(total.largest_deviation, one.largest_deviation);
  for (std::size_t k = 0; k < total.refused.size(); ++k) total.refused[k] += one.refused[k];
}

void append(ExactSurfaceReport& total, const ExactSurfaceReport& one) {
  total.parts += one.parts, total.instances += one.instances;
  total.analytic_solids += one.analytic_solids, total.meshed_bodies += one.meshed_bodies;
  total.triangles += one.triangles, total.failed_faces += one.failed_faces;
  total.curves += one.curves, total.annotations += one.annotations;
  total.largest_tolerance = std::max(total.largest_tolerance, one.largest_tolerance);
  total.deviation = std::max(total.deviation, one.deviation);
  total.analytic_deviation = std::max(total.analytic_deviation, one.analytic_deviation);
}

void append(ImportReport& total, ImportReport&& one) {
  if (!one.nodes.empty()) total.metres_per_unit = one.metres_per_unit;
  total.nodes.insert(total.nodes.end(), one.nodes.begin(), one.nodes.end());
  std::move(one.warnings.begin(), one.warnings.end(), std::back_inserter(total.warnings));
  for (std::size_t k = 0; k < total.items.size(); ++k) total.items[k] += one.items[k];
  total.degenerate += one.degenerate;
  total.attributed += one.attributed;
  total.shared_meshes += one.shared_meshes;
  total.sharing_error = std::max(total.sharing_error, one.sharing_error);
  total.bytes += one.bytes;
  append(total.recognition, one.recognition);
  append(total.surfaces, one.surfaces);
  total.side_files.insert(total.side_files.end(), one.side_files.begin(), one.side_files.end());
}

/// At least one byte, so that every file counts for something.
double size_of(const std::filesystem::path& path) {
  std::error_code code;
  const auto size = std::filesystem::file_size(path, code);
  return code ? 1.0 : 1.0 + double(size);
}

class SideBySide {
 public:
  SideBySide(std::span<const std::filesystem::path> paths, core::Scene& scene, core::NodeId parent,
             const ImportOptions& options)
      : paths_(paths), scene_(scene), parent_(parent), options_(options), files_(paths.size()) {
    const unsigned processors = std::max(1u, std::thread::hardware_concurrency());
    threads_ = std::min(paths.size(), std::size_t(options.threads > 0 ? unsigned(options.threads) : processors));
    root_from_parent_ = scene.world_from_node(parent);
    for (std::size_t i = 0; i < paths.size(); ++i) total_size_ += files_[i].size = size_of(paths[i]);
  }

  core::Expected<ImportReport> run() {
    std::vector<std::jthread> workers = start();
    if (workers.empty()) return core::fail(paths_[0].string() + ": no thread can be started to read it");
    const core::Scene::Mark mark = scene_.mark();
    ImportReport total;
    core::Expected<void> done;
    for (std::size_t i = 0; done && i < files_.size(); ++i) {
      done = wait_for(i);
      if (done) done = append(i, total);
      const bool last = i + 1 == files_.size();
      if (done && !tell(last) && !last) done = core::fail(std::string(kCancelled));
    }
    if (done) return total;
    stop();
    workers.clear();
    scene_.take_back(mark, total.nodes);
    return tl::unexpected(std::move(done.error()));
  }

 private:
  struct File {
    double size = 1.0;
    std::atomic<double> share{0.0};
    core::Scene scene;
    std::optional<core::Expected<ImportReport>> report;  // there when read
  };

  /// Starts as many threads as the system gives.
  std::vector<std::jthread> start() {
    std::vector<std::jthread> workers;
    try {
      for (std::size_t i = 0; i < threads_; ++i) workers.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
    }
    return workers;
  }

  /// Reads one file after the other, no farther ahead of the appended ones than memory allows.
  void work() {
    for (;;) {
      std::size_t i;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return stopped_ || next_ >= files_.size() || next_ < appended_ + 2 * threads_; });
        if (stopped_ || next_ >= files_.size()) return;
        i = next_++;
      }
      File& file = files_[i];
      // At its final distance from the origin, so that what could not be committed there is dropped.
      file.scene.set_transform(file.scene.root(), root_from_parent_);
      ImportOptions options = options_;
      options.progress = [&](double share) {
        file.share = share;
        return !stopped_;
      };
      auto report = import_file(paths_[i], file.scene, file.scene.root(), options);
      const std::lock_guard lock(mutex_);
      file.report = std::move(report);
      changed_.notify_all();
    }
  }

  /// Waits until the file has been read, and reports the progress of all files.
  core::Expected<void> wait_for(std::size_t i) {
    constexpr auto kBetweenReports = std::chrono::milliseconds(20);
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, kBetweenReports, [&] { return files_[i].report.has_value(); })) {
      lock.unlock();
      if (!tell(false)) return core::fail(std::string(kCancelled));
      lock.lock();
    }
    return {};
  }

  core::Expected<void> append(std::size_t i, ImportReport& total) {
    File& file = files_[i];
    if (!*file.report) return tl::unexpected(file.report->error());
    ImportReport report = std::move(**file.report);
    try {
      report.nodes = scene_.append(parent_, std::move(file.scene));
    } catch (const std::bad_alloc&) {
      return core::fail(paths_[i].string() + ": not enough memory");
    }
    importers::append(total, std::move(report));
    const std::lock_guard lock(mutex_);
    appended_ = i + 1;
    changed_.notify_all();
    return {};
  }

  /// Reports progress; false when the caller cancels. Reports 1 only when all files have been appended.
  bool tell(bool all_done) {
    if (!options_.progress) return true;
    constexpr double kNearlyDone = 0.999;
    double done = 0.0;
    for (const File& file : files_) done += file.size * file.share;
    const double share = all_done ? 1.0 : std::min(kNearlyDone, done / total_size_);
    if (share <= told_) return true;
    told_ = share;
    return options_.progress(share);
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }

  std::span<const std::filesystem::path> paths_;
  core::Scene& scene_;
  core::NodeId parent_;
  const ImportOptions& options_;
  core::Affine root_from_parent_;
  double total_size_ = 0.0, told_ = -1.0;
  std::size_t threads_ = 1;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<File> files_;
  std::size_t next_ = 0, appended_ = 0;
  std::atomic<bool> stopped_ = false;
};

/// Options whose progress is a part of the whole import's.
ImportOptions portion(const ImportOptions& options, double begin, double end) {
  ImportOptions part = options;
  if (options.progress)
    part.progress = [&options, begin, end](double share) { return options.progress(begin + share * (end - begin)); };
  return part;
}

/// Parts of one model that lie in files of their own fit together only if all of them are turned, or none. So none is
/// where the meshes of some files stand on y and those of others, which do not say either, do not.
void turn_all_or_none(std::span<const std::filesystem::path> paths, core::Scene& scene, ImportReport& report) {
  const auto says_nothing = [](const std::filesystem::path& path) {
    const std::string extension = lower_case_extension(path);
    return extension == ".obj" || extension == ".ply" || extension == ".stl";
  };
  const auto is_turned = [](const ImportWarning& warning) { return warning.message == kSeemsYUp; };
  const auto open = std::count_if(paths.begin(), paths.end(), says_nothing);
  if (std::count_if(report.warnings.begin(), report.warnings.end(), is_turned) == open) return;
  for (ImportWarning& warning : report.warnings) {
    if (!is_turned(warning)) continue;
    warning.message = "seems to have y up, but other files do not: none is turned";
    for (const core::NodeId node : report.nodes) {
      if (scene.name(node) != warning.file) continue;
      core::Affine upright = scene.transform(node);
      upright.linear = core::dmat3(glm::length(upright.linear[0]));
      scene.set_transform(node, upright);
    }
  }
}

core::Expected<ImportReport> import_models(std::span<const std::filesystem::path> paths, core::Scene& scene,
                                           core::NodeId parent, const ImportOptions& options) {
  if (paths.empty()) return ImportReport{};
  if (paths.size() == 1) return import_file(paths[0], scene, parent, options);
  auto report = SideBySide(paths, scene, parent, options).run();
  if (report && options.up == UpAxis::kAutomatic) turn_all_or_none(paths, scene, *report);
  return report;
}

}  // namespace

bool is_attribute_file(const std::filesystem::path& file) {
  const std::string extension = lower_case_extension(file);
  return extension == ".txt" || extension == ".att";
}

core::Expected<ImportReport> import_files(std::span<const std::filesystem::path> paths, core::Scene& scene,
                                          core::NodeId parent, const ImportOptions& options) {
  return options.cache_folder.empty() ? read_files(paths, scene, parent, options)
                                      : import_with_cache(paths, scene, parent, options);
}

core::Expected<ImportReport> read_files(std::span<const std::filesystem::path> paths, core::Scene& scene,
                                        core::NodeId parent, const ImportOptions& options) {
  std::vector<std::filesystem::path> ordered(paths.begin(), paths.end());
  const auto attributes =
      std::stable_partition(ordered.begin(), ordered.end(), [](const auto& path) { return !is_attribute_file(path); });
  const auto models = std::size_t(attributes - ordered.begin());
  const auto share = [&](std::size_t files) { return double(files) / double(ordered.size()); };
  const core::Scene::Mark mark = scene.mark();
  auto total = import_models(std::span(ordered).first(models), scene, parent, portion(options, 0.0, share(models)));
  if (!total) return total;
  for (std::size_t i = models; i < ordered.size(); ++i) {
    auto report = import_file(ordered[i], scene, parent, portion(options, share(i), share(i + 1)));
    if (!report) {
      scene.take_back(mark, total->nodes);
      return report;
    }
    append(*total, std::move(*report));
  }
  return total;
}

}  // namespace sightline::importers
