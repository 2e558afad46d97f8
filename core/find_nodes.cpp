#include "sightline/core/find_nodes.h"

#include <algorithm>
#include <string_view>

namespace sightline::core {
namespace {

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
}

bool same(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

bool holds(std::string_view text, std::string_view part) {
  return std::search(text.begin(), text.end(), part.begin(), part.end(),
                     [](char x, char y) { return lower(x) == lower(y); }) != text.end() ||
         part.empty();
}

bool fulfils(const Scene& scene, NodeId node, const NodeCondition& condition) {
  if (condition.key.empty() && holds(scene.name(node), condition.text)) return true;
  for (const auto& [key, value] : scene.attributes(node))
    if ((condition.key.empty() || same(key, condition.key)) && holds(value, condition.text)) return true;
  return false;
}

}  // namespace

std::vector<NodeId> find_nodes(const Scene& scene, NodeId top, std::span<const NodeCondition> conditions) {
  std::vector<NodeId> found;
  scene.for_each_node(top, [&](NodeId node, const Affine&, bool, std::uint32_t, MaterialId) {
    if (std::all_of(conditions.begin(), conditions.end(),
                    [&](const NodeCondition& condition) { return fulfils(scene, node, condition); }))
      found.push_back(node);
  });
  return found;
}

}  // namespace sightline::core
