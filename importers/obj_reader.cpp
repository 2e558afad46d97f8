#include "sightline/importers/obj_reader.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <istream>
#include <map>
#include <optional>
#include <streambuf>
#include <unordered_map>

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include "sightline/importers/triangulate.h"

namespace sightline::importers {
namespace {

static_assert(sizeof(tinyobj::real_t) == sizeof(double), "the double-precision variant of tinyobjloader is needed");

constexpr double kLargestCoordinate = 1e36;

/// Lets the library read the image in place, and tells how far it has come.
class ImageBuffer final : public std::streambuf {
 public:
  explicit ImageBuffer(std::span<const std::byte> bytes) {
    char* begin = reinterpret_cast<char*>(const_cast<std::byte*>(bytes.data()));  // only ever read
    setg(begin, begin, begin + bytes.size());
  }
  std::uint64_t consumed() const { return std::uint64_t(gptr() - eback()); }
  std::uint64_t line() const { return std::uint64_t(std::count(eback(), gptr(), '\n')); }
};

struct Corner {
  std::uint32_t position = 0, normal = core::kNone;
  friend bool operator==(const Corner&, const Corner&) = default;
};
struct CornerHash {
  std::size_t operator()(const Corner& c) const {
    return std::size_t((std::uint64_t(c.position) << 32 | c.normal) * 0x9e3779b97f4a7c15u >> 16);
  }
};

/// Faces of one name and one material: corners back to back, and how many each face has.
struct Part {
  std::vector<Corner> corners;
  std::vector<std::uint32_t> face_sizes;
};

struct Loading {
  ImageBuffer* image = nullptr;
  std::string file;
  std::filesystem::path directory;
  bool lenient = false;
  ImportReport report;
  std::uint64_t unlisted = 0;
  std::optional<core::Error> error;

  std::vector<core::dvec3> positions;
  std::vector<core::vec3> normals;
  std::vector<std::string> names;  // in order of appearance
  std::map<std::string, std::size_t, std::less<>> index_of_name;
  std::map<std::pair<std::size_t, int>, Part> parts;  // by name and material
  std::vector<tinyobj::material_t> materials;
  std::string name;
  int material = -1;

