#include "sightline/importers/rvm/internal/rvm_reader.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/tests/importers/rvm_bytes.h"

namespace sightline::importers::rvm_reader_test {
namespace {

using core::Kind;
using tests::RvmBytes;

struct Read {
  core::Scene scene;
  core::Expected<ImportReport> report;
  explicit Read(const std::vector<std::byte>& bytes, bool lenient = false)
      : report(read_rvm(bytes, "test.rvm", scene, scene.root(), {.lenient = lenient})) {}
  core::NodeId child(core::NodeId node, int index) const {
    core::NodeId child = scene.first_child(node);
    for (; index > 0; --index) child = scene.next_sibling(child);
    return child;
  }
  core::NodeId file() const { return report->nodes.at(0); }
};

TEST(RvmReader, AllKindsGroupsAndStrings) {
  const Read read(tests::small_rvm());
  ASSERT_TRUE(read.report) << read.report.error().message;
  const core::Scene& scene = read.scene;
  EXPECT_TRUE(read.report->warnings.empty());
  EXPECT_EQ(read.report->degenerate, 0u);
  const std::array<std::uint64_t, core::kKindCount> expected = {1, 2, 1, 1, 1, 1, 1, 3, 2, 1, 1, 0};
  EXPECT_EQ(read.report->items, expected);
  EXPECT_EQ(scene.name(read.file()), "test.rvm");
  const core::Scene::Attributes file_attributes = {
      {"rvm.info", "info"},        {"rvm.note", "note"},       {"rvm.date", "date"}, {"rvm.user", "user"},
      {"rvm.encoding", "Unicode"}, {"rvm.project", "project"}, {"rvm.model", "name"}};
  EXPECT_EQ(scene.attributes(read.file()), file_attributes);
  const core::NodeId a = read.child(read.file(), 0);
  EXPECT_EQ(scene.name(a), "/A");
  EXPECT_EQ(scene.attributes(a), (core::Scene::Attributes{{"rvm.position", "1 2 3"}}));
  core::ItemId item = scene.first_item(a);
  for (int kind = 0; kind < 11; ++kind, item = scene.next_item(item)) {
    ASSERT_EQ(scene.kind(item), Kind(kind));
    EXPECT_EQ(scene.placement(item).origin, core::dvec3(1, 2, 3));
    EXPECT_EQ(scene.placement(item).linear, core::dmat3(double(.001f)));
  }
  const auto snout = std::get<core::Snout>(scene.primitive(core::ItemId{6}));
  EXPECT_EQ(snout.bottom_radius, 3);
  EXPECT_EQ(snout.offset_x, 1);
  EXPECT_EQ(snout.bottom_shear_y, .2f);
  const core::Mesh& mesh = scene.mesh(scene.mesh_of(core::ItemId{10}));
  EXPECT_EQ(mesh.polygon_contours, (std::vector<std::uint32_t>{2, 1}));
  EXPECT_EQ(mesh.contour_sizes, (std::vector<std::uint32_t>{4, 4, 3}));
  EXPECT_EQ(mesh.indices.size(), 3u * (8 + 1));
  EXPECT_EQ(mesh.positions[9], core::vec3(1, 0, 5));
}

TEST(RvmReader, ColoursComeFromTheFileOrThePalette) {
  const Read read(tests::small_rvm());
  const core::NodeId a = read.child(read.file(), 0), b = read.child(a, 0), c = read.child(read.file(), 1);
  const core::Material& of_a = read.scene.material(read.scene.material(a));
  EXPECT_EQ(of_a.code, 2u);
  EXPECT_EQ(of_a.colour, core::vec3(0x10 / 255.f, 0x20 / 255.f, 0x30 / 255.f));
  EXPECT_EQ(of_a.alpha, 1.0f);
  const auto rgb = rvm_default_colour(3);
  EXPECT_EQ(read.scene.material(read.scene.material(b)).colour, core::vec3(rgb[0], rgb[1], rgb[2]) / 255.0f);
  const core::Material& of_c = read.scene.material(read.scene.material(c));
  EXPECT_EQ(of_c.code, 2u);
  EXPECT_FLOAT_EQ(of_c.alpha, 0.75f);
}

TEST(RvmReader, ObstructionAndInsulationHaveTheirOwnLayers) {
  const Read read(tests::small_rvm());
  const core::NodeId b = read.child(read.child(read.file(), 0), 0);
  const core::NodeId obstruction = read.child(b, 0), insulation = read.child(b, 1);
  EXPECT_EQ(read.scene.layers(obstruction), core::kLayerObstruction);
  EXPECT_EQ(read.scene.layers(insulation), core::kLayerInsulation);
  EXPECT_FLOAT_EQ(read.scene.material(read.scene.material(obstruction)).alpha, 0.5f);
  EXPECT_EQ(read.scene.kind(read.scene.first_item(obstruction)), Kind::kBox);
}

TEST(RvmReader, ExtraWordMayStandBeforeTheMatrix) {
  for (const bool first : {false, true}) {
    RvmBytes b;
    b.head().group("g", 1).begin("INSU").u32(1).u32(8);
    if (first) b.u32(30u << 24);
    b.floats({0, 2, 0, -2, 0, 0, 0, 0, 2, 7, 8, 9}).floats({-1, -1, -2, 1, 1, 2});
    if (!first) b.u32(30u << 24);
    b.floats({1, 4}).end().group_end().finish();
    const Read read(b.bytes);
    ASSERT_TRUE(read.report) << read.report.error().message;
    EXPECT_TRUE(read.report->warnings.empty());
    EXPECT_EQ(read.scene.placement(core::ItemId{0}).origin, core::dvec3(7, 8, 9)) << first;
    EXPECT_EQ(read.scene.placement(core::ItemId{0}).linear[0], core::dvec3(0, 2, 0)) << first;
    EXPECT_FLOAT_EQ(read.scene.material(read.scene.material(read.scene.node_of(core::ItemId{0}))).alpha, 0.7f);
  }
}

/// An obstruction's cylinder of radius 1 and height 4, or its given words.
RvmBytes obstruction(std::initializer_list<float> box, std::uint32_t extra) {
  RvmBytes b;
  b.head().group("g", 1).begin("OBST").u32(1).u32(8).matrix().floats(box).u32(extra).floats({1, 4}).end();
  b.group_end().finish();
  return b;
}

TEST(RvmReader, StoredBoxesMayBeAQuarterOfTheSizeOff) {
  for (const auto& [off, warnings] : {std::pair(0.2f, 0u), {0.3f, 1u}})
    for (int i = 0; i < 6; ++i) {
      std::array<float, 6> box = {-1, -1, -2, 1, 1, 2};
      box[std::size_t(i)] += 4 * off;  // of the longest side
      const Read read(obstruction({box[0], box[1], box[2], box[3], box[4], box[5]}, 0).bytes);
      ASSERT_TRUE(read.report);
      EXPECT_EQ(read.report->warnings.size(), warnings) << off << " at " << i;
      EXPECT_EQ(read.scene.placement(core::ItemId{0}).origin, core::dvec3(1, 2, 3));
    }
}

TEST(RvmReader, ExtraWordHoldsATransparencyAndNothingElse) {
  const auto expect = [](std::uint32_t extra, std::size_t warnings, float alpha) {
    const Read read(obstruction({-1, -1, -2, 1, 1, 2}, extra).bytes);
    ASSERT_TRUE(read.report);
    EXPECT_EQ(read.report->warnings.size(), warnings) << extra;
    EXPECT_FLOAT_EQ(read.scene.material(read.scene.material(read.scene.node_of(core::ItemId{0}))).alpha, alpha);
  };
  expect(100u << 24, 0, 0.0f);
  expect(101u << 24, 1, 0.0f);
  expect(50u << 24 | 1, 1, 0.5f);
  expect(50u << 24 | 1 << 23, 1, 0.5f);
}

TEST(RvmReader, ExtraWordDecidesWhereBoxesCannot) {
  // All of the box is 1, and so is the matrix's last number: read either way, the box fits.
  RvmBytes b;
  b.head().group("g", 1).begin("OBST").u32(1).u32(11).u32(30u << 24).floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 7, 8, 1});
  b.floats({1, 1, 1, 1, 1, 1}).u32(1).u32(1).u32(3);
  for (int i = 0; i < 3; ++i) b.floats({1, 1, 1, 0, 0, 1});
  b.end().group_end().finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report) << read.report.error().message;
  EXPECT_EQ(read.report->warnings.size(), 1u) << "its one triangle has no area";
  EXPECT_EQ(read.scene.placement(core::ItemId{0}).origin, core::dvec3(7, 8, 1));
}

