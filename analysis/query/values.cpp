#include "sightline/analysis/query/values.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <map>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "sightline/analysis/query/internal/leading_number.h"
#include "sightline/core/internal/ascii_case.h"

namespace sightline::query {
namespace {

using core::ItemId;
using core::NodeId;
using core::Scene;

constexpr const char* kOwnKeys[] = {"@kind", "@material", "@layer", "@file", "@size"};
constexpr std::size_t kMostSimilar = 5;

/// Gives texts numbers.
class Texts {
 public:
  std::uint32_t number_of(std::string_view text) {
    const auto [found, added] = numbers_.try_emplace(std::string(text), std::uint32_t(all_.size()));
    if (added) all_.push_back(&found->first);
    return found->second;
  }
  std::size_t size() const { return all_.size(); }
  const std::string& text(std::uint32_t number) const { return *all_[number]; }

 private:
  std::unordered_map<std::string, std::uint32_t> numbers_;
  std::vector<const std::string*> all_;
};

template <class Visit>
void for_each_item(const Scene& scene, NodeId node, const Visit& visit) {
  for (ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item)) visit(item);
}

/// Calls visit(node, inherited) for each node, parents first. What it returns is what the node's children inherit.
template <class Inherited, class Visit>
void walk_down(const Scene& scene, const Inherited& at_root, const Visit& visit) {
  std::vector<Inherited> known;
  scene.for_each_node(scene.root(), [&](NodeId node, const auto&...) {
    if (known.size() <= node.index) known.resize(node.index + 1, at_root);
    const NodeId parent = scene.parent(node);
    known[node.index] = visit(node, parent.valid() ? known[parent.index] : at_root);
  });
}

/// The text of a number that is the shortest one to be read as the same float.
std::string text_of(float number) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return {text.data(), end};
}

std::string colour_text(const core::vec3& colour) {
  std::string text = "#";
  for (int i = 0; i < 3; ++i) {
    constexpr char kDigits[] = "0123456789abcdef";
    const int byte = int(std::lround(255.0f * std::clamp(colour[i], 0.0f, 1.0f)));
    text += {kDigits[byte / 16], kDigits[byte % 16]};
  }
  return text;
}

std::string layer_text(std::uint32_t layers) {
  if (layers & core::kLayerModel) return "model";
  if (layers & core::kLayerObstruction) return "obstruction";
  if (layers & core::kLayerInsulation) return "insulation";
  return std::to_string(std::countr_zero(layers));
}

/// Collects the values of items.
class Collector {
 public:
  explicit Collector(const Scene& scene) : values_{{}, std::vector<std::uint32_t>(scene.item_slots(), core::kNone)} {}

  std::uint32_t number_of(std::string_view text) { return texts_.number_of(text); }
  void set(ItemId item, std::uint32_t number) { values_.of_item[to_index(item)] = number; }

  Values finish(const Scene& scene) && {
    std::vector<std::uint32_t> counts(texts_.size()), order, place(texts_.size());
    for (const std::uint32_t number : values_.of_item)
      if (number != core::kNone) ++counts[number], ++found_;
    for (std::uint32_t i = 0; i < counts.size(); ++i)
      if (counts[i] > 0) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return counts[a] != counts[b] ? counts[a] > counts[b] : texts_.text(a) < texts_.text(b);
    });
    for (const std::uint32_t number : order) {
      place[number] = std::uint32_t(values_.all.size());
      values_.all.push_back({texts_.text(number), counts[number]});
    }
    for (std::uint32_t& number : values_.of_item)
      if (number != core::kNone) number = place[number];
    values_.without = std::uint32_t(scene.item_count()) - found_;
    return std::move(values_);
  }

 private:
  Texts texts_;
  Values values_;
  std::uint32_t found_ = 0;
};

Values values_of_attribute(const Scene& scene, std::string_view key) {
  Collector values(scene);
  walk_down(scene, core::kNone, [&](NodeId node, std::uint32_t number) {
    for (const auto& [name, value] : scene.attributes(node))
      if (core::same_but_for_case(name, key)) {
        number = values.number_of(value);
        break;
      }
    for_each_item(scene, node, [&](ItemId item) { values.set(item, number); });
    return number;
  });
  return std::move(values).finish(scene);
}

Values files_of(const Scene& scene) {
  Collector values(scene);
  walk_down(scene, core::kNone, [&](NodeId node, std::uint32_t number) {
    if (scene.parent(node) == scene.root()) number = values.number_of(scene.path(node));
    for_each_item(scene, node, [&](ItemId item) { values.set(item, number); });
    return number;
  });
  return std::move(values).finish(scene);
}

/// Values that an item has by itself; `text_of(item, state)` is empty where it has none.
template <class TextOf>
Values values_by(const Scene& scene, const TextOf& text_of) {
  Collector values(scene);
  scene.for_each_node(scene.root(), [&](NodeId node, const core::Affine& world_from_node, bool, std::uint32_t layers,
                                        core::MaterialId material) {
    for_each_item(scene, node, [&](ItemId item) {
      const std::string text = text_of(item, scene.state(item, world_from_node, true, layers, material));
      if (!text.empty()) values.set(item, values.number_of(text));
    });
  });
  return std::move(values).finish(scene);
}

