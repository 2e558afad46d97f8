#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile::vtk {
namespace {

constexpr const char* kCounts[] = {"4294967295", "9223372036854775807", "99999999999999999999", "-1", "1431655766"};

std::string legacy(const std::string& format, const std::string& body) {
  return "# vtk DataFile Version 3.0\nhostile\n" + format + "\nDATASET POLYDATA\n" + body;
}
const std::string kPoints = "POINTS 3 float\n0 0 0 1 0 0 0 1 0\n";

Case legacy_count(std::size_t k) {
  const std::string count = kCounts[k / 6];
  std::string text;
  switch (k % 6) {
    case 0:
      text = legacy("ASCII", "POINTS " + count + " float\n0 0 0\n");
      break;
    case 1:
      text = legacy("BINARY", "POINTS " + count + " double\n" + std::string(24, '\0'));
      break;
    case 2:
      text = legacy("ASCII", kPoints + "POLYGONS " + count + " 4\n3 0 1 2\n");
      break;
    case 3:
      text = legacy("ASCII", kPoints + "POLYGONS 1 " + count + "\n3 0 1 2\n");
      break;
    case 4:
      text = legacy("ASCII", kPoints + "POLYGONS 1 4\n" + count + " 0 1 2\n");
      break;
    default:
      text = legacy("ASCII", kPoints + "POLYGONS 1 4\n3 0 1 " + count + "\n");
      break;
  }
  return {{{"model.vtk", text}}};
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
  if (k < 5)
    text = polydata(kCounts[k], "1", kAscii);
  else if (k < 10)
    text = polydata("3", kCounts[k - 5], kAscii);
  else if (k == 10)  // 2^32 - 1 blocks
    text = polydata("3", "1", "format=\"binary\">/////wAAAAAAAAAAAAAAAA==", zlib);
  else if (k == 11)  // one block of 2^32 - 1 bytes out of 8
    text = polydata("357913941", "1", "format=\"binary\">AQAAAP////8AAAAACAAAAA==eJxjYAAAAAQAAQ==", zlib);
  else
    text = polydata("3", "1", "format=\"appended\" offset=\"18446744073709551615\">");
  return {{{"model.vtp", text}}};
}

Case blocks(const std::string& content) {
  return {{{"model.vtm", "<VTKFile type=\"vtkMultiBlockDataSet\"><vtkMultiBlockDataSet>" + content +
                             "</vtkMultiBlockDataSet></VTKFile>"}}};
}
std::string block(const std::string& file) {
  return "<DataSet file=\"" + file + "\"/>";
}

/// Files of blocks that name themselves, each other, or each two of the next.
Case cycle(std::size_t k) {
  if (k == 0) return blocks(block("model.vtm"));
  Case made = blocks(block("a1.vtm") + block("a1.vtm"));
  const std::size_t last = k == 1 ? 1 : 40;
  for (std::size_t i = 1; i <= last; ++i) {
    const std::string next = i == last && k == 1 ? "model.vtm" : "a" + std::to_string(i + 1) + ".vtm";
    made.files.push_back({"a" + std::to_string(i) + ".vtm", blocks(block(next) + block(next)).files[0].content});
  }
  return made;
}

Case nested(std::size_t k) {
  if (k == 0) return blocks(repeated("<Block>", 300000));
  return {{{"model.vtp", repeated("<a>", 500000) + repeated("</a>", 500000)}}};
}

Case swollen(std::size_t k) {
  if (k == 0) {  // one file, many times
    Case made = blocks(repeated(block("a.vtp"), 20000));
    made.files.push_back({"a.vtp", polydata("3", "1", kAscii)});
    return made;
  }
  if (k == 1) {  // every strip runs over all points
    std::string strips = "TRIANGLE_STRIPS 10000 40000\n" + repeated("3 0 1 2\n", 10000);
    return {{{"model.vtk", legacy("ASCII", kPoints + strips)}}};
  }
  return {{{"model.vtp", "<!DOCTYPE a [<!ENTITY a \"" + repeated("a", 1000) + "\"><!ENTITY b \"" +
                             repeated("&a;", 1000) + "\"><!ENTITY c \"" + repeated("&b;", 1000) + "\">]>" +
                             polydata("3", "1", "format=\"ascii\">&c;")}}};
}

Case missing(std::size_t k) {
  return blocks(block(std::vector<std::string>{"none.vtp", "", ".", "none/none.vtp", "model.xyz"}[k]));
}

Case traversal(std::size_t k) {
  const std::string outside(kOutside);
  const std::vector<std::string> names = {"../secret.vtp",
                                          outside + "/secret.vtp",
                                          "link.vtp",
                                          "links/secret.vtp",
                                          "none/../../secret.vtp",
                                          "%2e%2e/secret.vtp",
                                          "&#46;&#46;/secret.vtp",
                                          "file://" + outside + "/secret.vtp",
                                          "..\\secret.vtp"};
  Case made = blocks(block(names[k]));
  made.files.push_back({"../secret.vtp", polydata("3", "1", kAscii)});
  made.files.push_back({"link.vtp", {}, "../secret.vtp"});
  made.files.push_back({"links", {}, ".."});
  made.most_items = 0;
  return made;
}

}  // namespace

std::vector<Attack> legacy_attacks() {
  return {{"absurd counts", 30, legacy_count}, {"swelling", 3, swollen}};
}

std::vector<Attack> polygon_attacks() {
  return {{"absurd counts", 13, xml_count}};
}

std::vector<Attack> block_attacks() {
  return {{"cycles", 3, cycle},
          {"deep nesting (to 500,000)", 2, nested},
          {"missing side files", 5, missing},
          {"path traversal", 9, traversal}};
}

}  // namespace sightline::hostile::vtk
