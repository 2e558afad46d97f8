#include "sightline/engine/paged/paged_engine.h"

#include <algorithm>
#include <new>
#include <system_error>
#include <utility>

#include "sightline/core/internal/clock.h"
#include "sightline/core/internal/platform/memory.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/engine/internal/settings.h"
#include "sightline/engine/paged/internal/page_store.h"
#include "sightline/engine/paged/internal/paged_image.h"
#include "sightline/engine/paged/internal/traced_pages.h"
#include "sightline/gl/internal/current_context.h"
#include "sightline/gl/internal/program_cache.h"
#include "sightline/render/image/image.h"

namespace sightline::engine {
namespace {

constexpr double kBudgetShare = 0.98;   // of the time for a traced image
constexpr int kForeseen = 3;            // the camera's motion is doubled so often: frames ahead
constexpr double kLongestTrial = 10.0;  // seconds
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

/// What is left to drivers and the allocator while they draw: one part in so many of the limit, but not too little.
std::size_t reserve_of(std::size_t limit) {
  return std::max(limit / kReserveShare, kLeastReserve);
}

/// What it takes to read an image and keep it: three bytes a pixel of colours, four each of depths and ids, and four
/// more while one of these is turned upside down.
std::size_t bytes_to_read(const PagedConfig& config) {
  return std::size_t(config.width) * std::size_t(config.height) * std::size_t(3 + 4 + 4 + (config.drawing.ids ? 4 : 0));
}

/// More than drivers are known to take when they draw for the first time.
std::size_t bytes_of_drivers(const PagedConfig& config) {
  return 64 * kMegabyte + 8 * std::size_t(config.width) * std::size_t(config.height);
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

bool traces(const PagedConfig& config) {
  return config.losses.budget_ms > 0.0;
}
void count_tracers(core::PagedScene& scene) {
  for (core::PagedScene::PageInfo& page : scene.pages) page.memory_bytes += PageStore::tracer_bytes(page);
}

std::size_t least_for_pages(const core::PagedScene& scene) {
  return PageStore::largest_page(scene) + (scene.coarse ? PageStore::largest_page(*scene.coarse) : 0);
}

/// That images will still take. `traced`: moving ones; may be null.
std::size_t bytes_of_images(const PagedConfig& config, const TracedPages* traced) {
  const std::size_t moving = traced ? traced->memory_bytes(config.width, config.height) : 0;
  return bytes_to_read(config) + moving - std::min(moving, traced ? traced->memory_bytes() : 0);
}

std::string in_megabytes(std::size_t bytes) {
  return std::to_string((bytes + kMegabyte - 1) / kMegabyte) + " MiB";
}

}  // namespace

class PagedEngine::Impl {
 public:
  static core::Expected<std::unique_ptr<Impl>> create(gl::Context context, core::PagedScene scene,
                                                      const PagedConfig& config);
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
    return image_->target();
  }
  const core::View& view() const { return *shown_; }
  const core::PagedScene& scene() const { return scene_; }
  const std::string& renderer() const { return context_.renderer(); }
  Memory memory() const {
    return coarse_ ? Memory{store_->bytes() + coarse_->bytes(), store_->limit() + coarse_->limit()}
                   : Memory{store_->bytes(), store_->limit()};
  }

 private:
  Impl(core::PagedScene scene, const PagedConfig& config, gl::Context context)
      : context_(std::move(context)), scene_(std::move(scene)), config_(config) {
    if (config_.losses.lod_error == 0.0)
      for (core::PagedScene::PageInfo& page : scene_.pages) page.level_indices = 0;  // nobody reads them
    if (!traces(config_)) return;
    count_tracers(scene_);
    if (!scene_.coarse) return;
    auto coarse = std::make_shared<core::PagedScene>(*scene_.coarse);
    count_tracers(*coarse);
    scene_.coarse = std::move(coarse);
  }
  core::Expected<void> prepare();
  core::Expected<void> warm_up();
  core::Expected<void> draw_trial();
  std::size_t room_for_pages() const;
  void set_limits(std::size_t limit);
  core::Expected<void> make_store();
  void keep_within_limit();

  core::Expected<void> take_context();
  OpenLeaves& leaves() { return image_->leaves(); }
  core::Expected<PagedReport> trace(const core::View& view, double began);
  core::Expected<void> take_loaded(bool upload);
  void count_pages();
  PagesInMemory pages() const { return {*store_, coarse_.get(), report_.frame}; }
  core::Expected<void> refine(double until, bool stays);
  core::Expected<PagedReport> complete(const core::View& view, const Progress& progress);
  core::Expected<void> refine_more();
  void ask_for_pages(bool stays);
  void ask_for_missing();
  bool lacks_coarse(std::uint32_t page) const;
  void foresee(std::vector<PageStore::Wanted>& wanted, std::vector<PageStore::Wanted>& coarse);
  core::Expected<void> show();

