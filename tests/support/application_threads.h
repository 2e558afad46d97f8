// Threads as an application lends them.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "sightline/core/thread_pool.h"

namespace sightline::tests {

/// Three threads, two of which begin with each call.
class ApplicationThreads : public core::JobRunner {
 public:
  int size() const override { return 3; }
  void run(std::uint32_t jobs, const std::function<void(std::uint32_t)>& job) override {
    ++calls;
    std::atomic<std::uint32_t> next{0};
    const auto work = [&] {
      for (std::uint32_t i = next++; i < jobs; i = next++) job(i);
    };
    const std::jthread one(work), two(work);
    work();
  }

  int calls = 0;
};

}  // namespace sightline::tests
