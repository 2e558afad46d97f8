// Imports of damaged and malicious bytes in this process, where a sanitizer sees every step beyond their end and
// counted_memory.cpp, which must be part of the program, their memory.
#pragma once

#include <cstring>
#include <memory>

#include <gtest/gtest.h>

#include "sightline/tests/hostile/check.h"
#include "sightline/tests/support/counted_memory.h"

namespace sightline::tests {

/// Imports a case from a heap buffer of exactly the model's size. Expects what hostile::check() requires, and that the
/// peak of memory stays below the target's bound. The constant part of the bound is for small files: large ones must do
/// with the factor. True when the import succeeded. `where`: the model's path, beside which side files lie.
inline bool survives(const hostile::Target& target, const hostile::Case& made, bool lenient,
                     const std::filesystem::path& where) {
  const std::string& content = made.files[0].content;
  const std::unique_ptr<std::byte[]> exact(new std::byte[content.size()]);
  if (!content.empty()) std::memcpy(exact.get(), content.data(), content.size());
  std::size_t total = 0, peak = 0;
  for (const hostile::File& file : made.files) total += file.content.size();
  const auto import = [&](core::Scene& scene, core::NodeId parent, const importers::ImportOptions& options) {
    const std::size_t before = live_bytes;
    peak_bytes = before;
    auto report = target.read({exact.get(), content.size()}, where, scene, parent, options);
    peak = peak_bytes - before;
    return report;
  };
  const hostile::Finding found = hostile::check(target, made, lenient, import);
  EXPECT_EQ(found.broken, "") << (lenient ? "lenient" : "strict");
  EXPECT_FALSE(found.leaked) << "read outside the model's directory";
  if (target.memory_factor > 0) {
    EXPECT_LE(peak, target.memory_factor * total + target.memory_constant);
  }
  return found.imported;
}

/// Imports a case strict and lenient, and in the other ways that the target has. What is read strictly is read
/// leniently, too. Returns how many of both succeeded.
inline int survives_both(const hostile::Target& target, const hostile::Case& made, const std::filesystem::path& where) {
  const bool strict = survives(target, made, false, where), lenient = survives(target, made, true, where);
  EXPECT_LE(strict, lenient) << "refused when lenient alone";
  if (target.use) target.use(std::as_bytes(std::span(made.files[0].content)));
  return int(strict) + int(lenient);
}

}  // namespace sightline::tests
