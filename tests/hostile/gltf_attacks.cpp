#include "sightline/importers/gltf/internal/gltf_reader.h"
#include "sightline/tests/hostile/attack.h"
#include "sightline/tests/importers/gltf_bytes.h"

namespace sightline::hostile {
namespace {

using tests::GltfBytes;
using Json = json::Value;

/// Parts of a document; the default is one triangle whose positions lie in a data URI of 36 bytes.
struct Parts {
  std::string nodes = R"({"mesh":0})";
  std::string meshes = R"({"primitives":[{"attributes":{"POSITION":0}}]})";
  std::string accessors = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})";
  std::string views = R"({"buffer":0,"byteLength":36})";
  std::string buffers =
      R"({"byteLength":36,"uri":"data:application/octet-stream;base64,)" + repeated("A", 48) + R"("})";
  std::string scene_nodes = "0";
  std::string more;

  std::string text() const {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" + scene_nodes + R"(]}],"nodes":[)" + nodes +
           R"(],"meshes":[)" + meshes + R"(],"accessors":[)" + accessors + R"(],"bufferViews":[)" + views +
           R"(],"buffers":[)" + buffers + "]" + more + "}";
  }
};

Case document(const Parts& parts) {
  return one_file("model.gltf", parts.text());
}

/// `item` with %d replaced by first … first + count - 1, comma between.
std::string list(const std::string& item, std::size_t count) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) all += ',';
    std::string one = item;
    for (std::size_t at; (at = one.find("%d")) != one.npos;) one.replace(at, 2, std::to_string(i));
    for (std::size_t at; (at = one.find("%n")) != one.npos;) one.replace(at, 2, std::to_string(i + 1));
    all += one;
  }
  return all;
}

Case gltf_count(std::size_t k) {
  constexpr const char* kNumbers[] = {"4294967295", "9007199254740992", "18446744073709551615", "-1",
                                      "1e300",      "1431655766"};
  const std::string number = kNumbers[k / 6];
  Parts p;
  const std::string vectors = R"({"bufferView":0,"componentType":5126,"type":"VEC3","count":)";
  if (k % 6 == 0) p.accessors = vectors + number + "}";
  if (k % 6 == 1) p.accessors = vectors + R"(3,"byteOffset":)" + number + "}";
  if (k % 6 == 2) p.views = R"({"buffer":0,"byteLength":36,"byteOffset":)" + number + "}";
  if (k % 6 == 3) p.views = R"({"buffer":0,"byteStride":4,"byteLength":)" + number + "}";
  if (k % 6 == 4) p.buffers = R"({"byteLength":)" + number + R"(,"uri":"data:application/octet-stream;base64,AAAA"})";
  if (k % 6 == 5) p.nodes = R"({"mesh":)" + number + R"(,"children":[)" + number + "]}";
  return damaged(document(p));
}

Case gltf_cycle(std::size_t k) {
  Parts p;
  if (k == 0) p.nodes = R"({"mesh":0,"children":[0]})";
  if (k == 1) p.nodes = R"({"mesh":0,"children":[1]},{"mesh":0,"children":[0]})";
  if (k == 2) p.nodes = R"({"mesh":0,"children":[1,1]},{"mesh":0})";
  if (k == 3) p.nodes = R"({"mesh":0,"children":[2]},{"mesh":0,"children":[2]},{"mesh":0})", p.scene_nodes = "0,1";
  if (k == 4) p.nodes = R"({"mesh":0,"children":[1]},{"children":[2]},{"children":[1]})";
  if (k == 5) p.nodes = list(R"({"mesh":0,"children":[%n,%n]})", 40) + R"(,{"mesh":0})";  // 2^40 ways down
  if (k == 6) p.nodes = list(R"({"children":[%n],"scale":[2,2,2]})", 50000) + R"(,{"children":[0]})";
  return damaged(document(p));
}

/// Nested text, refused unless it is shallow, and a chain of nodes, which is no nesting of the text.
Case gltf_nested(std::size_t k) {
  Parts p;
  if (k == 0) p.nodes = list(R"({"children":[%n],"scale":[2,2,2]})", 100000) + R"(,{"mesh":0})";
  if (k == 1) p.more = R"(,"extras":)" + repeated("[", 1000000) + repeated("]", 1000000);
  if (k == 2) p.more = R"(,"extensions":{"a":)" + repeated(R"({"a":)", 500000) + "1" + repeated("}", 500001);
  if (k == 3) return refused(one_file("model.gltf", repeated("[", 1000000)));
  if (k > 3) p.more = R"(,"extras":)" + repeated("[", k == 4 ? 100 : 1000) + repeated("]", k == 4 ? 100 : 1000);
  return k == 0 || k == 4 ? sound(document(p)) : refused(document(p));
}

