// Damaged and malicious glTF files: no crash, no hang, no memory beyond the stated multiple, and what is imported can
// be committed. Run under -fsanitize=address,undefined this also shows that no read leaves the buffer.
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/gltf/internal/gltf_reader.h"
#include "sightline/tests/importers/gltf_bytes.h"
#include "sightline/tests/importers/hostile.h"

namespace sightline::importers::gltf_hostile_test {
namespace {

using Bytes = std::vector<std::byte>;
using tests::GltfBytes;
using Json = nlohmann::json;

/// True when the import succeeded.
bool survives(std::span<const std::byte> content, bool lenient, double* factor = nullptr) {
  const auto read = [&](std::span<const std::byte> bytes, core::Scene& scene, core::NodeId parent) {
    return read_gltf(bytes, "hostile.glb", scene, parent, {.lenient = lenient});
  };
  return tests::survives(content, read, kGltfMemoryFactor, kGltfMemoryConstant, factor);
}

bool survives(const std::string& text, bool lenient, double* factor = nullptr) {
  return survives(std::as_bytes(std::span(text)), lenient, factor);
}

TEST(GltfHostile, EveryTruncation) {
  const GltfBytes file = tests::small_gltf();
  const Bytes whole = file.glb();
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    SCOPED_TRACE(testing::Message() << "binary, truncated to " << size);
    const std::span<const std::byte> part(whole.data(), size);
    ASSERT_EQ(survives(part, false), size == whole.size());
    survives(part, true);
    ASSERT_FALSE(testing::Test::HasFailure());
  }
  const std::string text = file.gltf("data:application/octet-stream;base64," + tests::base64(file.binary));
  for (std::size_t size = 0; size <= text.size(); ++size) {
    SCOPED_TRACE(testing::Message() << "text, truncated to " << size);
    ASSERT_EQ(survives(text.substr(0, size), false), size == text.size());
    ASSERT_EQ(survives(text.substr(0, size), true), size == text.size());
    ASSERT_FALSE(testing::Test::HasFailure());
  }
}

#ifdef __SANITIZE_ADDRESS__
constexpr int kLess = 5;  // of everything: sanitizers take their time
#else
constexpr int kLess = 1;
#endif
constexpr unsigned kMutations = 20000 / kLess;

/// Bytes of the container, of its JSON and of its numbers.
TEST(GltfHostile, RandomMutationsOfBytes) {
  const Bytes whole = tests::small_gltf().glb();
  int strict = 0, lenient = 0;
  for (unsigned seed = 0; seed < kMutations; ++seed) {
    std::mt19937 random(seed);
    Bytes bytes = whole;
    for (auto t = 0ul, n = 1 + random() % 4; t < n; ++t) {
      std::byte& byte = bytes[random() % bytes.size()];
      byte = random() % 2 ? std::byte(random()) : byte ^ std::byte(1u << (random() % 8));
    }
    strict += survives(bytes, false);
    lenient += survives(bytes, true);
    ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed;
  }
  EXPECT_GT(lenient, strict);
}

/// One of all values of the JSON, in no order of a reader's.
Json& any_value(Json& root, std::mt19937& random) {
  const Json flat = root.flatten();
  auto it = flat.begin();
  std::advance(it, random() % flat.size());
  Json::json_pointer pointer(it.key());
  for (auto up = random() % 3; up > 0 && !pointer.parent_pointer().empty(); --up) pointer = pointer.parent_pointer();
  return root[pointer];
}

/// Mutations that leave it JSON reach deeper than those of bytes.
TEST(GltfHostile, RandomMutationsOfValues) {
  const GltfBytes whole = tests::small_gltf();
  const Json values[] = {nullptr,
                         true,
                         -1,
                         0,
                         1,
                         2,
                         5121,
                         5125,
                         4294967295u,
                         4294967296u,
                         65536,
                         0.5,
                         1e300,
                         -1e300,
                         1e38,
                         "",
                         "text",
                         "MAT4",
                         "SCALAR",
                         Json::array(),
                         Json::object(),
                         {0, 1, 2},
                         {{"a", 1}},
                         9007199254740991u,
                         18446744073709551615u,
                         "data:;base64,AAAA"};
  int strict = 0, lenient = 0;
  for (unsigned seed = 0; seed < kMutations; ++seed) {
    std::mt19937 random(seed);
    GltfBytes file = whole;
    for (auto t = 0ul, n = 1 + random() % 3; t < n; ++t) {
      const Json other = random() % 3 ? values[random() % std::size(values)] : any_value(file.json, random);
      any_value(file.json, random) = other;
    }
    const Bytes bytes = file.glb();
    strict += survives(bytes, false);
    lenient += survives(bytes, true);
    ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed;
  }
  EXPECT_GT(lenient, strict);
}

TEST(GltfHostile, DeepNesting) {
  const std::string head = R"({"asset":{"version":"2.0"},"extras":)";
  const auto nested = [&](std::size_t depth) { return head + std::string(depth, '[') + std::string(depth, ']') + "}"; };
  EXPECT_TRUE(survives(nested(100), false));
  EXPECT_FALSE(survives(nested(1000), true));
  EXPECT_FALSE(survives(nested(2'000'000), true));
  EXPECT_FALSE(survives(head + std::string(2'000'000, '['), true));

  // A chain of nodes is no nesting of the text.
  std::string chain = R"({"asset":{"version":"2.0"},"nodes":[)";
  constexpr int kNodes = 50'000;
  for (int i = 0; i < kNodes; ++i) chain += "{\"children\":[" + std::to_string(i + 1) + "],\"scale\":[2,2,2]},";
  EXPECT_TRUE(survives(chain + "{}]}", false));
  EXPECT_FALSE(survives(chain + "{\"children\":[0]}]}", false));
  EXPECT_TRUE(survives(chain + "{\"children\":[0]}]}", true));
}

/// Few bytes that ask for much: each is refused, or within the stated multiple.
TEST(GltfHostile, AbsurdCounts) {
  const std::string head = R"({"asset":{"version":"2.0"},)";
  const auto refused = [](const std::string& text) {
    EXPECT_FALSE(survives(text, false));
    EXPECT_FALSE(survives(text, true));
  };
  // Zeros without end: positions, indices, instances, sparse ones.
  const std::string zeros = R"("accessors":[{"componentType":5126,"type":"VEC3","count":4294967294},)"
                            R"({"componentType":5125,"type":"SCALAR","count":4294967294}],)";
  const std::string nodes = R"("nodes":[{"mesh":0}],)";
  refused(head + zeros + nodes + R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})");
  refused(head + zeros + nodes + R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}]})");
  const std::string triangle = R"("meshes":[{"primitives":[{"attributes":{"POSITION":1}}]}],)"
                               R"("accessors":[{"componentType":5126,"type":"VEC3","count":4294967294},)"
                               R"({"componentType":5126,"type":"VEC3","count":3}],)";
  const auto instances = [](const std::string& name, const std::string& attribute) {
    return R"("nodes":[{"name":")" + name + R"(","mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{")" +
           attribute + R"(":0}}}}]})";
  };
  refused(head + triangle + instances("", "TRANSLATION"));
  refused(head + R"("accessors":[{"componentType":5126,"type":"MAT4","count":4294967294},)" +
          R"({"componentType":5126,"type":"SCALAR","count":4294967294}],)" +
          R"("nodes":[{"name":"BoxCollection","extensions":{"EXT_mesh_gpu_instancing":{"attributes":)" +
          R"({"_instanceMatrix":0,"_treeIndex":1}}}}]})");
  // One mesh of many primitives under many nodes: a million items from a hundred kilobytes.
  std::string many = head + R"("accessors":[{"componentType":5126,"type":"VEC3","count":3}],"meshes":[{"primitives":[)";
  for (int i = 0; i < 3000; ++i) many += std::string(i ? "," : "") + R"({"attributes":{"POSITION":0}})";
  many += R"(]}],"nodes":[)";
  for (int i = 0; i < 3000; ++i) many += std::string(i ? "," : "") + R"({"mesh":0})";
  refused(many + "]}");
  // The same with what draws nothing.
  std::string points = head + R"("accessors":[],"meshes":[{"primitives":[)";
  for (int i = 0; i < 20000; ++i) points += std::string(i ? "," : "") + R"({"mode":0})";
  points += R"(]}],"nodes":[)";
  for (int i = 0; i < 20000; ++i) points += std::string(i ? "," : "") + R"({"mesh":0})";
  refused(points + "]}");
  // The same triangles under another name each time.
  std::string aliases = head + R"("nodes":[{"mesh":0}],"accessors":[)";
  for (int i = 0; i < 500; ++i)
    aliases += std::string(i ? "," : "") + R"({"componentType":5126,"type":"VEC3","count":60000})";
  aliases += R"(],"meshes":[{"primitives":[)";
  for (int i = 0; i < 500; ++i)
    aliases += std::string(i ? "," : "") + R"({"attributes":{"POSITION":)" + std::to_string(i) + "}}";
  refused(aliases + "]}]}");
  // Images and buffers that do not exist, in numbers.
  std::string images =
      head + R"("nodes":[{"mesh":0}],"images":[{"uri":"x.png"}],"textures":[{"source":0}],"materials":[)";
  for (int i = 0; i < 5000; ++i)
    images += std::string(i ? "," : "") + R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  images += R"(],"accessors":[{"componentType":5126,"type":"VEC3","count":3}],"meshes":[{"primitives":[)";
  for (int i = 0; i < 5000; ++i)
    images += std::string(i ? "," : "") + R"({"attributes":{"POSITION":0},"material":)" + std::to_string(i) + "}";
  EXPECT_TRUE(survives(images + "]}]}", false));
}

