// Runs the primitives' own GLSL on single rays: a compute shader includes it, in a context without a window.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/bench/stability/measure.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/program.h"

namespace sightline::bench {

class GlslRays {
 public:
  /// Fails without GL. Programs are compiled at their first use.
  static core::Expected<GlslRays> create(gl::ContextPlatform platform = {});

  /// Finds the nearest crossing of each sample over the whole line. A record is packed for each sample. The shader gets
  /// what a renderer can give it (render/shaders/primitive.vert): the ray in the record's local frame, moved in double
  /// to its closest approach to the centre, or to the nearest point of the axis for kinds that may be needles, and then
  /// rounded to float. The shader's t counts from there and is added up in double. Answers for placements whose volume
  /// does not fit a float, which a renderer does not show, are dropped. All samples must be of one kind.
  core::Expected<std::vector<Answer>> trace(core::Kind kind, std::span<const Sample> samples);

  /// The programs of all kinds.
  static std::vector<gl::PipelineDescription> all_programs();

  const gl::Context& context() const { return context_; }

 private:
  explicit GlslRays(gl::Context context) : context_(std::move(context)) {}
  core::Expected<const gl::Program*> program(core::Kind kind);

  gl::Context context_;  // first: programs are destroyed before it
  std::map<std::string, gl::Program> programs_;
};

}  // namespace sightline::bench
