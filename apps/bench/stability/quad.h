// Arithmetic of 113 bits for the reference of the stability suite: a number, a vector, and polynomials up to degree 4
// with their real roots. Slow (a hundred times double) and simple.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>

#include <quadmath.h>

#include "sightline/core/conventions.h"

namespace sightline::bench {

__extension__ using Quad = __float128;

struct QuadVec {
  Quad x = 0, y = 0, z = 0;

  QuadVec() = default;
  QuadVec(Quad x_, Quad y_, Quad z_) : x(x_), y(y_), z(z_) {}
  explicit QuadVec(const core::dvec3& v) : x(v.x), y(v.y), z(v.z) {}

  friend QuadVec operator+(const QuadVec& a, const QuadVec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend QuadVec operator-(const QuadVec& a, const QuadVec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend QuadVec operator*(Quad s, const QuadVec& a) { return {s * a.x, s * a.y, s * a.z}; }
};

inline Quad dot(const QuadVec& a, const QuadVec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline QuadVec cross(const QuadVec& a, const QuadVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline core::dvec3 to_double(const QuadVec& a) {
  return {double(a.x), double(a.y), double(a.z)};
}

/// Polynomial in one variable, with coefficients by rising power. A number converts to a constant polynomial, so that
/// one implicit form serves a point and a line.
class Polynomial {
 public:
  static constexpr int kMaxDegree = 4;

  Polynomial() = default;
  Polynomial(Quad constant) : c_{constant} {}  // NOLINT(google-explicit-constructor): numbers are polynomials
  Polynomial(Quad constant, Quad slope) : c_{constant, slope}, degree_(1) {}

  int degree() const { return degree_; }
  Quad operator[](int power) const { return c_[static_cast<std::size_t>(power)]; }

  Quad operator()(Quad s) const {
    Quad value = (*this)[degree_];
    for (int i = degree_ - 1; i >= 0; --i) value = value * s + (*this)[i];
    return value;
  }

  Polynomial derivative() const {
    Polynomial result;
    result.degree_ = std::max(0, degree_ - 1);
    for (int i = 1; i <= degree_; ++i) result.at(i - 1) = i * (*this)[i];
    return result;
  }

  friend Polynomial operator+(const Polynomial& a, const Polynomial& b) {
    Polynomial result;
    result.degree_ = std::max(a.degree_, b.degree_);
    for (int i = 0; i <= result.degree_; ++i) result.at(i) = a[i] + b[i];
    return result;
  }
  friend Polynomial operator-(const Polynomial& a, const Polynomial& b) { return a + Polynomial(-1) * b; }
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b) {
    assert(a.degree_ + b.degree_ <= kMaxDegree);
    Polynomial result;
    result.degree_ = a.degree_ + b.degree_;
    for (int i = 0; i <= a.degree_; ++i)
      for (int j = 0; j <= b.degree_; ++j) result.at(i + j) += a[i] * b[j];
    return result;
  }

 private:
  Quad& at(int power) { return c_[static_cast<std::size_t>(power)]; }
  std::array<Quad, kMaxDegree + 1> c_{};
  int degree_ = 0;
};

/// Roots at which the polynomial changes its sign, in rising order.
struct Roots {
  std::array<Quad, Polynomial::kMaxDegree> at{};
  int count = 0;
};

/// The root between `low` and `high`, where a polynomial without extremes between them has different signs. Uses
/// Newton's method, and bisection where Newton would leave the bracket. Starts from what double finds in this way.
template <class Real>
Real bracketed_root(const Polynomial& p, const Polynomial& slope, Real low, Real high, Real start, Real exact) {
  const auto value_at = [](const Polynomial& f, Real s) {
    Real value = Real(f[f.degree()]);
    for (int i = f.degree() - 1; i >= 0; --i) value = value * s + Real(f[i]);
    return value;
  };
  const auto size = [](Real s) { return s < 0 ? -s : s; };
  const bool rising = p(Quad(high)) > 0;
  Real s = start > low && start < high ? start : (low + high) / 2;
  for (int i = 0; i < 400; ++i) {
    const Real value = value_at(p, s);
    ((value > 0) == rising ? high : low) = s;
    Real next = s - value / value_at(slope, s);
    if (!(next > low && next < high)) next = (low + high) / 2;
    const bool done = size(next - s) <= exact * size(s) || high - low <= exact * size(s);
    s = next;
    if (done) break;
  }
  return s;
}
inline Quad bracketed_root(const Polynomial& p, const Polynomial& slope, Quad low, Quad high) {
  if (p.degree() == 1) return -p[0] / p[1];
  const double middle = double((low + high) / 2);
  const double start = bracketed_root<double>(p, slope, double(low), double(high), middle, 1e-15);
  return bracketed_root<Quad>(p, slope, low, high, Quad(start), Quad(0x1p-111));  // two ulps of 1
}

/// Roots in [low, high]. Between neighbouring extremes, which are the roots of the derivative, lies at most one.
inline Roots roots(const Polynomial& p, Quad low, Quad high) {
  Roots found;
  if (p.degree() == 0) return found;
  const Polynomial slope = p.derivative();
  const Roots extremes = roots(slope, low, high);
  Quad from = low;
  for (int i = 0; i <= extremes.count; ++i) {
    const Quad to = i < extremes.count ? extremes.at[std::size_t(i)] : high;
    if ((p(from) > 0) != (p(to) > 0)) found.at[std::size_t(found.count++)] = bracketed_root(p, slope, from, to);
    from = to;
  }
  return found;
}

}  // namespace sightline::bench
