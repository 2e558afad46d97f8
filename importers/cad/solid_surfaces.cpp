#include "sightline/importers/cad/internal/solid_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepGProp.hxx>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Precision.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Vertex.hxx>
#include <gp_Circ.hxx>
#include <gp_Elips.hxx>

#include "sightline/core/internal/disjoint_sets.h"
#include "sightline/importers/cad/internal/face_surface.h"
#include "sightline/importers/cad/internal/occt_maths.h"

namespace sightline::importers {
namespace {

using core::dvec3;

/// How far apart two surfaces are, at most, within a reach of their origins; more than any tolerance where they are of
/// different kinds.
double distance(const SurfacePatch& a, const SurfacePatch& b, double reach) {
  if (a.kind != b.kind || a.convex != b.convex) return reach;
  const double turned = glm::length(glm::cross(a.axis, b.axis)) * reach;
  const dvec3 apart = b.origin - a.origin;
  const double along = glm::dot(apart, a.axis), aside = glm::length(apart - along * a.axis);
  switch (a.kind) {
    case SurfaceKind::kPlane:
      return glm::dot(a.axis, b.axis) < 0.0 ? reach : std::abs(along) + turned;
    case SurfaceKind::kCylinder:
      return aside + turned + std::abs(a.radius - b.radius);
    case SurfaceKind::kCone: {
      const double slope = glm::dot(a.axis, b.axis) < 0.0 ? -b.slope : b.slope;
      return aside + turned + std::abs(a.radius + along * a.slope - b.radius) + std::abs(a.slope - slope) * reach;
    }
    case SurfaceKind::kSphere:
      return glm::length(apart) + std::abs(a.radius - b.radius);
    case SurfaceKind::kTorus:
      return glm::length(apart) + turned + std::abs(a.radius - b.radius) + std::abs(a.tube_radius - b.tube_radius);
  }
  return reach;
}

/// Parameters of a point within a face's borders: those in the middle if they are. Tries ever finer grids.
gp_Pnt2d within(const TopoDS_Face& face) {
  double u0, u1, v0, v1;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  const BRepTopAdaptor_FClass2d borders(face, Precision::PConfusion());
  constexpr int kFinest = 32;
  for (int grid = 2; grid <= kFinest; grid *= 2)
    for (int i = 1; i < grid; ++i)
      for (int j = 1; j < grid; ++j) {
        const gp_Pnt2d at(u0 + (u1 - u0) * i / grid, v0 + (v1 - v0) * j / grid);
        if (borders.Perform(at) == TopAbs_IN) return at;
      }
  return {0.5 * (u0 + u1), 0.5 * (v0 + v1)};
}

/// Outwards, and on which side the solid lies.
void orient(SurfacePatch& patch, const BRepAdaptor_Surface& face) {
  const gp_Pnt2d at = within(face.Face());
  gp_Pnt point;
  gp_Vec du, dv;
  face.D1(at.X(), at.Y(), point, du, dv);
  dvec3 out = from_occt(du.Crossed(dv));
  if (face.Face().Orientation() == TopAbs_REVERSED) out = -out;
  patch.inside = from_occt(point);
  const dvec3 away = patch.inside - patch.origin, aside = away - glm::dot(away, patch.axis) * patch.axis;
  switch (patch.kind) {
    case SurfaceKind::kPlane:
      if (glm::dot(out, patch.axis) < 0.0) patch.axis = -patch.axis;
      break;
    case SurfaceKind::kCylinder:
    case SurfaceKind::kCone:
      patch.convex = glm::dot(out, aside) > 0.0;
      break;
    case SurfaceKind::kSphere:
      patch.convex = glm::dot(out, away) > 0.0;
      break;
    case SurfaceKind::kTorus:
      patch.convex = glm::dot(out, away - patch.radius * glm::normalize(aside)) > 0.0;
      break;
  }
}

/// Points of edges that form one curve, and the plane that a circle or an ellipse among them states.
struct Curve {
  std::vector<dvec3> points;
  std::optional<dvec3> normal;

