// Scattered elements of buffers, and the edits of a scene that are written with them.
#include "sightline/gpuscene/internal/element_writer.h"

#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "sightline/apps/bench/gl_call_count.h"
#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::element_writer_test {
namespace {

using gpuscene::ElementWriter;
using gpuscene::GpuScene;
using Random = std::mt19937_64;

using ElementWriterTest = tests::GlTest;

std::vector<std::uint32_t> contents(const gl::Buffer& buffer) {
  std::vector<std::uint32_t> words(buffer.size() / 4);
  buffer.read(0, buffer.size(), words.data());
  return words;
}

/// Without the spare room behind them, which holds anything.
std::vector<std::uint32_t> records_of(const gpuscene::Batch& batch) {
  std::vector<std::uint32_t> words = contents(batch.records);
  words.resize(batch.count * gpuscene::record_bytes(batch.kind) / 4);
  return words;
}

/// Elements of `words` words to random places, of which a share is written.
void expect_written(const gl::Context& context, ElementWriter& writer, Random& random, std::size_t words,
                    double share) {
  constexpr std::size_t kPlaces = 5000;
  std::vector<std::uint32_t> wanted(kPlaces * words), places, data;
  std::iota(wanted.begin(), wanted.end(), 0u);
  auto buffer = gl::Buffer::create(context.functions(), std::span(wanted), GL_DYNAMIC_STORAGE_BIT, "elements");
  ASSERT_TRUE(buffer);
  for (std::uint32_t place = 0; place < kPlaces; ++place) {
    if (std::uniform_real_distribution<double>(0.0, 1.0)(random) >= share) continue;
    places.push_back(place);
    for (std::size_t word = 0; word < words; ++word)
      data.push_back(wanted[place * words + word] = std::uint32_t(random()));
  }
  writer.write(*buffer, words * 4, places, data.data());
  EXPECT_EQ(contents(*buffer), wanted) << words << " words, share " << share;
}

TEST_F(ElementWriterTest, PutsEachInItsPlace) {
  Random random(5);
  ElementWriter writer(*context);
  for (const std::size_t words : {1, 5, 16, 384})
    for (const double share : {0.0, 0.001, 0.1, 0.9, 1.0}) expect_written(*context, writer, random, words, share);
}

TEST_F(ElementWriterTest, WritesOneByOneWhereStorageBlocksAreTooSmall) {
  const_cast<gl::Capabilities&>(context->capabilities()).max_storage_block_bytes = 1024;
  Random random(6);
  ElementWriter writer(*context);
  expect_written(*context, writer, random, 4, 0.1);
}

/// Cylinders and meshes in a row.
class ManyEdits : public tests::GlTest {
 protected:
  static constexpr std::size_t kItems = 20'000;

  void SetUp() override {
    tests::GlTest::SetUp();
    core::Mesh triangle;
    triangle.positions = {{0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}};
    triangle.indices = {0, 1, 2};
    const core::MeshId mesh = scene.add_mesh(triangle).value();
    for (std::size_t i = 0; i < kItems; ++i) {
      const core::Affine place = core::translation({double(i % 200), double(i / 200), 0.0});
      items.push_back(i % 2 == 0 ? scene.add_primitive(scene.root(), core::Cylinder{0.2f, 0.5f}, place)
                                 : scene.add_mesh_instance(scene.root(), mesh, place));
    }
    EXPECT_TRUE(scene.commit());
  }

  /// Hides every `stride`-th item; returns the GL calls of following that.
  std::uint64_t calls_of_hiding(core::Snapshot& snapshot, GpuScene& gpu, culling::GpuCuller& culler,
                                std::size_t stride) {
    for (std::size_t i = 0; i < kItems; i += stride) scene.set_visible(items[i], false);
    const std::vector<core::Slot> touched = snapshot.apply(*scene.commit());
    EXPECT_GE(touched.size(), kItems / stride);
    const bench::GlCallCount count(*context);
    EXPECT_TRUE(gpu.append(snapshot));
    gpu.update(snapshot, touched);
    EXPECT_TRUE(culler.update(snapshot, gpu, touched));
    return count.calls();
  }

  core::Scene scene;
  std::vector<core::ItemId> items;
};

TEST_F(ManyEdits, TakeFewCallsAndLeaveWhatANewSceneHas) {
  for (const auto form : {culling::GpuVariant::kGeometry, culling::GpuVariant::kCompute}) {
    core::Snapshot snapshot(scene);
    auto gpu = GpuScene::create(*context, snapshot);
    ASSERT_TRUE(gpu);
    auto culler = culling::GpuCuller::create(*context, snapshot, *gpu, {form});
    ASSERT_TRUE(culler);
    for (const core::ItemId item : items) scene.set_visible(item, true);
    snapshot.apply(*scene.commit());
    const std::uint64_t of_hundred = calls_of_hiding(snapshot, *gpu, *culler, 200),
                        of_thousands = calls_of_hiding(snapshot, *gpu, *culler, 7);
    EXPECT_LT(of_hundred, 400u);
    EXPECT_LT(of_thousands, 400u) << "for " << kItems / 7 << " edits";

    auto anew = GpuScene::create(*context, snapshot);
    ASSERT_TRUE(anew);
    for (const gpuscene::Batch& batch : gpu->batches())
      EXPECT_EQ(records_of(batch), records_of(*anew->batch(batch.kind))) << gpuscene::name_of(batch.kind);
    auto view = core::View::orthographic({{100, 50, 10}, {100, 50, 0}, {0, 1, 0}}, 60.0, 1.5, 0.0, 20.0);
    ASSERT_TRUE(view);
    auto lists = gpuscene::DrawLists::create(*context, *gpu);
    ASSERT_TRUE(culler->cull(*view, snapshot, *gpu, *lists));
    const auto found = culler->read_back(*lists).single_slots;
    auto fresh = culling::GpuCuller::create(*context, snapshot, *anew, {form});
    ASSERT_TRUE(fresh->cull(*view, snapshot, *anew, *lists));
    EXPECT_EQ(found, fresh->read_back(*lists).single_slots);
    EXPECT_GT(found.size(), 1000u);
    for (const core::ItemId item : items) scene.set_visible(item, true);
    EXPECT_TRUE(scene.commit());
  }
}

}  // namespace
}  // namespace sightline::element_writer_test
