// The plain twin of the wider kernels.
#include <cmath>

#include "sightline/raytrace/internal/packet_impl.h"

namespace sightline::raytrace {
namespace {

/// As the processor's vector instructions do: b when neither is the greater.
inline float most(float a, float b) {
  return a > b ? a : b;
}
inline float least(float a, float b) {
  return a < b ? a : b;
}

struct ScalarWide {
  float v[kPacket];
  static ScalarWide load(const float* a) {
    return each([&](int i) { return a[i]; });
  }
  static ScalarWide spread(float a) {
    return each([&](int) { return a; });
  }
  void store(float* out) const {
    for (int i = 0; i < kPacket; ++i) out[i] = v[i];
  }
  template <class Lane>
  static ScalarWide each(const Lane& lane) {
    ScalarWide result;
    for (int i = 0; i < kPacket; ++i) result.v[i] = lane(i);
    return result;
  }
  template <class Lane>
  static unsigned bits(const Lane& lane) {
    unsigned result = 0;
    for (int i = 0; i < kPacket; ++i) result |= unsigned(lane(i)) << i;
    return result;
  }
};
inline ScalarWide operator+(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::each([&](int i) { return a.v[i] + b.v[i]; });
}
inline ScalarWide operator-(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::each([&](int i) { return a.v[i] - b.v[i]; });
}
inline ScalarWide operator*(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::each([&](int i) { return a.v[i] * b.v[i]; });
}
inline ScalarWide operator/(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::each([&](int i) { return a.v[i] / b.v[i]; });
}
inline ScalarWide most(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::each([&](int i) { return most(a.v[i], b.v[i]); });
}
inline ScalarWide least(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::each([&](int i) { return least(a.v[i], b.v[i]); });
}
inline unsigned at_most(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::bits([&](int i) { return a.v[i] <= b.v[i]; });
}
inline unsigned less(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::bits([&](int i) { return a.v[i] < b.v[i]; });
}
inline unsigned equal(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::bits([&](int i) { return a.v[i] == b.v[i]; });
}

/// The lowest value of some rays, at least one.
inline float lowest_of(const ScalarWide& a, unsigned rays) {
  float result = std::numeric_limits<float>::infinity();
  for (int i = 0; i < kPacket; ++i)
    if ((rays >> i & 1u) != 0) result = least(result, a.v[i]);
  return result;
}
inline float highest(const ScalarWide& a, unsigned rays) {
  float result = -std::numeric_limits<float>::infinity();
  for (int i = 0; i < kPacket; ++i)
    if ((rays >> i & 1u) != 0) result = most(result, a.v[i]);
  return result;
}
/// The sign bit.
inline std::uint32_t sign_of(float a) {
  FloatBits u;
  u.value = a;
  return u.bits >> 31;
}
inline ScalarWide magnitude(const ScalarWide& a) {
  return ScalarWide::each([&](int i) { return sign_of(a.v[i]) != 0 ? -a.v[i] : a.v[i]; });
}
/// Magnitudes of a with the signs of b; a must not have any.
inline ScalarWide with_signs(const ScalarWide& a, const ScalarWide& b) {
  return ScalarWide::each([&](int i) { return sign_of(b.v[i]) != 0 ? -a.v[i] : a.v[i]; });
}
/// A bit per sign.
inline unsigned signs(const ScalarWide& a) {
  return ScalarWide::bits([&](int i) { return sign_of(a.v[i]) != 0; });
}

struct ScalarMask {
  unsigned m;
};
inline ScalarMask operator&(ScalarMask a, ScalarMask b) {
  return {a.m & b.m};
}
inline ScalarMask operator|(ScalarMask a, ScalarMask b) {
  return {a.m | b.m};
}
inline ScalarMask operator^(ScalarMask a, ScalarMask b) {
  return {a.m ^ b.m};
}
inline ScalarMask operator~(ScalarMask a) {
  return {~a.m & 0xffu};
}
inline bool any(ScalarMask a) {
  return a.m != 0;
}

struct ScalarEight {
  double v[8];
  static ScalarEight load(const double* a) {
    return each([&](int i) { return a[i]; });
  }
  static ScalarEight spread(double a) {
    return each([&](int) { return a; });
  }
  template <class Lane>
  static ScalarEight each(const Lane& lane) {
    ScalarEight result;
    for (int i = 0; i < 8; ++i) result.v[i] = lane(i);
    return result;
  }
  template <class Lane>
  static ScalarMask mask(const Lane& lane) {
    ScalarMask result{0};
    for (int i = 0; i < 8; ++i) result.m |= unsigned(lane(i)) << i;
    return result;
  }
};
inline ScalarEight operator+(const ScalarEight& a, const ScalarEight& b) {
  return ScalarEight::each([&](int i) { return a.v[i] + b.v[i]; });
}
inline ScalarEight operator-(const ScalarEight& a, const ScalarEight& b) {
  return ScalarEight::each([&](int i) { return a.v[i] - b.v[i]; });
}
inline ScalarEight operator*(const ScalarEight& a, const ScalarEight& b) {
  return ScalarEight::each([&](int i) { return a.v[i] * b.v[i]; });
}
inline ScalarEight operator/(const ScalarEight& a, const ScalarEight& b) {
  return ScalarEight::each([&](int i) { return a.v[i] / b.v[i]; });
}
inline ScalarEight operator-(const ScalarEight& a) {
  return ScalarEight::each([&](int i) { return -a.v[i]; });
}
inline ScalarMask less(const ScalarEight& a, const ScalarEight& b) {
  return ScalarEight::mask([&](int i) { return a.v[i] < b.v[i]; });
}
inline ScalarMask at_most(const ScalarEight& a, const ScalarEight& b) {
  return ScalarEight::mask([&](int i) { return a.v[i] <= b.v[i]; });
}
inline ScalarMask equal(const ScalarEight& a, const ScalarEight& b) {
  return ScalarEight::mask([&](int i) { return a.v[i] == b.v[i]; });
}

struct Scalar {
  using Wide = ScalarWide;
  using Eight = ScalarEight;
  using Mask = ScalarMask;

