#include "sightline/analysis/measure/amounts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <variant>
#include <vector>

#include "sightline/core/surface_area.h"

namespace sightline::measure {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec2;
using core::dvec3;
using core::length_of;
using core::Primitive;

constexpr double kPi = std::numbers::pi, kTurn = 2.0 * std::numbers::pi;
constexpr double kLastDigits = 1e-13;  // of an amount
constexpr double kUnknown = std::numeric_limits<double>::infinity();

struct Amount {
  double value = 0.0, error = 0.0;
};

// --- sums over surfaces ----------------------------------------------------------------------------------------------

/// Nodes and weights of Gauss and Legendre's rule on 0 … 1.
std::vector<dvec2> gauss(int count) {
  std::vector<dvec2> rule(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (count + 0.5)), slope = 1.0;
    for (int step = 0; step < 20; ++step) {  // Newton's method on Legendre's polynomial
      double last = 1.0, value = x;
      for (int k = 2; k <= count; ++k) {
        const double next = ((2 * k - 1) * x * value - (k - 1) * last) / k;
        last = value, value = next;
      }
      slope = count * (x * value - last) / (x * x - 1.0);
      const double change = value / slope;
      x -= change;
      if (std::fabs(change) < 1e-16) break;
    }
    rule[std::size_t(i)] = {0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)};
  }
  return rule;
}

/// Integrates over 0 … 1 in both arguments, of which the first goes round once where `round`. Doubles the places until
/// the sum stays.
template <class Value>
Amount integral(const Value& value, bool round) {
  constexpr int kFirst = 16, kMost = 256;
  Amount sum{0.0, kUnknown};
  for (int count = kFirst; count <= kMost; count *= 2) {
    const std::vector<dvec2> rule = gauss(count);
    std::vector<dvec2> along = rule;
    if (round) {
      along.resize(std::size_t(4 * count));
      for (std::size_t i = 0; i < along.size(); ++i)
        along[i] = {double(i) / double(along.size()), 1.0 / double(along.size())};
    }
    double now = 0.0;
    for (const dvec2& u : along)
      for (const dvec2& v : rule) now += u.y * v.y * value(u.x, v.x);
    sum = {now, std::fabs(now - sum.value) + kLastDigits * std::fabs(now)};
    if (sum.error <= 4.0 * kLastDigits * std::fabs(now)) break;
  }
  return sum;
}

/// A part of a surface: a point and its derivatives by both arguments, which go from 0 to 1.
struct Patch {
  struct At {
    dvec3 by_u, by_v;
  };
  std::function<At(double u, double v)> at;
  bool round = true;  ///< u goes round once
};

dvec3 around(double angle) {
  return {std::cos(angle), std::sin(angle), 0.0};
}
dvec3 around_slope(double angle) {
  return {-std::sin(angle), std::cos(angle), 0.0};
}

/// The disc within a closed contour, as seen from a point of its plane: `contour` gives it less that point.
Patch disc(std::function<std::pair<dvec3, dvec3>(double angle)> contour) {
  return {[contour](double u, double v) -> Patch::At {
    const auto [point, slope] = contour(kTurn * u);
    return {kTurn * v * slope, point};
  }};
}

Patch circle(double radius) {
  return disc([radius](double angle) { return std::pair(radius * around(angle), radius * around_slope(angle)); });
}

Patch quadrangle(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d) {
  return {[=](double u, double v) -> Patch::At {
            return {(1 - v) * (b - a) + v * (c - d), (1 - u) * (d - a) + u * (c - b)};
          },
          false};
}

// --- surfaces of primitives ------------------------------------------------------------------------------------------

using Patches = std::vector<Patch>;

/// A snout by its circles: at 0 … 1 of its height the centre lies at `lean` and the radius is `bottom` + `widening`.
struct Cone {
  double bottom, widening, height;
  dvec2 lean, bottom_slope, top_slope;

  explicit Cone(const core::Snout& s)
      : bottom(length_of(s.bottom_radius)),
        widening(length_of(s.top_radius) - bottom),
        height(s.height),
        lean(s.offset_x, s.offset_y),
        bottom_slope(std::tan(double(s.bottom_shear_x)), std::tan(double(s.bottom_shear_y))),
        top_slope(std::tan(double(s.top_shear_x)), std::tan(double(s.top_shear_y))) {}

