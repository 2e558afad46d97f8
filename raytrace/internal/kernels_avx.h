// Internal: what the kernels for AVX2 and AVX-512 share: eight lanes are one register of 256 bits. Static: each is
// compiled for its own instruction set.
#pragma once

#include <cstddef>

#include <immintrin.h>

#include "sightline/raytrace/internal/kernels_impl.h"

namespace sightline::raytrace {
namespace {

struct Avx2 {
  struct Ray {
    __m256 near_origin[3], far_origin[3], near_scale[3], far_scale[3];
    std::ptrdiff_t near_plane[3], far_plane[3];  // in bytes from the node's start

    explicit Ray(const BoxRay& r) {
      for (int axis = 0; axis < 3; ++axis) {
        near_origin[axis] = _mm256_set1_ps(r.near_origin[axis]);
        far_origin[axis] = _mm256_set1_ps(r.far_origin[axis]);
        near_scale[axis] = _mm256_set1_ps(r.near_scale[axis]);
        far_scale[axis] = _mm256_set1_ps(r.far_scale[axis]);
        near_plane[axis] = std::ptrdiff_t(sizeof(WideNode::bounds[0])) * r.near_plane[axis];
        far_plane[axis] = std::ptrdiff_t(sizeof(WideNode::bounds[0])) * r.far_plane[axis];
      }
    }
    /// A row of WideNode::bounds, without a multiplication in the chain of each node.
    static const float* plane_at(const WideNode& node, std::ptrdiff_t offset) {
      return reinterpret_cast<const float*>(reinterpret_cast<const std::byte*>(&node) + offset);
    }
    __m256 enter(const WideNode& node, int axis) const {
      const __m256 plane = _mm256_load_ps(plane_at(node, near_plane[axis]));
      return _mm256_mul_ps(_mm256_sub_ps(plane, near_origin[axis]), near_scale[axis]);
    }
    __m256 leave(const WideNode& node, int axis) const {
      const __m256 plane = _mm256_load_ps(plane_at(node, far_plane[axis]));
      return _mm256_mul_ps(_mm256_sub_ps(plane, far_origin[axis]), far_scale[axis]);
    }
  };

