#include "sightline/core/detail/chunk_grid.h"

#include <algorithm>

#include "sightline/core/aabb.h"

namespace sightline::core {
namespace {

constexpr double kSize = 16.0;
constexpr std::size_t kMaxChunks = 4096;  // their camera-relative origins are uploaded every frame

dvec3 coarse(const dvec3& place, double size) {
  const double step = size / 1024.0;
  return glm::round(place / step) * step;
}

/// Cuts the points into runs that fit into chunks of `size`. Returns the runs' origins.
std::vector<dvec3> cut_into_runs(std::span<const dvec3> points, double size, std::vector<std::uint32_t>& chunk_of) {
  const double limit = size * (1.0 - 1.0 / 512.0);
  std::vector<dvec3> origins;
  AabbD run;
  const auto close = [&] {
    if (!run.empty()) origins.push_back(coarse(run.centre(), size));
    run = {};
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    AabbD grown = run;
    grown.grow(points[i]);
    const dvec3 extent = grown.size();
    if (!run.empty() && std::max({extent.x, extent.y, extent.z}) > limit) {
      close();
      grown = {points[i], points[i]};
    }
    run = grown;
    chunk_of[i] = std::uint32_t(origins.size());
  }
  close();
  return origins;
}

}  // namespace

std::vector<std::uint32_t> ChunkGrid::cut(std::span<const dvec3> points) {
  std::vector<std::uint32_t> chunk_of(points.size());
  size_ = kSize;
  while ((origins_ = cut_into_runs(points, size_, chunk_of)).size() > kMaxChunks) size_ *= 2.0;
  index();
  return chunk_of;
}

ChunkGrid ChunkGrid::restored(double size, std::vector<dvec3> origins) {
  ChunkGrid grid;
  grid.size_ = size;
  grid.origins_ = std::move(origins);
  grid.index();
  return grid;
}

void ChunkGrid::index() {
  cells_.clear();
  for (std::uint32_t c = 0; c < origins_.size(); ++c) cells_.emplace(cell_of(origins_[c]), c);
}

bool ChunkGrid::reaches(std::uint32_t chunk, const dvec3& place) const {
  return chunk < origins_.size() && glm::distance(origins_[chunk], place) <= size_;
}

/// Cells are as wide as chunks. All cells beyond the millionth from the origin are clamped to it.
std::uint64_t ChunkGrid::cell_of(const dvec3& place, const dvec3& step) const {
  constexpr double kLast = 1 << 20;
  const dvec3 cell = glm::clamp(glm::floor(place / size_) + step, dvec3(-kLast), dvec3(kLast - 1.0)) + kLast;
  return std::uint64_t(cell.x) << 42 | std::uint64_t(cell.y) << 21 | std::uint64_t(cell.z);
}

std::uint32_t ChunkGrid::find(const dvec3& place, std::uint32_t own, std::uint32_t likely, const dvec3& fresh) {
  if (reaches(own, place)) return own;
  if (reaches(likely, place)) return likely;
  constexpr int kSteps[3] = {0, -1, 1};  // the cell itself first
  for (int i = 0; i < 27; ++i) {
    const auto found = cells_.find(cell_of(place, dvec3(kSteps[i % 3], kSteps[i / 3 % 3], kSteps[i / 9])));
    if (found != cells_.end() && reaches(found->second, place)) return found->second;
  }
  if (origins_.size() >= 2 * kMaxChunks) return likely != kNone ? likely : own != kNone ? own : 0;
  const std::uint32_t chunk = std::uint32_t(origins_.size());
  origins_.push_back(coarse(fresh, size_));
  cells_.emplace(cell_of(origins_.back()), chunk);
  return chunk;
}

}  // namespace sightline::core
