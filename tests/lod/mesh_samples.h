// Meshes for the tests of lod: smooth, rough, and hostile ones.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "sightline/core/mesh.h"

namespace sightline::tests {

using MeshRandom = std::mt19937_64;

inline double between(MeshRandom& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Triangles between points of a grid of `columns` x `rows` cells.
inline core::Mesh grid_mesh(std::uint32_t columns, std::uint32_t rows,
                            const std::function<core::dvec3(double u, double v)>& point) {
  core::Mesh mesh;
  for (std::uint32_t j = 0; j <= rows; ++j)
    for (std::uint32_t i = 0; i <= columns; ++i)
      mesh.positions.emplace_back(point(double(i) / columns, double(j) / rows));
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = j * (columns + 1) + i, c = a + columns + 1;
      for (const std::uint32_t corner : {a, a + 1, c, a + 1, c + 1, c}) mesh.indices.push_back(corner);
    }
  return mesh;
}

/// Hills, open at the border.
inline core::Mesh terrain(std::uint32_t cells, double roughness) {
  return grid_mesh(cells, cells, [=](double u, double v) {
    double height = 0.0;
    for (int octave = 1; octave < 7; ++octave) {
      const double s = std::exp2(octave);
      height += std::sin(3.1 * s * u + octave) * std::cos(2.7 * s * v + 2 * octave) * std::pow(s, roughness - 2.0);
    }
    return core::dvec3(10.0 * u, 10.0 * v, height);
  });
}

/// A closed torus with bumps: the seams' vertices have equal positions.
inline core::Mesh bumpy_torus(std::uint32_t cells, double bumps) {
  return grid_mesh(2 * cells, cells, [=](double u, double v) {
    const double a = u < 1.0 ? 2.0 * std::numbers::pi * u : 0.0, b = v < 1.0 ? 2.0 * std::numbers::pi * v : 0.0;
    const double tube = 1.0 + bumps * std::sin(7 * a) * std::cos(5 * b);
    const double ring = 3.0 + tube * std::cos(b);
    return core::dvec3(ring * std::cos(a), ring * std::sin(a), tube * std::sin(b));
  });
}

/// A closed cylinder with normals: its rims are creases, where positions have two vertices.
inline core::Mesh smooth_cylinder(std::uint32_t segments) {
  core::Mesh mesh;
  const auto add = [&](double angle, double z, const core::vec3& normal) {
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), z);
    mesh.normals.push_back(normal);
  };
  for (std::uint32_t i = 0; i < segments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / segments;
    const core::vec3 side(std::cos(angle), std::sin(angle), 0.0);
    add(angle, 0.0, side), add(angle, 4.0, side), add(angle, 0.0, {0, 0, -1}), add(angle, 4.0, {0, 0, 1});
  }
  for (std::uint32_t i = 0; i < segments; ++i) {
    const std::uint32_t a = 4 * i, b = 4 * ((i + 1) % segments);
    for (const std::uint32_t corner : {a, b, a + 1, b, b + 1, a + 1}) mesh.indices.push_back(corner);
    if (i == 0 || i + 1 == segments) continue;
    for (const std::uint32_t corner : {2u, b + 2, a + 2, 3u, a + 3, b + 3}) mesh.indices.push_back(corner);
  }
  return mesh;
}

/// A closed torus of which every position of the seams has two vertices with normals of their own, one at 0 and one at
/// -0, as sines and cosines of a full turn and mirrored halves have them.
inline core::Mesh torus_with_minus_zeros(std::uint32_t cells) {
  core::Mesh mesh = bumpy_torus(cells, 0.0);
  for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) {
    const float u = float(i % (2 * cells + 1)), v = float(i / (2 * cells + 1));
    mesh.normals.emplace_back(glm::normalize(core::vec3(u, v, 1.0f)));
    if (u > float(cells) || v > float(cells / 2))
      for (int k = 0; k < 3; ++k)
        if (mesh.positions[i][k] == 0.0f) mesh.positions[i][k] = -0.0f;
  }
  return mesh;
}

