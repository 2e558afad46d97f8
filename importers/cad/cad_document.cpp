#include "sightline/importers/cad/internal/cad_document.h"

#include <sstream>
#include <string_view>

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BinTools.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Static.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <TDF_Tool.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <fmt/format.h>
#include <zip.h>
#include <zlib.h>

#include "sightline/importers/cad/internal/step_facts.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/internal/file_bytes.h"

namespace sightline::importers {
namespace {

using Done = core::Expected<void>;

/// At most this much comes out of a compressed file.
constexpr std::size_t kMostInflated = std::size_t{4} << 30;

core::Expected<std::string> gunzipped(std::string_view bytes) {
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS;
  if (inflateInit2(&stream, kGzip) != Z_OK) return core::fail("cannot be inflated: no memory");
  std::string text;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  int result = Z_OK;
  while (result == Z_OK && text.size() < kMostInflated) {
    const std::size_t before = text.size();
    text.resize(before + (std::size_t{1} << 20));
    stream.next_out = reinterpret_cast<Bytef*>(text.data() + before);
    stream.avail_out = uInt(text.size() - before);
    result = inflate(&stream, Z_NO_FLUSH);
    text.resize(text.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  if (result != Z_STREAM_END) return core::fail("is no whole gzip file");
  return text;
}

core::Expected<std::string> unzipped(std::string_view bytes) {
  zip_error_t error{};
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  zip_t* archive = source ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr;
  if (!archive) {
    zip_source_free(source);
    return core::fail("is no whole zip file");
  }
  std::string text;
  zip_stat_t stat{};
  zip_file_t* file = zip_stat_index(archive, 0, 0, &stat) == 0 ? zip_fopen_index(archive, 0, 0) : nullptr;
  bool whole = file && stat.size <= kMostInflated;
  if (whole) {
    text.resize(stat.size);
    whole = zip_fread(file, text.data(), text.size()) == zip_int64_t(text.size());
  }
  if (file) zip_fclose(file);
  zip_discard(archive);
  if (!whole) return core::fail("is no zip file with one STEP file");
  return text;
}

core::Expected<std::string> text_of_file(const std::filesystem::path& path) {
  const auto bytes = read_file_bytes(path);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  auto inflated = text.starts_with("\x1f\x8b") ? gunzipped(text)
                  : text.starts_with("PK")     ? unzipped(text)
                                               : core::Expected<std::string>(std::string(text));
  if (!inflated) return core::fail(fmt::format("{}: {}", path.filename().string(), inflated.error().message));
  return inflated;
}

/// Entities that could not be made into shapes become a warning.
void warn_of_failures(ImportJob& job, const Handle(XSControl_WorkSession) & session) {
  const Handle(Transfer_TransientProcess)& process = session->TransferReader()->TransientProcess();
  if (process.IsNull()) return;
  std::uint64_t failed = 0;
  std::string first;
  for (Interface_CheckIterator at = process->CheckList(Standard_False); at.More(); at.Next()) {
    const Handle(Interface_Check) check = at.Value();
    if (check->NbFails() == 0) continue;
    if (failed++ == 0) first = fmt::format("entity {}: {}", at.Number(), check->CFail(1));
  }
  if (failed > 0) job.warn(0, fmt::format("{} entities could not be read, first {}", failed, first));
}

Done read_step(ImportJob& job, const std::filesystem::path& path, CadDocument& document,
               const Message_ProgressRange& progress) {
  auto text = text_of_file(path);
  if (!text) return tl::unexpected(text.error());
  STEPCAFControl_Controller::Init();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  Interface_Static::SetIVal("read.stepcaf.subshapes.name", 1);
  STEPCAFControl_Reader reader;
  reader.SetColorMode(Standard_True);
  reader.SetNameMode(Standard_True);
  reader.SetLayerMode(Standard_True);
  reader.SetPropsMode(Standard_False);
  reader.SetGDTMode(Standard_False);
  reader.SetMatMode(Standard_False);
  reader.SetSHUOMode(Standard_True);
  reader.SetViewMode(Standard_False);
  std::istringstream stream(std::move(*text));
  const auto status = reader.ChangeReader().ReadStream(path.c_str(), stream);
  if (status != IFSelect_RetDone)
    return core::fail(fmt::format("{}: expected a STEP file (ISO 10303-21), found damage or none", job.file()));
  if (auto checked = check_step_uses(job, reader); !checked) return checked;
  if (auto found = find_step_parts(job, path, reader); !found) return found;
  if (!reader.Transfer(document.handle(), progress) && !progress.UserBreak())
    if (auto told = job.damage(0, "no part of it could be read"); !told) return told;
  warn_of_failures(job, reader.Reader().WS());
  note_step_facts(reader, document);
  return {};
}

Done read_iges(ImportJob& job, const std::filesystem::path& path, CadDocument& document,
               const Message_ProgressRange& progress) {
  IGESControl_Controller::Init();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  IGESCAFControl_Reader reader;
  reader.SetColorMode(Standard_True);
  reader.SetNameMode(Standard_True);
  reader.SetLayerMode(Standard_True);
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone)
    return core::fail(fmt::format("{}: expected an IGES file, found damage or none", job.file()));
  if (!reader.Transfer(document.handle(), progress) && !progress.UserBreak())
    if (auto told = job.damage(0, "no part of it could be read"); !told) return told;
  warn_of_failures(job, reader.WS());
  const IGESData_GlobalSection& global = reader.IGESModel()->GlobalSection();
  if (!global.UnitName().IsNull()) document.units.emplace_back(global.UnitName()->ToCString());
  if (global.UnitValue() > 0.0) document.metres_per_unit = 1e-3 * global.UnitValue();
  return {};
}

Done read_brep(ImportJob& job, const std::filesystem::path& path, CadDocument& document,
               const Message_ProgressRange& progress) {
  const auto bytes = read_file_bytes(path);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const std::string_view begin = text.substr(0, 200);
  std::istringstream stream{std::string(text)};
  stream.exceptions(std::ios::failbit | std::ios::badbit);  // Open CASCADE would go on for ever at the end
  TopoDS_Shape shape;
  try {
    if (begin.find("Open CASCADE Topology V") != std::string_view::npos)
      BinTools::Read(shape, stream, progress);
    else if (begin.find("CASCADE Topology V") != std::string_view::npos)  // without it, Open CASCADE prints
      BRepTools::Read(shape, stream, BRep_Builder(), progress);
  } catch (const std::ios::failure&) {
    shape.Nullify();
  }
  if (progress.UserBreak()) return {};
  if (shape.IsNull())
    return core::fail(fmt::format("{}: expected a BREP file of Open CASCADE, found damage or none", job.file()));
  XCAFDoc_DocumentTool::ShapeTool(document.handle()->Main())->AddShape(shape, Standard_True);
  return {};
}

}  // namespace

CadDocument::CadDocument() {
  XCAFApp_Application::GetApplication()->NewDocument("BinXCAF", document_);
}

CadDocument::~CadDocument() {
  XCAFApp_Application::GetApplication()->Close(document_);
}

std::string entry_of(const TDF_Label& label) {
  TCollection_AsciiString entry;
  TDF_Tool::Entry(label, entry);
  return entry.ToCString();
}

Done read_cad_document(ImportJob& job, const std::filesystem::path& path, CadDocument& document,
                       const Message_ProgressRange& progress) {
  const std::string extension = lower_case_extension(path);
  if (extension == ".igs" || extension == ".iges") return read_iges(job, path, document, progress);
  if (extension == ".brep") return read_brep(job, path, document, progress);
  return read_step(job, path, document, progress);
}

}  // namespace sightline::importers
