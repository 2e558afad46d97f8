#include "sightline/importers/cad/internal/cad_document.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BinTools.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_CheckIterator.hxx>
#include <Interface_Static.hxx>
#include <Message_ProgressScope.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <StepData_StepModel.hxx>
#include <TCollection_AsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDF_Tool.hxx>
#include <TDataStd_Name.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <fmt/format.h>

#include "sightline/importers/cad/internal/cad_text.h"
#include "sightline/importers/cad/internal/iges_placements.h"
#include "sightline/importers/cad/internal/iges_repair.h"
#include "sightline/importers/cad/internal/occt_maths.h"
#include "sightline/importers/cad/internal/step_facts.h"
#include "sightline/importers/cad/internal/step_placements.h"
#include "sightline/importers/cad/internal/step_repair.h"
#include "sightline/importers/cad/internal/step_spheres.h"
#include "sightline/importers/cad/internal/temporary_folder.h"
#include "sightline/importers/cad/internal/tessellated_step.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/internal/side_files.h"
#include "sightline/importers/internal/text_encoding.h"

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;
using Done = core::Expected<void>;
using Labels = std::vector<TDF_Label>;

/// Entities that could not be made into shapes become a warning.
void warn_of_failures(ImportJob& job, const fs::path& file, const Handle(XSControl_WorkSession) & session) {
  const Handle(Transfer_TransientProcess)& process = session->TransferReader()->TransientProcess();
  if (process.IsNull()) return;
  std::uint64_t failed = 0;
  std::string first;
  for (Interface_CheckIterator at = process->CheckList(Standard_False); at.More(); at.Next()) {
    const Handle(Interface_Check) check = at.Value();
    if (check->NbFails() == 0) continue;
    if (failed++ == 0) first = fmt::format("entity {}: {}", at.Number(), check->CFail(1));
  }
  const std::string name = file.filename() == job.file() ? "" : file.filename().string() + ": ";
  if (failed > 0) job.warn(0, fmt::format("{}{} entities could not be read, first {}", name, failed, first));
}

/// Entities of IGES whose parameters make no sense.
void warn_of_damage(ImportJob& job, const Interface_InterfaceModel& model) {
  int damaged = 0, first = 0;
  for (int i = model.NbEntities(); i > 0; --i) {
    if (!model.IsErrorEntity(i)) continue;
    ++damaged;
    first = i;
  }
  if (damaged > 0)
    job.warn(0, fmt::format("{} entities are damaged and not read, the first at D{}", damaged, 2 * first - 1));
}

Labels free_shapes(const CadDocument& document) {
  TDF_LabelSequence shapes;
  XCAFDoc_DocumentTool::ShapeTool(document.handle()->Main())->GetFreeShapes(shapes);
  return {shapes.begin(), shapes.end()};
}

bool is_step_name(const fs::path& name) {
  const std::string extension = lower_case_extension(name);
  return extension == ".stp" || extension == ".step" || extension == ".stpz";
}

fs::path folder_of(const fs::path& file) {
  std::error_code ignored;
  return fs::weakly_canonical(file.has_parent_path() ? file.parent_path() : fs::path("."), ignored);
}

/// Adds what a part says of itself in the file that uses it to what it says in its own.
void merge_attributes(CadDocument& document, const TDF_Label& from, const TDF_Label& into) {
  const core::Scene::Attributes more = document.attributes[entry_of(from)];
  core::Scene::Attributes& all = document.attributes[entry_of(into)];
  for (const auto& added : more)
    if (std::none_of(all.begin(), all.end(), [&](const auto& known) { return known.first == added.first; }))
      all.push_back(added);
}

/// Transfers all that a reader has read. Shapes alone are read without the readers of Open CASCADE that also read names and looks.
template <class CafReader>
bool transfer(CafReader& reader, XSControl_Reader& plain, CadDocument& document,
              const Message_ProgressRange& progress) {
  if (!document.shapes_alone) return reader.Transfer(document.handle(), progress);
  plain.TransferRoots(progress);
  const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document.handle()->Main());
  for (int i = 1; i <= plain.NbShapes(); ++i) shapes->AddShape(plain.Shape(i), Standard_True);
  return plain.NbShapes() > 0;
}

