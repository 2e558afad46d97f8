// What a view draws of a mesh: errors as large as allowed move no visible point by more pixels than that, boxes left
// out show nothing, and cuts are consistent.
#include "sightline/lod/internal/cut.h"

#include <cmath>
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
