// Damaged and malicious RVM files: no crash, no hang, no memory beyond the stated multiple, and what is imported can be
// committed. Run under -fsanitize=address,undefined this also shows that no read leaves the buffer.
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/tests/importers/hostile.h"
#include "sightline/tests/importers/rvm_bytes.h"

namespace sightline::importers::rvm_hostile_test {
namespace {

using Bytes = std::vector<std::byte>;

/// True when the import succeeded.
bool survives(std::span<const std::byte> content, bool lenient, double* factor = nullptr) {
  const auto read = [&](std::span<const std::byte> bytes, core::Scene& scene, core::NodeId parent) {
    return read_rvm(bytes, "hostile.rvm", scene, parent, {.lenient = lenient});
  };
  return tests::survives(content, read, kRvmMemoryFactor, kRvmMemoryConstant, factor);
}

TEST(RvmHostile, EveryTruncation) {
  const Bytes whole = tests::small_rvm();
  std::size_t content = whole.size();
  while (whole[content - 1] == std::byte{0}) --content;  // the last byte of END: is not zero
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    SCOPED_TRACE(testing::Message() << "truncated to " << size);
    const std::span<const std::byte> part(whole.data(), size);
    // END: counts as read once its header is whole; its version word is not needed.
    ASSERT_EQ(survives(part, false), size + 4 >= content);
    survives(part, true);
  }
}

std::uint32_t interesting_word(std::mt19937& random) {
  constexpr std::uint32_t kWords[] = {0,          1,          0xffffffff, 0x7fffffff, 0x80000000, 0x7f800000,
                                      0x7fc00000, 0xff800000, 0x7f7fffff, 0x00000001, 0x3fffffff, 0x10000000,
                                      100,        24,         11,         12,         0x7149f2ca, 0x80000001};
  return random() % 4 == 0 ? std::uint32_t(random()) : kWords[random() % std::size(kWords)];
}

Bytes mutated(Bytes bytes, std::mt19937& random) {
  const int times = 1 + int(random() % 3);
  for (int t = 0; t < times; ++t) {
    if (random() % 2) {
      const int flips = 1 + int(random() % 8);
      for (int f = 0; f < flips; ++f) bytes[random() % bytes.size()] ^= std::byte(1u << (random() % 8));
    } else {
      const std::uint32_t word = interesting_word(random);
      const std::size_t at = random() % (bytes.size() / 4) * 4;
      for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = std::byte(word >> (24 - 8 * i) & 0xff);
    }
  }
  return bytes;
}

TEST(RvmHostile, RandomMutations) {
  Bytes whole = tests::small_rvm();
  while (whole.back() == std::byte{0}) whole.pop_back();  // mutating padding tests nothing
  int strict = 0, lenient = 0;
  for (unsigned seed = 0; seed < 100000; ++seed) {
    std::mt19937 random(seed);
    const Bytes bytes = mutated(whole, random);
    strict += survives(bytes, false);
    lenient += survives(bytes, true);
    ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed;
  }
  EXPECT_GT(lenient, strict);
  RecordProperty("strict_imports", strict);
  RecordProperty("lenient_imports", lenient);
}

TEST(RvmHostile, AbsurdCounts) {
  for (const std::uint32_t count : {0xffffffffu, 0x7fffffffu, 0x40000000u, 0x00ffffffu, 1000u}) {
    tests::RvmBytes facets, contours, vertices, name, info;
    facets.head().group("g", 1).item(11).u32(count).end().group_end().finish();
    contours.head().group("g", 1).item(11).u32(1).u32(count).end().group_end().finish();
    vertices.head().group("g", 1).item(11).u32(1).u32(1).u32(count).floats({1, 2, 3}).end().group_end().finish();
    name.head().begin("CNTB").u32(2).u32(count).end().group_end().finish();
    info.begin("HEAD").u32(2).u32(count).end().finish();
    for (const Bytes* bytes : {&facets.bytes, &contours.bytes, &vertices.bytes, &name.bytes}) {
      EXPECT_FALSE(survives(*bytes, false)) << count;
      EXPECT_TRUE(survives(*bytes, true)) << count;
    }
    EXPECT_FALSE(survives(info.bytes, true)) << count;
  }
}

TEST(RvmHostile, DeepNesting) {
  tests::RvmBytes b;
  b.head();
  for (int i = 0; i < 10000; ++i) b.group("", 1);
  b.prim(8, {1, 2});
  const Bytes open = b.bytes;
  for (int i = 0; i < 10000; ++i) b.group_end();
  b.finish();
  EXPECT_TRUE(survives(b.bytes, false));
  EXPECT_TRUE(survives(b.bytes, true));
  EXPECT_FALSE(survives(open, false));
  EXPECT_TRUE(survives(open, true));
}

TEST(RvmHostile, MemoryOfTheWorstInputs) {
  // What takes the most memory per byte of file: tiny groups with a colour each and a position, tiny items, empty
  // facets.
  double factor = 0.0;
  tests::RvmBytes groups, items, facets, layers, contours;
  groups.head();
  for (std::uint32_t i = 0; i < 40000; ++i)
    groups.begin("CNTB")
        .u32(3)
        .u32(0)
        .floats({1.2345678e-30f, -1.2345678e-30f, -7.6543212e-20f})
        .u32(i)
        .u32(i << 24)
        .end();
  items.head().group("", 1);
  for (int i = 0; i < 40000; ++i) items.prim(9, {1});
  facets.head().group("", 1);
  for (int i = 0; i < 40000; ++i) facets.item(11).u32(0).end();
  layers.head().group("", 1);
  for (std::uint32_t i = 0; i < 40000; ++i)
    layers.begin("OBST").u32(1).u32(9).matrix().floats({-1, -1, -1, 1, 1, 1}).u32(i % 100 << 24).f32(2).end();
  contours.head().group("", 1).item(11).u32(1).u32(400000);
  for (int i = 0; i < 400000; ++i) contours.u32(0);
  contours.end();
  for (const Bytes* bytes : {&groups.bytes, &items.bytes, &facets.bytes, &layers.bytes, &contours.bytes}) {
    double one = 0.0;
    survives(*bytes, true, &one);
    std::printf("peak memory / file size: %.1f\n", one);
    factor = std::max(factor, one);
  }
  EXPECT_LT(factor, double(kRvmMemoryFactor));
}

TEST(RvmHostile, NotFiniteOrFarBeyond) {
  const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f};
  for (const float value : bad) {
    tests::RvmBytes b;
    b.head().group("g", 1).prim(8, {1, value}).prim(2, {value, 1, 1}).prim(7, {1, 2, 3, value, 0, 0, 0, 0, 0});
    b.begin("PRIM")
        .u32(1)
        .u32(8)
        .floats({value, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0})
        .floats({0, 0, 0, 0, 0, 0})
        .floats({1, 1})
        .end();
    b.begin("PRIM")
        .u32(1)
        .u32(8)
        .floats({1, 0, 0, 0, 1, 0, 0, 0, 1, value, 0, 0})
        .floats({0, 0, 0, 0, 0, 0})
        .floats({1, 1})
        .end();
    b.item(11)
        .u32(1)
        .u32(1)
        .u32(3)
        .floats({0, 0, value, 0, 0, 1})
        .floats({1, 0, 0, 0, 0, 1})
        .floats({0, 1, 0, 0, 0, 1})
        .end();
    b.prim(8, {1, 2}).group_end().finish();
    for (const bool lenient : {false, true}) {
      SCOPED_TRACE(testing::Message() << value << (lenient ? " lenient" : " strict"));
      ASSERT_TRUE(survives(b.bytes, lenient));
      core::Scene scene;
      const auto report = read_rvm(b.bytes, "bad.rvm", scene, scene.root(), {.lenient = lenient});
      ASSERT_TRUE(report.has_value());
      // 3e38 mm scaled to metres is 3e35 m: within the limit. As a scale or a coordinate in metres it is not.
      EXPECT_EQ(report->warnings.size(), std::isfinite(value) ? 2u : 6u);
      EXPECT_EQ(scene.item_count() + report->warnings.size(), 7u);
    }
  }
}

