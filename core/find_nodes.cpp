#include "sightline/core/find_nodes.h"

#include <algorithm>
#include <string_view>

#include "sightline/core/internal/ascii_case.h"

namespace sightline::core {
namespace {

bool holds(std::string_view text, std::string_view part) {
  return std::search(text.begin(), text.end(), part.begin(), part.end(),
                     [](char x, char y) { return lower_case(x) == lower_case(y); }) != text.end() ||
         part.empty();
}

bool fulfils(const Scene& scene, NodeId node, const NodeCondition& condition) {
  if (condition.key.empty() && holds(scene.name(node), condition.text)) return true;
  for (const auto& [key, value] : scene.attributes(node))
    if ((condition.key.empty() || same_but_for_case(key, condition.key)) && holds(value, condition.text)) return true;
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
