// What functions of engines share: the call itself, and translations of their structs.
#pragma once

#include "sightline/bindings/c/internal/objects.h"
#include "sightline/bindings/c/internal/values.h"
#include "sightline/gl/external_target.h"

namespace sightline::capi {

/// Runs `run` with the engine.
template <class Run>
sl_status with_engine(const char* function, sl_engine handle, Access access, const Run& run) {
  return call(function, [&] { run(EngineUse(handle, access)); });
}

/// Refuses what is no size of an image.
void check_size(std::int32_t width, std::int32_t height);
/// Refuses a call that needs GL, where this library has none.
void check_drawing(bool needed);

/// All but the context and the controller, which is that of `controller` unless the struct names one.
engine::EngineConfig config_of(const sl_engine_config& from, const culling::ControllerConfig& controller);
sl_frame_report report_of(const engine::FrameReport& from);
gl::ExternalTarget target_of(const sl_external_target* from);
std::span<const core::ItemId> items_of(const sl_item* items, std::size_t count);

}  // namespace sightline::capi
