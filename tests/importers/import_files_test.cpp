#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include "sightline/importers/import.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/tests/importers/rvm_bytes.h"
#include "sightline/tests/importers/scene_compare.h"

namespace sightline::importers::import_files_test {
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

TEST_F(ImportFiles, AllIsDoneWhenTheLastFileIsThere) {
  core::Scene scene;
  const std::size_t nodes = one_by_one(paths_).node_count();
  double last = -1.0;
  const auto report =
      import_files(paths_, scene, scene.root(), {.threads = kFiles, .progress = [&](double share) {
                                                   // Time for the readers to end, while little has been appended.
                                                   if (last < 0.0)
                                                     std::this_thread::sleep_for(std::chrono::milliseconds(300));
                                                   last = share;
                                                   EXPECT_EQ(share == 1.0, scene.node_count() == nodes) << share;
                                                   return true;
                                                 }});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(last, 1.0);
}

TEST_F(ImportFiles, OneThreadReadsNoMoreThanTwoFilesAhead) {
  std::vector<double> shares;
  core::Scene scene;
  const auto report =
      import_files(paths_, scene, scene.root(), {.threads = 1, .progress = [&](double share) {
                                                   if (shares.size() < 2)
                                                     std::this_thread::sleep_for(std::chrono::milliseconds(200));
                                                   shares.push_back(share);
                                                   return true;
                                                 }});
  ASSERT_TRUE(report) << report.error().message;
  // At the second report two files are there at most; the smallest four of nine are less than half.
  ASSERT_GE(shares.size(), 3u);
  EXPECT_LT(shares[1], 0.5);
}

TEST_F(ImportFiles, WhatStretchesTooFarBelowTheParentIsDropped) {
  const auto far = [&](const char* name) {
    tests::RvmBytes b;
    b.head().group("g", 1).begin("PRIM").u32(1).u32(9);
    b.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 1e10f, 0, 0}).floats({-1, -1, -1, 1, 1, 1}).f32(1).end();
    b.prim(9, {1}).group_end().finish();
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(b.bytes.data()), std::streamsize(b.bytes.size()));
    return folder_ / name;
  };
  const std::vector<fs::path> paths = {far("a.rvm"), far("b.rvm")};
  core::Scene scene;
  const core::NodeId parent = scene.add_node(scene.root(), "parent", {core::dmat3(1e30), {}});
  const auto report = import_files(paths, scene, parent);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(scene.item_count(), 2u);
  EXPECT_EQ(report->warnings.size(), 2u);
  EXPECT_TRUE(scene.commit());
}

/// Reports of several files, and attribute files among them.
class SmallFiles : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("sightline_small_files_") + test->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, std::string_view text) {
    std::ofstream(folder_ / name, std::ios::binary).write(text.data(), std::streamsize(text.size()));
    return folder_ / name;
  }
  /// A facet group of the given size and another like it, turned; a degenerate cylinder; a stray group end.
  fs::path model(const std::string& name, float size) {
    tests::RvmBytes b;
    b.head().group("g", 1).prim(8, {1, 0});
    for (const float angle : {0.0f, 0.3f}) {
      b.item(11).u32(1).u32(1).u32(5);
      for (const auto& [x, y] : {std::pair{0.f, 0.f}, {5.f, 1.f}, {7.f, 3.f}, {2.f, 6.f}, {-1.f, 3.f}}) {
        const float s = std::sin(angle), c = std::cos(angle);
        b.floats({size * (c * x - s * y), size * (s * x + c * y), 0, 0, 0, 1});
      }
      b.end();
    }
    b.group_end().group_end().finish();
    return write(name, {reinterpret_cast<const char*>(b.bytes.data()), b.bytes.size()});
  }
  fs::path attributes(const std::string& name) {
    return write(name, "CADC_Attributes_File v1.0\nNEW g\nkey:= " + name + "\nEND\n");
  }

  fs::path folder_;
};

TEST_F(SmallFiles, ReportsAddUp) {
  const std::vector<fs::path> paths = {model("a.rvm", 1000), model("b.rvm", 1)};
  core::Scene scene, alone;
  const auto both = import_files(paths, scene, scene.root());
  const auto a = import_file(paths[0], alone, alone.root()), b = import_file(paths[1], alone, alone.root());
  ASSERT_TRUE(both && a && b);
  EXPECT_EQ(a->degenerate, 1u);
  EXPECT_EQ(both->degenerate, 2u);
  EXPECT_EQ(a->shared_meshes, 1u);
  EXPECT_EQ(both->shared_meshes, 2u);
  EXPECT_EQ(both->bytes, a->bytes + b->bytes);
  EXPECT_GT(b->sharing_error, 0.0);
  EXPECT_GT(a->sharing_error, b->sharing_error);
  EXPECT_EQ(both->sharing_error, a->sharing_error);
  ASSERT_EQ(both->warnings.size(), 2u);
  EXPECT_EQ(both->warnings[0].file, "a.rvm");
  EXPECT_EQ(both->warnings[1].file, "b.rvm");
}

TEST_F(SmallFiles, AttributesComeAfterTheModels) {
  const std::vector<fs::path> paths = {attributes("a.TXT"), attributes("b.ATT"), model("a.rvm", 1), model("b.rvm", 1)};
  core::Scene scene;
  double last = -1.0;
  const auto report = import_files(paths, scene, scene.root(), {.progress = [&](double share) {
                                     EXPECT_GE(share, last);
                                     last = share;
                                     return true;
                                   }});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(last, 1.0);
  EXPECT_EQ(report->attributed, 2u);
  ASSERT_EQ(report->nodes.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const core::Scene::Attributes expected = {{"key", i == 0 ? "a.TXT" : "b.ATT"}};
    EXPECT_EQ(scene.attributes(scene.first_child(report->nodes[i])), expected);
  }
}

TEST_F(SmallFiles, AFailingAttributeFileTakesTheModelsBack) {
  const std::vector<fs::path> paths = {model("a.rvm", 1), model("b.rvm", 1), write("a.txt", "no attributes")};
  core::Scene scene;
  EXPECT_FALSE(import_files(paths, scene, scene.root()));
  EXPECT_EQ(scene.node_count(), 1u);
  EXPECT_EQ(scene.item_slots() + scene.mesh_slots() + scene.material_slots(), 0u);
}

}  // namespace
}  // namespace sightline::importers::import_files_test
