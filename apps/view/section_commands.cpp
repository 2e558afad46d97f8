#include "sightline/apps/common/arguments.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/needs.h"

namespace sightline::apps {
namespace {

core::Expected<std::size_t> section_named(const Sections& sections, const std::string& number) {
  const std::size_t count = sections.all().size();
  if (!number.empty()) return numbered("section", number, count);
  if (sections.selected() && *sections.selected() < count) return *sections.selected();
  return core::fail(needs::kSection.missing);
}

/// Shows and selects the section that was added last.
Done added(bool done, Sections& sections, Shown& shown) {
  if (!done) return core::fail("there are eight sections: take one away first");
  sections.select(sections.all().size() - 1);
  shown.tab = "Sections";
  return {};
}

}  // namespace

core::Expected<std::size_t> numbered(const char* what, const std::string& number, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (number == std::to_string(i + 1)) return i;
  return core::fail(std::string("there is no ") + what + " " + number + ": there are " + std::to_string(count));
}

Done cut_at(const core::Expected<std::optional<engine::Pick>>& face, Session& session, Shown& shown) {
  if (!face) return tl::unexpected(face.error());
  if (!*face) return core::fail("there is no face under the cursor");
  return added(session.sections.add((*face)->point, (*face)->normal), session.sections, shown);
}

Done cut_middle(int axis, Session& session, Shown& shown) {
  const core::AabbD& bounds = session.bounds().bounds;
  if (bounds.empty()) return core::fail("the model is empty");
  return added(session.sections.add_middle(axis, bounds), session.sections, shown);
}

Done select_section(const std::string& number, Session& session) {
  Sections& sections = session.sections;
  if (number == "0") return sections.select(std::nullopt), Done();
  const auto index = section_named(sections, number);
  if (!index) return tl::unexpected(index.error());
  sections.select(*index);
  return {};
}

Done flip_section(const std::string& number, Session& session) {
  Sections& sections = session.sections;
  const auto index = section_named(sections, number);
  if (!index) return tl::unexpected(index.error());
  Sections::flip(sections.all()[*index]);
  return {};
}

Done move_section(const std::string& number_and_metres, Session& session) {
  const std::size_t space = number_and_metres.find(' ');
  const bool named = space != std::string::npos;
  Sections& sections = session.sections;
  const auto index = section_named(sections, named ? number_and_metres.substr(0, space) : "");
  const auto metres = parse_finite(named ? number_and_metres.substr(space + 1) : number_and_metres);
  if (!metres) return core::fail("expected N METRES or METRES, found \"" + number_and_metres + "\"");
  if (!index) return tl::unexpected(index.error());
  sections.all()[*index].offset += *metres;
  return {};
}

Done remove_section(const std::string& number, Session& session) {
  Sections& sections = session.sections;
  const auto index = section_named(sections, number);
  if (!index) return tl::unexpected(index.error());
  sections.remove(*index);
  return {};
}

}  // namespace sightline::apps
