// Boxes in the GPU's smaller forms contain those of core: on paper in every rounding that GLSL allows, and as the
// shaders have them.
#include "sightline/culling/gpu/gpu_bounds.h"

#include <cfenv>
#include <cmath>

#include "scenes.h"
#include "sightline/culling/gpu/compact_box.h"
#include "sightline/culling/gpu/gpu_pass.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/tests/culling/test_shaders.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline {
namespace {

using core::Aabb;
using core::dvec3;
using core::Slot;
using culling::CompactBox;
using culling::GpuBounds;
using culling::GpuBoundsForm;
using tests::chance;
using tests::magnitude;
using tests::point;
using tests::Random;
using tests::uniform;
using tests::whole;

bool contains(const Aabb& outer, const Aabb& inner) {
  // Nothing is said of NaN, which no plane rejects.
  for (int i = 0; i < 3; ++i)
    if (outer.min[i] > inner.min[i] || outer.max[i] < inner.max[i]) return false;
  return true;
}

// --- compact boxes ---------------------------------------------------------------------------------------------------

/// Arithmetic as GLSL may do it: in the rounding mode of the moment, denormals as they are or flushed.
struct Arithmetic {
  bool flush = false;

  float operator()(float value) const {
    return flush && std::fpclassify(value) == FP_SUBNORMAL ? std::copysign(0.0f, value) : value;
  }
  float product(float a, float b) const {
    const volatile float x = (*this)(a), y = (*this)(b);
    return (*this)(x * y);
  }
  float sum(float a, float b) const {
    const volatile float x = (*this)(a), y = (*this)(b);
    return (*this)(x + y);
  }
};

/// compact_box.glsl.
Aabb expand(const CompactBox& box, const Aabb& around, const Arithmetic& arithmetic) {
  Aabb result;
  for (int i = 0; i < 3; ++i) {
    const float low = around.min[i], high = around.max[i], thousandth = 1.0f / 1024.0f;
    const float step = arithmetic.sum(arithmetic.product(high, thousandth), -arithmetic.product(low, thousandth));
    const float from_low = arithmetic.product(float(box.low >> (10 * i) & 1023u), step);
    const float from_high = arithmetic.product(float(box.high >> (10 * i) & 1023u), step);
    result.min[i] = arithmetic.sum(low, from_low);
    result.max[i] = arithmetic.sum(high, -from_high);
  }
  return result;
}

/// A coordinate within [low, high], often at an end or a grid line.
float within(Random& random, float low, float high) {
  if (chance(random, 0.15)) return low;
  if (chance(random, 0.15)) return high;
  double at = uniform(random, 0.0, 1.0);
  if (chance(random, 0.4)) at = std::round(1024.0 * at) / 1024.0;
  return std::clamp(float(double(low) + at * (double(high) - double(low))), low, high);
}

TEST(CompactBoxes, ContainTheBoxHoweverGlslRounds) {
  Random random(1);
  double steps_lost = 0.0;
  int plain = 0;
  for (int round = 0; round < 60'000; ++round) {
    Aabb around, box;
    const bool huge = chance(random, 0.1), tiny = chance(random, 0.1);
    for (int i = 0; i < 3; ++i) {
      const double size = chance(random, 0.1) ? 0.0
                          : huge              ? magnitude(random, 1e30, 6e38)
                          : tiny              ? magnitude(random, 1e-45, 1e-36)
                                              : magnitude(random, 1e-6, 1e4);
      const double centre = huge || tiny || chance(random, 0.3) ? 0.0 : uniform(random, -1.0, 1.0) * 1e7;
      around.min[i] = core::round_down(centre - 0.5 * size);
      around.max[i] = core::round_up(centre + 0.5 * size);
      const float a = within(random, around.min[i], around.max[i]), b = within(random, around.min[i], around.max[i]);
      box.min[i] = std::min(a, b);
      box.max[i] = std::max(a, b);
    }
    const CompactBox compacted = culling::compact(box, around);
    EXPECT_EQ(compacted.low & CompactBox::kVacant, 0u);
    for (const int mode : {FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
      for (const bool flush : {false, true}) {
        std::fesetround(mode);
        const Aabb expanded = expand(compacted, around, {flush});
        std::fesetround(FE_TONEAREST);
        // The coordinates of the box itself are flushed, too, wherever they are.
        Aabb seen = box;
        const Arithmetic arithmetic{flush};
        for (int i = 0; i < 3; ++i) seen.min[i] = arithmetic(box.min[i]), seen.max[i] = arithmetic(box.max[i]);
        ASSERT_TRUE(contains(expanded, seen)) << "round " << round << ", mode " << mode << ", flush " << flush;
      }
    }
    if (huge || tiny) continue;
    const Aabb expanded = expand(compacted, around, {});
    for (int i = 0; i < 3; ++i) {
      const double step = (double(around.max[i]) - around.min[i]) / 1024.0;
      if (step <= 1e-5 * std::abs(double(around.max[i]))) continue;
      steps_lost += (double(box.min[i]) - expanded.min[i]) / step;
      ++plain;
    }
  }
  ASSERT_GT(plain, 1000);
  EXPECT_LT(steps_lost / plain, 2.0) << "a grid line below the corner, and sometimes the next";
}

// --- as shaders see them ---------------------------------------------------------------------------------------------

class GpuBoundsTest : public tests::GlTest {
 protected:
  /// Asks the shaders for every box of a scene; returns the share of records whose box came from the cluster.
  double expect_containing(const core::Snapshot& snapshot, GpuBoundsForm form) {
    double share = 1.0;
    compare(snapshot, form, share);
    return share;
  }

 private:
  void compare(const core::Snapshot& snapshot, GpuBoundsForm form, double& share) {
    auto scene = gpuscene::GpuScene::create(*context, snapshot);
    std::vector<glm::vec4> chunks;
    for (std::uint32_t i = 0; i < snapshot.chunk_origins().size(); ++i)
      chunks.emplace_back(culling::chunk_place(snapshot, i), 0.0f);
    auto chunk_rows = gl::Buffer::create(gl(), std::span(chunks), 0, "chunks");
    auto chunk_texels = gl::TextureBuffer::create(gl(), *chunk_rows, GL_RGBA32F, "chunks");
    std::size_t present = 0, clusters = 0;
    for (const gpuscene::Batch& batch : scene->batches()) {
      SCOPED_TRACE(batch_name(batch.kind));
      std::vector<Slot> slots;
      for (Slot slot = 0; slot < snapshot.size(); ++slot)
        if (gpuscene::batch_of(snapshot.kind(slot)) == batch.kind) slots.push_back(slot);
      auto bounds = GpuBounds::create(gl(), snapshot, batch, slots, GpuBounds::form_for(batch.kind, form));
      ASSERT_TRUE(bounds) << bounds.error().message;
      const culling::CullBatch cull_batch{batch.kind, std::move(*bounds), {}, batch.texels.id(), chunk_texels->id()};
      const std::vector<float> boxes = read(cull_batch);
      for (std::size_t record = 0; record < boxes.size() / 7; ++record) {
        const float* at = &boxes[7 * record];
        const bool there = record < slots.size() && !snapshot.vacant(slots[record]);
        ASSERT_EQ(at[0] > 0.0f, there) << "record " << record;
        if (!there) continue;
        const Aabb found{{at[1], at[2], at[3]}, {at[4], at[5], at[6]}}, wanted = snapshot.bounds().box(slots[record]);
        ASSERT_TRUE(contains(found, wanted))
            << "record " << record << ", " << core::kind_name(snapshot.kind(slots[record]));
        ++present;
      }
      if (cull_batch.bounds.form() == GpuBoundsForm::kParameters) clusters += from_cluster(cull_batch);
    }
    ASSERT_GT(present, 0u);
    share = double(clusters) / double(present);
  }

  std::vector<float> read(const culling::CullBatch& batch) {
    auto description = culling::describe_item_pass("read boxes", batch, {{GL_COMPUTE_SHADER, {"read_boxes.comp"}}});
    description.shaders.tables.push_back(tests::culling_shaders::shaders());
    auto program = gl::Program::create(gl(), description);
    if (!program) {
      ADD_FAILURE() << program.error().message;
      return {};
    }
    std::vector<float> boxes(7 * culling::kClusterSize * batch.bounds.cluster_capacity());
    auto buffer = gl::Buffer::create(gl(), std::span(boxes), 0, "boxes");
    program->use();
    culling::bind_batch(gl(), batch);
    gl().BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer->id());
    gl().DispatchCompute(batch.bounds.cluster_capacity(), 1, 1);
    gl().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    buffer->read(0, buffer->size(), boxes.data());
    return boxes;
  }

  static std::size_t from_cluster(const culling::CullBatch& batch) {
    std::vector<std::uint32_t> bits(4 * batch.bounds.cluster_capacity());
    const gl::Buffer& buffer = batch.bounds.item_boxes().buffer;
    buffer.read(0, buffer.size(), bits.data());
    std::size_t count = 0;
    for (std::size_t i = 0; i < bits.size(); ++i)
      if (i % 4 < 2) count += std::size_t(std::popcount(bits[i] & ~bits[i + 2]));
    return count;
  }
};

constexpr GpuBoundsForm kForms[] = {GpuBoundsForm::kFloat, GpuBoundsForm::kCompact, GpuBoundsForm::kParameters};

/// Random shapes of all kinds, rotated, sheared, mirrored and far away; some without any extent.
TEST_F(GpuBoundsTest, ContainTheBoxesOfCore) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Random random(seed);
    core::Scene scene;
    const dvec3 site = seed % 2 ? dvec3(0.0) : dvec3(1e7, -1e7, 100.0);
    for (int i = 0; i < 4000; ++i) {
      const auto kind = core::Kind(whole(random, 0, core::kPrimitiveKindCount - 1));
      core::Primitive primitive = tests::random_primitive(kind, random);
      if (chance(random, 0.3)) primitive = core::CircularTorus{1.0f, 0.2f, float(uniform(random, 1e-4, 7.0))};
      if (chance(random, 0.1))
        primitive = core::Snout{1.0f, 0.5f, 1.0f, 0.2f, 0.1f, float(uniform(random, -0.4, 0.4)), 0.1f, 0.2f, -0.1f};
      if (chance(random, 0.02)) primitive = core::Cylinder{0.0f, 1.0f};
      if (chance(random, 0.02)) primitive = core::Cylinder{1.0f, 0.0f};
      if (chance(random, 0.02)) primitive = core::Snout{1.0f, 0.5f, 0.0f, 0.3f, 0.0f, 0.1f, 0, 0, 0};
      if (chance(random, 0.02)) primitive = core::SphericalDish{1.0f, 1e-5f};
      core::Affine placement = core::translation(site + point(random, 200.0));
      const double size = magnitude(random, 1e-4, 1.0);
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
          placement.linear[c][r] = chance(random, 0.2) ? 0.0 : size * uniform(random, -1.0, 1.0);
      scene.add_primitive(scene.root(), primitive, placement);
    }
    ASSERT_TRUE(scene.commit());
    const core::Snapshot snapshot(scene);
    for (const GpuBoundsForm form : kForms) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", " + std::string(name_of(form)));
      EXPECT_LT(expect_containing(snapshot, form), 0.1);
    }
  }
}

/// Of a plant nearly all boxes come from records, and all that are hidden are seen to be.
TEST_F(GpuBoundsTest, OfAPlantComeFromRecords) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({20'000, 2}, scene));
  for (core::ItemId item = 0; item < scene.item_slots(); item += 7) scene.set_visible(item, false);
  ASSERT_TRUE(scene.commit());
  const core::Snapshot snapshot(scene);
  for (const GpuBoundsForm form : kForms) {
    SCOPED_TRACE(name_of(form));
    EXPECT_LT(expect_containing(snapshot, form), 1e-3);
  }
}

}  // namespace
}  // namespace sightline
