#include "sightline/importers/cad/internal/step_spheres.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include <Geom_Curve.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Precision.hxx>
#include <Standard_Failure.hxx>
#include <StepGeom_Axis2Placement3d.hxx>
#include <StepGeom_BSplineCurve.hxx>
#include <StepGeom_SphericalSurface.hxx>
#include <StepGeom_SurfaceCurve.hxx>
#include <StepShape_Edge.hxx>
#include <StepShape_EdgeCurve.hxx>
#include <StepShape_EdgeLoop.hxx>
#include <StepShape_FaceBound.hxx>
#include <StepShape_FaceSurface.hxx>
#include <StepShape_Loop.hxx>
#include <StepShape_OrientedEdge.hxx>
#include <StepToGeom.hxx>
#include <TCollection_HAsciiString.hxx>
#include <gp_Sphere.hxx>

#include "sightline/core/primitive.h"
#include "sightline/importers/cad/internal/occt_maths.h"
#include "sightline/importers/cad/internal/step_model.h"

namespace sightline::importers {
namespace {

using core::dvec3;

/// Points along the borders of a face: of splines, and of all else. Circles count as a whole.
struct Rim {
  std::vector<dvec3> splines, others;
};

void sample(const Handle(StepGeom_Curve) & stated, Rim& rim) {
  constexpr int kSamples = 512;
  const auto on_surface = Handle(StepGeom_SurfaceCurve)::DownCast(stated);
  const Handle(StepGeom_Curve) in_space = on_surface.IsNull() ? stated : on_surface->Curve3d();
  const Handle(Geom_Curve) curve = StepToGeom::MakeCurve(in_space);
  if (curve.IsNull() || Precision::IsInfinite(curve->FirstParameter()) || Precision::IsInfinite(curve->LastParameter()))
    return;
  std::vector<dvec3>& to = in_space->IsKind(STANDARD_TYPE(StepGeom_BSplineCurve)) ? rim.splines : rim.others;
  for (int i = 0; i <= kSamples; ++i) {
    const double t = double(i) / kSamples;
    to.push_back(from_occt(curve->Value((1.0 - t) * curve->FirstParameter() + t * curve->LastParameter())));
  }
}

/// Nothing where a face has a seam, which is there for good reason.
std::optional<Rim> rim_of(const StepShape_FaceSurface& face) {
  Rim rim;
  std::set<const void*> seen;
  for (int i = 1; i <= (face.Bounds().IsNull() ? 0 : face.NbBounds()); ++i) {
    const Handle(StepShape_FaceBound) bound = face.BoundsValue(i);
    const auto loop = Handle(StepShape_EdgeLoop)::DownCast(bound.IsNull() ? Handle(StepShape_Loop)() : bound->Bound());
    if (loop.IsNull() || loop->EdgeList().IsNull()) return std::nullopt;
    for (int k = 1; k <= loop->NbEdgeList(); ++k) {
      const Handle(StepShape_OrientedEdge) oriented = loop->EdgeListValue(k);
      const auto edge =
          Handle(StepShape_EdgeCurve)::DownCast(oriented.IsNull() ? Handle(StepShape_Edge)() : oriented->EdgeElement());
      if (edge.IsNull() || edge->EdgeGeometry().IsNull() || !seen.insert(edge.get()).second) return std::nullopt;
      sample(edge->EdgeGeometry(), rim);
    }
  }
  return rim;
}

/// The least angle about the axis between a half circle from pole to pole and points; those near the poles do not
/// count.
double least_angle(const std::vector<dvec3>& points, const core::Affine& sphere, double radius, double seam) {
  constexpr double kPole = 0.05;  // of the radius
  double least = core::kFullTurn;
  for (const dvec3& p : points) {
    const dvec3 at = glm::transpose(sphere.linear) * (p - sphere.origin);
    if (std::hypot(at.x, at.y) < kPole * radius) continue;
    least = std::min(least, std::abs(std::remainder(std::atan2(at.y, at.x) - seam, core::kFullTurn)));
  }
  return least;
}

void turn(const Handle(StepShape_FaceSurface) & face, const Handle(StepGeom_SphericalSurface) & stated) {
  constexpr double kNear = 1e-3;
  constexpr int kSeams = 16;
  const auto rim = rim_of(*face);
  const Handle(Geom_SphericalSurface) sphere = StepToGeom::MakeSphericalSurface(stated);
  if (sphere.IsNull() || !rim) return;
  const gp_Ax3& axes = sphere->Position();
  const core::Affine frame{{from_occt(axes.XDirection()), from_occt(axes.YDirection()), from_occt(axes.Direction())},
                           from_occt(axes.Location())};
  if (least_angle(rim->splines, frame, sphere->Radius(), 0.0) > kNear) return;
  double best = 0.0, farthest = 0.0;
  for (int i = 1; i < kSeams; ++i) {
    const double seam = core::kFullTurn * i / kSeams;
    const double angle = std::min(least_angle(rim->splines, frame, sphere->Radius(), seam),
                                  least_angle(rim->others, frame, sphere->Radius(), seam));
    if (angle <= farthest) continue;
    farthest = angle;
    best = seam;
  }
  const Handle(StepGeom_Axis2Placement3d) place = new StepGeom_Axis2Placement3d;
  place->Init(stated->Name(), stated->Position()->Location(), Standard_True, step_direction(frame.linear[2]),
              Standard_True, step_direction(frame.linear * dvec3(std::cos(best), std::sin(best), 0.0)));
  const Handle(StepGeom_SphericalSurface) turned = new StepGeom_SphericalSurface;
  turned->Init(stated->Name(), place, stated->Radius());
  face->SetFaceGeometry(turned);
}

}  // namespace

void turn_sphere(const Handle(StepShape_FaceSurface) & face) {
  const auto sphere = Handle(StepGeom_SphericalSurface)::DownCast(face->FaceGeometry());
  if (sphere.IsNull()) return;
  try {
    turn(face, sphere);
  } catch (const Standard_Failure&) {  // damaged curves are the transfer's to judge
  }
}

}  // namespace sightline::importers
