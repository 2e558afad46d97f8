#include "sightline/apps/viewpoints/item_names.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "sightline/apps/common/tree_walk.h"
#include "sightline/core/internal/hash.h"

namespace sightline::apps {
namespace {

using core::kNoItem;
using core::kNone;

std::string_view guid_of(const core::Scene& scene, core::NodeId node) {
  for (const auto& [key, value] : scene.attributes(node))
    if (key == "IfcGuid" || key == "IfcGUID" || key == "GlobalId") return value;
  return {};
}

}  // namespace

std::string to_text(const PartName& part) {
  std::string text = part.node;
  // A path that has a question mark itself always gets an ending, which is what follows the last one.
  const bool nth = part.nth > 0 || (!part.item && (text.empty() || text.find('?') != std::string::npos));
  if (nth) text += "?nth=" + std::to_string(part.nth + 1);
  if (part.item) text += (nth ? "&item=" : "?item=") + std::to_string(*part.item + 1);
  return text;
}

PartName part_of(std::string_view text) {
  const std::size_t mark = text.rfind('?');
  const PartName whole{std::string(text), 0, {}, {}};
  if (mark == std::string_view::npos) return whole;
  PartName part{std::string(text.substr(0, mark)), 0, {}, {}};
  std::string_view rest = text.substr(mark + 1);
  const auto take = [&](std::string_view key) -> std::optional<std::uint32_t> {
    std::uint32_t number = 0;
    if (!rest.starts_with(key)) return std::nullopt;
    const char* end = rest.data() + rest.size();
    const auto read = std::from_chars(rest.data() + key.size(), end, number);
    if (read.ec != std::errc() || number == 0) return std::nullopt;
    rest = {read.ptr, std::size_t(end - read.ptr)};
    return number - 1;
  };
  const auto nth = take("nth=");
  if (nth && rest.starts_with('&')) rest.remove_prefix(1);
  part.nth = nth.value_or(0);
  part.item = take("item=");
  return rest.empty() && (nth || part.item) ? part : whole;
}

ItemNames::ItemNames(const core::Scene& scene) : scene_(&scene) {
  places_.reserve(scene.node_count());
  items_.reserve(scene.item_count());
  std::vector<std::uint32_t> position;  // of the next child of each open node
  std::uint32_t parent = kNone;
  walk(
      scene,
      [&](core::NodeId node) {
        const auto here = std::uint32_t(places_.size());
        const std::uint32_t siblings_before = parent == kNone ? 0 : position.back()++;
        const auto first = std::uint32_t(items_.size());
        for (core::ItemId item = scene.first_item(node); item != kNoItem; item = scene.next_item(item))
          items_.push_back(item);
        places_.push_back(
            {node, core::kFnvBasis, 0, siblings_before, parent, here, first, std::uint32_t(items_.size())});
        Place& place = places_.back();
        if (parent != kNone)
          place.path =
              core::fnv1a(label(place), parent == 0 ? core::kFnvBasis : core::fnv1a("/", places_[parent].path));
        std::vector<std::uint32_t>& same = by_path_[place.path];
        place.nth = std::uint32_t(same.size());
        same.push_back(here);
        if (const std::string_view guid = guid_of(scene, node); !guid.empty()) by_guid_.emplace(guid, here);
        position.push_back(0);
        parent = here;
      },
      [&](core::NodeId) {
        places_[parent].end = std::uint32_t(places_.size());
        places_[parent].end_item = std::uint32_t(items_.size());
        position.pop_back();
        parent = places_[parent].parent;
      });
}

/// As core::Scene::path() has it.
std::string ItemNames::label(const Place& place) const {
  const std::string_view name = scene_->name(place.node);
  return name.empty() ? "#" + std::to_string(place.position) : std::string(name);
}

PartName ItemNames::name_of(const Place& place) const {
  std::vector<const Place*> chain;
  for (const Place* at = &place; at->parent != kNone; at = &places_[at->parent]) chain.push_back(at);
  PartName name{{}, place.nth, {}, std::string(guid_of(*scene_, place.node))};
  for (auto it = chain.rbegin(); it != chain.rend(); ++it)
    name.node.append(name.node.empty() ? "" : "/").append(label(**it));
  return name;
}

const ItemNames::Place* ItemNames::place_of(const PartName& part) const {
  // A name that is a GUID alone has no path, which the root would have.
  if (!part.node.empty() || part.guid.empty()) {
    const auto same = by_path_.find(core::fnv1a(part.node));
    if (same != by_path_.end() && part.nth < same->second.size()) return &places_[same->second[part.nth]];
  }
  const auto it = by_guid_.find(part.guid);
  return it != by_guid_.end() ? &places_[it->second] : nullptr;
}

std::vector<PartName> ItemNames::parts(const std::vector<bool>& marked) const {
  std::vector<std::uint32_t> before(items_.size() + 1);  // marked ones before each
  for (std::size_t i = 0; i < items_.size(); ++i) before[i + 1] = before[i] + marked[i];
  std::vector<PartName> parts;
  for (std::uint32_t i = 0; i < places_.size();) {
    const Place& place = places_[i];
    const std::uint32_t count = before[place.end_item] - before[place.first_item];
    if (count == 0) {
      i = place.end;
    } else if (count == place.end_item - place.first_item) {
      parts.push_back(name_of(place));
      i = place.end;
    } else {
      for (std::uint32_t item = place.first_item; item < place.own_end; ++item) {
        if (!marked[item]) continue;
        parts.push_back(name_of(place));
        parts.back().item = item - place.first_item;
      }
      ++i;
    }
  }
  return parts;
}

PartSet ItemNames::name(std::span<const core::ItemId> items, bool others) const {
  std::vector<bool> named(scene_->item_slots()), marked(items_.size());
  for (const core::ItemId item : items)
    if (to_index(item) < named.size()) named[to_index(item)] = true;
  for (std::size_t i = 0; i < items_.size(); ++i) marked[i] = named[to_index(items_[i])];
  PartSet set{false, parts(marked)};
  if (!others || set.parts.size() < 2) return set;
  marked.flip();
  PartSet rest{true, parts(marked)};
  return rest.parts.size() < set.parts.size() ? rest : set;
}

ItemNames::Found ItemNames::find(const PartSet& set) const {
  Found found;
  std::vector<bool> marked(items_.size());
  for (const PartName& part : set.parts) {
    const Place* place = place_of(part);
    if (!place || (part.item && *part.item >= place->own_end - place->first_item)) {
      ++found.missing;
      continue;
    }
    std::uint32_t first = place->first_item, last = place->end_item;
    if (part.item) {
      first += *part.item;
      last = first + 1;
    }
    for (; first < last; ++first) marked[first] = true;
  }
  // Where none of the others is known, all would be hidden that nobody meant.
  const bool unknown = set.all_but && !set.parts.empty() && found.missing == set.parts.size();
  for (std::size_t i = 0; i < items_.size() && !unknown; ++i)
    if (marked[i] != set.all_but) found.items.push_back(items_[i]);
  std::sort(found.items.begin(), found.items.end());
  return found;
}

}  // namespace sightline::apps
