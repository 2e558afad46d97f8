// Sequences of calls of the C API from bytes, for tests with random numbers and for a fuzzer: in any order, with
// handles that are null, stale, of another kind or made up, on the wrong thread, and with numbers of every sort.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace sightline::tests {

/// Makes calls until the bytes are used up, and destroys all that is left. Returns what was not as the header promises,
/// empty if nothing. `draws`: engines draw, offscreen.
std::string make_random_calls(const std::uint8_t* data, std::size_t size, bool draws = false);

}  // namespace sightline::tests