TEST(RvmReader, WhereNothingDecidesTheExtraWordIsLast) {
  // Without a facet there is no box of its own, and the first number is 0, as an extra word may be.
  RvmBytes b;
  b.head().group("g", 1).begin("OBST").u32(1).u32(11).floats({0, 2, 0, -2, 0, 0, 0, 0, 2, 7, 8, 9});
  b.floats({0, 0, 0, 0, 0, 0}).u32(0).u32(0).end().group_end().finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report) << read.report.error().message;
  EXPECT_EQ(read.report->warnings.size(), 1u) << "nothing to draw";
  EXPECT_EQ(read.scene.placement(core::ItemId{0}).origin, core::dvec3(7, 8, 9));
  // Nor does a box decide that fits neither: this one fits better after an extra word, but not well.
  b = {};
  b.head().group("g", 1).begin("OBST").u32(1).u32(8).u32(30u << 24).floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 7, 8, 9});
  b.floats({-1, -1, -2, 1, 1, 3.5f}).floats({1, 4}).end().group_end().finish();
  const Read off(b.bytes);
  ASSERT_TRUE(off.report) << off.report.error().message;
  EXPECT_EQ(off.report->warnings.size(), 1u);
  EXPECT_EQ(off.scene.placement(core::ItemId{0}).origin, core::dvec3(1, 7, 8));
  // What stands last is the box's 3.5, of which the first byte is 64.
  EXPECT_FLOAT_EQ(off.scene.material(off.scene.material(off.scene.node_of(core::ItemId{0}))).alpha, 0.36f);
}