TEST(RvmHostile, LargeScaleOfSomethingSmall) {
  // Reaches nowhere, and its matrix could still not be committed.
  tests::RvmBytes b;
  b.head().group("g", 1);
  b.begin("PRIM").u32(1).u32(8).floats({1, 0, 0, -3e38f, 1, 0, 0, 0, 1, 0, 0, 0});
  b.floats({0, 0, 0, 0, 0, 0}).floats({1e-39f, 1e-43f}).end();
  b.prim(8, {1, 2}).group_end().finish();
  for (const bool lenient : {false, true}) {
    ASSERT_TRUE(survives(b.bytes, lenient));
    core::Scene scene;
    const auto report = read_rvm(b.bytes, "bad.rvm", scene, scene.root(), {.lenient = lenient});
    ASSERT_TRUE(report.has_value());
    EXPECT_EQ(report->warnings.size(), 1u);
    EXPECT_EQ(scene.item_count(), 1u);
  }
}

TEST(RvmHostile, TextAndNoise) {
  const std::string_view text = "v 0 0 0\nthis is no RVM file, but it is long enough to hold a chunk header\n";
  EXPECT_FALSE(survives(std::as_bytes(std::span(text)), true));
  std::mt19937 random(11);
  for (int i = 0; i < 1000; ++i) {
    Bytes noise(random() % 3000 + 1);
    for (std::byte& b : noise) b = std::byte(random() & 0xff);
    EXPECT_FALSE(survives(noise, false));
    EXPECT_FALSE(survives(noise, true));
  }
}

}  // namespace
}  // namespace sightline::importers::rvm_hostile_test
