// What the viewer measures: points snapped to features of items, and distances between two of them or of two items.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sightline/analysis/measure/distances.h"
#include "sightline/analysis/measure/item.h"
#include "sightline/analysis/measure/snap.h"
#include "sightline/apps/view/numbers.h"
#include "sightline/core/scene.h"

namespace sightline::apps {

/// An item of a scene as the measuring library takes it.
core::Expected<measure::Item> measured_item(const core::Scene& scene, core::ItemId item);

class Measuring {
 public:
  struct Mark {
    core::ItemId item;
    measure::Snap snap;
    std::vector<measure::Dimension> dimensions;  ///< of the item; none of meshes
  };
  using Row = std::pair<std::string, std::string>;  ///< what, and its value

  void clear();
  /// The next of two marks. A third one begins anew.
  core::Expected<void> add(const core::Scene& scene, core::ItemId item, const measure::Snap& snap);
  /// The shortest distance of two items, in place of marks.
  core::Expected<void> between(const core::Scene& scene, core::ItemId a, core::ItemId b);

  const std::vector<Mark>& marks() const { return marks_; }
  /// From the first mark's point to the second's, or the shortest one of two items.
  const std::optional<measure::Distance>& distance() const { return distance_; }
  /// Everything in words.
  std::vector<Row> rows(const LengthFormat& lengths = {}) const;

 private:
  std::vector<Mark> marks_;
  std::optional<measure::Distance> distance_;
  bool of_items_ = false;
};

}  // namespace sightline::apps
