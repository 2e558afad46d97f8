// Images of a moving camera: traced pixels beside single rays and reference images, and points of earlier images beside
// their places in double.
#include "sightline/raytrace/internal/moving_image.h"

#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include "sightline/core/image_rays.h"
#include "sightline/core/internal/clock.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/raytrace/whitted.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::raytrace::moving_image_test {
namespace {

using core::dvec3;
using tests::uniform;

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr int kWidth = 203, kHeight = 118;  // neither is a number of blocks
constexpr std::size_t kPixels = std::size_t(kWidth) * kHeight;

core::View perspective(double turn) {
  const dvec3 eye = 14.0 * dvec3(std::cos(turn), std::sin(turn), 0.3);
  return *core::View::perspective({eye, {}, {0, 0, 1}}, 0.7, double(kWidth) / kHeight, 0.1);
}
core::View orthographic(double turn) {
  const dvec3 eye = 14.0 * dvec3(std::cos(turn), std::sin(turn), 0.3);
  return *core::View::orthographic({eye, {}, {0, 0, 1}}, 11.0, double(kWidth) / kHeight, 1.0, 40.0);
}

/// Solids of all kinds about the origin, far apart enough that some of the background shows, and their tracer.
class MovingImageTest : public testing::Test {
 protected:
  void SetUp() override {
    tests::Random random(4711);
    const auto length = [&] { return float(uniform(random, 0.1, 0.9)); };
    const auto shift = [&] { return float(uniform(random, -0.3, 0.3)); };
    const auto angle = [&] { return float(uniform(random, 0.5, 6.0)); };
    constexpr core::Kind kKinds[] = {core::Kind::kBox,           core::Kind::kCylinder,      core::Kind::kSphere,
                                     core::Kind::kSnout,         core::Kind::kCircularTorus, core::Kind::kPyramid,
                                     core::Kind::kEllipticalDish};
    std::vector<core::MaterialId> materials;
    for (const core::vec3& colour : {core::vec3(0.7f, 0.2f, 0.1f), core::vec3(0.2f, 0.6f, 0.3f), core::vec3(0.05f)})
      materials.push_back(scene.add_material({"", colour, 1.0f, 0}));
    for (int i = 0; i < 240; ++i) {
      dvec3 at, axis(0.0, 0.0, 1.1);
      at.z = uniform(random, -3, 3), at.y = uniform(random, -4, 4), at.x = uniform(random, -4, 4);
      axis.y = uniform(random, -1, 1), axis.x = uniform(random, -1, 1);
      core::Affine placed = core::translation(at);
      placed.linear = core::dmat3(glm::rotate(core::dmat4(1.0), uniform(random, 0, 3), glm::normalize(axis)));
      scene.add_primitive(scene.root(), tests::primitive_of(kKinds[i % 7], length, shift, angle), placed,
                          materials[std::size_t(i) % 3]);
    }
    ASSERT_TRUE(scene.commit());
    snapshot.emplace(scene);
    tracer.emplace(std::move(*Tracer::create(*snapshot)));
    whole.tracer = &*tracer;
  }

  MovingImage::Counts draw(MovingImage& image, const core::View& view, double deadline,
                           std::span<const std::uint64_t> without = {}) {
    whole.without = without;
    const auto counts = image.draw(request(view), threads, deadline);
    EXPECT_TRUE(counts);
    EXPECT_EQ(counts->traced + counts->kept + counts->filled, std::int64_t(kPixels));
    return *counts;
  }
  raytrace::ImageRequest request(const core::View& view, int width = kWidth) const {
    return {{{&whole, 1}}, view, width, kHeight};
  }
  /// The hit of a pixel's ray; pixels are counted from the bottom up.
  std::optional<Hit> hit(const core::View& view, std::size_t pixel, const RayFilter& filter,
                         const Tracer* by = nullptr) const {
    const auto ray =
        core::image_ray(view, kWidth, kHeight, double(pixel % kWidth) + 0.5, kHeight - (double(pixel / kWidth) + 0.5));
    return *(by ? by : &*tracer)->nearest(*ray, filter);
  }
  void expect_traced(const MovingImage& image, const core::View& view, std::size_t pixel, RayFilter filter) const {
    const auto found = hit(view, pixel, filter);
    ASSERT_EQ(image.points().pixels().ids[pixel], found ? to_index(found->item) + 1 : 0u) << pixel;
    if (!found) return;
    const core::dvec4 clip =
        gpuprims::reversed_clip_from_eye(view) * view.eye_from_world() * core::dvec4(found->point, 1.0);
    EXPECT_NEAR(image.points().pixels().depths[pixel], clip.z / clip.w, 2e-6);
  }

