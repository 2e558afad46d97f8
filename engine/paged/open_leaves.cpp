#include "sightline/engine/paged/internal/open_leaves.h"

#include <algorithm>
#include <numeric>

namespace sightline::engine {

OpenLeaves::OpenLeaves(const core::PagedScene& scene, const culling::ImageSamples& samples)
    : scene_(scene),
      samples_(samples),
      culler_(scene.leaves),
      page_boxes_(scene.pages.size()),
      line_leaves_(culling::bit_words(scene.leaves.size())),
      bits_(culling::bit_words(scene.leaves.size())),
      count_(scene.pages.size()),
      area_(scene.pages.size()) {
  for (std::uint32_t page = 0; page < page_boxes_.size(); ++page)
    for (std::uint32_t leaf = scene.pages[page].first_leaf; leaf < scene.leaf_end(page); ++leaf) {
      page_boxes_[page].grow(scene.leaves.box(leaf));
      if ((scene.colours[leaf] & core::PagedScene::kHasLines) != 0)
        line_leaves_[leaf / 64] |= std::uint64_t(1) << leaf % 64;
    }
}

void OpenLeaves::begin(const core::View& view) {
  find(view, found_);
  bits_.assign(bits_.size(), 0);
  culling::set_bits(found_, bits_);
  in_view_count_ = std::int64_t(found_.count());
  measure_pages(view);
}

void OpenLeaves::find(const core::View& view, core::VisibleSet& leaves) {
  core::View any_layer = view;
  any_layer.layers = ~0u;
  culler_.cull(any_layer, in_volume_);
  culling::SampleTest(view, scene_.leaves.origin, samples_).filter(scene_.leaves, in_volume_, leaves, line_leaves_);
}

/// Counts the leaves of each page, and sums up their areas.
void OpenLeaves::measure_pages(const core::View& view) {
  constexpr std::uint32_t kPart = 1 << 15;  // leaves at a time
  const culling::ContributionTest test(view, scene_.leaves.origin, samples_.width, samples_.height);
  const float whole = float(samples_.width) * float(samples_.height);
  std::fill(count_.begin(), count_.end(), 0);
  std::fill(area_.begin(), area_.end(), 0.0f);
  parts_.split(found_, kPart);
  for (std::uint32_t part = 0; part < parts_.count(); ++part) {
    test.areas(scene_.leaves, parts_[part], areas_);
    std::uint32_t page = 0;  // leaves of a part rise
    for (const auto& [leaf, area] : areas_) {
      while (leaf >= scene_.leaf_end(page)) ++page;
      ++count_[page];
      area_[page] += std::min(area, whole);
    }
  }
  by_area_.clear();
  for (std::uint32_t page = 0; page < scene_.pages.size(); ++page)
    if (count_[page] > 0) by_area_.push_back(page);
  std::sort(by_area_.begin(), by_area_.end(), [&](auto a, auto b) { return area_[a] > area_[b]; });
}

std::int64_t OpenLeaves::count() const {
  return std::accumulate(count_.begin(), count_.end(), std::int64_t(0));
}

std::span<const std::uint32_t> OpenLeaves::list_pages() {
  std::erase_if(by_area_, [&](std::uint32_t page) { return count_[page] == 0; });
  return by_area_;
}

void OpenLeaves::close(std::uint32_t page, const core::VisibleSet& but) {
  for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < scene_.leaf_end(page); ++leaf)
    bits_[leaf / 64] &= ~(std::uint64_t(1) << leaf % 64);
  culling::set_bits(but, bits_);
  count_[page] = std::uint32_t(but.count());
}

void OpenLeaves::close_hidden(std::uint32_t page, const culling::OcclusionTest& test) {
  core::VisibleSet leaves, open;
  for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < scene_.leaf_end(page); ++leaf)
    if (is_open(leaf)) culling::append_range(leaf, leaf + 1, leaves.ranges);
  test.filter(scene_.leaves, leaves, open, line_leaves_);
  close(page, open);
}

}  // namespace sightline::engine
