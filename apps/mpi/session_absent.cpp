// MpiSession in builds without MPI.
#include "sightline/apps/mpi/session.h"

namespace sightline::apps {

core::Expected<MpiSession> MpiSession::begin() {
  return core::fail("--mpi: this build has no MPI (libopenmpi-dev, SIGHTLINE_MPI)");
}

int MpiSession::first_failing(bool good) const {
  return good ? -1 : rank_;
}

void MpiSession::end_if_ranks_lost(int) {}

MpiSession::MpiSession(MpiSession&&) noexcept = default;
MpiSession::~MpiSession() = default;

}  // namespace sightline::apps
