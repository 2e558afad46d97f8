#include "sightline/apps/common/tessellated_scene.h"

#include <array>
#include <cstring>
#include <map>
#include <tuple>

#include "sightline/apps/common/item_copier.h"
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
    copier_.copy_state(from_.root(), to_.root());
    from_.for_each_node(from_.root(), [&](NodeId node, const auto&...) { copier_.copy(node); });
    for (ItemId item{0}; to_index(item) < from_.item_slots(); ++item) copy_item(item);
    return std::move(to_);
  }

 private:
  /// Bits of the parameters, and the tolerance in the primitive's own units; 0 with a number of segments.
  using ShapeKey = std::tuple<Kind, std::array<std::uint32_t, 9>, float>;

  void copy_item(ItemId item) {
    if (!from_.contains_item(item)) {  // its id stays unused
      to_.remove_item(to_.add_primitive(to_.root(), core::Line{}));
      return;
    }
    const NodeId node = copier_.copy(from_.node_of(item));
    const core::MaterialId own = copier_.copy(from_.item_material(item));
    const Kind kind = from_.kind(item);
    if (kind == Kind::kLine) {
      to_.add_primitive(node, from_.primitive(item), from_.placement(item), own);
    } else {
      const bool analytic = int(kind) < core::kPrimitiveKindCount;
      const core::MeshId mesh = analytic ? shape_of(item) : copier_.copy(from_.mesh_of(item)).value();
      to_.add_mesh_instance(node, mesh, from_.placement(item), own);
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

  const Scene& from_;
  Scene to_;
  ItemCopier copier_{from_, from_.root(), to_, to_.root(), ItemCopier::Materials::kKept};
  double metres_;
  gpuprims::Tessellation fineness_;
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
