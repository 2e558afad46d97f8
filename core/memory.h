// Scratch memory: buffers that functions such as CpuCuller::cull() keep from call to call, so that frames allocate
// nothing. Each thread has its own, as large as its largest call needed, until it ends.
#pragma once

#include <cstddef>

#include "sightline/core/api.h"

namespace sightline::core {

/// Bytes of the scratch buffers of all threads of the process. A buffer that is in use counts with the size that was
/// known before. Any thread may call it.
SIGHTLINE_API std::size_t scratch_bytes();

/// Frees the scratch buffers of all threads, except for those in use. Later calls allocate them again. For applications
/// that rest, or that close a large model and keep their threads. Any thread may call it.
SIGHTLINE_API void free_scratch();

}  // namespace sightline::core
