// Checks the structure of a glTF file by the specification's own rules, without the reader: chunks, alignment, bounds,
// ranges, the tree of nodes. Returns what is wrong, one line each.
#pragma once

#include <cmath>
#include <cstring>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "sightline/importers/json/internal/json.h"

namespace sightline::tests {

class GltfStructure {
 public:
  using Json = sightline::json::Value;

  /// A whole .glb.
  explicit GltfStructure(std::span<const std::byte> file) { open(file); }
  GltfStructure(Json text, std::span<const std::byte> binary) : json(std::move(text)), binary_(binary) { check(); }

  Json json;
  std::string problems;

  std::vector<double> numbers(std::size_t accessor) const {
    const Json& a = json["accessors"][accessor];
    const Json& view = json["bufferViews"][a["bufferView"].get<std::size_t>()];
    const auto type = a["componentType"].get<int>();
    const std::size_t n = components(a), size = bytes(type) * n, count = a["count"].get<std::size_t>();
    const std::size_t stride = view.value("byteStride", size);
    std::vector<double> all;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < n; ++c)
        all.push_back(number(std::size_t(view.value("byteOffset", 0)) + std::size_t(a.value("byteOffset", 0)) +
                                 i * stride + c * bytes(type),
                             type));
    return all;
  }

 private:
  void say(const std::string& problem) { problems += problem + "\n"; }
  void open(std::span<const std::byte> file) {
    if (file.size() < 20 || std::memcmp(file.data(), "glTF", 4) != 0) return say("no GLB header");
    if (word(file, 4) != 2 || word(file, 8) != file.size()) say("version or length of the header");
    const std::uint32_t size = word(file, 12);
    if (size % 4 != 0 || word(file, 16) != 0x4E4F534A || 20 + std::uint64_t(size) > file.size())
      return say("JSON chunk");
    auto parsed = sightline::json::parse({reinterpret_cast<const char*>(file.data()) + 20, size});
    if (!parsed) return say("JSON");
    json = std::move(*parsed);
    if (file.size() > 20 + size) {
      const std::size_t at = 20 + size;
      if (file.size() < at + 8 || word(file, at) % 4 != 0 || word(file, at + 4) != 0x004E4942 ||
          at + 8 + word(file, at) != file.size())
        return say("BIN chunk");
      binary_ = file.subspan(at + 8);
    }
    check();
  }
  static std::uint32_t word(std::span<const std::byte> from, std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, from.data() + at, 4);
    return value;
  }
  static std::size_t bytes(int type) { return type <= 5121 ? 1 : type <= 5123 ? 2 : 4; }
  static std::size_t components(const Json& a) {
    const auto type = a["type"].get<std::string>();
    return type == "SCALAR" ? 1 : type == "MAT4" ? 16 : std::size_t(type.back() - '0');
  }
  double number(std::size_t at, int type) const {
    const auto value = [&]<class T>(T) {
      T read;
      std::memcpy(&read, binary_.data() + at, sizeof read);
      return double(read);
    };
    switch (type) {
      case 5120:
        return value(std::int8_t{});
      case 5121:
        return value(std::uint8_t{});
      case 5122:
        return value(std::int16_t{});
      case 5123:
        return value(std::uint16_t{});
      case 5125:
        return value(std::uint32_t{});
      default:
        return value(float{});
    }
  }
  std::size_t count(const char* array) const { return json.contains(array) ? json[array].size() : 0; }

  void check() {
    if (json["asset"]["version"] != "2.0") say("asset");
    for (const auto& [key, value] : json.items())
      if (value.is_array() && value.empty()) say("empty array " + key);
    if (count("bufferViews") > 0) check_views();
    for (std::size_t i = 0; i < count("accessors") && problems.empty(); ++i) check_accessor(i);
    if (!problems.empty()) return;
    for (std::size_t i = 0; i < count("meshes"); ++i) check_mesh(i);
    check_nodes();
    std::set<std::string> used;
    for (const Json& name : json.value("extensionsUsed", Json::array())) used.insert(name.string());
    for (const Json& name : json.value("extensionsRequired", Json::array()))
      if (!used.contains(name.string())) say("required extension that is not used");
    if (uses_instancing_ != used.contains("EXT_mesh_gpu_instancing")) say("extensionsUsed");
  }

  void check_views() {
    if (count("buffers") != 1) return say("buffers");
    const auto length = json["buffers"][0]["byteLength"].get<std::size_t>();
    if (length > binary_.size() || binary_.size() - length > 3) say("length of the buffer");
    for (std::size_t i = 0; i < count("bufferViews"); ++i) {
      const Json& view = json["bufferViews"][i];
      const std::size_t offset = view.value("byteOffset", std::size_t{0}), size = view["byteLength"].get<std::size_t>();
      if (size == 0 || offset % 4 != 0 || offset + size > length) say("buffer view " + std::to_string(i));
      if (view.contains("byteStride"))
        if (const auto stride = view["byteStride"].get<std::size_t>(); stride < 4 || stride > 252 || stride % 4 != 0)
          say("stride");
    }
  }

  void check_accessor(std::size_t i) {
    const std::string name = "accessor " + std::to_string(i);
    const Json& a = json["accessors"][i];
    if (a["bufferView"].get<std::size_t>() >= count("bufferViews")) return say(name + ": view");
    const Json& view = json["bufferViews"][a["bufferView"].get<std::size_t>()];
    const std::size_t size = bytes(a["componentType"].get<int>()), element = size * components(a);
    const std::size_t offset = a.value("byteOffset", std::size_t{0}), n = a["count"].get<std::size_t>(),
                      stride = view.value("byteStride", element);
    if (n == 0) return say(name + ": count");
    if (offset % size != 0 || stride % size != 0) say(name + ": alignment");
    if (offset + (n - 1) * stride + element > view["byteLength"].get<std::size_t>())
      return say(name + ": beyond its view");
    const std::vector<double> values = numbers(i);
    for (const double v : values)
      if (!std::isfinite(v)) return say(name + ": not finite");
    if (!a.contains("min")) return;
    for (std::size_t c = 0; c < components(a); ++c) {
      double low = INFINITY, high = -INFINITY;
      for (std::size_t k = c; k < values.size(); k += components(a)) {
        low = std::min(low, values[k]);
        high = std::max(high, values[k]);
      }
      if (a["min"][c].get<double>() != low || a["max"][c].get<double>() != high) say(name + ": min or max");
    }
  }

  void check_mesh(std::size_t i) {
    const std::string name = "mesh " + std::to_string(i);
    for (const Json& primitive : json["meshes"][i]["primitives"]) {
      const auto at = primitive["attributes"]["POSITION"].get<std::size_t>();
      const Json& positions = json["accessors"][at];
      if (positions["type"] != "VEC3" || positions["componentType"] != 5126 || !positions.contains("min"))
        say(name + ": POSITION");
      const auto vertices = positions["count"].get<std::size_t>();
      if (json["bufferViews"][positions["bufferView"].get<std::size_t>()]["target"] != 34962) say(name + ": target");
      if (primitive["attributes"].contains("NORMAL")) {
        const std::vector<double> n = numbers(primitive["attributes"]["NORMAL"].get<std::size_t>());
        if (n.size() != 3 * vertices) say(name + ": NORMAL");
        for (std::size_t k = 0; k + 2 < n.size(); k += 3)
          if (std::abs(std::hypot(n[k], n[k + 1], n[k + 2]) - 1.0) > 1e-4)
            return say(name + ": normal of another length");
      }
      if (primitive.contains("indices")) {
        const Json& accessor = json["accessors"][primitive["indices"].get<std::size_t>()];
        const auto type = accessor["componentType"].get<int>();
        if (type != 5121 && type != 5123 && type != 5125) say(name + ": type of indices");
        if (json["bufferViews"][accessor["bufferView"].get<std::size_t>()]["target"] != 34963) say(name + ": target");
        const double reserved = type == 5121 ? 255.0 : type == 5123 ? 65535.0 : 4294967295.0;
        const std::vector<double> indices = numbers(primitive["indices"].get<std::size_t>());
        if (primitive.value("mode", 4) == 4 && indices.size() % 3 != 0) say(name + ": count of indices");
        for (const double index : indices)
          if (index >= double(vertices) || index == reserved) return say(name + ": index");
      }
      if (primitive.contains("material") && primitive["material"].get<std::size_t>() >= count("materials"))
        say(name + ": material");
    }
  }

  void check_nodes() {
    std::vector<int> parents(count("nodes"));
    const auto adopt = [&](const Json& list) {
      for (const Json& child : list)
        if (child.get<std::size_t>() >= parents.size() || ++parents[child.get<std::size_t>()] > 1)
          say("node " + child.dump() + ": expected one parent");
    };
    for (const Json& scene : json["scenes"]) adopt(scene.value("nodes", Json::array()));
    for (std::size_t i = 0; i < parents.size(); ++i) {
      const Json& node = json["nodes"][i];
      adopt(node.value("children", Json::array()));
      if (node.contains("children") && node["children"].empty()) say("empty children");
      if (node.contains("mesh") && node["mesh"].get<std::size_t>() >= count("meshes")) say("mesh of a node");
      if (node.contains("matrix")) check_matrix(node["matrix"], "node " + std::to_string(i));
      if (node.contains("extensions")) check_instances(node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]);
    }
    for (std::size_t i = 0; i < parents.size(); ++i)
      if (parents[i] == 0) say("node " + std::to_string(i) + " in no scene");
  }

  void check_matrix(const Json& m, const std::string& name) {
    if (m.size() != 16 || m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) return say(name + ": matrix");
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3;
      double dot = 0.0, p = 0.0, q = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto x = m[4 * a + k].get<double>(), y = m[4 * b + k].get<double>();
        dot += x * y, p += x * x, q += y * y;
      }
      if (p == 0.0 || std::abs(dot) > 1e-5 * std::sqrt(p * q)) say(name + ": matrix that shears");
    }
  }

  void check_instances(const Json& attributes) {
    uses_instancing_ = true;
    std::set<std::size_t> counts;
    for (const auto& [key, index] : attributes.items()) {
      if (index.get<std::size_t>() >= count("accessors")) return say("accessor of " + key);
      counts.insert(json["accessors"][index.get<std::size_t>()]["count"].get<std::size_t>());
      if (key != "ROTATION") continue;
      const std::vector<double> q = numbers(index.get<std::size_t>());
      for (std::size_t k = 0; k + 3 < q.size(); k += 4)
        if (std::abs(q[k] * q[k] + q[k + 1] * q[k + 1] + q[k + 2] * q[k + 2] + q[k + 3] * q[k + 3] - 1.0) > 1e-5)
          return say("rotation of another length");
    }
    if (counts.size() != 1) say("instances of different counts");
  }

  std::span<const std::byte> binary_;
  bool uses_instancing_ = false;
};

}  // namespace sightline::tests
