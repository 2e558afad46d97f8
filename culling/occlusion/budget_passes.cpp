#include "sightline/culling/occlusion/internal/budget_passes.h"

#include <algorithm>
#include <cmath>

#include "sightline/core/internal/clock.h"

namespace sightline::culling {
namespace {

constexpr int kLeastExponent = -8;                 // of the area of the smallest class
constexpr int kUnoccludedFirst = 4;                // classes by which items that were not occluded come earlier
constexpr std::size_t kTestedPiece = 2048;         // slots tested at a time
constexpr std::uint32_t kTestedAtOnce = 1u << 18;  // slots that the threads share out
constexpr std::size_t kMoreForeseen = 8;           // times as many items as those whose time was foreseen
constexpr double kForeseen = 1.5;                  // times as long as expected
constexpr double kSteady = 0.25;  // of a pass's own cost, which hardly changes; else estimates oscillate
constexpr double kGainUp = 1.0, kGainDown = 0.5;  // of an error: time that was too short does more harm
constexpr double kLeastMs = 1e-5;                 // of an item
constexpr double kGreatestChange = 4.0;           // of an estimate, by one pass
// First guess of what drawing takes, an item and a pixel, in milliseconds: llvmpipe's. A guess that is too large makes
// the first frames of a budget draw less, one that is too small makes them late.
constexpr double kPresumedItemMs = 1e-2, kPresumedPixelMs = 5e-6;

}  // namespace

int DrawCosts::class_of(float area) {
  if (!(area > 0.0f)) return 0;
  if (std::isinf(area)) return kClasses - 1;
  return std::clamp(std::ilogb(area) - kLeastExponent, 0, kClasses - 1);
}

/// At first what is presumed, with 640 x 360 pixels an item at most. A GPU, for which that is far too much, draws
/// little in its first passes, and all classes follow what these took.
DrawCosts::DrawCosts() {
  for (int c = 0; c < kClasses; ++c)
    ms_[std::size_t(c)] = kPresumedItemMs + kPresumedPixelMs * std::min(std::ldexp(1.0, c + kLeastExponent), 230'400.0);
}

/// Each class takes the blame for the error in proportion to its share of the time that was expected, so much that the
/// same pass would be expected to take as long as it took, or half of the way to that. A class that no pass has had
/// follows the others: the device is as much faster or slower for it.
double DrawCosts::took(const std::array<std::uint32_t, kClasses>& counts, double ms) {
  double expected = pass_ms_;
  for (std::size_t c = 0; c < std::size_t(kClasses); ++c) expected += counts[c] * ms_[c];
  const double ratio = std::clamp(ms / expected, 1.0 / kGreatestChange, kGreatestChange);
  const double gain = ratio > 1.0 ? kGainUp : kGainDown, of_pass = kSteady * pass_ms_ / expected;
  const auto share = [&](std::size_t c) { return counts[c] * ms_[c] / expected; };
  double squares = of_pass * pass_ms_ / expected;
  for (std::size_t c = 0; c < std::size_t(kClasses); ++c) squares += share(c) * share(c);
  for (std::size_t c = 0; c < std::size_t(kClasses); ++c) {
    measured_[c] = measured_[c] || counts[c] > 0;
    ms_[c] *= std::pow(ratio, gain * (measured_[c] ? share(c) / squares : 1.0));
    ms_[c] = std::max(ms_[c], kLeastMs);
  }
  pass_ms_ *= std::pow(ratio, gain * of_pass / squares);
  return ms / expected;
}

void BudgetPasses::begin(const ContributionTest& measure, const core::ItemBounds& bounds,
                         const core::VisibleSet& candidates, SlotBits lines) {
  begin_frame(candidates.generation, lines);
  measure.areas(bounds, candidates, areas_);
  order_areas();
}

void BudgetPasses::begin_shown(const ContributionTest& measure, const core::ItemBounds& bounds,
                               const core::VisibleSet& shown, const core::VisibleSet& others, SlotBits lines) {
  begin_frame(shown.generation, lines);
  unoccluded_.clear();
  measure.areas(bounds, shown, areas_);
  order_areas();
  others_.split(others, kTestedAtOnce);
  shown_first_ = true;
}

void BudgetPasses::begin_frame(std::uint64_t generation, SlotBits lines) {
  lines_ = lines;
  drawn_.clear();
  others_.split({});
  shown_first_ = false;
  drawn_.generation = pass_.generation = piece_.generation = generation;
  at_ = 0;
  others_at_ = 0;
  left_.fill(0);
  drawn_ms_ = looked_at_ms_ = 0.0;
}

/// Orders what is measured, the largest first.
void BudgetPasses::order_areas() {
  constexpr int kRanks = DrawCosts::kClasses + kUnoccludedFirst;
  const auto rank_of = [&](const SlotArea& a) {  // 0 comes first
    if (contains(lines_, a.slot)) return 0;
    return kRanks - 1 - (DrawCosts::class_of(a.area) + (contains(unoccluded_, a.slot) ? kUnoccludedFirst : 0));
  };
  std::array<std::size_t, kRanks + 1> begins{};
  for (const SlotArea& a : areas_) {
    ++begins[std::size_t(rank_of(a)) + 1];
    ++left_[std::size_t(DrawCosts::class_of(a.area))];
  }
  for (std::size_t i = 1; i < begins.size(); ++i) begins[i] += begins[i - 1];
  order_.resize(areas_.size());
  for (const SlotArea& a : areas_) order_[begins[std::size_t(rank_of(a))]++] = a;
}

void BudgetPasses::test_others(const ContributionTest& measure, const OcclusionTest* test,
                               const core::ItemBounds& bounds, const Hierarchy* hierarchy, core::ThreadPool& threads,
                               double deadline) {
  do {
    const core::VisibleSet& part = others_[others_at_++];
    if (test) test->filter(bounds, part, unoccluded_piece_, lines_, &threads, hierarchy);
    measure.areas(bounds, test ? unoccluded_piece_ : part, areas_);
    for (const SlotArea& a : areas_) ++left_[std::size_t(DrawCosts::class_of(a.area))];
    order_.insert(order_.end(), areas_.begin(), areas_.end());
  } while (others_at_ < others_.count() && core::now_seconds() < deadline);
}

std::size_t BudgetPasses::pending() const {
  std::size_t slots = order_.size() - at_;
  for (std::uint32_t part = others_at_; part < others_.count(); ++part) slots += std::size_t(others_[part].count());
  return slots;
}

bool BudgetPasses::next(const OcclusionTest* test, const core::ItemBounds& bounds, double ms) {
  pass_.single_slots.clear();
  counts_.fill(0);
  double left = ms - costs_.pass_ms();
  if (shown_first_) test = nullptr;  // it is shown, or has been tested
  const std::size_t begin = at_;
  const std::size_t most = shown_first_ ? foreseen_ : order_.size();  // other passes may each wait for a read-back
  while (at_ < order_.size() && pass_.single_slots.size() < most) {
    const std::size_t end = affordable(left, most - pass_.single_slots.size());
    if (end == at_) break;
    left -= take(end, test, bounds);
  }
  // A frame must come on, however short the time.
  while ((pass_.single_slots.empty() || at_ < begin + kFewest) && at_ < order_.size())
    take(std::min(order_.size(), at_ + kFewest), test, bounds);
  std::sort(pass_.single_slots.begin(), pass_.single_slots.end());
  drawn_.single_slots.insert(drawn_.single_slots.end(), pass_.single_slots.begin(), pass_.single_slots.end());
  return !pass_.single_slots.empty();
}

/// Larger passes than those whose time was foreseen might miss theirs by a multiple.
void BudgetPasses::took(double ms) {
  const std::size_t items = pass_.single_slots.size();
  if (costs_.took(counts_, ms) <= kForeseen)
    foreseen_ = std::max(foreseen_, kMoreForeseen * items);
  else
    foreseen_ = std::max(kFewest, items);
}

/// The end of the next piece that costs no more than that if none of it is hidden.
std::size_t BudgetPasses::affordable(double ms, std::size_t count) const {
  const std::size_t most = std::min(order_.size(), at_ + std::min(kTestedPiece, count));
  std::size_t end = at_;
  while (end < most && (ms -= costs_.ms(DrawCosts::class_of(order_[end].area))) >= 0.0) ++end;
  return end;
}

/// Adds what is open of the candidates up to `end` to the pass; returns what drawing it costs.
double BudgetPasses::take(std::size_t end, const OcclusionTest* test, const core::ItemBounds& bounds) {
  piece_.single_slots.clear();
  for (std::size_t i = at_; i < end; ++i) piece_.single_slots.push_back(order_[i].slot);
  if (test)
    test->filter(bounds, piece_, unoccluded_piece_, lines_);  // keeps their order
  else
    std::swap(piece_, unoccluded_piece_);
  double ms = 0.0;
  auto unoccluded = unoccluded_piece_.single_slots.begin();
  for (std::size_t i = at_; i < end; ++i) {
    const int size_class = DrawCosts::class_of(order_[i].area);
    --left_[std::size_t(size_class)];
    looked_at_ms_ += costs_.ms(size_class);
    if (unoccluded == unoccluded_piece_.single_slots.end() || *unoccluded != order_[i].slot) continue;
    ++unoccluded;
    ++counts_[std::size_t(size_class)];
    ms += costs_.ms(size_class);
  }
  pass_.single_slots.insert(pass_.single_slots.end(), unoccluded_piece_.single_slots.begin(),
                            unoccluded_piece_.single_slots.end());
  at_ = end;
  drawn_ms_ += ms;
  return ms;
}

void BudgetPasses::looked_at(std::size_t slots, std::vector<std::uint64_t>& bits) const {
  bits.assign(bit_words(slots), 0);
  for (std::uint32_t part = 0; part < others_at_; ++part) set_bits(others_[part], bits);
  const auto bit_of = [](const SlotArea& a) { return std::uint64_t(1) << a.slot % 64; };
  if (others_at_ > 0)  // of what was tested, the open ones may wait
    for (std::size_t i = at_; i < order_.size(); ++i) bits[order_[i].slot / 64] &= ~bit_of(order_[i]);
  for (std::size_t i = 0; i < at_; ++i) bits[order_[i].slot / 64] |= bit_of(order_[i]);
  for (std::size_t word = 0; word < std::min(lines_.size(), bits.size()); ++word) bits[word] |= lines_[word];
}

double BudgetPasses::most_pending_ms() const {
  double ms = 0.0;
  for (int c = 0; c < DrawCosts::kClasses; ++c) ms += left_[std::size_t(c)] * costs_.ms(c);
  return ms;
}

double BudgetPasses::pending_ms() const {
  const double ms = most_pending_ms();
  return looked_at_ms_ > 0.0 ? ms * drawn_ms_ / looked_at_ms_ : ms;
}

void BudgetPasses::remember(const OcclusionTest& test, const core::ItemBounds& bounds, core::ThreadPool* threads) {
  if (shown_first_) return;
  test.filter(bounds, drawn_, unoccluded_piece_, lines_, threads);
  unoccluded_.assign(bit_words(bounds.size()), 0);
  set_bits(unoccluded_piece_, unoccluded_);
}

void BudgetPasses::reset() {
  unoccluded_.clear();
  order_.clear();
  begin_frame(0, {});
}

}  // namespace sightline::culling
