// gpuprims::edges_of() against the edges that measure finds by code of its own.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/analysis/measure/features.h"
#include "sightline/gpuprims/internal/edges.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::tests::primitive_edges_test {
namespace {

using core::dvec3;
using Points = std::vector<dvec3>;

constexpr int kPoints = 256;  // of an edge

Points points_of(const gpuprims::PrimitiveEdge& edge) {
  Points points;
  for (int i = 0; i <= kPoints; ++i) {
    const double t = edge.sweep * i / kPoints;
    points.push_back(edge.centre + std::cos(t) * edge.u + std::sin(t) * edge.v);
  }
  return points;
}
Points points_of(const measure::Geometry& geometry) {
  Points points;
  for (int i = 0; i <= kPoints; ++i) {
    const double share = double(i) / kPoints;
    if (const auto* segment = std::get_if<measure::Segment>(&geometry)) {
      points.push_back(glm::mix(segment->from, segment->to, 0.5 - 0.5 * std::cos(share * std::numbers::pi)));
    } else {
      const measure::Arc& arc = std::get<measure::Arc>(geometry);
      const double t = glm::mix(arc.from, arc.to, share);
      points.push_back(arc.centre + std::cos(t) * arc.u + std::sin(t) * arc.v);
    }
  }
  return points;
}
/// The largest distance of a point of one from the nearest of the other.
double apart(const Points& a, const Points& b) {
  double most = 0.0;
  for (const dvec3& p : a) {
    double least = std::numeric_limits<double>::max();
    for (const dvec3& q : b) least = std::min(least, glm::distance(p, q));
    most = std::max(most, least);
  }
  return most;
}
double size_of(const Points& points) {
  dvec3 low = points[0], high = points[0];
  for (const dvec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  return glm::length(high - low);
}

TEST(PrimitiveEdges, AreThoseOfMeasure) {
  Random random(7);
  for (const core::Kind kind : {core::Kind::kPyramid, core::Kind::kBox, core::Kind::kRectangularTorus,
                                core::Kind::kCircularTorus, core::Kind::kEllipticalDish, core::Kind::kSphericalDish,
                                core::Kind::kSnout, core::Kind::kCylinder, core::Kind::kSphere})
    for (int turn = 0; turn < 12; ++turn) {
      SCOPED_TRACE(testing::Message() << core::name_of(kind) << " " << turn);
      const auto length = [&] { return float(uniform(random, 0.2, 5.0)); };
      core::Primitive primitive = primitive_of(
          kind, length, [&] { return float(uniform(random, -1.0, 1.0)); },
          [&] { return turn % 3 == 0 ? float(core::kFullTurn) : float(uniform(random, 0.2, 6.0)); });
      if (auto* torus = std::get_if<core::CircularTorus>(&primitive))
        torus->major_radius = torus->tube_radius * float(uniform(random, 1.1, 4.0));
      if (auto* snout = std::get_if<core::Snout>(&primitive); snout && turn % 2 == 1) {
        snout->height = 12.0f;
        snout->bottom_shear_x = 0.2f, snout->top_shear_y = -0.3f;
      }
      core::Affine placed = core::translation({uniform(random, -9.0, 9.0), 2.0, 5.0});
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) placed.linear[c][r] = uniform(random, -1.0, 1.0) + (c == r ? 2.0 : 0.0);
      std::vector<Points> found, wanted;
      for (const gpuprims::PrimitiveEdge& edge : gpuprims::edges_of(primitive, placed))
        found.push_back(points_of(edge));
      const auto features = measure::features(primitive, placed);
      ASSERT_TRUE(features);
      for (const measure::Feature& feature : *features)
        if (feature.kind == measure::FeatureKind::kEdge) wanted.push_back(points_of(feature.geometry));
      ASSERT_EQ(found.size(), wanted.size());
      for (const Points& edge : wanted) {
        const double step = 2.0 * core::kFullTurn / kPoints * size_of(edge);  // points of both lie elsewhere on it
        EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const Points& other) {
          return apart(edge, other) < step && apart(other, edge) < step;
        }));
      }
    }
}

TEST(PrimitiveEdges, OfWhatHasNone) {
  EXPECT_TRUE(gpuprims::edges_of(core::Sphere{2.0f}, {}).empty());
  EXPECT_TRUE(gpuprims::edges_of(core::Line{0.0f, 1.0f}, {}).empty());
  EXPECT_TRUE(gpuprims::edges_of(core::CircularTorus{2.0f, 1.0f, float(core::kFullTurn)}, {}).empty());
  EXPECT_EQ(gpuprims::edges_of(core::Box{1.0f, 1.0f, 0.0f}, {}).size(), 8u);             // uprights have no length
  EXPECT_EQ(gpuprims::edges_of(core::Snout{1, 0, 2, 0, 0, 0, 0, 0, 0}, {}).size(), 1u);  // a tip has no rim
}

}  // namespace
}  // namespace sightline::tests::primitive_edges_test