  static Eight max(const Eight& a, const Eight& b) {
    return Eight::each([&](int i) { return larger(a.v[i], b.v[i]); });
  }
  static Eight min(const Eight& a, const Eight& b) {
    return Eight::each([&](int i) { return smaller(a.v[i], b.v[i]); });
  }
  static Eight select(Mask m, const Eight& a, const Eight& b) {
    return Eight::each([&](int i) { return (m.m >> i & 1u) != 0 ? a.v[i] : b.v[i]; });
  }
  static Eight root(const Eight& a) {
    return Eight::each([&](int i) { return std::sqrt(a.v[i]); });
  }
  static Eight fused(const Eight& a, const Eight& b, const Eight& c) {
    return Eight::each([&](int i) { return std::fma(a.v[i], b.v[i], c.v[i]); });
  }
  static Eight magnitude(const Eight& a) {
    return Eight::each([&](int i) { return std::fabs(a.v[i]); });
  }
  static Eight with_sign(const Eight& a, const Eight& sign) {
    return Eight::each([&](int i) { return std::copysign(a.v[i], sign.v[i]); });
  }
  static Mask negative(const Eight& a) {
    return Eight::mask([&](int i) { return std::signbit(a.v[i]); });
  }
  static Mask every() { return {0xffu}; }
  static unsigned bits(Mask m) { return m.m; }
  static void store(double* p, unsigned which, const Eight& a) {
    for (int i = 0; i < 8; ++i)
      if ((which >> i & 1u) != 0) p[i] = a.v[i];
  }
  static Eight inverse_power_of_two(const Eight& a) {
    return Eight::each([&](int i) { return raytrace::inverse_power_of_two(a.v[i]); });
  }
  /// Rows of eight numbers become columns from `first` on.
  static void transpose(const double* rows, double* const* columns, int first) {
    for (int row = 0; row < 8; ++row)
      for (int column = 0; column < 8; ++column) columns[column][first + row] = rows[8 * row + column];
  }
  /// About a third of the exponent.
  static Eight rough_cube_root(const Eight& a) {
    return Eight::each([&](int i) {
      DoubleBits u;
      u.value = a.v[i];
      u.bits = (((u.bits >> 32) * kThird >> 32) + kTwoThirds) << 32;
      return u.value;
    });
  }

  struct Ray {
    const BoxRay& r;
    explicit Ray(const BoxRay& ray) : r(ray) {}
  };

  static unsigned meet(const WideNode& node, const Ray& ray, float t_max, float* t) {
    const BoxRay& r = ray.r;
    unsigned met = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      float near[3], far[3];
      for (int axis = 0; axis < 3; ++axis) {
        near[axis] = (node.bounds[r.near_plane[axis]][lane] - r.near_origin[axis]) * r.near_scale[axis];
        far[axis] = (node.bounds[r.far_plane[axis]][lane] - r.far_origin[axis]) * r.far_scale[axis];
      }
      t[lane] = most(most(near[0], near[1]), most(near[2], 0.0f));
      const float leave = least(least(far[0], far[1]), least(far[2], t_max));
      met |= unsigned(t[lane] <= leave) << lane;
    }
    return met;
  }

