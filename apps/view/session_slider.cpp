// The slider of a comparison: a session that draws both revisions, each in an image of the engine's, and shows a part
// of each. Items that only the other revision has are hidden while one is drawn, so that its image is what it would be
// alone.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/apps/view/session.h"

namespace sightline::apps {
namespace {

constexpr Revision other(Revision revision) {
  return revision == Revision::kNewer ? Revision::kOlder : Revision::kNewer;
}

/// The engine's image with a revision.
constexpr std::uint32_t image_of(Revision revision) {
  return revision == Revision::kNewer ? 0 : 1;
}

}  // namespace

core::Expected<void> Session::set_slider(std::optional<double> at) {
  if (!at) return slider_ ? end_slider() : core::Expected<void>();
  if (!slider_)
    if (auto done = begin_slider(); !done) return done;
  slider_ = std::clamp(*at, 0.0, 1.0);
  document_.hover({});  // something else may lie below the cursor now

  // It has other parts, and has left the images of the engine shifted.
  if (resting_.count() > 0) changed();
  return {};
}

core::Expected<void> Session::begin_slider() {
  slider_ = 0.0;
  auto done = edit_scene([&](core::Scene& scene) { return changes_->add_replaced(scene); });
  if (done) done = document_.set_base_styles(changes_->base_styles());
  if (done)
    done = configure([this](engine::EngineConfig& config) {
      slider_budget_ms_ = std::exchange(config.losses.budget_ms, 0.0);  // it would begin anew with each turn_to()
    });
  if (done) return done;
  if (const auto ended = end_slider(); !ended) return ended;
  return done;
}

/// All of it, whether a step fails or not.
core::Expected<void> Session::end_slider() {
  auto done = turn_to(Revision::kNewer);
  const auto also = [&done](const core::Expected<void>& step) {
    if (done) done = step;
  };
  also(document_.leave_out({}));
  also(engine_.forget_image(image_of(Revision::kOlder)));
  slider_.reset();
  also(edit_scene([&](core::Scene& scene) -> core::Expected<void> {
    changes_->take_replaced(scene);
    return {};
  }));
  also(document_.set_base_styles(changes_->base_styles()));
  also(configure([this](engine::EngineConfig& config) { config.losses.budget_ms = slider_budget_ms_; }));
  return done;
}

/// From now on the engine has the items of that revision, and uses its image.
core::Expected<void> Session::turn_to(Revision revision) {
  auto done = document_.leave_out(changes_->only_in(other(revision)));
  if (done) done = engine_.use_image(image_of(revision));
  if (!done) return done;
  revision_ = revision;
  const std::array<int, 2> drawn = drawn_size();
  const bool fits = engine_.config().width == drawn[0] && engine_.config().height == drawn[1];
  return fits ? done : engine_.resize(drawn[0], drawn[1]);
}

core::Expected<void> Session::turn_to(core::ItemId item) {
  return slider_ && document_.left_out(item) ? turn_to(other(revision_)) : core::Expected<void>();
}

core::Expected<void> Session::turn_to_column(double x) {
  if (!slider_) return {};
  const Revision there = x < *slider_ * size_[0] ? Revision::kOlder : Revision::kNewer;
  return there == revision_ ? core::Expected<void>() : turn_to(there);
}

std::vector<Session::ImagePart> Session::parts() const {
  const int wide = drawn_size()[0];
  if (!slider_) return {{Revision::kNewer, 0, wide}};
  const int split = int(std::lround(*slider_ * wide));
  return {{Revision::kOlder, 0, split}, {Revision::kNewer, split, wide}};
}

core::Expected<engine::FrameReport> Session::frame(const core::View& view) {
  const engine::FrameInput input{.view = view, .cull_view = frozen_ ? &frozen_->view() : nullptr};
  if (!slider_) return engine_.frame(input);
  core::Expected<engine::FrameReport> report;
  for (const Revision revision : {revision_, other(revision_)}) {
    if (auto done = turn_to(revision); !done) return tl::unexpected(done.error());
    report = engine_.frame(input);
    if (!report || !report->drawn) return report;
  }
  return report;
}

core::Expected<std::uint32_t> Session::framebuffer(const ImagePart& part) {
  if (!slider_) return engine_.framebuffer();
  if (auto done = engine_.use_image(image_of(part.revision)); !done) return tl::unexpected(done.error());
  const auto framebuffer = engine_.framebuffer();
  const auto back = engine_.use_image(image_of(revision_));
  return back ? framebuffer : tl::unexpected(back.error());
}

core::Expected<image::Image> Session::read_image() {
  if (!slider_) return engine_.read_colour();
  image::Image whole;
  for (const ImagePart& part : parts()) {
    if (auto done = engine_.use_image(image_of(part.revision)); !done) return tl::unexpected(done.error());
    auto image = engine_.read_colour();
    if (!image) return image;
    if (whole.pixels.empty()) whole = *image;
    for (int y = 0; y < whole.height; ++y) {
      const auto row = 3 * std::ptrdiff_t(whole.width) * y;
      std::copy(image->pixels.begin() + row + 3 * part.begin, image->pixels.begin() + row + 3 * part.end,
                whole.pixels.begin() + row + 3 * part.begin);
    }
  }
  const auto back = engine_.use_image(image_of(revision_));
  return back ? core::Expected<image::Image>(std::move(whole)) : tl::unexpected(back.error());
}

}  // namespace sightline::apps
