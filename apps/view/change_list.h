// What has changed since an older revision of the open model, as the viewer shows it: colours, a list, and the items
// that are no more. No window.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sightline/apps/common/item_facts.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/compare/compared.h"
#include "sightline/apps/view/document.h"

namespace sightline::apps {

/// Compares the file that `before` was read from with the same file of the open model: its only one, or the one of the
/// same name. Fails where there is none, and as compare_revisions() does.
core::Expected<Compared> compare_models(const Model& before, const Model& open,
                                        const std::function<bool(double)>& progress);

/// An attribute file of the open model has an older revision beside `file`: of its own name, or of the name of `file`.
/// Returns `file` and those that there are.
std::vector<std::string> older_files(const std::string& file, const std::vector<std::string>& open_files);

/// Tells an older file and the one of the open files that it was compared with apart: by their names, with their
/// folders where these are the same.
std::pair<std::string, std::string> names_apart(const std::string& older, const std::vector<std::string>& open_files);

class ChangeList {
 public:
  /// `found` tells what has become of `before` in the open scene.
  ChangeList(std::string file, Model before, Compared found);

  /// Copies the removed items, with the nodes above them, to below a node "removed (FILE)" of the open scene's root.
  /// They have the material of no item. Fails with nothing added.
  core::Expected<void> add_removed(core::Scene& scene);
  /// Takes them away again.
  void take_removed(core::Scene& scene);

  // Each revision as it was, side by side. Between these two calls unchanged items are not faint.
  /// Copies what the older revision had in place of items that moved or changed, to below "replaced (FILE)". Fails with
  /// nothing added. The removed items must be there.
  core::Expected<void> add_replaced(core::Scene& scene);
  void take_replaced(core::Scene& scene);
  /// Items of the scene that the other revision does not have, in rising order.
  std::vector<core::ItemId> only_in(Revision revision) const;

  const std::string& file() const { return file_; }
  const compare::Comparison& found() const { return compared_.found; }
  const core::Scene& before() const { return *before_.scene; }
  /// The bytes of a report in the format of an extension: .html, .csv, .json, .bcfzip or .bcf. `open`: the scene that
  /// was compared.
  core::Expected<std::string> report(const std::string& extension, core::Scene& open) const;

  bool shown(compare::State state) const { return shown_[std::size_t(state)]; }
  void set_shown(compare::State state, bool shown);
  BaseStyles base_styles() const;

  // The list: groups of equal changes (analysis/compare/groups.h) of states that are shown, those that are renamed with
  // the unchanged ones. An index must be below row_count().
  std::size_t row_count() const { return rows_.size(); }
  compare::State state(std::size_t row) const;
  /// Node and items of a row in the open scene, items in rising order.
  core::NodeId node(const core::Scene& scene, std::size_t row) const;
  std::vector<core::ItemId> items(const core::Scene& scene, std::size_t row) const;
  std::string name(std::size_t row) const;  ///< of the node
  /// "5,000 items moved by 1,000 mm along +x"
  const std::string& what(std::size_t row, const LengthFormat& lengths);

  std::optional<std::size_t> current() const { return current_; }
  void set_current(std::size_t row) { current_ = row; }
  /// The next row (1) or the one before (-1), from the end to the begin; none in an empty list. It becomes current.
  std::optional<std::size_t> step(int by);

  /// The change of an item of the open scene; null where it was not compared.
  const compare::Change* of(core::ItemId item) const;
  /// Facts and attributes that differ, where the item is in both revisions.
  std::vector<FactChange> differing_facts(const core::Scene& scene, core::ItemId item) const;

 private:
  std::size_t first_removed() const { return found().items.size() - found().count(compare::State::kRemoved); }
  const compare::Group& group(std::size_t row) const { return compared_.groups.all[rows_[row]]; }
  /// In the open scene: itself, or the copy.
  core::ItemId item_of(std::size_t change) const;
  void list();

  std::string file_;
  Model before_;
  Compared compared_;
  std::array<bool, compare::kStateCount> shown_;
  std::vector<std::uint32_t> rows_;       // indices of groups
  std::vector<std::string> words_;        // by group: what(), once it was asked for
  std::vector<std::uint32_t> change_of_;  // by item of the open scene
  std::optional<std::size_t> current_;
  /// Copies of items of the older scene, which lie below a node of the open one.
  struct Copies {
    core::NodeId node;                 // invalid: there are none
    std::vector<core::ItemId> items;   // in the order of the changes
    std::vector<core::MeshId> meshes;  // of these alone
  };
  core::Expected<Copies> copy(core::Scene& scene, const char* name, std::span<const std::uint32_t> changes);
  static void take(core::Scene& scene, Copies& copies);

  Copies removed_, replaced_;
  bool apart_ = false;  // between add_replaced() and take_replaced()
};

/// "added", "changed: shape, material; moved by 250 mm, turned by 12.0°; renamed", "unchanged", …
std::string describe(const compare::Change& change, const LengthFormat& lengths);

}  // namespace sightline::apps
