#include "sightline/analysis/measure/internal/shape.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace sightline::measure {
namespace {

using Form = Shape::Form;

/// Up to so many triangles a node's hull is that of its corners, not its box: far tighter on curved surfaces.
constexpr std::uint32_t kHullTriangles = 64;

dvec3 farthest_point(const dvec3* points, std::size_t count, const dvec3& d) {
  std::size_t best = 0;
  double farthest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    const double value = glm::dot(points[i], d);
    if (value > farthest) farthest = value, best = i;
  }
  return points[best];
}

dvec3 farthest_point(const Disc& disc, const dvec3& d) {
  const double a = glm::dot(disc.u, d), b = glm::dot(disc.v, d), norm = std::hypot(a, b);
  return norm > 0.0 ? disc.centre + disc.u * (a / norm) + disc.v * (b / norm) : disc.centre;
}

/// The next three are in local coordinates, u being the direction there.
dvec3 ball_point(const dvec3& u, bool upper_half) {
  const double z = upper_half ? std::max(0.0, u.z) : u.z, norm = glm::length(dvec3(u.x, u.y, z));
  return norm > 0.0 ? dvec3(u.x, u.y, z) / norm : dvec3(0.0);
}

dvec3 cap_point(double r, double h, const dvec3& u) {
  const double flat = std::hypot(u.x, u.y);
  if (h > 0.0) {
    // As core::support() has it: u| - u.z without cancellation.
    const double sphere = (r * r + h * h) / (2.0 * h), norm = glm::length(u);
    if (norm == 0.0) return {0, 0, 0};
    const double fall = u.z > 0.0 ? (u.x * u.x + u.y * u.y) / (norm + u.z) : norm - u.z;
    if (h * norm >= sphere * fall) return {sphere * u.x / norm, sphere * u.y / norm, h - sphere * fall / norm};
  }
  return flat > 0.0 ? dvec3(r * u.x / flat, r * u.y / flat, 0.0) : dvec3(0.0);
}

/// In the plane of a slice: (from the axis, z) of the point farthest along (w, z).
dvec2 slice_point(const Sweep& s, double w, double z) {
  dvec2 at(w > 0.0 ? s.outer : s.inner, std::copysign(s.half_height, z));
  const double norm = std::hypot(w, z);
  if (s.tube > 0.0 && norm > 0.0) at += dvec2(w, z) * (s.tube / norm);
  if (at.x < 0.0) at = {0.0, std::copysign(std::sqrt((s.tube - s.outer) * (s.tube + s.outer)), z)};
  return at;
}

