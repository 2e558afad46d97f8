// Ways to cull and draw for which one picture is right.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"
#include "sightline/tests/engine/drawn_grid.h"

namespace sightline::tests {

struct WayToDraw {
  const char* name;
  void (*set)(engine::EngineConfig&);
};

/// All cullers, with and without occlusion, with samples and with a budget that any frame keeps; and `more`.
inline std::vector<WayToDraw> ways_to_draw(std::initializer_list<WayToDraw> more) {
  using engine::CullerChoice;
  using engine::EngineConfig;
  using engine::OcclusionChoice;
  std::vector<WayToDraw> ways = {
      {"cpu", [](EngineConfig& c) { c.culling.culler = CullerChoice::kCpu; }},
      {"linear", [](EngineConfig& c) { c.culling.culler = CullerChoice::kLinear; }},
      {"gpu", [](EngineConfig& c) { c.culling.culler = CullerChoice::kGpu; }},
      {"hybrid",
       [](EngineConfig& c) {
         c.culling.culler = CullerChoice::kHybrid;
         DrawnGrid::switch_often(c);
       }},
      {"cpu_occlusion",
       [](EngineConfig& c) {
         c.culling.culler = CullerChoice::kCpu;
         c.culling.occlusion = OcclusionChoice::kOn;
       }},
      {"gpu_occlusion",
       [](EngineConfig& c) {
         c.culling.culler = CullerChoice::kGpu;
         c.culling.occlusion = OcclusionChoice::kOn;
       }},
      {"samples", [](EngineConfig& c) { c.drawing.samples = 4; }},
      {"budget", [](EngineConfig& c) { c.losses.budget_ms = 1e5; }},
  };
  ways.insert(ways.end(), more);
  return ways;
}

inline std::string name_of(const testing::TestParamInfo<WayToDraw>& way) {
  return way.param.name;
}

}  // namespace sightline::tests
