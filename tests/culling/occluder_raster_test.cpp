// The occluder raster against exact arithmetic: what a pixel holds, its line of sight meets.
#include "sightline/culling/occlusion/occluder_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "exact_samples.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::occluder_raster_test {
namespace {

using core::AabbD;
using core::Affine;
using core::dvec3;
using culling::DepthPyramid;
using culling::OccluderRaster;
using ExactPoint = std::array<mpq_class, 3>;

constexpr float kNothing = std::numeric_limits<float>::infinity();

ExactPoint exact(const dvec3& p) {
  return {mpq_class(p.x), mpq_class(p.y), mpq_class(p.z)};
}
ExactPoint minus(const ExactPoint& a, const ExactPoint& b) {
  return {mpq_class(a[0] - b[0]), mpq_class(a[1] - b[1]), mpq_class(a[2] - b[2])};
}
mpq_class determinant(const ExactPoint& a, const ExactPoint& b, const ExactPoint& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/// A part of a line, from `low` to `high`; `low` > `high`: none.
struct Interval {
  mpq_class low, high;

  /// Leaves where at + s * slope >= 0.
  void clip(const mpq_class& at, const mpq_class& slope) {
    if (slope == 0) {
      if (at < 0) high = low - 1;
      return;
    }
    const mpq_class s = -at / slope;
    if (slope > 0)
      low = std::max(low, s);
    else
      high = std::min(high, s);
  }
  void clip(const Form& form, const ExactLine& line) {
    const mpq_class at = value(form, line.at);
    clip(at, value(form, line.point(1)) - at);
  }
};

enum class Shape { kCube, kCylinder, kTriangle };

/// An occluder: one in a placement, or a triangle with corners in the columns of `placement.linear`.
struct Occluder {
  Shape shape;
  Affine placement;

  /// Whether the line meets it within the interval, which is not empty.
  bool met(const ExactLine& line, Interval part) const {
    const auto column = [&](int i) { return exact(placement.linear[i]); };
    if (shape == Shape::kTriangle) {
      const ExactPoint a = column(0), u = minus(column(1), a), v = minus(column(2), a), to = minus(line.at, a);
      // at + s along = a + b u + c v.
      const mpq_class whole = determinant(u, v, line.along);
      if (whole == 0) return false;
      const mpq_class b = determinant(to, v, line.along) / whole, c = determinant(u, to, line.along) / whole,
                      s = -determinant(u, v, to) / whole;
      return b >= 0 && c >= 0 && b + c <= 1 && part.low <= s && s <= part.high;
    }
    const ExactPoint x = column(0), y = column(1), z = column(2), to = minus(line.at, exact(placement.origin));
    const mpq_class whole = determinant(x, y, z);
    if (whole == 0) return false;
    const auto own = [&](const ExactPoint& p) {
      return ExactPoint{mpq_class(determinant(p, y, z) / whole), mpq_class(determinant(x, p, z) / whole),
                        mpq_class(determinant(x, y, p) / whole)};
    };
    const ExactPoint at = own(to), along = own(line.along);
    for (std::size_t i = shape == Shape::kCube ? 0 : 2; i < 3; ++i) {
      part.clip(1 + at[i], along[i]);
      part.clip(1 - at[i], -along[i]);
    }
    if (part.low > part.high || shape == Shape::kCube) return part.low <= part.high;
    // The least distance from the axis.
    const mpq_class square = along[0] * along[0] + along[1] * along[1];
    mpq_class s = part.low;
    if (square != 0) s = -(at[0] * along[0] + at[1] * along[1]) / square;
    s = std::max(part.low, std::min(part.high, s));
    const mpq_class px = at[0] + s * along[0], py = at[1] + s * along[1];
    return px * px + py * py <= 1;
  }

  void add(OccluderRaster& raster, int sides) const {
    if (shape == Shape::kCube) {
      raster.add_cube(placement);
    } else if (shape == Shape::kCylinder) {
      raster.add_cylinder(placement, sides);
    } else {
      const dvec3 middle = placement.linear[0];  // exact in float: mesh coordinates are
      const core::vec3 positions[] = {core::vec3(placement.linear[0] - middle),
                                      core::vec3(placement.linear[1] - middle),
                                      core::vec3(placement.linear[2] - middle)};
      const std::uint32_t indices[] = {0, 1, 2};
      raster.add_mesh(positions, indices, core::translation(middle));
    }
  }
};

/// A line of sight and what of it the near plane leaves.
struct Sight {
  ExactLine line;
  Interval part;
};

class ExactImage {
 public:
  ExactImage(const View& view, const ImageSamples& samples)
      : depth_(view.clip_depth()), exact_(view, dvec3(0.0), samples) {}

  std::optional<Sight> sight(int x, int y, float ox = 0.0f, float oy = 0.0f) const {
    const auto line = exact_.line(x, y, ox, oy);
    if (!line) return std::nullopt;
    Sight sight{*line, {mpq_class(-kFar), mpq_class(kFar)}};
    sight.part.clip(exact_.clip(3), sight.line);
    Form near = tests::minus(exact_.clip(2), core::near_depth(depth_), exact_.clip(3));
    if (core::far_depth(depth_) < core::near_depth(depth_))
      for (mpq_class& c : near) c = -c;
    sight.part.clip(near, sight.line);
    return sight;
  }
  /// Whether the line meets any of the occluders, at `distance` or nearer.
  bool met(const Sight& sight, std::span<const Occluder> occluders, float distance = kNothing) const {
    Interval part = sight.part;
    if (distance < kNothing) {
      Form nearer = exact_.distance();
      for (mpq_class& c : nearer) c = -c;
      nearer[3] += mpq_class(double(distance));
      part.clip(nearer, sight.line);
    }
    if (part.low > part.high) return false;
    for (const Occluder& occluder : occluders)
      if (occluder.met(sight.line, part)) return true;
    return false;
  }
  /// Whether the occluder holds the line's point on the near plane, or the eye.
  bool starts_in(const Sight& sight, const Occluder& occluder) const {
    const bool from_low = value(exact_.distance(), sight.line.point(1)) > value(exact_.distance(), sight.line.at);
    const mpq_class& s = from_low ? sight.part.low : sight.part.high;
    return occluder.met(sight.line, {s, s});
  }

 private:
  static constexpr double kFar = 1e200;  // of the line's parameter
  core::ClipDepth depth_;
  ExactSamples exact_;
};

/// A point that lies on a sample's line of sight but for rounding, in front of the near plane.
dvec3 point_at_a_sample(Random& random, const View& view, const ImageSamples& samples) {
  const double u = (2.0 * whole(random, -1, samples.width) + 1.0) / samples.width - 1.0;
  const double v = (2.0 * whole(random, -1, samples.height) + 1.0) / samples.height - 1.0;
  const core::dvec4 p = glm::inverse(view.clip_from_world()) * core::dvec4(u, v, uniform(random, 0.01, 0.99), 1.0);
  return dvec3(p) / p.w;
}

Occluder random_occluder(Random& random, const View& view, double half, const ImageSamples& samples) {
  Occluder occluder{Shape(whole(random, 0, 2)), {}};
  const auto place = [&] {
    return chance(random, 0.5) ? point_at_a_sample(random, view, samples) : point(random, half);
  };
  core::dmat3& linear = occluder.placement.linear;
  if (occluder.shape == Shape::kTriangle) {
    const dvec3 first = dvec3(core::vec3(place()));
    const double size = chance(random, 0.5) ? 0.0 : half * magnitude(random, 1e-3, 10.0);
    for (int i = 0; i < 3; ++i) {
      const dvec3 corner = size == 0.0 ? place() : first + point(random, size);
      linear[i] = i == 0 ? first : first + dvec3(core::vec3(corner - first));
    }
    if (chance(random, 0.1)) linear[2] = 0.5 * linear[0] + 0.5 * linear[1] + point(random, 1e-6 * half);  // a sliver
    return occluder;
  }
  if (occluder.shape == Shape::kCube && chance(random, 0.5)) {
    // Axis-aligned, with faces, edges and corners at lines of sight.
    const dvec3 a = place(), b = chance(random, 0.5) ? place() : a + point(random, half * magnitude(random, 1e-2, 2.0));
    occluder.placement.origin = 0.5 * (a + b);
    linear = core::dmat3(0.0);
    for (int i = 0; i < 3; ++i) linear[i][i] = 0.5 * std::abs(a[i] - b[i]);
    return occluder;
  }
  for (int i = 0; i < 3; ++i) linear[i] = point(random, half * magnitude(random, 1e-2, 3.0));
  if (chance(random, 0.1)) linear[whole(random, 0, 2)] *= 1e-9;
  occluder.placement.origin = place();
  if (chance(random, 0.2)) occluder.placement.origin += linear * point(random, 1.0);
  return occluder;
}

/// The line of sight, and those at all sides of it, enter the occluder beyond the near plane, and the eye is not so
/// near to it that places in the image lose their digits.
bool clearly_covered(const ExactImage& exact, const Occluder& occluder, double half, int x, int y) {
  constexpr float kAside = 0.2f;  // more than an outline moves inwards
  const core::dmat3& m = occluder.placement.linear;
  const double size = half + glm::length(m[0]) + glm::length(m[1]) + glm::length(m[2]);
  constexpr float kPlaces[][2] = {{0, 0}, {kAside, kAside}, {-kAside, kAside}, {kAside, -kAside}, {-kAside, -kAside}};
  for (const auto& [ox, oy] : kPlaces) {
    const auto sight = exact.sight(x, y, ox, oy);
    if (!sight || !exact.met(*sight, {&occluder, 1}) || exact.starts_in(*sight, occluder)) return false;
    if (exact.met(*sight, {&occluder, 1}, float(1e-3 * size))) return false;
  }
  return true;
}

/// Any line of sight through a pixel that holds a distance meets an occluder. Nearly all pixels that cubes and
/// triangles clearly cover hold one.
TEST(OccluderRaster, CoversOnlyWhatIsMetAndNoNearer) {
  std::size_t covered = 0, clearly = 0, lost = 0;
  for (int seed = 1; seed <= tests::repeated(700); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = magnitude(random, 1e-3, 1e4);
    const View view = random_view(random, dvec3(0.0), half);
    const ImageSamples samples{whole(random, 1, 21), whole(random, 1, 9), {{0, 0}}};
    const ExactImage exact(view, samples);
    OccluderRaster raster;
    raster.begin(view, samples.width, samples.height);
    std::vector<Occluder> occluders;
    for (int i = whole(random, 1, 3); i > 0; --i) {
      occluders.push_back(random_occluder(random, view, half, samples));
      occluders.back().add(raster, whole(random, 3, 16));
    }
    std::vector<float> distances(std::size_t(samples.width * samples.height));
    raster.distances(distances);
    for (int y = 0; y < samples.height; ++y) {
      for (int x = 0; x < samples.width; ++x) {
        const float distance = distances[std::size_t(y * samples.width + x)];
        ASSERT_FALSE(std::isnan(distance));
        if (distance < kNothing) {
          const auto sight = exact.sight(x, y);
          ASSERT_TRUE(sight && exact.met(*sight, occluders, distance)) << "pixel " << x << " " << y << " " << distance;
          ++covered;
        }
        for (const Occluder& occluder : occluders) {
          if (occluder.shape == Shape::kCylinder || !clearly_covered(exact, occluder, half, x, y)) continue;
          ++clearly;
          lost += distance == kNothing;
        }
      }
    }
  }
  EXPECT_GT(covered, std::size_t(tests::repeated(6'000)));
  EXPECT_GT(clearly, std::size_t(tests::repeated(2'500)));
  EXPECT_LT(lost, clearly / 100) << "of " << clearly;
}

constexpr int kWidth = 321, kHeight = 187;

View view_from(const dvec3& eye, const dvec3& target, double near = 0.1) {
  return *View::perspective({eye, target, {0, 0, 1}}, 1.0, double(kWidth) / kHeight, near);
}

struct Image {
  std::vector<float> distances = std::vector<float>(std::size_t(kWidth) * kHeight);

  template <class Add>
  Image(const View& view, const Add& add) {
    OccluderRaster raster;
    raster.begin(view, kWidth, kHeight);
    add(raster);
    raster.distances(distances);
  }
  std::size_t covered() const {
    return std::size_t(std::count_if(distances.begin(), distances.end(), [](float d) { return d < kNothing; }));
  }
};

/// Where the line of sight through a pixel enters a box, in double.
double entry(const View& view, const AabbD& box, int x, int y) {
  const core::dmat4 world_from_clip = glm::inverse(view.clip_from_world());
  const core::dvec4 ndc((2.0 * x + 1.0) / kWidth - 1.0, (2.0 * y + 1.0) / kHeight - 1.0, 0.5, 1.0);
  const core::dvec4 at = world_from_clip * ndc;
  const dvec3 eye = view.eye(), along = dvec3(at) / at.w - eye;
  double first = 0.0, last = 1e30;
  for (int i = 0; i < 3; ++i) {
    const double a = (box.min[i] - eye[i]) / along[i], b = (box.max[i] - eye[i]) / along[i];
    first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
  }
  const double scale = -(view.eye_from_world() * core::dvec4(along, 0.0)).z;
  return first < last ? first * scale : std::numeric_limits<double>::infinity();
}

/// Nearly every pixel of a box, at nearly its distance; alike far from the world's origin, mirrored, as a mesh, and
/// where the near plane cuts it.
TEST(OccluderRaster, LosesLittle) {
  struct Case {
    dvec3 eye, target;
    AabbD box;
  };
  const Case cases[] = {{{0, 0, 0}, {1, 3, -0.5}, {{-1, 5, -2}, {2, 7, 1}}},
                        {{3e6, -2e6, 40}, {3e6 + 1, -2e6 + 3, 40}, {{3e6 - 1, -2e6 + 5, 38}, {3e6 + 2, -2e6 + 7, 41}}},
                        {{0, 0, 1.7}, {0, 10, 1}, {{-200, -50, -1}, {200, 50, 0}}},  // stands on it
                        {{0, 0, 1}, {0, 10, 1}, {{-1, 3, 0}, {1, 4, 1}}}};           // the eye is level with its top
  for (const Case& c : cases) {
    const AabbD& box = c.box;
    SCOPED_TRACE(testing::Message() << "eye at " << c.eye.x << " " << c.eye.y << " " << c.eye.z);
    const View view = view_from(c.eye, c.target);
    const dvec3 half = 0.5 * box.size();
    const Affine placement{{{half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z}}, box.centre()};
    Affine mirrored = placement;
    mirrored.linear[1] *= -1.0;
    std::vector<core::vec3> corners;
    for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    const std::vector<std::uint32_t> triangles = {0, 1, 3, 0, 3, 2, 4, 7, 5, 4, 6, 7, 0, 5, 1, 0, 4, 5,
                                                  2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    const Image images[] = {{view, [&](OccluderRaster& r) { EXPECT_TRUE(r.add_box(box)); }},
                            {view, [&](OccluderRaster& r) { EXPECT_TRUE(r.add_cube(mirrored)); }},
                            {view, [&](OccluderRaster& r) { r.add_mesh(corners, triangles, placement); }}};
    for (const Image& image : images) {
      std::size_t expected = 0;
      double worst = 1.0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const double exact = entry(view, box, x, y);
          const float found = image.distances[std::size_t(y * kWidth + x)];
          ASSERT_GE(found, exact * (1.0 - 1e-9));
          expected += exact < kNothing;
          if (found < kNothing && exact < 50.0) worst = std::max(worst, found / exact);
        }
      }
      EXPECT_GT(expected, 1000u);
      EXPECT_GT(image.covered(), expected * 96 / 100);
      EXPECT_LT(worst, 1.02);
    }
  }
}

TEST(OccluderRaster, CylindersHideMoreTheMoreSidesTheyHave) {
  const View view = view_from({0, 0, 0}, {0, 10, 0});
  const Affine standing{{{2, 0, 0}, {0, 2, 0}, {0, 0, 5}}, {0, 10, 0}};
  std::size_t before = 0;
  for (const int sides : {3, 6, 12, 16}) {
    const Image image(view, [&](OccluderRaster& r) { EXPECT_TRUE(r.add_cylinder(standing, sides)); });
    EXPECT_GT(image.covered(), before);
    before = image.covered();
  }
  const Image box(view, [](OccluderRaster& r) { r.add_box(AabbD{{-2, 8, -5}, {2, 12, 5}}); });
  EXPECT_GT(before, box.covered() * 8 / 10);
  EXPECT_LT(before, box.covered());
}

TEST(OccluderRaster, AMeshHasNoGapsBetweenItsTriangles) {
  std::vector<core::vec3> positions;
  std::vector<std::uint32_t> indices;
  const int rows = 40, columns = 80;
  for (int i = 0; i <= rows; ++i)
    for (int k = 0; k <= columns; ++k) {
      const double a = std::numbers::pi * i / rows, b = 2.0 * std::numbers::pi * k / columns;
      positions.emplace_back(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
    }
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < columns; ++k) {
      const auto at = std::uint32_t(i * (columns + 1) + k), above = at + std::uint32_t(columns) + 1;
      indices.insert(indices.end(), {at, at + 1, above, at + 1, above + 1, above});
    }
  const View view = view_from({0.1, -5, 0.3}, {0, 0, 0});
  const Image image(view, [&](OccluderRaster& r) { r.add_mesh(positions, indices, {core::dmat3(2.0), {}}); });
  EXPECT_GT(image.covered(), 10'000u);
  for (int y = 0; y < kHeight; ++y) {
    const float* row = image.distances.data() + y * kWidth;
    int changes = 0;
    for (int x = 1; x < kWidth; ++x) changes += (row[x] < kNothing) != (row[x - 1] < kNothing);
    ASSERT_LE(changes, 2) << "row " << y;
  }
}

/// A section plane that cuts an occluder, or removes it, leaves none of it; of a mesh, none of the triangle.
TEST(OccluderRaster, WhatIsCutHidesNothing) {
  const AabbD box{{-1, 5, -1}, {1, 7, 1}};
  const core::vec3 positions[] = {{-1, 5, -1}, {1, 5, -1}, {1, 5, 1}, {-1, 5, 1}};
  const std::uint32_t indices[] = {0, 1, 2, 0, 2, 3};
  const auto covered = [&](std::vector<core::Plane> planes, core::SectionMode mode) {
    View view = view_from({0, 0, 0}, {0, 1, 0});
    view.sections = std::move(planes);
    view.section_mode = mode;
    const std::size_t solid = Image(view, [&](OccluderRaster& r) { r.add_box(box); }).covered();
    const std::size_t mesh = Image(view, [&](OccluderRaster& r) { r.add_mesh(positions, indices, {}); }).covered();
    return std::pair(solid, mesh);
  };
  const core::Plane keeps{{0, 1, 0}, -4.0}, cuts{{0, 1, 0}, -6.0}, removes{{0, 1, 0}, -8.0}, none{{0, 0, 0}, -1.0};
  const core::Plane cuts_a_corner{{1, 0, -1}, 1.0};  // of the second triangle
  using enum core::SectionMode;
  const auto [solid, mesh] = covered({}, kIntersection);
  EXPECT_GT(solid, 1000u);
  EXPECT_GT(mesh, 1000u);
  const std::pair whole(solid, mesh), nothing(std::size_t(0), std::size_t(0));
  EXPECT_EQ(covered({keeps, none}, kIntersection), whole);
  EXPECT_EQ(covered({keeps, removes}, kIntersection), nothing);
  EXPECT_EQ(covered({cuts}, kIntersection), nothing);
  EXPECT_EQ(covered({keeps, removes}, kUnion), whole);
  EXPECT_EQ(covered({cuts, removes}, kUnion), nothing);
  EXPECT_EQ(covered({none}, kUnion), whole);
  EXPECT_EQ(covered({{{0, 1, 0}, -5.0}}, kIntersection), nothing) << "touches";
  const auto [cut, half] = covered({cuts_a_corner}, kIntersection);
  EXPECT_EQ(cut, 0u);
  EXPECT_GT(half, mesh / 3);
  EXPECT_LT(half, 2 * mesh / 3);
}

TEST(OccluderRaster, LeavesOutWhatItCannotJudge) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const View view = view_from({0, 0, 0}, {0, 1, 0});
  OccluderRaster raster;
  raster.begin(view, kWidth, kHeight);
  EXPECT_FALSE(raster.add_box(AabbD{}));
  EXPECT_FALSE(raster.add_box(AabbD{dvec3(-1.0), dvec3(1.0)})) << "around the eye";
  EXPECT_FALSE(raster.add_box(AabbD{{-1, -7, -1}, {1, -5, 1}})) << "behind the eye";
  EXPECT_FALSE(raster.add_box(AabbD{{-1, 5, -1}, {1, inf, 1}}));
  EXPECT_FALSE(raster.add_box(AabbD{{-1, 5, -1}, {1, 1e200, 1}}));
  EXPECT_FALSE(raster.add_box(AabbD{{-1, 5, nan}, {1, 7, 1}}));
  EXPECT_FALSE(raster.add_box(AabbD{{100, 5, -1}, {101, 7, 1}})) << "beside the image";
  EXPECT_FALSE(raster.add_box(AabbD{{0, 5, 0}, {1e-6, 5, 1e-6}})) << "smaller than a pixel";
  EXPECT_FALSE(raster.add_cube(Affine{core::dmat3(nan), {0, 5, 0}}));
  EXPECT_FALSE(raster.add_cylinder(Affine{core::dmat3(0.0), {0, 5, 0}}));
  const core::vec3 positions[] = {{0, 5, 0}, {float(nan), 5, 0}, {1, 5, 1}, {1, 5, 1}};
  const std::uint32_t indices[] = {0, 1, 2, 0, 2, 3, 2, 3, 3};
  raster.add_mesh(positions, indices, {});
  raster.add_mesh({}, {}, {});
  std::vector<float> distances(std::size_t(kWidth) * kHeight);
  raster.distances(distances);
  for (const float d : distances) ASSERT_EQ(d, kNothing);

  // A combined matrix does not tell where the eye is.
  const View combined = *View::from_matrices(core::dmat4(1.0), view.clip_from_world(), view.clip_depth());
  raster.begin(combined, kWidth, kHeight);
  EXPECT_FALSE(raster.add_box(AabbD{{-1, 5, -1}, {1, 7, 1}}));
  // Scaled, it is the same view.
  const View scaled = *View::from_matrices(view.eye_from_world(), 3.0 * view.clip_from_eye(), view.clip_depth());
  const auto add = [](OccluderRaster& r) { EXPECT_TRUE(r.add_box(AabbD{{-1, 5, -1}, {1, 7, 1}})); };
  EXPECT_EQ(Image(scaled, add).covered(), Image(view, add).covered());
}

/// The nearest occluder counts, in any order, and the same with any instructions.
TEST(OccluderRaster, IsTheSameInAnyOrderAndForm) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = 10.0;
    const View view = random_view(random, dvec3(0.0), half);
    const ImageSamples samples{whole(random, 1, 150), whole(random, 1, 90), {{0, 0}}};
    std::vector<Occluder> occluders;
    for (int i = 0; i < 30; ++i) occluders.push_back(random_occluder(random, view, half, samples));
    std::vector<float> expected(std::size_t(samples.width * samples.height)), found = expected;
    const auto draw = [&](std::vector<float>& out) {
      OccluderRaster raster;
      raster.begin(view, samples.width, samples.height);
      for (const Occluder& occluder : occluders) occluder.add(raster, 7);
      raster.distances(out);
    };
    draw(expected);
    std::reverse(occluders.begin(), occluders.end());
    for_each_instruction_set([&] {
      draw(found);
      ASSERT_EQ(found, expected);
    });
  }
}

TEST(OccluderRaster, JoinsImages) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const View view = random_view(random, dvec3(0.0), 10.0);
    const ImageSamples samples{whole(random, 1, 90), whole(random, 1, 50), {{0, 0}}};
    std::array<OccluderRaster, 4> rasters;  // the last one with all
    for (OccluderRaster& raster : rasters) raster.begin(view, samples.width, samples.height);
    for (int i = 0; i < 12; ++i) {
      const Occluder occluder = random_occluder(random, view, 10.0, samples);
      occluder.add(rasters[std::size_t(whole(random, 0, 2))], 7);
      occluder.add(rasters[3], 7);
    }
    std::vector<float> expected(std::size_t(samples.width * samples.height)), found = expected;
    rasters[3].distances(expected);
    for_each_instruction_set([&] {
      rasters[0].distances(found, std::array<const OccluderRaster*, 2>{&rasters[1], &rasters[2]});
      ASSERT_EQ(found, expected);
    });
  }
}

TEST(OccluderRaster, AddsTheLargestFirst) {
  const View view = view_from({0, 0, 0}, {0, 1, 0});
  const std::vector<AabbD> solids = {{{-1, 50, -1}, {1, 52, 1}},    {{2, 5, -1}, {4, 6, 1}},
                                     {{-1, -9, -1}, {1, -5, 1}},    {{-9, -9, -9}, {9, 9, 9}},
                                     {{-50, 30, -1}, {50, 31, 20}}, {}};
  for (std::size_t count = 0; count <= 4; ++count) {
    std::size_t added = 0;
    const Image image(view, [&](OccluderRaster& r) { added = r.add_largest(solids, count); });
    const Image expected(view, [&](OccluderRaster& r) {
      const std::size_t order[] = {4, 1, 0};
      for (std::size_t i = 0; i < std::min<std::size_t>(count, 3); ++i) r.add_box(solids[order[i]]);
    });
    EXPECT_EQ(added, std::min<std::size_t>(count, 3));
    EXPECT_EQ(image.distances, expected.distances);
  }
}

/// A wall hides what is behind it, through the pyramid.
TEST(OccluderRaster, FeedsTheOcclusionTest) {
  for (const bool orthographic : {false, true}) {
    View view = view_from({0, 0, 0}, {0, 1, 0});
    if (orthographic)
      view = *View::orthographic({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 20.0, double(kWidth) / kHeight, -50, 100);
    OccluderRaster raster;
    raster.begin(view, kWidth, kHeight);
    EXPECT_TRUE(raster.add_box(AabbD{{-3, 10, -3}, {3, 11, 3}}));
    DepthPyramid pyramid;
    raster.build(pyramid);
    const culling::OcclusionTest test(view, dvec3(0.0), kWidth, kHeight, pyramid);
    EXPECT_TRUE(test.occluded({{-1, 12, -1}, {1, 14, 1}}));
    EXPECT_TRUE(test.occluded({{-1, 10.2f, -1}, {1, 10.5f, 1}})) << "within the wall";
    EXPECT_FALSE(test.occluded({{-1, 9.9f, -1}, {1, 14, 1}}));
    EXPECT_FALSE(test.occluded({{-1, 12, -1}, {5, 14, 1}}));
    raster.begin(view, kWidth, kHeight);
    raster.build(pyramid);
    EXPECT_FALSE(test.occluded({{-1, 12, -1}, {1, 14, 1}})) << "begun anew";
  }
}

}  // namespace
}  // namespace sightline::tests::occluder_raster_test
