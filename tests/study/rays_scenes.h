// Scenes and rays for the tests of apps/study/rays: ordinary ones, and all that is known to break traversals.
#pragma once

#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "sightline/apps/study/rays/traversals.h"

namespace sightline::study::rays::tests {

using core::dvec3;
using core::vec3;
using Random = std::mt19937_64;

struct Mesh {
  std::string name;
  std::vector<vec3> positions;
  std::vector<std::uint32_t> indices;

  void triangle(const vec3& a, const vec3& b, const vec3& c) {
    for (const vec3& p : {a, b, c}) {
      indices.push_back(std::uint32_t(positions.size()));
      positions.push_back(p);
    }
  }
  TriangleSet set() const { return {positions, indices}; }
};

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline dvec3 random_point(Random& random, double low, double high) {
  const double x = uniform(random, low, high), y = uniform(random, low, high);
  return {x, y, uniform(random, low, high)};
}
inline std::uint32_t pick(Random& random, std::size_t count) {
  return std::uint32_t(std::uniform_int_distribution<std::size_t>(0, count - 1)(random));
}

inline Mesh soup(Random& random, std::uint32_t count, double size) {
  Mesh mesh{"soup", {}, {}};
  for (std::uint32_t i = 0; i < count; ++i) {
    const dvec3 at = random_point(random, -1.0, 1.0);
    mesh.triangle(vec3(at), vec3(at + random_point(random, -size, size)), vec3(at + random_point(random, -size, size)));
  }
  return mesh;
}

/// Closed, with shared vertices.
inline Mesh sphere(int around, int up) {
  Mesh mesh{"sphere", {}, {}};
  const double pi = std::acos(-1.0);
  for (int j = 0; j <= up; ++j)
    for (int i = 0; i < around; ++i) {
      const double v = pi * j / up, u = 2.0 * pi * i / around, r = j == 0 || j == up ? 0.0 : std::sin(v);
      mesh.positions.push_back(vec3(dvec3(r * std::cos(u), r * std::sin(u), std::cos(v))));
    }
  const auto at = [&](int i, int j) { return std::uint32_t(j * around + i % around); };
  for (int j = 0; j < up; ++j)
    for (int i = 0; i < around; ++i) {
      if (j > 0) mesh.indices.insert(mesh.indices.end(), {at(i, j), at(i, j + 1), at(i + 1, j)});
      if (j + 1 < up) mesh.indices.insert(mesh.indices.end(), {at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return mesh;
}

/// Faces of unit cubes on a lattice: all lie in planes across the axes, where structures like to split, and those
/// between two cubes coincide.
inline Mesh lattice(int n) {
  Mesh mesh{"lattice", {}, {}};
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (int axis = 0; axis < 3; ++axis)
          for (int side = 0; side < 2; ++side) {
            vec3 corner{float(x), float(y), float(z)}, u(0.0f), v(0.0f);
            corner[axis] += float(side);
            u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1.0f;
            mesh.triangle(corner, corner + u, corner + v);
            mesh.triangle(corner + u, corner + u + v, corner + v);
          }
  return mesh;
}

inline Mesh flat(Random& random, std::uint32_t count) {
  Mesh mesh = soup(random, count, 0.2);
  mesh.name = "flat";
  for (vec3& p : mesh.positions) p.z = 0.25f;
  return mesh;
}

/// Points, lines, needles, and one triangle many times.
inline Mesh degenerate(Random& random) {
  Mesh mesh = soup(random, 40, 0.3);
  mesh.name = "degenerate";
  for (int i = 0; i < 40; ++i) {
    const vec3 a(random_point(random, -1.0, 1.0)), b(random_point(random, -1.0, 1.0));
    mesh.triangle(a, a, a);
    mesh.triangle(a, b, a);
    mesh.triangle(a, b, 0.5f * (a + b));
    mesh.triangle(a, b, a + vec3(1e-6f, 0.0f, 0.0f));
    mesh.triangle({-0.5f, -0.5f, 0.1f}, {0.5f, -0.5f, 0.1f}, {0.0f, 0.5f, 0.3f});
  }
  return mesh;
}

inline Mesh moved(Mesh mesh, const std::string& name, float scale, const vec3& by) {
  mesh.name = name;
  for (vec3& p : mesh.positions) p = scale * p + by;
  return mesh;
}

/// A hundredth of the scene holds almost all of it.
inline Mesh teapot_in_a_stadium() {
  Mesh mesh = moved(sphere(24, 12), "teapot in a stadium", 0.005f, {0.3f, 0.2f, 0.1f});
  mesh.triangle({-1, -1, -1}, {1, -1, -1}, {-1, 1, -1});
  mesh.triangle({1, -1, -1}, {1, 1, -1}, {-1, 1, -1});
  mesh.triangle({-1, -1, -1}, {-1, -1, 1}, {-1, 1, 1});
  return mesh;
}

inline std::vector<Mesh> scenes(Random& random) {
  Mesh one{"one triangle", {}, {}};
  one.triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f});
  Mesh point{"one point", {}, {}};
  point.triangle({2, 3, 4}, {2, 3, 4}, {2, 3, 4});
  return {{"empty", {}, {}},
          one,
          point,
          soup(random, 12, 2.0),
          soup(random, 600, 0.1),
          sphere(40, 20),
          lattice(4),
          flat(random, 200),
          degenerate(random),
          teapot_in_a_stadium(),
          moved(sphere(16, 8), "far from the origin", 100.0f, {1e5f, -2e5f, 3e4f}),
          moved(sphere(16, 8), "tiny", 1e-20f, vec3(0.0f)),
          moved(sphere(16, 8), "huge", 1e18f, vec3(0.0f))};
}

inline std::string describe(const Ray& ray) {
  char text[400];
  std::snprintf(text, sizeof text, "origin %a %a %a direction %a %a %a t_max %a", ray.origin.x, ray.origin.y,
                ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z, ray.t_max);
  return text;
}

/// Rays that hit nothing by definition.
inline std::vector<Ray> bad_rays() {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  std::vector<Ray> rays{
      {{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 1e-310, 0}}, {{0, 0, 0}, {0, 0, 1}, nan}, {{0, 0, 0}, {0, 0, 1}, -1.0}};
  for (const double bad : {nan, infinity, -infinity})
    for (int a = 0; a < 3; ++a) {
      Ray origin{{0, 0, 0}, {0, 0, 1}}, direction = origin;
      origin.origin[a] = direction.direction[a] = bad;
      rays.insert(rays.end(), {origin, direction});
    }
  return rays;
}

/// Random rays and adversarial ones: along axes, in split planes and grid lines, through corners of nodes, through
/// vertices and edges, from inside, from the surface, from far, in planes of triangles, with limits.
class RaySource {
 public:
  RaySource(const Structures& structures, Random& random) : s_(structures), random_(random) {
    boxes_ = node_boxes(s_.kd);
  }

  Ray next() {
    Ray ray = s_.triangles.size() == 0 ? Ray{random_point(random_, -1, 1), random_point(random_, -1, 1)} : aimed();
    switch (pick(random_, 12)) {  // directions
      case 0:
        ray.direction[int(pick(random_, 3))] = pick(random_, 2) == 0 ? 0.0 : -0.0;
        break;
      case 1:
        ray.direction = axis(pick(random_, 6));
        break;
      case 2:
        ray.direction[int(pick(random_, 3))] *= 1e-30;
        break;
      case 3:
        ray.direction *= std::exp(uniform(random_, -20.0, 20.0));
        break;
      case 4:
        ray.direction = glm::sign(ray.direction);
        break;
      default:
        break;
    }
    if (pick(random_, 6) == 0) ray.t_max = uniform(random_, 0.0, 2.0) * scale() / (glm::length(ray.direction) + 1e-300);
    return ray;
  }

 private:
  double scale() const { return s_.triangles.space().size; }
  dvec3 to_scene(const dvec3& p) const { return s_.triangles.space().corner + scale() * p; }
  static dvec3 axis(std::uint32_t i) {
    dvec3 d(0.0);
    d[int(i % 3)] = i < 3 ? 1.0 : -1.0;
    return d;
  }

  /// In the unit cube or around it.
  dvec3 origin() {
    switch (pick(random_, 8)) {
      case 0:
        return random_point(random_, -1000.0, 1000.0);
      case 1:
        return random_point(random_, -1e6, 1e6);
      case 2:
      case 3:
        return random_point(random_, -2.0, 3.0);
      default:
        return random_point(random_, 0.0, 1.0);
    }
  }

  dvec3 surface_point() {
    const auto& c = s_.triangles.corners(pick(random_, s_.triangles.size()));
    const double u = uniform(random_, 0.0, 1.0), v = uniform(random_, 0.0, 1.0 - u);
    const dvec3 a(c[0]), b(c[1]), d(c[2]);
    switch (pick(random_, 4)) {
      case 0:
        return a;
      case 1:
        return a + u * (b - a);
      case 2:
        return 0.5 * (a + b);
      default:
        return a + u * (b - a) + v * (d - a);
    }
  }

  /// A corner of a node's box, in the unit cube; its faces are split planes.
  dvec3 node_corner() {
    const core::Aabb& box = boxes_[pick(random_, boxes_.size())];
    dvec3 corner;
    for (int a = 0; a < 3; ++a) corner[a] = double((pick(random_, 2) == 0 ? box.min : box.max)[a]);
    return corner;
  }

  dvec3 line_crossing() {
    const GridLines& lines = pick(random_, 2) == 0 ? s_.grid.lines : s_.sbg.lines;
    dvec3 p;
    for (int a = 0; a < 3; ++a)
      p[a] = double(lines.line(a, std::int32_t(pick(random_, std::size_t(lines.cells[std::size_t(a)]) + 1))));
    return p;
  }

  Ray aimed() {
    const dvec3 from = to_scene(origin());
    switch (pick(random_, 9)) {
      case 0:
        return {from, random_point(random_, -1.0, 1.0) * scale()};
      case 1:
        return {from, to_scene(node_corner()) - from};
      case 2:
        return {from, to_scene(line_crossing()) - from};
      case 3:
        return {to_scene(node_corner()), random_point(random_, -1.0, 1.0)};
      case 4:
        return {surface_point(), random_point(random_, -1.0, 1.0) * scale()};
      case 5: {  // in a split plane or a grid line
        const dvec3 in_plane = to_scene(pick(random_, 2) == 0 ? node_corner() : line_crossing());
        const int across = int(pick(random_, 3));
        Ray ray{from, random_point(random_, -1.0, 1.0)};
        ray.origin[across] = in_plane[across];
        ray.direction[across] = 0.0;
        return ray;
      }
      case 6: {  // in the plane of a triangle
        const auto& c = s_.triangles.corners(pick(random_, s_.triangles.size()));
        const dvec3 a(c[0]), u = dvec3(c[1]) - a, v = dvec3(c[2]) - a;
        if (pick(random_, 2) == 0) return {a - 3.0 * u, u};  // along an edge
        const dvec3 inside = a + uniform(random_, 0.0, 0.5) * u + uniform(random_, 0.0, 0.5) * v;
        const dvec3 direction = uniform(random_, -1.0, 1.0) * u + uniform(random_, -1.0, 1.0) * v;
        return {inside - 3.0 * direction, direction};
      }
      default:
        return {from, surface_point() - from};
    }
  }

  const Structures& s_;
  Random& random_;
  std::vector<core::Aabb> boxes_;
};

}  // namespace sightline::study::rays::tests
