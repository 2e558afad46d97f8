// The GPU culler of an engine, and how its result is drawn. Internal to engine.
#pragma once

#include <optional>
#include <string>

#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/engine/drawing/internal/draw_context.h"

namespace sightline::engine {

/// Costs nothing until a culler is made. `left_out`, a bit per slot: items that are drawn over the image instead, which
/// the culler must not find.
class GpuCulling {
 public:
  /// Creates a culler for a scene that holds the snapshot. The first one of a context measures which variant to use.
  core::Expected<culling::GpuCuller> make(const DrawContext& context, const core::Snapshot& snapshot,
                                          const gpuscene::GpuScene& scene);
  /// Takes a culler that make() has created, or none.
  void use(std::optional<culling::GpuCuller> culler) { culler_ = std::move(culler); }
  const culling::GpuCuller* culler() const { return culler_ ? &*culler_ : nullptr; }
  const std::string& why_variant() const { return why_variant_; }
  std::size_t memory_bytes() const { return culler_ ? culler_->memory_bytes() : 0; }

  /// Leaves out the items with a bit. The scene must have all slots of the snapshot.
  core::Expected<void> leave_out(const DrawContext& context, const core::Snapshot& snapshot,
                                 culling::SlotBits left_out);
  /// Follows an edit of these slots. `moved`: bounds may have changed, not only what is drawn.
  core::Expected<void> update(const DrawContext& context, const core::Snapshot& snapshot,
                              std::span<const core::Slot> touched, culling::SlotBits left_out, bool moved);

  /// Culls for a frame. take_feedback() tells its number with the result, some frames later.
  core::Expected<void> cull(DrawContext& context, const Frame& frame);
  /// Draws what the last cull() has found.
  core::Expected<void> draw(DrawContext& context, const Frame& frame);
  std::optional<culling::GpuCuller::Feedback> take_feedback() {
    return culler_ ? culler_->take_feedback() : std::nullopt;
  }

 private:
  bool tests_occlusion(const DrawContext& context, std::size_t items) const;

  std::optional<culling::GpuCuller> culler_;
  std::optional<culling::GpuVariant> variant_;  // once it is settled
  std::string why_variant_;
  std::optional<culling::GpuCuller::Image> image_;  // of the last cull(); none where all of the view is drawn
};

}  // namespace sightline::engine
