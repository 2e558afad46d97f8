// Shared by the subcommands rays and grids.
#pragma once

#include <cstdio>
#include <string>

#include "sightline/apps/common/model.h"
#include "sightline/apps/study/rays/benchmark.h"
#include "sightline/apps/study/rays/generated_meshes.h"
#include "sightline/core/error.h"

namespace sightline::study::rays {

/// All triangles of a model file, about the middle of their bounds. Analytic primitives become triangles. `options`:
/// how to load, without files.
core::Expected<GeneratedMesh> load_triangles(apps::ModelOptions options, const std::string& file);

/// Makes a context and prints its name. The hook adds to a benchmark the times of the traversals in GLSL. A structure
/// that does not fit the GPU is left out, with a line on stderr.
core::Expected<BenchmarkHook> rays_on_gpu(int passes, std::FILE* out);

}  // namespace sightline::study::rays