  bool slanted() const { return bottom_slope != dvec2(0.0) || top_slope != dvec2(0.0); }
  /// Where the line at a share of the radius, in a direction, meets the plane of an end, and the derivative by the
  /// angle. The planes are those of core::Snout.
  dvec2 low(double angle, double share) const { return end(bottom_slope, bottom, angle, share); }
  dvec2 high(double angle, double share) const {
    return end(top_slope, bottom + widening, angle, share) + dvec2(1.0, 0.0);
  }
  /// Whether both ends are closed contours and do not cross.
  bool regular() const {
    constexpr int kChecked = 1024;
    for (const dvec2& slope : {bottom_slope, top_slope})
      if (!(std::fabs(height - glm::dot(slope, lean)) > (1.0 + 1e-9) * std::fabs(widening) * glm::length(slope)))
        return false;
    for (int i = 0; i < kChecked; ++i)
      if (low(kTurn * i / kChecked, 1.0).x > high(kTurn * i / kChecked, 1.0).x) return false;
    return true;
  }
  dvec3 point(double t, double angle) const {
    return dvec3(t * lean, t * height) + (bottom + t * widening) * around(angle);
  }

 private:
  dvec2 end(const dvec2& slope, double radius, double angle, double share) const {
    const double along = share * glm::dot(slope, dvec2(around(angle))),
                 by_angle = share * glm::dot(slope, dvec2(around_slope(angle)));
    const double rise = height - glm::dot(slope, lean) - widening * along;
    return {radius * along / rise, radius * by_angle * (rise + widening * along) / (rise * rise)};
  }
};

Patches patches_of(const core::Pyramid& p) {
  std::array<std::array<dvec3, 4>, 2> corners;
  for (int end = 0; end < 2; ++end) {
    const double sign = end == 0 ? -0.5 : 0.5, x = 0.5 * double(end == 0 ? p.bottom_x : p.top_x),
                 y = 0.5 * double(end == 0 ? p.bottom_y : p.top_y);
    const dvec3 middle = sign * dvec3(p.offset_x, p.offset_y, p.height);
    for (int i = 0; i < 4; ++i)
      corners[std::size_t(end)][std::size_t(i)] = middle + dvec3(i == 1 || i == 2 ? x : -x, i >= 2 ? y : -y, 0.0);
  }
  const auto& [low, high] = corners;
  Patches patches{quadrangle(low[0], low[1], low[2], low[3]), quadrangle(high[0], high[1], high[2], high[3])};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t next = (i + 1) % 4;
    patches.push_back(quadrangle(low[i], low[next], high[next], high[i]));
  }
  return patches;
}

Patches patches_of(const core::Box& b) {
  return patches_of(core::Pyramid{b.size_x, b.size_y, b.size_x, b.size_y, 0.0f, 0.0f, b.size_z});
}

/// What a line of the plane of radius and height leaves that turns about the axis: `line` gives radius, height and
/// their derivatives.
Patch swept(double sweep, std::function<std::array<double, 4>(double v)> line) {
  return {[=](double u, double v) -> Patch::At {
            const auto [radius, height, radius_slope, height_slope] = line(v);
            (void)height;
            const dvec3 out = around(sweep * u);
            return {sweep * radius * around_slope(sweep * u), radius_slope * out + dvec3(0, 0, height_slope)};
          },
          sweep >= core::kFullTurn};
}
Patch swept_segment(double sweep, const dvec2& from, const dvec2& to) {
  return swept(sweep, [=](double v) -> std::array<double, 4> {
    const dvec2 at = glm::mix(from, to, v);
    return {at.x, at.y, to.x - from.x, to.y - from.y};
  });
}

Patches patches_of(const core::RectangularTorus& t) {
  const double sweep = core::sweep_angle(t.angle), half = 0.5 * length_of(t.height);
  const double inner = std::min(length_of(t.inner_radius), length_of(t.outer_radius)),
               outer = std::max(length_of(t.inner_radius), length_of(t.outer_radius));
  Patches patches;
  const dvec2 corners[] = {{inner, -half}, {outer, -half}, {outer, half}, {inner, half}};
  for (std::size_t i = 0; i < 4; ++i) patches.push_back(swept_segment(sweep, corners[i], corners[(i + 1) % 4]));
  if (sweep >= core::kFullTurn) return patches;
  for (const double angle : {0.0, sweep}) {
    const dvec3 out = around(angle), up(0.0, 0.0, half);
    patches.push_back(quadrangle(inner * out - up, outer * out - up, outer * out + up, inner * out + up));
  }
  return patches;
}

/// Half the angle of the tube's circle that lies on its own side of the axis.
double kept_angle(double major, double tube) {
  return major >= tube ? kPi : std::acos(-major / tube);
}

