// The samples of an image in exact arithmetic: the line of sight of every sample, in rationals, meets a box or not.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <gmpxx.h>

#include "scenes.h"
#include "sightline/core/view.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::tests {

using core::Aabb;
using core::View;
using culling::ImageSamples;

using Form = std::array<mpq_class, 4>;  // of a world point: three coefficients and the constant term

/// a - factor * b.
inline Form minus(const Form& a, const mpq_class& factor, const Form& b) {
  Form out;
  for (std::size_t i = 0; i < 4; ++i) out[i] = a[i] - factor * b[i];
  return out;
}

/// The cross product of the first three; the fourth is 0.
inline Form cross(const Form& p, const Form& q) {
  return {mpq_class(p[1] * q[2] - p[2] * q[1]), mpq_class(p[2] * q[0] - p[0] * q[2]),
          mpq_class(p[0] * q[1] - p[1] * q[0]), mpq_class(0)};
}

inline mpq_class value(const Form& form, const std::array<mpq_class, 3>& p) {
  return form[0] * p[0] + form[1] * p[1] + form[2] * p[2] + form[3];
}

/// Points at + s * along.
struct ExactLine {
  std::array<mpq_class, 3> at, along;

  std::array<mpq_class, 3> point(const mpq_class& s) const {
    return {mpq_class(at[0] + s * along[0]), mpq_class(at[1] + s * along[1]), mpq_class(at[2] + s * along[2])};
  }
};

/// The samples of an image, in rationals.
class ExactSamples {
 public:
  ExactSamples(const View& view, const core::dvec3& origin, const ImageSamples& samples) : samples_(samples) {
    const core::dmat4 clip = view.clip_from_world();
    for (int row = 0; row < 4; ++row) {
      Form& form = rows_[std::size_t(row)];
      for (int i = 0; i < 4; ++i) form[std::size_t(i)] = clip[i][row];
      for (int i = 0; i < 3; ++i) form[3] += form[std::size_t(i)] * mpq_class(origin[i]);
    }
    for (int i = 0; i < 4; ++i) distance_[std::size_t(i)] = -view.eye_from_world()[i][2];
    for (int i = 0; i < 3; ++i) distance_[3] += distance_[std::size_t(i)] * mpq_class(origin[i]);
  }

  /// Whether any sample's line of sight meets the box in front of the eye.
  bool covered_by(const Aabb& box) const {
    for (int y = 0; y < samples_.height; ++y)
      for (int x = 0; x < samples_.width; ++x)
        for (const auto& [ox, oy] : samples_.offsets)
          if (nearest(box, x, y, ox, oy)) return true;
    return false;
  }

  /// The least distance along the viewing direction at which a sample's line of sight meets the box in front of the
  /// eye.
  std::optional<mpq_class> nearest(const Aabb& box, int x, int y, float ox = 0.0f, float oy = 0.0f) const {
    return nearest(box, place(x, ox, samples_.width), place(y, oy, samples_.height));
  }

  /// Forms of world points relative to the origin: clip coordinates and the distance along the viewing direction.
  const Form& clip(int row) const { return rows_[std::size_t(row)]; }
  const Form& distance() const { return distance_; }
  /// The line of sight, also behind the eye. None where the projection has none.
  std::optional<ExactLine> line(int x, int y, float ox = 0.0f, float oy = 0.0f) const {
    return line(place(x, ox, samples_.width), place(y, oy, samples_.height));
  }

 private:
  static mpq_class place(int pixel, float offset, int size) {
    return (2 * mpq_class(pixel) + 1 + 2 * mpq_class(double(offset))) / size - 1;
  }

  /// The line is where clip.x = u clip.w and clip.y = v clip.w.
  std::optional<ExactLine> line(const mpq_class& u, const mpq_class& v) const {
    const Form a = minus(rows_[0], u, rows_[3]), b = minus(rows_[1], v, rows_[3]);
    const Form d = cross(a, b);
    const mpq_class square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    if (square == 0) return std::nullopt;
    const Form bd = cross(b, d), da = cross(d, a);
    ExactLine line;
    for (std::size_t k = 0; k < 3; ++k) {
      line.at[k] = -(a[3] * bd[k] + b[3] * da[k]) / square;
      line.along[k] = d[k];
    }
    return line;
  }

  std::optional<mpq_class> nearest(const Aabb& box, const mpq_class& u, const mpq_class& v) const {
    const auto sight = line(u, v);
    if (!sight) return std::nullopt;
    // Clipped by the slabs, then by clip.w > 0.
    bool bounded = false;
    mpq_class low, high;
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = std::size_t(i);
      const mpq_class& at = sight->at[k];
      const mpq_class from(double(box.min[i])), to(double(box.max[i]));
      if (sight->along[k] == 0) {
        if (at < from || at > to) return std::nullopt;
        continue;
      }
      mpq_class first = (from - at) / sight->along[k], last = (to - at) / sight->along[k];
      if (first > last) std::swap(first, last);
      if (!bounded || first > low) low = first;
      if (!bounded || last < high) high = last;
      bounded = true;
    }
    if (low > high) return std::nullopt;
    const auto first = sight->point(low), last = sight->point(high);
    if (value(rows_[3], first) <= 0 && value(rows_[3], last) <= 0) return std::nullopt;
    return std::min(value(distance_, first), value(distance_, last));
  }

  ImageSamples samples_;
  std::array<Form, 4> rows_;
  Form distance_;
};

/// A box that barely touches the line of sight of a sample, with a corner, an edge or a face, or barely misses it.
inline Aabb box_at_a_sample(Random& random, const View& view, const core::dvec3& origin, const ImageSamples& samples) {
  const auto& offset = samples.offsets[std::size_t(whole(random, 0, int(samples.offsets.size()) - 1))];
  const double u = (2.0 * (whole(random, 0, samples.width - 1) + double(offset[0])) + 1.0) / samples.width - 1.0;
  const double v = (2.0 * (whole(random, 0, samples.height - 1) + double(offset[1])) + 1.0) / samples.height - 1.0;
  const core::dmat4 world_from_clip = glm::inverse(view.clip_from_world());
  const auto at = [&](double depth) { return world_from_clip * core::dvec4(u, v, depth, 1.0); };
  const core::dvec4 point = at(uniform(random, 0.01, 0.99));
  const core::dvec3 touched = core::dvec3(point) / point.w - origin;
  const double size = glm::length(touched) * magnitude(random, 1e-6, 1.0);
  core::dvec3 low, high;
  for (int i = 0; i < 3; ++i) {
    const double shift = chance(random, 0.5) ? 0.0 : uniform(random, 0.0, size);
    low[i] = touched[i] - shift;
    high[i] = low[i] + (chance(random, 0.1) ? 0.0 : size);
  }
  return {core::vec3(low), core::vec3(high)};
}

/// A view of boxes about an origin, both of any size.
struct RandomSite {
  explicit RandomSite(Random& random)
      : half(magnitude(random, 1e-3, 1e4)),
        origin(chance(random, 0.5) ? core::dvec3(0.0) : point(random, 1e3 * half)),
        view(random_view(random, origin, half)) {}

  double half;
  core::dvec3 origin;
  View view;
};

}  // namespace sightline::tests
