// The text form of RVM against the binary form of the same model, and damage with its line.
#include "sightline/importers/rvm/internal/rvm_text.h"

#include <gtest/gtest.h>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/tests/importers/rvm_bytes.h"
#include "sightline/tests/importers/rvm_text.h"
#include "sightline/tests/importers/scene_compare.h"

namespace sightline::importers::rvm_text_test {
namespace {

using tests::rvm_as_text;
using tests::RvmBytes;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

core::Expected<ImportReport> read(std::span<const std::byte> bytes, core::Scene& scene, bool lenient = false) {
  scene = core::Scene();
  return read_rvm(bytes, "model.rvm", scene, scene.root(), {.lenient = lenient, .copies = MeshCopies::kExact});
}

/// The text reads as the binary file does.
void expect_same(std::span<const std::byte> binary, const std::string& text) {
  core::Scene wanted, found;
  ASSERT_TRUE(read(binary, wanted));
  const auto report = read(bytes_of(text), found);
  ASSERT_TRUE(report) << report.error().message;
  for (const ImportWarning& warning : report->warnings) ADD_FAILURE() << warning.message;
  EXPECT_EQ(report->bytes, text.size());
  EXPECT_EQ(report->metres_per_unit, 0.001);
  EXPECT_EQ(tests::scene_difference(wanted, wanted.root(), found, found.root()), "");
}

TEST(RvmText, ReadsAsTheBinaryFileDoes) {
  const auto binary = tests::small_rvm();
  for (const bool first : {false, true})
    for (const char* newline : {"\n", "\r\n"})
      expect_same(binary, rvm_as_text(binary, {.extra_first = first, .newline = newline}));
  expect_same(binary, "\xEF\xBB\xBF" + rvm_as_text(binary));
  expect_same(binary, "\n  " + rvm_as_text(binary) + "\nwhat follows is nobody's\n");
}

TEST(RvmText, PlantsComeBackToTheBit) {
  for (const std::uint64_t seed : {1, 2}) {
    core::Scene plant;
    ASSERT_TRUE(generate_plant({.items = 2000, .seed = seed}, plant));
    const auto binary = write_rvm(plant, plant.root());
    ASSERT_TRUE(binary);
    expect_same(*binary, rvm_as_text(*binary));
  }
}

/// What converters write has five digits behind the point: placements of 0.001 keep one.
TEST(RvmText, NumbersOfFixedWidth) {
  RvmBytes b;
  b.head().group("", 2, {-123456.5f, 0.25f, 3}).prim(8, {2, 9});
  b.item(11).u32(1).u32(1).u32(3);
  for (const float x : {-1234567.f, -7654321.f, 5.f}) b.floats({x, -1234567.5f, -x, 0, 0, 1});  // columns that touch
  b.end().group_end().finish();
  const std::string text = rvm_as_text(b.bytes, {.fixed = true});
  EXPECT_NE(text.find("-1234567.00000-1234567.50000"), std::string::npos) << text;
  expect_same(b.bytes, text);
}

TEST(RvmText, HeadersOfVersionOneHaveNoEncoding) {
  core::Scene scene;
  ASSERT_TRUE(read(bytes_of("HEAD\n1 1\ninfo\n\ndate\nuser\nMODL\n1 1\nP\nM\nCNTB\n1 2\nA b \n0 0 0\n4\nPRIM\n1 1\n8\n"
                            ".001 0 0 1\n0 .001 0 2\n0 0 .001 3\n-1 -1 -1\n1 1 1\n2 3\nCNTE\n1 2\nEND:\n1 1\n"),
                   scene));
  const core::NodeId file = scene.first_child(scene.root()), group = scene.first_child(file);
  EXPECT_EQ(scene.name(group), "A b");
  EXPECT_EQ(
      scene.attributes(file),
      (core::Scene::Attributes{
          {"rvm.info", "info"}, {"rvm.date", "date"}, {"rvm.user", "user"}, {"rvm.project", "P"}, {"rvm.model", "M"}}));
  EXPECT_EQ(scene.placement(scene.first_item(group)).origin, core::dvec3(1, 2, 3));
}

TEST(RvmText, ExtensionsOfFiles) {
  const std::string text = rvm_as_text(tests::small_rvm());
  for (const char* name : {"sightline_text.rvm", "sightline_text.REV"}) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / name;
    ASSERT_TRUE(core::write_file(path, {bytes_of(text)}));
    core::Scene scene;
    const auto report = import_file(path, scene, scene.root());
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(scene.item_count(), 15u);
    std::filesystem::remove(path);
  }
}

/// Replaces the first `from` and expects an error and a warning that begin so.
void expect_damage(const std::string& from, const std::string& to, const std::string& message, std::size_t items_left) {
  std::string text = rvm_as_text(tests::small_rvm());
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  core::Scene scene;
  const auto strict = read(bytes_of(text), scene);
  ASSERT_FALSE(strict) << message;
  EXPECT_EQ(strict.error().message.find("model.rvm: " + message), 0u) << strict.error().message;
  const auto lenient = read(bytes_of(text), scene, true);
  ASSERT_TRUE(lenient) << lenient.error().message;
  ASSERT_FALSE(lenient->warnings.empty());
  EXPECT_EQ(lenient->warnings[0].message.find(message), 0u) << lenient->warnings[0].message;
  EXPECT_EQ(scene.item_count(), items_left) << message;
}

TEST(RvmText, DamageSaysItsLine) {
  const std::string cylinder = "     1     1\n     8\n";  // the first one
  expect_damage("PRIM\n" + cylinder, "PRIM\n     1     1\n     12\n", "line 80: PRIM chunk: expected a primitive kind",
                14);
  expect_damage(" 2 9\n", " 2\n", "line 80: PRIM chunk: expected 21 numbers, found 20", 14);
  expect_damage(" 2 9\n", " 2 9 4\n", "line 80: PRIM chunk: expected 21, found 22 numbers", 14);
  expect_damage(" 2 9\n", " 2 9x\n", "line 80: PRIM chunk: expected 21 numbers, found 19 before line 88: \"2 9x\"", 14);
  expect_damage("CNTB\n     1     2\n", "CNTB\n", "line 12: CNTB chunk: expected two numbers", 15);
  expect_damage("     3\nPRIM", "     -3\nPRIM", "line 143: CNTB chunk: expected a reference point and a colour", 15);
  expect_damage("PRIM\n", "PRIMUS\n", "line 17: expected a chunk's tag, found \"PRIMUS\"", 14);
  expect_damage("16 32 48", "16 32 480", "line 198: COLR chunk: expected an index and red, green, blue", 15);
  expect_damage("END:", "END", "line 202: expected a chunk's tag, found \"END\"", 15);
  // What only the binary reader finds: a group that stays open.
  const std::string text = rvm_as_text(tests::small_rvm());
  const std::size_t last = text.rfind("CNTE\n     1     2\n");
  ASSERT_NE(last, std::string::npos);
  core::Scene scene;
  std::string open = text;
  open.erase(last, 18);
  const auto report = read(bytes_of(open), scene);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("END: chunk: expected 1 more CNTE"), std::string::npos)
      << report.error().message;
  EXPECT_EQ(report.error().message.find("model.rvm: line "), 0u) << report.error().message;
}

}  // namespace
}  // namespace sightline::importers::rvm_text_test
