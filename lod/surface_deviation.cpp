#include "sightline/lod/internal/surface_deviation.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace sightline::lod {
namespace {

using core::dvec3;

// How often polygons of a surface may be cut or handed on to the next face: enough for fans of slivers across each
// other, and a bound for the time that hostile surfaces take.
constexpr std::int64_t kFewestSteps = 4000, kStepsPerCorner = 30;
constexpr std::size_t kMostProbes = 8;
constexpr double kTight = 1.1;       // a bound that exceeds a true distance by this factor is not refined
constexpr double kRaise = 1.02;      // the bound rises by a little more than it must, so it rises seldom
constexpr double kOutside = 0.5;     // of the bound: nearer polygons are not divided
constexpr double kSliver = 0.05;     // sine of the angle below which a triangle's normal is rounded too much
constexpr double kRounding = 1e-12;  // of distances, relative to coordinates: far more than the few roundings of each
constexpr double kNormalRounding = 4e-15;  // of a normal before it gets unit length, relative to the edges: the same

/// Nearest point of a triangle (C. Ericson, "Real-time collision detection", 2005, section 5.1.5).
dvec3 nearest_point(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  const dvec3 cp = p - c;
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

double square_of(const dvec3& v) {
  return glm::dot(v, v);
}

/// A triangle's normal of unit length, or 0. `rounding`: largest distance from the exact one; above 1 it tells nothing.
dvec3 unit_normal(const dvec3& a, const dvec3& b, const dvec3& c, double& rounding) {
  const dvec3 ab = b - a, ac = c - a, normal = glm::cross(ab, ac);
  const double length = glm::length(normal);
  rounding = kNormalRounding * std::sqrt(square_of(ab) * square_of(ac)) / length;
  return length > 0.0 ? normal / length : dvec3(0.0);
}

}  // namespace

Deviation SurfaceDeviation::bound(const Triangles& from, const Triangles& to) {
  if (from.corners.empty()) return {};
  assert(!to.corners.empty());
  make_faces(to);
  dvec3 size(0.0);
  for (const Triangles* triangles : {&from, &to})
    for (const std::uint32_t corner : triangles->corners) size = glm::max(size, glm::abs(triangles->points[corner]));
  const double largest = std::max({size.x, size.y, size.z});
  rounding_ = 0.1 * kRounding * largest;
  of_from_.assign(from.corners.size() / 3, 0.0);
  of_to_.assign(faces_.size(), 0.0);
  least_ = probe(from, to);
  bound_ = std::max(rounding_, kTight * least_);
  cosine_ = 1.0;
  steps_ = 0;
  most_steps_ = kFewestSteps + kStepsPerCorner * std::int64_t(from.corners.size() + to.corners.size());
  for (triangle_ = 0; triangle_ < starts_.size(); ++triangle_) {
    Polygon triangle;
    triangle.count = 3;
    for (std::size_t k = 0; k < 3; ++k) triangle.corners[k] = from.points[from.corners[3 * triangle_ + k]];
    normal_ = unit_normal(triangle.corners[0], triangle.corners[1], triangle.corners[2], normal_rounding_);
    error_ = from.errors.empty() ? 0.0 : double(from.errors[triangle_]);
    for (pieces_.push_back({triangle, starts_[triangle_], kNone}); !pieces_.empty();) {
      const Piece piece = pieces_.back();
      pieces_.pop_back();
      cover(piece);
    }
  }
  const auto outwards = [&](double distance) { return distance * (1.0 + kRounding) + kRounding * largest; };
  for (std::vector<double>* distances : {&of_from_, &of_to_})
    std::ranges::transform(*distances, distances->begin(), outwards);
  return {*std::ranges::max_element(of_from_), std::acos(std::clamp(cosine_, -1.0, 1.0))};
}

/// Finds a face near each triangle, and returns the distance of some point that lies far from all faces: the bound
/// cannot be less, and most polygons need not be divided to prove that they lie within it.
double SurfaceDeviation::probe(const Triangles& from, const Triangles& to) {
  seeds_.assign(from.points.size(), kNone);
  for (std::uint32_t i = 0; i < to.corners.size(); ++i) seeds_[to.corners[i]] = i / 3;
  starts_.clear(), probes_.clear();
  for (std::uint32_t i = 0; i < from.corners.size(); i += 3) {
    const std::uint32_t* corners = &from.corners[i];
    const double error = from.errors.empty() ? 0.0 : double(from.errors[i / 3]);
    const dvec3 centre = (from.points[corners[0]] + from.points[corners[1]] + from.points[corners[2]]) / 3.0;
    const Near at = start(corners, centre);
    starts_.push_back(at.face);
    probes_.push_back({at.face, error, at.distance + error, centre});
    for (int k = 0; k < 3; ++k) {
      std::uint32_t& seed = seeds_[corners[k]];
      if (seed != kNone) continue;
      const dvec3& point = from.points[corners[k]];
      const Near there = nearest_from(near(at.face, point), point);
      seed = there.face;
      probes_.push_back({seed, error, there.distance + error, point});
    }
  }
  const std::size_t tries = std::min(kMostProbes, probes_.size());
  std::partial_sort(probes_.begin(), probes_.begin() + std::ptrdiff_t(tries), probes_.end(),
                    [](const Probe& a, const Probe& b) { return a.distance > b.distance; });
  double farthest = 0.0;
  for (std::size_t i = 0; i < tries && probes_[i].distance > farthest; ++i) {
    const Probe& probe = probes_[i];
    farthest = std::max(farthest, nearest(near(probe.face, probe.point), probe.point).distance + probe.error);
  }
  return farthest;
}

/// A face near the centre of a triangle, from those at its corners on.
SurfaceDeviation::Near SurfaceDeviation::start(const std::uint32_t* corners, const dvec3& centre) const {
  Near best{kNone, std::numeric_limits<double>::infinity()};
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t seed = seeds_[corners[k]];
    if (seed == kNone || seed == best.face) continue;
    const double distance = faces_[seed].distance(centre, best.distance);
    if (distance < best.distance) best = {seed, distance};
  }
  if (best.face == kNone) return nearest(near(0, centre), centre);
  return faces_[best.face].is_above(centre) ? best : nearest_from(best, centre);
}

