// study: the CPU culling techniques that others have used, as they were, to be compared with production (culling/) in
// error and in time. A laboratory, built from the source tree alone. What can be chosen is in variant.h, the
// culler in culler.h, the yardstick for errors in exact.h, its hierarchies in tree.h. Uses core, culling.
//
// This header: one box against one camera. Outside, intersecting or inside. Arithmetic is a template parameter so that
// operations can be counted. Plane tests agree bit for bit with each other, as all of them evaluate
// ((nx * x + ny * y) + nz * z) + d, which is monotone in every coordinate as computed; only the form with one SIMD
// register per distance adds in another order.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#define SIGHTLINE_STUDY_SSE 1
#endif

namespace sightline::study {

#ifdef SIGHTLINE_STUDY_SSE
inline constexpr bool kSse = true;
#else
inline constexpr bool kSse = false;
#endif

enum class Answer : std::uint8_t { kOutside, kIntersecting, kInside };

template <class T>
struct BoxT {
  T lo[3], hi[3];
};
using Box = BoxT<float>;

/// Corner i of eight; bit k of i: high along axis k.
template <class T>
std::array<T, 3> corner(const BoxT<T>& b, int i) {
  return {(i & 1) != 0 ? b.hi[0] : b.lo[0], (i & 2) != 0 ? b.hi[1] : b.lo[1], (i & 4) != 0 ? b.hi[2] : b.lo[2]};
}

/// Unit normal, and two offsets that enclose the exact one by more than the rounding errors of a test: a box is outside
/// when its p-vertex is below zero with `out`, inside when its n-vertex is not below zero with `in`.
template <class T>
struct PlaneT {
  T n[3], out, in;
};
using Plane = PlaneT<float>;

/// Camera of the radar test: no planes, but axes and slopes of the view pyramid (F. Placeres, "Improved frustum
/// culling", 2005).
template <class T>
struct RadarT {
  T eye[3], forward[3], right[3], up[3];
  T near, far, slope_x, slope_y;  // slopes: tan(fov / 2)
};
using Radar = RadarT<float>;

struct Sphere {
  float centre[3], radius;
};

inline constexpr int kPlanes = 6;
inline constexpr unsigned kAllPlanes = (1u << kPlanes) - 1;

/// Which plane rejected a box, and by how much at least (metres); by == 0 when that is not known.
struct Rejection {
  float by = 0.0f;
  std::uint8_t plane = 0;
};

/// Six planes split into positive and negative parts, side by side; places 6 and 7 hold planes that never reject
/// (A. Reshetov, A. Soupikov, J. Hurley, "Multi-level ray tracing algorithm", 2005, there with four planes and one
/// answer).
struct alignas(16) SplitPlanes {
  float positive[3][8], negative[3][8], out[8], in[8];
};

// --- one plane -------------------------------------------------------------------------------------------------------

template <class T>
T height(const PlaneT<T>& p, T x, T y, T z) {
  return (p.n[0] * x + p.n[1] * y) + p.n[2] * z;
}

#ifdef SIGHTLINE_STUDY_SSE
/// The height through one register that is packed for this one distance, offset included.
inline float packed_height(const Plane& p, float x, float y, float z, float offset) {
  const __m128 product = _mm_mul_ps(_mm_set_ps(offset, p.n[2], p.n[1], p.n[0]), _mm_set_ps(1.0f, z, y, x));
  const __m128 pairs = _mm_add_ps(product, _mm_shuffle_ps(product, product, _MM_SHUFFLE(2, 3, 0, 1)));
  return _mm_cvtss_f32(_mm_add_ss(pairs, _mm_movehl_ps(pairs, pairs)));
}
#else
inline float packed_height(const Plane& p, float x, float y, float z, float offset) {
  return (p.n[0] * x + p.n[1] * y) + (p.n[2] * z + offset);
}
#endif

/// All eight corners, without an early end, as the classic form has it.
template <bool kSimd, class T>
Answer corners_against_plane(const PlaneT<T>& p, const BoxT<T>& b, float& below) {
  int out = 0, in = 0;
  T highest = T(-3.0e38f);
  for (int i = 0; i < 8; ++i) {
    const auto [x, y, z] = corner(b, i);
    T above, inner;
    if constexpr (kSimd) {
      above = packed_height(p, x, y, z, p.out);
      inner = packed_height(p, x, y, z, p.in);
    } else {
      const T h = height(p, x, y, z);
      above = h + p.out;
      inner = h + p.in;
    }
    if (above < T(0.0f)) {
      ++out;
      if (highest < above) highest = above;
    }
    if (inner >= T(0.0f)) ++in;
  }
  if (out == 8) {
    below = -float(highest);
    return Answer::kOutside;
  }
  return in == 8 ? Answer::kInside : Answer::kIntersecting;
}

/// p- and n-vertex, found anew for every box (U. Assarsson, T. Möller, 2000).
template <bool kSimd, class T>
Answer vertices_against_plane(const PlaneT<T>& p, const BoxT<T>& b, float& below) {
  const bool px = p.n[0] >= T(0.0f), py = p.n[1] >= T(0.0f), pz = p.n[2] >= T(0.0f);
  const T far_x = px ? b.hi[0] : b.lo[0], far_y = py ? b.hi[1] : b.lo[1], far_z = pz ? b.hi[2] : b.lo[2];
  T above, inner;
  if constexpr (kSimd)
    above = packed_height(p, far_x, far_y, far_z, p.out);
  else
    above = height(p, far_x, far_y, far_z) + p.out;
  if (above < T(0.0f)) {
    below = -float(above);
    return Answer::kOutside;
  }
  const T near_x = px ? b.lo[0] : b.hi[0], near_y = py ? b.lo[1] : b.hi[1], near_z = pz ? b.lo[2] : b.hi[2];
  if constexpr (kSimd)
    inner = packed_height(p, near_x, near_y, near_z, p.in);
  else
    inner = height(p, near_x, near_y, near_z) + p.in;
  return inner >= T(0.0f) ? Answer::kInside : Answer::kIntersecting;
}

// --- all planes ------------------------------------------------------------------------------------------------------

/// Asks `one_plane(k, below)` for the planes of `todo`, `*first` in front when given, and clears from `mask` the planes
/// that the box lies inside of. The plane that rejects is left in `*first`.
template <class OnePlane>
Answer in_turn(const OnePlane& one_plane, unsigned todo, unsigned& mask, std::uint8_t* first, Rejection& rejection) {
  unsigned open = 0;
  const auto rejects = [&](int k) {
    const Answer a = one_plane(k, rejection.by);
    if (a == Answer::kOutside) {
      rejection.plane = std::uint8_t(k);
      return true;
    }
    if (a == Answer::kInside)
      mask &= ~(1u << k);
    else
      open |= 1u << k;
    return false;
  };
  if (first != nullptr && (todo >> *first & 1u) != 0) {
    if (rejects(*first)) return Answer::kOutside;
    todo &= ~(1u << *first);
  }
  for (; todo != 0; todo &= todo - 1) {
    const int k = std::countr_zero(todo);
    if (rejects(k)) {
      if (first != nullptr) *first = std::uint8_t(k);
      return Answer::kOutside;
    }
  }
  return open == 0 ? Answer::kInside : Answer::kIntersecting;
}

/// Reshetov's form for six planes and three answers: two sets of products, all planes at once.
template <bool kSimd>
Answer split_planes(const SplitPlanes& s, const Box& b, unsigned todo, unsigned& mask, Rejection& rejection) {
  unsigned out = 0, in = 0;
  alignas(16) float above[8];
#ifdef SIGHTLINE_STUDY_SSE
  if constexpr (kSimd) {
    const __m128 zero = _mm_setzero_ps();
    for (int g = 0; g < 8; g += 4) {
      __m128 p = zero, n = zero;
      for (int axis = 0; axis < 3; ++axis) {
        const __m128 pos = _mm_load_ps(s.positive[axis] + g), neg = _mm_load_ps(s.negative[axis] + g);
        const __m128 lo = _mm_set1_ps(b.lo[axis]), hi = _mm_set1_ps(b.hi[axis]);
        p = _mm_add_ps(p, _mm_add_ps(_mm_mul_ps(pos, hi), _mm_mul_ps(neg, lo)));
        n = _mm_add_ps(n, _mm_add_ps(_mm_mul_ps(pos, lo), _mm_mul_ps(neg, hi)));
      }
      p = _mm_add_ps(p, _mm_load_ps(s.out + g));
      n = _mm_add_ps(n, _mm_load_ps(s.in + g));
      _mm_store_ps(above + g, p);
      out |= unsigned(_mm_movemask_ps(_mm_cmplt_ps(p, zero))) << g;
      in |= unsigned(_mm_movemask_ps(_mm_cmpge_ps(n, zero))) << g;
    }
  }
#endif
  if constexpr (!kSimd || !kSse) {
    for (int k = 0; k < kPlanes; ++k) {
      float p = 0.0f, n = 0.0f;
      for (int axis = 0; axis < 3; ++axis) {
        p += s.positive[axis][k] * b.hi[axis] + s.negative[axis][k] * b.lo[axis];
        n += s.positive[axis][k] * b.lo[axis] + s.negative[axis][k] * b.hi[axis];
      }
      above[k] = p + s.out[k];
      out |= unsigned(above[k] < 0.0f) << k;
      in |= unsigned(n + s.in[k] >= 0.0f) << k;
    }
  }
  out &= todo;
  if (out != 0) {
    rejection.plane = std::uint8_t(std::countr_zero(out));
    rejection.by = -above[rejection.plane];
    return Answer::kOutside;
  }
  mask &= ~in;
  return (todo & ~in) == 0 ? Answer::kInside : Answer::kIntersecting;
}

// --- radar -----------------------------------------------------------------------------------------------------------

/// Whether a point is within all limits: near, far, left, right, bottom, top. Gives up at the first that it violates.
template <class T>
bool within(const RadarT<T>& r, const std::array<T, 3>& p) {
  const T v[3] = {p[0] - r.eye[0], p[1] - r.eye[1], p[2] - r.eye[2]};
  const auto along = [&v](const T(&axis)[3]) { return (axis[0] * v[0] + axis[1] * v[1]) + axis[2] * v[2]; };
  const T f = along(r.forward);
  if (f < r.near || r.far < f) return false;
  const T x_limit = r.slope_x * f, right = along(r.right);
  if (right < -x_limit || x_limit < right) return false;
  const T y_limit = r.slope_y * f, up = along(r.up);
  return !(up < -y_limit || y_limit < up);
}

/// Counts corners: none within is 'outside'. Loses boxes whose corners all lie outside while their faces or edges
/// cross the view: large ones.
template <class T>
Answer radar_counting(const RadarT<T>& r, const BoxT<T>& b) {
  int in = 0;
  for (int i = 0; i < 8; ++i) in += within(r, corner(b, i)) ? 1 : 0;
  return in == 0 ? Answer::kOutside : in == 8 ? Answer::kInside : Answer::kIntersecting;
}

/// Without 'intersecting': the first corner within ends it. Answers kIntersecting for "visible". Same losses.
template <class T>
Answer radar_two_answers(const RadarT<T>& r, const BoxT<T>& b) {
  for (int i = 0; i < 8; ++i)
    if (within(r, corner(b, i))) return Answer::kIntersecting;
  return Answer::kOutside;
}

// --- boxes against boxes ---------------------------------------------------------------------------------------------

template <class T>
bool apart(const BoxT<T>& a, const BoxT<T>& b) {
  return a.hi[0] < b.lo[0] || b.hi[0] < a.lo[0] || a.hi[1] < b.lo[1] || b.hi[1] < a.lo[1] || a.hi[2] < b.lo[2] ||
         b.hi[2] < a.lo[2];
}

}  // namespace sightline::study
