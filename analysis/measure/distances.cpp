#include "sightline/analysis/measure/distances.h"

#include <algorithm>
#include <cmath>

#include "sightline/analysis/measure/internal/closest.h"
#include "sightline/analysis/measure/internal/item_data.h"

namespace sightline::measure {
namespace {

constexpr double kParallel = 1e-6;

double sine(const dvec3& unit_a, const dvec3& unit_b) {
  return glm::length(glm::cross(unit_a, unit_b));
}

/// Unit length, or zero. Scaled first, so that no square overflows or vanishes.
dvec3 unit(const dvec3& v) {
  const double size = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  return size > 0.0 ? glm::normalize(v / size) : dvec3(0.0);
}

Distance between_points(const dvec3& origin, const dvec3& from, const dvec3& to) {
  Distance found;
  found.distance = glm::length(to - from);
  found.from = origin + from, found.to = origin + to;
  found.touching = found.distance == 0.0;
  return found;
}

Distance between_lines(const Line& a, const Line& b) {
  const dvec3 u = unit(a.direction), v = unit(b.direction), offset = b.through - a.through;
  // Solved with the difference of the directions' perpendicular part, which keeps its digits where they are nearly
  // parallel.
  const dvec3 across = glm::cross(u, v);
  const double squared = glm::dot(across, across);
  if (squared < 1e-30) {  // parallel, or a point
    const dvec3 along = u == dvec3(0.0) ? v : u;
    const dvec3 foot = offset - along * glm::dot(offset, along);
    return u == dvec3(0.0) ? between_points(a.through, dvec3(0.0), foot) : between_points(b.through, -foot, dvec3(0.0));
  }
  const double s = glm::dot(glm::cross(offset, v), across) / squared;
  const double t = glm::dot(glm::cross(offset, u), across) / squared;
  Distance found = between_points(a.through, s * u, offset + t * v);
  // The part of the offset along the common normal: exact even where the closest points are far away.
  found.distance = std::fabs(glm::dot(offset, across)) / std::sqrt(squared);
  found.touching = found.distance == 0.0;
  return found;
}

Distance between_shapes(const Shape& a, const Shape& b, const SearchLimits& limits = {}) {
  const Gap gap = closest(a, b, limits);
  Distance found;
  found.distance = gap.upper;
  found.from = a.origin + gap.a, found.to = a.origin + gap.b;
  found.error = std::isinf(gap.upper) ? gap.upper : gap.upper - gap.lower + a.error + b.error;
  if (std::isinf(gap.upper)) return found;
  const auto within = [](const Shape& mesh, const dvec3& point) {
    return mesh.solid && !mesh.nodes.empty() && encloses(mesh, point);
  };
  // Positions are no better than this.
  constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();
  const double size = glm::length(a.origin) + glm::length(b.origin) + glm::length(gap.a) + glm::length(gap.b);
  // The slice in which a point lies is found to the search's tolerance only.
  const double resolution = gap.lower <= kRounding * size ? std::max(kRounding * size, sweep_tolerance(a, b)) : 0.0;
  found.touching = gap.upper <= resolution || within(a, gap.b) || within(b, a.origin - b.origin + gap.a);
  if (found.touching) found.distance = found.error = 0.0;
  return found;
}

/// The part of a line that faces the shape. The point of the line that is closest to a point of the shape is that
/// point's foot, which lies within the extent of the shape along the line.
Segment facing(const Line& line, const Shape& shape) {
  const dvec3 u = unit(line.direction);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const dvec3 offset = shape.origin - line.through;
  const auto grow = [&](const Piece& piece) {
    high = std::max(high, glm::dot(support(piece, u).point, u));
    low = std::min(low, glm::dot(support(piece, -u).point, u));
  };
  if (shape.form == Shape::Form::kSweep) {
    constexpr dvec2 kQuarters[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 0}};
    for (int i = 0; i < 4; ++i) grow({&shape, offset, kQuarters[i], kQuarters[i + 1]});
  } else if (shape.form != Shape::Form::kTriangles || !shape.nodes.empty()) {
    grow({&shape, offset});
  } else {
    low = high = 0.0;
  }
  return {line.through + low * u, line.through + high * u};
}

Distance to_shape(const Geometry& feature, const Shape& shape, const SearchLimits& limits = {}) {
  const Line* line = std::get_if<Line>(&feature);
  return between_shapes(line ? make_shape(facing(*line, shape)) : make_shape(feature), shape, limits);
}

Distance reversed(Distance d) {
  std::swap(d.from, d.to);
  return d;
}

/// What a feature has for angles: a direction, or a plane by its normal.
struct Orientation {
  dvec3 direction{0.0};
  bool plane = false;
};

Orientation orientation(const Geometry& geometry) {
  if (const auto* segment = std::get_if<Segment>(&geometry)) return {unit(segment->to - segment->from), false};
  if (const auto* line = std::get_if<Line>(&geometry)) return {unit(line->direction), false};
  if (const auto* arc = std::get_if<Arc>(&geometry)) return {unit(glm::cross(unit(arc->u), unit(arc->v))), true};
  if (const auto* face = std::get_if<Face>(&geometry)) return {unit(face->normal), true};
  return {};
}

}  // namespace

Distance limited_distance(const Geometry& a, const Geometry& b, const SearchLimits& limits) {
  const Line *line_a = std::get_if<Line>(&a), *line_b = std::get_if<Line>(&b);
  if (line_a && line_b) return between_lines(*line_a, *line_b);
  if (line_b) return reversed(to_shape(b, make_shape(a), limits));
  return to_shape(a, make_shape(b), limits);
}

Distance distance(const Geometry& a, const Geometry& b) {
  return limited_distance(a, b, {});
}

Distance distance(const Item& a, const Item& b) {
  return between_shapes(a.data().shape, b.data().shape);
}

Distance distance(const Geometry& feature, const Item& item) {
  return to_shape(feature, item.data().shape);
}

std::optional<double> angle(const Geometry& a, const Geometry& b) {
  const Orientation first = orientation(a), second = orientation(b);
  if (first.direction == dvec3(0.0) || second.direction == dvec3(0.0)) return std::nullopt;
  const double across = sine(first.direction, second.direction);
  const double along = std::fabs(glm::dot(first.direction, second.direction));
  return first.plane == second.plane ? std::atan2(across, along) : std::atan2(along, across);
}

AxisDistance axis_distance(const Segment& a, const Segment& b) {
  const dvec3 extent_a = a.to - a.from, extent_b = b.to - b.from;
  AxisDistance found;
  found.angle = angle(a, b).value_or(0.0);
  found.parallel = found.angle <= kParallel;
  if (!found.parallel) {
    found.shortest = between_lines({a.from, extent_a}, {b.from, extent_b});
    return found;
  }
  // Along a, relative to its start.
  const dvec3 along = extent_a == dvec3(0.0) ? unit(extent_b) : unit(extent_a);
  const double end_a = glm::dot(extent_a, along);
  const auto [low_b, high_b] = std::minmax({glm::dot(b.from - a.from, along), glm::dot(b.to - a.from, along)});
  const double low = std::max(0.0, low_b), high = std::min(end_a, high_b);
  const Line line_b{b.from, extent_b == dvec3(0.0) ? extent_a : extent_b};
  found.shortest = between_lines({a.from + along * (0.5 * (low + high)), dvec3(0.0)}, line_b);
  return found;
}

}  // namespace sightline::measure
