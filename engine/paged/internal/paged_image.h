// The image of a paged engine, and what of it is drawn. Internal to engine.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sightline/core/paged_scene.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/engine/drawing/internal/draw_choice.h"
#include "sightline/engine/paged/internal/open_leaves.h"
#include "sightline/engine/paged/internal/page_store.h"
#include "sightline/engine/paged/internal/placeholders.h"
#include "sightline/engine/paged/paged_engine.h"
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

/// Draws what comes into memory onto a canvas, where it stays when its page goes. The image that is shown is a copy of
/// the canvas, with coarse pages and splats in place of open leaves.
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
  /// Completes a moving image that the target has: lines of pages that are uploaded, which rays do not meet, and the
  /// loading bar. `share`: of the image that is there.
  core::Expected<void> complete_traced(const core::View& view, const PagesInMemory& pages, double share);
  const render::RenderTarget& target() const { return target_; }

  OpenLeaves& leaves() { return leaves_; }
  /// Whether a coarse page has drawn what it shows as well as the page in full: what is open needs that.
  bool coarse_drawn(std::uint32_t page) const { return coarse_drawn_[page]; }
  std::int64_t items_drawn() const { return items_drawn_; }
  std::int64_t coarse_items() const { return coarse_items_; }  ///< in the image that is shown, in place of open leaves
  std::int64_t splats() const { return splats_; }              ///< likewise

 private:
  PagedImage(const gl::Context& context, const core::PagedScene& scene, const PagedConfig& config);
  core::Expected<void> make_targets();
  std::vector<std::uint32_t> drawable(const PagesInMemory& pages) const;
  core::Expected<std::uint64_t> draw_page(const PagesInMemory& pages, std::uint32_t page);
  core::Expected<std::uint64_t> draw_coarse_page(const PagesInMemory& pages, std::uint32_t page);
  core::Expected<std::uint64_t> draw(const core::View& view, ResidentPage& resident, const core::VisibleSet& set,
                                     const render::RenderTarget& onto);
  ResidentPage& use(PageStore& store, std::uint32_t page, std::uint64_t frame) const;
  core::VisibleSet slots_of_page(std::uint32_t page, const ResidentPage& resident) const;
  core::VisibleSet shown_slots(std::uint32_t page, const ResidentPage& resident) const;
  culling::OcclusionTest occlusion_test(const core::dvec3& origin) const;
  core::Expected<void> show_coarse_pages(const PagesInMemory& pages);
  void draw_loading_bar(double share) const;

  const gl::Context& context_;
  const core::PagedScene& scene_;
  const PagedConfig& config_;
  OpenLeaves leaves_;
  render::RenderTarget target_, canvas_;
  std::optional<render::Renderer> renderer_;
  DrawChoice choice_;
  std::optional<Placeholders> placeholders_;
  std::optional<render::DepthShadingPass> depth_shading_;  // made with the first image that has some

  std::optional<core::View> view_;
  std::optional<lod::ImageError> error_;
  culling::DepthPyramid pyramid_;
  std::vector<float> distances_;
  core::VisibleSet lacking_;        // leaves that no coarse page shows
  std::vector<bool> coarse_drawn_;  // by page: see coarse_drawn()
  std::int64_t items_drawn_ = 0, coarse_items_ = 0, splats_ = 0;
};

}  // namespace sightline::engine
