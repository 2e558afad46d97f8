// Moving images of a paged engine, by rays. Internal to engine.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sightline/core/paged_scene.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/engine/looks.h"
#include "sightline/engine/paged/internal/open_leaves.h"
#include "sightline/engine/paged/internal/page_store.h"
#include "sightline/engine/paged/internal/paged_image.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::raytrace {
class ItemBoxes;
class MovingImage;
}  // namespace sightline::raytrace

namespace sightline::engine {

/// Shows what pages in memory have, coarse ones in place of others, and boxes of leaves of those that are not.
class TracedPages {
 public:
  /// Fails in builds without rays. Both must outlive it; `leaves`: of the scene.
  static core::Expected<std::unique_ptr<TracedPages>> create(const core::PagedScene& scene, const OpenLeaves& leaves,
                                                             int threads);

  struct Counts {
    double coarseness = 1.0, earlier = 0.0;  ///< as FrameReport has them
    std::int64_t leaves = 0;                 ///< of which the image shows the box
    double boxes = 0.0;                      ///< share of the pixels with an item that show one
  };
  /// Writes the image of a view to a target, as far as it comes by `deadline` (core::now_seconds()).
  core::Expected<Counts> draw(const core::View& view, const Looks& looks, const PagesInMemory& pages,
                              const render::RenderTarget& target, double deadline);
  /// Pages of the leaves whose boxes the last image shows or is taken in, by the pixels that wait for them.
  std::span<const PageStore::Wanted> missing() const { return missing_; }

  std::size_t memory_bytes() const;
  /// What memory_bytes() comes to with images of this size.
  std::size_t memory_bytes(int width, int height) const;

 private:
  TracedPages(const core::PagedScene& scene, const OpenLeaves& leaves, int threads);
  void mark_used(const PagesInMemory& pages, float pixels_a_ray);
  void show(const render::RenderTarget& target);
  void find_missing(const core::View& view, Counts& counts);
  bool holds(std::uint32_t page, const core::dvec3& place) const;

  const core::PagedScene& scene_;
  const OpenLeaves& leaves_;
  core::ThreadPool threads_;
  std::shared_ptr<raytrace::ItemBoxes> boxes_;  // builds without rays do not know their types
  std::shared_ptr<raytrace::MovingImage> image_;
  std::vector<std::uint32_t> page_of_, part_of_;  // by leaf; part_of_: in the list of the parts traced, or kNone
  std::vector<std::atomic<std::uint32_t>> hits_;  // by page, of one image
  std::vector<std::uint64_t> traced_;             // a bit per leaf whose page is traced
  std::vector<std::uint32_t> pixels_, ids_;       // by page: that show boxes of its leaves; by pixel
  std::vector<std::uint64_t> shown_;              // a bit per leaf whose box the image shows
  std::vector<PageStore::Wanted> missing_;
  std::uint64_t loaded_ = 0;         // pages read before the last image
  double after_rays_seconds_ = 0.0;  // what followed the rays of the last image
};

}  // namespace sightline::engine
