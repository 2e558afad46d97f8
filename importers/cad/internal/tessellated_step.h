// Internal to the importers: tessellated geometry of STEP files (ISO 10303-42 and AP242), which Open CASCADE 7.6 does
// not know: solids, shells and sets of triangulated faces.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Poly_Triangulation.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS_Shape.hxx>
#include <Transfer_TransientProcess.hxx>

#include "sightline/importers/cad/internal/cad_document.h"
#include "sightline/importers/cad/internal/step_model.h"

namespace sightline::importers {

/// The tessellated items of shape representations. Open CASCADE carries them along as items without content, so that
/// products, placements, styles and layers take their usual ways; before its transfer, each gets a shape of faces that
/// have triangles and no surface.
class TessellatedStep {
 public:
  /// Reads all items of a text, and makes it one that Open CASCADE understands. What cannot be read becomes a warning.
  TessellatedStep(ImportJob& job, std::string& text);
  /// Before the transfer.
  void bind(STEPCAFControl_Reader& reader);
  /// After the transfer: names of bodies, and those whose exact form has been read, too.
  void note(STEPCAFControl_Reader& reader, CadDocument& document) const;

 private:
  struct Item {
    Handle(Poly_Triangulation) face;           // of faces
    std::vector<std::uint64_t> children;       // of solids, shells and sets
    std::optional<std::uint64_t> link, place;  // the exact form; the placement within the representation
    TopoDS_Shape shape;
  };
  class Reading;

  TopoDS_Shape bind(std::uint64_t id, double millimetres, const Handle(Transfer_TransientProcess) & process);
  TopLoc_Location location_of(std::uint64_t placement, double millimetres) const;
  bool has_exact_form(const Item& item, const Handle(Transfer_TransientProcess) & process) const;

  std::map<std::uint64_t, Item> items_;
  std::vector<std::uint64_t> tops_;  // items of representations
  StepEntities entities_;
};

}  // namespace sightline::importers
