// A progress bar on stderr; silent when stderr is no terminal.
#pragma once

#include <functional>
#include <string>

namespace sightline::apps {

class Progress {
 public:
  explicit Progress(std::string label, std::size_t total = 1000);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void advance(std::size_t done);
  /// Callback for work that reports its share, 0 to 1, and asks whether to go on; the answer is always yes. The bar
  /// must outlive it.
  std::function<bool(double)> callback();

 private:
  std::string label_;
  std::size_t total_;
  int shown_ = -1;  // per cent on screen
  bool terminal_;
};

/// Shows the current step in a line on stderr, which the next call replaces; empty: clears it. Silent when stderr is no
/// terminal.
void show_step(const std::string& what);

}  // namespace sightline::apps