double cross(const dvec2& a, const dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

Support sweep_support(const Piece& piece, const dvec3& d) {
  const dvec3 u = d * piece.shape->linear;
  // A slice's support is convex in w, the share of u along its direction. So an end of w's range has the maximum.
  double farthest = -std::numeric_limits<double>::infinity();
  Support best;
  const auto consider = [&](const dvec2& e) {
    const double w = e.x * u.x + e.y * u.y;
    const dvec2 at = slice_point(piece.shape->sweep, w, u.z);
    const double value = at.x * w + at.y * u.z;
    if (value <= farthest) return;
    farthest = value;
    best = {{at.x * e.x, at.x * e.y, at.y}, e};
  };
  consider(piece.from);
  if (!piece.one_slice()) {
    consider(piece.to);
    const double flat = std::hypot(u.x, u.y);
    if (flat > 0.0) {
      dvec2 e(u.x / flat, u.y / flat);
      if (glm::dot(e, piece.from + piece.to) < 0.0) e = -e;
      if (cross(piece.from, e) > 0.0 && cross(e, piece.to) > 0.0) consider(e);
    }
  }
  best.point = piece.shape->linear * best.point;
  return best;
}

dvec3 support_point(const Piece& piece, const dvec3& d) {
  const Shape& shape = *piece.shape;
  switch (shape.form) {
    case Form::kPoints:
      return farthest_point(shape.points.data(), shape.points.size(), d);
    case Form::kDiscs: {
      const dvec3 first = farthest_point(shape.discs[0], d), second = farthest_point(shape.discs[1], d);
      return glm::dot(first, d) >= glm::dot(second, d) ? first : second;
    }
    case Form::kBall:
      return shape.linear * ball_point(d * shape.linear, false);
    case Form::kHalfBall:
      return shape.linear * ball_point(d * shape.linear, true);
    case Form::kCap:
      return shape.linear * cap_point(shape.base_radius, shape.height, d * shape.linear);
    default: {
      const TriangleNode& node = shape.nodes[piece.node];
      if (node.count <= kHullTriangles)
        return farthest_point(&shape.points[3 * std::size_t(node.begin)], 3 * std::size_t(node.count), d);
      return glm::mix(node.box.min, node.box.max, glm::greaterThan(d, dvec3(0.0)));
    }
  }
}

constexpr int kGenerators = 1024;

/// Points whose hull is inscribed in a snout of any ends: where its generators leave the solid, and where both end
/// planes meet at a level cut within the cone.
std::vector<dvec3> extreme_points(const core::Snout& s) {
  const double h = length_of(s.height), rb = length_of(s.bottom_radius), rt = length_of(s.top_radius);
  const dvec2 lean(s.offset_x / h, s.offset_y / h);
  const double radius = 0.5 * (rb + rt), widening = (rt - rb) / h;
  const double lowest = -0.5 * h + core::bottom_end_range(s).min, highest = 0.5 * h + core::top_end_range(s).max;
  // An end plane: z = height + dot(m, xy). The solid is above the first and below the second.
  struct EndPlane {
    dvec2 m;
    double height;
  };
  const auto end_plane = [&](float shear_x, float shear_y, double side) {
    const dvec2 m(std::tan(double(shear_x)), std::tan(double(shear_y)));
    return EndPlane{m, side * h * (1.0 - glm::dot(m, lean))};
  };
  const EndPlane planes[2] = {end_plane(s.bottom_shear_x, s.bottom_shear_y, -0.5),
                              end_plane(s.top_shear_x, s.top_shear_y, 0.5)};
  std::vector<dvec3> points;
  for (int i = 0; i < kGenerators; ++i) {
    const double angle = core::kFullTurn * i / kGenerators;
    const dvec2 e(std::cos(angle), std::sin(angle));
    // The point at height z is (lean z + (radius + widening z) e, z), kept where value + slope z >= 0.
    double low = lowest, high = highest;
    const auto keep = [&](double value, double slope) {
      if (slope > 0.0) low = std::max(low, -value / slope);
      if (slope < 0.0) high = std::min(high, -value / slope);
      if (slope == 0.0 && value < 0.0) high = -std::numeric_limits<double>::infinity();
    };
    keep(radius, widening);
    for (int end = 0; end < 2; ++end) {
      const double above = end == 0 ? 1.0 : -1.0;
      keep(above * (-planes[end].height - radius * glm::dot(planes[end].m, e)),
           above * (1.0 - glm::dot(planes[end].m, lean + widening * e)));
    }
    if (!(low <= high)) continue;
    for (const double z : {low, high}) points.emplace_back(lean * z + (radius + widening * z) * e, z);
  }
  const double turn = cross(planes[0].m, planes[1].m);
  for (const double z : {lowest, highest}) {
    if (turn == 0.0) break;
    const double a = z - planes[0].height, b = z - planes[1].height;
    const dvec2 xy = dvec2(a * planes[1].m.y - b * planes[0].m.y, b * planes[0].m.x - a * planes[1].m.x) / turn;
    if (glm::length(xy - lean * z) <= radius + widening * z) points.emplace_back(xy, z);
  }
  if (points.empty()) points = {dvec3(0.0)};
  return points;
}

struct MakeShape {
  const core::Affine& placement;

  Shape hull(std::span<const dvec3> local) const {
    Shape shape = of(Form::kPoints);
    for (const dvec3& p : local) shape.points.push_back(placement.linear * p);
    return shape;
  }
  Shape of(Form form) const {
    Shape shape;
    shape.form = form;
    shape.origin = placement.origin;
    shape.linear = placement.linear;
    return shape;
  }
  Shape discs(const Disc& first, const Disc& second) const {
    Shape shape = of(Form::kDiscs);
    const dmat3& m = placement.linear;
    shape.discs = {Disc{m * first.centre, m * first.u, m * first.v},
                   Disc{m * second.centre, m * second.u, m * second.v}};
    return shape;
  }
  Shape ball(Form form, double radius, double height) const {
    Shape shape = of(form);
    shape.linear[0] *= radius, shape.linear[1] *= radius, shape.linear[2] *= height;
    return shape;
  }
  Shape swept(const Sweep& sweep) const {
    Shape shape = of(Form::kSweep);
    shape.sweep = sweep;
    return shape;
  }

  Shape operator()(const core::Pyramid& p) const { return hull(corners_of(p)); }
  Shape operator()(const core::Box& b) const { return hull(corners_of(as_pyramid(b))); }
  Shape operator()(const core::RectangularTorus& t) const {
    const auto [inner, outer] = std::minmax({length_of(t.inner_radius), length_of(t.outer_radius)});
    return swept({inner, outer, 0.5 * length_of(t.height), 0.0, 0.0, core::sweep_angle(t.angle)});
  }
  Shape operator()(const core::CircularTorus& t) const {
    const double major = length_of(t.major_radius);
    return swept({major, major, 0.0, length_of(t.tube_radius), 0.0, core::sweep_angle(t.angle)});
  }
  Shape operator()(const core::EllipticalDish& d) const {
    return ball(Form::kHalfBall, length_of(d.base_radius), length_of(d.height));
  }
  Shape operator()(const core::SphericalDish& d) const {
    Shape shape = of(Form::kCap);
    shape.base_radius = length_of(d.base_radius);
    shape.height = length_of(d.height);
    return shape;
  }
  Shape operator()(const core::Snout& s) const {
    if (const auto ends = snout_ends(s)) return discs((*ends)[0].contour, (*ends)[1].contour);
    Shape shape = hull(extreme_points(s));
    double reach = 0.0;
    for (const dvec3& p : shape.points) reach = std::max(reach, glm::length(p));
    const double step = core::kFullTurn / kGenerators;
    shape.error = reach * step * step;
    return shape;
  }
  Shape operator()(const core::Cylinder& c) const {
    const double r = length_of(c.radius), half = 0.5 * length_of(c.height);
    return discs({{0, 0, -half}, {r, 0, 0}, {0, r, 0}}, {{0, 0, half}, {r, 0, 0}, {0, r, 0}});
  }
  Shape operator()(const core::Sphere& s) const {
    const double r = 0.5 * length_of(s.diameter);
    return ball(Form::kBall, r, r);
  }
  Shape operator()(const core::Line& l) const { return hull(std::array{dvec3(l.from, 0, 0), dvec3(l.to, 0, 0)}); }
};

/// Orders triangles[begin, end) and appends the node over them; returns its index.
std::uint32_t build_nodes(Shape& shape, std::vector<std::uint32_t>& triangles, std::size_t begin, std::size_t end) {
  const auto corner = [&](std::uint32_t triangle, int i) { return shape.points[3 * std::size_t(triangle) + i]; };
  const auto centre = [&](std::uint32_t t, int axis) {
    return corner(t, 0)[axis] + corner(t, 1)[axis] + corner(t, 2)[axis];
  };
  const std::uint32_t index = std::uint32_t(shape.nodes.size());
  TriangleNode node;
  dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = begin; i < end; ++i) {
    for (int k = 0; k < 3; ++k) node.box.grow(corner(triangles[i], k));
    const dvec3 c(centre(triangles[i], 0), centre(triangles[i], 1), centre(triangles[i], 2));
    low = glm::min(low, c), high = glm::max(high, c);
  }
  node.begin = std::uint32_t(begin), node.count = std::uint32_t(end - begin);
  shape.nodes.push_back(node);
  if (end - begin == 1) return index;
  const dvec3 extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::size_t middle = begin + (end - begin) / 2;
  std::nth_element(triangles.begin() + begin, triangles.begin() + middle, triangles.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) { return centre(a, axis) < centre(b, axis); });
  build_nodes(shape, triangles, begin, middle);
  const std::uint32_t second = build_nodes(shape, triangles, middle, end);
  shape.nodes[index].second = second;
  return index;
}

