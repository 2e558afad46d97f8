#include "sightline/importers/gltf/internal/gltf_collections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <variant>

#include <fmt/format.h>

namespace sightline::importers {
namespace {

using core::dvec2;
using core::dvec3;

constexpr double kPi = 3.14159265358979323846;
constexpr double kWholeTurn = 2.0 * kPi - 1e-5;  // writers compute angles in float

struct PlacedSolid {
  core::Primitive primitive;
  core::Affine placement;
};
struct Nut {
  core::Affine placement;
};
/// Faces to be gathered into a mesh.
struct LooseFaces {
  std::vector<dvec3> positions;
  std::vector<std::uint32_t> corners;
};
using Shape = std::variant<std::monostate, PlacedSolid, Nut, LooseFaces>;  // monostate: cannot be drawn

/// One instance's numbers, in the order of its kind's columns, after tree index and colour.
using Row = std::array<const double*, 9>;

dvec3 vector_at(const double* v) {
  return {v[0], v[1], v[2]};
}

/// The frame at `origin` whose z is `z` (of any length but 0) and whose x is as near to `x` as that allows.
core::Affine frame(const dvec3& origin, const dvec3& z, const dvec3& x) {
  const dvec3 axis = glm::normalize(z);
  dvec3 side = x - axis * glm::dot(x, axis);
  if (!(glm::length(side) > 1e-6 * glm::length(x)))
    side = glm::cross(axis, std::abs(axis.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0));
  side = glm::normalize(side);
  return {core::dmat3(side, glm::cross(axis, side), axis), origin};
}

core::Affine turned(const core::Affine& placement, double angle) {
  core::Affine turn;
  turn.linear = core::dmat3(std::cos(angle), std::sin(angle), 0, -std::sin(angle), std::cos(angle), 0, 0, 0, 1);
  return placement * turn;
}

core::Affine scaled_along_z(core::Affine placement, double factor) {
  placement.linear[2] *= factor;
  return placement;
}

/// The placement of something flat in z = 0. The matrix's third column says nothing and is often 0; the placement gets
/// one that makes it invertible.
core::Affine flat(const double* matrix) {
  core::Affine placement = gltf_affine(matrix);
  const dvec3 normal = glm::cross(placement.linear[0], placement.linear[1]);
  const double area = glm::length(normal);
  if (area > 0.0) placement.linear[2] = normal / std::sqrt(area);
  return placement;
}

/// Facets of the part of a wall over an arc. `rim` gives the lower and upper point of the wall in a direction.
template <class Rim>
Shape facets(const core::Affine& placement, double angle, double arc, Rim&& rim) {
  const double step = 2.0 * std::acos(1.0 - kFacetError);
  const int pieces = std::max(1, int(std::ceil(std::min(arc, 2.0 * kPi) / step)));
  LooseFaces faces;
  for (int i = 0; i <= pieces; ++i) {
    const double at = angle + std::min(arc, 2.0 * kPi) * i / pieces;
    const auto [low, high] = rim(dvec2(std::cos(at), std::sin(at)));
    faces.positions.push_back(core::transform_point(placement, low));
    faces.positions.push_back(core::transform_point(placement, high));
    if (i == 0) continue;
    const std::uint32_t a = std::uint32_t(2 * i - 2), b = a + 1, c = a + 2, d = a + 3;
    faces.corners.insert(faces.corners.end(), {a, c, d, a, d, b});
  }
  return faces;
}

Shape box(const Row& row) {
  return PlacedSolid{core::Box{1, 1, 1}, gltf_affine(row[0])};
}

Shape quad(const Row& row) {
  return PlacedSolid{core::Box{1, 1, 0}, flat(row[0])};
}

Shape circle(const Row& row) {
  return PlacedSolid{core::Cylinder{0.5f, 0}, flat(row[0])};
}

Shape nut(const Row& row) {
  return Nut{gltf_affine(row[0])};
}

Shape ring(const Row& row) {
  const double angle = *row[1], arc = *row[2], thickness = std::clamp(*row[3], 0.0, 1.0);
  if (!(arc > 0.0)) return {};
  return PlacedSolid{core::RectangularTorus{float(0.5 * (1.0 - thickness)), 0.5f, 0, float(std::min(arc, 2.0 * kPi))},
                     turned(flat(row[0]), angle)};
}

Shape torus(const Row& row) {
  const double arc = *row[1];
  if (!(arc > 0.0)) return {};
  return PlacedSolid{core::CircularTorus{float(*row[2]), float(*row[3]), float(std::min(arc, 2.0 * kPi))},
                     gltf_affine(row[0])};
}

Shape cone(const Row& row) {
  const dvec3 a = vector_at(row[0]), b = vector_at(row[1]);
  const double ra = *row[2], rb = *row[3], angle = *row[5], arc = *row[6], length = glm::length(a - b);
  if (!(length > 0.0) || !(arc > 0.0)) return {};
  const core::Affine placement = frame(0.5 * (a + b), a - b, vector_at(row[4]));
  const bool whole = arc >= kWholeTurn, straight = ra == rb;
  if (whole && straight) return PlacedSolid{core::Cylinder{float(ra), float(length)}, placement};
  if (whole) return PlacedSolid{core::Snout{float(rb), float(ra), float(length), 0, 0, 0, 0, 0, 0}, placement};
  if (straight)  // a bent sheet: a ring without thickness
    return PlacedSolid{core::RectangularTorus{float(ra), float(ra), float(length), float(arc)},
                       turned(placement, angle)};
  return facets(placement, angle, arc,
                [&](const dvec2& e) { return std::pair(dvec3(rb * e, -0.5 * length), dvec3(ra * e, 0.5 * length)); });
}

Shape eccentric_cone(const Row& row) {
  const dvec3 a = vector_at(row[0]), b = vector_at(row[1]);
  dvec3 normal = vector_at(row[4]);
  if (!(glm::length(normal) > 0.0)) return {};
  if (glm::dot(a - b, normal) < 0.0) normal = -normal;
  const core::Affine placement = frame(0.5 * (a + b), normal, dvec3(1, 0, 0));
  const dvec3 lean = glm::transpose(placement.linear) * (a - b);
  return PlacedSolid{
      core::Snout{float(*row[3]), float(*row[2]), float(lean.z), float(lean.x), float(lean.y), 0, 0, 0, 0}, placement};
}

Shape ellipsoid_segment(const Row& row) {
  const dvec3 centre = vector_at(row[0]), normal = vector_at(row[1]);
  const double across = std::abs(*row[2]), along = std::abs(*row[3]), height = *row[4];
  if (!(glm::length(normal) > 0.0) || !(height > 0.0) || !(along > 0.0)) return {};
  const core::Affine upright = frame(centre, normal, dvec3(1, 0, 0));
  // A sphere of the horizontal radius, stretched along the normal.
  const core::Affine stretched = scaled_along_z(upright, across > 0.0 ? along / across : 1.0);
  if (height >= 2.0 * along) return PlacedSolid{core::Sphere{float(2.0 * across)}, stretched};
  if (height == along) return PlacedSolid{core::EllipticalDish{float(across), float(along)}, upright};
  const double cap = across * height / along, base = std::sqrt(cap * (2.0 * across - cap));
  return PlacedSolid{core::SphericalDish{float(base), float(cap)},
                     stretched * core::translation({0.0, 0.0, across - cap})};
}

/// Where a slanted end cuts its axis, measured from B, and the slope of its plane along x and y.
struct SlantedEnd {
  double z;
  dvec2 slope;
  bool slanted() const { return slope.x != 0.0 || slope.y != 0.0; }
};
/// `outward` is +1 for end A, -1 for B. Nothing: the plane does not face its end of the axis.
std::optional<SlantedEnd> slanted_end(const double* plane, double outward, double length, double radius) {
  const dvec3 n = vector_at(plane) * outward;
  if (!(n.z > 1e-6 * glm::length(n))) return {};
  const double cut = radius * std::hypot(n.x, n.y) / n.z;
  return SlantedEnd{outward > 0.0 ? length - cut : cut, dvec2(-n.x, -n.y) / n.z};
}

Shape general_cylinder(const Row& row) {
  const dvec3 a = vector_at(row[0]), b = vector_at(row[1]);
  const double radius = std::abs(*row[2]), angle = *row[6], arc = *row[7], length = glm::length(a - b);
  if (!(length > 0.0) || !(arc > 0.0)) return {};
  const auto top = slanted_end(row[3], 1.0, length, radius), bottom = slanted_end(row[4], -1.0, length, radius);
  if (!top || !bottom) return {};
  const dvec3 axis = (a - b) / length;
  const core::Affine at_b = frame(b, axis, vector_at(row[5]));
  const core::Affine middle = at_b * core::translation({0.0, 0.0, 0.5 * (top->z + bottom->z)});
  const double height = top->z - bottom->z;
  const bool whole = arc >= kWholeTurn;
  if (whole && height > 0.0 && !top->slanted() && !bottom->slanted())
    return PlacedSolid{core::Cylinder{float(radius), float(height)}, middle};
  if (whole && height > 0.0)
    return PlacedSolid{
        core::Snout{float(radius), float(radius), float(height), 0, 0, float(std::atan(bottom->slope.x)),
                    float(std::atan(bottom->slope.y)), float(std::atan(top->slope.x)), float(std::atan(top->slope.y))},
        middle};
  return facets(at_b, angle, arc, [&](const dvec2& e) {
    const double low = bottom->z + radius * glm::dot(bottom->slope, e);
    const double high = top->z + radius * glm::dot(top->slope, e);
    return std::pair(dvec3(radius * e, low), dvec3(radius * e, std::max(low, high)));
  });
}

Shape trapezium(const Row& row) {
  return LooseFaces{{vector_at(row[0]), vector_at(row[1]), vector_at(row[2]), vector_at(row[3])}, {0, 1, 3, 0, 3, 2}};
}

struct Kind {
  std::string_view name;
  Shape (*shape)(const Row&);
  std::vector<GltfTable::Column> columns;
};

const std::vector<Kind>& kinds() {
  static const GltfTable::Column matrix{"_instanceMatrix", 16, true};
  static const std::vector<Kind> all = {
      {"BoxCollection", box, {matrix}},
      {"QuadCollection", quad, {matrix}},
      {"CircleCollection", circle, {matrix}},
      {"NutCollection", nut, {matrix}},
      {"GeneralRingCollection", ring, {matrix, {"_angle", 1, true}, {"_arcAngle", 1, true}, {"_thickness", 1, true}}},
      {"TorusSegmentCollection",
       torus,
       {matrix, {"_arcAngle", 1, true}, {"_radius", 1, true}, {"_tubeRadius", 1, true}}},
      {"ConeCollection",
       cone,
       {{"_centerA", 3, true},
        {"_centerB", 3, true},
        {"_radiusA", 1, true},
        {"_radiusB", 1, true},
        {"_localXAxis", 3, true},
        {"_angle", 1, true},
        {"_arcAngle", 1, true}}},
      {"EccentricConeCollection",
       eccentric_cone,
       {{"_centerA", 3, true},
        {"_centerB", 3, true},
        {"_radiusA", 1, true},
        {"_radiusB", 1, true},
        {"_normal", 3, true}}},
      {"EllipsoidSegmentCollection",
       ellipsoid_segment,
       {{"_center", 3, true},
        {"_normal", 3, true},
        {"_horizontalRadius", 1, true},
        {"_verticalRadius", 1, true},
        {"_height", 1, true}}},
      {"GeneralCylinderCollection",
       general_cylinder,
       {{"_centerA", 3, true},
        {"_centerB", 3, true},
        {"_radius", 1, true},
        {"_planeA", 4, true},
        {"_planeB", 4, true},
        {"_localXAxis", 3, true},
        {"_angle", 1, true},
        {"_arcAngle", 1, true}}},
      {"TrapeziumCollection",
       trapezium,
       {{"_vertex1", 3, true}, {"_vertex2", 3, true}, {"_vertex3", 3, true}, {"_vertex4", 3, true}}},
  };
  return all;
}

const Kind* kind_named(std::string_view name) {
  for (const Kind& kind : kinds())
    if (kind.name == name) return &kind;
  return nullptr;
}

core::Mesh nut_mesh() {
  core::Mesh mesh;
  mesh.name = "nut";
  for (const float z : {-0.5f, 0.5f})
    for (int i = 0; i < 6; ++i)
      mesh.positions.emplace_back(-0.5 * std::sin(i * kPi / 3.0), 0.5 * std::cos(i * kPi / 3.0), z);
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t next = (i + 1) % 6;
    mesh.indices.insert(mesh.indices.end(), {i, next, next + 6, i, next + 6, i + 6});
    if (i > 1) mesh.indices.insert(mesh.indices.end(), {0, i, i - 1, 6, i + 5, i + 6});
  }
  return mesh;
}

/// Gathers the faces of consecutive instances that share part and colour, and passes them to `add` as one mesh.
class Gathered {
 public:
  template <class Add>
  void take(std::uint64_t key, LooseFaces&& faces, Add&& add) {
    constexpr std::size_t kMany = 1 << 16;
    if (key != key_ || mesh_.positions.size() > kMany) flush(add);
    key_ = key;
    const auto base = std::uint32_t(mesh_.positions.size());
    mesh_.positions.insert(mesh_.positions.end(), faces.positions.begin(), faces.positions.end());
    for (const std::uint32_t corner : faces.corners) mesh_.corners.push_back(base + corner);
  }
  template <class Add>
  void flush(Add&& add) {
    if (!mesh_.corners.empty()) add(std::as_const(mesh_));
    mesh_ = {};
  }

