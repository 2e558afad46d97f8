#include "sightline/bindings/python/scene.h"

#include <optional>
#include <span>
#include <variant>

#include "sightline/bindings/python/module.h"
#include "sightline/bindings/python/values.h"
#include "sightline/core/find_nodes.h"
#include "sightline/core/mesh_extras.h"
#include "sightline/importers/plant/plant_generator.h"

namespace sightline::python {
namespace {

bool alive(const Node& node, const core::Scene& scene) {
  return scene.contains(node.id);
}
bool alive(const Mesh& mesh, const core::Scene& scene) {
  return scene.contains(mesh.id);
}
bool alive(const Material& material, const core::Scene& scene) {
  return scene.contains(material.id);
}
bool alive(const Item& item, const core::Scene& scene) {
  return scene.contains_item(item.id);
}

template <class Handle>
void check(const Handle& handle, const core::Scene& scene) {
  constexpr const char* kWhat = std::is_same_v<Handle, Node>   ? "node"
                                : std::is_same_v<Handle, Mesh> ? "mesh"
                                : std::is_same_v<Handle, Item> ? "item"
                                                               : "material";
  if (!alive(handle, scene)) fail(std::string(kWhat) + ": it has been removed from its scene");
}

template <class Handle>
auto id_in(const ScenePtr& scene, const Handle& handle, const char* argument) {
  if (handle.scene != scene) fail(std::string(argument) + ": it belongs to another scene");
  check(handle, scene->read());
  return handle.id;
}

core::MaterialId material_in(const ScenePtr& scene, const std::optional<Material>& material) {
  return material ? id_in(scene, *material, "material") : core::MaterialId();
}

py::object material_or_none(const ScenePtr& scene, core::MaterialId id) {
  return id.valid() && scene->scene.contains(id) ? py::cast(Material{scene, id}) : py::none();
}

py::object node_or_none(const ScenePtr& scene, core::NodeId id) {
  return id.valid() ? py::cast(Node{scene, id}) : py::none();
}

core::vec3 colour_of(py::handle value) {
  const auto c = floats(value, "colour", {3});
  return {c.data()[0], c.data()[1], c.data()[2]};
}

// --- meshes ----------------------------------------------------------------------------------------------------------

Mesh add_mesh(const ScenePtr& scene, const py::object& positions, const py::object& indices_, const py::object& normals,
              const py::str& name) {
  const auto copy = [](const Numbers<float>& rows) {
    const auto* first = reinterpret_cast<const core::vec3*>(rows.data());
    return std::vector<core::vec3>(first, first + rows.shape(0));
  };
  core::Mesh mesh;
  mesh.name = to_bytes(name);
  mesh.positions = copy(floats(positions, "positions", {-1, 3}));
  if (!normals.is_none()) mesh.normals = copy(floats(normals, "normals", {-1, 3}));
  const auto corners = indices(indices_, "indices", {-1, 3});
  mesh.indices.assign(corners.data(), corners.data() + corners.size());
  return {scene, unwrap(scene->edit().add_mesh(std::move(mesh)))};
}

/// An array that looks into the mesh. While it lives, the mesh is not removed.
template <class T, class Row>
py::array_t<T> look_into(const Mesh& mesh, const std::vector<Row>& rows) {
  static_assert(sizeof(Row) % sizeof(T) == 0);
  const ScenePtr& scene = mesh.scene;
  auto kept = std::make_unique<Mesh>(mesh);
  const py::capsule owner(kept.get(), [](void* p) {
    const std::unique_ptr<Mesh> view(static_cast<Mesh*>(p));
    --view->scene->mesh_views[view->id.index];
  });
  (void)kept.release();  // the capsule has it
  ++scene->mesh_views[mesh.id.index];
  const bool triples = std::is_same_v<Row, core::vec3>;
  const auto count = py::ssize_t(triples ? rows.size() : rows.size() / 3);
  auto array = view_of(reinterpret_cast<const T*>(rows.data()), {count, 3}, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

void remove_mesh(const Mesh& mesh) {
  core::Scene& scene = edit(mesh);
  if (mesh.scene->mesh_views[mesh.id.index] > 0) fail("mesh: arrays still look into it");
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item) && int(scene.kind(item)) >= core::kPrimitiveKindCount &&
        scene.mesh_of(item) == mesh.id)
      fail("mesh: item " + std::to_string(to_index(item)) + " still uses it");
  scene.remove_mesh(mesh.id);
}

std::optional<py::dict> surface_of_triangle(const Mesh& x, std::uint32_t triangle) {
  const core::Mesh& mesh = read(x).mesh(x.id);
  if (triangle >= mesh.indices.size() / 3) fail("triangle: the mesh has fewer");
  const std::uint32_t face = core::surface_of(mesh, triangle);
  if (face == core::kNone) return std::nullopt;
  const core::MeshSurface& surface = core::surfaces_stored_with(mesh)[face];
  py::dict found;
  found["kind"] = std::string(core::name_of(surface.kind));
  found["origin"] = to_array(surface.origin);
  found["axis"] = to_array(surface.axis);
  found["radius"] = surface.radius;
  found["tube_radius"] = surface.tube_radius;
  found["slope"] = surface.slope;
  return found;
}

void bind_mesh(py::module_& m) {
  py::class_<Mesh>(m, "Mesh", "Triangles of a scene, shared between items and immutable.")
      .def_property_readonly(
          "scene", [](const Mesh& x) { return x.scene; }, "The scene that holds it.")
      .def_property_readonly(
          "alive", [](const Mesh& x) { return alive(x, x.scene->read()); }, "False once it has been removed.")
      .def_property_readonly(
          "name", [](const Mesh& x) { return to_text(read(x).mesh(x.id).name); }, "Its name.")
      .def_property_readonly(
          "positions", [](const Mesh& x) { return look_into<float>(x, read(x).mesh(x.id).positions); },
          "(N, 3) float32: looks into the scene's memory, read-only.")
      .def_property_readonly(
          "normals", [](const Mesh& x) { return look_into<float>(x, read(x).mesh(x.id).normals); },
          "(N, 3) float32, or (0, 3): looks into the scene's memory, read-only.")
      .def_property_readonly(
          "indices", [](const Mesh& x) { return look_into<std::uint32_t>(x, read(x).mesh(x.id).indices); },
          "(triangles, 3) uint32: looks into the scene's memory, read-only.")
      .def_property_readonly(
          "bounds", [](const Mesh& x) { return to_array(read(x).mesh_bounds(x.id)); },
          "[[min], [max]] in local coordinates; None when empty.")
      .def("surface", &surface_of_triangle, py::arg("triangle"),
           "The surface that the mesh's file (STEP, IGES, BREP) states for the face of a triangle, such as that of a "
           "pick: kind (plane, cylinder, cone, sphere, torus), origin and axis in local coordinates, radius, "
           "tube_radius of a torus, slope of a cone: tangent of its half angle. None where it states none of these.")
      .def("remove", &remove_mesh, "Frees it. Fails while an item uses it or an array looks into it.")
      .def(
          "__eq__", [](const Mesh& a, const Mesh& b) { return a == b; }, py::is_operator())
      .def("__hash__", [](const Mesh& x) { return py::hash(py::int_(x.id.index)); });
}

// --- materials -------------------------------------------------------------------------------------------------------

template <class Change>
void update(const Material& material, const Change& change) {
  core::Scene& scene = edit(material);
  core::Material changed = scene.material(material.id);
  change(changed);
  scene.update_material(material.id, std::move(changed));
}

void bind_material(py::module_& m) {
  py::class_<Material>(m, "Material", "The look of items. Assigning to an attribute changes all of them at a commit.")
      .def_property_readonly(
          "scene", [](const Material& x) { return x.scene; }, "The scene that holds it.")
      .def_property_readonly(
          "alive", [](const Material& x) { return alive(x, x.scene->read()); }, "False once it has been removed.")
      .def_property(
          "name", [](const Material& x) { return to_text(read(x).material(x.id).name); },
          [](const Material& x, const py::str& name) {
            update(x, [&](core::Material& to) { to.name = to_bytes(name); });
          },
          "Its name.")
      .def_property(
          "colour",
          [](const Material& x) {
            const core::vec3 c = read(x).material(x.id).colour;
            return py::make_tuple(c.x, c.y, c.z);
          },
          [](const Material& x, const py::object& colour) {
            const core::vec3 c = colour_of(colour);
            update(x, [&](core::Material& to) { to.colour = c; });
          },
          "(red, green, blue), sRGB, 0 to 1.")
      .def_property(
          "alpha", [](const Material& x) { return read(x).material(x.id).alpha; },
          [](const Material& x, float alpha) { update(x, [&](core::Material& to) { to.alpha = alpha; }); },
          "1 opaque, 0 invisible.")
      .def_property(
          "code", [](const Material& x) { return read(x).material(x.id).code; },
          [](const Material& x, std::uint32_t code) { update(x, [&](core::Material& to) { to.code = code; }); },
          "The source file's own number.")
      .def(
          "remove", [](const Material& x) { edit(x).remove_material(x.id); },
          "Nodes and items with it have none from now on.")
      .def(
          "__eq__", [](const Material& a, const Material& b) { return a == b; }, py::is_operator())
      .def("__hash__", [](const Material& x) { return py::hash(py::int_(x.id.index)); });
}

// --- items -----------------------------------------------------------------------------------------------------------

void bind_item(py::module_& m) {
  py::class_<Item>(m, "Item", "A primitive or an instance of a mesh. Usable as its id wherever a number is.")
      .def_property_readonly(
          "scene", [](const Item& x) { return x.scene; }, "The scene that holds it.")
      .def_property_readonly(
          "alive", [](const Item& x) { return alive(x, x.scene->read()); }, "False once it has been removed.")
      .def_property_readonly(
          "id", [](const Item& x) { return x.id; },
          "Its number in the order of insertion; never given to another item.")
      .def_property_readonly(
          "kind", [](const Item& x) { return std::string(name_of(read(x).kind(x.id))); },
          "\"cylinder\", \"mesh\", …: one of KINDS.")
      .def_property_readonly(
          "node",
          [](const Item& x) {
            return Node{x.scene, read(x).node_of(x.id)};
          },
          "The node that holds it.")
      .def_property_readonly(
          "part", [](const Item& x) { return node_or_none(x.scene, core::part_of(read(x), read(x).node_of(x.id))); },
          "The part of its node; None where the item is a part by itself.")
      .def_property_readonly(
          "primitive",
          [](const Item& x) -> std::optional<core::Primitive> {
            const core::Scene& scene = read(x);
            if (int(scene.kind(x.id)) >= core::kPrimitiveKindCount) return std::nullopt;
            return scene.primitive(x.id);
          },
          "A copy of the primitive; None for a mesh.")
      .def_property_readonly(
          "mesh",
          [](const Item& x) -> std::optional<Mesh> {
            const core::Scene& scene = read(x);
            if (int(scene.kind(x.id)) < core::kPrimitiveKindCount) return std::nullopt;
            return Mesh{x.scene, scene.mesh_of(x.id)};
          },
          "The mesh; None for a primitive.")
      .def_property(
          "placement", [](const Item& x) { return to_array(read(x).placement(x.id)); },
          [](const Item& x, const py::object& m4) { edit(x).set_placement(x.id, affine(m4, "placement")); },
          "4 x 4, node from item. Kept in float32 but for the origin. A copy: assign to change it.")
      .def_property_readonly(
          "world_from_item", [](const Item& x) { return to_array(read(x).state(x.id).world_from_item); },
          "4 x 4: the placement under all nodes above.")
      .def_property(
          "visible", [](const Item& x) { return read(x).item_visible(x.id); },
          [](const Item& x, bool visible) { edit(x).set_visible(x.id, visible); }, "Its own flag; nodes have theirs.")
      .def_property(
          "material", [](const Item& x) { return material_or_none(x.scene, read(x).item_material(x.id)); },
          [](const Item& x, const std::optional<Material>& material) {
            const auto id = material_in(x.scene, material);
            edit(x).set_material(x.id, id);
          },
          "Its own material; None: the node's.")
      .def_property_readonly(
          "bounds",
          [](const Item& x) {
            const core::Scene& scene = read(x);
            return to_array(scene.bounds_under(x.id, scene.state(x.id).world_from_item));
          },
          "[[min], [max]] in the world; None when empty.")
      .def(
          "remove", [](const Item& x) { edit(x).remove_item(x.id); }, "Removes it from the scene.")
      .def("__index__", [](const Item& x) { return x.id; })
      .def("__int__", [](const Item& x) { return x.id; })
      .def(
          "__eq__", [](const Item& a, const Item& b) { return a == b; }, py::is_operator())
      .def("__hash__", [](const Item& x) { return py::hash(py::int_(to_index(x.id))); })
      .def("__repr__", [](const Item& x) { return "<sightline.Item " + std::to_string(to_index(x.id)) + ">"; });
}

// --- nodes -----------------------------------------------------------------------------------------------------------

std::vector<Node> children(const Node& node) {
  const core::Scene& scene = read(node);
  std::vector<Node> out;
  for (core::NodeId id = scene.first_child(node.id); id.valid(); id = scene.next_sibling(id))
    out.push_back({node.scene, id});
  return out;
}

py::array_t<std::uint32_t> items_of(const Node& node) {
  const core::Scene& scene = read(node);
  std::vector<core::ItemId> out;
  for (core::ItemId id = scene.first_item(node.id); id != core::kNoItem; id = scene.next_item(id)) out.push_back(id);
  return take(std::move(out));
}

Item add_item(const Node& node, const std::variant<core::Primitive, Mesh>& what, const py::object& placement,
              const std::optional<Material>& material) {
  const core::Affine node_from_item = affine(placement, "placement");
  const auto material_id = material_in(node.scene, material);
  if (const auto* mesh = std::get_if<Mesh>(&what)) {
    const auto mesh_id = id_in(node.scene, *mesh, "mesh");
    return {{node.scene, edit(node).add_mesh_instance(node.id, mesh_id, node_from_item, material_id)}};
  }
  return {
      {node.scene, edit(node).add_primitive(node.id, std::get<core::Primitive>(what), node_from_item, material_id)}};
}

py::array_t<std::uint32_t> add_primitives(const Node& node, const std::string& kind_name, const py::object& parameters,
                                          const py::object& placements, const std::optional<Material>& material) {
  std::size_t kind = 0;
  while (kind < core::kPrimitiveKindCount && core::name_of(core::Kind(kind)) != kind_name) ++kind;
  if (kind == core::kPrimitiveKindCount)
    fail("kind: expected a name of sightline.KINDS without meshes, found \"" + kind_name + "\"");
  const auto width = py::ssize_t(core::parameter_count(core::Kind(kind)));
  const auto rows = floats(parameters, "parameters", {-1, width});
  const py::ssize_t count = rows.shape(0);
  const bool placed = !placements.is_none();
  const auto matrices = placed ? doubles(placements, "placements", {count, 4, 4}) : Numbers<double>();
  std::vector<core::Affine> places(std::size_t(placed ? count : 0));
  for (py::ssize_t i = 0; i < py::ssize_t(places.size()); ++i)
    places[std::size_t(i)] = affine(matrices.data() + 16 * i, "placements");
  const auto material_id = material_in(node.scene, material);
  core::Scene& scene = edit(node);
  std::vector<core::ItemId> ids(std::size_t(count), core::kNoItem);
  for (py::ssize_t i = 0; i < count; ++i) {
    const auto values = std::span(rows.data() + i * width, std::size_t(width));
    ids[std::size_t(i)] = scene.add_primitive(node.id, core::make_primitive(core::Kind(kind), values),
                                              placed ? places[std::size_t(i)] : core::Affine(), material_id);
  }
  return take(std::move(ids));
}

py::dict attributes_of(const Node& node) {
  py::dict out;
  for (const auto& [key, value] : read(node).attributes(node.id)) out[to_text(key)] = to_text(value);
  return out;
}

std::vector<Node> find(const Node& node, const py::str& text, const py::str& key) {
  const core::NodeCondition condition{to_bytes(key), to_bytes(text)};
  std::vector<Node> out;
  const core::FoundNodes found = unwrap(core::find_nodes(read(node), node.id, std::span(&condition, 1)));
  for (const core::NodeId id : found.nodes) out.push_back({node.scene, id});
  return out;
}

void remove_node(const Node& node) {
  core::Scene& scene = edit(node);
  if (node.id == scene.root()) fail("node: the root stays");
  scene.remove_node(node.id);
}

void reparent(const Node& node, const Node& parent) {
  const auto parent_id = id_in(node.scene, parent, "parent");
  core::Scene& scene = edit(node);
  if (node.id == scene.root()) fail("node: the root stays");
  unwrap(scene.reparent(node.id, parent_id));
}

void bind_node_tree(py::class_<Node>& node) {
  node.def_property_readonly(
          "scene", [](const Node& x) { return x.scene; }, "The scene that holds it.")
      .def_property_readonly(
          "alive", [](const Node& x) { return alive(x, x.scene->read()); }, "False once it has been removed.")
      .def_property_readonly(
          "path", [](const Node& x) { return to_text(read(x).path(x.id)); },
          "Names from below the root, joined by \"/\"; \"#k\" for unnamed nodes.")
      .def_property_readonly(
          "parent", [](const Node& x) { return node_or_none(x.scene, read(x).parent(x.id)); }, "None for the root.")
      .def_property_readonly(
          "part", [](const Node& x) { return node_or_none(x.scene, core::part_of(read(x), x.id)); },
          "The nearest node at or above it that has a name and lies below a file's, which is a child of the root; None "
          "where there is no such. node.part.parent.part is the assembly.")
      .def_property_readonly("children", &children, "A list, in order.")
      .def_property_readonly("items", &items_of, "Ids of its own items, uint32, in order of insertion.")
      .def(
          "add_node",
          [](const Node& x, const py::str& name, const py::object& transform) {
            const core::Affine m = affine(transform, "transform");
            return Node{x.scene, edit(x).add_node(x.id, to_bytes(name), m)};
          },
          py::arg("name") = "", py::arg("transform") = py::none(), "Appends a child.")
      .def("add", &add_item, py::arg("what"), py::arg("placement") = py::none(), py::arg("material") = py::none(),
           "Adds a primitive, or an instance of a mesh of the same scene. `placement`: 4 x 4, node from item.")
      .def("add_primitives", &add_primitives, py::arg("kind"), py::arg("parameters"),
           py::arg("placements") = py::none(), py::arg("material") = py::none(),
           "Adds many primitives of one kind: `parameters` (N, count), `placements` (N, 4, 4). Returns their ids.")
      .def("find", &find, py::arg("text"), py::arg("key") = "",
           "The nodes of this subtree that `text` names, by the first step that finds any: a path or its end, a name, "
           "the "
           "value of an attribute (`KEY=TEXT`, or with `key`, of one; key `Name` is the node's name), whole words of "
           "these. `*`, `?` and `re:` make a pattern of it. Exact case first, then any case of ASCII letters.")
      .def(
          "bounds", [](const Node& x, std::uint32_t layers) { return to_array(read(x).bounds(x.id, layers)); },
          py::arg("layers") = core::kDefaultLayerMask,
          "[[min], [max]] in the world of the subtree's visible items; None when there are none.")
      .def("reparent", &reparent, py::arg("parent"), "Makes it the last child of another node.")
      .def("remove", &remove_node, "Removes it with its subtree and items. Not the root.")
      .def(
          "__eq__", [](const Node& a, const Node& b) { return a == b; }, py::is_operator())
      .def("__hash__", [](const Node& x) { return py::hash(py::int_(x.id.index)); })
      .def("__repr__", [](const Node& x) {
        return py::str("<sightline.Node {!r}>")
            .format(alive(x, x.scene->read()) ? to_text(read(x).path(x.id)) : py::str("removed"));
      });
}

void bind_node(py::module_& m) {
  py::class_<Node> node(m, "Node", "A node of a scene's tree. It keeps its scene alive.");
  bind_node_tree(node);
  node.def_property(
          "name", [](const Node& x) { return to_text(read(x).name(x.id)); },
          [](const Node& x, const py::str& name) { edit(x).set_name(x.id, to_bytes(name)); },
          "Its name; bytes that are no UTF-8 are lone surrogates.")
      .def_property(
          "transform", [](const Node& x) { return to_array(read(x).transform(x.id)); },
          [](const Node& x, const py::object& m4) { edit(x).set_transform(x.id, affine(m4, "transform")); },
          "4 x 4 float64, parent from node. A copy: assign to change it.")
      .def_property_readonly(
          "world_from_node", [](const Node& x) { return to_array(read(x).world_from_node(x.id)); },
          "4 x 4: all transforms from the root down.")
      .def_property(
          "visible", [](const Node& x) { return read(x).visible(x.id); },
          [](const Node& x, bool visible) { edit(x).set_visible(x.id, visible); }, "Hides or shows the whole subtree.")
      .def_property(
          "layers", [](const Node& x) { return read(x).layers(x.id); },
          [](const Node& x, std::uint32_t layers) { edit(x).set_layers(x.id, layers); },
          "Layer bits of its own items; 0: the parent's.")
      .def_property(
          "material", [](const Node& x) { return material_or_none(x.scene, read(x).material(x.id)); },
          [](const Node& x, const std::optional<Material>& material) {
            const auto id = material_in(x.scene, material);
            edit(x).set_material(x.id, id);
          },
          "For items of the subtree without one; None: the parent's.")
      .def_property_readonly("attributes", &attributes_of, "A dict: a copy, see set_attribute().")
      .def(
          "set_attribute",
          [](const Node& x, const py::str& key, const py::str& value) {
            edit(x).set_attribute(x.id, to_bytes(key), to_bytes(value));
          },
          py::arg("key"), py::arg("value"), "Sets one attribute.");
}

// --- the scene -------------------------------------------------------------------------------------------------------

core::SceneDelta commit(const ScenePtr& scene) {
  core::Expected<core::SceneDelta> delta;
  {
    const LongCall call({scene->gate, Use::kWrite});
    delta = scene->scene.commit();
  }
  return unwrap(std::move(delta));
}

void generate_plant(const ScenePtr& scene, std::uint64_t items, std::uint64_t seed) {
  core::Expected<void> done;
  {
    const LongCall call({scene->gate, Use::kWrite});
    done = importers::generate_plant({items, seed}, scene->scene);
  }
  unwrap(std::move(done));
}

py::array_t<std::uint32_t> all_items(const ScenePtr& scene) {
  const core::Scene& from = scene->read();
  std::vector<core::ItemId> ids;
  ids.reserve(from.item_count());
  for (core::ItemId id{0}; to_index(id) < from.item_slots(); ++id)
    if (from.contains_item(id)) ids.push_back(id);
  return take(std::move(ids));
}

template <class Handle, class At>
std::vector<Handle> all(const ScenePtr& scene, std::size_t slots, const At& at) {
  std::vector<Handle> out;
  for (std::size_t i = 0; i < slots; ++i)
    if (const auto id = at(i); id.valid()) out.push_back({scene, id});
  return out;
}

void bind_delta(py::module_& m) {
  using core::SceneDelta;
  py::class_<SceneDelta> c(m, "SceneDelta", "What a commit published. Ids as uint32 arrays, rising.");
  c.def_property_readonly(
       "inserted", [](const SceneDelta& d) { return to_array(d.inserted); }, "New items.")
      .def_property_readonly(
          "changed", [](const SceneDelta& d) { return to_array(d.changed); },
          "Items moved, hidden, shown, re-layered or given another material.")
      .def_property_readonly(
          "removed", [](const SceneDelta& d) { return to_array(d.removed); }, "Items that are gone for good.")
      .def("__len__", &SceneDelta::size);
  bind_value<&SceneDelta::inserted, &SceneDelta::changed, &SceneDelta::removed>(c);
}

}  // namespace

template <class Handle>
const core::Scene& read(const Handle& handle) {
  const core::Scene& scene = handle.scene->read();
  check(handle, scene);
  return scene;
}

template <class Handle>
core::Scene& edit(const Handle& handle) {
  core::Scene& scene = handle.scene->edit();
  check(handle, scene);
  return scene;
}

template const core::Scene& read(const Node&);

core::NodeId node_in(const ScenePtr& scene, const std::optional<Node>& node, const char* argument) {
  return node ? id_in(scene, *node, argument) : scene->read().root();
}

void bind_scene(py::module_& m) {
  // Declared before any of them is described, so that signatures name them.
  SceneClass scene(m, "Scene", "The retained scene graph. Edits are cheap and take effect at commit().");
  bind_delta(m);
  bind_material(m);
  bind_mesh(m);
  bind_item(m);
  bind_node(m);
  scene.def(py::init<>(), "An empty scene with its root.")
      .def_property_readonly(
          "root",
          [](const ScenePtr& s) {
            return Node{s, s->read().root()};
          },
          "The node above all others.")
      .def_property_readonly(
          "node_count", [](SceneBox& s) { return s.read().node_count(); }, "With the root.")
      .def_property_readonly(
          "item_count", [](SceneBox& s) { return s.read().item_count(); }, "Of living items.")
      .def_property_readonly(
          "memory_bytes", [](SceneBox& s) { return s.read().memory_bytes(); }, "Held by the scene.")
      .def_property(
          "reuse_ids", [](SceneBox& s) { return s.read().reuses_ids(); },
          [](SceneBox& s, bool reuse) { s.edit().reuse_ids(reuse); },
          "Whether what is added may get ids of items that were removed since this was set: for programs that add and "
          "remove for days, which forget the ids that they remove.")
      .def_property_readonly("items", &all_items, "Ids of all items, uint32, rising.")
      .def_property_readonly(
          "meshes",
          [](const ScenePtr& s) {
            return all<Mesh>(s, s->read().mesh_slots(), [&](std::size_t i) { return s->scene.mesh_at(i); });
          },
          "All meshes, a list.")
      .def_property_readonly(
          "materials",
          [](const ScenePtr& s) {
            return all<Material>(s, s->read().material_slots(), [&](std::size_t i) { return s->scene.material_at(i); });
          },
          "All materials, a list.")
      .def(
          "item",
          [](const ScenePtr& s, core::ItemId id) {
            if (!s->read().contains_item(id)) fail("item: there is none with id " + std::to_string(to_index(id)));
            return Item{{s, id}};
          },
          py::arg("id"), "The item with this id.")
      .def("add_mesh", &add_mesh, py::arg("positions"), py::arg("indices"), py::arg("normals") = py::none(),
           py::arg("name") = "",
           "Copies a mesh into the scene. `positions`, `normals`: (N, 3) float32; `indices`: (triangles, 3), "
           "counter-clockwise from outside.")
      .def(
          "add_material",
          [](const ScenePtr& s, const py::str& name, const py::object& colour, float alpha, std::uint32_t code) {
            const core::vec3 c = colour_of(colour);
            return Material{s, s->edit().add_material({to_bytes(name), c, alpha, code})};
          },
          py::arg("name") = "", py::arg("colour") = py::make_tuple(0.7, 0.7, 0.7), py::arg("alpha") = 1.0f,
          py::arg("code") = 0u, "`colour`: (red, green, blue), sRGB, 0 to 1; `alpha`: 1 opaque, 0 invisible.")
      .def("generate_plant", &generate_plant, py::arg("items") = 100'000, py::arg("seed") = 1,
           "Appends a synthetic process plant of exactly so many items, 1,000 to 10,000,000: the same for the same "
           "seed, everywhere.")
      .def("commit", &commit,
           "Validates and publishes all edits since the last one, or none of them: the error names the node. "
           "Engine.commit() calls it, too.");
  bind_import(m, scene);
}

}  // namespace sightline::python
