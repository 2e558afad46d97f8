#include "sightline/analysis/query/colouring.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>
#include <utility>

#include "sightline/core/internal/ascii_case.h"

namespace sightline::query {
namespace {

using core::vec3;

constexpr vec3 colour(std::uint32_t rgb) {
  return vec3(float(rgb >> 16), float(rgb >> 8 & 0xff), float(rgb & 0xff)) / 255.0f;
}

const vec3 kMuted[] = {colour(0x332288), colour(0xddcc77), colour(0x117733), colour(0xcc6677), colour(0x88ccee),
                       colour(0x882255), colour(0x44aa99), colour(0x999933), colour(0xaa4499)};
const vec3 kOther = colour(0xc8c8c8), kWithout = colour(0xffffff);
const vec3 kViridis[] = {colour(0x440154), colour(0x443983), colour(0x31688e), colour(0x21918c),
                         colour(0x35b779), colour(0x90d743), colour(0xfde725)};
constexpr std::size_t kMostRanges = std::size(kViridis);

/// A place of viridis, 0 to 1.
vec3 viridis(double at) {
  const double place = at * double(kMostRanges - 1);
  const auto below = std::min(std::size_t(place), kMostRanges - 2);
  const auto share = float(place - double(below));
  return kViridis[below] * (1.0f - share) + kViridis[below + 1] * share;
}

/// Gives each value a group, and counts.
class Groups {
 public:
  Groups(const Values& values, std::string_view key) : values_(values), group_(values.all.size()) {
    made_.key = std::string(key);
  }

  std::uint8_t add(std::string label, const vec3& colour) {
    made_.groups.push_back({std::move(label), colour, 0});
    return std::uint8_t(made_.groups.size() - 1);
  }
  void put(std::uint32_t value, std::uint8_t group) {
    group_[value] = group;
    made_.groups[group].items += values_.all[value].items;
  }
  /// Values that have no colour of their own, in one group.
  void put_others(std::span<const std::uint32_t> values) {
    if (values.empty()) return;
    const std::size_t count = values.size();
    const std::uint8_t group =
        add(count == 1 ? values_.all[values[0]].text : std::to_string(count) + " other values", kOther);
    for (const std::uint32_t value : values) put(value, group);
  }

  Colouring finish(const core::Scene& scene) && {
    const std::uint8_t without = std::uint8_t(made_.groups.size());
    if (values_.without > 0) made_.groups.push_back({"no value", kWithout, values_.without});
    made_.of_item.assign(values_.of_item.size(), 255);
    for (std::size_t i = 0; i < made_.of_item.size(); ++i) {
      if (values_.of_item[i] != core::kNone)
        made_.of_item[i] = group_[values_.of_item[i]];
      else if (scene.contains_item(core::ItemId(i)))
        made_.of_item[i] = without;
    }
    return std::move(made_);
  }

 private:
  const Values& values_;
  std::vector<std::uint8_t> group_;  // by value
  Colouring made_;
};

struct Number {
  double number;
  std::uint32_t value;
};

/// Ends of ranges: values as the model has them, and sizes to four digits.
std::string label_of(const Number& number, const Values& values, std::string_view key) {
  if (key != "@size") return values.all[number.value].text;
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), number.number, std::chars_format::general, 4).ptr;
  return std::string(text.data(), end) + " m";
}

/// The first number of each range: of about equally many items where there are more numbers than ranges.
std::vector<std::size_t> range_begins(const Values& values, const std::vector<Number>& numbers) {
  std::vector<std::size_t> different;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (i == 0 || numbers[i].number != numbers[i - 1].number) different.push_back(i);
  if (different.size() <= kMostRanges) return different;
  std::uint64_t left = 0, taken = 0;
  for (const Number& one : numbers) left += values.all[one.value].items;
  std::vector<std::size_t> begins{0};
  for (std::size_t d = 0; d < different.size() && begins.size() < kMostRanges; ++d) {
    const std::size_t end = d + 1 < different.size() ? different[d + 1] : numbers.size();
    for (std::size_t i = different[d]; i < end; ++i) taken += values.all[numbers[i].value].items;
    const std::size_t ranges_left = kMostRanges - begins.size() + 1;
    if (end == numbers.size() || taken * ranges_left < left) continue;
    begins.push_back(end);
    left -= std::exchange(taken, 0);
  }
  return begins;
}

void put_numbers(const Values& values, std::vector<Number> numbers, std::string_view key, Groups& groups) {
  std::sort(numbers.begin(), numbers.end(), [](const Number& a, const Number& b) {
    return a.number != b.number ? a.number < b.number : a.value < b.value;
  });
  const std::vector<std::size_t> begins = range_begins(values, numbers);
  for (std::size_t r = 0; r < begins.size(); ++r) {
    const std::size_t end = r + 1 < begins.size() ? begins[r + 1] : numbers.size();
    const Number &low = numbers[begins[r]], &high = numbers[end - 1];
    std::string label = label_of(low, values, key);
    if (low.number != high.number) label += " – " + label_of(high, values, key);
    const std::uint8_t group =
        groups.add(std::move(label), viridis(begins.size() == 1 ? 0.5 : double(r) / double(begins.size() - 1)));
    for (std::size_t i = begins[r]; i < end; ++i) groups.put(numbers[i].value, group);
  }
}

}  // namespace

bool are_numbers(const Values& values) {
  std::uint64_t items = 0, with_number = 0;
  std::optional<double> first;
  bool several = false;
  for (const Values::Value& value : values.all) {
    items += value.items;
    const auto number = number_of(value.text);
    if (!number) continue;
    with_number += value.items;
    several = several || (first && *first != *number);
    if (!first) first = number;
  }
  return several && 20 * with_number >= 19 * items;
}

core::Expected<Colouring> colour_by(const core::Scene& scene, std::string_view wanted) {
  const auto values = values_of(scene, wanted);
  if (!values) return tl::unexpected(values.error());
  const std::string key = wanted.starts_with('@') ? core::lower_case(wanted) : std::string(wanted);
  Groups groups(*values, key);
  std::vector<std::uint32_t> others;
  if (are_numbers(*values)) {
    std::vector<Number> numbers;
    for (std::uint32_t i = 0; i < values->all.size(); ++i)
      if (const auto number = number_of(values->all[i].text))
        numbers.push_back({*number, i});
      else
        others.push_back(i);
    put_numbers(*values, std::move(numbers), key, groups);
  } else {
    for (std::uint32_t i = 0; i < values->all.size(); ++i)
      if (i < std::size(kMuted))
        groups.put(i, groups.add(values->all[i].text, kMuted[i]));
      else
        others.push_back(i);
  }
  groups.put_others(others);
  return std::move(groups).finish(scene);
}

}  // namespace sightline::query
