#include "sightline/engine/paged_engine.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <new>
#include <system_error>
#include <utility>

#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/engine/internal/clock.h"
#include "sightline/engine/internal/page_store.h"
#include "sightline/engine/internal/placeholders.h"
#include "sightline/gl/internal/current_context.h"
#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/gl/internal/program_cache.h"
#include "sightline/lod/internal/cut.h"
#include "sightline/render/image/image.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::engine {
namespace {

constexpr std::uint64_t kFirstPass = 1 << 15;  // items to draw before depth is read back; each pass has twice as many
constexpr std::uint32_t kShortestLeafRange = 16;  // leaves
constexpr int kForeseen = 3;                      // the camera's motion is doubled so often: frames ahead
constexpr double kLongestTrial = 10.0;            // seconds
constexpr float kBarShare = 0.2f;                 // of the image's width
constexpr std::size_t kMegabyte = std::size_t(1) << 20;
constexpr std::size_t kCoarseShare = 4;  // one part in so many of the memory for pages is for coarse ones
constexpr std::size_t kReserveShare = 10, kLeastReserve = 32 * kMegabyte;  // see reserve_of()

/// The motion of a camera between two views, kept up for 2^kForeseen frames.
std::optional<core::View> foreseen(const core::View& before, const core::View& now) {
  if (before.clip_from_eye() != now.clip_from_eye()) return std::nullopt;
  core::dmat4 motion = now.eye_from_world() * glm::inverse(before.eye_from_world());
  for (int i = 0; i < kForeseen; ++i) motion = motion * motion;
  auto view = core::View::from_matrices(motion * now.eye_from_world(), now.clip_from_eye(), now.clip_depth());
  if (!view) return std::nullopt;
  return *view;
}

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

/// What is left to drivers and the allocator while they draw: one part in so many of the limit, but not too little.
std::size_t reserve_of(std::size_t limit) {
  return std::max(limit / kReserveShare, kLeastReserve);
}

/// What it takes to read an image and keep it: three bytes a pixel of colours, four each of depths and ids, and four
/// more while one of these is turned upside down.
std::size_t bytes_to_read(const PagedConfig& config) {
  return std::size_t(config.width) * std::size_t(config.height) * std::size_t(3 + 4 + 4 + (config.ids ? 4 : 0));
}

/// More than drivers are known to take when they draw for the first time.
std::size_t bytes_of_drivers(const PagedConfig& config) {
  return 64 * kMegabyte + 8 * std::size_t(config.width) * std::size_t(config.height);
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

/// What the standard library throws becomes an error.
template <class Call>
auto without_throwing(const Call& call) -> decltype(call()) {
  try {
    return call();
  } catch (const std::bad_alloc&) {
    return core::fail("engine: not enough memory");
  } catch (const std::system_error& error) {
    return core::fail(std::string("engine: ") + error.what());
  }
}

std::string in_megabytes(std::size_t bytes) {
  return std::to_string((bytes + kMegabyte - 1) / kMegabyte) + " MiB";
}

}  // namespace

class PagedEngine::Impl {
 public:
  static core::Expected<std::unique_ptr<Impl>> create(core::PagedScene scene, const PagedConfig& config);
  ~Impl() { (void)context_.make_current(); }
  core::Expected<PagedReport> frame(const core::View& view);
  core::Expected<PagedReport> settle(const core::View& view, const Progress& progress);
  bool wait(double seconds) {
    return coarse_ && coarse_->on_their_way() > 0 ? coarse_->wait(seconds) : store_->wait(seconds);
  }

  std::vector<std::string> take_errors();
  std::vector<std::string> take_gl_errors() {
    return context_.make_current() ? context_.take_errors() : std::vector<std::string>();
  }
  const render::RenderTarget& image() const {
    (void)context_.make_current();
    return target_;
  }
  const core::View& view() const { return *view_; }
  const core::PagedScene& scene() const { return scene_; }
  const std::string& renderer() const { return context_.renderer(); }
  Memory memory() const {
    return coarse_ ? Memory{store_->bytes() + coarse_->bytes(), store_->limit() + coarse_->limit()}
                   : Memory{store_->bytes(), store_->limit()};
  }

