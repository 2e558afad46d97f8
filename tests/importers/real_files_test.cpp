// The reader's counts on real plants against a scanner that shares no code with it.
#include <cmath>
#include <cstring>
#include <fstream>

#include <gtest/gtest.h>

#include "sightline/importers/import.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::real_files_test {
namespace {

struct Scan {
  std::array<std::uint64_t, core::kKindCount> items{};
  std::uint64_t groups = 0, sheared_reducers = 0, sheared_offset = 0;
};

std::uint32_t word(const std::string& file, std::size_t at) {
  std::uint32_t v = 0;
  for (std::size_t i = 0; i < 4; ++i) v = v << 8 | std::uint8_t(file.at(at + i));
  return v;
}

float number(const std::string& file, std::size_t at) {
  const std::uint32_t bits = word(file, at);
  float v;
  std::memcpy(&v, &bits, 4);
  return v;
}

void scan_snout(const std::string& file, std::size_t at, Scan& scan) {
  const std::size_t p = at + 24 + 8 + 48 + 24;
  const bool sheared =
      number(file, p + 20) != 0 || number(file, p + 24) != 0 || number(file, p + 28) != 0 || number(file, p + 32) != 0;
  scan.sheared_reducers += sheared && number(file, p) != number(file, p + 4);
  scan.sheared_offset += sheared && (number(file, p + 12) != 0 || number(file, p + 16) != 0);
}

/// Hops from chunk to chunk.
Scan scan_file(const std::string& file) {
  Scan scan;
  for (std::size_t at = 0;;) {
    const std::string tag = {file.at(at + 3), file.at(at + 7), file.at(at + 11), file.at(at + 15)};
    if (tag == "END:") return scan;
    if (tag == "CNTB") ++scan.groups;
    if (tag == "PRIM") {
      const std::uint32_t kind = word(file, at + 28);
      ++scan.items.at(kind - 1);
      if (kind == 7) scan_snout(file, at, scan);
    }
    at = word(file, at + 16);
  }
}

std::string contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void compare_with_scan(const std::vector<std::string>& files) {
  Scan total;
  std::vector<std::filesystem::path> paths;
  std::uint64_t degenerate = 0;
  for (const std::string& name : files) {
    SCOPED_TRACE(name);
    paths.push_back(tests::data_path(name));
    const Scan scan = scan_file(contents(paths.back()));
    core::Scene scene;
    const auto report = import_file(paths.back(), scene, scene.root());
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty());
    EXPECT_EQ(report->items, scan.items);
    EXPECT_EQ(scene.node_count(), scan.groups + 2);
    ASSERT_TRUE(scene.commit());
    for (std::size_t k = 0; k < total.items.size(); ++k) total.items[k] += scan.items[k];
    total.groups += scan.groups;
    total.sheared_reducers += scan.sheared_reducers;
    total.sheared_offset += scan.sheared_offset;
    degenerate += report->degenerate;
    std::printf("%s: %llu degenerate\n", name.c_str(), static_cast<unsigned long long>(report->degenerate));
  }
  core::Scene scene;
  const auto report = import_files(paths, scene, scene.root());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->items, total.items);
  EXPECT_EQ(report->degenerate, degenerate);
  EXPECT_EQ(scene.node_count(), total.groups + 1 + files.size());
  std::array<std::uint64_t, core::kKindCount> in_scene{};
  for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) ++in_scene[std::size_t(scene.kind(i))];
  EXPECT_EQ(in_scene, total.items);
  for (int k = 0; k < core::kKindCount; ++k)
    std::printf("%s %llu\n", std::string(core::name_of(core::Kind(k))).c_str(),
                static_cast<unsigned long long>(total.items[std::size_t(k)]));
  std::printf("sheared snouts with two radii: %llu, with an offset: %llu\n",
              static_cast<unsigned long long>(total.sheared_reducers),
              static_cast<unsigned long long>(total.sheared_offset));
}

TEST(RealFiles, CountsAgreeWithAnIndependentScan) {
  const std::vector<std::string> files = {"huldra/HA-MECH.RVM", "huldra/HA-PIPE.RVM", "huldra/WD1-PSUP.RVM"};
  for (const std::string& file : files) SIGHTLINE_NEED_DATA(file);
  compare_with_scan(files);
}

TEST(RealFiles, CountsOfTheSmallPlantAgreeWithAnIndependentScan) {
  compare_with_scan({"small_plant.rvm"});
}

}  // namespace
}  // namespace sightline::importers::real_files_test
