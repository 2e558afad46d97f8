// Primitives along a chain of rings: cylinders, snouts, slices of tori, dishes.
#include <algorithm>
#include <cmath>

#include "sightline/importers/recognise/internal/shape_fit.h"

namespace sightline::importers::recognition {
namespace {

using core::dmat3;
using core::dvec2;

constexpr double kPi = std::numbers::pi;
/// Neighbours on a ring, or rings of a torus, may be this far apart as seen from the centre.
constexpr double kWidestGap = kPi / 3.0 + 1e-6;
/// Slope of a slanted end, as a share of that of the cone that it cuts.
constexpr double kMostAlongCone = 0.5;
constexpr int kMostDomeTrials = 64;  // per chain: keeps the time linear

/// What a ring looks like.
struct RingShape {
  dvec3 centre{0.0}, normal{0.0};
  double radius = 0.0;    ///< 0 for a pole
  double residual = 0.0;  ///< farthest vertex from the circle
  double sagitta = 0.0;   ///< of its widest gap
  bool round = false;     ///< once around, without wide gaps
  bool circle = false;    ///< round, and within its own allowance
};

dvec3 mean_of(const Solid& solid, const std::vector<std::uint32_t>& vertices) {
  dvec3 sum(0.0);
  for (const std::uint32_t v : vertices) sum += solid.points[v];
  return sum / double(vertices.size());
}

/// Newell's normal of a polygon, whose length is twice its area.
dvec3 newell(const Solid& solid, const std::vector<std::uint32_t>& vertices, const dvec3& middle) {
  dvec3 sum(0.0);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    sum += glm::cross(solid.points[vertices[i]] - middle, solid.points[vertices[(i + 1) % vertices.size()]] - middle);
  return sum;
}

RingShape shape_of(const Solid& solid, const Ring& ring, const Allowance& allowance) {
  RingShape shape;
  const auto& vertices = ring.vertices;
  shape.centre = mean_of(solid, vertices);
  if (ring.is_pole()) return shape;
  const dvec3 area = newell(solid, vertices, shape.centre);
  const double twice = glm::length(area);
  if (!(twice > 0.0)) return shape;
  shape.normal = area / twice;
  if (vertices.size() < kLeastSegments) return shape;
  const dmat3 axes = axes_along(shape.normal, solid.points[vertices[0]] - shape.centre), turn = glm::transpose(axes);
  std::vector<dvec2> flat;
  double off_plane = 0.0;
  for (const std::uint32_t v : vertices) {
    const dvec3 q = turn * (solid.points[v] - shape.centre);
    flat.emplace_back(q.x, q.y);
    off_plane = std::max(off_plane, std::fabs(q.z));
  }
  const auto circle = fit_circle(flat);
  if (!circle) return shape;
  shape.radius = circle->radius;
  shape.centre += axes * dvec3(circle->centre, 0.0);
  shape.residual = off_plane;
  double widest = 0.0, around = 0.0;
  bool forward = true;
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const dvec2 p = flat[i] - circle->centre, q = flat[(i + 1) % flat.size()] - circle->centre;
    shape.residual = std::max(shape.residual, std::fabs(glm::length(p) - circle->radius));
    const double step = std::atan2(p.x * q.y - p.y * q.x, glm::dot(p, q));
    forward = forward && step > 0.0;
    widest = std::max(widest, step);
    around += step;
  }
  shape.sagitta = shape.radius * (1.0 - std::cos(0.5 * widest));
  shape.round = forward && widest <= kWidestGap && std::fabs(around - core::kFullTurn) < 1e-3;
  shape.circle = shape.round && shape.residual <= allowance.vertex(shape.radius, shape.sagitta);
  return shape;
}

class ChainFit {
 public:
  ChainFit(const Solid& solid, const RingChain& chain, const Allowance& allowance)
      : solid_(solid), chain_(chain), allowance_(allowance) {
    for (const Ring& ring : chain.rings) shapes_.push_back(shape_of(solid, ring, allowance));
    // Normals point along the chain.
    if (shapes_.size() > 1) {
      const bool first_is_pole = chain.rings[0].is_pole();
      const dvec3 way = shapes_[1].centre - shapes_[0].centre;
      if (glm::dot(shapes_[first_is_pole ? 1 : 0].normal, way) < 0.0)
        for (RingShape& shape : shapes_) shape.normal = -shape.normal;
    }
  }

