// Analytic primitives recognised in triangle meshes.
#include "sightline/importers/recognise/internal/recognise.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sightline/core/mesh_extras.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/importers/obj/obj_writer.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/tests/importers/random_recognition.h"
#include "sightline/tests/importers/triangle_distance.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::recognise_test {
namespace {

using core::dmat3;
using core::dvec3;
using core::Kind;
using core::Primitive;

constexpr double kPi = std::numbers::pi;
constexpr int kSegments[] = {8, 12, 24, 64};

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * (double(engine_()) / double(engine_.max())); }
  std::uint32_t below(std::uint32_t count) { return std::uint32_t(engine_() % count); }
  dmat3 rotation() {
    dvec3 axis(0.0);
    do axis = {between(-1, 1), between(-1, 1), between(-1, 1)};
    while (glm::length(axis) < 0.1 || glm::length(axis) > 1.0);
    axis = glm::normalize(axis);
    const double angle = between(0.0, 2.0 * kPi), c = std::cos(angle), s = std::sin(angle);
    dmat3 m;
    for (int k = 0; k < 3; ++k) {
      dvec3 e(0.0);
      e[k] = 1.0;
      m[k] = c * e + s * glm::cross(axis, e) + (1.0 - c) * glm::dot(axis, e) * axis;
    }
    return m;
  }

 private:
  std::mt19937 engine_;
};

/// Primitives whose triangles tell them from all others at the given segments of a full circle.
std::vector<Primitive> samples(Random& random) {
  const auto size = [&] { return float(random.between(0.2, 2.0)); };
  const float r = size(), h = size(), angle = float(random.between(0.9, 4.5));
  return {
      core::Cylinder{r, h},
      core::Cylinder{r, 20.0f * h},
      core::Cylinder{r, 0.1f * r},
      core::Snout{r, 0.6f * r, h, 0, 0, 0, 0, 0, 0},
      core::Snout{r, 0.0f, h, 0, 0, 0, 0, 0, 0},
      core::Snout{r, 1.5f * r, h, 0.4f * r, 0.3f * r, 0, 0, 0, 0},
      core::Snout{r, r, 4.0f * r, 0, 0, 0.2f, 0.1f, -0.3f, 0.15f},
      core::Snout{r, 0.7f * r, 4.0f * r, 0, 0, 0.2f, 0.1f, -0.1f, 0.15f},
      core::Snout{r, r, 4.0f * r, 0, 0, 0.02f, 0, -0.01f, 0},
      core::CircularTorus{3.0f * r, r, angle},
      core::CircularTorus{1.2f * r, r, float(0.5 * kPi)},
      core::CircularTorus{3.0f * r, r, float(2.0 * kPi)},
      core::RectangularTorus{r, 1.8f * r, h, 1.6f + 0.5f * angle},
      core::RectangularTorus{r, 1.8f * r, h, float(2.0 * kPi)},
      core::RectangularTorus{0.0f, r, h, 2.0f},
      core::RectangularTorus{0.0f, r, h, 4.5f},
      core::Sphere{r},
      core::SphericalDish{r, 0.7f * r},
      core::EllipticalDish{r, 0.5f * r},
      core::EllipticalDish{r, 1.5f * r},
      core::Box{r, h, 0.3f * h + 0.5f * r},
      core::Pyramid{r, h, 0.5f * r, 0.7f * h, 0.1f * r, -0.2f * h, 1.5f * r},
      core::Pyramid{r, h, 0, 0, 0, 0, 1.5f * r},
      core::Pyramid{r, h, 0, 0.5f * h, 0.3f * r, 0, 1.5f * r},
  };
}

core::Mesh placed(core::Mesh mesh, const dmat3& linear, const dvec3& origin) {
  for (core::vec3& p : mesh.positions) p = core::vec3(linear * dvec3(p) + origin);
  for (core::vec3& n : mesh.normals) n = core::vec3(glm::normalize(linear * dvec3(n)));
  return mesh;
}

core::Mesh tessellated(const Primitive& primitive, int segments) {
  return gpuprims::tessellate(primitive, {.fixed_segments = segments});
}

/// Every triangle with corners of its own, in any order.
core::Mesh soup(const core::Mesh& mesh, Random& random) {
  std::vector<std::uint32_t> order(mesh.indices.size() / 3);
  for (std::uint32_t t = 0; t < order.size(); ++t) order[t] = t;
  for (std::size_t t = order.size(); t > 1; --t) std::swap(order[t - 1], order[random.below(std::uint32_t(t))]);
  core::Mesh out;
  for (const std::uint32_t t : order) {
    const std::uint32_t turn = random.below(3);
    for (std::uint32_t k = 0; k < 3; ++k) {
      out.indices.push_back(std::uint32_t(out.positions.size()));
      out.positions.push_back(mesh.positions[mesh.indices[3 * t + (k + turn) % 3]]);
    }
  }
  return out;
}

void append(core::Mesh& to, const core::Mesh& mesh) {
  const auto first = std::uint32_t(to.positions.size());
  to.positions.insert(to.positions.end(), mesh.positions.begin(), mesh.positions.end());
  for (const std::uint32_t i : mesh.indices) to.indices.push_back(first + i);
}

/// How far two convex hulls are apart: by their support functions, in many directions of the world.
double apart(const Primitive& p, const core::Affine& at_p, const Primitive& q, const core::Affine& at_q,
             Random& random) {
  double most = 0.0;
  for (int i = 0; i < 200; ++i) {
    const dvec3 d = random.rotation()[0];
    const auto reach = [&](const Primitive& of, const core::Affine& at) {
      return core::support(of, glm::transpose(at.linear) * d) + glm::dot(d, at.origin);
    };
    most = std::max(most, std::fabs(reach(p, at_p) - reach(q, at_q)));
  }
  return most;
}