  gl::Context context_;  // destroyed last
  core::PagedScene scene_;
  PagedConfig config_;
  std::unique_ptr<PagedImage> image_;
  std::size_t page_limit_ = 0;  // bytes for pages, where drivers take what was foreseen
  std::unique_ptr<PageStore> store_;
  std::unique_ptr<PageStore> coarse_;    // of the coarsest levels; null: there are none
  std::unique_ptr<TracedPages> traced_;  // null: moving images are drawn as others
  std::optional<core::View> shown_;      // of the last frame
  std::optional<core::View> before_;     // of the frame before it that had another
  bool settling_ = false;                // nobody looks at what comes before the image is complete
  std::uint64_t frames_ = 0;
  double after_rays_seconds_ = 0.0;  // what followed the rays of the last traced image
  PagedReport report_;
};

// --- making ----------------------------------------------------------------------------------------------------------

core::Expected<std::unique_ptr<PagedEngine::Impl>> PagedEngine::Impl::create(gl::Context context,
                                                                             core::PagedScene scene,
                                                                             const PagedConfig& config) {
  std::unique_ptr<Impl> impl(new Impl(std::move(scene), config, std::move(context)));
  if (auto done = impl->prepare(); !done) return tl::unexpected(done.error());
  return impl;
}

core::Expected<void> PagedEngine::Impl::prepare() {
  if (auto current = context_.make_current(); !current) return current;
  context_.cache_programs(config_.context.program_cache.value_or(gl::ProgramCache::default_folder()));
  context_.test_driver();
  auto image = PagedImage::create(context_, scene_, config_);
  if (!image) return tl::unexpected(image.error());
  image_ = std::move(*image);
  if (traces(config_))
    if (auto done = core::store(TracedPages::create(scene_, leaves(), config_.threads), traced_); !done) return done;
  if (auto done = warm_up(); !done) return done;
  return make_store();
}

/// What frames take beside pages is taken once before it is measured.
core::Expected<void> PagedEngine::Impl::warm_up() {
  if (auto done = image_->warm_up(); !done) return done;
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
  if (const core::Aabb& box = leaves().page_box(first.page); !box.empty())
    place = {core::dvec3(box.min) + scene_.leaves.origin, core::dvec3(box.max) + scene_.leaves.origin};
  const auto view =
      core::View::fit(place, core::kOverviewDirection, 0.8, double(config_.width) / double(config_.height));
  if (!view) return {};
  if (auto done = image_->begin(*view); !done) return done;
  store_ = std::make_unique<PageStore>(scene_, 0, traces(config_));
  store_->ask_for({&first, 1}, 0, true);
  (void)store_->wait(kLongestTrial);
  store_->take_loaded(0);
  auto done = store_->upload(context_);
  if (done) done = image_->draw_resident(pages());
  report_.pending = leaves().in_view();
  if (done) done = show();
  store_.reset();
  image_->forget();
  return done;
}

/// What the limit leaves; 0 where that is less than a page.
std::size_t PagedEngine::Impl::room_for_pages() const {
  const std::size_t taken =
      core::platform::process_memory() + bytes_of_images(config_, traced_.get()) + reserve_of(config_.memory_limit);
  return config_.memory_limit < taken + least_for_pages(scene_) ? 0 : config_.memory_limit - taken;
}

void PagedEngine::Impl::set_limits(std::size_t limit) {
  if (coarse_) {
    coarse_->set_limit(limit / kCoarseShare);
    limit -= std::min(limit, coarse_->limit());
  }
  store_->set_limit(limit);
}

core::Expected<void> PagedEngine::Impl::make_store() {
  core::platform::give_back_free_memory();
  page_limit_ = room_for_pages();
  if (page_limit_ == 0) {
    const std::size_t used = core::platform::process_memory() + bytes_of_images(config_, traced_.get()),
                      least = least_for_pages(scene_);
    return core::fail(
        "engine: a memory limit of " + in_megabytes(config_.memory_limit) + " is too low: " + in_megabytes(used) +
        " are taken without any page, and the largest page takes " + in_megabytes(least) + "; expected " +
        in_megabytes(std::max((used + least) * kReserveShare / (kReserveShare - 1), used + least + kLeastReserve)) +
        " or more");
  }
  store_ = std::make_unique<PageStore>(scene_, page_limit_, traces(config_));
  if (scene_.coarse) coarse_ = std::make_unique<PageStore>(*scene_.coarse, 0, traces(config_));
  set_limits(page_limit_);
  return {};
}

/// Drivers and the allocator may take more than was foreseen. Then pages get less, until these take less again.
void PagedEngine::Impl::keep_within_limit() {
  const std::size_t most =
      config_.memory_limit - reserve_of(config_.memory_limit) / 2 - bytes_of_images(config_, traced_.get());
  if (core::platform::process_memory() > most) core::platform::give_back_free_memory();
  const std::size_t used = core::platform::process_memory();
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
  const double began = core::now_seconds();
  if (auto ready = take_context(); !ready) return tl::unexpected(ready.error());
  const bool moves = !shown_ || !core::same_image(*shown_, view);
  if (moves) before_ = std::exchange(shown_, view);
  report_ = {};
  report_.frame = frames_++;
  if (moves && traced_ && !settling_) return trace(view, began);
  const bool stays = image_->view() && core::same_image(*image_->view(), view);
  if (!stays)
    if (auto done = image_->begin(view); !done) return tl::unexpected(done.error());
  if (auto done = refine(began + 1e-3 * config_.refine_ms, stays); !done) return tl::unexpected(done.error());
  if (auto done = show(); !done) return tl::unexpected(done.error());
  if (auto ready = take_context(); !ready) return tl::unexpected(ready.error());  // else nothing of this was drawn
  report_.frame_ms = 1e3 * (core::now_seconds() - began);
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

/// Draws more of the image begun, without showing it.
core::Expected<void> PagedEngine::Impl::refine_more() {
  const gl::CurrentContext kept;
  if (auto ready = take_context(); !ready) return ready;
  return refine(core::now_seconds() + 1e-3 * config_.refine_ms, true);
}

/// Draws what is in memory; while the view stays, also what arrives until then.
core::Expected<void> PagedEngine::Impl::refine(double until, bool stays) {
  while (true) {
    if (auto done = take_loaded(true); !done) return done;
    if (auto done = image_->draw_resident(pages()); !done) return done;
    keep_within_limit();
    ask_for_pages(stays);
    const double left = until - core::now_seconds();
    if (!stays || report_.complete || left <= 0.0 || !wait(left)) break;
  }
  report_.leaves = leaves().in_view();
  report_.pending = leaves().count();
  report_.items_drawn = image_->items_drawn();
  count_pages();
  return {};
}

/// Takes pages that were read. To upload them takes longer than a traced image may.
core::Expected<void> PagedEngine::Impl::take_loaded(bool upload) {
  for (PageStore* const store : {store_.get(), coarse_.get()}) {
    if (!store) continue;
    store->take_loaded(report_.frame);
    if (!upload) continue;
    if (auto done = store->upload(context_); !done) return done;
  }
  return {};
}

void PagedEngine::Impl::count_pages() {
  const PageStore::Counts& counts = store_->counts();
  report_.resident = counts.resident;
  report_.loaded = counts.loaded;
  report_.evicted = counts.evicted;
  report_.prefetched = counts.prefetched;
  report_.failed = counts.failed;
  if (coarse_) report_.coarse_resident = coarse_->counts().resident, report_.coarse_loaded = coarse_->counts().loaded;
  report_.memory = core::platform::process_memory();
}

/// The image of a view that has just changed, within the budget.
core::Expected<PagedReport> PagedEngine::Impl::trace(const core::View& view, double began) {
  if (auto done = take_loaded(false); !done) return tl::unexpected(done.error());
  const double deadline = began + kBudgetShare * 1e-3 * config_.losses.budget_ms - after_rays_seconds_;
  const auto counts = traced_->draw(view, config_.drawing.looks, pages(), image_->target(), deadline);
  if (!counts) return tl::unexpected(counts.error());
  const double traced = core::now_seconds();
  if (auto done = image_->complete_traced(view, pages(), 1.0 - counts->boxes); !done)
    return tl::unexpected(done.error());
  keep_within_limit();
  ask_for_missing();
  report_.leaves = report_.pending = counts->leaves;
  report_.coarseness = counts->coarseness;
  report_.earlier = counts->earlier;
  count_pages();
  if (auto ready = take_context(); !ready) return tl::unexpected(ready.error());
  after_rays_seconds_ = core::now_seconds() - traced;
  report_.frame_ms = 1e3 * (core::now_seconds() - began);
  return report_;
}

core::Expected<void> PagedEngine::Impl::show() {
  auto done = image_->show(pages(), report_.pending);
  report_.placeholders = image_->splats();
  report_.coarse_items = image_->coarse_items();
  return done;
}

// --- what comes next -------------------------------------------------------------------------------------------------

/// Whether a page has a coarse form, and nothing of it is in memory.
bool PagedEngine::Impl::lacks_coarse(std::uint32_t page) const {
  return coarse_ && scene_.coarse->pages[page].slot_count > 0 && !coarse_->find(page) && !coarse_->failed(page) &&
         !store_->find(page);
}

/// Asks for what a traced image lacks, and now and then for what will be needed. Pages that it has shown lately stay.
void PagedEngine::Impl::ask_for_missing() {
  constexpr std::uint64_t kUnseen = 30, kLooksAhead = 4;  // frames
  std::vector<PageStore::Wanted> wanted, coarse;
  for (const PageStore::Wanted& page : traced_->missing()) (lacks_coarse(page.page) ? coarse : wanted).push_back(page);
  if (before_ && report_.frame % kLooksAhead == 0 && store_->on_their_way() < PageStore::kMostAsked)
    foresee(wanted, coarse);
  const std::uint64_t since = report_.frame > kUnseen ? report_.frame - kUnseen : 0;
  store_->ask_for(wanted, since, false);
  if (coarse_) coarse_->ask_for(coarse, since, false);
}

void PagedEngine::Impl::ask_for_pages(bool stays) {
  std::vector<PageStore::Wanted> wanted, coarse;
  for (const std::uint32_t page : leaves().list_pages()) {
    if (store_->failed(page)) continue;
    // Where the coarse form may be enough, it comes first; else it comes to be looked at meanwhile.
    const bool may_do = config_.losses.lod_error > 0.0 && !image_->coarse_drawn(page);
    const bool of_use = (may_do || !settling_) && lacks_coarse(page);
    if (may_do && of_use ? coarse.size() >= PageStore::kMostAsked : wanted.size() >= PageStore::kMostAsked) continue;
    image_->close_hidden(page);
    if (leaves().of_page(page) == 0) continue;
    if (of_use) coarse.push_back({page, leaves().area(page), true});
    if (!may_do || !of_use) wanted.push_back({page, leaves().area(page), true});
  }
  report_.complete =
      std::ranges::none_of(leaves().list_pages(), [&](std::uint32_t page) { return !store_->failed(page); });
  if (!stays && before_) foresee(wanted, coarse);
  store_->ask_for(wanted, report_.frame, stays);
  if (coarse_) coarse_->ask_for(coarse, report_.frame, stays);
}

/// Appends what the view will need when the camera goes on as it does.
void PagedEngine::Impl::foresee(std::vector<PageStore::Wanted>& wanted, std::vector<PageStore::Wanted>& coarse) {
  const auto view = foreseen(*before_, *shown_);
  if (!view) return;
  core::VisibleSet ahead;
  leaves().find(*view, ahead);
  const culling::ContributionTest test(*view, scene_.leaves.origin, config_.width, config_.height);
  std::vector<std::uint64_t> bits(culling::bit_words(scene_.leaves.size()));
  culling::set_bits(ahead, bits);
  std::vector<PageStore::Wanted> later;
  for (std::uint32_t page = 0; page < scene_.pages.size(); ++page) {
    if (store_->find(page)) continue;
    const std::uint32_t end = scene_.leaf_end(page);
    bool any = false;
    for (std::uint32_t leaf = scene_.pages[page].first_leaf; leaf < end && !any; ++leaf)
      any = culling::contains(bits, leaf);
    if (any) later.push_back({page, test.area(leaves().page_box(page)), false});
  }
  std::sort(later.begin(), later.end(), [](const auto& a, const auto& b) { return a.area > b.area; });
  if (config_.losses.lod_error == 0.0) wanted.insert(wanted.end(), later.begin(), later.end());
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
  if (auto good = check_ranges(config); !good) return tl::unexpected(good.error());
  const gl::CurrentContext kept;
  gl::ContextOptions options;
  options.platform = config.context.platform;
  options.debug = config.context.gl_debug;
  auto context = gl::Context::create_offscreen(options);
  if (!context) return tl::unexpected(context.error());
  return create_in(std::move(*context), std::move(scene), config);
}

core::Expected<PagedEngine> PagedEngine::create_in(gl::Context context, core::PagedScene scene,
                                                   const PagedConfig& config) {
  const gl::CurrentContext kept;
  return without_throwing([&]() -> core::Expected<PagedEngine> {
    auto impl = Impl::create(std::move(context), std::move(scene), config);
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
