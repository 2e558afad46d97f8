// Checks a folder of 3D Tiles by the specification's own rules (OGC 22-025r4), without the writer: properties, volumes,
// errors, transforms, files. Returns what is wrong, one line each, and the tiles for closer looks.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/tests/importers/gltf_structure.h"

namespace sightline::tests {

class TilesStructure {
 public:
  using Json = sightline::json::Value;

  struct Tile {
    core::Affine world_from_tile;
    core::AabbD box;  // in the tile's coordinates
    double error = 0.0;
    std::filesystem::path content;  // empty: none
    std::vector<std::size_t> children;
    std::size_t depth = 0;
  };

  explicit TilesStructure(const std::filesystem::path& folder) : folder_(folder) { open(); }

  Json json;
  std::string problems;
  std::vector<Tile> tiles;  // the root first

 private:
  void say(const std::string& problem) { problems += problem + "\n"; }
  static bool is_number(const Json& value) { return value.is_number() && std::isfinite(value.get<double>()); }

  void open() {
    const auto bytes = importers::read_file_bytes(folder_ / "tileset.json");
    if (!bytes) return say("no tileset.json");
    auto parsed = sightline::json::parse({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
    if (!parsed) return say("tileset.json is not JSON");
    json = std::move(*parsed);
    check();
  }

  void check() {
    if (!json.contains("asset") || json["asset"]["version"] != "1.1") say("asset.version");
    if (!json.contains("geometricError") || !is_number(json["geometricError"])) return say("geometricError");
    if (!json.contains("root")) return say("root");
    for (const auto& [key, value] : json.items())
      if (!std::set<std::string>{"asset", "geometricError", "root"}.contains(key)) say("unknown property " + key);
    add(json["root"], {}, 0);
    if (!tiles.empty() && tiles[0].error > json["geometricError"].get<double>()) say("error of the tileset");
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_)) files += entry.is_regular_file();
    if (files != contents_.size() + 1) say("files that no tile has");
  }

  static core::Affine affine(const Json& m) {
    const auto at = [&](std::size_t i) { return m[i].get<double>(); };
    return {core::dmat3(at(0), at(1), at(2), at(4), at(5), at(6), at(8), at(9), at(10)), {at(12), at(13), at(14)}};
  }

  std::size_t add(const Json& tile, const core::Affine& world_from_parent, std::size_t depth) {
    const std::size_t number = tiles.size();
    const std::string name = "tile " + std::to_string(number);
    tiles.push_back({world_from_parent, {}, 0.0, {}, {}, depth});
    for (const auto& [key, value] : tile.items())
      if (!std::set<std::string>{"boundingVolume", "geometricError", "refine", "content", "children", "transform"}
               .contains(key))
        say(name + ": unknown property " + key);
    if (tile.contains("transform")) check_transform(tile["transform"], name, tiles[number].world_from_tile);
    if (!tile.contains("geometricError") || !is_number(tile["geometricError"]) ||
        tile["geometricError"].get<double>() < 0.0) {
      say(name + ": geometricError");
      return number;
    }
    tiles[number].error = tile["geometricError"].get<double>();
    if (depth == 0 && !tile.contains("refine")) say("refine of the root");
    if (tile.contains("refine") && tile["refine"] != "REPLACE" && tile["refine"] != "ADD") say(name + ": refine");
    if (!tile.contains("boundingVolume") || !tile["boundingVolume"].contains("box")) {
      say(name + ": boundingVolume");
      return number;
    }
    check_box(tile["boundingVolume"]["box"], name, tiles[number].box);
    if (tile.contains("content")) check_content(tile["content"], name, tiles[number].content);
    if (!tile.contains("children")) return number;
    if (tile["children"].empty()) say(name + ": empty children");
    for (const Json& child : tile["children"]) {
      const std::size_t at = add(child, tiles[number].world_from_tile, depth + 1);
      tiles[number].children.push_back(at);
      if (tiles[at].error > tiles[number].error) say(name + ": an error that grows");
      check_nesting(child, number, at, name);
    }
    return number;
  }

