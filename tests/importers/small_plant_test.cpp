// tests/data/small_plant.rvm and .txt: a file as plants have them, for machines without real ones. This file is its
// recipe:
//   SIGHTLINE_WRITE_DATA=1 build/release/tests/importers_tests --gtest_filter='SmallPlant.*'
// writes it anew. All eleven kinds, in metres 6,500 km from the origin; millimetres in the items' own units.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "sightline/core/snapshot.h"
#include "sightline/importers/import.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/tests/support/places.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::small_plant_test {
namespace {

using core::dmat3;
using core::dvec3;
using core::NodeId;

constexpr float kQuarter = 1.5707964f;

/// Steps of half a metre are what a float has left up there.
const dvec3 kSite(400'000.0, 6'500'000.0, 30.0);

// Where an item's z axis points.
const dmat3 kUp(1.0), kAlongX({0, 1, 0}, {0, 0, 1}, {1, 0, 0}), kAgainstX({0, 1, 0}, {0, 0, -1}, {-1, 0, 0}),
    kAlongY({0, 0, 1}, {1, 0, 0}, {0, 1, 0}), kAgainstY({1, 0, 0}, {0, 0, 1}, {0, -1, 0});

struct Builder {
  core::Scene& scene;
  NodeId node;
  dvec3 at;

  void add(const core::Primitive& primitive, const dvec3& place, const dmat3& axes = kUp) {
    scene.add_primitive(node, primitive, {1e-3 * axes, at + place});
  }
};

/// From end to end: flat dish, pipe, elbow, pipe, reducer, pipe, dish.
void add_pipe(Builder b) {
  b.add(core::SphericalDish{250, 100}, {1, -3, 0}, kAgainstY);
  b.add(core::Cylinder{250, 3000}, {1, -1.5, 0}, kAlongY);
  b.add(core::CircularTorus{1000, 250, kQuarter}, {0, 0, 0});
  b.add(core::Cylinder{250, 3000}, {-1.5, 1, 0}, kAlongX);
  b.add(core::Snout{250, 125, 1000, 0, 0, 0, 0, 0, 0}, {-3.5, 1, 0}, kAgainstX);
  b.add(core::Cylinder{125, 2000}, {-5, 1, 0}, kAlongX);
  b.add(core::EllipticalDish{125, 60}, {-6, 1, 0}, kAgainstX);
}

void add_equipment(Builder b) {
  b.add(core::Sphere{3000}, {5, 5, 3});
  b.add(core::Snout{600, 400, 1200, 150, 0, 0.1f, 0, 0, 0.05f}, {5, 5, 5});
  b.add(core::RectangularTorus{1600, 1900, 200, 6.2831855f}, {5, 5, 3});
  b.add(core::RectangularTorus{800, 1000, 300, kQuarter}, {5, 5, 1});
  for (const double x : {4.0, 6.0}) b.add(core::Pyramid{500, 500, 250, 250, 0, 0, 1500}, {x, 5, 0.75});
  b.add(core::Box{9000, 9000, 200}, {2, 2, -1});
  b.add(core::Line{-4000, 4000}, {2, 2, 0});
  core::Mesh roof;
  roof.positions = {{-2000, -2000, 0}, {2000, -2000, 0}, {2000, 2000, 0}, {-2000, 2000, 0}, {0, 0, 1000}};
  roof.indices = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 0, 2, 1, 0, 3, 2};
  b.scene.add_mesh_instance(b.node, b.scene.add_mesh(std::move(roof)).value(), {1e-3 * kUp, b.at + dvec3(5, 5, 7)});
}

std::vector<std::byte> small_plant() {
  core::Scene scene;
  const NodeId top = scene.add_node(scene.root(), "small_plant.rvm");
  const NodeId site = scene.add_node(top, "/SITE");
  const NodeId pipes = scene.add_node(site, "/SITE/PIPES"), equipment = scene.add_node(site, "/SITE/EQUIPMENT");
  scene.set_material(pipes, scene.add_material({"steel", {0.6f, 0.6f, 0.65f}, 1.0f, 2}));
  scene.set_material(equipment, scene.add_material({"red", {0.8f, 0.2f, 0.1f}, 1.0f, 5}));
  for (int i = 0; i < 4; ++i)
    add_pipe({scene, scene.add_node(pipes, "/PIPE-" + std::to_string(i + 1)), kSite + dvec3(0, 0, i)});
  add_equipment({scene, equipment, kSite});
  const auto bytes = write_rvm(scene, top);
  EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().message);
  return bytes.value_or(std::vector<std::byte>());
}

TEST(SmallPlant, IsWhatItsRecipeMakes) {
  const std::vector<std::byte> made = small_plant();
  const std::filesystem::path path = tests::in_checkout("tests/data/small_plant.rvm");
  if (std::getenv("SIGHTLINE_WRITE_DATA"))
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(made.data()), std::streamsize(made.size()));
  std::ifstream file(path, std::ios::binary);
  const std::string found(std::istreambuf_iterator<char>(file), {});
  EXPECT_TRUE(found == std::string(reinterpret_cast<const char*>(made.data()), made.size()));
}

TEST(SmallPlant, HasEveryKindFarAway) {
  core::Scene scene;
  const auto report = import_file(tests::data_path("small_plant.rvm"), scene, scene.root());
  ASSERT_TRUE(report) << report.error().message;
  for (int kind = 0; kind <= int(core::Kind::kFacetGroup); ++kind)
    EXPECT_GT(report->items[std::size_t(kind)], 0u) << core::name_of(core::Kind(kind));
  ASSERT_TRUE(scene.commit());
  const core::Snapshot snapshot(scene);
  EXPECT_GT(snapshot.bounds().origin.y, 6e6);
}

}  // namespace
}  // namespace sightline::importers::small_plant_test
