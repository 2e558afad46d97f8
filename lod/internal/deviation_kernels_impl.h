// Internal: what all forms of the kernels have in common. Included by them alone. Form is a type of the including
// file's anonymous namespace, so that every instance is local to the file.
//
// Four::load, spread and operators, least() and most() as the processor has them (the second where neither is less),
// less() with a bit for each lane, and Form::choose(), which takes from `where_less` where the first lane is less.
#pragma once

#include <limits>

#include "sightline/lod/internal/deviation_kernels.h"

namespace sightline::lod {

template <class Form>
struct DeviationKernelsOf {
  using Four = typename Form::Four;
  struct Point {
    Four x, y, z;
  };

  static Point load(const Polygon& polygon, int i) {
    Point points;
    Form::load(&polygon.corners[i], points.x, points.y, points.z);
    return points;
  }
  static Point spread(const core::dvec3& p) { return {Four::spread(p.x), Four::spread(p.y), Four::spread(p.z)}; }
  static Point minus(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  static Four dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

  /// Square distance from an edge of a face. Wherever on the edge rounding puts its nearest point, none is nearer.
  static Four from_edge(const FaceShape& face, int k, const Point& points) {
    const Point from = spread(face.corners[k]), p = minus(points, from);
    const Point along = minus(spread(face.corners[k == 2 ? 0 : k + 1]), from);
    const Four t = dot(p, along) * Four::spread(face.per_square[k]);
    const Four inside = least(most(t, Four::spread(0.0)), Four::spread(1.0));
    const Point to{p.x - inside * along.x, p.y - inside * along.y, p.z - inside * along.z};
    return dot(to, to);
  }
  static Four beside(const Four& coordinate, double height) {
    const Four outside = least(coordinate, Four::spread(0.0));
    return outside * outside * Four::spread(height);
  }

  /// Four corners alone, so that the compiler keeps nothing for the next ones, which most polygons do not have.
  static Farthest of_four(const FaceShape& face, const Polygon& polygon, int first, double most_square) {
    const Four limit = Four::spread(most_square), border = Four::spread(-kBeside);
    const Point points = load(polygon, first), p = minus(points, spread(face.corners[0]));
    const Four u = dot(spread(face.gradients[0]), p), v = dot(spread(face.gradients[1]), p);
    const Four w = Four::spread(1.0) - u - v, height = dot(spread(face.normal), p);
    const Four coordinate = least(least(u, v), w);
    Four square = height * height;
    unsigned beyond = 0;
    if (less(coordinate, border) != 0) {
      beyond =
          unsigned(less(v, border) != 0) | unsigned(less(w, border) != 0) << 1 | unsigned(less(u, border) != 0) << 2;
      const Four aside = most(most(beside(u, face.heights[0]), beside(v, face.heights[1])), beside(w, face.heights[2]));
      if (less(limit, square + aside) != 0) return {std::numeric_limits<double>::infinity(), beyond};
      const Four edges =
          least(least(from_edge(face, 0, points), from_edge(face, 1, points)), from_edge(face, 2, points));
      square = Form::choose(coordinate, border, edges, square);
    }
    return {Form::largest(square), beyond};
  }

  static Farthest farthest(const FaceShape& face, const Polygon& polygon, double most_square) {
    Farthest found = of_four(face, polygon, 0, most_square);
    for (int i = kLanes; i < polygon.count; i += kLanes) {
      const Farthest more = of_four(face, polygon, i, most_square);
      found.square = more.square > found.square ? more.square : found.square;
      found.beyond |= more.beyond;
    }
    return found;
  }

  static Side split(const Polygon& polygon, const core::dvec3& normal, const core::dvec3& point, double rounding,
                    Polygon& inside, Polygon& outside) {
    const Point across = spread(normal), from = spread(point);
    const Four high = Four::spread(rounding), low = Four::spread(-rounding);
    double side[12];
    unsigned above = 0, below = 0;
    for (int i = 0; i < polygon.count; i += kLanes) {
      const Four sides = dot(across, minus(load(polygon, i), from));
      sides.store(side + i);
      above |= less(high, sides) << i;
      below |= less(sides, low) << i;
    }
    if (above == 0) return Side::kInside;
    if (below == 0) return Side::kOutside;
    const int count = polygon.count;
    int cuts = 0;
    inside.count = outside.count = 0;
    for (int i = 0; i < count; ++i) {
      const int next = i + 1 < count ? i + 1 : 0;
      const Corner& corner = polygon.corners[i];
      const unsigned over = above >> i & 1, under = below >> i & 1;
      Form::copy(corner, inside.corners[inside.count]), inside.count += int(over ^ 1);
      Form::copy(corner, outside.corners[outside.count]), outside.count += int(under ^ 1);
      if (((over & (below >> next)) | (under & (above >> next))) == 0) continue;
      if (++cuts > 2) return Side::kInside;
      Corner& between = inside.corners[inside.count++];
      Form::between(corner, polygon.corners[next], side[i] / (side[i] - side[next]), between);
      Form::copy(between, outside.corners[outside.count++]);
    }
    for (int i = inside.count; i % kLanes != 0; ++i) Form::copy(inside.corners[0], inside.corners[i]);
    for (int i = outside.count; i % kLanes != 0; ++i) Form::copy(outside.corners[0], outside.corners[i]);
    return Side::kBoth;
  }
};

template <class Form>
constexpr DeviationKernels make_deviation_kernels() {
  return {DeviationKernelsOf<Form>::farthest, DeviationKernelsOf<Form>::split, Form::near_ones};
}

}  // namespace sightline::lod
