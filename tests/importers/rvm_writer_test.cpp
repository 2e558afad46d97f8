#include "sightline/importers/rvm/rvm_writer.h"

#include <bit>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/rvm/internal/rvm_output.h"
#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/importers/write_file.h"
#include "sightline/tests/importers/rvm_bytes.h"
#include "sightline/tests/importers/scene_compare.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::rvm_writer_test {
namespace {

using core::NodeId;
using core::Scene;

/// Writes `top`, reads that as a new scene; the node of the file.
NodeId rewrite(const Scene& scene, NodeId top, Scene& again) {
  const auto bytes = write_rvm(scene, top);
  EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().message);
  if (!bytes) return {};
  EXPECT_EQ(bytes->size() % 1760, 0u);
  const auto report = read_rvm(*bytes, scene.name(top), again, again.root(), {.copies = MeshCopies::kExact});
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  if (!report) return {};
  EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
  return report->nodes[0];
}

void expect_round_trip(const std::vector<std::byte>& bytes) {
  Scene first, second, third;
  const auto report = read_rvm(bytes, "file.rvm", first, first.root(), {.copies = MeshCopies::kExact});
  ASSERT_TRUE(report) << report.error().message;
  const NodeId top = report->nodes[0], again = rewrite(first, top, second);
  ASSERT_TRUE(again.valid());
  EXPECT_EQ(tests::scene_difference(first, top, second, again), "");
  EXPECT_EQ(first.attributes(top), second.attributes(again));
  EXPECT_EQ(*write_rvm(first, top), *write_rvm(second, again));
}

TEST(RvmWriter, RoundTripOfEveryChunk) {
  expect_round_trip(tests::small_rvm());
}

class RandomFile {
 public:
  explicit RandomFile(unsigned seed) : random_(seed) {}
  std::vector<std::byte> make() {
    b_.head();
    int depth = 0;
    for (int i = 0; i < 60; ++i) {
      const auto what = random_() % 8;
      if (depth == 0 || what == 0)
        group(), ++depth;
      else if (what == 1)
        b_.group_end(), --depth;
      else if (what == 2)
        layered_item(random_() % 2 ? "OBST" : "INSU");
      else if (what == 3)
        b_.facets();
      else
        item(1 + std::uint32_t(random_() % 10));
    }
    while (depth-- > 0) b_.group_end();
    for (std::uint32_t i = 0; i < 5; ++i) b_.colour(std::uint32_t(random_() % 30), std::uint32_t(random_() & 0xffffff));
    return b_.finish().bytes;
  }

 private:
  float number() {
    if (random_() % 10 == 0) return random_() % 2 ? -0.0f : 0.0f;
    if (random_() % 10 == 0) return 1e-42f;
    return std::uniform_real_distribution<float>(-1000.0f, 1000.0f)(random_);
  }
  void group() {
    const std::uint32_t version = 2 + std::uint32_t(random_() % 2);
    b_.begin("CNTB").u32(version).text(std::string(random_() % 9, char('a' + random_() % 26)));
    b_.floats({number(), number(), number()}).u32(std::uint32_t(random_() % 30));
    if (version == 3) b_.u32(std::uint32_t(random_() % 101) << 24);
    b_.end();
  }
  void matrix() {
    for (int i = 0; i < 12; ++i) b_.f32(number());
  }
  void item(std::uint32_t kind) {
    b_.begin("PRIM").u32(1).u32(kind);
    matrix();
    b_.floats({0, 0, 0, 0, 0, 0});
    for (int i = core::parameter_count(core::Kind(kind - 1)); i > 0; --i) b_.f32(number());
    b_.end();
  }
  void layered_item(const char* tag) {
    b_.begin(tag).u32(1).u32(2);
    matrix();
    b_.floats({-1, -2, -3, 1, 2, 3}).u32(std::uint32_t(random_() % 3) * 20 << 24).floats({2, 4, 6}).end();
  }
  std::mt19937 random_;
  tests::RvmBytes b_;
};

