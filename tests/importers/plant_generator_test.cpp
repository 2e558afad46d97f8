#include "sightline/importers/plant/plant_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <unordered_map>
#include <vector>

#include <gtest/gtest.h>

namespace sightline::importers::plant_generator_test {
namespace {

using core::Affine;
using core::dvec3;
using core::Kind;
using core::Scene;

Scene generate(std::uint64_t items, std::uint64_t seed) {
  Scene scene;
  const auto done = generate_plant({items, seed}, scene);
  EXPECT_TRUE(done) << done.error().message;
  return scene;
}

/// FNV-1a over everything that makes up the plant: kinds, parameters, placements, names and colours.
class Hash {
 public:
  void bytes(const void* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      value_ = (value_ ^ static_cast<const unsigned char*>(data)[i]) * 0x100000001b3u;
  }
  template <class T>
  void add(const T& value) {
    bytes(&value, sizeof value);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

std::uint64_t hash_of(const Scene& scene) {
  Hash hash;
  scene.for_each_node(scene.root(), [&](core::NodeId node, const Affine&, bool, std::uint32_t, core::MaterialId paint) {
    const std::string_view name = scene.name(node);
    hash.bytes(name.data(), name.size());
    if (paint.valid()) hash.add(scene.material(paint).colour), hash.add(scene.material(paint).code);
    for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item)) {
      hash.add(scene.kind(item));
      const Affine placement = scene.placement(item);
      hash.add(placement.linear);
      hash.add(placement.origin);
      if (scene.kind(item) == Kind::kFacetGroup) {
        for (const core::vec3& p : scene.mesh(scene.mesh_of(item)).positions) hash.add(p);
      } else {
        const core::Primitive primitive = scene.primitive(item);
        const auto values = core::parameters(primitive);
        hash.bytes(values.data(), values.size_bytes());
      }
    }
  });
  return hash.value();
}

std::array<std::size_t, core::kKindCount> count_kinds(const Scene& scene) {
  std::array<std::size_t, core::kKindCount> counts{};
  for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) ++counts[std::size_t(scene.kind(i))];
  return counts;
}

/// Where a pipe-like item ends, in metres, and the unit direction out of it.
struct End {
  dvec3 at, out;
  core::ItemId item;
};

void collect_ends(const Scene& scene, core::ItemId item, std::vector<End>& ends) {
  const Affine place = scene.placement(item);  // the nodes of a plant are at the origin
  const auto add = [&](const dvec3& at, const dvec3& out) {
    ends.push_back({core::transform_point(place, at), glm::normalize(place.linear * out), item});
  };
  const core::Primitive primitive = scene.primitive(item);
  if (const auto* c = std::get_if<core::Cylinder>(&primitive)) {
    for (const double side : {-1.0, 1.0}) add({0, 0, 0.5 * side * c->height}, {0, 0, side});
  } else if (const auto* s = std::get_if<core::Snout>(&primitive)) {
    for (const double side : {-1.0, 1.0}) add(0.5 * side * dvec3(s->offset_x, s->offset_y, s->height), {0, 0, side});
  } else if (const auto* t = std::get_if<core::CircularTorus>(&primitive)) {
    const double a = t->angle;
    add({t->major_radius, 0, 0}, {0, -1, 0});
    add(double(t->major_radius) * dvec3(std::cos(a), std::sin(a), 0), {-std::sin(a), std::cos(a), 0});
  }
}

/// The portion of torus slice ends that another item's end meets within 0.1 mm, facing it.
double connected_torus_ends(const Scene& scene) {
  std::vector<End> ends;
  for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i)
    if (scene.kind(i) != Kind::kFacetGroup) collect_ends(scene, i, ends);
  const double cell = 1e-3, reach = 1e-4;
  const auto key = [&](const dvec3& p) {
    const auto n = [&](double v) { return std::uint64_t(std::int64_t(std::floor(v / cell))); };
    return (n(p.x) * 0x9e3779b97f4a7c15u) ^ (n(p.y) * 0xc2b2ae3d27d4eb4fu) ^ (n(p.z) * 0x165667b19e3779f9u);
  };
  std::unordered_multimap<std::uint64_t, std::size_t> grid;
  for (std::size_t i = 0; i < ends.size(); ++i) grid.emplace(key(ends[i].at), i);
  const auto met = [&](const End& end) {
    for (int corner = 0; corner < 27; ++corner) {
      const dvec3 shift(corner % 3 - 1, corner / 3 % 3 - 1, corner / 9 - 1);
      const auto [first, last] = grid.equal_range(key(end.at + cell * shift));
      for (auto it = first; it != last; ++it) {
        const End& other = ends[it->second];
        if (other.item != end.item && glm::length(other.at - end.at) <= reach &&
            glm::dot(other.out, end.out) < -0.999999)
          return true;
      }
    }
    return false;
  };
  std::size_t total = 0, connected = 0;
  for (const End& end : ends) {
    if (scene.kind(end.item) != Kind::kCircularTorus) continue;
    ++total;
    connected += met(end);
  }
  return double(connected) / double(total);
}

