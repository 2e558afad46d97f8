#include "sightline/importers/gltf/internal/gltf_collections_writer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/gltf/internal/gltf_shapes.h"
#include "sightline/importers/import.h"

namespace sightline::importers {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec2;
using core::dvec3;
using core::kNoItem;
using core::kNone;

constexpr float kTurn = float(core::kFullTurn);
constexpr std::size_t kMostParts = std::size_t{1} << 24;  // tree indices are floats
/// From here on floats are coarser than a quarter of a millimetre, and rows count from the model's middle.
constexpr double kFar = 4096.0;

/// Rows of one collection: a column of floats for each parameter.
struct Collection {
  struct Column {
    std::string name;
    int components = 1;
    std::vector<float> values;
  };
  std::vector<Column> columns;
  std::vector<float> trees;
  std::vector<std::uint8_t> colours;
};

/// What a placement leaves of a solid of revolution about z.
struct Upright {
  dvec3 x{0.0}, z{0.0};
  double across = 1.0, along = 1.0;  // scales
  bool round = false;                // circles stay circles, and z stays across them
  bool similar = false;              // and both scales are the same
  bool mirrored = false;
};

Upright upright(const dmat3& m) {
  constexpr double kSkew = 1e-6;
  const double x = glm::length(m[0]), y = glm::length(m[1]), z = glm::length(m[2]);
  Upright found;
  if (!(x > 0.0) || !(y > 0.0) || !(z > 0.0)) return found;
  found.x = m[0] / x, found.z = m[2] / z, found.across = x, found.along = z;
  found.round = std::abs(x - y) <= kSkew * x && std::abs(glm::dot(m[0], m[1])) <= kSkew * x * y &&
                std::abs(glm::dot(m[0], m[2])) <= kSkew * x * z && std::abs(glm::dot(m[1], m[2])) <= kSkew * y * z;
  found.similar = found.round && std::abs(x - z) <= kSkew * x;
  found.mirrored = glm::determinant(m) < 0.0;
  return found;
}

double size(float length) {
  return std::abs(double(length));
}

class CollectionsWriter {
 public:
  CollectionsWriter(const core::Scene& scene, const GltfWriteOptions& options, GltfOutput& output,
                    GltfWriteReport& report)
      : scene_(scene),
        options_(options),
        output_(output),
        report_(report),
        shapes_(scene, options.tolerance, output, report) {}

  core::Expected<void> run(core::NodeId top) {
    const core::AabbD box = scene_.bounds(top);
    if (!box.empty()) {
      const dvec3 reach = glm::max(glm::abs(box.min), glm::abs(box.max));
      if (std::max({reach.x, reach.y, reach.z}) > kFar) centre_ = glm::round(box.centre());
    }
    std::uint64_t items = 0;
    scene_.for_each_node(top, [&](core::NodeId node, auto&&...) {
      for (core::ItemId item = scene_.first_item(node); item != kNoItem; item = scene_.next_item(item)) ++items;
    });
    step_ = 1.0 / double(std::max<std::uint64_t>(1, items));
    scene_.for_each_node(top, [&](core::NodeId node, const Affine& world, bool visible, std::uint32_t layers,
                                  core::MaterialId material) {
      if (error_.empty()) write_node(node, node == top, world, visible, layers, material);
    });
    if (!error_.empty()) return core::fail(error_);
    prune();
    write_all_rows();
    return {};
  }

  core::Expected<void> run(core::NodeId top, std::span<const CollectionItem> items, const dvec3& centre) {
    centre_ = centre;
    rows_have_centre_ = false;
    std::unordered_map<std::uint32_t, std::size_t> parts;  // by node
    for (const CollectionItem& item : items) {
      const auto [part, added] = parts.try_emplace(item.node.index, parts_);
      tree_ = float(part->second);
      const bool written = write_item(item.id, item.state);
      ++(written ? report_.items[std::size_t(scene_.kind(item.id))] : report_.left_out);
      if (written && part->second == parts_) ++parts_;
      if (!written && part->second == parts_) parts.erase(part);
    }
    if (parts_ > kMostParts) return core::fail(too_many_parts());
    for (const CollectionItem& item : items)
      if (parts.contains(item.node.index)) place(item.node, top, parts);
    write_all_rows();
    return {};
  }

