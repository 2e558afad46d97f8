// The tracer of an order of the items, which picks use. Internal to engine.
#pragma once

#include <future>
#include <memory>
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

/// The tracer of an order, made on another thread. The order's snapshot must not be edited meanwhile.
class BackgroundTracer {
 public:
  /// Unless the order has one or it is being made. Does nothing where the system gives no thread.
  void begin(const Order& order);
  /// Waits for it, and gives it to that order. Where it could not be made, make_tracer() says why.
  void finish(Order& order);

 private:
  std::future<std::shared_ptr<raytrace::Tracer>> made_;  // destroying it waits
};

#else

inline core::Expected<void> make_tracer(Order&) {
  return {};
}
inline void follow_tracer(Order&, std::span<const core::Slot>) {}
inline std::size_t tracer_bytes(const Order&) {
  return 0;
}
class BackgroundTracer {
 public:
  void finish(Order&) {}
};

#endif

}  // namespace sightline::engine