/// The radii that an item shows (metres); empty for what has none.
std::vector<double> radii(const core::Primitive& p) {
  if (const auto* c = std::get_if<core::Cylinder>(&p)) return {c->radius * 1e-3};
  if (const auto* s = std::get_if<core::Snout>(&p)) return {s->bottom_radius * 1e-3, s->top_radius * 1e-3};
  if (const auto* t = std::get_if<core::CircularTorus>(&p)) return {t->tube_radius * 1e-3};
  if (const auto* d = std::get_if<core::EllipticalDish>(&p)) return {d->base_radius * 1e-3};
  if (const auto* d = std::get_if<core::SphericalDish>(&p)) return {d->base_radius * 1e-3};
  if (const auto* b = std::get_if<core::Sphere>(&p)) return {b->diameter * 0.5e-3};
  return {};
}

struct Size {
  std::uint64_t items, seed;
};
void PrintTo(const Size& size, std::ostream* out) {
  *out << size.items << " items, seed " << size.seed;
}

class Plant : public ::testing::TestWithParam<Size> {
 protected:
  const Scene scene = generate(GetParam().items, GetParam().seed);
};

TEST_P(Plant, HasTheItemsAndTheStatisticsPromised) {
  const double n = double(GetParam().items);
  ASSERT_EQ(scene.item_count(), GetParam().items);
  ASSERT_EQ(scene.item_slots(), GetParam().items);
  const auto counts = count_kinds(scene);
  const double cylinders = double(counts[std::size_t(Kind::kCylinder)]) / n;
  const double tori = double(counts[std::size_t(Kind::kCircularTorus)]) / n;
  const double snouts = double(counts[std::size_t(Kind::kSnout)]) / n;
  EXPECT_NEAR(cylinders, 0.65, 0.01);
  EXPECT_NEAR(tori, 0.20, 0.01);
  EXPECT_NEAR(snouts, 0.05, 0.005);
  EXPECT_NEAR(1.0 - cylinders - tori - snouts, 0.10, 0.01);
}

TEST_P(Plant, StaysWithinTheSite) {
  core::AabbD all;
  for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) {
    const core::AabbD box = scene.bounds_under(i, scene.placement(i));
    ASSERT_TRUE(core::is_finite(box.min) && core::is_finite(box.max)) << "item " << to_index(i);
    const bool inside = box.min.x >= -200 && box.max.x <= 200 && box.min.y >= -50 && box.max.y <= 50 &&
                        box.min.z >= -0.001 && box.max.z <= 60;
    ASSERT_TRUE(inside) << "item " << to_index(i) << " of " << scene.path(scene.node_of(i)) << " spans " << box.min.x
                        << "," << box.min.y << "," << box.min.z << " to " << box.max.x << "," << box.max.y << ","
                        << box.max.z;
    all.grow(box);
  }
  if (GetParam().items >= 100'000) {
    EXPECT_GT(all.size().x, 390.0);
    EXPECT_GT(all.size().y, 95.0);
    EXPECT_GT(all.size().z, 40.0);
  }
  EXPECT_LT(std::min(std::fabs(all.min.z), std::fabs(all.max.z)), 0.01) << "stands on the ground";
}

TEST_P(Plant, RadiiRunFromTubingToVessels) {
  double least = 1e9, most = 0.0;
  std::array<std::size_t, 11> octaves{};
  for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) {
    if (scene.kind(i) == Kind::kFacetGroup) continue;
    const core::Primitive p = scene.primitive(i);
    ASSERT_FALSE(core::is_degenerate(p)) << "item " << to_index(i) << " of " << scene.path(scene.node_of(i));
    for (const double r : radii(p)) {
      least = std::min(least, r), most = std::max(most, r);
      ASSERT_GE(r, 0.00199) << scene.path(scene.node_of(i));
      ASSERT_LE(r, 4.001) << scene.path(scene.node_of(i));
      ++octaves[std::size_t(std::clamp(std::log2(r / 0.00195), 0.0, 10.0))];
    }
  }
  if (GetParam().items < 100'000) return;
  EXPECT_LE(least, 0.0021);
  EXPECT_GE(most, 3.5);
  for (std::size_t octave = 0; octave < octaves.size(); ++octave)
    EXPECT_GT(octaves[octave], 0u) << "no radius around " << 0.00195 * std::exp2(double(octave)) << " m";
}

