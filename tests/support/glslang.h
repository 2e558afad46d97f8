// Compiles programs without a driver: glslang compiles their stages, links those that run together and translates them
// to SPIR-V by the rules of OpenGL, which SPIRV-Tools validates.
#pragma once

#include <span>
#include <string>

#include "sightline/gl/internal/program.h"

namespace sightline::tests {

/// What there is to say against a pipeline, with names of files and lines. Warnings count. Empty if there is nothing.
std::string glslang_complaint(const gl::PipelineDescription& pipeline);

/// In a test: fails with all complaints, each once with the programs and defines of the first pipeline that has it.
/// Prints how many pipelines there are. On all cores.
void expect_valid(std::span<const gl::PipelineDescription> pipelines);

}  // namespace sightline::tests
