// Internal to the glTF writer: plant models in the convention of web viewers for industry, the way back of
// gltf_collections.h. gltf_writer.h says what becomes what.
#pragma once

#include "sightline/core/scene.h"
#include "sightline/importers/gltf/gltf_writer.h"
#include "sightline/importers/gltf/internal/gltf_output.h"

namespace sightline::importers {

core::Expected<void> write_collections(const core::Scene& scene, core::NodeId top, const GltfWriteOptions& options,
                                       GltfOutput& output, GltfWriteReport& report);

}  // namespace sightline::importers
