// Threads of the operating system. Internal.
#pragma once

#include <atomic>
#include <cstdint>

#include "sightline/core/api.h"

namespace sightline::core::platform {

/// Has `run(object)` called when this thread ends, later ones first; perhaps not when the process does. What a thread
/// keeps and must clean up is an object of its own on the heap: g++ for Windows frees a thread's variables before it
/// calls their destructors.
SIGHTLINE_API void at_end_of_thread(void (*run)(void* object), void* object);

/// Waits until another thread wakes those that wait for `value`, unless it is no longer `seen`; may return before. As
/// std::atomic's wait(), whose wake-ups may get lost with g++ 12 for Windows.
SIGHTLINE_API void wait_while(const std::atomic<std::uint32_t>& value, std::uint32_t seen);
/// Wakes all threads that wait for `value`, which has been changed.
SIGHTLINE_API void wake_all(std::atomic<std::uint32_t>& value);

}  // namespace sightline::core::platform
