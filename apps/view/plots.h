// Small plots in panels.
#pragma once

#include <functional>
#include <initializer_list>
#include <string>

#include <imgui.h>

namespace sightline::apps {

struct Curve {
  const char* name;
  ImVec4 colour;
  std::function<double(std::size_t)> value;  ///< NaN: a gap
};
/// Curves over the numbers 0 … count - 1, from zero up to the largest value, which the title says, in `words`.
/// Nothing where there is no value.
void plot(const char* title, const std::function<std::string(double)>& words, std::size_t count,
          std::initializer_list<Curve> curves);

/// A square of a colour in a line of text, which may begin `lower` than the line.
void colour_square(const ImVec4& colour, float lower = 0.0f);

}  // namespace sightline::apps
