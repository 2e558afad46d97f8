// A progress bar on stderr; silent when that is no terminal.
#pragma once

#include <string>

namespace sightline::apps {

class Progress {
 public:
  Progress(std::string label, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void advance(std::size_t done);

 private:
  std::string label_;
  std::size_t total_;
  int shown_ = -1;  // per cent on screen
  bool terminal_;
};

}  // namespace sightline::apps
