#include "sightline/importers/obj/internal/obj_reader.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <map>
#include <optional>
#include <set>
#include <streambuf>

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/side_files.h"

namespace sightline::importers {
namespace {

static_assert(sizeof(tinyobj::real_t) == sizeof(double), "the double-precision variant of tinyobjloader is needed");

/// Lets the library read the file image in place, and tells how far it has come.
class ImageBuffer final : public std::streambuf {
 public:
  explicit ImageBuffer(std::span<const std::byte> bytes) {
    char* begin = reinterpret_cast<char*>(const_cast<std::byte*>(bytes.data()));  // only ever read
    setg(begin, begin, begin + bytes.size());
  }
  std::uint64_t consumed() const { return std::uint64_t(gptr() - eback()); }
  std::uint64_t line() {
    line_ += std::uint64_t(std::count(eback() + counted_, gptr(), '\n'));
    counted_ = gptr() - eback();
    return line_;
  }
  double share() const { return double(gptr() - eback()) / double(egptr() - eback()); }

 private:
  std::uint64_t line_ = 0;
  std::ptrdiff_t counted_ = 0;
};

struct Corner {
  std::uint32_t position = 0, normal = core::kNone;
  friend bool operator==(const Corner&, const Corner&) = default;
};
/// Faces of one name and one material: corners back to back, and the number of corners of each face.
struct Part {
  std::vector<Corner> corners;
  std::vector<std::uint32_t> face_sizes;
};

struct Loading {
  Loading(ImportJob& import, std::span<const std::byte> bytes, const std::filesystem::path& file)
      : job(import), image(bytes), path(file) {}
  ImportJob& job;
  ImageBuffer image;
  const std::filesystem::path& path;
  std::optional<core::Error> error;

  std::vector<core::dvec3> positions;
  std::vector<core::vec3> normals;
  std::vector<std::string> names;  // in order of appearance
  std::map<std::string, std::size_t, std::less<>> index_of_name;
  std::map<std::pair<std::size_t, int>, Part> parts;  // by name and material
  Part* part = nullptr;                               // of the current name and material; null after a change of either
  std::vector<tinyobj::material_t> materials;
  std::string name;
  int material = -1;

  void warn(std::string_view message) { job.warn(image.consumed(), fmt::format("line {}: {}", image.line(), message)); }
  void check(core::Expected<void> result) {
    if (!result && !error) error = std::move(result.error());
  }
  void damage(std::string_view message) {
    check(job.damage(image.consumed(), fmt::format("line {}: {}{}", image.line(), message,
                                                   job.options().lenient ? "; face left out" : "")));
  }
  void begin_name(const char* begun) {
    name = begun;
    part = nullptr;
  }
  Part& current_part() {
    if (part) return *part;
    const auto [at, added] = index_of_name.try_emplace(name, names.size());
    if (added) names.push_back(name);
    part = &parts[{at->second, material}];
    return *part;
  }
};

/// Converts an index from 1, or from -1 backwards, to an index from 0. Nothing when there is no such element.
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
  // A normal that is not finite counts as none: the mesh then has no normals.
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
    if (!corner) return part.corners.resize(begin);
    part.corners.push_back(*corner);
  }
  part.face_sizes.push_back(std::uint32_t(indices.size()));
  loading.check(loading.job.progress(0.9 * loading.image.share()));
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
    loading.part = nullptr;
    if (material < 0) loading.warn(fmt::format("unknown material '{}'", name));
  };
  on.mtllib_cb = [](void* to, const tinyobj::material_t* materials, int count) {
    auto& known = static_cast<Loading*>(to)->materials;  // the call passes all materials so far
    known.insert(known.end(), materials + known.size(), materials + count);
  };
  on.group_cb = [](void* to, const char** names, int count) {
    static_cast<Loading*>(to)->begin_name(count > 0 ? names[0] : "");
  };
  on.object_cb = [](void* to, const char* name) { static_cast<Loading*>(to)->begin_name(name); };
  return on;
}

/// Opens MTL files in the OBJ file's directory and nowhere else. Reads each once, no matter how often and by which
/// names it is asked for.
class NearbyMaterials final : public tinyobj::MaterialReader {
 public:
  explicit NearbyMaterials(Loading& loading) : loading_(loading) {}

  bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                  std::map<std::string, int>* index_of, std::string* warning, std::string* error) override {
    const auto path = find_side_file(loading_.path, name);
    if (path && known_.contains(*path)) return !materials->empty();
    const auto bytes = path ? read_side_file(loading_.path, name) : tl::unexpected(path.error());
    if (!bytes) {
      loading_.warn("material file " + bytes.error().message);
      return false;
    }
    known_.insert(*path);
    ImageBuffer image(*bytes);
    std::istream stream(&image);
    tinyobj::LoadMtl(index_of, materials, &stream, warning, error);
    return !materials->empty();
  }

 private:
  Loading& loading_;
  std::set<std::filesystem::path> known_;
};

