// sightline-study occlusion: what occlusion culling costs and finds without a renderer. Two scenes: the boxes of a
// made-up plant, each taken as solid, the largest of them as occluders; and the same with walls, which are the
// occluders.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/models/random.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/core/error.h"
#include "sightline/core/internal/instruction_set.h"
#include "sightline/core/view.h"
#include "sightline/culling/box_culler.h"
#include "sightline/culling/occlusion/occluder_raster.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::occlusion_bench {
namespace {

using Json = json::Value;
using core::AabbD;
using core::dvec3;
using core::View;
using culling::DepthPyramid;
using culling::OccluderRaster;
using culling::OcclusionTest;

struct Options {
  std::size_t generate = 713'000, occluders = 512, solids = 8192, walls = 2000;
  int views = 24, passes = 15;
  std::string size = "640x360", json;
};

void add_options(apps::CommandLine& line, Options& options) {
  add_generate_option(line, options.generate).shows_default();
  line.add("--size", options.size, "image, WIDTHxHEIGHT").accepted_by(apps::parse_size).shows_default();
  line.add("--occluders", options.occluders, "boxes that are rastered for each view").shows_default();
  line.add("--solids", options.solids, "pipes alone: the largest boxes, which these are chosen from")
      .in_range(1, 50'000'000)
      .shows_default();
  line.add("--walls", options.walls, "walls, slabs and vessels of the second scene, which these are chosen from")
      .in_range(1, 1'000'000)
      .shows_default();
  line.add("--views", options.views, "made-up views, three quarters of them within the plant")
      .in_range(1, 10'000)
      .shows_default();
  line.add("--passes", options.passes, "repetitions; the least time of each view counts")
      .in_range(1, 1000)
      .shows_default();
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-study occlusion\n"
      "  sightline-study occlusion --generate 100000 --occluders 1000 --json out.json");
}

struct Image {
  int width, height;
};

/// The least milliseconds that call(i) takes in any pass, each after prepare(i), for each i below count: other programs
/// cost time, they save none.
template <class Call, class Prepare>
std::vector<double> least_times(std::size_t count, int passes, const Call& call, const Prepare& prepare) {
  std::vector<double> times(count, std::numeric_limits<double>::infinity());
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t i = 0; i < count; ++i) {
      prepare(i);
      const double start = milliseconds();
      call(i);
      times[i] = std::min(times[i], milliseconds() - start);
    }
  }
  return times;
}

template <class Call>
std::vector<double> least_times(std::size_t count, int passes, const Call& call) {
  return least_times(count, passes, call, [](std::size_t) {});
}

std::vector<View> made_up_views(int count, const AabbD& bounds, double aspect) {
  Random random(5);
  std::vector<View> views;
  const dvec3 size = bounds.size();
  const auto within = [&] {
    const double x = random.unit(), y = random.unit();
    return bounds.min + size * dvec3(x, y, 0.02 + 0.3 * random.unit());
  };
  while (int(views.size()) < count) {
    dvec3 eye = within();
    const dvec3 target = within();
    if (views.size() % 4 == 3) eye += 0.6 * size * glm::normalize(eye - bounds.centre());
    if (auto view = View::perspective({eye, target, {0, 0, 1}}, 1.0, aspect, 0.1)) views.push_back(*view);
  }
  return views;
}

/// Those with the largest faces.
std::vector<AabbD> largest(const std::vector<AabbD>& boxes, std::size_t count) {
  std::vector<AabbD> out = boxes;
  const auto area = [](const AabbD& box) {
    const dvec3 s = box.size();
    return std::max({s.x * s.y, s.y * s.z, s.z * s.x});
  };
  count = std::min(count, out.size());
  std::nth_element(out.begin(), out.begin() + std::ptrdiff_t(count), out.end(),
                   [&](const AabbD& a, const AabbD& b) { return area(a) > area(b); });
  out.resize(count);
  return out;
}

// --- what single things cost
// -------------------------------------------------------------------------------------------

