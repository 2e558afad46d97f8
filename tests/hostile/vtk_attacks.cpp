#include "sightline/importers/vtk/internal/vtk_module.h"
#include "sightline/importers/vtk/internal/vtk_reader.h"
#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile {
namespace {

const std::vector<std::string> kVtkCounts = {
    "4294967295",           "9223372036854775807", "99999999999999999999999", "-1",    "1431655766",
    "18446744073709551615", "2147483647",          "4611686018427387904",     "99999", "1e9"};

std::string legacy(const std::string& format, const std::string& body, const std::string& kind = "POLYDATA") {
  return "# vtk DataFile Version 3.0\nhostile\n" + format + "\nDATASET " + kind + "\n" + body;
}
const std::string kVtkPoints = "POINTS 3 float\n0 0 0 1 0 0 0 1 0\n";

/// The body of a legacy file that counts something as `n`.
std::string counted_body(std::size_t kind, const std::string& n) {
  const std::string points = "POINTS 0 float\n";
  const std::string bodies[] = {"POINTS " + n + " float\n0 0 0 1 0 0 0 1 0\n",
                                "POINTS " + n + " double\n" + std::string(24, '\0'),
                                points + "POLYGONS " + n + " 4\n3 0 1 2\n",
                                points + "POLYGONS 1 " + n + "\n3 0 1 2\n",
                                points + "POINT_DATA " + n + "\nVECTORS a float\n1 2 3\n",
                                points + "POINT_DATA 1\nSCALARS a float " + n + "\nLOOKUP_TABLE d\n1 2\n",
                                points + "FIELD f 1\na " + n + " " + n + " string\nx\n",
                                points + "FIELD f " + n + "\n",
                                points + "CELLS 1 4\n3 0 1 2\nCELL_TYPES " + n + "\n5\n"};
  return bodies[kind];
}

Case legacy_count(std::size_t k) {
  constexpr std::size_t kKinds = 9;
  const std::size_t kind = k / 2 % kKinds;
  Case made = one_file("model.vtk", legacy(k % 2 ? "BINARY" : "ASCII", counted_body(kind, kVtkCounts[k / 2 / kKinds]),
                                           kind == 8 ? "UNSTRUCTURED_GRID" : "POLYDATA"));
  made.strict = Expect::kFailure;
  return made;
}

/// Cells of a sound file that claim too many points, or points that are not there.
Case legacy_cell(std::size_t k) {
  const std::string n = kVtkCounts[k / 4];
  const std::string cells[] = {"POLYGONS " + n + " 4\n3 0 1 2\n", "POLYGONS 1 " + n + "\n3 0 1 2\n",
                               "POLYGONS 1 4\n" + n + " 0 1 2\n", "POLYGONS 1 4\n3 0 1 " + n + "\n"};
  Case made = one_file("model.vtk", legacy("ASCII", kVtkPoints + cells[k % 4]));
  made.strict = Expect::kFailure;
  return made;
}

std::string polydata(const std::string& points, const std::string& polys, const std::string& positions,
                     const std::string& attributes = "") {
  return "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" " + attributes +
         "><PolyData><Piece NumberOfPoints=\"" + points + "\" NumberOfPolys=\"" + polys +
         "\"><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" " + positions +
         "</DataArray></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 "
         "2</DataArray>"
         "<DataArray type=\"Int64\" Name=\"offsets\" "
         "format=\"ascii\">3</DataArray></Polys></Piece></PolyData></VTKFile>";
}
const std::string kAscii = "format=\"ascii\">0 0 0 1 0 0 0 1 0";

/// Counts of pieces, and block headers that promise what the blocks cannot hold.
Case xml_count(std::size_t k) {
  const std::string zlib = "compressor=\"vtkZLibDataCompressor\"";
  std::string text;
  if (k == 0)  // 2^32 - 1 blocks
    text = polydata("3", "1", "format=\"binary\">/////wAAAAAAAAAAAAAAAA==", zlib);
  else if (k == 1)  // one block of 2^32 - 1 bytes out of 8
    text = polydata("357913941", "1", "format=\"binary\">AQAAAP////8AAAAACAAAAA==eJxjYAAAAAQAAQ==", zlib);
  else if (k == 2)
    text = polydata("3", "1", "format=\"appended\" offset=\"18446744073709551615\">");
  else if (k % 2)
    text = polydata(kVtkCounts[(k - 3) / 2], "1", kAscii);
  else
    text = polydata("3", kVtkCounts[(k - 3) / 2], kAscii);
  return refused(one_file("model.vtp", text));
}

Case grid_count(std::size_t k) {
  const auto grid = [](const std::string& points, const std::string& cells) {
    return R"(<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints=")" + points +
           R"(" NumberOfCells=")" + cells +
           R"("><Points><DataArray type="Float32">0 0 0 1 0 0 0 1 0</DataArray></Points>
           <Cells><DataArray type="Int64" Name="connectivity">0 1 2</DataArray><DataArray type="Int64" Name="offsets">3
           </DataArray><DataArray type="UInt8" Name="types">5</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>)";
  };
  if (k == 0) return sound(one_file("model.vtu", grid("3", "1")));
  const std::string& n = kVtkCounts[(k - 1) / 2];
  Case made = one_file("model.vtu", k % 2 ? grid(n, "1") : grid("3", n));
  made.strict = Expect::kFailure;
  return made;
}

