#include "sightline/apps/bench/losses/level_chain.h"

#include <algorithm>
#include <limits>

#if SIGHTLINE_HAS_MESHOPT
#include <meshoptimizer.h>
#endif

namespace sightline::bench {
namespace {

constexpr std::size_t kFewTriangles = 32;
constexpr double kLeastGain = 0.9;  // of the triangles before: a halving that leaves more is the last

#if SIGHTLINE_HAS_MESHOPT
/// About half as many triangles, with the vertices that these have; adds the estimated error.
core::Mesh halved(const core::Mesh& mesh, float& error) {
  constexpr float kAnyError = std::numeric_limits<float>::max();
  std::vector<core::vec3> places = mesh.positions;
  for (core::vec3& p : places) p += 0.0f;  // meshoptimizer takes -0 for another place than 0
  const float* positions = &places[0].x;
  std::vector<std::uint32_t> indices(mesh.indices.size());
  float relative = 0.0f;
  indices.resize(meshopt_simplify(indices.data(), mesh.indices.data(), mesh.indices.size(), positions,
                                  mesh.positions.size(), sizeof(core::vec3), mesh.indices.size() / 6 * 3, kAnyError, 0,
                                  &relative));
  error += relative * meshopt_simplifyScale(positions, mesh.positions.size(), sizeof(core::vec3));
  core::Mesh half;
  std::vector<std::uint32_t> place(mesh.positions.size(), core::kNone);
  for (std::uint32_t& index : indices) {
    if (place[index] == core::kNone) {
      place[index] = std::uint32_t(half.positions.size());
      half.positions.push_back(mesh.positions[index]);
      if (!mesh.normals.empty()) half.normals.push_back(mesh.normals[index]);
    }
    index = place[index];
  }
  half.indices = std::move(indices);
  return half;
}
#else
core::Mesh halved(const core::Mesh& mesh, float&) {
  return mesh;
}
#endif

}  // namespace

LevelChain::Chain LevelChain::make_chain(const core::Mesh& mesh) {
  Chain chain;
  for (const core::vec3& position : mesh.positions) chain.box.grow({position, position});
  float error = 0.0f;
  const core::Mesh* last = &mesh;
  while (last->indices.size() > 3 * kFewTriangles) {
    core::Mesh half = halved(*last, error);
    if (half.indices.empty() || double(half.indices.size()) > kLeastGain * double(last->indices.size())) break;
    chain.levels.push_back({scene_.add_mesh(std::move(half)).value(), error});
    last = &scene_.mesh(chain.levels.back().mesh);
  }
  return chain;
}

LevelChain::LevelChain(const core::Scene& scene) : scene_(scene), model_(scene) {
  const std::size_t meshes = scene.mesh_slots(), items = scene.item_slots();
  for (std::size_t i = 0; i < meshes; ++i)
    chains_.push_back(scene.mesh_at(i).valid() ? make_chain(scene.mesh(scene.mesh_at(i))) : Chain());
  chain_of_.assign(items, core::kNone);
  first_level_.assign(items, core::kNoItem);
  for (core::ItemId item{0}; to_index(item) < items; ++item) {
    originals_.push_back(item);
    if (scene.contains_item(item) && int(scene.kind(item)) >= core::kPrimitiveKindCount)
      chain_of_[to_index(item)] = scene.mesh_of(item).index;
  }
  for (core::ItemId item{0}; to_index(item) < items; ++item) {
    if (chain_of_[to_index(item)] == core::kNone || !scene.item_visible(item)) continue;
    first_level_[to_index(item)] = core::ItemId(originals_.size());
    for (const Level& level : chains_[chain_of_[to_index(item)]].levels) {
      scene_.add_mesh_instance(scene.node_of(item), level.mesh, scene.placement(item), scene.item_material(item));
      originals_.push_back(item);
    }
  }
  (void)scene_.commit();  // of items where the model's own are
}

void LevelChain::choose(const lod::ImageError& image, const core::VisibleSet& visible, const core::Snapshot& drawn,
                        core::VisibleSet& chosen) const {
  chosen.clear();
  chosen.generation = drawn.generation();
  visible.for_each_slot([&](core::Slot slot) {
    if (model_.vacant(slot)) return;
    const core::ItemId item = model_.item(slot);
    core::ItemId shown = item;
    if (const std::uint32_t number = chain_of_[to_index(item)]; number != core::kNone) {
      const Chain& chain = chains_[number];
      const float allowed = lod::MeshError(image, model_.world_from_item(slot)).allowed(chain.box);
      const auto fine = std::ranges::upper_bound(chain.levels, allowed, {}, &Level::error) - chain.levels.begin();
      if (fine > 0) shown = core::ItemId(to_index(first_level_[to_index(item)]) + std::uint32_t(fine) - 1);
    }
    chosen.single_slots.push_back(drawn.slot(shown));
  });
  std::ranges::sort(chosen.single_slots);
}

}  // namespace sightline::bench
