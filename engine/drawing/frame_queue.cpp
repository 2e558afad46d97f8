#include "sightline/engine/drawing/internal/frame_queue.h"

#include <algorithm>

#include "sightline/core/internal/clock.h"

namespace sightline::engine {
namespace {

constexpr std::size_t kFramesInFlight = 2;
constexpr GLuint64 kLongestFenceWait = 10'000'000'000;  // ns; a lost context must not hang the application
constexpr std::size_t kMostDrawn = 8;

}  // namespace

FrameQueue::~FrameQueue() {
  for (const InFlight& frame : in_flight_) gl_->DeleteSync(frame.fence);
}

double FrameQueue::wait_for_room() {
  const double begin = core::now_seconds();
  while (in_flight_.size() >= kFramesInFlight) wait_for_oldest();
  return 1e3 * (core::now_seconds() - begin);
}

void FrameQueue::wait_for_oldest() {
  const InFlight oldest = in_flight_.front();
  in_flight_.pop_front();
  const auto wait = [&](GLuint64 ns) -> GLenum {
    return oldest.fence ? gl_->ClientWaitSync(oldest.fence, GL_SYNC_FLUSH_COMMANDS_BIT, ns) : GL_WAIT_FAILED;
  };
  const bool ready = wait(0) == GL_ALREADY_SIGNALED;
  // A driver without memory makes no fence, or cannot wait for it.
  if (!ready && wait(kLongestFenceWait) == GL_WAIT_FAILED) gl_->Finish();
  gl_->DeleteSync(oldest.fence);
  const double now = core::now_seconds();
  drawn_.push_back({oldest.frame, ready ? 0.0 : 1e3 * (now - std::max(last_drawn_, oldest.submitted))});
  if (drawn_.size() > kMostDrawn) drawn_.pop_front();  // nobody takes them
  last_drawn_ = now;
}

void FrameQueue::submit(std::uint64_t frame) {
  in_flight_.push_back({gl_->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0), frame, core::now_seconds()});
  gl_->Flush();
}

void FrameQueue::finish() {
  while (!in_flight_.empty()) wait_for_oldest();
}

std::optional<DrawnFrame> FrameQueue::take_drawn() {
  if (drawn_.empty()) return std::nullopt;
  const DrawnFrame oldest = drawn_.front();
  drawn_.pop_front();
  return oldest;
}

}  // namespace sightline::engine
