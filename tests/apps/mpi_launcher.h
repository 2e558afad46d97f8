// How tests start the ranks of an MPI run.
#pragma once

#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests {

/// Arguments of env, up to mpirun's own: ranks here, by root, too, more of them than cores, and in containers that let
/// no process read the memory of another. Nor does hwloc look for GPUs of displays, such as those of tests that run
/// beside this one: it ends with a display that ends meanwhile.
inline Args mpirun_here() {
  return {"OMPI_ALLOW_RUN_AS_ROOT=1",
          "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
          "OMPI_MCA_btl_vader_single_copy_mechanism=none",
          "HWLOC_COMPONENTS=-gl",
          "mpirun",
          "--oversubscribe"};
}

}  // namespace sightline::tests