inline core::Mesh joined(core::Mesh a, const core::Mesh& b, const core::vec3& shift) {
  const auto first = std::uint32_t(a.positions.size());
  for (const core::vec3& p : b.positions) a.positions.push_back(p + shift);
  for (const std::uint32_t corner : b.indices) a.indices.push_back(first + corner);
  return a;
}

/// Closed shells each of which touches one before in a position, so that groups share vertices inside of their
/// surfaces.
inline core::Mesh touching_tori(std::uint32_t cells, int count, MeshRandom& random) {
  const core::Mesh torus = bumpy_torus(cells, 0.1);
  core::Mesh mesh = torus;
  while (--count > 0) {
    const core::vec3 to = mesh.positions[random() % mesh.positions.size()];
    const core::vec3 from = torus.positions[random() % torus.positions.size()];
    const auto first = mesh.positions.size();
    mesh = joined(std::move(mesh), torus, to - from);
    for (std::size_t i = 0; i < torus.positions.size(); ++i)
      if (torus.positions[i] == from) mesh.positions[first + i] = to;
  }
  return mesh;
}

/// Triangles without vertices in common.
inline core::Mesh soup_of(const core::Mesh& mesh) {
  core::Mesh soup;
  for (const std::uint32_t corner : mesh.indices) {
    soup.indices.push_back(std::uint32_t(soup.positions.size()));
    soup.positions.push_back(mesh.positions[corner]);
  }
  return soup;
}

/// Gives triangles normals. A position has a vertex for each group of triangles there, with the mean normal of
/// these: all in one group is smooth, each in its own is flat.
inline core::Mesh with_normals(const core::Mesh& mesh, const std::function<std::size_t(std::size_t triangle)>& group) {
  const std::vector<std::uint32_t> welded = core::weld(mesh.positions);
  std::map<std::pair<std::uint32_t, std::size_t>, std::uint32_t> vertices;
  core::Mesh made;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const auto corner = [&](std::size_t k) { return mesh.positions[mesh.indices[i / 3 * 3 + k]]; };
    const std::uint32_t at = welded[mesh.indices[i]];
    const auto [place, fresh] = vertices.try_emplace({at, group(i / 3)}, std::uint32_t(made.positions.size()));
    if (fresh) made.positions.push_back(mesh.positions[at]), made.normals.emplace_back(0.0f);
    made.indices.push_back(place->second);
    made.normals[place->second] += glm::cross(corner(1) - corner(0), corner(2) - corner(0));
  }
  for (core::vec3& normal : made.normals) normal = glm::normalize(normal);
  return made;
}

struct NamedMesh {
  std::string name;
  core::Mesh mesh;
};

/// Surfaces as files have them, each closed unless its name says otherwise.
inline std::vector<NamedMesh> ordinary_meshes() {
  core::Mesh bolts = bumpy_torus(24, 0.05);
  for (int i = 0; i < 30; ++i)
    bolts = joined(std::move(bolts), bumpy_torus(3, 0.0), {8.0f + 9.0f * float(i), 0.0f, 0.0f});
  return {{"open terrain", terrain(64, 1.0)},
          {"open rough terrain", terrain(40, 1.9)},
          {"torus", bumpy_torus(40, 0.1)},
          {"small torus", bumpy_torus(8, 0.0)},
          {"cylinder with creases", smooth_cylinder(60)},
          {"torus with minus zeros", torus_with_minus_zeros(40)},
          {"soup of a torus", soup_of(bumpy_torus(20, 0.2))},
          {"torus and many small shells", bolts}};
}