TEST(RvmReader, ALayerHasOneNodeForEachTransparency) {
  RvmBytes b;
  b.head().group("g", 1);
  for (const auto& [tag, transparency] : {std::pair("OBST", 0u), {"INSU", 0u}, {"OBST", 0u}, {"OBST", 50u}})
    b.begin(tag).u32(1).u32(8).matrix().floats({-1, -1, -2, 1, 1, 2}).u32(transparency << 24).floats({1, 4}).end();
  b.group_end().finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report) << read.report.error().message;
  EXPECT_EQ(read.scene.node_of(core::ItemId{0}), read.scene.node_of(core::ItemId{2}));
  const core::NodeId nodes[] = {read.scene.node_of(core::ItemId{0}), read.scene.node_of(core::ItemId{1}),
                                read.scene.node_of(core::ItemId{3})};
  EXPECT_EQ(read.scene.node_count(), 2u + 1u + 3u);
  const std::uint32_t layers[] = {core::kLayerObstruction, core::kLayerInsulation, core::kLayerObstruction};
  const float alphas[] = {1.0f, 1.0f, 0.5f};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(read.scene.layers(nodes[i]), layers[i]);
    EXPECT_EQ(read.scene.material(read.scene.material(nodes[i])).alpha, alphas[i]);
  }
}

TEST(RvmReader, PaletteBeyondTheUsualColoursIsOfOneTone) {
  using Rgb = std::array<std::uint8_t, 3>;
  EXPECT_EQ(rvm_default_colour(1), (Rgb{150, 155, 160}));
  EXPECT_EQ(rvm_default_colour(16), (Rgb{190, 84, 150}));
  std::set<Rgb> all;
  for (std::uint32_t index = 17; index < 1017; ++index) {
    const Rgb c = rvm_default_colour(index);
    EXPECT_EQ(*std::max_element(c.begin(), c.end()), 204) << index;
    EXPECT_EQ(*std::min_element(c.begin(), c.end()), 122) << index;
    all.insert(c);
  }
  EXPECT_GT(all.size(), 300u);  // of 6 * 82
}

