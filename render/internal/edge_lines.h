// Lines along the edges of items, as those who draw them take them: EdgePass on a GPU, engine/traced/edges.h by the
// processor.
#pragma once

#include <cstdint>

#include "sightline/core/conventions.h"

namespace sightline::render {

/// In the coordinates of a mesh.
struct EdgeSegment {
  glm::vec3 from, to;
};

/// Edges of an item with a mesh.
struct MeshLines {
  std::uint32_t first = 0, count = 0;  ///< of all segments
  glm::mat4 eye_from_mesh{1.0f};
  float strength = 1.0f;  ///< 0 … 1
};

/// centre + cos(t) u + sin(t) v, 0 <= t <= sweep, in eye space, metres, drawn as `parts` segments.
struct CurvedLine {
  glm::vec3 centre, u, v;
  float sweep, strength;
  std::uint32_t parts;
};

struct LineStyle {
  float width = 1.5f;  ///< pixels
  core::vec3 colour{0.0f};
  /// Pixels by which the image's surfaces may lie before the items' own, as with levels of detail.
  float surface_error = 0.0f;
};

// A point of a line shows unless the surface in the image lies before it by more than a quarter of the width of a pixel
// there, and the error. The surface is compared in the point itself, not where its depth is known: depth is affine on
// planes, so that the differences to a pixel's neighbours carry it there. Of the two neighbours along an axis, which
// may lie on two faces, the one counts that is kinder to the line, if a plane goes on there for another pixel. Of the
// four pixels around the point those that do not hide it count the more the nearer they are. So lines on a surface are not
// stitched, however steep it is, and lines that come to lie behind something fade within a pixel beyond its outline.
//
// A line is as wide on both sides, also beyond the outline of its item. Each pixel is covered by its distance from the
// line, and by the strongest line alone, so that nothing is darker where lines meet. Points that section planes cut
// away do not show.
inline constexpr float kHiddenPixels = 0.25f;  ///< that a surface may lie before a line
/// Points count as in a section plane within this share of their distance from the eye.
inline constexpr float kSectionShare = 8.0f / 16777216.0f;

}  // namespace sightline::render
