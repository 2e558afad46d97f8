#include "sightline/bindings/wasm/scene.h"

#include <algorithm>
#include <cstring>

#include "sightline/bindings/wasm/call.h"
#include "sightline/bindings/wasm/numbers.h"
#include "sightline/bindings/wasm/visibility.h"
#include "sightline/core/find_nodes.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/rvm/internal/rvm_attributes.h"
#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/importers/slc/internal/slc_scene.h"

namespace sightline::wasm {
namespace {

/// A share of slots out of order from which on a snapshot is made anew.
constexpr std::size_t kDisorder = 4;

core::Expected<importers::ImportReport> read(Model& model, std::span<const std::byte> bytes, const std::string& name,
                                             const importers::ImportOptions& options) {
  const std::filesystem::path path(name);
  const core::NodeId root = model.scene.root();
  const std::string extension = importers::lower_case_extension(path);
  if (extension == ".rvm" || extension == ".rev") return importers::read_rvm(bytes, name, model.scene, root, options);
  if (extension == ".slc") return importers::read_slc(bytes, path, model.scene, root, options);
  if (extension == ".txt" || extension == ".att")
    return importers::read_rvm_attributes(bytes, path, model.scene, root, options);
  return core::fail(name + ": expected a name that ends in .rvm, .rev, .slc, .txt or .att");
}

void append(std::string& text, std::string_view part) {
  text.append(part);
  text.push_back('\0');
}
void answer_text(const std::string& text) {
  answer(text.data(), text.size());
}

core::Expected<core::NodeId> node_at(const Model& model, std::uint32_t number) {
  if (number >= model.nodes.size() || !model.scene.contains(model.nodes[number]))
    return core::fail("expected a node of this scene, got " + std::to_string(number));
  return model.nodes[number];
}
core::Expected<core::ItemId> item_at(const Model& model, std::uint32_t number) {
  if (!model.scene.contains_item(core::ItemId(number)))
    return core::fail("expected an item of this scene, got " + std::to_string(number));
  return core::ItemId(number);
}

/// Calls edit(node), of a number that JavaScript gave.
template <class Edit>
bool edit_node(Model* model, std::uint32_t number, const Edit& edit) {
  return attempt([&]() -> core::Expected<bool> {
    const auto node = node_at(*model, number);
    if (!node) return tl::unexpected(node.error());
    edit(*node);
    return true;
  });
}
template <class Edit>
bool edit_item(Model* model, std::uint32_t number, const Edit& edit) {
  return attempt([&]() -> core::Expected<bool> {
    const auto item = item_at(*model, number);
    if (!item) return tl::unexpected(item.error());
    edit(*item);
    return true;
  });
}
core::MaterialId material_at(const Model& model, std::uint32_t number) {
  return number < model.materials.size() ? model.materials[number] : core::MaterialId();
}

}  // namespace

void Model::find_nodes() {
  scene.for_each_node(scene.root(), [&](core::NodeId node, const auto&...) {
    if (number_of.try_emplace(node.index, std::uint32_t(nodes.size())).second) nodes.push_back(node);
  });
}

core::Expected<void> Model::commit() {
  const auto delta = scene.commit();
  if (!delta) return tl::unexpected(delta.error());
  joints.reset();
  if (snapshot && snapshot->disorder() * kDisorder <= snapshot->size()) {
    const std::vector<core::Slot> touched = snapshot->apply(*delta);
    culler->update(touched, &threads);
    if (tracer) return tracer->update(touched);
    return {};
  }
  tracer.reset();
  culler.reset();
  snapshot = std::make_unique<core::Snapshot>(scene);
  culler.emplace(snapshot->bounds());
  return {};
}

// --- the scene -------------------------------------------------------------------------------------------------------

SIGHTLINE_EXPORT Model* sl_scene_create() {
  return attempt([]() -> core::Expected<Model*> { return new Model; });
}
SIGHTLINE_EXPORT void sl_scene_destroy(Model* model) {
  delete model;
}

/// Reads a file's bytes; its name's extension tells the format. sl_scene_warnings() and sl_scene_report() follow.
SIGHTLINE_EXPORT bool sl_scene_read(Model* model, const std::byte* bytes, std::uint32_t count, const char* name,
                                    std::uint32_t name_length, bool lenient) {
  return attempt([&]() -> core::Expected<bool> {
    importers::ImportOptions options;
    options.lenient = lenient;
    auto report = read(*model, {bytes, count}, std::string(name, name_length), options);
    if (!report) return tl::unexpected(report.error());
    model->report = std::move(*report);
    model->find_nodes();
    return true;
  });
}
SIGHTLINE_EXPORT void sl_scene_warnings(Model* model) {
  model->text.clear();
  for (const importers::ImportWarning& warning : model->report.warnings)
    append(model->text, warning.file + ": byte " + std::to_string(warning.offset) + ": " + warning.message);
  answer_text(model->text);
}
/// Metres per unit, degenerate items, groups with attributes, and items by kind.
SIGHTLINE_EXPORT void sl_scene_report(Model* model) {
  const importers::ImportReport& report = model->report;
  model->doubles = {report.metres_per_unit, double(report.degenerate), double(report.attributed)};
  model->doubles.insert(model->doubles.end(), report.items.begin(), report.items.end());
  answer(model->doubles);
}
SIGHTLINE_EXPORT void sl_scene_kind_names(Model* model) {
  model->text.clear();
  for (int kind = 0; kind < core::kKindCount; ++kind) append(model->text, core::name_of(core::Kind(kind)));
  answer_text(model->text);
}

SIGHTLINE_EXPORT bool sl_scene_commit(Model* model) {
  return attempt([&]() -> core::Expected<bool> { return done(model->commit()); });
}

// --- building --------------------------------------------------------------------------------------------------------

constexpr std::uint32_t kFailed = core::kNone;

/// Returns the node's number, or kFailed.
SIGHTLINE_EXPORT std::uint32_t sl_scene_add_node(Model* model, std::uint32_t parent, const char* name,
                                                 std::uint32_t length, const double* parent_from_node) {
  std::uint32_t number = kFailed;
  attempt([&]() -> core::Expected<bool> {
    const auto above = node_at(*model, parent);
    if (!above) return tl::unexpected(above.error());
    const core::NodeId node = model->scene.add_node(*above, {name, length}, affine_at(parent_from_node));
    number = std::uint32_t(model->nodes.size());
    model->number_of[node.index] = number;
    model->nodes.push_back(node);
    return true;
  });
  return number;
}
SIGHTLINE_EXPORT bool sl_scene_set_transform(Model* model, std::uint32_t node, const double* parent_from_node) {
  return edit_node(model, node,
                   [&](core::NodeId found) { model->scene.set_transform(found, affine_at(parent_from_node)); });
}
SIGHTLINE_EXPORT bool sl_scene_set_node_visible(Model* model, std::uint32_t node, bool visible) {
  return edit_node(model, node, [&](core::NodeId found) { model->scene.set_visible(found, visible); });
}
/// `normals` may be null. Returns a number for sl_scene_add_instance(), or kFailed.
SIGHTLINE_EXPORT std::uint32_t sl_scene_add_mesh(Model* model, const float* positions, std::uint32_t vertices,
                                                 const float* normals, const std::uint32_t* indices,
                                                 std::uint32_t index_count) {
  std::uint32_t number = kFailed;
  attempt([&]() -> core::Expected<bool> {
    core::Mesh mesh;
    const auto* const points = reinterpret_cast<const core::vec3*>(positions);
    mesh.positions.assign(points, points + vertices);
    if (normals != nullptr) {
      const auto* const directions = reinterpret_cast<const core::vec3*>(normals);
      mesh.normals.assign(directions, directions + vertices);
    }
    mesh.indices.assign(indices, indices + index_count);
    const auto added = model->scene.add_mesh(std::move(mesh));
    if (!added) return tl::unexpected(added.error());
    number = std::uint32_t(model->meshes.size());
    model->meshes.push_back(*added);
    return true;
  });
  return number;
}
SIGHTLINE_EXPORT std::uint32_t sl_scene_add_material(Model* model, float red, float green, float blue, float alpha) {
  std::uint32_t number = kFailed;
  attempt_all([&] {
    const core::MaterialId added =
        model->scene.add_material({.name = {}, .colour = {red, green, blue}, .alpha = alpha});
    number = std::uint32_t(model->materials.size());
    model->materials.push_back(added);
  });
  return number;
}
/// Returns the item, or kFailed. `material`: kNone for none.
SIGHTLINE_EXPORT std::uint32_t sl_scene_add_primitive(Model* model, std::uint32_t node, std::uint32_t kind,
                                                      const float* parameters, std::uint32_t count,
                                                      const double* node_from_item, std::uint32_t material) {
  std::uint32_t item = kFailed;
  attempt([&]() -> core::Expected<bool> {
    const auto found = node_at(*model, node);
    if (!found) return tl::unexpected(found.error());
    if (kind >= core::kPrimitiveKindCount) return core::fail("expected a kind of primitive");
    const auto wanted = std::uint32_t(core::parameter_count(core::Kind(kind)));
    if (count != wanted)
      return core::fail(std::string(core::name_of(core::Kind(kind))) + ": expected " + std::to_string(wanted) +
                        " parameters, got " + std::to_string(count));
    item =
        core::to_index(model->scene.add_primitive(*found, core::make_primitive(core::Kind(kind), {parameters, count}),
                                                  affine_at(node_from_item), material_at(*model, material)));
    return true;
  });
  return item;
}
SIGHTLINE_EXPORT std::uint32_t sl_scene_add_instance(Model* model, std::uint32_t node, std::uint32_t mesh,
                                                     const double* node_from_item, std::uint32_t material) {
  std::uint32_t item = kFailed;
  attempt([&]() -> core::Expected<bool> {
    const auto found = node_at(*model, node);
    if (!found) return tl::unexpected(found.error());
    if (mesh >= model->meshes.size()) return core::fail("expected a mesh of addMesh()");
    item = core::to_index(model->scene.add_mesh_instance(*found, model->meshes[mesh], affine_at(node_from_item),
                                                         material_at(*model, material)));
    return true;
  });
  return item;
}
SIGHTLINE_EXPORT bool sl_scene_remove_item(Model* model, std::uint32_t item) {
  return edit_item(model, item, [&](core::ItemId found) { model->scene.remove_item(found); });
}
SIGHTLINE_EXPORT bool sl_scene_set_placement(Model* model, std::uint32_t item, const double* node_from_item) {
  return edit_item(model, item,
                   [&](core::ItemId found) { model->scene.set_placement(found, affine_at(node_from_item)); });
}
SIGHTLINE_EXPORT bool sl_scene_set_item_visible(Model* model, std::uint32_t item, bool visible) {
  return edit_item(model, item, [&](core::ItemId found) { model->scene.set_visible(found, visible); });
}

// --- what is in it ---------------------------------------------------------------------------------------------------

/// Parents of nodes, by number; kNone of the root.
SIGHTLINE_EXPORT bool sl_scene_parents(Model* model) {
  return attempt_all([&] {
    model->words.assign(model->nodes.size(), core::kNone);
    for (std::size_t i = 0; i < model->nodes.size(); ++i) {
      const core::NodeId parent = model->scene.parent(model->nodes[i]);
      if (parent.valid()) model->words[i] = model->number_of.at(parent.index);
    }
    answer(model->words);
  });
}
/// Names of nodes, by number, each ended by a NUL.
SIGHTLINE_EXPORT bool sl_scene_names(Model* model) {
  return attempt_all([&] {
    model->text.clear();
    for (const core::NodeId node : model->nodes) append(model->text, model->scene.name(node));
    answer_text(model->text);
  });
}
/// Numbers of the nodes that a text names.
SIGHTLINE_EXPORT bool sl_scene_find(Model* model, const char* text, std::uint32_t length) {
  return attempt([&]() -> core::Expected<bool> {
    const core::NodeCondition condition{"", {text, length}};
    const auto found = core::find_nodes(model->scene, model->scene.root(), {&condition, 1});
    if (!found) return tl::unexpected(found.error());
    model->words.clear();
    for (const core::NodeId node : found->nodes) model->words.push_back(model->number_of.at(node.index));
    answer(model->words);
    return true;
  });
}
/// Keys and values in turn, each ended by a NUL.
SIGHTLINE_EXPORT bool sl_scene_attributes(Model* model, std::uint32_t node) {
  return attempt([&]() -> core::Expected<bool> {
    const auto found = node_at(*model, node);
    if (!found) return tl::unexpected(found.error());
    model->text.clear();
    for (const auto& [key, value] : model->scene.attributes(*found)) {
      append(model->text, key);
      append(model->text, value);
    }
    answer_text(model->text);
    return true;
  });
}
/// Nodes of items, by id; kNone of those that were removed.
SIGHTLINE_EXPORT bool sl_scene_item_nodes(Model* model) {
  return attempt_all([&] {
    model->words.assign(model->scene.item_slots(), core::kNone);
    for (std::size_t i = 0; i < model->words.size(); ++i)
      if (const core::ItemId item{std::uint32_t(i)}; model->scene.contains_item(item))
        model->words[i] = model->number_of.at(model->scene.node_of(item).index);
    answer(model->words);
  });
}
/// Kinds of items, by id.
SIGHTLINE_EXPORT bool sl_scene_item_kinds(Model* model) {
  return attempt_all([&] {
    model->bytes.assign(model->scene.item_slots(), 0xff);
    for (std::size_t i = 0; i < model->bytes.size(); ++i)
      if (const core::ItemId item{std::uint32_t(i)}; model->scene.contains_item(item))
        model->bytes[i] = std::uint8_t(model->scene.kind(item));
    answer(model->bytes);
  });
}
/// Boxes of items, by id, as of the last commit: empty ones of those that are hidden or removed.
SIGHTLINE_EXPORT bool sl_scene_boxes(Model* model) {
  return attempt([&]() -> core::Expected<bool> {
    if (!model->snapshot) return core::fail("expected commit() first");
    const core::AabbD empty;
    std::vector<double>& numbers = model->doubles;
    numbers.clear();
    for (std::uint32_t i = 0; i < model->scene.item_slots(); ++i) {
      const core::Slot slot = model->snapshot->slot(core::ItemId(i));
      core::AabbD box = empty;
      const core::ItemBounds& bounds = model->snapshot->bounds();
      if (slot != core::kNone && !model->snapshot->vacant(slot)) box = bounds.in_world(bounds.box(slot));
      for (int axis = 0; axis < 3; ++axis) numbers.push_back(box.min[axis]);
      for (int axis = 0; axis < 3; ++axis) numbers.push_back(box.max[axis]);
    }
    answer(numbers);
    return true;
  });
}

// --- what a view shows of it -----------------------------------------------------------------------------------------

SIGHTLINE_EXPORT bool sl_scene_visible(Model* model, const ViewObject* view, const culling::DepthPyramid* pyramid,
                                       float least_area) {
  return attempt([&]() -> core::Expected<bool> {
    if (!model->snapshot) return core::fail("expected commit() first");
    find_visible(model->snapshot->bounds(), *model->culler, *view, {pyramid, least_area}, &model->threads, model->set);
    model->words.clear();
    model->set.for_each_slot([&](core::Slot slot) {
      if (!model->snapshot->vacant(slot)) model->words.push_back(core::to_index(model->snapshot->item(slot)));
    });
    answer(model->words);
    return true;
  });
}

/// A depth image of the solids that the view shows, of those that are expected to cover so many pixels.
SIGHTLINE_EXPORT bool sl_scene_occluders(Model* model, const ViewObject* view, culling::DepthPyramid* pyramid,
                                         float least_area) {
  return attempt([&]() -> core::Expected<bool> {
    if (!model->snapshot) return core::fail("expected commit() first");
    find_visible(model->snapshot->bounds(), *model->culler, *view, {nullptr, least_area}, nullptr, model->set);
    model->solids.begin(*model->snapshot, view->view, view->width, view->height);
    model->solids.add(model->set, &model->threads);
    model->solids.build(*pyramid, {}, &model->threads);
    return true;
  });
}

// --- rays ------------------------------------------------------------------------------------------------------------

/// Answers with eleven numbers for each hit: item, t, point, normal, triangle, face, node. `view`: whose sections and
/// layers count, or null. `all`: every crossing, else the first.
SIGHTLINE_EXPORT bool sl_scene_hits(Model* model, const double* ray, const ViewObject* view, bool all) {
  return attempt([&]() -> core::Expected<bool> {
    if (!model->snapshot) return core::fail("expected commit() first");
    if (!model->tracer) {
      auto tracer = raytrace::Tracer::create(*model->snapshot);
      if (!tracer) return tl::unexpected(tracer.error());
      model->tracer.emplace(std::move(*tracer));
    }
    const raytrace::RayFilter filter = view != nullptr ? raytrace::filter_of(view->view) : raytrace::RayFilter();
    model->hits.clear();
    if (all) {
      const auto found = model->tracer->all(ray_at(ray), model->hits, filter);
      if (!found) return tl::unexpected(found.error());
    } else {
      const auto found = model->tracer->nearest(ray_at(ray), filter);
      if (!found) return tl::unexpected(found.error());
      if (*found) model->hits.push_back(**found);
    }
    model->doubles.clear();
    for (const raytrace::Hit& hit : model->hits)
      model->doubles.insert(
          model->doubles.end(),
          {double(core::to_index(hit.item)), hit.t, hit.point.x, hit.point.y, hit.point.z, hit.normal.x, hit.normal.y,
           hit.normal.z, hit.triangle == core::kNone ? -1.0 : double(hit.triangle), double(hit.face),
           double(model->number_of.at(model->scene.node_of(hit.item).index))});
    answer(model->doubles);
    return true;
  });
}
SIGHTLINE_EXPORT void sl_scene_face_names(Model* model) {
  model->text.clear();
  for (int face = 0; face <= int(core::Face::kCut); ++face) append(model->text, core::name_of(core::Face(face)));
  answer_text(model->text);
}

}  // namespace sightline::wasm
