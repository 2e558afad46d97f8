#include "sightline/apps/common/progress.h"

#include <cstdio>

#include "sightline/core/internal/platform/console.h"

namespace sightline::apps {

Progress::Progress(std::string label, std::size_t total)
    : label_(std::move(label)), total_(total), terminal_(core::platform::errors_are_on_terminal()) {}

void Progress::advance(std::size_t done) {
  if (!terminal_ || total_ == 0) return;
  const int percent = int(100 * done / total_);
  if (percent == shown_) return;
  shown_ = percent;
  std::string bar(40, '.');
  for (int i = 0; i < 40 * percent / 100; ++i) bar[std::size_t(i)] = '#';
  std::fprintf(stderr, "\r%s [%s] %3d%% ", label_.c_str(), bar.c_str(), percent);
}

std::function<bool(double)> Progress::callback() {
  return [this](double share) {
    advance(std::size_t(share * double(total_)));
    return true;
  };
}

Progress::~Progress() {
  if (shown_ >= 0) std::fprintf(stderr, "\r%*s\r", int(label_.size()) + 50, "");
}

void show_step(const std::string& what) {
  static const bool terminal = core::platform::errors_are_on_terminal();
  if (terminal) std::fprintf(stderr, "\r\033[K%s", what.c_str());
}

}  // namespace sightline::apps
