#include "sightline/apps/view/measuring.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>
#include <variant>

#include "sightline/apps/common/svg_canvas.h"

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

/// "1.234 m²", "567 mm²", "8.9 ft³": an amount in square or cubic metres, `small` of which are told in millimetres.
std::string amount_text(double amount, bool cubic, bool small, Units units) {
  const char* const power = cubic ? "³" : "²";
  const auto text = [&](double value, const char* unit) { return short_number(value, 6) + " " + unit + power; };
  if (units == Units::kFeet) return text(amount / std::pow(0.3048, cubic ? 3 : 2), "ft");
  return small ? text(amount * (cubic ? 1e9 : 1e6), "mm") : text(amount, "m");
}

void weight_rows(const measure::Amounts& amounts, std::size_t items, double density, Units units,
                 std::vector<Measuring::Row>& rows) {
  rows.emplace_back("items", grouped(std::int64_t(items)));
  constexpr double kSmallArea = 0.1, kSmallVolume = 1e-3;
  const bool small = amounts.area < kSmallArea && amounts.volume < kSmallVolume;
  rows.emplace_back("area", amount_text(amounts.area, false, small, units));
  rows.emplace_back("volume", amount_text(amounts.volume, true, small, units));
  rows.emplace_back("mass at " + short_number(density, 6) + " kg/m³",
                    short_number(amounts.volume * density, 6) + " kg");
  constexpr double kExact = 1e-6;
  if (!(amounts.area_error <= kExact * amounts.area))
    rows.emplace_back("area, off by at most", amount_text(amounts.area_error, false, small, units));
  if (!(amounts.volume_error <= kExact * amounts.volume))
    rows.emplace_back("volume, off by at most", amount_text(amounts.volume_error, true, small, units));
  if (amounts.open > 0) rows.emplace_back("without volume", grouped(std::int64_t(amounts.open)) + " open or flat");
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
  weighed_.reset();
  of_items_ = false;
}

void Measuring::set_angles(bool angles) {
  if (std::exchange(angles_, angles) != angles) forget_last();
}

void Measuring::add(core::ItemId item, const measure::Snap& snap) {
  if (of_items_ || weighed_ || marks_.size() == (angles_ ? 3u : 2u)) forget_last();
  marks_.push_back({item, snap});
  if (marks_.size() == 3)
    list_.push_back({marks_[1].snap.point, marks_[2].snap.point, "the other leg, at " + degrees(angle())});
  if (marks_.size() != 2) return;
  const measure::Snap &first = marks_[0].snap, &second = marks_[1].snap;
  distance_ = measure::distance(first.point, second.point);
  list_.push_back({first.point, second.point, first.words + " to " + second.words});
}

/// At the second of three marks; exact for small ones, too.
double Measuring::angle() const {
  const core::dvec3 &at = marks_[1].snap.point, a = marks_[0].snap.point - at, b = marks_[2].snap.point - at;
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

core::Expected<void> Measuring::weigh(const core::Scene& scene, std::span<const core::ItemId> items, double density) {
  const auto amounts = measure::amounts(scene, items);
  if (!amounts) return tl::unexpected(amounts.error());
  forget_last();
  weighed_ = {*amounts, items.size(), density};
  return {};
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
  constexpr const char* kOrdinals[] = {"first", "second", "third"};
  std::vector<Row> rows;
  for (const Mark& mark : marks_) {
    rows.emplace_back(kOrdinals[&mark - marks_.data()], mark.snap.words);
    rows.emplace_back("at", lengths.text(mark.snap.point));
    for (const measure::Dimension& dimension : mark.snap.dimensions)
      rows.emplace_back(dimension.name, dimension.angle ? degrees(dimension.value) : lengths.text(dimension.value));
  }
  if (weighed_) weight_rows(weighed_->amounts, weighed_->items, weighed_->density, lengths.units, rows);
  if (!distance_) return rows;
  rows.emplace_back(of_items_ ? "shortest distance" : "distance",
                    distance_->touching ? "0, they touch" : lengths.text(distance_->distance));
  if (distance_->error > 1e-6) rows.emplace_back("less by at most", lengths.text(distance_->error));
  rows.emplace_back("elevation", lengths.text(distance_->rise()));
  rows.emplace_back("along x, y, z", lengths.text(distance_->to - distance_->from));
  if (marks_.size() == 2) relation_rows(marks_[0].snap, marks_[1].snap, lengths, rows);
  if (marks_.size() == 3) rows.emplace_back("angle at the second", degrees(angle()));
  return rows;
}

}  // namespace sightline::apps
