// What a comparison has found, and how it is said.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sightline/analysis/compare/groups.h"
#include "sightline/apps/common/item_facts.h"
#include "sightline/apps/common/numbers.h"
#include "sightline/core/aabb.h"

namespace sightline::apps {

struct Compared {
  std::string before_file, after_file;
  double tolerance;
  compare::Revision before, after;
  compare::Comparison found;
  compare::Groups groups;
  std::optional<LengthFormat> lengths = {};  ///< none: each length in the unit that suits it

  const compare::Change& item(const compare::Group& group, std::size_t i) const {
    return found.items[groups.members[group.begin + i]];
  }
};

/// Compares, and groups equal changes. Fails as compare::revisions() does.
core::Expected<Compared> compare_revisions(const compare::Revision& before, const compare::Revision& after,
                                           const compare::Options& options);

/// Whether a change is more than none: names count, too.
bool is_listed(const compare::Change& change);

/// "added", …, and "renamed" where nothing but names differs.
std::string_view state_name(const compare::Change& change);
std::string path_before(const Compared& compared, const compare::Change& change);
std::string path_after(const Compared& compared, const compare::Change& change);
/// Where the item is, or was if it is no more.
std::string path_of(const Compared& compared, const compare::Change& change);
core::Kind kind_of(const Compared& compared, const compare::Change& change);
/// "shape", "place", …: of bits of compare::Difference.
std::vector<std::string> names_of(std::uint8_t differences);

/// Dimensions, material and attributes that differ, of items that both revisions have.
std::vector<FactChange> facts_of(const Compared& compared, const compare::Change& change);
std::vector<FactChange> facts_of(const Compared& compared, const compare::NodeChange& change);

/// Members of a group by what is told of them: those of which the same is told are one row, with their number.
template <class Row>
struct Rows {
  std::vector<std::pair<Row, std::size_t>> rows;  ///< in the order of their first members
  std::size_t left_out = 0;                       ///< members, from where there would be more than `most` rows
};
template <class RowOf>
auto rows_of(const compare::Group& group, std::size_t most, const RowOf& row_of) {
  using Row = decltype(row_of(std::size_t{0}));
  Rows<Row> out;
  std::map<Row, std::size_t> known;  // index of the row
  for (std::size_t i = 0; i < group.size(); ++i) {
    const auto [place, fresh] = known.try_emplace(row_of(i), out.rows.size());
    if (fresh && out.rows.size() == most) {
      out.left_out = group.size() - i;
      break;
    }
    if (fresh) out.rows.emplace_back(place->first, 0);
    ++out.rows[place->second].second;
  }
  return out;
}

/// The state whose colour and switch groups of a way have: that of their items, or that of changed ones.
compare::State shown_as(compare::Way way);

enum class Revision { kNewer, kOlder };
/// Items of a revision that a group is about, in rising order: of nodes, those below them.
std::vector<core::ItemId> items_of(const Compared& compared, const compare::Group& group, Revision revision);
/// What an image of the group shows: the box of its items in that revision, or, where they moved by no more than its
/// diagonal, in both.
core::AabbD box_of(const Compared& compared, const compare::Group& group, Revision revision);
/// An image of the group is of this shape, and half filled by it, so that its surroundings tell where it is.
inline constexpr double kGroupAspect = 4.0 / 3.0, kGroupFilled = 0.5;

std::string path_of(const Compared& compared, const compare::Group& group);
/// The last name of that path.
std::string name_of(const Compared& compared, const compare::Group& group);
/// "5,000 items moved by 1.000 m along +x"
std::string what_of(const Compared& compared, const compare::Group& group);

}  // namespace sightline::apps
