// This tells what tools say of an item, in words.
#pragma once

#include <string>
#include <vector>

#include "sightline/apps/common/numbers.h"
#include "sightline/core/scene.h"

namespace sightline::apps {

struct Fact {
  std::string name, value;

  friend bool operator==(const Fact&, const Fact&) = default;
};

/// Kind, dimensions in the world, box and material, which may be inherited.
std::vector<Fact> item_facts(const core::Scene& scene, core::ItemId item, const LengthFormat& lengths = {});
/// Attributes of the node itself.
std::vector<Fact> attribute_facts(const core::Scene& scene, core::NodeId node);

struct FactChange {
  std::string name, before, after;  ///< empty: it had, or has, none

  friend bool operator==(const FactChange&, const FactChange&) = default;
};
/// Facts whose words differ, in the order of `after`, then those that only `before` has. Names of one list are unique.
std::vector<FactChange> differing(const std::vector<Fact>& before, const std::vector<Fact>& after);

}  // namespace sightline::apps