 private:
  std::uint64_t key_ = 0;
  PolygonMesh mesh_;
};

std::optional<std::uint32_t> part_of(const double* tree_index) {
  if (!tree_index || !(*tree_index >= 0.0 && *tree_index < double(core::kNone))) return {};
  return std::uint32_t(*tree_index);
}

/// Red, green and blue as bytes.
std::uint32_t bytes_of(const double* colour, const GltfAccessor& accessor) {
  std::uint32_t bytes = 0;
  for (int i = 0; i < 3; ++i)
    bytes |= std::uint32_t(std::lround(255.0 * gltf_colour_channel(colour[i], accessor))) << (8 * i);
  return bytes;
}

}  // namespace

bool GltfCollections::is_collection(std::string_view node_name) {
  return kind_named(node_name) != nullptr;
}

bool GltfCollections::follows_convention(const GltfDocument& document) {
  const auto named = [](const Json& json) {
    const Json* attributes = gltf_find(json, "attributes");
    return attributes && gltf_find(*attributes, "_treeIndex");
  };
  if (const Json* nodes = gltf_find(document.root(), "nodes"))
    for (const Json& node : *nodes)
      if (const Json* extensions = gltf_find(node, "extensions"))
        if (const Json* instancing = gltf_find(*extensions, "EXT_mesh_gpu_instancing");
            instancing && named(*instancing))
          return true;
  if (const Json* meshes = gltf_find(document.root(), "meshes"))
    for (const Json& mesh : *meshes)
      if (const Json* primitives = gltf_find(mesh, "primitives"); primitives && primitives->is_array())
        if (std::any_of(primitives->begin(), primitives->end(), named)) return true;
  return false;
}

