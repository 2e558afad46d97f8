#include "sightline/gpuprims/internal/packing.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <variant>

#include "sightline/gpuprims/internal/joints.h"
#include "sightline/gpuprims/internal/mesh_builder.h"

namespace sightline::gpuprims {
namespace {

using core::length_of;

using core::dvec3;

std::uint32_t word(double v) {
  return std::bit_cast<std::uint32_t>(float(v));
}

Texel texel(double x, double y, double z, double w) {
  return {word(x), word(y), word(z), word(w)};
}

/// The local frame of a record: its axes and origin in the primitive's own frame.
struct Frame {
  core::dmat3 axes{1.0};
  dvec3 origin{0.0};
};

Frame scaled(const dvec3& size, const dvec3& origin = dvec3(0.0)) {
  Frame frame;
  for (int i = 0; i < 3; ++i) frame.axes[i][i] = size[i];
  frame.origin = origin;
  return frame;
}

/// Rotated by `angle` about z.
Frame turned(double size, double angle) {
  const double c = size * std::cos(angle), s = size * std::sin(angle);
  return {core::dmat3(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, size), dvec3(0.0)};
}

/// The four texels all kinds share.
void pack_head(const PackedItem& item, const Frame& frame, double extra, std::span<Texel> out) {
  const core::dmat3 linear(item.placement.linear), m = linear * frame.axes;
  const dvec3 o = dvec3(item.placement.origin) + linear * frame.origin;
  out[0] = texel(m[0].x, m[0].y, m[0].z, m[1].x);
  out[1] = texel(m[1].y, m[1].z, m[2].x, m[2].y);
  out[2] = texel(m[2].z, o.x, o.y, o.z);
  out[3] = {item.placement.chunk, item.id, item.material, word(extra)};
}

/// Shapes with numbers beyond this are not drawn: float cannot hold the squares.
constexpr double kFarBeyond = 1e18;
/// A snout whose height is less than this part of its other lengths counts as one without height.
constexpr double kFlattest = 1e-12;

/// Writes a record that shows nothing.
void pack_nothing(const PackedItem& item, std::span<Texel> out) {
  std::fill(out.begin(), out.end(), Texel{});
  pack_head(item, scaled(dvec3(0.0)), 0.0, out);
}

/// A shape thinner than this part of its greatest length is drawn with this thickness. Ray casting needs a volume, and
/// float still tells its two sides apart.
constexpr double kThinnest = 1e-7;

void pack_shape(const core::Cylinder& c, const PackedItem& item, std::span<Texel> out) {
  const double radius = length_of(c.radius);
  if (radius == 0.0) return pack_nothing(item, out);
  pack_head(item, scaled(dvec3(radius)), length_of(c.height) / radius, out);
}

/// Half the sweep of a torus slice in the form of its shader: (first, 1 when closed, cos, sin).
Texel sweep_texel(double first, double angle) {
  return texel(first, angle == core::kFullTurn ? 1.0 : 0.0, std::cos(0.5 * angle), std::sin(0.5 * angle));
}

void pack_shape(const core::CircularTorus& t, const PackedItem& item, std::span<Texel> out) {
  const double major = length_of(t.major_radius), tube_radius = length_of(t.tube_radius),
               angle = core::sweep_angle(t.angle);
  if (tube_radius == 0.0) return pack_nothing(item, out);  // without thickness nothing shows
  const double unit = std::max(major, tube_radius);
  pack_head(item, turned(unit, 0.5 * angle), tube_radius / unit, out);
  out[4] = sweep_texel(major / unit, angle);
}

void pack_shape(const core::RectangularTorus& t, const PackedItem& item, std::span<Texel> out) {
  const double a = length_of(t.inner_radius), b = length_of(t.outer_radius), angle = core::sweep_angle(t.angle);
  const double outer = std::max(a, b);
  if (outer == 0.0) return pack_nothing(item, out);
  pack_head(item, turned(outer, 0.5 * angle), length_of(t.height) / outer, out);
  out[4] = sweep_texel(std::min(a, b) / outer, angle);
}

void pack_shape(const core::Pyramid& p, const PackedItem& item, std::span<Texel> out) {
  const double bottom_x = length_of(p.bottom_x), bottom_y = length_of(p.bottom_y), top_x = length_of(p.top_x),
               top_y = length_of(p.top_y), height = length_of(p.height);
  const double unit = std::max({bottom_x, bottom_y, top_x, top_y, height});
  if (unit == 0.0) return pack_nothing(item, out);
  pack_head(item, scaled(dvec3(unit)), std::max(height / unit, kThinnest), out);
  const double half = 0.5 / unit;
  out[4] = texel(bottom_x * half, bottom_y * half, top_x * half, top_y * half);
  out[5] = texel(p.offset_x / unit, p.offset_y / unit, 0.0, 0.0);
}

void pack_shape(const core::Snout& s, const PackedItem& item, std::span<Texel> out) {
  const double bottom = length_of(s.bottom_radius), top = length_of(s.top_radius), height = length_of(s.height);
  const double unit = std::max(bottom, top);
  if (unit == 0.0) return pack_nothing(item, out);
  if (height <=
      kFlattest * (unit + std::abs(double(s.offset_x)) + std::abs(double(s.offset_y)))) {  // the larger end's disc
    const double side = top > bottom ? 0.5 : -0.5;
    pack_head(item, scaled(dvec3(unit), side * dvec3(s.offset_x, s.offset_y, 0.0)), 0.0, out);
    out[4] = texel(1.0, 1.0, 0.0, 0.0);
    out[5] = texel(0.0, 0.0, 0.0, 0.0);
    out[6] = texel(0.0, 0.0, -kFarBeyond, kFarBeyond);
    return;
  }
  pack_head(item, scaled(dvec3(unit)), height / unit, out);
  const core::EndRange below = core::bottom_end_range(s), above = core::top_end_range(s);
  const double low = std::min(-0.5 * height + below.min, 0.5 * height + above.min);
  const double high = std::max(-0.5 * height + below.max, 0.5 * height + above.max);
  out[4] = texel(bottom / unit, top / unit, s.offset_x / unit, s.offset_y / unit);
  out[5] = texel(std::tan(double(s.bottom_shear_x)), std::tan(double(s.bottom_shear_y)),
                 std::tan(double(s.top_shear_x)), std::tan(double(s.top_shear_y)));
  out[6] = texel(low / unit, high / unit, below.limited ? (-0.5 * height + below.min) / unit : -kFarBeyond,
                 above.limited ? (0.5 * height + above.max) / unit : kFarBeyond);
}

/// Half a ball, stretched along z: a cap whose height is the ball's radius.
void pack_shape(const core::EllipticalDish& d, const PackedItem& item, std::span<Texel> out) {
  const double radius = length_of(d.base_radius), height = length_of(d.height);
  if (radius == 0.0) return pack_nothing(item, out);
  pack_head(item, scaled(dvec3(radius, radius, std::max(height, kThinnest * radius))), 1.0, out);
}

void pack_shape(const core::SphericalDish& d, const PackedItem& item, std::span<Texel> out) {
  const double radius = length_of(d.base_radius), height = length_of(d.height);
  if (radius == 0.0 && height == 0.0) return pack_nothing(item, out);
  if (height < radius) {
    pack_head(item, scaled(dvec3(radius)), std::max(height / radius, kThinnest), out);
    return;
  }
  const double ball = 0.5 * (radius * (radius / height) + height);
  pack_head(item, scaled(dvec3(ball), dvec3(0.0, 0.0, height - ball)), height / ball, out);
}

void pack_shape(const core::Sphere& s, const PackedItem& item, std::span<Texel> out) {
  pack_head(item, scaled(dvec3(0.5 * length_of(s.diameter))), 2.0, out);
}

void pack_shape(const core::Box& b, const PackedItem& item, std::span<Texel> out) {
  const dvec3 size(length_of(b.size_x), length_of(b.size_y), length_of(b.size_z));
  const double thinnest = kThinnest * std::max({size.x, size.y, size.z});
  pack_head(item, scaled(glm::max(size, dvec3(thinnest))), 0.0, out);
}

void pack_shape(const core::Line& l, const PackedItem& item, std::span<Texel> out) {
  pack_head(item, scaled(dvec3(double(l.to) - l.from, 1.0, 1.0), dvec3(l.from, 0.0, 0.0)), 0.0, out);
}

/// Whether all numbers of a record's shape, which follow its placement, are small enough to compute with.
bool sane(std::span<const Texel> record) {
  const auto within = [](std::uint32_t w) { return std::abs(double(std::bit_cast<float>(w))) <= kFarBeyond; };
  if (!within(record[3][3])) return false;
  for (const Texel& texel : record.subspan(4))
    if (!std::all_of(texel.begin(), texel.end(), within)) return false;
  return true;
}

/// Whether a linear map leaves a solid no volume that floats can tell from none. Shaders may round so that the volume
/// that they compute is not 0.
bool is_singular(const core::mat3& linear) {
  constexpr double kRounding = 1e-15;  // of a determinant in double
  const core::dmat3 m(linear);
  return std::abs(glm::determinant(m)) <= kRounding * glm::length(m[0]) * glm::length(m[1]) * glm::length(m[2]);
}

}  // namespace

void pack(core::Kind kind, std::span<const float> parameters, const PackedItem& item, std::span<Texel> out) {
  assert(out.size() == std::size_t(texels_per_item(kind)));
  if (int(kind) >= core::kPrimitiveKindCount) return pack_head(item, {}, 0.0, out);
  if (!all_finite(parameters)) return pack_nothing(item, out);
  if (kind != core::Kind::kLine && is_singular(item.placement.linear)) return pack_nothing(item, out);
  std::visit([&](const auto& shape) { pack_shape(shape, item, out); }, core::make_primitive(kind, parameters));
  if (!sane(out)) pack_nothing(item, out);
}

std::uint32_t material_row(const core::Snapshot& snapshot, core::Slot slot) {
  const std::uint32_t material = snapshot.material(slot);
  return material == core::kNone ? 0u : (material + 1) & kMaterialMask;
}

std::uint32_t material_word(const core::Snapshot& snapshot, const Joints& joints, core::Slot slot) {
  const Ends covered = joints.covered(snapshot, slot);
  std::uint32_t word = material_row(snapshot, slot);
  if ((covered & kBottomEnd) != 0) word |= kBottomOpen;
  if ((covered & kTopEnd) != 0) word |= kTopOpen;
  if (snapshot.vacant(slot)) word |= kVacant;
  return word;
}

void pack(const core::Snapshot& snapshot, core::Slot slot, std::uint32_t material, std::span<Texel> out) {
  const core::Kind kind = snapshot.kind(slot);
  const core::KindItems& items = snapshot.of_kind(kind);
  const std::uint32_t i = snapshot.index_in_kind(slot);
  std::span<const float> parameters;
  if (int(kind) < core::kPrimitiveKindCount) {
    const auto n = std::size_t(core::parameter_count(kind));
    parameters = std::span(items.parameters).subspan(i * n, n);
  }
  pack(kind, parameters, {items.placements[i], to_index(snapshot.item(slot)), material}, out);
}

}  // namespace sightline::gpuprims
