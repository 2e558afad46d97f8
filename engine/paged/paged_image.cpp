#include "sightline/engine/paged/internal/paged_image.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "sightline/core/internal/store.h"
#include "sightline/engine/internal/settings.h"
#include "sightline/gl/internal/pipeline_state.h"

namespace sightline::engine {
namespace {

constexpr std::uint64_t kFirstPass = 1 << 15;  // items to draw before depth is read back; each pass has twice as many
constexpr std::uint32_t kShortestLeafRange = 16;  // leaves
constexpr float kBarShare = 0.2f;                 // of the image's width

/// The slots whose bits are set, as a set.
void to_set(culling::SlotBits bits, core::VisibleSet& set) {
  set.clear();
  const core::Slot end = core::Slot(bits.size() * 64);
  core::Slot slot = 0;
  while (slot < end) {
    const std::uint64_t rest = bits[slot / 64] >> slot % 64;
    if (rest == 0) {
      slot = (slot / 64 + 1) * 64;
      continue;
    }
    slot += core::Slot(std::countr_zero(rest));
    const core::Slot first = slot;
    while (slot < end && culling::contains(bits, slot)) ++slot;
    if (slot - first >= kShortestLeafRange)
      set.ranges.push_back({first, slot - first});
    else
      for (core::Slot s = first; s < slot; ++s) set.single_slots.push_back(s);
  }
}

/// Whether a coarse page shows an item as the page itself does.
bool is_fine_enough(const core::Page& page, core::Slot slot, const lod::ImageError& image) {
  const core::Kind kind = page.snapshot.kind(slot);
  if (int(kind) < core::kPrimitiveKindCount) return true;
  const auto deviations = page.deviations_of(page.snapshot.of_kind(kind).meshes[page.snapshot.index_in_kind(slot)]);
  if (deviations.empty()) return true;
  // The very rule by which a cut through all levels ends at the coarsest (lod/internal/cut.h).
  const lod::MeshError error(image, page.snapshot.world_from_item(slot));
  return std::ranges::all_of(deviations, [&](const core::MeshDeviation& deviation) {
    return deviation.error <= error.allowed(deviation.box) || error.outside(deviation.box);
  });
}

}  // namespace

PagedImage::PagedImage(const gl::Context& context, const core::PagedScene& scene, const PagedConfig& config)
    : context_(context),
      scene_(scene),
      config_(config),
      leaves_(scene, {config.width,
                      config.height,
                      {{0.0f, 0.0f}},
                      culling::rasteriser_snap(context.capabilities().subpixel_bits, config.width, config.height)}),
      coarse_drawn_(scene.pages.size()) {}

core::Expected<std::unique_ptr<PagedImage>> PagedImage::create(const gl::Context& context,
                                                               const core::PagedScene& scene,
                                                               const PagedConfig& config) {
  std::unique_ptr<PagedImage> image(new PagedImage(context, scene, config));
  if (auto done = image->make_targets(); !done) return tl::unexpected(done.error());
  return image;
}

core::Expected<void> PagedImage::make_targets() {
  const render::TargetFormat format{.ids = config_.drawing.ids};
  for (render::RenderTarget* made : {&target_, &canvas_}) {
    auto target = render::RenderTarget::create(context_, config_.width, config_.height, format);
    if (auto done = core::store(std::move(target), *made); !done) return done;
  }
  std::array<bool, gpuscene::kBatchKindCount> has{};
  for (const auto& page : scene_.pages)
    for (int kind = 0; kind < core::kKindCount; ++kind)
      if (page.of_kind[std::size_t(kind)] > 0) has[std::size_t(gpuscene::batch_of(core::Kind(kind)))] = true;
  std::vector<gpuscene::BatchKind> kinds;
  for (int kind = 0; kind < gpuscene::kBatchKindCount; ++kind)
    if (has[std::size_t(kind)]) kinds.push_back(gpuscene::BatchKind(kind));
  if (auto done = core::store(render::Renderer::create(context_, kinds, format), renderer_); !done) return done;
  give_looks(config_.drawing.looks, *renderer_);
  return core::store(Placeholders::create(context_, format), placeholders_);
}

core::Expected<void> PagedImage::warm_up() {
  if (auto done = renderer_->clear(canvas_); !done) return done;
  canvas_.copy_to(target_);
  pyramid_.clear(config_.width, config_.height);
  distances_.resize(std::size_t(config_.width) * std::size_t(config_.height));
  placeholders_->forget(config_.width, config_.height);
  context_.functions().Finish();
  return {};
}

// --- views -----------------------------------------------------------------------------------------------------------

core::Expected<void> PagedImage::begin(const core::View& view) {
  view_ = view;
  error_.emplace(view, config_.width, config_.height, config_.losses.lod_error);
  if (auto done = renderer_->clear(canvas_); !done) return done;
  pyramid_.clear(config_.width, config_.height);
  coarse_drawn_.assign(coarse_drawn_.size(), false);
  leaves_.begin(view);
  items_drawn_ = coarse_items_ = splats_ = 0;
  return {};
}

culling::OcclusionTest PagedImage::occlusion_test(const core::dvec3& origin) const {
  return {*view_,
          origin,
          config_.width,
          config_.height,
          pyramid_,
          render::RenderTarget::orthographic_error(*view_),
          leaves_.samples().snap};
}

void PagedImage::close_hidden(std::uint32_t page) {
  leaves_.close_hidden(page, occlusion_test(scene_.leaves.origin));
}

// --- drawing ---------------------------------------------------------------------------------------------------------

/// Pages with open leaves of which something that is in memory was not drawn, nearest first.
std::vector<std::uint32_t> PagedImage::drawable(const PagesInMemory& pages) const {
  const core::dvec4 depth = glm::transpose(view_->eye_from_world())[2];  // larger means nearer
  std::vector<std::pair<double, std::uint32_t>> found;
  std::vector<std::uint32_t> resident(pages.full.resident().begin(), pages.full.resident().end());
  if (pages.coarse)
    for (const std::uint32_t page : pages.coarse->resident())
      if (!coarse_drawn_[page] && !pages.full.find(page)) resident.push_back(page);
  for (const std::uint32_t page : resident) {
    if (leaves_.of_page(page) == 0) continue;
    const core::Aabb& box = leaves_.page_box(page);
    double nearest = depth.w;
    for (int axis = 0; axis < 3; ++axis)
      nearest += depth[axis] * (scene_.leaves.origin[axis] + double((depth[axis] > 0.0 ? box.max : box.min)[axis]));
    found.emplace_back(-nearest, page);
  }
  std::sort(found.begin(), found.end());
  std::vector<std::uint32_t> sorted;
  for (const auto& [distance, page] : found) sorted.push_back(page);
  return sorted;
}

/// In passes of more and more items, each behind the depth of the ones before.
core::Expected<void> PagedImage::draw_resident(const PagesInMemory& pages) {
  std::uint64_t drawn = 0, pass = kFirstPass;
  const auto read_back = [&]() -> core::Expected<void> {
    if (auto read = canvas_.read_distances(*view_, distances_); !read) return read;
    pyramid_.build(distances_, config_.width, config_.height);
    items_drawn_ += std::int64_t(std::exchange(drawn, 0));
    return {};
  };
  for (const std::uint32_t page : drawable(pages)) {
    const auto items = pages.full.find(page) ? draw_page(pages, page) : draw_coarse_page(pages, page);
    if (!items) return tl::unexpected(items.error());
    if ((drawn += *items) < pass) continue;
    if (auto read = read_back(); !read) return read;
    pass *= 2;
  }
  return drawn > 0 ? read_back() : core::Expected<void>();
}

/// The slots of the open leaves, those of the view's layers.
core::VisibleSet PagedImage::slots_of_page(std::uint32_t page, const ResidentPage& resident) const {
  const auto& info = scene_.pages[page];
  const core::ItemBounds& bounds = resident.content->snapshot.bounds();
  core::VisibleSet set;
  set.generation = resident.content->snapshot.generation();
  for (std::uint32_t leaf = info.first_leaf; leaf < scene_.leaf_end(page); ++leaf) {
    if (!leaves_.is_open(leaf)) continue;
    const core::Slot first = (leaf - info.first_leaf) * core::kBlockSlots;
    const core::Slot end = std::min<core::Slot>(info.slot_count, first + core::kBlockSlots);
    if (bounds.uses_layers()) {
      for (core::Slot slot = first; slot < end; ++slot)
        if ((bounds.layers(slot) & view_->layers) != 0 && !bounds.vacant(slot)) set.single_slots.push_back(slot);
    } else if ((core::kLayerModel & view_->layers) != 0) {
      culling::append_range(first, end, set.ranges);
    }
  }
  return set;
}

/// What of the open leaves covers a sample and is not known to be hidden.
core::VisibleSet PagedImage::shown_slots(std::uint32_t page, const ResidentPage& resident) const {
  const core::ItemBounds& bounds = resident.content->snapshot.bounds();
  core::VisibleSet open = slots_of_page(page, resident), shown;
  culling::SampleTest(*view_, bounds.origin, leaves_.samples()).filter(bounds, open, shown, resident.lines);
  occlusion_test(bounds.origin).filter(bounds, shown, open, resident.lines);
  return open;
}

/// Returns the number of items drawn.
core::Expected<std::uint64_t> PagedImage::draw(const core::View& view, ResidentPage& resident,
                                               const core::VisibleSet& set, const render::RenderTarget& onto) {
  if (set.count() == 0) return 0;
  const core::Snapshot& snapshot = resident.content->snapshot;
  MeshRules rules{view};
  if (resident.level_bytes > 0) rules.error = &*error_;
  auto& [scene, lists] = *resident.uploaded;
  auto done = choice_.update(lists, scene, snapshot, set, rules);
  if (done) done = renderer_->draw({view, snapshot, scene, lists, onto});
  if (!done) return tl::unexpected(done.error());
  return snapshot.count(set);
}

/// A page in memory that is about to be drawn.
ResidentPage& PagedImage::use(PageStore& store, std::uint32_t page, std::uint64_t frame) const {
  ResidentPage& resident = *store.find(page);
  resident.used = frame;
  resident.area = leaves_.area(page);
  return resident;
}

core::Expected<std::uint64_t> PagedImage::draw_page(const PagesInMemory& pages, std::uint32_t page) {
  ResidentPage& resident = use(pages.full, page, pages.frame);
  close_hidden(page);
  const auto drawn = draw(*view_, resident, shown_slots(page, resident), canvas_);
  if (!drawn) return drawn;
  pages.full.count_again(page);
  leaves_.close(page);
  return drawn;
}

/// Draws the leaves whose meshes are all drawn as well by their coarsest levels. The others stay open.
core::Expected<std::uint64_t> PagedImage::draw_coarse_page(const PagesInMemory& pages, std::uint32_t page) {
  ResidentPage& resident = use(*pages.coarse, page, pages.frame);
  coarse_drawn_[page] = true;
  close_hidden(page);
  const core::VisibleSet shown = shown_slots(page, resident);
  const core::Snapshot& snapshot = resident.content->snapshot;
  std::vector<std::uint64_t> fine(culling::bit_words(snapshot.size())), rough = fine;
  culling::set_bits(shown, fine);
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot)
    if (culling::contains(fine, slot) && !is_fine_enough(*resident.content, slot, *error_))
      rough[slot / 64] |= (~std::uint64_t(0) >> (64 - core::kBlockSlots))
                          << slot % 64 / core::kBlockSlots * core::kBlockSlots;
  core::VisibleSet set, open;
  const std::uint32_t first = scene_.pages[page].first_leaf;
  for (std::uint32_t leaf = first; leaf < scene_.leaf_end(page); ++leaf)
    if (leaves_.is_open(leaf) && culling::contains(rough, (leaf - first) * core::kBlockSlots))
      culling::append_range(leaf, leaf + 1, open.ranges);
  for (std::size_t word = 0; word < fine.size(); ++word) fine[word] &= ~rough[word];
  to_set(fine, set);
  set.generation = snapshot.generation();
  const auto drawn = draw(*view_, resident, set, canvas_);
  if (!drawn) return drawn;
  pages.coarse->count_again(page);
  leaves_.close(page, open);
  return drawn;
}