TEST(RvmReader, HeadsOfVersion1HaveNoEncoding) {
  RvmBytes b;
  b.begin("HEAD").u32(1).text("info").text("note").text("date").text("user").end();
  b.begin("MODL").u32(1).text("project").text("name").end();
  b.group("g", 1, {-0.0f, 0, 0}).prim(8, {1, 2}).group_end().finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report) << read.report.error().message;
  for (const auto& [key, value] : read.scene.attributes(read.file())) EXPECT_NE(key, "rvm.encoding");
  // Any bit that is set is kept, so that writing gives the file's bytes.
  EXPECT_EQ(read.scene.attributes(read.child(read.file(), 0)), (core::Scene::Attributes{{"rvm.position", "-0 0 0"}}));
}

TEST(RvmReader, AmbiguousExtraWordIsReported) {
  RvmBytes b;
  b.head().group("g", 1).begin("OBST").u32(1).u32(8).matrix().floats({50, 60, 70, 80, 90, 100}).u32(0x01020304);
  b.floats({1, 4}).end().group_end().finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report);
  ASSERT_EQ(read.report->warnings.size(), 1u);
  EXPECT_NE(read.report->warnings[0].message.find("layout"), std::string::npos);
  EXPECT_EQ(read.scene.placement(core::ItemId{0}).origin, core::dvec3(1, 2, 3));
}

TEST(RvmReader, GroupVersions) {
  RvmBytes b;
  b.head();
  b.begin("CNTB").u32(1).text("one").floats({0, 0, 0}).u32(5).end().group_end();
  b.begin("CNTB").u32(3).text("three").floats({0, 0, 0}).u32(5).u32(40u << 24).end().group_end();
  b.begin("CNTB")
      .u32(4)
      .text("four")
      .floats({0, 0, 0})
      .u32(5)
      .u32(60u << 24)
      .floats({0, 0, 0, 0, 0, 0})
      .end()
      .group_end();
  b.finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report) << read.report.error().message;
  const float alphas[] = {1.0f, 0.6f, 0.4f};
  for (int i = 0; i < 3; ++i)
    EXPECT_FLOAT_EQ(read.scene.material(read.scene.material(read.child(read.file(), i))).alpha, alphas[i]);
}

TEST(RvmReader, DegenerateItemsStayAndAreCounted) {
  RvmBytes b;
  b.head().group("g", 1).prim(8, {1, 0}).prim(8, {0, 1}).prim(7, {1, 2, -3, 0, 0, 0, 0, 0, 0}).item(11).u32(0).end();
  b.group_end().finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report);
  EXPECT_EQ(read.scene.item_count(), 4u);
  EXPECT_EQ(read.report->degenerate, 3u);
  EXPECT_EQ(read.report->items[std::size_t(Kind::kFacetGroup)], 1u);
}

TEST(RvmReader, StoredNormalsDecideWhereOutsideIs) {
  for (const float nz : {1.0f, -1.0f}) {
    RvmBytes b;
    b.head().group("g", 1).item(11).u32(1).u32(1).u32(3);
    b.floats({0, 0, 0, 0, 0, nz}).floats({1, 0, 0, 0, 0, nz}).floats({0, 1, 0, 0, 0, nz}).end().group_end().finish();
    const Read read(b.bytes);
    const core::Mesh& m = read.scene.mesh(read.scene.mesh_of(core::ItemId{0}));
    const core::vec3 normal = glm::cross(m.positions[m.indices[1]] - m.positions[m.indices[0]],
                                         m.positions[m.indices[2]] - m.positions[m.indices[0]]);
    EXPECT_GT(normal.z * nz, 0.0f);
  }
}