TEST(GltfHostile, MemoryOfTheWorstInputs) {
  const std::string head = R"({"asset":{"version":"2.0"},)";
  const auto repeated = [](const std::string& text, int times) {
    std::string all;
    for (int i = 0; i < times; ++i) all += (i ? "," : "") + text;
    return all;
  };
  std::vector<std::pair<std::string, std::string>> cases;
  const auto add = [&](const std::string& name, const std::string& body) {
    cases.emplace_back(name, head + body + "}");
  };
  add("empty objects", R"("materials":[)" + repeated("{}", 250'000 / kLess) + "]");
  add("empty arrays", R"("extras":[)" + repeated("[]", 250'000 / kLess) + "]");
  add("zeros", R"("extras":[)" + repeated("0", 500'000 / kLess) + "]");
  add("nodes", R"("nodes":[)" + repeated("{}", 250'000 / kLess) + "]");
  add("attributes", R"("nodes":[)" + repeated(R"({"extras":0})", 125'000 / kLess) + "]");
  add("damaged nodes", R"("nodes":[)" + repeated(R"({"mesh":9})", 125'000 / kLess) + "]");
  const std::string accessor = R"("accessors":[{"componentType":5126,"type":"VEC3","count":3}],)";
  std::string materials = accessor + R"("nodes":[{"mesh":0}],"materials":[)" + repeated("{}", 50'000 / kLess) + "]," +
                          R"("meshes":[{"primitives":[)";
  for (int i = 0; i < 50'000 / kLess; ++i)
    materials += (i ? "," : "") + std::string(R"({"attributes":{"POSITION":0},"material":)") + std::to_string(i) + "}";
  add("materials and items", materials + "]}]");
  std::string meshes = R"("nodes":[{"mesh":0}],"accessors":[)" +
                       repeated(R"({"componentType":5126,"type":"VEC3","count":3})", 25'000 / kLess) +
                       R"(],"meshes":[{"primitives":[)";
  for (int i = 0; i < 25'000 / kLess; ++i)
    meshes += (i ? "," : "") + std::string(R"({"attributes":{"POSITION":)") + std::to_string(i) + "}}";
  add("meshes", meshes + "]}]");
  add("items", accessor + R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[)" +
                   repeated(R"({"mesh":0})", 125'000 / kLess) + "]");

  for (const auto& [name, text] : cases) {
    double factor = 0.0;
    survives(text, true, &factor);
    std::printf("%-20s %8zu bytes, peak memory / file size: %.1f\n", name.c_str(), text.size(), factor);
  }
  // Bytes of a buffer that become corners, instances with parts and colours of their own.
  GltfBytes strip;
  strip.mesh({{"attributes",
               {{"POSITION", strip.add("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 256}})}}},
              {"indices", 0},
              {"mode", 5}});
  std::vector<std::uint8_t> order(500'000 / kLess);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = std::uint8_t(i * 7);
  strip.json["meshes"][0]["primitives"][0]["indices"] = strip.accessor(order, "SCALAR");
  strip.root({{"mesh", 0}});
  GltfBytes plain = strip;
  plain.json["meshes"][0]["primitives"][0]["mode"] = 4;
  GltfBytes parts;
  std::vector<std::uint16_t> trees(65536);
  std::vector<std::uint8_t> colours;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    trees[i] = std::uint16_t(i);
    for (int c = 0; c < 4; ++c) colours.push_back(std::uint8_t(i >> (4 * c)));
  }
  const int matrix = parts.add("accessors", {{"componentType", 5126}, {"type", "MAT4"}, {"count", trees.size()}});
  const int tree = parts.accessor(trees, "SCALAR"), colour = parts.accessor(colours, "VEC4");
  for (const char* const kind : {"NutCollection", "BoxCollection", "QuadCollection"})
    parts.root({{"name", kind},
                {"extensions",
                 {{"EXT_mesh_gpu_instancing",
                   {{"attributes", {{"_instanceMatrix", matrix}, {"_treeIndex", tree}, {"_color", colour}}}}}}}});
  // Each primitive of some forty bytes splits into many meshes.
  GltfBytes shades;
  std::vector<std::uint8_t> of_vertices;
  for (int i = 0; i < 255; ++i)
    for (int c = 0; c < 3; ++c) of_vertices.push_back(std::uint8_t(i * (c + 1) * 7));
  const int colours_of = shades.accessor(of_vertices, "VEC3");
  const int zeros = shades.add("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 255}});
  Json primitives = Json::array();
  for (int i = 0; i < 2000 / kLess; ++i)
    primitives.push_back({{"attributes", {{"POSITION", zeros}, {"COLOR_0", colours_of}}}, {"mode", 4}});
  for (int i = 0; i < 2000 / kLess; ++i) {
    const int other = shades.add("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 255}});
    primitives[std::size_t(i)]["attributes"]["POSITION"] = other;
  }
  shades.add("meshes", {{"primitives", primitives}});
  shades.root({{"mesh", 0}});
  for (const GltfBytes* file : {&strip, &plain, &parts, &shades}) {
    double factor = 0.0;
    survives(file->glb(), true, &factor);
    std::printf("buffer %33.1f\n", factor);
  }
}

}  // namespace
}  // namespace sightline::importers::gltf_hostile_test
