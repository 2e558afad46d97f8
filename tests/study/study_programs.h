// Every program that the study can ask a driver for beside the library's.
#pragma once

#include <vector>

#include "sightline/apps/study/gpu/flat.h"
#include "sightline/apps/study/gpu/in_draw.h"
#include "sightline/apps/study/rays/gpu/tracer.h"

namespace sightline::tests {

inline std::vector<gl::PipelineDescription> study_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const auto& list :
       {study::flat_programs(), study::InDraw::all_programs(), study::rays::GpuTracer::all_programs()})
    all.insert(all.end(), list.begin(), list.end());
  return all;
}

}  // namespace sightline::tests
