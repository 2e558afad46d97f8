#include "sightline/importers/cad/internal/face_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <BRepTools.hxx>
#include <TopoDS_Face.hxx>
#include <gp_Ax3.hxx>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <gp_Pln.hxx>
#include <gp_Sphere.hxx>
#include <gp_Torus.hxx>

#include "sightline/importers/cad/internal/occt_maths.h"

namespace sightline::importers {
namespace {

using core::dvec3;

std::optional<FaceSurface> stated(const BRepAdaptor_Surface& face) {
  FaceSurface found;
  SurfacePatch& as = found.as;
  const auto place = [&](const gp_Ax3& at) {
    as.origin = from_occt(at.Location());
    as.axis = from_occt(at.Direction());
  };
  switch (face.GetType()) {
    case GeomAbs_Plane:
      place(face.Plane().Position());
      return found;
    case GeomAbs_Cylinder:
      as.kind = SurfaceKind::kCylinder;
      place(face.Cylinder().Position());
      as.radius = face.Cylinder().Radius();
      return found;
    case GeomAbs_Cone:
      as.kind = SurfaceKind::kCone;
      place(face.Cone().Position());
      as.radius = face.Cone().RefRadius();
      as.slope = std::tan(face.Cone().SemiAngle());
      return found;
    case GeomAbs_Sphere:
      as.kind = SurfaceKind::kSphere;
      place(face.Sphere().Position());
      as.radius = face.Sphere().Radius();
      return found;
    case GeomAbs_Torus:
      as.kind = SurfaceKind::kTorus;
      place(face.Torus().Position());
      as.radius = face.Torus().MajorRadius();
      as.tube_radius = face.Torus().MinorRadius();
      return found;
    default:
      return std::nullopt;
  }
}

/// Points of a face, spread evenly over its parameters.
class Samples {
 public:
  static constexpr int kSide = 17;

  explicit Samples(const BRepAdaptor_Surface& face) {
    double u0, u1, v0, v1;
    BRepTools::UVBounds(face.Face(), u0, u1, v0, v1);
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        const double s = double(i) / (kSide - 1), t = double(j) / (kSide - 1);
        points_[std::size_t(i)][std::size_t(j)] =
            from_occt(face.Value((1.0 - s) * u0 + s * u1, (1.0 - t) * v0 + t * v1));
      }
  }

  dvec3 at(int i, int j) const { return points_[std::size_t(i)][std::size_t(j)]; }
  /// The points of the middle line along one parameter.
  dvec3 middle(bool along_u, int i) const { return along_u ? at(i, kSide / 2) : at(kSide / 2, i); }

  std::optional<FaceSurface> within(const SurfacePatch& surface, double tolerance) const {
    FaceSurface found{surface, 0.0};
    const core::MeshSurface whole = mesh_surface(surface);
    for (const auto& row : points_)
      for (const dvec3& p : row) found.gap = std::max(found.gap, glm::length(p - core::nearest_point(whole, p)));
    if (!(found.gap <= tolerance)) return std::nullopt;
    return found;
  }

