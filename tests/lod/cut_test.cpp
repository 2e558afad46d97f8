// What a view draws of a mesh: errors as large as allowed move no visible point by more pixels than that, boxes left
// out show nothing, and cuts are consistent.
#include "sightline/lod/internal/cut.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "sightline/lod/stored_levels.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/lod/mesh_samples.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::cut_test {
namespace {

using core::dvec2;
using core::dvec3;
using core::dvec4;

constexpr int kWidth = 640, kHeight = 360;

core::View any_view(Random& random, const dvec3& about, double distance) {
  const core::Pose pose{about + distance * random_direction(random), about + 0.2 * distance * random_direction(random),
                        random_direction(random)};
  const double near = distance * uniform(random, 1e-3, 0.5);
  const double far = random() % 2 ? core::kInfiniteFar : 100.0 * distance;
  switch (random() % 3) {
    case 0:
      return *core::View::perspective(pose, uniform(random, 0.1, 2.6), 16.0 / 9.0, near, far);
    case 1:
      return *core::View::orthographic(pose, distance * uniform(random, 0.01, 3.0), 16.0 / 9.0, -distance,
                                       10.0 * distance);
    default: {
      const double left = near * uniform(random, -2, 1), bottom = near * uniform(random, -2, 1);
      return *core::View::asymmetric(pose, left, left + near * uniform(random, 0.1, 3), bottom,
                                     bottom + near * uniform(random, 0.1, 3), near, far);
    }
  }
}

core::Affine any_placement(Random& random, double far) {
  core::Affine a{uniform(random, 0.1, 10.0) * random_rotation(random), {}};
  if (random() % 2) a.linear = a.linear * core::dmat3(1, 0, 0, uniform(random, -2, 2), 0.2, 0, 0.5, 0.3, 3);
  if (random() % 3 == 0) a.linear[0] = -a.linear[0];
  for (int i = 0; i < 3; ++i) a.origin[i] = uniform(random, -far, far);
  return a;
}

core::Aabb any_box(Random& random) {
  core::Aabb box;
  for (int i = 0; i < 2; ++i) {
    const core::vec3 p(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    box.grow({p, p});
  }
  return box;
}

dvec3 point_in(const core::Aabb& box, Random& random) {
  dvec3 p;
  for (int i = 0; i < 3; ++i)
    p[i] = random() % 3 ? uniform(random, box.min[i], box.max[i]) : random() % 2 ? box.min[i] : box.max[i];
  return p;
}

struct Stage {
  core::View view;
  core::Affine world_from_mesh;
  core::dmat4 clip;

  Stage(Random& random, double far) : Stage(random, any_placement(random, far)) {}
  Stage(Random& random, const core::Affine& placement)
      : view(any_view(random, placement.origin, uniform(random, 0.5, 30.0))),
        world_from_mesh(placement),
        clip(view.clip_from_world()) {}
  dvec4 in_clip(const dvec3& p) const { return clip * dvec4(core::transform_point(world_from_mesh, p), 1.0); }
  /// Inside the image and beyond the near plane, that is in the view volume.
  bool visible(const dvec3& p) const {
    for (const core::Plane& plane : core::frustum_planes(clip, view.clip_depth()))
      if (core::evaluate(plane, core::transform_point(world_from_mesh, p)) < 0.0) return false;
    return true;
  }
  static dvec2 pixel(const dvec4& c) { return {0.5 * kWidth * c.x / c.w, 0.5 * kHeight * c.y / c.w}; }
};

TEST(MeshError, AllowsNoErrorThatMovesAVisiblePointFarther) {
  double tightest = 0.0;
  int checked = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(3000)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stage stage(random, seed % 4 == 0 ? 1e5 : 10.0);
    const double pixels = std::pow(10.0, uniform(random, -2.0, 2.0));
    const lod::MeshError error(lod::ImageError(stage.view, kWidth, kHeight, pixels), stage.world_from_mesh);
    const core::Aabb box = any_box(random);
    const double allowed = error.allowed(box);
    if (allowed < 0.0) continue;
    for (int i = 0; i < 40; ++i) {
      const dvec3 p = point_in(box, random);
      if (!stage.visible(p)) continue;
      const dvec3 q = p + allowed * random_direction(random);
      const dvec4 at = stage.in_clip(q);
      ASSERT_GT(at.w, 0.0);
      const double moved = glm::length(stage.pixel(at) - stage.pixel(stage.in_clip(p)));
      ASSERT_LE(moved, pixels * (1.0 + 1e-6));
      tightest = std::max(tightest, moved / pixels);
      ++checked;
    }
  }
  EXPECT_GT(checked, 2000);
  EXPECT_GT(tightest, 0.9) << "the bound is nearly reached";
}

using Long = long double;

/// MeshError in long double, by definitions: forms of mesh coordinates from the matrix, and the largest move of a point
/// in the image by trying the directions of the image.
struct ErrorTwin {
  std::array<std::array<Long, 4>, 4> rows{};  // of clip coordinates, as forms of mesh coordinates
  Long nearest = 0.0L;                        // least w beyond the near plane

