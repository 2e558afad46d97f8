// A disk that takes no more. Where the system can say how long files may become, SIGHTLINE_HAS_FULL_DISK is defined.
#pragma once

#if __has_include(<sys/resource.h>)
#define SIGHTLINE_HAS_FULL_DISK 1

#include <csignal>
#include <cstdint>

#include <sys/resource.h>

namespace sightline::tests {

/// As long as this lives, no file of this process becomes longer than so many bytes.
class FullDisk {
 public:
  explicit FullDisk(std::uint64_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

}  // namespace sightline::tests
#endif