/// Nanoseconds for a turned box that covers about side x side pixels, its place in the image at random.
double box_ns(const Image& image, double side, int passes) {
  const View view = *View::perspective({}, 1.0, double(image.width) / image.height, 0.1);
  Random random(3);
  std::vector<core::Affine> boxes;
  const double pixel = 2.0 * std::tan(0.5) / image.height;  // metres at 1 m
  for (int i = 0; i < 2000; ++i) {
    const double distance = 5.0 + 50.0 * random.unit(), half = 0.35 * side * pixel * distance;
    const double angle = 6.28 * random.unit(), c = std::cos(angle), s = std::sin(angle);
    const double u = random.unit() - 0.5, v = random.unit() - 0.5;
    const dvec3 at = distance * dvec3(u * image.width * pixel, 1.0, v * image.height * pixel);
    boxes.push_back({half * core::dmat3(c, s, 0, -s, c, 0, 0, 0, 1), at});
  }
  OccluderRaster raster;
  const auto times = least_times(1, passes, [&](std::size_t) {
    raster.begin(view, image.width, image.height);
    for (const core::Affine& box : boxes) raster.add_cube(box);
  });
  return 1e6 * times[0] / double(boxes.size());
}

/// Nanoseconds for a triangle of half side x side pixels: a sheet of them covers the image.
double triangle_ns(const Image& image, double side, int passes) {
  const View view = *View::orthographic({}, image.height, double(image.width) / image.height, 0.0, 100.0);
  const int columns = int(image.width / side), rows = int(image.height / side);
  std::vector<core::vec3> positions;
  std::vector<std::uint32_t> indices;
  for (int y = 0; y <= rows; ++y)
    for (int x = 0; x <= columns; ++x)
      positions.emplace_back(x * side - 0.5 * image.width, 50.0 + (x + y) % 3, y * side - 0.5 * image.height);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const auto at = std::uint32_t(y * (columns + 1) + x), above = at + std::uint32_t(columns) + 1;
      indices.insert(indices.end(), {at, at + 1, above, at + 1, above + 1, above});
    }
  }
  OccluderRaster raster;
  const auto times = least_times(1, passes, [&](std::size_t) {
    raster.begin(view, image.width, image.height);
    raster.add_mesh(positions, indices, {});
  });
  return 3e6 * times[0] / double(indices.size());
}

// --- the plant
// ---------------------------------------------------------------------------------------------------------

/// What an exact test would leave: boxes that are visible in the id image when all boxes are drawn.
class Truth {
 public:
  Truth(const View& view, const Image& image, const std::vector<AabbD>& boxes,
        const std::vector<std::uint32_t>& in_view)
      : image_(image), eye_(view.eye()) {
    const core::dmat4 clip = view.clip_from_world();
    const core::dmat4 inverse = glm::inverse(clip);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const core::dvec4 p =
            inverse * core::dvec4((2.0 * x + 1.0) / image.width - 1.0, (2.0 * y + 1.0) / image.height - 1.0, 0.5, 1.0);
        const dvec3 along = dvec3(p) / p.w - eye_;
        const double forward = -(view.eye_from_world() * core::dvec4(along, 0.0)).z;
        sights_.push_back(1.0 / (along / forward));
      }
    }
    nearest_.assign(sights_.size(), std::numeric_limits<double>::infinity());
    owner_.assign(sights_.size(), core::kNone);
    for (const std::uint32_t i : in_view) {
      for_each_pixel(clip, boxes[i], [&](std::size_t pixel) {
        const double entry = enter(boxes[i], sights_[pixel]);
        if (entry < nearest_[pixel]) nearest_[pixel] = entry, owner_[pixel] = i;
      });
    }
  }
  /// The boxes that are visible in the id image, sorted.
  std::vector<std::uint32_t> owners() const {
    std::vector<std::uint32_t> ids = owner_;
    std::erase(ids, core::kNone);
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return ids;
  }
  DepthPyramid pyramid() const {
    std::vector<float> distances(nearest_.begin(), nearest_.end());
    DepthPyramid pyramid;
    pyramid.build(distances, image_.width, image_.height);
    return pyramid;
  }

 private:
  double enter(const AabbD& box, const dvec3& inverse) const {
    const dvec3 a = (box.min - eye_) * inverse, b = (box.max - eye_) * inverse;
    const dvec3 low = glm::min(a, b), high = glm::max(a, b);
    const double first = std::max({low.x, low.y, low.z, 0.1}), last = std::min({high.x, high.y, high.z});
    return first <= last ? first : std::numeric_limits<double>::infinity();
  }
  template <class Visit>
  void for_each_pixel(const core::dmat4& clip, const AabbD& box, const Visit& visit) const {
    double x0 = 1e9, x1 = -1e9, y0 = 1e9, y1 = -1e9;
    for (int i = 0; i < 8; ++i) {
      const core::dvec4 p = clip * core::dvec4(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                               i & 4 ? box.max.z : box.min.z, 1.0);
      if (p.w <= 0.0) {
        x0 = y0 = -1e9, x1 = y1 = 1e9;
        break;
      }
      const double x = (0.5 * p.x / p.w + 0.5) * image_.width - 0.5, y = (0.5 * p.y / p.w + 0.5) * image_.height - 0.5;
      x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
    }
    const int left = int(std::ceil(std::max(x0, 0.0))), right = int(std::floor(std::min(x1, image_.width - 1.0)));
    const int bottom = int(std::ceil(std::max(y0, 0.0))), top = int(std::floor(std::min(y1, image_.height - 1.0)));
    for (int y = bottom; y <= top; ++y)
      for (int x = left; x <= right; ++x) visit(std::size_t(y) * std::size_t(image_.width) + std::size_t(x));
  }

  Image image_;
  dvec3 eye_;
  std::vector<dvec3> sights_;  // reciprocals of the directions, 1 m forward
  std::vector<double> nearest_;
  std::vector<std::uint32_t> owner_;
};