std::string told(const Primitive& primitive) {
  std::string text(core::name_of(core::kind_of(primitive)));
  for (const float v : core::parameters(primitive)) text += " " + std::to_string(v);
  return text;
}

TEST(Recognise, EveryKindComesBack) {
  double worst = 0.0;
  for (unsigned seed = 0; seed < 6; ++seed) {
    Random random(seed);
    for (const int segments : kSegments)
      for (const Primitive& primitive : samples(random)) {
        const double scale = std::pow(10.0, random.between(-2.0, 2.0));
        const core::Affine place{random.rotation(),
                                 scale * dvec3(random.between(-3, 3), random.between(-3, 3), random.between(-3, 3))};
        const core::Mesh own = tessellated(primitive, segments);
        core::Affine scaled = place;
        scaled.linear *= scale;
        const core::Mesh indexed = placed(own, scaled.linear, scaled.origin);
        for (const core::Mesh& mesh : {indexed, soup(indexed, random)}) {
          SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << segments << " segments, " << told(primitive));
          const RecognisedMesh found = recognise(mesh);
          ASSERT_EQ(found.primitives.size(), 1u);
          const RecognisedPrimitive& one = found.primitives[0];
          EXPECT_EQ(core::kind_of(primitive), core::kind_of(one.primitive)) << told(one.primitive);
          EXPECT_EQ(one.triangles, mesh.indices.size() / 3);
          EXPECT_TRUE(found.rest.indices.empty());
          const double off = apart(primitive, scaled, one.primitive, one.mesh_from_primitive, random) / scale;
          EXPECT_LE(off, 2e-5) << told(one.primitive);
          worst = std::max(worst, off);
        }
      }
  }
  RecordProperty("worst", std::to_string(1e6 * worst) + " millionths");
}

/// A scene whose primitives are meshes, each with its own.
core::Scene as_meshes(const core::Scene& scene, int segments) {
  core::Scene out;
  scene.for_each_node(scene.root(),
                      [&](core::NodeId node, const core::Affine& world, bool, std::uint32_t, core::MaterialId) {
                        const core::NodeId copy = out.add_node(out.root(), "n" + std::to_string(node.index), world);
                        for (core::ItemId i = scene.first_item(node); i != core::kNoItem; i = scene.next_item(i)) {
                          if (int(scene.kind(i)) >= core::kPrimitiveKindCount) continue;
                          core::Mesh mesh = tessellated(scene.primitive(i), segments);
                          if (!mesh.indices.empty())
                            out.add_mesh_instance(copy, out.add_mesh(std::move(mesh)).value(), scene.placement(i));
                        }
                      });
  return out;
}

struct Recovery {
  std::uint64_t triangles = 0, recovered = 0, items = 0, matched = 0;
  RecognitionReport report;
};

/// Through an OBJ file and back. matched: primitives that are those of the scene.
Recovery round_trip(const core::Scene& scene, int segments) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "sightline_recognise";
  std::filesystem::create_directories(folder);
  const auto path = folder / (std::to_string(segments) + ".obj");
  const core::Scene meshes = as_meshes(scene, segments);
  const auto written = write_obj(meshes, meshes.root(), path);
  EXPECT_TRUE(written) << written.error().message;
  core::Scene again;
  const auto read = import_file(path, again, again.root(), {.recognise = true});
  std::filesystem::remove(path);
  EXPECT_TRUE(read) << read.error().message;
  Recovery out;
  if (!written || !read) return out;
  out.report = read->recognition;
  out.triangles = written->triangles;
  std::uint64_t left = 0;
  Random random(1);
  struct Known {
    Primitive primitive;
    core::Affine world;
  };
  std::map<std::tuple<int, int, int>, std::vector<Known>> known;  // by the middle of their bounds
  const auto cell = [](const dvec3& p) { return glm::floor(p / 0.01); };
  for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) {
    if (!scene.contains_item(i) || int(scene.kind(i)) >= core::kPrimitiveKindCount) continue;
    const core::Affine world = scene.state(i).world_from_item;
    const core::AabbD box = core::bounds(scene.primitive(i), world);
    const dvec3 c = cell(0.5 * (box.min + box.max));
    known[{int(c.x), int(c.y), int(c.z)}].push_back({scene.primitive(i), world});
  }
  for (core::ItemId i{0}; to_index(i) < again.item_slots(); ++i) {
    if (!again.contains_item(i)) continue;
    if (int(again.kind(i)) >= core::kPrimitiveKindCount) {
      left += again.mesh(again.mesh_of(i)).indices.size() / 3;
      continue;
    }
    ++out.items;
    const core::Affine world = again.state(i).world_from_item;
    const core::AabbD box = core::bounds(again.primitive(i), world);
    const dvec3 c = cell(0.5 * (box.min + box.max));
    bool found = false;
    for (int k = 0; k < 27 && !found; ++k) {
      const auto at = known.find({int(c.x) + k % 3 - 1, int(c.y) + k / 3 % 3 - 1, int(c.z) + k / 9 - 1});
      if (at == known.end()) continue;
      for (const Known& one : at->second)
        found = found || apart(one.primitive, one.world, again.primitive(i), world, random) <=
                             1e-3 * glm::length(box.max - box.min);
    }
    out.matched += found;
  }
  out.recovered = written->triangles - left;
  return out;
}