  std::vector<Found> run() {
    if (auto prism = curved_prism()) return {std::move(*prism)};
    std::vector<Found> all;
    const std::size_t last = shapes_.size() - 1;
    for (std::size_t i = 0; i < last;) {
      std::size_t end = i;
      auto found = longest_from(i, end);
      if (found) all.push_back(std::move(*found));
      i = found ? end : i + 1;
    }
    return all;
  }

 private:
  bool pole(std::size_t i) const { return chain_.rings[i].is_pole(); }
  std::size_t segments(std::size_t i) const { return chain_.rings[i].vertices.size(); }
  double vertex_allowance(const RingShape& shape) const { return allowance_.vertex(shape.radius, shape.sagitta); }
  double same(const RingShape& shape) const { return allowance_.same(shape.radius, shape.sagitta, shape.residual); }

  std::optional<Found> longest_from(std::size_t i, std::size_t& end) {
    const std::size_t last = shapes_.size() - 1;
    if (pole(last) && last - i >= 2)
      if (auto found = dome(last, i)) return end = last, found;
    if (i == 0 && pole(0))
      if (auto found = dome_from_first_pole(end)) return found;
    const std::size_t straight = straight_run(i), bent = torus_run(i);
    for (const std::size_t j : {bent, i + 1})
      if (bent > straight)
        if (auto found = torus(i, j)) return end = j, j == i + 1 ? closer(std::move(found), slanted(i)) : found;
    for (const std::size_t j : {straight, i + 1})
      if (j > i && straight > i)
        if (auto found = straight_between(i, j)) return end = j, found;
    if (auto found = slanted(i)) return end = i + 1, found;
    return {};
  }

  /// Two circles a little out of parallel are almost the ends of a cylinder cut askew: what fits its vertices better.
  static std::optional<Found> closer(std::optional<Found> torus, std::optional<Found> snout) {
    return snout && snout->residual < torus->residual ? snout : torus;
  }

  /// Triangles of bands begin … end - 1, and the caps that close them. Adds the area of ends without caps to `bare`.
  std::vector<std::uint32_t> part(std::size_t begin, std::size_t end, double& bare) const {
    std::vector<std::uint32_t> triangles;
    for (std::size_t k = begin; k < end; ++k)
      triangles.insert(triangles.end(), chain_.bands[k].begin(), chain_.bands[k].end());
    const auto cap = [&](std::size_t ring, const std::vector<std::uint32_t>& with, bool outermost) {
      if (pole(ring)) return;
      if (outermost && !with.empty())
        triangles.insert(triangles.end(), with.begin(), with.end());
      else
        bare += 0.5 * glm::length(newell(solid_, chain_.rings[ring].vertices, shapes_[ring].centre));
    };
    cap(begin, chain_.first_cap, begin == 0);
    cap(end, chain_.last_cap, end + 1 == shapes_.size());
    return triangles;
  }

  std::optional<Found> checked(Found found, std::size_t begin, std::size_t end, double vertex, double explained,
                               double rim) const {
    double bare = 0.0;
    found.triangles = part(begin, end, bare);
    if (!verify(solid_, vertex, explained, bare, rim, found)) return {};
    return found;
  }

  double largest_allowance(std::size_t begin, std::size_t end) const {
    double most = 0.0;
    for (std::size_t k = begin; k <= end; ++k)
      if (!pole(k)) most = std::max(most, vertex_allowance(shapes_[k]));
    return most;
  }
  double largest_sagitta(std::size_t begin, std::size_t end) const {
    double most = 0.0;
    for (std::size_t k = begin; k <= end; ++k) most = std::max(most, shapes_[k].sagitta);
    return most;
  }

  /// The angle between neighbouring planes that noise alone may make.
  double noise_angle(std::size_t i, std::size_t j) const {
    const RingShape &a = shapes_[i], &b = shapes_[j];
    const double least = std::min(pole(i) ? b.radius : a.radius, pole(j) ? a.radius : b.radius);
    return 1e-6 + 2.0 * std::max(pole(i) ? 0.0 : same(a), pole(j) ? 0.0 : same(b)) / least;
  }
  double angle(std::size_t i, std::size_t j) const {
    const dvec3 &a = shapes_[i].normal, &b = shapes_[j].normal;
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
  }
  bool straight_pair(std::size_t i) const {
    const RingShape &a = shapes_[i], &b = shapes_[i + 1];
    if (pole(i) || pole(i + 1)) return (pole(i) ? b : a).circle;
    return a.circle && b.circle && segments(i) == segments(i + 1) && angle(i, i + 1) <= noise_angle(i, i + 1);
  }