Patches patches_of(const core::CircularTorus& t) {
  const double sweep = core::sweep_angle(t.angle), major = length_of(t.major_radius), tube = length_of(t.tube_radius);
  const double kept = kept_angle(major, tube);
  Patches patches{swept(sweep, [=](double v) -> std::array<double, 4> {
    const double angle = kept * (2.0 * v - 1.0), slope = 2.0 * kept * tube;
    return {major + tube * std::cos(angle), tube * std::sin(angle), -slope * std::sin(angle), slope * std::cos(angle)};
  })};
  if (sweep >= core::kFullTurn) return patches;
  // The circle and, where that is cut off, the chord along the axis.
  for (const double angle : {0.0, sweep}) {
    const dvec3 out = around(angle), up(0.0, 0.0, 1.0);
    patches.push_back({[=](double u, double v) -> Patch::At {
                         const double at = kept * (2.0 * u - 1.0);
                         const dvec3 point = tube * (std::cos(at) * out + std::sin(at) * up),
                                     slope = 2.0 * kept * tube * (-std::sin(at) * out + std::cos(at) * up);
                         return {v * slope, point};
                       },
                       kept == kPi});
    if (kept < kPi) {
      const double side = tube * std::sin(kept);
      const dvec3 axis = -major * out;
      patches.push_back({[=](double, double v) -> Patch::At {
                           return {v * 2.0 * side * up, axis};  // a triangle from the circle's centre to the axis
                         },
                         false});
    }
  }
  return patches;
}

Patches patches_of(const core::EllipticalDish& d) {
  const double radius = length_of(d.base_radius), height = length_of(d.height);
  return {circle(radius), swept(core::kFullTurn, [=](double v) -> std::array<double, 4> {
            const double at = 0.5 * kPi * v;
            return {radius * std::cos(at), height * std::sin(at), -0.5 * kPi * radius * std::sin(at),
                    0.5 * kPi * height * std::cos(at)};
          })};
}

Patches patches_of(const core::SphericalDish& d) {
  const double radius = length_of(d.base_radius), height = length_of(d.height);
  const double sphere = height > 0.0 ? (radius * radius + height * height) / (2.0 * height) : 0.0;
  if (height == 0.0) return {circle(radius), circle(radius)};
  const double most = 2.0 * std::atan2(height, radius);  // angle at the sphere's centre, from the pole to the rim
  return {circle(radius), swept(core::kFullTurn, [=](double v) -> std::array<double, 4> {
            const double at = most * v;
            return {sphere * std::sin(at), sphere * std::cos(at), most * sphere * std::cos(at),
                    -most * sphere * std::sin(at)};
          })};
}

Patches patches_of(const core::Snout& s) {
  const Cone cone(s);
  Patches patches{{[cone](double u, double v) -> Patch::At {
    const double angle = kTurn * u;
    const dvec2 low = cone.low(angle, 1.0), high = cone.high(angle, 1.0);
    const double t = glm::mix(low.x, high.x, v), t_by_angle = glm::mix(low.y, high.y, v);
    const dvec3 by_t = dvec3(cone.lean, cone.height) + cone.widening * around(angle);
    return {kTurn * ((cone.bottom + t * cone.widening) * around_slope(angle) + t_by_angle * by_t),
            (high.x - low.x) * by_t};
  }}};
  for (const bool top : {false, true}) {
    const dvec3 centre = top ? dvec3(cone.lean, cone.height) : dvec3(0.0);
    patches.push_back(disc([=](double angle) {
      const dvec2 end = top ? cone.high(angle, 1.0) : cone.low(angle, 1.0);
      const dvec3 by_t = dvec3(cone.lean, cone.height) + cone.widening * around(angle);
      return std::pair(cone.point(end.x, angle) - centre,
                       (cone.bottom + end.x * cone.widening) * around_slope(angle) + end.y * by_t);
    }));
  }
  return patches;
}

Patches patches_of(const core::Cylinder& c) {
  return patches_of(core::Snout{c.radius, c.radius, c.height, 0, 0, 0, 0, 0, 0});
}

Patches patches_of(const core::Sphere& s) {
  const double radius = 0.5 * length_of(s.diameter);
  return {swept(core::kFullTurn, [=](double v) -> std::array<double, 4> {
    const double at = kPi * (v - 0.5);
    return {radius * std::cos(at), radius * std::sin(at), -kPi * radius * std::sin(at), kPi * radius * std::cos(at)};
  })};
}

Patches patches_of(const core::Line&) {
  return {};
}

