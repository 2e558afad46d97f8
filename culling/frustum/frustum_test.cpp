// Error bounds. u = 2^-53 and v = 2^-24 are the unit roundoffs of double and float, gamma_k(u) = k u / (1 - k u)
// (N. Higham, "Accuracy and Stability of Numerical Algorithms", 2002, lemma 3.1: k roundings in a row change a product
// of factors by a relative error of at most gamma_k). n, d: the computed double plane after scaling; n*, d*: the exact
// one; o: origin; p: corner of a float box; M: the extent's largest |coordinate| per axis. The exact value is
//     V = n* . (o + p) + d*.
//
// 1. Extraction. w +- x is one rounding per component: |n_i - n*_i| <= u |n_i|, |d - d*| <= u |d|, however much
//    cancels. Scaling by 2^k changes nothing but what underflows: at most 2^-1075 per component. An overflow makes the
//    plane non-finite, and it is dropped.
// 2. Shift. D = ((n_x o_x + n_y o_y) + n_z o_z) + d takes at most 4 roundings per term, with 1. 5:
//    |D - (n* . o + d*)| <= gamma_5(u) S with S = sum |n_i o_i| + |d|. Hence also |D| <= (1 + gamma_5) S.
// 3. Evaluation in double, s_d = ((n_x p_x + n_y p_y) + n_z p_z) + D: at most 4 roundings per product, 1 for D, and the
//    error of n: gamma_5(u) sum |n_i p_i| + u |D|.
//    Together |s_d - V| <= gamma_7(u) (S + sum |n_i p_i|) + underflow <= e(p) := 8u (S + sum |n_i p_i|) + tiny; the
//    slack between gamma_7 and 8u covers the rounding of e itself. An item fails only when s_d < -e, that is V < 0.
//    Underflow: 2^-1075 from scaling times |o_i| + |p_i|, and at most 2^-1075 for each of 6 products and for d:
//    tiny = 2^-1070 (sum (|o_i| + M_i) + 4).
// 4. Float. Rounding n and D to float is one more rounding per factor; products take 1 + 1 + 3 = 5, D takes 2:
//    |s - (n . p + D)| <= gamma_5(v) (sum |n_i| M_i + |D|) + 2^-150 (sum M_i + 4), the last part for underflow.
//    B = 5.01 v (...) + 2^-149 (sum M_i + 4) + 2 e(M), rounded up: s < -B implies V < 0 and s >= B implies V > 0.
//
// Range. max |n_i| lies in [1/32, 1/16), so |n . p| < 3/16 FLT_MAX for any float p: no sum overflows as long as
// |D| <= 2^127. Where the exact offset is surely larger it decides alone, for every box: the plane is always passed or
// never. What remains above the limit has an error e that large, and is clamped to it. A clamp from below only raises s
// and s_d: whatever still fails, failed before. A clamp from above leaves s >= 2^127 - 3/16 FLT_MAX > 0: nothing fails.
// So clamping never drops a box; nor does a band beyond the float range, which becomes FLT_MAX: no s lies below its
// negative. Scaling may overflow d alone; with |n . o| < 2^900 (kUnusable otherwise) its sign decides, too.
#include "sightline/culling/frustum/frustum_test.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "sightline/core/internal/section_rounding.h"

