// The view volume in exact arithmetic: the planes that the sixteen doubles of clip_from_world define, in rationals. In
// front of the rationals stands a filter in long double with a forward error bound (an adaptive predicate after
// J. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", 1997): it settles
// what rounding cannot have changed, the rationals all else. conservative_test.cpp holds the one to the other.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gmpxx.h>

#include "sightline/core/aabb.h"
#include "sightline/core/view.h"

namespace sightline::tests {

/// Half-space sum over i < 3 of (a_i + b_i) x_i + (a_3 + b_3) >= 0 of world points x, every coefficient an unevaluated
/// sum of two finite doubles.
struct ExactPlane {
  ExactPlane(const std::array<double, 4>& first, const std::array<double, 4>& second) : a(first), b(second) {
    for (std::size_t i = 0; i < 4; ++i) {
      rounded[i] = static_cast<long double>(a[i]) + b[i];
      exact[i] = mpq_class(a[i]) + mpq_class(b[i]);
    }
  }

  std::array<double, 4> a, b;
  std::array<long double, 4> rounded;  ///< a rounded sum never has the wrong sign
  std::array<mpq_class, 4> exact;

  /// Coordinate of the corner of `box` that is farthest inside.
  float p_vertex(const core::Aabb& box, int axis) const {
    return rounded[std::size_t(axis)] >= 0.0L ? box.max[axis] : box.min[axis];
  }

  /// Sign of the plane at origin + corner in rationals.
  int exact_sign(const core::dvec3& origin, const core::vec3& corner) const {
    mpq_class value = exact[3];
    for (int i = 0; i < 3; ++i) value += exact[std::size_t(i)] * (mpq_class(origin[i]) + mpq_class(double(corner[i])));
    return sgn(value);
  }

  /// The sign where it is certain, 0 where the rationals must decide.
  ///
  /// With u the unit roundoff, n_i and x_i = origin_i + corner_i carry one rounding each, their product one more and
  /// the sums at most three: the value computed is off by at most gamma_6 times the sum of the absolute exact terms,
  /// and that sum is at most (1 - u)^-6 times the one computed here. gamma_6 (1 - u)^-6 < 8 u, with room for the
  /// rounding of the product 8 u * size. No underflow: factors are zero or at least 2^-1074, so products are at least
  /// 2^-2148; no overflow: they are below 2^2051. Where long double has not that range, the filter abstains.
  int filtered_sign(const core::dvec3& origin, const core::vec3& corner) const {
    using Limits = std::numeric_limits<long double>;
    if constexpr (Limits::min_exponent > -4096 || Limits::max_exponent < 4096) return 0;
    long double value = 0.0L, size = 0.0L;
    for (int i = 0; i < 3; ++i) {
      const long double term = rounded[std::size_t(i)] * (static_cast<long double>(origin[i]) + corner[i]);
      value += term;
      size += std::abs(term);
    }
    value += rounded[3];
    size += std::abs(rounded[3]);
    constexpr long double kUnit = Limits::epsilon() / 2.0L;
    if (std::abs(value) <= 8.0L * kUnit * size) return 0;
    return value < 0.0L ? -1 : 1;
  }
};

class ExactVolume {
 public:
  /// Section planes that are not finite are no limit, as CullPlanes promises: they are left out, and a union with one
  /// is given up.
  explicit ExactVolume(const core::View& view) {
    const core::dmat4 m = view.clip_from_world();
    const double near = core::near_depth(view.clip_depth()), far = core::far_depth(view.clip_depth());
    const double sign_of_depth = far > near ? 1.0 : -1.0;
    const auto add = [&](double share_of_w, int row, double sign) {
      std::array<double, 4> w{}, other{};
      for (std::size_t i = 0; i < 4; ++i) {
        w[i] = share_of_w * m[int(i)][3];
        other[i] = sign * m[int(i)][row];
      }
      planes_.emplace_back(w, other);
    };
    for (const int row : {0, 1}) {
      add(1.0, row, 1.0);
      add(1.0, row, -1.0);
    }
    add(-sign_of_depth * near, 2, sign_of_depth);
    add(sign_of_depth * far, 2, -sign_of_depth);
    union_first_ = planes_.size();
    bool given_up = false;
    for (const core::Plane& s : view.sections) {
      if (s.normal == core::dvec3(0.0) && std::isfinite(s.offset)) continue;
      if (core::is_finite(s.normal) && std::isfinite(s.offset))
        planes_.emplace_back(std::array<double, 4>{s.normal.x, s.normal.y, s.normal.z, s.offset},
                             std::array<double, 4>{});
      else
        given_up = true;
    }
    if (view.section_mode == core::SectionMode::kIntersection)
      union_first_ = planes_.size();
    else if (given_up)
      planes_.erase(planes_.begin() + std::ptrdiff_t(union_first_), planes_.end());
  }

