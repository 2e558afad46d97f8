// Icons as lines on a grid of 16 by 16, drawn in any size and colour.
#pragma once

#include <imgui.h>

namespace sightline::apps {

/// `icon`: moves "M x y" and lines "L x y" from there, of which each stroke ends at the next M, C or D; "Z" closes a
/// stroke, "F" closes and fills it; "C x y r" is a circle, "D x y r" a disc. `corner`: the upper left one.
void draw_icon(ImDrawList& list, const char* icon, const ImVec2& corner, float size, ImU32 colour);

namespace icons {
inline constexpr char kOpen[] = "M 1 13 L 1 3 L 6 3 L 8 5 L 14 5 L 14 7 M 1 13 L 4 7 L 16 7 L 13 13 Z";
inline constexpr char kCamera[] = "M 1 5 L 5 5 L 6 2.5 L 10 2.5 L 11 5 L 15 5 L 15 13.5 L 1 13.5 Z C 8 9 2.8";
inline constexpr char kCursor[] = "M 4 1 L 4 13 L 7 10.3 L 9 15 L 11 14 L 9 9.5 L 13 9.5 Z";
inline constexpr char kEye[] = "M 1 8 L 4 5 L 8 3.5 L 12 5 L 15 8 L 12 11 L 8 12.5 L 4 11 Z D 8 8 2";
inline constexpr char kEyeCrossed[] =
    "M 1 8 L 4 5 L 8 3.5 L 12 5 L 15 8 L 12 11 L 8 12.5 L 4 11 Z D 8 8 2 M 2 14.5 L 14 1.5";
inline constexpr char kEyeHalf[] = "M 1 8 L 4 5 L 8 3.5 L 12 5 L 15 8 D 8 8 2 M 2 13 L 6 13 M 10 13 L 14 13";
inline constexpr char kEyeClosed[] =
    "M 1 7 L 4 10 L 8 11.5 L 12 10 L 15 7 M 4 10 L 3 12 M 8 11.5 L 8 13.5 M 12 10 L 13 12";
inline constexpr char kIsolate[] =
    "M 1 5 L 1 1 L 5 1 M 11 1 L 15 1 L 15 5 M 15 11 L 15 15 L 11 15 M 5 15 L 1 15 L 1 11 M 5 5 L 11 5 L 11 11 L 5 11 F";
inline constexpr char kFit[] =
    "M 1.5 6 L 1.5 1.5 L 6 1.5 M 1.5 1.5 L 6.5 6.5 M 10 1.5 L 14.5 1.5 L 14.5 6 M 14.5 1.5 L 9.5 6.5 "
    "M 14.5 10 L 14.5 14.5 L 10 14.5 M 14.5 14.5 L 9.5 9.5 M 6 14.5 L 1.5 14.5 L 1.5 10 M 1.5 14.5 L 6.5 9.5";
inline constexpr char kFocus[] = "C 8 8 4.5 D 8 8 1.2 M 8 0.5 L 8 5 M 8 11 L 8 15.5 M 0.5 8 L 5 8 M 11 8 L 15.5 8";
// A cube seen from the front, right and above, with one of its faces filled.
#define SIGHTLINE_CUBE                                                                                                \
  "M 1 5 L 11 5 L 11 15 L 1 15 Z M 5 1 L 15 1 L 15 11 L 5 11 Z M 1 5 L 5 1 M 11 5 L 15 1 M 11 15 L 15 11 M 1 15 L 5 " \
  "11 "
inline constexpr char kFront[] = SIGHTLINE_CUBE "M 1 5 L 11 5 L 11 15 L 1 15 F";
inline constexpr char kBack[] = SIGHTLINE_CUBE "M 5 1 L 15 1 L 15 11 L 5 11 F";
inline constexpr char kLeft[] = SIGHTLINE_CUBE "M 1 5 L 5 1 L 5 11 L 1 15 F";
inline constexpr char kRight[] = SIGHTLINE_CUBE "M 11 5 L 15 1 L 15 11 L 11 15 F";
inline constexpr char kTop[] = SIGHTLINE_CUBE "M 1 5 L 5 1 L 15 1 L 11 5 F";
inline constexpr char kBottom[] = SIGHTLINE_CUBE "M 1 15 L 5 11 L 15 11 L 11 15 F";
#undef SIGHTLINE_CUBE
inline constexpr char kPerspective[] = "M 1 14 L 15 14 L 11 3 L 5 3 Z M 8 3 L 8 14 M 3 8.5 L 13 8.5";
inline constexpr char kWalk[] =
    "D 9 2.5 1.9 M 9 5 L 8 9.5 L 11.5 15 M 8 9.5 L 4.5 15 M 4 9 L 6 6.3 L 9 5.2 L 11 8 L 13.5 8.5";
inline constexpr char kMeasure[] =
    "M 1 11 L 11 1 L 15 5 L 5 15 Z M 3.7 8.3 L 5.5 10.1 M 6.2 5.8 L 8 7.6 M 8.7 3.3 L 10.5 5.1";
inline constexpr char kMarkup[] = "M 2 14 L 3 10.5 L 11.5 2 L 14 4.5 L 5.5 13 Z M 9.5 4 L 12 6.5 M 8 14.5 L 15 14.5";
inline constexpr char kSection[] =
    "M 1 8 L 8 4.5 L 15 8 L 8 11.5 F M 1 8 L 1 12 L 8 15.5 L 15 12 L 15 8 M 8 11.5 L 8 15.5 M 4 2 L 4 4.5 M 12 2 L 12 "
    "4.5";
inline constexpr char kBox[] =
    "M 2 4.5 L 8 1.5 L 14 4.5 L 14 11.5 L 8 14.5 L 2 11.5 Z M 2 4.5 L 8 7.5 L 14 4.5 M 8 7.5 L 8 14.5";
}  // namespace icons

}  // namespace sightline::apps
