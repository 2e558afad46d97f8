// All settings of engines, one by one: of two structs of C, or of one and that of C++.
#pragma once

#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>

#include "c_scene.h"
#include "sightline/engine/engine_config.h"

namespace sightline::tests {

/// Fields have no padding, unlike the structs that they are in.
template <class T>
bool same_setting(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

/// Whether C says the same as C++.
template <class C, class Cpp>
bool same_setting(const C& c, const Cpp& cpp) {
  if constexpr (std::is_same_v<Cpp, engine::ScenePart>)
    return c.index == cpp.index && c.count == cpp.count;
  else if constexpr (std::is_same_v<Cpp, std::optional<core::vec3>>)
    return (c.given != 0) == cpp.has_value() && (!cpp || same_setting(c.colour, *cpp));
  else if constexpr (std::is_same_v<Cpp, std::optional<std::filesystem::path>>)
    return c ? cpp && cpp->string() == c : !cpp;
  else if constexpr (std::is_same_v<Cpp, std::filesystem::path>)
    return c ? cpp.string() == c : cpp.empty();
  else if constexpr (std::is_same_v<Cpp, std::optional<culling::GpuVariant>>)
    return c == (cpp ? int(*cpp) + 1 : 0);
  else if constexpr (std::is_array_v<C>)
    return c[0] == cpp[0] && c[1] == cpp[1] && c[2] == cpp[2];
  else
    return c == C(cpp);
}

/// Calls `each` with the name of each setting of an sl_engine_config and with both values.
template <class B, class Each>
void for_each_setting(const sl_engine_config& a, const B& b, const Each& each) {
#define SIGHTLINE_SETTING(path, name, ...) each(#name, a.path, b.path);
#define SIGHTLINE_UNPAGED_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_ENGINE_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_CONTROLLER_SETTING SIGHTLINE_SETTING
#include "sightline/engine/internal/settings.inc"
}

/// Calls `each` with the name of each setting of an sl_paged_config and with both values.
template <class B, class Each>
void for_each_setting(const sl_paged_config& a, const B& b, const Each& each) {
#define SIGHTLINE_SETTING(path, name, ...) each(#name, a.path, b.path);
#define SIGHTLINE_UNPAGED_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_PAGED_SETTING SIGHTLINE_SETTING
#include "sightline/engine/internal/settings.inc"
}

template <class A, class B>
void compare_settings(const A& a, const B& b) {
  for_each_setting(a, b, [](const char* name, const auto& one, const auto& other) {
    EXPECT_TRUE(same_setting(one, other)) << name;
  });
}

}  // namespace sightline::tests