  static unsigned meet(const WideNode& node, const Ray& ray, float t_max, float* t) {
    _mm_prefetch(reinterpret_cast<const char*>(node.children), _MM_HINT_T0);
    const __m256 enter = _mm256_max_ps(_mm256_max_ps(ray.enter(node, 0), ray.enter(node, 1)),
                                       _mm256_max_ps(ray.enter(node, 2), _mm256_setzero_ps()));
    const __m256 leave = _mm256_min_ps(_mm256_min_ps(ray.leave(node, 0), ray.leave(node, 1)),
                                       _mm256_min_ps(ray.leave(node, 2), _mm256_set1_ps(t_max)));
    _mm256_storeu_ps(t, enter);
    return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ)));
  }

  /// Children whose boxes any of the rays may meet, and where the first of them may enter.
  static unsigned meet_hull(const WideNode& node, const Hull& hull, float* t) {
    __m256 enter = _mm256_setzero_ps(), leave = _mm256_set1_ps(hull.limit);
    for (int axis = 0; axis < 3; ++axis) {
      const __m256 near =
          _mm256_sub_ps(_mm256_load_ps(node.bounds[hull.near_plane[axis]]), _mm256_set1_ps(hull.near_origin[axis]));
      const __m256 far =
          _mm256_sub_ps(_mm256_load_ps(node.bounds[hull.far_plane[axis]]), _mm256_set1_ps(hull.far_origin[axis]));
      enter = _mm256_max_ps(enter, _mm256_min_ps(_mm256_mul_ps(near, _mm256_set1_ps(hull.near_scale[0][axis])),
                                                 _mm256_mul_ps(near, _mm256_set1_ps(hull.near_scale[1][axis]))));
      leave = _mm256_min_ps(leave, _mm256_max_ps(_mm256_mul_ps(far, _mm256_set1_ps(hull.far_scale[0][axis])),
                                                 _mm256_mul_ps(far, _mm256_set1_ps(hull.far_scale[1][axis]))));
    }
    _mm256_storeu_ps(t, enter);
    return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ)));
  }

  struct Areas {
    __m256 x[3], y[3], z[3], u, v, w;
  };
  static __m256 area(__m256 ax, __m256 ay, __m256 bx, __m256 by) {
    return _mm256_sub_ps(_mm256_mul_ps(ax, by), _mm256_mul_ps(ay, bx));
  }
  static void shear(const TriangleRay& ray, const TriangleBlock& block, Areas& a, unsigned& hit, unsigned& unsure) {
    const __m256 ox = _mm256_set1_ps(ray.origin[0]), oy = _mm256_set1_ps(ray.origin[1]);
    const __m256 oz = _mm256_set1_ps(ray.origin[2]);
    const __m256 sx = _mm256_set1_ps(ray.shear[0]), sy = _mm256_set1_ps(ray.shear[1]);
    const __m256 sz = _mm256_set1_ps(ray.shear[2]);
    for (int corner = 0; corner < 3; ++corner) {
      const float(*place)[kLanes] = block.corners[corner];
      const __m256 z = _mm256_sub_ps(_mm256_load_ps(place[ray.axes[2]]), oz);
      a.x[corner] = _mm256_sub_ps(_mm256_sub_ps(_mm256_load_ps(place[ray.axes[0]]), ox), _mm256_mul_ps(sx, z));
      a.y[corner] = _mm256_sub_ps(_mm256_sub_ps(_mm256_load_ps(place[ray.axes[1]]), oy), _mm256_mul_ps(sy, z));
      a.z[corner] = _mm256_mul_ps(sz, z);
    }
    a.u = area(a.x[2], a.y[2], a.x[1], a.y[1]);
    a.v = area(a.x[0], a.y[0], a.x[2], a.y[2]);
    a.w = area(a.x[1], a.y[1], a.x[0], a.y[0]);
    const __m256 zero = _mm256_setzero_ps();
    const __m256 least = _mm256_min_ps(_mm256_min_ps(a.u, a.v), a.w);
    const __m256 most = _mm256_max_ps(_mm256_max_ps(a.u, a.v), a.w);
    const auto above = unsigned(_mm256_movemask_ps(_mm256_cmp_ps(least, zero, _CMP_GT_OQ)));
    const auto below = unsigned(_mm256_movemask_ps(_mm256_cmp_ps(most, zero, _CMP_LT_OQ)));
    const __m256 touch = _mm256_or_ps(_mm256_cmp_ps(least, zero, _CMP_EQ_OQ), _mm256_cmp_ps(most, zero, _CMP_EQ_OQ));
    hit = above | below;
    unsure = unsigned(_mm256_movemask_ps(touch));
  }
  static __m256 extent(const __m256 (&place)[3]) {
    const __m256 sign = _mm256_set1_ps(-0.0f);
    return _mm256_max_ps(_mm256_andnot_ps(sign, place[0]),
                         _mm256_max_ps(_mm256_andnot_ps(sign, place[1]), _mm256_andnot_ps(sign, place[2])));
  }
  static __m256 range(const __m256 (&place)[3]) {
    return _mm256_sub_ps(_mm256_max_ps(place[0], _mm256_max_ps(place[1], place[2])),
                         _mm256_min_ps(place[0], _mm256_min_ps(place[1], place[2])));
  }
  /// Returns the slim ones. `lost`: what t may be off by; infinite or NaN where float does not know.
  static unsigned distances(const Areas& a, float across, float* t, float* lost) {
    const __m256 sum = _mm256_add_ps(_mm256_add_ps(a.u, a.v), a.w);
    const __m256 product = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a.u, a.z[0]), _mm256_mul_ps(a.v, a.z[1])),
                                         _mm256_mul_ps(a.w, a.z[2]));
    _mm256_storeu_ps(t, _mm256_div_ps(product, sum));
    const __m256 wide = extent(a.x), high = extent(a.y), size = _mm256_add_ps(wide, high);
    const __m256 twice = _mm256_andnot_ps(_mm256_set1_ps(-0.0f), sum);
    const __m256 area = _mm256_max_ps(_mm256_sub_ps(twice, _mm256_mul_ps(_mm256_set1_ps(kAreaLost * across), size)),
                                      _mm256_setzero_ps());
    const __m256 slope = _mm256_div_ps(_mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(kSlope), range(a.z)), size), area);
    const __m256 off = _mm256_set1_ps(across);
    _mm256_storeu_ps(lost, _mm256_add_ps(off, _mm256_mul_ps(off, slope)));
    const __m256 limit = _mm256_mul_ps(_mm256_set1_ps(kSlim), _mm256_mul_ps(wide, high));
    return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(twice, limit, _CMP_LT_OQ)));
  }
  static void corners(const Areas& a, unsigned lane, Sheared& out) {
    alignas(32) float lanes[kLanes];
    for (int corner = 0; corner < 3; ++corner) {
      _mm256_store_ps(lanes, a.x[corner]);
      out.x[corner] = lanes[lane];
      _mm256_store_ps(lanes, a.y[corner]);
      out.y[corner] = lanes[lane];
      _mm256_store_ps(lanes, a.z[corner]);
      out.z[corner] = lanes[lane];
    }
  }
};

}  // namespace
}  // namespace sightline::raytrace