TEST(RvmReader, NormalsWithoutADirectionTurnNothing) {
  RvmBytes b;
  b.head().group("g", 1).item(11).u32(1).u32(1).u32(3);
  b.floats({0, 0, 0, 0, 0, 0}).floats({1, 0, 0, 0, 0, 0}).floats({0, 1, 0, 0, 0, 0}).end().group_end().finish();
  const Read read(b.bytes);
  EXPECT_EQ(read.scene.mesh(read.scene.mesh_of(core::ItemId{0})).indices, (std::vector<std::uint32_t>{0, 1, 2}));
}

/// Strict: an error that says all of `parts`. Lenient: that many items and at least one warning.
void expect_damage(const std::vector<std::byte>& bytes, std::initializer_list<std::string> parts, std::size_t items) {
  const Read strict(bytes);
  ASSERT_FALSE(strict.report);
  for (const std::string& part : parts)
    EXPECT_NE(strict.report.error().message.find(part), std::string::npos) << strict.report.error().message;
  EXPECT_EQ(strict.scene.node_count(), 1u);
  const Read lenient(bytes, true);
  ASSERT_TRUE(lenient.report) << lenient.report.error().message;
  EXPECT_EQ(lenient.scene.item_count(), items);
  ASSERT_FALSE(lenient.report->warnings.empty());
  EXPECT_EQ(lenient.report->warnings[0].file, "test.rvm");
}

TEST(RvmReader, DamageIsAnErrorOrAWarning) {
  RvmBytes unknown_kind, unknown_chunk, no_end, open_group, outside, short_chunk, long_chunk, bad_group;
  unknown_kind.head().group("g", 1).prim(8, {1, 2});
  const std::size_t at = unknown_kind.bytes.size();
  unknown_kind.prim(12, {1, 2}).prim(8, {1, 2}).group_end().finish();
  expect_damage(unknown_kind.bytes, {"test.rvm: byte " + std::to_string(at + 28), "PRIM", "1 to 11, found 12"}, 2);
  unknown_chunk.head().group("g", 1).begin("WXYZ").u32(7).end().prim(8, {1, 2}).group_end().finish();
  expect_damage(unknown_chunk.bytes, {"WXYZ", "unknown"}, 1);
  no_end.head().group("g", 1).prim(8, {1, 2}).group_end();
  expect_damage(no_end.bytes, {"END:"}, 1);
  open_group.head().group("g", 1).prim(8, {1, 2}).finish();
  expect_damage(open_group.bytes, {"END:", "CNTE"}, 1);
  outside.head().prim(8, {1, 2}).finish();
  expect_damage(outside.bytes, {"PRIM", "CNTB"}, 1);
  short_chunk.head().group("g", 1).item(8).f32(1).end().prim(8, {1, 2}).group_end().finish();
  expect_damage(short_chunk.bytes, {"PRIM", "expected parameter (4 bytes), found 0"}, 1);
  long_chunk.head().group("g", 1).prim(8, {1, 2, 3}).prim(8, {1, 2}).group_end().finish();
  expect_damage(long_chunk.bytes, {"PRIM", "next chunk"}, 2);
  bad_group.head().begin("CNTB").u32(9).text("g").floats({0, 0, 0}).u32(1).end().prim(8, {1, 2}).group_end().finish();
  expect_damage(bad_group.bytes, {"CNTB", "version 1 to 4, found 9"}, 1);
  for (const std::uint32_t version : {0u, 5u}) {
    RvmBytes b;
    b.head().begin("CNTB").u32(version).text("g").floats({0, 0, 0}).u32(1).end().prim(8, {1, 2}).group_end().finish();
    expect_damage(b.bytes, {"CNTB", "version 1 to 4, found " + std::to_string(version)}, 1);
  }
  // A tag is of printable characters, of which space is one.
  for (const auto& [tag, message] :
       {std::pair("W YZ", "unknown"), {"W\x1fYZ", "expected a chunk header"}, {"W\x7fYZ", "expected a chunk header"}}) {
    RvmBytes b;
    b.head().group("g", 1).prim(8, {1, 2}).begin(tag).u32(7).end().group_end().finish();
    expect_damage(b.bytes, {message}, 1);
  }
}

