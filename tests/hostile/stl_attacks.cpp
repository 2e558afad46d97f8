#include "sightline/importers/stl/internal/stl_reader.h"
#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile {
namespace {

std::string stl(std::uint32_t triangles, const std::string& facets) {
  return std::string(80, ' ') + little_endian(triangles) + facets;
}

/// Triangles that the file does not hold; 85899346 of them take 4 bytes more than 2^32.
Case stl_count(std::size_t k) {
  constexpr std::uint32_t kTriangles[] = {0xffffffff, 0x7fffffff, 0x55555556, 85899346, 2, 0};
  return damaged(one_file("model.stl", stl(kTriangles[k], std::string(50, '\0'))));
}

Case stl_swollen(std::size_t k) {
  const std::string solid = "solid\nendsolid\n", facet = "facet normal 0 0 1\nouter loop\n";
  if (k == 0) return sound(one_file("model.stl", repeated(solid, 100000)));
  if (k == 1) return damaged(one_file("model.stl", "solid deep\n" + repeated(facet, 100000)));
  return damaged(one_file("model.stl", "solid " + repeated("a", 1000000)));
}

/// The most memory for their bytes: triangles far apart, without and with colours of their own, and solids.
Case stl_worst(std::size_t k) {
  constexpr std::uint32_t kTriangles = 100000, kSolids = 20000;
  if (k == 2)
    return one_file("model.stl",
                    repeated("solid a\nfacet normal 0 0 0 outer loop vertex 1 2 3 vertex 4 5 6 vertex 7 8 9 endloop "
                             "endfacet endsolid\n",
                             kSolids));
  if (k == 3) return one_file("model.stl", repeated("solid a\nendsolid\n", kSolids));
  std::string text = "solid\n", facets;
  for (std::uint32_t i = 0; k > 3 && i < kSolids; ++i) {
    const std::string x = "vertex " + std::to_string(i);
    text += "facet normal 0 0 0 outer loop " + x + " 2 3 " + x + " 5 6 " + x + " 8 9 endloop endfacet\n";
  }
  if (k > 3) return one_file("model.stl", text + (k == 5 ? "solid" : ""));
  std::mt19937 random(3);
  for (std::uint32_t i = 0; i < kTriangles; ++i) {
    facets += std::string(12, '\0');
    for (int c = 0; c < 9; ++c) facets += little_endian(0x3f800000 + random() % 0x08000000);
    facets += little_endian(k == 1 ? 0x8000 + random() % 256 : 0).substr(0, 2);
  }
  return one_file("model.stl", stl(kTriangles, facets));
}

/// Text of what is read though the specification is bent, in masses.
Case stl_bent(std::size_t k) {
  constexpr std::size_t kMany = 100000;
  std::string polygon = "solid\nfacet\n";
  for (std::size_t i = 0; k == 0 && i < kMany; ++i)
    polygon += "vertex " + std::to_string(i) + " " + std::to_string(i * i % 977) + " 0\n";
  const std::string facet = "facet loop vertex 1 0 0 vertex 2 0 0 vertex 2 1 0 end loop end facet\n";
  const std::string texts[] = {polygon + "endfacet\nendsolid\n",
                               "solid\n" + repeated("end\n", kMany),
                               "solid\n" + repeated("outer loop\n", kMany),
                               "solid\n" + repeated("facet\n", kMany),
                               "solid\n" + repeated("vertex 1 2 3\n", kMany),
                               "solid\n" + repeated("facet vertex 1 2 3 # comment\n# comment\n", kMany),
                               repeated("# comment\n", kMany) + "solid\n" + facet,
                               repeated("solid a\nsolid b\n" + facet, kMany / 10),
                               repeated(facet, kMany),
                               "solid\n" + repeated(facet + "what is this\n", kMany / 10) + "end solid\n",
                               "\xef\xbb\xbf",
                               "\xef\xbb\xbfsolid",
                               "solid\nfacet end",
                               "facet",
                               "end\nsolid\nend"};
  return one_file("model.stl", texts[k]);
}

/// Counts that the length contradicts, with records that are facets, fill or noise.
Case stl_surplus(std::size_t k) {
  constexpr std::uint32_t kCounts[] = {0, 1, 999, 1001, 0xffffffff};
  std::mt19937 random(unsigned(k) + 1);
  std::string facets;
  for (int i = 0; i < 1000; ++i) {
    std::string facet(12, '\0');
    for (int c = 0; c < 9; ++c) facet += little_endian(0x3f800000 + random() % 0x08000000);
    facets += facet + std::string(2, '\0');
  }
  if (k / 5 == 1) facets += std::string(1 + random() % 200, '\0');
  if (k / 5 == 2)
    for (auto n = 1 + random() % 200; n > 0; --n) facets += char(random());
  return one_file("model.stl", stl(kCounts[k % 5], facets));
}

/// Text is whole after each of its solids, and a binary file after each facet if its count is not believed, so no
/// strict length is known.
Needs stl_needs(std::string_view seed) {
  if (seed.size() < 84 || seed.size() % 50 != 84 % 50) return {};
  return {0, seed.starts_with("solid") ? 0u : 84u};
}

}  // namespace

std::vector<Target> stl_targets() {
  Target target;
  target = {.format = "stl",
            .extension = ".stl",
            .read = importers::read_stl,
            .memory_factor = importers::kStlMemoryFactor,
            .memory_constant = importers::kStlMemoryConstant,
            .mutations = 30000,
            .attacks = {{"absurd_counts", 6, stl_count},
                        {"swelling_and_nesting", 3, stl_swollen},
                        {"bent_text", 15, stl_bent},
                        {"surplus", 15, stl_surplus},
                        {"most_memory", 6, stl_worst}},
            .noise = Expect::kEither,
            .needs = stl_needs};
  return {target};
}

}  // namespace sightline::hostile