TEST_P(Plant, PipesMeetEndToEnd) {
  EXPECT_GE(connected_torus_ends(scene), 0.95);
}

TEST_P(Plant, PositionsSurviveSinglePrecision) {
  for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) {
    const dvec3 p = scene.placement(i).origin;
    for (int axis = 0; axis < 3; ++axis) ASSERT_EQ(p[axis], double(float(p[axis])));
  }
}

TEST_P(Plant, EveryGroupWithItemsHasAColourAndAName) {
  std::size_t groups = 0;
  std::array<bool, 32> colours{};
  scene.for_each_node(scene.root(), [&](core::NodeId node, const Affine&, bool, std::uint32_t, core::MaterialId paint) {
    if (scene.first_item(node) == core::kNoItem) return;
    ++groups;
    ASSERT_TRUE(paint.valid());
    ASSERT_FALSE(scene.name(node).empty());
    ASSERT_LT(scene.material(paint).code, colours.size());
    colours[scene.material(paint).code] = true;
  });
  EXPECT_GE(double(groups), double(GetParam().items) / 60.0);
  EXPECT_GE(std::count(colours.begin(), colours.end(), true), 5);
}

INSTANTIATE_TEST_SUITE_P(Sizes, Plant,
                         ::testing::Values(Size{1'000, 1}, Size{1'001, 2}, Size{1'777, 3}, Size{5'000, 4},
                                           Size{10'000, 5}, Size{40'000, 6}, Size{100'000, 1}, Size{400'000, 7}));

TEST(PlantGenerator, HoldsForManySeeds) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const std::uint64_t items = 1'000 + seed * 37;
    SCOPED_TRACE("items " + std::to_string(items) + ", seed " + std::to_string(seed));
    Scene scene = generate(items, seed);
    ASSERT_EQ(scene.item_count(), items);
    EXPECT_GE(connected_torus_ends(scene), 0.95);
    core::AabbD all;
    for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) all.grow(scene.bounds_under(i, scene.placement(i)));
    const double length = 400.0 * std::sqrt(double(items) / 1e5);
    EXPECT_LE(all.size().x, length) << "leaves its share of the site";
    EXPECT_LE(all.size().y, 0.25 * length) << "leaves its share of the site";
  }
}

TEST(PlantGenerator, DependsOnTheSeedAlone) {
  const std::uint64_t once = hash_of(generate(20'000, 42)), again = hash_of(generate(20'000, 42));
  EXPECT_EQ(once, again);
  EXPECT_EQ(once, 0x77d874624fe7d82u) << std::hex << "0x" << once << ": the plant of this seed has changed";
  EXPECT_NE(once, hash_of(generate(20'000, 43)));
  EXPECT_NE(once, hash_of(generate(20'001, 42)));
}

TEST(PlantGenerator, CommitsWithoutComplaint) {
  Scene scene = generate(30'000, 9);
  const auto delta = scene.commit();
  ASSERT_TRUE(delta) << delta.error().message;
  EXPECT_EQ(delta->inserted.size(), 30'000u);
}

TEST(PlantGenerator, HasEveryKindButPlainMeshes) {
  const auto counts = count_kinds(generate(100'000, 3));
  for (int kind = 0; kind < core::kKindCount; ++kind) {
    if (Kind(kind) == Kind::kMesh) continue;
    EXPECT_GT(counts[std::size_t(kind)], 0u) << core::name_of(Kind(kind));
  }
}

TEST(PlantGenerator, AppendsToAScene) {
  Scene scene;
  ASSERT_TRUE(generate_plant({1'000, 1}, scene));
  ASSERT_TRUE(generate_plant({1'000, 2}, scene));
  EXPECT_EQ(scene.item_count(), 2'000u);
}

TEST(PlantGenerator, RefusesOtherSizes) {
  for (const std::uint64_t items :
       {std::uint64_t(0), std::uint64_t(999), std::uint64_t(10'000'001), ~std::uint64_t(0)}) {
    Scene scene;
    const auto done = generate_plant({items, 1}, scene);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().message, "plant generator: expected 1000 to 10000000 items, got " + std::to_string(items));
    EXPECT_EQ(scene.item_count(), 0u);
    EXPECT_EQ(scene.material_slots(), 0u);
  }
}

}  // namespace
}  // namespace sightline::importers::plant_generator_test