  core::Scene scene;
  std::optional<core::Snapshot> snapshot;
  std::optional<Tracer> tracer;
  TracedPart whole{};
  core::ThreadPool threads{2};
};

TEST_F(MovingImageTest, IsTheImageOfItsRaysInTime) {
  for (const core::View& view : {perspective(0.3), orthographic(0.3)}) {
    MovingImage image;
    EXPECT_EQ(draw(image, view, kNever).traced, std::int64_t(kPixels));
    const auto reference = render_whitted(*tracer, view, kWidth, kHeight);
    ASSERT_TRUE(reference);
    int background = 0;
    for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
      expect_traced(image, view, pixel, filter_of(view));
      const std::size_t there = (kHeight - 1 - pixel / kWidth) * kWidth + pixel % kWidth;
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(image.points().pixels().colours[pixel] >> 8 * c & 255u, reference->rgb[3 * there + c], 1) << pixel;
      background += image.points().pixels().ids[pixel] == 0;
    }
    EXPECT_GT(background, int(kPixels / 20));
    EXPECT_LT(background, int(kPixels * 4 / 5));
  }
}

/// Rays pass slots as if their items were not there, where they go together and, with sections, alone.
TEST_F(MovingImageTest, SeesWhatItsViewAndFilterKeep) {
  std::vector<std::uint64_t> without((snapshot->size() + 63) / 64);
  for (core::Slot slot = 0; slot < snapshot->size(); slot += 3) {
    without[slot / 64] |= std::uint64_t(1) << slot % 64;
    scene.set_visible(snapshot->item(slot), false);
  }
  ASSERT_TRUE(scene.commit());
  const core::Snapshot rest(scene);
  const auto twin = Tracer::create(rest);
  ASSERT_TRUE(twin);
  MovingImage image;
  draw(image, perspective(0.3), kNever);
  for (core::View view : {perspective(0.3), perspective(0.31)}) {
    if (view.eye() != perspective(0.3).eye()) view.sections.push_back({{0, -1, 0}, 0.5});
    image.forget();
    draw(image, view, kNever, without);
    int surfaces = 0;
    for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
      const auto found = hit(view, pixel, filter_of(view), &*twin);
      ASSERT_EQ(image.points().pixels().ids[pixel], found ? to_index(found->item) + 1 : 0u) << pixel;
      surfaces += found.has_value();
    }
    EXPECT_GT(surfaces, int(kPixels / 10));
  }
}

/// The twin of following points: places of surfaces in the image of another view, in double, and between them the
/// background that lay there before.
struct Follower {
  struct Found {
    double depth = -1.0;  // reversed
    std::uint32_t id = 0;
    bool sure = true, background = false;
    glm::ivec2 from{0, 0};  // pixel of the view before
  };
  std::vector<Found> found{kPixels};

  /// Where a view has a point, in pixels; none outside.
  static std::optional<core::dvec3> place(const core::View& view, const dvec3& point) {
    const core::dvec4 clip = gpuprims::reversed_clip_from_eye(view) * view.eye_from_world() * core::dvec4(point, 1.0);
    const double x = 0.5 * kWidth * (1.0 + clip.x / clip.w), y = 0.5 * kHeight * (1.0 + clip.y / clip.w);
    if (!(clip.w > 0.0 && x >= 0.0 && x < kWidth && y >= 0.0 && y < kHeight)) return std::nullopt;
    return core::dvec3(x, y, clip.z / clip.w);
  }
  static bool on_border(const core::dvec3& place) {
    return std::abs(place.x - std::round(place.x)) < 2e-3 || std::abs(place.y - std::round(place.y)) < 2e-3;
  }

