// The GPU culler with all that it takes to cull and to draw, beside the CPU's: what the tests of it share.
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/culling/frustum/linear_culler.h"
#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::tests {

/// All ways to cull.
inline std::vector<culling::GpuCullerConfig> all_gpu_configs() {
  return {{culling::GpuVariant::kGeometry}, {culling::GpuVariant::kCompute}};
}
inline std::string name_of(const culling::GpuCullerConfig& config) {
  return std::string(culling::name_of(*config.variant));
}
inline std::string gpu_config_name(const testing::TestParamInfo<culling::GpuCullerConfig>& info) {
  return name_of(info.param);
}

/// All that it takes to cull a scene on the GPU.
struct Rig {
  const gl::Context* context;
  core::Snapshot snapshot;
  gpuscene::GpuScene gpu;
  gpuscene::DrawLists lists;
  culling::GpuCuller culler;

  Rig(const gl::Context& gl, const core::Scene& scene, const culling::GpuCullerConfig& config)
      : context(&gl),
        snapshot(scene),
        gpu(std::move(*gpuscene::GpuScene::create(gl, snapshot))),
        lists(std::move(*gpuscene::DrawLists::create(gl, gpu))),
        culler(std::move(*culling::GpuCuller::create(gl, snapshot, gpu, config))) {}

  std::vector<core::Slot> cull(const core::View& view) {
    EXPECT_TRUE(culler.cull(view, snapshot, gpu, lists));
    return culler.read_back(lists).single_slots;
  }
  /// A set's slots but the vacant ones, which the GPU never names.
  std::vector<core::Slot> occupied(const core::VisibleSet& set) const {
    std::vector<core::Slot> slots = set.sorted_slots();
    std::erase_if(slots, [&](core::Slot slot) { return snapshot.vacant(slot); });
    return slots;
  }
  std::vector<core::Slot> cull_linear(const core::View& view) const {
    core::VisibleSet set;
    culling::LinearCuller(snapshot.bounds()).cull(view, set);
    return occupied(set);
  }
  void apply(const core::SceneDelta& delta) {
    const std::vector<core::Slot> touched = snapshot.apply(delta);
    ASSERT_TRUE(gpu.append(snapshot));
    gpu.update(snapshot, touched);
    ASSERT_TRUE(gpu.upload_meshes(core::kNoDeadline));
    ASSERT_TRUE(culler.update(snapshot, gpu, touched));
  }
};

/// Culls on the GPU and compares with `wanted`, the CPU's slots in rising order: none is lost, and what is extra lies
/// within the float planes' band. Returns how many are extra.
inline std::size_t expect_found(Rig& rig, const core::View& view, const std::vector<core::Slot>& wanted) {
  const std::vector<core::Slot> found = rig.cull(view);
  EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end()) << "named twice";
  EXPECT_TRUE(std::includes(found.begin(), found.end(), wanted.begin(), wanted.end()))
      << "of " << wanted.size() << " some are lost; found " << found.size();
  std::vector<core::Slot> extra;
  std::set_difference(found.begin(), found.end(), wanted.begin(), wanted.end(), std::back_inserter(extra));
  const core::ItemBounds& bounds = rig.snapshot.bounds();
  const culling::CullPlanes planes(view, bounds);
  for (const core::Slot slot : extra) {
    EXPECT_FALSE(bounds.vacant(slot));
    EXPECT_NE(bounds.layers(slot) & view.layers, 0u);
    EXPECT_TRUE(left_open(planes, bounds.box(slot))) << "slot " << slot << " is clearly outside";
  }
  return extra.size();
}

/// Expects the linear culler's set; the feedback must count as many.
inline std::size_t expect_same(const gl::Functions& gl, Rig& rig, const core::View& view) {
  const std::vector<core::Slot> wanted = rig.cull_linear(view);
  const std::size_t extra = expect_found(rig, view, wanted);
  gl.Finish();
  const auto feedback = rig.culler.take_feedback();
  EXPECT_TRUE(feedback) << "all is done";
  if (feedback) {
    EXPECT_EQ(feedback->visible, wanted.size() + extra);
  }
  return extra;
}

/// Draws what either path finds and compares.
class ImagePair {
 public:
  static constexpr int kWidth = 160, kHeight = 120;

  ImagePair(const gl::Context& context, const Rig& rig)
      : renderer_(std::move(*render::Renderer::create(context, rig.gpu))),
        target_(std::move(*render::RenderTarget::create(context, kWidth, kHeight, {.ids = true}))) {}

  struct Pixels {
    std::size_t shown = 0, ties = 0;  ///< ties: one of two items at the very same depth
  };
  /// Depths are equal, and colours where the same item is shown.
  Pixels expect_same(Rig& rig, const core::View& view, const core::VisibleSet& cpu_set) {
    EXPECT_TRUE(rig.lists.update(rig.snapshot, rig.gpu, cpu_set));
    const Image cpu = draw(rig, view);
    EXPECT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists));
    const Image gpu = draw(rig, view);
    EXPECT_EQ(cpu.depth.metres, gpu.depth.metres);
    Pixels pixels;
    std::size_t other_colours = 0;
    for (std::size_t i = 0; i < cpu.ids.ids.size(); ++i) {
      pixels.shown += cpu.ids.ids[i] != 0;
      if (cpu.ids.ids[i] != gpu.ids.ids[i])
        ++pixels.ties;
      else
        other_colours +=
            !std::equal(&cpu.colour.pixels[3 * i], &cpu.colour.pixels[3 * i] + 3, &gpu.colour.pixels[3 * i]);
    }
    EXPECT_EQ(other_colours, 0u);
    return pixels;
  }

 private:
  struct Image {
    image::Image colour;
    image::IdImage ids;
    image::DepthImage depth;
  };
  Image draw(const Rig& rig, const core::View& view) {
    EXPECT_TRUE(renderer_.draw(view, rig.snapshot, rig.gpu, rig.lists, target_));
    return {target_.read_colour(), target_.read_ids(), target_.read_depth(view)};
  }

  render::Renderer renderer_;
  render::RenderTarget target_;
};

}  // namespace sightline::tests