/// At 8 and 12 segments a plant has single rows in its flattest dishes: these are cones, to the triangle.
void expect_recovered(const core::Scene& scene, const std::string& name, int segments) {
  SCOPED_TRACE(testing::Message() << segments << " segments");
  const Recovery r = round_trip(scene, segments);
  EXPECT_GE(double(r.recovered), (segments >= 12 ? 0.99 : 0.95) * double(r.triangles));
  EXPECT_GT(r.items, 0u);
  EXPECT_GE(double(r.matched), 0.99 * double(r.items));
  EXPECT_LE(r.report.triangles_before, r.triangles);  // those of shared meshes count once
  EXPECT_LE(r.report.triangles_after, r.triangles - r.recovered);
  EXPECT_LT(r.report.bytes_after, r.report.bytes_before / 10);
  testing::Test::RecordProperty(name + "_" + std::to_string(segments),
                                std::to_string(r.recovered) + " of " + std::to_string(r.triangles) + " triangles, " +
                                    std::to_string(r.matched) + " of " + std::to_string(r.items) + " primitives");
}

TEST(Recognise, PlantsComeBackThroughObj) {
  core::Scene plant;
  ASSERT_TRUE(generate_plant({.items = 1500}, plant));
  for (const int segments : kSegments) expect_recovered(plant, "plant", segments);
}

/// Each with one number of segments in turn, or all in a long run.
TEST(Recognise, RealPlantsComeBackThroughObj) {
  std::size_t next = 0;
  for (const char* file : {"huldra/HA-PIPE.RVM", "huldra/HA-MECH.RVM", "huldra/WD1-PSUP.RVM"}) {
    SIGHTLINE_NEED_DATA(file);
    SCOPED_TRACE(file);
    core::Scene plant;
    ASSERT_TRUE(import_file(tests::data_path(file), plant, plant.root()));
    const std::size_t tried = tests::long_run() ? std::size(kSegments) : 1;
    for (std::size_t i = 0; i < tried; ++i) expect_recovered(plant, file, kSegments[next++ % std::size(kSegments)]);
  }
}

TEST(Recognise, RoundedCoordinates) {
  double worst = 0.0;
  for (unsigned seed = 0; seed < 6; ++seed) {
    Random random(seed);
    for (const int segments : kSegments)
      for (const Primitive& primitive : samples(random)) {
        const double step = 1e-4;
        const core::Affine place{random.rotation(), dvec3(random.between(-9, 9), random.between(-9, 9), 3.0)};
        core::Mesh mesh = placed(tessellated(primitive, segments), place.linear, place.origin);
        for (core::vec3& p : mesh.positions) p = core::vec3(step * glm::round(dvec3(p) / step));
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << segments << " segments, " << told(primitive));
        const RecognisedMesh found = recognise(soup(mesh, random));
        ASSERT_EQ(found.primitives.size(), 1u);
        const RecognisedPrimitive& one = found.primitives[0];
        EXPECT_EQ(core::kind_of(primitive), core::kind_of(one.primitive)) << told(one.primitive);
        EXPECT_TRUE(found.rest.indices.empty());
        const double off = apart(primitive, place, one.primitive, one.mesh_from_primitive, random) / step;
        EXPECT_LE(off, 10.0) << told(one.primitive);
        worst = std::max(worst, off);
      }
  }
  RecordProperty("worst", std::to_string(worst) + " steps");
}

/// A prism over a polygon in the plane z = 0, without normals.
core::Mesh prism(const std::vector<core::dvec2>& outline, double height, double twist = 0.0) {
  core::Mesh mesh;
  const auto n = std::uint32_t(outline.size());
  for (const double z : {0.0, height})
    for (const core::dvec2& p : outline) {
      const double angle = z > 0.0 ? twist : 0.0, c = std::cos(angle), s = std::sin(angle);
      mesh.positions.emplace_back(c * p.x - s * p.y, s * p.x + c * p.y, z);
    }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.indices.insert(mesh.indices.end(), {i, j, n + j, i, n + j, n + i});
    if (i > 0 && i + 1 < n) mesh.indices.insert(mesh.indices.end(), {0, i + 1, i, n, n + i, n + i + 1});
  }
  return mesh;
}

std::vector<core::dvec2> polygon(int n, double rx = 1.0, double ry = 1.0) {
  std::vector<core::dvec2> out;
  for (int i = 0; i < n; ++i) out.emplace_back(rx * std::cos(2 * kPi * i / n), ry * std::sin(2 * kPi * i / n));
  return out;
}

/// A closed surface over a grid of longitudes and latitudes.
template <class At>
core::Mesh lathe(int columns, int rows, const At& at) {
  core::Mesh mesh;
  for (int j = 1; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      mesh.positions.push_back(core::vec3(at(2 * kPi * i / columns, kPi * j / rows - kPi / 2)));
  const auto south = std::uint32_t(mesh.positions.size()), north = south + 1, n = std::uint32_t(columns);
  mesh.positions.push_back(core::vec3(at(0.0, -kPi / 2)));
  mesh.positions.push_back(core::vec3(at(0.0, kPi / 2)));
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t k = (i + 1) % n, last = (std::uint32_t(rows) - 2) * n;
    mesh.indices.insert(mesh.indices.end(), {south, k, i, north, last + i, last + k});
    for (std::uint32_t j = 0; j < last; j += n)
      mesh.indices.insert(mesh.indices.end(), {j + i, j + k, j + n + k, j + i, j + n + k, j + n + i});
  }
  return mesh;
}

dvec3 on_sphere(double u, double v) {
  return {std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v)};
}

TEST(Recognise, PrismsAndLathesOfTheTestsAreSolids) {
  EXPECT_EQ(recognise(prism(polygon(12), 2.0)).primitives.size(), 1u);
  EXPECT_EQ(core::kind_of(recognise(prism(polygon(12), 2.0)).primitives.at(0).primitive), Kind::kCylinder);
  EXPECT_EQ(core::kind_of(recognise(lathe(12, 6, on_sphere)).primitives.at(0).primitive), Kind::kSphere);
}

