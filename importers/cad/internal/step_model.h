// Internal to the importers: entities of a STEP file as Open CASCADE has read them.
#pragma once

#include <cstdint>
#include <unordered_map>

#include <Interface_Graph.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <StepGeom_Direction.hxx>
#include <StepRepr_Representation.hxx>

#include "sightline/core/affine.h"

namespace sightline::importers {

using StepEntities = std::unordered_map<std::uint64_t, Handle(Standard_Transient)>;

/// All entities of a file by their numbers.
StepEntities step_entities(STEPCAFControl_Reader& reader);
/// The representation that has an entity as an item, or null.
Handle(StepRepr_Representation)
    representation_of(const Handle(Standard_Transient) & item, const Interface_Graph& graph);
Handle(StepGeom_Direction) step_direction(const core::dvec3& v);
/// The unit of length of a representation; 1 where it states none.
double millimetres_per_unit(const Handle(StepRepr_Representation) & representation);

}  // namespace sightline::importers