  static unsigned meet_hull(const WideNode& node, const Hull& hull, float* t) {
    unsigned met = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      float enter = 0.0f, leave = hull.limit;
      for (int axis = 0; axis < 3; ++axis) {
        const float near = node.bounds[hull.near_plane[axis]][lane] - hull.near_origin[axis];
        const float far = node.bounds[hull.far_plane[axis]][lane] - hull.far_origin[axis];
        enter = most(enter, least(near * hull.near_scale[0][axis], near * hull.near_scale[1][axis]));
        leave = least(leave, most(far * hull.far_scale[0][axis], far * hull.far_scale[1][axis]));
      }
      t[lane] = enter;
      met |= unsigned(enter <= leave) << lane;
    }
    return met;
  }

  struct Areas {
    float x[3][kLanes], y[3][kLanes], z[3][kLanes], u[kLanes], v[kLanes], w[kLanes];
  };
  static void shear(const TriangleRay& ray, const TriangleBlock& block, Areas& a, unsigned& hit, unsigned& unsure) {
    hit = unsure = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      for (int corner = 0; corner < 3; ++corner) {
        const float x = block.corners[corner][ray.axes[0]][lane] - ray.origin[0];
        const float y = block.corners[corner][ray.axes[1]][lane] - ray.origin[1];
        const float z = block.corners[corner][ray.axes[2]][lane] - ray.origin[2];
        a.x[corner][lane] = x - ray.shear[0] * z;
        a.y[corner][lane] = y - ray.shear[1] * z;
        a.z[corner][lane] = ray.shear[2] * z;
      }
      const float u = a.u[lane] = a.x[2][lane] * a.y[1][lane] - a.y[2][lane] * a.x[1][lane];
      const float v = a.v[lane] = a.x[0][lane] * a.y[2][lane] - a.y[0][lane] * a.x[2][lane];
      const float w = a.w[lane] = a.x[1][lane] * a.y[0][lane] - a.y[1][lane] * a.x[0][lane];
      const bool above = u > 0.0f && v > 0.0f && w > 0.0f, below = u < 0.0f && v < 0.0f && w < 0.0f;
      const bool some_above = u > 0.0f || v > 0.0f || w > 0.0f, some_below = u < 0.0f || v < 0.0f || w < 0.0f;
      const bool zero = u == 0.0f || v == 0.0f || w == 0.0f;
      hit |= unsigned(above || below) << lane;
      unsure |= unsigned(zero && !(some_above && some_below)) << lane;
    }
  }
  static float extent(const float (&place)[3][kLanes], int lane) {
    return most(std::fabs(place[0][lane]), most(std::fabs(place[1][lane]), std::fabs(place[2][lane])));
  }
  static float range(const float (&place)[3][kLanes], int lane) {
    return most(place[0][lane], most(place[1][lane], place[2][lane])) -
           least(place[0][lane], least(place[1][lane], place[2][lane]));
  }
  /// Returns the slim ones. `lost`: what t may be off by; infinite or NaN where float does not know.
  static unsigned distances(const Areas& a, float across, float* t, float* lost) {
    unsigned slim = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      const float sum = (a.u[lane] + a.v[lane]) + a.w[lane];
      const float wide = extent(a.x, lane), high = extent(a.y, lane), size = wide + high;
      slim |= unsigned(std::fabs(sum) < kSlim * (wide * high)) << lane;
      const float area = most(std::fabs(sum) - (kAreaLost * across) * size, 0.0f);
      lost[lane] = across + across * ((kSlope * range(a.z, lane)) * size / area);
      t[lane] = ((a.u[lane] * a.z[0][lane] + a.v[lane] * a.z[1][lane]) + a.w[lane] * a.z[2][lane]) / sum;
    }
    return slim;
  }
  static void corners(const Areas& a, unsigned lane, Sheared& out) {
    for (int corner = 0; corner < 3; ++corner) {
      out.x[corner] = a.x[corner][lane];
      out.y[corner] = a.y[corner][lane];
      out.z[corner] = a.z[corner][lane];
    }
  }
};

}  // namespace

const Kernels& scalar_kernels() {
  static constexpr Kernels kKernels = make_kernels<Scalar>();
  return kKernels;
}
const PacketKernels& scalar_packet_kernels() {
  static constexpr PacketKernels kKernels = make_packet_kernels<Scalar>();
  return kKernels;
}

}  // namespace sightline::raytrace
