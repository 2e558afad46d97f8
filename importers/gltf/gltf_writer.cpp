#include "sightline/importers/gltf/gltf_writer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/gltf/internal/gltf_collections_writer.h"
#include "sightline/importers/gltf/internal/gltf_output.h"
#include "sightline/importers/gltf/internal/gltf_placement.h"
#include "sightline/importers/gltf/internal/gltf_shapes.h"
#include "sightline/importers/import.h"
#include "sightline/importers/internal/extension.h"

namespace sightline::importers {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::kNoItem;
using core::kNone;
using core::NodeId;

/// Members of an object, joined.
class Members {
 public:
  Members& add(std::string_view member) {
    if (!text_.empty() && !member.empty()) text_ += ',';
    text_ += member;
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

class TreeWriter {
 public:
  TreeWriter(const core::Scene& scene, const GltfWriteOptions& options, GltfOutput& output, GltfWriteReport& report)
      : scene_(scene),
        options_(options),
        output_(output),
        report_(report),
        shapes_(scene, options.tolerance, output, report) {}

  core::Expected<void> run(NodeId top) {
    std::uint64_t items = 0;
    scene_.for_each_node(top, [&](NodeId node, auto&&...) {
      for (core::ItemId item = scene_.first_item(node); item != kNoItem; item = scene_.next_item(item)) ++items;
    });
    step_ = 1.0 / double(std::max<std::uint64_t>(1, items));
    scene_.for_each_node(
        top, [&](NodeId node, const Affine& world, bool visible, std::uint32_t layers, core::MaterialId material) {
          if (!cancelled_) write_node(node, node == top, world, visible, layers, material);
        });
    if (cancelled_) return core::fail(std::string(kCancelled));
    prune();
    return {};
  }

 private:
  struct Item {
    core::ItemId id;
    std::uint32_t material, shape;
    Affine node_from_shape;
  };

  void write_node(NodeId node, bool is_top, const Affine& world, bool visible, std::uint32_t layers,
                  core::MaterialId material) {
    const std::uint64_t left_out_before = report_.left_out;
    const std::vector<Item> items = items_of(node, world, visible, layers, material);
    if (is_top) file_from_top_ = kGltfFromWorld * world;
    if (is_top && items.empty()) return;
    const NodeId above = is_top ? NodeId{} : scene_.parent(node);
    const auto known = above.valid() ? place_of(above) : kNone;
    Affine placement = is_top ? file_from_top_ : scene_.transform(node);
    if (!is_top && known == kNone) placement = file_from_top_ * placement;

    Members members;
    if (!scene_.name(node).empty()) members.add("\"name\":" + json_string(scene_.name(node)));
    // One item of a leaf needs no node of its own.
    const bool alone = items.size() == 1 && (is_top || !scene_.first_child(node).valid()) &&
                       is_decomposable((placement * items[0].node_from_shape).linear);
    if (alone) placement = placement * items[0].node_from_shape;
    members.add(gltf_transform(placement));
    if (alone) members.add(fmt::format("\"mesh\":{}", shapes_.mesh(items[0].shape, items[0].material)));
    members.add(extras(node));
    const std::uint32_t index = output_.node(known, members.text());
    if (!is_top) remember(node, index);
    note(index, !items.empty(), report_.left_out > left_out_before);
    if (!alone) write_items(index, items);
  }

  std::vector<Item> items_of(NodeId node, const Affine& world, bool visible, std::uint32_t layers,
                             core::MaterialId material) {
    std::vector<Item> items;
    for (core::ItemId id = scene_.first_item(node); id != kNoItem && !cancelled_; id = scene_.next_item(id)) {
      if (options_.progress && !options_.progress(step_ * double(done_++))) cancelled_ = true;
      const core::Scene::ItemState state = scene_.state(id, world, visible, layers, material);
      Item item{id, state.material, kNone, scene_.placement(id)};
      if ((state.layers & core::kDefaultLayerMask) != 0) {
        if (is_decomposable(item.node_from_shape.linear)) {
          const GltfShapes::Scaled scaled = shapes_.shape(id, state.world_from_item);
          item.shape = scaled.shape;
          for (int c = 0; c < 3; ++c) item.node_from_shape.linear[c] *= scaled.scale[c];
        } else {
          item.shape = shapes_.baked(id, item.node_from_shape.linear, state.world_from_item);
          item.node_from_shape.linear = dmat3(1.0);
        }
      }
      if (item.shape == kNone) {
        ++report_.left_out;
        continue;
      }
      ++report_.items[std::size_t(scene_.kind(id))];
      items.push_back(item);
    }
    return items;
  }

  void write_items(std::uint32_t node, const std::vector<Item>& items) {
    // Groups by mesh, in the order of their first items.
    std::map<std::uint32_t, std::vector<std::size_t>> same;
    std::vector<std::uint32_t> meshes(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
      meshes[i] = shapes_.mesh(items[i].shape, items[i].material);
      if (items.size() >= kGltfInstancesFrom) same[meshes[i]].push_back(i);
    }
    for (std::size_t i = 0; i < items.size(); ++i) {
      const auto group = same.find(meshes[i]);
      if (group != same.end() && group->second.size() >= kGltfInstancesFrom) {
        if (group->second.front() == i) write_instances(node, meshes[i], items, group->second);
        continue;
      }
      Members members;
      members.add(gltf_transform(items[i].node_from_shape)).add(fmt::format("\"mesh\":{}", meshes[i]));
      note(output_.node(node, members.text()), true, false);
    }
  }

  void write_instances(std::uint32_t node, std::uint32_t mesh, const std::vector<Item>& items,
                       const std::vector<std::size_t>& group) {
    // Relative to their middle, so that float suffices far from the origin.
    dvec3 low(items[group[0]].node_from_shape.origin), high(low);
    for (const std::size_t i : group) {
      low = glm::min(low, items[i].node_from_shape.origin);
      high = glm::max(high, items[i].node_from_shape.origin);
    }
    const dvec3 middle = 0.5 * (low + high);
    std::vector<Affine> placements;
    for (const std::size_t i : group) {
      placements.push_back(items[i].node_from_shape);
      placements.back().origin -= middle;
    }
    Members members;
    members.add(gltf_transform(core::translation(middle))).add(fmt::format("\"mesh\":{}", mesh));
    members.add(fmt::format("\"extensions\":{{\"EXT_mesh_gpu_instancing\":{{\"attributes\":{{{}}}}}}}",
                            instance_attributes(output_, placements)));
    output_.use_extension("EXT_mesh_gpu_instancing", true);
    note(output_.node(node, members.text()), true, false);
  }

  std::string extras(NodeId node) const {
    const auto& attributes = scene_.attributes(node);
    if (attributes.empty()) return {};
    Members members;
    for (const auto& [key, value] : attributes) members.add(json_string(key) + ":" + json_string(value));
    return "\"extras\":{" + members.text() + "}";
  }

  /// Index in the file of a node of the scene; kNone: it has none there.
  std::uint32_t place_of(NodeId node) const { return node.index < place_.size() ? place_[node.index] : kNone; }
  void remember(NodeId node, std::uint32_t index) {
    if (place_.size() <= node.index) place_.resize(std::size_t(node.index) + 1, kNone);
    place_[node.index] = index;
  }

  void note(std::uint32_t node, bool shows, bool lost) {
    shows_.resize(std::size_t(node) + 1);
    lost_.resize(std::size_t(node) + 1);
    shows_[node] = shows;
    lost_[node] = lost;
  }

  /// Leaves out nodes that show nothing because what they had was left out.
  void prune() {
    for (std::uint32_t i = output_.node_count(); i-- > 0;)
      if (const std::uint32_t parent = output_.parent(i); parent != kNone) {
        if (shows_[i]) shows_[parent] = true;
        if (lost_[i]) lost_[parent] = true;
      }
    // A node without items, in a group of which others were left out, stays.
    std::vector<bool> keep(shows_.size());
    for (std::uint32_t i = output_.node_count(); i-- > 0;) {
      keep[i] = keep[i] || shows_[i] || !lost_[i];
      if (const std::uint32_t parent = output_.parent(i); keep[i] && parent != kNone) keep[parent] = true;
    }
    output_.prune(keep);
  }

  const core::Scene& scene_;
  const GltfWriteOptions& options_;
  GltfOutput& output_;
  GltfWriteReport& report_;
  GltfShapes shapes_;
  Affine file_from_top_;
  std::vector<std::uint32_t> place_;
  std::vector<bool> shows_, lost_;
  std::uint64_t done_ = 0;
  double step_ = 1.0;
  bool cancelled_ = false;
};

}  // namespace

core::Expected<GltfWriteReport> write_gltf(const core::Scene& scene, NodeId node, const std::filesystem::path& path,
                                           const GltfWriteOptions& options) {
  if (!(options.tolerance > 0.0) || !std::isfinite(options.tolerance))
    return core::fail(fmt::format("expected a tolerance above 0 m, found {}", options.tolerance));
  const std::string extension = lower_case_extension(path);
  if (extension != ".glb" && extension != ".gltf")
    return core::fail(fmt::format("{}: expected a name ending in .glb or .gltf", path.string()));
  GltfOutput output;
  GltfWriteReport report;
  const auto done = options.collections ? write_collections(scene, node, options, output, report)
                                        : TreeWriter(scene, options, output, report).run(node);
  if (!done && done.error().message == kCancelled) return tl::unexpected(done.error());
  if (!done) return core::fail(fmt::format("{}: {}", path.string(), done.error().message));
  const auto bytes = output.write(path);
  if (!bytes) return tl::unexpected(bytes.error());
  report.bytes = *bytes;
  return report;
}

}  // namespace sightline::importers
