#include "sightline/importers/internal/triangulate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sightline::importers {
namespace {

using core::dvec2;
using core::dvec3;
using core::vec3;

constexpr std::uint32_t kNoNode = 0xffffffffu;

double cross(const dvec2& a, const dvec2& b, const dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Projects along the normal's largest axis and keeps counter-clockwise polygons so.
class Projection {
 public:
  explicit Projection(const dvec3& normal) {
    const dvec3 size = glm::abs(normal);
    const int drop = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    u_ = (drop + 1) % 3, v_ = (drop + 2) % 3;
    if (normal[drop] < 0) std::swap(u_, v_);
  }
  dvec2 operator()(const vec3& p) const { return {double(p[u_]), double(p[v_])}; }

 private:
  int u_, v_;
};

/// Joins the outline and its holes to one ring of vertices, and clips it ear by ear.
class EarClipper {
 public:
  EarClipper(std::span<const vec3> vertices, const Projection& project, std::uint32_t base, std::int64_t& steps_left,
             std::vector<std::uint32_t>& indices)
      : vertices_(vertices), project_(project), base_(base), steps_left_(steps_left), indices_(indices) {}

  void set_outline(std::uint32_t first, std::uint32_t count) {
    outline_ = add_ring(first, count, signed_area(first, count) < 0);
  }

  /// Remembers the contour as a hole if it starts inside the outline.
  bool take_hole(std::uint32_t first, std::uint32_t count) {
    if (!inside_outline(project_(vertices_[first]))) return false;
    const std::uint32_t ring = add_ring(first, count, signed_area(first, count) > 0);
    std::uint32_t leftmost = ring;
    for (std::uint32_t n = nodes_[ring].next; n != ring; n = nodes_[n].next)
      if (nodes_[n].p.x < nodes_[leftmost].p.x) leftmost = n;
    holes_.push_back(leftmost);
    return true;
  }

  void run() {
    std::sort(holes_.begin(), holes_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return nodes_[a].p.x != nodes_[b].p.x ? nodes_[a].p.x < nodes_[b].p.x : a < b;
    });
    for (const std::uint32_t hole : holes_) {
      const std::uint32_t bridge = find_bridge(hole);
      if (bridge != kNoNode) join(bridge, hole);
    }
    clip();
  }

 private:
  struct Node {
    dvec2 p;
    std::uint32_t vertex, previous, next;
    std::uint32_t blocker_place = kNoNode;  // in blockers_
  };

  double signed_area(std::uint32_t first, std::uint32_t count) const {
    const dvec2 origin = project_(vertices_[first]);
    double sum = 0.0;
    for (std::uint32_t i = 1; i + 1 < count; ++i)
      sum += cross(origin, project_(vertices_[first + i]), project_(vertices_[first + i + 1]));
    return sum;
  }

  std::uint32_t add_ring(std::uint32_t first, std::uint32_t count, bool reverse) {
    const auto begin = std::uint32_t(nodes_.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t vertex = reverse ? first + count - 1 - i : first + i;
      nodes_.push_back({project_(vertices_[vertex]), vertex, begin + (i + count - 1) % count, begin + (i + 1) % count});
    }
    return begin;
  }

  bool inside_outline(const dvec2& q) {
    bool inside = false;
    std::uint32_t n = outline_;
    do {
      const dvec2 &a = nodes_[n].p, &b = nodes_[nodes_[n].next].p;
      if ((a.y > q.y) != (b.y > q.y) && q.x < a.x + (q.y - a.y) * (b.x - a.x) / (b.y - a.y)) inside = !inside;
      n = nodes_[n].next;
      --steps_left_;
    } while (n != outline_ && steps_left_ > 0);
    return inside;
  }

  const dvec2& point(std::uint32_t n) const { return nodes_[n].p; }
  const dvec2& before(std::uint32_t n) const { return nodes_[nodes_[n].previous].p; }
  const dvec2& after(std::uint32_t n) const { return nodes_[nodes_[n].next].p; }

  /// Whether the segment from ring vertex n to q starts into the interior.
  bool opens_towards(std::uint32_t n, const dvec2& q) const {
    const bool left_of_next = cross(point(n), after(n), q) >= 0, left_of_previous = cross(before(n), point(n), q) >= 0;
    return cross(before(n), point(n), after(n)) > 0 ? left_of_next && left_of_previous
                                                    : left_of_next || left_of_previous;
  }

  static bool in_triangle(const dvec2& a, const dvec2& b, const dvec2& c, const dvec2& q) {
    const double ab = cross(a, b, q), bc = cross(b, c, q), ca = cross(c, a, q);
    return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
  }

  /// A ring vertex that is visible from the hole's leftmost vertex: an end of the nearest edge to its left, or a vertex
  /// that stands in the way.
  std::uint32_t find_bridge(std::uint32_t hole) {
    const dvec2 h = point(hole);
    double hit_x = -std::numeric_limits<double>::infinity();
    std::uint32_t best = kNoNode, n = outline_;
    do {
      const dvec2 &a = point(n), &b = after(n);
      if (h.y <= a.y && h.y >= b.y && a.y != b.y) {
        const double x = a.x + (h.y - a.y) * (b.x - a.x) / (b.y - a.y);
        if (x <= h.x && x > hit_x) {
          hit_x = x;
          best = a.x < b.x ? n : nodes_[n].next;
          if (x == h.x && (h.y == a.y || h.y == b.y)) return h.y == a.y ? n : nodes_[n].next;
        }
      }
      n = nodes_[n].next;
      if (--steps_left_ <= 0) return kNoNode;
    } while (n != outline_);
    return best == kNoNode ? best : nearest_in_the_way(best, h, {hit_x, h.y});
  }

  std::uint32_t nearest_in_the_way(std::uint32_t best, const dvec2& h, const dvec2& hit) {
    const dvec2 corner = point(best);
    double best_slope = std::numeric_limits<double>::infinity();
    if (opens_towards(best, h) && corner.x < h.x) best_slope = std::abs(h.y - corner.y) / (h.x - corner.x);
    for (std::uint32_t n = nodes_[best].next, stop = best; n != stop; n = nodes_[n].next) {
      if (--steps_left_ <= 0) break;
      const dvec2& q = point(n);
      if (q.x >= h.x || !in_triangle(h, hit, corner, q) || !opens_towards(n, h)) continue;
      const double slope = std::abs(h.y - q.y) / (h.x - q.x);
      if (slope < best_slope || (slope == best_slope && q.x > point(best).x)) best = n, best_slope = slope;
    }
    return best;
  }

  /// Cuts the ring open from `outer` to `hole` and back.
  void join(std::uint32_t outer, std::uint32_t hole) {
    const auto hole_copy = std::uint32_t(nodes_.size()), outer_copy = hole_copy + 1;
    nodes_.push_back(nodes_[hole]);
    nodes_.push_back(nodes_[outer]);
    const std::uint32_t hole_end = nodes_[hole].previous, outer_next = nodes_[outer].next;
    link(outer, hole), link(hole_end, hole_copy), link(hole_copy, outer_copy), link(outer_copy, outer_next);
  }
  void link(std::uint32_t a, std::uint32_t b) { nodes_[a].next = b, nodes_[b].previous = a; }

  // Only a vertex that is not strictly convex can lie in another vertex's ear. These are the blockers.
  void update_blocker(std::uint32_t n) {
    const bool blocks = cross(before(n), point(n), after(n)) <= 0;
    Node& node = nodes_[n];
    if (blocks == (node.blocker_place != kNoNode)) return;
    if (blocks) {
      node.blocker_place = std::uint32_t(blockers_.size());
      blockers_.push_back(n);
    } else {
      remove_blocker(n);
    }
  }
  void remove_blocker(std::uint32_t n) {
    const std::uint32_t place = nodes_[n].blocker_place;
    if (place == kNoNode) return;
    blockers_[place] = blockers_.back();
    nodes_[blockers_[place]].blocker_place = place;
    blockers_.pop_back();
    nodes_[n].blocker_place = kNoNode;
  }

  bool is_ear(std::uint32_t n) {
    const dvec2 &a = before(n), &b = point(n), &c = after(n);
    if (cross(a, b, c) <= 0) return false;
    const dvec2 low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
    steps_left_ -= 1 + std::int64_t(blockers_.size());
    for (const std::uint32_t other : blockers_) {
      const dvec2& q = point(other);
      if (q.x < low.x || q.x > high.x || q.y < low.y || q.y > high.y || q == a || q == b || q == c) continue;
      if (cross(a, b, q) >= 0 && cross(b, c, q) >= 0 && cross(c, a, q) >= 0) return false;
    }
    return true;
  }

  void emit(std::uint32_t n) {
    for (const std::uint32_t corner : {nodes_[n].previous, n, nodes_[n].next})
      indices_.push_back(base_ + nodes_[corner].vertex);
  }

  void unlink(std::uint32_t n) {
    const std::uint32_t previous = nodes_[n].previous, next = nodes_[n].next;
    remove_blocker(n);
    link(previous, next);
    update_blocker(previous);
    update_blocker(next);
  }

  // What to do when a whole turn found no ear: first nothing, then drop flat vertices, then clip any convex one.
  enum class Effort { kEars, kFlat, kConvex };

  bool clip_vertex(std::uint32_t n, Effort effort) {
    const double turn = cross(before(n), point(n), after(n));
    if (effort == Effort::kFlat && turn == 0.0) return true;
    if (effort == Effort::kConvex ? turn <= 0.0 : !is_ear(n)) return false;
    emit(n);
    return true;
  }

  void clip() {
    std::uint32_t n = outline_, left = 0;
    do update_blocker(n), n = nodes_[n].next, ++left;
    while (n != outline_);
    Effort effort = Effort::kEars;
    for (std::uint32_t failures = 0; left > 3 && steps_left_ > 0;) {
      const std::uint32_t next = nodes_[n].next;
      if (clip_vertex(n, effort)) {
        unlink(n);
        --left, failures = 0, effort = Effort::kEars;
        n = nodes_[next].next;  // skipping one gives rounder triangles than a fan
        continue;
      }
      n = next;
      if (++failures < left) continue;
      if (effort == Effort::kConvex) break;
      effort = effort == Effort::kEars ? Effort::kFlat : Effort::kConvex;
      failures = 0;
    }
    fan(n, left);
  }

  void fan(std::uint32_t apex, std::uint32_t left) {
    for (std::uint32_t n = nodes_[apex].next; left > 2; --left, n = nodes_[n].next) {
      if (left == 3 && cross(point(apex), point(n), after(n)) == 0.0) continue;
      for (const std::uint32_t corner : {apex, n, nodes_[n].next}) indices_.push_back(base_ + nodes_[corner].vertex);
    }
  }

  std::span<const vec3> vertices_;
  Projection project_;
  std::uint32_t base_;
  std::int64_t& steps_left_;
  std::vector<std::uint32_t>& indices_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> holes_, blockers_;
  std::uint32_t outline_ = kNoNode;
};

/// Handles triangles and convex quads, which are nearly all polygons of real facet groups. False for any other polygon.
bool quick(std::span<const vec3> p, const Projection& project, std::uint32_t base,
           std::vector<std::uint32_t>& indices) {
  if (p.size() == 3) {
    indices.insert(indices.end(), {base, base + 1, base + 2});
    return true;
  }
  if (p.size() != 4) return false;
  for (std::size_t i = 0; i < 4; ++i)
    if (!(cross(project(p[i]), project(p[(i + 1) % 4]), project(p[(i + 2) % 4])) > 0)) return false;
  indices.insert(indices.end(), {base, base + 1, base + 2, base, base + 2, base + 3});
  return true;
}

/// The largest area vector of a triangle of the outline's first vertex and an edge: the plane of an outline whose parts
/// on either side cancel each other out.
dvec3 largest_fan_normal(std::span<const vec3> outline) {
  dvec3 largest(0.0);
  for (std::size_t i = 1; i + 1 < outline.size(); ++i) {
    const dvec3 normal = newell_normal(std::array{outline[0], outline[i], outline[i + 1]});
    if (glm::dot(normal, normal) > glm::dot(largest, largest)) largest = normal;
  }
  return largest;
}

/// Whether two edges without a common end cross. An outline that goes there and back on the same way has no such edges.
bool crosses_itself(std::span<const vec3> outline, const Projection& project, std::int64_t& steps_left) {
  const std::size_t count = outline.size();
  const auto point = [&](std::size_t i) { return project(outline[i % count]); };
  const auto parts = [&](std::size_t edge, std::size_t other) {
    const dvec2 a = point(edge), b = point(edge + 1);
    return (cross(a, b, point(other)) < 0.0) != (cross(a, b, point(other + 1)) < 0.0);
  };
  const auto meet = [&](std::size_t i, std::size_t j) {
    return point(i) == point(j) || point(i) == point(j + 1) || point(i + 1) == point(j) || point(i + 1) == point(j + 1);
  };
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 2; j < count && --steps_left > 0; ++j)
      if (parts(i, j) && parts(j, i) && !meet(i, j)) return true;
  return false;
}