 private:
  // --- nodes -------------------------------------------------------------------------------------------------------

  void write_node(core::NodeId node, bool is_top, const Affine& world, bool visible, std::uint32_t layers,
                  core::MaterialId material) {
    const std::uint64_t left_out_before = report_.left_out;
    bool shows = false;
    tree_ = float(parts_);
    for (core::ItemId id = scene_.first_item(node); id != kNoItem && error_.empty(); id = scene_.next_item(id)) {
      if (options_.progress && !options_.progress(step_ * double(done_++))) error_ = kCancelled;
      const core::Scene::ItemState state = scene_.state(id, world, visible, layers, material);
      const bool written = (state.layers & core::kDefaultLayerMask) != 0 && write_item(id, state);
      ++(written ? report_.items[std::size_t(scene_.kind(id))] : report_.left_out);
      shows = shows || written;
    }
    if (is_top && !shows) return;
    const core::NodeId above = is_top ? core::NodeId{} : scene_.parent(node);
    const std::uint32_t index = output_.node(above.valid() && above.index < place_.size() ? place_[above.index] : kNone,
                                             node_text(node, shows ? parts_ : kMostParts));
    if (!is_top) remember(node, index);
    shows_.push_back(shows);
    lost_.push_back(report_.left_out > left_out_before);
    if (shows && ++parts_ >= kMostParts) error_ = too_many_parts();
  }

  static std::string too_many_parts() {
    return fmt::format("more than {} nodes with items, which the tree indices of collections cannot count", kMostParts);
  }

  /// Members of a node's object. `part`: its tree index; kMostParts: it has none.
  std::string node_text(core::NodeId node, std::size_t part) const {
    std::string text = "\"name\":" + json_string(scene_.name(node));
    std::string extras;
    for (const auto& [key, value] : scene_.attributes(node))
      extras += json_string(key) + ':' + json_string(value) + ',';
    if (part != kMostParts) extras += fmt::format("\"treeIndex\":{},", part);
    if (!extras.empty()) extras.pop_back(), text += ",\"extras\":{" + extras + '}';
    return text;
  }

  void remember(core::NodeId node, std::uint32_t index) {
    if (place_.size() <= node.index) place_.resize(std::size_t(node.index) + 1, kNone);
    place_[node.index] = index;
  }

  /// Writes a node and those above it, below `top`, unless they are written.
  void place(core::NodeId node, core::NodeId top, const std::unordered_map<std::uint32_t, std::size_t>& parts) {
    std::vector<core::NodeId> path;
    std::uint32_t above = kNone;
    for (; node.valid(); node = scene_.parent(node)) {
      if (const auto known = nodes_.find(node.index); known != nodes_.end()) {
        above = known->second;
        break;
      }
      path.push_back(node);
      if (node == top) break;
    }
    for (; !path.empty(); path.pop_back()) {
      const auto part = parts.find(path.back().index);
      // The root of a scene is written where it has items alone.
      if (part == parts.end() && path.back() == scene_.root()) continue;
      above = output_.node(above, node_text(path.back(), part == parts.end() ? kMostParts : part->second));
      nodes_.emplace(path.back().index, above);
    }
  }

  /// Leaves out nodes that show nothing because what they had was left out.
  void prune() {
    std::vector<bool> keep(shows_.size());
    for (std::uint32_t i = output_.node_count(); i-- > 0;) {
      keep[i] = keep[i] || shows_[i] || !lost_[i];
      const std::uint32_t parent = output_.parent(i);
      if (parent == kNone) continue;
      if (keep[i]) keep[parent] = true;
      if (lost_[i]) lost_[parent] = true;
    }
    output_.prune(keep);
  }

  void write_all_rows() {
    for (const auto& [name, rows] : rows_) write_rows(name, {}, rows);
    for (const auto& [shape, rows] : meshes_)
      write_rows("InstanceMesh", fmt::format(",\"mesh\":{}", shapes_.mesh(shape, kNone)), rows);
    if (!caps_.trees.empty()) write_rows("CircleCollection", ",\"extras\":{\"caps\":true}", caps_);
  }

