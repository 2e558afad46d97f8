#include "sightline/apps/mpi/session.h"

#include <cstdio>
#include <utility>

#include <mpi.h>

namespace sightline::apps {

core::Expected<MpiSession> MpiSession::begin() {
  if (MPI_Init(nullptr, nullptr) != MPI_SUCCESS) return core::fail("MPI_Init failed");
  // A process that was killed must not take the others down.
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
  MpiSession session(0, 0);
  MPI_Comm_rank(MPI_COMM_WORLD, &session.rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &session.size_);
  return session;
}

int MpiSession::first_failing(bool good) const {
  const int own = good ? size_ : rank_;
  int first = own;
  MPI_Allreduce(&own, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  return first < size_ ? first : -1;
}

void MpiSession::end_if_ranks_lost(int code) {
  if (!ranks_lost_) return;
  std::fflush(nullptr);
  MPI_Abort(MPI_COMM_WORLD, code);
}

MpiSession::MpiSession(MpiSession&& other) noexcept
    : rank_(other.rank_), size_(std::exchange(other.size_, 0)), ranks_lost_(other.ranks_lost_) {}

MpiSession::~MpiSession() {
  if (size_ > 0) MPI_Finalize();
}

}  // namespace sightline::apps
