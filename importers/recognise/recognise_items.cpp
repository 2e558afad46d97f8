#include <cmath>
#include <map>
#include <numbers>

#include "sightline/importers/recognise/internal/recognise.h"

namespace sightline::importers {
namespace {

std::uint64_t bytes_of(const core::Mesh& mesh) {
  return mesh.positions.size() * sizeof(core::vec3) + mesh.normals.size() * sizeof(core::vec3) +
         mesh.indices.size() * sizeof(std::uint32_t);
}

/// An upper bound of what the map multiplies any length by.
double tight_largest_stretch(const core::Affine& map) {
  double squares = 0.0;
  for (int column = 0; column < 3; ++column) squares += glm::dot(map.linear[column], map.linear[column]);
  const core::dmat3 product = glm::transpose(map.linear) * map.linear;
  // A similarity stretches all lengths alike; the norm of any other is a bound.
  const double mean = squares / 3.0;
  double off = 0.0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) off = std::max(off, std::fabs(product[c][r] - (c == r ? mean : 0.0)));
  return std::sqrt(off <= 1e-5 * mean ? mean : squares);
}

/// The longest that a map makes a deviation. With u across z and w along it, |map v|^2 is at most xx u^2 + 2 xz u w +
/// zz w^2, which turns around once between u and w.
double stretched(const core::dmat3& map, const RecognisedPrimitive& p) {
  const core::dmat3 products = glm::transpose(map) * map;
  const double x = products[0][0], y = products[1][1], zz = products[2][2];
  const double xx = 0.5 * (x + y + std::hypot(x - y, 2.0 * products[0][1]));
  const double xz = std::hypot(products[0][2], products[1][2]);
  const double steepest = p.along < p.deviation ? std::asin(p.along / p.deviation) : 0.5 * std::numbers::pi;
  const double angle = std::min(0.5 * std::atan2(2.0 * xz, xx - zz), steepest);
  const double u = std::cos(angle), w = std::sin(angle);
  return p.deviation * std::sqrt(xx * u * u + 2.0 * xz * u * w + zz * w * w);
}

class ItemRecogniser {
 public:
  ItemRecogniser(core::Scene& scene, core::ItemId first, double tolerance, RecognitionReport& report)
      : scene_(scene), tolerance_(tolerance), report_(report) {
    for (core::ItemId item = first; to_index(item) < scene.item_slots(); ++item)
      if (scene.contains_item(item) && int(scene.kind(item)) >= core::kPrimitiveKindCount) {
        const std::uint32_t mesh = scene.mesh_of(item).index;
        const auto [at, fresh] = place_.try_emplace(mesh, meshes_.size());
        if (fresh) meshes_.push_back({scene.mesh_of(item), {}});
        meshes_[at->second].items.push_back(item);
      }
  }

  bool run(const std::function<bool(double)>& progress) {
    double done = 0.0, all = 1.0;
    for (const MeshUse& use : meshes_) all += double(scene_.mesh(use.mesh).indices.size());
    for (const MeshUse& use : meshes_) {
      if (progress && !progress(done / all)) return false;
      done += double(scene_.mesh(use.mesh).indices.size());
      replace(use);
    }
    return true;
  }

 private:
  struct MeshUse {
    core::MeshId mesh;
    std::vector<core::ItemId> items;
  };

  void replace(const MeshUse& use) {
    const core::Mesh& mesh = scene_.mesh(use.mesh);
    const std::uint64_t triangles = mesh.indices.size() / 3, bytes = bytes_of(mesh);
    ++report_.meshes;
    report_.triangles_before += triangles;
    report_.bytes_before += bytes;
    double stretch = 0.0;
    std::vector<core::Affine> worlds;
    scene_.for_each_state(use.items, [&](core::ItemId, const core::Scene::ItemState& state) {
      worlds.push_back(state.world_from_item);
      stretch = std::max(stretch, tight_largest_stretch(state.world_from_item));
    });
    const RecognisedMesh found = recognise(mesh, tolerance_ > 0.0 && stretch > 0.0 ? tolerance_ / stretch : 0.0);
    for (std::size_t i = 0; i < kRefusalCount; ++i) report_.refused[i] += found.refused[i];
    if (found.primitives.empty()) return keep(triangles, bytes);
    core::MeshId rest;
    if (!found.rest.indices.empty()) {
      auto added = scene_.add_mesh(found.rest);
      if (!added) return keep(triangles, bytes);
      rest = *added;
    }
    std::size_t replaced = 0;
    for (std::size_t i = 0; i < use.items.size(); ++i) replaced += replace_item(use.items[i], worlds[i], found, rest);
    if (replaced < use.items.size()) keep(triangles, bytes);
    if (replaced == 0) {
      if (rest.valid()) scene_.remove_mesh(rest);
      return;
    }
    report_.triangles_after += found.rest.indices.size() / 3;
    report_.bytes_after += bytes_of(found.rest);
    for (const RecognisedPrimitive& p : found.primitives)
      report_.bytes_after += core::parameters(p.primitive).size_bytes();
    if (replaced == use.items.size()) scene_.remove_mesh(use.mesh);
  }

  void keep(std::uint64_t triangles, std::uint64_t bytes) {
    report_.triangles_after += triangles;
    report_.bytes_after += bytes;
  }

  /// All or nothing: an item that a commit would refuse stays a mesh.
  bool replace_item(core::ItemId item, const core::Affine& world, const RecognisedMesh& found, core::MeshId rest) {
    const core::NodeId node = scene_.node_of(item);
    const core::Affine placement = scene_.placement(item);
    const core::MaterialId material = scene_.item_material(item);
    const bool visible = scene_.item_visible(item);
    std::vector<core::ItemId> added;
    bool fit = true;
    for (const RecognisedPrimitive& p : found.primitives) {
      added.push_back(scene_.add_primitive(node, p.primitive, placement * p.mesh_from_primitive, material));
      fit = fit && scene_.can_commit(added.back(), world * p.mesh_from_primitive);
    }
    if (rest.valid()) added.push_back(scene_.add_mesh_instance(node, rest, placement, material));
    if (!fit) {
      for (const core::ItemId a : added) scene_.remove_item(a);
      return false;
    }
    if (!visible)
      for (const core::ItemId a : added) scene_.set_visible(a, false);
    for (const RecognisedPrimitive& p : found.primitives) {
      ++report_.items[std::size_t(core::kind_of(p.primitive))];
      report_.largest_deviation =
          std::max(report_.largest_deviation, stretched(world.linear * p.mesh_from_primitive.linear, p));
    }
    scene_.remove_item(item);
    return true;
  }

  core::Scene& scene_;
  double tolerance_;
  RecognitionReport& report_;
  std::map<std::uint32_t, std::size_t> place_;  // of a mesh's index in meshes_
  std::vector<MeshUse> meshes_;
};

}  // namespace

bool recognise_items(core::Scene& scene, core::ItemId first, double tolerance,
                     const std::function<bool(double)>& progress, RecognitionReport& report) {
  return ItemRecogniser(scene, first, tolerance, report).run(progress);
}

}  // namespace sightline::importers