  ErrorTwin(const core::View& view, const core::Affine& world_from_mesh) {
    const core::dmat4 clip = view.clip_from_world();
    for (int row = 0; row < 4; ++row)
      for (int i = 0; i < 4; ++i) {
        Long& sum = rows[std::size_t(row)][std::size_t(i)];
        for (int k = 0; k < 3; ++k)
          sum += Long(clip[k][row]) * Long(i < 3 ? world_from_mesh.linear[i][k] : world_from_mesh.origin[k]);
        if (i == 3) sum += Long(clip[3][row]);
      }
    const core::dmat4& eye = view.clip_from_eye();
    const Long depth = core::near_depth(view.clip_depth());
    const Long z = -(Long(eye[3][2]) - depth * Long(eye[3][3])) / (Long(eye[2][2]) - depth * Long(eye[2][3]));
    nearest = std::max(0.0L, Long(eye[2][3]) * z + Long(eye[3][3]));
  }

  static Long least(const std::array<Long, 4>& form, const core::Aabb& box) {
    Long sum = form[3];
    for (int i = 0; i < 3; ++i)
      sum += std::min(form[std::size_t(i)] * Long(box.min[i]), form[std::size_t(i)] * Long(box.max[i]));
    return sum;
  }
  /// Length of what moves a point along one direction of the image most, in pixels of clip coordinates.
  Long move(Long right, Long up, Long direction) const {
    Long square = 0.0L;
    for (std::size_t i = 0; i < 3; ++i) {
      const Long x = 0.5L * kWidth * (rows[0][i] - right * rows[3][i]);
      const Long y = 0.5L * kHeight * (rows[1][i] - up * rows[3][i]);
      const Long along = std::cos(direction) * x + std::sin(direction) * y;
      square += along * along;
    }
    return std::sqrt(square);
  }
  /// Over all directions, of which the half turns about the best of some have only one maximum.
  Long largest_move(Long right, Long up) const {
    constexpr Long kStep = std::numbers::pi_v<Long> / 32;
    Long best = 0.0L;
    for (int i = 1; i < 32; ++i)
      if (move(right, up, i * kStep) > move(right, up, best)) best = i * kStep;
    Long low = best - kStep, high = best + kStep;
    for (int i = 0; i < 60; ++i) {
      const Long a = low + (high - low) / 3, b = high - (high - low) / 3;
      const bool rises = move(right, up, a) < move(right, up, b);
      (rises ? low : high) = rises ? a : b;
    }
    return move(right, up, 0.5L * (low + high));
  }
  /// Pixels that the error of a metre at w = 1 moves a point by, and what it takes off w.
  Long error_per_w(Long pixels) const {
    Long most = 0.0L;
    for (const Long right : {-1.0L, 1.0L})
      for (const Long up : {-1.0L, 1.0L}) most = std::max(most, largest_move(right, up));
    return pixels / (most + pixels * std::hypot(rows[3][0], rows[3][1], rows[3][2]));
  }
  Long allowed(const core::Aabb& box, Long pixels) const {
    return error_per_w(pixels) * std::max(least(rows[3], box), nearest);
  }
};

TEST(MeshError, AllowsWhatTheImageMayShow) {
  int some = 0, none = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(3000)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stage stage(random, 10.0);
    const double pixels = std::pow(10.0, uniform(random, -2.0, 2.0));
    const lod::MeshError error(lod::ImageError(stage.view, kWidth, kHeight, pixels), stage.world_from_mesh);
    const core::Aabb box = any_box(random);
    const Long exact = ErrorTwin(stage.view, stage.world_from_mesh).allowed(box, pixels);
    const Long allowed = error.allowed(box);
    ASSERT_LE(allowed, exact);
    ASSERT_GE(allowed, exact * (1.0L - 2e-6L));
    ++(allowed > 0.0L ? some : none);
    ASSERT_LT(lod::MeshError(lod::ImageError(stage.view, kWidth, kHeight, 0.0), {}).allowed(box), 0.0f);
  }
  EXPECT_GT(some, 250);
}