  void write_rows(std::string_view name, const std::string& members, const Collection& rows) {
    std::string attributes =
        fmt::format("\"_treeIndex\":{},\"_color\":{}", output_.numbers(rows.trees, 1), output_.colours(rows.colours));
    for (const Collection::Column& column : rows.columns)
      attributes += fmt::format(",\"{}\":{}", column.name, output_.numbers(column.values, column.components));
    const std::string placement = rows_have_centre_ ? gltf_transform(core::translation(centre_)) : std::string();
    output_.node(kNone, fmt::format("\"name\":\"{}\"{}{}{},\"extensions\":{{\"EXT_mesh_gpu_instancing\":"
                                    "{{\"attributes\":{{{}}}}}}}",
                                    name, placement.empty() ? "" : ",", placement, members, attributes));
    output_.use_extension("EXT_mesh_gpu_instancing", true);
  }

  // --- items -------------------------------------------------------------------------------------------------------

  bool write_item(core::ItemId id, const core::Scene::ItemState& state) {
    const core::Material look =
        state.material == kNone ? core::Material{} : scene_.material(scene_.material_at(state.material));
    for (int i = 0; i < 3; ++i)
      colour_[i] = std::uint8_t(std::lround(255.0 * std::clamp(double(look.colour[i]), 0.0, 1.0)));
    Affine world = state.world_from_item;
    world.origin -= centre_;
    const bool primitive = int(scene_.kind(id)) < core::kPrimitiveKindCount;
    if (primitive) {
      const core::Primitive solid = scene_.primitive(id);
      const bool row = !core::is_degenerate(solid) && core::is_finite(world) &&
                       std::visit([&](const auto& of) { return write(of, world); }, solid);
      if (row) ++report_.analytic;
      if (row) return true;
    }
    if (scene_.kind(id) == core::Kind::kLine) return false;
    const GltfShapes::Scaled scaled = shapes_.shape(id, state.world_from_item);
    if (scaled.shape == kNone) return false;
    for (int c = 0; c < 3; ++c) world.linear[c] *= scaled.scale[c];
    add(meshes_[scaled.shape], {matrix(world)});
    return true;
  }

  // Each returns false when the convention has no row for the solid.

  bool write(const core::Box& b, const Affine& world) {
    Affine placement = world;
    const double sizes[3] = {size(b.size_x), size(b.size_y), size(b.size_z)};
    for (int i = 0; i < 3; ++i) placement.linear[i] *= sizes[i];
    return add("BoxCollection", {matrix(placement)});
  }
  bool write(const core::Pyramid& p, const Affine& world) {
    const bool box = p.bottom_x == p.top_x && p.bottom_y == p.top_y && p.offset_x == 0.0f && p.offset_y == 0.0f;
    return box && write(core::Box{p.bottom_x, p.bottom_y, p.height}, world);
  }
  bool write(const core::Cylinder& c, const Affine& world) {
    return write(core::Snout{c.radius, c.radius, c.height, 0, 0, 0, 0, 0, 0}, world);
  }
  bool write(const core::Sphere& s, const Affine& world) {
    const Upright to = upright(world.linear);
    if (!to.round) return false;
    const double radius = 0.5 * size(s.diameter);
    return add_ellipsoid(world.origin, to.z, radius * to.across, radius * to.along, 2.0 * radius * to.along);
  }
  bool write(const core::EllipticalDish& d, const Affine& world) {
    const Upright to = upright(world.linear);
    if (!to.round) return false;
    const double height = size(d.height) * to.along;
    add_cap(world, {0, 0, 0}, {size(d.base_radius), 0, 0}, {0, -size(d.base_radius), 0});
    return add_ellipsoid(world.origin, to.z, size(d.base_radius) * to.across, height, height);
  }
  bool write(const core::SphericalDish& d, const Affine& world) {
    const Upright to = upright(world.linear);
    if (!to.similar) return false;
    const double base = size(d.base_radius), height = size(d.height);
    const double radius = (base * base + height * height) / (2.0 * height);
    add_cap(world, {0, 0, 0}, {base, 0, 0}, {0, -base, 0});
    return add_ellipsoid(core::transform_point(world, {0, 0, height - radius}), to.z, radius * to.across,
                         radius * to.across, height * to.across);
  }
  bool write(const core::CircularTorus& t, const Affine& world) {
    const double angle = core::sweep_angle(t.angle), major = size(t.major_radius), tube = size(t.tube_radius);
    if (!(angle > 0.0) || upright(world.linear).across * tube == 0.0) return false;
    if (angle < core::kFullTurn) {
      const dvec3 out(std::cos(angle), std::sin(angle), 0);
      add_cap(world, {major, 0, 0}, {tube, 0, 0}, {0, 0, tube});
      add_cap(world, major * out, -tube * out, {0, 0, tube});
    }
    return add("TorusSegmentCollection", {matrix(world),
                                          {"_arcAngle", {angle < core::kFullTurn ? angle : double(kTurn)}},
                                          {"_radius", {major}},
                                          {"_tubeRadius", {tube}}});
  }

