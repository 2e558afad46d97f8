#include "sightline/importers/gltf/internal/gltf_reader.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/gltf/internal/gltf_collections.h"
#include "sightline/importers/gltf/internal/gltf_compression.h"
#include "sightline/importers/gltf/internal/gltf_document.h"
#include "sightline/importers/gltf/internal/gltf_geometry.h"
#include "sightline/importers/gltf/internal/gltf_materials.h"
#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {
namespace {

using core::Affine;
using core::NodeId;

constexpr std::string_view kKnownExtensions[] = {
    "KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_texture_transform",  "KHR_lights_punctual",
    "KHR_animation_pointer", "KHR_xmp_json_ld",         "KHR_materials_variants", "KHR_node_visibility"};

constexpr std::string_view kTreeIndex = "treeIndex";

class Reading {
 public:
  Reading(ImportJob& job, const std::filesystem::path& path)
      : job_(job), document_(job, path), materials_(job, document_), collections_(job, document_) {}

  void run(std::span<const std::byte> bytes) {
    document_.open(bytes);
    with_place(job_.file(), [&] { read(); });
  }

 private:
  struct Visit {
    std::uint64_t node;
    NodeId parent;
    Affine file_from_parent;
  };
  struct Node {
    NodeId id;
    Affine file_from_node;
    std::string where;
  };
  /// The triangles of one colour.
  struct SharedPart {
    PackedColour colour = kNoColour;
    PolygonMesh polygons;  // until the first item
    core::MeshId mesh;     // from then on
    Affine placement;      // where its coordinates lie
  };
  struct SharedMesh {
    std::string name;
    std::vector<SharedPart> parts;  // none: it has no triangles, or was reported as unreadable
  };

  // Errors from here on say where in the file, but not which file.

  void read() {
    check_extensions();
    find_parents();
    // The convention has z up, whatever glTF says.
    follows_convention_ = GltfCollections::follows_convention(document_);
    if (follows_convention_) job_.scene().set_transform(job_.file_node(), {});
    walk();
    job_.report().bytes = document_.bytes_read();
    if (!not_triangles_.empty())
      job_.warn(0, fmt::format("{} primitives left out: points or lines, expected triangles", not_triangles_.size()));
    if (!without_positions_.empty())
      job_.warn(0, fmt::format("{} primitives left out: they have no POSITION", without_positions_.size()));
    materials_.warn_of_left_out();
  }

  /// Handles a part that cannot be read: fails when strict, else leaves it out. Always fails when the caller cancels,
  /// and for files that ask for more than is in proportion to their bytes.
  void left_out(core::Error error) {
    if (!job_.options().lenient || error.message == kCancelled || document_.overdrawn())
      throw ImportFault{std::move(error)};
    job_.warn(0, std::move(error.message));
  }
  template <class Read>
  bool or_left_out(Read&& read) {
    try {
      read();
      return true;
    } catch (ImportFault& fault) {
      left_out(std::move(fault.error));
      return false;
    }
  }

  void check_extensions() {
    const Json* required = gltf_find(document_.root(), "extensionsRequired");
    if (!required || !required->is_array()) return;
    for (const Json& extension : *required) {
      const std::string name = extension.is_string() ? extension.get<std::string>() : describe(extension);
      if (is_gltf_compression(name)) {
        if (auto can = can_decompress(name); !can) left_out({"/extensionsRequired: " + can.error().message});
        continue;
      }
      const bool look = name.starts_with("KHR_materials_") || name.find("texture") != std::string::npos;
      if (look ||
          std::find(std::begin(kKnownExtensions), std::end(kKnownExtensions), name) != std::end(kKnownExtensions))
        continue;
      left_out({fmt::format("/extensionsRequired: expected extensions that can be read, found {}", name)});
    }
  }

  // --- the tree ----------------------------------------------------------------------------------------------------

