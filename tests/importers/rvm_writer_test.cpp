#include "sightline/importers/rvm/rvm_writer.h"

#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/rvm/rvm_output.h"
#include "sightline/importers/rvm/rvm_reader.h"
#include "sightline/tests/importers/rvm_bytes.h"
#include "sightline/tests/importers/scene_compare.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers {
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

TEST(RvmWriter, RoundTripOfRealFiles) {
  for (const char* name : {"huldra/HA-MECH.RVM", "huldra/HA-PIPE.RVM", "huldra/WD1-PSUP.RVM"}) {
    SIGHTLINE_NEED_DATA(name);
    SCOPED_TRACE(name);
    std::ifstream file(tests::data_path(name), std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    const auto bytes = std::as_bytes(std::span(text));
    expect_round_trip({bytes.begin(), bytes.end()});
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
  EXPECT_EQ(again.placement(0).origin, core::dvec3(-0.25, 0.125, 0.0));
  EXPECT_EQ(again.placement(0).linear[0], core::dvec3(0, 2, 0));
}

TEST(RvmWriter, MeshesBecomeFacetGroups) {
  Scene scene, again;
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  const NodeId top = scene.add_node(scene.root(), "file");
  scene.add_mesh_instance(scene.add_node(top, "g"), scene.add_mesh(mesh).value());
  ASSERT_TRUE(rewrite(scene, top, again).valid());
  ASSERT_EQ(again.kind(0), core::Kind::kFacetGroup);
  const core::Mesh& got = again.mesh(again.mesh_of(0));
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
  for (core::ItemId i = 0; i < 5; ++i) {
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
  scene.remove_item(1);
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

}  // namespace
}  // namespace sightline::importers
