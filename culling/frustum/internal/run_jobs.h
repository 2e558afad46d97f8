// Internal: jobs on helper threads, where there are any.
#pragma once

#include <cstdint>
#include <functional>

#include "sightline/culling/frustum/cull_threads.h"

namespace sightline::culling {

/// CullThreads::run(); null: on this thread alone.
template <class Job>
void run_jobs(CullThreads* threads, std::uint32_t jobs, const Job& job, const std::function<void()>& beside = {}) {
  if (threads) return threads->run(jobs, job, beside);
  if (beside) beside();
  for (std::uint32_t i = 0; i < jobs; ++i) job(i);
}

}  // namespace sightline::culling
