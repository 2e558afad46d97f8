#include "sightline/apps/view/marking.h"

#include <algorithm>
#include <sstream>

#include "sightline/apps/common/arguments.h"
#include "sightline/core/image_rays.h"

namespace sightline::apps {
namespace {

using Kind = Markup::Kind;

core::Expected<core::dvec2> take_point(std::istream& in) {
  std::string x, y;
  in >> x >> y;
  const auto first = parse_finite(x), second = parse_finite(y);
  if (!first || !second) return core::fail("mark: expected X Y, found \"" + x + " " + y + "\"");
  return core::dvec2(*first, *second);
}

}  // namespace

core::dvec3 direction_of(const core::View& view) {
  const auto ray = core::image_ray(view, 2, 2, 1.0, 1.0);
  return ray ? ray->direction : core::dvec3(0.0);
}

core::Expected<core::dvec3> MarkupPlane::at(const core::dvec2& pixel) const {
  const auto ray = core::image_ray(view, size[0], size[1], pixel.x, pixel.y);
  const core::dvec3 ahead = direction_of(view);
  const double along = ray ? glm::dot(ray->direction, ahead) : 0.0;
  const double distance = ray ? glm::dot(through - ray->origin, ahead) : 0.0;
  if (!(along > 0.0) || !(distance > 0.0)) return core::fail("there is no room for a mark-up");
  return ray->origin + ray->direction * (distance / along);
}

core::Expected<Markup> drawn_markup(Kind kind, const std::string& words, const MarkupPlane& plane,
                                    const core::dvec2& from, const core::dvec2& to) {
  if (kind == Kind::kText && words.empty()) return core::fail("a text needs words");
  const core::dvec2 low = glm::min(from, to), high = glm::max(from, to);
  std::vector<core::dvec2> pixels{from};
  if (kind == Kind::kArrow) pixels = {to, from};
  if (kind == Kind::kCloud) pixels = {low, {high.x, low.y}, high, {low.x, high.y}};
  Markup markup{kind, {}, words};
  for (const core::dvec2& pixel : pixels) {
    const auto point = plane.at(pixel);
    if (!point) return tl::unexpected(point.error());
    markup.points.push_back(*point);
  }
  return markup;
}

core::Expected<AskedMarkup> parse_markup(const std::string& text) {
  std::istringstream in(text);
  std::string kind;
  in >> kind;
  const auto* const known = std::find(kMarkupKinds.begin(), kMarkupKinds.end(), kind);
  if (known >= kMarkupKinds.begin() + int(Kind::kLine))
    return core::fail("mark: expected arrow, cloud or text, found \"" + kind + "\"");
  AskedMarkup asked{Kind(known - kMarkupKinds.begin()), {}, {}, ""};
  const auto from = take_point(in);
  if (!from) return tl::unexpected(from.error());
  asked.from = asked.to = *from;
  if (asked.kind != Kind::kText) {
    const auto to = take_point(in);
    if (!to) return tl::unexpected(to.error());
    asked.to = *to;
  }
  std::getline(in >> std::ws, asked.words);
  return asked;
}

}  // namespace sightline::apps