 private:
  Impl(core::PagedScene scene, const PagedConfig& config, gl::Context context)
      : context_(std::move(context)), scene_(std::move(scene)), config_(config), culler_(scene_.leaves) {
    if (config_.lod_error == 0.0)
      for (core::PagedScene::PageInfo& page : scene_.pages) page.level_indices = 0;  // nobody reads them
  }
  core::Expected<void> prepare();
  core::Expected<void> warm_up();
  core::Expected<void> draw_trial();
  std::size_t room_for_pages() const;
  std::size_t least_for_pages() const;
  void set_limits(std::size_t limit);
  core::Expected<void> make_store();
  void keep_within_limit();

  core::Expected<void> take_context();
  PagedReport begin(const core::View& view);
  void unoccluded_leaves();
  core::Expected<void> refine(double until, bool stays);
  core::Expected<PagedReport> complete(const core::View& view, const Progress& progress);
  core::Expected<void> refine_more();
  core::Expected<void> draw_resident();
  core::Expected<std::uint64_t> draw_page(std::uint32_t page);
  core::Expected<std::uint64_t> draw_coarse_page(std::uint32_t page);
  core::VisibleSet shown_slots(std::uint32_t page, const ResidentPage& resident) const;
  core::Expected<std::uint64_t> draw(ResidentPage& resident, const core::VisibleSet& set,
                                     const render::RenderTarget& onto);
  std::vector<std::uint32_t> drawable() const;
  core::VisibleSet slots_of_page(std::uint32_t page, const ResidentPage& resident) const;
  void close_hidden(std::uint32_t page);
  void close(std::uint32_t page, const core::VisibleSet& but);
  culling::OcclusionTest occlusion_test(const core::dvec3& origin) const;
  void ask_for_pages(bool stays);
  bool lacks_coarse(std::uint32_t page) const;
  void foresee(std::vector<PageStore::Wanted>& wanted, std::vector<PageStore::Wanted>& coarse);
  core::Expected<void> show();
  core::Expected<void> show_coarse_pages();
  void draw_loading_bar() const;

  gl::Context context_;  // destroyed last
  core::PagedScene scene_;
  PagedConfig config_;
  culling::CpuCuller culler_;
  std::vector<core::Aabb> page_boxes_;  // relative to the origin of the leaves
  std::vector<std::uint64_t> line_leaves_;
  render::RenderTarget target_, canvas_;
  std::optional<render::Renderer> renderer_;
  std::optional<Placeholders> placeholders_;
  std::size_t page_limit_ = 0;  // bytes for pages, where drivers take what was foreseen
  std::unique_ptr<PageStore> store_;
  std::unique_ptr<PageStore> coarse_;  // of the coarsest levels; null: there are none

