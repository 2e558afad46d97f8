// Functions of Engine about what this engine alone shows otherwise than the scene says: styles and hidden items.
#include <algorithm>

#include "sightline/core/internal/sort_unique.h"
#include "sightline/engine/internal/engine_state.h"

namespace sightline::engine {

core::Expected<void> known(const EngineState& s, const char* call, std::span<const core::ItemId> items) {
  for (const core::ItemId item : items)
    if (s.live.snapshot->slot(item) == core::kNone)
      return core::fail("engine: " + std::string(call) + ": no item " + std::to_string(to_index(item)) +
                        " as of the last commit");
  return {};
}

namespace {

/// Lets `edit` change the overrides and the snapshot, and everything follow that depends on them.
template <class Edit>
core::Expected<void> override_items(EngineState& s, const Edit& edit) {
  s.new_tracer.interrupt(s.live);
  Overrides::Change change;
  core::SceneDelta edited;
  const auto apply = [&] {
    change = edit(*s.live.snapshot);
    if (s.rebuild)
      for (const core::Slot slot : change.touched) edited.changed.push_back(s.live.snapshot->item(slot));
  };
  s.rebuild ? s.rebuild->edit(edited, apply) : apply();
  if (!change.touched.empty()) s.live.follow_overrides(change.uncovered, change.boxes, change.touched);
  s.new_tracer.follow(s.live);
  if (change.touched.empty()) return {};
  if (s.hybrid && change.boxes) s.hybrid->scene_changed(s.live.snapshot->size());
  follow_in_incoming(s, edited, change.materials);
  if (s.next_backend) s.next_backend->follow_later(change.touched, change.materials);
  if (!s.backend->ready()) return {};
  const auto kept = s.keep_state();
  return update_backend(s, [&] {
    return s.backend->update(Backend::Edit::kStyles, *s.live.snapshot, s.live.joints, change.touched, change.materials,
                             core::kNoDeadline);
  });
}

}  // namespace

core::Expected<void> Engine::set_override(std::span<const core::ItemId> items, const ItemStyle& style) {
  const auto in_range = [](float value) { return value >= 0.0f && value <= 1.0f; };
  if (!in_range(style.alpha)) return core::fail("engine: set_override: alpha must be within 0 and 1");
  if (style.colour && !(in_range(style.colour->r) && in_range(style.colour->g) && in_range(style.colour->b)))
    return core::fail("engine: set_override: colour must be within 0 and 1");
  if (auto good = known(*state_, "set_override", items); !good) return good;
  return override_items(*state_, [&](auto& snapshot) { return state_->overrides.set(snapshot, items, style); });
}

core::Expected<void> Engine::clear_override(std::span<const core::ItemId> items) {
  if (auto good = known(*state_, "clear_override", items); !good) return good;
  return override_items(*state_, [&](auto& snapshot) { return state_->overrides.clear(snapshot, items); });
}

core::Expected<void> Engine::clear_overrides() {
  return override_items(*state_, [&](auto& snapshot) { return state_->overrides.clear_all(snapshot); });
}

core::Expected<void> Engine::hide(std::span<const core::ItemId> items) {
  if (auto good = known(*state_, "hide", items); !good) return good;
  return override_items(*state_, [&](auto& snapshot) { return state_->overrides.hide(snapshot, items); });
}

core::Expected<void> Engine::show(std::span<const core::ItemId> items) {
  if (auto good = known(*state_, "show", items); !good) return good;
  return override_items(*state_, [&](auto& snapshot) { return state_->overrides.show(snapshot, items); });
}

core::Expected<void> Engine::show_all() {
  return override_items(*state_, [&](auto& snapshot) { return state_->overrides.show_all(snapshot); });
}

core::Expected<void> Engine::isolate(std::span<const core::NodeId> nodes) {
  const auto inside = items_below(nodes);
  if (!inside) return tl::unexpected(inside.error());
  std::vector<bool> below(state_->scene->item_slots());
  for (const core::ItemId item : *inside) below[to_index(item)] = true;
  std::vector<core::ItemId> outside;
  for (core::Slot slot = 0; slot < snapshot().size(); ++slot) {
    const core::ItemId item = snapshot().item(slot);
    if (item != core::kNoItem && !below[to_index(item)]) outside.push_back(item);
  }
  if (auto done = show(*inside); !done) return done;
  return hide(outside);
}

std::optional<ItemStyle> Engine::override_of(core::ItemId item) const {
  return state_->overrides.style(item);
}
std::vector<core::ItemId> Engine::overridden_items() const {
  return state_->overrides.styled_items();
}
bool Engine::is_hidden(core::ItemId item) const {
  return state_->overrides.is_hidden(item);
}
std::vector<core::ItemId> Engine::hidden_items() const {
  return state_->overrides.hidden_items();
}

core::Expected<std::vector<core::ItemId>> Engine::items_below(std::span<const core::NodeId> nodes) const {
  const core::Scene& scene = *state_->scene;
  std::vector<core::ItemId> items;
  for (const core::NodeId top : nodes) {
    if (!scene.contains(top))
      return core::fail("engine: no node " + std::to_string(top.index) + " of generation " +
                        std::to_string(top.generation));
    scene.for_each_node(top, [&](core::NodeId node, const auto&...) {
      for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item))
        if (snapshot().slot(item) != core::kNone) items.push_back(item);
    });
  }
  core::sort_unique(items);
  return items;
}

}  // namespace sightline::engine
