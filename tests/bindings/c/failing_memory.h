// Allocations that fail on request: this thread's, from a given one on.
#pragma once

namespace sightline::tests {

/// While it lives, this thread's allocations after the first `successes` fail.
class FailingMemory {
 public:
  explicit FailingMemory(int successes);
  ~FailingMemory();
  FailingMemory(const FailingMemory&) = delete;
  FailingMemory& operator=(const FailingMemory&) = delete;

  bool failed() const;  ///< whether any has failed
};

}  // namespace sightline::tests