  // The image that is being drawn.
  std::optional<core::View> view_, before_;
  std::optional<lod::ImageError> image_error_;
  culling::ImageSamples samples_;
  culling::DepthPyramid pyramid_;
  std::vector<float> distances_;
  core::VisibleSet in_view_, candidates_;  // leaves
  std::vector<std::uint64_t> open_;        // a bit per leaf that is still to be drawn
  std::vector<std::uint32_t> open_count_;  // by page: its open leaves
  std::vector<bool> coarse_drawn_;         // by page: what of its coarse form shows as much as all of it
  bool settling_ = false;                  // nobody looks at what comes before the image is complete
  std::vector<float> area_;                // by page: pixels that its leaves come to
  std::vector<std::uint32_t> by_area_;  // pages with open leaves, the largest first, and some that have none any more
  culling::SetParts parts_;
  std::vector<culling::ContributionTest::SlotArea> areas_;
  std::uint64_t frames_ = 0;
  PagedReport report_;
};

// --- making ----------------------------------------------------------------------------------------------------------

core::Expected<std::unique_ptr<PagedEngine::Impl>> PagedEngine::Impl::create(core::PagedScene scene,
                                                                             const PagedConfig& config) {
  if (!(config.lod_error >= 0.0)) return core::fail("engine: lod_error must be 0 or more pixels");
  gl::ContextOptions options;
  options.platform = config.context_platform;
  options.debug = config.gl_debug;
  auto context = gl::Context::create_offscreen(options);
  if (!context) return tl::unexpected(context.error());
  std::unique_ptr<Impl> impl(new Impl(std::move(scene), config, std::move(*context)));
  if (auto done = impl->prepare(); !done) return tl::unexpected(done.error());
  return impl;
}

core::Expected<void> PagedEngine::Impl::prepare() {
  if (auto current = context_.make_current(); !current) return current;
  context_.cache_programs(config_.program_cache.value_or(gl::ProgramCache::default_folder()));
  context_.test_driver();
  const render::TargetFormat format{.ids = config_.ids};
  for (render::RenderTarget* made : {&target_, &canvas_}) {
    auto target = render::RenderTarget::create(context_, config_.width, config_.height, format);
    if (!target) return tl::unexpected(target.error());
    *made = std::move(*target);
  }
  samples_ = {config_.width,
              config_.height,
              {{0.0f, 0.0f}},
              culling::rasteriser_snap(context_.capabilities().subpixel_bits, config_.width, config_.height)};
  std::array<bool, gpuscene::kBatchKindCount> has{};
  for (const auto& page : scene_.pages)
    for (int kind = 0; kind < core::kKindCount; ++kind)
      if (page.of_kind[std::size_t(kind)] > 0) has[std::size_t(gpuscene::batch_of(core::Kind(kind)))] = true;
  std::vector<gpuscene::BatchKind> kinds;
  for (int kind = 0; kind < gpuscene::kBatchKindCount; ++kind)
    if (has[std::size_t(kind)]) kinds.push_back(gpuscene::BatchKind(kind));
  auto renderer = render::Renderer::create(context_, kinds, format);
  if (!renderer) return tl::unexpected(renderer.error());
  renderer_.emplace(std::move(*renderer));
  auto placeholders = Placeholders::create(context_, format);
  if (!placeholders) return tl::unexpected(placeholders.error());
  placeholders_.emplace(std::move(*placeholders));

  page_boxes_.resize(scene_.pages.size());
  line_leaves_.resize(culling::bit_words(scene_.leaves.size()));
  for (std::uint32_t page = 0; page < page_boxes_.size(); ++page)
    for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < scene_.leaf_end(page); ++leaf) {
      page_boxes_[page].grow(scene_.leaves.box(leaf));
      if ((scene_.colours[leaf] & core::PagedScene::kHasLines) != 0)
        line_leaves_[leaf / 64] |= std::uint64_t(1) << leaf % 64;
    }
  open_.resize(culling::bit_words(scene_.leaves.size()));
  open_count_.resize(scene_.pages.size());
  area_.resize(scene_.pages.size());
  coarse_drawn_.resize(scene_.pages.size());
  if (auto done = warm_up(); !done) return done;
  return make_store();
}

/// What frames take beside pages is taken once before it is measured.
core::Expected<void> PagedEngine::Impl::warm_up() {
  renderer_->clear(canvas_);
  canvas_.copy_to(target_);
  pyramid_.clear(config_.width, config_.height);
  distances_.resize(std::size_t(config_.width) * std::size_t(config_.height));
  placeholders_->forget(config_.width, config_.height);
  context_.functions().Finish();
  return room_for_pages() < bytes_of_drivers(config_) ? draw_trial() : core::Expected<void>();
}

/// Drivers compile and allocate when they draw for the first time. Where pages could not give that back later, one is
/// drawn now, as large as the image is.
core::Expected<void> PagedEngine::Impl::draw_trial() {
  const auto largest = std::max_element(scene_.pages.begin(), scene_.pages.end(), [](const auto& a, const auto& b) {
    return PageStore::bytes_of(a) < PageStore::bytes_of(b);
  });
  if (largest == scene_.pages.end()) return {};
  const PageStore::Wanted first{std::uint32_t(largest - scene_.pages.begin()), 1.0f, true};
  core::AabbD place;
  if (const core::Aabb& box = page_boxes_[first.page]; !box.empty())
    place = {core::dvec3(box.min) + scene_.leaves.origin, core::dvec3(box.max) + scene_.leaves.origin};
  const auto view =
      core::View::fit(place, core::kOverviewDirection, 0.8, double(config_.width) / double(config_.height));
  if (!view) return {};
  report_ = begin(*view);
  store_ = std::make_unique<PageStore>(scene_, 0);
  store_->ask_for({&first, 1}, 0, true);
  (void)store_->wait(kLongestTrial);
  auto done = store_->take_loaded(context_, 0);
  if (done) done = draw_resident();
  report_.pending = report_.leaves;
  if (done) done = show();
  store_.reset();
  view_.reset();
  return done;
}

/// What the limit leaves; 0 where that is less than a page.
std::size_t PagedEngine::Impl::room_for_pages() const {
  const std::size_t taken = process_memory() + bytes_to_read(config_) + reserve_of(config_.memory_limit);
  return config_.memory_limit < taken + least_for_pages() ? 0 : config_.memory_limit - taken;
}