void SurfaceDeviation::make_faces(const Triangles& to) {
  faces_.resize(to.corners.size() / 3);
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    Face& face = faces_[i];
    for (std::size_t k = 0; k < 3; ++k) {
      face.corners[k] = to.points[to.corners[3 * i + k]];
      face.neighbours[k] = kNone;
    }
    face.error = to.errors.empty() ? 0.0 : double(to.errors[i]);
    face.normal = unit_normal(face.corners[0], face.corners[1], face.corners[2], face.normal_rounding);
    const dvec3 ab = face.corners[1] - face.corners[0], ac = face.corners[2] - face.corners[0];
    const double area = glm::dot(glm::cross(ab, ac), face.normal);  // twice it
    const bool sliver = !(area > kSliver * std::sqrt(square_of(ab) * square_of(ac)));
    const double scale = sliver ? std::numeric_limits<double>::quiet_NaN() : 1.0 / area;
    face.gradients[0] = scale * glm::cross(ac, face.normal);
    face.gradients[1] = scale * glm::cross(face.normal, ab);
    const double area_square = area * area;
    face.heights[0] = area_square / square_of(ac), face.heights[1] = area_square / square_of(ab);
    face.heights[2] = area_square / square_of(ac - ab);
  }
  join_faces(to);
  make_balls();
}

/// In float, relative to a point among the faces: they tell only where to look. Balls of no face are infinitely far;
/// radii are less by the face's error.
void SurfaceDeviation::make_balls() {
  origin_ = faces_[0].corners[0];
  balls_.assign((faces_.size() + kBalls - 1) / kBalls, {});
  for (Balls& balls : balls_) std::ranges::fill(balls.x, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const auto& [a, b, c] = faces_[i].corners;
    const dvec3 centre = (a + b + c) / 3.0;
    const core::vec3 at(centre - origin_);
    Balls& balls = balls_[i / kBalls];
    balls.x[i % kBalls] = at.x, balls.y[i % kBalls] = at.y, balls.z[i % kBalls] = at.z;
    balls.radius[i % kBalls] = float(
        std::sqrt(std::max({square_of(a - centre), square_of(b - centre), square_of(c - centre)})) - faces_[i].error);
  }
}

