// Models as triangles, for what is about rays.
#pragma once

#include <string>

#include "sightline/apps/common/model.h"
#include "sightline/core/error.h"
#include "sightline/study/rays/generated_meshes.h"

namespace sightline::study {

/// All triangles of a model file, about the middle of their bounds. Analytic primitives become triangles. `options`:
/// how to load, without files.
core::Expected<rays::GeneratedMesh> load_triangles(apps::ModelOptions options, const std::string& file);

}  // namespace sightline::study