/// Entities that Open CASCADE 7.6 takes otherwise than the standard has them.
void correct_entities(const StepData_StepModel& model) {
  std::vector<Handle(StepShape_FaceSurface)> faces;
  for (int i = 1; i <= model.NbEntities(); ++i) {
    const Handle(Standard_Transient) entity = model.Value(i);
    if (const auto placement = Handle(StepGeom_Axis2Placement3d)::DownCast(entity); !placement.IsNull())
      complete_axes(*placement);
    else if (const auto face = Handle(StepShape_FaceSurface)::DownCast(entity); !face.IsNull())
      faces.push_back(face);
    else if (const auto item = Handle(StepRepr_MappedItem)::DownCast(entity); !item.IsNull())
      order_mapping(*item);
    else if (const auto relation = Handle(StepRepr_ShapeRepresentationRelationshipWithTransformation)::DownCast(entity);
             !relation.IsNull())
      order_transformation(*relation);
  }
  for (const auto& face : faces) turn_sphere(face);
}

/// Reads the STEP files of an assembly into one document.
class StepFiles {
 public:
  StepFiles(ImportJob& job, const fs::path& top, CadDocument& document) : job_(job), top_(top), document_(document) {
    std::error_code ignored;
    open_.insert(fs::weakly_canonical(top, ignored));
  }

  /// The roots of a file. When cancelled, what has been read till then.
  core::Expected<Labels> read(const fs::path& file, const Message_ProgressRange& progress) {
    constexpr int kAlone = 9;  // of ten
    Message_ProgressScope scope(progress, nullptr, kAlone + 1);
    Labels roots;
    auto parts = read_alone(file, scope.Next(kAlone), roots);
    if (!parts) return tl::unexpected(parts.error());
    Message_ProgressScope others(scope.Next(), nullptr, std::max(1.0, double(parts->size())));
    for (const Part& part : *parts) {
      if (others.UserBreak()) break;
      if (auto done = read_part(file, part, others.Next()); !done) return tl::unexpected(done.error());
    }
    return roots;
  }

 private:
  /// A part that is in another file.
  struct Part {
    TDF_Label label;
    std::vector<std::string> names;
  };

  /// A file without its parts in others, which are returned.
  core::Expected<std::vector<Part>> read_alone(const fs::path& file, const Message_ProgressRange& progress,
                                               Labels& roots) {
    auto text = read_cad_text(job_, file);
    if (!text) return tl::unexpected(text.error());
    std::string repaired = repaired_step(job_, *text);
    *text = {};
    TessellatedStep tessellated(job_, repaired);
    std::istringstream stream(std::move(repaired));
    STEPCAFControl_Reader reader;
    reader.SetPropsMode(Standard_False);
    reader.SetGDTMode(Standard_False);
    reader.SetMatMode(Standard_False);
    reader.SetSHUOMode(Standard_True);
    reader.SetViewMode(Standard_False);
    const auto status = reader.ChangeReader().ReadStream(file.c_str(), stream);
    if (status != IFSelect_RetDone)
      return core::fail(
          fmt::format("{}: expected a STEP file (ISO 10303-21), found damage or none", file.filename().string()));
    if (auto checked = check_step_uses(job_, reader); !checked) return tl::unexpected(checked.error());
    const std::vector<ExternalReference> references = take_external_references(reader);
    correct_entities(*reader.ChangeReader().StepModel());
    const StepOperators operators(job_, stream.view(), reader);
    tessellated.bind(reader);
    const Labels before = free_shapes(document_);
    if (!transfer(reader, reader.ChangeReader(), document_, progress) && !progress.UserBreak())
      if (auto told = job_.damage(0, "no part of it could be read"); !told) return tl::unexpected(told.error());
    warn_of_failures(job_, file, reader.Reader().WS());
    operators.note(reader, document_);
    tessellated.note(reader, document_);
    note_step_facts(job_, reader, document_);
    for (const TDF_Label& root : free_shapes(document_))
      if (std::find(before.begin(), before.end(), root) == before.end()) roots.push_back(root);
    std::vector<Part> parts;
    if (document_.shapes_alone) {
      if (!references.empty()) document_.lost_parts.emplace_back("they are left out where shapes are read alone");
      return parts;
    }
    for (const ExternalReference& reference : references)
      if (const TDF_Label label = empty_part(reference, reader, document_); !label.IsNull())
        parts.push_back({label, reference.files});
    return parts;
  }