TEST(Recognise, NearlyIsNotEnough) {
  const auto expect_none = [](const core::Mesh& mesh, const char* what) {
    const RecognisedMesh found = recognise(mesh);
    EXPECT_TRUE(found.primitives.empty()) << what << " became a " << told(found.primitives[0].primitive);
  };
  expect_none(prism(polygon(6), 1.0), "hexagonal bar");
  expect_none(prism(polygon(12, 1.0, 0.97), 2.0), "elliptical bar");
  expect_none(prism(polygon(64, 1.0, 0.998), 2.0), "slightly elliptical bar");
  expect_none(prism(polygon(24), 2.0, kPi / 2.0), "twisted bar");
  std::vector<core::dvec2> d_bar = polygon(24);
  d_bar.erase(d_bar.begin() + 1, d_bar.begin() + 8);
  expect_none(prism(d_bar, 1.0), "bar with a flat side");
  std::vector<core::dvec2> gear = polygon(32);
  for (std::size_t i = 0; i < gear.size(); i += 2) gear[i] *= 0.9;
  expect_none(prism(gear, 0.3), "gear");
  expect_none(lathe(24, 12, [](double u, double v) { return on_sphere(u, v) * dvec3(1.0, 0.98, 1.0); }),
              "squeezed sphere");
  expect_none(
      lathe(24, 12, [](double u, double v) { return (1.0 + 0.02 * std::sin(5 * u) * std::cos(v)) * on_sphere(u, v); }),
      "wavy sphere");
  core::Mesh box = tessellated(core::Box{1, 2, 3}, 8);
  for (core::vec3& p : box.positions)
    if (p.x > 0 && p.y > 0 && p.z > 0) p += core::vec3(0.03f, 0, 0);
  expect_none(box, "box with one corner off");
  // Vertices off by a third of the sagitta, of all that has one.
  for (unsigned seed = 0; seed < 5; ++seed) {
    Random random(seed);
    for (const int segments : kSegments) {
      core::Mesh bar = prism(polygon(segments), 1.3);
      const double sagitta = 1.0 - std::cos(kPi / segments);
      for (core::vec3& p : bar.positions) {
        const double off = 1.0 + 0.33 * sagitta * (random.below(2) == 0 ? 1.0 : -1.0);
        p.x = float(p.x * off), p.y = float(p.y * off);
      }
      expect_none(bar, "rough bar");
    }
  }
}

TEST(Recognise, ToleranceWidensIt) {
  const core::Mesh bar = prism(polygon(12, 1.0, 0.97), 2.0);
  ASSERT_TRUE(recognise(bar).primitives.empty());
  const RecognisedMesh found = recognise(bar, 0.02);
  ASSERT_EQ(found.primitives.size(), 1u);
  EXPECT_EQ(core::kind_of(found.primitives[0].primitive), Kind::kCylinder);
  EXPECT_LE(found.primitives[0].deviation, 0.02 + 1.0 - std::cos(kPi / 12));
}

/// Found by the fuzzer. A ring between spheres a little larger and smaller, with a slit: all its triangles are near.
TEST(Recognise, ToleranceMakesNoSphereOfARing) {
  const core::Mesh ring = tessellated(core::RectangularTorus{1.45f, 1.55f, 1.9f, 5.9f}, 18);
  for (const double tolerance : {0.0, 0.11})
    for (const RecognisedPrimitive& one : recognise(ring, tolerance).primitives)
      EXPECT_NE(core::kind_of(one.primitive), Kind::kSphere) << tolerance;
}

TEST(Recognise, NothingInScansAndNoise) {
  Random random(1);
  core::Mesh noise;
  for (int i = 0; i < 3000; ++i) {
    noise.positions.emplace_back(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    noise.indices.push_back(random.below(3000));
  }
  EXPECT_TRUE(recognise(noise).primitives.empty());
  const core::Mesh bumpy =
      lathe(100, 50, [&](double u, double v) { return random.between(0.95, 1.05) * on_sphere(u, v); });
  EXPECT_TRUE(recognise(bumpy).primitives.empty());
  for (const char* file : {"meshes/stanford-bunny.ply", "meshes/rocker-arm.obj"}) {
    SIGHTLINE_NEED_DATA(file);
    core::Scene scene;
    const auto report = import_file(tests::data_path(file), scene, scene.root(), {.recognise = true});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->recognition.triangles_before, report->recognition.triangles_after) << file;
    EXPECT_EQ(scene.item_count(), 1u);
  }
}

TEST(Recognise, MixedMeshesAreSplit) {
  Random random(3);
  const core::Mesh bumpy =
      lathe(30, 15, [&](double u, double v) { return random.between(0.9, 1.1) * on_sphere(u, v); });
  core::Mesh mesh = bumpy;
  append(mesh, placed(prism(polygon(24), 2.0), dmat3(0.5), {0.2, 0.3, 0.4}));  // through one another
  append(mesh, placed(tessellated(core::Box{1, 2, 3}, 8), random.rotation(), {5, 0, 0}));
  const RecognisedMesh found = recognise(mesh);
  ASSERT_EQ(found.primitives.size(), 2u);
  EXPECT_EQ(core::kind_of(found.primitives[0].primitive), Kind::kCylinder);
  EXPECT_EQ(core::kind_of(found.primitives[1].primitive), Kind::kBox);
  EXPECT_EQ(found.rest.indices.size(), bumpy.indices.size());
  EXPECT_EQ(found.refused[std::size_t(Refusal::kNoStructure)] + found.refused[std::size_t(Refusal::kOffSurface)], 1u);
  for (std::size_t i = 0; i < found.rest.indices.size(); ++i)
    ASSERT_EQ(found.rest.positions[found.rest.indices[i]], bumpy.positions[bumpy.indices[i]]);
}