/// Where terms of w are up to 10¹⁴ times as large as their sum, as those of a site far from its origin are.
TEST(MeshError, AllowsNoMoreFarFromTheOrigin) {
  int beyond = 0, close = 0;
  for (const double far : {1e6, 1e9, 1e12, 1e14})
    for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(3000)); ++seed) {
      SCOPED_TRACE(testing::Message() << far << ", seed " << seed);
      Random random(seed);
      const Stage stage(random, far);
      const lod::MeshError error(lod::ImageError(stage.view, kWidth, kHeight, 1.0), stage.world_from_mesh);
      const core::Aabb box = any_box(random);
      const ErrorTwin twin(stage.view, stage.world_from_mesh);
      const Long exact = twin.allowed(box, 1.0L);
      ASSERT_LE(Long(error.allowed(box)), exact);
      beyond += ErrorTwin::least(twin.rows[3], box) > twin.nearest;
      close += Long(error.allowed(box)) > 0.9L * exact;
    }
  EXPECT_GT(beyond, 4 * repeated(3000) / 4);
  EXPECT_GT(close, 4 * repeated(3000) / 2);
}

/// Boxes around the eye, in views whose near plane makes the exact error lie just below a float that the product of
/// rounded numbers reaches.
TEST(MeshError, AllowsNoMoreWhereProductsRoundUp) {
  const core::Aabb around{core::vec3(-1.0f), core::vec3(1.0f)};
  int at_the_float = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(1000)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double fovy = uniform(random, 0.1, 2.6), pixels = std::pow(10.0, uniform(random, -2.0, 2.0));
    const auto view_of = [&](double near) {
      return *core::View::perspective({dvec3(0.0), {0, 0, -1}, {0, 1, 0}}, fovy, 1.7, near);
    };
    const double any = uniform(random, 0.01, 0.5);
    const Long per_w = ErrorTwin(view_of(any), {}).error_per_w(pixels);
    const auto wanted = float(Long(any) * per_w);
    auto near = double(Long(wanted) / per_w);
    for (int i = 0; i < 3; ++i) near = std::nextafter(near, 0.0);
    for (int i = 0; i < 6; ++i, near = std::nextafter(near, 1.0)) {
      const core::View view = view_of(near);
      const Long exact = ErrorTwin(view, {}).allowed(around, pixels);
      at_the_float += std::abs(exact / Long(wanted) - 1.0L) < 1e-15L;
      ASSERT_LE(Long(lod::MeshError(lod::ImageError(view, kWidth, kHeight, pixels), {}).allowed(around)), exact);
    }
  }
  EXPECT_GT(at_the_float, 3 * repeated(1000));
}

/// Meshes whose unit is so large that errors in it are subnormal floats, of few bits.
TEST(MeshError, AllowsNoMoreAmongSubnormalErrors) {
  int subnormal = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(3000)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    core::Affine placement = any_placement(random, 10.0);
    const Stage stage(random, placement);
    placement.linear *= std::pow(10.0, uniform(random, 35.0, 42.0));
    const core::Aabb point{core::vec3(0.0f), core::vec3(0.0f)};
    const float allowed = lod::MeshError(lod::ImageError(stage.view, kWidth, kHeight, 1.0), placement).allowed(point);
    ASSERT_LE(Long(allowed), ErrorTwin(stage.view, placement).allowed(point, 1.0L));
    subnormal += allowed > 0.0f && allowed < std::numeric_limits<float>::min();
  }
  EXPECT_GT(subnormal, repeated(3000) / 3);
}

