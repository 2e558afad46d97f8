// Internal to the importers: faces that belong to nothing, as IGES files have them, joined to shells and solids.
#pragma once

#include <vector>

#include "sightline/importers/cad/internal/body_mesh.h"

namespace sightline::importers {

struct SewnBody {
  Body body;
  bool solid = false;  ///< closed, and its faces look outwards
};

/// Joins faces along edges that agree within the faces' own tolerance, at least a millionth of their size. A closed
/// shell becomes a solid. Faces keep their styles, and what joins nothing stays as it is.
std::vector<SewnBody> sewn(const Body& loose);

/// A shell as a solid, where it is closed; faces turn outwards.
SewnBody solid_of(const Body& shell);

}  // namespace sightline::importers