/// Accessors of zeros that no buffer backs, as positions, indices, places of instances and matrices.
Case zeros(std::size_t k) {
  const auto accessor = [](const char* type, const char* shape) {
    return R"({"componentType":)" + std::string(type) + R"(,"type":")" + shape + R"(","count":4294967294})";
  };
  const auto instances = [](const std::string& more, const std::string& attributes) {
    return R"({)" + more + R"("extensions":{"EXT_mesh_gpu_instancing":{"attributes":{)" + attributes + "}}}}";
  };
  Parts p;
  p.more = R"(,"extensionsUsed":["EXT_mesh_gpu_instancing"])";
  if (k == 0) p.accessors = accessor("5126", "VEC3");
  if (k == 1) p.accessors += "," + accessor("5125", "SCALAR");
  if (k == 1) p.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"indices":1}]})";
  if (k == 2) p.accessors += "," + accessor("5126", "VEC3");
  if (k == 2) p.nodes = instances(R"("mesh":0,)", R"("TRANSLATION":1)");
  if (k == 3) p.accessors = accessor("5126", "MAT4") + "," + accessor("5126", "SCALAR"), p.meshes.clear();
  if (k == 3) p.nodes = instances(R"("name":"BoxCollection",)", R"("_instanceMatrix":0,"_treeIndex":1)");
  if (k == 4)
    p.accessors =
        R"({"componentType":5126,"type":"VEC3","count":1000000000,"sparse":{"count":1,"indices":{"bufferView":0,)"
        R"("componentType":5121},"values":{"bufferView":0}}})";
  return refused(document(p));
}

/// Much out of little: one buffer read by many meshes, many parts drawn many times.
Case gltf_swollen(std::size_t k) {
  Parts p;
  if (k == 0) {  // 5000 meshes over the same 120 kB
    p.buffers =
        R"({"byteLength":120000,"uri":"data:application/octet-stream;base64,)" + repeated("AAAA", 40000) + R"("})";
    p.views = R"({"buffer":0,"byteLength":120000})";
    p.accessors = list(R"({"bufferView":0,"componentType":5126,"count":9999,"type":"VEC3","name":"%d"})", 5000);
    p.meshes = list(R"({"primitives":[{"attributes":{"POSITION":%d}}]})", 5000);
    p.nodes = list(R"({"mesh":%d})", 5000);
    p.scene_nodes = list("%d", 5000);
  }
  if (k == 1) {  // one mesh of 5000 parts, 5000 times
    p.meshes = R"({"primitives":[)" + list(R"({"attributes":{"POSITION":0}})", 5000) + "]}";
    p.nodes = list(R"({"mesh":0})", 5000);
    p.scene_nodes = list("%d", 5000);
  }
  if (k == 2) {  // parts that draw nothing
    p.meshes = R"({"primitives":[)" + repeated(R"({"mode":0})", 20000, ",") + "]}";
    p.nodes = repeated(R"({"mesh":0})", 20000, ",");
    p.scene_nodes = list("%d", 20000);
  }
  if (k == 3) {  // the same zeros under another name each time
    p.accessors = repeated(R"({"componentType":5126,"type":"VEC3","count":60000})", 500, ",");
    p.meshes = R"({"primitives":[)" + list(R"({"attributes":{"POSITION":%d}})", 500) + "]}";
  }
  return refused(document(p));
}

/// An image that is not there, named by thousands of materials.
Case missing_image(std::size_t) {
  Parts p;
  p.meshes = R"({"primitives":[)" + list(R"({"attributes":{"POSITION":0},"material":%d})", 5000) + "]}";
  p.more = R"(,"images":[{"uri":"x.png"}],"textures":[{"source":0}],"materials":[)" +
           repeated(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})", 5000, ",") + "]";
  return sound(document(p));
}

