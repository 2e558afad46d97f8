// Internal to the importers: what a STEP file says beside shapes: units, annotations, properties of parts, other files.
#pragma once

#include <string>
#include <vector>

#include <STEPCAFControl_Reader.hxx>
#include <StepBasic_ProductDefinition.hxx>

#include "sightline/importers/cad/internal/cad_document.h"

namespace sightline::importers {

/// A product whose shape may be in another file, and what that may be called, the likeliest first.
struct ExternalReference {
  Handle(StepBasic_ProductDefinition) product;
  std::vector<std::string> files;
};
/// Before the transfer: takes the names of other files from the model, so that Open CASCADE opens none.
std::vector<ExternalReference> take_external_references(STEPCAFControl_Reader& reader);
/// After the transfer: the label of a product without a shape of its own in this file; null for others.
TDF_Label empty_part(const ExternalReference& reference, STEPCAFControl_Reader& reader, const CadDocument& document);

/// Before the transfer, which would walk over each use of a product within a use: fails where there are more than
/// kMostNodes.
core::Expected<void> check_step_uses(ImportJob& job, STEPCAFControl_Reader& reader);

/// After the transfer: units, names of bodies, properties; a warning of what is unknown. Units alone where
/// `document.shapes_alone`.
void note_step_facts(ImportJob& job, STEPCAFControl_Reader& reader, CadDocument& document);

}  // namespace sightline::importers
