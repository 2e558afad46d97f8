// The GPU forms of the study against the linear culler: nothing lost, what is extra lies within the float planes' band.
#include <algorithm>
#include <numeric>

#include "sightline/culling/frustum/linear_culler.h"
#include "sightline/gl/internal/query.h"
#include "sightline/study/gpu/flat.h"
#include "sightline/study/gpu/frontier.h"
#include "sightline/study/gpu/in_draw.h"
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

void expect_none_lost(const Ids& found, const Ids& wanted) {
  EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end()) << "named twice";
  EXPECT_TRUE(std::includes(found.begin(), found.end(), wanted.begin(), wanted.end()))
      << "of " << wanted.size() << " some are lost; found " << found.size();
}

/// Returns how many more there are than the CPU finds.
std::size_t expect_same(Method& method, const core::ItemBounds& bounds, const View& view) {
  method.cull(view);
  const Ids found = method.ids(), wanted = cull_linear(bounds, view);
  EXPECT_EQ(method.count(), found.size());
  expect_none_lost(found, wanted);
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

// --- frontier --------------------------------------------------------------------------------------------------------

/// The nodes of a cut span all places, one after the other.
void expect_cut(const Tree& tree, std::span<const std::uint32_t> cut) {
  std::uint32_t place = 0;
  for (const std::uint32_t node : cut) {
    ASSERT_EQ(tree.nodes[node].first, place);
    place = tree.nodes[node].end;
  }
  ASSERT_EQ(place, tree.order.size());
}

Ids places_to_ids(const Tree& tree, std::span<const core::SlotRange> ranges) {
  Ids ids;
  std::uint32_t end = 0;
  for (const core::SlotRange& range : ranges) {
    EXPECT_GT(range.count, 0u);
    EXPECT_GE(range.first, end) << "out of order";
    end = range.first + range.count;
    for (std::uint32_t place = range.first; place < end; ++place) ids.push_back(tree.order[place]);
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

TEST_F(StudyGpuTest, FrontierFindsWhatTheCpuFinds) {
  std::size_t extra = 0, found = 0;
  for_each_case([&](Case c) {
    std::erase_if(c.boxes, [](const core::Aabb& box) { return box.empty(); });  // trees hold none
    const core::ItemBounds bounds = bounds_of(c.boxes);
    const Tree tree = build_tree(c.boxes, {}, Split::kMedian);
    auto frontier = Frontier::create(*context, tree, c.boxes);
    ASSERT_TRUE(frontier) << frontier.error().message;
    for (std::size_t i = 0; i < c.views.size(); ++i) {
      SCOPED_TRACE("view " + std::to_string(i));
      (*frontier)->take_over(c.views[i]);  // nothing that ends there can overflow
      const std::size_t more = expect_same(**frontier, bounds, c.views[i]);
      EXPECT_EQ((*frontier)->overflowed(), 0u);
      expect_cut(tree, (*frontier)->cut());
      if (!c.mild) continue;
      extra += more;
      found += (*frontier)->count();
    }
  });
  EXPECT_GT(found, 1000u);
  EXPECT_LE(extra, found / 1000);
}

/// Along a path with jumps, a look away, and one at everything. With little room nodes overflow, and add boxes only.
TEST_F(StudyGpuTest, FrontierLosesNothingAlongAPath) {
  constexpr double kHalf = 50.0;
  for (const std::uint32_t room : {1u, 3u, 16u, kRangesPerNode}) {
    SCOPED_TRACE("ranges per node " + std::to_string(room));
    Random random(room);
    const auto boxes = tests::random_boxes(random, 4000, kHalf);
    const core::ItemBounds bounds = bounds_of(boxes);
    const Tree tree = build_tree(boxes, {}, Split::kSah);
    auto frontier = Frontier::create(*context, tree, boxes, room);
    ASSERT_TRUE(frontier) << frontier.error().message;
    std::size_t overflows = 0, steady = 0, coarsest = boxes.size(), finest = 0;
    dvec3 eye = tests::point(random, kHalf);
    double angle = 0.0;
    for (int frame = 0; frame < 100; ++frame) {
      SCOPED_TRACE("frame " + std::to_string(frame));
      eye += dvec3(0.3, 0.2, 0.0);
      angle += 0.03;
      if (frame % 20 == 19) eye = tests::point(random, 1.5 * kHalf), angle += 2.0;
      View view = towards(eye, eye + dvec3(std::cos(angle), std::sin(angle), 0.1), 0.8, 3.0 * kHalf);
      if (frame >= 40 && frame < 60) view = view_of_nothing(kHalf);
      if (frame >= 80) view = view_of_all(kHalf);
      Method& method = **frontier;
      method.cull(view);
      ASSERT_EQ(places_to_ids(tree, (*frontier)->ranges()), method.ids());
      expect_cut(tree, (*frontier)->cut());
      const Ids wanted = cull_linear(bounds, view);
      expect_none_lost(method.ids(), wanted);
      overflows += (*frontier)->overflowed();
      if ((*frontier)->overflowed() == 0) {
        ++steady;
        EXPECT_LE(method.count(), wanted.size() + 2);
      }
      if (frame >= 40 && frame < 60) {
        EXPECT_EQ(method.count(), 0u);
      }
      if (frame >= 80) {
        EXPECT_EQ(method.count(), boxes.size());
      }
      if (room > 2 && (*frontier)->overflowed() > 0) {
        method.cull(view);
        EXPECT_EQ((*frontier)->overflowed(), 0u) << "room was made for the same view";
        EXPECT_LE(method.count(), wanted.size() + 2);
      }
      coarsest = std::min(coarsest, (*frontier)->cut().size());
      finest = std::max(finest, (*frontier)->cut().size());
      if (HasFailure()) return;
    }
    EXPECT_GT(overflows, 0u) << "nothing was tried";
    EXPECT_GT(steady, 0u) << "never settles";
    EXPECT_LT(coarsest, finest / 4) << "the cut follows the view";
  }
}

TEST_F(StudyGpuTest, FrontierRefusesRoomThatThereIsNot) {
  const std::vector<core::Aabb> boxes{{core::vec3(0.0f), core::vec3(1.0f)}};
  const Tree tree = build_tree(boxes, {}, Split::kMedian);
  EXPECT_FALSE(Frontier::create(*context, tree, boxes, 0));
  EXPECT_FALSE(Frontier::create(*context, tree, boxes, 100000));
  auto one = Frontier::create(*context, tree, boxes);
  ASSERT_TRUE(one) << one.error().message;
  (*one)->cull(view_of_all(1.0));
  EXPECT_EQ((*one)->ids(), Ids{0});
  const Tree empty;
  auto none = Frontier::create(*context, empty, {});
  ASSERT_TRUE(none) << none.error().message;
  (*none)->cull(view_of_all(1.0));
  EXPECT_EQ((*none)->count(), 0u);
}

TEST(StudyFrontier, CutsStayCuts) {
  Random random(7);
  const auto boxes = tests::random_boxes(random, 500, 10.0);
  for (const Split split : {Split::kMean, Split::kMedian, Split::kSah}) {
    const Tree tree = build_tree(boxes, {}, split);
    Ids cut{0};
    std::size_t finest = 0;
    for (int step = 0; step < 400; ++step) {
      SCOPED_TRACE("step " + std::to_string(step));
      std::vector<Found> found;
      const auto few = std::uint32_t(tests::whole(random, 1, 200));
      const int refining = step < 200 ? 6 : 1;
      for (std::size_t i = 0; i < cut.size(); ++i)
        found.push_back(tests::whole(random, 0, 9) < refining ? Found::kTooMuch : Found(tests::whole(random, 0, 2)));
      cut = next_cut(tree, cut, found, few);
      expect_cut(tree, cut);
      finest = std::max(finest, cut.size());
    }
    EXPECT_GT(finest, 100u);
    // All alike: up to the root, a level a frame.
    for (std::uint32_t level = 0; level < tree.height; ++level)
      cut = next_cut(tree, cut, std::vector<Found>(cut.size(), Found::kNothing), 1);
    EXPECT_EQ(cut, Ids{0});
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
