#include "sightline/analysis/compare/compare.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <unordered_map>

#include "sightline/analysis/compare/internal/matching.h"
#include "sightline/core/internal/hash.h"

namespace sightline::compare {
namespace {

std::uint64_t joined(std::uint64_t hash, std::uint64_t with) {
  return core::mixed(core::mixed(hash) + with);
}

/// Hashes of the nodes of a revision, by node index.
struct NodeNames {
  std::vector<std::uint64_t> path, key;
  std::unordered_map<std::uint64_t, std::uint32_t> equal;  // how many siblings had this parent and name so far

  void add(const core::Scene& scene, core::NodeId node, core::NodeId top) {
    if (path.size() <= node.index) path.resize(node.index + 1, 0), key.resize(node.index + 1, 0);
    if (node == top) return;
    const std::uint64_t name = std::hash<std::string_view>()(scene.name(node));
    const core::NodeId parent = scene.parent(node);
    path[node.index] = joined(path[parent.index], name);
    const std::uint64_t named = joined(key[parent.index], name);
    key[node.index] = joined(named, equal[named]++);
  }
};

Side gather(const Revision& revision, Progress& progress, double share) {
  progress.begin(share);
  const core::Scene& scene = *revision.scene;
  Side side{Shapes(scene), {}};
  NodeNames names;
  scene.for_each_node(revision.top, [&](core::NodeId node, const core::Affine& world, bool visible,
                                        std::uint32_t layers, core::MaterialId material) {
    if (progress.stopped()) return;
    names.add(scene, node, revision.top);
    const std::uint64_t above = node == revision.top ? 0 : names.path[scene.parent(node).index];
    std::uint64_t order = 0;
    for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item)) {
      const core::Scene::ItemState state = scene.state(item, world, visible, layers, material);
      side.entries.push_back({side.shapes.geometry(item, state.world_from_item), names.path[node.index], above,
                              joined(~names.key[node.index], order++), node, item, state.material, kFree});
      progress.go_on(side.entries.size(), scene.item_count());
    }
  });
  return side;
}

core::Material material_of(const core::Scene& scene, std::uint32_t index) {
  const core::MaterialId material = scene.material_at(index);
  return material.valid() ? scene.material(material) : core::Material{};
}

/// Tells whether materials of two scenes look alike, and remembers it.
class MaterialPairs {
 public:
  MaterialPairs(const core::Scene& before, const core::Scene& after) : before_(before), after_(after) {}

  bool alike(std::uint32_t a, std::uint32_t b) {
    const auto [place, fresh] = known_.try_emplace(std::uint64_t(a) << 32 | b, false);
    if (fresh) {
      const core::Material x = material_of(before_, a), y = material_of(after_, b);
      place->second = x.name == y.name && x.colour == y.colour && x.alpha == y.alpha;
    }
    return place->second;
  }

 private:
  const core::Scene &before_, &after_;
  std::unordered_map<std::uint64_t, bool> known_;
};

bool attributes_alike(const core::Scene::Attributes& a, const core::Scene::Attributes& b) {
  if (a == b) return true;
  if (a.size() != b.size()) return false;
  core::Scene::Attributes x = a, y = b;
  std::sort(x.begin(), x.end());
  std::sort(y.begin(), y.end());
  return x == y;
}

bool items_have_attributes(const Revision& revision) {
  bool any = false;
  revision.scene->for_each_node(revision.top, [&](core::NodeId node, const auto&...) {
    any = any || (revision.scene->first_item(node) != core::kNoItem && !revision.scene->attributes(node).empty());
  });
  return any;
}

State state_of(std::uint8_t differences) {
  if (differences & (kShape | kMaterial | kAttributes)) return State::kChanged;
  return differences & kPlace ? State::kMoved : State::kUnchanged;
}

class Comparer {
 public:
  Comparer(const Revision& before, const Revision& after, double tolerance, Progress& progress)
      : before_(gather(before, progress, 0.2)),
        after_(gather(after, progress, 0.2)),
        materials_(*before.scene, *after.scene),
        tolerance_(tolerance),
        progress_(progress),
        with_attributes_(items_have_attributes(before) == items_have_attributes(after)) {}

