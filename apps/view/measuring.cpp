#include "sightline/apps/view/measuring.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <variant>

namespace sightline::apps {
namespace {

std::string degrees(double radians) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4f°", glm::degrees(radians));
  return text;
}

/// The line that a mark is on, or else the axis of what it is on.
const measure::Segment* line_of(const measure::Snap& snap) {
  const auto* line = std::get_if<measure::Segment>(&snap.feature.geometry);
  return line ? line : snap.axis ? &*snap.axis : nullptr;
}

/// The angle of two features, or of their axes, and the distance of two lines.
void relation_rows(const measure::Snap& a, const measure::Snap& b, const LengthFormat& lengths,
                   std::vector<Measuring::Row>& rows) {
  const measure::Segment *first = line_of(a), *second = line_of(b);
  auto angle = measure::angle(a.feature.geometry, b.feature.geometry);
  if (!angle && first && second) angle = measure::angle(*first, *second);
  if (angle) rows.emplace_back("angle", degrees(*angle));
  if (!first || !second) return;
  const measure::AxisDistance axes = measure::axis_distance(*first, *second);
  rows.emplace_back(axes.parallel ? "between the axes" : "between the lines", lengths.text(axes.shortest.distance));
}

struct Boxed {
  core::AabbD box;
  core::ItemId item;
  std::optional<measure::Item> measured;

  Boxed(const core::Scene& scene, core::ItemId of)
      : box(scene.bounds_under(of, scene.state(of).world_from_item)), item(of) {}
  core::Expected<void> measure(const core::Scene& scene) {
    if (measured) return {};
    return measure::Item::create(scene, item).map([&](measure::Item&& made) { measured.emplace(std::move(made)); });
  }
};

std::vector<Boxed> boxed(const core::Scene& scene, std::span<const core::ItemId> items) {
  std::vector<Boxed> all;
  for (const core::ItemId item : items) all.emplace_back(scene, item);
  return all;
}

double gap(const core::AabbD& a, const core::AabbD& b) {
  return glm::length(glm::max(core::dvec3(0.0), glm::max(a.min - b.max, b.min - a.max)));
}

/// Passes over pairs whose boxes are no nearer than what was found.
core::Expected<measure::Distance> shortest_distance(const core::Scene& scene, std::span<const core::ItemId> a,
                                                    std::span<const core::ItemId> b) {
  std::vector<Boxed> first = boxed(scene, a), second = boxed(scene, b);
  core::AabbD around;
  for (const Boxed& one : second) around.grow(one.box);
  std::sort(first.begin(), first.end(),
            [&](const Boxed& x, const Boxed& y) { return gap(x.box, around) < gap(y.box, around); });
  std::optional<measure::Distance> shortest;
  double least = std::numeric_limits<double>::infinity();  // that it can be
  const auto matters = [&](const core::AabbD& x, const core::AabbD& y) {
    return !shortest || gap(x, y) < shortest->distance;
  };
  for (Boxed& one : first) {
    if (!matters(one.box, around)) break;
    for (Boxed& other : second) {
      if (!matters(one.box, other.box)) continue;
      for (Boxed* item : {&one, &other})
        if (auto done = item->measure(scene); !done) return tl::unexpected(done.error());
      const measure::Distance found = measure::distance(*one.measured, *other.measured);
      least = std::min(least, found.distance - found.error);
      if (!shortest || found.distance < shortest->distance) shortest = found;
    }
  }
  shortest->error = std::max(shortest->error, shortest->distance - least);
  return *shortest;
}

}  // namespace

std::string measurement_table(std::span<const Measurement> list, const core::dvec3& origin,
                              const LengthFormat& lengths) {
  const std::string unit = lengths.unit();
  std::string text = "no.\tdistance, " + unit;
  for (const char* column : {"along x", "along y", "along z", "from x", "from y", "from z", "to x", "to y", "to z"})
    text += std::string("\t") + column + ", " + unit;
  text += "\twhat\n";
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Measurement& one = list[i];
    text += std::to_string(i + 1) + "\t" + lengths.plain(one.distance());
    for (const core::dvec3& v : {one.to - one.from, one.from - origin, one.to - origin})
      for (int axis = 0; axis < 3; ++axis) text += "\t" + lengths.plain(v[axis]);
    text += "\t" + one.words + "\n";
  }
  return text;
}

void Measuring::clear() {
  list_.clear();
  forget_last();
}

void Measuring::merge(std::span<const Measurement> others) {
  for (const Measurement& other : others)
    if (std::find(list_.begin(), list_.end(), other) == list_.end()) list_.push_back(other);
}

void Measuring::drop_mark() {
  if (marks_.size() == 1) marks_.clear();
}

void Measuring::forget_last() {
  marks_.clear();
  distance_.reset();
  of_items_ = false;
}

void Measuring::add(core::ItemId item, const measure::Snap& snap) {
  if (of_items_ || marks_.size() == 2) forget_last();
  marks_.push_back({item, snap});
  if (marks_.size() < 2) return;
  const measure::Snap &first = marks_[0].snap, &second = marks_[1].snap;
  distance_ = measure::distance(first.point, second.point);
  list_.push_back({first.point, second.point, first.words + " to " + second.words});
}

core::Expected<void> Measuring::between(const core::Scene& scene, std::span<const core::ItemId> a,
                                        std::span<const core::ItemId> b) {
  constexpr std::size_t kMostPairs = 100'000'000;  // whose boxes are looked at in half a second
  if (a.size() > kMostPairs / b.size()) return core::fail("that is too much to measure: select smaller parts");
  const auto shortest = shortest_distance(scene, a, b);
  if (!shortest) return tl::unexpected(shortest.error());
  forget_last();
  distance_ = *shortest;
  of_items_ = true;
  list_.push_back(
      {distance_->from, distance_->to,
       a.size() == 1 && b.size() == 1 ? "shortest distance of two items" : "shortest distance of two parts"});
  return {};
}

std::vector<Measuring::Row> Measuring::rows(const LengthFormat& lengths) const {
  std::vector<Row> rows;
  for (const Mark& mark : marks_) {
    rows.emplace_back(&mark == &marks_[0] ? "first" : "second", mark.snap.words);
    rows.emplace_back("at", lengths.text(mark.snap.point));
    for (const measure::Dimension& dimension : mark.snap.dimensions)
      rows.emplace_back(dimension.name, dimension.angle ? degrees(dimension.value) : lengths.text(dimension.value));
  }
  if (!distance_) return rows;
  rows.emplace_back(of_items_ ? "shortest distance" : "distance",
                    distance_->touching ? "0, they touch" : lengths.text(distance_->distance));
  if (distance_->error > 1e-6) rows.emplace_back("less by at most", lengths.text(distance_->error));
  rows.emplace_back("elevation", lengths.text(distance_->rise()));
  rows.emplace_back("along x, y, z", lengths.text(distance_->to - distance_->from));
  if (marks_.size() == 2) relation_rows(marks_[0].snap, marks_[1].snap, lengths, rows);
  return rows;
}

}  // namespace sightline::apps