/// Whether the outline crosses itself so that its halves cancel each other out in its Newell normal, but for rounding.
bool cancels_out(std::span<const vec3> outline, const dvec3& newell, std::int64_t& steps_left) {
  constexpr double kRounding = 1e-6;
  const dvec3 largest = largest_fan_normal(outline);
  return outline.size() > 3 && glm::dot(newell, newell) <= kRounding * kRounding * glm::dot(largest, largest) &&
         crosses_itself(outline, Projection(largest), steps_left);
}

void fan(std::span<const vec3> outline, std::uint32_t base, std::vector<std::uint32_t>& indices) {
  for (std::uint32_t i = 1; i + 1 < outline.size(); ++i)
    if (newell_normal(std::array{outline[0], outline[i], outline[i + 1]}) != dvec3(0.0))
      indices.insert(indices.end(), {base, base + i, base + i + 1});
}

}  // namespace

dvec3 newell_normal(std::span<const vec3> polygon) {
  dvec3 sum(0.0);
  if (polygon.size() < 3) return sum;
  const dvec3 origin(polygon[0]);  // relative coordinates: far polygons keep their digits
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    sum += glm::cross(dvec3(polygon[i]) - origin, dvec3(polygon[i + 1]) - origin);
  return sum;
}

void triangulate_polygon(std::span<const vec3> vertices, std::span<const std::uint32_t> contour_sizes,
                         std::uint32_t base, std::vector<std::uint32_t>& indices) {
  std::vector<std::uint32_t> firsts;
  std::uint32_t first = 0;
  for (const std::uint32_t size : contour_sizes) firsts.push_back(first), first += size;
  std::vector<bool> done(contour_sizes.size(), false);
  std::int64_t steps_left = 1'000'000 + 2000 * std::int64_t(vertices.size());  // for all outlines together
  for (std::size_t k = 0; k < contour_sizes.size(); ++k) {
    if (done[k] || contour_sizes[k] < 3) continue;
    const auto outline = vertices.subspan(firsts[k], contour_sizes[k]);
    const dvec3 normal = newell_normal(outline);
    const bool flat = !(glm::dot(normal, normal) > 0.0), alone = k + 1 == contour_sizes.size();
    const Projection project(normal);
    if (!flat && alone && quick(outline, project, base + firsts[k], indices)) continue;
    if (cancels_out(outline, normal, steps_left)) {
      fan(outline, base + firsts[k], indices);
      continue;
    }
    if (flat) continue;
    EarClipper clipper(vertices, project, base, steps_left, indices);
    clipper.set_outline(firsts[k], contour_sizes[k]);
    for (std::size_t h = k + 1; h < contour_sizes.size() && --steps_left > 0; ++h)
      if (!done[h] && contour_sizes[h] >= 3) done[h] = clipper.take_hole(firsts[h], contour_sizes[h]);
    clipper.run();
  }
}

}  // namespace sightline::importers
