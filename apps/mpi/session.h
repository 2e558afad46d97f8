// A process as one of those that mpirun has started.
#pragma once

#include "sightline/core/error.h"

namespace sightline::apps {

/// Between MPI_Init and MPI_Finalize, or MPI_Abort where ranks were lost. One at a time, once in a process.
class MpiSession {
 public:
  /// Fails in builds without MPI (SIGHTLINE_MPI), naming that.
  static core::Expected<MpiSession> begin();
  MpiSession(MpiSession&& other) noexcept;
  MpiSession& operator=(MpiSession&&) = delete;
  ~MpiSession();

  int rank() const { return rank_; }  ///< 0 … size() - 1
  int size() const { return size_; }

  /// The lowest rank that calls it with `good` false; -1 where there is none. All ranks must call it. So all can stop
  /// where one must.
  int first_failing(bool good) const;
  /// Tells that ranks were lost. MPI_Finalize might wait for these forever.
  void set_ranks_lost() { ranks_lost_ = true; }
  /// Ends the process with this exit code, and all other ranks, where ranks were lost; else does nothing. All has been
  /// written and said.
  void end_if_ranks_lost(int code);
  /// What the others then fail with, for run() of cli.h.
  static tl::unexpected<core::Error> failed_elsewhere() { return core::fail(""); }
  /// What this rank has, if all ranks have theirs; else its error, on the lowest rank with one, and none on the others.
  template <class T>
  core::Expected<T> agreed(core::Expected<T> own) const {
    const int failing = first_failing(own.has_value());
    if (failing < 0 || failing == rank_) return own;
    return failed_elsewhere();
  }

 private:
  MpiSession(int rank, int size) : rank_(rank), size_(size) {}

  int rank_ = 0, size_ = 0;  // size 0: moved from
  bool ranks_lost_ = false;
};

}  // namespace sightline::apps
