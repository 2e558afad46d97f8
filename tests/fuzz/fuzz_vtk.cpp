// VTK files of all kinds, and behind the separator the blocks that a .vtm file names. VTK itself is not instrumented.
#include "sightline/importers/vtk/internal/vtk_file.h"
#include "sightline/importers/vtk/internal/vtk_reader.h"
#include "sightline/tests/fuzz/fuzz_target.h"

namespace {

const char* name_of(std::string_view text) {
  if (text.starts_with("# vtk")) return "fuzz.vtk";
  if (text.find("\"PolyData\"") != text.npos) return "fuzz.vtp";
  return text.find("\"UnstructuredGrid\"") != text.npos ? "fuzz.vtu" : "fuzz.vtm";
}

}  // namespace

/// vtkGeometryFilter of VTK 9.1 leaks its helper, a byte, whenever it is used on a grid.
extern "C" const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "leak:vtkGeometryFilterHelper::CharacterizeUnstructuredGrid";
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const auto bytes = fuzz::bytes_of(data, size);
  constexpr std::size_t kFactor = importers::kVtkMemoryFactor * importers::kVtkDecodedFactor;
  constexpr std::size_t kConstant =
      importers::kVtkMemoryFactor * importers::kVtkDecodedConstant + importers::kVtkMemoryConstant;
  const std::string_view model = fuzz::text_of(data, size);
  fuzz::check_reader(importers::read_vtk, name_of(model.substr(0, model.find(fuzz::kSideFileSeparator))), bytes,
                     {kFactor, kConstant});
  return 0;
}
