#include "sightline/analysis/compare/groups.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include <glm/gtc/quaternion.hpp>

#include "sightline/analysis/compare/internal/displacements.h"
#include "sightline/analysis/compare/internal/tree.h"
#include "sightline/core/internal/hash.h"

namespace sightline::compare {
namespace {

/// The share of what could have changed alike from which a group stands for all of it, with exceptions.
constexpr bool nearly_all(std::size_t count, std::size_t of) {
  return 10 * count >= 9 * of;
}

/// A change of an item or node, which is named by its order in the tree.
struct Mark {
  std::uint64_t kind;  // marks of equal kind changed alike
  std::uint32_t order;
  std::uint32_t index;  // in Comparison::items or nodes
};

/// What may change in one way: items or nodes in tree order.
struct Candidates {
  std::span<const std::uint32_t> node_of;  // by order; empty: each is its own node
  std::span<const std::uint32_t> first;    // by node; empty: the same
  std::vector<std::uint32_t> before;       // by order: how many candidates come before, and how many there are

  std::uint32_t node(std::uint32_t order) const { return node_of.empty() ? order : node_of[order]; }
  std::uint32_t begin(std::uint32_t node) const { return first.empty() ? node : first[node]; }
  /// Counts items below the nodes from `node` up to `end`, which is excluded.
  std::uint32_t count(std::uint32_t node, std::uint32_t end) const { return before[begin(end)] - before[begin(node)]; }
};

template <class Counts>
std::vector<std::uint32_t> counts_before(std::size_t size, const Counts& counts) {
  std::vector<std::uint32_t> before{0};
  before.reserve(size + 1);
  for (std::size_t i = 0; i < size; ++i) before.push_back(before.back() + (counts(i) ? 1 : 0));
  return before;
}

/// Collects groups of one way of changing.
class Grouper {
 public:
  Grouper(const Tree& tree, Way way, Candidates candidates, Groups& out)
      : tree_(tree), way_(way), candidates_(std::move(candidates)), out_(out) {}

  void add(std::vector<Mark> marks) {
    std::sort(marks.begin(), marks.end(),
              [](const Mark& a, const Mark& b) { return std::tie(a.kind, a.order) < std::tie(b.kind, b.order); });
    for (std::size_t i = 0, end = 0; i < marks.size(); i = end) {
      while (end < marks.size() && marks[end].kind == marks[i].kind) ++end;
      split({marks.data() + i, end - i});
    }
  }

 private:
  using Marks = std::span<const Mark>;

  /// Marks of one kind become groups at the topmost nodes that they fill.
  void split(Marks all) {
    std::vector<Marks> open{all};
    while (!open.empty()) {
      const Marks marks = open.back();
      open.pop_back();
      const std::uint32_t lowest =
          tree_.common(candidates_.node(marks.front().order), candidates_.node(marks.back().order));
      const auto below = [&](std::uint32_t node) { return candidates_.count(node, tree_.end[node]); };
      const std::uint32_t of = below(lowest);
      if (marks.size() == of)
        emit(tree_.climb(lowest, [&](std::uint32_t node) { return below(node) == of; }), marks, of);
      else if (nearly_all(marks.size(), of))
        emit(lowest, marks, of);
      else
        split_at(lowest, marks, open);
    }
  }

  /// Marks of a node's own and of its leaves, which are children without children, are a group; those of other
  /// children are left open.
  void split_at(std::uint32_t node, Marks marks, std::vector<Marks>& open) {
    const auto order_from = [](const Mark& mark, std::uint32_t order) { return mark.order < order; };
    const auto before = [&](std::uint32_t order) {
      return std::size_t(std::lower_bound(marks.begin(), marks.end(), order, order_from) - marks.begin());
    };
    const std::size_t opened = open.size(), own = before(candidates_.begin(node + 1));
    std::vector<Mark> close(marks.begin(), marks.begin() + std::ptrdiff_t(own));
    std::uint32_t holder = node;
    std::size_t holders = own > 0 ? 1 : 0;
    for (marks = marks.subspan(own); !marks.empty();) {
      const std::uint32_t child = tree_.climb(candidates_.node(marks.front().order), [&](std::uint32_t above) {
        return tree_.depth[above] > tree_.depth[node];
      });
      const Marks taken = marks.first(before(candidates_.begin(tree_.end[child])));
      marks = marks.subspan(taken.size());
      if (tree_.end[child] > child + 1) {
        open.push_back(taken);
        continue;
      }
      close.insert(close.end(), taken.begin(), taken.end());
      holder = child;
      ++holders;
    }
    std::reverse(open.begin() + std::ptrdiff_t(opened), open.end());  // the first one is taken next
    if (holders == 1) emit(holder, close, candidates_.count(holder, holder + 1));
    if (holders > 1) emit(node, close, candidates_.count(node, tree_.end[node]));
  }