  bool write(const core::Snout& s, const Affine& world) {
    const Upright to = upright(world.linear);
    const double low = size(s.bottom_radius), high = size(s.top_radius), height = size(s.height);
    if (!to.round || !(height > 0.0)) return false;
    const dvec2 lean(s.offset_x, s.offset_y);
    const dvec2 slope_b = slope(s.bottom_shear_x, s.bottom_shear_y), slope_a = slope(s.top_shear_x, s.top_shear_y);
    const bool leans = lean != dvec2(0.0), slanted = slope_a != dvec2(0.0) || slope_b != dvec2(0.0);
    const dvec3 end(0.5 * lean, 0.5 * height);
    if (!slanted) {
      add_cap(world, -end, {low, 0, 0}, {0, -low, 0});
      add_cap(world, end, {high, 0, 0}, {0, high, 0});
      const dvec3 a = core::transform_point(world, end), b = core::transform_point(world, -end);
      if (leans)
        return add("EccentricConeCollection", {point("_centerA", a),
                                               point("_centerB", b),
                                               {"_radiusA", {high * to.across}},
                                               {"_radiusB", {low * to.across}},
                                               point("_normal", to.z)});
      return add("ConeCollection", {point("_centerA", a),
                                    point("_centerB", b),
                                    {"_radiusA", {high * to.across}},
                                    {"_radiusB", {low * to.across}},
                                    point("_localXAxis", to.x),
                                    {"_angle", {0.0}},
                                    {"_arcAngle", {double(kTurn)}}});
    }
    constexpr double kSteep = 1e3;
    if (leans || low != high || !to.similar || glm::length(slope_a) > kSteep || glm::length(slope_b) > kSteep)
      return false;
    // The convention's centres lie where the slanted ends would end on their longer sides.
    const dvec3 a(0, 0, 0.5 * height + low * glm::length(slope_a));
    const dvec3 b(0, 0, -0.5 * height - low * glm::length(slope_b));
    const double hand = to.mirrored ? -1.0 : 1.0;
    const dvec3 out_a = glm::normalize(dvec3(-slope_a.x, -hand * slope_a.y, 1.0));
    const dvec3 out_b = glm::normalize(dvec3(slope_b.x, hand * slope_b.y, -1.0));
    add_cap(world, {0, 0, 0.5 * height}, low * dvec3(1, 0, slope_a.x), low * dvec3(0, 1, slope_a.y));
    add_cap(world, {0, 0, -0.5 * height}, low * dvec3(1, 0, slope_b.x), -low * dvec3(0, 1, slope_b.y));
    const double length = (a.z - b.z) * to.across;
    return add("GeneralCylinderCollection", {point("_centerA", core::transform_point(world, a)),
                                             point("_centerB", core::transform_point(world, b)),
                                             {"_radius", {low * to.across}},
                                             {"_planeA", {out_a.x, out_a.y, out_a.z, length}},
                                             {"_planeB", {out_b.x, out_b.y, out_b.z, length}},
                                             point("_localXAxis", to.x),
                                             {"_angle", {0.0}},
                                             {"_arcAngle", {double(kTurn)}}});
  }

