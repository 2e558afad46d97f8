// What functions of engines share: the call itself, and translations of their structs.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <vector>

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

/// Settings in C++: all but the application's context.
engine::EngineConfig config_of(const sl_engine_config& from);
engine::PagedConfig config_of(const sl_paged_config& from);
sl_frame_report report_of(const engine::FrameReport& from);
gl::ExternalTarget target_of(const sl_external_target* from);
std::span<const core::ItemId> items_of(const sl_item* items, std::size_t count);

template <class T, class Pixels>
void write_image(const Pixels& from, T* to, std::size_t capacity) {
  require(to != nullptr, "room for the image, found null");
  if (capacity < from.size())
    refuse(SL_ERROR_ARGUMENT,
           "the image has " + std::to_string(from.size()) + " values, found room for " + std::to_string(capacity));
  std::copy(from.begin(), from.end(), to);
}

/// Appends lines to those that were not yet told, and tells all. They are told once the text has room for all of them.
void tell_lines(const std::vector<std::string>& lines, std::string& not_told, sl_text* text);

}  // namespace sightline::capi
