// Pairs of box and view for the JavaScript package, and its answers against exact arithmetic.
#pragma once

#include <cstdint>
#include <filesystem>

namespace sightline::tests {

/// Writes blocks of 1,024 boxes and 8 views, whose families are those of culling/conservative_test: `pairs` at least,
/// from the families' generators of `batch` on. False where the file cannot be written.
bool write_pairs(const std::filesystem::path& file, std::uint64_t pairs, std::uint64_t batch);

/// Prints what is kept, lost and extra. True where each view has an answer, and no box is lost.
bool check_pairs(const std::filesystem::path& pairs, const std::filesystem::path& answers);

}  // namespace sightline::tests
