// What a warm-up has drawn is compiled: the program cache has the programs of the first frame.
#include "sightline/engine/drawing/internal/warm_up.h"

#include <filesystem>
#include <fstream>
#include <thread>

#include <unistd.h>

#include "sightline/gl/internal/program_cache.h"
#include "sightline/render/internal/renderer.h"
#include "sightline/tests/support/environment.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::warm_up_test {
namespace {

namespace fs = std::filesystem;
using gpuscene::BatchKind;

/// Mesa has program binaries only where it has a cache of its own, and it looks when the first context is made.
const bool kMesaCache = [] {
  core::platform::set_environment("MESA_SHADER_CACHE_DISABLE", "false");
  return true;
}();

class WarmUpTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!context) return;
    fs::remove_all(folder);
    if (!context->capabilities().software || std::thread::hardware_concurrency() < 2 ||
        !gl::ProgramCache(context->functions(), folder).enabled())
      GTEST_SKIP() << "the driver compiles programs otherwise, or keeps none";
    config.context.program_cache = folder;
  }
  void TearDown() override {
    fs::remove_all(folder);
    GlTest::TearDown();
  }

  std::vector<BatchKind> cached(const render::TargetFormat& format) const {
    std::vector<BatchKind> found;
    for (int kind = 0; kind < gpuscene::kBatchKindCount; ++kind)
      if (render::Renderer::has_cached(context->functions(), BatchKind(kind), format)) found.push_back(BatchKind(kind));
    return found;
  }
  std::size_t entries() const {
    return fs::exists(folder) ? std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()))
                              : 0;
  }

  const fs::path folder = fs::temp_directory_path() / ("sightline-warm-up-" + std::to_string(getpid()));
  engine::EngineConfig config;
};

TEST_F(WarmUpTest, CompilesWhatTheCacheLacksOfTheKinds) {
  context->cache_programs(folder);
  for (const render::TargetFormat& format : {render::TargetFormat{.ids = true}, render::TargetFormat{.samples = 4}}) {
    std::vector<BatchKind> all;
    for (int kind = 0; kind < gpuscene::kBatchKindCount; ++kind) all.push_back(BatchKind(kind));
    const std::vector<BatchKind> some = {BatchKind::kCylinder, BatchKind::kMesh};
    EXPECT_TRUE(cached(format).empty());
    engine::warm_up(*context, config, format, some);
    EXPECT_EQ(cached(format), some);
    engine::warm_up(*context, config, format, all);
    EXPECT_EQ(cached(format), all);
    const std::size_t before = entries();
    engine::warm_up(*context, config, format, all);
    EXPECT_EQ(entries(), before);
  }
}

TEST_F(WarmUpTest, DoesNothingWithoutAProgramCache) {
  engine::warm_up(*context, config, {.ids = true}, std::vector{BatchKind::kCylinder, BatchKind::kMesh});
  EXPECT_EQ(entries(), 0u);
}

TEST_F(WarmUpTest, ACacheThatCannotBeWrittenIsNoError) {
  std::ofstream(folder) << "a file";
  context->cache_programs(folder);
  engine::warm_up(*context, config, {.ids = true}, std::vector{BatchKind::kCylinder, BatchKind::kMesh});
  EXPECT_TRUE(cached({.ids = true}).empty());
}

}  // namespace
}  // namespace sightline::tests::warm_up_test
