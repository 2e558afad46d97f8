// Lists against a loop over the set, for every instruction set of the machine.
#include "sightline/culling/frustum/internal/slot_list.h"

#include <random>

#include <gtest/gtest.h>

#include "sightline/tests/support/instruction_sets.h"

namespace sightline::culling::slot_list_test {
namespace {

std::vector<core::Slot> by_hand(const core::VisibleSet& set) {
  std::vector<core::Slot> slots;
  for (const core::SlotRange& range : set.ranges)
    for (std::uint32_t i = 0; i < range.count; ++i) slots.push_back(range.first + i);
  slots.insert(slots.end(), set.single_slots.begin(), set.single_slots.end());
  return slots;
}

std::uint32_t below(std::mt19937& random, std::uint32_t limit) {
  return std::uint32_t(random() % limit);
}

core::VisibleSet random_set(std::mt19937& random) {
  core::VisibleSet set;
  core::Slot next = below(random, 3);
  for (std::uint32_t i = below(random, 40); i > 0; --i) {
    const std::uint32_t count = 1 + below(random, i % 5 == 0 ? 2000 : 40);
    set.ranges.push_back({next, count});
    next += count + 1 + below(random, 50);
  }
  for (std::uint32_t i = below(random, 40); i > 0; --i) set.single_slots.push_back(next += 1 + below(random, 9));
  return set;
}

TEST(SlotList, ListsWhatTheSetHolds) {
  constexpr unsigned kSeed = 20261121;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  constexpr std::uint32_t kSentinel = 0xdeadbeef;
  tests::for_each_instruction_set([&] {
    std::mt19937 random(kSeed);
    for (int round = 0; round < 200; ++round) {
      const core::VisibleSet set = random_set(random);
      const std::vector<core::Slot> expected = by_hand(set);
      std::vector<std::uint32_t> list(expected.size() + 1, kSentinel), ids(100'000);
      list_slots(set, list);
      ASSERT_EQ(list.back(), kSentinel) << "wrote beyond the set";
      ASSERT_TRUE(std::equal(expected.begin(), expected.end(), list.begin()));
      for (std::uint32_t& id : ids) id = std::uint32_t(random());
      list_ids(set, ids, list);
      ASSERT_EQ(list.back(), kSentinel) << "wrote beyond the set";
      for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(list[i], ids[expected[i]]);
    }
  });
}

TEST(SlotList, AnEmptySetListsNothing) {
  list_slots({}, {});
  list_ids({}, {}, {});
}

}  // namespace
}  // namespace sightline::culling::slot_list_test
