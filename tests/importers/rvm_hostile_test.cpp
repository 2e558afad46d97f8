// RVM items with numbers that no scene can hold. hostile_test.cpp has the other damaged and malicious files.
#include <cmath>

#include <gtest/gtest.h>

#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/tests/importers/hostile.h"
#include "sightline/tests/importers/rvm_bytes.h"

namespace sightline::importers::rvm_hostile_test {
namespace {

/// True when the import succeeded.
bool survives(const tests::RvmBytes& rvm, bool lenient) {
  const hostile::Case made = hostile::one_file("model.rvm", hostile::text_of(rvm.bytes));
  return tests::survives(hostile::target_of("rvm"), made, lenient, "model.rvm");
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
      ASSERT_TRUE(survives(b, lenient));
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
    ASSERT_TRUE(survives(b, lenient));
    core::Scene scene;
    const auto report = read_rvm(b.bytes, "bad.rvm", scene, scene.root(), {.lenient = lenient});
    ASSERT_TRUE(report.has_value());
    EXPECT_EQ(report->warnings.size(), 1u);
    EXPECT_EQ(scene.item_count(), 1u);
  }
}

}  // namespace
}  // namespace sightline::importers::rvm_hostile_test