Amount summed_area(const Primitive& primitive, const dmat3& linear) {
  Amount sum;
  for (const Patch& patch : std::visit([](const auto& p) { return patches_of(p); }, primitive)) {
    const Amount one = integral(
        [&](double u, double v) {
          const Patch::At at = patch.at(u, v);
          return glm::length(glm::cross(linear * at.by_u, linear * at.by_v));
        },
        patch.round);
    sum.value += one.value;
    sum.error += one.error;
  }
  return sum;
}

// --- formulas --------------------------------------------------------------------------------------------------------

/// By how much a placement scales areas alike, and the share by which it does not: single precision leaves some 1e-7.
/// None where that is more.
std::optional<Amount> area_scale(const dmat3& m) {
  constexpr double kUnequal = 1e-6;
  const double square = (glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2])) / 3.0;
  double off = 0.0;
  for (int i = 0; i < 3; ++i)
    off = std::max({off, std::fabs(glm::dot(m[i], m[i]) - square), std::fabs(glm::dot(m[i], m[(i + 1) % 3]))});
  // Eigenvalues of the squared map differ from their mean by at most three times that (Gershgorin), areas by as much.
  if (!(square > 0.0) || off > kUnequal * square) return std::nullopt;
  return Amount{square, 3.0 * off};
}

/// Half of a spheroid, and its base.
double dish_area(double radius, double height) {
  if (radius == 0.0 || height == 0.0) return (height == 0.0 ? 2.0 : 1.0) * kPi * radius * radius;
  const double ratio = height / radius, excess = std::fabs(1.0 - ratio) * (1.0 + ratio);
  if (excess < 1e-4) {  // the series about a ball, whose next term is 1e-14 of it
    const double x = 1.0 - ratio * ratio;
    return kPi * radius * radius * (1.0 + 2.0 - x * (2.0 / 3.0) - x * x * (2.0 / 15.0) - x * x * x * (2.0 / 35.0));
  }
  const double e = std::sqrt(ratio < 1.0 ? excess : excess / (ratio * ratio));
  const double curved = ratio < 1.0 ? 1.0 + ratio * ratio * std::atanh(e) / e : 1.0 + ratio * std::asin(e) / e;
  return kPi * radius * radius * (1.0 + curved);
}

/// Whether core::surface_area() is exact.
bool has_formula(const Primitive& primitive) {
  if (const auto* snout = std::get_if<core::Snout>(&primitive))
    return snout->offset_x == 0.0f && snout->offset_y == 0.0f && !Cone(*snout).slanted();
  if (const auto* torus = std::get_if<core::CircularTorus>(&primitive))
    return length_of(torus->major_radius) >= length_of(torus->tube_radius);
  return true;
}

Amount area_of(const Primitive& primitive, const dmat3& linear) {
  const auto scale = area_scale(linear);
  if (!scale || !has_formula(primitive)) return summed_area(primitive, linear);
  const auto* dish = std::get_if<core::EllipticalDish>(&primitive);
  const double own =
      dish ? dish_area(length_of(dish->base_radius), length_of(dish->height)) : core::surface_area(primitive);
  return {scale->value * own, (scale->error + kLastDigits * scale->value) * own};
}

Amount exact(double value) {
  return {value, kLastDigits * value};
}

Amount volume_of(const core::Pyramid& p) {
  const auto area = [&](double t) {
    return std::fabs(glm::mix(double(p.bottom_x), double(p.top_x), t) *
                     glm::mix(double(p.bottom_y), double(p.top_y), t));
  };
  return exact(length_of(p.height) * (area(0.0) + 4.0 * area(0.5) + area(1.0)) / 6.0);
}
Amount volume_of(const core::Box& b) {
  return exact(length_of(b.size_x) * length_of(b.size_y) * length_of(b.size_z));
}
Amount volume_of(const core::RectangularTorus& t) {
  const double inner = length_of(t.inner_radius), outer = length_of(t.outer_radius);
  return exact(0.5 * core::sweep_angle(t.angle) * std::fabs(outer - inner) * (outer + inner) * length_of(t.height));
}
Amount volume_of(const core::CircularTorus& t) {
  const double sweep = core::sweep_angle(t.angle), major = length_of(t.major_radius), tube = length_of(t.tube_radius);
  if (major >= tube) return exact(sweep * kPi * tube * tube * major);
  const double chord = std::sqrt((tube - major) * (tube + major)), kept = kept_angle(major, tube);
  return exact(sweep * (major * (tube * tube * kept + major * chord) + 2.0 / 3.0 * chord * chord * chord));
}
Amount volume_of(const core::EllipticalDish& d) {
  return exact(2.0 / 3.0 * kPi * length_of(d.base_radius) * length_of(d.base_radius) * length_of(d.height));
}
Amount volume_of(const core::SphericalDish& d) {
  const double r = length_of(d.base_radius), h = length_of(d.height);
  return exact(kPi * h * (3.0 * r * r + h * h) / 6.0);
}
/// Between the ends, by circles of equal shares of the radius.
Amount volume_of(const core::Snout& s) {
  const Cone cone(s);
  const auto thirds = [&](double low, double high) {
    const double a = cone.bottom + low * cone.widening, b = cone.bottom + high * cone.widening;
    return (high - low) * (a * a + a * b + b * b) / 3.0;
  };
  if (!cone.slanted()) return exact(kPi * std::fabs(cone.height) * thirds(0.0, 1.0));
  return integral(
      [&](double u, double v) {
        return kTurn * v * std::fabs(cone.height) * thirds(cone.low(kTurn * u, v).x, cone.high(kTurn * u, v).x);
      },
      true);
}
Amount volume_of(const core::Cylinder& c) {
  return exact(kPi * length_of(c.radius) * length_of(c.radius) * length_of(c.height));
}
Amount volume_of(const core::Sphere& s) {
  return exact(kPi / 6.0 * std::pow(length_of(s.diameter), 3));
}
Amount volume_of(const core::Line&) {
  return {};
}