  void add(const core::View& view, const dvec3& point, std::uint32_t id, std::size_t from) {
    const auto there_is = place(view, point);
    if (!there_is) return;
    const double x = there_is->x, y = there_is->y, depth = there_is->z;
    Found& there = found[std::size_t(y) * kWidth + std::size_t(x)];
    for (int dx = -1; dx <= 1 && on_border(*there_is); ++dx)  // float may put it into a neighbour
      for (int dy = -1; dy <= 1; ++dy)
        if (x + dx >= 0.0 && x + dx < kWidth && y + dy >= 0.0 && y + dy < kHeight)
          found[std::size_t(y + dy) * kWidth + std::size_t(x + dx)].sure = false;
    if (std::abs(depth - there.depth) < 1e-5 && there.id != id) there.sure = false;
    if (depth > there.depth) {
      there.depth = depth, there.id = id;
      there.from = {int(from % kWidth), int(from / kWidth)};
    }
  }
  /// `at`: where the background of a pixel lies. `empty`: pixels of the view before that show the background.
  void keep_background(const core::View& before, std::size_t pixel, const dvec3& at, const std::vector<bool>& empty) {
    Found& there = found[pixel];
    if (there.depth >= 0.0) return;
    const auto from = place(before, at);
    if (!from) return;
    there.sure &= !on_border(*from);
    there.from = {int(from->x), int(from->y)};
    there.background = empty[std::size_t(from->y) * kWidth + std::size_t(from->x)];
  }

  /// Whether surfaces near a pixel, on both sides or above and below, have moved past it: none where that is not sure.
  std::optional<bool> hidden(int x, int y) const {
    const auto at = [&](int u, int v) -> const Found& { return found[std::size_t(v) * kWidth + std::size_t(u)]; };
    bool sure = true, past = false;
    const auto surface = [&](int dx, int dy) {
      for (int k = 1, u = x + dx, v = y + dy; k <= 4 && u >= 0 && u < kWidth && v >= 0 && v < kHeight;
           ++k, u += dx, v += dy) {
        const Found& there = at(u, v);
        sure &= there.sure;
        if (there.id == 0) continue;
        const glm::ivec2 moved = glm::abs(k * glm::ivec2(dx, dy) - there.from + at(x, y).from);
        const int farther = std::max(moved.x, moved.y) - k;
        past |= farther > 0;
        sure &= farther < 0 || farther > 1;  // where background comes from may be off by a pixel
        return true;
      }
      return false;
    };
    const bool left = surface(-1, 0), right = surface(1, 0), above = surface(0, 1), below = surface(0, -1);
    if (!sure) return std::nullopt;
    return past && ((left && right) || (above && below));
  }
};

/// Where the background of a ray lies, as PointImage has it.
dvec3 background_place(const core::View& view, std::size_t pixel) {
  const auto ray =
      core::image_ray(view, kWidth, kHeight, double(pixel % kWidth) + 0.5, kHeight - (double(pixel / kWidth) + 0.5));
  return ray->origin + (view.orthographic() ? 0.5 * (ray->t_min + ray->t_max) : 1e7) * ray->direction;
}