/// Makes a mesh of a part with vertices of its own: each pair of position and normal once.
class PartMesh {
 public:
  explicit PartMesh(const Loading& loading) : loading_(loading), first_(loading.positions.size(), core::kNone) {}

  /// Consumes the part's corners.
  PolygonMesh make(Part& part) {
    PolygonMesh mesh;
    const bool with_normals =
        std::none_of(part.corners.begin(), part.corners.end(), [](const Corner& c) { return c.normal == core::kNone; });
    vertices_.clear();
    for (Corner corner : part.corners) {
      if (!with_normals) corner.normal = core::kNone;
      mesh.corners.push_back(vertex_of(corner));
    }
    for (const Vertex& vertex : vertices_) {
      mesh.positions.push_back(loading_.positions[vertex.corner.position]);
      if (with_normals) mesh.normals.push_back(loading_.normals[vertex.corner.normal]);
      first_[vertex.corner.position] = core::kNone;  // for the next part
    }
    mesh.face_sizes = std::move(part.face_sizes);
    part = {};
    return mesh;
  }

 private:
  struct Vertex {
    Corner corner;
    std::uint32_t next = core::kNone;  // of the same position
  };

  std::uint32_t vertex_of(const Corner& corner) {
    std::uint32_t& first = first_[corner.position];
    for (std::uint32_t i = first; i != core::kNone; i = vertices_[i].next)
      if (vertices_[i].corner == corner) return i;
    vertices_.push_back({corner, first});
    return first = std::uint32_t(vertices_.size() - 1);
  }

  const Loading& loading_;
  std::vector<std::uint32_t> first_;  // latest vertex made of each position of the file
  std::vector<Vertex> vertices_;
};

core::MaterialId add_material(ImportJob& job, const tinyobj::material_t& source) {
  core::Material material;
  material.name = source.name;
  for (int i = 0; i < 3; ++i) {
    const double channel = source.diffuse[i];
    material.colour[i] = std::isfinite(channel) ? float(std::clamp(channel, 0.0, 1.0)) : 0.7f;
  }
  if (source.dissolve > 0.0)
    material.alpha = float(std::min(source.dissolve, 1.0));
  else  // writers differ on which of 0 and 1 is opaque, and nobody writes faces to hide them
    job.warn(0, fmt::format("material '{}': transparent throughout (d 0 or Tr 1); shown opaque", source.name));
  return job.scene().add_material(std::move(material));
}

core::Expected<void> add_to_scene(Loading& loading) {
  core::Scene& scene = loading.job.scene();
  std::vector<core::NodeId> nodes;
  for (const std::string& name : loading.names) nodes.push_back(scene.add_node(loading.job.file_node(), name));
  std::map<int, core::MaterialId> made;
  PartMesh part_mesh(loading);
  std::size_t done = 0;
  for (auto& [key, part] : loading.parts) {
    if (auto asked = loading.job.progress(0.9 + 0.1 * double(done++) / double(loading.parts.size())); !asked)
      return asked;
    if (part.face_sizes.empty()) continue;
    core::MaterialId material;
    if (key.second >= 0 && std::size_t(key.second) < loading.materials.size()) {
      core::MaterialId& known = made[key.second];
      if (!known.valid()) known = add_material(loading.job, loading.materials[std::size_t(key.second)]);
      material = known;
    }
    loading.job.add_mesh(nodes[key.first], part_mesh.make(part), loading.names[key.first], {}, material,
                         loading.image.consumed());
  }
  return {};
}

core::Expected<void> parse(Loading& loading) {
  std::istream stream(&loading.image);
  NearbyMaterials material_reader(loading);
  std::string warnings, errors;
  try {
    if (!tinyobj::LoadObjWithCallback(stream, callbacks(), &loading, &material_reader, &warnings, &errors))
      return core::fail(fmt::format("{}: {}", loading.job.file(), errors));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& thrown) {
    return core::fail(fmt::format("{}: line {}: {}", loading.job.file(), loading.image.line(), thrown.what()));
  }
  if (loading.error) return tl::unexpected(*loading.error);
  if (loading.positions.empty())
    return core::fail(
        fmt::format("{}: not an OBJ file: expected vertex statements ('v x y z'), found none", loading.job.file()));
  return {};
}

}  // namespace

core::Expected<ImportReport> read_obj(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  return run_import(path.filename().string(), scene, parent, options, frame_of(options), [&](ImportJob& job) {
    job.report().bytes = bytes.size();
    Loading loading(job, bytes, path);
    auto done = parse(loading);
    return done ? add_to_scene(loading) : done;
  });
}

}  // namespace sightline::importers
