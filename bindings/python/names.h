// How many values the enumerations of engines have.
#pragma once

#include "sightline/bindings/python/values.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/choices.h"

namespace sightline::python {

#define SIGHTLINE_CHOICE(Enum, prefix, ...) \
  template <>                               \
  inline constexpr int kEnumerators<Enum> = int(engine::kChoices<Enum>.size());
#include "sightline/engine/internal/settings.inc"
template <>
inline constexpr int kEnumerators<culling::ControllerState> = 3;

}  // namespace sightline::python