TEST_F(MovingImageTest, KeepsPointsWhereTheNextViewHasThem) {
  using Make = core::View (*)(double);
  for (const Make make : {Make(perspective), Make(orthographic)})
    for (const double step : {0.004, 0.03, 0.2}) {
      SCOPED_TRACE(step);
      const core::View before = make(0.3), after = make(0.3 + step);
      MovingImage image;
      draw(image, before, kNever);
      Follower twin;
      std::vector<bool> empty(kPixels);
      for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
        const auto found = hit(before, pixel, filter_of(before));
        empty[pixel] = !found;
        if (found) twin.add(after, found->point, to_index(found->item) + 1, pixel);
      }
      for (std::size_t pixel = 0; pixel < kPixels; ++pixel)
        twin.keep_background(before, pixel, background_place(after, pixel), empty);
      const auto counts = draw(image, after, -kNever);
      EXPECT_GT(counts.kept, std::int64_t(kPixels / 2));
      EXPECT_GT(counts.traced, 0);
      int compared = 0, wrong = 0, without = 0, doubtful = 0, hidden = 0;
      for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
        const std::uint8_t age = image.points().ages()[pixel];
        const Follower::Found& there = twin.found[pixel];
        const bool own = PointAge::shows_own(age) && age != PointAge::kAssumed;
        doubtful += age == PointAge::kDoubtful;
        if (age == PointAge::kNew) {
          expect_traced(image, after, pixel, filter_of(after));
        } else if (there.sure) {
          ++compared;
          const auto hides = twin.hidden(int(pixel % kWidth), int(pixel / kWidth));
          const bool hides_it = age >= PointAge::kHidden && age != PointAge::kNoPoint;
          without += !there.background && there.depth < 0.0;
          hidden += hides_it;
          wrong += own != (there.depth >= 0.0 || (there.background && !hides_it));
          wrong += own && image.points().pixels().ids[pixel] != there.id;
          if (there.background && hides) wrong += *hides != hides_it;
        }
      }
      EXPECT_EQ(wrong, 0) << "of " << compared;
      EXPECT_GT(compared, int(kPixels / 3));
      if (step > 0.01) {
        EXPECT_GT(without, 0);
        EXPECT_GT(doubtful, 0) << "points between nearer ones";
        EXPECT_LT(doubtful, int(kPixels / 10));
        EXPECT_GT(hidden, 0) << "background that surfaces have moved past";
      }
    }
}

/// A pixel without a point shows the farthest surface of the smallest cell about it that has any point.
TEST_F(MovingImageTest, FillsWithWhatLiesBehind) {
  MovingImage image;
  const core::View view = perspective(0.31);
  const auto first = draw(image, view, -kNever);  // hardly anything is traced
  EXPECT_GT(first.filled, std::int64_t(kPixels / 2));
  const PointImage& points = image.points();
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (PointAge::shows_own(points.ages()[points.at(x, y)])) continue;
      bool any = false;
      float depth = 2.0f;
      for (int side = 2; !any; side *= 2)
        for (int v = y / side * side; v < std::min(kHeight, (y / side + 1) * side); ++v)
          for (int u = x / side * side; u < std::min(kWidth, (x / side + 1) * side); ++u) {
            if (!PointAge::shows_own(points.ages()[points.at(u, v)])) continue;
            any = true;
            if (points.pixels().ids[points.at(u, v)] != 0)
              depth = std::min(depth, points.pixels().depths[points.at(u, v)]);
          }
      ASSERT_EQ(points.pixels().depths[points.at(x, y)], depth == 2.0f ? 0.0f : depth) << x << ", " << y;
      ASSERT_EQ(points.pixels().ids[points.at(x, y)] == 0, depth == 2.0f);
    }
}

/// An image that is there is as good as one that rays have made.
TEST_F(MovingImageTest, BeginsWithAnImageThatIsThere) {
  using Make = core::View (*)(double);
  for (const Make make : {Make(perspective), Make(orthographic)}) {
    MovingImage traced, begun;
    draw(traced, make(0.3), kNever);
    begun.begin(make(0.3), kWidth, kHeight, traced.points().pixels(), threads);
    EXPECT_TRUE(begun.shows(make(0.3)));
    EXPECT_EQ(draw(begun, make(0.3), -kNever).traced, std::int64_t(kPixels));
    draw(traced, make(0.33), -kNever);
    draw(begun, make(0.33), -kNever);
    int other = 0;
    for (std::size_t pixel = 0; pixel < kPixels; ++pixel)
      other += traced.points().pixels().ids[pixel] != begun.points().pixels().ids[pixel] ||
               traced.points().pixels().colours[pixel] != begun.points().pixels().colours[pixel];
    EXPECT_LE(other, int(kPixels / 100)) << "float depths put points on the borders of pixels into others";
  }
}

/// However little time each call has, the image of a view that stays becomes complete, and no pixel is traced twice.
TEST_F(MovingImageTest, BecomesCompleteAtRest) {
  MovingImage image, all;
  draw(image, perspective(0.0), kNever);
  std::int64_t traced = 0;
  int calls = 0;
  for (MovingImage::Counts counts; calls < 100 && traced < std::int64_t(kPixels); ++calls) {
    counts = draw(image, perspective(0.1), -kNever);
    EXPECT_GT(counts.traced, traced);
    traced = counts.traced;
  }
  EXPECT_GT(calls, 3);
  draw(all, perspective(0.1), kNever);
  EXPECT_TRUE(std::ranges::equal(image.points().pixels().ids, all.points().pixels().ids));
  EXPECT_TRUE(std::ranges::equal(image.points().pixels().colours, all.points().pixels().colours));
  EXPECT_TRUE(std::ranges::equal(image.points().pixels().depths, all.points().pixels().depths));
}

