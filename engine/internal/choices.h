// Names of settings' choices, from internal/settings.inc. Internal.
#pragma once

#include <array>
#include <string_view>

#include "sightline/engine/engine_config.h"

namespace sightline::engine {

/// The name of each enumerator, from 0 on; empty for other enumerations.
template <class Enum>
inline constexpr std::array<std::string_view, 0> kChoices{};
#define SIGHTLINE_NAME_CHOICE(Enum, prefix, ...) \
  template <>                                    \
  inline constexpr auto kChoices<sightline::Enum> = std::to_array<std::string_view>({__VA_ARGS__});
#define SIGHTLINE_CHOICE SIGHTLINE_NAME_CHOICE
#include "sightline/engine/internal/settings.inc"

template <class Enum>
consteval bool names_agree() {
  for (std::size_t i = 0; i < kChoices<Enum>.size(); ++i)
    if (name_of(Enum(i)) != kChoices<Enum>[i]) return false;
  return true;
}
static_assert(names_agree<CullerChoice>() && names_agree<OcclusionChoice>() && names_agree<Renderer>() &&
              names_agree<Transparency>() && names_agree<ContributionMode>() && names_agree<GlState>() &&
              names_agree<culling::GpuVariant>() && names_agree<gpuprims::Lighting>());

}  // namespace sightline::engine