  void check_transform(const Json& m, const std::string& name, core::Affine& world) {
    if (m.size() != 16 || m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) return say(name + ": transform");
    const core::Affine local = affine(m);
    if (std::abs(glm::determinant(local.linear)) < 1e-12) say(name + ": singular transform");
    world = world * local;
  }

  /// Axes along the coordinates, which the writer has.
  void check_box(const Json& box, const std::string& name, core::AabbD& to) {
    if (box.size() != 12) return say(name + ": box");
    for (const std::size_t zero : {4, 5, 6, 8, 9, 10})
      if (box[zero] != 0) return say(name + ": axes of the box");
    for (int i = 0; i < 3; ++i) {
      const double centre = box[std::size_t(i)].get<double>(), half = box[std::size_t(3 + 4 * i)].get<double>();
      if (!(half > 0.0) || !std::isfinite(centre)) say(name + ": extent of the box");
      to.min[i] = centre - half, to.max[i] = centre + half;
    }
  }

  void check_content(const Json& content, const std::string& name, std::filesystem::path& to) {
    if (!content.contains("uri") || !content["uri"].is_string()) return say(name + ": uri");
    const std::string uri = content["uri"].string();
    to = folder_ / uri;
    if (!std::filesystem::is_regular_file(to)) say(name + ": no file " + uri);
    if (!contents_.insert(uri).second) say(name + ": a file of two tiles");
  }

  /// To the bit: centres and boxes are on a grid.
  void check_nesting(const Json& child, std::size_t parent, std::size_t at, const std::string& name) {
    const core::Affine local = child.contains("transform") ? affine(child["transform"]) : core::Affine();
    if (local.linear != core::dmat3(1.0)) return say(name + ": a child that turns");
    const core::AabbD &outer = tiles[parent].box, &inner = tiles[at].box;
    for (int i = 0; i < 3; ++i)
      if (inner.min[i] + local.origin[i] < outer.min[i] || inner.max[i] + local.origin[i] > outer.max[i])
        say(name + ": the box of a child lies outside");
  }

  std::filesystem::path folder_;
  std::set<std::string> contents_;
};

/// Triangles of a tile's content by feature, in the tile's coordinates, as a viewer places them: in floats.
class TileTriangles {
 public:
  using Json = sightline::json::Value;
  using Triangle = std::array<core::dvec3, 3>;
  struct Feature {
    double node = -1.0;  // number of the node, from the property table
    std::vector<Triangle> triangles;
  };

  /// `content`: not compressed.
  explicit TileTriangles(const std::filesystem::path& content)
      : bytes_(importers::read_file_bytes(content).value()), structure(bytes_) {
    const Json& json = structure.json;
    if (!structure.problems.empty()) return;
    const Json& table = json["extensions"]["EXT_structural_metadata"]["propertyTables"][0];
    rows = table["count"].get<std::size_t>();
    nodes_ = column(table["properties"]["node"]["values"].get<std::size_t>());
    for (const Json& node : json["nodes"]) add(node);
  }

  std::size_t rows = 0;
  std::vector<Feature> features;  // by row
  std::size_t triangles = 0, instances = 0;
  core::AabbD box;  // of all positions, lines included

 private:
  std::vector<std::byte> bytes_;

 public:
  GltfStructure structure;

  std::span<const std::byte> view(std::size_t index) const {
    const Json& of = structure.json["bufferViews"][index];
    const std::size_t json_size = 20 + word(12);
    return std::span(bytes_).subspan(json_size + 8 + of.value("byteOffset", std::size_t{0}),
                                     of["byteLength"].get<std::size_t>());
  }
  std::vector<std::uint32_t> column(std::size_t index) const {
    const auto from = view(index);
    std::vector<std::uint32_t> values(from.size() / 4);
    std::memcpy(values.data(), from.data(), from.size());
    return values;
  }
  /// Strings of a property; empty where the table has no such property.
  std::vector<std::string> strings(const std::string& property) const {
    const Json& properties = structure.json["extensions"]["EXT_structural_metadata"]["propertyTables"][0]["properties"];
    if (!properties.contains(property)) return std::vector<std::string>(rows);
    const auto text = view(properties[property]["values"].get<std::size_t>());
    const auto offsets = column(properties[property]["stringOffsets"].get<std::size_t>());
    std::vector<std::string> all;
    for (std::size_t row = 0; row + 1 < offsets.size(); ++row)
      all.emplace_back(reinterpret_cast<const char*>(text.data()) + offsets[row], offsets[row + 1] - offsets[row]);
    return all;
  }
  std::vector<std::uint32_t> numbers(const std::string& property) const {
    const Json& table = structure.json["extensions"]["EXT_structural_metadata"]["propertyTables"][0];
    return column(table["properties"][property]["values"].get<std::size_t>());
  }

