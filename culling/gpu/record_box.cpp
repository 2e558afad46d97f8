#include "sightline/culling/gpu/record_box.h"

#include <array>
#include <bit>
#include <cmath>

namespace sightline::culling {
namespace {

using core::dvec3;
using gpuscene::BatchKind;

class Record {
 public:
  explicit Record(std::span<const gpuprims::Texel> texels) : texels_(texels) {}
  double operator()(int texel, int word) const {
    return double(std::bit_cast<float>(texels_[std::size_t(texel)][std::size_t(word)]));
  }
  /// Row `axis` of the placement's linear part.
  dvec3 row(int axis) const {
    const auto entry = [&](int column) { return (*this)((3 * column + axis) / 4, (3 * column + axis) % 4); };
    return {entry(0), entry(1), entry(2)};
  }
  double origin(int axis) const { return (*this)(2, axis + 1); }

 private:
  std::span<const gpuprims::Texel> texels_;
};

/// Along one direction u: least and greatest dot(u, p) of the shape, and the sum of absolute terms, of |u| or a bit
/// more.
struct Extent {
  double least = 0.0, most = 0.0, terms = 0.0;
};

double xy(const dvec3& u) {
  return std::hypot(u.x, u.y);
}

Extent of_cylinder(const Record& r, const dvec3& u, const dvec3& a) {
  const double height = r(3, 3), reach = xy(u) + 0.5 * height * std::abs(u.z);
  return {-reach, reach, a.x + a.y + 0.5 * height * a.z};
}

Extent of_box(const Record&, const dvec3& u, const dvec3& a) {
  const double reach = 0.5 * (std::abs(u.x) + std::abs(u.y) + std::abs(u.z));
  return {-reach, reach, a.x + a.y + a.z};
}

/// gpuprims/shaders/sphere_cap.glsl has what a cap of height c is.
double cap_support(double c, const dvec3& u) {
  const double all = glm::length(u), cut = 1.0 - c;
  if (c >= 1.0) return u.z >= cut * all ? all : cut * u.z + std::sqrt(std::max(0.0, (1.0 - cut) * (1.0 + cut))) * xy(u);
  const double fall = u.z > 0.0 ? (u.x * u.x + u.y * u.y) / (all + u.z) : all - u.z;  // |u| - u.z
  const double ball_fall = 0.5 * (1.0 + c * c) * fall;                                // times c
  return c * c * all >= ball_fall ? c * u.z + ball_fall / c : xy(u);
}

Extent of_cap(const Record& r, const dvec3& u, const dvec3& a) {
  const double c = r(3, 3);
  return {-cap_support(c, -u), cap_support(c, u), 2.0 * (a.x + a.y + a.z)};
}

/// Least and greatest of dot(u, e) over the unit vectors e of a sweep.
std::array<double, 2> sweep_extent(const Record& r, const dvec3& u) {
  const double whole = xy(u), c = r(4, 2), s = r(4, 3);
  if (r(4, 1) > 0.0) return {-whole, whole};
  const auto in_sweep = [&](double x) { return x * s >= std::abs(u.y) * c; };  // without the shader's slack
  const double across = std::abs(u.y) * s;
  return {in_sweep(-u.x) ? -whole : u.x * c - across, in_sweep(u.x) ? whole : u.x * c + across};
}

Extent of_torus(const Record& r, const dvec3& u, const dvec3& a) {
  const double major = r(4, 0), tube = r(3, 3);
  const auto [least, most] = sweep_extent(r, u);
  const double disc_least = tube * std::hypot(least, u.z), disc_most = tube * std::hypot(most, u.z);
  return {std::min(major * least - disc_least, major * most - disc_most),
          std::max(major * least + disc_least, major * most + disc_most), 2.0 * (major + tube) * (a.x + a.y + a.z)};
}

Extent of_rectangular_torus(const Record& r, const dvec3& u, const dvec3& a) {
  const double inner = r(4, 0), rise = 0.5 * r(3, 3) * std::abs(u.z);
  const auto [least, most] = sweep_extent(r, u);
  return {std::min(least, inner * least) - rise, std::max(most, inner * most) + rise,
          2.0 * (a.x + a.y) + 0.5 * r(3, 3) * a.z};
}

Extent of_pyramid(const Record& r, const dvec3& u, const dvec3& a) {
  const double lean = 0.5 * (u.x * r(5, 0) + u.y * r(5, 1) + u.z * r(3, 3));
  const double bottom = r(4, 0) * std::abs(u.x) + r(4, 1) * std::abs(u.y);
  const double top = r(4, 2) * std::abs(u.x) + r(4, 3) * std::abs(u.y);
  const double terms = (r(4, 0) + r(4, 2) + std::abs(r(5, 0))) * a.x + (r(4, 1) + r(4, 3) + std::abs(r(5, 1))) * a.y;
  return {std::min(-lean - bottom, lean - top), std::max(bottom - lean, top + lean), terms + r(3, 3) * a.z};
}

Extent of_snout(const Record& r, const dvec3& u, const dvec3& a) {
  const double height = r(3, 3), bottom = r(4, 0), top = r(4, 1), x = r(4, 2), y = r(4, 3);
  const auto circle = [&](double z) -> Extent {
    const double part = z / height, centre = part * (u.x * x + u.y * y) + z * u.z;
    const double reach = std::max(0.0, bottom + (top - bottom) * (0.5 + part)) * xy(u);
    const double terms = std::abs(part) * (a.x * std::abs(x) + a.y * std::abs(y)) + std::abs(z) * a.z +
                         (bottom + top) * (2.0 + std::abs(part)) * (a.x + a.y);
    return {centre - reach, centre + reach, 2.0 * terms};
  };
  const Extent below = circle(r(6, 0)), above = circle(r(6, 1));
  return {std::min(below.least, above.least), std::max(below.most, above.most), std::max(below.terms, above.terms)};
}

using ExtentOf = Extent (*)(const Record&, const dvec3&, const dvec3&);

ExtentOf extent_of(BatchKind kind) {
  switch (kind) {
    case BatchKind::kCylinder:
      return of_cylinder;
    case BatchKind::kSnout:
      return of_snout;
    case BatchKind::kCircularTorus:
      return of_torus;
    case BatchKind::kSphereCap:
      return of_cap;
    case BatchKind::kRectangularTorus:
      return of_rectangular_torus;
    case BatchKind::kPyramid:
      return of_pyramid;
    case BatchKind::kBox:
      return of_box;
    default:
      return nullptr;
  }
}

}  // namespace

bool record_box_contains(BatchKind kind, std::span<const gpuprims::Texel> record, const core::vec3& chunk,
                         const core::Aabb& box) {
  const ExtentOf extent = extent_of(kind);
  const Record r(record);
  if (!extent || (kind == BatchKind::kSnout && !(r(3, 3) > 0.0))) return false;  // a snout's slope is per height
  for (int axis = 0; axis < 3; ++axis) {
    const dvec3 u = r.row(axis), a = glm::abs(u) + 0x1p-43;
    const double place = double(chunk[axis]), offset = r.origin(axis), centre = place + offset;
    const Extent shape = extent(r, u, a);
    const double half_margin = 0.5 * (0x1p-20 * (std::abs(place) + std::abs(offset)) + 0x1p-17 * shape.terms);
    constexpr double kLargest = 1e18;  // whose square is a float
    const bool contained = double(box.min[axis]) >= centre + shape.least - half_margin &&
                           double(box.max[axis]) <= centre + shape.most + half_margin;
    if (!contained || !(std::abs(centre) + shape.terms < kLargest)) return false;
  }
  return true;
}

}  // namespace sightline::culling
