// The viewer measures points snapped to features of items, and distances between two of them or of two parts.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sightline/analysis/measure/amounts.h"
#include "sightline/analysis/measure/distances.h"
#include "sightline/analysis/measure/item.h"
#include "sightline/analysis/measure/snap.h"
#include "sightline/apps/common/numbers.h"
#include "sightline/apps/viewpoints/viewpoint.h"
#include "sightline/core/scene.h"

namespace sightline::apps {

/// A line of text for each, with columns that spreadsheets take apart: number, distance, parts along x, y, z, both
/// points, words; the first line names them. `origin`: of the coordinates.
std::string measurement_table(std::span<const Measurement> list, const core::dvec3& origin,
                              const LengthFormat& lengths);

class Measuring {
 public:
  struct Mark {
    core::ItemId item;
    measure::Snap snap;
  };
  using Row = std::pair<std::string, std::string>;  ///< what, and its value

  void clear();  ///< with the list
  /// The next of two marks, or of three while angles are measured. One more begins anew.
  void add(core::ItemId item, const measure::Snap& snap);
  /// Whether a third mark gives the angle at the second one. Forgets marks where that changes.
  void set_angles(bool angles);
  bool angles() const { return angles_; }
  /// Areas and volumes of these items, in place of marks; and what they weigh at a density, kg a cubic metre.
  core::Expected<void> weigh(const core::Scene& scene, std::span<const core::ItemId> items, double density);
  /// The shortest distance of what is among these items to what is among those, in place of marks. Both have some.
  /// Fails where they make more than 100 million pairs.
  core::Expected<void> between(const core::Scene& scene, std::span<const core::ItemId> a,
                               std::span<const core::ItemId> b);

  const std::vector<Mark>& marks() const { return marks_; }
  /// From the first mark's point to the second's, or the shortest one of two parts.
  const std::optional<measure::Distance>& distance() const { return distance_; }
  /// All distances since clear(), but for those that were removed.
  const std::vector<Measurement>& list() const { return list_; }
  void remove(std::size_t index) { list_.erase(list_.begin() + std::ptrdiff_t(index)); }
  /// Adds those that are not in the list.
  void merge(std::span<const Measurement> others);
  /// Forgets marks that wait for a second one.
  void drop_mark();
  /// The last one in words.
  std::vector<Row> rows(const LengthFormat& lengths = {}) const;

 private:
  void forget_last();
  double angle() const;

  std::vector<Measurement> list_;
  std::vector<Mark> marks_;
  std::optional<measure::Distance> distance_;
  struct Weighed {
    measure::Amounts amounts;
    std::size_t items;
    double density;
  };
  std::optional<Weighed> weighed_;
  bool of_items_ = false, angles_ = false;
};

}  // namespace sightline::apps
