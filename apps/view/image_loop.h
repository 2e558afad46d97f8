// Brings the session's images into the window: at less quality while the view moves, and smooth at rest.
#pragma once

#include <optional>
#include <vector>

#include "sightline/apps/view/messages.h"
#include "sightline/apps/view/motion_resolution.h"
#include "sightline/apps/view/session.h"
#include "sightline/apps/view/shown.h"
#include "sightline/apps/view/window.h"

namespace sightline::apps {

/// Times and counts of one of the last images, for plots.
struct FrameMeasurements {
  double cull_ms, image_ms;  ///< of an image: culling and drawing
  bool on_gpu;               ///< who culled
  std::int64_t visible,
      items_drawn;  ///< items in the view volume, as last known; items drawn, -1 where the GPU alone knows
};

class ImageLoop {
 public:
  /// Options and window must outlive this. `scale`: of text and lines in the window.
  ImageLoop(const ViewerOptions& options, Window& window, double scale);

  /// The configuration of the images; their context and size come later.
  engine::EngineConfig config(const Shown& shown) const;
  Done apply_styles(Session& session, const Shown& shown) const;

  /// Another session is shown from now on, with the switches as they are now.
  Done begin(Session& session, const Shown& shown);
  /// Draws the session's image into that part of the window. `frame_seconds`: what the last frame took.
  Done draw(Session& session, const Shown& shown, double frame_seconds);
  /// The part of the window that has the image.
  void place(const Part& part) { part_ = part; }
  const Part& part() const { return part_; }
  /// A place of the window in the image's pixels, from its upper left corner.
  core::dvec2 in_image(const core::dvec2& cursor) const;
  bool contains(const core::dvec2& cursor) const;

  const std::vector<FrameMeasurements>& history() const { return history_; }  ///< the last one last
  int frames() const { return frames_; }                                      ///< that were drawn
  /// Times of all images, for --json.
  const std::vector<double>& cull_ms() const { return cull_ms_; }
  const std::vector<double>& frame_ms() const { return frame_ms_; }

  double motion_error;  ///< pixels, of meshes while the view moves and Settings::levels is on

 private:
  engine::Looks looks(const Shown& shown) const;
  double error_in_motion(const Shown& shown) const { return shown.levels ? motion_error : 0.0; }
  Done adapt_to_motion(Session& session, const Shown& shown, double frame_seconds);
  Done show(Session& session, const Shown& shown);
  void note_image(const Session& session);

  const ViewerOptions& options_;
  Window& window_;
  engine::Looks looks_;              // with shading, edges and hatching also while these are off
  bool keeps_moving_image_ = false;  // the window shows it until the image at rest is complete
  MotionResolution motion_;
  std::optional<core::View> shown_view_;  // of the last frame
  Part part_;
  std::vector<FrameMeasurements> history_;
  std::vector<double> cull_ms_, frame_ms_;
  int frames_ = 0;
};

}  // namespace sightline::apps