  /// The planes of the frustum, then the sections.
  const std::vector<ExactPlane>& planes() const { return planes_; }
  bool has_union() const { return union_first_ < planes_.size(); }

  /// Whether the p-vertex of origin + box is inside every plane (and any of a union): true for every box that meets the
  /// volume.
  bool passes(const core::dvec3& origin, const core::Aabb& box) {
    return !box.empty() && passes([&](const ExactPlane& plane) {
      return sign_at(plane, origin, {plane.p_vertex(box, 0), plane.p_vertex(box, 1), plane.p_vertex(box, 2)});
    });
  }
  /// Overload for a box in double.
  bool passes(const core::AabbD& box) {
    return !box.empty() && passes([&](const ExactPlane& plane) {
      core::dvec3 corner;
      for (int i = 0; i < 3; ++i) corner[i] = plane.rounded[std::size_t(i)] >= 0.0L ? box.max[i] : box.min[i];
      return sign_at(plane, corner, core::vec3(0.0f));
    });
  }

  /// passes(), with planes moved outwards by `tolerance` times the absolute terms that enter their value. Not exact.
  bool nearly_passes(const core::dvec3& origin, const core::Aabb& box, long double tolerance) const {
    const auto near_plane = [&](const ExactPlane& plane) {
      long double value = plane.rounded[3], size = std::abs(value);
      for (int i = 0; i < 3; ++i) {
        const long double n = plane.rounded[std::size_t(i)], at_origin = n * origin[i], p = n * plane.p_vertex(box, i);
        value += at_origin + p;
        size += std::abs(at_origin) + std::abs(p);
      }
      return value >= -tolerance * size;
    };
    const auto first_of_union = planes_.begin() + std::ptrdiff_t(union_first_);
    return std::all_of(planes_.begin(), first_of_union, near_plane) &&
           (!has_union() || std::any_of(first_of_union, planes_.end(), near_plane));
  }

  /// Whether the closed sets share a point (not for unions). Their intersection lies within the box, so if it is not
  /// empty it has a vertex: three planes of either that meet in a point which all of them contain.
  bool meets(const core::dvec3& origin, const core::Aabb& box) const {
    std::vector<std::array<mpq_class, 4>> halves;
    halves.reserve(planes_.size() + 6);
    for (const ExactPlane& p : planes_) halves.push_back(p.exact);
    for (int i = 0; i < 3; ++i) {
      for (const int side : {1, -1}) {
        std::array<mpq_class, 4> h;
        h[std::size_t(i)] = side;
        h[3] = mpq_class(-side) * (mpq_class(origin[i]) + mpq_class(double(side > 0 ? box.min[i] : box.max[i])));
        halves.push_back(h);
      }
    }
    for (std::size_t i = 0; i < halves.size(); ++i)
      for (std::size_t j = i + 1; j < halves.size(); ++j)
        for (std::size_t k = j + 1; k < halves.size(); ++k)
          if (is_common_vertex(halves, i, j, k)) return true;
    return false;
  }

  std::uint64_t decided_in_rationals = 0;  ///< planes, over all calls of passes()

 private:
  template <class SignAtPVertex>
  bool passes(const SignAtPVertex& sign) {
    for (std::size_t k = 0; k < union_first_; ++k)
      if (sign(planes_[k]) < 0) return false;
    for (std::size_t k = union_first_; k < planes_.size(); ++k)
      if (sign(planes_[k]) >= 0) return true;
    return !has_union();
  }

  int sign_at(const ExactPlane& plane, const core::dvec3& origin, const core::vec3& corner) {
    if (const int sign = plane.filtered_sign(origin, corner); sign != 0) return sign;
    ++decided_in_rationals;
    return plane.exact_sign(origin, corner);
  }

  static bool is_common_vertex(const std::vector<std::array<mpq_class, 4>>& h, std::size_t i, std::size_t j,
                               std::size_t k) {
    const auto minor = [&](std::size_t p, std::size_t q, std::size_t r) -> mpq_class {
      return h[i][p] * (h[j][q] * h[k][r] - h[j][r] * h[k][q]) - h[i][q] * (h[j][p] * h[k][r] - h[j][r] * h[k][p]) +
             h[i][r] * (h[j][p] * h[k][q] - h[j][q] * h[k][p]);
    };
    const mpq_class w = minor(0, 1, 2);
    if (sgn(w) == 0) return false;
    // Cramer's rule for n . x = -d.
    const mpq_class x = -minor(3, 1, 2), y = -minor(0, 3, 2), z = -minor(0, 1, 3);
    for (const auto& plane : h) {
      const mpq_class value = plane[0] * x + plane[1] * y + plane[2] * z + plane[3] * w;
      if (sgn(value) * sgn(w) < 0) return false;
    }
    return true;
  }

  std::vector<ExactPlane> planes_;
  std::size_t union_first_ = 0;  // planes from here on form the union
};

}  // namespace sightline::tests
