// Culling without a hierarchy on the GPU with the answer read back: one point per box, the test in the vertex stage.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/program.h"
#include "sightline/study/method.h"

namespace sightline::study {

/// How visible boxes get out of the GPU, and what is done to test less.
struct FlatForm {
  /// Carlos's second form for meshes: every box's number is written, signed by its answer, and the CPU picks the
  /// visible ones. Otherwise his first: a geometry stage lets pass the numbers of visible boxes alone.
  bool signed_answers = false;
  /// Six planes at once in the form of A. Reshetov, A. Soupikov and J. Hurley, "Multi-level ray tracing algorithm",
  /// 2005, and three answers.
  bool split = false;
  /// The plane that rejected a box last comes first; remembered on the GPU, four bytes a box. Not with `split`.
  bool plane_order = false;
  /// Boxes are not tested against planes that their cluster of 64 neighbours lies wholly inside of.
  bool masking = false;
};
std::string name(const FlatForm& form);
/// The two forms as they were, then the first with each acceleration, and with those that go together.
std::vector<FlatForm> flat_forms();
/// The programs of flat_forms().
std::vector<gl::PipelineDescription> flat_programs();

/// Promise: conservative; needless only within rounding of a plane. Counts and ids do without the GPU. The context must
/// live longer, and be current in all calls. Fails when the GPU has not the memory, for plane_order also when vertex
/// stages of the context cannot write.
core::Expected<std::unique_ptr<Method>> make_flat(const gl::Context& context, const FlatForm& form,
                                                  std::span<const core::Aabb> boxes);

}  // namespace sightline::study