/// Faces keep the surfaces that came with them, as far as their triangles stay.
TEST(Recognise, TheRestKeepsItsSurfaces) {
  Random random(3);
  const core::Mesh bumpy =
      lathe(30, 15, [&](double u, double v) { return random.between(0.9, 1.1) * on_sphere(u, v); });
  core::Mesh mesh = placed(tessellated(core::Box{1, 2, 3}, 8), dmat3(1.0), {5, 0, 0});
  mesh.normals.clear();  // the ball has none
  const auto box = std::uint32_t(mesh.indices.size() / 3);
  append(mesh, bumpy);
  const auto all = std::uint32_t(mesh.indices.size() / 3);
  std::vector<core::MeshSurface> surfaces(4);
  const std::uint32_t ends[] = {box / 2, box + 10, box + 30, all};
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    surfaces[i].end_triangle = ends[i];
    surfaces[i].radius = double(i);
  }
  mesh.extras = core::MeshExtrasSlot({nullptr, std::make_shared<const std::vector<core::MeshSurface>>(surfaces)});
  const RecognisedMesh found = recognise(mesh);
  ASSERT_EQ(found.primitives.size(), 1u);
  const auto left = core::surfaces_stored_with(found.rest);
  ASSERT_EQ(left.size(), 3u);
  for (std::size_t i = 0; i < left.size(); ++i) {
    EXPECT_EQ(left[i].radius, double(i + 1));
    EXPECT_EQ(left[i].end_triangle, ends[i + 1] - box);
  }
}

/// Pipes whose solids have no ends where they meet, in one piece: rings along a path.
TEST(Recognise, PipesWithoutInnerEndsAreTakenApart) {
  struct Ring {
    dvec3 centre, along;
    double radius;
  };
  constexpr int kAround = 16;
  std::vector<Ring> rings = {{{0, 0, 0}, {0, 0, 1}, 0.5}, {{0, 0, 4}, {0, 0, 1}, 0.5}};
  for (int k = 1; k <= 4; ++k) {  // an elbow towards +x about (2, *, 4)
    const double a = 0.5 * kPi * k / 4;
    rings.push_back({{2 - 2 * std::cos(a), 0, 4 + 2 * std::sin(a)}, {std::sin(a), 0, std::cos(a)}, 0.5});
  }
  rings.push_back({{5, 0, 6}, {1, 0, 0}, 0.5});
  rings.push_back({{6, 0, 6}, {1, 0, 0}, 0.3});  // a reducer
  core::Mesh mesh;
  for (const Ring& ring : rings)
    for (int i = 0; i < kAround; ++i) {
      const dvec3 y(0, 1, 0), x = glm::cross(y, ring.along);
      const double a = 2 * kPi * i / kAround;
      mesh.positions.push_back(core::vec3(ring.centre + ring.radius * (std::cos(a) * x + std::sin(a) * y)));
    }
  const auto n = std::uint32_t(kAround);
  const auto last = std::uint32_t(rings.size() - 1) * n;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t k = (i + 1) % n;
    for (std::uint32_t j = 0; j < last; j += n)
      mesh.indices.insert(mesh.indices.end(), {j + i, j + k, j + n + k, j + i, j + n + k, j + n + i});
    if (i > 0 && i + 1 < n) mesh.indices.insert(mesh.indices.end(), {0, i + 1, i, last, last + i, last + i + 1});
  }
  Random random(1);
  const RecognisedMesh found = recognise(soup(mesh, random));
  ASSERT_EQ(found.primitives.size(), 4u);
  EXPECT_TRUE(found.rest.indices.empty());
  std::array<int, core::kPrimitiveKindCount> kinds{};
  for (const RecognisedPrimitive& p : found.primitives) ++kinds[std::size_t(core::kind_of(p.primitive))];
  EXPECT_EQ(kinds[std::size_t(Kind::kCylinder)], 2);
  EXPECT_EQ(kinds[std::size_t(Kind::kCircularTorus)], 1);
  EXPECT_EQ(kinds[std::size_t(Kind::kSnout)], 1);
}

TEST(Recognise, OpenAndInsideOutSolidsStay) {
  core::Mesh open = prism(polygon(12), 2.0);
  open.indices.resize(open.indices.size() - 3);
  RecognisedMesh found = recognise(open);
  EXPECT_TRUE(found.primitives.empty());
  EXPECT_EQ(found.refused[std::size_t(Refusal::kOpen)], 1u);
  core::Mesh hollow = tessellated(core::Box{10, 10, 10}, 8), cavity = prism(polygon(12), 2.0);
  for (std::size_t i = 0; i < cavity.indices.size(); i += 3) std::swap(cavity.indices[i], cavity.indices[i + 1]);
  hollow.normals.clear();
  append(hollow, cavity);
  found = recognise(hollow);
  ASSERT_EQ(found.primitives.size(), 1u);
  EXPECT_EQ(core::kind_of(found.primitives[0].primitive), Kind::kBox);
  EXPECT_EQ(found.refused[std::size_t(Refusal::kCavity)], 1u);
  EXPECT_EQ(recognise(cavity).primitives.size(), 1u) << "a file that is inside out as a whole";
}

