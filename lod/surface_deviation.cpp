#include "sightline/lod/internal/surface_deviation.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/core/aabb.h"

namespace sightline::lod {
namespace {

using core::dvec3;

// How often polygons of a surface may be cut or handed on to the next face: enough for fans of slivers across each
// other, and a bound for the time that hostile surfaces take.
constexpr std::int64_t kFewestSteps = 4000, kStepsPerCorner = 30;
constexpr std::int64_t kFacesPerStep = 16;  // a search among so many takes as long as a step
constexpr double kTight = 1.1;              // a bound that exceeds a true distance by this factor is not refined
constexpr double kRaise = 1.02;             // the bound rises by a little more than it must, so it rises seldom
constexpr double kOutside = 0.5;            // of the bound: nearer polygons are not divided
constexpr double kSliver = 0.05;            // sine of the angle below which a triangle's normal is rounded too much
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

dvec3 centre_of(const Triangles& triangles, const std::uint32_t* corners) {
  return (triangles.points[corners[0]] + triangles.points[corners[1]] + triangles.points[corners[2]]) / 3.0;
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

Deviation SurfaceDeviation::bound(const Triangles& from, const Triangles& to, const Known& known) {
  if (from.corners.empty()) return {};
  assert(!to.corners.empty());
  make_faces(to);
  dvec3 size(0.0);
  for (const dvec3& point : from.points) size = glm::max(size, glm::abs(point));
  const double largest = std::max({size.x, size.y, size.z});
  rounding_ = 0.1 * kRounding * largest;
  of_from_.assign(from.corners.size() / 3, 0.0);
  of_to_.assign(faces_.size(), 0.0);
  seed(from, to);
  if (known.starts.empty())
    least_ = probe(from);
  else
    start_from(from, known.starts);
  bound_ = std::max({rounding_, kTight * least_, known.enough});
  cosine_ = 1.0;
  steps_ = 0;
  most_steps_ = kFewestSteps + kStepsPerCorner * std::int64_t(from.corners.size() + to.corners.size());
  for (triangle_ = 0; triangle_ < starts_.size(); ++triangle_) {
    Piece piece{{}, starts_[triangle_], kNone};
    for (std::size_t k = 0; k < 3; ++k) piece.polygon.add(from.points[from.corners[3 * triangle_ + k]]);
    piece.polygon.fill_up();
    normal_ = unit_normal(piece.polygon.corner(0), piece.polygon.corner(1), piece.polygon.corner(2), normal_rounding_);
    error_ = from.errors.empty() ? 0.0 : double(from.errors[triangle_]);
    for (cover(piece); !pieces_.empty(); cover(piece)) {
      piece = pieces_.back();
      pieces_.pop_back();
    }
  }
  const auto outwards = [&](double distance) { return distance * (1.0 + kRounding) + kRounding * largest; };
  for (std::vector<double>* distances : {&of_from_, &of_to_})
    std::ranges::transform(*distances, distances->begin(), outwards);
  return {*std::ranges::max_element(of_from_), std::acos(std::clamp(cosine_, -1.0, 1.0))};
}

void SurfaceDeviation::seed(const Triangles& from, const Triangles& to) {
  seeds_.assign(from.points.size(), kNone);
  for (std::uint32_t i = 0; i < to.corners.size(); ++i) seeds_[to.corners[i]] = i / 3;
}

void SurfaceDeviation::start_from(const Triangles& from, std::span<const std::uint32_t> starts) {
  least_ = 0.0;
  starts_.assign(starts.begin(), starts.end());
  for (std::uint32_t i = 0; i < starts_.size(); ++i) {
    if (starts_[i] != kNone) continue;
    const std::uint32_t* const corners = &from.corners[3 * i];
    starts_[i] = start(corners, centre_of(from, corners)).face;
  }
}

/// Finds a face near each triangle, and returns the distance of some point that lies far from all faces: the bound
/// cannot be less, and most polygons need not be divided to prove that they lie within it.
double SurfaceDeviation::probe(const Triangles& from) {
  starts_.clear();
  near_to_.assign(faces_.size(), kNone);
  near_squares_.assign(faces_.size(), kAny);
  FarthestProbes probes;
  for (std::uint32_t i = 0; i < from.corners.size(); i += 3) {
    const std::uint32_t* corners = &from.corners[i];
    const double error = from.errors.empty() ? 0.0 : double(from.errors[i / 3]);
    const dvec3 centre = centre_of(from, corners);
    const Near at = start(corners, centre);
    starts_.push_back(at.face);
    const auto& [a, b, c] = faces_[at.face].corners;
    const double square = square_of((a + b + c) / 3.0 - centre);
    if (square < near_squares_[at.face]) near_squares_[at.face] = square, near_to_[at.face] = i / 3;
    probes.offer({at, error, at.distance + error, centre});
    for (int k = 0; k < 3; ++k) {
      std::uint32_t& seed = seeds_[corners[k]];
      if (seed != kNone) continue;
      const dvec3& point = from.points[corners[k]];
      const Near there = nearest_from(near(at.face, point), point);
      seed = there.face;
      probes.offer({there, error, there.distance + error, point});
    }
  }
  double farthest = 0.0;
  for (const Probe& probe : probes.farthest_first()) {
    if (probe.distance <= farthest) break;
    farthest = std::max(farthest, nearest(probe.near, probe.point).distance + probe.error);
  }
  return farthest;
}

/// A face near the centre of a triangle, from those at its corners on.
SurfaceDeviation::Near SurfaceDeviation::start(const std::uint32_t* corners, const dvec3& centre) {
  Near best{kNone, kAny, 0};
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t seed = seeds_[corners[k]];
    if (seed == kNone || seed == best.face) continue;
    const Near at = near(seed, centre);
    if (at.distance < best.distance) best = at;
  }
  if (best.face == kNone) return nearest(near(0, centre), centre);
  return nearest_from(best, centre);
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
    const double scale =
        !(face.normal_rounding < kNormalRounding / kSliver) ? std::numeric_limits<double>::quiet_NaN() : 1.0 / area;
    face.gradients[0] = scale * glm::cross(ac, face.normal);
    face.gradients[1] = scale * glm::cross(face.normal, ab);
    const double area_square = area * area;
    face.heights[0] = area_square / square_of(ac), face.heights[1] = area_square / square_of(ab);
    face.heights[2] = area_square / square_of(ac - ab);
    for (std::size_t k = 0; k < 3; ++k) {
      const double square = square_of(face.corners[(k + 1) % 3] - face.corners[k]);
      face.per_square[k] = square > 0.0 ? 1.0 / square : 0.0;
    }
  }
  join_faces(to);
  make_balls();
}

/// In float, relative to a point among the faces: they tell only where to look. Balls of no face are infinitely far;
/// radii are less by the face's error.
void SurfaceDeviation::make_balls() {
  origin_ = faces_[0].corners[0];
  const auto without = [](std::size_t count) {
    Balls none{};
    std::ranges::fill(none.x, std::numeric_limits<float>::infinity());
    return std::vector((count + kBalls - 1) / kBalls, none);
  };
  const auto put = [](std::vector<Balls>& balls, std::size_t i, const core::vec3& at, float radius) {
    Balls& ball = balls[i / kBalls];
    const std::size_t place = i % kBalls;
    ball.x[place] = at.x, ball.y[place] = at.y, ball.z[place] = at.z, ball.radius[place] = radius;
  };
  balls_ = without(faces_.size());
  around_ = without(balls_.size());
  for (std::size_t first = 0; first < faces_.size(); first += kBalls) {
    const std::size_t end = std::min(first + kBalls, faces_.size());
    core::AabbD box;
    for (std::size_t i = first; i < end; ++i) {
      const auto& [a, b, c] = faces_[i].corners;
      const dvec3 centre = (a + b + c) / 3.0;
      const double square = std::max({square_of(a - centre), square_of(b - centre), square_of(c - centre)});
      put(balls_, i, core::vec3(centre - origin_), float(std::sqrt(square) - faces_[i].error));
      box.grow(centre);
    }
    const dvec3 middle = 0.5 * (box.min + box.max);
    float radius = -std::numeric_limits<float>::infinity();
    for (std::size_t i = first; i < end; ++i) {
      const auto& [a, b, c] = faces_[i].corners;
      radius = std::max(radius, balls_[i / kBalls].radius[i % kBalls] + float(glm::length((a + b + c) / 3.0 - middle)));
    }
    put(around_, first / kBalls, core::vec3(middle - origin_), radius);
  }
}

/// Where more than two triangles meet at an edge, each becomes the neighbour of one before that is left: any choice is
/// right.
void SurfaceDeviation::join_faces(const Triangles& to) {
  const std::span<const std::uint32_t> corners = to.corners;
  first_edge_.assign(to.points.size(), kNone);
  edges_.resize(corners.size());
  for (std::uint32_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t start = corners[i], end = corners[i % 3 == 2 ? i - 2 : i + 1];
    if (start == end) continue;
    const std::uint32_t higher = std::max(start, end);
    std::uint32_t* at = &first_edge_[std::min(start, end)];
    while (*at != kNone && (edges_[*at].to != higher || *at / 3 == i / 3)) at = &edges_[*at].next;
    if (*at == kNone) {
      *at = i;
      edges_[i] = {higher, kNone};
    } else {
      join(corners, *at, i);
      *at = edges_[*at].next;
    }
  }
}

/// Makes the faces neighbours whose edges start at the corners `a` and `b`.
void SurfaceDeviation::join(std::span<const std::uint32_t> corners, std::uint32_t a, std::uint32_t b) {
  Face &first = faces_[a / 3], &second = faces_[b / 3];
  const double sign = corners[a] == corners[b] ? -1.0 : 1.0;  // neighbours of opposite orientation
  const dvec3 between = first.normal + sign * second.normal;
  const dvec3 along = first.corners[(a % 3 + 1) % 3] - first.corners[a % 3];
  const bool folded = !(square_of(between) > 1e-12);  // then both lie on the same side
  const dvec3 cut = glm::cross(along, folded ? first.normal : between);
  const double length = glm::length(cut);
  first.neighbours[a % 3] = b / 3;
  second.neighbours[b % 3] = a / 3;
  first.cuts[a % 3] = length > 0.0 ? cut / length : dvec3(0.0);
  second.cuts[b % 3] = folded ? first.cuts[a % 3] : -first.cuts[a % 3];
}

/// Walks across edges that the point lies beyond, to nearer neighbours, until there is none.
SurfaceDeviation::Near SurfaceDeviation::nearest_from(Near start, const dvec3& point) const {
  for (unsigned beyond = start.beyond; beyond != 0;) {
    const std::uint32_t neighbour = faces_[start.face].neighbours[std::countr_zero(beyond)];
    beyond &= beyond - 1;
    if (neighbour == kNone) continue;
    const Near at = near(neighbour, point);
    if (at.distance < start.distance) start = at, beyond = at.beyond;
  }
  return start;
}

/// Among all faces, but those whose balls are too far off. `start`: one that may be near.
SurfaceDeviation::Near SurfaceDeviation::nearest(Near start, const dvec3& point) {
  Near best = nearest_from(start, point);
  best.distance = faces_[best.face].distance(point);
  const core::vec3 p(point - origin_);
  std::int64_t faces = 0;
  for (std::uint32_t outer = 0; outer < around_.size(); ++outer) {
    std::uint32_t around = kernels_.near_ones(around_[outer], &p.x, float(best.distance));
    for (; around != 0; around &= around - 1) {
      const std::uint32_t inner = kBalls * outer + std::uint32_t(std::countr_zero(around));
      std::uint32_t near_ones = kernels_.near_ones(balls_[inner], &p.x, float(best.distance));
      for (; near_ones != 0; near_ones &= near_ones - 1, ++faces) {
        Near at = near(kBalls * inner + std::uint32_t(std::countr_zero(near_ones)), point);
        if (at.distance >= best.distance) continue;
        at.distance = faces_[at.face].distance(point);
        if (at.distance < best.distance) best = at;
      }
    }
  }
  steps_ += faces / kFacesPerStep;
  return best;
}

double SurfaceDeviation::Face::square_distance(const dvec3& point) const {
  const double square = square_of(point - nearest_point(point, corners[0], corners[1], corners[2]));
  return square >= 0.0 ? square : square_of(point - corners[0]);  // a degenerate triangle may give no number
}

/// The largest distance of the polygon's points, with the errors of both triangles, where it is at most so much; else
/// anything that is more.
SurfaceDeviation::Distant SurfaceDeviation::farthest(const Polygon& polygon, std::uint32_t face, double most) const {
  const double errors = faces_[face].error + error_, left = most - errors;
  if (!(left >= 0.0)) return {kAny, kAnyEdge};
  Farthest found{0.0, kAnyEdge};
  if (!faces_[face].is_sliver())
    found = kernels_.farthest(faces_[face], polygon, left * left);
  else
    for (int i = 0; i < polygon.count; ++i)
      found.square = std::max(found.square, faces_[face].square_distance(polygon.corner(i)));
  return {std::sqrt(found.square) + errors, found.beyond};
}

/// Gives a polygon at that distance to the face.
void SurfaceDeviation::accept(std::uint32_t face, double distance) {
  of_from_[triangle_] = std::max(of_from_[triangle_], distance);
  of_to_[face] = std::max(of_to_[face], distance);
  if (const double rounding = normal_rounding_ + faces_[face].normal_rounding; rounding < 1.0)
    cosine_ = std::min(cosine_, glm::dot(normal_, faces_[face].normal) - rounding);
}

/// A face that is not would hand the piece on in a circle.
bool SurfaceDeviation::is_nearer(std::uint32_t face, const Piece& piece) const {
  const dvec3 centre = middle_of(piece.polygon);
  return near(face, centre).distance < near(piece.face, centre).distance;
}

/// Divides the piece among the face that it lies near and the faces around, which get what lies beyond the planes.
void SurfaceDeviation::cover(Piece& piece) {
  Distant at = farthest(piece.polygon, piece.face, bound_);
  if (at.distance <= kOutside * bound_) return accept(piece.face, at.distance);
  bool changed = false;
  for (unsigned k = 0; k < 3;) {
    const Face& face = faces_[piece.face];
    const std::uint32_t neighbour = face.neighbours[k];
    const bool may_cut = (at.beyond >> k & 1) != 0 && neighbour != kNone && neighbour != piece.from &&
                         piece.polygon.count < Polygon::kMostCorners && steps_ < most_steps_;
    Side side = Side::kInside;
    Polygon inside;
    if (may_cut) {
      Piece& outside = pieces_.emplace_back();
      side = kernels_.split(piece.polygon, face.cuts[k], face.corners[k], rounding_, inside, outside.polygon);
      outside.face = neighbour, outside.from = piece.face;
      if (side != Side::kBoth) pieces_.pop_back();
    }
    if (side == Side::kInside || (side == Side::kOutside && !is_nearer(neighbour, piece))) {
      ++k;
      continue;
    }
    ++steps_;
    changed = true;
    if (side == Side::kOutside) {
      piece.from = std::exchange(piece.face, neighbour);
      at.beyond = kAnyEdge;
      k = 0;
    } else {
      piece.polygon = inside;
      ++k;
    }
  }
  if (changed) at = farthest(piece.polygon, piece.face, bound_);
  if (at.distance <= bound_) return accept(piece.face, at.distance);
  refine(piece);
}

dvec3 SurfaceDeviation::middle_of(const Polygon& polygon) {
  dvec3 sum(0.0);
  for (int i = 0; i < polygon.count; ++i) sum += polygon.corner(i);
  return sum / double(polygon.count);
}

/// Looks for a better face among those nearest to the corners and the centre. Where there is none, raises the bound if
/// some point is known to be about that far from the surface, and bisects the polygon otherwise.
void SurfaceDeviation::refine(const Piece& piece) {
  const Polygon& polygon = piece.polygon;
  const std::uint32_t face = piece.face;
  double best = farthest(polygon, face, kAny).distance;
  std::uint32_t best_face = face;
  const auto consider = [&](std::uint32_t other) {
    const double distance = farthest(polygon, other, best).distance;
    if (distance < best) best = distance, best_face = other;
  };
  for (int i = 0; i < polygon.count && best > bound_; ++i) {
    const dvec3 corner = polygon.corner(i);
    consider(nearest_from(near(face, corner), corner).face);
  }
  const dvec3 centre = middle_of(polygon);
  if (best > bound_) consider(nearest_from(near(face, centre), centre).face);
  if (best > std::max(bound_, kTight * least_)) {
    dvec3 corner = polygon.corner(0);
    for (int i = 1; i < polygon.count; ++i)
      if (faces_[best_face].square_distance(corner) < faces_[best_face].square_distance(polygon.corner(i)))
        corner = polygon.corner(i);
    // Where a corner lies near a face, smaller pieces will, too.
    const Near walked = nearest_from(near(best_face, corner), corner);
    if (faces_[walked.face].distance(corner) + error_ > bound_) {
      const Near found = nearest(walked, corner);
      consider(found.face);
      least_ = std::max(least_, found.distance + error_);
    }
  }
  if (best > bound_) {
    if (best > kTight * least_ && steps_ < most_steps_ && bisect(polygon, best_face)) return;
    bound_ = kRaise * best;
  }
  accept(best_face, best);
}

/// Cuts the polygon into two pieces that are yet to be covered: across its longest edge, or along a diagonal if it has
/// many corners. False if it is too small.
bool SurfaceDeviation::bisect(const Polygon& polygon, std::uint32_t face) {
  Polygon halves[2];
  if (polygon.count >= kManyCorners) {
    const int middle = polygon.count / 2;
    for (int i = 0; i < polygon.count; ++i) {
      if (i <= middle) halves[0].add(polygon.corner(i));
      if (i >= middle || i == 0) halves[1].add(polygon.corner(i));
    }
    for (Polygon& half : halves) half.fill_up();
  } else {
    int longest = 0;
    const auto edge = [&](int i) { return polygon.corner((i + 1) % polygon.count) - polygon.corner(i); };
    for (int i = 1; i < polygon.count; ++i)
      if (square_of(edge(i)) > square_of(edge(longest))) longest = i;
    const dvec3 along = edge(longest);
    const double length = glm::length(along);
    if (length <= 0.1 * least_ || length <= 4.0 * rounding_ ||
        kernels_.split(polygon, along / length, polygon.corner(longest) + 0.5 * along, rounding_, halves[0],
                       halves[1]) != Side::kBoth)
      return false;
  }
  ++steps_;
  for (const Polygon& half : halves) {
    const dvec3 centre = middle_of(half);
    pieces_.push_back({half, nearest_from(near(face, centre), centre).face, kNone});
  }
  return true;
}

}  // namespace sightline::lod
