// sightline-study views: the cost of several views at once, section planes and layers, as ratios to one plain view.
#include <array>
#include <cstdio>

#include <glm/gtc/matrix_transform.hpp>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::views_bench {
namespace {

using Json = json::Value;

constexpr double kEyeDistance = 0.065;  // metres
constexpr std::size_t kCascades = 4;

struct Options {
  Input input;
  std::string json;
  int threads = 2;
};

void add_options(apps::CommandLine& line, Options& options) {
  add_input_options(line, options.input);
  line.add("--threads", options.threads, "threads that several views may use")
      .in_range(1, culling::CullThreads::kMost)
      .shows_default();
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-study views --boxes boxes.f32 --views views.f64\n"
      "  sightline-study views --generate 713000 --views views.f64 --threads 2 --json out.json");
}

core::View view_of(const core::dmat4& clip_from_world) {
  return *core::View::from_matrices(core::dmat4(1.0), clip_from_world, core::ClipDepth::kMinusOneToOne);
}

/// The camera moved along its own x axis.
core::View second_eye(const core::View& view) {
  const core::dmat4 m = view.clip_from_world();
  const core::dvec3 right = glm::normalize(core::dvec3(m[0][0], m[1][0], m[2][0]));
  return view_of(glm::translate(m, -kEyeDistance * right));
}

/// Light views around slices of the camera's frustum; each slice is four times as deep as the one before.
std::vector<core::View> cascades(const core::View& view) {
  const core::dmat4 world_from_clip = glm::inverse(view.clip_from_world());
  const auto corner = [&](double x, double y, double depth) {
    const auto at = [&](double z) {
      const core::dvec4 p = world_from_clip * core::dvec4(x, y, z, 1.0);
      return core::dvec3(p) / p.w;
    };
    const core::dvec3 near = at(-1.0), far = at(0.999);
    return near + depth / glm::distance(near, far) * (far - near);
  };
  const core::dvec3 light = glm::normalize(core::dvec3(0.4, 0.3, -1.0));
  std::vector<core::View> views;
  double begin = 0.1;
  for (std::size_t i = 0; i < kCascades; ++i, begin *= 4.0) {
    core::AabbD slice;
    for (const double x : {-1.0, 1.0})
      for (const double y : {-1.0, 1.0})
        for (const double depth : {begin, 4.0 * begin}) slice.grow(corner(x, y, 3.0 * depth));
    const double radius = 0.5 * glm::length(slice.size());
    const core::Pose pose{slice.centre() - 200.0 * light, slice.centre(), {0.0, 0.0, 1.0}};
    views.push_back(*core::View::orthographic(pose, 2.0 * radius, 1.0, 0.0, 200.0 + radius));
  }
  return views;
}

class Measurement {
 public:
  Measurement(const culling::CpuCuller& culler, Json& rows) : culler_(&culler), rows_(&rows) {}

  /// Culls several views per frame: in one query, or in a query each.
  double run(const char* name, const std::vector<std::vector<core::View>>& frames, bool together,
             culling::CullThreads* threads, double reference) {
    std::array<core::VisibleSet, 2 + kCascades> sets;
    std::uint64_t visible = 0, boxes = 0;
    const auto times = time_path(frames.size(), [&](std::size_t i) {
      const std::vector<core::View>& views = frames[i];
      if (together) return culler_->cull(views, sets, threads);
      for (std::size_t k = 0; k < views.size(); ++k) culler_->cull(views[k], sets[k]);
    });
    for (const std::vector<core::View>& views : frames) {
      culler_->cull(views, sets, threads);
      for (std::size_t k = 0; k < views.size(); ++k) visible += sets[k].count(), boxes += sets[k].counters.boxes_tested;
    }
    const apps::Summary s = apps::summarise(times);
    const double ratio = reference > 0.0 ? s.mean / reference : 1.0;
    const double frame_count = double(std::max<std::size_t>(1, frames.size()));
    rows_->push_back({{"name", name},
                      {"mean_ms", s.mean},
                      {"median_ms", s.median},
                      {"ratio", ratio},
                      {"mean_visible", double(visible) / frame_count},
                      {"mean_boxes_tested", double(boxes) / frame_count}});
    return s.mean;
  }

 private:
  const culling::CpuCuller* culler_;
  Json* rows_;
};

using Frames = std::vector<std::vector<core::View>>;

