#include "sightline/importers/ply/internal/ply_reader.h"
#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile {
namespace {

std::string ply(const std::string& format, const std::string& elements, const std::string& body) {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n" + body;
}
const std::string kXyz = "\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kVertices = "element vertex 3" + kXyz;
const std::string kBinaryVertices(36, '\0');

Case ply_count(std::size_t k) {
  constexpr const char* kCounts[] = {"4294967295", "2147483647", "18446744073709551615", "99999999999999999999", "-1"};
  const std::string count = kCounts[k / 5], little = "binary_little_endian";
  const std::string faces = kVertices + "element face ";
  const std::string files[] = {
      ply("ascii", "element vertex " + count + kXyz, "0 0 0\n"),
      ply(little, "element vertex " + count + kXyz, kBinaryVertices),
      ply(little, faces + count + "\nproperty list uchar int vertex_indices\n", kBinaryVertices),
      ply(little, kVertices + "element nothing " + count + "\n", kBinaryVertices),  // takes no bytes
      ply("ascii", faces + "1\nproperty list uint int vertex_indices\n", "0 0 0\n1 0 0\n0 1 0\n" + count + " 0 1 2\n")};
  return one_file("model.ply", files[k % 5]);
}

Case ply_list(std::size_t k) {
  const std::string types[] = {"uint", "int", "float", "double"};
  const std::string bytes[] = {"\xff\xff\xff\xff", "\xff\xff\xff\xff", std::string("\x00\x00\x80\x7f", 4),
                               std::string("\x00\x00\x00\x00\x00\x00\xf0\x7f", 8)};
  return damaged(one_file(
      "model.ply",
      ply("binary_little_endian", kVertices + "element face 1\nproperty list " + types[k] + " int vertex_indices\n",
          kBinaryVertices + bytes[k])));
}

/// Elements that take no bytes or hardly any: empty faces, empty lists of an element that nobody knows.
Case ply_swollen(std::size_t k) {
  const std::string little = "binary_little_endian";
  if (k == 0)
    return one_file("model.ply",
                    ply(little, kVertices + "element face 1000000\nproperty list uchar int vertex_indices\n",
                        kBinaryVertices + std::string(1000000, '\0')));
  if (k == 1)
    return one_file("model.ply", ply(little, kVertices + repeated("element a 4000000000\n", 1000), kBinaryVertices));
  std::string properties;
  for (int i = 0; i < 20000; ++i) properties += "property uchar p" + std::to_string(i) + "\n";
  return one_file("model.ply", ply("ascii", kVertices + properties, "0 0 0\n"));
}

/// The most memory for their bytes: vertices, faces, strips, headers.
Case ply_worst(std::size_t k) {
  constexpr std::size_t kMany = 400000;
  const std::string little = "binary_little_endian", many = "element vertex " + std::to_string(kMany) + "\n";
  const std::string bytes = "property uchar x\nproperty uchar y\nproperty uchar z\n";
  const std::string list = "property list uchar uchar vertex_indices\n", corners("\0\0\0\1\0\0\0\1\0", 9);
  const std::string colours = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const auto faces = [&](std::size_t n) {
    return "element vertex 3\n" + bytes + "element face " + std::to_string(n) + "\n" + list;
  };
  const std::string triangles = corners + repeated(std::string("\3\0\1\2", 4), kMany);
  const std::vector<std::function<std::string()>> files = {
      [&] { return ply(little, many + bytes, std::string(3 * kMany, '\1')); },
      [&] { return ply("ascii", many + bytes, repeated("1 2 3\n", kMany)); },
      [&] { return ply(little, faces(kMany), triangles); },
      [&] { return ply(little, faces(kMany) + colours, triangles); },
      [&] { return ply(little, faces(4 * kMany), std::string(9 + 4 * kMany, '\0')); },
      [&] {
        return ply(little,
                   "element vertex 3\n" + bytes +
                       "element tristrips 1\nproperty list uint uchar "
                       "vertex_indices\n",
                   corners + std::string("\0\0\x40\0", 4) + repeated(std::string("\0\1\2\1", 4), 1 << 20));
      },
      [&] { return "ply\nformat binary_little_endian 1.0\n" + repeated("element a 1\n", kMany); },
      [&] { return ply(little, "element a 1\n" + repeated("property char a\n", kMany), ""); },
      [&] { return ply("ascii", many + bytes + "element face 1\n" + list, repeated("x y z ", kMany)); },
  };
  return one_file("model.ply", files[k]());
}

/// Lines that hold more, less or other than the header says, in masses.
Case ply_lines(std::size_t k) {
  constexpr std::size_t kMany = 100000;
  const std::string many = std::to_string(kMany), xyz = kXyz, list = "property list uint int vertex_indices\n";
  const std::string normals = "property float nx\nproperty float ny\nproperty float nz\n";
  const std::string faces = kVertices + "element face " + many + "\n" + list, corners = "0 0 0\n1 0 0\n0 1 0\n";
  const std::string files[] = {
      ply("ascii", faces, corners + repeated("1000 0 1 2\n", kMany)),
      ply("ascii", faces, corners + repeated("3 0\n1 2\n", kMany)),
      ply("ascii", faces, corners + repeated("\n", 10 * kMany) + "3 0 1 2\n"),
      ply("ascii", faces, corners + repeated("comment\n# 3 0 1 2\n", kMany)),
      ply("ascii", faces, corners + repeated("3 0 1 2 ", kMany)),
      ply("ascii", faces, corners + repeated("x y z\n", kMany)),
      ply("ascii", "element vertex " + many + xyz, repeated("x y z\n1 y z\n", kMany)),
      ply("ascii", "element vertex " + many + xyz + normals + "element face " + many + "\n" + list,
          repeated("1 2 3 nan nan nan\n", kMany) + repeated("3 0 1 2\n", kMany)),
      ply("ascii", repeated("a line\n", kMany) + kVertices, corners),
      ply("binary_little_endian", repeated("a line\n", kMany) + kVertices, kBinaryVertices + "more"),
      "\xef\xbb\xbf",
      "\xef\xbb\xbfply\n",
      "ply\nend_header\n"};
  return one_file("model.ply", files[k]);
}

/// Headers that are no use, even when lenient.
Case bad_header(std::size_t k) {
  const std::string begin = "ply\nformat ascii 1.0\n", end = "end_header\n", one = "element vertex 1\n";
  const std::string headers[] = {
      "",
      "ply",
      "plyx\n",
      "solid\n",
      "ply\nformat ascii 2.0\n" + end,
      "ply\nformat xml 1.0\n" + end,
      "ply\nelement vertex 3\n",
      begin + "element vertex -1\n" + end,
      begin + "element vertex 99999999999999999999\n" + end,
      begin + "property float x\n" + end,
      begin + one + "property real x\n" + end,
      begin + one + "property list uchar\n" + end,
      begin + one + "property float x\nproperty float y\n" + end + "0 0\n",
      begin + "element face 1\nproperty list uchar int vertex_indices\nelement vertex 1" + kXyz + end,
      begin + "element vertex 1" + kXyz};
  return refused(one_file("model.ply", headers[k]));
}

/// A header that begins well and then is noise.
Case noisy_header(std::size_t k) {
  std::mt19937 random(unsigned(k) + 1);
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  for (std::size_t n = random() % 2000; n > 0; --n) text += char(random() & 0xff);
  return refused(one_file("model.ply", text));
}

/// The last line's end is not missed.
Needs ply_needs(std::string_view seed) {
  const bool text = seed.find("ascii") != seed.npos;
  return {seed.size() - (text ? 1 : 0), seed.find("end_header\n") + 11};
}

}  // namespace

std::vector<Target> ply_targets() {
  Target target;
  target = {.format = "ply",
            .extension = ".ply",
            .read = importers::read_ply,
            .memory_factor = importers::kPlyMemoryFactor,
            .memory_constant = importers::kPlyMemoryConstant,
            .mutations = 30000,
            .attacks = {{"noisy_headers", kAnyNumber, noisy_header},
                        {"bad_headers", 15, bad_header},
                        {"absurd_counts", 25, ply_count},
                        {"absurd_list_lengths", 4, ply_list},
                        {"swelling", 3, ply_swollen},
                        {"lines", 13, ply_lines},
                        {"most_memory", 9, ply_worst}},
            .needs = ply_needs};
  return {target};
}

}  // namespace sightline::hostile