  void add(const TopoDS_Edge& edge) {
    constexpr int kSamples = 8;
    const BRepAdaptor_Curve curve(edge);
    for (int i = 0; i <= kSamples; ++i) {
      const double t = double(i) / kSamples;
      points.push_back(from_occt(curve.Value((1.0 - t) * curve.FirstParameter() + t * curve.LastParameter())));
    }
    if (curve.GetType() == GeomAbs_Circle) normal = from_occt(curve.Circle().Axis().Direction());
    if (curve.GetType() == GeomAbs_Ellipse) normal = from_occt(curve.Ellipse().Axis().Direction());
  }

  /// The normal of the largest triangle with the first point and the one farthest from it.
  dvec3 fitted() const {
    const auto far = *std::max_element(points.begin(), points.end(), [&](const dvec3& a, const dvec3& b) {
      return glm::length(a - points[0]) < glm::length(b - points[0]);
    });
    dvec3 best(0.0);
    for (const dvec3& p : points) {
      const dvec3 across = glm::cross(far - points[0], p - points[0]);
      if (glm::length(across) > glm::length(best)) best = across;
    }
    return best == dvec3(0.0) ? dvec3(0.0, 0.0, 1.0) : glm::normalize(best);
  }

  Border border(std::uint32_t neighbour) const {
    Border made{neighbour, dvec3(0.0), normal ? *normal : fitted()};
    for (const dvec3& p : points) made.centre += p / double(points.size());
    for (const dvec3& p : points)
      made.off_plane = std::max(made.off_plane, std::abs(glm::dot(p - made.centre, made.normal)));
    return made;
  }
};

/// Makes one solid's SolidSurfaces.
class Extraction {
 public:
  explicit Extraction(const TopoDS_Shape& solid) : solid_(solid) {}

  std::optional<SolidSurfaces> run() {
    TopTools_IndexedMapOfShape shells;
    TopExp::MapShapes(solid_, TopAbs_SHELL, shells);
    TopExp::MapShapes(solid_, TopAbs_FACE, faces_);
    TopExp::MapShapesAndAncestors(solid_, TopAbs_EDGE, TopAbs_FACE, edges_);
    constexpr int kMostFaces = 500;  // what has more is no primitive, and its faces would be compared in vain
    if (shells.Extent() != 1 || faces_.Extent() == 0 || faces_.Extent() > kMostFaces) return std::nullopt;
    find_corners();
    if (!find_surfaces() || !join_faces()) return std::nullopt;
    if (!measure()) return std::nullopt;
    find_borders();
    return std::move(made_);
  }

 private:
  void find_corners() {
    TopTools_IndexedMapOfShape vertices;
    TopExp::MapShapes(solid_, TopAbs_VERTEX, vertices);
    core::AabbD box;
    double tolerance = 0.0;
    for (int i = 1; i <= vertices.Extent(); ++i) {
      box.grow(from_occt(BRep_Tool::Pnt(TopoDS::Vertex(vertices(i)))));
      tolerance = std::max(tolerance, BRep_Tool::Tolerance(TopoDS::Vertex(vertices(i))));
    }
    for (int i = 1; i <= faces_.Extent(); ++i) {
      const BRepAdaptor_Surface face(TopoDS::Face(faces_(i)));
      double u0, u1, v0, v1;
      BRepTools::UVBounds(face.Face(), u0, u1, v0, v1);
      for (const double u : {u0, 0.5 * (u0 + u1)})
        for (const double v : {v0, 0.5 * (v0 + v1)}) box.grow(from_occt(face.Value(u, v)));
    }
    reach_ = glm::length(box.size());
    constexpr double kLeast = 1e-9, kMost = 1e-4;  // of the size
    made_.tolerance = std::clamp(tolerance, kLeast * reach_, kMost * reach_);
    for (int i = 1; i <= vertices.Extent(); ++i) {
      const dvec3 p = from_occt(BRep_Tool::Pnt(TopoDS::Vertex(vertices(i))));
      const bool known = std::any_of(made_.corners.begin(), made_.corners.end(),
                                     [&](const dvec3& q) { return glm::length(p - q) <= made_.tolerance; });
      if (!known) made_.corners.push_back(p);
    }
  }

  bool find_surfaces() {
    for (int i = 1; i <= faces_.Extent(); ++i) {
      const BRepAdaptor_Surface face(TopoDS::Face(faces_(i)));
      auto found = face_surface(face, made_.tolerance);
      if (!found || found->gap > made_.tolerance) return false;
      orient(found->as, face);
      surfaces_.push_back(std::move(*found));
    }
    return true;
  }

