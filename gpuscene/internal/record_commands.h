// How records are drawn without attributes: some vertices each, and many records per command.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/gl/functions.h"
#include "sightline/gpuscene/internal/draw_lists.h"

namespace sightline::gpuscene {

/// Records per command: their vertices must fit 16-bit indices.
inline constexpr std::uint32_t kRecordsPerCommand = 8192;

/// Triangles of a proxy, by its corners: the strips of gpuprims/shaders/proxy.glsl.
inline constexpr std::array<std::uint16_t, 18> kProxyTriangles = {1, 3, 5, 5, 3, 7, 5, 7, 4, 4, 7, 6, 2, 6, 3, 3, 6, 7};

/// A record of a batch without attributes.
struct RecordForm {
  GLenum mode;
  std::uint32_t vertices, indices;  ///< per record
  std::uint32_t first_index;        ///< of a command's first record, in DrawLists::record_indices()
};

/// Lines have two ends. A ray-cast item is a point, which a geometry stage makes a proxy; with
/// Workaround::kNoGeometryStage it is the proxy's triangles. They share corners, so that a vertex is computed seven
/// times for an item and not eighteen.
constexpr RecordForm record_form(BatchKind kind, gl::Workarounds workarounds) {
  if (kind == BatchKind::kLine) return {GL_LINES, 2, 2, 0};
  if (!workarounds[gl::Workaround::kNoGeometryStage]) return {GL_POINTS, 1, 1, 0};
  return {GL_TRIANGLES, 8, std::uint32_t(kProxyTriangles.size()), 2 * kRecordsPerCommand};
}

}  // namespace sightline::gpuscene
