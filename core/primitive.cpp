#include "sightline/core/primitive.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

namespace sightline::core {
namespace {

constexpr std::array<std::string_view, kKindCount> kKindNames = {
    "pyramid",        "box",   "rectangular_torus", "circular_torus", "elliptical_dish",
    "spherical_dish", "snout", "cylinder",          "sphere",         "line",
    "facet_group",    "mesh"};

// Parameters are read back as floats in declaration order, so every alternative must be nothing but floats.
template <class T>
constexpr int float_count() {
  static_assert(std::is_standard_layout_v<T> && std::is_trivially_copyable_v<T> && sizeof(T) % sizeof(float) == 0);
  return int(sizeof(T) / sizeof(float));
}

template <std::size_t... I>
constexpr std::array<int, kPrimitiveKindCount> parameter_counts(std::index_sequence<I...>) {
  return {float_count<std::variant_alternative_t<I, Primitive>>()...};
}
constexpr auto kParameterCounts = parameter_counts(std::make_index_sequence<kPrimitiveKindCount>());

double xy_length(const dvec3& u) {
  return std::hypot(u.x, u.y);
}

/// Largest and smallest dot(unit xy direction of a sweep angle, u) over the arc 0 … angle, up to kFullTurn.
struct ArcRange {
  double min, max;
};
ArcRange arc_range(const dvec3& u, double angle) {
  const double length_xy = xy_length(u);
  if (angle == kFullTurn) return {-length_xy, length_xy};
  const double end = u.x * std::cos(angle) + u.y * std::sin(angle);
  ArcRange range{std::min(u.x, end), std::max(u.x, end)};
  double towards = std::atan2(u.y, u.x);
  if (towards < 0.0) towards += kFullTurn;
  const double away = towards >= std::numbers::pi ? towards - std::numbers::pi : towards + std::numbers::pi;
  if (towards <= angle) range.max = length_xy;
  if (away <= angle) range.min = -length_xy;
  return range;
}

double support_of(const Pyramid& p, const dvec3& u) {
  const double lean = 0.5 * (u.x * p.offset_x + u.y * p.offset_y + u.z * length_of(p.height));
  const double bottom = 0.5 * (length_of(p.bottom_x) * std::abs(u.x) + length_of(p.bottom_y) * std::abs(u.y)) - lean;
  const double top = 0.5 * (length_of(p.top_x) * std::abs(u.x) + length_of(p.top_y) * std::abs(u.y)) + lean;
  return std::max(bottom, top);
}

double support_of(const Box& b, const dvec3& u) {
  return 0.5 * (length_of(b.size_x) * std::abs(u.x) + length_of(b.size_y) * std::abs(u.y) +
                length_of(b.size_z) * std::abs(u.z));
}

double support_of(const RectangularTorus& t, const dvec3& u) {
  const ArcRange w = arc_range(u, sweep_angle(t.angle));
  const double inner = length_of(t.inner_radius), outer = length_of(t.outer_radius);
  const double radial = std::max({inner * w.min, inner * w.max, outer * w.min, outer * w.max});
  return radial + 0.5 * length_of(t.height) * std::abs(u.z);
}

double support_of(const CircularTorus& t, const dvec3& u) {
  // Over one disc of the sweep the support is R w + r sqrt(w^2 + u_z^2): convex in w, so an end of w's range has the
  // maximum.
  const ArcRange w = arc_range(u, sweep_angle(t.angle));
  const auto disc = [&](double along) {
    return length_of(t.major_radius) * along + length_of(t.tube_radius) * std::hypot(along, u.z);
  };
  return std::max(disc(w.min), disc(w.max));
}

double support_of(const EllipticalDish& d, const dvec3& u) {
  const double base = length_of(d.base_radius) * xy_length(u);
  return u.z <= 0.0 ? base : std::hypot(base, length_of(d.height) * u.z);
}

double support_of(const SphericalDish& d, const dvec3& u) {
  const double r = length_of(d.base_radius), h = length_of(d.height);
  const double base = r * xy_length(u);
  if (h == 0.0) return base;
  const double radius = (r * r + h * h) / (2.0 * h), norm = glm::length(u);
  // u| - u.z without cancellation. For a flat dish, radius / r is about as large as r / h.
  const double fall = u.z > 0.0 ? (u.x * u.x + u.y * u.y) / (norm + u.z) : norm - u.z;
  const bool on_cap = h * norm >= radius * fall;  // the sphere's extreme point lies above the base
  return on_cap ? h * u.z + radius * fall : base;
}

double support_of(const Snout& s, const dvec3& u) {
  const double h = length_of(s.height), rb = length_of(s.bottom_radius), rt = length_of(s.top_radius),
               disc = xy_length(u);
  const dvec3 end{0.5 * s.offset_x, 0.5 * s.offset_y, 0.5 * h};
  const EndRange bottom = bottom_end_range(s), top = top_end_range(s);
  if (h == 0.0) {
    const double slant_b = std::max(u.z * bottom.min, u.z * bottom.max);
    const double slant_t = std::max(u.z * top.min, u.z * top.max);
    return std::max(rb * disc - glm::dot(u, end) + slant_b, rt * disc + glm::dot(u, end) + slant_t);
  }
  // The solid lies within the hull of the cone's circles at the lowest and highest point of each end contour.
  const auto circle = [&](double z) {
    const double fraction = 0.5 + z / h;
    return z * (u.x * s.offset_x + u.y * s.offset_y) / h + u.z * z + std::max(0.0, rb + (rt - rb) * fraction) * disc;
  };
  const double zb = -0.5 * h, zt = 0.5 * h;
  return std::max({circle(zb + bottom.min), circle(zb + bottom.max), circle(zt + top.min), circle(zt + top.max)});
}

double support_of(const Cylinder& c, const dvec3& u) {
  return length_of(c.radius) * xy_length(u) + 0.5 * length_of(c.height) * std::abs(u.z);
}

double support_of(const Sphere& s, const dvec3& u) {
  return 0.5 * length_of(s.diameter) * glm::length(u);
}

double support_of(const Line& l, const dvec3& u) {
  return std::max(u.x * l.from, u.x * l.to);
}

EndRange end_range(const Snout& s, double radius, double shear_x, double shear_y) {
  constexpr double kNearlyOpen = 1e-3;  // contours a thousand radii long come from bad data
  const double h = length_of(s.height);
  const dvec2 m(std::tan(shear_x), std::tan(shear_y));
  const double steep = std::hypot(m.x, m.y);
  if (steep == 0.0) return {};
  double lean = 0.0, slope = 0.0;
  if (h > 0.0) {
    lean = (m.x * s.offset_x + m.y * s.offset_y) / h;
    slope = (length_of(s.top_radius) - length_of(s.bottom_radius)) / h;
  }
  const double up = 1.0 - lean - slope * steep, down = 1.0 - lean + slope * steep;
  if (!(up > kNearlyOpen && down > kNearlyOpen)) return {-h, h, true};
  return {-radius * steep / down, radius * steep / up, false};
}

}  // namespace

std::string_view name_of(Kind kind) {
  return kKindNames[std::size_t(kind)];
}

std::string_view faces::name_of(Face face) {
  constexpr std::string_view kNames[] = {"side",  "bottom", "top",   "bottom_level", "top_level", "inner",    "below",
                                         "above", "min_x",  "max_x", "min_y",        "max_y",     "triangle", "cut"};
  return kNames[face];
}

int parameter_count(Kind kind) {
  assert(int(kind) < kPrimitiveKindCount);
  return kParameterCounts[std::size_t(kind)];
}

std::span<const float> parameters(const Primitive& primitive) {
  return std::visit(
      [](const auto& p) {
        return std::span<const float>(reinterpret_cast<const float*>(&p), float_count<std::decay_t<decltype(p)>>());
      },
      primitive);
}

namespace {
template <std::size_t I = 0>
Primitive make_alternative(std::size_t index, std::span<const float> values) {
  if constexpr (I < kPrimitiveKindCount) {
    if (index != I) return make_alternative<I + 1>(index, values);
    std::variant_alternative_t<I, Primitive> p;
    std::memcpy(&p, values.data(), sizeof(p));
    return p;
  } else {
    assert(false && "not a primitive kind");
    return Line{0.0f, 0.0f};
  }
}
}  // namespace

Primitive make_primitive(Kind kind, std::span<const float> values) {
  assert(int(kind) < kPrimitiveKindCount && values.size() >= std::size_t(parameter_count(kind)));
  return make_alternative(std::size_t(kind), values);
}

bool is_degenerate(const Primitive& primitive) {
  struct Visitor {
    bool operator()(const Pyramid& p) const {
      const bool no_bottom = p.bottom_x == 0 || p.bottom_y == 0, no_top = p.top_x == 0 || p.top_y == 0;
      // A wedge may shrink to a line at one end only.
      return p.height == 0 || (no_bottom && no_top && (p.bottom_x + p.top_x == 0 || p.bottom_y + p.top_y == 0));
    }
    bool operator()(const Box& b) const { return b.size_x == 0 || b.size_y == 0 || b.size_z == 0; }
    bool operator()(const RectangularTorus& t) const {
      return std::abs(t.inner_radius) == std::abs(t.outer_radius) || t.height == 0 || t.angle == 0;
    }
    bool operator()(const CircularTorus& t) const { return t.tube_radius == 0 || t.angle == 0; }
    bool operator()(const EllipticalDish& d) const { return d.base_radius == 0 || d.height == 0; }
    bool operator()(const SphericalDish& d) const { return d.height == 0; }
    bool operator()(const Snout& s) const { return s.height == 0 || (s.bottom_radius == 0 && s.top_radius == 0); }
    bool operator()(const Cylinder& c) const { return c.radius == 0 || c.height == 0; }
    bool operator()(const Sphere& s) const { return s.diameter == 0; }
    bool operator()(const Line& l) const { return l.from == l.to; }
  };
  return std::visit(Visitor{}, primitive);
}

double sweep_angle(float angle) {
  constexpr double kNearlyFull = 6.283185;
  const double swept = length_of(angle);
  return swept >= kNearlyFull ? kFullTurn : swept;
}

EndRange bottom_end_range(const Snout& s) {
  return end_range(s, length_of(s.bottom_radius), s.bottom_shear_x, s.bottom_shear_y);
}

EndRange top_end_range(const Snout& s) {
  return end_range(s, length_of(s.top_radius), s.top_shear_x, s.top_shear_y);
}

double support(const Primitive& primitive, const dvec3& direction) {
  return std::visit([&](const auto& p) { return support_of(p, direction); }, primitive);
}

AabbD bounds(const Primitive& primitive, const Affine& world_from_item) {
  constexpr double kPad = 16.0 * std::numeric_limits<double>::epsilon();
  // No point lies farther from the local origin than the sum of all parameters (except for slanted ends). Terms of that
  // size may cancel in a support value but not in its rounding error. A parameter that is NaN makes the box NaN.
  double reach = 0.0;
  for (const float value : parameters(primitive)) reach += length_of(value);
  const dmat3 rows = glm::transpose(world_from_item.linear);
  AabbD box;
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = world_from_item.origin[axis];
    const double above = support(primitive, rows[axis]), below = support(primitive, -rows[axis]);
    const double row = std::abs(rows[axis].x) + std::abs(rows[axis].y) + std::abs(rows[axis].z);
    const double pad = kPad * (std::abs(origin) + std::max(std::abs(above), std::abs(below)) + reach * row);
    box.min[axis] = origin - below - pad;
    box.max[axis] = origin + above + pad;
  }
  return box;
}

}  // namespace sightline::core