std::size_t PagedEngine::Impl::least_for_pages() const {
  return PageStore::largest_page(scene_) + (scene_.coarse ? PageStore::largest_page(*scene_.coarse) : 0);
}

void PagedEngine::Impl::set_limits(std::size_t limit) {
  if (coarse_) {
    coarse_->set_limit(limit / kCoarseShare);
    limit -= std::min(limit, coarse_->limit());
  }
  store_->set_limit(limit);
}

core::Expected<void> PagedEngine::Impl::make_store() {
  give_back_free_memory();
  page_limit_ = room_for_pages();
  if (page_limit_ == 0) {
    const std::size_t used = process_memory() + bytes_to_read(config_), least = least_for_pages();
    return core::fail(
        "engine: a memory limit of " + in_megabytes(config_.memory_limit) + " is too low: " + in_megabytes(used) +
        " are taken without any page, and the largest page takes " + in_megabytes(least) + "; expected " +
        in_megabytes(std::max((used + least) * kReserveShare / (kReserveShare - 1), used + least + kLeastReserve)) +
        " or more");
  }
  store_ = std::make_unique<PageStore>(scene_, page_limit_);
  if (scene_.coarse) coarse_ = std::make_unique<PageStore>(*scene_.coarse, 0);
  set_limits(page_limit_);
  return {};
}

/// Drivers and the allocator may take more than was foreseen. Then pages get less, until these take less again.
void PagedEngine::Impl::keep_within_limit() {
  const std::size_t most = config_.memory_limit - reserve_of(config_.memory_limit) / 2 - bytes_to_read(config_);
  if (process_memory() > most) give_back_free_memory();
  const std::size_t used = process_memory();
  const std::size_t pages = store_->resident_bytes() + (coarse_ ? coarse_->resident_bytes() : 0);
  set_limits(std::min(page_limit_, most + pages > used ? most + pages - used : 0));
}

// --- frames ----------------------------------------------------------------------------------------------------------

core::Expected<void> PagedEngine::Impl::take_context() {
  if (auto current = context_.make_current(); !current) return current;
  return context_.lost() ? core::fail("engine: the context is lost") : core::Expected<void>();
}

core::Expected<PagedReport> PagedEngine::Impl::frame(const core::View& view) {
  const gl::CurrentContext kept;
  const double began = now_seconds();
  if (auto ready = take_context(); !ready) return tl::unexpected(ready.error());
  const bool stays = view_ && core::same_image(*view_, view);
  if (!stays) report_ = begin(view);
  report_.frame = frames_++;
  if (auto done = refine(began + 1e-3 * config_.refine_ms, stays); !done) return tl::unexpected(done.error());
  if (auto done = show(); !done) return tl::unexpected(done.error());
  if (auto ready = take_context(); !ready) return tl::unexpected(ready.error());  // else nothing of this was drawn
  report_.frame_ms = 1e3 * (now_seconds() - began);
  return report_;
}

core::Expected<PagedReport> PagedEngine::Impl::settle(const core::View& view, const Progress& progress) {
  settling_ = true;
  auto report = complete(view, progress);
  settling_ = false;
  return report;
}

/// Shows no image before it is complete.
core::Expected<PagedReport> PagedEngine::Impl::complete(const core::View& view, const Progress& progress) {
  auto report = frame(view);
  while (report && !report_.complete) {
    if (progress && !progress(report_)) return report_;
    if (auto done = refine_more(); !done) return tl::unexpected(done.error());
    if (!report_.complete) continue;
    report = frame(view);
  }
  return report;
}

std::vector<std::string> PagedEngine::Impl::take_errors() {
  auto errors = store_->take_errors();
  if (coarse_)
    for (std::string& error : coarse_->take_errors()) errors.push_back(std::move(error));
  return errors;
}

/// Of the image begun, without showing it.
core::Expected<void> PagedEngine::Impl::refine_more() {
  const gl::CurrentContext kept;
  if (auto ready = take_context(); !ready) return ready;
  return refine(now_seconds() + 1e-3 * config_.refine_ms, true);
}

PagedReport PagedEngine::Impl::begin(const core::View& view) {
  before_ = std::exchange(view_, view);
  image_error_.emplace(view, config_.width, config_.height, config_.lod_error);
  renderer_->clear(canvas_);
  pyramid_.clear(config_.width, config_.height);
  coarse_drawn_.assign(coarse_drawn_.size(), false);
  unoccluded_leaves();
  PagedReport report;
  report.leaves = std::int64_t(candidates_.count());
  return report;
}

