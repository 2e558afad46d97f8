#include "sightline/apps/view/section_gizmo.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::apps {
namespace {

using core::dvec2;
using core::dvec3;

constexpr double kArrow = 64.0, kLeastArrow = 54.0, kSquare = 34.0;  // pixels from the middle
constexpr double kMiddleRadius = 8.0, kArrowRadius = 9.0, kTurnRadius = 6.0, kShaft = 5.0, kSlack = 2.0;
constexpr double kOwnMargin = 28.0;                      // pixels where no middle is
constexpr double kMargin = 76.0, kBottomMargin = 118.0;  // nor one that is moved into the image: below are the axes
constexpr double kMarginShare = 0.3;                     // of the image at most
constexpr double kNoDirection = 8.0;                     // pixels of an arrow
constexpr double kAlongSight = 0.97;                     // cosine: an axis that is seen from its end
constexpr double kEdgeOn = 0.3;                          // cosine: a plane that is seen from its side
constexpr double kPixelsPerRadian = 120.0;
constexpr double kParallel = 1e-9;

dvec2 clamped(const dvec2& at, const dvec2& size, double scale) {
  const double most = kMarginShare * std::min(size.x, size.y), margin = std::min(kMargin * scale, most);
  return glm::clamp(at, dvec2(margin), size - dvec2(margin, std::min(kBottomMargin * scale, most)));
}

/// A point of the section's plane whose handles the image has room for.
std::optional<dvec3> anchor_of(const ImageFrame& frame, const Sections::Section& section, double scale) {
  const dvec3 place = section.place();
  if (const auto at = frame.project(place)) {
    const dvec2 room = clamped(*at, frame.size(), scale), own(kOwnMargin * scale);
    if (glm::all(glm::greaterThan(*at, own)) && glm::all(glm::lessThan(*at, frame.size() - own))) return place;
    if (const auto there = frame.on_plane(room, place, section.normal)) return there;
  }
  std::optional<dvec3> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const double y : {0.5, 0.0, 1.0})
    for (const double x : {0.5, 0.0, 1.0}) {
      const auto there =
          frame.on_plane(clamped(dvec2(x, y) * frame.size(), frame.size(), scale), place, section.normal);
      if (!there || !(frame.pixel_at(*there) < least)) continue;
      nearest = there;
      least = frame.pixel_at(*there);
    }
  return nearest;
}

double distance_to_segment(const dvec2& point, const dvec2& a, const dvec2& b) {
  const dvec2 along = b - a;
  const double square = glm::dot(along, along);
  const double t = square > 0.0 ? std::clamp(glm::dot(point - a, along) / square, 0.0, 1.0) : 0.0;
  return glm::length(point - a - t * along);
}

}  // namespace

// --- the image -------------------------------------------------------------------------------------------------------

ImageFrame::ImageFrame(const core::View& view, const dvec2& size, core::ImageRays rays)
    : clip_from_eye_(view.clip_from_eye()),
      eye_from_world_(view.eye_from_world()),
      size_(size),
      rays_(std::move(rays)),
      orthographic_(view.orthographic()) {}

core::Expected<ImageFrame> ImageFrame::create(const core::View& view, int width, int height) {
  auto rays = core::ImageRays::create(view, width, height);
  if (!rays) return tl::unexpected(rays.error());
  return ImageFrame(view, dvec2(width, height), std::move(*rays));
}

std::optional<dvec2> ImageFrame::project(const dvec3& point) const {
  const core::dvec4 clip = clip_from_eye_ * (eye_from_world_ * core::dvec4(point, 1.0));
  if (!(clip.w > 0.0)) return std::nullopt;
  const dvec2 at = 0.5 * size_ * (1.0 + dvec2(clip.x, -clip.y) / clip.w);
  return std::isfinite(at.x) && std::isfinite(at.y) ? std::optional(at) : std::nullopt;
}

double ImageFrame::pixel_at(const dvec3& point) const {
  const core::dvec4 clip = clip_from_eye_ * (eye_from_world_ * core::dvec4(point, 1.0));
  return 2.0 * clip.w / (clip_from_eye_[1][1] * size_.y);
}

std::optional<double> ImageFrame::along_axis(const dvec2& at, const dvec3& point, const dvec3& axis) const {
  const core::Ray r = ray(at);
  const dvec3 to = point - r.origin;
  const double cosine = glm::dot(r.direction, axis);
  const dvec3 across = axis - cosine * r.direction;  // of length sine
  const double sine2 = glm::dot(across, across);
  if (!(sine2 > kParallel * kParallel)) return std::nullopt;
  const double along = -glm::dot(across, to) / sine2;
  if (!ahead(glm::dot(r.direction, to) + along * cosine)) return std::nullopt;
  return along;
}

std::optional<dvec3> ImageFrame::on_plane(const dvec2& at, const dvec3& point, const dvec3& normal) const {
  const core::Ray r = ray(at);
  const double slope = glm::dot(r.direction, normal);
  if (!(std::abs(slope) > kParallel)) return std::nullopt;
  const double t = glm::dot(point - r.origin, normal) / slope;
  if (!ahead(t)) return std::nullopt;
  return r.origin + t * r.direction;
}

// --- the handles -----------------------------------------------------------------------------------------------------

SectionGizmo::SectionGizmo(const ImageFrame& frame, const Sections::Section& section, const dvec3& anchor, bool whole,
                           double scale)
    : frame_(frame), section_(section), anchor_(anchor), scale_(scale), pixel_(frame.pixel_at(anchor)), whole_(whole) {
  const dvec3 level = glm::cross(dvec3(0.0, 0.0, 1.0), section.normal);
  right_ = glm::length(level) > kParallel ? glm::normalize(level) : dvec3(1.0, 0.0, 0.0);
  up_ = glm::cross(section.normal, right_);
}