namespace sightline::culling {
namespace {

constexpr double kUnitDouble = 0x1p-53, kUnitFloat = 0x1p-24;
constexpr double kOffsetLimit = 0x1p127, kOriginLimit = 0x1p900;

bool inverted(const core::Aabb& b) {
  return b.min.x > b.max.x || b.min.y > b.max.y || b.min.z > b.max.z;
}

/// Largest |coordinate| per axis.
core::dvec3 largest_coordinate(const core::Aabb& extent) {
  if (extent.empty()) return core::dvec3(0.0);
  return glm::max(glm::abs(core::dvec3(extent.min)), glm::abs(core::dvec3(extent.max)));
}

/// Two powers of two, to multiply by one after the other: their product may lie beyond the range.
struct Scale {
  double first, second;
};

/// The scale that brings `largest` > 0 into [1/32, 1/16). Multiplying by its two factors rounds a number at most once.
Scale scale_for(double largest) {
  constexpr std::uint64_t kFractionBits = 52, kBias = 1023;
  const std::uint64_t exponent = std::bit_cast<std::uint64_t>(largest) >> kFractionBits;
  // largest = f 2^(exponent - 1022), 1/2 <= f < 1, unless it is denormal.
  constexpr std::uint64_t kSum = kBias + 1022 - 4;
  if (exponent > 0 && exponent < kSum) return {std::bit_cast<double>((kSum - exponent) << kFractionBits), 1.0};
  int power = 0;
  std::frexp(largest, &power);
  const int shift = -power - 4;
  return {std::ldexp(1.0, shift / 2), std::ldexp(1.0, shift - shift / 2)};
}

/// Smallest float >= x for x > 2^-149, FLT_MAX beyond the float range: core::round_up without its calls.
float band_above(double x) {
  if (!(x < double(core::Aabb::kFar))) return std::numeric_limits<float>::max();
  const float f = static_cast<float>(x);
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(f) + (double(f) < x));
}

float corner(const core::Aabb& box, int axis) {
  return axis < 3 ? box.min[axis] : box.max[axis - 3];
}

float evaluate_at(const FloatPlane& plane, const std::uint8_t (&axis)[3], const core::Aabb& box) {
  return ((plane.normal[0] * corner(box, axis[0]) + plane.normal[1] * corner(box, axis[1])) +
          plane.normal[2] * corner(box, axis[2])) +
         plane.offset;
}

}  // namespace

/// What the bounds contribute to every plane.
struct CullPlanes::Sizes {
  explicit Sizes(const core::ItemBounds& bounds) : origin(bounds.origin), largest(largest_coordinate(bounds.extent())) {
    double largest_sum = 4.0;
    for (int i = 0; i < 3; ++i) {
      largest_sum += std::abs(origin[i]) + largest[i];
      extents += largest[i];
    }
    tiny = 0x1p-1070 * largest_sum;
  }
  core::dvec3 origin, largest;
  double extents = 4.0, tiny;
};

CullPlanes::CullPlanes(const core::View& view, const core::ItemBounds& bounds) {
  const Sizes sizes(bounds);
  add_frustum(view, sizes);
  union_first_ = count_;
  if (!view.sections.empty()) add_sections(view, sizes);
  all_ = (PlaneMask(1) << union_first_) - 1;
  if (union_first_ < count_) all_ |= kUnionPlanes;
}

void CullPlanes::add_frustum(const core::View& view, const Sizes& sizes) {
  for (const core::Plane& plane : core::frustum_planes(view.clip_from_world(), view.clip_depth())) {
    const Kind kind = add(plane, sizes);
    if (kind == Kind::kNever || (kind == Kind::kNoNormal && plane.offset < 0.0)) nothing_visible_ = true;
  }
}

void CullPlanes::add_sections(const core::View& view, const Sizes& sizes) {
  assert(view.sections.size() <= core::kMaxSectionPlanes);
  const std::size_t count = std::min(view.sections.size(), core::kMaxSectionPlanes);
  const bool in_union = view.section_mode == core::SectionMode::kUnion;
  bool some_never = false, some_give_up = view.sections.size() > count;
  for (std::size_t i = 0; i < count; ++i) {
    const Kind kind = add(core::moved_outwards(view.sections[i], sizes.origin, sizes.largest), sizes);
    some_never |= kind == Kind::kNever;
    some_give_up |= kind == Kind::kAlways || kind == Kind::kUnusable;
  }
  if (!in_union) {
    union_first_ = count_;
    nothing_visible_ |= some_never;
  } else if (some_give_up) {
    // Without one of its planes an intersection grows, but a union shrinks: there the whole union is given up.
    count_ = union_first_;
  } else {
    nothing_visible_ |= some_never && union_first_ == count_;
  }
}