  void warn(std::string message) {
    if (report.warnings.size() < kMaxWarnings)
      report.warnings.push_back({file, image->consumed(), std::move(message)});
    else
      ++unlisted;
  }
  void damage(std::string message) {
    if (lenient)
      warn(fmt::format("line {}: {}; face left out", image->line(), message));
    else if (!error)
      error = core::Error{fmt::format("{}: line {}: {}", file, image->line(), message)};
  }
  Part& current_part() {
    const auto [at, added] = index_of_name.try_emplace(name, names.size());
    if (added) names.push_back(name);
    return parts[{at->second, material}];
  }
};

bool usable(const core::dvec3& p) {
  return core::is_finite(p) && std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= kLargestCoordinate;
}

/// Index from 1, or from -1 backwards, to an index from 0. Nothing when there is no such element.
std::optional<std::uint32_t> resolve(int index, std::size_t count) {
  const std::int64_t at = index > 0 ? std::int64_t(index) - 1 : std::int64_t(count) + index;
  if (index == 0 || at < 0 || at >= std::int64_t(count)) return {};
  return std::uint32_t(at);
}

std::optional<Corner> resolve_corner(Loading& loading, const tinyobj::index_t& index) {
  const auto position = resolve(index.vertex_index, loading.positions.size());
  if (!position) {
    loading.damage(fmt::format("expected a vertex index within the {} vertices so far, found {}",
                               loading.positions.size(), index.vertex_index));
    return {};
  }
  Corner corner{*position, core::kNone};
  if (index.normal_index == 0) return corner;
  const auto normal = resolve(index.normal_index, loading.normals.size());
  if (!normal) {
    loading.damage(fmt::format("expected a normal index within the {} normals so far, found {}", loading.normals.size(),
                               index.normal_index));
    return {};
  }
  // A normal that is no direction counts as none: the mesh then goes without.
  if (core::is_finite(core::dvec3(loading.normals[*normal]))) corner.normal = *normal;
  return corner;
}

void add_face(Loading& loading, std::span<const tinyobj::index_t> indices) {
  if (loading.error) return;
  if (indices.size() < 3)
    return loading.damage(fmt::format("expected a face of 3 corners or more, found {}", indices.size()));
  Part& part = loading.current_part();
  const std::size_t begin = part.corners.size();
  for (const tinyobj::index_t& index : indices) {
    const auto corner = resolve_corner(loading, index);
    const bool good = corner && usable(loading.positions[corner->position]);
    if (corner && !good)
      loading.warn(fmt::format("line {}: face dropped: a vertex is not finite or beyond {:g}", loading.image->line(),
                               kLargestCoordinate));
    if (!good) return part.corners.resize(begin);
    part.corners.push_back(*corner);
  }
  part.face_sizes.push_back(std::uint32_t(indices.size()));
}

tinyobj::callback_t callbacks() {
  tinyobj::callback_t on;
  on.vertex_cb = [](void* to, double x, double y, double z, double) {
    static_cast<Loading*>(to)->positions.emplace_back(x, y, z);
  };
  on.normal_cb = [](void* to, double x, double y, double z) {
    static_cast<Loading*>(to)->normals.emplace_back(float(x), float(y), float(z));
  };
  on.index_cb = [](void* to, tinyobj::index_t* indices, int count) {
    add_face(*static_cast<Loading*>(to), {indices, std::size_t(count)});
  };
  on.usemtl_cb = [](void* to, const char* name, int material) {
    auto& loading = *static_cast<Loading*>(to);
    loading.material = material;
    if (material < 0) loading.warn(fmt::format("line {}: unknown material '{}'", loading.image->line(), name));
  };
  on.mtllib_cb = [](void* to, const tinyobj::material_t* materials, int count) {
    static_cast<Loading*>(to)->materials.assign(materials, materials + count);
  };
  on.group_cb = [](void* to, const char** names, int count) {
    static_cast<Loading*>(to)->name = count > 0 ? names[0] : "";
  };
  on.object_cb = [](void* to, const char* name) { static_cast<Loading*>(to)->name = name; };
  return on;
}

/// Opens MTL files in the OBJ file's directory and nowhere else.
class NearbyMaterials final : public tinyobj::MaterialReader {
 public:
  explicit NearbyMaterials(Loading& loading) : loading_(loading) {}

  bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                  std::map<std::string, int>* index_of, std::string* warning, std::string* error) override {
    const auto path = locate(name);
    if (!path) return false;
    std::ifstream file(*path);
    if (!file) {
      loading_.warn(fmt::format("line {}: material file '{}' not found", loading_.image->line(), name));
      return false;
    }
    tinyobj::LoadMtl(index_of, materials, &file, warning, error);
    return !materials->empty();
  }

