// Hands out what js/plant.js draws of a scene: records of analytic primitives, and meshes with their instances.
#include <array>

#include "sightline/bindings/wasm/call.h"
#include "sightline/bindings/wasm/scene.h"
#include "sightline/gpuprims/internal/packing.h"

namespace sightline::wasm {
namespace {

using core::Kind;

/// Kinds that one program draws, in the order of RECORD_WORDS in js/primitives.js.
constexpr std::array<std::initializer_list<Kind>, 7> kPrograms = {
    {{Kind::kCylinder},
     {Kind::kSnout},
     {Kind::kCircularTorus},
     {Kind::kSphere, Kind::kEllipticalDish, Kind::kSphericalDish},
     {Kind::kRectangularTorus},
     {Kind::kPyramid},
     {Kind::kBox}}};

/// Calls visit(slot, its index among the kind) for items that are shown.
template <class Visit>
void for_each_shown(const core::Snapshot& snapshot, Kind kind, const Visit& visit) {
  const core::KindItems& items = snapshot.of_kind(kind);
  for (std::size_t i = 0; i < items.size(); ++i)
    if (!snapshot.vacant(items.members[i])) visit(items.members[i], i);
}

constexpr std::array kMeshKinds = {Kind::kFacetGroup, Kind::kMesh};

}  // namespace

/// Answers with the words of the records of a program's primitives; their items follow at sl_scene_record_items().
SIGHTLINE_EXPORT bool sl_scene_records(Model* model, std::uint32_t program) {
  return attempt([&]() -> core::Expected<bool> {
    if (!model->snapshot) return core::fail("expected commit() first");
    const core::Snapshot& snapshot = *model->snapshot;
    if (!model->joints) model->joints.emplace(snapshot);
    model->words.clear();
    std::array<gpuprims::Texel, 8> texels;
    for (const Kind kind : kPrograms.at(program)) {
      const std::span record(texels.data(), std::size_t(gpuprims::texels_per_item(kind)));
      for_each_shown(snapshot, kind, [&](core::Slot slot, std::size_t) {
        gpuprims::pack(snapshot, slot, gpuprims::material_word(snapshot, *model->joints, slot), record);
        for (const gpuprims::Texel& texel : record) model->words.insert(model->words.end(), texel.begin(), texel.end());
      });
    }
    answer(model->words);
    return true;
  });
}
SIGHTLINE_EXPORT bool sl_scene_record_items(Model* model, std::uint32_t program) {
  return attempt_all([&] {
    model->words.clear();
    for (const Kind kind : kPrograms.at(program))
      for_each_shown(*model->snapshot, kind, [&](core::Slot slot, std::size_t) {
        model->words.push_back(core::to_index(model->snapshot->item(slot)));
      });
    answer(model->words);
  });
}
SIGHTLINE_EXPORT void sl_scene_chunk_origins(Model* model) {
  const auto& origins = model->snapshot->chunk_origins();
  answer(origins.data(), 3 * origins.size());
}
/// sRGB and alpha: of items without a material, then by material index.
SIGHTLINE_EXPORT bool sl_scene_materials(Model* model) {
  return attempt_all([&] {
    const core::Material none;
    model->floats = {none.colour.x, none.colour.y, none.colour.z, none.alpha};
    for (const glm::vec4& row : model->snapshot->materials())
      model->floats.insert(model->floats.end(), {row.x, row.y, row.z, row.w});
    answer(model->floats);
  });
}

/// Three words for each mesh item that is shown: item, mesh, row of sl_scene_materials().
SIGHTLINE_EXPORT bool sl_scene_instances(Model* model) {
  return attempt([&]() -> core::Expected<bool> {
    if (!model->snapshot) return core::fail("expected commit() first");
    const core::Snapshot& snapshot = *model->snapshot;
    model->words.clear();
    for (const Kind kind : kMeshKinds)
      for_each_shown(snapshot, kind, [&](core::Slot slot, std::size_t i) {
        const std::uint32_t mesh = snapshot.of_kind(kind).meshes[i];
        model->words.insert(model->words.end(),
                            {core::to_index(snapshot.item(slot)), mesh, gpuprims::material_row(snapshot, slot)});
      });
    answer(model->words);
    return true;
  });
}
/// Sixteen numbers in columns for each of these.
SIGHTLINE_EXPORT bool sl_scene_instance_matrices(Model* model) {
  return attempt_all([&] {
    const core::Snapshot& snapshot = *model->snapshot;
    model->doubles.clear();
    for (const Kind kind : kMeshKinds)
      for_each_shown(snapshot, kind, [&](core::Slot slot, std::size_t) {
        const core::Affine world = snapshot.world_from_item(slot);
        for (int column = 0; column < 3; ++column) {
          const core::dvec3& axis = world.linear[column];
          model->doubles.insert(model->doubles.end(), {axis.x, axis.y, axis.z, 0.0});
        }
        model->doubles.insert(model->doubles.end(), {world.origin.x, world.origin.y, world.origin.z, 1.0});
      });
    answer(model->doubles);
  });
}

enum class MeshPart : std::uint32_t { kPositions, kNormals, kIndices };

/// Numbers of a mesh, in place. `mesh`: as sl_scene_instances() has it.
SIGHTLINE_EXPORT bool sl_scene_mesh(const Model* model, std::uint32_t mesh, MeshPart part) {
  return attempt([&]() -> core::Expected<bool> {
    const core::MeshId found = mesh < model->scene.mesh_slots() ? model->scene.mesh_at(mesh) : core::MeshId();
    if (!found.valid()) return core::fail("expected a mesh of this scene, got " + std::to_string(mesh));
    const core::Mesh& content = model->scene.mesh(found);
    if (part == MeshPart::kIndices)
      answer(content.indices);
    else if (part == MeshPart::kNormals)
      answer(content.normals.data(), 3 * content.normals.size());
    else
      answer(content.positions.data(), 3 * content.positions.size());
    return true;
  });
}

}  // namespace sightline::wasm
