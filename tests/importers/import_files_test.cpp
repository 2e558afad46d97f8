#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include "sightline/importers/import.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/tests/importers/scene_compare.h"

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;

/// Plants of a thousand items each, on disk.
class ImportFiles : public testing::Test {
 protected:
  static constexpr int kFiles = 9;

  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("sightline_import_files_") + test->name());
    fs::create_directories(folder_);
    for (int i = 0; i < kFiles; ++i) {
      core::Scene plant;
      ASSERT_TRUE(generate_plant({1000u + 100u * unsigned(i), 7u + unsigned(i)}, plant));
      paths_.push_back(folder_ / ("plant" + std::to_string(i) + ".rvm"));
      ASSERT_TRUE(write_rvm(plant, plant.root(), paths_.back()));
    }
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
  std::vector<fs::path> paths_;
};

/// The twin: one file after the other into one scene.
core::Scene one_by_one(const std::vector<fs::path>& paths) {
  core::Scene scene;
  for (const fs::path& path : paths) EXPECT_TRUE(import_file(path, scene, scene.root()));
  return scene;
}

TEST_F(ImportFiles, SideBySideGivesTheSameSceneAsOneByOne) {
  const core::Scene expected = one_by_one(paths_);
  for (const int threads : {0, 1, 2, 5, 32}) {
    SCOPED_TRACE(std::to_string(threads) + " threads");
    core::Scene scene;
    const auto report = import_files(paths_, scene, scene.root(), {.threads = threads});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(tests::scene_difference(expected, expected.root(), scene, scene.root()), "");
    EXPECT_EQ(scene.item_slots(), expected.item_slots());
    ASSERT_EQ(report->nodes.size(), paths_.size());
    for (std::size_t i = 0; i < paths_.size(); ++i) EXPECT_EQ(scene.name(report->nodes[i]), paths_[i].filename());
    const auto delta = scene.commit();
    ASSERT_TRUE(delta);
    EXPECT_EQ(delta->inserted.size(), scene.item_count());
  }
}

TEST_F(ImportFiles, AppendAfterWhatIsThere) {
  core::Scene scene;
  const core::NodeId parent = scene.add_node(scene.root(), "parent"), gone = scene.add_node(parent, "gone");
  scene.add_primitive(parent, core::Sphere{1.0f}, {}, scene.add_material({.name = "own"}));
  scene.remove_node(gone);
  ASSERT_TRUE(scene.commit());
  const auto report = import_files(paths_, scene, parent);
  ASSERT_TRUE(report) << report.error().message;
  const core::Scene expected = one_by_one(paths_);
  EXPECT_EQ(scene.item_count(), expected.item_count() + 1);
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    core::Scene alone;
    const auto one = import_file(paths_[i], alone, alone.add_node(alone.root(), "parent"));
    ASSERT_TRUE(one);
    EXPECT_EQ(tests::scene_difference(alone, one->nodes[0], scene, report->nodes[i]), "");
  }
  const core::NodeId after = scene.add_node(parent, "after");
  scene.set_attribute(after, "key", "value");
  EXPECT_EQ(scene.attributes(after).size(), 1u);
  const auto delta = scene.commit();
  ASSERT_TRUE(delta);
  EXPECT_EQ(delta->inserted.size(), expected.item_count());
}

TEST_F(ImportFiles, TheFirstFailureIsToldAndNothingStays) {
  std::ofstream(paths_[3], std::ios::binary | std::ios::trunc) << "no model";
  std::ofstream(paths_[6], std::ios::binary | std::ios::trunc) << "no model either";
  for (int round = 0; round < 20; ++round) {
    core::Scene scene;
    const auto report = import_files(paths_, scene, scene.root());
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message.find("plant3.rvm"), std::string::npos) << report.error().message;
    EXPECT_EQ(scene.node_count(), 1u);
    EXPECT_EQ(scene.item_slots(), 0u);
    EXPECT_EQ(scene.material_slots(), 0u);
  }
}

TEST_F(ImportFiles, ProgressRisesOnTheCallingThreadAndCancels) {
  const auto caller = std::this_thread::get_id();
  double last = -1.0;
  ImportOptions options;
  options.progress = [&](double share) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    EXPECT_GT(share, last);
    last = share;
    return true;
  };
  core::Scene scene;
  ASSERT_TRUE(import_files(paths_, scene, scene.root(), options));
  EXPECT_EQ(last, 1.0);

  for (const double until : {0.0, 0.3, 0.5}) {
    core::Scene cancelled;
    options.progress = [&](double share) { return share < until; };
    const auto report = import_files(paths_, cancelled, cancelled.root(), options);
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().message, kCancelled);
    EXPECT_EQ(cancelled.node_count(), 1u);
    EXPECT_EQ(cancelled.item_slots(), 0u);
  }
}

}  // namespace
}  // namespace sightline::importers
