#include <algorithm>
#include <cstdio>

#include "sightline/apps/common/numbers.h"
#include "sightline/apps/compare/reports.h"

namespace sightline::apps {
namespace {

std::string count_line(std::string_view name, std::size_t count) {
  char text[80];
  std::snprintf(text, sizeof text, "%-16s %12zu\n", std::string(name).c_str(), count);
  return text;
}

}  // namespace

std::string text_report(const Compared& c, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    text += count_line(compare::name_of(compare::State(i)), c.found.counts[i]);
  text += count_line("renamed", c.found.renamed) + count_line("nodes changed", c.found.nodes.size());
  if (!c.found.with_attributes) text += "attributes are not compared: one revision has none\n";
  const std::size_t all = c.groups.all.size(), shown = std::min(most, all);
  if (shown > 0) text += "\n";
  for (std::size_t i = 0; i < shown; ++i)
    text += path_of(c, c.groups.all[i]) + ": " + what_of(c, c.groups.all[i]) + "\n";
  if (shown > 0 && shown < all) text += "and " + grouped(std::int64_t(all - shown)) + " more: --all or --html FILE\n";
  return text;
}

}  // namespace sightline::apps
