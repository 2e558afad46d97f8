// What every reader must survive: damaged and malicious bytes. For test programs with counted_memory.cpp, which sees
// their memory.
#pragma once

#include <cstring>
#include <memory>
#include <span>
#include <string>

#include <gtest/gtest.h>

#include "sightline/importers/import.h"
#include "sightline/tests/support/counted_memory.h"

namespace sightline::tests {

/// Reads from a heap buffer of exactly the content's size, so that a sanitizer sees every step beyond it. Expects that
/// the peak of memory stays below factor * size + constant, that a failed import names the file "hostile…" and leaves
/// the scene as it was, and that a successful one can be committed. `read(bytes, scene, parent)` is the reader. True
/// when it succeeded; `*used` becomes the largest memory per byte of content.
template <class Read>
bool survives(std::span<const std::byte> content, Read&& read, std::size_t factor, std::size_t constant,
              double* used = nullptr) {
  const std::unique_ptr<std::byte[]> exact(new std::byte[content.size()]);
  if (!content.empty()) std::memcpy(exact.get(), content.data(), content.size());
  const std::size_t before = live_bytes;
  peak_bytes = before;
  core::Scene scene;
  const core::NodeId parent = scene.add_node(scene.root(), "kept");
  const auto report = read(std::span<const std::byte>(exact.get(), content.size()), scene, parent);
  const std::size_t peak = peak_bytes - before;
  EXPECT_LE(peak, factor * content.size() + constant);
  if (used) *used = std::max(*used, double(peak) / double(content.size()));
  if (report) {
    EXPECT_LE(report->warnings.size(), importers::kMaxWarnings + 1);
    const auto committed = scene.commit();
    EXPECT_TRUE(committed.has_value()) << (committed ? "" : committed.error().message);
    return true;
  }
  EXPECT_NE(report.error().message.find("hostile"), std::string::npos) << report.error().message;
  EXPECT_EQ(scene.node_count(), 2u);
  EXPECT_EQ(scene.item_slots(), 0u);
  EXPECT_EQ(scene.mesh_slots(), 0u);
  EXPECT_EQ(scene.material_slots(), 0u);
  return false;
}

}  // namespace sightline::tests
