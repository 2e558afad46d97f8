// Are two subtrees the same, bit for bit?
#pragma once

#include <bit>
#include <string>

#include "sightline/core/scene.h"

namespace sightline::tests {

inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

inline bool same_bits(const core::Affine& a, const core::Affine& b) {
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (!same_bits(a.linear[c][r], b.linear[c][r])) return false;
  return same_bits(a.origin.x, b.origin.x) && same_bits(a.origin.y, b.origin.y) && same_bits(a.origin.z, b.origin.z);
}

inline bool same_bits(const std::vector<core::vec3>& a, const std::vector<core::vec3>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (std::bit_cast<std::uint32_t>(a[i][k]) != std::bit_cast<std::uint32_t>(b[i][k])) return false;
  return true;
}

inline bool same_mesh(const core::Mesh& a, const core::Mesh& b) {
  return same_bits(a.positions, b.positions) && same_bits(a.normals, b.normals) && a.indices == b.indices &&
         a.contour_sizes == b.contour_sizes && a.polygon_contours == b.polygon_contours;
}

inline bool same_material(const core::Scene& a, core::MaterialId m, const core::Scene& b, core::MaterialId n) {
  if (m.valid() != n.valid()) return false;
  if (!m.valid()) return true;
  const core::Material &x = a.material(m), &y = b.material(n);
  return x.name == y.name && x.colour == y.colour && x.alpha == y.alpha && x.code == y.code;
}

inline bool same_item(const core::Scene& a, core::ItemId i, const core::Scene& b, core::ItemId j) {
  if (a.kind(i) != b.kind(j) || !same_bits(a.placement(i), b.placement(j))) return false;
  if (!same_material(a, a.item_material(i), b, b.item_material(j))) return false;
  if (int(a.kind(i)) >= core::kPrimitiveKindCount) return same_mesh(a.mesh(a.mesh_of(i)), b.mesh(b.mesh_of(j)));
  const core::Primitive p = a.primitive(i), q = b.primitive(j);
  const auto u = core::parameters(p), v = core::parameters(q);
  for (std::size_t k = 0; k < u.size(); ++k)
    if (std::bit_cast<std::uint32_t>(u[k]) != std::bit_cast<std::uint32_t>(v[k])) return false;
  return true;
}

/// Empty when the subtrees agree in structure, names, attributes, layers, materials, items and the order of item ids;
/// else the path of the first node that differs. Names and attributes of the tops are not compared.
inline std::string scene_difference(const core::Scene& a, core::NodeId top_a, const core::Scene& b,
                                    core::NodeId top_b) {
  std::vector<core::NodeId> in_a, in_b;
  const auto list = [](const core::Scene& s, core::NodeId top, std::vector<core::NodeId>& out) {
    s.for_each_node(
        top, [&](core::NodeId n, const core::Affine&, bool, std::uint32_t, core::MaterialId) { out.push_back(n); });
  };
  list(a, top_a, in_a), list(b, top_b, in_b);
  if (in_a.size() != in_b.size())
    return "node counts " + std::to_string(in_a.size()) + ", " + std::to_string(in_b.size());
  std::vector<std::pair<core::ItemId, core::ItemId>> pairs;
  for (std::size_t n = 0; n < in_a.size(); ++n) {
    const core::NodeId x = in_a[n], y = in_b[n];
    const std::string where = a.path(x) + " | " + b.path(y);
    if (n > 0 && (a.name(x) != b.name(y) || a.attributes(x) != b.attributes(y))) return "name or attributes: " + where;
    if (n > 0 && a.path(a.parent(x)) != b.path(b.parent(y)) && a.name(top_a) == b.name(top_b))
      return "parent: " + where;
    if (a.layers(x) != b.layers(y)) return "layers: " + where;
    if (!same_bits(a.transform(x), b.transform(y))) return "transform: " + where;
    if (!same_material(a, a.material(x), b, b.material(y))) return "material: " + where;
    core::ItemId i = a.first_item(x), j = b.first_item(y);
    for (; i != core::kNoItem && j != core::kNoItem; i = a.next_item(i), j = b.next_item(j)) {
      if (!same_item(a, i, b, j)) return "item " + std::to_string(to_index(i)) + ": " + where;
      pairs.emplace_back(i, j);
    }
    if (i != j) return "item count: " + where;
  }
  std::sort(pairs.begin(), pairs.end());
  for (std::size_t k = 1; k < pairs.size(); ++k)
    if (pairs[k].second <= pairs[k - 1].second) return "item order at " + std::to_string(to_index(pairs[k].first));
  return {};
}

}  // namespace sightline::tests
