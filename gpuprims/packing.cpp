#include "sightline/gpuprims/packing.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace sightline::gpuprims {
namespace {

using core::dvec3;

std::uint32_t word(double v) {
  return std::bit_cast<std::uint32_t>(float(v));
}

Texel texel(double x, double y, double z, double w) {
  return {word(x), word(y), word(z), word(w)};
}

/// The four texels all kinds share; the placement's columns are scaled, its origin moved by `local_origin`.
void pack_head(const PackedItem& item, const dvec3& scale, const dvec3& local_origin, double extra,
               std::span<Texel> out) {
  const core::dmat3 linear(item.placement.linear);
  const dvec3 x = linear[0] * scale.x, y = linear[1] * scale.y, z = linear[2] * scale.z;
  const dvec3 o = dvec3(item.placement.origin) + linear * local_origin;
  out[0] = texel(x.x, x.y, x.z, y.x);
  out[1] = texel(y.y, y.z, z.x, z.y);
  out[2] = texel(z.z, o.x, o.y, o.z);
  out[3] = {item.placement.chunk, item.id, item.material, word(extra)};
}

double length(float v) {
  return std::abs(double(v));
}

void pack_cylinder(std::span<const float> p, const PackedItem& item, std::span<Texel> out) {
  const double radius = length(p[0]);
  pack_head(item, dvec3(radius), dvec3(0.0), radius > 0.0 ? length(p[1]) / radius : 0.0, out);
}

void pack_torus(std::span<const float> p, const PackedItem& item, std::span<Texel> out) {
  const double major = length(p[0]), tube = length(p[1]), angle = length(p[2]);
  const double unit = std::max(major, tube), inverse = unit > 0.0 ? 1.0 / unit : 0.0;
  // Without a tube there is nothing to see, not even a hoop.
  pack_head(item, dvec3(tube > 0.0 && angle > 0.0 ? unit : 0.0), dvec3(0.0), tube * inverse, out);
  out[4] = texel(major * inverse, angle, std::cos(angle), std::sin(angle));
}

void pack_snout(std::span<const float> p, const PackedItem& item, std::span<Texel> out) {
  const core::Snout s = std::get<core::Snout>(core::make_primitive(core::Kind::kSnout, p));
  const double bottom = length(s.bottom_radius), top = length(s.top_radius), height = length(s.height);
  const double unit = std::max(bottom, top), inverse = unit > 0.0 ? 1.0 / unit : 0.0;
  pack_head(item, dvec3(unit), dvec3(0.0), height * inverse, out);
  const core::EndRange below = core::bottom_end_range(s), above = core::top_end_range(s);
  const double low = std::min(-0.5 * height + below.min, 0.5 * height + above.min);
  const double high = std::max(-0.5 * height + below.max, 0.5 * height + above.max);
  out[4] = texel(bottom * inverse, top * inverse, s.offset_x * inverse, s.offset_y * inverse);
  out[5] =
      texel(std::tan(s.bottom_shear_x), std::tan(s.bottom_shear_y), std::tan(s.top_shear_x), std::tan(s.top_shear_y));
  out[6] = texel(low * inverse, high * inverse, 0.0, 0.0);
}

/// The unit ball above z = cut, stretched by `radii` about `centre`.
void pack_cap(const PackedItem& item, const dvec3& radii, double centre, double cut, std::span<Texel> out) {
  pack_head(item, radii, dvec3(0.0, 0.0, centre), cut, out);
}

void pack_elliptical_dish(double radius, double height, const PackedItem& item, std::span<Texel> out) {
  // A dish of no height is a disc: drawn a thousandth of its radius thick, which float still resolves.
  const double shown = std::max(height, 1e-3 * radius);
  pack_cap(item, dvec3(radius, radius, shown), 0.0, 0.0, out);
}

void pack_spherical_dish(double radius, double height, const PackedItem& item, std::span<Texel> out) {
  if (height < 1e-3 * radius) return pack_elliptical_dish(radius, height, item, out);
  const double sphere = (radius * radius + height * height) / (2.0 * height);
  pack_cap(item, dvec3(sphere), height - sphere, (sphere - height) / sphere, out);
}

void pack_line(std::span<const float> p, const PackedItem& item, std::span<Texel> out) {
  pack_head(item, dvec3(double(p[1]) - p[0], 1.0, 1.0), dvec3(p[0], 0.0, 0.0), 0.0, out);
}

}  // namespace

void pack(core::Kind kind, std::span<const float> parameters, const PackedItem& item, std::span<Texel> out) {
  assert(out.size() == std::size_t(texels_per_item(kind)));
  switch (kind) {
    case core::Kind::kCylinder:
      return pack_cylinder(parameters, item, out);
    case core::Kind::kCircularTorus:
      return pack_torus(parameters, item, out);
    case core::Kind::kSnout:
      return pack_snout(parameters, item, out);
    case core::Kind::kSphere:
      return pack_cap(item, dvec3(0.5 * length(parameters[0])), 0.0, -1.0, out);
    case core::Kind::kEllipticalDish:
      return pack_elliptical_dish(length(parameters[0]), length(parameters[1]), item, out);
    case core::Kind::kSphericalDish:
      return pack_spherical_dish(length(parameters[0]), length(parameters[1]), item, out);
    case core::Kind::kLine:
      return pack_line(parameters, item, out);
    case core::Kind::kBox:
      return pack_head(item, dvec3(length(parameters[0]), length(parameters[1]), length(parameters[2])), dvec3(0.0),
                       0.0, out);
    default:
      return pack_head(item, dvec3(1.0), dvec3(0.0), 0.0, out);
  }
}

}  // namespace sightline::gpuprims
