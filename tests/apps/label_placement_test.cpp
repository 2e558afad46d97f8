// Labels of points that lie close together cover neither each other nor the points, and stay in the plot.
#include "sightline/apps/common/label_placement.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace sightline::apps::label_placement_test {
namespace {

bool overlap(const Rectangle& a, const Rectangle& b) {
  return std::max(a.left, b.left) < std::min(a.right, b.right) && std::max(a.top, b.top) < std::min(a.bottom, b.bottom);
}

constexpr Rectangle kArea{0, 0, 400, 300};
constexpr double kWidth = 60, kHeight = 14, kRadius = 4;

Rectangle mark_at(double x, double y) {
  return {x - kRadius, y - kRadius, x + kRadius, y + kRadius};
}

/// Places a label for each point.
std::vector<Rectangle> placed(const std::vector<std::array<double, 2>>& points) {
  LabelPlacement placement(kArea);
  for (const auto& [x, y] : points) placement.add_mark(mark_at(x, y));
  std::vector<Rectangle> labels;
  for (const auto& [x, y] : points) labels.push_back(placement.place(x, y, kWidth, kHeight));
  return labels;
}

TEST(LabelPlacement, ALoneLabelStandsBesideItsPoint) {
  const Rectangle label = placed({{200, 150}}).front();
  EXPECT_GT(label.left, 200 + kRadius);
  EXPECT_LT(label.left, 200 + 5 * kRadius);
  EXPECT_DOUBLE_EQ(label.right - label.left, kWidth);
  EXPECT_DOUBLE_EQ(label.bottom - label.top, kHeight);
}

TEST(LabelPlacement, CrowdedLabelsCoverNothing) {
  const std::vector<std::vector<std::array<double, 2>>> crowds = {
      {{200, 150}, {203, 152}, {206, 149}, {210, 155}},      // a heap
      {{390, 10}, {392, 14}, {394, 290}, {6, 290}, {4, 8}},  // in corners
      {{200, 100}, {200, 108}, {200, 116}, {200, 124}},      // one above the other
      {{100, 150}, {110, 150}, {120, 150}, {130, 150}, {140, 150}}};
  for (const auto& points : crowds) {
    const std::vector<Rectangle> labels = placed(points);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      EXPECT_GE(labels[i].left, kArea.left);
      EXPECT_LE(labels[i].right, kArea.right);
      EXPECT_GE(labels[i].top, kArea.top);
      EXPECT_LE(labels[i].bottom, kArea.bottom);
      for (const auto& [x, y] : points) EXPECT_FALSE(overlap(labels[i], mark_at(x, y))) << x << ' ' << y;
      for (std::size_t k = 0; k < i; ++k) EXPECT_FALSE(overlap(labels[i], labels[k])) << i << ' ' << k;
    }
  }
}

/// A line to the right takes the places there, where a label would stand without it.
TEST(LabelPlacement, LinesAreLeftFreeWhereThereIsRoom) {
  LabelPlacement placement(kArea);
  placement.add_line({{200, 150}, {300, 145}});
  const Rectangle label = placement.place(200, 150, kWidth, kHeight);
  EXPECT_FALSE(overlap(label, {206, 144, 300, 150})) << label.left << ' ' << label.top;
}

}  // namespace
}  // namespace sightline::apps::label_placement_test