TEST(Recognise, SharedMeshesStayShared) {
  core::Scene scene;
  core::Mesh mesh = prism(polygon(12), 2.0);
  append(mesh, placed(tessellated(core::Pyramid{1, 1, 0.5f, 0.5f, 0, 0, 1}, 8), dmat3(1.0), {9, 0, 0}));
  append(mesh, lathe(12, 6, [](double u, double v) {
           return dvec3(0, 0, 9) + (1.0 + 0.1 * std::sin(3 * u)) * on_sphere(u, v);
         }));
  const core::MeshId id = scene.add_mesh(mesh).value();
  const core::MaterialId red = scene.add_material({.name = "red"});
  const core::NodeId node = scene.add_node(scene.root(), "node", core::translation({1, 2, 3}));
  Random random(4);
  std::vector<core::Affine> placements(3);
  for (core::Affine& placement : placements) placement = {0.7 * random.rotation(), random.rotation()[1]};
  placements[1].linear = placements[1].linear * dmat3(-1, 0, 0, 0, 1, 0, 0, 0.3, 2);  // mirrored and sheared
  for (const core::Affine& placement : placements) scene.add_mesh_instance(node, id, placement, red);
  scene.set_visible(core::ItemId(2), false);
  RecognitionReport report;
  ASSERT_TRUE(recognise_items(scene, core::ItemId{0}, 0.0, {}, report));
  EXPECT_EQ(report.meshes, 1u);
  EXPECT_EQ(report.items[std::size_t(Kind::kCylinder)], 3u);
  EXPECT_EQ(report.items[std::size_t(Kind::kPyramid)], 3u);
  EXPECT_EQ(scene.item_count(), 9u);
  EXPECT_FALSE(scene.contains(id));
  std::vector<core::MeshId> rests;
  int cylinders = 0;
  for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) {
    if (!scene.contains_item(i)) continue;
    EXPECT_EQ(scene.node_of(i), node);
    EXPECT_EQ(scene.item_material(i), red);
    if (scene.kind(i) == Kind::kMesh) rests.push_back(scene.mesh_of(i));
    if (scene.kind(i) != Kind::kCylinder) continue;
    const core::Affine found = scene.placement(i);
    const core::Affine wanted = placements[std::size_t(cylinders)] * core::translation({0, 0, 1});
    EXPECT_EQ(scene.item_visible(i), cylinders != 2);
    EXPECT_LE(glm::length(found.origin - wanted.origin), 1e-6);
    EXPECT_LE(apart(core::Cylinder{1, 2}, wanted, scene.primitive(i), found, random), 1e-5);
    ++cylinders;
  }
  EXPECT_EQ(cylinders, 3);
  ASSERT_EQ(rests.size(), 3u);
  EXPECT_EQ(rests[0], rests[1]);
  EXPECT_EQ(rests[0], rests[2]);
  EXPECT_TRUE(scene.commit());
}

TEST(Recognise, WhatACommitWouldRefuseStaysAMesh) {
  // Turned, the polygon ends below the largest coordinate, and the circle beyond it.
  const double angle = glm::radians(15.0), large = 1.02e37;
  core::Mesh mesh = prism(polygon(12), 2.0);
  append(mesh, placed(lathe(12, 6, [](double u, double v) { return (1.0 + 0.1 * std::sin(3 * u)) * on_sphere(u, v); }),
                      dmat3(0.1), {0, 0, 9}));
  core::Affine turned;
  turned.linear = dmat3(large, 0, 0, 0, large, 0, 0, 0, 1) *
                  dmat3(std::cos(angle), std::sin(angle), 0, -std::sin(angle), std::cos(angle), 0, 0, 0, 1);
  for (const bool with_another : {false, true}) {
    SCOPED_TRACE(with_another);
    core::Scene scene;
    const core::MeshId id = scene.add_mesh(mesh).value();
    scene.add_mesh_instance(scene.root(), id, turned);
    if (with_another) scene.add_mesh_instance(scene.root(), id);
    RecognitionReport report;
    ASSERT_TRUE(recognise_items(scene, core::ItemId{0}, 0.0, {}, report));
    EXPECT_TRUE(scene.contains(id));
    EXPECT_EQ(report.items[std::size_t(Kind::kCylinder)], with_another ? 1u : 0u);
    EXPECT_EQ(scene.item_count(), with_another ? 3u : 1u);
    std::size_t triangles = 0, meshes = 0;
    for (std::size_t i = 0; i < scene.mesh_slots(); ++i)
      if (const core::MeshId left = scene.mesh_at(i); left.valid())
        triangles += scene.mesh(left).indices.size() / 3, ++meshes;
    EXPECT_EQ(meshes, with_another ? 2u : 1u);
    EXPECT_EQ(report.triangles_after, triangles);
    EXPECT_TRUE(scene.commit());
  }
}

TEST(Recognise, SameMeshSameResult) {
  Random random(5);
  core::Mesh mesh;
  for (const Primitive& primitive : samples(random))
    append(mesh, placed(tessellated(primitive, 12), random.rotation(), 9.0 * random.rotation()[0]));
  mesh = soup(mesh, random);
  const RecognisedMesh once = recognise(mesh), again = recognise(mesh);
  ASSERT_EQ(once.primitives.size(), again.primitives.size());
  for (std::size_t i = 0; i < once.primitives.size(); ++i) {
    const auto a = core::parameters(once.primitives[i].primitive), b = core::parameters(again.primitives[i].primitive);
    EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
    EXPECT_EQ(once.primitives[i].mesh_from_primitive.origin, again.primitives[i].mesh_from_primitive.origin);
    EXPECT_EQ(once.primitives[i].mesh_from_primitive.linear, again.primitives[i].mesh_from_primitive.linear);
  }
}

