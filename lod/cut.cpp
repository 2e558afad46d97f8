#include "sightline/lod/internal/cut.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include "sightline/core/internal/scratch.h"

namespace sightline::lod {
namespace {

using core::dvec3;
using core::dvec4;

constexpr double kInwards = 1.0 - 1e-6;    // for the rounding of the few operations of each bound
constexpr double kGpuRounding = 4e-6;      // of a value that a GPU computes in float, relative to its terms
constexpr double kDoubleRounding = 2e-15;  // of a value computed here, relative to its terms: twice its nine roundings
constexpr std::size_t kGroupsOfJob = 64;   // some ten microseconds

/// Makes the first `count` values 0. Others may be there.
template <class T>
void reset(std::vector<std::atomic<T>>& values, std::size_t count) {
  if (values.size() < count) values = std::vector<std::atomic<T>>(count);
  for (std::size_t i = 0; i < count; ++i) values[i].store(T{}, std::memory_order_relaxed);
}

dvec4 form_of(const core::Plane& plane) {
  return {plane.normal, plane.offset};
}

/// A linear form of world coordinates as one of mesh coordinates.
dvec4 in_mesh(const dvec4& form, const core::Affine& world_from_mesh) {
  const dvec3 normal(form);
  return {normal * world_from_mesh.linear, glm::dot(normal, world_from_mesh.origin) + form.w};
}

core::Affine sizes_of(const core::Affine& a) {
  return {{glm::abs(a.linear[0]), glm::abs(a.linear[1]), glm::abs(a.linear[2])}, glm::abs(a.origin)};
}

/// Least value in a box, and in a box around that none that is larger: each term rounds in the same direction.
double least(const dvec4& form, const core::Aabb& box) {
  double sum = form.w;
  for (int i = 0; i < 3; ++i) sum += form[i] * double(form[i] > 0.0 ? box.min[i] : box.max[i]);
  return sum;
}
double most(const dvec4& form, const core::Aabb& box) {
  return -least(-form, box);
}

/// Largest sum of the sizes of a form's terms in a box.
double size_in(const dvec4& form, const core::Aabb& box) {
  const dvec3 farthest = glm::max(glm::abs(dvec3(box.min)), glm::abs(dvec3(box.max)));
  return glm::dot(glm::abs(dvec3(form)), farthest) + std::abs(form.w);
}
/// What a GPU's value in a box is off by.
double gpu_rounding(const dvec4& form, const core::Aabb& box) {
  return kGpuRounding * size_in(form, box);
}

/// Largest singular value of the matrix of two rows.
double norm(const dvec3& a, const dvec3& b) {
  const double aa = glm::dot(a, a), bb = glm::dot(b, b), ab = glm::dot(a, b);
  return std::sqrt(0.5 * (aa + bb) + std::sqrt(0.25 * (aa - bb) * (aa - bb) + ab * ab));
}

/// Least w of points beyond the near plane, where the plane is parallel to the image; else 0.
double least_visible_w(const core::View& view) {
  const core::Plane near = core::frustum_planes(view.clip_from_eye(), view.clip_depth())[core::kNear];
  if (near.normal.x != 0.0 || near.normal.y != 0.0 || near.normal.z == 0.0) return 0.0;
  const core::dmat4& clip = view.clip_from_eye();
  const double z = -near.offset / near.normal.z;
  return clip[0][3] == 0.0 && clip[1][3] == 0.0 ? std::max(0.0, clip[2][3] * z + clip[3][3]) : 0.0;
}

}  // namespace

ImageError::ImageError(const core::View& view, int width, int height, double pixels)
    : rows_(glm::transpose(view.clip_from_world())),
      planes_(core::frustum_planes(view.clip_from_world(), view.clip_depth())),
      sections_(view.sections),
      half_width_(0.5 * width),
      half_height_(0.5 * height),
      pixels_(pixels),
      nearest_(least_visible_w(view)) {}

MeshError::MeshError(const ImageError& image, const core::Affine& world_from_mesh)
    : pixels_(image.pixels_), nearest_(image.nearest_) {
  const dvec4 x = in_mesh(image.rows_[0], world_from_mesh), y = in_mesh(image.rows_[1], world_from_mesh);
  w_ = in_mesh(image.rows_[3], world_from_mesh);
  w_sizes_ = in_mesh(glm::abs(image.rows_[3]), sizes_of(world_from_mesh));
  double largest_move = 0.0;
  for (const double right : {-1.0, 1.0})
    for (const double up : {-1.0, 1.0})
      largest_move = std::max(largest_move,
                              norm(image.half_width_ * dvec3(x - right * w_), image.half_height_ * dvec3(y - up * w_)));
  const bool any = image.pixels_ > 0.0;
  error_per_w_ = any ? kInwards * image.pixels_ / (largest_move + image.pixels_ * glm::length(dvec3(w_))) : 0.0;
  for (std::size_t i = 0; i < planes_.size(); ++i) planes_[i] = in_mesh(form_of(image.planes_[i]), world_from_mesh);
  for (const core::Plane& section : image.sections_) sections_.push_back(in_mesh(form_of(section), world_from_mesh));
}

float MeshError::allowed(const core::Aabb& box) const {
  if (!(error_per_w_ > 0.0)) return -1.0f;
  for (const dvec4& section : sections_) {
    const double rounding = gpu_rounding(section, box);
    if (least(section, box) <= rounding && most(section, box) >= -rounding) return -1.0f;
  }
  // Far from the origin the terms of w are much larger than their sum.
  const double w = std::max(least(w_, box) - kDoubleRounding * size_in(w_sizes_, box), nearest_);
  if (!(w > 0.0)) return -1.0f;
  return core::round_down(error_per_w_ * w);
}

bool MeshError::outside(const core::Aabb& box) const {
  return std::ranges::any_of(planes_, [&](const dvec4& plane) { return most(plane, box) < -gpu_rounding(plane, box); });
}

core::AabbD placed_box(const core::Aabb& box, const core::Affine& world_from_mesh, const dvec3& origin) {
  const core::dmat3 &linear = world_from_mesh.linear, sizes = sizes_of(world_from_mesh).linear;
  const dvec3 low(box.min), high(box.max), shift = world_from_mesh.origin - origin;
  const dvec3 centre = linear * (0.5 * (low + high)) + shift;
  const dvec3 rounding = kGpuRounding * (sizes * glm::max(glm::abs(low), glm::abs(high)) + glm::abs(shift));
  const dvec3 half = sizes * (0.5 * (high - low)) + rounding;
  return {centre - half, centre + half};
}

/// In rounds: each considers what the groups that the one before has expanded were made from.
std::vector<std::uint32_t>& CutChooser::choose(const MeshLevels& levels, const MeshError& error,
                                               core::ThreadPool* threads) {
  error_ = 0.0;
  const std::size_t words = (levels.clusters.size() + 63) / 64;
  reset(state_, levels.groups.size());
  reset(shown_, words);
  open_.clear();
  if (found_.empty()) found_.resize(1);
  consider(levels, error, std::span(levels.members).subspan(levels.first_root), found_[0]);
  take(found_[0]);
  while (!open_.empty()) {
    const auto jobs = std::uint32_t((open_.size() + kGroupsOfJob - 1) / kGroupsOfJob);
    if (found_.size() < jobs) found_.resize(jobs);
    core::ThreadPool::run_on(threads, jobs, [&](std::uint32_t job) {
      const std::size_t first = job * kGroupsOfJob;
      for (const std::uint32_t number : std::span(open_).subspan(first, std::min(kGroupsOfJob, open_.size() - first))) {
        const ClusterGroup& group = levels.groups[number];
        consider(levels, error, std::span(levels.members).subspan(group.first_member, group.member_count), found_[job]);
      }
    });
    open_.clear();
    for (Found& found : std::span(found_).first(jobs)) take(found);
  }
  list_drawn(words);
  return drawn_;
}

void CutChooser::take(Found& found) {
  open_.insert(open_.end(), found.expanded.begin(), found.expanded.end());
  error_ = std::max(error_, found.error);
  found.expanded.clear();
  found.error = 0.0;
}

void CutChooser::list_drawn(std::size_t words) {
  drawn_.clear();
  for (std::size_t word = 0; word < words; ++word)
    for (std::uint64_t left = shown_[word]; left != 0; left &= left - 1)
      drawn_.push_back(std::uint32_t(64 * word) + std::uint32_t(std::countr_zero(left)));
}

std::size_t CutChooser::memory_bytes() const {
  std::size_t bytes = core::bytes_of(state_, shown_, found_, open_, drawn_);
  for (const Found& found : found_) bytes += core::bytes_of(found.expanded);
  return bytes;
}

void CutChooser::merge(const MeshLevels& levels, std::span<const std::uint32_t> clusters,
                       std::vector<IndexRange>& ranges) {
  ranges.clear();
  for (const std::uint32_t number : clusters) {
    const Cluster& cluster = levels.clusters[number];
    if (!ranges.empty() && ranges.back().first + ranges.back().count == cluster.first_index)
      ranges.back().count += cluster.index_count;
    else
      ranges.push_back({cluster.first_index, cluster.index_count});
  }
}

/// Draws these clusters, and in place of those that are too coarse, later, the clusters that they were made from.
void CutChooser::consider(const MeshLevels& levels, const MeshError& error, std::span<const std::uint32_t> clusters,
                          Found& found) {
  for (const std::uint32_t number : clusters) {
    const Cluster& cluster = levels.clusters[number];
    if (cluster.made_by != core::kNone && decide(levels, error, cluster.made_by, found) == State::kExpanded) continue;
    if (!error.outside(cluster.box))
      shown_[number / 64].fetch_or(std::uint64_t(1) << number % 64, std::memory_order_relaxed);
  }
}

/// Several threads may decide about a group at once, alike. One of them then tells of it.
CutChooser::State CutChooser::decide(const MeshLevels& levels, const MeshError& error, std::uint32_t number,
                                     Found& found) {
  std::atomic<State>& known = state_[number];
  State state = known.load(std::memory_order_relaxed);
  if (state != State::kUnknown) return state;
  const ClusterGroup& group = levels.groups[number];
  const float allowed = error.allowed(group.box);
  const State decided = group.error <= allowed ? State::kSimplified : State::kExpanded;
  if (!known.compare_exchange_strong(state, decided, std::memory_order_relaxed)) return decided;
  // The pixels K e / (w - |w| e) of an error grow faster than it, so a share of what is allowed shows as at most that
  // share of the pixels.
  if (decided == State::kSimplified && group.error > 0.0f)
    found.error = std::max(found.error, error.pixels() * double(group.error / allowed));
  if (decided == State::kExpanded && !error.outside(group.box)) found.expanded.push_back(number);
  return decided;
}

}  // namespace sightline::lod
