// When a view is drawn with less: by levels of detail while it moves, and with fewer pixels where frames then come
// late.
#pragma once

namespace sightline::apps {

class MotionResolution {
 public:
  static constexpr double kLate = 0.04;  ///< seconds that a frame of a moving view may take with all pixels
  static constexpr double kRest = 0.2;   ///< seconds without motion after which all pixels are drawn again

  /// Whether the next frame should have fewer pixels. `moves`: it shows another view than the last one. `now`: seconds,
  /// which do not go back. `last_frame`: seconds that the last frame took.
  bool next(bool moves, double now, double last_frame) {
    if (moves) {
      coarse_ |= moved_ && last_frame > kLate;
      moved_at_ = now;
      moved_ = true;
    } else if (now - moved_at_ >= kRest) {
      coarse_ = moved_ = false;
    }
    return coarse_;
  }
  /// Whether the view moves, or has moved less than kRest before the last next().
  bool moving() const { return moved_; }

 private:
  bool coarse_ = false;
  bool moved_ = false;  // so that the last frame was one of a motion
  double moved_at_ = 0.0;
};

}  // namespace sightline::apps
