#include "sightline/apps/view/section_handles.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace sightline::apps {
namespace {

constexpr double kReach = 10.0;       // pixels within which features are felt
constexpr double kRoundPixels = 6.0;  // that a round step takes or more
constexpr double kTurnStep = std::numbers::pi / 12;
constexpr double kDegrees = 180.0 / std::numbers::pi;

/// 1, 2 or 5 times a power of ten, and no less.
double round_step(double least) {
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double times : {1.0, 2.0, 5.0})
    if (times * power >= least) return times * power;
  return 10.0 * power;
}

/// The handle at a point, that in front of others.
std::optional<std::pair<SectionHandles::Shown, SectionGizmo::Part>> felt(const std::vector<SectionHandles::Shown>& all,
                                                                         const core::dvec2& at) {
  for (auto one = all.rbegin(); one != all.rend(); ++one)
    if (const auto part = one->gizmo.part_at(at)) return std::pair(*one, *part);
  return std::nullopt;
}

}  // namespace

std::vector<SectionHandles::Shown> SectionHandles::shown(const Session& session, double scale) {
  std::vector<Shown> all;
  const auto view = session.image.view();
  if (!view) return all;
  const auto frame = ImageFrame::create(*view, session.image.size()[0], session.image.size()[1]);
  if (!frame) return all;
  const Sections& sections = session.sections;
  for (std::size_t i = 0; i < sections.all().size(); ++i) {
    if (!sections.all()[i].on) continue;
    if (auto gizmo = SectionGizmo::create(*frame, sections.all()[i], sections.selected() == i, scale))
      all.push_back({i, std::move(*gizmo)});
  }
  std::stable_sort(all.begin(), all.end(), [](const Shown& a, const Shown& b) {
    return std::pair(a.gizmo.whole(), -a.gizmo.pixel()) < std::pair(b.gizmo.whole(), -b.gizmo.pixel());
  });
  return all;
}

std::optional<SectionHandles::Target> SectionHandles::at(const Session& session, const core::dvec2& at, double scale) {
  const auto found = felt(shown(session, scale), at);
  return found ? std::optional(Target{found->first.section, found->second}) : std::nullopt;
}

Sections::Section* SectionHandles::section(Session& session) const {
  std::vector<Sections::Section>& all = session.sections.all();
  return drag_ && drag_->target.section < all.size() ? &all[drag_->target.section] : nullptr;
}

bool SectionHandles::press(Session& session, const core::dvec2& at, double scale) {
  const auto found = felt(shown(session, scale), at);
  if (!found) return false;
  const auto& [one, part] = *found;
  Sections& sections = session.sections;
  const Sections::Section& section = sections.all()[one.section];
  drag_ = Drag{{one.section, part},
               one.gizmo,
               section,
               at,
               sections.selected() == one.section,
               0.0,
               section.place() - session.offset()};
  sections.select(one.section);
  return true;
}

double SectionHandles::snapped(Session& session, double by, const core::dvec2& to, const Snapping& snapping) const {
  const Sections::Section& before = drag_->before;
  if (SectionGizmo::turns(drag_->target.part)) return snapping.round ? kTurnStep * std::round(by / kTurnStep) : by;
  if (snapping.model) {
    const auto aimed = session.aim(to, kReach * drag_->gizmo.scale());
    return aimed && *aimed ? glm::dot(before.normal, (*aimed)->snap.point - before.place()) : by;
  }
  if (!snapping.round) return by;
  const double step = round_step(kRoundPixels * drag_->gizmo.scale() * drag_->gizmo.pixel());
  const double begin = glm::dot(before.normal, before.place() - session.offset());
  return step * std::round((begin + by) / step) - begin;
}

void SectionHandles::drag(Session& session, const core::dvec2& to, const Snapping& snapping) {
  Sections::Section* section = this->section(session);
  if (!section) return;
  const auto by = drag_->gizmo.dragged(drag_->target.part, drag_->from, to);
  if (!by) return;  // it stays where it was last
  drag_->by = snapped(session, *by, to, snapping);
  *section = drag_->gizmo.moved(drag_->target.part, drag_->by);
  drag_->place = section->place() - session.offset();
}

void SectionHandles::release(Session& session, bool click) {
  Sections::Section* section = this->section(session);
  if (section && click && drag_->was_selected && drag_->target.part == SectionGizmo::Part::kMiddle)
    Sections::flip(*section);
  drag_.reset();
}

void SectionHandles::cancel(Session& session) {
  if (Sections::Section* section = this->section(session)) *section = drag_->before;
  drag_.reset();
}

std::string SectionHandles::words(const LengthFormat& lengths) const {
  if (!drag_) return {};
  char text[80];
  if (SectionGizmo::turns(drag_->target.part)) {
    std::snprintf(text, sizeof text, "%+.1f\u00b0", kDegrees * drag_->by);
    return text;
  }
  std::string words = (drag_->by < 0.0 ? "" : "+") + lengths.text(drag_->by);
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(drag_->before.normal[axis]) < 1.0 - 1e-12) continue;
    words += std::string(", ") + "XYZ"[axis] + " = " + lengths.text(drag_->place[axis]);
  }
  return words;
}

}  // namespace sightline::apps
