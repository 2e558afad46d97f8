// Writer of Wavefront OBJ with MTL: what obj_reader.h reads.
//
// What becomes what. Each node with items becomes an object. The object's name joins the names from below the written
// node down to it by "/" ("#k" for the k-th child where it has none). The written node's own items get its name.
// Positions are world coordinates in metres, z up, with as many digits as give the same double back: far coordinates
// stay exact. Meshes are written as triangles, once for each instance; mirrored ones are turned to face outwards.
// Analytic primitives are written as triangles within a chord tolerance, lines as lines. Normals follow where there are
// any. Materials go into an MTL file beside the OBJ file: newmtl, Kd, d; their names are without space and made unique.
// An item without a material after one with a material gets the material "default".
//
// OBJ knows no layers. So items that are hidden, or on no layer but those hidden by default (obstruction and insulation
// volumes), are left out; so are meshes without triangles. Attributes and the hierarchy beyond the names are lost.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::importers {

struct ObjWriteOptions {
  /// Largest distance in metres between an analytic primitive and its triangles; finite and > 0.
  double tolerance = 0.001;
  /// Called like ImportOptions::progress: returning false cancels with kCancelled as the message.
  std::function<bool(double)> progress = {};
};

/// Most segments of a full circle, whatever the tolerance.
inline constexpr int kObjMostSegments = 1024;

struct ObjWriteReport {
  std::array<std::uint64_t, core::kKindCount> items{};  ///< written, by kind
  std::uint64_t left_out = 0;                           ///< items hidden or without triangles
  std::uint64_t vertices = 0, triangles = 0;
  std::uint64_t bytes = 0;  ///< of both files
  /// Largest distance in metres between a written edge and the primitive that it stands for, computed from the normals
  /// at its ends: exact for circles, an estimate to second order elsewhere. Exceeds the tolerance where
  /// kObjMostSegments was the limit.
  double largest_chord_error = 0.0;
};

/// Writes temporary files beside `path` and, if items have materials, beside the same name with ".mtl" (space as '_'),
/// and renames both at the end: on failure or cancellation the old files stay. Fails on a path that cannot be written
/// or ends in ".mtl", on a tolerance that is not > 0, and on more than 2^31 - 1 vertices. Streams: memory is a few
/// bytes per node and material, plus one primitive's triangles.
SIGHTLINE_API core::Expected<ObjWriteReport> write_obj(const core::Scene& scene, core::NodeId node,
                                                       const std::filesystem::path& path,
                                                       const ObjWriteOptions& options = {});

}  // namespace sightline::importers