  Comparison compare() {
    match(before_, after_, tolerance_, progress_, 0.3);
    progress_.begin(0.2);
    Comparison out;
    out.with_attributes = with_attributes_;
    out.items.reserve(std::max(before_.entries.size(), after_.entries.size()));
    for (std::uint32_t j = 0; j < after_.entries.size() && progress_.go_on(j, after_.entries.size()); ++j) {
      const Entry& entry = after_.entries[j];
      out.items.push_back(entry.partner == kFree ? Change{core::kNoItem, entry.item, State::kAdded}
                                                 : change(entry.partner, j));
    }
    for (const Entry& entry : before_.entries)
      if (entry.partner == kFree) out.items.push_back({entry.item, core::kNoItem, State::kRemoved});
    for (const Change& c : out.items) {
      ++out.counts[std::size_t(c.state)];
      out.renamed += c.differences & kPath ? 1 : 0;
    }
    return out;
  }

 private:
  Change change(std::uint32_t i, std::uint32_t j) {
    const Entry &a = before_.entries[i], &b = after_.entries[j];
    Change out{a.item, b.item};
    const Likeness l = likeness(before_.shown(i), after_.shown(j), tolerance_);
    const auto differs = [&](bool same, Difference bit) {
      if (!same) out.differences = std::uint8_t(out.differences | bit);
    };
    differs(l.same_shape, kShape);
    differs(l.same_place, kPlace);
    differs(materials_.alike(a.material, b.material), kMaterial);
    differs(!with_attributes_ ||
                attributes_alike(before_.shapes.scene().attributes(a.node), after_.shapes.scene().attributes(b.node)),
            kAttributes);
    differs(a.path == b.path, kPath);
    out.state = state_of(out.differences);
    if (!l.same_place) {
      out.offset = b.geometry.centre - a.geometry.centre;
      if (l.same_shape) out.turn = turn_between(a.geometry.world_from_item, b.geometry.world_from_item);
    }
    return out;
  }

  Side before_, after_;
  MaterialPairs materials_;
  double tolerance_;
  Progress& progress_;
  bool with_attributes_;
};

/// The nodes whose path occurs once.
std::unordered_map<std::uint64_t, core::NodeId> nodes_by_path(const Revision& revision) {
  NodeNames names;
  std::unordered_map<std::uint64_t, core::NodeId> found;
  revision.scene->for_each_node(revision.top,
                                [&](core::NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
                                  names.add(*revision.scene, node, revision.top);
                                  const auto [place, fresh] = found.try_emplace(names.path[node.index], node);
                                  if (!fresh) place->second = {};
                                });
  return found;
}

std::vector<NodeChange> changed_nodes(const Revision& before, const Revision& after) {
  const auto old_nodes = nodes_by_path(before), new_nodes = nodes_by_path(after);
  std::vector<NodeChange> changes;
  NodeNames names;
  after.scene->for_each_node(
      after.top, [&](core::NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
        names.add(*after.scene, node, after.top);
        const std::uint64_t path = names.path[node.index];
        const auto old = old_nodes.find(path);
        if (old == old_nodes.end() || !old->second.valid() || !new_nodes.at(path).valid()) return;
        if (before.scene->first_item(old->second) != core::kNoItem && after.scene->first_item(node) != core::kNoItem)
          return;
        if (!attributes_alike(before.scene->attributes(old->second), after.scene->attributes(node)))
          changes.push_back({old->second, node});
      });
  return changes;
}

}  // namespace

std::string_view name_of(State state) {
  constexpr std::string_view kNames[kStateCount] = {"unchanged", "added", "removed", "moved", "changed"};
  return kNames[std::size_t(state)];
}

core::Expected<Comparison> revisions(const Revision& before, const Revision& after, const Options& options) {
  if (!(options.tolerance >= 0.0 && std::isfinite(options.tolerance)))
    return core::fail("compare: expected a tolerance that is finite and not negative, in metres, found " +
                      std::to_string(options.tolerance));
  Progress progress(options.progress);
  Comparison comparison = Comparer(before, after, options.tolerance, progress).compare();
  progress.begin(0.1);
  if (progress.stopped()) return core::fail(std::string(kCancelled));
  if (comparison.with_attributes) comparison.nodes = changed_nodes(before, after);
  return comparison;
}

}  // namespace sightline::compare
