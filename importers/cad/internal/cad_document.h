// Internal to the importers: a file of exact surfaces as Open CASCADE's document of parts, in millimetres.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Message_ProgressRange.hxx>
#include <TCollection_ExtendedString.hxx>
#include <TDF_Label.hxx>
#include <TDocStd_Document.hxx>
#include <TopLoc_Datum3D.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS_TShape.hxx>

#include "sightline/core/affine.h"
#include "sightline/core/scene.h"
#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {

/// More parts in parts in assemblies than a model has; an error from there on.
inline constexpr std::size_t kMostNodes = 50'000'000;

/// Names of solids and shells in parts.
using BodyNames = std::unordered_map<const TopoDS_TShape*, std::string>;
/// The layers of a solid or shell, joined by ", ", and whether any of them is visible.
struct BodyLayers {
  std::string names;
  bool visible = false;
};

/// Closes its document when it goes.
class CadDocument {
 public:
  CadDocument();
  ~CadDocument();
  CadDocument(const CadDocument&) = delete;
  CadDocument& operator=(const CadDocument&) = delete;

  const Handle(TDocStd_Document) & handle() const { return document_; }
  Handle(TDocStd_Document) & handle() { return document_; }

  bool shapes_alone = false;                                  ///< what is to be read
  std::vector<TDF_Label> roots;                               ///< parts and assemblies that the file itself has on top
  std::vector<std::string> units;                             ///< of length, as the file names them, each once
  double metres_per_unit = 1e-3;                              ///< of the first of them
  std::uint64_t annotations = 0;                              ///< dimensions, tolerances and notes, which are not read
  std::map<std::string, core::Scene::Attributes> attributes;  ///< of parts, by the entry of their label
  std::map<std::string, std::vector<TDF_Label>> parts_elsewhere;  ///< roots of another file, by the part's entry
  std::vector<std::string> lost_parts;  ///< in other files, which could not be read: why, one by one
  BodyNames body_names;
  std::unordered_map<const TopoDS_TShape*, BodyLayers> body_layers;
  std::set<Handle(TopoDS_TShape)> doubled;  ///< tessellated, and there in their exact form, too
  /// Placements that scale or mirror, which Open CASCADE forbids in locations: by the datum that stands for each.
  std::map<Handle(TopLoc_Datum3D), core::Affine> placements;

  /// The meaning of a location, in millimetres.
  core::Affine placement(const TopLoc_Location& location) const;

 private:
  Handle(TDocStd_Document) document_;
};

std::string utf8(const TCollection_ExtendedString& text);
/// The name of a label; empty: it has none.
std::string name_of(const TDF_Label& label);

/// The entry of a label, such as "0:1:1:2".
std::string entry_of(const TDF_Label& label);

/// Reads STEP (.step, .stp), compressed or not (.stpz: gzip or zip), IGES (.igs, .iges), or BREP (.brep, text or
/// binary). Fails where nothing can be made of the file; smaller damage is `job`'s to judge. Files that an assembly
/// names are looked for as import.h has it. Throws what Open CASCADE throws.
core::Expected<void> read_cad_document(ImportJob& job, const std::filesystem::path& path, CadDocument& document,
                                       const Message_ProgressRange& progress);

}  // namespace sightline::importers
