#include "sightline/gpuprims/cylinder.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/gpuprims/local_ray.h"
#include "sightline/gpuprims/mesh_builder.h"

namespace sightline::gpuprims {
namespace {

enum Face : int { kLateral, kBottom, kTop };

/// The part of the line within the infinite cylinder.
Span lateral_span(const LocalRay& ray, double radius) {
  Span span;
  const dvec2 o(ray.origin), u(ray.direction);
  const double across = glm::length(u);
  if (across == 0.0) {
    if (!(glm::length(o) <= radius)) span.clear();
    return span;
  }
  const double distance = std::fabs(cross(o, u)) / across;
  if (!(distance <= radius)) {
    span.clear();
    return span;
  }
  const double middle = -(glm::dot(o, u) / across) / across;
  const double half = std::sqrt((radius - distance) * (radius + distance)) / across;
  span.enter(middle - half, kLateral);
  span.leave(middle + half, kLateral);
  return span;
}

}  // namespace

template <class Real>
Hits intersect(const core::Cylinder& cylinder, const Ray& ray, Caps caps) {
  Hits hits;
  const double radius = std::fabs(cylinder.radius), height = std::fabs(cylinder.height);
  if (!(radius > 0.0 && std::isfinite(radius + height))) return hits;
  const LocalRay local = closest_approach(ray);
  if (!local.valid) return hits;

  Span span = lateral_span(local, radius);
  span.clip(0.5 * height + local.origin.z, local.direction.z, kBottom);
  span.clip(0.5 * height - local.origin.z, -local.direction.z, kTop);
  const bool edge_on_disc = height == 0.0 && local.direction.z == 0.0;
  if (span.empty() || edge_on_disc) return hits;

  const auto emit = [&](double s, int face) {
    if (face == kBottom) {
      if (caps.bottom) hits.insert({local.t(s), {0.0, 0.0, -1.0}});
    } else if (face == kTop) {
      if (caps.top) hits.insert({local.t(s), {0.0, 0.0, 1.0}});
    } else {
      hits.insert({local.t(s), {local.origin.x + s * local.direction.x, local.origin.y + s * local.direction.y, 0.0}});
    }
  };
  emit(span.from, span.from_face);
  emit(span.to, span.to_face);
  return hits;
}

template Hits intersect<double>(const core::Cylinder&, const Ray&, Caps);
template Hits intersect<float>(const core::Cylinder&, const Ray&, Caps);

core::Mesh tessellate(const core::Cylinder& cylinder, const Tessellation& config, Caps caps) {
  const double radius = std::fabs(cylinder.radius), half = 0.5 * std::fabs(cylinder.height);
  if (!(radius > 0.0 && std::isfinite(radius + half))) return {};
  const int segments = segment_count(config, radius, 2.0 * std::numbers::pi);
  const std::vector<dvec2> circle = arc_points(segments, 2.0 * std::numbers::pi);

  MeshBuilder builder;
  builder.add_grid(1, segments, [&](int row, int column) {
    return Vertex{dvec3(radius * circle[column], row == 0 ? -half : half), dvec3(circle[column], 0.0)};
  });
  std::vector<dvec3> rim(segments);
  if (caps.top) {
    for (int i = 0; i < segments; ++i) rim[i] = dvec3(radius * circle[i], half);
    builder.add_flat_polygon(rim, {0.0, 0.0, 1.0});
  }
  if (caps.bottom) {
    for (int i = 0; i < segments; ++i) rim[i] = dvec3(radius * circle[segments - i], -half);
    builder.add_flat_polygon(rim, {0.0, 0.0, -1.0});
  }
  return builder.finish();
}

}  // namespace sightline::gpuprims