/// Meshes that no program should write, some of which programs write. All coordinates are finite.
inline std::vector<NamedMesh> hostile_meshes(std::uint64_t seed) {
  MeshRandom random(seed);
  std::vector<NamedMesh> meshes;
  const auto add = [&](const char* name, core::Mesh mesh) { meshes.push_back({name, std::move(mesh)}); };

  core::Mesh any;
  for (int i = 0; i < 60; ++i) {
    const double z = between(random, -1, 1), y = between(random, -1, 1), x = between(random, -1, 1);
    any.positions.emplace_back(x, y, z);
  }
  for (int i = 0; i < 900; ++i) any.indices.push_back(std::uint32_t(random() % 60));
  add("random triangles of few points", any);

  core::Mesh twice = terrain(16, 1.5);
  for (std::size_t i = 0, n = twice.indices.size(); i < n; ++i) twice.indices.push_back(twice.indices[n - 1 - i]);
  add("every triangle in both directions", twice);

  core::Mesh points = terrain(16, 1.0);
  for (std::size_t i = 0; i < points.indices.size(); i += 9) points.indices[i] = points.indices[i + 1];
  add("a third degenerate", points);

  core::Mesh point;
  point.positions.assign(400, core::vec3(1, 2, 3));
  for (std::uint32_t i = 0; i < 399; ++i) point.indices.push_back(i);
  add("one point", point);

  core::Mesh line;
  for (int i = 0; i < 400; ++i) line.positions.emplace_back(i % 40, 0, 0);
  for (std::uint32_t i = 0; i < 399; ++i) line.indices.push_back(i);
  add("a line", line);

  core::Mesh fan;  // a hundred triangles at one edge
  fan.positions = {{0, 0, 0}, {0, 0, 1}};
  for (std::uint32_t i = 0; i < 100; ++i) {
    fan.positions.emplace_back(std::cos(0.06 * i), std::sin(0.06 * i), between(random, 0, 1));
    for (const std::uint32_t corner : {0u, 1u, i + 2}) fan.indices.push_back(corner);
  }
  add("a fan of pages", fan);

  core::Mesh needles = terrain(24, 1.0);
  for (core::vec3& p : needles.positions) p.x *= 1e-6f;
  add("needles", needles);

  core::Mesh spikes = terrain(24, 1.0);
  for (std::size_t i = 0; i < spikes.positions.size(); i += 7) spikes.positions[i].z += float(between(random, -50, 50));
  add("spikes", spikes);

  core::Mesh far = terrain(24, 1.0);
  for (core::vec3& p : far.positions) p += core::vec3(1e7f, -1e7f, 1e7f);
  add("far from the origin", far);

  core::Mesh huge = bumpy_torus(12, 0.2);
  for (core::vec3& p : huge.positions) p *= 1e30f;
  add("huge", huge);

  core::Mesh tiny = bumpy_torus(12, 0.2);
  for (core::vec3& p : tiny.positions) p *= 1e-30f;
  add("tiny", tiny);

  const core::Mesh sheet = terrain(16, 1.0);
  add("two sheets a micrometre apart", joined(sheet, sheet, {0.0f, 0.0f, 1e-6f}));
  add("the same sheet twice", joined(sheet, sheet, core::vec3(0.0f)));

  // Coarser levels close holes, where they lie far from this mesh, but this mesh near them.
  core::Mesh holes = grid_mesh(60, 60, [&](double u, double v) { return core::dvec3(u, v, 0.0); });
  std::vector<std::uint32_t> left;
  for (std::size_t i = 0; i < holes.indices.size(); i += 6)
    if (random() % 5 < 3)
      left.insert(left.end(), holes.indices.begin() + std::ptrdiff_t(i), holes.indices.begin() + std::ptrdiff_t(i) + 6);
  holes.indices = left;
  add("a flat sheet with holes", holes);

  core::Mesh folded = grid_mesh(30, 30, [](double u, double v) {
    return core::dvec3(u < 0.5 ? u : 1.0 - u, v, u < 0.5 ? 0.0 : 1e-3 * (u - 0.5));
  });
  add("folded on itself", folded);
  return meshes;
}

}  // namespace sightline::tests