  // --- cylinders and snouts ------------------------------------------------------------------------------------------

  /// The last ring of the longest run of rings whose centres and radii change linearly; i for none.
  std::size_t straight_run(std::size_t i) const {
    std::size_t j = i;
    for (; j + 1 < shapes_.size() && straight_pair(j); ++j) {
      if (j == i) continue;
      if (pole(j)) break;
      // Ring j lies on the line from ring i to ring j + 1.
      const RingShape &a = shapes_[i], &m = shapes_[j], &b = shapes_[j + 1];
      const dvec3 way = b.centre - a.centre;
      const double t = glm::dot(m.centre - a.centre, way) / std::max(glm::dot(way, way), 1e-300);
      const double off =
          glm::length(a.centre + t * way - m.centre) + std::fabs(a.radius + t * (b.radius - a.radius) - m.radius);
      if (!(t > 0.0 && t < 1.0 && off <= 2.0 * same(m))) break;
    }
    return j;
  }

  std::optional<Found> straight_between(std::size_t i, std::size_t j) const {
    const RingShape &a = shapes_[i], &b = shapes_[j];
    const RingShape& wider = a.radius >= b.radius ? a : b;
    const dvec3 way = b.centre - a.centre;
    const double length = glm::length(way);
    if (!(length > 0.0)) return {};
    const dvec3 normal = pole(i) ? b.normal : pole(j) ? a.normal : glm::normalize(a.normal + b.normal);
    const double height = glm::dot(way, normal), slack = same(wider) * (1.0 + length / wider.radius);
    if (!(height > slack)) return {};
    const dvec3 aside = way - height * normal;
    const dvec3 middle = 0.5 * (a.centre + b.centre);
    const bool right = glm::length(aside) <= slack;
    const dvec3 towards = segments(i) > 1 ? solid_.points[chain_.rings[i].vertices[0]] - a.centre
                                          : solid_.points[chain_.rings[j].vertices[0]] - b.centre;
    Found found;
    if (right) {
      // The line of centres is the better axis for what is long, the rings' planes for what is flat.
      const dvec3 axis = length > 2.0 * wider.radius ? way / length : normal;
      const double h = glm::dot(way, axis);
      found.mesh_from_primitive = {axes_along(axis, towards), middle};
      const double mean = 0.5 * (a.radius + b.radius);
      if (std::fabs(a.radius - b.radius) <= same(wider))
        found.primitive = core::Cylinder{float(mean), float(h)};
      else
        found.primitive = core::Snout{float(a.radius), float(b.radius), float(h), 0, 0, 0, 0, 0, 0};
    } else {
      found.mesh_from_primitive = {axes_along(normal, aside), middle};
      found.primitive =
          core::Snout{float(a.radius), float(b.radius), float(height), float(glm::length(aside)), 0, 0, 0, 0, 0};
    }
    const double sagitta = largest_sagitta(i, j);
    return checked(std::move(found), i, j, largest_allowance(i, j), sagitta, sagitta);
  }

  /// A straight cone or cylinder between two slanted ends. Its generators join the vertices of both rings.
  std::optional<Found> slanted(std::size_t i) const {
    const std::size_t n = segments(i);
    if (n < kLeastSegments || segments(i + 1) != n) return {};
    for (const std::size_t shift : {std::size_t(0), std::size_t(1), n - 1})
      if (auto found = slanted(i, shift)) return found;
    return {};
  }

  std::optional<Found> slanted(std::size_t i, std::size_t shift) const {
    const auto &low = chain_.rings[i].vertices, &high = chain_.rings[i + 1].vertices;
    const std::size_t n = low.size();
    std::vector<dvec3> from, along;
    dvec3 mean(0.0);
    for (std::size_t k = 0; k < n; ++k) {
      from.push_back(solid_.points[low[k]]);
      const dvec3 way = solid_.points[high[(k + shift) % n]] - from.back();
      const double length = glm::length(way);
      if (!(length > 0.0)) return {};
      along.push_back(way / length);
      mean += along.back();
    }
    mean /= double(n);
    double spread = 0.0;
    for (const dvec3& g : along) spread = std::max(spread, glm::length(g - mean));
    return spread < 1e-3 ? slanted_cylinder(i, glm::normalize(mean)) : slanted_cone(i, from, along);
  }