TEST(RvmWriter, RoundTripOfRandomFiles) {
  for (unsigned seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    expect_round_trip(RandomFile(seed).make());
    ASSERT_FALSE(HasFailure());
  }
}

void expect_round_trip_of_file(const char* name) {
  SCOPED_TRACE(name);
  std::ifstream file(tests::data_path(name), std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const auto bytes = std::as_bytes(std::span(text));
  expect_round_trip({bytes.begin(), bytes.end()});
}

TEST(RvmWriter, RoundTripOfTheSmallPlant) {
  expect_round_trip_of_file("small_plant.rvm");
}

TEST(RvmWriter, RoundTripOfRealFiles) {
  for (const char* name : {"huldra/HA-MECH.RVM", "huldra/HA-PIPE.RVM", "huldra/WD1-PSUP.RVM"}) {
    SIGHTLINE_NEED_DATA(name);
    expect_round_trip_of_file(name);
  }
}

TEST(RvmWriter, TransformsAreBakedInDouble) {
  Scene scene, again;
  core::Affine turn{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, {3e6, 7e6, 1e3}};
  const NodeId top = scene.add_node(scene.root(), "file", core::translation({-3e6, -7e6, 0.0}));
  const NodeId group = scene.add_node(top, "turned", turn);
  scene.add_primitive(group, core::Cylinder{1, 2}, {core::dmat3(2.0), {0.125, 0.25, -1000.0}});
  const NodeId file = rewrite(scene, top, again);
  ASSERT_TRUE(file.valid());
  EXPECT_EQ(again.placement(core::ItemId{0}).origin, core::dvec3(-0.25, 0.125, 0.0));
  EXPECT_EQ(again.placement(core::ItemId{0}).linear[0], core::dvec3(0, 2, 0));
}

TEST(RvmWriter, MeshesBecomeFacetGroups) {
  Scene scene, again;
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  const NodeId top = scene.add_node(scene.root(), "file");
  scene.add_mesh_instance(scene.add_node(top, "g"), scene.add_mesh(mesh).value());
  ASSERT_TRUE(rewrite(scene, top, again).valid());
  ASSERT_EQ(again.kind(core::ItemId{0}), core::Kind::kFacetGroup);
  const core::Mesh& got = again.mesh(again.mesh_of(core::ItemId{0}));
  ASSERT_EQ(got.indices.size(), mesh.indices.size());
  for (std::size_t i = 0; i < mesh.indices.size(); ++i)
    EXPECT_EQ(got.positions[got.indices[i]], mesh.positions[mesh.indices[i]]);
  EXPECT_EQ(got.normals[0], core::vec3(0, 0, -1));
}

TEST(RvmWriter, ItemMaterialsAndCodesInConflict) {
  Scene scene, again;
  const auto red = scene.add_material({"red", {1, 0, 0}, 1.0f, 5}),
             blue = scene.add_material({"blue", {0, 0, 1}, 0.5f, 5});
  const NodeId top = scene.add_node(scene.root(), "file"), group = scene.add_node(top, "g");
  scene.set_material(group, red);
  scene.add_primitive(group, core::Sphere{1});
  scene.add_primitive(group, core::Sphere{2}, {}, blue);
  scene.add_primitive(group, core::Sphere{3}, {}, blue);
  scene.add_primitive(group, core::Sphere{4}, {}, red);
  scene.add_primitive(top, core::Sphere{5});
  ASSERT_TRUE(rewrite(scene, top, again).valid());
  ASSERT_EQ(again.item_count(), 5u);
  const core::vec3 colours[] = {{1, 0, 0}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}};
  for (core::ItemId i{0}; to_index(i) < 5; ++i) {
    const float diameter = std::get<core::Sphere>(again.primitive(i)).diameter;
    const core::Material& m = again.material(again.material(again.node_of(i)));
    if (diameter < 5) {
      EXPECT_EQ(m.colour, colours[int(diameter) - 1]);
    } else {
      EXPECT_EQ(again.name(again.node_of(i)), "file");
    }
    if (m.colour.z == 1) {
      EXPECT_EQ(m.alpha, 0.5f);
    }
  }
}