struct MakeGeometryShape {
  Shape operator()(const dvec3& p) const { return hull(p, {p}); }
  Shape operator()(const Segment& s) const { return hull(s.from, {s.from, s.to}); }
  Shape operator()(const Line& l) const { return hull(l.through, {l.through}); }
  Shape operator()(const Arc& a) const { return swept(a.centre, a.u, a.v, {1.0, 1.0, 0.0, 0.0, a.from, a.to}); }
  Shape operator()(const Face& f) const {
    if (!f.corners.empty()) return hull(f.centre, f.corners);
    return swept(f.centre, f.u, f.v, {f.inner, 1.0, 0.0, 0.0, f.from, f.to});
  }
  static Shape hull(const dvec3& origin, const std::vector<dvec3>& points) {
    Shape shape;
    shape.origin = origin;
    for (const dvec3& p : points) shape.points.push_back(p - origin);
    return shape;
  }
  static Shape swept(const dvec3& centre, const dvec3& u, const dvec3& v, const Sweep& sweep) {
    Shape shape;
    shape.origin = centre;
    if (sweep.inner == 0.0 && sweep.to - sweep.from == core::kFullTurn) {  // convex: no slices needed
      shape.form = Form::kDiscs;
      shape.discs = {Disc{dvec3(0.0), u, v}, Disc{dvec3(0.0), u, v}};
      return shape;
    }
    shape.form = Form::kSweep;
    shape.linear = {u, v, dvec3(0.0)};
    shape.sweep = sweep;
    return shape;
  }
};

}  // namespace