  std::optional<Found> slanted_cylinder(std::size_t i, const dvec3& axis) const {
    const dvec3 middle = shapes_[i].centre;
    const dmat3 axes = axes_along(axis, solid_.points[chain_.rings[i].vertices[0]] - middle),
                turn = glm::transpose(axes);
    std::vector<dvec2> flat;
    for (const std::size_t ring : {i, i + 1})
      for (const std::uint32_t v : chain_.rings[ring].vertices) {
        const dvec3 q = turn * (solid_.points[v] - middle);
        flat.emplace_back(q.x, q.y);
      }
    const auto circle = fit_circle(flat);
    if (!circle) return {};
    return slanted_snout(i, axes, middle + axes * dvec3(circle->centre, 0.0), [&](double) { return circle->radius; });
  }

  std::optional<Found> slanted_cone(std::size_t i, const std::vector<dvec3>& from,
                                    const std::vector<dvec3>& along) const {
    // Unit vectors along the generators of a straight cone end on a circle, whose normal is the axis.
    dvec3 mean(0.0), axis(0.0);
    for (const dvec3& g : along) mean += g / double(along.size());
    for (std::size_t k = 0; k < along.size(); ++k)
      axis += glm::cross(along[k] - mean, along[(k + 1) % along.size()] - mean);
    if (!(glm::dot(axis, axis) > 1e-24)) return {};
    axis = glm::normalize(axis);
    if (glm::dot(axis, mean) < 0.0) axis = -axis;
    // The apex is the point closest to all of them.
    dmat3 sum(0.0);
    dvec3 right(0.0);
    for (std::size_t k = 0; k < along.size(); ++k) {
      const dmat3 across = dmat3(1.0) - glm::outerProduct(along[k], along[k]);
      sum += across, right += across * (from[k] - shapes_[i].centre);
    }
    const auto apex = solve(sum, right);
    if (!apex) return {};
    const dvec3 tip = *apex + shapes_[i].centre;
    const dmat3 axes = axes_along(axis, from[0] - tip), turn = glm::transpose(axes);
    double above = 0.0, squares = 0.0;
    for (const std::size_t ring : {i, i + 1})
      for (const std::uint32_t v : chain_.rings[ring].vertices) {
        const dvec3 q = turn * (solid_.points[v] - tip);
        above += std::hypot(q.x, q.y) * std::fabs(q.z), squares += q.z * q.z;
      }
    if (!(squares > 0.0)) return {};
    const double slope = above / squares;
    return slanted_snout(i, axes, tip, [&](double z) { return slope * std::fabs(z); });
  }

  /// `radius_at`: of the cone, by the height over `origin`.
  template <class Radius>
  std::optional<Found> slanted_snout(std::size_t i, const dmat3& axes, const dvec3& origin,
                                     const Radius& radius_at) const {
    const dmat3 turn = glm::transpose(axes);
    double heights[2], tangents[2][2], steepest = 1.0;  // cosine of the steepest end's slope
    for (int end = 0; end < 2; ++end) {
      const RingShape& shape = shapes_[i + std::size_t(end)];
      const dvec3 normal = turn * shape.normal, at = turn * (shape.centre - origin);
      if (std::fabs(normal.z) < 0.2) return {};
      steepest = std::min(steepest, std::fabs(normal.z));
      heights[end] = at.z + (normal.x * at.x + normal.y * at.y) / normal.z;
      tangents[end][0] = -normal.x / normal.z, tangents[end][1] = -normal.y / normal.z;
    }
    const double height = heights[1] - heights[0];
    if (!(height > std::max(same(shapes_[i]), same(shapes_[i + 1])))) return {};
    const double bottom = radius_at(heights[0]), top = radius_at(heights[1]), wider = std::max(bottom, top);
    const double sagitta = wider * (1.0 - std::cos(kPi / double(segments(i))));
    const double vertex = allowance_.vertex(std::min(bottom, top), sagitta);
    // Where an end cuts a flat cone almost along its surface, vertices may be close to both and yet far from the rim.
    const double widening = (top - bottom) / height;
    double off_rim = 0.0;
    for (std::size_t end = 0; end < 2; ++end) {
      const dvec2 tangent(tangents[end][0], tangents[end][1]);
      if (std::fabs(widening) * glm::length(tangent) > kMostAlongCone) return {};
      for (const std::uint32_t v : chain_.rings[i + end].vertices) {
        const dvec3 q = turn * (solid_.points[v] - origin);
        const double rho = std::hypot(q.x, q.y), slope = rho > 0.0 ? glm::dot(tangent, dvec2(q)) / rho : 0.0;
        off_rim = std::max(off_rim, std::fabs((end == 0 ? bottom : top) / (1.0 - widening * slope) - rho));
      }
    }
    if (!(off_rim <= vertex + sagitta)) return {};
    Found found;
    found.primitive = core::Snout{float(bottom),
                                  float(top),
                                  float(height),
                                  0,
                                  0,
                                  float(std::atan(tangents[0][0])),
                                  float(std::atan(tangents[0][1])),
                                  float(std::atan(tangents[1][0])),
                                  float(std::atan(tangents[1][1]))};
    found.mesh_from_primitive = {axes, origin + 0.5 * (heights[0] + heights[1]) * axes[2]};
    return checked(std::move(found), i, i + 1, vertex, 1.5 * sagitta, off_rim + sagitta / steepest);
  }