TEST(RvmReader, WrongNextOffsetsLoseNothingWhereContentsLeadOn) {
  RvmBytes begun;
  begun.head().group("g", 1);
  const std::size_t at = begun.bytes.size();
  const auto within = [&](std::size_t offset) { return std::uint32_t(at + offset); };
  for (const std::uint32_t next : {0u, 0xffffffffu, 24u, 700u, within(24), within(25), within(60), within(100)}) {
    RvmBytes b = begun;
    b.prim(8, {1, 2}).prim(8, {3, 4}).group_end().group("h", 1).prim(9, {1}).group_end().finish();
    b.put(at + 16, next);
    const Read read(b.bytes);
    ASSERT_TRUE(read.report) << read.report.error().message;
    ASSERT_EQ(read.report->warnings.size(), 1u);
    EXPECT_NE(read.report->warnings[0].message.find("PRIM chunk: the next chunk"), std::string::npos);
    EXPECT_EQ(read.scene.item_count(), 3u);
  }
}

TEST(RvmReader, HeadsMayHoldMoreThanIsKnown) {
  for (const int words : {1, 8, 100}) {
    RvmBytes b;
    b.begin("HEAD").u32(2).text("info").text("note").text("date").text("user").text("Unicode");
    for (int i = 0; i < words; ++i) b.u32(0x41424344u);
    b.end().begin("MODL").u32(1).text("project").text("name").end();
    b.group("g", 1).prim(8, {1, 2}).group_end().finish();
    const Read read(b.bytes);
    ASSERT_TRUE(read.report) << read.report.error().message;
    EXPECT_EQ(read.report->warnings.size(), 1u);
    EXPECT_EQ(read.scene.item_count(), 1u);
  }
}

TEST(RvmReader, NamesAreDecodedAsTheHeadSays) {
  const auto with = [](std::string_view encoding, std::string_view name) {
    RvmBytes b;
    b.begin("HEAD").u32(2).text("info").text("note").text("date").text("user").text(encoding).end();
    b.begin("MODL").u32(1).text("project").text("name").end();
    return b.group(name, 1).prim(8, {1, 2}).group_end().finish().bytes;
  };
  const auto name_of = [](const Read& read) { return std::string(read.scene.name(read.child(read.file(), 0))); };
  const Read stated(with("Latin-1", "/GEL\xC4NDER"));
  EXPECT_EQ(name_of(stated), "/GELÄNDER");
  EXPECT_TRUE(stated.report->warnings.empty());
  const Read cyrillic(with("CP1251", "\xCD\xE0\xF1\xEE\xF1"));
  EXPECT_EQ(name_of(cyrillic), "Насос");
  const Read utf8(with("Latin-1", "/GELÄNDER"));
  EXPECT_EQ(name_of(utf8), "/GELÄNDER") << "whatever the head says";
  for (const std::string_view encoding : {"", "Unicode", "no such encoding"}) {
    const Read guessed(with(encoding, "/GEL\xC4NDER"));
    EXPECT_EQ(name_of(guessed), "/GELÄNDER");
    ASSERT_EQ(guessed.report->warnings.size(), 1u) << encoding;
    EXPECT_NE(guessed.report->warnings[0].message.find("Windows-1252"), std::string::npos);
  }
}

TEST(RvmReader, BadPolygonsAndNormalsLoseThemselvesAlone) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  RvmBytes b;
  b.head().group("g", 1).item(11).u32(3);
  const auto triangle = [&](float x, float normal) {
    b.u32(1).u32(3).floats({x, 0, 0, 0, 0, normal}).floats({4, 0, 0, 0, 0, 1}).floats({0, 4, 0, 0, 0, 1});
  };
  triangle(0, 1), triangle(kNan, 1), triangle(1, kNan);
  b.end().group_end().finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report) << read.report.error().message;
  ASSERT_EQ(read.report->warnings.size(), 2u);
  EXPECT_NE(read.report->warnings[0].message.find("1 of 3 polygons dropped"), std::string::npos);
  EXPECT_NE(read.report->warnings[1].message.find("1 normals left out"), std::string::npos);
  const core::Mesh& mesh = read.scene.mesh(read.scene.mesh_of(core::ItemId{0}));
  EXPECT_EQ(mesh.indices.size(), 6u);
  EXPECT_EQ(mesh.polygon_contours.size(), 2u);
  for (const core::vec3& normal : mesh.normals) EXPECT_EQ(glm::length(normal) > 0.0f, normal.z == 1.0f);
}