TEST(RvmWriter, FilesAreReplacedWholeOrNotAtAll) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "sightline_rvm_writer_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  Scene scene;
  const NodeId top = scene.add_node(scene.root(), "file"), group = scene.add_node(top, "g");
  scene.add_primitive(group, core::Cylinder{1, 2});
  const auto path = folder / "out.rvm";
  ASSERT_TRUE(write_rvm(scene, top, path));
  EXPECT_EQ(std::filesystem::file_size(path), 1760u);
  scene.add_primitive(group, core::Cylinder{1, 2}, core::translation({1e300, 0, 0}));
  const auto failed = write_rvm(scene, top, path);
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("out.rvm"), std::string::npos);
  EXPECT_EQ(std::filesystem::file_size(path), 1760u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  scene.remove_item(core::ItemId{1});
  for (int i = 0; i < 10000; ++i) scene.add_primitive(group, core::Cylinder{1, 2});
  const auto cancelled = write_rvm(scene, top, path, [](double share) { return share < 0.5; });
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().message, kCancelled);
  EXPECT_EQ(std::filesystem::file_size(path), 1760u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  EXPECT_FALSE(write_rvm(scene, group, folder));
  EXPECT_FALSE(write_rvm(scene, group, folder / "nowhere" / "out.rvm"));
  std::filesystem::remove_all(folder);
}

/// The report of a part speaks of the part, not of the scene around it.
TEST(RvmWriter, ReportsCountWhatIsBelowTheNode) {
  Scene scene;
  const NodeId part = scene.add_node(scene.root()), below = scene.add_node(part);
  const core::Cylinder cylinder{0.5f, 2.0f};
  for (const NodeId node : {part, below, scene.add_node(scene.root())}) scene.add_primitive(node, cylinder);
  const auto path = std::filesystem::path(testing::TempDir()) / "part.rvm";
  const auto written = write_file(scene, part, path);
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(written->items[std::size_t(core::Kind::kCylinder)], 2u);
#ifdef SIGHTLINE_HAVE_SLC
  const auto all = write_file(scene, part, path.string() + ".slc");
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_EQ(all->items[std::size_t(core::Kind::kCylinder)], 3u);
#endif
}

TEST(RvmWriter, OffsetsEndAt4GiB) {
  struct Discard final : ByteSink {
    bool write(std::span<const std::byte> added) override {
      bytes += added.size();
      return true;
    }
    std::uint64_t bytes = 0;
  } sink;
  rvm::ChunkWriter out(sink);
  const std::string text(std::size_t{1} << 26, 'x');
  for (int i = 0; i < 63; ++i) {
    out.begin("CNTB");
    out.string(text);
    out.end();
  }
  EXPECT_TRUE(out.ok());
  out.begin("CNTB");
  out.string(text);
  out.end();
  EXPECT_TRUE(out.too_large());
  EXPECT_LT(sink.bytes, std::uint64_t{1} << 32);
}

TEST(RvmWriter, DeepTrees) {
  Scene scene, again;
  const NodeId top = scene.add_node(scene.root(), "file");
  NodeId node = top;
  for (int i = 0; i < 10000; ++i) node = scene.add_node(node, "n");
  scene.add_primitive(node, core::Sphere{1});
  ASSERT_TRUE(rewrite(scene, top, again).valid());
  EXPECT_EQ(again.node_count(), 10002u);
}

/// What an item looks like, where it is and what it belongs to.
struct Seen {
  core::vec3 colour{0.0f};
  float alpha = 0.0f;
  std::uint32_t layers = 0, code = 0;
  core::dvec3 origin{0.0};
};
/// Spheres by their diameters, after writing and reading.
std::map<float, Seen> spheres_after(const Scene& scene, NodeId top, Scene& again) {
  std::map<float, Seen> seen;
  if (!rewrite(scene, top, again).valid()) return seen;
  for (core::ItemId i{0}; to_index(i) < again.item_slots(); ++i) {
    const auto state = again.state(i);
    const core::Material& m = again.material(again.material_at(state.material));
    seen[std::get<core::Sphere>(again.primitive(i)).diameter] = {m.colour, m.alpha, state.layers, m.code,
                                                                 state.world_from_item.origin};
  }
  return seen;
}