/// Leaves that may cover a sample, and how many pixels those of each page come to.
void PagedEngine::Impl::unoccluded_leaves() {
  constexpr std::uint32_t kPart = 1 << 15;  // leaves at a time
  core::View any_layer = *view_;
  any_layer.layers = ~0u;
  culler_.cull(any_layer, in_view_);
  const core::dvec3& origin = scene_.leaves.origin;
  culling::SampleTest(*view_, origin, samples_).filter(scene_.leaves, in_view_, candidates_, line_leaves_);
  open_.assign(open_.size(), 0);
  culling::set_bits(candidates_, open_);

  const culling::ContributionTest test(*view_, origin, config_.width, config_.height);
  const float whole = float(config_.width) * float(config_.height);
  std::fill(open_count_.begin(), open_count_.end(), 0);
  std::fill(area_.begin(), area_.end(), 0.0f);
  parts_.split(candidates_, kPart);
  for (std::uint32_t part = 0; part < parts_.count(); ++part) {
    test.areas(scene_.leaves, parts_[part], areas_);
    std::uint32_t page = 0;  // leaves of a part rise
    for (const auto& [leaf, area] : areas_) {
      while (leaf >= scene_.leaf_end(page)) ++page;
      ++open_count_[page];
      area_[page] += std::min(area, whole);
    }
  }
  by_area_.clear();
  for (std::uint32_t page = 0; page < scene_.pages.size(); ++page)
    if (open_count_[page] > 0) by_area_.push_back(page);
  std::sort(by_area_.begin(), by_area_.end(), [&](auto a, auto b) { return area_[a] > area_[b]; });
}

/// Draws what is in memory; while the view stays, also what arrives until then.
core::Expected<void> PagedEngine::Impl::refine(double until, bool stays) {
  while (true) {
    if (auto done = store_->take_loaded(context_, report_.frame); !done) return done;
    if (coarse_)
      if (auto done = coarse_->take_loaded(context_, report_.frame); !done) return done;
    if (auto done = draw_resident(); !done) return done;
    keep_within_limit();
    ask_for_pages(stays);
    const double left = until - now_seconds();
    if (!stays || report_.complete || left <= 0.0 || !wait(left)) break;
  }
  report_.pending = 0;
  for (const std::uint32_t page : by_area_) report_.pending += open_count_[page];
  const PageStore::Counts& counts = store_->counts();
  report_.resident = counts.resident;
  report_.loaded = counts.loaded;
  report_.evicted = counts.evicted;
  report_.prefetched = counts.prefetched;
  report_.failed = counts.failed;
  if (coarse_) report_.coarse_resident = coarse_->counts().resident, report_.coarse_loaded = coarse_->counts().loaded;
  report_.memory = process_memory();
  return {};
}

/// Pages with open leaves of which something that is in memory was not drawn, nearest first.
std::vector<std::uint32_t> PagedEngine::Impl::drawable() const {
  const core::dvec4 depth = glm::transpose(view_->eye_from_world())[2];  // larger means nearer
  std::vector<std::pair<double, std::uint32_t>> found;
  std::vector<std::uint32_t> resident(store_->resident().begin(), store_->resident().end());
  if (coarse_)
    for (const std::uint32_t page : coarse_->resident())
      if (!coarse_drawn_[page] && !store_->find(page)) resident.push_back(page);
  for (const std::uint32_t page : resident) {
    if (open_count_[page] == 0) continue;
    const core::Aabb& box = page_boxes_[page];
    double nearest = depth.w;
    for (int axis = 0; axis < 3; ++axis)
      nearest += depth[axis] * (scene_.leaves.origin[axis] + double((depth[axis] > 0.0 ? box.max : box.min)[axis]));
    found.emplace_back(-nearest, page);
  }
  std::sort(found.begin(), found.end());
  std::vector<std::uint32_t> pages;
  for (const auto& [distance, page] : found) pages.push_back(page);
  return pages;
}

