// The tracer of an order of the items, which picks use. Internal to engine.
#pragma once

#include <span>

#include "sightline/core/error.h"
#include "sightline/engine/internal/rebuild.h"

namespace sightline::engine {

#if SIGHTLINE_HAS_RAYTRACE

/// Makes the tracer unless there is one.
core::Expected<void> make_tracer(Order& order);
/// Updates the tracer, if there is one, after an edit of the snapshot. Where that fails it is dropped.
void follow_tracer(Order& order, std::span<const core::Slot> touched);
std::size_t tracer_bytes(const Order& order);

#else

inline core::Expected<void> make_tracer(Order&) {
  return {};
}
inline void follow_tracer(Order&, std::span<const core::Slot>) {}
inline std::size_t tracer_bytes(const Order&) {
  return 0;
}

#endif

}  // namespace sightline::engine