  /// Finds each node's only parent. Leaves out links that would make the file more than a forest.
  void find_parents() {
    parents_.assign(document_.count("nodes"), core::kNone);
    for (std::size_t i = 0; i < parents_.size(); ++i) {
      const Json& node = (*gltf_find(document_.root(), "nodes"))[i];
      const Json* children = gltf_find(node, "children");
      for (std::size_t c = 0; children && c < children->size(); ++c)
        or_left_out([&] { parents_[child_of(*children, c, i)] = std::uint32_t(i); });
    }
    cut_cycles();
  }

  std::uint64_t child_of(const Json& children, std::size_t place, std::size_t parent) {
    const std::string where = fmt::format("/nodes/{}/children", parent);
    if (!children.is_array()) gltf_fail("{}: expected an array, found {}", where, describe(children));
    const std::uint64_t child = index_at(children[place], where);
    document_.element("nodes", child, where);
    if (parents_[child] != core::kNone)
      gltf_fail("/nodes/{}: expected one parent, found nodes {} and {}", child, parents_[child], parent);
    return child;
  }

  static std::uint64_t index_at(const Json& value, const std::string& where) {
    if (const auto whole = gltf_whole(value)) return *whole;
    gltf_fail("{}: expected whole numbers, found {}", where, describe(value));
  }

  /// A node whose ancestors lead back to it cannot be reached from a root: cuts the cycle above it.
  void cut_cycles() {
    std::vector<std::uint32_t> seen_from(parents_.size(), core::kNone);
    for (std::uint32_t start = 0; start < parents_.size(); ++start) {
      std::uint32_t node = start;
      while (node != core::kNone && seen_from[node] == core::kNone) {
        seen_from[node] = start;
        node = parents_[node];
      }
      if (node == core::kNone || seen_from[node] != start) continue;
      left_out({fmt::format("/nodes/{}: expected a tree, found it among its own ancestors", node)});
      parents_[node] = core::kNone;
    }
  }

  std::vector<std::uint64_t> roots() {
    std::vector<std::uint64_t> found;
    const std::uint64_t wanted = gltf_index(document_.root(), "scene", "", 0);
    if (document_.count("scenes") == 0) {
      for (std::uint64_t i = 0; i < parents_.size(); ++i)
        if (parents_[i] == core::kNone) found.push_back(i);
      return found;
    }
    if (document_.count("scenes") > 1)
      job_.warn(0, fmt::format("/scenes: only scene {} of {} is read", wanted, document_.count("scenes")));
    const GltfElement scene = document_.element("scenes", wanted, "/scene");
    const Json* nodes = gltf_find(*scene.json, "nodes");
    if (!nodes) return found;
    const std::string where = scene.where() + "/nodes";
    std::vector<bool> taken(parents_.size());
    for (std::size_t i = 0; i < nodes->size(); ++i)
      or_left_out([&] {
        if (!nodes->is_array()) gltf_fail("{}: expected an array, found {}", where, describe(*nodes));
        const std::uint64_t node = index_at((*nodes)[i], where);
        if (node >= parents_.size())
          gltf_fail("{}: expected one of the {} nodes, found {}", where, parents_.size(), node);
        if (parents_[node] != core::kNone || taken[node])
          gltf_fail("{}: expected nodes without a parent, each once, found {}", where, node);
        taken[node] = true;
        found.push_back(node);
      });
    return found;
  }

  void walk() {
    std::vector<std::uint64_t> tops;
    or_left_out([&] { tops = roots(); });
    std::vector<Visit> stack;
    for (auto top = tops.rbegin(); top != tops.rend(); ++top) stack.push_back({*top, job_.file_node(), {}});
    for (; !stack.empty(); ++visited_) {
      progress(0.0);
      const Visit visit = stack.back();
      stack.pop_back();
      GltfElement element;
      if (!or_left_out([&] { element = document_.element("nodes", visit.node, "/nodes"); })) continue;
      const Node node = add_node(element, visit);
      or_left_out([&] { add_items(element, node); });
      const Json* children = gltf_find(*element.json, "children");
      for (std::size_t c = children && children->is_array() ? children->size() : 0; c-- > 0;) {
        const auto child = gltf_whole((*children)[c]);
        if (!child || *child >= parents_.size() || parents_[*child] != visit.node) continue;
        stack.push_back({*child, node.id, node.file_from_node});
        parents_[*child] = core::kNone;  // a node listed twice is still one child
      }
    }
  }

