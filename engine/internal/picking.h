// The tracer of an order of the items, which picks use. Internal to engine.
#pragma once

#include <future>
#include <memory>
#include <span>
#include <stop_token>

#include "sightline/core/error.h"
#include "sightline/engine/internal/rebuild.h"

namespace sightline::engine {

#if SIGHTLINE_HAS_RAYTRACE

/// Makes the tracer unless there is one. Fails soon after a stop was requested.
core::Expected<void> make_tracer(SceneVersion& version, const std::stop_token& stop = {});
/// Updates the tracer, if there is one, after an edit of the snapshot. Where that fails it is dropped.
void follow_tracer(SceneVersion& version, std::span<const core::Slot> touched);
std::size_t tracer_bytes(const SceneVersion& version);

/// The tracer of an order, made on another thread. The order's snapshot must not be edited meanwhile.
class BackgroundTracer {
 public:
  bool for_motion = true;  // moving images may use it; false for tests of those that are drawn

  BackgroundTracer() = default;
  /// Stops it, which takes some milliseconds.
  ~BackgroundTracer() { stop_.request_stop(); }
  BackgroundTracer(const BackgroundTracer&) = delete;
  BackgroundTracer& operator=(const BackgroundTracer&) = delete;

  /// Unless the order has one or it is being made. Does nothing where the system gives no thread.
  void begin(const SceneVersion& version);
  /// Whether finish() would not wait.
  bool ready() const;
  /// Waits for it, and gives it to that order. Where it could not be made, make_tracer() says why.
  void finish(SceneVersion& version);
  /// Gives it to that order if it is made, and stops it if not: the snapshot will be edited. After that follow()
  /// begins it anew. It is stopped a few times and waited for then, so that edits cannot keep it from ending.
  void interrupt(SceneVersion& version);
  void follow(const SceneVersion& version);

 private:
  static constexpr int kMostStops = 8;

  bool failed_ = false;  // and nothing has changed since

  std::stop_source stop_;
  int stops_ = 0;
  bool stopped_ = false;
  std::future<std::shared_ptr<raytrace::Tracer>> made_;  // destroying it waits
};

#else

inline core::Expected<void> make_tracer(SceneVersion&, const std::stop_token& = {}) {
  return {};
}
inline void follow_tracer(SceneVersion&, std::span<const core::Slot>) {}
inline std::size_t tracer_bytes(const SceneVersion&) {
  return 0;
}
class BackgroundTracer {
 public:
  bool for_motion = false;
  void finish(SceneVersion&) {}
  void interrupt(SceneVersion&) {}
  void follow(const SceneVersion&) {}
};

#endif

}  // namespace sightline::engine
