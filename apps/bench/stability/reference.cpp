#include "sightline/apps/bench/stability/reference.h"

#include <cmath>
#include <functional>
#include <limits>

namespace sightline::bench {
namespace {

using core::dvec3;

/// A point, or a line as a function of its parameter.
struct Coordinates {
  Polynomial x, y, z;
};
using Implicit = std::function<Polynomial(const Coordinates&)>;

struct Surface {
  Implicit f;  ///< <= 0 inside, if it is the only boundary
  int face;
};

/// `inside` is called only for points that lie on no surface. A sheet is the part of its first surface where `inside`
/// holds: it has two sides and no volume.
struct Solid {
  std::vector<Surface> surfaces;
  std::function<bool(const QuadVec&)> inside;
  bool sheet = false;
};

Coordinates at(const QuadVec& p) {
  return {p.x, p.y, p.z};
}
Coordinates along(const QuadRay& ray) {
  return {{ray.origin.x, ray.direction.x}, {ray.origin.y, ray.direction.y}, {ray.origin.z, ray.direction.z}};
}
Quad value(const Implicit& f, const QuadVec& p) {
  return f(at(p))[0];
}
Quad length(float v) {
  return fabsq(Quad(v));
}
const Quad kQuadPi = 4 * atanq(1);

/// The solid inside all of the surfaces.
Solid convex(std::vector<Surface> surfaces) {
  Solid solid{std::move(surfaces), {}};
  solid.inside = [surfaces = solid.surfaces](const QuadVec& p) {
    return std::all_of(surfaces.begin(), surfaces.end(), [&](const Surface& s) { return value(s.f, p) <= 0; });
  };
  return solid;
}

/// The part of `carrier` inside all of `limits`.
Solid sheet(Surface carrier, const std::vector<Surface>& limits) {
  Solid solid = convex(limits);
  solid.surfaces = {std::move(carrier)};
  solid.sheet = true;
  return solid;
}

Surface below_z(Quad z) {
  return {[z](const Coordinates& p) { return p.z - z; }, kTop};
}
Surface above_z(Quad z) {
  return {[z](const Coordinates& p) { return z - p.z; }, kBottom};
}
Surface within_circle(Quad radius) {
  return {[radius](const Coordinates& p) { return p.x * p.x + p.y * p.y - radius * radius; }, kSide};
}

Solid solid_of(const core::Cylinder& c) {
  const Quad radius = length(c.radius), half = length(c.height) / 2;
  if (radius == 0) return {};
  if (half == 0) return sheet(below_z(0), {within_circle(radius)});
  return convex({within_circle(radius), above_z(-half), below_z(half)});
}

/// The half-space below or above z = height + tangent . (xy - centre), for the end on the side of `sign`.
Surface slanted_end(Quad centre_x, Quad centre_y, Quad height, float shear_x, float shear_y, int sign) {
  const Quad mx = tanq(shear_x), my = tanq(shear_y);
  return {[=](const Coordinates& p) {
            return Polynomial(sign) * (p.z - height - mx * (p.x - centre_x) - my * (p.y - centre_y));
          },
          sign < 0 ? kBottom : kTop};
}

/// Whether an end has no closed contour and is cut level one height beyond it (core::EndRange).
bool cut_level(const core::Snout& s, float shear_x, float shear_y) {
  const Quad h = length(s.height), mx = tanq(shear_x), my = tanq(shear_y), steep = hypotq(mx, my);
  const Quad lean = (mx * s.offset_x + my * s.offset_y) / h;
  const Quad slope = (length(s.top_radius) - length(s.bottom_radius)) / h;
  const Quad nearly_open = 1e-3;
  return steep > 0 && !(1 - lean - slope * steep > nearly_open && 1 - lean + slope * steep > nearly_open);
}

Solid solid_of(const core::Snout& s) {
  const Quad h = length(s.height), bottom = length(s.bottom_radius), top = length(s.top_radius);
  if (bottom == 0 && top == 0) return {};
  const Quad half_x = Quad(s.offset_x) / 2, half_y = Quad(s.offset_y) / 2;
  if (h == 0) {  // the larger end
    const int side = top > bottom ? 1 : -1;
    const Quad radius = std::max(bottom, top);
    return sheet(below_z(0), {{[=](const Coordinates& p) {
                                 const Polynomial x = p.x - side * half_x, y = p.y - side * half_y;
                                 return x * x + y * y - radius * radius;
                               },
                               kSide}});
  }
  const auto radius = [=](const Coordinates& p) { return (bottom + top) / 2 + (top - bottom) / h * p.z; };
  std::vector<Surface> surfaces{
      {[=](const Coordinates& p) {
         const Polynomial x = p.x - s.offset_x / h * p.z, y = p.y - s.offset_y / h * p.z, r = radius(p);
         return x * x + y * y - r * r;
       },
       kSide},
      {[=](const Coordinates& p) { return Polynomial(-1) * radius(p); }, kSide},  // only one nappe
      slanted_end(-half_x, -half_y, -h / 2, s.bottom_shear_x, s.bottom_shear_y, -1),
      slanted_end(half_x, half_y, h / 2, s.top_shear_x, s.top_shear_y, 1)};
  if (cut_level(s, s.bottom_shear_x, s.bottom_shear_y)) surfaces.push_back(above_z(-h / 2 - h));
  if (cut_level(s, s.top_shear_x, s.top_shear_y)) surfaces.push_back(below_z(h / 2 + h));
  return convex(std::move(surfaces));
}

Solid solid_of(const core::Sphere& s) {
  const Quad radius = length(s.diameter) / 2;
  if (radius == 0) return {};
  return convex({{[=](const Coordinates& p) { return p.x * p.x + p.y * p.y + p.z * p.z - radius * radius; }, kSide}});
}

Solid solid_of(const core::EllipticalDish& d) {
  const Quad r = length(d.base_radius), h = length(d.height);
  if (r == 0) return {};
  if (h == 0) return sheet(below_z(0), {within_circle(r)});
  return convex(
      {{[=](const Coordinates& p) { return (p.x * p.x + p.y * p.y) * (1 / (r * r)) + p.z * p.z * (1 / (h * h)) - 1; },
        kSide},
       above_z(0)});
}

Solid solid_of(const core::SphericalDish& d) {
  const Quad r = length(d.base_radius), h = length(d.height);
  if (h == 0) return r == 0 ? Solid{} : sheet(below_z(0), {within_circle(r)});
  // |p - (0, 0, h - R)|^2 = R^2 with 2 h R = r^2 + h^2.
  return convex(
      {{[=](const Coordinates& p) { return p.x * p.x + p.y * p.y + p.z * p.z + (r * r / h - h) * p.z - r * r; }, kSide},
       above_z(0)});
}

Surface side(Quad sign, bool x_axis, Quad bottom, Quad top, Quad offset, Quad height) {
  return {[=](const Coordinates& p) {
            const Polynomial part = p.z * (1 / height);  // -1/2 ... 1/2
            return sign * ((x_axis ? p.x : p.y) - offset * part) - ((bottom + top) / 4 + (top - bottom) / 2 * part);
          },
          kSide};
}

/// A pyramid of height 0: the hull of both ends. A point lies in it if it lies in one of the rectangles between them.
Solid flat_pyramid(const core::Pyramid& p) {
  Solid solid;
  solid.surfaces = {below_z(0)};
  solid.sheet = true;
  solid.inside = [p](const QuadVec& at) {
    Quad from = 0, to = 1;  // the remaining part of the way up
    const auto keep = [&](Quad distance, float bottom, float top, float offset, int sign) {
      // length(bottom) / 2 + part (length(top) - length(bottom)) / 2 - sign (distance - offset (part - 1/2)) >= 0
      const Quad value = length(bottom) / 2 - sign * (distance + Quad(offset) / 2);
      const Quad slope = (length(top) - length(bottom)) / 2 + sign * Quad(offset);
      if (slope > 0) from = std::max(from, -value / slope);
      if (slope < 0) to = std::min(to, -value / slope);
      if (slope == 0 && value < 0) to = -1;
    };
    for (const int sign : {-1, 1}) {
      keep(at.x, p.bottom_x, p.top_x, p.offset_x, sign);
      keep(at.y, p.bottom_y, p.top_y, p.offset_y, sign);
    }
    return from <= to;
  };
  return solid;
}

Solid solid_of(const core::Pyramid& p) {
  const Quad bx = length(p.bottom_x), by = length(p.bottom_y), tx = length(p.top_x), ty = length(p.top_y);
  const Quad h = length(p.height);
  const bool flat_x = bx == 0 && tx == 0, flat_y = by == 0 && ty == 0;
  if (flat_x && flat_y) return {};
  if (h == 0) return flat_x || flat_y ? Solid{} : flat_pyramid(p);
  const std::vector<Surface> x_sides{side(1, true, bx, tx, p.offset_x, h), side(-1, true, bx, tx, p.offset_x, h)};
  const std::vector<Surface> y_sides{side(1, false, by, ty, p.offset_y, h), side(-1, false, by, ty, p.offset_y, h)};
  std::vector<Surface> limits{above_z(-h / 2), below_z(h / 2)};
  if (!flat_x) limits.insert(limits.end(), x_sides.begin(), x_sides.end());
  if (!flat_y) limits.insert(limits.end(), y_sides.begin(), y_sides.end());
  if (flat_x || flat_y) return sheet(flat_x ? x_sides[0] : y_sides[0], limits);
  return convex(limits);
}

/// The half-space sign * axis <= half.
Surface slab(int axis, int sign, Quad half) {
  return {[=](const Coordinates& p) {
            return Polynomial(sign) * (axis == 0 ? p.x : axis == 1 ? p.y : p.z) - half;
          },
          axis < 2   ? kSide
          : sign < 0 ? kBottom
                     : kTop};
}

Solid solid_of(const core::Box& b) {
  const Quad half[3] = {length(b.size_x) / 2, length(b.size_y) / 2, length(b.size_z) / 2};
  std::vector<Surface> slabs;
  int flat = -1, flats = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (half[axis] == 0) {
      flat = axis;
      ++flats;
      continue;
    }
    slabs.push_back(slab(axis, -1, half[axis]));
    slabs.push_back(slab(axis, 1, half[axis]));
  }
  if (flats > 1) return {};
  return flats == 1 ? sheet(slab(flat, 1, 0), slabs) : convex(slabs);
}

/// The sweep 0 ... angle about z: its two half-planes, and a test whether it contains a point.
struct Sweep {
  Quad angle, end_x, end_y;

