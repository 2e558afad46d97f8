#include "sightline/apps/view/revision_slider.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

void RevisionSlider::set(double at, const ChangeList& changes) {
  at_ = std::clamp(at, 0.0, 1.0);
  changes_ = &changes;
}

core::Expected<void> RevisionSlider::end(const std::array<int, 2>& size) {
  auto done = turn_to(Revision::kNewer, size);
  for (const auto& step : {document_.leave_out({}), engine_.forget_image(image_of(Revision::kOlder))})
    if (done) done = step;
  at_.reset();
  return done;
}

core::Expected<void> RevisionSlider::turn_to(Revision revision, const std::array<int, 2>& size) {
  auto done = document_.leave_out(changes_->only_in(other(revision)));
  if (done) done = engine_.use_image(image_of(revision));
  if (!done) return done;
  revision_ = revision;
  const bool fits = engine_.config().width == size[0] && engine_.config().height == size[1];
  return fits ? done : engine_.resize(size[0], size[1]);
}

core::Expected<void> RevisionSlider::turn_to(core::ItemId item, const std::array<int, 2>& size) {
  return at_ && document_.left_out(item) ? turn_to(other(revision_), size) : core::Expected<void>();
}

core::Expected<void> RevisionSlider::turn_to_column(double x, double wide, const std::array<int, 2>& size) {
  if (!at_) return {};
  const Revision there = x < *at_ * wide ? Revision::kOlder : Revision::kNewer;
  return there == revision_ ? core::Expected<void>() : turn_to(there, size);
}

std::vector<ImagePart> RevisionSlider::parts(int wide) const {
  if (!at_) return {{Revision::kNewer, 0, wide}};
  const int split = int(std::lround(*at_ * wide));
  return {{Revision::kOlder, 0, split}, {Revision::kNewer, split, wide}};
}

core::Expected<engine::FrameReport> RevisionSlider::frame(const engine::FrameInput& input,
                                                          const std::array<int, 2>& size) {
  if (!at_) return engine_.frame(input);
  core::Expected<engine::FrameReport> report;
  for (const Revision revision : {revision_, other(revision_)}) {
    if (auto done = turn_to(revision, size); !done) return tl::unexpected(done.error());
    report = engine_.frame(input);
    if (!report || !report->drawn) return report;
  }
  return report;
}

core::Expected<std::uint32_t> RevisionSlider::framebuffer(const ImagePart& part) {
  if (!at_) return engine_.framebuffer();
  if (auto done = engine_.use_image(image_of(part.revision)); !done) return tl::unexpected(done.error());
  const auto framebuffer = engine_.framebuffer();
  const auto back = engine_.use_image(image_of(revision_));
  return back ? framebuffer : tl::unexpected(back.error());
}

core::Expected<image::Image> RevisionSlider::read_image(const std::array<int, 2>& size) {
  if (!at_) return engine_.read_colour();
  image::Image whole;
  for (const ImagePart& part : parts(size[0])) {
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
