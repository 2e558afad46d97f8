// Internal to the importers: a file of exact surfaces as Open CASCADE's document of parts, in millimetres.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Message_ProgressRange.hxx>
#include <TDF_Label.hxx>
#include <TDocStd_Document.hxx>

#include "sightline/core/scene.h"
#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {

/// More parts in parts in assemblies than a model has; an error from there on.
inline constexpr std::size_t kMostNodes = 50'000'000;

/// Closes its document when it goes.
class CadDocument {
 public:
  CadDocument();
  ~CadDocument();
  CadDocument(const CadDocument&) = delete;
  CadDocument& operator=(const CadDocument&) = delete;

  const Handle(TDocStd_Document) & handle() const { return document_; }
  Handle(TDocStd_Document) & handle() { return document_; }

  std::vector<std::string> units;                             ///< of length, as the file names them, each once
  double metres_per_unit = 1e-3;                              ///< of the first of them
  std::uint64_t annotations = 0;                              ///< dimensions, tolerances and notes, which are not read
  std::map<std::string, core::Scene::Attributes> attributes;  ///< of parts, by the entry of their label

 private:
  Handle(TDocStd_Document) document_;
};

/// The entry of a label, such as "0:1:1:2".
std::string entry_of(const TDF_Label& label);

/// Reads STEP (.step, .stp), compressed or not (.stpz: gzip or zip), IGES (.igs, .iges), or BREP (.brep, text or
/// binary). Fails where nothing can be made of the file; smaller damage is `job`'s to judge. Files that an assembly
/// names are looked for as import.h has it. Throws what Open CASCADE throws.
core::Expected<void> read_cad_document(ImportJob& job, const std::filesystem::path& path, CadDocument& document,
                                       const Message_ProgressRange& progress);

}  // namespace sightline::importers
