// The slider of a comparison: the engine draws both revisions, each in an image of its own, and a part of each is
// shown. Items that only the other revision has are hidden while one is drawn, so that its image is what it would be
// alone.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sightline/apps/view/change_list.h"
#include "sightline/apps/view/document.h"
#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

/// What the image has between two of its columns.
struct ImagePart {
  Revision revision = Revision::kNewer;
  int begin = 0, end = 0;
};

class RevisionSlider {
 public:
  /// Both must outlive this.
  RevisionSlider(engine::Engine& engine, Document& document) : engine_(engine), document_(document) {}

  /// The share of the image's width that is the older revision's; none while it shows the newer one alone.
  const std::optional<double>& at() const { return at_; }
  /// Moves it. The first call begins to draw both revisions of `changes`, which must outlive end().
  void set(double at, const ChangeList& changes);
  /// From now on the newer revision is drawn alone, in that size. All of it is done, whether a step fails or not.
  core::Expected<void> end(const std::array<int, 2>& size);

  /// The parts of an image that is so many pixels wide, from left to right; one without the slider.
  std::vector<ImagePart> parts(int wide) const;
  core::Expected<std::uint32_t> framebuffer(const ImagePart& part);  ///< GL's name; it has all columns
  core::Expected<engine::FrameReport> frame(const engine::FrameInput& input, const std::array<int, 2>& size);
  core::Expected<image::Image> read_image(const std::array<int, 2>& size);
  /// From now on the engine has the items of that revision, and uses its image, of that size.
  core::Expected<void> turn_to(Revision revision, const std::array<int, 2>& size);
  /// Turns to a revision that has the item.
  core::Expected<void> turn_to(core::ItemId item, const std::array<int, 2>& size);
  /// Turns to what is at `x` of an image that is `wide`.
  core::Expected<void> turn_to_column(double x, double wide, const std::array<int, 2>& size);

 private:
  engine::Engine& engine_;
  Document& document_;
  const ChangeList* changes_ = nullptr;
  std::optional<double> at_;
  Revision revision_ = Revision::kNewer;  // that the engine has
};

}  // namespace sightline::apps