Support support(const Piece& piece, const dvec3& direction) {
  if (piece.shape->form == Form::kSweep) {
    Support found = sweep_support(piece, direction);
    found.point += piece.offset;
    return found;
  }
  return {support_point(piece, direction) + piece.offset, {1, 0}};
}

Shape make_shape(const core::Primitive& primitive, const core::Affine& world_from_item) {
  return std::visit(MakeShape{world_from_item}, primitive);
}

Shape make_shape(const core::Mesh& mesh, const core::Affine& world_from_item) {
  Shape shape;
  shape.form = Form::kTriangles;
  core::AabbD box;
  for (const core::vec3& p : mesh.positions)
    if (core::is_finite(dvec3(p))) box.grow(dvec3(p));
  const dvec3 middle = box.empty() ? dvec3(0.0) : box.centre();
  shape.origin = core::transform_point(world_from_item, middle);
  std::vector<std::uint32_t> kept;  // triangles of the mesh
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    dvec3 corners[3];
    for (int k = 0; k < 3; ++k)
      corners[k] = world_from_item.linear * (dvec3(mesh.positions[mesh.indices[i + k]]) - middle);
    if (!core::is_finite(corners[0]) || !core::is_finite(corners[1]) || !core::is_finite(corners[2])) continue;
    shape.points.insert(shape.points.end(), corners, corners + 3);
    kept.push_back(std::uint32_t(i / 3));
  }
  shape.solid = core::enclosure(mesh) != core::Enclosure::kNothing;
  std::vector<std::uint32_t> triangles(shape.points.size() / 3);
  std::iota(triangles.begin(), triangles.end(), 0u);
  shape.nodes.reserve(2 * triangles.size());
  if (triangles.empty()) return shape;
  build_nodes(shape, triangles, 0, triangles.size());
  std::vector<dvec3> ordered;
  ordered.reserve(shape.points.size());
  for (std::uint32_t& triangle : triangles) {
    for (int k = 0; k < 3; ++k) ordered.push_back(shape.points[3 * std::size_t(triangle) + k]);
    triangle = kept[triangle];
  }
  shape.points = std::move(ordered);
  shape.mesh_triangles = std::move(triangles);
  return shape;
}