core::Expected<void> PagedImage::show(const PagesInMemory& pages, std::int64_t pending) {
  canvas_.copy_to(target_);
  coarse_items_ = splats_ = 0;
  if (pending > 0) {
    to_set(leaves_.bits(), lacking_);
    if (pages.coarse)
      if (auto done = show_coarse_pages(pages); !done) return done;
    if (auto done = placeholders_->draw(scene_, *view_, lacking_, target_); !done) return done;
    splats_ = std::int64_t(placeholders_->drawn());
  }
  const DepthShading& shading = config_.drawing.looks.depth_shading;
  if (shading.any()) {
    if (!depth_shading_) depth_shading_.emplace(context_.functions());
    if (auto done = depth_shading_->draw(target_, *view_, shading.strength, shading.edge_lines); !done) return done;
  }
  if (pending > 0 && config_.loading_bar)
    draw_loading_bar(1.0 - double(pending) / double(std::max<std::int64_t>(1, leaves_.in_view())));
  context_.functions().Finish();
  return {};
}

core::Expected<void> PagedImage::complete_traced(const core::View& view, const PagesInMemory& pages, double share) {
  for (const std::uint32_t page : pages.full.resident()) {
    ResidentPage& resident = *pages.full.find(page);
    if (resident.lines.empty() || !resident.uploaded) continue;
    core::VisibleSet lines;
    lines.generation = resident.content->snapshot.generation();
    lines.single_slots = culling::slots_of(resident.lines);
    if (const auto drawn = draw(view, resident, lines, target_); !drawn) return tl::unexpected(drawn.error());
    pages.full.count_again(page);
  }
  if (share < 1.0 && config_.loading_bar) draw_loading_bar(share);
  context_.functions().Finish();
  return {};
}