  // --- tori ----------------------------------------------------------------------------------------------------------

  /// The last ring of the longest run of equal circles whose planes turn about one direction; i for none.
  std::size_t torus_run(std::size_t i) const {
    std::size_t j = i;
    dvec3 axis(0.0);
    double bend = 0.0;
    for (; j + 1 < shapes_.size(); ++j) {
      const RingShape &a = shapes_[j], &b = shapes_[j + 1];
      if (!a.circle || !b.circle || segments(j) != segments(j + 1)) break;
      const double turn = angle(j, j + 1);
      if (std::fabs(a.radius - b.radius) > 2.0 * same(a) || turn <= noise_angle(j, j + 1) || turn > kWidestGap) break;
      const dvec3 about = glm::normalize(glm::cross(a.normal, b.normal));
      const double radius = 0.5 * glm::length(b.centre - a.centre) / std::sin(0.5 * turn);
      if (j > i && (glm::dot(about, axis) < 0.9 || std::fabs(radius - bend) > 0.25 * bend)) break;
      if (j == i) axis = about, bend = radius;
    }
    return j;
  }

  std::optional<Found> torus(std::size_t i, std::size_t j) const {
    dvec3 axis(0.0);
    double sweep = 0.0, widest = 0.0, tube = 0.0;
    for (std::size_t k = i; k < j; ++k) {
      axis += glm::cross(shapes_[k].normal, shapes_[k + 1].normal);
      const double turn = angle(k, k + 1);
      sweep += turn, widest = std::max(widest, turn);
    }
    if (!(glm::dot(axis, axis) > 0.0) || sweep >= core::kFullTurn) return {};
    axis = glm::normalize(axis);
    for (std::size_t k = i; k <= j; ++k) tube += shapes_[k].radius / double(j - i + 1);
    const auto origin = centre_of_bend(i, j, axis);
    if (!origin) return {};
    double major = 0.0;
    for (std::size_t k = i; k <= j; ++k) {
      const dvec3 arm = shapes_[k].centre - *origin;
      major += glm::length(arm - glm::dot(arm, axis) * axis) / double(j - i + 1);
    }
    if (!(major > tube * 1.0001)) return {};
    Found found;
    found.primitive = core::CircularTorus{float(major), float(tube), float(sweep)};
    found.mesh_from_primitive = {axes_along(axis, shapes_[i].centre - *origin), *origin};
    const double explained = largest_sagitta(i, j) + (major + tube) * (1.0 - std::cos(0.5 * widest));
    return checked(std::move(found), i, j, largest_allowance(i, j), explained, largest_sagitta(i, j));
  }

  /// Where the planes of the rings meet, at the mean height of their centres. Three rings or more have it from the
  /// circle through their centres, which noise turns less.
  std::optional<dvec3> centre_of_bend(std::size_t i, std::size_t j, const dvec3& axis) const {
    const dvec3 first = shapes_[i].centre;
    const dmat3 axes = axes_along(axis, shapes_[i].normal), turn = glm::transpose(axes);
    double height = 0.0;
    std::vector<dvec2> centres;
    double xx = 0, xy = 0, yy = 0, xr = 0, yr = 0;
    for (std::size_t k = i; k <= j; ++k) {
      const dvec3 c = turn * (shapes_[k].centre - first), n = turn * shapes_[k].normal;
      height += c.z / double(j - i + 1);
      centres.emplace_back(c.x, c.y);
      const double distance = n.x * c.x + n.y * c.y;
      xx += n.x * n.x, xy += n.x * n.y, yy += n.y * n.y, xr += n.x * distance, yr += n.y * distance;
    }
    if (const auto circle = centres.size() > 2 ? fit_circle(centres) : std::nullopt)
      return first + axes * dvec3(circle->centre, height);
    const double det = xx * yy - xy * xy;
    if (!(det > 1e-12)) return {};
    return first + axes * dvec3((xr * yy - yr * xy) / det, (yr * xx - xr * xy) / det, height);
  }

