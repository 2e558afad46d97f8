#include "sightline/importers/recognise/internal/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sightline::importers::recognition {
namespace {

using core::dvec2;
using core::dvec3;

/// Signed distance of a solid that is the intersection of two, from their signed distances at right angles.
double both(double a, double b) {
  return a > 0.0 && b > 0.0 ? std::hypot(a, b) : std::max(a, b);
}

SurfaceDistance distance_of(const core::Cylinder& c) {
  return [r = std::fabs(double(c.radius)), half = 0.5 * std::fabs(double(c.height))](const dvec3& p) {
    return std::fabs(both(std::hypot(p.x, p.y) - r, std::fabs(p.z) - half));
  };
}

SurfaceDistance distance_of(const core::Snout& s) {
  const double height = s.height, bottom = s.bottom_radius, top = s.top_radius;
  const dvec2 offset(s.offset_x, s.offset_y), lean = offset / height;
  const double widening = (top - bottom) / height, steep = std::sqrt(1.0 + widening * widening);
  const dvec2 low(std::tan(double(s.bottom_shear_x)), std::tan(double(s.bottom_shear_y)));
  const dvec2 high(std::tan(double(s.top_shear_x)), std::tan(double(s.top_shear_y)));
  const double per_low = 1.0 / std::sqrt(1.0 + glm::dot(low, low)),
               per_high = 1.0 / std::sqrt(1.0 + glm::dot(high, high));
  return [=](const dvec3& p) {
    const dvec2 q(p.x, p.y);
    const double side = (glm::length(q - lean * p.z) - (0.5 * (bottom + top) + widening * p.z)) / steep;
    const double above = (p.z - 0.5 * height - glm::dot(high, q - 0.5 * offset)) * per_high;
    const double below = (-p.z - 0.5 * height + glm::dot(low, q + 0.5 * offset)) * per_low;
    return std::fabs(std::max({side, above, below}));
  };
}

/// A profile, given by its signed distance at (rho, z), swept about z.
template <class Profile>
SurfaceDistance swept(double sweep, const Profile& profile) {
  return [=](const dvec3& p) {
    const double rho = std::hypot(p.x, p.y), inside = profile(rho, p.z);
    if (sweep >= core::kFullTurn) return std::fabs(inside);
    double azimuth = std::atan2(p.y, p.x);
    if (azimuth < 0.0) azimuth += core::kFullTurn;
    const double beyond = std::min(azimuth - sweep, core::kFullTurn - azimuth);
    constexpr double kSquare = 0.5 * std::numbers::pi;
    if (azimuth > sweep) {
      if (beyond >= kSquare) return std::hypot(rho, std::max(0.0, profile(0.0, p.z)));  // from the axis
      return std::hypot(rho * std::sin(beyond), std::max(0.0, profile(rho * std::cos(beyond), p.z)));
    }
    const double within = std::min({azimuth, sweep - azimuth, kSquare});
    return std::fabs(std::max(inside, -rho * std::sin(within)));
  };
}

SurfaceDistance distance_of(const core::CircularTorus& t) {
  const double major = std::fabs(t.major_radius), tube = std::fabs(t.tube_radius);
  return swept(core::sweep_angle(t.angle), [=](double rho, double z) { return std::hypot(rho - major, z) - tube; });
}

SurfaceDistance distance_of(const core::RectangularTorus& t) {
  const double middle = 0.5 * (double(t.inner_radius) + t.outer_radius),
               half_width = 0.5 * std::fabs(double(t.outer_radius) - t.inner_radius),
               half_height = 0.5 * std::fabs(double(t.height));
  return swept(core::sweep_angle(t.angle), [=](double rho, double z) {
    return both(std::fabs(rho - middle) - half_width, std::fabs(z) - half_height);
  });
}

SurfaceDistance distance_of(const core::Sphere& s) {
  return [r = 0.5 * double(s.diameter)](const dvec3& p) { return std::fabs(glm::length(p) - r); };
}

SurfaceDistance distance_of(const core::SphericalDish& d) {
  const double base = d.base_radius, height = d.height, r = 0.5 * (base * base / height + height);
  return [=](const dvec3& p) { return std::fabs(std::max(glm::length(dvec3(p.x, p.y, p.z - height + r)) - r, -p.z)); };
}

SurfaceDistance distance_of(const core::EllipticalDish& d) {
  const double base = d.base_radius, height = d.height;
  return [=](const dvec3& p) {
    const double rho = std::hypot(p.x, p.y);
    const double unit = std::hypot(rho / base, p.z / height),
                 slope = std::hypot(rho / (base * base), p.z / (height * height));
    const double side = slope > 0.0 ? unit * (unit - 1.0) / slope : -std::min(base, height);
    return std::fabs(std::max(side, -p.z));
  };
}

SurfaceDistance distance_of(const core::Box& b) {
  return [half = 0.5 * dvec3(b.size_x, b.size_y, b.size_z)](const dvec3& p) {
    const dvec3 d = glm::abs(p) - half;
    const double inside = std::max({d.x, d.y, d.z});
    return inside <= 0.0 ? -inside : glm::length(glm::max(d, dvec3(0.0)));
  };
}

SurfaceDistance distance_of(const core::Pyramid& p) {
  const double half = 0.5 * double(p.height);
  std::array<dvec3, 4> low, high, normals;
  for (int i = 0; i < 4; ++i) {
    const double x = i == 1 || i == 2 ? 0.5 : -0.5, y = i >= 2 ? 0.5 : -0.5;
    low[i] = {x * p.bottom_x - 0.5 * p.offset_x, y * p.bottom_y - 0.5 * p.offset_y, -half};
    high[i] = {x * p.top_x + 0.5 * p.offset_x, y * p.top_y + 0.5 * p.offset_y, half};
  }
  for (int i = 0; i < 4; ++i) {
    const int n = (i + 1) % 4;
    const dvec3 normal = glm::cross((low[n] - low[i]) + (high[n] - high[i]), (high[i] - low[i]) + (high[n] - low[n]));
    const double length = glm::length(normal);
    normals[i] = length > 0.0 ? normal / length : dvec3(0.0);
  }
  return [=](const dvec3& q) {
    double most = std::fabs(q.z) - half;
    for (int i = 0; i < 4; ++i) most = std::max(most, glm::dot(normals[i], q - 0.5 * (low[i] + high[i])));
    return std::fabs(most);
  };
}

SurfaceDistance distance_of(const core::Line&) {
  return [](const dvec3&) { return std::numeric_limits<double>::infinity(); };
}

}  // namespace

SurfaceDistance surface_distance(const core::Primitive& primitive) {
  return std::visit([](const auto& p) { return distance_of(p); }, primitive);
}

}  // namespace sightline::importers::recognition