/// Boxes, and those of them that the application would know as solid.
struct Scene {
  std::string name;
  std::vector<AabbD> boxes, solids;
};

/// Panels, slabs and vessels of 4 to 16 m, most of them low.
std::vector<AabbD> walls(const AabbD& bounds, std::size_t count) {
  Random random(9);
  std::vector<AabbD> out;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = random.unit(), y = random.unit(), z = random.unit() * random.unit();
    const dvec3 at = bounds.min + bounds.size() * dvec3(x, y, z);
    dvec3 half{random.between(2.0, 8.0), random.between(2.0, 8.0), random.between(1.5, 5.0)};
    if (i % 8 != 0) half[int(i % 3)] = 0.15;
    out.push_back({at - half, at + half});
  }
  return out;
}

Json measure(const Scene& scene, const std::vector<View>& views, const Image& image, const Options& options) {
  const auto culler = culling::BoxCuller::create(scene.boxes);
  OccluderRaster raster;
  DepthPyramid depth;
  std::vector<std::uint32_t> indices;
  const auto raster_and_pyramid = [&](std::size_t i) {
    raster.begin(views[i], image.width, image.height);
    raster.add_largest(scene.solids, options.occluders);
    raster.build(depth);
  };
  const auto frustum = [&](std::size_t i) { culler->visible(views[i], indices); };
  const auto frustum_and_test = [&](std::size_t i) { culler->visible(views[i], depth, indices); };
  const auto all = [&](std::size_t i) {
    raster_and_pyramid(i);
    frustum_and_test(i);
  };
  const auto times = [&](const auto&... calls) {
    return apps::to_json(apps::summarise(least_times(views.size(), options.passes, calls...)));
  };
  Json json{{"scene", scene.name}, {"boxes", scene.boxes.size()}, {"solids", scene.solids.size()}};
  // After raster and pyramid, as in an application: what they leave in the caches counts.
  json["frustum_ms"] = times(frustum, raster_and_pyramid);
  json["raster_ms"] = times(raster_and_pyramid);
  json["frustum_and_test_ms"] = times(frustum_and_test, raster_and_pyramid);
  json["all_ms"] = times(all);
  std::uint64_t in_view = 0, found = 0, owning = 0, with_exact_depth = 0, lost = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    frustum(i);
    in_view += indices.size();
    const Truth truth(views[i], image, scene.boxes, indices);
    const std::vector<std::uint32_t> owners = truth.owners();
    owning += owners.size();
    all(i);
    found += indices.size();
    std::sort(indices.begin(), indices.end());
    for (const std::uint32_t owner : owners) lost += !std::binary_search(indices.begin(), indices.end(), owner);
    culler->visible(views[i], truth.pyramid(), indices);
    with_exact_depth += indices.size();
  }
  const auto mean = [&](std::uint64_t sum) { return double(sum) / double(views.size()); };
  json["in_view"] = mean(in_view);
  json["left"] = mean(found);
  json["left_with_exact_depth"] = mean(with_exact_depth);
  json["owning_a_pixel"] = mean(owning);
  json["owning_but_culled"] = lost;  // 0, or the test is wrong
  const double hidden = double(in_view - owning);
  json["culled_of_hidden"] = hidden > 0.0 ? double(in_view - found) / hidden : 1.0;
  return json;
}