std::optional<SectionGizmo> SectionGizmo::create(const ImageFrame& frame, const Sections::Section& section, bool whole,
                                                 double scale) {
  const auto anchor = anchor_of(frame, section, scale);
  if (!anchor) return std::nullopt;
  SectionGizmo gizmo(frame, section, *anchor, whole, scale);
  if (!(gizmo.pixel_ > 0.0) || !gizmo.add_handles()) return std::nullopt;
  return gizmo;
}

std::optional<dvec2> SectionGizmo::seen(const dvec3& off) const {
  const auto at = frame_.project(anchor_ + off);
  return at ? std::optional(*at - middle()) : std::nullopt;
}

bool SectionGizmo::add_handles() {
  const auto middle = frame_.project(anchor_);
  if (!middle) return false;
  handles_.push_back({Part::kMiddle, *middle});
  sight_ = frame_.ray(*middle).direction;
  const auto out = seen(kArrow * scale_ * pixel_ * section_.normal);
  if (!out) return false;
  // An arrow that points along the line of sight would vanish: it is drawn longer, and aslant where it has hardly any
  // direction.
  const double length = glm::length(*out), least = kLeastArrow * scale_;
  const dvec2 arrow =
      length < kNoDirection * scale_ ? least * dvec2(0.6, -0.8) : *out * (std::max(length, least) / length);
  handles_.push_back({Part::kOut, *middle + arrow});
  if (!whole_) return true;
  handles_.push_back({Part::kIn, *middle - arrow});
  const double side = kSquare * scale_ * pixel_;
  for (const Part part : {Part::kRight, Part::kLeft, Part::kUp, Part::kDown}) {
    const auto at = seen(side * side_of(part));
    if (!at) return false;
    if (glm::length(*at) > (kMiddleRadius + kTurnRadius + kSlack) * scale_) handles_.push_back({part, *middle + *at});
  }
  for (int i = 0; i < 4; ++i) {
    const auto at = seen(side * ((i == 0 || i == 3 ? 1.0 : -1.0) * right_ + (i < 2 ? 1.0 : -1.0) * up_));
    if (!at) return false;
    outline_[std::size_t(i)] = *middle + *at;
  }
  return true;
}

const char* SectionGizmo::name_of(Part part) {
  constexpr const char* kNames[] = {"middle", "out", "in", "right", "left", "up", "down"};
  return kNames[std::size_t(part)];
}

double SectionGizmo::radius(Part part) const {
  return scale_ * (part == Part::kMiddle ? kMiddleRadius : turns(part) ? kTurnRadius : kArrowRadius);
}

std::optional<SectionGizmo::Part> SectionGizmo::part_at(const dvec2& point) const {
  std::optional<Part> found;
  double least = 1.0;
  const auto offer = [&](Part part, double distance, double reach) {
    if (!(distance < least * reach)) return;
    least = distance / reach;
    found = part;
  };
  for (const Handle& handle : handles_) {
    offer(handle.part, glm::length(point - handle.at), radius(handle.part) + kSlack * scale_);
    if (handle.part != Part::kOut && handle.part != Part::kIn) continue;
    const dvec2 shaft = glm::normalize(handle.at - middle());  // from the middle's rim on
    offer(handle.part, distance_to_segment(point, middle() + radius(Part::kMiddle) * shaft, handle.at),
          kShaft * scale_);
  }
  return found;
}

dvec3 SectionGizmo::side_of(Part part) const {
  return part == Part::kRight ? right_ : part == Part::kLeft ? -right_ : part == Part::kUp ? up_ : -up_;
}

// --- dragging --------------------------------------------------------------------------------------------------------

std::optional<double> SectionGizmo::dragged(Part part, const dvec2& from, const dvec2& to) const {
  const dvec3& normal = section_.normal;
  if (!turns(part)) {
    if (std::abs(glm::dot(sight_, normal)) > kAlongSight) {
      const dvec2 arrow = handles_[1].at - middle();
      return pixel_ * glm::dot(to - from, arrow) / glm::length(arrow);
    }
    const auto begin = frame_.along_axis(from, anchor_, normal), end = frame_.along_axis(to, anchor_, normal);
    return begin && end ? std::optional(*end - *begin) : std::nullopt;
  }
  // The handle runs from its side of the square towards the normal.
  const dvec3 side = side_of(part), axis = glm::cross(side, normal);
  if (std::abs(glm::dot(sight_, axis)) < kEdgeOn) {
    const auto off = seen(kSquare * scale_ * pixel_ * side);
    if (!off || glm::length(*off) < kSlack) return std::nullopt;
    const double inwards = glm::dot(from - to, glm::normalize(*off));
    return (glm::dot(sight_, normal) < 0.0 ? inwards : -inwards) / (kPixelsPerRadian * scale_);
  }
  const auto begin = frame_.on_plane(from, anchor_, axis), end = frame_.on_plane(to, anchor_, axis);
  if (!begin || !end) return std::nullopt;
  const auto angle = [&](const dvec3& at) {
    return std::atan2(glm::dot(at - anchor_, normal), glm::dot(at - anchor_, side));
  };
  return std::remainder(angle(*end) - angle(*begin), 2.0 * 3.14159265358979323846);
}

Sections::Section SectionGizmo::moved(Part part, double by) const {
  Sections::Section section = section_;
  if (!turns(part)) {
    section.offset += by;
    return section;
  }
  section.normal = glm::normalize(std::cos(by) * section_.normal - std::sin(by) * side_of(part));
  section.point = anchor_;
  section.offset = 0.0;
  return section;
}

}  // namespace sightline::apps
