// Scene caches. The checksums of header, table and end are made right first, and those of arrays are not compared, so
// that changes get past them.
#include <cstring>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/gpuprims/internal/joints.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/tests/fuzz/fuzz_target.h"
#include "sightline/tests/importers/slc_seal.h"

namespace {

using namespace sightline;

/// Uses all of a scene, as applications do, and edits it.
void use(core::Scene& scene) {
  fuzz::require(scene.commit().has_value(), "a scene that can be committed");
  core::Snapshot snapshot(scene);
  fuzz::require(snapshot.size() == scene.item_count(), "a snapshot with all items");
  const gpuprims::Joints joints(snapshot);
  std::size_t nodes = 0, items = 0;
  std::vector<core::NodeId> all;
  scene.for_each_node(scene.root(), [&](core::NodeId node, auto&&...) {
    ++nodes;
    all.push_back(node);
    (void)scene.path(node).size();
    (void)scene.attributes(node).size();
    for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item)) ++items;
  });
  fuzz::require(nodes == scene.node_count() && items == scene.item_count(), "as many nodes and items as counted");
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot) {
    fuzz::require(snapshot.slot(snapshot.item(slot)) == slot, "slots of items and items of slots");
    if (int(snapshot.kind(slot)) < core::kPrimitiveKindCount)
      (void)snapshot.primitive(slot);
    else
      (void)snapshot.mesh(slot).indices.size();
  }
  for (std::size_t i = 1; i < all.size(); i += 3)
    if (scene.contains(all[i])) scene.set_transform(all[i], core::translation({1.0, 2.0, 3.0}));
  if (all.size() > 2 && scene.contains(all[2])) scene.remove_node(all[2]);
  if (const auto delta = scene.commit()) snapshot.apply(*delta);
}

/// Uses all pages.
void use(const core::PagedScene& scene) {
  for (std::uint32_t number = 0; number < scene.pages.size(); ++number) {
    const auto page = scene.load(number);
    if (!page) continue;
    const core::Snapshot& snapshot = (*page)->snapshot;
    fuzz::require(snapshot.size() == scene.pages[number].slot_count, "as many slots as the page says");
    const auto joints = gpuprims::Joints::of_slots((*page)->internal_end_caps);
    for (core::Slot slot = 0; slot < snapshot.size(); ++slot) {
      (void)joints.covered(snapshot, slot);
      (void)snapshot.opaque(slot);
      (void)snapshot.world_from_item(slot);
      if (int(snapshot.kind(slot)) < core::kPrimitiveKindCount)
        (void)snapshot.primitive(slot);
      else
        (void)snapshot.mesh(slot).indices.size();
    }
    (*page)->drop_records();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = fuzz::bytes_of(data, size);
  std::vector<std::byte> bytes(input.begin(), input.end());
  tests::make_current(bytes);
  tests::reseal(bytes);
  const auto file = importers::SlcFile::of_bytes(bytes);
  if (!file) return 0;
  if (auto loaded = importers::load(*file, false)) {
    core::Scene scene;
    scene.append(scene.root(), std::move(loaded->scene));
    use(scene);
  }
  if (const auto paged = importers::open_paged_scene(*file, "fuzz.slc", false)) use(*paged);
  core::Scene scene;
  const core::NodeId parent = scene.add_node(scene.root(), "kept", core::translation({1e6, 0.0, 0.0}));
  scene.add_primitive(parent, core::Sphere{1.0f});
  const auto report = importers::read_slc(bytes, "fuzz.slc", scene, parent, {});
  if (report)
    use(scene);
  else
    fuzz::require(scene.node_count() == 2 && scene.item_slots() == 1 &&
                      report.error().message.find("fuzz.slc") != std::string::npos,
                  "the scene as it was, and an error that names the file");
  return 0;
}