/// Where more than two triangles meet at an edge, the first two that are left become neighbours, and so on: any choice
/// is right.
void SurfaceDeviation::join_faces(const Triangles& to) {
  const std::span<const std::uint32_t> corners = to.corners;
  const auto end_of = [&](std::uint32_t i) { return corners[i % 3 == 2 ? i - 2 : i + 1]; };
  first_edge_.assign(to.points.size() + 1, 0);
  for (std::uint32_t i = 0; i < corners.size(); ++i) ++first_edge_[std::min(corners[i], end_of(i))];
  std::uint32_t sum = 0;
  for (std::uint32_t& first : first_edge_) sum += first, first = sum;
  edges_.resize(corners.size());
  for (auto i = std::uint32_t(corners.size()); i-- > 0;)
    edges_[--first_edge_[std::min(corners[i], end_of(i))]] = {std::max(corners[i], end_of(i)), i};
  for (std::size_t point = 0; point + 1 < first_edge_.size(); ++point) {
    const auto edges = std::span(edges_).subspan(first_edge_[point], first_edge_[point + 1] - first_edge_[point]);
    std::ranges::sort(
        edges, [](const HalfEdge& a, const HalfEdge& b) { return a.to != b.to ? a.to < b.to : a.corner < b.corner; });
    for (std::size_t i = 0; i + 1 < edges.size(); ++i)
      if (edges[i].to == edges[i + 1].to && edges[i].to != point && edges[i].corner / 3 != edges[i + 1].corner / 3) {
        join(corners, edges[i].corner, edges[i + 1].corner);
        ++i;
      }
  }
}

/// Makes the faces neighbours whose edges start at the corners `a` and `b`.
void SurfaceDeviation::join(std::span<const std::uint32_t> corners, std::uint32_t a, std::uint32_t b) {
  Face &first = faces_[a / 3], &second = faces_[b / 3];
  const auto cut_of = [](const Face& face, std::uint32_t edge, const dvec3& neighbour) {
    const dvec3 between = face.normal + neighbour;
    const dvec3 along = face.corners[(edge + 1) % 3] - face.corners[edge];
    const dvec3 cut = glm::cross(along, square_of(between) > 1e-12 ? between : face.normal);
    const double length = glm::length(cut);
    return length > 0.0 ? cut / length : dvec3(0.0);
  };
  const double sign = corners[a] == corners[b] ? -1.0 : 1.0;  // neighbours of opposite orientation
  first.neighbours[a % 3] = b / 3;
  second.neighbours[b % 3] = a / 3;
  first.cuts[a % 3] = cut_of(first, a % 3, sign * second.normal);
  second.cuts[b % 3] = cut_of(second, b % 3, sign * first.normal);
}

/// Walks to nearer neighbours until there is none.
SurfaceDeviation::Near SurfaceDeviation::nearest_from(Near start, const dvec3& point) const {
  for (;;) {
    Near nearer = start;
    for (const std::uint32_t neighbour : faces_[start.face].neighbours) {
      if (neighbour == kNone) continue;
      const double distance = faces_[neighbour].distance(point, nearer.distance);
      if (distance < nearer.distance) nearer = {neighbour, distance};
    }
    if (nearer.face == start.face) return start;
    start = nearer;
  }
}

/// Among all faces, but those whose balls are too far off. `start`: one that may be near.
SurfaceDeviation::Near SurfaceDeviation::nearest(Near start, const dvec3& point) const {
  Near best = nearest_from(start, point);
  const core::vec3 p(point - origin_);
  for (std::size_t first = 0; first < faces_.size(); first += kBalls) {
    const Balls& balls = balls_[first / kBalls];
    const auto most = float(best.distance);
    std::uint32_t near_ones = 0;
    for (std::size_t i = 0; i < kBalls; ++i) {
      const float x = balls.x[i] - p.x, y = balls.y[i] - p.y, z = balls.z[i] - p.z;
      const float reach = std::max(balls.radius[i] + most, 0.0f);
      near_ones |= std::uint32_t(x * x + y * y + z * z < reach * reach) << i;
    }
    for (; near_ones != 0; near_ones &= near_ones - 1) {
      const auto face = std::uint32_t(first) + std::uint32_t(std::countr_zero(near_ones));
      const double distance = faces_[face].distance(point, best.distance);
      if (distance < best.distance) best = {face, distance};
    }
  }
  return best;
}