 private:
  std::optional<std::filesystem::path> locate(const std::string& name) {
    std::error_code code;
    const std::filesystem::path root = std::filesystem::weakly_canonical(loading_.directory, code);
    const std::filesystem::path path = std::filesystem::weakly_canonical(root / name, code);
    const std::filesystem::path relative = path.lexically_relative(root);
    if (code || relative.empty() || *relative.begin() == "..") {
      loading_.warn(fmt::format("line {}: material file '{}' refused: it lies outside the model's directory",
                                loading_.image->line(), name));
      return {};
    }
    if (!std::filesystem::is_regular_file(path, code)) {
      loading_.warn(fmt::format("line {}: material file '{}' not found", loading_.image->line(), name));
      return {};
    }
    return path;
  }
  Loading& loading_;
};

core::AabbD extent(const Part& part, const std::vector<core::dvec3>& positions) {
  core::AabbD box;
  for (const Corner& corner : part.corners) box.grow(positions[corner.position]);
  return box;
}

core::Mesh make_mesh(const Part& part, const Loading& loading, const core::dvec3& centre) {
  core::Mesh mesh;
  const bool with_normals =
      std::none_of(part.corners.begin(), part.corners.end(), [](const Corner& c) { return c.normal == core::kNone; });
  std::unordered_map<Corner, std::uint32_t, CornerHash> vertex_of;
  std::vector<core::vec3> outline;
  std::vector<std::uint32_t> vertices, triangles;
  std::size_t first = 0;
  for (const std::uint32_t size : part.face_sizes) {
    outline.clear(), vertices.clear(), triangles.clear();
    for (std::size_t i = first; i < first + size; ++i) {
      Corner corner = part.corners[i];
      if (!with_normals) corner.normal = core::kNone;
      const auto [at, added] = vertex_of.try_emplace(corner, std::uint32_t(mesh.positions.size()));
      if (added) {
        mesh.positions.emplace_back(loading.positions[corner.position] - centre);
        if (with_normals) mesh.normals.push_back(loading.normals[corner.normal]);
      }
      vertices.push_back(at->second);
      outline.push_back(mesh.positions[at->second]);
    }
    triangulate_polygon(outline, std::span(&size, 1), 0, triangles);
    for (const std::uint32_t t : triangles) mesh.indices.push_back(vertices[t]);
    first += size;
  }
  return mesh;
}

core::MaterialId add_material(core::Scene& scene, const tinyobj::material_t& source) {
  core::Material material;
  material.name = source.name;
  for (int i = 0; i < 3; ++i) {
    const double channel = source.diffuse[i];
    material.colour[i] = std::isfinite(channel) ? float(std::clamp(channel, 0.0, 1.0)) : 0.7f;
  }
  if (std::isfinite(source.dissolve)) material.alpha = float(std::clamp(source.dissolve, 0.0, 1.0));
  return scene.add_material(std::move(material));
}

void add_to_scene(Loading& loading, core::Scene& scene, core::NodeId parent) {
  const core::NodeId file_node = scene.add_node(parent, loading.file);
  loading.report.nodes.push_back(file_node);
  std::vector<core::NodeId> nodes;
  for (const std::string& name : loading.names) nodes.push_back(scene.add_node(file_node, name));
  std::map<int, core::MaterialId> made;
  for (auto& [key, part] : loading.parts) {
    if (part.face_sizes.empty()) continue;
    core::MaterialId material;
    if (key.second >= 0 && std::size_t(key.second) < loading.materials.size()) {
      core::MaterialId& known = made[key.second];
      if (!known.valid()) known = add_material(scene, loading.materials[std::size_t(key.second)]);
      material = known;
    }
    const core::dvec3 centre = extent(part, loading.positions).centre();
    core::Mesh mesh = make_mesh(part, loading, centre);
    mesh.name = loading.names[key.first];
    part = {};
    ++loading.report.items[std::size_t(core::Kind::kMesh)];
    if (mesh.indices.empty()) ++loading.report.degenerate;
    scene.add_mesh_instance(nodes[key.first], scene.add_mesh(std::move(mesh)), core::translation(centre), material);
  }
}

core::Expected<void> parse(Loading& loading) {
  std::istream stream(loading.image);
  NearbyMaterials material_reader(loading);
  std::string warnings, errors;
  try {
    if (!tinyobj::LoadObjWithCallback(stream, callbacks(), &loading, &material_reader, &warnings, &errors))
      return core::fail(fmt::format("{}: {}", loading.file, errors));
  } catch (const std::exception& thrown) {
    return core::fail(fmt::format("{}: line {}: {}", loading.file, loading.image->line(), thrown.what()));
  }
  if (loading.error) return tl::unexpected(*loading.error);
  if (loading.positions.empty())
    return core::fail(
        fmt::format("{}: not an OBJ file: expected vertex statements ('v x y z'), found none", loading.file));
  return {};
}

}  // namespace

core::Expected<ImportReport> read_obj(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  ImageBuffer image(bytes);
  Loading loading;
  loading.image = &image;
  loading.file = path.filename().string();
  loading.directory = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  loading.lenient = options.lenient;
  loading.report.bytes = bytes.size();
  if (auto parsed = parse(loading); !parsed) return tl::unexpected(parsed.error());
  add_to_scene(loading, scene, parent);
  if (loading.unlisted > 0)
    loading.report.warnings.push_back(
        {loading.file, bytes.size(), fmt::format("{} further warnings are not listed", loading.unlisted)});
  return std::move(loading.report);
}

}  // namespace sightline::importers