TEST(RvmWriter, ColoursInConflictTakeFreeIndices) {
  Scene scene, again;
  const NodeId top = scene.add_node(scene.root(), "file");
  const core::vec3 red(1, 0, 0), green(0, 1, 0), blue(0, 0, 1), grey(0.5f, 1.5f, -0.5f);
  float diameter = 0.0f;
  for (const core::Material& m : {core::Material{"a", red, 1, 5},
                                  {"b", green, 1, 256},
                                  {"c", blue, 1, 5},
                                  {"d", blue, 2, 5},
                                  {"e", grey, -1, 5}}) {
    const NodeId group = scene.add_node(top, m.name);
    scene.set_material(group, scene.add_material(m));
    scene.add_primitive(group, core::Sphere{++diameter});
  }
  auto seen = spheres_after(scene, top, again);
  EXPECT_EQ(seen[1].colour, red);
  EXPECT_EQ(seen[2].colour, green);
  EXPECT_EQ(seen[2].code, 256u);
  EXPECT_EQ(seen[3].colour, blue);
  EXPECT_EQ(seen[4].colour, blue);
  EXPECT_EQ(seen[3].code, seen[4].code);
  EXPECT_EQ(seen[4].alpha, 1.0f);
  EXPECT_EQ(seen[5].colour, core::vec3(128 / 255.0f, 1, 0));
  EXPECT_EQ(seen[5].alpha, 0.0f);
}

TEST(RvmWriter, ChildrenInheritLookLayersAndPlace) {
  Scene scene, again;
  const core::Affine far = core::translation({10, 20, 30});
  const NodeId above = scene.add_node(scene.root(), "above"), top = scene.add_node(above, "file");
  scene.set_material(above, scene.add_material({"blue", {0, 0, 1}, 1.0f, 7}));
  const NodeId moved = scene.add_node(top, "moved", far), below = scene.add_node(moved, "below");
  const NodeId still = scene.add_node(top, "still"), last = scene.add_node(still, "last", far);
  scene.set_layers(still, core::kLayerInsulation);
  const NodeId painted = scene.add_node(top, "painted"), child = scene.add_node(painted, "child");
  const core::MaterialId red = scene.add_material({"red", {1, 0, 0}, 1.0f, 8}),
                         green = scene.add_material({"green", {0, 1, 0}, 1.0f, 9});
  scene.set_material(painted, red);
  scene.add_primitive(below, core::Sphere{1});
  scene.add_primitive(last, core::Sphere{2});
  scene.add_primitive(child, core::Sphere{3});
  scene.add_primitive(child, core::Sphere{4}, {}, green);
  scene.add_primitive(child, core::Sphere{5}, {}, scene.add_material({"white", {1, 1, 1}, 1.0f, 10}));
  scene.add_primitive(child, core::Sphere{6});
  auto seen = spheres_after(scene, top, again);
  EXPECT_EQ(seen[1].origin, far.origin);
  EXPECT_EQ(seen[1].colour, core::vec3(0, 0, 1));
  EXPECT_EQ(seen[1].layers, core::kLayerModel);
  EXPECT_EQ(seen[2].origin, far.origin);
  EXPECT_EQ(seen[2].layers, core::kLayerInsulation);
  const core::vec3 colours[] = {{1, 0, 0}, {0, 1, 0}, {1, 1, 1}, {1, 0, 0}};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(seen[float(3 + i)].colour, colours[i]) << i;
}

