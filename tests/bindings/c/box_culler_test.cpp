// Culling boxes in C gives what it gives in C++, also from several threads and during updates.
#include "sightline/culling/box_culler.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <thread>

#include <glm/gtc/type_ptr.hpp>

#include "c_scene.h"
#include "sightline/culling/occlusion/occluder_raster.h"

namespace sightline::tests::box_culler_test {
namespace {

constexpr unsigned kSeed = 5;

struct Boxes {
  std::vector<sl_box> c;
  std::vector<core::AabbD> cpp;

  explicit Boxes(int count) {
    std::mt19937_64 random(kSeed);
    std::uniform_real_distribution<double> place(-100, 100), size(0, 3);
    for (int i = 0; i < count; ++i) {
      sl_box box;
      for (int axis = 0; axis < 3; ++axis) {
        box.min[axis] = place(random);
        box.max[axis] = box.min[axis] + size(random);
      }
      c.push_back(box);
      cpp.push_back({glm::make_vec3(box.min), glm::make_vec3(box.max)});
    }
  }
};

std::vector<BothViews> some_views() {
  std::vector<BothViews> views;
  for (int i = 0; i < 20; ++i) {
    const double turn = 0.3 * i;
    views.emplace_back(core::dvec3(90 * std::cos(turn), 90 * std::sin(turn), 10.0 * (i % 5)), core::dvec3(0, 0, i));
  }
  return views;
}

TEST(CapiBoxCuller, FindsTheBoxesThatCppFinds) {
  const Boxes boxes(5000);
  sl_box_culler culler = {0};
  ASSERT_OK(sl_box_culler_create(boxes.c.data(), boxes.c.size(), &culler));
  auto twin = culling::BoxCuller::create(boxes.cpp);
  ASSERT_TRUE(twin);
  std::vector<std::uint32_t> found(boxes.c.size()), expected;
  std::size_t count = 0, visible = 0;
  const auto compare = [&](const BothViews& view) {
    twin->visible(view.cpp, expected);
    ASSERT_OK(sl_box_culler_visible(culler, &view.c, found.data(), found.size(), &count));
    ASSERT_EQ(count, expected.size());
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found.begin()));
    const core::dmat4 matrix = view.cpp.clip_from_world();
    ASSERT_OK(sl_box_culler_visible_in(culler, glm::value_ptr(matrix), SL_DEPTH_REVERSED_ZERO_TO_ONE, found.data(),
                                       found.size(), &count));
    ASSERT_TRUE(twin->visible(glm::value_ptr(matrix), core::ClipDepth::kReversedZeroToOne, expected));
    ASSERT_EQ(count, expected.size());
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found.begin()));
    visible += count;
  };
  for (const BothViews& view : some_views()) compare(view);
  EXPECT_GT(visible, 1000u);
  for (std::uint32_t i = 0; i < 100; ++i) {
    const sl_box moved = {{0, double(i) / 10, 0}, {1, double(i) / 10 + 1, 1}};
    ASSERT_OK(sl_box_culler_update(culler, 50 * i, &moved));
    ASSERT_TRUE(twin->update(50 * i, {glm::make_vec3(moved.min), glm::make_vec3(moved.max)}));
  }
  for (const BothViews& view : some_views()) compare(view);
  EXPECT_OK(sl_box_culler_destroy(culler));
}

