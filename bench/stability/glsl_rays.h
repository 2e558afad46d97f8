// The primitives' own GLSL on single rays: a compute shader that includes it, in a context without a window.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "sightline/bench/stability/measure.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/program.h"

namespace sightline::bench {

class GlslRays {
 public:
  /// Fails where there is no GL. Programs are compiled at their first use.
  static core::Expected<GlslRays> create();

  /// The nearest crossing over the whole line of each sample. A record is packed for each; what the shader gets is what
  /// a renderer can give it (render/shaders/primitive.vert): the ray in the record's local frame, moved in double to
  /// its closest approach to the centre, or of kinds that may be needles to the nearest point of their axis, and then
  /// rounded to float. Its t, counted from there, is added up in double. What it says of placements that
  /// a renderer does not show, because float cannot hold their volume, is left out. All samples must be of one kind.
  core::Expected<std::vector<Answer>> trace(core::Kind kind, std::span<const Sample> samples);

  const gl::Context& context() const { return context_; }

 private:
  explicit GlslRays(gl::Context context) : context_(std::move(context)) {}
  core::Expected<const gl::Program*> program(core::Kind kind);

  gl::Context context_;  // first: programs go before it
  std::map<std::string, gl::Program> programs_;
};

}  // namespace sightline::bench