/// Nanoseconds a box for the occlusion test of all boxes one after the other, by one thread.
double test_ns(const std::vector<core::Aabb>& boxes, const std::vector<AabbD>& solids, const std::vector<View>& views,
               const Image& image, const Options& options) {
  const core::ItemBounds ordered = in_production_order(boxes);
  core::VisibleSet all, open;
  all.ranges = {{0, std::uint32_t(ordered.size())}};
  OccluderRaster raster;
  std::vector<DepthPyramid> depths;
  for (const View& view : views) {
    raster.begin(view, image.width, image.height);
    raster.add_largest(solids, options.occluders);
    raster.build(depths.emplace_back());
  }
  const auto times = least_times(views.size(), options.passes, [&](std::size_t i) {
    OcclusionTest(views[i], ordered.origin, image.width, image.height, depths[i]).filter(ordered, all, open);
  });
  return 1e6 * apps::median(times) / double(ordered.size());
}

void print_table(const Json& json, std::FILE* out) {
  const auto row = [&](const char* key, const char* what) {
    std::fprintf(out, "ns %s of about", what);
    for (const auto& [side, ns] : json[key].items())
      std::fprintf(out, "  %s x %s pixels: %.0f", side.c_str(), side.c_str(), ns.template get<double>());
    std::fprintf(out, "\n");
  };
  std::fprintf(out, "%s, %s, least times of %d passes, medians over the views\n",
               json["instructions"].get<std::string>().c_str(), json["size"].get<std::string>().c_str(),
               json["passes"].get<int>());
  row("box_ns", "an occluder box");
  row("triangle_ns", "a triangle, half");
  std::fprintf(out, "ns a box for the test, one by one: %.1f\n", json["test_ns"].get<double>());
  for (const Json& scene : json["scenes"]) {
    const auto median = [&](const char* key) { return scene[key]["median"].get<double>(); };
    std::fprintf(out, "%s: %zu boxes, occluders chosen from %zu\n", scene["scene"].get<std::string>().c_str(),
                 scene["boxes"].get<std::size_t>(), scene["solids"].get<std::size_t>());
    std::fprintf(out, "  ms: view volume %.3f, the same and occlusion %.3f, raster %.3f, all together %.3f\n",
                 median("frustum_ms"), median("frustum_and_test_ms"), median("raster_ms"), median("all_ms"));
    std::fprintf(out, "  boxes: in the view volume %.0f, left %.0f (exact depth: %.0f), visible in the id image %.0f\n",
                 scene["in_view"].get<double>(), scene["left"].get<double>(),
                 scene["left_with_exact_depth"].get<double>(), scene["owning_a_pixel"].get<double>());
    std::fprintf(out,
                 "  culled: of those that are not visible in the id image %.1f %%, of the others %d in all views\n",
                 100.0 * scene["culled_of_hidden"].get<double>(), scene["owning_but_culled"].get<int>());
  }
}

core::Expected<int> run(const Options& options) {
  const auto size = *apps::parse_size(options.size);
  const Image image{size[0], size[1]};
  Json json{{"instructions", core::name_of(core::instruction_set())},
            {"size", options.size},
            {"passes", options.passes},
            {"views", options.views},
            {"occluders", options.occluders}};
  for (const int side : {8, 32, 128}) json["box_ns"][std::to_string(side)] = box_ns(image, side, options.passes);
  for (const int side : {4, 16, 64})
    json["triangle_ns"][std::to_string(side)] = triangle_ns(image, side, options.passes);

  auto floats = boxes_of({{}, {}, options.generate});
  if (!floats) return tl::unexpected(floats.error());
  Scene pipes{"pipes", {}, {}};
  AabbD bounds;
  for (const core::Aabb& box : *floats) {
    pipes.boxes.push_back({dvec3(box.min), dvec3(box.max)});
    bounds.grow(pipes.boxes.back());
  }
  pipes.solids = largest(pipes.boxes, options.solids);
  Scene walled{"pipes and walls", pipes.boxes, walls(bounds, options.walls)};
  walled.boxes.insert(walled.boxes.end(), walled.solids.begin(), walled.solids.end());
  const auto views = made_up_views(options.views, bounds, double(image.width) / image.height);
  json["test_ns"] = test_ns(*floats, walled.solids, views, image, options);
  for (const Scene& scene : {pipes, walled}) json["scenes"].push_back(measure(scene, views, image, options));
  return finish(options.json, json, print_table);
}

}  // namespace
}  // namespace sightline::bench::occlusion_bench

sightline::bench::Run sightline::bench::add_occlusion(apps::CommandLine& line) {
  using namespace occlusion_bench;
  return add_subcommand<Options>(line, add_options, run);
}
