// Reading in the background, with work on what was read.
#include "sightline/apps/view/loader.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"
#include "sightline/importers/import.h"

namespace sightline::apps::loader_test {
namespace {

class LoaderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    // Each test has its own file, since tests run at the same time.
    file = std::filesystem::path(testing::TempDir()) /
           ("loader_test_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".obj");
    std::ofstream(file) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    options.files = {file.string()};
  }
  void TearDown() override { std::filesystem::remove(file); }

  std::filesystem::path file;
  ModelOptions options;
  std::promise<void> ready;
  const std::function<void()> tell = [this] { ready.set_value(); };
};

TEST_F(LoaderTest, WorksOnTheCommittedModel) {
  std::size_t items = 0;
  double at_work = 0.0;
  std::atomic<Loader*> self = nullptr;
  const auto begun = std::chrono::steady_clock::now();
  Loader loader(options, tell, [&](Model& model, const std::function<bool(double)>& progress) {
    while (!self) std::this_thread::yield();
    EXPECT_GT(self.load()->read_at(), begun);
    EXPECT_LE(self.load()->read_at(), std::chrono::steady_clock::now());
    items = model.scene->commit()->inserted.size() + model.scene->item_count();
    EXPECT_TRUE(progress(0.5));
    at_work = self.load()->progress();
    return core::Expected<void>();
  });
  self = &loader;
  ready.get_future().wait();
  const auto model = loader.take();
  ASSERT_TRUE(model && *model);
  EXPECT_EQ(items, 1u) << "nothing was left to commit";
  EXPECT_GT(at_work, 0.5);
  EXPECT_LT(at_work, 1.0);
  EXPECT_FALSE(loader.take()) << "only once";
}

/// While the engine is made, too.
TEST_F(LoaderTest, ProgressGoesOnWithTheWork) {
  std::vector<double> shares;
  std::atomic<Loader*> self = nullptr;
  Loader loader(options, tell, [&](Model& model, const std::function<bool(double)>& progress) {
    while (!self) std::this_thread::yield();
    const auto engine = engine::Engine::create(*model.scene, {}, [&](double share) {
      const bool go_on = progress(share);
      shares.push_back(self.load()->progress());
      return go_on;
    });
    return engine ? core::Expected<void>() : tl::unexpected(engine.error());
  });
  self = &loader;
  ready.get_future().wait();
  ASSERT_TRUE(*loader.take());
  ASSERT_GE(shares.size(), 2u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_LT(shares.front(), shares.back());
  EXPECT_EQ(shares.back(), 1.0);
  core::Scene empty;
  EXPECT_FALSE(engine::Engine::create(empty, {}, [](double) { return false; })) << "cancelled";
}

TEST_F(LoaderTest, WorkThatFailsFailsTheLoader) {
  Loader loader(options, tell, [](Model&, const auto&) { return core::Expected<void>(core::fail("no such thing")); });
  ready.get_future().wait();
  const auto model = loader.take();
  ASSERT_TRUE(model && !*model);
  EXPECT_EQ(model->error().message, "no such thing");
}

TEST_F(LoaderTest, WorkCanBeCancelled) {
  std::promise<void> begun;
  Loader loader(options, tell, [&](Model&, const std::function<bool(double)>& progress) {
    begun.set_value();
    while (progress(0.5)) std::this_thread::yield();
    return core::Expected<void>(core::fail(std::string(importers::kCancelled)));
  });
  begun.get_future().wait();
  loader.cancel();
  ready.get_future().wait();
  const auto model = loader.take();
  ASSERT_TRUE(model && !*model);
  EXPECT_EQ(model->error().message, importers::kCancelled);
}

TEST_F(LoaderTest, WhatCannotBeReadIsNotWorkedOn) {
  options.files = {"/nonexistent.obj"};
  bool worked = false;
  Loader loader(options, tell, [&](Model&, const auto&) { return worked = true, core::Expected<void>(); });
  ready.get_future().wait();
  const auto model = loader.take();
  ASSERT_TRUE(model && !*model);
  EXPECT_FALSE(worked);
}

}  // namespace
}  // namespace sightline::apps::loader_test
