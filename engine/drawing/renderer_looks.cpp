#include "sightline/engine/internal/settings.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::engine {

void give_looks(const Looks& looks, render::Renderer& to, const std::array<double, 2>& rows) {
  to.hatching = {looks.hatching.strength, looks.hatching.spacing};
  to.lighting = looks.lighting;
  to.sun = looks.sun;
  to.background = rows_of(looks.background, rows);
}

}  // namespace sightline::engine