 private:
  std::array<std::array<dvec3, kSide>, kSide> points_;
};

struct Circle {
  dvec3 centre, normal;
  double radius;
};

/// The circle through three points; nothing where they lie on a line.
std::optional<Circle> circle_through(const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 p = b - a, q = c - a, across = glm::cross(p, q);
  const double squared = glm::dot(across, across), size = std::max(glm::dot(p, p), glm::dot(q, q));
  constexpr double kStraight = 1e-5;  // of sagitta to chord, about
  if (!(squared > kStraight * kStraight * size * size)) return std::nullopt;
  const dvec3 to_centre =
      (glm::dot(p, p) * glm::cross(q, across) + glm::dot(q, q) * glm::cross(across, p)) / (2.0 * squared);
  return Circle{a + to_centre, across / std::sqrt(squared), glm::length(to_centre)};
}

std::optional<Circle> circle_along(const Samples& samples, bool along_u) {
  constexpr int kThird = Samples::kSide / 3;  // not the ends, which meet where a curve is closed
  return circle_through(samples.middle(along_u, 0), samples.middle(along_u, kThird),
                        samples.middle(along_u, 2 * kThird));
}

SurfacePatch plane_of(const Samples& samples) {
  constexpr int kLast = Samples::kSide - 1;
  SurfacePatch plane;
  plane.origin = samples.at(kLast / 2, kLast / 2);
  const dvec3 across =
      glm::cross(samples.at(kLast, kLast) - samples.at(0, 0), samples.at(kLast, 0) - samples.at(0, kLast));
  if (glm::length(across) > 0.0) plane.axis = glm::normalize(across);
  return plane;
}

/// Whose sections across its axis are circles such as this one, and whose other lines are straight.
SurfacePatch round_about(const Circle& circle, const dvec3& p, const dvec3& q, double tolerance) {
  SurfacePatch surface;
  surface.origin = circle.centre;
  surface.axis = circle.normal;
  surface.radius = circle.radius;
  const auto place = [&](const dvec3& at) {
    const double along = glm::dot(at - circle.centre, circle.normal);
    return std::pair(along, glm::length(at - circle.centre - along * circle.normal));
  };
  const auto [h0, r0] = place(p);
  const auto [h1, r1] = place(q);
  // Rounding of points makes a slope, too: a cone that is a cylinder to a fraction of the tolerance is one.
  constexpr double kNoSlope = 0.1;
  if (h1 == h0 || std::abs(r1 - r0) <= kNoSlope * tolerance) {
    surface.kind = SurfaceKind::kCylinder;
    return surface;
  }
  surface.kind = SurfaceKind::kCone;
  surface.slope = (r1 - r0) / (h1 - h0);
  return surface;
}

SurfacePatch sphere_of(const Circle& one, const Circle& other) {
  SurfacePatch sphere;
  sphere.kind = SurfaceKind::kSphere;
  // The centre lies on the axes of both circles.
  const dvec3 between = other.centre - one.centre, across = glm::cross(one.normal, other.normal);
  const double squared = glm::dot(across, across);
  const double along = squared > 0.0 ? glm::dot(glm::cross(between, other.normal), across) / squared : 0.0;
  sphere.origin = one.centre + along * one.normal;
  sphere.radius = std::hypot(along, one.radius);
  return sphere;
}

/// `parallel` runs about the axis, `tube` in a plane through it.
SurfacePatch torus_of(const Circle& parallel, const Circle& tube) {
  SurfacePatch torus;
  torus.kind = SurfaceKind::kTorus;
  torus.axis = parallel.normal;
  const double along = glm::dot(tube.centre - parallel.centre, torus.axis);
  torus.origin = parallel.centre + along * torus.axis;
  torus.radius = glm::length(tube.centre - torus.origin);
  torus.tube_radius = tube.radius;
  return torus;
}

std::optional<FaceSurface> sampled(const BRepAdaptor_Surface& face, double tolerance) {
  const Samples samples(face);
  const auto u = circle_along(samples, true), v = circle_along(samples, false);
  constexpr int kLast = Samples::kSide - 1;
  if (!u && !v) return samples.within(plane_of(samples), tolerance);
  if (!u || !v)
    return samples.within(
        round_about(u ? *u : *v, samples.middle(!u.has_value(), 0), samples.middle(!u.has_value(), kLast), tolerance),
        tolerance);
  for (const SurfacePatch& candidate : {sphere_of(*u, *v), torus_of(*u, *v), torus_of(*v, *u)})
    if (auto found = samples.within(candidate, tolerance)) return found;
  return std::nullopt;
}

}  // namespace

std::optional<FaceSurface> face_surface(const BRepAdaptor_Surface& face, double tolerance) {
  auto found = stated(face);
  return found ? found : sampled(face, tolerance);
}

core::MeshSurface mesh_surface(const SurfacePatch& patch) {
  constexpr core::MeshSurface::Kind kKinds[] = {core::MeshSurface::Kind::kPlane, core::MeshSurface::Kind::kCylinder,
                                                core::MeshSurface::Kind::kCone, core::MeshSurface::Kind::kSphere,
                                                core::MeshSurface::Kind::kTorus};
  core::MeshSurface made;
  made.kind = kKinds[std::size_t(patch.kind)];
  made.origin = patch.origin, made.axis = patch.axis;
  made.radius = patch.radius, made.tube_radius = patch.tube_radius, made.slope = patch.slope;
  return made;
}

}  // namespace sightline::importers