GltfCollections::Place GltfCollections::place(const double* tree_index, core::NodeId fallback,
                                              const core::Affine& file_from_node, const core::Affine& node_from_item) {
  const auto part = part_of(tree_index);
  if (!part) return {fallback, node_from_item};
  Part& known = parts_[*part];
  if (!known.node.valid()) known.node = job_.scene().add_node(job_.file_node(), std::to_string(*part));
  return {known.node, known.node_from_file * file_from_node * node_from_item};
}

void GltfCollections::name_part(std::uint32_t tree_index, core::NodeId node, const core::Affine& file_from_node) {
  const double determinant = glm::determinant(file_from_node.linear);
  if (determinant == 0.0 || !std::isfinite(1.0 / determinant)) return;
  const core::dmat3 inverse = glm::inverse(file_from_node.linear);
  parts_.try_emplace(tree_index, Part{node, {inverse, -(inverse * file_from_node.origin)}});
}

core::MaterialId GltfCollections::material(const double* colour, const GltfAccessor* accessor) {
  if (!colour) return {};
  const std::uint32_t bytes = bytes_of(colour, *accessor);
  core::MaterialId& known = materials_[bytes];
  if (known.valid()) return known;
  core::Material material;
  material.name = fmt::format("#{:02x}{:02x}{:02x}", bytes & 0xff, bytes >> 8 & 0xff, bytes >> 16 & 0xff);
  for (int i = 0; i < 3; ++i) material.colour[i] = float(bytes >> (8 * i) & 0xff) / 255.0f;
  return known = job_.scene().add_material(std::move(material));
}

