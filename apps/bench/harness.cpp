#include "sightline/apps/bench/harness.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "sightline/apps/bench/models/plant_boxes.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/core/block_order.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/engine/tour.h"
#include "sightline/importers/plant/plant_generator.h"

static_assert(std::endian::native == std::endian::little, "the file formats are read as they lie in memory");

namespace sightline::bench {
namespace {

/// Reads the whole file as numbers, `group` of them per record.
template <class T>
core::Expected<std::vector<T>> read_numbers(const std::string& name, std::size_t group, const char* what) {
  const std::filesystem::path path = core::platform::path_of(name);
  std::error_code error;
  const auto bytes = std::filesystem::is_regular_file(path, error) ? std::filesystem::file_size(path, error) : 0;
  std::ifstream file(path, std::ios::binary);
  if (error || !file || !std::filesystem::is_regular_file(path)) return core::fail(name + ": cannot be read as a file");
  if (bytes % (group * sizeof(T)) != 0)
    return core::fail(name + ": size " + std::to_string(bytes) + " is not a multiple of " +
                      std::to_string(group * sizeof(T)) + " bytes (" + what + ")");
  std::vector<T> numbers(bytes / sizeof(T));
  file.read(reinterpret_cast<char*>(numbers.data()), std::streamsize(bytes));
  if (file.gcount() != std::streamsize(bytes)) return core::fail(name + ": could not be read to its end");
  return numbers;
}

}  // namespace

core::Expected<std::vector<core::Aabb>> read_boxes(const std::string& path) {
  const auto numbers = read_numbers<float>(path, 6, "six float32 per box");
  if (!numbers) return tl::unexpected(numbers.error());
  std::vector<core::Aabb> boxes(numbers->size() / 6);
  if (boxes.size() >= core::kNone / 2) return core::fail(path + ": more boxes than this tool can number");
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const float* f = numbers->data() + 6 * i;
    if (!std::all_of(f, f + 6, [](float x) { return std::isfinite(x); }))
      return core::fail(path + ": box " + std::to_string(i) + " has a coordinate that is not finite");
    boxes[i] = {{f[0], f[1], f[2]}, {f[3], f[4], f[5]}};
  }
  return boxes;
}

core::Expected<std::vector<core::View>> read_views(const std::string& path) {
  const auto numbers = read_numbers<double>(path, 16, "sixteen float64 per view");
  if (!numbers) return tl::unexpected(numbers.error());
  std::vector<core::View> views;
  for (std::size_t i = 0; i < numbers->size(); i += 16) {
    core::dmat4 clip_from_world;
    for (int k = 0; k < 16; ++k) clip_from_world[k / 4][k % 4] = (*numbers)[i + std::size_t(k)];
    auto view = core::View::from_matrices(core::dmat4(1.0), clip_from_world, core::ClipDepth::kMinusOneToOne);
    if (!view) return core::fail(path + ": view " + std::to_string(i / 16) + ": " + view.error().message);
    views.push_back(std::move(*view));
  }
  return views;
}

apps::Option add_generate_option(apps::CommandLine& line, std::size_t& count) {
  return line.add("--generate", count, "So many boxes of a made-up plant of 400 x 100 x 60 m").in_range(1, 50'000'000);
}

apps::Option add_views_option(apps::CommandLine& line, std::string& file) {
  return line.add("--views", file, "float64, 16 per frame: column-major clip_from_world, clip space -1...1");
}

void add_input_options(apps::CommandLine& line, Input& input) {
  apps::CommandLine source = line.exactly_one_of("boxes");
  source.add("--boxes", input.boxes, "float32 min x y z, max x y z per item");
  add_generate_option(source, input.generate);
  add_views_option(line, input.views).required();
}

core::Expected<std::vector<core::Aabb>> boxes_of(const Input& input) {
  if (input.generate > 0) return PlantBoxes(1).make(input.generate);
  return read_boxes(input.boxes);
}

apps::Option add_frames_option(apps::CommandLine& line, int& frames, int least) {
  return line.add("--frames", frames, "Of the tour, evenly spaced").in_range(least, 10'000).shows_default();
}

core::Expected<std::vector<core::View>> tour_views(const core::Snapshot& snapshot, int frames, double aspect) {
  const core::CameraPath path = engine::make_tour(snapshot.bounds(), snapshot.bounds().fitted_bounds());
  std::vector<core::View> views;
  for (int i = 0; i < frames; ++i) {
    auto view = path.view(path.time_of(i, std::max(2, frames)), aspect);
    if (!view) return tl::unexpected(view.error());
    views.push_back(std::move(*view));
  }
  return views;
}

double thread_milliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

core::ItemBounds in_production_order(std::span<const core::Aabb> boxes) {
  core::ItemBounds bounds;
  fill(bounds, boxes, core::block_order(boxes, {.smallest_block = culling::kLeafSize}));
  return bounds;
}

void fill(core::ItemBounds& bounds, std::span<const core::Aabb> boxes, std::span<const std::uint32_t> order) {
  bounds.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) bounds.set(i, boxes[order.empty() ? i : order[i]]);
}

void add_model_or_plant_options(apps::CommandLine& line, ModelOrPlant& subject) {
  apps::add_model_options(line, subject.model);
  const apps::Option items = line.add("--items", subject.items, "Instead of models: a generated plant of so many items")
                                 .in_range(std::uint64_t(1'000), std::uint64_t(10'000'000));
  line.option("MODEL").required(false).excludes(items);
  line.check([&subject]() -> core::Expected<void> {
    if (subject.model.files.empty() && subject.items == 0) return core::fail("MODEL or --items is required");
    return {};
  });
}

core::Expected<std::unique_ptr<core::Scene>> model_or_plant(const apps::ModelOptions& options, std::uint64_t items) {
  auto scene = std::make_unique<core::Scene>();
  if (!options.files.empty()) {
    auto model = apps::load_model(options);
    if (!model) return tl::unexpected(model.error());
    scene = std::move(model->scene);
  } else if (auto made = importers::generate_plant({.items = items}, *scene); !made) {
    return tl::unexpected(made.error());
  }
  if (auto done = scene->commit(); !done) return tl::unexpected(done.error());
  return scene;
}

}  // namespace sightline::bench
