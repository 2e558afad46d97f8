// The GPU forms of the study against the linear culler: nothing lost, what is extra lies within the float planes' band.
#include <algorithm>

#include "sightline/apps/study/gpu/flat.h"
#include "sightline/apps/study/gpu/in_draw.h"
#include "sightline/culling/frustum/linear_culler.h"
#include "sightline/gl/internal/query.h"
#include "sightline/tests/culling/scenes.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::study::gpu_test {
namespace {

using core::dvec3;
using core::View;
using tests::Random;
using Ids = std::vector<std::uint32_t>;

core::ItemBounds bounds_of(std::span<const core::Aabb> boxes) {
  core::ItemBounds bounds;
  bounds.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) bounds.set(i, boxes[i]);
  return bounds;
}

Ids cull_linear(const core::ItemBounds& bounds, const View& view) {
  core::VisibleSet set;
  culling::LinearCuller(bounds).cull(view, set);
  Ids ids = set.sorted_slots();
  std::erase_if(ids, [&](core::Slot slot) { return bounds.vacant(slot); });
  return ids;
}

/// Returns how many more there are than the CPU finds.
std::size_t expect_same(Method& method, const core::ItemBounds& bounds, const View& view) {
  method.cull(view);
  const Ids found = method.ids(), wanted = cull_linear(bounds, view);
  EXPECT_EQ(method.count(), found.size());
  EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end()) << "named twice";
  EXPECT_TRUE(std::includes(found.begin(), found.end(), wanted.begin(), wanted.end()))
      << "of " << wanted.size() << " some are lost; found " << found.size();
  Ids extra;
  std::set_difference(found.begin(), found.end(), wanted.begin(), wanted.end(), std::back_inserter(extra));
  const culling::CullPlanes planes(view, bounds);
  for (const std::uint32_t id : extra)
    EXPECT_TRUE(!bounds.vacant(id) && tests::left_open(planes, bounds.box(id))) << "box " << id;
  return extra.size();
}

/// Without size, of denormals, huge, long, and such that touch the planes of the view or miss them by a bit.
std::vector<core::Aabb> boxes_at_planes(Random& random, const View& view, const dvec3& site, double half,
                                        bool with_huge) {
  std::vector<core::Plane> planes;
  for (const core::Plane& plane : core::frustum_planes(view.clip_from_world(), view.clip_depth()))
    if (plane.normal != dvec3(0.0)) planes.push_back(plane);
  const double sizes[] = {0.0, 1e-42, 1e-6, 1.0, half, 1e12};
  std::vector<core::Aabb> boxes;
  for (int i = 0; i < 1000; ++i) {
    const core::Plane& plane = planes[std::size_t(tests::whole(random, 0, int(planes.size()) - 1))];
    const dvec3 a = glm::abs(plane.normal);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    dvec3 p = site + tests::point(random, half);
    p[axis] = 0.0;
    p[axis] = -(glm::dot(plane.normal, p) + plane.offset) / plane.normal[axis];
    if (!core::is_finite(p) || glm::length(p - site) > 100.0 * half) continue;
    p[axis] += half * (tests::chance(random, 0.3) ? 0.0 : tests::magnitude(random, 1e-12, 1e-5)) *
               (tests::chance(random, 0.5) ? 1.0 : -1.0);
    core::AabbD box{p, p};
    for (int k = 0; k < 3; ++k)
      (plane.normal[k] > 0.0 ? box.min : box.max)[k] +=
          (plane.normal[k] > 0.0 ? -1.0 : 1.0) * sizes[tests::whole(random, 0, with_huge ? 5 : 4)];
    boxes.push_back(core::round_outwards(box, dvec3(0.0)));
  }
  return boxes;
}

struct Case {
  std::vector<core::Aabb> boxes;
  std::vector<View> views;
  dvec3 site{0.0};
  double half = 1.0;
  bool mild = false;  // nothing widens the band: extra boxes must be rare
};

/// Even seeds lie 10^7 m away.
Case random_case(std::uint64_t seed, Random& random) {
  Case c;
  c.half = tests::magnitude(random, 1.0, 1e3);
  if (seed % 2 == 0) c.site = {1e7, -1e7, 1e3};
  for (const core::Aabb& box : tests::random_boxes(random, 2500, c.half))
    c.boxes.push_back(core::round_outwards({dvec3(box.min) + c.site, dvec3(box.max) + c.site}, dvec3(0.0)));
  if (seed % 4 == 1) tests::spoil(random, c.boxes);
  c.mild = seed % 4 == 3;
  for (int i = 0; i < 8; ++i) c.views.push_back(tests::random_view(random, c.site, c.half));
  return c;
}

Case touching_case(std::uint64_t seed, Random& random) {
  Case c;
  c.half = tests::magnitude(random, 1.0, 1e3);
  if (seed % 2 == 0) c.site = {1e7, -1e7, 1e3};
  c.views.push_back(tests::random_view(random, c.site, c.half));
  c.boxes = boxes_at_planes(random, c.views.front(), c.site, c.half, seed > 4);
  return c;
}

View towards(const dvec3& eye, const dvec3& target, double fovy, double far) {
  return *View::perspective({eye, target, {0, 0, 1}}, fovy, 1.4, 1e-4 * far, far);
}
/// A view of a scene of half side `half` around the origin.
View view_of_all(double half) {
  return towards({0, -20 * half, 0}, dvec3(0.0), 1.0, 100 * half);
}
View view_of_nothing(double half) {
  return towards({0, -20 * half, 0}, {0, -40 * half, 0}, 1.0, 100 * half);
}