/// Text that takes the most memory for its bytes.
Case worst_text(std::size_t k) {
  const std::string accessor = R"({"componentType":5126,"type":"VEC3","count":3})";
  const std::string one = R"("accessors":[)" + accessor + "],", part = R"({"attributes":{"POSITION":)";
  const std::string parts = R"(],"meshes":[{"primitives":[)", node = R"("nodes":[{"mesh":0}],)";
  std::string body;
  if (k == 0) body = R"("materials":[)" + repeated("{}", 250000, ",");
  if (k == 1) body = R"("extras":[)" + repeated("[]", 250000, ",");
  if (k == 2) body = R"("extras":[)" + repeated("0", 500000, ",");
  if (k == 3) body = R"("nodes":[)" + repeated("{}", 250000, ",");
  if (k == 4) body = R"("nodes":[)" + repeated(R"({"extras":0})", 125000, ",");
  if (k == 5) body = R"("nodes":[)" + repeated(R"({"mesh":9})", 125000, ",");
  if (k == 6) body = one + node + R"("materials":[)" + repeated("{}", 50000, ",") + parts;
  if (k == 6) body += list(part + R"(0},"material":%d})", 50000) + "]}";
  if (k == 7) body = node + R"("accessors":[)" + repeated(accessor, 25000, ",") + parts;
  if (k == 7) body += list(part + "%d}}", 25000) + "]}";
  if (k == 8) body = one + R"("meshes":[{"primitives":[)" + part + R"(0}}]}],"nodes":[)";
  if (k == 8) body += repeated(R"({"mesh":0})", 125000, ",");
  return one_file("model.gltf", R"({"asset":{"version":"2.0"},)" + body + "]}");
}

Case with_buffer(const std::string& uri) {
  Parts p;
  p.buffers = R"({"byteLength":36,"uri":)" + Json(uri).dump() + "}";
  return document(p);
}

Case refused_buffer(const std::string& uri) {
  Case made = damaged(with_buffer(uri));
  made.most_items = 0;
  return made;
}

Case missing_buffer(std::size_t k) {
  constexpr const char* kNames[] = {
      "none.bin", "", ".", "none/none.bin", "data:application/octet-stream;base64,=", "http://example.org/a.bin"};
  return damaged(with_buffer(kNames[k]));
}

/// Lengths in the header and chunk headers of a GLB file.
Case absurd_length(std::size_t k) {
  constexpr std::uint32_t kLengths[] = {0, 1, 0x7fffffff, 0x80000000, 0xfffffff0, 0xffffffff};
  Parts p;
  p.buffers = R"({"byteLength":36})";
  std::string json = p.text();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::uint32_t lengths[] = {std::uint32_t(12 + 8 + json.size() + 8 + 36), std::uint32_t(json.size()), 36};
  lengths[k / 6] = kLengths[k % 6];
  Case made =
      one_file("model.glb", "glTF" + little_endian(2) + little_endian(lengths[0]) + little_endian(lengths[1]) + "JSON" +
                                json + little_endian(lengths[2]) + std::string("BIN\0", 4) + std::string(36, '\0'));
  made.strict = Expect::kFailure;
  return made;
}

std::string glb(const GltfBytes& file) {
  return text_of(file.glb());
}

/// Zeros that make a mesh.
int zeros_of(GltfBytes& file, std::size_t count, const char* type = "VEC3") {
  return file.add("accessors", {{"componentType", 5126}, {"type", type}, {"count", count}});
}

/// A mesh of three zeros in triangles or a strip, whose half a million indices are bytes.
Case worst_indices(int mode) {
  GltfBytes file;
  const int positions = zeros_of(file, 256);
  std::vector<std::uint8_t> order(500000);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = std::uint8_t(i * 7);
  file.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", file.accessor(order, "SCALAR")}, {"mode", mode}});
  file.root({{"mesh", 0}});
  return one_file("model.glb", glb(file));
}

/// Instances with parts and colours of their own.
Case worst_instances() {
  GltfBytes file;
  std::vector<std::uint16_t> trees(65536);
  std::vector<std::uint8_t> colours;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    trees[i] = std::uint16_t(i);
    for (int c = 0; c < 4; ++c) colours.push_back(std::uint8_t(i >> (4 * c)));
  }
  const int matrix = zeros_of(file, trees.size(), "MAT4");
  const int tree = file.accessor(trees, "SCALAR"), colour = file.accessor(colours, "VEC4");
  for (const char* const kind : {"NutCollection", "BoxCollection", "QuadCollection"})
    file.root({{"name", kind},
               {"extensions",
                {{"EXT_mesh_gpu_instancing",
                  {{"attributes", {{"_instanceMatrix", matrix}, {"_treeIndex", tree}, {"_color", colour}}}}}}}});
  return one_file("model.glb", glb(file));
}

