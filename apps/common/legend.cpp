#include "sightline/apps/common/legend.h"

#include "sightline/apps/common/html_page.h"
#include "sightline/apps/common/numbers.h"

namespace sightline::apps {

std::string legend_text(const query::Colouring& colouring) {
  if (colouring.groups.empty()) return {};
  std::string text = "colours: " + colouring.key + "\n";
  for (const query::ColourGroup& group : colouring.groups)
    text += "  " + hex_of(group.colour) + "  " + group.label + "  (" + grouped(group.items) + ")\n";
  return text;
}

json::Value legend_json(const query::Colouring& colouring) {
  if (colouring.groups.empty()) return nullptr;
  json::Value groups = json::Value::array();
  for (const query::ColourGroup& group : colouring.groups)
    groups.push_back({{"label", group.label}, {"colour", hex_of(group.colour)}, {"items", group.items}});
  return {{"key", colouring.key}, {"groups", std::move(groups)}};
}

}  // namespace sightline::apps
