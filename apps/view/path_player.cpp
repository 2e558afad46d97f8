#include "sightline/apps/view/path_player.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace sightline::apps {
namespace {

bool same(const core::Pose& a, const core::Pose& b) {
  return a.eye == b.eye && a.target == b.target && a.up == b.up;
}

}  // namespace

void PathPlayer::set_path(core::CameraPath path) {
  stop();
  path_ = std::move(path);
}

void PathPlayer::play() {
  assert(path_);
  playing_ = true;
  time_ = path_->begin();
  last_.reset();
  placed_.reset();
}

std::optional<core::CameraSample> PathPlayer::next(double now, const core::Pose& camera) {
  if (playing_ && placed_ && !same(*placed_, camera)) stop();
  if (!playing_) return std::nullopt;
  time_ += std::clamp(speed, kSlowest, kFastest) * (now - std::exchange(last_, now).value_or(now));
  const double length = path_->end() - path_->begin();
  if (loop && length > 0.0)
    time_ = path_->begin() + std::fmod(time_ - path_->begin(), length);
  else
    playing_ = time_ < path_->end();
  const core::CameraSample sample = path_->sample(time_);
  placed_ = sample.pose;
  return sample;
}

std::optional<core::CameraSample> PathPlayer::next_frame(int frame, int frames) {
  if (!playing_) return std::nullopt;
  playing_ = frame + 1 < frames;
  return path_->sample(frames > 1 ? path_->time_of(std::min(frame, frames - 1), frames) : path_->begin());
}

}  // namespace sightline::apps