TEST(RvmWriter, LayerNodesThatSayMoreGetAGroup) {
  Scene scene, again;
  const NodeId top = scene.add_node(scene.root(), "file"), group = scene.add_node(top, "g");
  scene.set_material(group, scene.add_material({"red", {1, 0, 0}, 1.0f, 8}));
  const auto layer = [&](NodeId above, std::string_view name, float diameter) {
    const NodeId node = scene.add_node(above, name);
    scene.set_layers(node, core::kLayerObstruction);
    scene.add_primitive(node, core::Sphere{diameter});
    return node;
  };
  layer(group, "named", 1);
  scene.set_attribute(layer(group, "", 2), rvm::kPositionKey, "1 2 3");
  scene.set_transform(layer(group, "", 3), core::translation({10, 20, 30}));
  layer(top, "", 4);
  scene.set_material(layer(group, "", 5), scene.add_material({"green", {0, 1, 0}, 1.0f, 9}));
  scene.add_primitive(scene.add_node(layer(group, "", 6)), core::Sphere{7});
  auto seen = spheres_after(scene, top, again);
  ASSERT_EQ(seen.size(), 7u);
  std::map<float, NodeId> above;
  for (core::ItemId i{0}; to_index(i) < again.item_slots(); ++i)
    above[std::get<core::Sphere>(again.primitive(i)).diameter] = again.parent(again.node_of(i));
  EXPECT_EQ(again.name(above[1]), "named");
  EXPECT_EQ(again.attributes(above[2]), (Scene::Attributes{{std::string(rvm::kPositionKey), "1 2 3"}}));
  EXPECT_EQ(seen[3].origin, core::dvec3(10, 20, 30));
  EXPECT_EQ(seen[5].colour, core::vec3(0, 1, 0));
  for (const auto& [diameter, sphere] : seen) EXPECT_EQ(sphere.layers, core::kLayerObstruction) << diameter;
}

TEST(RvmWriter, NormalsOfMeshesAreWritten) {
  Scene scene, again;
  const NodeId top = scene.add_node(scene.root(), "file"), group = scene.add_node(top, "g");
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals = {{0, 0, 1}, {0, 0.6f, 0.8f}, {0.6f, 0, 0.8f}};
  mesh.indices = {0, 1, 2};
  scene.add_mesh_instance(group, scene.add_mesh(mesh).value(), {});
  mesh.contour_sizes = {3}, mesh.polygon_contours = {1};
  scene.add_mesh_instance(group, scene.add_mesh(mesh).value(), {});
  ASSERT_TRUE(rewrite(scene, top, again).valid());
  ASSERT_EQ(again.item_count(), 2u);
  for (core::ItemId i{0}; to_index(i) < 2; ++i)
    EXPECT_EQ(again.mesh(again.mesh_of(i)).normals, mesh.normals) << to_index(i);
}

TEST(RvmWriter, BoxesHoldTheirItems) {
  Scene scene;
  const NodeId top = scene.add_node(scene.root(), "file"), group = scene.add_node(top, "g");
  const core::Primitive snout = core::Snout{0.3f, 0.7f, 1.1f, 0.1f, 0.2f, 0.1f, 0.2f, -0.3f, 0.05f};
  scene.add_primitive(group, snout);
  const auto bytes = write_rvm(scene, top);
  ASSERT_TRUE(bytes);
  const auto word = [&](std::size_t at) {
    std::uint32_t w = 0;
    for (std::size_t i = 0; i < 4; ++i) w = w << 8 | std::uint32_t((*bytes)[at + i]);
    return w;
  };
  std::size_t chunk = 0;
  while (word(chunk) != 'P' || word(chunk + 4) != 'R' || word(chunk + 8) != 'I') chunk += 4;
  const core::AabbD exact = core::bounds(snout, {});
  int rounded = 0;
  for (int i = 0; i < 6; ++i) {
    const double stored = double(std::bit_cast<float>(word(chunk + 24 + 8 + 48 + 4 * std::size_t(i))));
    const double value = i < 3 ? exact.min[i] : exact.max[i - 3];
    EXPECT_LE(i < 3 ? stored : value, i < 3 ? value : stored) << i;
    EXPECT_NEAR(stored, value, 1e-6);
    rounded += stored != value;
  }
  EXPECT_GT(rounded, 0);
}

}  // namespace
}  // namespace sightline::importers::rvm_writer_test
