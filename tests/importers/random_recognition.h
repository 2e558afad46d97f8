// Triangle meshes from bytes, for the recognition of primitives: whole and damaged solids beside one another, and raw
// vertices of every sort. For tests with random numbers and for a fuzzer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/mesh.h"

namespace sightline::tests {

struct RecognitionInput {
  core::Mesh mesh;  ///< passes core::validate(); a few thousand triangles at most
  double tolerance = 0.0;
  core::Affine node;                     ///< of the node that the mesh's items lie below
  std::vector<core::Affine> placements;  ///< of these items: turned, mirrored, sheared, flat, very large or small
  unsigned stop_after = 0;               ///< calls of progress
};

RecognitionInput recognition_input(const std::uint8_t* data, std::size_t size);

/// Recognises the mesh by itself. Returns what is not as the headers promise, empty if nothing: the same result twice;
/// a rest that is part of the mesh, in its order; triangles that lie on the primitives that replace them, and
/// primitives that lie on the triangles that they replace, neither larger nor smaller than these.
std::string check_mesh(const RecognitionInput& input);

/// Recognises it in a scene, with the placements. Returns what is wrong with the scene or the report. The scene is
/// committed and built into a snapshot.
std::string check_items(const RecognitionInput& input);

}  // namespace sightline::tests