/// The square distance of a point that does not lie above the face, or of any point from a sliver.
double SurfaceDeviation::Face::square_distance_beside(const dvec3& point) const {
  const double square = square_of(point - nearest_point(point, corners[0], corners[1], corners[2]));
  return square >= 0.0 ? square : square_of(point - corners[0]);  // a degenerate triangle may give no number
}

/// The largest distance of the polygon's points, with the errors of both triangles, where it is at most so much; else
/// anything that is more.
double SurfaceDeviation::farthest(const Polygon& polygon, std::uint32_t face, double most) const {
  const double errors = faces_[face].error + error_, left = most - errors;
  if (!(left >= 0.0)) return std::numeric_limits<double>::infinity();
  const double most_square = left * left;
  double square = 0.0;
  for (int i = 0; i < polygon.count; ++i) {
    square = std::max(square, faces_[face].square_distance(polygon.corners[i], most_square));
    if (!(square <= most_square)) return std::numeric_limits<double>::infinity();
  }
  return std::sqrt(square) + errors;
}

/// Gives the polygon to the face if it lies near enough.
bool SurfaceDeviation::accept(const Polygon& polygon, std::uint32_t face, double most) {
  const double distance = farthest(polygon, face, most);
  if (!(distance <= most)) return false;
  of_from_[triangle_] = std::max(of_from_[triangle_], distance);
  of_to_[face] = std::max(of_to_[face], distance);
  if (const double rounding = normal_rounding_ + faces_[face].normal_rounding; rounding < 1.0)
    cosine_ = std::min(cosine_, glm::dot(normal_, faces_[face].normal) - rounding);
  return true;
}

/// A face that is not would hand the piece on in a circle.
bool SurfaceDeviation::is_nearer(std::uint32_t face, const Piece& piece) const {
  const dvec3 centre = centre_of(piece.polygon);
  return faces_[face].distance(centre) < faces_[piece.face].distance(centre);
}

/// Divides the piece among the face that it lies near and the faces around, which get what lies beyond the planes.
void SurfaceDeviation::cover(Piece piece) {
  if (accept(piece.polygon, piece.face, kOutside * bound_)) return;
  for (int k = 0; k < 3;) {
    const Face& face = faces_[piece.face];
    const std::uint32_t neighbour = face.neighbours[k];
    Polygon inside, outside;
    const Side side =
        neighbour == kNone || neighbour == piece.from || piece.polygon.count == kMostCorners || steps_ >= most_steps_
            ? Side::kInside
            : split(piece.polygon, face.cuts[k], face.corners[k], inside, outside);
    if (side == Side::kInside || (side == Side::kOutside && !is_nearer(neighbour, piece))) {
      ++k;
      continue;
    }
    ++steps_;
    if (side == Side::kOutside) {
      piece.from = std::exchange(piece.face, neighbour);
      k = 0;
    } else {
      pieces_.push_back({outside, neighbour, piece.face});
      piece.polygon = inside;
      ++k;
    }
  }
  if (!accept(piece.polygon, piece.face, bound_)) refine(piece);
}

