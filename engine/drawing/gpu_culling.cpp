#include "sightline/engine/drawing/internal/gpu_culling.h"

namespace sightline::engine {
namespace {

bool can_test_occlusion(const DrawContext& context, const culling::GpuCuller& culler) {
  return context.config.draw && context.target().format().samples == 1 && culler.can_test_occlusion();
}

}  // namespace

core::Expected<culling::GpuCuller> GpuCulling::make(const DrawContext& context, const core::Snapshot& snapshot,
                                                    const gpuscene::GpuScene& scene) {
  culling::GpuCullerConfig config = {context.config.culling.gpu_variant};
  if (variant_) config.variant = variant_;
  auto culler = culling::GpuCuller::create(context.context, snapshot, scene, config);
  if (!culler) return culler;
  if (why_variant_.empty() || !config.variant) why_variant_ = culler->why_this_variant();
  if (culler->variant_settled()) variant_ = culler->variant();
  const bool occlusion =
      context.config.culling.occlusion == OcclusionChoice::kOn && can_test_occlusion(context, *culler);
  const bool tests_image = context.config.draw && (context.config.culling.sample_test || occlusion);
  if (auto done = culler->prepare(tests_image, occlusion); !done) return tl::unexpected(done.error());
  return culler;
}

core::Expected<void> GpuCulling::leave_out(const DrawContext& context, const core::Snapshot& snapshot,
                                           culling::SlotBits left_out) {
  if (!culler_) return {};
  const std::vector<core::Slot> slots = culling::slots_of(left_out);
  return slots.empty() ? core::Expected<void>() : culler_->update(snapshot, *context.scene, slots, left_out);
}

core::Expected<void> GpuCulling::update(const DrawContext& context, const core::Snapshot& snapshot,
                                        std::span<const core::Slot> touched, culling::SlotBits left_out, bool moved) {
  if (!culler_) return {};
  return moved ? culler_->update(snapshot, *context.scene, touched, left_out)
               : culler_->update_shown(snapshot, *context.scene, touched, left_out);
}

bool GpuCulling::tests_occlusion(const DrawContext& context, std::size_t items) const {
  if (context.config.culling.occlusion == OcclusionChoice::kOff || !can_test_occlusion(context, *culler_)) return false;
  return context.config.culling.occlusion == OcclusionChoice::kOn || items >= kGpuOcclusionScene;
}

core::Expected<void> GpuCulling::cull(DrawContext& context, const Frame& frame) {
  image_.reset();
  const bool occlusion = tests_occlusion(context, frame.snapshot.size());
  if (context.renderer && (context.config.culling.sample_test || occlusion))
    image_ = {frame.view, context.samples(), occlusion};
  const std::optional<lod::ImageError> error = context.mesh_error(frame.view);
  return culler_->cull(frame.cull_view, frame.snapshot, *context.scene, *context.lists,
                       {frame.number, image_ ? &*image_ : nullptr, error ? &*error : nullptr});
}

/// With the occlusion test, the items follow that the first pass has neither drawn nor occludes.
core::Expected<void> GpuCulling::draw(DrawContext& context, const Frame& frame) {
  const render::RenderTarget& target = context.target();
  const render::DrawPass pass{frame.view, frame.snapshot, *context.scene, *context.lists, target};
  auto done = context.renderer->clear(target);
  if (done) done = context.renderer->draw(pass);
  if (!done || !image_ || !image_->occlusion) return done;
  const double error = render::RenderTarget::orthographic_error(frame.view);
  done = culler_->cull_others(*image_, *context.scene, *context.lists, target.depth(), error);
  return done ? context.renderer->draw(pass) : done;
}

}  // namespace sightline::engine
