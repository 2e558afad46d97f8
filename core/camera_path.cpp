#include "sightline/core/camera_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace sightline::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
using Channels = std::array<double, 7>;

Channels channels(const CameraKey& key) {
  const dvec3 &e = key.pose.eye, &t = key.pose.target;
  return {e.x, e.y, e.z, t.x, t.y, t.z, std::log(std::tan(0.5 * key.fovy))};
}

/// Second derivatives at the keys of the natural cubic spline of one channel: the tridiagonal system of C. de Boor,
/// "A Practical Guide to Splines", chapter IV, solved by elimination without pivoting (it is diagonally dominant).
class NaturalSpline {
 public:
  explicit NaturalSpline(const std::vector<CameraKey>& keys) : keys_(keys), values_(keys.size()) {
    std::transform(keys.begin(), keys.end(), values_.begin(), channels);
  }

  std::vector<Channels> solve() const {
    const std::size_t n = keys_.size();
    std::vector<Channels> second(n, Channels{});
    std::vector<double> upper(n, 0.0);
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double h0 = step(i - 1), h1 = step(i);
      const double lambda = h0 / (h0 + h1);
      const double pivot = 2.0 + lambda * upper[i - 1];
      upper[i] = (lambda - 1.0) / pivot;
      for (std::size_t c = 0; c < second[i].size(); ++c) {
        const double bend = (slope(i, c) - slope(i - 1, c)) * (6.0 / (h0 + h1));
        second[i][c] = (bend - lambda * second[i - 1][c]) / pivot;
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      if (i + 1 >= n) continue;
      for (std::size_t c = 0; c < second[i].size(); ++c) second[i][c] += upper[i] * second[i + 1][c];
    }
    return second;
  }

 private:
  double step(std::size_t i) const { return keys_[i + 1].time - keys_[i].time; }
  double slope(std::size_t i, std::size_t c) const { return (values_[i + 1][c] - values_[i][c]) / step(i); }

  const std::vector<CameraKey>& keys_;
  std::vector<Channels> values_;
};

dvec3 eye_of(const Channels& v) {
  return {v[0], v[1], v[2]};
}
dvec3 target_of(const Channels& v) {
  return {v[3], v[4], v[5]};
}

/// One span of the spline at parameter u in [0, 1].
struct Segment {
  Channels from, to, second_from, second_to;
  double duration;

  Channels at(double u) const {
    const double v = 1.0 - u, scale = duration * duration / 6.0;
    Channels out;
    for (std::size_t c = 0; c < out.size(); ++c)
      out[c] = v * from[c] + u * to[c] + ((v * v * v - v) * second_from[c] + (u * u * u - u) * second_to[c]) * scale;
    return out;
  }
};

