#include "sightline/culling/gpu/record_box.h"

#include <bit>
#include <cmath>
#include <numbers>

namespace sightline::culling {
namespace {

using core::dvec2;
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

double cap_support(double cut, const dvec3& u) {
  const double all = glm::length(u);
  return u.z >= cut * all ? all : cut * u.z + std::sqrt(std::max(0.0, (1.0 - cut) * (1.0 + cut))) * xy(u);
}

Extent of_cap(const Record& r, const dvec3& u, const dvec3& a) {
  const double cut = r(3, 3);
  return {-cap_support(cut, -u), cap_support(cut, u), 2.0 * (a.x + a.y + a.z)};
}

Extent of_torus(const Record& r, const dvec3& u, const dvec3& a) {
  const double major = r(4, 0), tube = r(3, 3), angle = r(4, 1);
  const dvec2 end(r(4, 2), r(4, 3));
  const auto in_sweep = [&](const dvec2& v) {  // without the shader's slack
    const bool after_start = v.y >= 0.0, before_end = end.x * v.y - end.y * v.x <= 0.0;
    if (angle >= 2.0 * std::numbers::pi) return true;
    return angle <= std::numbers::pi ? after_start && before_end : after_start || before_end;
  };
  const double whole = xy(u), at_end = u.x * end.x + u.y * end.y;
  const double least = in_sweep({-u.x, -u.y}) ? -whole : std::min(u.x, at_end);
  const double most = in_sweep({u.x, u.y}) ? whole : std::max(u.x, at_end);
  const double disc_least = tube * std::hypot(least, u.z), disc_most = tube * std::hypot(most, u.z);
  return {std::min(major * least - disc_least, major * most - disc_most),
          std::max(major * least + disc_least, major * most + disc_most), 2.0 * (major + tube) * (a.x + a.y + a.z)};
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