TEST(CapiBoxCuller, AnswersQueriesAsCppDoes) {
  const Boxes boxes(5000);
  sl_box_culler culler = {0};
  ASSERT_OK(sl_box_culler_create(boxes.c.data(), boxes.c.size(), &culler));
  auto twin = culling::BoxCuller::create(boxes.cpp);
  ASSERT_TRUE(twin);
  std::vector<std::uint32_t> found(boxes.c.size()), expected;
  std::vector<sl_box_hit> hits(10);
  std::vector<culling::BoxHit> expected_hits;
  std::size_t count = 0;
  const auto compare = [&] {
    ASSERT_EQ(count, expected.size());
    EXPECT_GT(count, 0u);
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found.begin()));
  };
  const auto compare_hits = [&] {
    ASSERT_EQ(count, expected_hits.size());
    EXPECT_GT(count, 0u);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(hits[i].index, expected_hits[i].index);
      EXPECT_EQ(hits[i].distance, expected_hits[i].distance);
    }
  };
  const sl_box range = {{-30, -30, -30}, {40, 50, 60}};
  for (const bool inside : {false, true}) {
    ASSERT_OK(sl_box_culler_in_box(culler, &range, inside, found.data(), found.size(), &count));
    twin->in_box({{-30, -30, -30}, {40, 50, 60}}, inside, expected);
    compare();
  }
  const double place[3] = {1, 2, 3};
  ASSERT_OK(sl_box_culler_around(culler, place, 20.0, found.data(), found.size(), &count));
  twin->around({1, 2, 3}, 20.0, expected);
  compare();
  ASSERT_OK(sl_box_culler_nearest(culler, place, hits.data(), hits.size(), &count));
  twin->nearest({1, 2, 3}, hits.size(), expected_hits);
  compare_hits();
  sl_ray ray = SL_RAY_INIT;
  for (int axis = 0; axis < 3; ++axis) ray.origin[axis] = boxes.c[7].min[axis];
  ASSERT_OK(sl_box_culler_along(culler, &ray, hits.data(), hits.size(), &count));
  twin->along({boxes.cpp[7].min, {0, 1, 0}}, hits.size(), expected_hits);
  compare_hits();
  const double far[3] = {1e200, 0, 0};
  EXPECT_EQ(sl_box_culler_nearest(culler, far, hits.data(), hits.size(), &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_in_box(culler, nullptr, 0, found.data(), found.size(), &count), SL_ERROR_ARGUMENT);
  EXPECT_OK(sl_box_culler_destroy(culler));
}

TEST(CapiBoxCuller, ChangesManyBoxesAsCppDoes) {
  Boxes boxes(5000);
  sl_box_culler culler = {0};
  ASSERT_OK(sl_box_culler_create(boxes.c.data(), boxes.c.size(), &culler));
  auto twin = culling::BoxCuller::create(boxes.cpp);
  ASSERT_TRUE(twin);
  std::vector<std::uint32_t> found(boxes.c.size()), expected;
  const auto compare = [&] {
    for (const BothViews& view : some_views()) {
      std::size_t count = 0;
      twin->visible(view.cpp, expected);
      ASSERT_OK(sl_box_culler_visible(culler, &view.c, found.data(), found.size(), &count));
      ASSERT_EQ(count, expected.size());
      ASSERT_TRUE(std::equal(expected.begin(), expected.end(), found.begin()));
    }
  };
  const std::vector<std::uint32_t> indices{7, 4999, 0, 7, 2500, 7};
  ASSERT_OK(sl_box_culler_update_many(culler, indices.data(), boxes.c.data() + 100, indices.size()));
  ASSERT_TRUE(twin->update(indices, std::span(boxes.cpp).subspan(100, indices.size())));
  ASSERT_NO_FATAL_FAILURE(compare());
  std::reverse(boxes.c.begin(), boxes.c.end());
  std::reverse(boxes.cpp.begin(), boxes.cpp.end());
  ASSERT_OK(sl_box_culler_refit(culler, boxes.c.data(), boxes.c.size()));
  ASSERT_TRUE(twin->refit(boxes.cpp));
  ASSERT_NO_FATAL_FAILURE(compare());
  EXPECT_OK(sl_box_culler_destroy(culler));
  EXPECT_EQ(sl_box_culler_update_many(culler, nullptr, nullptr, 0), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_box_culler_refit(culler, nullptr, 0), SL_ERROR_HANDLE);
}

TEST(CapiBoxCuller, ARefusedChangeChangesNothing) {
  const Boxes boxes(1000);
  sl_box_culler culler = {0};
  ASSERT_OK(sl_box_culler_create(boxes.c.data(), boxes.c.size(), &culler));
  const BothViews view({0, -90, 0}, {0, 0, 0});
  std::vector<std::uint32_t> before(1000), after(1000);
  std::size_t count = 0;
  ASSERT_OK(sl_box_culler_visible(culler, &view.c, before.data(), before.size(), &count));
  std::vector<sl_box> moved(1000, {{1e6, 0, 0}, {1e6, 1, 1}});
  std::vector<std::uint32_t> indices(1000);
  std::iota(indices.begin(), indices.end(), 0u);
  moved[999].max[1] = HUGE_VAL;
  EXPECT_EQ(sl_box_culler_update_many(culler, indices.data(), moved.data(), 1000), SL_ERROR_FAILED);
  EXPECT_NE(std::string(sl_last_error()).find("box 999: expected finite corners"), std::string::npos);
  EXPECT_EQ(sl_box_culler_refit(culler, moved.data(), 1000), SL_ERROR_FAILED);
  EXPECT_EQ(sl_box_culler_refit(culler, moved.data(), 999), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_refit(culler, nullptr, 1000), SL_ERROR_ARGUMENT);
  moved[999] = moved[0];
  indices[500] = 1000;
  EXPECT_EQ(sl_box_culler_update_many(culler, indices.data(), moved.data(), 1000), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_update_many(culler, indices.data(), nullptr, 1), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_update_many(culler, nullptr, moved.data(), 1), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_update_many(culler, indices.data(), moved.data(), std::size_t(-1)), SL_ERROR_ARGUMENT);
  EXPECT_OK(sl_box_culler_update_many(culler, nullptr, nullptr, 0)) << "no boxes at all";
  ASSERT_OK(sl_box_culler_visible(culler, &view.c, after.data(), after.size(), &count));
  EXPECT_EQ(after, before);
  EXPECT_OK(sl_box_culler_destroy(culler));
}