/// Projections whose near plane is no plane of one w, whose w is not that of the eye, or whose depth has other limits.
TEST(MeshError, AllowsNoMoreForOtherProjections) {
  const core::Pose pose{{0, 0, 0}, {0, 0, -1}, {0, 1, 0}};
  const core::dmat4 eye = *core::look_at(pose), usual = core::View::perspective(pose, 0.8, 1.7, 0.5)->clip_from_eye();
  const core::Aabb behind{core::vec3(-1.0f), core::vec3(1.0f)}, ahead{{-1, -1, -4}, {1, 1, -3}};
  const auto view_of = [&](const core::dmat4& clip, core::ClipDepth depth) {
    return *core::View::from_matrices(eye, clip, depth);
  };
  const auto allowed = [](const core::View& view, const core::Aabb& box) {
    return lod::MeshError(lod::ImageError(view, kWidth, kHeight, 1.0), {}).allowed(box);
  };
  // An image has one least w, whether its depths rise from 0 or from -1.
  const float known = allowed(view_of(usual, core::ClipDepth::kReversedZeroToOne), behind);
  EXPECT_GT(known, 0.0f);
  core::dmat4 rising = usual;
  rising[2][2] = -1.0, rising[3][2] = -0.5;
  EXPECT_NEAR(allowed(view_of(rising, core::ClipDepth::kZeroToOne), behind), known, 1e-6f * known);
  rising[3][2] = -1.0;
  EXPECT_NEAR(allowed(view_of(rising, core::ClipDepth::kMinusOneToOne), behind), known, 1e-6f * known);
  // Behind an oblique near plane, or where w also depends on x or y, points may have any w above 0.
  for (const int i : {0, 1}) {
    core::dmat4 oblique = usual;
    rising = usual;
    oblique[i][2] = 0.1;
    EXPECT_LT(allowed(view_of(oblique, core::ClipDepth::kReversedZeroToOne), behind), 0.0f) << i;
    EXPECT_GT(allowed(view_of(oblique, core::ClipDepth::kReversedZeroToOne), ahead), 0.0f) << i;
    rising[2][2] = -1.0, rising[3][2] = -0.5, rising[i][3] = 0.1;
    EXPECT_LT(allowed(view_of(rising, core::ClipDepth::kZeroToOne), behind), 0.0f) << i;
    EXPECT_GT(allowed(view_of(rising, core::ClipDepth::kZeroToOne), ahead), 0.0f) << i;
  }
}

/// A form of points as a GPU may compute it: coefficients and terms in float, summed in any order, with or without
/// fused operations.
float on_gpu(const dvec4& form, const core::vec3& p, Random& random) {
  const glm::vec4 f(form);
  std::array<int, 3> order{0, 1, 2};
  std::ranges::shuffle(order, random);
  const bool first = random() % 2, fused = random() % 2;
  float sum = first ? f.w : 0.0f;
  for (const int i : order) sum = fused ? std::fma(f[i], p[i], sum) : sum + f[i] * p[i];
  return first ? sum : sum + f.w;
}

/// A box on the side of a plane that the plane's normal points away from. The corner that is nearest to the plane is
/// `corner`, so that the rounding of the corner tells on which side that lies.
core::Aabb box_behind(const dvec3& normal, const core::vec3& corner, Random& random) {
  core::Aabb box{corner, corner};
  for (int i = 0; i < 3; ++i)
    (normal[i] > 0.0 ? box.min : box.max)[i] += float(normal[i] > 0.0 ? -1.0 : 1.0) * float(uniform(random, 0.0, 2.0));
  return box;
}

