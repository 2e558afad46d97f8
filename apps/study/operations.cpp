#include "sightline/apps/study/operations.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/apps/study/camera.h"

namespace sightline::study {
namespace {

thread_local std::uint64_t performed = 0;

struct Counted {
  float value = 0.0f;
  Counted() = default;
  explicit Counted(float v) : value(v) {}
  explicit operator float() const { return value; }
};
Counted result(float v) {
  ++performed;
  return Counted(v);
}
Counted operator+(Counted a, Counted b) {
  return result(a.value + b.value);
}
Counted operator-(Counted a, Counted b) {
  return result(a.value - b.value);
}
Counted operator-(Counted a) {
  return result(-a.value);
}
Counted operator*(Counted a, Counted b) {
  return result(a.value * b.value);
}
Counted operator/(Counted a, Counted b) {
  return result(a.value / b.value);
}
bool operator<(Counted a, Counted b) {
  ++performed;
  return a.value < b.value;
}
bool operator>=(Counted a, Counted b) {
  ++performed;
  return a.value >= b.value;
}
Counted root(Counted a) {
  return result(std::sqrt(a.value));
}

struct Vector {
  Counted x{1.0f}, y{2.0f}, z{3.0f};
};
Counted dot(const Vector& a, const Vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vector unit(const Vector& v) {
  const Counted scale = Counted(1.0f) / root(dot(v, v));
  return {v.x * scale, v.y * scale, v.z * scale};
}

/// Axes of the camera from eye, target and up.
void update_radar() {
  const Vector eye, target, up{Counted(0.0f), Counted(1.0f), Counted(5.0f)};
  const Vector forward = unit({target.x - eye.x, target.y - eye.y, target.z - eye.z});
  const Vector right = unit(cross(forward, up));
  cross(right, forward);
}

/// Projection times view, six sums of rows, normalised.
void update_planes() {
  Counted product[4][4], a(1.0f), b(2.0f);
  for (auto& line : product)
    for (Counted& c : line) c = a * b + a * b + a * b + a * b;
  for (int k = 0; k < kPlanes; ++k) {
    Counted plane[4];
    for (int i = 0; i < 4; ++i) plane[i] = product[3][i] + product[k / 2][i];
    const Counted scale = Counted(1.0f) / root(dot({plane[0], plane[1], plane[2]}, {plane[0], plane[1], plane[2]}));
    for (Counted& c : plane) c = c * scale;
  }
}

template <class To, std::size_t kN>
void convert(const float (&from)[kN], To (&to)[kN]) {
  for (std::size_t i = 0; i < kN; ++i) to[i] = To(from[i]);
}

struct CountedCamera {
  std::array<PlaneT<Counted>, kPlanes> planes;
  RadarT<Counted> radar;
  explicit CountedCamera(const Camera& c) {
    for (std::size_t k = 0; k < planes.size(); ++k) {
      convert(c.planes[k].n, planes[k].n);
      planes[k].out = Counted(c.planes[k].out);
      planes[k].in = Counted(c.planes[k].in);
    }
    convert(c.radar.eye, radar.eye);
    convert(c.radar.forward, radar.forward);
    convert(c.radar.right, radar.right);
    convert(c.radar.up, radar.up);
    radar.near = Counted(c.radar.near), radar.far = Counted(c.radar.far);
    radar.slope_x = Counted(c.radar.slope_x), radar.slope_y = Counted(c.radar.slope_y);
  }
};

template <class Test>
Operations count(const char* name, std::uint64_t update, const std::vector<CountedCamera>& cameras,
                 const std::vector<BoxT<Counted>>& boxes, const Test& test) {
  Operations o{name, update, std::numeric_limits<std::uint64_t>::max(), 0, 0.0};
  std::uint64_t sum = 0;
  for (const CountedCamera& camera : cameras) {
    for (const auto& box : boxes) {
      performed = 0;
      test(camera, box);
      o.best = std::min(o.best, performed);
      o.worst = std::max(o.worst, performed);
      sum += performed;
    }
  }
  const std::size_t n = cameras.size() * boxes.size();
  if (n == 0) return {name, update, 0, 0, 0.0};
  o.mean = double(sum) / double(n);
  return o;
}

template <class OnePlane>
void all_planes(const CountedCamera& c, const OnePlane& one_plane) {
  unsigned mask = kAllPlanes;
  Rejection rejection;
  in_turn([&](int k, float& below) { return one_plane(c.planes[std::size_t(k)], below); }, mask, mask, nullptr,
          rejection);
}

}  // namespace

OperationTable count_operations(std::span<const core::Aabb> boxes, std::span<const core::View> views) {
  core::Aabb extent;
  for (const core::Aabb& b : boxes) extent.grow(b);
  std::vector<CountedCamera> cameras;
  for (std::size_t i = 0; i < views.size(); i += std::max<std::size_t>(1, views.size() / 10)) {
    const Camera camera(views[i], extent);
    if (camera.radar_usable) cameras.emplace_back(camera);
  }
  std::vector<BoxT<Counted>> counted;
  for (std::size_t i = 0; i < boxes.size(); i += std::max<std::size_t>(1, boxes.size() / 4000)) {
    const Box plain{{boxes[i].min.x, boxes[i].min.y, boxes[i].min.z}, {boxes[i].max.x, boxes[i].max.y, boxes[i].max.z}};
    BoxT<Counted> box;
    convert(plain.lo, box.lo);
    convert(plain.hi, box.hi);
    counted.push_back(box);
  }
  performed = 0;
  update_planes();
  const std::uint64_t planes = performed;
  performed = 0;
  update_radar();
  const std::uint64_t radar = performed;
  using B = BoxT<Counted>;
  return {count("planes, 8 corners", planes, cameras, counted,
                [](const CountedCamera& c, const B& b) {
                  all_planes(c,
                             [&b](const auto& p, float& below) { return corners_against_plane<false>(p, b, below); });
                }),
          count("radar, three answers", radar, cameras, counted,
                [](const CountedCamera& c, const B& b) { radar_counting(c.radar, b); }),
          count("radar, two answers", radar, cameras, counted,
                [](const CountedCamera& c, const B& b) { radar_two_answers(c.radar, b); }),
          count("planes, p- and n-vertex", planes, cameras, counted, [](const CountedCamera& c, const B& b) {
            all_planes(c, [&b](const auto& p, float& below) { return vertices_against_plane<false>(p, b, below); });
          })};
}

}  // namespace sightline::study
