#include "sightline/apps/view/session_image.h"

#include <tuple>
#include <utility>

#include "sightline/apps/common/tiled_image.h"

namespace sightline::apps {

SessionImage::SessionImage(engine::Engine& engine, const Document& document, const Camera& camera,
                           const Sections& sections, RevisionSlider& slider, double motion_error)
    : engine_(engine),
      document_(document),
      camera_(camera),
      sections_(sections),
      slider_(slider),
      size_{engine.config().width, engine.config().height},
      motion_error_(motion_error) {}

static_assert(SessionImage::kSamples <= MeanImage::kMost);

const std::vector<core::dvec2>& SessionImage::shifts() {
  static const std::vector<core::dvec2> made = sample_shifts(kSamples);
  return made;
}

core::Expected<void> SessionImage::resize(const std::array<int, 2>& size) {
  return size == size_ ? core::Expected<void>() : resize(size, coarse_);
}

core::Expected<void> SessionImage::set_coarse(bool coarse) {
  return coarse == coarse_ ? core::Expected<void>() : resize(size_, coarse);
}

core::Expected<void> SessionImage::resize(const std::array<int, 2>& size, bool coarse) {
  if (frozen_ && size != size_) frozen_->forget();
  const auto former = std::pair(size_, coarse_);
  std::tie(size_, coarse_) = std::tie(size, coarse);
  const std::array<int, 2> drawn = drawn_size();
  auto done = engine_.resize(drawn[0], drawn[1]);
  if (!done) std::tie(size_, coarse_) = former;
  changed();
  return done;
}

std::array<int, 2> SessionImage::drawn_size() const {
  return coarse_ ? std::array{(size_[0] + 1) / 2, (size_[1] + 1) / 2} : size_;
}

/// Not where they would need another culler: that would cost more than they save.
bool SessionImage::has_levels() const {
  const core::Snapshot& snapshot = engine_.snapshot();
  const bool meshes = !snapshot.of_kind(core::Kind::kMesh).members.empty() ||
                      !snapshot.of_kind(core::Kind::kFacetGroup).members.empty();
  return meshes && !engine_.plan().gpu_culls();
}

core::Expected<void> SessionImage::set_motion_error(double pixels) {
  motion_error_ = pixels;
  return set_moving(true);
}

core::Expected<void> SessionImage::set_moving(bool moving) {
  engine::EngineConfig config = engine_.config();
  const double error = moving && has_levels() ? motion_error_ : 0.0;
  if (config.losses.lod_error == error) return {};
  const auto lost = loss();
  if (!lost || lost->lod_error > error) changed();
  config.losses.lod_error = error;
  return engine_.configure(config);
}

core::Expected<core::View> SessionImage::view(const core::dvec2& shift) const {
  return view_of(camera_, aspect(), shift);
}

core::Expected<core::View> SessionImage::view_of(const Camera& camera, double aspect, const core::dvec2& shift) const {
  auto view = camera.view(aspect, shift);
  if (view) view->sections = sections_.planes();
  return view;
}

bool SessionImage::stale() const {
  const auto seen = view();
  return !drawn_ || report_.pending > 0 || drawn_version_ != document_.version() ||
         (seen && !core::same_image(*seen, *drawn_));
}

core::Expected<bool> SessionImage::draw() {
  if (!stale()) return false;
  const auto seen = view();
  if (!seen) return tl::unexpected(seen.error());
  if (frozen_)
    if (auto done = frozen_->follow(engine_, seen->sections, document_.solid_version()); !done)
      return tl::unexpected(done.error());
  const auto report = frame(*seen, false);
  if (!report) return tl::unexpected(report.error());
  if (!report->drawn) return core::fail("the GL context was lost");
  drawn_ = *seen;
  drawn_version_ = document_.version();
  resting_.clear();
  loss_.reset();
  report_ = *report;
  if (report->visible >= 0) visible_ = report->visible;
  while (const auto late = engine_.take_late_report()) visible_ = late->visible;
  return true;
}

core::Expected<void> SessionImage::refine() {
  if (!refining()) return {};
  const core::dvec2 shift = shifts()[std::size_t(resting_.count())] / core::dvec2(size_[0], size_[1]);
  const auto view = this->view(shift);
  if (!view) return tl::unexpected(view.error());
  const auto report = frame(*view, true);
  if (!report) return tl::unexpected(report.error());
  if (report->pending > 0) return {};
  const auto image = slider_.read_image(drawn_size());
  if (!image) return tl::unexpected(image.error());
  resting_.add(*image);
  if (resting_.count() == kSamples) mean_ = resting_.mean();
  return {};
}

core::Expected<image::Image> SessionImage::read(bool smooth) {
  if (auto done = set_coarse(false); !done) return tl::unexpected(done.error());
  if (auto done = set_moving(false); !done) return tl::unexpected(done.error());
  if (const auto drawn = draw(); !drawn) return tl::unexpected(drawn.error());
  if (const image::Image* mean = smooth ? this->smooth() : nullptr) return *mean;
  return slider_.read_image(drawn_size());
}

core::Expected<void> SessionImage::outline_hovered(const gl::ExternalTarget& target) {
  const std::optional<Taken>& taken = document_.hovered;
  constexpr std::size_t kMost = 2'000;  // each frame draws them once more
  if (!taken || taken->items.size() > kMost || !drawn_ || coarse_ || document_.is(taken->item, Document::kSelected))
    return {};
  if (auto done = slider_.turn_to(taken->item, drawn_size()); !done) return done;
  return engine_.draw_outline(*drawn_, taken->items, target);
}

void SessionImage::set_frozen(bool frozen) {
  frozen_.reset();
  if (frozen && drawn_) frozen_.emplace(*drawn_);
  changed();
}

std::optional<engine::LossReport> SessionImage::loss() {
  if (stale() || frozen_) return std::nullopt;
  if (!loss_)
    if (const auto loss = engine_.loss(*drawn_)) loss_ = *loss;
  return loss_;
}

core::Expected<void> SessionImage::configure(const std::function<void(engine::EngineConfig&)>& change) {
  engine::EngineConfig config = engine_.config();
  change(config);
  auto done = engine_.configure(config);
  changed();
  if (frozen_) frozen_->forget();
  return done;
}

core::Expected<void> SessionImage::use_context(gl::Context& context) {
  changed();
  if (frozen_) frozen_->forget();
  return engine_.use_context(context);
}

core::Expected<engine::FrameReport> SessionImage::frame(const core::View& view, bool at_rest) {
  return slider_.frame({.view = view, .cull_view = frozen_ ? &frozen_->view() : nullptr, .at_rest = at_rest},
                       drawn_size());
}

}  // namespace sightline::apps