/// The oldest points are traced first, and an image has the time for a twenty-fourth of its blocks at least. The
/// sky, which most likely stays, waits longer than surfaces do, but not for ever.
TEST_F(MovingImageTest, KeepsNoPointForLong) {
  MovingImage image;
  draw(image, perspective(0.0), kNever);
  int oldest = 0;
  std::vector<bool> again(kPixels);
  for (int step = 1; step <= 200; ++step) {
    draw(image, perspective(1e-5 * step), -kNever);
    for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
      const std::uint8_t age = image.points().ages()[pixel];
      if (age == PointAge::kNew) again[pixel] = true;
      if (age <= PointAge::kOldest && image.points().pixels().ids[pixel] != 0) oldest = std::max(oldest, int(age));
    }
  }
  EXPECT_GT(oldest, 8);
  EXPECT_LE(oldest, 26);
  EXPECT_EQ(std::ranges::count(again, false), 0);
}

/// Where little time meets a new view, a sixteenth of the pixels has points. The sky is assumed between them where they
/// and those around show nothing else, and rays look for it again.
TEST_F(MovingImageTest, AssumesTheSkyAmongItsPoints) {
  MovingImage image;
  const core::View view = perspective(0.31);
  const auto counts = draw(image, view, -kNever);
  std::int64_t assumed = 0, without = 0, wrong = 0;
  for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
    const std::uint8_t age = image.points().ages()[pixel];
    assumed += age == PointAge::kAssumed;
    without += age == PointAge::kNoPoint;
    if (age != PointAge::kAssumed) continue;
    EXPECT_EQ(image.points().pixels().ids[pixel], 0u);
    wrong += hit(view, pixel, filter_of(view)).has_value();
  }
  EXPECT_GT(assumed, std::int64_t(kPixels / 20));
  EXPECT_LT(wrong, assumed / 50);
  EXPECT_EQ(counts.filled, assumed + without);
  EXPECT_EQ(draw(image, view, kNever).traced, std::int64_t(kPixels));
}

TEST_F(MovingImageTest, KnowsNothingOfForgottenPoints) {
  MovingImage image, fresh;
  draw(image, perspective(0.0), kNever);
  image.forget();
  EXPECT_EQ(draw(image, perspective(0.0), -kNever).kept, 0);
  core::View cut = perspective(0.0);
  cut.sections.push_back({{0, -1, 0}, 0.5});
  EXPECT_EQ(draw(image, cut, -kNever).kept, 0);
  const auto counts = image.draw(request(cut, kWidth / 2), threads, -kNever);
  ASSERT_TRUE(counts);
  EXPECT_EQ(counts->kept, 0);
}

double seconds_of_test = 0.0;
double tick() {
  return seconds_of_test += 1e-3;
}

/// By a clock that a look at it moves on by a millisecond, as tracing a block does here. The first image is drawn by
/// it, too: what it takes tells the second how early its rays have to end.
TEST_F(MovingImageTest, EndsAtItsDeadline) {
  MovingImage image;
  core::use_clock(tick);
  core::ThreadPool one(1);
  ASSERT_TRUE(image.draw(request(perspective(0.0)), one, kNever));
  const double begin = core::now_seconds();
  const auto counts = image.draw(request(perspective(0.1)), one, begin + 0.050);
  const double taken = core::now_seconds() - begin;
  core::use_clock(nullptr);
  ASSERT_TRUE(counts);
  EXPECT_GT(counts->kept, 0);
  EXPECT_LT(taken, 0.06) << "tracing all blocks takes 0.1 s";
  EXPECT_GT(counts->traced, 32 * 256);
  EXPECT_LT(counts->traced, 48 * 256);
}

}  // namespace
}  // namespace sightline::raytrace::moving_image_test