/// Draws open leaves by the coarsest levels of their meshes, and leaves the others to splats.
core::Expected<void> PagedImage::show_coarse_pages(const PagesInMemory& pages) {
  const culling::SlotBits open = leaves_.bits();
  std::vector<std::uint64_t> rest(open.begin(), open.end());
  for (const std::uint32_t page : pages.coarse->resident()) {
    if (leaves_.of_page(page) == 0) continue;
    ResidentPage& resident = use(*pages.coarse, page, pages.frame);
    const auto drawn = draw(*view_, resident, shown_slots(page, resident), target_);
    if (!drawn) return tl::unexpected(drawn.error());
    coarse_items_ += std::int64_t(*drawn);
    pages.coarse->count_again(page);
    for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < scene_.leaf_end(page); ++leaf)
      rest[leaf / 64] &= ~(std::uint64_t(1) << leaf % 64);
  }
  to_set(rest, lacking_);
  return {};
}

void PagedImage::draw_loading_bar(double share) const {
  const gl::Functions& gl = context_.functions();
  gl::reset_pipeline_state(gl);
  gl.Enable(GL_SCISSOR_TEST);
  const int width = std::max(8, int(kBarShare * float(config_.width))), height = std::max(3, config_.height / 120);
  const float ground[4] = {0.15f, 0.15f, 0.17f, 1.0f}, done[4] = {1.0f, 0.6f, 0.1f, 1.0f};
  const GLuint framebuffer = target_.framebuffer().id();
  gl.Scissor(height, height, width, height);
  gl.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, ground);
  gl.Scissor(height, height, int(share * width), height);
  gl.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, done);
  gl.Disable(GL_SCISSOR_TEST);
}

}  // namespace sightline::engine
