// Tests that run sightline-study as a user does.
#pragma once

#include <string>

#include "sightline/core/scene.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests {

class StudyTest : public ToolTest {
 protected:
  /// A plant of so many items. The tools that could make it are not built with the study.
  std::string plant(std::uint64_t items) const {
    const std::string file = path("plant-" + std::to_string(items) + ".rvm");
    core::Scene scene;
    EXPECT_TRUE(importers::generate_plant({.items = items, .seed = 1}, scene));
    EXPECT_TRUE(importers::write_rvm(scene, scene.root(), file));
    return file;
  }
};

}  // namespace sightline::tests
