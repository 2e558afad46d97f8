#include "sightline/apps/view/document.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "sightline/apps/common/tree_walk.h"
#include "sightline/core/snapshot.h"

namespace sightline::apps {
namespace {

constexpr std::size_t kMostSteps = 100;
// Blue and orange differ for all kinds of colour blindness.
constexpr core::vec3 kSelectedColour{0.20f, 0.55f, 1.0f};

std::uint8_t style_bits(std::uint8_t flags) {
  return flags & std::uint8_t(Document::kSelected | Document::kGhost);
}

engine::ItemStyle style_of(std::uint8_t flags, const BaseStyle* base_style) {
  engine::ItemStyle style = base_style ? base_style->style : engine::ItemStyle();
  if ((flags & Document::kSelected) != 0) {
    if (!style.colour) style.colour = kSelectedColour;
    style.outline = true;
    style.ghost = false;
  } else {
    style.ghost |= (flags & Document::kGhost) != 0;
  }
  return style;
}

bool unseen(core::ItemId item, std::uint8_t flags, const BaseStyles& base_styles) {
  const BaseStyle* base_style = base_styles.of(item);
  return (flags & Document::kHidden) != 0 || (base_style && !base_style->shown);
}

/// Whether each of `count` items is among these.
std::vector<bool> marked(std::span<const core::ItemId> items, std::size_t count) {
  std::vector<bool> marks(count);
  for (const core::ItemId item : items)
    if (to_index(item) < marks.size()) marks[to_index(item)] = true;
  return marks;
}

}  // namespace

Document::Document(const core::Scene& scene, engine::Engine& engine)
    : scene_(&scene), engine_(&engine), flags_(scene.item_slots()) {}

core::NodeId Document::node_of_selection() const {
  if (selection_.empty()) return {};
  std::vector<core::NodeId> above;  // of the first item: its node, then what that lies below
  for (core::NodeId at = scene_->node_of(selection_[0]); at.valid(); at = scene_->parent(at)) above.push_back(at);
  std::size_t lowest = 0;
  for (const core::ItemId item : selection_)
    for (core::NodeId at = scene_->node_of(item); at.valid(); at = scene_->parent(at))
      if (const auto found = std::find(above.begin() + std::ptrdiff_t(lowest), above.end(), at); found != above.end()) {
        lowest = std::size_t(found - above.begin());
        break;
      }
  return above[lowest];
}

core::NodeId Document::selected_part() const {
  if (!part_) {
    const core::NodeId node = node_of_selection();
    part_ = node.valid() && items_below(*scene_, node).size() == selection_.size() ? node : core::NodeId{};
  }
  return *part_;
}

core::Expected<void> Document::select_part() {
  core::NodeId node = node_of_selection();
  if (!node.valid()) return {};
  std::vector<core::ItemId> items = items_below(*scene_, node);
  while (items.size() <= selection_.size() && scene_->parent(node).valid()) {
    node = scene_->parent(node);
    items = items_below(*scene_, node);
  }
  return select(items);
}

std::vector<core::ItemId> Document::items_with(Flag flag) const {
  std::vector<core::ItemId> items;
  for (core::ItemId item{0}; to_index(item) < flags_.size(); ++item)
    if ((flags_[to_index(item)] & flag) != 0) items.push_back(item);
  return items;
}

core::AabbD Document::bounds(std::span<const core::ItemId> items) const {
  core::AabbD all;
  for (const core::ItemId item : items) all.grow(scene_->bounds_under(item, scene_->state(item).world_from_item));
  return all;
}

template <class FlagsOf>
Document::Changes Document::changes(const FlagsOf& flags_of) const {
  Changes list;
  const core::Snapshot& snapshot = engine_->snapshot();
  for (core::ItemId item{0}; to_index(item) < flags_.size(); ++item)
    if (const std::uint8_t flags = flags_of(item);
        flags != flags_[to_index(item)] && snapshot.slot(item) != core::kNone)
      list.push_back({item, flags});
  return list;
}

core::Expected<void> Document::select(std::span<const core::ItemId> items, SelectMode mode) {
  const std::vector<bool> named = marked(items, flags_.size());
  return step(changes([&](core::ItemId item) {
    const std::uint8_t flags = flags_[to_index(item)], without = flags & std::uint8_t(~kSelected);
    if (!named[to_index(item)]) return mode == SelectMode::kReplace ? without : flags;
    if (unseen(item, flags, base_styles_)) return without;
    if (mode == SelectMode::kToggle) return std::uint8_t(flags ^ kSelected);
    return std::uint8_t(flags | kSelected);
  }));
}

core::Expected<void> Document::mark(std::span<const core::ItemId> items, Marks of_these, Marks of_others) {
  const std::vector<bool> named = marked(items, flags_.size());
  return step(changes([&](core::ItemId item) {
    const Marks& marks = named[to_index(item)] ? of_these : of_others;
    return std::uint8_t((flags_[to_index(item)] | marks.set) & ~marks.clear);
  }));
}

core::Expected<void> Document::hide(std::span<const core::ItemId> items) {
  return mark(items, {kHidden, kSelected}, {});
}

core::Expected<void> Document::show(std::span<const core::ItemId> items) {
  return mark(items, {0, kHidden | kGhost}, {});
}

core::Expected<void> Document::isolate(std::span<const core::ItemId> items) {
  return mark(items, {0, kHidden | kGhost}, {kHidden, kSelected});
}

core::Expected<void> Document::ghost_others(std::span<const core::ItemId> items) {
  return mark(items, {0, kGhost}, {kGhost, kSelected});
}

core::Expected<void> Document::show_all() {
  return mark({}, {}, {0, kHidden | kGhost});
}

core::Expected<void> Document::set(std::span<const core::ItemId> hidden, std::span<const core::ItemId> ghosts,
                                   std::span<const core::ItemId> selected) {
  const std::vector<bool> hide = marked(hidden, flags_.size()), faint = marked(ghosts, flags_.size()),
                          select = marked(selected, flags_.size());
  return step(changes([&](core::ItemId item) {
    int flags = flags_[to_index(item)] & ~(kHidden | kGhost | kSelected);
    if (hide[to_index(item)]) flags |= kHidden;
    if (faint[to_index(item)]) flags |= kGhost;
    if (select[to_index(item)] && !hide[to_index(item)]) flags |= kSelected;
    return std::uint8_t(flags);
  }));
}

core::Expected<void> Document::step(Changes changes) {
  if (changes.empty()) return {};
  auto before = apply(changes);
  if (!before) return tl::unexpected(before.error());
  undone_.clear();
  done_.push_back(std::move(*before));
  if (done_.size() > kMostSteps) done_.erase(done_.begin());
  return {};
}

core::Expected<void> Document::undo() {
  return take(done_, undone_);
}

core::Expected<void> Document::redo() {
  return take(undone_, done_);
}

core::Expected<void> Document::take(std::vector<Changes>& from, std::vector<Changes>& to) {
  if (from.empty()) return {};
  auto before = apply(from.back());
  if (!before) return tl::unexpected(before.error());
  from.pop_back();
  to.push_back(std::move(*before));
  return {};
}

bool Document::shown(core::ItemId item) const {
  return to_index(item) < flags_.size() && !unseen(item, flags_[to_index(item)], base_styles_);
}

bool Document::left_out(core::ItemId item) const {
  return std::binary_search(left_out_.begin(), left_out_.end(), item);
}

core::Expected<void> Document::leave_out(std::vector<core::ItemId> items) {
  std::vector<core::ItemId> hide, show;
  std::set_difference(items.begin(), items.end(), left_out_.begin(), left_out_.end(), std::back_inserter(hide));
  std::set_difference(left_out_.begin(), left_out_.end(), items.begin(), items.end(), std::back_inserter(show));
  for (std::vector<core::ItemId>* list : {&hide, &show})
    std::erase_if(*list, [this](core::ItemId item) { return !shown(item); });
  core::Expected<void> done;
  if (!hide.empty()) done = engine_->hide(hide);
  if (done && !show.empty()) done = engine_->show(show);
  if (done) left_out_ = std::move(items);
  return done;
}

/// Lets the engine show these items with their new flags and base styles.
core::Expected<void> Document::show(const Changes& changes, const BaseStyles& base_styles) {
  constexpr std::size_t kStyles = 8;  // of each base style, by style bits
  std::vector<std::vector<core::ItemId>> styled(kStyles * (base_styles.all.size() + 1));
  std::vector<core::ItemId> hide, show;
  for (const auto& [item, flags] : changes) {
    const std::uint8_t old = flags_[to_index(item)];
    const BaseStyle* base_style = base_styles.of(item);
    if (style_of(flags, base_style) != style_of(old, base_styles_.of(item)))
      styled[style_bits(flags) + kStyles * (base_style ? base_styles.which[to_index(item)] : 0)].push_back(item);
    const bool unseen_now = unseen(item, flags, base_styles);
    if (unseen_now != unseen(item, old, base_styles_) && !left_out(item)) (unseen_now ? hide : show).push_back(item);
  }
  core::Expected<void> done;
  for (std::size_t i = 0; i < styled.size() && done; ++i)
    if (!styled[i].empty())
      done = engine_->set_override(
          styled[i], style_of(std::uint8_t(i % kStyles), i < kStyles ? nullptr : &base_styles.all[i / kStyles - 1]));
  if (done && !hide.empty()) done = engine_->hide(hide);
  if (done && !show.empty()) done = engine_->show(show);
  return done;
}

/// Returns what brings back the state before.
core::Expected<Document::Changes> Document::apply(const Changes& changes) {
  if (auto done = show(changes, base_styles_); !done) return tl::unexpected(done.error());
  Changes before;
  before.reserve(changes.size());
  bool selects = false, solids_change = false;
  for (const auto& [item, flags] : changes) {
    const BaseStyle* base_style = base_styles_.of(item);
    solids_change |= style_of(flags, base_style).ghost != style_of(flags_[to_index(item)], base_style).ghost;
    const int turned = flags ^ flags_[to_index(item)];
    before.push_back({item, flags_[to_index(item)]});
    selects |= (turned & kSelected) != 0;
    solids_change |= (turned & kHidden) != 0;
    if ((turned & kHidden) != 0) hidden_ += (flags & kHidden) != 0 ? 1 : std::size_t(-1);
    if ((turned & kGhost) != 0) ghosts_ += (flags & kGhost) != 0 ? 1 : std::size_t(-1);
    flags_[to_index(item)] = flags;
  }
  if (selects) list_selection();
  ++version_;
  if (solids_change) ++solid_version_;
  return before;
}

void Document::list_selection() {
  part_.reset();
  selection_ = items_with(kSelected);
}

core::Expected<void> Document::set_base_styles(BaseStyles base_styles) {
  Changes all;
  for (core::ItemId item{0}; to_index(item) < flags_.size(); ++item) {
    const BaseStyle *now = base_styles.of(item), *then = base_styles_.of(item);
    const bool same = now && then ? *now == *then : now == then;
    if (!same && engine_->snapshot().slot(item) != core::kNone) all.push_back({item, flags_[to_index(item)]});
  }
  if (auto done = show(all, base_styles); !done) return done;
  base_styles_ = std::move(base_styles);
  ++version_;
  ++solid_version_;
  return {};
}

void Document::follow_scene() {
  flags_.resize(scene_->item_slots());
  const auto gone = [&](core::ItemId item) { return !scene_->contains_item(item); };
  for (core::ItemId item{0}; to_index(item) < flags_.size(); ++item) {
    if (flags_[to_index(item)] == 0 || !gone(item)) continue;
    hidden_ -= (flags_[to_index(item)] & kHidden) != 0 ? 1 : 0;
    ghosts_ -= (flags_[to_index(item)] & kGhost) != 0 ? 1 : 0;
    flags_[to_index(item)] = 0;
  }
  for (std::vector<Changes>* steps : {&done_, &undone_}) {
    for (Changes& step : *steps) std::erase_if(step, [&](const Change& change) { return gone(change.item); });
    std::erase_if(*steps, [](const Changes& step) { return step.empty(); });
  }
  std::erase_if(left_out_, gone);
  if (hovered && std::any_of(hovered->items.begin(), hovered->items.end(), gone)) hovered.reset();
  list_selection();
  ++version_;
  ++solid_version_;
}

}  // namespace sightline::apps
