// PLY and STL.
#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile::polygon_file {
namespace {

constexpr const char* kCounts[] = {"4294967295", "2147483647", "18446744073709551615", "99999999999999999999", "-1"};

std::string ply(const std::string& format, const std::string& elements, const std::string& body) {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n" + body;
}
const std::string kVertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kBinaryVertices(36, '\0');

Case ply_count(std::size_t k) {
  const std::string count = kCounts[k / 5];
  const std::string xyz = "\nproperty float x\nproperty float y\nproperty float z\n";
  std::string text;
  switch (k % 5) {
    case 0:
      text = ply("ascii", "element vertex " + count + xyz, "0 0 0\n");
      break;
    case 1:
      text = ply("binary_little_endian", "element vertex " + count + xyz, kBinaryVertices);
      break;
    case 2:
      text = ply("binary_little_endian",
                 kVertices + "element face " + count + "\nproperty list uchar int vertex_indices\n", kBinaryVertices);
      break;
    case 3:  // an element that takes no bytes
      text = ply("binary_little_endian", kVertices + "element nothing " + count + "\n", kBinaryVertices);
      break;
    default:
      text = ply("ascii", kVertices + "element face 1\nproperty list uint int vertex_indices\n",
                 "0 0 0\n1 0 0\n0 1 0\n" + count + " 0 1 2\n");
      break;
  }
  return {{{"model.ply", text}}};
}

Case ply_list(std::size_t k) {
  const std::string types[] = {"uint", "int", "float", "double"};
  const std::string bytes[] = {"\xff\xff\xff\xff", "\xff\xff\xff\xff", std::string("\x00\x00\x80\x7f", 4),
                               std::string("\x00\x00\x00\x00\x00\x00\xf0\x7f", 8)};
  return {{{"model.ply", ply("binary_little_endian",
                             kVertices + "element face 1\nproperty list " + types[k] + " int vertex_indices\n",
                             kBinaryVertices + bytes[k])}}};
}

/// Elements that take no bytes or hardly any: empty faces, empty lists of an element that nobody knows.
Case ply_swollen(std::size_t k) {
  if (k == 0)
    return {{{"model.ply",
              ply("binary_little_endian", kVertices + "element face 1000000\nproperty list uchar int vertex_indices\n",
                  kBinaryVertices + std::string(1000000, '\0'))}}};
  if (k == 1)
    return {{{"model.ply",
              ply("binary_little_endian", kVertices + repeated("element a 4000000000\n", 1000), kBinaryVertices)}}};
  std::string properties;
  for (int i = 0; i < 20000; ++i) properties += "property uchar p" + std::to_string(i) + "\n";
  return {{{"model.ply", ply("ascii", kVertices + properties, "0 0 0\n")}}};
}

std::string word(std::uint32_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += char(value >> shift & 0xff);
  return bytes;
}

/// Triangles that the file does not hold; 85899346 of them take 4 bytes more than 2^32.
Case stl_count(std::size_t k) {
  constexpr std::uint32_t kTriangles[] = {0xffffffff, 0x7fffffff, 85899346, 2, 0};
  return {{{"model.stl", std::string(80, ' ') + word(kTriangles[k]) + std::string(50, '\0')}}};
}

Case stl_swollen(std::size_t k) {
  const std::string solid = "solid\nendsolid\n", facet = "facet normal 0 0 1\nouter loop\n";
  if (k == 0) return {{{"model.stl", repeated(solid, 100000)}}};
  if (k == 1) return {{{"model.stl", "solid deep\n" + repeated(facet, 100000)}}};
  return {{{"model.stl", "solid " + repeated("a", 1000000)}}};
}

}  // namespace

std::vector<Attack> ply_attacks() {
  return {{"absurd counts", 25, ply_count}, {"absurd list lengths", 4, ply_list}, {"swelling", 3, ply_swollen}};
}

std::vector<Attack> stl_attacks() {
  return {{"absurd counts", 5, stl_count}, {"swelling and nesting", 3, stl_swollen}};
}

}  // namespace sightline::hostile::polygon_file
