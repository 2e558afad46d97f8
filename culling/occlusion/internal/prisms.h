// Internal: the convex solids that the occluder raster knows.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "sightline/core/affine.h"

namespace sightline::culling::raster {

/// A prism along z between -1 and 1 over a convex polygon: first the corners below, then those above. Faces: the sides,
/// side i over the edge from corner i to the next, then the ends below and above, each with its corners in the order
/// that turns left as seen from outside.
struct Prism {
  static constexpr int kMostSides = 16;
  static constexpr double kMostBulge = 2.01;  // coordinates; that of three sides
  struct Edge {
    std::uint8_t from, to;     // as the face on its left has it
    std::uint8_t left, right;  // faces
  };

  /// `bulge`: where the tangents at two neighbouring corners meet, as a multiple of the point in their middle; 0: none.
  Prism(std::span<const core::dvec2> base, double bulge) {
    const auto n = std::uint8_t(base.size());
    for (const double z : {-1.0, 1.0})
      for (const core::dvec2& p : base) corners.push_back({p, z});
    faces.resize(std::size_t(n) + 2);
    for (std::uint8_t i = 0; i < n; ++i) {
      const auto next = std::uint8_t((i + 1) % n), above = std::uint8_t(n + i), above_next = std::uint8_t(n + next);
      faces[i] = {i, next, above_next, above};
      faces[n].push_back(std::uint8_t(n - 1 - i));
      faces[n + 1u].push_back(above);
      edges.push_back({i, next, i, n});
      edges.push_back({above_next, above, i, std::uint8_t(n + 1)});
      edges.push_back({next, above_next, i, next});
      if (bulge == 0.0) continue;
      const core::dvec2 outside = 0.5 * bulge * (base[i] + base[next]);
      bulges.push_back({outside, -1.0});
      bulges.push_back({outside, 1.0});
    }
  }

  std::vector<core::dvec3> corners;
  std::vector<std::vector<std::uint8_t>> faces;
  std::vector<Edge> edges;
  /// Two for each side, or none: what is drawn lies within the hull of the side and these, not in the side itself.
  std::vector<core::dvec3> bulges;
};

/// The prism of so many sides within the cylinder of radius 1.
inline const Prism& prism(int sides) {
  static const std::vector<Prism> kPrisms = [] {
    std::vector<Prism> prisms;
    for (int n = 3; n <= Prism::kMostSides; ++n) {
      std::vector<core::dvec2> base;
      for (int i = 0; i < n; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / n;
        base.push_back((1.0 - 0x1p-48) * core::dvec2(std::cos(angle), std::sin(angle)));
      }
      const double middle = std::cos(std::numbers::pi / n);
      prisms.emplace_back(base, (1.0 + 0x1p-40) / (middle * middle));
    }
    return prisms;
  }();
  return kPrisms[std::size_t(sides - 3)];
}

inline const Prism& cube() {
  static const Prism kCube{std::array{core::dvec2(-1, -1), core::dvec2(1, -1), core::dvec2(1, 1), core::dvec2(-1, 1)},
                           0.0};
  return kCube;
}

}  // namespace sightline::culling::raster