TEST(RvmReader, LenientImportsGoOnAtTheNextChunk) {
  RvmBytes b;
  b.head().group("g", 1).prim(8, {1, 2});
  const std::size_t at = b.bytes.size();
  b.prim(9, {3}).prim(8, {3, 4}).group_end().group("h", 1).prim(9, {1}).group_end().finish();
  for (std::size_t i = 0; i < 30; ++i) b.bytes[at + i] = std::byte(0x5a);  // over the header and into the contents
  expect_damage(b.bytes, {"expected a chunk header"}, 3);
  const Read read(b.bytes, true);
  EXPECT_EQ(read.report->warnings.size(), 2u) << "the damage, and how much was skipped";
}

TEST(RvmReader, StrayGroupEndIsOnlyAWarning) {
  RvmBytes b;
  b.head().group("g", 1).prim(8, {1, 2}).group_end().group_end().group("h", 1).prim(9, {1}).group_end().finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report) << read.report.error().message;
  EXPECT_EQ(read.report->warnings.size(), 1u);
  EXPECT_EQ(read.scene.item_count(), 2u);
}

TEST(RvmReader, WarningsAreCapped) {
  RvmBytes b;
  b.head();
  for (int i = 0; i < 5000; ++i) b.group_end();
  b.finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report);
  ASSERT_EQ(read.report->warnings.size(), kMaxWarnings + 1);
  EXPECT_NE(read.report->warnings.back().message.find("4001"), std::string::npos);
}

/// Programs that rewrite a file leave the offsets of the former one, which lead anywhere.
TEST(RvmReader, OffsetsOfAnotherFileLoseNothing) {
  std::mt19937 random(60);
  for (int i = 0; i < 200; ++i) {
    RvmBytes b;
    std::vector<std::size_t> chunks{0};
    const auto next = [&]() { chunks.push_back(b.bytes.size()); };
    b.head(), next();
    b.group("a long name of a group", 1), next(), b.prim(8, {1, 2}), next(), b.prim(9, {3}), next();
    b.prim(2, {1, 2, 3}), next(), b.group_end().finish();
    for (std::size_t k = 1; k + 1 < chunks.size(); ++k)
      b.put(chunks[k] + 16, std::uint32_t(chunks[k] + 24 + random() % (chunks[k + 1] - chunks[k] - 24)));
    for (const bool lenient : {false, true}) {
      const Read read(b.bytes, lenient);
      ASSERT_TRUE(read.report) << read.report.error().message;
      EXPECT_EQ(read.report->warnings.size(), chunks.size() - 2) << i;
      EXPECT_EQ(read.scene.item_count(), 3u) << i;
    }
  }
}

TEST(RvmReader, LostContentsAreSkipped) {
  RvmBytes b;
  b.head().group("g", 1).prim(8, {1, 2});
  const std::size_t at = b.bytes.size();
  b.prim(12, {1, 2}).prim(8, {1, 2}).group_end().finish();
  expect_damage(b.bytes, {"1 to 11, found 12"}, 2);
  for (const std::uint32_t next : {0u, std::uint32_t(at), std::uint32_t(at + 4), std::uint32_t(b.bytes.size() + 4)}) {
    b.put(at + 16, next);
    expect_damage(b.bytes, {"1 to 11, found 12"}, 2);  // the next chunk is found
    EXPECT_EQ(Read(b.bytes, true).report->warnings.size(), 2u) << next;
  }
}

TEST(RvmReader, BytesThatResembleNoKnownChunkAreSkipped) {
  RvmBytes b;
  b.head().group("g", 1).item(8).floats({1, 2});
  for (const char c : {'A', 'B', 'C', 'D'}) b.u32(std::uint8_t(c));
  b.u32(0).u32(1).end().prim(8, {1, 2}).group_end().finish();
  expect_damage(b.bytes, {"next chunk"}, 2);
  EXPECT_EQ(Read(b.bytes, true).report->warnings.size(), 1u);
}