TEST(Recognise, HostileMeshes) {
  EXPECT_TRUE(recognise({}).primitives.empty());
  const float nan = std::numeric_limits<float>::quiet_NaN(), huge = std::numeric_limits<float>::max();
  Random random(6);
  const core::Mesh good = soup(prism(polygon(12), 2.0), random);
  for (const float bad : {nan, huge, -huge, std::numeric_limits<float>::infinity(), 0.0f, 1e-45f})
    for (int round = 0; round < 30; ++round) {
      core::Mesh mesh = good;
      for (std::uint32_t k = 0; k < 1 + random.below(20); ++k)
        mesh.positions[random.below(std::uint32_t(mesh.positions.size()))][int(random.below(3))] = bad;
      for (const RecognisedPrimitive& p : recognise(mesh).primitives)
        EXPECT_TRUE(core::is_finite(p.mesh_from_primitive));
    }
  core::Mesh broken = good;
  append(broken, core::Mesh{.name = {},
                            .positions = {{nan, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 5, 5}},
                            .normals = {},
                            .indices = {0, 1, 2, 3, 3, 3},
                            .contour_sizes = {},
                            .polygon_contours = {}});
  const RecognisedMesh found = recognise(broken);
  EXPECT_EQ(found.primitives.size(), 1u);
  EXPECT_EQ(found.refused[std::size_t(Refusal::kBroken)], 2u);
  EXPECT_EQ(found.rest.indices.size(), 6u);

  // All vertices within the rounding of one far one; all triangles around one edge; coplanar triangles, connected and
  // not; one solid twice.
  core::Mesh mesh;
  for (int i = 0; i < 100000; ++i)
    mesh.positions.emplace_back(random.between(0, 1e-4), random.between(0, 1e-4), random.between(0, 1e-4));
  for (std::uint32_t i = 0; i < 100000; ++i) mesh.indices.push_back(random.below(100000));
  mesh.indices.resize(mesh.indices.size() / 3 * 3);
  mesh.positions[0] = core::vec3(1e4f);
  (void)recognise(mesh);
  for (std::uint32_t i = 0; i + 2 < mesh.indices.size(); i += 3) mesh.indices[i] = 1, mesh.indices[i + 1] = 2;
  (void)recognise(mesh);
  mesh = {};
  constexpr std::uint32_t kSide = 400;
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      mesh.positions.emplace_back(float(x), float(y), 0.0f);
      const std::uint32_t v = y * kSide + x;
      if (x + 1 < kSide && y + 1 < kSide)
        mesh.indices.insert(mesh.indices.end(), {v, v + 1, v + kSide + 1, v, v + kSide + 1, v + kSide});
    }
  EXPECT_TRUE(recognise(mesh).primitives.empty());
  core::Mesh twice = good;
  append(twice, good);
  EXPECT_LE(recognise(twice).primitives.size(), 2u);
}

/// The largest distance of points of one mesh's triangles, `steps` to an edge, from the other's.
double farthest(const core::Mesh& from, const core::Mesh& to, int steps) {
  const auto corner = [](const core::Mesh& mesh, std::size_t i) { return dvec3(mesh.positions[mesh.indices[i]]); };
  double most = 0.0;
  for (std::size_t t = 0; t < from.indices.size(); t += 3)
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; i + j <= steps; ++j) {
        const dvec3 p = (double(i) * corner(from, t) + double(j) * corner(from, t + 1) +
                         double(steps - i - j) * corner(from, t + 2)) /
                        double(steps);
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t u = 0; u < to.indices.size() && nearest > most; u += 3)
          nearest =
              std::min(nearest, tests::distance_to_triangle(p, {corner(to, u), corner(to, u + 1), corner(to, u + 2)}));
        most = std::max(most, nearest);
      }
  return most;
}

/// Found by the fuzzer: corners that are close to all faces of a flat pyramid may be far from its own corners.
TEST(Recognise, DeviationsOfPyramidsAreThoseOfTheirCorners) {
  double most = 0.0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const double step = 1e-4;
    core::Mesh mesh = placed(tessellated(core::Pyramid{1.7f, 0.98f, 1.6f, 0.8f, 0.4f, -0.12f, 0.06f}, 8),
                             random.rotation(), {1, 2, 3});
    for (core::vec3& p : mesh.positions) p = core::vec3(step * glm::round(dvec3(p) / step));
    for (const RecognisedPrimitive& one : recognise(mesh).primitives) {
      const core::Mesh own =
          placed(tessellated(one.primitive, 8), one.mesh_from_primitive.linear, one.mesh_from_primitive.origin);
      for (const core::vec3& corner : own.positions) {
        double nearest = 1.0;
        for (const core::vec3& p : mesh.positions) nearest = std::min(nearest, double(glm::distance(p, corner)));
        EXPECT_LE(nearest, one.deviation + 1e-6) << "seed " << seed;
        most = std::max(most, nearest);
      }
    }
  }
  EXPECT_GT(most, 1e-4) << "a test of something";
}

/// Found by the fuzzer: between two circles a step of a float apart lies a cone whose ends are anywhere.
TEST(Recognise, StepsOfNoHeightAreNoSnouts) {
  const std::uint32_t n = 24;
  for (unsigned seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const core::Affine place{random.rotation(), {random.between(-9, 9), 2, 3}};
    const double step = random.between(0.0, 1e-6);
    core::Mesh mesh;
    for (const core::dvec2 ring : {core::dvec2(0.7, 0.0), {0.7, 2.0}, {0.3, 2.0 + step}, {0.3, 4.0}})
      for (std::uint32_t i = 0; i < n; ++i)
        mesh.positions.push_back(core::vec3(core::transform_point(
            place, {ring.x * std::cos(2 * kPi * i / n), ring.x * std::sin(2 * kPi * i / n), ring.y})));
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t k = (i + 1) % n;
      for (std::uint32_t j = 0; j < 3 * n; j += n)
        mesh.indices.insert(mesh.indices.end(), {j + i, j + k, j + n + k, j + i, j + n + k, j + n + i});
      if (i > 0 && i + 1 < n) mesh.indices.insert(mesh.indices.end(), {0, i + 1, i, 3 * n, 3 * n + i, 3 * n + i + 1});
    }
    const RecognisedMesh found = recognise(mesh);
    EXPECT_EQ(found.primitives.size(), 2u) << "seed " << seed;
    for (const RecognisedPrimitive& one : found.primitives)
      EXPECT_EQ(core::kind_of(one.primitive), Kind::kCylinder) << "seed " << seed << ": " << told(one.primitive);
  }
}

