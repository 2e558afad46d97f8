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

/// Text is whole after each of its solids, so no length of it is known.
Needs stl_needs(std::string_view seed) {
  if (seed.size() < 84 || seed.size() % 50 != 84 % 50) return {};
  return {seed.size(), seed.starts_with("solid") ? 0u : 84u};
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
                        {"most_memory", 6, stl_worst}},
            .noise = Expect::kEither,
            .needs = stl_needs};
  return {target};
}

}  // namespace sightline::hostile
