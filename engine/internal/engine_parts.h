// Parts of an engine that tests and measurements of this library read, and applications have no use for. Not installed.
#pragma once

#include "sightline/engine/engine.h"

namespace sightline::gpuprims {
class Joints;
}

namespace sightline::engine {

class Drawing;

class EngineParts {
 public:
  /// The half that needs GL. Null when nothing needs GL, and while the context is lost. An engine's own context is then
  /// current and stays so.
  static Drawing* drawing(Engine& engine);
  /// Depths of the last frame as the GPU has them, reversed: 1 at the near plane, 0 where nothing is.
  static core::Expected<image::DepthImage> reversed_depths(Engine& engine);
  /// The covered ends that are not drawn.
  static const gpuprims::Joints& joints(const Engine& engine);
  /// Whether moving images within a budget may be traced, which they are where that is faster.
  static void set_traces_motion(Engine& engine, bool traces);
};

}  // namespace sightline::engine
