// Shared by the benchmarks: boxes and views from files or generated, the clock, and times of a camera path.
#pragma once

#include <cstdint>
#include <ctime>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/common/model.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/core/error.h"
#include "sightline/core/internal/clock.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"

namespace sightline::apps {
class CommandLine;
class Option;
}  // namespace sightline::apps

namespace sightline::bench {

/// Little-endian float32, min x y z and max x y z per box, no header; all finite.
core::Expected<std::vector<core::Aabb>> read_boxes(const std::string& path);
/// Little-endian float64, 16 per view: column-major clip_from_world, clip space -1 ... 1.
core::Expected<std::vector<core::View>> read_views(const std::string& path);

/// --generate, into `count`.
apps::Option add_generate_option(apps::CommandLine& line, std::size_t& count);
/// --views, into `file`.
apps::Option add_views_option(apps::CommandLine& line, std::string& file);

/// Source of boxes and views.
struct Input {
  std::string boxes, views;
  std::size_t generate = 0;  ///< number of boxes to generate; 0: read them
};
/// --boxes or --generate, and --views.
void add_input_options(apps::CommandLine& line, Input& input);
core::Expected<std::vector<core::Aabb>> boxes_of(const Input& input);

/// Boxes in the given order (empty: in their own order).
void fill(core::ItemBounds& bounds, std::span<const core::Aabb> boxes, std::span<const std::uint32_t> order);

struct ModelOrPlant {
  apps::ModelOptions model;
  std::uint64_t items = 0;
};
/// MODEL… or --items, of which one has to be given.
void add_model_or_plant_options(apps::CommandLine& line, ModelOrPlant& subject);
/// The model, or without files a generated plant of `items`; committed.
core::Expected<std::unique_ptr<core::Scene>> model_or_plant(const apps::ModelOptions& model, std::uint64_t items);

/// --frames, at least so many, into `frames`.
apps::Option add_frames_option(apps::CommandLine& line, int& frames, int least);
/// `frames` evenly spaced views of the flight through a model; a single one is its start.
core::Expected<std::vector<core::View>> tour_views(const core::Snapshot& snapshot, int frames, double aspect);

/// Time since an arbitrary moment.
inline double milliseconds() {
  return 1e3 * core::now_seconds();
}

/// Time that all threads of the process have run.
inline double processor_milliseconds() {
  return 1e3 * double(std::clock()) / CLOCKS_PER_SEC;
}

/// Time that the calling thread has run.
double thread_milliseconds();

/// Boxes in the order in which production culls them.
core::ItemBounds in_production_order(std::span<const core::Aabb> boxes);

inline constexpr std::size_t kPasses = 3;  ///< of time_path()

/// Runs call(0) … call(count - 1) on each pass. Returns one time per call, the median over the passes.
template <class Call>
std::vector<double> time_path(std::size_t count, const Call& call) {
  std::vector<std::vector<double>> passes(count, std::vector<double>(kPasses));
  for (std::size_t pass = 0; pass < kPasses; ++pass) {
    for (std::size_t i = 0; i < count; ++i) {
      const double start = milliseconds();
      call(i);
      passes[i][pass] = milliseconds() - start;
    }
  }
  std::vector<double> times;
  times.reserve(count);
  for (const auto& of_view : passes) times.push_back(apps::median(of_view));
  return times;
}

}  // namespace sightline::bench
