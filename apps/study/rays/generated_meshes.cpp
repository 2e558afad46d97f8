#include "sightline/apps/study/rays/generated_meshes.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace sightline::study::rays {
namespace {

using core::dvec3;
using core::vec3;

/// The radius of the surface in this direction, about 1.
double radius(const dvec3& direction) {
  double r = 1.0;
  for (double frequency = 3.0, height = 0.08; frequency < 200.0; frequency *= 2.1, height *= 0.5)
    r += height * std::sin(frequency * direction.x + 1.3) * std::sin(frequency * direction.y + 0.7) *
         std::sin(frequency * direction.z + 2.1);
  return r;
}

/// Adds a scan of six faces of n by n squares each.
void add_scan(GeneratedMesh& mesh, int n, const dvec3& centre, double size) {
  for (int face = 0; face < 6; ++face) {
    const std::uint32_t first = std::uint32_t(mesh.positions.size());
    const int axis = face % 3;
    const double side = face < 3 ? 1.0 : -1.0;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        // Equal angles give triangles of about one size.
        dvec3 p;
        p[axis] = side;
        p[(axis + 1) % 3] = side * std::tan(0.785398163397448 * (2.0 * i / n - 1.0));
        p[(axis + 2) % 3] = std::tan(0.785398163397448 * (2.0 * j / n - 1.0));
        p = glm::normalize(p);
        mesh.positions.push_back(vec3(centre + size * radius(p) * p));
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const std::uint32_t a = first + std::uint32_t(j * (n + 1) + i), b = a + std::uint32_t(n) + 1;
        mesh.indices.insert(mesh.indices.end(), {a, a + 1, b, a + 1, b + 1, b});
      }
  }
}

int squares_for(double triangles) {
  return std::max(1, int(std::lround(std::sqrt(triangles / 12.0))));
}

}  // namespace

GeneratedMesh make_scan(std::size_t triangles) {
  GeneratedMesh mesh;
  add_scan(mesh, squares_for(double(triangles)), dvec3(0.0), 1.0);
  return mesh;
}

GeneratedMesh make_scattered(std::size_t triangles) {
  constexpr int kScans = 100;
  constexpr double kGround = 20.0;
  std::mt19937_64 random(2011);
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
  GeneratedMesh mesh;
  for (int i = 0; i < kScans; ++i) {
    const double size = 2.0 * std::pow(30.0, -uniform(0.0, 1.0));
    const double x = uniform(-kGround, kGround), y = uniform(-kGround, kGround);
    add_scan(mesh, squares_for(double(triangles) / kScans), {x, y, size}, size);
  }
  const std::uint32_t first = std::uint32_t(mesh.positions.size());
  for (const auto& [x, y] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}})
    mesh.positions.push_back(vec3(x, y, 0.0f) * vec3(1.2f * float(kGround)));
  mesh.indices.insert(mesh.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
  return mesh;
}

}  // namespace sightline::study::rays