/// In passes of more and more items, each behind the depth of the ones before.
core::Expected<void> PagedEngine::Impl::draw_resident() {
  std::uint64_t drawn = 0, pass = kFirstPass;
  const auto read_back = [&] {
    canvas_.read_distances(*view_, distances_);
    pyramid_.build(distances_, config_.width, config_.height);
    report_.items_drawn += std::int64_t(std::exchange(drawn, 0));
  };
  for (const std::uint32_t page : drawable()) {
    const auto items = store_->find(page) ? draw_page(page) : draw_coarse_page(page);
    if (!items) return tl::unexpected(items.error());
    if ((drawn += *items) < pass) continue;
    read_back();
    pass *= 2;
  }
  if (drawn > 0) read_back();
  return {};
}

culling::OcclusionTest PagedEngine::Impl::occlusion_test(const core::dvec3& origin) const {
  return {*view_,         origin,   config_.width,
          config_.height, pyramid_, render::RenderTarget::orthographic_error(*view_),
          samples_.snap};
}

/// Leaves of a page that what is drawn hides need not be drawn.
void PagedEngine::Impl::close_hidden(std::uint32_t page) {
  core::VisibleSet leaves, open;
  for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < scene_.leaf_end(page); ++leaf)
    if (culling::contains(open_, leaf)) culling::append_range(leaf, leaf + 1, leaves.ranges);
  occlusion_test(scene_.leaves.origin).filter(scene_.leaves, leaves, open, line_leaves_);
  close(page, open);
}

/// Closes all leaves of a page, but for these.
void PagedEngine::Impl::close(std::uint32_t page, const core::VisibleSet& but) {
  for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < scene_.leaf_end(page); ++leaf)
    open_[leaf / 64] &= ~(std::uint64_t(1) << leaf % 64);
  culling::set_bits(but, open_);
  open_count_[page] = std::uint32_t(but.count());
}

/// The slots of the open leaves, those of the view's layers.
core::VisibleSet PagedEngine::Impl::slots_of_page(std::uint32_t page, const ResidentPage& resident) const {
  const auto& info = scene_.pages[page];
  const core::ItemBounds& bounds = resident.content->snapshot.bounds();
  core::VisibleSet set;
  set.generation = resident.content->snapshot.generation();
  for (std::uint32_t leaf = info.first_leaf; leaf < scene_.leaf_end(page); ++leaf) {
    if (!culling::contains(open_, leaf)) continue;
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
core::VisibleSet PagedEngine::Impl::shown_slots(std::uint32_t page, const ResidentPage& resident) const {
  const core::ItemBounds& bounds = resident.content->snapshot.bounds();
  core::VisibleSet open = slots_of_page(page, resident), shown;
  culling::SampleTest(*view_, bounds.origin, samples_).filter(bounds, open, shown, resident.lines);
  occlusion_test(bounds.origin).filter(bounds, shown, open, resident.lines);
  return open;
}

/// Returns the number of items drawn.
core::Expected<std::uint64_t> PagedEngine::Impl::draw(ResidentPage& resident, const core::VisibleSet& set,
                                                      const render::RenderTarget& onto) {
  if (set.count() == 0) return 0;
  const core::Snapshot& snapshot = resident.content->snapshot;
  gpuscene::DrawnIn in{&*view_};
  if (resident.level_bytes > 0) in.error = &*image_error_;
  if (auto done = resident.lists.update(snapshot, resident.scene, set, in); !done) return tl::unexpected(done.error());
  if (auto done = renderer_->draw_more(*view_, snapshot, resident.scene, resident.lists, onto); !done)
    return tl::unexpected(done.error());
  return snapshot.count(set);
}

core::Expected<std::uint64_t> PagedEngine::Impl::draw_page(std::uint32_t page) {
  ResidentPage& resident = *store_->find(page);
  resident.used = report_.frame;
  resident.area = area_[page];
  close_hidden(page);
  const auto drawn = draw(resident, shown_slots(page, resident), canvas_);
  if (!drawn) return drawn;
  store_->count_again(page);
  close(page, {});
  return drawn;
}

/// Draws the leaves whose meshes are all drawn as well by their coarsest levels. The others stay open.
core::Expected<std::uint64_t> PagedEngine::Impl::draw_coarse_page(std::uint32_t page) {
  ResidentPage& resident = *coarse_->find(page);
  resident.used = report_.frame;
  resident.area = area_[page];
  coarse_drawn_[page] = true;
  close_hidden(page);
  const core::VisibleSet shown = shown_slots(page, resident);
  const core::Snapshot& snapshot = resident.content->snapshot;
  std::vector<std::uint64_t> fine(culling::bit_words(snapshot.size())), rough = fine;
  culling::set_bits(shown, fine);
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot)
    if (culling::contains(fine, slot) && !is_fine_enough(*resident.content, slot, *image_error_))
      rough[slot / 64] |= (~std::uint64_t(0) >> (64 - core::kBlockSlots))
                          << slot % 64 / core::kBlockSlots * core::kBlockSlots;
  core::VisibleSet set, open;
  const std::uint32_t first = scene_.pages[page].first_leaf;
  for (std::uint32_t leaf = first; leaf < scene_.leaf_end(page); ++leaf)
    if (culling::contains(open_, leaf) && culling::contains(rough, (leaf - first) * core::kBlockSlots))
      culling::append_range(leaf, leaf + 1, open.ranges);
  for (std::size_t word = 0; word < fine.size(); ++word) fine[word] &= ~rough[word];
  to_set(fine, set);
  set.generation = snapshot.generation();
  const auto drawn = draw(resident, set, canvas_);
  if (!drawn) return drawn;
  coarse_->count_again(page);
  close(page, open);
  return drawn;
}

/// The canvas, and what stands in for the rest.
core::Expected<void> PagedEngine::Impl::show() {
  canvas_.copy_to(target_);
  report_.placeholders = report_.coarse_items = 0;
  if (report_.pending > 0) {
    to_set(open_, candidates_);
    if (coarse_)
      if (auto done = show_coarse_pages(); !done) return done;
    if (auto done = placeholders_->draw(scene_, *view_, candidates_, target_); !done) return done;
    report_.placeholders = std::int64_t(placeholders_->drawn());
    if (config_.loading_bar) draw_loading_bar();
  }
  context_.functions().Finish();
  return {};
}

/// Draws open leaves by the coarsest levels of their meshes, and leaves the others as candidates.
core::Expected<void> PagedEngine::Impl::show_coarse_pages() {
  std::vector<std::uint64_t> rest = open_;
  for (const std::uint32_t page : coarse_->resident()) {
    if (open_count_[page] == 0) continue;
    ResidentPage& resident = *coarse_->find(page);
    resident.used = report_.frame;
    resident.area = area_[page];
    const auto drawn = draw(resident, shown_slots(page, resident), target_);
    if (!drawn) return tl::unexpected(drawn.error());
    report_.coarse_items += std::int64_t(*drawn);
    coarse_->count_again(page);
    for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < scene_.leaf_end(page); ++leaf)
      rest[leaf / 64] &= ~(std::uint64_t(1) << leaf % 64);
  }
  to_set(rest, candidates_);
  return {};
}