 private:
  std::uint32_t word(std::size_t at) const {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes_.data() + at, 4);
    return value;
  }

  Feature& feature(double row) {
    if (features.size() < rows) features.resize(rows);
    Feature& found = features.at(std::size_t(row));
    found.node = nodes_.at(std::size_t(row));
    return found;
  }

  void add(const Json& node) {
    if (!node.contains("mesh")) return;
    for (const Json& primitive : structure.json["meshes"][node["mesh"].get<std::size_t>()]["primitives"]) {
      const std::vector<double> points = structure.numbers(primitive["attributes"]["POSITION"].get<std::size_t>());
      std::vector<double> corners;
      if (primitive.contains("indices")) corners = structure.numbers(primitive["indices"].get<std::size_t>());
      if (node.contains("extensions"))
        add_instances(node["extensions"], points, corners);
      else
        add_features(primitive, points, corners);
    }
  }

  static core::vec3 point(const std::vector<double>& points, double index) {
    const std::size_t i = 3 * std::size_t(index);
    return {float(points[i]), float(points[i + 1]), float(points[i + 2])};
  }
  /// y up to z up, as viewers of 3D Tiles do it.
  core::dvec3 in_tile(const core::vec3& p) {
    const core::dvec3 turned(p.x, -p.z, p.y);
    box.grow(turned);
    return turned;
  }

  void add_features(const Json& primitive, const std::vector<double>& points, const std::vector<double>& corners) {
    const std::vector<double> ids = structure.numbers(primitive["attributes"]["_FEATURE_ID_0"].get<std::size_t>());
    for (std::size_t i = 0; i < points.size() / 3; ++i) in_tile(point(points, double(i))), feature(ids[i]);
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k) triangle[k] = in_tile(point(points, corners[i + k]));
      feature(ids[std::size_t(corners[i])]).triangles.push_back(triangle);
      ++triangles;
    }
  }

  void add_instances(const Json& extensions, const std::vector<double>& points, const std::vector<double>& corners) {
    const Json& attributes = extensions["EXT_mesh_gpu_instancing"]["attributes"];
    const auto values = [&](const char* name) { return structure.numbers(attributes[name].get<std::size_t>()); };
    const auto t = values("TRANSLATION"), r = values("ROTATION"), s = values("SCALE"), ids = values("_FEATURE_ID_0");
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const auto x = float(r[4 * i]), y = float(r[4 * i + 1]), z = float(r[4 * i + 2]), w = float(r[4 * i + 3]);
      glm::mat3 m(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 2 * (x * y - z * w),
                  1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 2 * (x * z + y * w), 2 * (y * z - x * w),
                  1 - 2 * (x * x + y * y));
      for (int c = 0; c < 3; ++c) m[c] *= float(s[3 * i + std::size_t(c)]);
      const core::vec3 origin{float(t[3 * i]), float(t[3 * i + 1]), float(t[3 * i + 2])};
      ++instances;
      for (std::size_t k = 0; k < corners.size(); k += 3) {
        Triangle triangle;
        for (std::size_t v = 0; v < 3; ++v) triangle[v] = in_tile(m * point(points, corners[k + v]) + origin);
        feature(ids[i]).triangles.push_back(triangle);
        ++triangles;
      }
    }
  }

  std::vector<std::uint32_t> nodes_;
};

}  // namespace sightline::tests
