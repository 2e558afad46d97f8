#include "sightline/apps/common/item_copier.h"

#include <string>

#include "sightline/importers/import.h"

namespace sightline::apps {

core::Expected<core::ItemId> ItemCopier::copy(core::ItemId item) {
  const core::NodeId node = copy(from_.node_of(item));
  const core::MaterialId material = copy(from_.item_material(item));
  core::ItemId copied = core::kNoItem;
  if (int(from_.kind(item)) < core::kPrimitiveKindCount) {
    copied = to_.add_primitive(node, from_.primitive(item), from_.placement(item), material);
  } else {
    const auto mesh = copy(from_.mesh_of(item));
    if (!mesh) return tl::unexpected(mesh.error());
    copied = to_.add_mesh_instance(node, *mesh, from_.placement(item), material);
  }
  to_.set_visible(copied, from_.item_visible(item));
  return copied;
}

core::NodeId ItemCopier::copy(core::NodeId node) {
  std::vector<core::NodeId> above;  // without a copy
  for (; !nodes_.contains(node.index); node = from_.parent(node)) above.push_back(node);
  core::NodeId copied = nodes_.at(node.index);
  for (; !above.empty(); above.pop_back()) {
    const core::NodeId next = above.back();
    copied = to_.add_node(copied, from_.name(next));
    copy_state(next, copied);
    nodes_.emplace(next.index, copied);
  }
  return copied;
}

void ItemCopier::copy_state(core::NodeId from, core::NodeId to) {
  to_.set_transform(to, from_.transform(from));
  to_.set_visible(to, from_.visible(from));
  to_.set_layers(to, from_.layers(from));
  to_.set_material(to, copy(from_.material(from)));
  for (const auto& [key, value] : from_.attributes(from)) to_.set_attribute(to, key, value);
}

core::Expected<core::MeshId> ItemCopier::copy(core::MeshId mesh) {
  if (const auto known = meshes_.find(mesh.index); known != meshes_.end()) return known->second;
  auto copied = to_.add_mesh(from_.mesh(mesh));
  if (copied) meshes_.emplace(mesh.index, *copied);
  return copied;
}

core::MaterialId ItemCopier::copy(core::MaterialId material) {
  if (!materials_kept_ || !material.valid()) return {};
  const auto [at, fresh] = materials_.try_emplace(material.index);
  if (fresh) at->second = to_.add_material(from_.material(material));
  return at->second;
}

std::vector<core::MeshId> ItemCopier::meshes() const {
  std::vector<core::MeshId> all;
  for (const auto& [old, mesh] : meshes_) all.push_back(mesh);
  return all;
}

core::Expected<core::Scene> copy_of_part(const core::Scene& from, std::span<const core::NodeId> tops,
                                         const std::vector<bool>* items, const std::function<bool(double)>& progress) {
  constexpr std::size_t kNodesBetween = 1 << 10;
  core::Scene part;
  part.set_transform(part.root(), from.transform(from.root()));
  ItemCopier copier(from, from.root(), part, part.root(), ItemCopier::Materials::kKept);
  core::Expected<void> done;
  std::size_t nodes = 0;
  const auto copy_node = [&](core::NodeId node) -> core::Expected<void> {
    if (++nodes % kNodesBetween == 0 && progress && !progress(double(nodes) / double(from.node_count())))
      return core::fail(std::string(importers::kCancelled));
    if (!items) copier.copy(node);
    for (core::ItemId item = from.first_item(node); item != core::kNoItem; item = from.next_item(item)) {
      if (items && !(*items)[to_index(item)]) continue;
      if (const auto copied = copier.copy(item); !copied) return tl::unexpected(copied.error());
    }
    return {};
  };
  for (const core::NodeId top : tops)
    from.for_each_node(top, [&](core::NodeId node, const auto&...) {
      if (done) done = copy_node(node);
    });
  if (!done) return tl::unexpected(done.error());
  if (part.item_count() == 0) return core::fail("there are no items to write");
  return part;
}

}  // namespace sightline::apps