void PagedEngine::Impl::draw_loading_bar() const {
  const gl::Functions& gl = context_.functions();
  gl::reset_pipeline_state(gl);
  gl.Enable(GL_SCISSOR_TEST);
  const int width = std::max(8, int(kBarShare * float(config_.width))), height = std::max(3, config_.height / 120);
  const float share = 1.0f - float(report_.pending) / float(std::max<std::int64_t>(1, report_.leaves));
  const float ground[4] = {0.15f, 0.15f, 0.17f, 1.0f}, done[4] = {1.0f, 0.6f, 0.1f, 1.0f};
  const GLuint framebuffer = target_.framebuffer().id();
  gl.Scissor(height, height, width, height);
  gl.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, ground);
  gl.Scissor(height, height, int(share * float(width)), height);
  gl.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, done);
  gl.Disable(GL_SCISSOR_TEST);
}

// --- what comes next -------------------------------------------------------------------------------------------------

/// Whether a page has a coarse form, and nothing of it is in memory.
bool PagedEngine::Impl::lacks_coarse(std::uint32_t page) const {
  return coarse_ && scene_.coarse->pages[page].slot_count > 0 && !coarse_->find(page) && !coarse_->failed(page) &&
         !store_->find(page);
}

void PagedEngine::Impl::ask_for_pages(bool stays) {
  std::vector<PageStore::Wanted> wanted, coarse;
  std::size_t left = 0;  // pages that may still have open leaves
  for (const std::uint32_t page : by_area_) {
    if (open_count_[page] == 0) continue;
    by_area_[left++] = page;
    if (store_->failed(page)) continue;
    // Where the coarse form may be enough, it comes first; else it comes to be looked at meanwhile.
    const bool may_do = config_.lod_error > 0.0 && !coarse_drawn_[page];
    const bool of_use = (may_do || !settling_) && lacks_coarse(page);
    if (may_do && of_use ? coarse.size() >= PageStore::kMostAsked : wanted.size() >= PageStore::kMostAsked) continue;
    close_hidden(page);
    if (open_count_[page] == 0) continue;
    if (of_use) coarse.push_back({page, area_[page], true});
    if (!may_do || !of_use) wanted.push_back({page, area_[page], true});
  }
  by_area_.resize(left);
  report_.complete = std::none_of(by_area_.begin(), by_area_.end(),
                                  [&](std::uint32_t page) { return open_count_[page] > 0 && !store_->failed(page); });
  if (!stays && before_) foresee(wanted, coarse);
  store_->ask_for(wanted, report_.frame, stays);
  if (coarse_) coarse_->ask_for(coarse, report_.frame, stays);
}