  /// `share` of the node being visited.
  void progress(double share) {
    value_or_throw(
        job_.progress(0.2 + 0.8 * (double(visited_) + share) / double(std::max<std::size_t>(parents_.size(), 1))));
  }

  // --- a node ------------------------------------------------------------------------------------------------------

  Affine transform_of(const GltfElement& element) {
    const Json& json = *element.json;
    const std::string where = element.where();
    if (gltf_find(json, "matrix")) {
      double m[16] = {};
      gltf_numbers(json, "matrix", where, m, 16);
      return affine_of(m, where);
    }
    double translation[3] = {}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    gltf_numbers(json, "translation", where, translation, 3);
    gltf_numbers(json, "rotation", where, rotation, 4);
    gltf_numbers(json, "scale", where, scale, 3);
    return gltf_affine(translation, rotation, scale);
  }

  /// The map of a matrix whose last row need not be 0 0 0 1: 0 0 0 w divides by w, and rows that differ by rounding are
  /// taken for that. Fails on perspective, which a lenient import leaves out of the map.
  Affine affine_of(double (&m)[16], const std::string& where) {
    constexpr double kRounding = 1e-5;
    const double w = m[15], perspective = std::max({std::abs(m[3]), std::abs(m[7]), std::abs(m[11])});
    if (perspective == 0.0 && w == 1.0) return gltf_affine(m);
    const std::string message = fmt::format("{}/matrix: expected 0 0 0 1 as its last row, found {:g} {:g} {:g} {:g}",
                                            where, m[3], m[7], m[11], w);
    if (w == 0.0) gltf_fail("{}", message);
    if (perspective > kRounding * std::abs(w))
      refuse_or_warn(job_, message);
    else
      job_.warn(0, message);
    if (std::abs(w - 1.0) > kRounding)
      for (double& value : m) value /= w;
    return gltf_affine(m);
  }

  Node add_node(const GltfElement& element, const Visit& visit) {
    Affine parent_from_node;
    or_left_out([&] { parent_from_node = transform_of(element); });
    const NodeId id = job_.scene().add_node(visit.parent, name_of(element), parent_from_node);
    const Affine file_from_node = visit.file_from_parent * parent_from_node;
    add_attributes(*element.json, id);
    if (const Json* tree = follows_convention_ ? extra(*element.json, kTreeIndex) : nullptr)
      if (const auto part = gltf_whole(*tree); part && *part < core::kNone)
        collections_.name_part(std::uint32_t(*part), id, file_from_node);
    return {id, file_from_node, element.where()};
  }

  std::string name_of(const GltfElement& element) const {
    std::string name = gltf_text(*element.json, "name");
    const Json* mesh = gltf_find(*element.json, "mesh");
    const auto index = mesh ? gltf_whole(*mesh) : std::nullopt;
    if (!name.empty() || !index || *index >= document_.count("meshes")) return name;
    return gltf_text((*gltf_find(document_.root(), "meshes"))[*index], "name");
  }

  void add_attributes(const Json& node, NodeId id) {
    const Json* extras = gltf_find(node, "extras");
    if (!extras) return;
    const auto add = [&](const std::string& key, const Json& value) {
      if (value.is_string())
        job_.scene().set_attribute(id, key, value.string());
      else if (value.is_number() || value.is_boolean())
        job_.scene().set_attribute(id, key, value.dump());
    };
    if (!extras->is_object()) return add("extras", *extras);
    for (const auto& [key, value] : extras->items())
      if (!follows_convention_ || key != kTreeIndex) add(key, value);
  }

  static const Json* extra(const Json& node, std::string_view key) {
    const Json* extras = gltf_find(node, "extras");
    return extras ? gltf_find(*extras, key) : nullptr;
  }