void GltfCollections::add(std::string_view kind_name, const Json& attributes, core::NodeId node,
                          const core::Affine& file_from_node, const std::string& where, const Progress& progress) {
  const Kind& kind = *kind_named(kind_name);
  constexpr std::size_t kTree = 0, kColour = 1, kFirst = 2;
  std::vector<GltfTable::Column> columns = {{"_treeIndex", 1}, {"_color", 4}};
  columns.insert(columns.end(), kind.columns.begin(), kind.columns.end());
  GltfTable table;
  table.open(document_, attributes, columns, where);
  if (!document_.take_items(table.count()))
    gltf_fail("{}: more instances than a file of {} bytes may hold", where, document_.bytes_read());

  std::uint64_t shapeless = 0;
  Gathered gathered;
  core::NodeId gathered_node = node;
  core::Affine gathered_from;
  core::MaterialId gathered_material;
  const auto add_gathered = [&](const PolygonMesh& mesh) {
    job_.add_mesh(gathered_node, mesh, kind_name, gathered_from, gathered_material);
  };
  for (std::uint64_t first = 0; first < table.count(); first += GltfTable::kBlock) {
    progress(double(first) / double(table.count()));
    const std::uint64_t n = table.load(first);
    for (std::uint64_t i = 0; i < n; ++i) {
      Row row{};
      for (std::size_t c = 0; c < kind.columns.size(); ++c) row[c] = table.row(kFirst + c, i);
      Shape shape = kind.shape(row);
      if (std::holds_alternative<std::monostate>(shape)) {
        ++shapeless;
        continue;
      }
      const double* tree = table.row(kTree, i);
      const core::MaterialId colour =
          material(table.row(kColour, i), table.has(kColour) ? &table.accessor(kColour) : nullptr);
      if (auto* faces = std::get_if<LooseFaces>(&shape)) {
        const Place at = place(tree, node, file_from_node, {});
        const std::uint64_t key = std::uint64_t{at.node.index} << 32 | colour.index;
        gathered.take(key, std::move(*faces), add_gathered);
        gathered_node = at.node, gathered_from = at.from_item, gathered_material = colour;
        continue;
      }
      const auto* solid = std::get_if<PlacedSolid>(&shape);
      const Place at = place(tree, node, file_from_node, solid ? solid->placement : std::get<Nut>(shape).placement);
      if (solid) {
        job_.add_primitive(at.node, solid->primitive, at.from_item, colour);
      } else {
        const bool first_nut = !nut_.valid();
        if (first_nut) nut_ = job_.scene().add_mesh(nut_mesh()).value();
        job_.add_instance(at.node, nut_, at.from_item, colour, first_nut);
      }
    }
  }
  gathered.flush(add_gathered);
  if (shapeless > 0)
    job_.warn(0, fmt::format("{}: {} of {} instances dropped: no axis, no arc or no height", where, shapeless,
                             table.count()));
}

