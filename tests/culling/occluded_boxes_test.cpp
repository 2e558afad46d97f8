// The occlusion test from the side on which it may err: what brute force in double finds hidden, with some room for
// rounding, must be hidden, and what it finds in front of all else must be in front.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/culling/occlusion/occlusion_test.h"

namespace sightline::tests::occluded_boxes_test {
namespace {

using core::Aabb;
using core::dvec3;
using core::View;
using culling::DepthPyramid;
using culling::OcclusionTest;

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr double kWindow = 0.02;  // pixels by which rays in float may be off, beside the rasteriser's snap

/// Points at + t * along; t is the distance along the viewing direction.
struct Ray {
  dvec3 at, along;
};

struct Camera {
  View view;
  dvec3 origin;  // of boxes
  int width, height;
  double metres_of_pixel;  // at distance 1; in orthographic views, at any
  core::dmat4 world_from_clip = glm::inverse(view.clip_from_world());
  dvec3 forward = -dvec3(glm::transpose(view.eye_from_world())[2]);

  /// In coordinates of boxes.
  Ray ray(double x, double y) const {
    const core::dvec4 p =
        world_from_clip * core::dvec4((2.0 * x + 1.0) / width - 1.0, (2.0 * y + 1.0) / height - 1.0, 0.75, 1.0);
    const dvec3 first = dvec3(p) / p.w, to = first - view.eye();
    if (view.orthographic()) return {first - glm::dot(to, forward) * forward - origin, forward};
    return {view.eye() - origin, to / glm::dot(to, forward)};
  }
  double distance(const dvec3& p) const { return glm::dot(p + origin - view.eye(), forward); }
};

Camera random_camera(Random& random, int most) {
  const dvec3 origin = chance(random, 0.5) ? dvec3(0.0) : point(random, 1e4), eye = origin + point(random, 5.0);
  const dvec3 axes[] = {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  const dvec3 towards = chance(random, 0.2) ? axes[whole(random, 0, 2)] : random_direction(random);
  const core::Pose pose{eye, eye + towards, random_direction(random)};
  const int width = whole(random, 1, most), height = whole(random, 1, most);
  const double aspect = double(width) / height;
  if (chance(random, 0.3)) {
    const double high = uniform(random, 4.0, 20.0);
    return {*View::orthographic(pose, high, aspect, 0.1, 200.0), origin, width, height, high / height};
  }
  const double fovy = uniform(random, 0.5, 1.4);
  return {*View::perspective(pose, fovy, aspect, 0.1), origin, width, height, 3.0 * std::tan(0.5 * fovy) / height};
}

/// Where a ray enters a box that is larger by `room`. Slabs along which its direction has no more than this share count
/// only where it begins beside them, or not at all where `leave_out` is above 0.
double entry(const Ray& ray, const Aabb& box, double room, double leave_out = 0.0) {
  double first = -kNever, last = kNever;
  for (int i = 0; i < 3; ++i) {
    const double low = double(box.min[i]) - room - ray.at[i], high = double(box.max[i]) + room - ray.at[i];
    if (std::abs(ray.along[i]) < leave_out) continue;
    if (std::abs(ray.along[i]) < 1e-12) {
      if (low > 0.0 || high < 0.0) return kNever;
      continue;
    }
    const double a = low / ray.along[i], b = high / ray.along[i];
    first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
  }
  return first <= last ? first : kNever;
}

/// Least and greatest distances of a box.
std::pair<double, double> distances_of(const Camera& camera, const Aabb& box) {
  double least = kNever, most = -kNever;
  for (int i = 0; i < 8; ++i) {
    const dvec3 p(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z);
    least = std::min(least, camera.distance(p)), most = std::max(most, camera.distance(p));
  }
  return {least, most};
}

/// By how much a box must grow so that the ray of a pixel meets it wherever one within the pixel's window does.
double room_of(const Camera& camera, double snap, double farthest) {
  const double pixels = (kWindow + snap) * camera.metres_of_pixel;
  return 1e-4 + 2.0 * pixels * (camera.view.orthographic() ? 1.0 : std::max(0.0, farthest));
}

/// In front of the eye: a cube, a plate, a needle, or what holds the eye between two of its faces.
Aabb random_box_before(Random& random, const Camera& camera) {
  const int row = whole(random, 0, camera.height - 1), column = whole(random, 0, camera.width - 1);
  const Ray ray = camera.ray(column, row);
  const double away = magnitude(random, 1.0, 50.0);
  const dvec3 middle = ray.at + away * ray.along;
  dvec3 half(away * magnitude(random, 3e-3, 0.5));
  if (chance(random, 0.4)) half[whole(random, 0, 2)] *= magnitude(random, 1e-3, 1.0);
  if (chance(random, 0.4)) half[whole(random, 0, 2)] *= magnitude(random, 1e-3, 1.0);
  if (chance(random, 0.1)) half[whole(random, 0, 2)] *= 4.0;
  return {core::vec3(middle - half), core::vec3(middle + half)};
}

/// The rectangle about a box in the image, larger by some room: places with pixel centres at integers.
struct Rectangle {
  core::dvec2 low{kNever}, high{-kNever};
  int width, height;

  Rectangle(const Camera& camera, const Aabb& box, double room) : width(camera.width), height(camera.height) {
    for (int i = 0; i < 8; ++i) {
      const dvec3 p(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z);
      const core::dvec4 clip = camera.view.clip_from_world() * core::dvec4(p + camera.origin, 1.0);
      const core::dvec2 at = 0.5 * core::dvec2(width, height) * (core::dvec2(clip) / clip.w + 1.0) - 0.5;
      low = glm::min(low, at - room), high = glm::max(high, at + room);
    }
  }
  bool holds(int x, int y) const { return low.x <= x && x <= high.x && low.y <= y && y <= high.y; }
  int columns() const { return count(low.x, high.x, width); }
  int rows() const { return count(low.y, high.y, height); }

 private:
  static int count(double from, double to, int size) {
    return std::max(0, int(std::floor(std::min(to, size - 1.0))) - int(std::ceil(std::max(from, 0.0))) + 1);
  }
};

/// Where the ray of a pixel may be thought to enter a box: a larger one, in the rectangle about it. In orthographic
/// views the rectangle alone bounds it along axes that the rays hardly move along.
double entry_at_least(const Camera& camera, const Aabb& box, const Rectangle& rectangle, double room, int x, int y) {
  constexpr double kAlong = 1.1e-3;
  return rectangle.holds(x, y) ? entry(camera.ray(x, y), box, room, camera.view.orthographic() ? kAlong : 0.0) : kNever;
}

/// The rays of pixels that hold something in front of a box, or nearly all others, too, meet it, if it were a little
/// larger. Boxes of few pixels must be hidden, most of the others.
TEST(OccludedBoxes, AreOccludedByThePixelsThatMeetThem) {
  constexpr float kSnaps[] = {0.0f, 1.0f / 256.0f, culling::kCoarsestSnap};
  std::size_t small = 0, large = 0, lost = 0, opened = 0;
  for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Camera camera = random_camera(random, chance(random, 0.4) ? 150 : 24);
    const float snap = kSnaps[whole(random, 0, 2)];
    const double error = chance(random, 0.5) ? 0.0 : 0.01;
    const Aabb box = random_box_before(random, camera);
    const auto [least, most] = distances_of(camera, box);
    const double room = room_of(camera, double(snap), most);
    if (least < 0.3 + 2.0 * room) continue;
    const Rectangle rectangle(camera, box, double(snap) + kWindow);
    std::vector<float> distances(std::size_t(camera.width * camera.height), kNothing);
    std::vector<std::pair<std::size_t, double>> meeting, grazing;  // pixels, and where their rays enter the box
    const double open = chance(random, 0.5) ? 1.0 : 0.003;         // share of the pixels beside the box
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const double grown = entry_at_least(camera, box, rectangle, room, x, y);
        const auto pixel = std::size_t(y * camera.width + x);
        if (grown == kNever && chance(random, open)) continue;
        distances[pixel] = grown == kNever ? 0.1f : float(grown * (1.0 - 4e-5) - error - 1e-4);
        // A rasteriser may move a box by its snap.
        const double by_x = uniform(random, -0.98, 0.98) * double(snap),
                     by_y = uniform(random, -0.98, 0.98) * double(snap);
        const double met = entry(camera.ray(x + by_x, y + by_y), box, 0.0);
        if (met < kNever) meeting.emplace_back(pixel, met);
        if (met < kNever && entry(camera.ray(x, y), box, 0.0) == kNever) grazing.push_back(meeting.back());
      }
    DepthPyramid pyramid;
    pyramid.build(distances, camera.width, camera.height);
    const OcclusionTest test(camera.view, camera.origin, camera.width, camera.height, pyramid, error, snap);
    ASSERT_NEAR(test.distance(box), least, 1e-4 * most + 1e-4);
    const bool is_small = rectangle.columns() * rectangle.rows() <= 64;  // their rays are all looked at
    bool hidden = false;
    for_each_instruction_set([&] { hidden = test.occluded(box); });
    if (is_small) {
      ASSERT_TRUE(hidden) << rectangle.columns() << " x " << rectangle.rows() << " pixels";
    }
    ++(is_small ? small : large);
    lost += !is_small && !hidden;
    for (int i = 0; i < 6 && !meeting.empty(); ++i) {
      const auto& some = i < 4 && !grazing.empty() ? grazing : meeting;
      const auto [pixel, met] = some[std::size_t(whole(random, 0, int(some.size()) - 1))];
      const float before = std::exchange(distances[pixel], float(met * (1.0 + 1e-6) + 1e-6));
      pyramid.build(distances, camera.width, camera.height);
      distances[pixel] = before;
      for_each_instruction_set([&] { ASSERT_FALSE(test.occluded(box)); });
      ++opened;
    }
  }
  EXPECT_GT(small, 3000u);
  EXPECT_GT(large, 700u);
  EXPECT_LT(lost, large * 31 / 100) << "too many rows of blocks to look at";
  EXPECT_GT(opened, 10'000u);
}

/// A box of the front is entered first by the ray of some pixel, but for rounding, or has too many pixels to look at
/// each.
TEST(OccludedBoxes, FrontsAreEnteredFirst) {
  std::size_t fronts = 0, large = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Camera camera = random_camera(random, 24);
    core::ItemBounds bounds;
    bounds.origin = camera.origin;
    const std::size_t count = std::size_t(whole(random, 1, 60));
    bounds.resize(count);
    std::vector<double> rooms;
    std::vector<Rectangle> rectangles;
    for (std::size_t i = 0; i < count; ++i) {
      Aabb box = random_box_before(random, camera);
      while (distances_of(camera, box).first < 0.3) box = random_box_before(random, camera);
      bounds.set(i, box);
      rectangles.emplace_back(camera, box, kWindow);
      rooms.push_back(room_of(camera, 0.0, distances_of(camera, box).second));
    }
    std::vector<float> distances(std::size_t(camera.width * camera.height), kNothing);
    const float wall = float(magnitude(random, 1.0, 50.0));
    for (float& d : distances)
      if (chance(random, 0.3)) d = wall;
    DepthPyramid pyramid;
    pyramid.build(distances, camera.width, camera.height);
    const OcclusionTest test(camera.view, camera.origin, camera.width, camera.height, pyramid, 0.0, 0.0f);
    std::vector<bool> first(count);
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const Ray ray = camera.ray(x, y);
        double nearest = kNever;
        for (std::size_t i = 0; i < count; ++i) nearest = std::min(nearest, entry(ray, bounds.box(i), 0.0));
        for (std::size_t i = 0; i < count; ++i) {
          const double grown = entry_at_least(camera, bounds.box(i), rectangles[i], rooms[i], x, y),
                       slack = 1e-3 + 1e-4 * std::abs(grown);
          if (grown == kNever) continue;
          if (grown <= nearest + slack && grown <= double(distances[std::size_t(y * camera.width + x)]) + slack)
            first[i] = true;
        }
      }
    core::VisibleSet all, front, behind;
    all.ranges = {{0, core::Slot(count)}};
    for_each_instruction_set([&] {
      test.split_front(bounds, nullptr, all, front, behind);
      for (const core::Slot slot : front.single_slots) {
        // Rows of sixteen pixels, of which there may be 64.
        const int columns = rectangles[slot].columns(), rows = rectangles[slot].rows();
        const bool is_large = ((columns - 1) / 16 + 1) * rows > 64;
        ASSERT_TRUE(first[slot] || is_large) << "slot " << slot << " of " << columns << " x " << rows;
        large += is_large;
      }
      fronts += front.single_slots.size();
    });
  }
  EXPECT_GT(fronts, 3000u);
  EXPECT_LT(large, fronts / 10);
}

}  // namespace
}  // namespace sightline::tests::occluded_boxes_test
