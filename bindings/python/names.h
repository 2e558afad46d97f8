// How many values the enumerations of engines have, and names of those that have none in C++.
#pragma once

#include "sightline/bindings/python/values.h"
#include "sightline/engine/engine.h"

namespace sightline::engine {

constexpr std::string_view name_of(GlState state) {
  return state == GlState::kRestore ? "restore" : "leave";
}

}  // namespace sightline::engine

namespace sightline::python {

template <>
inline constexpr int kEnumerators<engine::CullerChoice> = 5;
template <>
inline constexpr int kEnumerators<engine::OcclusionChoice> = 3;
template <>
inline constexpr int kEnumerators<engine::ContributionMode> = 3;
template <>
inline constexpr int kEnumerators<engine::Transparency> = 2;
template <>
inline constexpr int kEnumerators<core::Lighting> = 3;
template <>
inline constexpr int kEnumerators<engine::GlState> = 2;
template <>
inline constexpr int kEnumerators<culling::GpuVariant> = 2;
template <>
inline constexpr int kEnumerators<culling::ControllerState> = 3;

}  // namespace sightline::python