TEST(CapiBoxCuller, WritesNoMoreThanFits) {
  const Boxes boxes(1000);
  sl_box_culler culler = {0};
  ASSERT_OK(sl_box_culler_create(boxes.c.data(), boxes.c.size(), &culler));
  const BothViews view({0, -90, 0}, {0, 0, 0});
  std::size_t all = 0, count = 0;
  ASSERT_OK(sl_box_culler_visible(culler, &view.c, nullptr, 0, &all));
  ASSERT_GT(all, 10u);
  std::vector<std::uint32_t> found(11, 0xdeadbeef);
  ASSERT_OK(sl_box_culler_visible(culler, &view.c, found.data(), 10, &count));
  EXPECT_EQ(count, all);
  EXPECT_EQ(found[10], 0xdeadbeef);
  EXPECT_NE(found[9], 0xdeadbeef);
  EXPECT_OK(sl_box_culler_destroy(culler));
}

TEST(CapiBoxCuller, BadArgumentsAreErrors) {
  sl_box nan = {{0, 0, 0}, {1, std::nan(""), 1}};
  sl_box_culler culler = {99};
  EXPECT_EQ(sl_box_culler_create(&nan, 1, &culler), SL_ERROR_FAILED);
  EXPECT_EQ(sl_box_culler_create(nullptr, 1, &culler), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_create(&nan, std::size_t(-1), &culler), SL_ERROR_ARGUMENT);
  EXPECT_EQ(culler.id, 99u);
  ASSERT_OK(sl_box_culler_create(nullptr, 0, &culler)) << "no boxes at all";
  std::size_t count = 7;
  const BothViews view({0, -300, 0}, {0, 0, 0});
  ASSERT_OK(sl_box_culler_visible(culler, &view.c, nullptr, 0, &count));
  EXPECT_EQ(count, 0u);
  const sl_box box = {{0, 0, 0}, {1, 1, 1}};
  EXPECT_EQ(sl_box_culler_update(culler, 0, &box), SL_ERROR_ARGUMENT);
  Matrix infinite;
  infinite.m[5] = HUGE_VAL;
  EXPECT_EQ(sl_box_culler_visible_in(culler, infinite.m, 0, nullptr, 0, &count), SL_ERROR_FAILED);
  EXPECT_EQ(sl_box_culler_visible_in(culler, nullptr, 0, nullptr, 0, &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_visible_in(culler, Matrix().m, 7, nullptr, 0, &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_visible(culler, &view.c, nullptr, 0, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_OK(sl_box_culler_destroy(culler));
}

TEST(CapiBoxCuller, ThreadsCullWhileOneUpdatesAndDestroys) {
  const Boxes boxes(2000);
  sl_box_culler culler = {0};
  ASSERT_OK(sl_box_culler_create(boxes.c.data(), boxes.c.size(), &culler));
  const BothViews view({0, -90, 0}, {0, 0, 0});
  std::atomic<int> culled{0}, wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t)
    threads.emplace_back([&] {
      std::vector<std::uint32_t> found(boxes.c.size());
      std::size_t count = 0;
      for (;;) {
        const sl_status status = sl_box_culler_visible(culler, &view.c, found.data(), found.size(), &count);
        if (status == SL_ERROR_HANDLE) return;  // destroyed
        if (status != SL_OK || count > boxes.c.size()) ++wrong;
        ++culled;
      }
    });
  const std::vector<std::uint32_t> some{0, 1999, 7, 1000, 7};
  for (int i = 0; i < 300 || culled < 100; ++i) {
    EXPECT_OK(sl_box_culler_update(culler, std::uint32_t(i) % 2000, &boxes.c[std::size_t(i) % 7]));
    EXPECT_OK(sl_box_culler_update_many(culler, some.data(), &boxes.c[std::size_t(i) % 7], some.size()));
    if (i % 10 == 0) {
      EXPECT_OK(sl_box_culler_refit(culler, boxes.c.data(), boxes.c.size()));
    }
  }
  EXPECT_OK(sl_box_culler_destroy(culler));
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

// --- occluders -------------------------------------------------------------------------------------------------------

constexpr int kImageWidth = 160, kImageHeight = 100;

/// A culler of many small boxes and a raster, in both APIs.
class CapiOccluders : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_OK(sl_box_culler_create(boxes.c.data(), boxes.c.size(), &culler));
    ASSERT_OK(sl_occluder_raster_create(&raster));
  }
  void TearDown() override {
    EXPECT_OK(sl_box_culler_destroy(culler));
    EXPECT_OK(sl_occluder_raster_destroy(raster));
  }

  void add_walls() {
    std::size_t added = 7, added_in_cpp = 0;
    ASSERT_OK(sl_occluder_raster_begin(raster, &view.c, kImageWidth, kImageHeight));
    twin.begin(view.cpp, kImageWidth, kImageHeight);
    ASSERT_OK(sl_occluder_raster_add_largest(raster, walls.data(), walls.size(), 2, &added));
    const std::vector<core::AabbD> same = {
        {{-20, -40, -20}, {20, -39, 20}}, {{30, -40, 0}, {31, -39, 1}}, {{-60, 10, -60}, {-20, 11, 60}}};
    added_in_cpp = twin.add_largest(same, 2);
    EXPECT_EQ(added, added_in_cpp);
    Matrix cube, cylinder = translation(40, -30, 0);
    cube.m[0] = 6, cube.m[1] = 2, cube.m[12] = -35, cube.m[13] = -30;
    cylinder.m[0] = cylinder.m[5] = 5, cylinder.m[10] = 20;
    ASSERT_OK(sl_occluder_raster_add_cube(raster, cube.m));
    ASSERT_OK(sl_occluder_raster_add_cylinder(raster, cylinder.m, 12));
    const auto affine = [](const Matrix& m) {
      const core::dmat4 all = glm::make_mat4(m.m);
      return core::Affine{core::dmat3(all), core::dvec3(all[3])};
    };
    EXPECT_TRUE(twin.add_cube(affine(cube)));
    EXPECT_TRUE(twin.add_cylinder(affine(cylinder), 12));
    const float corners[9] = {-50, -20, -50, -10, -20, -50, -30, -20, 50};
    const std::uint32_t indices[3] = {0, 1, 2};
    sl_mesh_data mesh = SL_MESH_DATA_INIT;
    mesh.vertex_count = 3, mesh.positions = corners, mesh.index_count = 3, mesh.indices = indices;
    ASSERT_OK(sl_occluder_raster_add_mesh(raster, &mesh, nullptr));
    const core::vec3 positions[3] = {{-50, -20, -50}, {-10, -20, -50}, {-30, -20, 50}};
    twin.add_mesh(positions, indices, {});
  }
  /// The boxes that `ask` lists.
  template <class Ask>
  std::vector<std::uint32_t> seen(const Ask& ask) {
    std::vector<std::uint32_t> found(boxes.c.size());
    std::size_t count = 0;
    EXPECT_OK(ask(found.data(), found.size(), &count));
    found.resize(count);
    return found;
  }

  const Boxes boxes{20'000};
  const BothViews view{{0, -90, 5}, {0, 0, 0}, double(kImageWidth) / kImageHeight};
  const std::vector<sl_box> walls = {
      {{-20, -40, -20}, {20, -39, 20}}, {{30, -40, 0}, {31, -39, 1}}, {{-60, 10, -60}, {-20, 11, 60}}};
  sl_box_culler culler = {0};
  sl_occluder_raster raster = {0};
  culling::OccluderRaster twin;
  std::vector<float> image = std::vector<float>(kImageWidth * kImageHeight);
};

TEST_F(CapiOccluders, HideTheBoxesThatTheyHideInCpp) {
  auto cpp = culling::BoxCuller::create(boxes.cpp);
  ASSERT_TRUE(cpp);
  for (int round = 0; round < 2; ++round) {
    add_walls();
    std::vector<float> expected_image(image.size());
    ASSERT_OK(sl_occluder_raster_read(raster, image.data(), image.size()));
    twin.distances(expected_image);
    EXPECT_EQ(image, expected_image);
    culling::DepthPyramid pyramid;
    twin.build(pyramid);
    std::vector<std::uint32_t> expected, all;
    cpp->visible(view.cpp, pyramid, expected);
    cpp->visible(view.cpp, all);
    const auto behind = seen([&](std::uint32_t* to, std::size_t capacity, std::size_t* count) {
      return sl_box_culler_visible_behind(culler, &view.c, raster, to, capacity, count);
    });
    const auto in_depth = seen([&](std::uint32_t* to, std::size_t capacity, std::size_t* count) {
      return sl_box_culler_visible_in_depth(culler, &view.c, image.data(), kImageWidth, kImageHeight, to, capacity,
                                            count);
    });
    EXPECT_EQ(behind, expected);
    EXPECT_EQ(in_depth, expected);
    EXPECT_LT(expected.size(), all.size() * 9 / 10);
    EXPECT_GT(expected.size(), 200u);
  }
  // More occluders count from the next call on, and another begin() forgets all.
  const auto hidden_by_now = [&] {
    std::size_t count = 0;
    EXPECT_OK(sl_box_culler_visible_behind(culler, &view.c, raster, nullptr, 0, &count));
    return count;
  };
  const std::size_t before = hidden_by_now();
  const sl_box everything = {{-90, -60, -90}, {90, -59, 90}};
  ASSERT_OK(sl_occluder_raster_add_largest(raster, &everything, 1, 1, nullptr));
  EXPECT_LT(hidden_by_now(), before / 4);
  ASSERT_OK(sl_occluder_raster_begin(raster, &view.c, kImageWidth, kImageHeight));
  EXPECT_GT(hidden_by_now(), before);
}

TEST_F(CapiOccluders, BadArgumentsAreErrors) {
  std::size_t count = 0;
  const Matrix identity;
  Matrix projective;
  projective.m[3] = 1;
  EXPECT_EQ(sl_occluder_raster_add_cube(raster, identity.m), SL_ERROR_ARGUMENT) << "before begin";
  EXPECT_EQ(sl_occluder_raster_read(raster, image.data(), image.size()), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_visible_behind(culler, &view.c, raster, nullptr, 0, &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_occluder_raster_begin(raster, &view.c, 0, 10), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_occluder_raster_begin(raster, &view.c, 16385, 10), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_occluder_raster_begin(raster, nullptr, 10, 10), SL_ERROR_ARGUMENT);
  ASSERT_OK(sl_occluder_raster_begin(raster, &view.c, 10, 10));
  EXPECT_EQ(sl_occluder_raster_add_cube(raster, projective.m), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_occluder_raster_add_cylinder(raster, identity.m, 2), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_occluder_raster_add_cylinder(raster, identity.m, 17), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_occluder_raster_add_largest(raster, nullptr, 1, 1, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_occluder_raster_add_mesh(raster, nullptr, nullptr), SL_ERROR_ARGUMENT);
  const float corner[3] = {0, 0, 0};
  const std::uint32_t indices[3] = {0, 0, 1};
  sl_mesh_data mesh = SL_MESH_DATA_INIT;
  mesh.vertex_count = 1, mesh.positions = corner, mesh.index_count = 3, mesh.indices = indices;
  EXPECT_EQ(sl_occluder_raster_add_mesh(raster, &mesh, nullptr), SL_ERROR_ARGUMENT) << "no such vertex";
  mesh.index_count = 2;
  EXPECT_EQ(sl_occluder_raster_add_mesh(raster, &mesh, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_occluder_raster_read(raster, image.data(), 99), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_occluder_raster_read(raster, nullptr, 100), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_visible_in_depth(culler, &view.c, nullptr, 10, 10, nullptr, 0, &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_visible_in_depth(culler, &view.c, image.data(), 0, 10, nullptr, 0, &count),
            SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_box_culler_visible_behind(culler, &view.c, {culler.id}, nullptr, 0, &count), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_box_culler_visible_behind({raster.id}, &view.c, raster, nullptr, 0, &count), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_occluder_raster_destroy({0}), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_occluder_raster_create(nullptr), SL_ERROR_ARGUMENT);
}

}  // namespace
}  // namespace sightline::tests::box_culler_test
