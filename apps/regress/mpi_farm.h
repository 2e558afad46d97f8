// The farm over MPI: rank 0 hands tasks out, and every rank, 0 too, draws with one worker process. So a crash in
// drawing costs a process that is no rank, which MPI survives. A rank that is killed itself is given up once it has
// been silent for a while, where the launcher lets the others live (mpirun --enable-recovery).
#pragma once

#include "sightline/apps/mpi/session.h"
#include "sightline/apps/regress/farm.h"

namespace sightline::apps {

/// On rank 0: draws all with the workers of all ranks. `silence`: seconds after which a silent rank is given up, which
/// `session` is told.
core::Expected<void> run_mpi_farm(Farm& farm, Worker& worker, double silence, MpiSession& session);

/// On other ranks: draws what rank 0 hands out, until it says that all is done.
core::Expected<void> serve_mpi_farm(const Suite& suite, Worker& worker);

}  // namespace sightline::apps