  bool write(const core::RectangularTorus&, const Affine&) { return false; }
  bool write(const core::Line&, const Affine&) { return false; }

  // --- rows --------------------------------------------------------------------------------------------------------

  static dvec2 slope(float shear_x, float shear_y) { return {std::tan(double(shear_x)), std::tan(double(shear_y))}; }

  struct Parameter {
    const char* name;
    std::vector<double> numbers;
  };
  static Parameter point(const char* name, const dvec3& p) { return {name, {p.x, p.y, p.z}}; }
  static Parameter matrix(const Affine& m) {
    const dmat3& l = m.linear;
    return {"_instanceMatrix",
            {l[0].x, l[0].y, l[0].z, 0, l[1].x, l[1].y, l[1].z, 0, l[2].x, l[2].y, l[2].z, 0, m.origin.x, m.origin.y,
             m.origin.z, 1}};
  }

  bool add_ellipsoid(const dvec3& centre, const dvec3& normal, double across, double along, double height) {
    return add("EllipsoidSegmentCollection", {point("_center", centre),
                                              point("_normal", normal),
                                              {"_horizontalRadius", {across}},
                                              {"_verticalRadius", {along}},
                                              {"_height", {height}}});
  }

  /// A disc about `centre`, in the item's coordinates, with two radii whose cross product points outwards.
  void add_cap(const Affine& world, const dvec3& centre, const dvec3& u, const dvec3& v) {
    const double hand = glm::determinant(world.linear) < 0.0 ? -1.0 : 1.0;
    const dvec3 across = world.linear * u, up = hand * (world.linear * v), normal = glm::cross(across, up);
    const double area = glm::length(normal);
    if (!(area > 0.0)) return;  // of a tip
    const Affine placement{dmat3(2.0 * across, 2.0 * up, normal / area), core::transform_point(world, centre)};
    add(caps_, {matrix(placement), point("_normal", normal / area)});
  }

  bool add(const char* name, const std::vector<Parameter>& parameters) { return add(rows_[name], parameters); }
  bool add(Collection& to, const std::vector<Parameter>& parameters) {
    if (to.columns.empty())
      for (const Parameter& p : parameters) to.columns.push_back({p.name, int(p.numbers.size()), {}});
    for (std::size_t i = 0; i < parameters.size(); ++i)
      for (const double number : parameters[i].numbers) to.columns[i].values.push_back(float(number));
    to.trees.push_back(tree_);
    to.colours.insert(to.colours.end(), {colour_[0], colour_[1], colour_[2], 255});
    return true;
  }

  const core::Scene& scene_;
  const GltfWriteOptions& options_;
  GltfOutput& output_;
  GltfWriteReport& report_;
  GltfShapes shapes_;
  dvec3 centre_{0.0};
  bool rows_have_centre_ = true;  // no: the file is relative to it
  std::map<std::string, Collection> rows_;
  std::map<std::uint32_t, Collection> meshes_;  // by shape
  Collection caps_;
  std::vector<std::uint32_t> place_;                        // in the file, of each node of the scene
  std::unordered_map<std::uint32_t, std::uint32_t> nodes_;  // the same where few are written
  std::vector<bool> shows_, lost_;
  std::size_t parts_ = 0;
  float tree_ = 0.0f;            // of the present node
  std::uint8_t colour_[3] = {};  // of the present item
  std::uint64_t done_ = 0;
  double step_ = 1.0;
  std::string error_;
};

}  // namespace

core::Expected<void> write_collections(const core::Scene& scene, core::NodeId top, const GltfWriteOptions& options,
                                       GltfOutput& output, GltfWriteReport& report) {
  return CollectionsWriter(scene, options, output, report).run(top);
}

core::Expected<void> write_collections(const core::Scene& scene, core::NodeId top, const CollectionPart& part,
                                       const GltfWriteOptions& options, GltfOutput& output, GltfWriteReport& report) {
  return CollectionsWriter(scene, options, output, report).run(top, part.items, part.centre);
}

}  // namespace sightline::importers