  void emit(std::uint32_t node, Marks marks, std::uint32_t of) {
    Group group;
    group.way = way_;
    group.node = tree_.nodes[node];
    group.begin = std::uint32_t(out_.members.size());
    for (const Mark& mark : marks) out_.members.push_back(mark.index);
    group.end = std::uint32_t(out_.members.size());
    group.of = of;
    out_.all.push_back(group);
  }

  const Tree& tree_;
  Way way_;
  Candidates candidates_;
  Groups& out_;
};

std::uint64_t attribute_kind(const core::Scene::Attributes& before, const core::Scene::Attributes& after) {
  core::Scene::Attributes a = before, b = after, off;
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(off));
  std::uint64_t kind = 0;
  for (std::size_t i = 0; i < off.size(); ++i)
    if (i == 0 || off[i].first != off[i - 1].first)
      kind = core::mixed(core::mixed(kind) + std::hash<std::string>()(off[i].first));
  return kind;
}

class Finder {
 public:
  Finder(const Revision& before, const Revision& after, const Comparison& found, double tolerance)
      : before_(before), after_(after), found_(found), displacements_(std::max(2.0 * tolerance, 1e-6)) {}

  Groups find() {
    if (found_.same() && found_.renamed == 0) return {};
    place_changed();
    group_later();
    if (found_.count(State::kRemoved) > 0) group_removed();
    measure();
    sort();
    return std::move(out_);
  }

 private:
  std::size_t first_removed() const { return found_.items.size() - found_.count(State::kRemoved); }
  static bool paired(const Change& c) { return c.before != core::kNoItem && c.after != core::kNoItem; }
  static bool displaced(const Change& c) { return (c.differences & (kPlace | kShape)) == kPlace; }

  /// Placements of all that has changed: where it is, and, of what turned, where it was.
  void place_changed() {
    std::vector<core::ItemId> now, was;
    std::vector<std::uint32_t> now_index, was_index;
    place_of_.assign(found_.items.size(), core::kNone);
    for (std::uint32_t i = 0; i < found_.items.size(); ++i) {
      const Change& c = found_.items[i];
      if (c.state == State::kUnchanged && c.differences == 0) continue;
      place_of_[i] = std::uint32_t(places_.size());
      places_.emplace_back();
      const bool gone = c.after == core::kNoItem;
      if (!gone) changed_.push_back(i);
      if (!gone) now.push_back(c.after), now_index.push_back(place_of_[i]);
      if (gone || (displaced(c) && c.turn > kLeastTurn)) was.push_back(c.before), was_index.push_back(place_of_[i]);
    }
    std::size_t i = 0;
    before_.scene->for_each_state(was, [&](core::ItemId item, const core::Scene::ItemState& state) {
      Place& place = places_[was_index[i++]];
      place.was = state.world_from_item;
      place.box = before_.scene->bounds_under(item, state.world_from_item);
    });
    i = 0;
    after_.scene->for_each_state(now, [&](core::ItemId item, const core::Scene::ItemState& state) {
      Place& place = places_[now_index[i++]];
      place.now = state.world_from_item;
      place.material = state.material;
      place.box = after_.scene->bounds_under(item, state.world_from_item);
    });
  }

  /// The kind of a change in one way; none where the item did not change so.
  std::optional<std::uint64_t> kind(Way way, std::uint32_t index) {
    const Change& c = found_.items[index];
    const auto has = [&](Difference bit) { return (c.differences & bit) != 0; };
    switch (way) {
      case Way::kAdded:
        return c.state == State::kAdded ? std::optional<std::uint64_t>(0) : std::nullopt;
      case Way::kMoved: {
        if (!displaced(c)) return std::nullopt;
        Place& place = places_[place_of_[index]];
        return place.displacement = displacements_.class_of({c.offset, c.turn, place.was, place.now});
      }
      case Way::kShape: {
        if (!has(kShape)) return std::nullopt;
        const auto from = std::uint64_t(before_.scene->kind(c.before)), to = std::uint64_t(after_.scene->kind(c.after));
        return from == to ? 0 : 1 + (from << 8 | to);
      }
      case Way::kMaterial:
        return has(kMaterial) ? std::optional<std::uint64_t>(places_[place_of_[index]].material) : std::nullopt;
      case Way::kAttributes:
        if (!has(kAttributes)) return std::nullopt;
        return attribute_kind(before_.scene->attributes(before_.scene->node_of(c.before)),
                              after_.scene->attributes(after_.scene->node_of(c.after)));
      case Way::kRenamed:
        return has(kPath) ? std::optional<std::uint64_t>(0) : std::nullopt;
      case Way::kRemoved:
      case Way::kNodeAttributes:
        break;
    }
    return std::nullopt;
  }

