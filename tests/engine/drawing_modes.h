// Modes of culling and drawing for which one image is right.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"
#include "sightline/tests/engine/drawn_grid.h"

namespace sightline::tests {

struct DrawingMode {
  const char* name;
  void (*set)(engine::EngineConfig&);
};

/// All cullers, with and without occlusion, with samples and with a budget that any frame keeps; and `more`.
inline std::vector<DrawingMode> drawing_modes(std::initializer_list<DrawingMode> more) {
  using engine::CullerChoice;
  using engine::EngineConfig;
  using engine::OcclusionChoice;
  std::vector<DrawingMode> modes = {
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
  modes.insert(modes.end(), more);
  return modes;
}

inline std::string name_of(const testing::TestParamInfo<DrawingMode>& mode) {
  return mode.param.name;
}

}  // namespace sightline::tests
