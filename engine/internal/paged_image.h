// The image of a paged engine, and what of it is drawn. Internal to engine.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sightline/core/paged_scene.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/engine/internal/page_store.h"
#include "sightline/engine/internal/placeholders.h"
#include "sightline/engine/paged_engine.h"
#include "sightline/lod/internal/cut.h"
#include "sightline/render/internal/depth_shading_pass.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::engine {

/// Pages that a frame can draw.
struct PagesInMemory {
  PageStore& full;
  PageStore* coarse;  ///< of the coarsest levels; null: there are none
  std::uint64_t frame;
};

/// Draws what comes into memory onto a canvas, where it stays when its page goes. Leaves of the view are open as long
/// as they are neither drawn nor known to be hidden. The image that is shown is a copy of the canvas, with coarse pages
/// and splats in place of open leaves.
class PagedImage {
 public:
  /// `context` must be current in all calls. All three arguments must outlive the image.
  static core::Expected<std::unique_ptr<PagedImage>> create(const gl::Context& context, const core::PagedScene& scene,
                                                            const PagedConfig& config);
  /// Takes the memory that images need whatever they show.
  core::Expected<void> warm_up();

  /// Begins the image of a view, with all of its leaves open.
  core::Expected<void> begin(const core::View& view);
  void forget() { view_.reset(); }
  const std::optional<core::View>& view() const { return view_; }  ///< of the image; none before begin()

  /// Draws open leaves of pages in memory. Of a coarse page it draws only what that shows as well as the page in full.
  core::Expected<void> draw_resident(const PagesInMemory& pages);
  /// Closes leaves of a page that what is drawn hides.
  void close_hidden(std::uint32_t page);
  /// Makes the image that is shown. `pending`: leaves that it lacks; 0: it is complete.
  core::Expected<void> show(const PagesInMemory& pages, std::int64_t pending);
  const render::RenderTarget& target() const { return target_; }

  std::int64_t leaves() const { return leaves_; }
  std::int64_t open_leaves() const;
  bool is_open(std::uint32_t page) const { return open_count_[page] > 0; }
  /// Pages that were open when they were listed, the largest first.
  std::span<const std::uint32_t> list_open_pages();
  float area(std::uint32_t page) const { return area_[page]; }  ///< pixels that its leaves come to
  /// Whether a coarse page has drawn what it shows as well as the page in full: what is open needs that.
  bool coarse_drawn(std::uint32_t page) const { return coarse_drawn_[page]; }
  std::int64_t items_drawn() const { return items_drawn_; }
  std::int64_t coarse_items() const { return coarse_items_; }  ///< in the image that is shown, in place of open leaves
  std::int64_t splats() const { return splats_; }              ///< likewise

  /// Leaves that may cover a sample of any view.
  void find_leaves(const core::View& view, core::VisibleSet& leaves);
  const core::Aabb& page_box(std::uint32_t page) const { return page_boxes_[page]; }

 private:
  PagedImage(const gl::Context& context, const core::PagedScene& scene, const PagedConfig& config)
      : context_(context), scene_(scene), config_(config), culler_(scene.leaves) {}
  core::Expected<void> make_targets();
  void list_leaves();
  void measure_pages();
  std::vector<std::uint32_t> drawable(const PagesInMemory& pages) const;
  core::Expected<std::uint64_t> draw_page(const PagesInMemory& pages, std::uint32_t page);
  core::Expected<std::uint64_t> draw_coarse_page(const PagesInMemory& pages, std::uint32_t page);
  core::Expected<std::uint64_t> draw(ResidentPage& resident, const core::VisibleSet& set,
                                     const render::RenderTarget& onto);
  ResidentPage& use(PageStore& store, std::uint32_t page, std::uint64_t frame) const;
  core::VisibleSet slots_of_page(std::uint32_t page, const ResidentPage& resident) const;
  core::VisibleSet shown_slots(std::uint32_t page, const ResidentPage& resident) const;
  culling::OcclusionTest occlusion_test(const core::dvec3& origin) const;
  void close(std::uint32_t page, const core::VisibleSet& but);
  core::Expected<void> show_coarse_pages(const PagesInMemory& pages);
  void draw_loading_bar(std::int64_t pending) const;

  const gl::Context& context_;
  const core::PagedScene& scene_;
  const PagedConfig& config_;
  culling::CpuCuller culler_;
  culling::ImageSamples samples_;
  std::vector<core::Aabb> page_boxes_;  // relative to the origin of the leaves
  std::vector<std::uint64_t> line_leaves_;
  render::RenderTarget target_, canvas_;
  std::optional<render::Renderer> renderer_;
  std::optional<Placeholders> placeholders_;
  std::optional<render::DepthShadingPass> depth_shading_;  // made with the first image that has some

  std::optional<core::View> view_;
  std::optional<lod::ImageError> error_;
  culling::DepthPyramid pyramid_;
  std::vector<float> distances_;
  core::VisibleSet in_view_, candidates_;      // leaves
  std::vector<std::uint64_t> visible_leaves_;  // a bit per leaf
  std::vector<std::uint32_t> open_count_;      // by page: its open leaves
  std::vector<bool> coarse_drawn_;             // by page: see coarse_drawn()
  std::vector<float> area_;                    // by page: pixels that its leaves come to
  std::vector<std::uint32_t> by_area_;  // pages with open leaves, the largest first, and some that have none any more
  culling::SetParts parts_;
  std::vector<culling::ContributionTest::SlotArea> areas_;
  std::int64_t leaves_ = 0, items_drawn_ = 0, coarse_items_ = 0, splats_ = 0;
};

}  // namespace sightline::engine
