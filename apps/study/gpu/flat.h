// Culling without a hierarchy on the GPU with the answer read back: one point per box, the test in the vertex stage.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/study/method.h"
#include "sightline/core/aabb.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/program.h"

namespace sightline::study {

/// Promise: conservative; needless only within rounding of a plane. Counts and ids do without the GPU. The context must
/// live longer, and be current in all calls. Fails when the GPU has not the memory.
/// `signed_answers`: Carlos's second form for meshes, in which every box's number is written, signed by its answer, and
/// the CPU picks the visible ones. Otherwise his first: a geometry stage lets pass the numbers of visible boxes alone.
core::Expected<std::unique_ptr<Method>> make_flat(const gl::Context& context, bool signed_answers,
                                                  std::span<const core::Aabb> boxes);
std::string flat_name(bool signed_answers);
/// The programs of both forms.
std::vector<gl::PipelineDescription> flat_programs();

}  // namespace sightline::study