/// Each primitive of some forty bytes splits into many meshes.
Case worst_colours() {
  GltfBytes file;
  std::vector<std::uint8_t> of_vertices;
  for (int i = 0; i < 255; ++i)
    for (int c = 0; c < 3; ++c) of_vertices.push_back(std::uint8_t(i * (c + 1) * 7));
  const int colours = file.accessor(of_vertices, "VEC3");
  Json primitives = Json::array();
  for (int i = 0; i < 2000; ++i)
    primitives.push_back({{"attributes", {{"POSITION", zeros_of(file, 255)}, {"COLOR_0", colours}}}, {"mode", 4}});
  file.add("meshes", {{"primitives", primitives}});
  file.root({{"mesh", 0}});
  return one_file("model.glb", glb(file));
}

Case worst_binary(std::size_t k) {
  return k < 2 ? worst_indices(k == 0 ? 4 : 5) : k == 2 ? worst_instances() : worst_colours();
}

/// Adds the values from `value` to each one that holds no others: a branch of the tree each.
void add_branches(Json& value, std::vector<Json*>& branch, std::vector<std::vector<Json*>>& branches) {
  branch.push_back(&value);
  if (value.is_array() || value.is_object())
    for (Json& child : value) add_branches(child, branch, branches);
  if (value.empty() || !(value.is_array() || value.is_object())) branches.push_back(branch);
  branch.pop_back();
}

/// One of all values below the root, in no order of a reader's.
Json& any_value(Json& root, std::mt19937& random) {
  std::vector<std::vector<Json*>> branches;
  std::vector<Json*> branch;
  add_branches(root, branch, branches);
  branch = branches[random() % branches.size()];
  const std::size_t up = std::min<std::size_t>(random() % 3, branch.size() - 2);
  return *branch[branch.size() - 1 - up];
}

/// Changes that leave it JSON reach deeper than those of bytes.
Case changed_values(std::size_t k) {
  static const Json values =
      json::parse(
          R"([null,true,-1,0,1,2,5121,5125,4294967295,4294967296,65536,0.5,1e300,-1e300,1e38,"","text","MAT4","SCALAR",[],)"
          R"({},[0,1,2],{"a":1},9007199254740991,18446744073709551615,"data:;base64,AAAA"])")
          .value();
  static const GltfBytes whole = tests::small_gltf();
  std::mt19937 random(unsigned(k) + 1);
  GltfBytes file = whole;
  for (auto times = 1 + random() % 3; times > 0; --times) {
    const Json other = random() % 3 ? values[random() % values.size()] : any_value(file.json, random);
    any_value(file.json, random) = other;
  }
  return one_file("model.glb", glb(file));
}

Needs whole_text(std::string_view seed) {
  const std::size_t size = seed.find_last_of('}') + 1;
  return {size, size};
}

}  // namespace

std::vector<Target> gltf_targets() {
  Target text, binary;
  text = {.format = "gltf",
          .extension = ".gltf",
          .read = importers::read_gltf,
          .memory_factor = importers::kGltfMemoryFactor,
          .memory_constant = importers::kGltfMemoryConstant,
          .mutations = 10000,
          .attacks = {{"absurd_counts", 36, gltf_count},
                      {"cycles", 7, gltf_cycle},
                      {"deep_nesting", 6, gltf_nested},
                      {"zeros", 5, zeros},
                      {"swelling", 4, gltf_swollen},
                      {"most_memory", 9, worst_text},
                      {"missing_side_files", 6, missing_buffer},
                      {"missing_images", 1, missing_image},
                      path_traversal(".bin", std::string(36, '\0'), refused_buffer)},
          .needs = whole_text};
  binary = text;
  binary.extension = ".glb";
  binary.mutations = 20000;
  binary.attacks = {{"mutated_values", kAnyNumber, changed_values},
                    {"absurd_lengths", 18, absurd_length},
                    {"most_memory", 4, worst_binary}};
  binary.needs = [](std::string_view seed) { return Needs{seed.size(), 0}; };
  return {text, binary};
}

}  // namespace sightline::hostile