std::string material_text(const Scene& scene, std::uint32_t index) {
  const core::MaterialId material = scene.material_at(index);
  if (!material.valid()) return {};
  const core::Material& found = scene.material(material);
  return found.name.empty() ? colour_text(found.colour) : found.name;
}

std::string size_text(const Scene& scene, ItemId item, const core::Affine& world_from_item) {
  const core::AabbD box = scene.bounds_under(item, world_from_item);
  if (box.empty()) return {};
  const core::dvec3 size = box.size();
  return text_of(float(std::max({size.x, size.y, size.z})));
}

Values own_values(const Scene& scene, std::string_view key) {
  using State = Scene::ItemState;
  if (key == "@file") return files_of(scene);
  if (key == "@material")
    return values_by(scene, [&](ItemId, const State& state) { return material_text(scene, state.material); });
  if (key == "@layer") {
    // A hidden item lies on its layers, too.
    Collector values(scene);
    scene.for_each_node(scene.root(), [&](NodeId node, const core::Affine&, bool, std::uint32_t layers, const auto&) {
      const std::uint32_t number = values.number_of(layer_text(layers));
      for_each_item(scene, node, [&](ItemId item) { values.set(item, number); });
    });
    return std::move(values).finish(scene);
  }
  if (key == "@size")
    return values_by(scene,
                     [&](ItemId item, const State& state) { return size_text(scene, item, state.world_from_item); });
  return values_by(scene, [&](ItemId item, const State&) { return std::string(core::name_of(scene.kind(item))); });
}

/// Names keys that are like one that nothing has.
core::Error no_values(const Scene& scene, std::string_view key) {
  std::string message = "no item has a value for \"" + std::string(key) + "\"", also;
  const std::string wanted = core::lower_case(key);
  std::vector<std::string> like, others;
  for (const Key& known : attribute_keys(scene))
    (core::lower_case(known.name).find(wanted) != std::string::npos ? like : others).push_back(known.name);
  like.insert(like.end(), others.begin(), others.end());
  for (std::size_t i = 0; i < std::min(kMostSimilar, like.size()); ++i) also += (i == 0 ? "; keys: " : ", ") + like[i];
  if (key.starts_with('@')) also = "; keys: @kind, @material, @layer, @file, @size";
  return {message + also};
}

}  // namespace

std::vector<Key> attribute_keys(const Scene& scene) {
  struct Found {
    Key key;
    std::unordered_set<std::string_view> values;
  };
  std::vector<Found> found;
  std::unordered_map<std::string, std::uint32_t> number_of;
  // The keys that a node's items have are a list, which all nodes with these keys share.
  std::vector<std::vector<std::uint32_t>> lists{{}};
  std::map<std::vector<std::uint32_t>, std::uint32_t> list_of;
  std::vector<std::uint32_t> items_below(1);
  walk_down(scene, 0u, [&](NodeId node, std::uint32_t list) {
    std::vector<std::uint32_t> gained;
    for (const auto& [name, value] : scene.attributes(node)) {
      const auto [known, added] = number_of.try_emplace(core::lower_case(name), std::uint32_t(found.size()));
      if (added) found.push_back({{name}, {}});
      found[known->second].values.insert(value);
      const auto& above = lists[list];
      if (std::find(above.begin(), above.end(), known->second) == above.end() &&
          std::find(gained.begin(), gained.end(), known->second) == gained.end())
        gained.push_back(known->second);
    }
    if (!gained.empty()) {
      gained.insert(gained.end(), lists[list].begin(), lists[list].end());
      const auto [known, fresh] = list_of.try_emplace(std::move(gained), std::uint32_t(lists.size()));
      if (fresh) {
        lists.push_back(known->first);
        items_below.push_back(0);
      }
      list = known->second;
    }
    for_each_item(scene, node, [&](ItemId) { ++items_below[list]; });
    return list;
  });
  for (std::size_t list = 0; list < lists.size(); ++list)
    for (const std::uint32_t key : lists[list]) found[key].key.items += items_below[list];
  std::vector<Key> keys;
  for (Found& one : found) {
    one.key.values = std::uint32_t(one.values.size());
    if (one.key.items > 0) keys.push_back(std::move(one.key));
  }
  std::sort(keys.begin(), keys.end(),
            [](const Key& a, const Key& b) { return a.items != b.items ? a.items > b.items : a.name < b.name; });
  return keys;
}

std::span<const char* const> own_keys() {
  return kOwnKeys;
}

core::Expected<Values> values_of(const Scene& scene, std::string_view key) {
  const std::string own = core::lower_case(key);
  const bool is_own = std::find(std::begin(kOwnKeys), std::end(kOwnKeys), own) != std::end(kOwnKeys);
  Values values = is_own ? own_values(scene, own) : values_of_attribute(scene, key);
  if (values.all.empty()) return tl::unexpected(no_values(scene, key));
  return values;
}

std::optional<double> number_of(std::string_view value) {
  const auto read = leading_number(value);
  return read ? std::optional(read->first) : std::nullopt;
}

}  // namespace sightline::query
