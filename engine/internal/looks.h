// What engines make of Looks. Internal to engine.
#pragma once

#include <array>

#include "sightline/core/error.h"
#include "sightline/engine/looks.h"

namespace sightline::render {
class Renderer;
}

namespace sightline::engine {

/// Fails on what is out of range, saying what was expected.
core::Expected<void> check(const Looks& looks);

/// Makes a renderer draw with these looks. `rows`: where the image reaches in that of which it is a part, 0 at its
/// upper border and 1 at its lower.
void give_looks(const Looks& looks, render::Renderer& to, const std::array<double, 2>& rows = {0.0, 1.0});

}  // namespace sightline::engine
