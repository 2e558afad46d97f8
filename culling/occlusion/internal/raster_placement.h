// Internal: places in the image of an occluder's points, with bounds for what rounding takes. See occluder_raster.h.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sightline/core/affine.h"
#include "sightline/culling/occlusion/detail/occluder_image.h"
#include "sightline/culling/occlusion/internal/occluder_area.h"

namespace sightline::culling::raster {

/// A linear form of an occluder's own coordinates.
struct Form {
  core::dvec4 row;
  double size, lost;  // bounds for its values, and for what they are off by

  Form() = default;
  /// `eye_from_own`: to the eye as origin, axes as in the world. No coordinate exceeds `magnitudes`.
  Form(const EyeForm& form, const core::Affine& eye_from_own, const core::dvec3& magnitudes) {
    const core::dmat3& m = eye_from_own.linear;
    row = core::dvec4(form.normal * m, glm::dot(form.normal, eye_from_own.origin) + form.at_eye);
    const core::dvec3 coordinates = glm::abs(eye_from_own.origin) + glm::abs(m[0]) * magnitudes.x +
                                    glm::abs(m[1]) * magnitudes.y + glm::abs(m[2]) * magnitudes.z;
    size = glm::dot(form.sizes, coordinates) + std::abs(form.at_eye);
    lost = kLost * size + form.lost;
  }
  /// Made from coordinates relative to the eye.
  Form(const EyeForm& form, const core::dvec3& magnitudes)
      : row(form.normal, form.at_eye),
        size(glm::dot(form.sizes, magnitudes) + std::abs(form.at_eye)),
        lost(kLost * size + form.lost) {}
  double operator()(const core::dvec3& p) const { return row.x * p.x + row.y * p.y + row.z * p.z + row.w; }
  /// The least value in a box.
  double least(const core::dvec3& low, const core::dvec3& high) const {
    return (*this)({row.x > 0.0 ? low.x : high.x, row.y > 0.0 ? low.y : high.y, row.z > 0.0 ? low.z : high.z});
  }
};

struct Point {
  double x, y, z, near;
};

/// Place in the image, and reciprocal depth: 1 / z, or -z in orthographic views. x and y are off by less than `error`;
/// reciprocal depth is not greater than the exact one. A corner that cannot be used has a NaN error.
struct Corner {
  double x, y, reciprocal_depth, error;
};

/// An occluder's own coordinates in a view.
class Placement {
 public:
  /// Made from coordinates relative to the eye.
  Placement(const OccluderImage& view, const core::dvec3& magnitudes)
      : Placement(view, magnitudes, [](const EyeForm& form, const core::dvec3& most) { return Form(form, most); }) {}
  Placement(const OccluderImage& view, const core::Affine& eye_from_own, const core::dvec3& magnitudes)
      : Placement(view, magnitudes,
                  [&](const EyeForm& form, const core::dvec3& most) { return Form(form, eye_from_own, most); }) {}

  Point operator()(const core::dvec3& p) const { return {x_(p), y_(p), z_(p), near_(p)}; }

  /// A bit for each section plane that surely keeps p.
  unsigned kept(const core::dvec3& p) const {
    unsigned bits = 0;
    for (unsigned i = 0; i < section_count_; ++i) bits |= unsigned(sections_[i](p) > sections_[i].lost) << i;
    return bits;
  }
  /// Whether the section planes leave a convex solid whole; of its points' bits those that all have.
  bool whole(unsigned kept) const {
    const unsigned all = (1u << section_count_) - 1u;
    return section_mode_ == core::SectionMode::kUnion && all != 0 ? (kept & all) != 0 : (kept & all) == all;
  }

  static constexpr int kClipPlanes = 2;
  /// Greater than 0 where clip plane k leaves a point: the near plane, or one so far in front of the eye that places in
  /// the image still are exact.
  double inside(int k, const Point& p) const { return (k == 0 ? p.near : p.z) - least_[k]; }
  bool in_front(const Point& p) const { return inside(0, p) > 0.0 && inside(1, p) > 0.0; }

  /// Point::near of the eye, for coordinates relative to it.
  double near_at_eye() const { return near_.row.w; }

  /// Whether all of a box is kept and in front.
  bool leaves_whole(const core::dvec3& low, const core::dvec3& high) const {
    if (!(near_.least(low, high) > least_[0] && z_.least(low, high) > least_[1])) return false;
    unsigned bits = 0;
    for (unsigned i = 0; i < section_count_; ++i)
      bits |= unsigned(sections_[i].least(low, high) > sections_[i].lost) << i;
    return whole(bits);
  }

  /// Projects a point in front of the eye.
  Corner project(const Point& p) const {
    const double lost = std::max(x_.lost, y_.lost);
    if (!perspective_) {
      const double place = std::max(std::abs(p.x), std::abs(p.y));
      return usable({p.x, p.y, -p.z - z_.lost - kLost * std::abs(p.z), lost + kPlaceLost * place});
    }
    const double reciprocal_depth = 1.0 / p.z, off = z_.lost * reciprocal_depth;
    if (!(off >= 0.0 && off < 0x1p-6 && p.z < kLarge)) return unusable();
    const double x = p.x * reciprocal_depth, y = p.y * reciprocal_depth, place = std::max(std::abs(x), std::abs(y));
    return usable({x, y, reciprocal_depth * (1.0 - 1.1 * off - kLost),
                   1.1 * (lost * reciprocal_depth + place * off) + kPlaceLost * place});
  }
  /// Greater than 0 where the placement mirrors: faces then wind the other way.
  double handedness() const {
    return glm::dot(core::dvec3(x_.row), glm::cross(core::dvec3(y_.row), core::dvec3(z_.row)));
  }

 private:
  template <class Make>
  Placement(const OccluderImage& view, const core::dvec3& magnitudes, const Make& form)
      : perspective_(view.perspective),
        section_mode_(view.section_mode),
        x_(form(view.x, magnitudes)),
        y_(form(view.y, magnitudes)),
        z_(form(view.z, magnitudes)),
        near_(form(view.near, magnitudes)),
        least_{2.0 * near_.lost, least_z()} {
    for (const EyeForm& section : view.sections) sections_[section_count_++] = form(section, magnitudes);
  }
  /// At this distance x / z is off by some 2^-8 pixels because of z.
  double least_z() const {
    return perspective_ ? 16.0 * std::sqrt(kLost) * std::sqrt(std::max(x_.size, y_.size) * z_.size)
                        : -std::numeric_limits<double>::infinity();
  }
  static Corner unusable() { return {0.0, 0.0, 0.0, std::numeric_limits<double>::quiet_NaN()}; }
  static Corner usable(const Corner& c) {
    const double most = std::max({std::abs(c.x), std::abs(c.y), std::abs(c.reciprocal_depth)});
    return c.error < kMostError && most < kLarge ? c : unusable();
  }

  bool perspective_;
  core::SectionMode section_mode_;
  Form x_, y_, z_, near_;
  double least_[kClipPlanes];
  unsigned section_count_ = 0;
  std::array<Form, core::kMaxSectionPlanes> sections_;
};

}  // namespace sightline::culling::raster