/// Where the polygon lies by a plane, and its parts where that is on both sides. Corners at the plane are in both. Says
/// inside, too, where rounding has made a polygon that a plane would cut more than twice.
SurfaceDeviation::Side SurfaceDeviation::split(const Polygon& polygon, const dvec3& normal, const dvec3& point,
                                               Polygon& inside, Polygon& outside) const {
  double side[kMostCorners];
  bool any_inside = false, any_outside = false;
  for (int i = 0; i < polygon.count; ++i) {
    side[i] = glm::dot(normal, polygon.corners[i] - point);
    if (std::abs(side[i]) <= rounding_) side[i] = 0.0;
    any_outside |= side[i] > 0.0;
    any_inside |= side[i] < 0.0;
  }
  if (!any_outside) return Side::kInside;
  if (!any_inside) return Side::kOutside;
  int cuts = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const int next = i + 1 < polygon.count ? i + 1 : 0;
    const dvec3 &a = polygon.corners[i], &b = polygon.corners[next];
    if (side[i] <= 0.0) inside.corners[inside.count++] = a;
    if (side[i] >= 0.0) outside.corners[outside.count++] = a;
    if ((side[i] < 0.0 && side[next] > 0.0) || (side[i] > 0.0 && side[next] < 0.0)) {
      if (++cuts > 2) return Side::kInside;
      const dvec3 between = a + side[i] / (side[i] - side[next]) * (b - a);
      inside.corners[inside.count++] = between;
      outside.corners[outside.count++] = between;
    }
  }
  return Side::kBoth;
}

dvec3 SurfaceDeviation::centre_of(const Polygon& polygon) {
  dvec3 sum(0.0);
  for (int i = 0; i < polygon.count; ++i) sum += polygon.corners[i];
  return sum / double(polygon.count);
}

/// Looks for a better face among those nearest to the corners and the centre. Where there is none, raises the bound if
/// some point is known to be about that far from the surface, and bisects the polygon otherwise.
void SurfaceDeviation::refine(const Piece& piece) {
  const Polygon& polygon = piece.polygon;
  const std::uint32_t face = piece.face;
  double best = farthest(polygon, face, kAny);
  std::uint32_t best_face = face;
  const auto consider = [&](std::uint32_t other) {
    const double distance = farthest(polygon, other, best);
    if (distance < best) best = distance, best_face = other;
  };
  for (int i = 0; i < polygon.count && best > bound_; ++i) {
    const dvec3& corner = polygon.corners[i];
    consider(nearest_from(near(face, corner), corner).face);
  }
  const dvec3 centre = centre_of(polygon);
  if (best > bound_) consider(nearest_from(near(face, centre), centre).face);
  if (best > std::max(bound_, kTight * least_)) {
    const dvec3& corner = *std::max_element(polygon.corners, polygon.corners + polygon.count, [&](auto& a, auto& b) {
      return faces_[best_face].square_distance(a) < faces_[best_face].square_distance(b);
    });
    const Near found = nearest(near(best_face, corner), corner);
    consider(found.face);
    least_ = std::max(least_, found.distance + error_);
  }
  if (best > bound_) {
    if (best > kTight * least_ && steps_ < most_steps_ && bisect(polygon, best_face)) return;
    bound_ = kRaise * best;
  }
  accept(polygon, best_face, kAny);
}

/// Cuts the polygon into two pieces that are yet to be covered: across its longest edge, or along a diagonal if it has
/// many corners. False if it is too small.
bool SurfaceDeviation::bisect(const Polygon& polygon, std::uint32_t face) {
  Polygon halves[2];
  if (polygon.count >= kManyCorners) {
    const int middle = polygon.count / 2;
    halves[0].corners[halves[0].count++] = polygon.corners[0];
    for (int i = 0; i < polygon.count; ++i) {
      if (i <= middle && i > 0) halves[0].corners[halves[0].count++] = polygon.corners[i];
      if (i >= middle || i == 0) halves[1].corners[halves[1].count++] = polygon.corners[i];
    }
  } else {
    int longest = 0;
    const auto edge = [&](int i) { return polygon.corners[(i + 1) % polygon.count] - polygon.corners[i]; };
    for (int i = 1; i < polygon.count; ++i)
      if (square_of(edge(i)) > square_of(edge(longest))) longest = i;
    const dvec3 along = edge(longest);
    const double length = glm::length(along);
    if (length <= 0.1 * least_ || length <= 4.0 * rounding_ ||
        split(polygon, along / length, polygon.corners[longest] + 0.5 * along, halves[0], halves[1]) != Side::kBoth)
      return false;
  }
  ++steps_;
  for (const Polygon& half : halves) {
    const dvec3 centre = centre_of(half);
    pieces_.push_back({half, nearest_from(near(face, centre), centre).face, kNone});
  }
  return true;
}

}  // namespace sightline::lod
