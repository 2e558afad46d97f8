// Internal to the importers: placements of STEP files as ISO 10303-42 defines them, where Open CASCADE 7.6
// departs from it.
#pragma once

#include <string_view>
#include <vector>

#include <STEPCAFControl_Reader.hxx>
#include <StepGeom_Axis2Placement3d.hxx>
#include <StepRepr_MappedItem.hxx>
#include <StepRepr_ShapeRepresentationRelationshipWithTransformation.hxx>

#include "sightline/importers/cad/internal/cad_document.h"

namespace sightline::importers {

/// The default direction of a placement that states none (first_proj_axis of the standard).
void complete_axes(StepGeom_Axis2Placement3d& placement);

/// Before the transfer, of placements by a source and a target: Open CASCADE takes the two in the wrong order, which
/// shows where neither is at the origin.
void order_mapping(StepRepr_MappedItem& item);
void order_transformation(StepRepr_ShapeRepresentationRelationshipWithTransformation& relation);

/// The frame of a placement after complete_axes(), in the unit of its representation.
core::Affine frame_of(const StepGeom_Axis2Placement3d& placement);

/// The CARTESIAN_TRANSFORMATION_OPERATORs of a file, whose scale and mirror no location of Open CASCADE holds. It
/// places by their axes alone, and the document notes which of its locations stand for more.
class StepOperators {
 public:
  /// Before the transfer, with the text that was read. An operator that makes no sense becomes a warning.
  StepOperators(ImportJob& job, std::string_view text, STEPCAFControl_Reader& reader);
  /// After the transfer.
  void note(STEPCAFControl_Reader& reader, CadDocument& document) const;

  /// An entity that becomes a placed shape.
  struct Use {
    Handle(Standard_Transient) entity;
    core::Affine correction;  ///< what the operator does after the location, in millimetres
    bool reversed = false;    ///< the location is the inverse
  };

 private:
  std::vector<Use> uses_;
};

}  // namespace sightline::importers
