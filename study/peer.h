// Cullers of other libraries, those that this build has (STUDY_OSG, _OCCT, _VTK): the same boxes as items of
// theirs, with nothing drawn and everything off that culls by size or distance.
#pragma once

#include <memory>
#include <span>

#include "sightline/core/aabb.h"
#include "sightline/study/method.h"

namespace sightline::study {

struct Peer {
  const char* name;
  /// Boxes finite and not empty. Needs hundreds of bytes a box. Views must be study::symmetric; of others it keeps
  /// everything.
  std::unique_ptr<Method> (*make)(std::span<const core::Aabb> boxes);
};
std::span<const Peer> peers();

/// CullVisitor over groups of groups (bounding spheres) down to drawables (their boxes); depth ranges not computed.
std::unique_ptr<Method> make_osg(std::span<const core::Aabb> boxes);
/// Graphic3d_Layer over one structure for each box: its own hierarchy, separating axes.
std::unique_ptr<Method> make_occt(std::span<const core::Aabb> boxes);
/// vtkFrustumCoverageCuller over one prop for each box: bounding spheres, no hierarchy.
std::unique_ptr<Method> make_vtk(std::span<const core::Aabb> boxes);

}  // namespace sightline::study