void GltfCollections::add_triangles(const GltfSources& sources, const Json& attributes, core::NodeId node,
                                    const core::Affine& file_from_node, const std::string& where,
                                    const Progress& progress) {
  // Positions are a column, so that their length is checked against the others.
  constexpr GltfTable::Column kColumns[] = {{"_treeIndex", 1, true}, {"COLOR_0", 4}, {"POSITION", 3, true}};
  GltfTable table;
  table.open(document_, attributes, kColumns, where + "/attributes");
  const std::vector<std::uint32_t> corners = gltf_triangles(job_, document_, sources, where);
  const GltfAccessor& trees = table.accessor(0);
  const GltfAccessor* colours = table.has(1) ? &table.accessor(1) : nullptr;

  struct Of {
    double tree = 0.0, colour[4] = {};
    bool operator==(const Of&) const = default;
  };
  /// A triangle takes part and colour of its first corner.
  const auto of = [&](std::size_t corner) {
    Of found;
    trees.read(corners[corner], 1, &found.tree);
    if (colours) colours->read(corners[corner], 1, found.colour);
    found.colour[3] = 1.0;  // alpha is ignored
    return found;
  };
  for (std::size_t begin = 0; begin < corners.size();) {
    progress(double(begin) / double(corners.size()));
    if (!document_.take_items(1))
      gltf_fail("{}: more parts than a file of {} bytes may hold", where, document_.bytes_read());
    const Of run = of(begin);
    std::size_t end = begin + 3;
    while (end < corners.size() && of(end) == run) end += 3;
    const PolygonMesh mesh =
        gltf_mesh(job_, document_, sources,
                  {corners.begin() + std::ptrdiff_t(begin), corners.begin() + std::ptrdiff_t(end)}, where);
    const Place at = place(&run.tree, node, file_from_node, {});
    job_.add_mesh(at.node, mesh, "part", at.from_item, material(colours ? run.colour : nullptr, colours));
    begin = end;
  }
}

}  // namespace sightline::importers