  // --- dishes --------------------------------------------------------------------------------------------------------

  /// From a pole at the chain's begin, with the widest ring that fits as its base.
  std::optional<Found> dome_from_first_pole(std::size_t& end) {
    std::size_t base = 1;
    while (base + 1 < shapes_.size() && shapes_[base + 1].radius > shapes_[base].radius * (1.0 + 1e-6)) ++base;
    for (; base >= 2; --base)
      if (auto found = dome(0, base)) return end = base, found;
    return {};
  }

  /// A ring of a dome: its radius, its height above the base, and how many vertices it has.
  struct Level {
    double rho, z, weight;
  };

  /// The levels from the base's on up to the pole; nothing where they do not lie one above the other.
  std::optional<std::vector<Level>> levels_of(std::size_t pole_ring, std::size_t base_ring, const dvec3& axis) const {
    const RingShape& base = shapes_[base_ring];
    const double slack = vertex_allowance(base);  // for small rings near the pole, too
    std::vector<Level> levels = {{base.radius, 0.0, double(segments(base_ring))}};
    for (std::size_t k = base_ring; k != pole_ring;) {
      k = pole_ring > base_ring ? k + 1 : k - 1;
      const RingShape& ring = shapes_[k];
      const dvec3 up = ring.centre - base.centre;
      const double z = glm::dot(up, axis);
      if (!pole(k) && !(ring.round && ring.residual <= slack)) return {};
      if (!(z > levels.back().z) || glm::length(up - z * axis) > 2.0 * slack) return {};
      levels.push_back({ring.radius, z, double(segments(k))});
    }
    return levels;
  }

  std::optional<Found> dome(std::size_t pole_ring, std::size_t base_ring) {
    const RingShape& base = shapes_[base_ring];
    if (!base.circle || ++dome_trials_ > kMostDomeTrials) return {};
    const dvec3 way = shapes_[pole_ring].centre - base.centre;
    const dvec3 axis = glm::dot(way, base.normal) < 0.0 ? -base.normal : base.normal;
    const auto levels = levels_of(pole_ring, base_ring, axis);
    if (!levels) return {};
    // The longest chord of the meridian, whose depth the tessellation explains as long as it is not a cut.
    double chord = 0.0;
    for (std::size_t k = 1; k < levels->size(); ++k) {
      const Level &a = (*levels)[k - 1], &b = (*levels)[k];
      chord = std::max(chord, std::hypot(b.z - a.z, b.rho - a.rho));
    }
    const std::size_t begin = std::min(pole_ring, base_ring), end = std::max(pole_ring, base_ring);
    Found found;
    found.mesh_from_primitive = {axes_along(axis, solid_.points[chain_.rings[base_ring].vertices[0]] - base.centre),
                                 base.centre};
    const double radius = base.radius, vertex = vertex_allowance(base);
    const auto depth = [chord](double bend) {
      return chord <= 2.0 * bend ? bend - std::sqrt(bend * bend - 0.25 * chord * chord) : bend;
    };
    if (const double height = spherical_height(*levels); height > same(base)) {
      found.primitive = core::SphericalDish{float(radius), float(height)};
      const double bend = 0.5 * (radius * radius / height + height), explained = depth(bend) + base.sagitta;
      if (chord <= bend)
        if (auto done = checked(found, begin, end, vertex, explained, base.sagitta)) return done;
    }
    if (const double height = elliptical_height(*levels); height > same(base)) {
      found.primitive = core::EllipticalDish{float(radius), float(height)};
      const double large = std::max(radius, height), most_bend = large * large / std::min(radius, height);
      const double coarse = large * (1.0 - std::cos(kPi / double(segments(base_ring))));
      const double explained = std::max(depth(large) + base.sagitta, std::min(0.2 * large, depth(most_bend) + coarse));
      if (chord <= large) return checked(std::move(found), begin, end, vertex, explained, base.sagitta);
    }
    return {};
  }