  Done read_part(const fs::path& user, const Part& part, const Message_ProgressRange& progress) {
    const auto file = find(user, part.names);
    if (!file) return tl::unexpected(file.error());
    if (!*file) return {};
    const fs::path& path = **file;
    if (open_.contains(path))
      return lose(fmt::format("part {} is used within itself", excerpt(path.filename().string())));
    if (!read_.contains(path)) {
      open_.insert(path);
      auto roots = read(path, progress);
      open_.erase(path);
      read_[path] = roots.value_or(Labels());
      if (!roots && !job_.options().lenient && roots.error().message.starts_with(job_.file() + ": "))
        return tl::unexpected(roots.error());
      if (!roots) return lose("part " + roots.error().message);
    }
    const Labels& roots = read_[path];
    if (roots.empty()) return {};
    document_.parts_elsewhere[entry_of(part.label)] = roots;
    if (roots.size() == 1) merge_attributes(document_, part.label, roots[0]);
    return {};
  }

  Done lose(const std::string& what) {
    document_.lost_parts.push_back(what);
    return job_.damage(0, what);
  }

  /// The file of a part; nothing where there is none, which is said.
  core::Expected<std::optional<fs::path>> find(const fs::path& user, const std::vector<std::string>& names) {
    for (const std::string& name : names)
      for (const char* extension : {"", ".stp", ".step"}) {
        if (*extension && fs::path(name).has_extension()) break;
        if (const auto found = find_from(user, name + extension); found && may_be_step(*found)) return *found;
      }
    for (const std::string& name : names)
      for (const auto& [model, path] :
           {std::pair(top_, below_top(user, percent_decoded(name))), std::pair(user, name)}) {
        const auto similar = find_similar_file(model, path);
        if (!similar || !may_be_step(*similar)) continue;
        job_.warn(0,
                  fmt::format("part {} not found; {} is read", excerpt(name), excerpt(similar->filename().string())));
        return *similar;
      }
    const auto step = std::find_if(names.begin(), names.end(), is_step_name);
    if (step != names.end()) {
      const auto found = find_from(user, *step);
      const std::string why = found ? excerpt(*step) + " is no STEP file" : found.error().message;
      if (auto told = lose("part " + why); !told) return tl::unexpected(told.error());
    } else if (!names.empty()) {
      document_.lost_parts.push_back(
          fmt::format("part {} is not read: it is no STEP file, or not there", excerpt(names[0])));
      job_.warn(0, document_.lost_parts.back());
    }
    return std::nullopt;
  }

  /// A name in a file as seen from the top one's folder.
  std::string below_top(const fs::path& user, std::string name) const {
    std::replace(name.begin(), name.end(), '\\', '/');
    return (folder_of(user).lexically_relative(folder_of(top_)) / name).lexically_normal().string();
  }

  /// Looks from the folder of the file that names it and from the top one's, but nowhere outside of that.
  core::Expected<fs::path> find_from(const fs::path& user, const std::string& name) const {
    auto as_written = find_named_file(user, name);
    if (as_written) return as_written;
    for (const std::string& other : {below_top(user, name), name})
      if (auto found = find_named_file(top_, other)) return found;
    return as_written;
  }

  ImportJob& job_;
  const fs::path& top_;
  CadDocument& document_;
  std::set<fs::path> open_;          // files that are being read
  std::map<fs::path, Labels> read_;  // and those that have been, with their roots
};

Done read_step(ImportJob& job, const fs::path& path, CadDocument& document, const Message_ProgressRange& progress) {
  STEPCAFControl_Controller::Init();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  // Open CASCADE crashes at faces and items that it does not know where it reads names of bodies; step_facts.cpp does.
  Interface_Static::SetIVal("read.stepcaf.subshapes.name", 0);
  auto roots = StepFiles(job, path, document).read(path, progress);
  if (!roots) return tl::unexpected(roots.error());
  document.roots = std::move(*roots);
  return {};
}

/// The path of a file for Open CASCADE, which reads IGES from files alone: of the file itself, or of a copy of `text`
/// in the folder.
core::Expected<fs::path> file_of(ImportJob& job, const std::string& text, const fs::path& path,
                                 const TemporaryFolder& folder) {
  const auto repaired = repaired_iges(job, text);
  std::error_code ignored;
  if (!repaired && fs::file_size(path, ignored) == text.size()) return path;
  const fs::path copy = folder.path() / "model.igs";
  std::ofstream file(copy, std::ios::binary);
  file << (repaired ? *repaired : text);
  file.close();
  if (folder.path().empty() || !file) return core::fail(fmt::format("{}: cannot be written", copy.string()));
  return copy;
}

