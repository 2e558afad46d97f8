#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile::gltf {
namespace {

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
  return {{{"model.gltf", parts.text()}}};
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

Case absurd_count(std::size_t k) {
  constexpr const char* kNumbers[] = {"4294967295", "9007199254740992", "18446744073709551615", "-1",
                                      "1e300",      "1431655766"};
  const std::string number = kNumbers[k / 6];
  Parts p;
  switch (k % 6) {
    case 0:
      p.accessors = R"({"bufferView":0,"componentType":5126,"type":"VEC3","count":)" + number + "}";
      break;
    case 1:
      p.accessors = R"({"bufferView":0,"componentType":5126,"type":"VEC3","count":3,"byteOffset":)" + number + "}";
      break;
    case 2:
      p.views = R"({"buffer":0,"byteLength":36,"byteOffset":)" + number + "}";
      break;
    case 3:
      p.views = R"({"buffer":0,"byteStride":4,"byteLength":)" + number + "}";
      break;
    case 4:
      p.buffers = R"({"byteLength":)" + number + R"(,"uri":"data:application/octet-stream;base64,AAAA"})";
      break;
    default:
      p.nodes = R"({"mesh":)" + number + R"(,"children":[)" + number + "]}";
      break;
  }
  return document(p);
}

Case cycle(std::size_t k) {
  Parts p;
  if (k == 0) p.nodes = R"({"mesh":0,"children":[0]})";
  if (k == 1) p.nodes = R"({"mesh":0,"children":[1]},{"mesh":0,"children":[0]})";
  if (k == 2) p.nodes = R"({"mesh":0,"children":[1,1]},{"mesh":0})";
  if (k == 3) p.nodes = R"({"mesh":0,"children":[2]},{"mesh":0,"children":[2]},{"mesh":0})", p.scene_nodes = "0,1";
  if (k == 4) p.nodes = R"({"mesh":0,"children":[1]},{"children":[2]},{"children":[1]})";
  if (k == 5) p.nodes = list(R"({"mesh":0,"children":[%n,%n]})", 40) + R"(,{"mesh":0})";  // 2^40 ways down
  return document(p);
}

Case nested(std::size_t k) {
  Parts p;
  if (k == 0) p.nodes = list(R"({"children":[%n]})", 100000) + R"(,{"mesh":0})";
  if (k == 1) p.more = R"(,"extras":)" + repeated("[", 1000000) + repeated("]", 1000000);
  if (k == 2) p.more = R"(,"extensions":{"a":)" + repeated(R"({"a":)", 500000) + "1" + repeated("}", 500001);
  if (k == 3) return {{{"model.gltf", repeated("[", 1000000)}}};
  return document(p);
}

/// Much out of little: zeros that no buffer backs, one buffer read by many meshes, instances of instances.
Case swollen(std::size_t k) {
  Parts p;
  if (k == 0) p.accessors = R"({"componentType":5126,"type":"VEC3","count":1000000000})";
  if (k == 1)
    p.accessors =
        R"({"componentType":5126,"type":"VEC3","count":1000000000,"sparse":{"count":1,"indices":{"bufferView":0,)"
        R"("componentType":5121},"values":{"bufferView":0}}})";
  if (k == 2) {  // 5000 meshes over the same 120 kB
    p.buffers =
        R"({"byteLength":120000,"uri":"data:application/octet-stream;base64,)" + repeated("AAAA", 40000) + R"("})";
    p.views = R"({"buffer":0,"byteLength":120000})";
    p.accessors = list(R"({"bufferView":0,"componentType":5126,"count":9999,"type":"VEC3","name":"%d"})", 5000);
    p.meshes = list(R"({"primitives":[{"attributes":{"POSITION":%d}}]})", 5000);
    p.nodes = list(R"({"mesh":%d})", 5000);
    p.scene_nodes = list("%d", 5000);
  }
  if (k == 3) {  // one mesh of 5000 parts, 5000 times
    p.meshes = R"({"primitives":[)" + list(R"({"attributes":{"POSITION":0}})", 5000) + "]}";
    p.nodes = list(R"({"mesh":0})", 5000);
    p.scene_nodes = list("%d", 5000);
  }
  if (k == 4) {  // instances that nothing backs
    p.accessors += R"(,{"componentType":5126,"type":"VEC3","count":1000000000})";
    p.nodes = R"({"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":1}}}})";
    p.more = R"(,"extensionsUsed":["EXT_mesh_gpu_instancing"])";
  }
  return document(p);
}

Case with_buffer(const std::string& uri) {
  Parts p;
  p.buffers = R"({"byteLength":36,"uri":")" + uri + R"("})";
  return document(p);
}

Case missing(std::size_t k) {
  constexpr const char* kNames[] = {
      "none.bin", "", ".", "none/none.bin", "data:application/octet-stream;base64,=", "http://example.org/a.bin"};
  return with_buffer(kNames[k]);
}

Case traversal(std::size_t k) {
  const std::string outside(kOutside);
  const std::vector<std::string> names = {
      "../secret.bin",    outside + "/secret.bin", "link.bin",
      "links/secret.bin", "none/../../secret.bin", "%2e%2e/secret.bin",
      "..%2fsecret.bin",  "%2E%2E%2Fsecret.bin",   "file://" + outside + "/secret.bin",
      "..\\\\secret.bin"};
  Case made = with_buffer(names[k]);
  made.files.push_back({"../secret.bin", std::string(36, '\0')});
  made.files.push_back({"link.bin", {}, "../secret.bin"});
  made.files.push_back({"links", {}, ".."});
  made.most_items = 0;
  return made;
}

std::string word(std::uint32_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += char(value >> shift & 0xff);
  return bytes;
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
  return {{{"model.glb", "glTF" + word(2) + word(lengths[0]) + word(lengths[1]) + "JSON" + json + word(lengths[2]) +
                             std::string("BIN\0", 4) + std::string(36, '\0')}}};
}

}  // namespace

std::vector<Attack> attacks() {
  return {{"absurd counts", 36, absurd_count},        {"cycles", 6, cycle},
          {"deep nesting (to 1,000,000)", 4, nested}, {"swelling", 5, swollen},
          {"missing side files", 6, missing},         {"path traversal", 10, traversal}};
}

std::vector<Attack> binary_attacks() {
  return {{"absurd lengths", 18, absurd_length}};
}

}  // namespace sightline::hostile::gltf
