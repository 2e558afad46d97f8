// The view volume in exact arithmetic: the planes that the sixteen doubles of clip_from_world define, in rationals,
// with a long-double filter in front that settles all but the closest calls.
#pragma once

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
/// sum of two doubles.
struct ExactPlane {
  std::array<double, 4> a{}, b{};
  /// Sign of the exact coefficient: a rounded sum never has the wrong sign.
  double rounded(std::size_t i) const { return a[i] + b[i]; }
  mpq_class coefficient(std::size_t i) const { return mpq_class(a[i]) + mpq_class(b[i]); }
};

class ExactVolume {
 public:
  explicit ExactVolume(const core::View& view) {
    const core::dmat4 m = view.clip_from_world();
    const bool reversed = view.clip_depth() == core::ClipDepth::kReversedZeroToOne;
    const auto plane = [&](bool with_w, int row, double sign) {
      ExactPlane p;
      for (std::size_t i = 0; i < 4; ++i) {
        p.a[i] = with_w ? m[int(i)][3] : 0.0;
        p.b[i] = sign * m[int(i)][row];
      }
      return p;
    };
    all_ = {plane(true, 0, 1.0),
            plane(true, 0, -1.0),
            plane(true, 1, 1.0),
            plane(true, 1, -1.0),
            reversed ? plane(true, 2, -1.0) : plane(true, 2, 1.0),
            reversed ? plane(false, 2, 1.0) : plane(true, 2, -1.0)};
    for (const core::Plane& s : view.sections) {
      if (s.normal == core::dvec3(0.0)) continue;
      ExactPlane p;
      for (int i = 0; i < 3; ++i) p.a[std::size_t(i)] = s.normal[i];
      p.a[3] = s.offset;
      (view.section_mode == core::SectionMode::kUnion ? any_ : all_).push_back(p);
    }
  }

  const std::vector<ExactPlane>& planes() const { return all_; }
  bool has_union() const { return !any_.empty(); }

  /// Whether the p-vertex of origin + box is inside every plane (and any of a union): true for every box that meets the
  /// volume.
  bool passes(const core::dvec3& origin, const core::Aabb& box) {
    if (box.empty()) return false;
    for (const ExactPlane& plane : all_)
      if (sign_at_p_vertex(plane, origin, box) < 0) return false;
    for (const ExactPlane& plane : any_)
      if (sign_at_p_vertex(plane, origin, box) >= 0) return true;
    return any_.empty();
  }

  /// Whether the closed sets share a point (not for unions). Their intersection lies within the box, so if it is not
  /// empty it has a vertex: three planes of either that meet in a point which all of them contain.
  bool meets(const core::dvec3& origin, const core::Aabb& box) {
    std::vector<std::array<mpq_class, 4>> halves;
    for (const ExactPlane& p : all_)
      halves.push_back({p.coefficient(0), p.coefficient(1), p.coefficient(2), p.coefficient(3)});
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

  std::uint64_t decided_in_rationals = 0;

 private:
  int sign_at_p_vertex(const ExactPlane& plane, const core::dvec3& origin, const core::Aabb& box) {
    const long double unit = std::numeric_limits<long double>::epsilon();
    long double value = 0.0L, size = 0.0L;
    std::array<float, 3> corner;
    for (std::size_t i = 0; i < 3; ++i) {
      corner[i] = plane.rounded(i) >= 0.0 ? box.max[int(i)] : box.min[int(i)];
      const long double term =
          (static_cast<long double>(plane.a[i]) + plane.b[i]) * (static_cast<long double>(origin[int(i)]) + corner[i]);
      value += term;
      size += std::abs(term);
    }
    const long double d = static_cast<long double>(plane.a[3]) + plane.b[3];
    value += d;
    size += std::abs(d);
    if (std::abs(value) > 16.0L * unit * size && std::abs(value) > 1e-280L) return value < 0.0L ? -1 : 1;
    ++decided_in_rationals;
    mpq_class exact = plane.coefficient(3);
    for (std::size_t i = 0; i < 3; ++i)
      exact += plane.coefficient(i) * (mpq_class(origin[int(i)]) + mpq_class(double(corner[i])));
    return sgn(exact);
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

  std::vector<ExactPlane> all_, any_;
};

}  // namespace sightline::tests
