// The leaves of a view that an image lacks. Internal to engine.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/paged_scene.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::engine {

/// Leaves of the view are open as long as they are neither drawn nor known to be hidden.
class OpenLeaves {
 public:
  /// The scene must outlive it.
  OpenLeaves(const core::PagedScene& scene, const culling::ImageSamples& samples);

  /// Opens all leaves that may cover a sample of the view, and measures their pages.
  void begin(const core::View& view);
  /// Leaves that may cover a sample of any view.
  void find(const core::View& view, core::VisibleSet& leaves);

  std::int64_t in_view() const { return in_view_count_; }
  std::int64_t count() const;
  culling::SlotBits bits() const { return bits_; }  ///< a bit for each leaf that is open
  bool is_open(std::uint32_t leaf) const { return culling::contains(bits_, leaf); }
  std::uint32_t of_page(std::uint32_t page) const { return count_[page]; }
  /// Pages that have some, the largest first.
  std::span<const std::uint32_t> list_pages();
  float area(std::uint32_t page) const { return area_[page]; }  ///< pixels that its leaves come to

  /// Closes all leaves of a page, but for these.
  void close(std::uint32_t page, const core::VisibleSet& but = {});
  /// Closes leaves of a page that fail the test.
  void close_hidden(std::uint32_t page, const culling::OcclusionTest& test);

  const core::Aabb& page_box(std::uint32_t page) const { return page_boxes_[page]; }  ///< from the leaves' origin
  const culling::ImageSamples& samples() const { return samples_; }

 private:
  void measure_pages(const core::View& view);

  const core::PagedScene& scene_;
  const culling::ImageSamples samples_;
  culling::CpuCuller culler_;
  std::vector<core::Aabb> page_boxes_;
  std::vector<std::uint64_t> line_leaves_;
  core::VisibleSet in_volume_, found_;
  std::int64_t in_view_count_ = 0;
  std::vector<std::uint64_t> bits_;
  std::vector<std::uint32_t> count_;    // by page
  std::vector<float> area_;             // by page
  std::vector<std::uint32_t> by_area_;  // pages with open leaves, the largest first, and some that have none any more
  culling::SetParts parts_;
  std::vector<culling::ContributionTest::SlotArea> areas_;
};

}  // namespace sightline::engine