  void add_items(const GltfElement& element, const Node& node) {
    const Json& json = *element.json;
    const Json* extensions = gltf_find(json, "extensions");
    const Json* instancing = extensions ? gltf_find(*extensions, "EXT_mesh_gpu_instancing") : nullptr;
    const Json* attributes = instancing ? gltf_find(*instancing, "attributes") : nullptr;
    const std::string where = node.where + "/extensions/EXT_mesh_gpu_instancing/attributes";
    if (instancing && !attributes) gltf_fail("{}: expected an object, which is missing", where);
    const std::string name = gltf_text(json, "name");
    const bool collection = attributes && follows_convention_ && GltfCollections::is_collection(name);
    if (const Json* caps = collection ? extra(json, "caps") : nullptr; caps && *caps == true) return;
    if (collection)
      return collections_.add(name, *attributes, node.id, node.file_from_node, where,
                              [this](double share) { progress(share); });
    if (!gltf_find(json, "mesh")) return;
    const GltfElement mesh = document_.element("meshes", gltf_index(json, "mesh", node.where), node.where + "/mesh");
    attributes ? add_instances(mesh, *attributes, node, where) : add_mesh(mesh, node);
  }

  // --- meshes ------------------------------------------------------------------------------------------------------

  /// Calls visit(primitive, where) for each primitive of a mesh. Leaves out what cannot be read.
  template <class VisitPrimitive>
  void for_each_primitive(const GltfElement& mesh, VisitPrimitive&& visit) {
    const Json* primitives = gltf_find(*mesh.json, "primitives");
    if (!primitives || !primitives->is_array())
      gltf_fail("{}/primitives: expected an array of mesh primitives", mesh.where());
    for (std::size_t i = 0; i < primitives->size(); ++i) {
      const std::string where = fmt::format("{}/primitives/{}", mesh.where(), i);
      or_left_out([&] {
        take_items(1, where);  // even a primitive that draws nothing takes time under each node
        document_.decompress((*primitives)[i], where);
        visit((*primitives)[i], where);
      });
    }
  }

  void add_mesh(const GltfElement& mesh, const Node& node) {
    for_each_primitive(mesh, [&](const Json& primitive, const std::string& where) {
      const GltfSources sources = gltf_sources(primitive, where);
      const Json* attributes = gltf_find(primitive, "attributes");
      if (sources.draws_triangles() && attributes && gltf_find(*attributes, "_treeIndex"))
        return collections_.add_triangles(sources, *attributes, node.id, node.file_from_node, where,
                                          [this](double share) { progress(share); });
      SharedMesh& shared = shared_mesh(sources, mesh, where);
      take_parts(shared, 1, where);
      for (SharedPart& part : shared.parts)
        add_item(part, shared.name, node.id, {}, material_of(primitive, part.colour, where));
    });
  }

  void add_instances(const GltfElement& mesh, const Json& attributes, const Node& node, const std::string& where) {
    enum { kTranslation, kRotation, kScale, kMatrix, kTree, kColour };
    constexpr GltfTable::Column kColumns[] = {{"TRANSLATION", 3},      {"ROTATION", 4},   {"SCALE", 3},
                                              {"_instanceMatrix", 16}, {"_treeIndex", 1}, {"_color", 4}};
    GltfTable table;
    table.open(document_, attributes, kColumns, where);
    for_each_primitive(mesh, [&](const Json& primitive, const std::string& at) {
      SharedMesh& shared = shared_mesh(gltf_sources(primitive, at), mesh, at);
      if (shared.parts.empty()) return;
      take_items(table.count(), at);
      take_parts(shared, table.count(), at);
      std::vector<core::MaterialId> materials;
      for (const SharedPart& part : shared.parts) materials.push_back(material_of(primitive, part.colour, at));
      for (std::uint64_t first = 0; first < table.count(); first += GltfTable::kBlock) {
        progress(double(first) / double(table.count()));
        const std::uint64_t n = table.load(first);
        for (std::uint64_t i = 0; i < n; ++i) {
          const double* matrix = table.row(kMatrix, i);
          const Affine from_copy =
              matrix ? gltf_affine(matrix)
                     : gltf_affine(table.row(kTranslation, i), table.row(kRotation, i), table.row(kScale, i));
          const auto place = collections_.place(table.row(kTree, i), node.id, node.file_from_node, from_copy);
          const bool coloured = table.has(kColour);
          for (std::size_t p = 0; p < materials.size(); ++p) {
            const core::MaterialId colour =
                coloured ? collections_.material(table.row(kColour, i), &table.accessor(kColour)) : materials[p];
            add_item(shared.parts[p], shared.name, place.node, place.from_item, colour);
          }
        }
      }
    });
  }