void measure_views(const core::ItemBounds& bounds, const std::vector<core::View>& views, int thread_count, Json& rows) {
  const culling::CpuCuller culler(bounds);
  culling::CullThreads threads(thread_count);
  Measurement measure(culler, rows);
  Frames one, eyes, six;
  for (const core::View& view : views) {
    one.push_back({view});
    eyes.push_back({view, second_eye(view)});
    six.push_back(eyes.back());
    for (const core::View& cascade : cascades(view)) six.back().push_back(cascade);
  }
  const double single = measure.run("one view", one, false, nullptr, 0.0);
  measure.run("two eyes, two queries", eyes, false, nullptr, single);
  measure.run("two eyes, one query", eyes, true, nullptr, single);
  measure.run("two eyes, one query, threads", eyes, true, &threads, single);
  const double separate = measure.run("eyes and cascades, six queries", six, false, nullptr, 0.0);
  measure.run("eyes and cascades, one query", six, true, nullptr, separate);
  measure.run("eyes and cascades, one query, threads", six, true, &threads, separate);
}

/// Uses section planes that cut nothing away, so that the same items are visible.
void measure_sections(const core::ItemBounds& bounds, const std::vector<core::View>& views, Json& rows) {
  const culling::CpuCuller culler(bounds);
  Measurement measure(culler, rows);
  const core::Aabb& e = bounds.extent();
  Frames plain, all, any;
  for (const core::View& view : views) {
    plain.push_back({view});
    core::View cut = view;
    for (int k = 0; k < 8; ++k) {
      core::dvec3 normal(k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, k & 4 ? 1.0 : -1.0);
      core::dvec3 farthest;
      for (int axis = 0; axis < 3; ++axis) farthest[axis] = normal[axis] > 0.0 ? e.min[axis] : e.max[axis];
      cut.sections.push_back({normal, 1.0 - glm::dot(normal, farthest + bounds.origin)});
    }
    all.push_back({cut});
    cut.section_mode = core::SectionMode::kUnion;
    any.push_back({cut});
  }
  const double single = measure.run("no section planes", plain, false, nullptr, 0.0);
  measure.run("eight section planes, and", all, false, nullptr, single);
  measure.run("eight section planes, or", any, false, nullptr, single);
}

/// The view shows all layers, or all except the layer of every tenth run of items.
void measure_layers(core::ItemBounds bounds, const std::vector<core::View>& views, Json& rows) {
  Frames shown, some;
  for (const core::View& view : views) {
    shown.push_back({view});
    shown.back().front().layers = 0xffu;
    some.push_back({view});
    some.back().front().layers = core::kLayerModel;
  }
  const culling::CpuCuller plain(bounds);
  const double single = Measurement(plain, rows).run("no layers", shown, false, nullptr, 0.0);
  constexpr std::size_t kRun = 5000;  // the items of a system lie together
  for (std::size_t i = 0; i < bounds.size(); ++i)
    if (i / kRun % 10 == 9) bounds.set_layers(i, 0x10u);
  const culling::CpuCuller layered(bounds);
  Measurement measure(layered, rows);
  measure.run("two layers, both shown", shown, false, nullptr, single);
  measure.run("two layers, one shown", some, false, nullptr, single);
}

core::Expected<Json> measure(const Options& options) {
  const auto boxes = boxes_of(options.input);
  if (!boxes) return tl::unexpected(boxes.error());
  const auto views = read_views(options.input.views);
  if (!views) return tl::unexpected(views.error());
  const core::ItemBounds bounds = in_production_order(*boxes);
  Json json{{"items", boxes->size()}, {"frames", views->size()}, {"threads", options.threads}, {"rows", Json::array()}};
  measure_views(bounds, *views, options.threads, json["rows"]);
  measure_sections(bounds, *views, json["rows"]);
  measure_layers(bounds, *views, json["rows"]);
  return json;
}

void print_table(const Json& json, std::FILE* out) {
  std::fprintf(out, "%zu items, %zu frames, %d threads\n%-40s %9s %9s %7s %10s %10s\n",
               json["items"].get<std::size_t>(), json["frames"].get<std::size_t>(), json["threads"].get<int>(), "",
               "mean ms", "median ms", "ratio", "visible", "boxes");
  for (const Json& row : json["rows"])
    std::fprintf(out, "%-40s %9.4f %9.4f %7.2f %10.0f %10.0f\n", row["name"].get<std::string>().c_str(),
                 row["mean_ms"].get<double>(), row["median_ms"].get<double>(), row["ratio"].get<double>(),
                 row["mean_visible"].get<double>(), row["mean_boxes_tested"].get<double>());
}

core::Expected<int> run(const Options& options) {
  const auto json = measure(options);
  if (!json) return tl::unexpected(json.error());
  return finish(options.json, *json, print_table);
}

}  // namespace
}  // namespace sightline::bench::views_bench

sightline::bench::Run sightline::bench::add_views(apps::CommandLine& line) {
  using namespace views_bench;
  return add_subcommand<Options>(line, add_options, run);
}