TEST(RvmReader, WhatIsNotFiniteOrTooFarIsDropped) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  RvmBytes b;
  b.head().group("g", 1, {1, kNan, 2});
  for (const float x : {5000.0f, 9e35f, 2e36f})
    b.begin("PRIM").u32(1).u32(9).floats({1, 0, 0, 0, 1, 0, 0, 0, 1, x, 0, 0, -1, -1, -1, 1, 1, 1, 2}).end();
  b.group_end().finish();
  const Read read(b.bytes);
  ASSERT_TRUE(read.report) << read.report.error().message;
  EXPECT_EQ(read.report->metres_per_unit, 0.001);
  EXPECT_TRUE(read.scene.attributes(read.child(read.file(), 0)).empty());
  EXPECT_EQ(read.scene.item_count(), 2u);
  ASSERT_EQ(read.report->warnings.size(), 2u);
  EXPECT_NE(read.report->warnings[0].message.find("not finite"), std::string::npos);
  EXPECT_NE(read.report->warnings[1].message.find("reaches 2e+36"), std::string::npos);
}

class ImportFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) / (std::string("sightline_import_") + test->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& name, std::span<const std::byte> bytes) {
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    return folder_ / name;
  }
  void expect_error(const std::filesystem::path& path, const std::string& part) {
    for (const bool lenient : {false, true}) {
      const auto report = import_file(path, scene_, scene_.root(), {.lenient = lenient});
      ASSERT_FALSE(report);
      EXPECT_NE(report.error().message.find(path.string()), std::string::npos) << report.error().message;
      EXPECT_NE(report.error().message.find(part), std::string::npos) << report.error().message;
    }
  }
  std::filesystem::path folder_;
  core::Scene scene_;
};

TEST_F(ImportFile, SaysWhatIsWrongWithAPath) {
  expect_error(folder_ / "missing.rvm", "no such file");
  std::filesystem::create_directory(folder_ / "folder.rvm");
  expect_error(folder_ / "folder.rvm", "directory");
  expect_error(write("empty.rvm", {}), "empty");
  const std::string text = "hello, this is a text file with a misleading name";
  expect_error(write("text.rvm", std::as_bytes(std::span(text))), "not an RVM file");
  expect_error(write("model.xyz", std::as_bytes(std::span(text))), "extension '.xyz'");
  expect_error(write("none", std::as_bytes(std::span(text))), "extension");
  EXPECT_EQ(scene_.node_count(), 1u);
}

TEST_F(ImportFile, ExtensionsInAnyCaseAndSeveralFiles) {
  const std::vector<std::filesystem::path> paths = {write("a.RVM", tests::small_rvm()),
                                                    write("b.rVm", tests::small_rvm())};
  const auto report = import_files(paths, scene_, scene_.root());
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->nodes.size(), 2u);
  EXPECT_EQ(scene_.name(report->nodes[0]), "a.RVM");
  EXPECT_EQ(scene_.name(report->nodes[1]), "b.rVm");
  EXPECT_EQ(report->items[std::size_t(Kind::kCylinder)], 6u);
  EXPECT_EQ(report->bytes, 2 * tests::small_rvm().size());
}

TEST_F(ImportFile, AFailedImportLeavesTheSceneAsItWas) {
  ASSERT_TRUE(import_file(write("a.rvm", tests::small_rvm()), scene_, scene_.root()));
  const std::size_t nodes = scene_.node_count(), items = scene_.item_count();
  auto broken = tests::small_rvm();
  broken.resize(broken.size() / 3);
  const std::vector<std::filesystem::path> paths = {write("b.rvm", tests::small_rvm()), write("c.rvm", broken)};
  EXPECT_FALSE(import_files(paths, scene_, scene_.root()));
  EXPECT_EQ(scene_.node_count(), nodes);
  EXPECT_EQ(scene_.item_count(), items);
}

}  // namespace
}  // namespace sightline::importers::rvm_reader_test
