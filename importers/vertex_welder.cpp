#include "sightline/importers/internal/vertex_welder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "sightline/core/internal/prefetch.h"

namespace sightline::importers {
namespace {

constexpr std::size_t kSmallestTable = 64;
constexpr std::size_t kMostProbes = 256;  // far beyond the longest run of a table half full

/// Multiplies and folds, since the low bits of doubles that were floats are all zero.
std::uint64_t hash(const core::dvec3& p) {
  std::uint64_t h = 0;
  for (int i = 0; i < 3; ++i) {
    h = (h ^ std::bit_cast<std::uint64_t>(p[i])) * 0x9e3779b97f4a7c15u;
    h ^= h >> 32;
  }
  return h * 0x9e3779b97f4a7c15u;
}

bool same_bits(const core::dvec3& a, const core::dvec3& b) {
  using Bits = std::array<std::uint64_t, 3>;
  return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);  // a NaN equals itself
}

}  // namespace

VertexWelder::VertexWelder(std::size_t vertices) {
  positions_.reserve(vertices);
  grow(vertices);
}

void VertexWelder::grow(std::size_t vertices) {
  const std::size_t size = std::bit_ceil(std::max(kSmallestTable, 2 * vertices));
  table_ = {};
  table_.assign(size, core::kNone);
  shift_ = 64 - std::countr_zero(size);
  for (std::size_t v = 0; v < positions_.size(); ++v) {
    std::size_t place = hash(positions_[v]) >> shift_;
    for (std::size_t probe = 0; probe < kMostProbes && table_[place] != core::kNone; ++probe)
      place = (place + 1) & (size - 1);
    if (table_[place] == core::kNone) table_[place] = std::uint32_t(v);
  }
}

std::uint32_t VertexWelder::find_or_add(const core::dvec3& position, std::size_t place) {
  const auto added = std::uint32_t(positions_.size());
  for (std::size_t probe = 0; probe < kMostProbes; ++probe) {
    const std::uint32_t number = table_[place];
    if (number == core::kNone) {
      table_[place] = added;
      break;
    }
    if (same_bits(positions_[number], position)) return number;
    place = (place + 1) & (table_.size() - 1);
  }
  positions_.push_back(position);
  return added;
}

void VertexWelder::add(std::span<const core::dvec3> corners, std::vector<std::uint32_t>& numbers) {
  std::array<core::dvec3, kBlock> block;
  std::array<std::size_t, kBlock> places;
  for (; !corners.empty(); corners = corners.subspan(std::min(kBlock, corners.size()))) {
    const std::size_t count = std::min(kBlock, corners.size());
    if (2 * (positions_.size() + count) > table_.size()) grow(2 * (positions_.size() + count));
    for (std::size_t i = 0; i < count; ++i) {
      block[i] = corners[i] + 0.0;  // -0 becomes 0
      places[i] = hash(block[i]) >> shift_;
      core::prefetch(table_[places[i]]);
    }
    for (std::size_t i = 0; i < count; ++i)
      if (const std::uint32_t number = table_[places[i]]; number != core::kNone) core::prefetch(positions_[number]);
    for (std::size_t i = 0; i < count; ++i) numbers.push_back(find_or_add(block[i], places[i]));
  }
}

std::vector<core::dvec3> VertexWelder::take_positions() {
  std::vector<core::dvec3> taken = std::move(positions_);
  *this = VertexWelder();
  return taken;
}

}  // namespace sightline::importers
