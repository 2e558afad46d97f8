// Compiles on all processors what a first frame needs. Internal to engine.
#pragma once

#include <span>

#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"
#include "sightline/gpuscene/internal/batch_kinds.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::engine {

/// Draws an item of each of these kinds, in contexts and on threads of its own, and returns when all are drawn.
///
/// A software rasteriser compiles in the thread that draws, once for each program, for more than a second in a scene of
/// all kinds. What it has compiled it keeps in a cache of its own, which all contexts read. So after this the first
/// frame finds everything compiled. Nothing else is shared: a warm-up that fails, or that draws otherwise than the
/// frame, costs time and nothing more.
///
/// Does nothing where it would not help: with hardware, on one processor, without a program cache, and for kinds whose
/// programs that cache has.
void warm_up(const gl::Context& context, const EngineConfig& config, const render::TargetFormat& format,
             std::span<const gpuscene::BatchKind> kinds);

}  // namespace sightline::engine