core::vec3 point_on(const dvec4& plane, Random& random) {
  dvec3 p(uniform(random, -9, 9), uniform(random, -9, 9), uniform(random, -9, 9));
  const dvec3 normal(plane);
  p -= (glm::dot(normal, p) + plane.w) / glm::dot(normal, normal) * normal;
  return core::vec3(p);
}

Long exact_value(const dvec4& form, const core::vec3& p) {
  return Long(form.x) * Long(p.x) + Long(form.y) * Long(p.y) + Long(form.z) * Long(p.z) + Long(form.w);
}

/// Boxes beside a section plane whose nearest corner a GPU puts onto the plane's other side.
TEST(MeshError, AllowsNothingWhereAGpuMayCut) {
  const core::View view = *core::View::orthographic({{0, 0, 50}, {0, 0, 0}}, 30.0, 1.7, 0.0, 100.0);
  int cut = 0, whole = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(30000)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    core::View with_section = view;
    const dvec4 plane(random_direction(random), uniform(random, -5, 5));
    with_section.sections.push_back({dvec3(plane), plane.w});
    const core::vec3 corner = point_on(plane, random);
    const bool cut_off = random() % 2;
    const core::Aabb box = box_behind(cut_off ? dvec3(plane) : -dvec3(plane), corner, random);
    const Long exact = exact_value(plane, corner);
    const float allowed = lod::MeshError(lod::ImageError(with_section, kWidth, kHeight, 1.0), {}).allowed(box);
    if (cut_off ? exact < 0.0L && on_gpu(plane, corner, random) >= 0.0f
                : exact > 0.0L && on_gpu(plane, corner, random) <= 0.0f) {
      ASSERT_LT(allowed, 0.0f);
      ++cut;
    }
    const core::vec3 away = 1e-3f * core::vec3(plane) * (cut_off ? -1.0f : 1.0f);
    ASSERT_GT(lod::MeshError(lod::ImageError(with_section, kWidth, kHeight, 1.0), {})
                  .allowed({box.min + away, box.max + away}),
              0.0f);
    ++whole;
  }
  EXPECT_GT(cut, whole / 100);
}

/// Boxes beside the view volume whose nearest corner a GPU puts into it.
TEST(MeshError, FindsNoBoxOutsideThatAGpuMayDraw) {
  int drawn = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(30000)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stage stage(random, core::Affine());
    const lod::MeshError error(lod::ImageError(stage.view, kWidth, kHeight, 1.0), stage.world_from_mesh);
    const auto planes = core::frustum_planes(stage.clip, stage.view.clip_depth());
    const core::Plane& one = planes[random() % (std::isfinite(planes[5].offset) ? 6 : 5)];
    const dvec4 plane(one.normal, one.offset);
    if (!(glm::length(one.normal) > 0.0)) continue;
    const core::vec3 corner = point_on(plane, random);
    const core::Aabb box = box_behind(one.normal, corner, random);
    if (exact_value(plane, corner) >= 0.0L || on_gpu(plane, corner, random) < 0.0f) continue;
    bool inside = true;
    for (const core::Plane& other : planes)
      if (&other != &one) inside = inside && core::evaluate(other, dvec3(corner)) > 0.0;
    if (!inside) continue;
    ASSERT_FALSE(error.outside(box));
    const double length = glm::length(dvec3(corner)) + std::abs(plane.w) / glm::length(one.normal);
    const core::vec3 away = -1e-4f * float(length) * core::vec3(glm::normalize(one.normal));
    ASSERT_TRUE(error.outside({box.min + away, box.max + away}));
    ++drawn;
  }
  EXPECT_GT(drawn, repeated(30000) / 200);
}

