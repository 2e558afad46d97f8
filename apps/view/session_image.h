// The image of an open model: its size, what it is drawn with, and what is known of it.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "sightline/apps/common/mean_image.h"
#include "sightline/apps/view/camera.h"
#include "sightline/apps/view/document.h"
#include "sightline/apps/view/frozen_camera.h"
#include "sightline/apps/view/revision_slider.h"
#include "sightline/apps/view/sections.h"
#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

class SessionImage {
 public:
  static constexpr int kSamples = 8;
  /// Pixels by which the images are shifted whose mean has smooth edges, right and up; between -0.5 and 0.5.
  static const std::vector<core::dvec2>& shifts();

  /// All of it must outlive this. `size`: pixels; `motion_error`: set_motion_error().
  SessionImage(engine::Engine& engine, const Document& document, const Camera& camera, const Sections& sections,
               RevisionSlider& slider, double motion_error);

  /// The view that the image shows now: the camera's, cut by the sections; `shift` as Camera::view() has it.
  core::Expected<core::View> view(const core::dvec2& shift = core::dvec2(0.0)) const;
  /// The view of another camera, of an image of any shape.
  core::Expected<core::View> view_of(const Camera& camera, double aspect,
                                     const core::dvec2& shift = core::dvec2(0.0)) const;
  double aspect() const { return double(size_[0]) / size_[1]; }
  const std::array<int, 2>& size() const { return size_; }
  core::Expected<void> resize(const std::array<int, 2>& size);
  /// Draws half as many pixels each way, or all of them again. Points of the image are those of all its pixels.
  core::Expected<void> set_coarse(bool coarse);
  /// The image may be one of a view that moves, with fewer pixels or by levels of detail.
  bool lowered() const { return coarse_ || engine_.config().losses.lod_error > 0.0; }
  std::array<int, 2> drawn_size() const;  ///< that of the engine's image
  /// Pixels by which meshes may be drawn elsewhere, by levels of detail, while the view moves; 0: none. The levels are
  /// built in the background from Session::begin() or this call on. Nothing where no item has a mesh or a GPU culls.
  core::Expected<void> set_motion_error(double pixels);
  bool has_levels() const;  ///< else that does nothing
  double motion_error() const { return motion_error_; }
  /// Draws meshes by levels of detail from now on, or again in full, and so anew where levels have drawn the image.
  core::Expected<void> set_moving(bool moving);
  /// Engine::configure() with what `change` changes of the settings that hold.
  core::Expected<void> configure(const std::function<void(engine::EngineConfig&)>& change);
  /// Draws in that context from now on, which is current; a former one is lost. All else stays.
  core::Expected<void> use_context(gl::Context& context);

  /// Draws a frame unless it would be the last one again. True where it has drawn.
  core::Expected<bool> draw();
  /// Whether draw() would draw.
  bool stale() const;
  /// Makes the next draw() draw.
  void changed() {
    drawn_.reset();
    resting_.clear();
  }
  /// Draws one more of the images whose mean has smooth edges, or with a budget as much of it as that allows; nothing
  /// once they are complete, while the image is stale, or where multisampling leaves none to draw.
  core::Expected<void> refine();
  bool refining() const {
    return engine_.config().drawing.samples == 1 && !lowered() && !stale() && resting_.count() < kSamples;
  }
  bool begun_refining() const { return resting_.count() > 0; }
  bool partly_refined() const { return begun_refining() && resting_.count() < kSamples; }
  /// That mean; null until it is complete and while something has changed.
  const image::Image* smooth() const { return !stale() && resting_.count() == kSamples ? &mean_ : nullptr; }
  /// That mean, or with `smooth` false or where there is none the last frame's image, with all its pixels.
  core::Expected<image::Image> read(bool smooth);
  /// Draws a line around the item under the cursor, unless it is selected, over a framebuffer that shows the image.
  core::Expected<void> outline_hovered(const gl::ExternalTarget& target);
  const std::optional<core::View>& drawn() const { return drawn_; }  ///< the view of the image
  const engine::FrameReport& report() const { return report_; }
  std::int64_t visible() const { return visible_; }  ///< items in the view volume, as last known

  /// The culling camera that stays where it is; null where it is the image's.
  const FrozenCamera* frozen() const { return frozen_ ? &*frozen_ : nullptr; }
  /// Culls for this view from now on, or again for the camera's.
  void set_frozen(bool frozen);
  /// Tells what the image lost by EngineConfig::losses. Nothing while it is stale, and while frozen().
  std::optional<engine::LossReport> loss();

 private:
  core::Expected<void> resize(const std::array<int, 2>& size, bool coarse);
  core::Expected<engine::FrameReport> frame(const core::View& view, bool at_rest);

  engine::Engine& engine_;
  const Document& document_;
  const Camera& camera_;
  const Sections& sections_;
  RevisionSlider& slider_;
  std::array<int, 2> size_;
  bool coarse_ = false;
  double motion_error_;
  std::optional<core::View> drawn_;
  std::uint64_t drawn_version_ = 0;
  std::optional<FrozenCamera> frozen_;
  std::optional<engine::LossReport> loss_;  // of drawn_, once it was asked for
  MeanImage resting_;
  image::Image mean_;
  engine::FrameReport report_;
  std::int64_t visible_ = 0;
};

}  // namespace sightline::apps