Case blocks(const std::string& content) {
  return one_file("model.vtm", "<VTKFile type=\"vtkMultiBlockDataSet\"><vtkMultiBlockDataSet>" + content +
                                   "</vtkMultiBlockDataSet></VTKFile>");
}
std::string block(const std::string& file) {
  return "<DataSet file=\"" + file + "\"/>";
}

/// Files of blocks that name themselves, each other, or each two of the next.
Case block_cycle(std::size_t k) {
  Case made = blocks(block("model.vtm"));
  if (k > 0) made = blocks(block("a1.vtm") + block("a1.vtm"));
  const std::size_t last = k == 0 ? 0 : k == 1 ? 1 : 40;
  for (std::size_t i = 1; i <= last; ++i) {
    const std::string next = i == last && k == 1 ? "model.vtm" : "a" + std::to_string(i + 1) + ".vtm";
    made.files.push_back({"a" + std::to_string(i) + ".vtm", blocks(block(next) + block(next)).files[0].content});
  }
  made.strict = Expect::kFailure;
  return made;
}

Case nested_blocks(std::size_t) {
  return refused(blocks(repeated("<Block>", 300000)));
}

Case nested_elements_of_xml(std::size_t) {
  return refused(one_file("model.vtp", repeated("<a>", 500000) + repeated("</a>", 500000)));
}

/// Every strip runs over all points.
Case swollen_strips(std::size_t) {
  const std::string strips = "TRIANGLE_STRIPS 10000 40000\n" + repeated("3 0 1 2\n", 10000);
  return one_file("model.vtk", legacy("ASCII", kVtkPoints + strips));
}

/// Entities of entities, as in the billion laughs.
Case swollen_entities(std::size_t) {
  return refused(one_file("model.vtp", "<!DOCTYPE a [<!ENTITY a \"" + repeated("a", 1000) + "\"><!ENTITY b \"" +
                                           repeated("&a;", 1000) + "\"><!ENTITY c \"" + repeated("&b;", 1000) +
                                           "\">]>" + polydata("3", "1", "format=\"ascii\">&c;")));
}

/// One file, many times.
Case swollen_blocks(std::size_t) {
  Case made = blocks(repeated(block("a.vtp"), 20000));
  made.files.push_back({"a.vtp", polydata("3", "1", kAscii)});
  return made;
}

Case missing_block(std::size_t k) {
  return blocks(block(std::vector<std::string>{"none.vtp", "", ".", "none/none.vtp", "model.xyz"}[k]));
}

Case refused_block(const std::string& file) {
  Case made = damaged(blocks(block(file)));
  made.most_items = 0;
  return made;
}

}  // namespace

std::vector<Target> vtk_targets() {
  const auto of_extension = [](const char* extension, std::vector<Attack> attacks) {
    Target target;
    target.format = "vtk";
    target.extension = extension;
    target.read = importers::read_vtk_by_module;
    // Arrays may be larger than the file: the largest factor is what hostile_table allows.
    target.memory_factor = 10 * importers::kVtkMemoryFactor;
    target.memory_constant = 4 * importers::kVtkMemoryConstant;
    target.mutations = 5000;
    target.attacks = std::move(attacks);
    return target;
  };
  return {of_extension(".vtk", {{"absurd_counts", 2 * 9 * kVtkCounts.size(), legacy_count},
                                {"absurd_cells", 4 * kVtkCounts.size(), legacy_cell},
                                {"swelling", 1, swollen_strips}}),
          of_extension(".vtp", {{"absurd_counts", 3 + 2 * kVtkCounts.size(), xml_count},
                                {"deep_nesting", 1, nested_elements_of_xml},
                                {"swelling", 1, swollen_entities}}),
          of_extension(".vtu", {{"absurd_counts", 1 + 2 * kVtkCounts.size(), grid_count}}),
          of_extension(".vtm", {{"cycles", 3, block_cycle},
                                {"deep_nesting", 1, nested_blocks},
                                {"swelling", 1, swollen_blocks},
                                {"missing_side_files", 5, missing_block},
                                path_traversal(".vtp", polydata("3", "1", kAscii), refused_block)})};
}

}  // namespace sightline::hostile
