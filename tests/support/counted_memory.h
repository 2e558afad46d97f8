// Counts what operator new gives out, in programs that counted_memory.cpp is part of: it replaces the global operators.
#pragma once

#include <atomic>
#include <cstddef>

namespace sightline::tests {

extern std::atomic<std::size_t> live_bytes, peak_bytes, allocations;

}  // namespace sightline::tests
