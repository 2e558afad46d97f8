// OpenMP, with which a build may do without: its pragmas then mean nothing.
#pragma once

#ifdef _OPENMP
#include <omp.h>
#endif

namespace sightline::core {

/// How many threads share a loop: `threads`, or where that is 0, all that OpenMP offers.
inline int team_of([[maybe_unused]] int threads) {
#ifdef _OPENMP
  return threads > 0 ? threads : omp_get_max_threads();
#else
  return 1;
#endif
}

/// Whether this is the thread that began the loop.
inline bool leads_team() {
#ifdef _OPENMP
  return omp_get_thread_num() == 0;
#else
  return true;
#endif
}

}  // namespace sightline::core