/// Appends what the view will need when the camera goes on as it does.
void PagedEngine::Impl::foresee(std::vector<PageStore::Wanted>& wanted, std::vector<PageStore::Wanted>& coarse) {
  const auto view = foreseen(*before_, *view_);
  if (!view) return;
  core::View any_layer = *view;
  any_layer.layers = ~0u;
  core::VisibleSet seen, ahead;
  culler_.cull(any_layer, seen);
  culling::SampleTest(*view, scene_.leaves.origin, samples_).filter(scene_.leaves, seen, ahead, line_leaves_);
  const culling::ContributionTest test(*view, scene_.leaves.origin, config_.width, config_.height);
  std::vector<std::uint64_t> bits(open_.size());
  culling::set_bits(ahead, bits);
  std::vector<PageStore::Wanted> later;
  for (std::uint32_t page = 0; page < scene_.pages.size(); ++page) {
    if (store_->find(page)) continue;
    const std::uint32_t end = scene_.leaf_end(page);
    bool any = false;
    for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < end && !any; ++leaf)
      any = culling::contains(bits, leaf);
    if (any) later.push_back({page, test.area(page_boxes_[page]), false});
  }
  std::sort(later.begin(), later.end(), [](const auto& a, const auto& b) { return a.area > b.area; });
  if (config_.lod_error == 0.0) wanted.insert(wanted.end(), later.begin(), later.end());
  std::copy_if(later.begin(), later.end(), std::back_inserter(coarse),
               [&](const auto& w) { return lacks_coarse(w.page); });
}

// --- interface -------------------------------------------------------------------------------------------------------

PagedEngine::PagedEngine(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PagedEngine::PagedEngine(PagedEngine&&) noexcept = default;
PagedEngine& PagedEngine::operator=(PagedEngine&& other) noexcept {
  const gl::CurrentContext kept;
  impl_ = std::move(other.impl_);
  return *this;
}
PagedEngine::~PagedEngine() {
  const gl::CurrentContext kept;
  impl_.reset();
}

core::Expected<PagedEngine> PagedEngine::create(core::PagedScene scene, const PagedConfig& config) {
  const gl::CurrentContext kept;
  return without_throwing([&]() -> core::Expected<PagedEngine> {
    auto impl = Impl::create(std::move(scene), config);
    if (!impl) return tl::unexpected(impl.error());
    return PagedEngine(std::move(*impl));
  });
}

core::Expected<PagedReport> PagedEngine::frame(const core::View& view) {
  return without_throwing([&] { return impl_->frame(view); });
}
bool PagedEngine::wait(double seconds) {
  return impl_->wait(seconds);
}
core::Expected<PagedReport> PagedEngine::settle(const core::View& view, const Progress& progress) {
  return without_throwing([&] { return impl_->settle(view, progress); });
}
std::vector<std::string> PagedEngine::take_errors() {
  return impl_->take_errors();
}
std::vector<std::string> PagedEngine::take_gl_errors() {
  const gl::CurrentContext kept;
  return impl_->take_gl_errors();
}
image::Image PagedEngine::read_colour() const {
  const gl::CurrentContext kept;
  return impl_->image().read_colour();
}
image::IdImage PagedEngine::read_ids() const {
  const gl::CurrentContext kept;
  return impl_->image().read_ids();
}
image::DepthImage PagedEngine::read_depth() const {
  const gl::CurrentContext kept;
  return impl_->image().read_depth(impl_->view());
}
const core::PagedScene& PagedEngine::scene() const {
  return impl_->scene();
}
std::string PagedEngine::renderer() const {
  return impl_->renderer();
}
PagedEngine::Memory PagedEngine::memory() const {
  return impl_->memory();
}

}  // namespace sightline::engine
