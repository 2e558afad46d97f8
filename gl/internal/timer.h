// Measures GPU time without waiting for the GPU.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "sightline/gl/functions.h"

namespace sightline::gl {

/// Measures spans of GPU work with pairs of GL_TIMESTAMP queries in a ring; results arrive some frames later.
/// Move-only. On software rasterisers (Capabilities::software) the figures mean nothing: use a wall clock there.
class GpuTimer {
 public:
  static constexpr std::size_t kSlots = 8;
  static constexpr double kNoTime = -1.0;  ///< of a span whose clock stood still or was set back

  explicit GpuTimer(const Functions& gl);
  GpuTimer(GpuTimer&& other) noexcept;
  GpuTimer& operator=(GpuTimer&& other) noexcept;
  ~GpuTimer();

  /// Starts a span. False when all slots are still unread, and always where the driver has made no queries or under
  /// Workaround::kNoTimer: then the span is not measured, but end() must be called.
  bool begin();
  void end();

  /// Takes the oldest finished span, in milliseconds and in order of begin(), or kNoTime; nothing while the GPU has not
  /// finished it.
  std::optional<double> poll();

  std::size_t pending() const { return count_; }  ///< spans ended and not yet polled

 private:
  const Functions* gl_ = nullptr;
  std::array<GLuint, 2 * kSlots> queries_{};  // begin and end of each slot; all 0 when there are none
  std::size_t first_ = 0;                     // oldest slot not yet read
  std::size_t count_ = 0;
  bool open_ = false;
};

}  // namespace sightline::gl
