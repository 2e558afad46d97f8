#include "sightline/engine/paged/internal/traced_pages.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/core/internal/clock.h"
#include "sightline/culling/occlusion/sample_test.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/raytrace/internal/item_boxes.h"
#include "sightline/raytrace/internal/moving_image.h"
#endif

namespace sightline::engine {

#if SIGHTLINE_HAS_RAYTRACE

namespace {

constexpr std::uint32_t kFirstLeafId = 1u << 31;  // of boxes in images, beyond all items
// A page that is read must show in so many times as many pixels as one that goes for it, whose number is guessed by the
// rays that hit it; that decays so fast from image to image.
constexpr float kWorth = 0.5f, kKept = 0.9f;
constexpr float kWholeImage = std::numeric_limits<float>::infinity();

std::int64_t leaf_of(std::uint32_t pixel_id) {
  return pixel_id > kFirstLeafId ? std::int64_t(pixel_id - kFirstLeafId - 1) : -1;
}

}  // namespace

TracedPages::TracedPages(const core::PagedScene& scene, const OpenLeaves& leaves, int threads)
    : scene_(scene),
      leaves_(leaves),
      threads_(threads),
      boxes_(std::make_shared<raytrace::ItemBoxes>(scene.leaves, 0)),
      image_(std::make_shared<raytrace::MovingImage>()),
      page_of_(scene.leaves.size()),
      part_of_(scene.leaves.size()),
      hits_(scene.pages.size()),
      traced_(culling::bit_words(scene.leaves.size())),
      pixels_(scene.pages.size()),
      shown_(culling::bit_words(scene.leaves.size())) {
  for (std::uint32_t page = 0; page < scene.pages.size(); ++page)
    std::fill(page_of_.begin() + scene.pages[page].first_leaf, page_of_.begin() + scene.leaf_end(page), page);
}

core::Expected<std::unique_ptr<TracedPages>> TracedPages::create(const core::PagedScene& scene,
                                                                 const OpenLeaves& leaves, int threads) {
  return std::unique_ptr<TracedPages>(new TracedPages(scene, leaves, threads));
}

core::Expected<TracedPages::Counts> TracedPages::draw(const core::View& view, const Looks& looks,
                                                      const PagesInMemory& pages, const render::RenderTarget& target,
                                                      double deadline) {
  std::vector<raytrace::TracedPart> parts;
  core::VisibleSet traced;
  std::fill(part_of_.begin(), part_of_.end(), core::kNone);
  const auto add = [&](std::uint32_t page, const ResidentPage& resident) {
    if (!resident.tracer) return;
    hits_[page] = 0;
    const std::uint32_t first = scene_.pages[page].first_leaf, end = scene_.leaf_end(page);
    std::fill(part_of_.begin() + first, part_of_.begin() + end, std::uint32_t(parts.size()));
    culling::append_range(first, end, traced.ranges);
    parts.push_back({resident.tracer.get(), {}, &hits_[page]});
  };
  for (const std::uint32_t page : pages.full.resident()) add(page, *pages.full.find(page));
  if (pages.coarse)
    for (const std::uint32_t page : pages.coarse->resident())
      if (!pages.full.find(page)) add(page, *pages.coarse->find(page));
  std::fill(traced_.begin(), traced_.end(), 0);
  culling::set_bits(traced, traced_);
  const std::uint64_t loaded = pages.full.counts().loaded + (pages.coarse ? pages.coarse->counts().loaded : 0);
  if (std::exchange(loaded_, loaded) != loaded)
    image_->doubt([&](std::uint32_t id) {
      const std::int64_t leaf = leaf_of(id);
      return leaf >= 0 && culling::contains(traced_, core::Slot(leaf));
    });
  const raytrace::ImageRequest request{{parts, {boxes_.get(), part_of_, traced_, scene_.colours, kFirstLeafId}},
                                               view,
                                               target.width(),
                                               target.height(),
                                               looks.lighting,
                                               looks.sun,
                                               {looks.background.bottom, looks.background.top}};
  const auto drawn = image_->draw(request, threads_, deadline - after_rays_seconds_);
  if (!drawn) return tl::unexpected(drawn.error());
  const double after_rays = core::now_seconds();
  const double all = double(target.width()) * target.height();
  mark_used(pages, float(all / double(std::max<std::int64_t>(1, drawn->traced))));
  show(target);
  Counts counts{std::sqrt(all / std::max(1.0, all - double(drawn->filled))), double(drawn->kept) / all};
  find_missing(view, counts);
  after_rays_seconds_ = core::now_seconds() - after_rays;
  return counts;
}

void TracedPages::mark_used(const PagesInMemory& pages, float pixels_a_ray) {
  for (PageStore* const store : {&pages.full, pages.coarse}) {
    if (!store) continue;
    for (const std::uint32_t page : store->resident()) {
      if (hits_[page] == 0) continue;
      ResidentPage& resident = *store->find(page);
      resident.used = pages.frame;
      resident.area = std::max(kKept * resident.area, pixels_a_ray * float(hits_[page]));
      store->need(page);
    }
  }
}

/// Boxes have no id.
void TracedPages::show(const render::RenderTarget& target) {
  const raytrace::PointImage::Pixels image = image_->points().pixels();
  if (target.has_ids()) {
    ids_.resize(image.ids.size());
    std::transform(image.ids.begin(), image.ids.end(), ids_.begin(),
                   [](std::uint32_t id) { return id > kFirstLeafId ? 0 : id; });
  }
  target.write(image.colours, image.depths, ids_);
}

/// Boxes that the eye is in do not show, and their items come first.
void TracedPages::find_missing(const core::View& view, Counts& counts) {
  std::fill(pixels_.begin(), pixels_.end(), 0);
  std::fill(shown_.begin(), shown_.end(), 0);
  std::int64_t items = 0, boxes = 0;
  std::uint32_t last = 0, page_of_last = 0;
  for (const std::uint32_t id : image_->points().pixels().ids) {
    items += std::int64_t(id != 0);
    const std::int64_t leaf = leaf_of(id);
    if (leaf < 0) continue;
    ++boxes;
    if (std::exchange(last, id) != id) {
      page_of_last = page_of_[std::size_t(leaf)];
      shown_[std::size_t(leaf) / 64] |= std::uint64_t(1) << leaf % 64;
    }
    ++pixels_[page_of_last];
  }
  for (const std::uint64_t word : shown_) counts.leaves += std::popcount(word);
  if (items > 0) counts.boxes = double(boxes) / double(items);
  missing_.clear();
  const core::dvec3 eye(glm::inverse(view.eye_from_world())[3]);
  for (std::uint32_t page = 0; page < pixels_.size(); ++page) {
    if (holds(page, eye - scene_.leaves.origin))
      missing_.push_back({page, kWholeImage, true});
    else if (pixels_[page] > 0)
      missing_.push_back({page, kWorth * float(pixels_[page]), true});
  }
  std::sort(missing_.begin(), missing_.end(), [](const auto& a, const auto& b) { return a.area > b.area; });
}

/// Whether a leaf of a page that is not traced has a place within its box.
bool TracedPages::holds(std::uint32_t page, const core::dvec3& place) const {
  const auto within = [&](const core::Aabb& box) {
    return glm::all(glm::greaterThanEqual(place, core::dvec3(box.min))) &&
           glm::all(glm::lessThanEqual(place, core::dvec3(box.max)));
  };
  if (!within(leaves_.page_box(page))) return false;
  for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < scene_.leaf_end(page); ++leaf)
    if (!culling::contains(traced_, leaf) && within(scene_.leaves.box(leaf))) return true;
  return false;
}

std::size_t TracedPages::memory_bytes() const {
  return boxes_->memory_bytes() + image_->points().memory_bytes();
}
std::size_t TracedPages::memory_bytes(int width, int height) const {
  return boxes_->memory_bytes() + raytrace::PointImage::kBytes * std::size_t(width) * std::size_t(height);
}

#else

core::Expected<std::unique_ptr<TracedPages>> TracedPages::create(const core::PagedScene&, const OpenLeaves&, int) {
  return core::fail("engine: this build traces no rays, by which a paged engine keeps budget_ms");
}
core::Expected<TracedPages::Counts> TracedPages::draw(const core::View&, const Looks&, const PagesInMemory&,
                                                      const render::RenderTarget&, double) {
  return Counts();
}
std::size_t TracedPages::memory_bytes() const {
  return 0;
}
std::size_t TracedPages::memory_bytes(int, int) const {
  return 0;
}

#endif

}  // namespace sightline::engine