TEST(PlacedBox, HoldsWhatAGpuDraws) {
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(30000)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double far = seed % 3 == 0 ? 1e7 : 10.0;
    const core::Affine placement = any_placement(random, far);
    const dvec3 origin = placement.origin + uniform(random, 0.0, 100.0) * random_direction(random);
    const core::Aabb box = any_box(random);
    const core::AabbD placed = lod::placed_box(box, placement, origin);
    for (int axis = 0; axis < 3; ++axis) {
      const dvec4 form(placement.linear[0][axis], placement.linear[1][axis], placement.linear[2][axis],
                       placement.origin[axis] - origin[axis]);
      Long low = std::numeric_limits<Long>::infinity(), high = -low, terms = 0.0L;
      for (int i = 0; i < 8; ++i) {
        const core::vec3 corner((i & 1 ? box.max : box.min).x, (i & 2 ? box.max : box.min).y,
                                (i & 4 ? box.max : box.min).z);
        const double drawn = on_gpu(form, corner, random);
        ASSERT_GE(drawn, placed.min[axis]);
        ASSERT_LE(drawn, placed.max[axis]);
        low = std::min(low, exact_value(form, corner)), high = std::max(high, exact_value(form, corner));
        terms = std::max(terms, exact_value(glm::abs(form), glm::abs(corner)));
      }
      ASSERT_GE(Long(placed.min[axis]), low - 1e-5L * terms) << "no larger than rounding makes it";
      ASSERT_LE(Long(placed.max[axis]), high + 1e-5L * terms);
    }
  }
}

TEST(MeshError, AllowsLessForABoxAround) {
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(3000)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stage stage(random, 10.0);
    core::View view = stage.view;
    if (seed % 2) view.sections.push_back({random_direction(random), uniform(random, -5, 5)});
    const lod::MeshError error(lod::ImageError(view, kWidth, kHeight, 1.0), stage.world_from_mesh);
    const core::Aabb box = any_box(random);
    core::Aabb around = box;
    around.grow(any_box(random));
    ASSERT_LE(error.allowed(around), error.allowed(box));
    ASSERT_TRUE(!error.outside(around) || error.outside(box));
  }
}

TEST(MeshError, FindsOnlyBoxesOutsideThatShowNothing) {
  int outside = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(3000)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stage stage(random, seed % 4 == 0 ? 1e5 : 10.0);
    const lod::MeshError error(lod::ImageError(stage.view, kWidth, kHeight, 1.0), stage.world_from_mesh);
    const core::Aabb box = any_box(random);
    if (!error.outside(box)) continue;
    ++outside;
    for (int i = 0; i < 40; ++i) ASSERT_FALSE(stage.visible(point_in(box, random)));
  }
  EXPECT_GT(outside, 50);
}

TEST(MeshError, AllowsNothingWhereASectionCuts) {
  const auto view = *core::View::perspective({{0, -10, 0}, {0, 0, 0}}, 0.8, 1.0, 0.1);
  core::View cut = view;
  cut.sections.push_back({{1, 0, 0}, 0.0});
  const core::Aabb middle{{-1, -1, -1}, {1, 1, 1}}, right{{1, -1, -1}, {3, 1, 1}};
  const auto allowed = [](const core::View& v, const core::Aabb& box) {
    return lod::MeshError(lod::ImageError(v, 100, 100, 1.0), {}).allowed(box);
  };
  EXPECT_GT(allowed(view, middle), 0.0f);
  EXPECT_LT(allowed(cut, middle), 0.0f);
  EXPECT_EQ(allowed(cut, right), allowed(view, right));
}

/// Whether each cluster is drawn.
std::vector<bool> drawn(const lod::MeshLevels& levels, const std::vector<lod::IndexRange>& ranges) {
  std::vector<bool> drawn(levels.clusters.size());
  for (std::size_t i = 0; i < drawn.size(); ++i)
    for (const lod::IndexRange& range : ranges)
      drawn[i] = drawn[i] || (levels.clusters[i].first_index >= range.first &&
                              levels.clusters[i].first_index < range.first + range.count);
  return drawn;
}

