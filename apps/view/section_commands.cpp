#include "sightline/apps/view/section_commands.h"

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/view/viewer.h"

namespace sightline::apps {
namespace {

core::Expected<std::size_t> section_named(const Sections& sections, const std::string& number) {
  const std::size_t count = sections.all().size();
  if (number.empty()) {
    if (sections.selected() && *sections.selected() < count) return *sections.selected();
    return core::fail("select a section first, in the tab Sections or by its handle");
  }
  for (std::size_t i = 0; i < count; ++i)
    if (number == std::to_string(i + 1)) return i;
  return core::fail("there is no section " + number + ": there are " + std::to_string(count));
}

}  // namespace

core::Expected<void> cut_at(Viewer& viewer, const core::Expected<std::optional<engine::Pick>>& face) {
  if (!face) return tl::unexpected(face.error());
  if (!*face) return core::fail("there is no face under the cursor");
  Sections& sections = viewer.session()->sections();
  if (!sections.add((*face)->point, (*face)->normal))
    return core::fail("there are eight sections: take one away first");
  sections.select(sections.all().size() - 1);
  viewer.shown.tab = "Sections";
  return {};
}

core::Expected<void> cut_middle(Viewer& viewer, int axis) {
  Sections& sections = viewer.session()->sections();
  const core::AabbD& bounds = viewer.session()->bounds().bounds;
  if (bounds.empty()) return core::fail("the model is empty");
  if (!sections.add_middle(axis, bounds)) return core::fail("there are eight sections: take one away first");
  sections.select(sections.all().size() - 1);
  viewer.shown.tab = "Sections";
  return {};
}

core::Expected<void> select_section(Viewer& viewer, const std::string& number) {
  Sections& sections = viewer.session()->sections();
  if (number == "0") return sections.select(std::nullopt), core::Expected<void>();
  const auto index = section_named(sections, number);
  if (!index) return tl::unexpected(index.error());
  sections.select(*index);
  return {};
}

core::Expected<void> flip_section(Viewer& viewer, const std::string& number) {
  Sections& sections = viewer.session()->sections();
  const auto index = section_named(sections, number);
  if (!index) return tl::unexpected(index.error());
  Sections::flip(sections.all()[*index]);
  return {};
}

core::Expected<void> move_section(Viewer& viewer, const std::string& number_and_metres) {
  const std::size_t space = number_and_metres.find(' ');
  const bool named = space != std::string::npos;
  Sections& sections = viewer.session()->sections();
  const auto index = section_named(sections, named ? number_and_metres.substr(0, space) : "");
  const auto metres = parse_finite(named ? number_and_metres.substr(space + 1) : number_and_metres);
  if (!metres) return core::fail("expected N METRES or METRES, found \"" + number_and_metres + "\"");
  if (!index) return tl::unexpected(index.error());
  sections.all()[*index].offset += *metres;
  return {};
}

core::Expected<void> remove_section(Viewer& viewer, const std::string& number) {
  Sections& sections = viewer.session()->sections();
  const auto index = section_named(sections, number);
  if (!index) return tl::unexpected(index.error());
  sections.remove(*index);
  return {};
}

}  // namespace sightline::apps
