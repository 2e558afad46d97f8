// Functions of Engine that read the drawn image, and that draw over a copy of it.
#include <algorithm>
#include <type_traits>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/engine/internal/engine_state.h"

namespace sightline::engine {
namespace {

tl::unexpected<core::Error> no_image() {
  return core::fail("image: nothing is drawn without EngineConfig::draw, or while the context is lost");
}

}  // namespace

core::Expected<image::Image> Backend::read_colour() {
  return no_image();
}
core::Expected<image::IdImage> Backend::read_ids() {
  return no_image();
}
core::Expected<image::DepthImage> Backend::read_depth(const core::View*) {
  return no_image();
}

namespace {

/// Result of `read` for the image's target.
template <class Read>
auto read_from(Drawing* drawing, Read read) -> core::Expected<std::invoke_result_t<Read, const render::RenderTarget&>> {
  if (!drawing || drawing->target().width() == 0) return no_image();
  const gl::Functions& gl = drawing->context().functions();
  gl::discard_errors(gl);
  auto result = read(drawing->target());
  if (const GLenum error = gl::check_error(gl); error != GL_NO_ERROR)
    return core::fail("image: reading it failed with " + gl::error_name(error));
  return result;
}

}  // namespace

core::Expected<image::Image> Drawing::read_colour() {
  return read_from(drawing(), [](const render::RenderTarget& target) { return target.read_colour(); });
}

core::Expected<image::IdImage> Drawing::read_ids() {
  return read_from(drawing(), [](const render::RenderTarget& target) { return target.read_ids(); });
}

core::Expected<image::DepthImage> Drawing::read_depth(const core::View* view) {
  return read_from(drawing(), [&](const render::RenderTarget& target) {
    return view ? target.read_depth(*view)
                : image::DepthImage{target.width(), target.height(), target.read_reversed_depths()};
  });
}

core::Expected<image::Image> Engine::read_colour() {
  const auto kept = state_->keep_state();
  return state_->backend->read_colour();
}

core::Expected<image::IdImage> Engine::read_ids() {
  if (config().draw && !config().drawing.ids)
    return core::fail("image: ids are not drawn without EngineConfig::drawing.ids");
  const auto kept = state_->keep_state();
  return state_->backend->read_ids();
}

core::Expected<image::DepthImage> Engine::read_depth(const core::View& view) {
  const auto kept = state_->keep_state();
  return state_->backend->read_depth(&view);
}

core::Expected<image::DepthImage> EngineParts::reversed_depths(Engine& engine) {
  const auto kept = engine.state_->keep_state();
  return engine.state_->backend->read_depth(nullptr);
}

core::Expected<bool> Engine::covered() {
  const auto depths = EngineParts::reversed_depths(*this);
  if (!depths) return tl::unexpected(depths.error());
  return std::ranges::any_of(depths->metres, [](float depth) { return depth > 0.0f; });
}

core::Expected<std::uint32_t> Engine::framebuffer() {
  const auto kept = state_->keep_state();
  if (state_->backend->traces()) return core::fail("image: rays draw into no framebuffer");
  return read_from(state_->backend->drawing(),
                   [](const render::RenderTarget& target) { return std::uint32_t(target.resolved().id()); });
}

core::Expected<void> Engine::draw_outline(const core::View& view, std::span<const core::ItemId> items,
                                          const gl::ExternalTarget& target) {
  if (!config().draw || !config().context.application)
    return core::fail(
        "engine: an outline needs EngineConfig::draw and the application's EngineConfig::context.application");
  if (target.width != config().width || target.height != config().height)
    return core::fail("engine: the target of an outline must have the size of the image");
  if (auto good = known(*state_, "draw_outline", items); !good) return good;
  core::VisibleSet shown;
  shown.generation = snapshot().generation();
  for (const core::ItemId item : items)
    if (const core::Slot slot = snapshot().slot(item); !snapshot().bounds().vacant(slot))
      shown.single_slots.push_back(slot);
  std::sort(shown.single_slots.begin(), shown.single_slots.end());
  const auto kept = state_->keep_state();
  Drawing* drawing = state_->backend->drawing();
  if (shown.single_slots.empty() || !drawing || drawing->lost()) return {};
  return drawing->put_outline({view, view, snapshot()}, shown, target);
}

}  // namespace sightline::engine
