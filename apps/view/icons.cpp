#include "sightline/apps/view/icons.h"

#include <algorithm>
#include <cstdlib>

namespace sightline::apps {

void draw_icon(ImDrawList& list, const char* icon, const ImVec2& corner, float size, ImU32 colour) {
  const float grid = size / 16.0f, thick = std::max(1.0f, 1.2f * grid);
  char* rest = const_cast<char*>(icon);
  const auto number = [&] { return std::strtof(rest, &rest); };
  const auto point = [&] {
    const float x = number();
    return ImVec2(corner.x + grid * x, corner.y + grid * number());
  };
  while (*rest != '\0') {
    switch (*rest++) {
      case 'M':
        list.PathStroke(colour, 0, thick);  // what is left of the stroke before
        list.PathLineTo(point());
        break;
      case 'L':
        list.PathLineTo(point());
        break;
      case 'Z':
        list.PathStroke(colour, ImDrawFlags_Closed, thick);
        break;
      case 'F':
        list.PathFillConvex(colour);
        break;
      case 'C':
      case 'D': {
        list.PathStroke(colour, 0, thick);
        const bool disc = rest[-1] == 'D';
        const ImVec2 centre = point();
        const float radius = grid * number();
        disc ? list.AddCircleFilled(centre, radius, colour) : list.AddCircle(centre, radius, colour, 0, thick);
        break;
      }
      default:
        break;
    }
  }
  list.PathStroke(colour, 0, thick);
}

}  // namespace sightline::apps
