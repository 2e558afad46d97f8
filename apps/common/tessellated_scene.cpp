#include "sightline/apps/common/tessellated_scene.h"

#include <array>
#include <cstring>
#include <map>
#include <tuple>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/importers/internal/tessellated.h"

namespace sightline::apps {
namespace {

using core::ItemId;
using core::Kind;
using core::NodeId;
using core::Scene;

class Converter {
 public:
  /// Segments per full circle, or, where they are 0, a tolerance in metres.
  Converter(const Scene& from, int segments, double metres) : from_(from), metres_(metres) {
    fineness_.fixed_segments = segments;
  }

  Scene run() {
    for (std::size_t i = 0; i < from_.material_slots(); ++i) {
      const core::MaterialId old = from_.material_at(i);
      materials_.push_back(old.valid() ? to_.add_material(from_.material(old)) : core::MaterialId{});
    }
    copy_nodes();
    for (ItemId item{0}; to_index(item) < from_.item_slots(); ++item) copy_item(item);
    return std::move(to_);
  }

 private:
  /// Bits of the parameters, and the tolerance in the primitive's own units; 0 with a number of segments.
  using ShapeKey = std::tuple<Kind, std::array<std::uint32_t, 9>, float>;

  core::MaterialId material(core::MaterialId old) const {
    return old.valid() ? materials_[old.index] : core::MaterialId{};
  }

  /// Appends siblings in their order. The stack holds nodes; each also stands for its later siblings.
  void copy_nodes() {
    copy_node_state(from_.root(), to_.root());
    std::vector<std::pair<NodeId, NodeId>> open{{from_.first_child(from_.root()), to_.root()}};
    while (!open.empty()) {
      const auto [old, parent] = open.back();
      open.pop_back();
      if (!old.valid()) continue;
      const NodeId node = to_.add_node(parent, from_.name(old), from_.transform(old));
      copy_node_state(old, node);
      open.emplace_back(from_.next_sibling(old), parent);
      open.emplace_back(from_.first_child(old), node);
    }
  }

  void copy_node_state(NodeId old, NodeId node) {
    nodes_[old.index] = node;
    to_.set_transform(node, from_.transform(old));
    to_.set_visible(node, from_.visible(old));
    to_.set_layers(node, from_.layers(old));
    to_.set_material(node, material(from_.material(old)));
    for (const auto& [key, value] : from_.attributes(old)) to_.set_attribute(node, key, value);
  }

  void copy_item(ItemId item) {
    if (!from_.contains_item(item)) {  // its id stays unused
      to_.remove_item(to_.add_primitive(to_.root(), core::Line{}));
      return;
    }
    const NodeId node = nodes_.at(from_.node_of(item).index);
    const core::MaterialId own = material(from_.item_material(item));
    const Kind kind = from_.kind(item);
    if (kind == Kind::kLine) {
      to_.add_primitive(node, from_.primitive(item), from_.placement(item), own);
    } else {
      to_.add_mesh_instance(node, int(kind) < core::kPrimitiveKindCount ? shape_of(item) : copied(item),
                            from_.placement(item), own);
    }
    to_.set_visible(item, from_.item_visible(item));
  }

  core::MeshId shape_of(ItemId item) {
    const core::Primitive primitive = from_.primitive(item);
    if (fineness_.fixed_segments == 0) {
      // In float, so that placements that differ by roundings share a mesh.
      const double scale = importers::largest_scale(from_.state(item).world_from_item.linear);
      fineness_.chord_tolerance = scale > 0.0 ? float(metres_ / scale) : 0.0;
    }
    const double tolerance = fineness_.fixed_segments == 0 ? fineness_.chord_tolerance : 0.0;
    ShapeKey key{core::kind_of(primitive), {}, float(tolerance)};
    const auto values = core::parameters(primitive);
    std::memcpy(std::get<1>(key).data(), values.data(), values.size_bytes());
    const auto [place, fresh] = shapes_.try_emplace(key);
    if (fresh) place->second = to_.add_mesh(gpuprims::tessellate(primitive, fineness_)).value();
    return place->second;
  }

  core::MeshId copied(ItemId item) {
    const core::MeshId old = from_.mesh_of(item);
    const auto [place, fresh] = meshes_.try_emplace(old.index);
    if (fresh) place->second = to_.add_mesh(from_.mesh(old)).value();
    return place->second;
  }

  const Scene& from_;
  Scene to_;
  double metres_;
  gpuprims::Tessellation fineness_;
  std::vector<core::MaterialId> materials_;
  std::map<std::uint32_t, NodeId> nodes_;         // by the old node's index
  std::map<std::uint32_t, core::MeshId> meshes_;  // by the old mesh's index
  std::map<ShapeKey, core::MeshId> shapes_;
};

}  // namespace

Scene tessellated(const Scene& scene, int segments) {
  return Converter(scene, segments, 0.0).run();
}

Scene tessellated_within(const Scene& scene, double metres) {
  return Converter(scene, 0, metres).run();
}

}  // namespace sightline::apps