  explicit Sweep(float value) : angle(core::sweep_angle(value)), end_x(cosq(angle)), end_y(sinq(angle)) {}
  bool whole() const { return angle == Quad(core::kFullTurn); }
  bool holds(const QuadVec& p) const {
    if (whole()) return true;
    const bool behind_start = p.y >= 0, before_end = p.x * end_y - p.y * end_x >= 0;
    return angle <= kQuadPi ? behind_start && before_end : behind_start || before_end;
  }
  void add_ends(std::vector<Surface>& surfaces) const {
    if (whole()) return;
    surfaces.push_back({[](const Coordinates& p) { return Polynomial(-1) * p.y; }, kBottom});
    surfaces.push_back({[x = end_x, y = end_y](const Coordinates& p) { return x * p.y - y * p.x; }, kTop});
  }
};

Solid solid_of(const core::CircularTorus& t) {
  const Quad major = length(t.major_radius), tube = length(t.tube_radius);
  const Sweep sweep(t.angle);
  if (tube == 0) return {};
  const auto in_disc = [=](const QuadVec& p) {
    const Quad off = hypotq(p.x, p.y) - major;
    return off * off + p.z * p.z <= tube * tube;
  };
  Solid solid;
  if (sweep.angle == 0) {  // a disc in the plane y = 0; only the half-plane x >= 0 is swept
    solid.surfaces = {{[](const Coordinates& p) { return Polynomial(-1) * p.y; }, kBottom}};
    solid.inside = [=](const QuadVec& p) { return p.x >= 0 && in_disc({p.x, 0, p.z}); };
    solid.sheet = true;
    return solid;
  }
  solid.surfaces.push_back({[=](const Coordinates& p) {
                              const Polynomial across = p.x * p.x + p.y * p.y;
                              const Polynomial k = across + p.z * p.z + (major - tube) * (major + tube);
                              return k * k - 4 * major * major * across;
                            },
                            kSide});
  sweep.add_ends(solid.surfaces);
  solid.inside = [=](const QuadVec& p) { return in_disc(p) && sweep.holds(p); };
  return solid;
}

Solid solid_of(const core::RectangularTorus& t) {
  const Quad inner = std::min(length(t.inner_radius), length(t.outer_radius));
  const Quad outer = std::max(length(t.inner_radius), length(t.outer_radius)), half = length(t.height) / 2;
  const Sweep sweep(t.angle);
  if (outer == 0) return {};
  const auto in_ring = [=](const QuadVec& p) {
    const Quad across = p.x * p.x + p.y * p.y;
    return across <= outer * outer && across >= inner * inner;
  };
  Solid solid;
  const int flats = int(inner == outer) + int(half == 0) + int(sweep.angle == 0);
  if (flats > 1) return {};
  solid.sheet = flats == 1;
  if (inner == outer) {
    solid.surfaces = {within_circle(outer)};
    solid.inside = [=](const QuadVec& p) { return fabsq(p.z) <= half && sweep.holds(p); };
  } else if (half == 0) {
    solid.surfaces = {below_z(0)};
    solid.inside = [=](const QuadVec& p) { return in_ring(p) && sweep.holds(p); };
  } else if (sweep.angle == 0) {
    solid.surfaces = {{[](const Coordinates& p) { return Polynomial(-1) * p.y; }, kBottom}};
    solid.inside = [=](const QuadVec& p) { return p.x >= inner && p.x <= outer && fabsq(p.z) <= half; };
  } else {
    solid.surfaces = {within_circle(outer),
                      {[=](const Coordinates& p) { return inner * inner - p.x * p.x - p.y * p.y; }, kSide},
                      above_z(-half),
                      below_z(half)};
    sweep.add_ends(solid.surfaces);
    solid.inside = [=](const QuadVec& p) { return in_ring(p) && fabsq(p.z) <= half && sweep.holds(p); };
  }
  return solid;
}

Solid solid_of(const core::Line&) {
  return {};
}

bool all_finite(const core::Primitive& primitive) {
  const auto values = core::parameters(primitive);
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

/// Radius of a sphere about the local origin that contains the primitive with room to spare.
Quad reach_of(const core::Primitive& primitive) {
  const core::AabbD box = core::bounds(primitive, {});
  return 2 * hypotq(hypotq(std::max(fabs(box.min.x), fabs(box.max.x)), std::max(fabs(box.min.y), fabs(box.max.y))),
                    std::max(fabs(box.min.z), fabs(box.max.z)));
}

/// The gradient of f at p: its slopes along the axes.
QuadVec gradient(const Implicit& f, const QuadVec& p) {
  return {f(along({p, {1, 0, 0}}))[1], f(along({p, {0, 1, 0}}))[1], f(along({p, {0, 0, 1}}))[1]};
}

/// Unit gradient against the ray (entering) or with it (leaving); zero where there is none.
dvec3 outward_normal(const Implicit& f, const QuadVec& p, const QuadVec& direction, bool entering) {
  const QuadVec g = gradient(f, p);
  const Quad size = sqrtq(dot(g, g));
  if (!(size > 0)) return dvec3(0.0);
  const bool turned = (dot(g, direction) > 0) == entering;
  return to_double((turned ? -1 / size : 1 / size) * g);
}

struct Candidate {
  Quad s;
  const Surface* surface;
};

std::vector<Candidate> candidates(const Solid& solid, const QuadRay& local, Quad low, Quad high) {
  std::vector<Candidate> result;
  const Coordinates line = along(local);
  for (const Surface& surface : solid.surfaces) {
    const Roots found = roots(surface.f(line), low, high);
    for (int i = 0; i < found.count; ++i) result.push_back({found.at[std::size_t(i)], &surface});
  }
  std::sort(result.begin(), result.end(), [](const Candidate& a, const Candidate& b) { return a.s < b.s; });
  return result;
}

}  // namespace

QuadRay in_item_frame(const core::Affine& world_from_item, const core::Ray& ray) {
  const QuadVec x(world_from_item.linear[0]), y(world_from_item.linear[1]), z(world_from_item.linear[2]);
  const QuadVec rows[3] = {cross(y, z), cross(z, x), cross(x, y)};
  const Quad determinant = dot(x, rows[0]);
  if (determinant == 0) return {};
  const auto transformed = [&](const QuadVec& v) {
    return (1 / determinant) * QuadVec(dot(rows[0], v), dot(rows[1], v), dot(rows[2], v));
  };
  return {transformed(QuadVec(ray.origin) - QuadVec(world_from_item.origin)), transformed(QuadVec(ray.direction))};
}

struct ReferenceSolid::Surfaces : Solid {};

ReferenceSolid::ReferenceSolid(const core::Primitive& primitive) {
  if (!all_finite(primitive)) return;
  Solid solid = std::visit([](const auto& p) { return solid_of(p); }, primitive);
  if (solid.surfaces.empty()) return;
  surfaces_ = std::make_shared<const Surfaces>(Surfaces{std::move(solid)});
  reach_ = reach_of(primitive);
}

std::vector<Crossing> ReferenceSolid::crossings(const QuadRay& ray) const {
  std::vector<Crossing> crossings;
  const Quad square = dot(ray.direction, ray.direction);
  if (!surfaces_ || !(square > 0 && finiteq(square)) || !finiteq(dot(ray.origin, ray.origin))) return crossings;
  const Solid& solid = *surfaces_;

  // Moves the origin to the point closest to the centre, so that a far origin costs no digits.
  const Quad start = -dot(ray.origin, ray.direction) / square;
  const QuadRay local{ray.origin + start * ray.direction, ray.direction};
  const Quad room = (reach_ - sqrtq(dot(local.origin, local.origin))) * reach_ / square;
  if (!(room > 0)) return crossings;
  const Quad end = 2 * sqrtq(room);
  const std::vector<Candidate> found = candidates(solid, local, -end, end);

  const auto point = [&](Quad s) { return local.origin + s * local.direction; };
  const auto add = [&](const Candidate& c, bool entering) {
    crossings.push_back(
        {start + c.s, outward_normal(c.surface->f, point(c.s), local.direction, entering), c.surface->face});
  };
  if (solid.sheet) {
    for (const Candidate& c : found) {
      if (!solid.inside(point(c.s))) continue;
      add(c, true);
      add(c, false);
    }
    return crossings;
  }
  bool inside = false;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Quad next = i + 1 < found.size() ? found[i + 1].s : end;
    if (solid.inside(point((found[i].s + next) / 2)) == inside) continue;
    inside = !inside;
    add(found[i], inside);
  }
  return crossings;
}

