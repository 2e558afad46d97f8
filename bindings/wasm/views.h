// Views, as the other parts of the module take them.
#pragma once

#include "sightline/core/view.h"

namespace sightline::wasm {

/// A camera and the size of its image.
struct ViewObject {
  core::View view;
  int width = 0, height = 0;
};

}  // namespace sightline::wasm
