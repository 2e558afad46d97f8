#include "sightline/engine/drawing/internal/unseen_items.h"

#include <algorithm>

namespace sightline::engine {

core::Expected<void> UnseenItems::split(DrawContext& context, const Culled& culled) {
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  if (split_view_ && core::same_image(*split_view_, view)) return {};
  context.image->changed();
  split_view_.reset();
  const core::ItemBounds& bounds = snapshot.bounds();
  if (context.may_test_occlusion()) {
    if (auto done = in_passes_.draw(context, {culled}); !done) return tl::unexpected(done.error());
    context.occlusion_test(view, bounds).filter(bounds, visible, seen_, lines);
  } else if (context.config.culling.sample_test) {
    context.sample_test(view, bounds).filter(bounds, visible, seen_, lines);
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
  if (auto done = make_materials(context, snapshot); !done) return done;
  split_view_ = view;
  return {};
}

core::Expected<void> UnseenItems::make_materials(const DrawContext& context, const core::Snapshot& snapshot) {
  const core::vec3 colour = context.config.drawing.culled_colour.value_or(core::vec3(0.0f));
  const std::vector<glm::vec4> rows(snapshot.materials().size() + 1, glm::vec4(colour, 1.0f));
  auto buffer = gl::Buffer::create(context.gl(), std::span(rows), 0, "colour of unseen items");
  if (!buffer) return tl::unexpected(buffer.error());
  auto texels = gl::TextureBuffer::create(context.gl(), *buffer, GL_RGBA32F, "colour of unseen items");
  if (!texels) return tl::unexpected(texels.error());
  materials_ = std::move(*texels);
  rows_ = std::move(*buffer);
  return {};
}

core::Expected<std::int64_t> UnseenItems::draw(DrawContext& context, const core::View& view,
                                               const core::Snapshot& snapshot) {
  const core::ItemBounds& bounds = snapshot.bounds();
  const core::VisibleSet* left = &unseen_;
  if (context.may_test_occlusion()) {
    if (auto read = context.read_back_depth(view, context.target()); !read) return tl::unexpected(read.error());
    context.occlusion_test(view, bounds).filter(bounds, unseen_, drawn_);
    left = &drawn_;
  }
  const auto count = std::int64_t(snapshot.count(*left));
  return context.draw_more(view, snapshot, *left, context.target(), &materials_).map([count] { return count; });
}

}  // namespace sightline::engine
