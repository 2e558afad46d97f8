// What both dishes have in common, by type.
#pragma once

#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::twin {

template <class Dish>
void expect_a_disc_of_two_sides_without_height() {
  for (const float height : {0.0f, 1e-30f}) {
    const Dish disc{2.0f, height};
    const Hits hits = intersect(disc, {{1.0, 0.0, 5.0}, {0.0, 0.0, -2.0}});
    ASSERT_EQ(hits.count, 2);
    EXPECT_EQ(hits.hit[0].t, 2.5);
    EXPECT_EQ(hits.hit[0].normal.z, 1.0);
    EXPECT_EQ(hits.hit[1].t, 2.5);
    EXPECT_EQ(hits.hit[1].normal.z, -1.0);
    EXPECT_EQ(intersect(disc, {{2.1, 0.0, 5.0}, {0.0, 0.0, -1.0}}).count, 0);
    EXPECT_EQ(intersect(disc, {{1.0, 0.0, 5.0}, {0.0, 0.0, -2.0}}, {false, true}).count, 1) << "the upper side";
  }
}

template <class Dish>
void expect_an_open_base_to_drop_its_crossing_only() {
  const Dish dish{1.0f, 0.5f};
  const Ray down{{0.1, 0.2, 5.0}, {0.0, 0.0, -1.0}};
  const Hits open = intersect(dish, down, {false, true});
  ASSERT_EQ(open.count, 1);
  EXPECT_GT(open.hit[0].normal.z, 0.0);
  const Hits closed = intersect(dish, down, {true, false});
  ASSERT_EQ(closed.count, 2) << "it has no top";
  EXPECT_EQ(closed.hit[1].t, 5.0);
}

}  // namespace sightline::gpuprims::twin