CullPlanes::Kind CullPlanes::add(const core::Plane& plane, const Sizes& sizes) {
  const core::dvec3 n = plane.normal;
  if (!core::is_finite(n) || !std::isfinite(plane.offset)) return Kind::kUnusable;
  const double largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
  if (largest == 0.0) return Kind::kNoNormal;

  const Scale scale = scale_for(largest);
  const auto scaled = [=](double x) { return x * scale.first * scale.second; };
  DoublePlane& e = exact_[std::size_t(count_)];
  const double d = scaled(plane.offset);
  double offset = 0.0, magnitude = 0.0, size = 0.0;
  for (int i = 0; i < 3; ++i) {
    e.normal[i] = scaled(n[i]);
    const double at_origin = e.normal[i] * sizes.origin[i];
    offset += at_origin;
    magnitude += std::abs(at_origin);
    size += std::abs(e.normal[i]) * sizes.largest[i];
  }
  if (!(magnitude < kOriginLimit)) return Kind::kUnusable;
  if (std::isinf(d)) return d > 0.0 ? Kind::kAlways : Kind::kNever;
  offset += d;
  magnitude += std::abs(d);
  const double double_error = 8.0 * kUnitDouble * (magnitude + size) + sizes.tiny;
  if (std::abs(offset) - double_error > kOffsetLimit) return offset > 0.0 ? Kind::kAlways : Kind::kNever;
  e.offset = std::clamp(offset, -kOffsetLimit, kOffsetLimit);
  e.magnitude = magnitude;
  e.tiny = sizes.tiny;

  FloatPlane& f = planes_[std::size_t(count_)];
  for (int i = 0; i < 3; ++i) {
    f.normal[i] = static_cast<float>(e.normal[i]);
    const int positive = e.normal[i] >= 0.0 ? 3 : 0;
    f.p_axis[i] = std::uint8_t(i + positive);
    f.n_axis[i] = std::uint8_t(i + 3 - positive);
  }
  f.offset = static_cast<float>(e.offset);
  const double float_error = 5.01 * kUnitFloat * (size + std::abs(e.offset)) + 0x1p-149 * sizes.extents;
  f.band = band_above(float_error + 2.0 * double_error);
  ++count_;
  return Kind::kPlane;
}

bool CullPlanes::passes(int plane, const core::Aabb& box) const {
  const FloatPlane& f = planes_[std::size_t(plane)];
  const float s = evaluate_at(f, f.p_axis, box);
  if (s >= f.band) return true;
  if (s < -f.band) return false;
  return passes_in_double(plane, box);
}

bool CullPlanes::passes_in_double(int plane, const core::Aabb& box) const {
  const DoublePlane& e = exact_[std::size_t(plane)];
  double s = 0.0, magnitude = e.magnitude;
  for (int i = 0; i < 3; ++i) {
    const double term = e.normal[i] * double(e.normal[i] >= 0.0 ? box.max[i] : box.min[i]);
    s += term;
    magnitude += std::abs(term);
  }
  s += e.offset;
  return !(s < -(8.0 * kUnitDouble * magnitude + e.tiny));
}

bool CullPlanes::visible(const core::Aabb& box, PlaneMask mask) const {
  if (inverted(box)) return false;
  for (PlaneMask m = mask & (kUnionPlanes - 1); m != 0; m &= m - 1)
    if (!passes(std::countr_zero(m), box)) return false;
  if ((mask & kUnionPlanes) == 0) return true;
  for (int k = union_first_; k < count_; ++k)
    if (passes(k, box)) return true;
  return false;
}

bool CullPlanes::outside(const core::Aabb& box, PlaneMask mask) const {
  const auto surely_outside = [&](const FloatPlane& f) { return evaluate_at(f, f.p_axis, box) < -f.band; };
  for (PlaneMask m = mask & (kUnionPlanes - 1); m != 0; m &= m - 1)
    if (surely_outside(planes_[std::size_t(std::countr_zero(m))])) return true;
  return (mask & kUnionPlanes) != 0 &&
         std::all_of(planes_.begin() + union_first_, planes_.begin() + count_, surely_outside);
}

PlaneMask CullPlanes::remaining(const core::Aabb& box, PlaneMask mask) const {
  const auto surely_inside = [&](const FloatPlane& f) { return evaluate_at(f, f.n_axis, box) >= f.band; };
  PlaneMask left = mask;
  for (PlaneMask m = mask & (kUnionPlanes - 1); m != 0; m &= m - 1)
    if (surely_inside(planes_[std::size_t(std::countr_zero(m))])) left &= ~(PlaneMask(1) << std::countr_zero(m));
  if (std::any_of(planes_.begin() + union_first_, planes_.begin() + count_, surely_inside)) left &= ~kUnionPlanes;
  return left;
}

}  // namespace sightline::culling
