// What the user has selected, hidden and made faint in a model, with undo. No window, no GL of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sightline/apps/view/selection_level.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"
#include "sightline/engine/engine.h"

namespace sightline::apps {

enum class SelectMode { kReplace, kAdd, kToggle };

/// How items look that nobody has selected, hidden or made faint.
struct BaseStyle {
  engine::ItemStyle style;
  bool shown = true;  ///< false: as if hidden

  friend bool operator==(const BaseStyle&, const BaseStyle&) = default;
};

/// A base style for each item.
struct BaseStyles {
  std::vector<BaseStyle> all;       ///< at most 255
  std::vector<std::uint8_t> which;  ///< by item: 0 is the scene's own style, i is all[i - 1]; 0 for items beyond

  const BaseStyle* of(core::ItemId item) const {
    return to_index(item) < which.size() && which[to_index(item)] != 0 ? &all[which[to_index(item)] - 1u] : nullptr;
  }
};

/// Shows the state of items as overrides of an engine, which are nobody else's.
class Document {
 public:
  enum Flag : std::uint8_t { kSelected = 1, kHidden = 2, kGhost = 4 };

  /// Both are borrowed; whoever edits the scene calls follow_scene().
  Document(const core::Scene& scene, engine::Engine& engine);

  bool is(core::ItemId item, Flag flag) const {
    return to_index(item) < flags_.size() && (flags_[to_index(item)] & flag) != 0;
  }
  /// Neither hidden nor without a base style that shows.
  bool shown(core::ItemId item) const;
  std::span<const core::ItemId> selection() const { return selection_; }  ///< in rising order
  std::size_t hidden() const { return hidden_; }                          ///< number of hidden items
  std::size_t ghosts() const { return ghosts_; }                          ///< number of faint items
  std::vector<core::ItemId> items_with(Flag flag) const;                  ///< in rising order
  /// The lowest node that all selected items lie below; invalid without a selection.
  core::NodeId node_of_selection() const;
  /// That node, if nothing else lies below it; else invalid. Found once for a selection.
  core::NodeId selected_part() const;
  /// Selects all that lies below the node or, where that is selected, below the next node above that has more.
  core::Expected<void> select_part();
  /// Bounds of items in the world.
  core::AabbD bounds(std::span<const core::ItemId> items) const;

  // Each of these is one step of undo(), unless it changes nothing. They fail as Engine::set_override() does. Items
  // that cannot be seen are not selected.
  core::Expected<void> select(std::span<const core::ItemId> items, SelectMode mode = SelectMode::kReplace);
  core::Expected<void> hide(std::span<const core::ItemId> items);     ///< hidden items are not selected
  core::Expected<void> show(std::span<const core::ItemId> items);     ///< neither hidden nor faint
  core::Expected<void> isolate(std::span<const core::ItemId> items);  ///< hides all others
  core::Expected<void> ghost_others(std::span<const core::ItemId> items);
  core::Expected<void> show_all();  ///< without ghosts
  /// These are hidden, faint and selected, and no others. Hidden items are not selected.
  core::Expected<void> set(std::span<const core::ItemId> hidden, std::span<const core::ItemId> ghosts,
                           std::span<const core::ItemId> selected);

  core::Expected<void> undo();  ///< nothing where there is nothing to undo
  core::Expected<void> redo();
  std::size_t undo_steps() const { return done_.size(); }
  std::size_t redo_steps() const { return undone_.size(); }

  /// A click would take this. It is neither a step of undo() nor part of the image, which need not be drawn anew for
  /// it.
  std::optional<Taken> hovered;

  /// Shows items in these base styles, and no others. A selected item keeps the colour that its base style gives it and
  /// has a line around it. No step of undo().
  core::Expected<void> set_base_styles(BaseStyles base_styles);
  /// The engine leaves these out for now, in rising order, whatever else is true of them, and no others: for images of
  /// what only some of the items are in. They may be selected. Neither a step of undo() nor another version(). Takes
  /// time in proportion to these items and those before.
  core::Expected<void> leave_out(std::vector<core::ItemId> items);
  bool left_out(core::ItemId item) const;
  /// Takes notice of items that were added and removed, once the engine has. What undo() brings back of those that are
  /// gone is forgotten.
  void follow_scene();

  /// Rises whenever the image changes.
  std::uint64_t version() const { return version_; }
  /// Rises whenever other items hide something in the image: with those that are hidden or faint.
  std::uint64_t solid_version() const { return solid_version_; }

 private:
  struct Change {
    core::ItemId item;
    std::uint8_t flags;
  };
  using Changes = std::vector<Change>;

  /// Flags of all items as `flags_of` says.
  template <class FlagsOf>
  Changes changes(const FlagsOf& flags_of) const;
  core::Expected<void> show(const Changes& changes, const BaseStyles& base_styles);
  void list_selection();
  struct Marks {
    int set = 0, clear = 0;  // flags
  };
  core::Expected<void> mark(std::span<const core::ItemId> items, Marks of_these, Marks of_others);
  core::Expected<void> step(Changes changes);
  core::Expected<Changes> apply(const Changes& changes);
  core::Expected<void> take(std::vector<Changes>& from, std::vector<Changes>& to);

  const core::Scene* scene_;
  engine::Engine* engine_;
  std::vector<std::uint8_t> flags_;  // by item
  BaseStyles base_styles_;
  std::vector<core::ItemId> left_out_;
  std::vector<core::ItemId> selection_;
  mutable std::optional<core::NodeId> part_;  // selected_part(), once it was asked for
  std::size_t hidden_ = 0, ghosts_ = 0;
  std::vector<Changes> done_, undone_;  // what brings back the state before, the last one last
  std::uint64_t version_ = 0, solid_version_ = 0;
};

}  // namespace sightline::apps