bool is_finite(const Primitive& primitive, const Affine& place) {
  const auto values = core::parameters(primitive);
  return core::is_finite(place) && std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

}  // namespace

core::Expected<Amounts> amounts(const Primitive& primitive, const Affine& world_from_item) {
  if (!is_finite(primitive, world_from_item))
    return core::fail("measure: " + std::string(core::name_of(core::kind_of(primitive))) +
                      ": expected finite parameters and a finite placement");
  const auto* snout = std::get_if<core::Snout>(&primitive);
  if (snout && Cone(*snout).slanted() && !Cone(*snout).regular()) return Amounts{0.0, kUnknown, 0.0, kUnknown, 0};
  const Amount area = area_of(primitive, world_from_item.linear),
               volume = std::visit([](const auto&p) { return volume_of(p); }, primitive);
  const double scale = std::fabs(glm::determinant(world_from_item.linear));
  return Amounts{area.value, area.error, scale * volume.value, scale * volume.error,
                 std::holds_alternative<core::Line>(primitive) ? std::size_t(1) : 0};
}

core::Expected<Amounts> amounts(const core::Mesh& mesh, const Affine& world_from_item) {
  if (auto valid = core::validate(mesh); !valid) return tl::unexpected(valid.error());
  if (!core::is_finite(world_from_item)) return core::fail("measure: mesh: expected a finite placement");
  Amounts sum;
  const bool closed = core::enclosure(mesh) != core::Enclosure::kNothing;
  double bulk = 0.0;  // what rounding is a share of
  const auto corner = [&](std::size_t i) {
    return world_from_item.linear * (dvec3(mesh.positions[mesh.indices[i]]) - dvec3(mesh.positions[mesh.indices[0]]));
  };
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const dvec3 a = corner(i), b = corner(i + 1), c = corner(i + 2), normal = glm::cross(b - a, c - a);
    if (!std::isfinite(glm::dot(normal, normal))) continue;  // as measure::Item leaves it out
    sum.area += 0.5 * glm::length(normal);
    sum.volume += glm::dot(a, normal) / 6.0;
    bulk += std::fabs(glm::dot(a, normal)) / 6.0;
  }
  sum.area_error = kLastDigits * sum.area;
  sum.volume = closed ? std::fabs(sum.volume) : 0.0;
  sum.volume_error = closed ? kLastDigits * bulk : 0.0;
  sum.open = closed ? 0 : 1;
  return sum;
}

core::Expected<Amounts> amounts(const core::Scene& scene, std::span<const core::ItemId> items) {
  Amounts sum;
  core::Expected<void> done;
  scene.for_each_state(items, [&](core::ItemId item, const core::Scene::ItemState& state) {
    if (!done) return;
    const auto one = int(scene.kind(item)) < core::kPrimitiveKindCount
                         ? amounts(scene.primitive(item), state.world_from_item)
                         : amounts(scene.mesh(scene.mesh_of(item)), state.world_from_item);
    if (!one) return void(done = tl::unexpected(one.error()));
    sum.area += one->area;
    sum.area_error += one->area_error;
    sum.volume += one->volume;
    sum.volume_error += one->volume_error;
    sum.open += one->open;
  });
  return done ? core::Expected<Amounts>(sum) : tl::unexpected(done.error());
}

}  // namespace sightline::measure
