// Stand-in for drawing.h in builds without GL: create() always fails. Internal to engine.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "sightline/engine/engine.h"
#include "sightline/engine/internal/culled.h"
#include "sightline/engine/internal/overrides.h"

namespace sightline::engine {

class Drawing {
 public:
  static core::Expected<std::unique_ptr<Drawing>> begin(const EngineConfig&, const Overrides&) {
    return core::fail("drawing and the GPU culler need OpenGL, and this build was made without it (SIGHTLINE_GL)");
  }
  static core::Expected<std::unique_ptr<Drawing>> create(const core::Snapshot&, const gpuprims::Joints&,
                                                         const EngineConfig& config, const Overrides& overrides, bool) {
    return begin(config, overrides);
  }
  core::Expected<bool> advance(const core::Snapshot&, const gpuprims::Joints&, bool,
                               std::chrono::steady_clock::time_point) {
    return true;
  }
  void follow_later(std::span<const core::Slot>, std::span<const std::uint32_t>) {}
  core::Expected<bool> advance_order(const core::Snapshot&, const gpuprims::Joints&, bool,
                                     std::chrono::steady_clock::time_point) {
    return true;
  }
  core::Expected<void> take_order(const core::Snapshot&, const core::Snapshot&, const gpuprims::Joints&, bool) {
    return {};
  }
  void abandon_order() {}
  static void plan_programs(Plan&, const core::Snapshot&, bool) {}

  // None of these is ever called.
  struct KeptState {};
  static KeptState keep_current() { return {}; }
  KeptState keep_state() const { return {}; }
  void configure(const EngineConfig&) {}
  void put_into(const core::ExternalTarget*) {}
  struct Feedback {
    std::uint64_t frame = 0, visible = 0, shown = 0;
    std::optional<double> time_ms;
    double gpu_ms = 0.0;
  };
  core::Expected<void> draw(const Culled&, std::uint64_t, double, bool) { return {}; }
  core::Expected<void> draw_from_aside(const core::View&, const Culled&, std::uint64_t, double) { return {}; }
  core::Expected<LeftOut> left_out(const Culled&) { return {}; }
  core::Expected<LossReport> loss(const Culled&) { return {}; }
  void picture_changed() {}
  core::Expected<void> cull(const core::View&, const core::View&, const core::Snapshot&, std::uint64_t) { return {}; }
  bool has_overlays() const { return false; }
  bool blends() const { return false; }
  glm::vec2 blend_range(const core::View&, const core::Snapshot&, const core::VisibleSet&) { return {}; }
  void set_blend_range(const std::optional<glm::vec2>&) {}
  core::Expected<void> draw_culled(const core::View&, const core::Snapshot&, std::uint64_t, const Culled*) {
    return {};
  }
  core::Expected<void> update(const core::Snapshot&, const gpuprims::Joints&, std::span<const core::Slot>,
                              std::span<const std::uint32_t>) {
    return {};
  }
  core::Expected<void> update_looks(const core::Snapshot&, const gpuprims::Joints&, std::span<const core::Slot>,
                                    std::span<const std::uint32_t>) {
    return {};
  }
  core::Expected<void> rebuild(const core::Snapshot&, const gpuprims::Joints&, bool) { return {}; }
  core::Expected<void> add_culler(const core::Snapshot&) { return {}; }
  core::Expected<void> resize(int, int) { return {}; }
  core::Expected<void> use_picture(std::uint32_t, int, int) { return {}; }
  void forget_picture(std::uint32_t) {}
  core::Expected<void> make_current() const { return {}; }
  std::optional<Feedback> take_drawn() { return {}; }
  std::optional<Feedback> take_gpu_feedback() { return {}; }
  std::optional<culling::GpuVariant> gpu_variant() const { return {}; }
  std::string why_gpu_variant() const { return {}; }
  std::string platform() const { return {}; }
  std::string renderer() const { return {}; }
  std::vector<std::string> take_gl_errors() { return {}; }
  double waited_ms() const { return 0.0; }
  bool lost() const { return false; }
  bool software() const { return false; }
  struct Counts {
    std::int64_t sampled = 0, shown = 0, small = 0, pending = 0, squares = 0;
  };
  Counts counts() const { return {}; }
  void finish() {}
  std::size_t memory_bytes() const { return 0; }
};

}  // namespace sightline::engine
