// Frames that are submitted and not yet drawn. Internal to engine.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "sightline/engine/internal/backend.h"
#include "sightline/gl/functions.h"

namespace sightline::engine {

/// Lets the CPU be at most two frames ahead of the GPU, and tells how long the GPU takes for each. The context must be
/// current in all calls, and when the queue is destroyed.
class FrameQueue {
 public:
  explicit FrameQueue(const gl::Functions& gl) : gl_(&gl) {}
  FrameQueue(const FrameQueue&) = delete;
  FrameQueue& operator=(const FrameQueue&) = delete;
  ~FrameQueue();

  /// Waits until at most one earlier frame is still being drawn. Returns how long it has waited, milliseconds.
  double wait_for_room();
  /// Ends a frame, all of whose commands are issued.
  void submit(std::uint64_t frame);
  /// Waits until all frames are drawn.
  void finish();

  /// The oldest drawn frame that was not yet taken.
  std::optional<DrawnFrame> take_drawn();

 private:
  struct InFlight {
    GLsync fence;
    std::uint64_t frame;
    double submitted;  // seconds on the steady clock
  };
  void wait_for_oldest();

  const gl::Functions* gl_;
  std::deque<InFlight> in_flight_;
  std::deque<DrawnFrame> drawn_;
  double last_drawn_ = 0.0;  // when the newest of drawn_ was known to be drawn, seconds on the steady clock
};

}  // namespace sightline::engine
