// Writes glTF files for tests, number by number.
#pragma once

#include <cstring>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "sightline/importers/json/internal/json.h"

namespace sightline::tests {

struct GltfBytes {
  using Json = sightline::json::Value;
  Json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", Json::array()}}}}};
  std::vector<std::byte> binary;

  template <class T>
  static constexpr int type_code() {
    if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
    if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
    return 5126;
  }

  int add(const std::string& array, Json element) {
    json[array].push_back(std::move(element));
    return int(json[array].size()) - 1;
  }
  int view(const void* data, std::size_t size, std::size_t stride = 0) {
    while (binary.size() % 4) binary.push_back(std::byte{0});
    Json made = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", size}};
    if (stride) made["byteStride"] = stride;
    const auto* bytes = static_cast<const std::byte*>(data);
    binary.insert(binary.end(), bytes, bytes + size);
    return add("bufferViews", made);
  }
  template <class T>
  int accessor(const std::vector<T>& values, const std::string& type, bool normalized = false) {
    const int components = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : type.back() - '0';
    return add("accessors", {{"bufferView", view(values.data(), values.size() * sizeof(T))},
                             {"componentType", type_code<T>()},
                             {"count", values.size() / std::size_t(components)},
                             {"type", type},
                             {"normalized", normalized}});
  }
  int floats(const std::vector<float>& values, const std::string& type) { return accessor(values, type); }

  int mesh(Json primitive) { return add("meshes", {{"primitives", Json::array({std::move(primitive)})}}); }
  /// A node of the scene.
  int root(Json node) {
    const int index = add("nodes", std::move(node));
    json["scenes"][0]["nodes"].push_back(index);
    return index;
  }

  /// The buffer of `binary`, then those of the JSON.
  Json buffers(Json own) const {
    Json all = Json::array({std::move(own)});
    if (json.contains("buffers"))
      for (const Json& other : json["buffers"]) all.push_back(other);
    return all;
  }
  std::vector<std::byte> glb() const {
    Json with = json;
    if (!binary.empty()) with["buffers"] = buffers({{"byteLength", binary.size()}});
    std::string text = with.dump();
    while (text.size() % 4) text += ' ';
    std::vector<std::byte> bytes;
    const auto word = [&](std::uint32_t value) {
      for (int i = 0; i < 4; ++i) bytes.push_back(std::byte(value >> (8 * i) & 0xff));
    };
    const std::size_t padded = (binary.size() + 3) / 4 * 4;
    word(0x46546C67), word(2), word(std::uint32_t(12 + 8 + text.size() + (padded ? 8 + padded : 0)));
    word(std::uint32_t(text.size())), word(0x4E4F534A);
    for (const char c : text) bytes.push_back(std::byte(c));
    if (padded == 0) return bytes;
    word(std::uint32_t(padded)), word(0x004E4942);
    bytes.insert(bytes.end(), binary.begin(), binary.end());
    bytes.resize(bytes.size() + padded - binary.size());
    return bytes;
  }
  /// The model as text, its buffer in a file or data URI named `uri`.
  std::string gltf(const std::string& uri) const {
    Json with = json;
    with["buffers"] = buffers({{"byteLength", binary.size()}, {"uri", uri}});
    return with.dump(1);
  }
};

inline std::string base64(std::span<const std::byte> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? std::uint32_t(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63];
  }
  return text;
}

/// A file with one triangle (1 0 0, 0 2 0, 0 0 3) of floats.
inline GltfBytes triangle_gltf() {
  GltfBytes g;
  g.mesh({{"attributes", {{"POSITION", g.floats({1, 0, 0, 0, 2, 0, 0, 0, 3}, "VEC3")}}}});
  return g;
}

/// One instance of everything: hierarchy, indexed mesh with normals and material, sparse accessor, instances, extras,
/// a texture, colours of vertices and two collections of primitives.
inline GltfBytes small_gltf() {
  GltfBytes g;
  const int positions = g.floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
  const int normals = g.accessor<std::int8_t>({0, 0, 127, 0, 0, 127, 0, 0, 127, 0, 0, 127}, "VEC3", true);
  const int indices = g.accessor<std::uint8_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
  const std::vector<std::uint8_t> which = {2};
  const std::vector<float> value = {2, 2, 0};
  const int sparse = g.add("accessors", g.json["accessors"][std::size_t(positions)]);
  g.json["accessors"][std::size_t(sparse)]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", g.view(which.data(), 1)}, {"componentType", 5121}}},
      {"values", {{"bufferView", g.view(value.data(), 12)}}}};
  const char* const png =
      "data:image/"
      "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAAD0lEQVR42mP4z8AARA0MAA38An892BTgAAAAAElFTkSu"
      "QmCC";
  g.add("images", {{"uri", png}});
  g.add("textures", {{"source", 0}});
  g.add("materials",
        {{"name", "paint"},
         {"pbrMetallicRoughness", {{"baseColorFactor", {1.0, 0.5, 0.25, 0.5}}, {"baseColorTexture", {{"index", 0}}}}},
         {"alphaMode", "BLEND"}});
  const int quad =
      g.mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}, {"indices", indices}, {"material", 0}});
  const int other = g.mesh({{"attributes", {{"POSITION", sparse}}}, {"mode", 6}});
  const int leaf = g.add("nodes", {{"name", "leaf"}, {"mesh", quad}, {"translation", {0, 0, 5}}});
  g.root({{"name", "top"}, {"children", {leaf}}, {"scale", {2, 2, 2}}, {"extras", {{"tag", "P-1"}, {"count", 3}}}});
  const int places = g.floats({1, 0, 0, 2, 0, 0}, "VEC3");
  g.root({{"mesh", other}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}});
  const int trees = g.floats({7, 8}, "SCALAR");
  const int colours = g.accessor<std::uint8_t>({255, 0, 0, 255, 0, 255, 0, 255}, "VEC4", true);
  const int matrices = g.floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1,  //
                                 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 8, 9, 1, 1},
                                "MAT4");
  g.root({{"name", "BoxCollection"},
          {"extensions",
           {{"EXT_mesh_gpu_instancing",
             {{"attributes", {{"_treeIndex", trees}, {"_color", colours}, {"_instanceMatrix", matrices}}}}}}}});
  const int corner = g.floats({0, 0, 0, 0, 0, 1}, "VEC3"), ones = g.floats({1, 0, 0, 1, 0, 0}, "VEC3");
  g.root({{"name", "TrapeziumCollection"},
          {"extensions",
           {{"EXT_mesh_gpu_instancing",
             {{"attributes",
               {{"_treeIndex", trees},
                {"_vertex1", corner},
                {"_vertex2", ones},
                {"_vertex3", corner},
                {"_vertex4", ones}}}}}}}});
  const int shades = g.accessor<std::uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9}, "VEC3", true);
  g.root({{"mesh", g.mesh({{"attributes", {{"POSITION", positions}, {"COLOR_0", shades}}}, {"mode", 5}})},
          {"extras", {{"treeIndex", 8}}}});
  return g;
}

}  // namespace sightline::tests