/// Runs `check(case)` on many of both kinds.
template <class Check>
void for_each_case(const Check& check) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    for (const bool touching : {false, true}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + (touching ? ", touching planes" : ", random"));
      Random random(seed);
      check(touching ? touching_case(seed, random) : random_case(seed, random));
      if (testing::Test::HasFailure()) return;
    }
  }
}

class StudyGpuTest : public tests::GlTest {};

TEST_F(StudyGpuTest, FlatFormsFindWhatTheCpuFinds) {
  std::size_t extra = 0, found = 0;
  for_each_case([&](const Case& c) {
    const core::ItemBounds bounds = bounds_of(c.boxes);
    for (const bool form : {false, true}) {
      SCOPED_TRACE(flat_name(form));
      auto method = make_flat(*context, form, c.boxes);
      ASSERT_TRUE(method) << method.error().message;
      for (std::size_t i = 0; i < c.views.size(); ++i) {
        SCOPED_TRACE("view " + std::to_string(i));
        const std::size_t more = expect_same(**method, bounds, c.views[i]);
        if (!c.mild) continue;
        extra += more;
        found += (*method)->count();
      }
    }
  });
  EXPECT_GT(found, 8000u);
  EXPECT_LE(extra, found / 1000);
}

TEST_F(StudyGpuTest, FlatFormsSeeAllAndNothing) {
  Random random(3);
  const auto boxes = tests::random_boxes(random, 777, 10.0);
  for (const bool form : {false, true}) {
    SCOPED_TRACE(flat_name(form));
    auto method = make_flat(*context, form, boxes);
    ASSERT_TRUE(method) << method.error().message;
    (*method)->cull(view_of_all(10.0));
    EXPECT_EQ((*method)->count(), boxes.size());
    (*method)->cull(view_of_nothing(10.0));
    EXPECT_EQ((*method)->count(), 0u);
    EXPECT_TRUE((*method)->ids().empty());
    auto empty = make_flat(*context, form, {});
    ASSERT_TRUE(empty) << empty.error().message;
    (*empty)->cull(view_of_all(10.0));
    EXPECT_EQ((*empty)->count(), 0u);
  }
}

// --- in the draw -----------------------------------------------------------------------------------------------------

/// Cylinders of any direction, near and far, and some that the eye is in.
void add_cylinders(Random& random, core::Scene& scene, const dvec3& site, double half, int count) {
  for (int i = 0; i < count; ++i) {
    core::Affine placement = core::translation(site + tests::point(random, half));
    placement.linear = core::dmat3(*core::look_at({dvec3(0.0), tests::point(random, 1.0), {0, 0, 1}}));
    const float radius = float(half * tests::magnitude(random, 1e-3, 0.1));
    scene.add_primitive(scene.root(), core::Cylinder{radius, radius * float(tests::magnitude(random, 0.1, 50.0))},
                        placement);
  }
}

TEST_F(StudyGpuTest, CullingInTheDrawChangesNoPixel) {
  constexpr int kCylinders = 1500;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const double half = 20.0;
    const dvec3 site = seed % 2 ? dvec3(0.0) : dvec3(1e7, -1e7, 0.0);
    core::Scene model;
    add_cylinders(random, model, site, half, kCylinders);
    ASSERT_TRUE(model.commit());
    const core::Snapshot snapshot(model);
    auto scene = gpuscene::GpuScene::create(*context, snapshot);
    ASSERT_TRUE(scene);
    auto renderer = render::Renderer::create(*context, *scene);
    auto lists = gpuscene::DrawLists::create(*context, *scene);
    auto target = render::RenderTarget::create(*context, 160, 120, {.ids = true});
    auto in_draw = InDraw::create(*context, snapshot, *scene);
    ASSERT_TRUE(renderer && lists && target);
    ASSERT_TRUE(in_draw) << in_draw.error().message;
    core::VisibleSet everything;
    everything.ranges = {{0, std::uint32_t(snapshot.size())}};
    ASSERT_TRUE(lists->update(snapshot, *scene, everything));
    const gl::Query triangles(gl(), GL_PRIMITIVES_GENERATED);
    std::uint64_t drawn = 0;
    for (int i = 0; i < 10; ++i) {
      SCOPED_TRACE("view " + std::to_string(i));
      const dvec3 eye = site + tests::point(random, 1.5 * half);
      const View view = *View::perspective({eye, site + tests::point(random, half), {0, 0, 1}}, 0.9, 4.0 / 3.0, 0.1,
                                           tests::chance(random, 0.5) ? core::kInfiniteFar : 2.0 * half);
      ASSERT_TRUE(renderer->draw(view, snapshot, *scene, *lists, *target));
      const auto ids = target->read_ids();
      const auto colour = target->read_colour();
      triangles.begin();
      ASSERT_TRUE(in_draw->draw(view, snapshot, *scene, *renderer, *target));
      triangles.end();
      EXPECT_EQ(target->read_ids().ids, ids.ids);
      EXPECT_EQ(target->read_colour().pixels, colour.pixels);
      const std::uint64_t visible = cull_linear(snapshot.bounds(), view).size();
      EXPECT_GE(triangles.result(), InDraw::kTrianglesPerCylinder * visible);
      EXPECT_LE(triangles.result(), InDraw::kTrianglesPerCylinder * (visible + 2)) << "of " << kCylinders;
      drawn += visible;
    }
    EXPECT_GT(drawn, 100u);
    EXPECT_LT(drawn, 8u * kCylinders);
  }
}

}  // namespace
}  // namespace sightline::study::gpu_test