TEST(CutChooser, DrawsEachGroupInOneWay) {
  const core::Mesh mesh = bumpy_torus(40, 0.1);
  const lod::MeshLevels levels = lod::build_levels(mesh);
  lod::CutChooser chooser;
  std::vector<lod::IndexRange> ranges;
  std::size_t least = levels.indices.size(), most = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(300)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stage stage(random, 0.5);
    const double pixels = std::pow(10.0, uniform(random, -2.0, 2.0));
    const lod::MeshError error(lod::ImageError(stage.view, kWidth, kHeight, pixels), stage.world_from_mesh);
    chooser.choose(levels, error, ranges);
    for (std::size_t i = 1; i < ranges.size(); ++i)
      ASSERT_GT(ranges[i].first, ranges[i - 1].first + ranges[i - 1].count);
    std::size_t indices = 0;
    for (const lod::IndexRange& range : ranges) indices += range.count;
    least = std::min(least, indices), most = std::max(most, indices);
    const std::vector<bool> shown = drawn(levels, ranges);
    // A group is simplified where its error is allowed. Then none of its clusters is drawn, and all that it made are,
    // but for those that lie outside or are simplified further.
    for (std::size_t i = 0; i < shown.size(); ++i) {
      const lod::Cluster& cluster = levels.clusters[i];
      const auto simplified = [&](std::uint32_t group) {
        return levels.groups[group].error <= error.allowed(levels.groups[group].box);
      };
      const bool fine = cluster.made_by == core::kNone || simplified(cluster.made_by);
      const bool replaced = cluster.goes_into != core::kNone && simplified(cluster.goes_into);
      ASSERT_TRUE(!replaced || fine) << "a group above is simplified only where this one is";
      ASSERT_EQ(shown[i], fine && !replaced && !error.outside(cluster.box));
    }
  }
  EXPECT_LT(least, 400u);
  EXPECT_GT(most, mesh.indices.size() / 3);
}

/// The mesh is so large that threads share its rounds.
TEST(CutChooser, ChoosesTheSameWithAnyNumberOfThreads) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no coarser levels in this build";
  const lod::MeshLevels levels = lod::build_levels(bumpy_torus(220, 0.1));
  ASSERT_GT(levels.groups.size(), 100u);
  lod::CutChooser chooser;
  for (const int threads : {1, 2, 3, 5, 16}) {
    core::ThreadPool pool(threads);
    lod::CutChooser shared;
    for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(200)); ++seed) {
      SCOPED_TRACE(testing::Message() << "threads " << threads << ", seed " << seed);
      Random random(seed);
      const Stage stage(random, 0.5);
      const double pixels = std::pow(10.0, uniform(random, -3.0, 1.0));
      const lod::MeshError error(lod::ImageError(stage.view, kWidth, kHeight, pixels), stage.world_from_mesh);
      ASSERT_EQ(shared.choose(levels, error, &pool), chooser.choose(levels, error));
      ASSERT_EQ(shared.error(), chooser.error());
    }
  }
}

/// The error that is told is one which allows what was chosen, and little more than the least such error.
TEST(CutChooser, TellsTheErrorOfWhatItChose) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no coarser levels in this build";
  const lod::MeshLevels levels = lod::build_levels(bumpy_torus(40, 0.1));
  lod::CutChooser chooser;
  std::vector<lod::IndexRange> ranges;
  int told = 0, tight = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(300)); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stage stage(random, 0.5);
    const double pixels = std::pow(10.0, uniform(random, -2.0, 2.0));
    const auto error_of = [&](double p) {
      return lod::MeshError(lod::ImageError(stage.view, kWidth, kHeight, p), stage.world_from_mesh);
    };
    chooser.choose(levels, error_of(pixels), ranges);
    ASSERT_LE(chooser.error(), pixels);
    const std::vector<bool> shown = drawn(levels, ranges);
    const lod::MeshError same = error_of(chooser.error() * (1.0 + 1e-5)), less = error_of(0.7 * chooser.error());
    bool refused = false;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      if (!shown[i] || levels.clusters[i].made_by == core::kNone) continue;
      const lod::ClusterGroup& group = levels.groups[levels.clusters[i].made_by];
      ASSERT_TRUE(group.error == 0.0f || group.error <= same.allowed(group.box));
      refused = refused || group.error > less.allowed(group.box);
    }
    told += chooser.error() > 0.0;
    tight += refused;
  }
  EXPECT_GT(told, repeated(300) / 8);
  EXPECT_GT(tight, 9 * told / 10);
}

}  // namespace
}  // namespace sightline::tests::cut_test
