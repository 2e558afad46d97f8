// VTK data sets as models, for applications that hold them in memory. Link sightline::importers_vtk. Files (.vtk, .vtp,
// .vtu, .vtm) are read through import_file() and need no VTK header.
//
// What becomes what:
// - vtkPolyData: its polygons and strips, as one mesh item. Any other vtkDataSet: its outer surface, as
//   vtkGeometryFilter makes it, after every cell was checked against the points. Lines and vertices are left out with a
//   warning.
// - Composite data: a node for each block, named by its meta data (vtkCompositeDataSet::NAME) and nested as the blocks
//   are. Pieces of a vtkMultiPieceDataSet or vtkPartitionedDataSet lie on their parent's node. The levels of AMR data
//   are flattened. Blocks that hold the same object share its mesh.
// - Points are read in double and re-centred before they become float. Point normals are kept.
// - Colours are unsigned chars, RGB or RGBA: the active scalars, else an array named Colors, RGB or RGBA in any case.
//   Cell colours split the data set into a mesh per colour, up to 256; with more colours the mean colours the whole.
//   Without them a cell has the mean of its points' colours. Other scalars need a lookup table, which is no part of the data: they give no colour.
// - Strings in field data become attributes of the node, "name" or "name[i]", up to kMaxVtkAttributes of them.
//
// Left out with damage (an error when strict): polygons and cells that refer to missing points, have another number of
// points than their type asks for, or are of a type other than linear, quadratic or polyhedral. Also all cells of a
// grid that crowds them around so few points that finding its surface would take forever.
#pragma once

#include <cstddef>
#include <string_view>

#include "sightline/importers/import.h"

class vtkDataObject;

namespace sightline::importers {

inline constexpr std::size_t kMaxVtkAttributes = 1000;

/// Adds a data object as a new child of `parent`, named `name`. ImportOptions say what its coordinates mean. The data
/// is not modified, and not referred to afterwards. While an import runs, VTK prints no errors and warnings, in any
/// thread. Errors: see above. On any error, and on cancellation, the scene is untouched.
core::Expected<ImportReport> import_vtk(vtkDataObject& data, std::string_view name, core::Scene& scene,
                                        core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