/// Largest component by magnitude: no overflow, unlike a length.
double magnitude(const dvec3& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

dvec3 unit(const dvec3& v) {
  const double m = magnitude(v);
  return m > 0.0 ? glm::normalize(v / m) : dvec3(0.0);
}

/// True when rounding alone could have made the difference between the two points.
bool coincide(const dvec3& a, const dvec3& b) {
  const double noise = 64.0 * std::numeric_limits<double>::epsilon();
  return magnitude(a - b) <= noise * std::max(magnitude(a), magnitude(b));
}

/// The target for a moment at which it coincides with the eye. It lies on the line of sight of the nearest earlier
/// moment that has one.
dvec3 keep_line_of_sight(const Segment& segment, double u, const dvec3& eye) {
  dvec3 sight = target_of(segment.from) - eye_of(segment.from);
  for (double back = 1e-9; back < u; back *= 2.0) {
    const Channels before = segment.at(u - back);
    if (coincide(eye_of(before), target_of(before))) continue;
    sight = target_of(before) - eye_of(before);
    break;
  }
  const double visible_length = std::max(magnitude(sight), 1e-6 * std::max(1.0, magnitude(eye)));
  return eye + unit(sight) * visible_length;
}

dvec3 unit_up(const dvec3& up) {
  const dvec3 u = unit(up);
  return u == dvec3(0.0) ? dvec3(0.0, 0.0, 1.0) : u;
}

/// The part of `v` at right angles to the unit vector `axis`, normalised; any such direction when there is none.
dvec3 perpendicular(const dvec3& v, const dvec3& axis) {
  const dvec3 p = v - glm::dot(v, axis) * axis;
  if (magnitude(p) > 1e-9) return glm::normalize(p);
  const dvec3 other = std::fabs(axis.x) < 0.7 ? dvec3(1.0, 0.0, 0.0) : dvec3(0.0, 1.0, 0.0);
  return glm::normalize(other - glm::dot(other, axis) * axis);
}

/// Turns up vectors along the great circle; antipodal ones about the line of sight of the first key.
dvec3 turn_up(const Pose& from, const Pose& to, double u) {
  const dvec3 a = unit_up(from.up), b = unit_up(to.up);
  const double sine = glm::length(glm::cross(a, b)), cosine = glm::dot(a, b);
  if (sine < 1e-7 && cosine > 0.0) return unit_up(glm::mix(a, b, u));
  const bool antipodal = sine < 1e-7;
  const dvec3 aside = antipodal ? glm::cross(perpendicular(unit(from.target - from.eye), a), a) : perpendicular(b, a);
  const double ease = u * u * u * (10.0 + u * (6.0 * u - 15.0));
  const double angle = (antipodal ? kPi : std::atan2(sine, cosine)) * ease;
  return glm::normalize(std::cos(angle) * a + std::sin(angle) * aside);
}

bool same_camera(const CameraKey& a, const CameraKey& b) {
  return a.pose.eye == b.pose.eye && a.pose.target == b.pose.target && a.pose.up == b.pose.up && a.fovy == b.fovy;
}

std::string name_of(std::size_t key) {
  return "camera key " + std::to_string(key) + ": ";
}

/// What is wrong with the key on its own; empty when nothing is.
std::string complaint(const CameraKey& key) {
  if (!std::isfinite(key.time)) return "time must be a finite number";
  if (!is_finite(key.pose.eye)) return "eye must be three finite numbers";
  if (!is_finite(key.pose.target)) return "target must be three finite numbers";
  if (!is_finite(key.pose.up)) return "up must be three finite numbers";
  if (key.pose.eye == key.pose.target) return "eye and target must differ";
  if (!(key.fovy > 0.0 && key.fovy < kPi)) return "field of view must lie between 0 and pi radians (0 and 180 degrees)";
  return {};
}

bool all_finite(const std::vector<Channels>& values) {
  return std::all_of(values.begin(), values.end(), [](const Channels& v) {
    return std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
  });
}

}  // namespace

Expected<CameraPath> CameraPath::create(std::vector<CameraKey> keys) {
  if (keys.empty()) return fail("camera path: needs at least one key");
  CameraPath path;
  path.keys_.reserve(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::string problem = complaint(keys[i]);
    if (!problem.empty()) return fail(name_of(i) + problem);
    if (!path.keys_.empty() && keys[i].time <= path.keys_.back().time) {
      if (keys[i].time < path.keys_.back().time)
        return fail(name_of(i) + "time must not be earlier than that of the key before it");
      if (!same_camera(keys[i], path.keys_.back()))
        return fail(name_of(i) + "has the time of the key before it but another pose");
      continue;
    }
    path.keys_.push_back(keys[i]);
  }
  path.second_derivatives_ = NaturalSpline(path.keys_).solve();
  if (!all_finite(path.second_derivatives_))
    return fail("camera path: key times are too close together for the distance between their poses");
  return path;
}

CameraSample CameraPath::sample(double time) const {
  assert(!keys_.empty());
  const auto at_key = [](const CameraKey& key) {
    return CameraSample{{key.pose.eye, key.pose.target, unit_up(key.pose.up)}, key.fovy};
  };
  if (!(time > begin())) return at_key(keys_.front());
  if (time >= end()) return at_key(keys_.back());
  const auto after =
      std::upper_bound(keys_.begin(), keys_.end(), time, [](double t, const CameraKey& k) { return t < k.time; });
  const std::size_t i = std::size_t(after - keys_.begin()) - 1;
  const CameraKey &from = keys_[i], &to = keys_[i + 1];
  if (time == from.time) return at_key(from);

  const double duration = to.time - from.time, u = (time - from.time) / duration;
  const Segment segment{channels(from), channels(to), second_derivatives_[i], second_derivatives_[i + 1], duration};
  const Channels now = segment.at(u);
  CameraSample out{{eye_of(now), target_of(now), turn_up(from.pose, to.pose, u)}, 2.0 * std::atan(std::exp(now[6]))};
  if (coincide(out.pose.eye, out.pose.target)) out.pose.target = keep_line_of_sight(segment, u, out.pose.eye);
  return out;
}

Expected<View> CameraPath::view(double time, double aspect) const {
  const CameraSample at = sample(time);
  return View::perspective(at.pose, at.fovy, aspect, near, far);
}

double CameraPath::time_of(int frame, int frames) const {
  const double share = frames > 1 ? double(frame) / (frames - 1) : 0.0;
  return begin() + share * (end() - begin());
}

}  // namespace sightline::core