Shape make_shape(const Geometry& geometry) {
  return std::visit(MakeGeometryShape{}, geometry);
}

std::array<dvec3, 8> corners_of(const core::Pyramid& p) {
  const dvec2 sizes[2] = {{length_of(p.bottom_x), length_of(p.bottom_y)}, {length_of(p.top_x), length_of(p.top_y)}};
  constexpr double kSigns[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  std::array<dvec3, 8> corners;
  for (int i = 0; i < 8; ++i) {
    const double side = i < 4 ? -0.5 : 0.5;
    const dvec2 at = dvec2(kSigns[i % 4][0], kSigns[i % 4][1]) * sizes[i / 4] + side * dvec2(p.offset_x, p.offset_y);
    corners[i] = dvec3(at, side * length_of(p.height));
  }
  return corners;
}

core::Pyramid as_pyramid(const core::Box& b) {
  return {b.size_x, b.size_y, b.size_x, b.size_y, 0.0f, 0.0f, b.size_z};
}

std::optional<std::array<SnoutEnd, 2>> snout_ends(const core::Snout& s) {
  const double h = length_of(s.height), radii[2] = {length_of(s.bottom_radius), length_of(s.top_radius)};
  std::array<SnoutEnd, 2> ends;
  if (h == 0.0) {  // a level disc about the centre of the larger end
    const int larger = radii[1] > radii[0] ? 1 : 0;
    const double r = radii[larger], side = larger == 1 ? 0.5 : -0.5;
    ends.fill({{{side * s.offset_x, side * s.offset_y, 0}, {r, 0, 0}, {0, r, 0}}, {0, 0, 1}});
    return ends;
  }
  if (core::bottom_end_range(s).limited || core::top_end_range(s).limited) return std::nullopt;
  const dvec2 lean(s.offset_x / h, s.offset_y / h);
  const double widening = (radii[1] - radii[0]) / h;
  for (int end = 0; end < 2; ++end) {
    const double r = radii[end], side = end == 0 ? -0.5 : 0.5;
    const dvec2 m(std::tan(double(end == 0 ? s.bottom_shear_x : s.top_shear_x)),
                  std::tan(double(end == 0 ? s.bottom_shear_y : s.top_shear_y)));
    // Relative to the leaning axis the contour is a conic in polar form about it: q = r / (1 - eccentricity cos(phi)),
    // phi from m. With q, xy = lean z + q and z = m . xy give z = m . q / upright.
    const double steep = glm::length(m), upright = 1.0 - glm::dot(m, lean), eccentricity = widening * steep / upright;
    const dvec2 along = steep > 0.0 ? m / steep : dvec2(1, 0), across(-along.y, along.x);
    const double shrink = (1.0 - eccentricity) * (1.0 + eccentricity), major = r / shrink,
                 minor = r / std::sqrt(shrink);
    const auto lifted = [&](const dvec2& q) {
      const double z = glm::dot(m, q) / upright;
      return dvec3(q + lean * z, z);
    };
    ends[end].contour = {dvec3(side * s.offset_x, side * s.offset_y, side * h) + lifted(major * eccentricity * along),
                         lifted(major * along), lifted(minor * across)};
    ends[end].upwards = glm::normalize(dvec3(-m.x, -m.y, 1.0));
  }
  // The ends cross within the cone exactly if a point of the lower contour lies above the upper plane.
  const Disc& lower = ends[0].contour;
  const dvec3 top_centre(0.5 * s.offset_x, 0.5 * s.offset_y, 0.5 * h), up = ends[1].upwards;
  if (glm::dot(up, lower.centre - top_centre) + std::hypot(glm::dot(up, lower.u), glm::dot(up, lower.v)) > 1e-12 * h)
    return std::nullopt;
  return ends;
}

}  // namespace sightline::measure
