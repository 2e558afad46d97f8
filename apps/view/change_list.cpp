#include "sightline/apps/view/change_list.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <utility>

#include "sightline/apps/common/change_colours.h"
#include "sightline/apps/common/item_copier.h"
#include "sightline/apps/common/numbers.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/tree_walk.h"
#include "sightline/apps/compare/group_images.h"
#include "sightline/apps/view/tree_rows.h"

namespace sightline::apps {
namespace {

using compare::Change;
using compare::State;

constexpr std::uint32_t kNoChange = ~std::uint32_t{0};
constexpr double kTurned = 1e-4;  // radians; less is not worth telling

/// Both revisions have such an item, each in its own way.
bool is_replaced(State state) {
  return state == State::kMoved || state == State::kChanged;
}

core::Expected<core::NodeId> same_file(const Model& open, std::string_view name) {
  const std::vector<core::NodeId>& files = open.report.nodes;
  if (files.size() == 1) return files[0];
  for (const core::NodeId file : files)
    if (open.scene->name(file) == name) return file;
  return core::fail("compare: expected a file with the name of one of the " + std::to_string(files.size()) +
                    " that are open, found " + std::string(name));
}

}  // namespace

core::Expected<Compared> compare_models(const Model& before, const Model& open,
                                        const std::function<bool(double)>& progress) {
  if (before.report.nodes.size() != 1)
    return core::fail("compare: expected a file with a model, found attributes alone");
  const core::NodeId old_file = before.report.nodes[0];
  const auto new_file = same_file(open, before.scene->name(old_file));
  if (!new_file) return tl::unexpected(new_file.error());
  compare::Options options;
  options.tolerance += before.report.sharing_error + open.report.sharing_error;
  options.progress = progress;
  return compare_revisions({before.scene.get(), old_file}, {open.scene.get(), *new_file}, options);
}

std::vector<std::string> older_files(const std::string& file, const std::vector<std::string>& open_files) {
  namespace fs = std::filesystem;
  std::vector<std::string> files{file};
  for (const fs::path open : open_files) {
    if (!importers::is_attribute_file(open)) continue;
    const fs::path beside = fs::path(file).parent_path() / open.filename();
    fs::path named = file;
    named.replace_extension(open.extension());
    std::error_code none;
    for (const fs::path& place : {beside, named})
      if (fs::exists(place, none) && std::find(files.begin(), files.end(), place.string()) == files.end()) {
        files.push_back(place.string());
        break;
      }
  }
  return files;
}

std::pair<std::string, std::string> names_apart(const std::string& older, const std::vector<std::string>& open_files) {
  namespace fs = std::filesystem;
  const fs::path old = older;
  std::vector<fs::path> models(open_files.begin(), open_files.end());
  std::erase_if(models, [](const fs::path& file) { return importers::is_attribute_file(file); });
  if (models.size() > 1) std::erase_if(models, [&](const fs::path& file) { return file.filename() != old.filename(); });
  const fs::path now = models.empty() ? fs::path() : models.front();
  if (now.filename() != old.filename()) return {old.filename().string(), now.filename().string()};
  const auto in_folder = [](const fs::path& file) {
    const fs::path whole = fs::absolute(file).lexically_normal();
    return (whole.parent_path().filename() / whole.filename()).string();
  };
  return {in_folder(old), in_folder(now)};
}

ChangeList::ChangeList(std::string file, Model before, Compared found)
    : file_(std::move(file)), before_(std::move(before)), compared_(std::move(found)) {
  shown_.fill(true);
  list();
}

/// Copies what changes, by their indices, had before. Below the root, which moves all of a model, as the former root
/// did.
core::Expected<ChangeList::Copies> ChangeList::copy(core::Scene& scene, const char* name,
                                                    std::span<const std::uint32_t> changes) {
  Copies copies;
  if (changes.empty()) return copies;
  const core::Scene& old = before();
  const core::NodeId top = before_.report.nodes[0];
  const core::Affine here = scene.transform(scene.root()), there = old.world_from_node(top);
  const core::dmat3 back = glm::inverse(here.linear);
  copies.node = scene.add_node(scene.root(), name + (" (" + std::filesystem::path(file_).filename().string() + ")"),
                               {back * there.linear, back * (there.origin - here.origin)});
  ItemCopier copier(old, top, scene, copies.node, ItemCopier::Materials::kNone);
  core::Expected<void> done;
  for (const std::uint32_t change : changes) {
    const auto copied = copier.copy(found().items[change].before);
    if (!copied) {
      done = tl::unexpected(copied.error());
      break;
    }
    copies.items.push_back(*copied);
    change_of_.resize(scene.item_slots(), kNoChange);
    change_of_[to_index(*copied)] = change;
  }
  copies.meshes = copier.meshes();
  if (done) return copies;
  take(scene, copies);
  return tl::unexpected(done.error());
}

void ChangeList::take(core::Scene& scene, Copies& copies) {
  if (!copies.node.valid()) return;
  scene.remove_node(copies.node);
  for (const core::MeshId mesh : copies.meshes) scene.remove_mesh(mesh);
  copies = {};
}

core::Expected<void> ChangeList::add_removed(core::Scene& scene) {
  change_of_.assign(scene.item_slots(), kNoChange);
  for (std::size_t i = 0; i < first_removed(); ++i) change_of_[to_index(found().items[i].after)] = std::uint32_t(i);
  std::vector<std::uint32_t> removed(found().count(State::kRemoved));
  std::iota(removed.begin(), removed.end(), std::uint32_t(first_removed()));
  auto copies = copy(scene, "removed", removed);
  if (!copies) return tl::unexpected(copies.error());
  removed_ = std::move(*copies);
  return {};
}

void ChangeList::take_removed(core::Scene& scene) {
  take(scene, removed_);
}

core::Expected<void> ChangeList::add_replaced(core::Scene& scene) {
  std::vector<std::uint32_t> replaced;
  for (std::size_t i = 0; i < first_removed(); ++i)
    if (is_replaced(found().items[i].state)) replaced.push_back(std::uint32_t(i));
  auto copies = copy(scene, "replaced", replaced);
  if (!copies) return tl::unexpected(copies.error());
  replaced_ = std::move(*copies);
  apart_ = true;
  return {};
}

void ChangeList::take_replaced(core::Scene& scene) {
  take(scene, replaced_);
  apart_ = false;
}

std::vector<core::ItemId> ChangeList::only_in(Revision revision) const {
  std::vector<core::ItemId> items;
  if (revision == Revision::kOlder) {
    items = removed_.items;
    items.insert(items.end(), replaced_.items.begin(), replaced_.items.end());
  } else {
    for (std::size_t i = 0; i < first_removed(); ++i)
      if (const Change& change = found().items[i]; change.state == State::kAdded || is_replaced(change.state))
        items.push_back(change.after);
  }
  std::sort(items.begin(), items.end());
  return items;
}

void ChangeList::set_shown(State state, bool shown) {
  shown_[std::size_t(state)] = shown;
  list();
}

void ChangeList::list() {
  const std::optional<std::uint32_t> was = current_ ? std::optional(rows_[*current_]) : std::nullopt;
  rows_.clear();
  for (std::size_t i = 0; i < compared_.groups.all.size(); ++i)
    if (shown(shown_as(compared_.groups.all[i].way))) rows_.push_back(std::uint32_t(i));
  current_.reset();
  if (!was) return;
  const auto same = std::lower_bound(rows_.begin(), rows_.end(), *was);
  if (same != rows_.end() && *same == *was) current_ = std::size_t(same - rows_.begin());
}

BaseStyles ChangeList::base_styles() const {
  BaseStyles base_styles;
  for (std::size_t i = 0; i < compare::kStateCount; ++i) {
    const std::optional<core::vec3> colour = change_colour(State(i));
    base_styles.all.push_back({{.colour = colour, .ghost = !colour && !apart_}, shown_[i]});
  }
  base_styles.which.resize(change_of_.size());
  for (std::size_t item = 0; item < change_of_.size(); ++item)
    if (change_of_[item] != kNoChange)
      base_styles.which[item] = std::uint8_t(std::size_t(found().items[change_of_[item]].state) + 1);
  return base_styles;
}

core::ItemId ChangeList::item_of(std::size_t change) const {
  return change < first_removed() ? found().items[change].after : removed_.items[change - first_removed()];
}

core::Expected<std::string> ChangeList::report(const std::string& extension, core::Scene& open) const {
  if (extension == ".csv") return csv_report(compared_);
  if (extension == ".json") return to_text(json::sorted(json_report(compared_)));
  if (extension != ".html" && extension != ".bcf" && extension != ".bcfzip")
    return core::fail("expected a name that ends in .html, .csv, .json, .bcfzip or .bcf");
  std::vector<GroupImage> images;
#if SIGHTLINE_HAS_GROUP_IMAGES
  auto drawn = group_images(compared_, *before_.scene, open);
  if (!drawn) return tl::unexpected(drawn.error());
  images = std::move(*drawn);
#else
  (void)open;
#endif
  return extension == ".html" ? html_report(compared_, images) : bcf_report(compared_, images);
}

State ChangeList::state(std::size_t row) const {
  return shown_as(group(row).way);
}

/// What is removed hangs on copies of the nodes that it hung on.
core::NodeId ChangeList::node(const core::Scene& scene, std::size_t row) const {
  const compare::Group& of = group(row);
  if (of.way != compare::Way::kRemoved) return of.node;
  core::NodeId now = scene.node_of(item_of(compared_.groups.members[of.begin]));
  for (core::NodeId old = before().node_of(compared_.item(of, 0).before);
       old != of.node && old != before_.report.nodes[0]; old = before().parent(old))
    now = scene.parent(now);
  return now;
}

std::vector<core::ItemId> ChangeList::items(const core::Scene& scene, std::size_t row) const {
  const compare::Group& of = group(row);
  std::vector<core::ItemId> items;
  std::vector<core::NodeId> nodes;
  for (std::uint32_t i = of.begin; i < of.end; ++i) {
    const std::uint32_t member = compared_.groups.members[i];
    if (of.way == compare::Way::kNodeAttributes)
      nodes.push_back(found().nodes[member].after);
    else
      items.push_back(item_of(member));
  }
  if (!nodes.empty()) return items_below(scene, nodes);
  std::sort(items.begin(), items.end());
  return items;
}

std::string ChangeList::name(std::size_t row) const {
  return name_of(compared_, group(row));
}

const std::string& ChangeList::what(std::size_t row, const LengthFormat& lengths) {
  if (!compared_.lengths || compared_.lengths->units != lengths.units ||
      compared_.lengths->decimals != lengths.decimals) {
    compared_.lengths = lengths;
    words_.assign(compared_.groups.all.size(), "");
  }
  std::string& words = words_[rows_[row]];
  if (words.empty()) words = what_of(compared_, group(row));
  return words;
}

std::optional<std::size_t> ChangeList::step(int by) {
  const std::size_t count = rows_.size();
  if (count == 0) return current_ = std::nullopt;
  if (current_)
    current_ = (*current_ + (by > 0 ? 1 : count - 1)) % count;
  else
    current_ = by > 0 ? 0 : count - 1;
  return current_;
}

const Change* ChangeList::of(core::ItemId item) const {
  return to_index(item) < change_of_.size() && change_of_[to_index(item)] != kNoChange
             ? &found().items[change_of_[to_index(item)]]
             : nullptr;
}

std::vector<FactChange> ChangeList::differing_facts(const core::Scene& scene, core::ItemId item) const {
  const Change* change = of(item);
  if (!change || change->before == core::kNoItem || change->after == core::kNoItem) return {};
  std::vector<FactChange> facts = differing(item_facts(before(), change->before), item_facts(scene, change->after));
  const core::NodeId old = before().node_of(change->before), now = scene.node_of(change->after);
  for (FactChange& fact : differing(attribute_facts(before(), old), attribute_facts(scene, now)))
    facts.push_back(std::move(fact));
  if (before().name(old) != scene.name(now))
    facts.push_back({"name", std::string(before().name(old)), std::string(scene.name(now))});
  return facts;
}

std::string describe(const Change& change, const LengthFormat& lengths) {
  if (change.before == core::kNoItem || change.after == core::kNoItem)
    return std::string(compare::name_of(change.state));
  std::string text;
  for (const auto& [bit, name] : {std::pair(compare::kShape, "shape"), std::pair(compare::kMaterial, "material"),
                                  std::pair(compare::kAttributes, "attributes")})
    if (change.differences & bit) text.append(text.empty() ? "changed: " : ", ").append(name);
  const auto add = [&](const std::string& words) { text.append(text.empty() ? "" : "; ").append(words); };
  if (change.differences & compare::kPlace) {
    add("moved by " + lengths.text(glm::length(change.offset)));
    char turn[40];
    std::snprintf(turn, sizeof turn, ", turned by %.1f°", glm::degrees(change.turn));
    if (change.turn > kTurned) text += turn;
  }
  if (change.differences & compare::kPath) add("renamed");
  return text.empty() ? std::string(compare::name_of(change.state)) : text;
}

}  // namespace sightline::apps
