// Threads of the operating system. Internal.
#pragma once

#include "sightline/core/api.h"

namespace sightline::core::platform {

/// Has `run(object)` called when this thread ends, later ones first; perhaps not when the process does. What a thread
/// keeps and must clean up is an object of its own on the heap: g++ for Windows frees a thread's variables before it
/// calls their destructors.
SIGHTLINE_API void at_end_of_thread(void (*run)(void* object), void* object);

}  // namespace sightline::core::platform
