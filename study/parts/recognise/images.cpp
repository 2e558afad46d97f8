#include "sightline/study/parts/recognise/images.h"

#include <unordered_map>
#include <utility>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/common/tessellated_scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/engine/drawing/internal/drawing.h"

namespace sightline::bench {
namespace {

constexpr int kWidth = 640, kHeight = 360;

/// A scene in which other items stand for those of the original one.
struct Placeholder {
  core::Scene scene;
  std::unordered_map<core::ItemId, core::ItemId> item_of;  // what an added item stands for
};

Placeholder placeholder(const core::Scene& scene, std::span<const Original> originals,
                        std::span<const core::Mesh> meshes, std::span<const importers::RecognisedMesh> found) {
  constexpr int kCoarse = 8;  // of triangles that go at once: the copy is for all else
  Placeholder made{apps::tessellated(scene, kCoarse), {}};
  core::Scene& to = made.scene;
  const core::Affine& root = to.transform(to.root());
  const core::dmat3 back = glm::inverse(root.linear);
  for (std::size_t i = 0; i < originals.size(); ++i) {
    const core::ItemId old = originals[i].item;
    const core::Scene::ItemState state = to.state(old);
    const core::Affine place{back, back * (originals[i].origin - root.origin)};
    const core::MaterialId material =
        state.material == core::kNone ? core::MaterialId{} : to.material_at(state.material);
    std::vector<core::ItemId> added;
    const bool primitives = !found.empty() && !found[i].primitives.empty();
    if (primitives)
      for (const importers::RecognisedPrimitive& one : found[i].primitives)
        added.push_back(to.add_primitive(to.root(), one.primitive, place * one.mesh_from_primitive, material));
    const core::Mesh& mesh = primitives ? found[i].rest : meshes[i];
    if (!mesh.indices.empty())
      if (const auto id = to.add_mesh(mesh)) added.push_back(to.add_mesh_instance(to.root(), *id, place, material));
    for (const core::ItemId item : added) {
      to.set_visible(item, state.layers != 0);
      made.item_of[item] = old;
    }
    to.remove_item(old);
  }
  return made;
}

}  // namespace

core::Expected<Images> Images::create(core::Scene& scene, std::span<const Original> originals, int frames,
                                      gl::ContextPlatform platform) {
  Images made(scene, originals, platform);
  const core::Snapshot snapshot(scene);
  auto views = tour_views(snapshot, frames, double(kWidth) / kHeight);
  if (!views) return tl::unexpected(views.error());
  made.views_ = std::move(*views);
  auto reference = made.draw(scene);
  if (!reference) return tl::unexpected(reference.error());
  made.reference_ = std::move(*reference);
  return made;
}

core::Expected<std::vector<apps::DrawnImage>> Images::draw(core::Scene& scene) const {
  auto engine = engine::Engine::create(scene, drawing_config(kWidth, kHeight, platform_));
  if (!engine) return tl::unexpected(engine.error());
  std::vector<apps::DrawnImage> images;
  for (const core::View& view : views_) {
    if (auto report = engine->frame(view); !report) return tl::unexpected(report.error());
    auto image = apps::read_image(*engine, view);
    if (!image) return tl::unexpected(image.error());
    images.push_back(std::move(*image));
  }
  return images;
}

core::Expected<MeanErrors> Images::errors(std::span<const core::Mesh> meshes,
                                          std::span<const importers::RecognisedMesh> found) const {
  Placeholder made = placeholder(scene_, originals_, meshes, found);
  if (auto done = made.scene.commit(); !done) return tl::unexpected(done.error());
  auto images = draw(made.scene);
  if (!images) return tl::unexpected(images.error());
  MeanErrors means;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    apps::DrawnImage& image = (*images)[i];
    for (std::uint32_t& id : image.ids.ids)  // the item + 1
      if (const auto at = id > 0 ? made.item_of.find(core::ItemId{id - 1}) : made.item_of.end();
          at != made.item_of.end())
        id = to_index(at->second) + 1;
    const auto errors = apps::image_errors(reference_[i], image);
    if (!errors) return tl::unexpected(errors.error());
    means.flip += errors->flip_mean / double(views_.size());
    means.wrong_ids += errors->wrong_share / double(views_.size());
  }
  return means;
}

}  // namespace sightline::bench