  core::MaterialId material_of(const Json& primitive, PackedColour tint, const std::string& where) {
    std::uint64_t index = core::kNone;
    or_warn(job_, "the default material instead",
            [&] { index = gltf_index(primitive, "material", where, core::kNone); });
    return materials_.material(index, tint, where + "/material");
  }

  /// Counts the items of a mesh's parts beyond the first one, which are items that the file does not list.
  void take_parts(const SharedMesh& shared, std::uint64_t copies, const std::string& where) {
    if (shared.parts.size() > 1) take_items(copies * (shared.parts.size() - 1), where);
  }

  void take_items(std::uint64_t count, const std::string& where) {
    if (!document_.take_items(count))
      gltf_fail("{}: more items than a file of {} bytes may hold", where, document_.bytes_read());
  }

  void add_item(SharedPart& shared, const std::string& name, NodeId node, const Affine& node_from_copy,
                core::MaterialId material) {
    if (shared.mesh.valid()) return job_.add_instance(node, shared.mesh, node_from_copy * shared.placement, material);
    // The job decides what the mesh becomes and where its coordinates lie.
    core::Scene& scene = job_.scene();
    const auto item = core::ItemId(scene.item_slots());
    if (!job_.add_mesh(node, shared.polygons, name, {}, material)) return;
    shared.polygons = {};
    shared.mesh = scene.mesh_of(item);
    shared.placement = scene.placement(item);
    scene.set_placement(item, node_from_copy * shared.placement);
  }

  /// The mesh of a primitive, read when it is first asked for. One mesh for each colour of its vertices.
  SharedMesh& shared_mesh(const GltfSources& sources, const GltfElement& mesh, const std::string& where) {
    if (!sources.draws_triangles()) (sources.mode < 4 ? not_triangles_ : without_positions_).insert(where);
    const auto [known, added] = meshes_.try_emplace(sources);
    SharedMesh& shared = known->second;
    if (!added || !sources.draws_triangles()) return shared;
    std::vector<std::uint32_t> corners = gltf_triangles(job_, document_, sources, where);
    std::vector<PackedColour> colours;
    or_warn(job_, "colours of vertices left out",
            [&] { colours = gltf_face_colours(document_, sources, corners, where); });
    PolygonMesh polygons = gltf_mesh(job_, document_, sources, std::move(corners), where);
    shared.name = gltf_text(*mesh.json, "name");
    if (colours.empty())
      shared.parts.push_back({kNoColour, std::move(polygons), {}, {}});
    else
      for_each_colour(job_, polygons, colours, [&](const PolygonMesh& part, PackedColour colour) {
        shared.parts.push_back({colour, part, {}, {}});
      });
    // A mesh takes as much memory as several items.
    constexpr std::uint64_t kItemsPerMesh = 16;
    take_parts(shared, kItemsPerMesh, where);
    return shared;
  }

  ImportJob& job_;
  GltfDocument document_;
  GltfMaterials materials_;
  GltfCollections collections_;
  bool follows_convention_ = false;
  std::vector<std::uint32_t> parents_;
  std::uint64_t visited_ = 0;
  std::set<std::string> not_triangles_, without_positions_;  // primitives that are left out
  std::map<GltfSources, SharedMesh> meshes_;
};

}  // namespace

core::Expected<ImportReport> read_gltf(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                       core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  return run_import(path.filename().string(), scene, parent, options, {1.0, UpAxis::kY},
                    [&](ImportJob& job) -> core::Expected<void> {
                      Reading(job, path).run(bytes);
                      return {};
                    });
}

}  // namespace sightline::importers