std::vector<Crossing> reference_crossings(const core::Primitive& primitive, const QuadRay& ray) {
  return ReferenceSolid(primitive).crossings(ray);
}

Neighbours neighbours(const ReferenceSolid& solid, const QuadRay& ray, double band) {
  constexpr int kDirections = 16;
  const QuadVec& d = ray.direction;
  const Quad size = sqrtq(dot(d, d));
  if (!(size > 0)) return {};
  const QuadVec side = cross(d, fabsq(d.x) < size / 2 ? QuadVec(1, 0, 0) : QuadVec(0, 1, 0));
  const QuadVec u = (1 / sqrtq(dot(side, side))) * side, v = (1 / size) * cross(u, d);
  Neighbours result;
  for (int i = 0; i < 2 * kDirections; ++i) {
    const double angle = 2.0 * double(kQuadPi) * (i % kDirections) / kDirections;
    const Quad step = i < kDirections ? Quad(band) : Quad(band) / 4;
    const QuadVec moved = ray.origin + step * (Quad(std::cos(angle)) * u + Quad(std::sin(angle)) * v);
    result.push_back(solid.crossings({moved, d}));
  }
  return result;
}

bool near_tie(const std::vector<Crossing>& crossings, const Neighbours& neighbours) {
  const auto same_face = [](const Crossing& a, const Crossing& b) { return a.face == b.face; };
  return std::any_of(neighbours.begin(), neighbours.end(), [&](const std::vector<Crossing>& there) {
    return !std::equal(crossings.begin(), crossings.end(), there.begin(), there.end(), same_face);
  });
}

double normal_spread(const std::vector<Crossing>& crossings, const Neighbours& neighbours) {
  double spread = 0.0;
  for (const std::vector<Crossing>& there : neighbours) {
    if (there.size() != crossings.size()) continue;
    for (std::size_t i = 0; i < there.size(); ++i)
      spread = std::max(spread, angle_between(there[i].normal, crossings[i].normal));
  }
  return spread;
}

double angle_between(const dvec3& found, const dvec3& expected) {
  if (expected == dvec3(0.0)) return 0.0;
  const double length = glm::length(found);
  if (!(length > 0.0)) return double(kQuadPi);
  return 2.0 * std::asin(std::min(1.0, 0.5 * glm::length(found / length - glm::normalize(expected))));
}

}  // namespace sightline::bench
