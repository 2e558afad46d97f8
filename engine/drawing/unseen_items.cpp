#include "sightline/engine/drawing/internal/unseen_items.h"

#include <algorithm>

#include "sightline/core/internal/store.h"

namespace sightline::engine {

core::Expected<void> UnseenItems::split(DrawContext& context, const Frame& frame, const core::VisibleSet& visible) {
  if (split_view_ && core::same_image(*split_view_, frame.cull_view)) return {};
  context.image->changed();
  split_view_.reset();
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  const Frame culled{frame.cull_view, frame.cull_view, frame.snapshot, frame.lines, frame.hierarchy};
  if (context.may_test_occlusion()) {
    if (auto done = in_passes_.draw(context, culled, visible); !done) return tl::unexpected(done.error());
    context.occlusion_test(culled).filter(bounds, visible, seen_, frame.lines, &context.threads);
  } else if (context.config.culling.sample_test) {
    context.sample_test(culled).filter(bounds, visible, seen_, frame.lines, &context.threads);
  } else {
    seen_ = visible;
  }
  std::vector<std::uint64_t> seen(culling::bit_words(bounds.size()));
  culling::set_bits(seen_, seen);
  unseen_.clear();
  unseen_.generation = seen_.generation = visible.generation;
  visible.for_each_slot([&](core::Slot slot) {
    if (!bounds.vacant(slot) && !culling::contains(seen, slot)) unseen_.single_slots.push_back(slot);
  });
  std::sort(unseen_.single_slots.begin(), unseen_.single_slots.end());
  if (auto done = make_materials(context, frame.snapshot); !done) return done;
  split_view_ = frame.cull_view;
  return {};
}

core::Expected<void> UnseenItems::make_materials(const DrawContext& context, const core::Snapshot& snapshot) {
  const core::vec3 colour = context.config.drawing.culled_colour.value_or(core::vec3(0.0f));
  const std::vector<glm::vec4> rows(snapshot.materials().size() + 1, glm::vec4(colour, 1.0f));
  return core::store(gl::TexelArray::create(context.gl(), rows.size() * sizeof(rows[0]), rows.data(), GL_RGBA32F,
                                            "colour of unseen items", 0),
                     materials_);
}

core::Expected<std::int64_t> UnseenItems::draw(DrawContext& context, const Frame& frame) {
  const core::VisibleSet* left = &unseen_;
  if (context.may_test_occlusion()) {
    if (auto read = context.read_back_depth(frame.view, context.target()); !read) return tl::unexpected(read.error());
    context.occlusion_test(frame).filter(frame.snapshot.bounds(), unseen_, drawn_);
    left = &drawn_;
  }
  const auto count = std::int64_t(frame.snapshot.count(*left));
  return context.draw(frame, {*left, context.target(), nullptr, 0.0, &materials_.texels}).map([count] {
    return count;
  });
}

}  // namespace sightline::engine