  /// The height of the sphere through the base whose other levels are off by the least algebraic error; 0 for none.
  static double spherical_height(const std::vector<Level>& levels) {
    const double squared = levels[0].rho * levels[0].rho;
    double above = 0.0, below = 0.0;
    for (const Level& level : levels) {
      above += level.weight * level.z * (level.rho * level.rho + level.z * level.z - squared);
      below += level.weight * level.z * level.z;
    }
    if (!(below > 0.0)) return 0.0;
    const double centre = 0.5 * above / below;
    return centre + std::sqrt(squared + centre * centre);
  }

  /// The height of an ellipse whose widest place is the base: z^2 = h^2 (1 - rho^2 / r^2).
  static double elliptical_height(const std::vector<Level>& levels) {
    double above = 0.0, below = 0.0;
    for (const Level& level : levels) {
      const double share = 1.0 - level.rho * level.rho / (levels[0].rho * levels[0].rho);
      above += level.weight * level.z * level.z * share;
      below += level.weight * share * share;
    }
    return below > 0.0 && above > 0.0 ? std::sqrt(above / below) : 0.0;
  }

  // --- slices of rectangular tori ------------------------------------------------------------------------------------

  /// A prism over a sector of a ring: two arcs about one centre, joined by two radial edges.
  std::optional<Found> curved_prism() const {
    if (!chain_.whole || chain_.rings.size() != 2 || chain_.last_cap.empty()) return {};
    const auto& low = chain_.rings[0].vertices;
    const RingShape &a = shapes_[0], &b = shapes_[1];
    const dvec3 normal = a.normal + b.normal;
    if (low.size() < 5 || chain_.rings[1].vertices.size() != low.size() || a.circle) return {};
    if (!(glm::dot(normal, normal) > 1.0)) return {};
    const dvec3 way = b.centre - a.centre, reach = solid_.points[low[0]] - a.centre;
    const bool is_long = glm::dot(way, way) > glm::dot(reach, reach);  // as for cylinders
    const dvec3 axis = glm::normalize(is_long ? way : normal);
    const dmat3 axes = axes_along(axis, reach), turn = glm::transpose(axes);
    std::vector<dvec2> flat;
    for (const std::uint32_t v : low) {
      const dvec3 q = turn * (solid_.points[v] - a.centre);
      flat.emplace_back(q.x, q.y);
    }
    auto sector = sector_of(flat);
    if (!sector) return {};
    double widest = 0.0, sweep = 0.0;
    for (std::size_t k = 0; k + 1 < sector->arc.size(); ++k) {
      const dvec2 p = sector->arc[k] - sector->centre, q = sector->arc[k + 1] - sector->centre;
      const double step = std::atan2(p.x * q.y - p.y * q.x, glm::dot(p, q));
      sweep += step, widest = std::max(widest, std::fabs(step));
    }
    if (sweep < 0.0) std::reverse(sector->arc.begin(), sector->arc.end()), sweep = -sweep;
    // Both rings' planes give the middle; their centroids lie one above the other.
    const double rise = glm::dot(b.centre - a.centre, axis), height = std::fabs(rise);
    const double thin = std::min(sector->outer - sector->inner, height);
    if (widest > kWidestGap || !(thin > 0.0)) return {};
    const double sagitta = sector->outer * (1.0 - std::cos(0.5 * widest));
    const dvec2 start = glm::normalize(sector->arc.front() - sector->centre);
    Found found;
    found.primitive = core::RectangularTorus{float(sector->inner), float(sector->outer), float(height), float(sweep)};
    found.mesh_from_primitive = {axes_along(axis, axes * dvec3(start, 0.0)),
                                 a.centre + axes * dvec3(sector->centre, 0.5 * rise)};
    return checked(std::move(found), 0, 1, allowance_.vertex(thin, sagitta), sagitta, sagitta);
  }

  /// A sector of a ring, or of a disc with inner radius 0.
  struct Sector {
    dvec2 centre;
    double inner, outer;
    std::vector<dvec2> arc;  ///< the outer one
  };