  void group_later() {
    const Tree tree(after_);
    const auto items = [&](const auto& counts) {
      return Candidates{tree.node_of_item, tree.first_item, counts_before(first_removed(), counts)};
    };
    const auto pairs = [&](std::size_t i) { return paired(found_.items[i]); };
    for (const Way way : {Way::kAdded, Way::kMoved, Way::kShape, Way::kMaterial, Way::kAttributes, Way::kRenamed}) {
      std::vector<Mark> marks;
      for (const std::uint32_t i : changed_)
        if (const auto k = kind(way, i)) marks.push_back({*k, i, i});
      if (marks.empty()) continue;
      const auto of_way = [&](std::size_t i) {
        return way == Way::kAdded || (pairs(i) && !(way == Way::kMoved && found_.items[i].differences & kShape));
      };
      Grouper(tree, way, items(of_way), out_).add(std::move(marks));
    }
    if (!found_.nodes.empty()) group_nodes(tree);
  }

  void group_nodes(const Tree& tree) {
    std::vector<Mark> marks;
    std::uint32_t index = 0;  // changed nodes are in tree order, too
    for (std::uint32_t node = 0; node < tree.nodes.size() && index < found_.nodes.size(); ++node) {
      const NodeChange& c = found_.nodes[index];
      if (tree.nodes[node] != c.after) continue;
      marks.push_back(
          {attribute_kind(before_.scene->attributes(c.before), after_.scene->attributes(c.after)), node, index++});
    }
    const auto bare = [&](std::size_t node) {
      return after_.scene->first_item(tree.nodes[node]) == core::kNoItem ||
             std::binary_search(marks.begin(), marks.end(), Mark{0, std::uint32_t(node), 0},
                                [](const Mark& a, const Mark& b) { return a.order < b.order; });
    };
    Candidates nodes{{}, {}, counts_before(tree.nodes.size(), bare)};
    Grouper(tree, Way::kNodeAttributes, std::move(nodes), out_).add(std::move(marks));
  }

  void group_removed() {
    const Tree tree(before_);
    std::vector<Mark> marks;
    auto index = std::uint32_t(first_removed());  // in tree order, too
    for (std::uint32_t i = 0; i < tree.items.size() && index < found_.items.size(); ++i)
      if (tree.items[i] == found_.items[index].before) marks.push_back({0, i, index++});
    Candidates items{tree.node_of_item, tree.first_item,
                     counts_before(tree.items.size(), [](std::size_t) { return true; })};
    Grouper(tree, Way::kRemoved, std::move(items), out_).add(std::move(marks));
  }

  void measure() {
    for (Group& group : out_.all) {
      if (group.way == Way::kNodeAttributes) continue;
      for (std::uint32_t i = group.begin; i < group.end; ++i) group.box.grow(places_[place_of_[out_.members[i]]].box);
      if (group.way == Way::kMoved) measure_move(group);
    }
  }

  void measure_move(Group& group) {
    const std::uint32_t index = out_.members[group.begin];
    const Change& c = found_.items[index];
    const Place& place = places_[place_of_[index]];
    const core::Affine& map = displacements_.map(place.displacement);
    group.offset = map.origin;
    if (!displacements_.turned(place.displacement)) return;
    const core::dvec3 centre = group.box.empty() ? place.now.origin : group.box.centre();
    group.offset = centre - glm::inverse(map.linear) * (centre - map.origin);
    const glm::dquat turn = glm::normalize(glm::quat_cast(map.linear));
    group.turn = c.turn;
    group.axis = turn.w < 0.0 ? -glm::axis(turn) : glm::axis(turn);
  }

  void sort() {
    // In millimetres, so that rounding decides no order.
    const auto diagonal = [](const Group& g) { return std::round(1e3 * glm::length(g.box.size())); };
    std::stable_sort(out_.all.begin(), out_.all.end(), [&](const Group& a, const Group& b) {
      return a.size() != b.size() ? a.size() > b.size() : diagonal(a) > diagonal(b);
    });
  }

  struct Place {
    core::Affine was, now;
    core::AabbD box;
    std::uint32_t material = core::kNone, displacement = core::kNone;
  };

  Revision before_, after_;
  const Comparison& found_;
  Displacements displacements_;
  std::vector<std::uint32_t> place_of_;  // by index of Comparison::items
  std::vector<std::uint32_t> changed_;   // indices of the later revision's items that changed, in tree order
  std::vector<Place> places_;
  Groups out_;
};

}  // namespace

std::string_view name_of(Way way) {
  switch (way) {
    case Way::kAdded:
      return "added";
    case Way::kRemoved:
      return "removed";
    case Way::kMoved:
      return "moved";
    case Way::kShape:
    case Way::kMaterial:
    case Way::kAttributes:
    case Way::kNodeAttributes:
      return "changed";
    case Way::kRenamed:
      break;
  }
  return "renamed";
}

Groups grouped(const Revision& before, const Revision& after, const Comparison& found, double tolerance) {
  return Finder(before, after, found, tolerance).find();
}

}  // namespace sightline::compare