  /// False where an edge has not two sides.
  bool join_faces() {
    core::DisjointSets sets(surfaces_.size());
    for (int i = 1; i <= edges_.Extent(); ++i) {
      if (BRep_Tool::Degenerated(TopoDS::Edge(edges_.FindKey(i)))) continue;
      const auto sides = sides_of(i);
      if (!sides) return false;
      const double apart = distance(surfaces_[sides->first].as, surfaces_[sides->second].as, reach_);
      if (sides->first == sides->second || apart > made_.tolerance) continue;
      sets.merge(sides->first, sides->second);
      made_.merge_error = std::max(made_.merge_error, apart);
    }
    patch_of_.assign(surfaces_.size(), 0);
    std::map<std::uint32_t, std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < surfaces_.size(); ++i) {
      const auto [at, fresh] = numbers.try_emplace(sets.find(i), std::uint32_t(numbers.size()));
      if (fresh) made_.patches.push_back(surfaces_[i].as);
      patch_of_[i] = at->second;
      made_.merge_error = std::max(made_.merge_error, surfaces_[i].gap);
    }
    return true;
  }

  /// Faces, by their index, on both sides of an edge: the same one twice for a seam.
  std::optional<std::pair<std::uint32_t, std::uint32_t>> sides_of(int edge) const {
    std::vector<std::uint32_t> sides;
    for (const TopoDS_Shape& face : edges_(edge)) sides.push_back(std::uint32_t(faces_.FindIndex(face) - 1));
    if (sides.size() == 1 &&
        BRep_Tool::IsClosed(TopoDS::Edge(edges_.FindKey(edge)), TopoDS::Face(faces_(int(sides[0]) + 1))))
      sides.push_back(sides[0]);
    if (sides.size() != 2) return std::nullopt;
    return std::pair(sides[0], sides[1]);
  }

  bool measure() {
    GProp_GProps volume;
    BRepGProp::VolumeProperties(solid_, volume, kPrecise);
    made_.volume = volume.Mass();
    for (int i = 1; i <= faces_.Extent(); ++i) {
      GProp_GProps area;
      BRepGProp::SurfaceProperties(faces_(i), area, kPrecise);
      made_.patches[patch_of_[std::size_t(i) - 1]].area += area.Mass();
    }
    return made_.volume > 0.0;
  }

  /// Edges between the same two patches that hang together are one curve.
  void find_borders() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<TopoDS_Edge>> between;
    for (int i = 1; i <= edges_.Extent(); ++i) {
      const TopoDS_Edge& edge = TopoDS::Edge(edges_.FindKey(i));
      if (BRep_Tool::Degenerated(edge)) continue;
      const auto sides = sides_of(i);
      const std::uint32_t a = patch_of_[sides->first], b = patch_of_[sides->second];
      if (a != b) between[std::minmax(a, b)].push_back(edge);
    }
    for (const auto& [patches, edges] : between) {
      core::DisjointSets sets(edges.size());
      for (std::uint32_t i = 0; i < edges.size(); ++i)
        for (std::uint32_t j = 0; j < i; ++j) {
          TopoDS_Vertex shared;
          if (TopExp::CommonVertex(edges[i], edges[j], shared)) sets.merge(i, j);
        }
      std::map<std::uint32_t, Curve> curves;
      for (std::uint32_t i = 0; i < edges.size(); ++i) curves[sets.find(i)].add(edges[i]);
      for (const auto& [set, curve] : curves) {
        made_.patches[patches.first].borders.push_back(curve.border(patches.second));
        made_.patches[patches.second].borders.push_back(curve.border(patches.first));
      }
    }
  }

  static constexpr double kPrecise = 1e-9;  // relative error of integrals

  const TopoDS_Shape& solid_;
  TopTools_IndexedMapOfShape faces_;
  TopTools_IndexedDataMapOfShapeListOfShape edges_;
  std::vector<FaceSurface> surfaces_;    // of the faces
  std::vector<std::uint32_t> patch_of_;  // of the faces
  double reach_ = 0.0;
  SolidSurfaces made_;
};

}  // namespace

std::optional<SolidSurfaces> solid_surfaces(const TopoDS_Shape& solid) {
  return Extraction(solid).run();
}

}  // namespace sightline::importers
