// Writer of AVEVA review models (RVM): the way back of rvm_reader.h.
//
// The children of the written node become the file's top groups. The node itself is the file (its "rvm.*" attributes
// become HEAD and MODL). What was read from an RVM file is written so that reading it again gives the same scene:
// parameters, matrices, names, materials, groups and facet polygons bit for bit (facets that were read with
// MeshCopies::kExact or kApart), items in the same order. What RVM has no form for is written as follows:
//   node transforms       baked into item matrices in double, in world coordinates, then rounded to float
//   meshes                facet groups of one triangle per polygon
//   item materials        an unnamed group around items whose material is not their node's
//   items of `node`       a group named after it
//   layers                OBST or INSU when an item is on kLayerObstruction or kLayerInsulation and not on kLayerModel
//   colours               one COLR chunk per colour index; a Material::code two colours share is replaced by a free one
//   alpha                 whole per cent of transparency
// Visibility, other attributes and any number's digits beyond float are lost. Stored boxes are recomputed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::importers {

/// Writes a temporary file beside `path` and renames it at the end: on failure the old file stays. Fails on a path that
/// cannot be written, on more than 4 GiB (offsets are 32 bits), and on an item whose baked matrix is not finite in
/// float. Streams: memory is a few bytes per node, not per item. `progress` works as ImportOptions::progress: returning
/// false cancels with kCancelled as the message.
SIGHTLINE_API core::Expected<void> write_rvm(const core::Scene& scene, core::NodeId node,
                                             const std::filesystem::path& path,
                                             const std::function<bool(double)>& progress = {});

/// Writes into memory.
SIGHTLINE_API core::Expected<std::vector<std::byte>> write_rvm(const core::Scene& scene, core::NodeId node);

}  // namespace sightline::importers
