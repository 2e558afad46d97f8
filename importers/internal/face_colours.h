// Internal to the importers: meshes whose faces have colours of their own. An item of a scene has one material, so such
// a mesh becomes several items.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {

/// sRGB and alpha, a byte each, red highest. Zero (invisible black) stands for no colour.
using PackedColour = std::uint32_t;
inline constexpr PackedColour kNoColour = 0;

inline PackedColour pack_colour(std::uint32_t red, std::uint32_t green, std::uint32_t blue, std::uint32_t alpha = 255) {
  return red << 24 | green << 16 | blue << 8 | alpha;
}

/// Sum of colours, for their average.
struct ColourSum {
  std::uint64_t channels[4] = {0, 0, 0, 0};
  std::uint64_t count = 0;
  void add(PackedColour colour);
  /// kNoColour when nothing was added. Opaque when all alphas are 0: writers without a use for alpha leave it so.
  PackedColour average() const;
};

/// "#rrggbb", with alpha "#rrggbbaa".
std::string colour_name(PackedColour colour);

/// A material with the colour's name; none for kNoColour.
core::MaterialId add_colour_material(core::Scene& scene, PackedColour colour);

/// More distinct colours than this become their average: the shades of a scan are no parts.
inline constexpr std::size_t kMostFaceColours = 256;

/// Calls visit(polygons, colour) for the faces of each distinct colour, in order of first appearance, each with
/// vertices of its own. Faces of one colour keep their mesh; so does a mesh of too many colours, whose average counts,
/// with a warning. Colours are opaque when all alphas are 0. `colours`: one per face.
void for_each_colour(ImportJob& job, const PolygonMesh& polygons, const std::vector<PackedColour>& colours,
                     const std::function<void(const PolygonMesh&, PackedColour)>& visit);

/// A colour for each face: the mean of its corners' in linear light; of corners without a colour, kNoColour.
/// `of_vertices`: one per position.
std::vector<PackedColour> colours_from_vertices(const PolygonMesh& polygons,
                                                const std::vector<PackedColour>& of_vertices);

/// Adds one item for each call of for_each_colour().
void add_coloured_meshes(ImportJob& job, core::NodeId node, const PolygonMesh& polygons,
                         const std::vector<PackedColour>& colours, std::string_view name);

}  // namespace sightline::importers
