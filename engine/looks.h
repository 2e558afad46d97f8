// How images look: shading, lines, light and background. Nothing here changes which items an image shows.
#pragma once

#include <cstdint>
#include <string_view>

#include "sightline/core/conventions.h"
#include "sightline/gpuprims/surroundings.h"

namespace sightline::engine {

/// Shading and lines by the depth of the image alone, so that shapes of one colour can be told apart: looks, without
/// any meaning as light. They cost the same for every scene (docs/results/drawing.md), and nothing where both are 0.
/// What is drawn over the image is left as it is: ghosts, blended items, outlines. Dithered items become darker.
struct DepthShading {
  float strength = 0.0f;    ///< 0 … 1: darkness of corners and of what lies behind edges
  float edge_lines = 0.0f;  ///< 0 … 1: darkness of lines where surfaces begin or end, and along creases

  bool any() const { return strength > 0.0f || edge_lines > 0.0f; }
};

/// Lines at 45 degrees on the cut faces of section planes, as in drawings: in the plane of the section, where they lie
/// still while the camera moves. Items whose ids are neighbours differ in the direction or the place of their lines.
/// Costs nothing in views without sections, and where `strength` is 0.
struct Hatching {
  float strength = 0.0f;  ///< 0 … 1: darkness of the lines, lightness on dark faces
  float spacing = 6.0f;   ///< pixels, 2 or more: their least distance; it is up to twice that, and they a sixth wide

  bool any() const { return strength > 0.0f; }
};

enum class EdgeChoice : std::uint8_t {
  kOff,
  kFeature,  ///< rims and corners of primitives, core::MeshEdges::kFeature of meshes
  kAll,      ///< of meshes those of all triangles
};

constexpr std::string_view name_of(EdgeChoice choice) {
  return choice == EdgeChoice::kOff ? "off" : choice == EdgeChoice::kFeature ? "feature" : "all";
}

/// Lines along the edges of items, over the finished image, hidden where its surfaces hide them: to a pixel beyond the
/// outlines of these (render/internal/edge_pass.h). Lines are fainter where they would cover most of an item, and
/// items that are too small for lines have none. Ids, depths and picks are those of the surfaces. Ghosts and blended
/// items have none, nor have images of a budget that lack something, and the outlines of caps in sections. Outlines of
/// round surfaces are no edges: DepthShading::edge_lines draws them.
///
/// Edges of a mesh are found when it first shows: 0.2 us per index, 24 bytes per edge in GPU memory. A frame takes time
/// by the items that show; with one sample per pixel its depth is read back to find these. Costs nothing where `which`
/// is off.
struct Edges {
  EdgeChoice which = EdgeChoice::kOff;
  float width = 1.5f;                      ///< pixels, 0.5 … 32
  core::vec3 colour{0.08f, 0.09f, 0.11f};  ///< sRGB

  bool any() const { return which != EdgeChoice::kOff; }
};

struct Looks {
  DepthShading depth_shading = {};
  Hatching hatching = {};
  Edges edges = {};
  gpuprims::Lighting lighting = gpuprims::Lighting::kHeadLight;
  /// Direction to the light of gpuprims::Lighting::kSun, in the world; any length but 0.
  core::dvec3 sun{0.0, 0.0, 1.0};
  gpuprims::Background background = {};  ///< colours from 0 to 1

  /// Whether a finished image is drawn over.
  bool finish() const { return depth_shading.any() || edges.any(); }

  /// What images for people have: a studio's light, a quiet background, depth shading and light edge lines. The others
  /// are as above.
  static Looks standard() {
    return {.depth_shading = {.strength = 0.4f, .edge_lines = 0.4f},
            .lighting = gpuprims::Lighting::kStudio,
            .background = {.bottom = {0.91f, 0.92f, 0.93f}, .top = {0.73f, 0.78f, 0.85f}}};
  }
};

}  // namespace sightline::engine