/// Against many points of the triangles and of the surfaces, under maps that stretch in any direction.
TEST(Recognise, TheLargestDeviationIsOneBothWays) {
  for (unsigned seed = 0; seed < (tests::long_run() ? 2u : 1u); ++seed) {
    Random random(seed);
    for (const Primitive& primitive : samples(random))
      for (int shape = 0; shape < 3; ++shape) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", map " << shape << ", " << told(primitive));
        core::Affine map{random.rotation(), {1, 2, 3}};
        if (shape == 1) map.linear = map.linear * dmat3(0.1, 0, 0, 0, 0.1, 0, 0, 0, 8);  // a pipe from a unit cylinder
        if (shape == 2) map.linear = map.linear * dmat3(2, 0, 0, 0.5, 1, 0.2, 0, -0.7, 0.4) * random.rotation();
        core::Mesh mesh = tessellated(primitive, 8);
        mesh.normals.clear();
        core::Scene scene;
        scene.add_mesh_instance(scene.root(), scene.add_mesh(mesh).value(), map);
        RecognitionReport report;
        ASSERT_TRUE(recognise_items(scene, core::ItemId{0}, 0.0, {}, report));
        ASSERT_EQ(report.triangles_after, 0u);
        const core::Mesh coarse = placed(mesh, map.linear, map.origin);
        core::Mesh fine = tessellated(primitive, 48);
        fine.normals.clear();
        fine = placed(fine, map.linear, map.origin);
        const double true_one = std::max(farthest(coarse, fine, 6), farthest(fine, coarse, 1));
        EXPECT_GE(report.largest_deviation, 0.95 * true_one - 1e-5);
        if (true_one < 1e-4) continue;
        if (shape == 0 || core::kind_of(primitive) == Kind::kCylinder) {  // of others a bound alone
          EXPECT_LE(report.largest_deviation, (shape == 2 ? 1.6 : 1.05) * true_one);
        }
      }
  }
}

TEST(Recognise, KeepsItsPromisesForAnyMesh) {
  std::uint64_t recognised = 0;
  for (unsigned seed = 0; seed < unsigned(tests::repeated(10'000)); ++seed) {
    std::mt19937 engine(seed);
    std::vector<std::uint8_t> bytes(300);
    for (std::uint8_t& byte : bytes) byte = std::uint8_t(engine());
    const tests::RecognitionInput input = tests::recognition_input(bytes.data(), bytes.size());
    ASSERT_EQ(tests::check_mesh(input), "") << "seed " << seed;
    ASSERT_EQ(tests::check_items(input), "") << "seed " << seed;
    recognised += recognise(input.mesh, input.tolerance).primitives.size();
  }
  EXPECT_GT(recognised, std::uint64_t(tests::repeated(10'000) / 3));
}

TEST(Recognise, ManyFacets) {
  const RecognisedMesh found = recognise(tessellated(core::Cylinder{1.0f, 3.0f}, 200000));
  ASSERT_EQ(found.primitives.size(), 1u);
  ASSERT_EQ(core::kind_of(found.primitives[0].primitive), Kind::kCylinder);
  EXPECT_NEAR(std::get<core::Cylinder>(found.primitives[0].primitive).radius, 1.0f, 1e-6f);
}

TEST(Recognise, CancelledImportsLeaveNothing) {
  core::Scene plant;
  ASSERT_TRUE(generate_plant({.items = 1000}, plant));
  const auto path = std::filesystem::path(testing::TempDir()) / "sightline_recognise_cancelled.obj";
  ASSERT_TRUE(write_obj(plant, plant.root(), path, {.tolerance = 0.05}));
  core::Scene scene;
  double last = 0.0;
  const auto report = import_file(path, scene, scene.root(), {.recognise = true, .progress = [&](double share) {
                                                                EXPECT_GE(share, last);
                                                                last = share;
                                                                return share < 0.7;
                                                              }});
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find(kCancelled), std::string::npos);
  EXPECT_GE(last, 0.7);
  EXPECT_EQ(scene.item_slots(), 0u);
  EXPECT_EQ(scene.node_count(), 1u);
  EXPECT_FALSE(import_file(path, scene, scene.root(), {.recognise = true, .recognise_tolerance = -1.0}));
  std::filesystem::remove(path);
}

TEST(Recognise, CachesKeepItApart) {
  core::Scene plant;
  ASSERT_TRUE(generate_plant({.items = 1000}, plant));
  const auto folder = std::filesystem::path(testing::TempDir()) / "sightline_recognise_cache";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::filesystem::path paths[] = {folder / "plant.obj"};
  ASSERT_TRUE(write_obj(plant, plant.root(), paths[0], {.tolerance = 0.05}));
  std::array<std::uint64_t, 2> items{};
  for (int round = 0; round < 2; ++round)  // the second time from the caches, if this build has any
    for (const bool recognised : {false, true}) {
      core::Scene scene;
      const auto report =
          import_files(paths, scene, scene.root(), {.recognise = recognised, .cache_folder = folder / "cache"});
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_EQ(report->recognition.meshes > 0, recognised);
      if (recognised) {
        EXPECT_GT(report->recognition.items[std::size_t(Kind::kCylinder)], 500u);
        EXPECT_GT(report->recognition.bytes_before, report->recognition.bytes_after);
        EXPECT_GT(report->recognition.largest_deviation, 0.0);
      }
      std::uint64_t& known = items[recognised ? 1 : 0];
      if (round == 0) known = scene.item_count();
      EXPECT_EQ(scene.item_count(), known);
    }
  EXPECT_GT(items[1], items[0]);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace sightline::importers::recognise_test
