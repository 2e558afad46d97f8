// Mark-ups: what somebody has drawn onto a view, at places of the world, so that it stays there when the camera moves.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/conventions.h"
#include "sightline/core/error.h"

namespace sightline::json {
class Value;
}

namespace sightline::apps {

struct Markup {
  enum class Kind { kArrow, kCloud, kText, kLine };

  Kind kind = Kind::kArrow;
  /// On a plane parallel to the image, in metres. An arrow: where it begins, and its tip; a cloud: the corners of a
  /// rectangle, in order around it; a text: where it stands; a line, as other programs draw it: two points or more.
  std::vector<core::dvec3> points;
  std::string words;  ///< what a text says; may be empty for the others

  friend bool operator==(const Markup&, const Markup&) = default;
};
inline constexpr std::array<std::string_view, 4> kMarkupKinds{"arrow", "cloud", "text", "line"};
std::string_view name_of(Markup::Kind kind);

/// The lines that show a mark-up, each through two points or more: an arrow has a head, across the direction `ahead` in
/// which the image looks, and a cloud has bows. A text has none.
std::vector<std::vector<core::dvec3>> strokes(const Markup& markup, const core::dvec3& ahead);
/// The middle of the words: where an arrow begins, between a cloud's first corners, else the first point.
core::dvec3 words_place(const Markup& markup);

/// {"kind":"arrow", "points":[[X,Y,Z],…], "words":"…"}
json::Value to_json(const Markup& markup);
/// An array of these. `where` begins errors.
core::Expected<std::vector<Markup>> markups_of(const json::Value& json, const std::string& where);

}  // namespace sightline::apps