  static std::optional<Sector> sector_of(const std::vector<dvec2>& outline) {
    // Arcs turn a little at each vertex, and much at the corners: four, or those of a disc's sector, its centre in
    // their middle.
    const std::size_t n = outline.size();
    std::vector<bool> corner(n);
    for (std::size_t i = 0; i < n; ++i) {
      const dvec2 p = outline[i] - outline[(i + n - 1) % n], q = outline[(i + 1) % n] - outline[i];
      corner[i] = glm::dot(p, q) < 0.5 * glm::length(p) * glm::length(q);
    }
    const auto corners = std::count(corner.begin(), corner.end(), true);
    const auto walk = [&](std::size_t from, std::size_t count) {
      std::vector<dvec2> points;
      for (std::size_t k = 0; k < count; ++k) points.push_back(outline[(from + k) % n]);
      return points;
    };
    for (std::size_t i = 0; i < n && corners == 3; ++i) {
      if (!corner[i] || !corner[(i + 1) % n] || !corner[(i + n - 1) % n]) continue;
      Sector sector{outline[i], 0.0, 0.0, walk(i + 1, n - 1)};
      sector.centre = evened(sector.centre, sector.arc);
      for (const dvec2& p : sector.arc) sector.outer += glm::length(p - sector.centre) / double(n - 1);
      return sector;
    }
    const std::size_t half = n / 2;
    for (std::size_t i = 0; i < n && corners == 4 && n % 2 == 0; ++i) {
      if (!corner[i] || !corner[(i + half - 1) % n] || !corner[(i + half) % n] || !corner[(i + n - 1) % n]) continue;
      std::vector<dvec2> arcs[2] = {walk(i, half), walk(i + half, half)};
      const auto centre = common_centre(arcs[0], arcs[1]);
      if (!centre) return {};
      double radii[2] = {0.0, 0.0};
      for (int arc = 0; arc < 2; ++arc)
        for (const dvec2& p : arcs[arc]) radii[arc] += glm::length(p - *centre) / double(half);
      const int outer = radii[0] >= radii[1] ? 0 : 1;
      return Sector{*centre, radii[1 - outer], radii[outer], std::move(arcs[outer])};
    }
    return {};
  }

  /// Moves the vertex at the centre of an arc so that it and the arc's vertices are off by the least squares: one step
  /// of Gauss and Newton.
  static dvec2 evened(const dvec2& centre, const std::vector<dvec2>& arc) {
    dvec2 mean(0.0);
    double radius = 0.0;
    for (const dvec2& p : arc) {
      mean += glm::normalize(p - centre) / double(arc.size());
      radius += glm::length(p - centre) / double(arc.size());
    }
    double xx = 1.0, xy = 0.0, yy = 1.0;
    dvec2 right(0.0);
    for (const dvec2& p : arc) {
      const dvec2 u = glm::normalize(p - centre) - mean;
      xx += u.x * u.x, xy += u.x * u.y, yy += u.y * u.y;
      right += (glm::length(p - centre) - radius) * u;
    }
    const double det = xx * yy - xy * xy;  // at least 1
    return centre + dvec2(right.x * yy - right.y * xy, right.y * xx - right.x * xy) / det;
  }

  /// The centre of two concentric circles: |p|^2 - 2 p.c is the same for all points of each.
  static std::optional<dvec2> common_centre(const std::vector<dvec2>& one, const std::vector<dvec2>& other) {
    double xx = 0, xy = 0, yy = 0, xs = 0, ys = 0;
    for (const auto* arc : {&one, &other}) {
      dvec2 mean(0.0);
      double squares = 0.0;
      for (const dvec2& p : *arc) mean += p / double(arc->size()), squares += glm::dot(p, p) / double(arc->size());
      for (const dvec2& p : *arc) {
        const dvec2 d = p - mean;
        const double s = glm::dot(p, p) - squares;
        xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y, xs += d.x * s, ys += d.y * s;
      }
    }
    const double det = xx * yy - xy * xy;
    if (!(det > 1e-12 * (xx + yy) * (xx + yy))) return {};
    return dvec2(0.5 * (xs * yy - ys * xy) / det, 0.5 * (ys * xx - xs * xy) / det);
  }

  const Solid& solid_;
  const RingChain& chain_;
  const Allowance& allowance_;
  std::vector<RingShape> shapes_;
  int dome_trials_ = 0;
};

}  // namespace

std::vector<Found> fit_chain(const Solid& solid, const RingChain& chain, const Allowance& allowance) {
  if (chain.rings.size() < 2) return {};
  return ChainFit(solid, chain, allowance).run();
}

}  // namespace sightline::importers::recognition