Done read_iges(ImportJob& job, const fs::path& path, CadDocument& document, const Message_ProgressRange& progress) {
  auto text = read_cad_text(job, path);
  if (!text) return tl::unexpected(text.error());
  const TemporaryFolder folder;
  const auto file = file_of(job, *text, path, folder);
  if (!file) return tl::unexpected(file.error());
  IGESControl_Controller::Init();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  IGESCAFControl_Reader reader;
  reader.SetColorMode(Standard_True);
  reader.SetNameMode(Standard_True);
  reader.SetLayerMode(Standard_True);
  if (reader.ReadFile(file->c_str()) != IFSelect_RetDone)
    return core::fail(fmt::format("{}: expected an IGES file, found damage or none", job.file()));
  warn_of_damage(job, *reader.IGESModel());
  prepare_iges_placements(job, reader.IGESModel());
  if (!transfer(reader, reader, document, progress) && !progress.UserBreak())
    if (auto told = job.damage(0, "no part of it could be read"); !told) return told;
  warn_of_failures(job, path, reader.WS());
  document.roots = free_shapes(document);
  const IGESData_GlobalSection& global = reader.IGESModel()->GlobalSection();
  if (!global.UnitName().IsNull()) document.units.emplace_back(global.UnitName()->ToCString());
  if (global.UnitValue() > 0.0) document.metres_per_unit = 1e-3 * global.UnitValue();
  return {};
}

Done read_brep(ImportJob& job, const fs::path& path, CadDocument& document, const Message_ProgressRange& progress) {
  auto text = read_cad_text(job, path);
  if (!text) return tl::unexpected(text.error());
  const std::string begin = text->substr(0, 200);
  std::istringstream stream{std::move(*text)};
  stream.exceptions(std::ios::failbit | std::ios::badbit);  // Open CASCADE would go on for ever at the end
  TopoDS_Shape shape;
  try {
    if (begin.find("Open CASCADE Topology V") != begin.npos)
      BinTools::Read(shape, stream, progress);
    else if (begin.find("CASCADE Topology V") != begin.npos)  // without it, Open CASCADE prints
      BRepTools::Read(shape, stream, BRep_Builder(), progress);
  } catch (const std::ios::failure&) {
    shape.Nullify();
  }
  if (progress.UserBreak()) return {};
  if (shape.IsNull())
    return core::fail(fmt::format("{}: expected a BREP file of Open CASCADE, found damage or none", job.file()));
  XCAFDoc_DocumentTool::ShapeTool(document.handle()->Main())->AddShape(shape, Standard_True);
  document.roots = free_shapes(document);
  return {};
}

}  // namespace

CadDocument::CadDocument() {
  XCAFApp_Application::GetApplication()->NewDocument("BinXCAF", document_);
}

CadDocument::~CadDocument() {
  XCAFApp_Application::GetApplication()->Close(document_);
}

std::string utf8(const TCollection_ExtendedString& text) {
  return TCollection_AsciiString(text).ToCString();
}

std::string name_of(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  return label.FindAttribute(TDataStd_Name::GetID(), name) ? utf8(name->Get()) : "";
}

core::Affine CadDocument::placement(const TopLoc_Location& location) const {
  core::Affine whole;  // the innermost comes first
  for (TopLoc_Location rest = location; !rest.IsIdentity(); rest = rest.NextLocation()) {
    const auto known = placements.find(rest.FirstDatum());
    if (known == placements.end())
      whole = from_occt(rest.FirstDatum()->Transformation().Powered(rest.FirstPower())) * whole;
    else
      whole = (rest.FirstPower() < 0 ? inverse_of(known->second) : known->second) * whole;
  }
  return whole;
}

std::string entry_of(const TDF_Label& label) {
  TCollection_AsciiString entry;
  TDF_Tool::Entry(label, entry);
  return entry.ToCString();
}

Done read_cad_document(ImportJob& job, const fs::path& path, CadDocument& document,
                       const Message_ProgressRange& progress) {
  const std::string extension = lower_case_extension(path);
  if (extension == ".igs" || extension == ".iges") return read_iges(job, path, document, progress);
  if (extension == ".brep") return read_brep(job, path, document, progress);
  return read_step(job, path, document, progress);
}

}  // namespace sightline::importers
