// The plain twin of the wider kernels.
#include <cmath>

#include "sightline/raytrace/internal/kernels_impl.h"

namespace sightline::raytrace {
namespace {

/// As the processor's vector instructions do: b when neither is the greater.
inline float most(float a, float b) {
  return a > b ? a : b;
}
inline float least(float a, float b) {
  return a < b ? a : b;
}

struct Scalar {
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
  /// Returns the slim ones.
  static unsigned distances(const Areas& a, float* t) {
    unsigned slim = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      const float sum = (a.u[lane] + a.v[lane]) + a.w[lane];
      slim |= unsigned(std::fabs(sum) < kSlim * (extent(a.x, lane) * extent(a.y, lane))) << lane;
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

}  // namespace sightline::raytrace
