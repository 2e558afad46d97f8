#include "sightline/importers/cad/internal/body_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <span>

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepGProp.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <IMeshTools_Parameters.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>

#include "sightline/importers/cad/internal/face_surface.h"
#include "sightline/importers/cad/internal/occt_maths.h"

namespace sightline::importers {
namespace {

using core::dvec3;

double distance_to_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 along = b - a;
  const double length2 = glm::dot(along, along);
  const double t = length2 > 0.0 ? std::clamp(glm::dot(p - a, along) / length2, 0.0, 1.0) : 0.0;
  return glm::length(p - a - t * along);
}

/// Whether a parameter does not count at a place, as the longitude at a pole.
struct Free {
  bool u = false, v = false;
};
constexpr double kNoSpeed = 1e-9;  // of the other parameter's
struct Place {
  gp_XY at;
  Free free;
};

/// The parameters of a triangle's corner. One that does not count there is that of the side between the other corners.
gp_XY seen_from(const std::array<Place, 3>& corners, std::size_t which) {
  const Place &corner = corners[which], &one = corners[(which + 1) % 3], &other = corners[(which + 2) % 3];
  const auto middle = [](double a, bool a_free, double b, bool b_free) {
    return a_free ? b : b_free ? a : 0.5 * (a + b);
  };
  return {corner.free.u ? middle(one.at.X(), one.free.u, other.at.X(), other.free.u) : corner.at.X(),
          corner.free.v ? middle(one.at.Y(), one.free.v, other.at.Y(), other.free.v) : corner.at.Y()};
}

/// The area of its surface that the borders of a face enclose; no number where Open CASCADE cannot tell.
double enclosed_area(const TopoDS_Face& face) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  if (!has_surface(face)) return kUnknown;
  try {
    GProp_GProps enclosed;
    BRepGProp::SurfaceProperties(face, enclosed);
    return std::abs(enclosed.Mass());
  } catch (const Standard_Failure&) {
    return kUnknown;
  }
}

/// A triangulated face, its nodes with the numbers of their positions in the body.
struct MeshedFace {
  std::uint32_t style;
  TopoDS_Face face;
  std::vector<std::uint32_t> positions;                 // of the nodes
  std::vector<core::vec3> normals;                      // of the nodes
  std::vector<std::array<std::uint32_t, 3>> triangles;  // of nodes, counter-clockwise from outside
  std::size_t number = 0;                               // in the body, from 1
};

/// The surface of a face whose triangles have these corners, of any kind where they lie farther off than the tolerance.
core::MeshSurface surface_at(const TopoDS_Face& face, const dvec3& centre, std::span<const core::vec3> corners,
                             double tolerance) {
  constexpr double kOfSize = 1e-5;  // splines that are a surface of a kind to less than this are one
  core::AabbD box;
  for (const core::vec3& p : corners) box.grow(dvec3(p));
  if (box.empty() || !has_surface(face)) return {};
  const auto found =
      face_surface(BRepAdaptor_Surface(face), std::max(BRep_Tool::Tolerance(face), kOfSize * glm::length(box.size())));
  if (!found) return {};
  core::MeshSurface made = mesh_surface(found->as);
  made.origin -= centre;
  for (const core::vec3& p : corners)
    made.gap = std::max(made.gap, glm::length(dvec3(p) - core::nearest_point(made, dvec3(p))));
  return made.gap <= tolerance ? made : core::MeshSurface();
}

/// Collects what the mesher has left in the faces of a body.
class Collection {
 public:
  explicit Collection(const Body& body) {
    TopExp::MapShapes(body.shape, TopAbs_EDGE, edges_);
    TopExp::MapShapes(body.shape, TopAbs_VERTEX, vertices_);
    at_vertex_.assign(std::size_t(vertices_.Extent()), core::kNone);
    along_edge_.resize(std::size_t(edges_.Extent()));
    for (std::size_t i = 0; i < body.faces.size(); ++i)
      if (has_surface(body.faces[i].face) ? add(body.faces[i]) : add_triangles(body.faces[i]))
        faces_.back().number = i + 1;
      else
        ++failed_;
    for (int i = 1; i <= edges_.Extent(); ++i) measure_rim(i);
  }

  double deviation() const { return deviation_; }
  std::uint64_t failed() const { return failed_; }

  /// All faces of a style as one mesh; vertices are shared where position and normal are the same. Faces whose
  /// triangles' corners lie within the tolerance of a surface of a kind keep it.
  BodyMesh meshes(double tolerance) const {
    BodyMesh made;
    core::AabbD box;
    for (const dvec3& p : positions_) box.grow(p);
    if (!box.empty()) made.centre = box.centre();
    std::map<std::uint32_t, Building> of_style;
    for (const MeshedFace& face : faces_) add(face, made.centre, tolerance, of_style[face.style]);
    for (auto& [style, building] : of_style) {
      if (building.mesh.indices.empty()) continue;
      const auto is_known = [](const core::MeshSurface& s) { return s.kind != core::MeshSurface::Kind::kOther; };
      if (std::ranges::any_of(building.surfaces, is_known))
        building.mesh.extras = core::MeshExtrasSlot(
            {nullptr, std::make_shared<const std::vector<core::MeshSurface>>(std::move(building.surfaces))});
      made.meshes.push_back({style, std::move(building.mesh)});
    }
    made.failed_faces = failed_;
    made.deviation = deviation_;
    return made;
  }

  /// Compares the areas of faces with what their borders enclose, and looks for gaps in a solid.
  void judge(const Body& body, double tolerance, BodyMesh& made) const {
    constexpr double kOfArea = 0.1, kOfStrip = 4.0;  // the strip along the border, as wide as the tolerance
    for (const MeshedFace& face : faces_) {
      const TopoDS_Face& exact = body.faces[face.number - 1].face;
      const double area = enclosed_area(exact), off = std::abs(area_of(face) - area), rim = rim_length(exact);
      if (!(off > kOfArea * area + kOfStrip * tolerance * rim)) continue;
      made.wrong_faces.push_back(face.number);
      made.deviation = std::max(made.deviation, rim > 0.0 ? off / rim : std::sqrt(off));
    }
    if (body.shape.ShapeType() != TopAbs_SOLID || failed_ > 0) return;
    std::vector<std::uint32_t> each(positions_.size());
    std::iota(each.begin(), each.end(), 0u);
    made.open_edges = open_edges(each);
    // Faces that share no edge may meet all the same.
    if (made.open_edges > 0) made.open_edges = open_edges(welded());
  }

 private:
  /// A mesh, and for each position its first vertex, from which others at the same place follow.
  struct Building {
    core::Mesh mesh;
    std::vector<core::MeshSurface> surfaces;  // of the faces so far
    std::vector<std::uint32_t> first, next;
  };

  bool add(const StyledFace& styled) {
    const TopoDS_Face& face = styled.face;
    TopLoc_Location location;
    const Handle(Poly_Triangulation) from = BRep_Tool::Triangulation(face, location);
    if (from.IsNull() || from->NbTriangles() == 0) return false;
    const gp_Trsf body_from_face = location.Transformation();
    MeshedFace made{styled.style, face, std::vector<std::uint32_t>(std::size_t(from->NbNodes()), core::kNone),
                    {},           {},   0};
    std::vector<dvec3> nodes;
    for (int i = 1; i <= from->NbNodes(); ++i) nodes.push_back(from_occt(from->Node(i).Transformed(body_from_face)));
    for (TopExp_Explorer edge(face, TopAbs_EDGE); edge.More(); edge.Next())
      share(TopoDS::Edge(edge.Current()), from, location, nodes, made.positions);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (made.positions[i] == core::kNone) made.positions[i] = position(nodes[i]);
    for (int i = 1; i <= from->NbTriangles(); ++i) {
      int a, b, c;
      from->Triangle(i).Get(a, b, c);
      if (face.Orientation() == TopAbs_REVERSED) std::swap(b, c);
      made.triangles.push_back({std::uint32_t(a - 1), std::uint32_t(b - 1), std::uint32_t(c - 1)});
    }
    examine(face, *from, made);
    faces_.push_back(std::move(made));
    return true;
  }

  /// A face without a surface. Points at the same place are one; corners without normals have their triangle's.
  bool add_triangles(const StyledFace& styled) {
    TopLoc_Location location;
    const Handle(Poly_Triangulation) from = BRep_Tool::Triangulation(styled.face, location);
    if (from.IsNull() || from->NbTriangles() == 0) return false;
    const gp_Trsf body_from_face = location.Transformation();
    const bool reversed = styled.face.Orientation() == TopAbs_REVERSED;
    MeshedFace made{styled.style, styled.face, {}, {}, {}, 0};
    for (int i = 1; i <= from->NbTriangles(); ++i) {
      std::array<int, 3> nodes;
      from->Triangle(i).Get(nodes[0], nodes[1], nodes[2]);
      if (reversed) std::swap(nodes[1], nodes[2]);
      std::array<dvec3, 3> at;
      for (std::size_t k = 0; k < 3; ++k) at[k] = from_occt(from->Node(nodes[k]).Transformed(body_from_face));
      const dvec3 across = glm::cross(at[1] - at[0], at[2] - at[0]);
      const double area2 = glm::length(across);
      if (!(area2 > 0.0)) continue;
      const auto first = std::uint32_t(made.positions.size());
      for (std::size_t k = 0; k < 3; ++k) {
        made.positions.push_back(welded_position(at[k]));
        const dvec3 stated =
            from->HasNormals() ? from_occt(from->Normal(nodes[k]).Transformed(body_from_face)) * (reversed ? -1.0 : 1.0)
                               : across / area2;
        made.normals.emplace_back(stated);
      }
      made.triangles.push_back({first, first + 1, first + 2});
    }
    faces_.push_back(std::move(made));
    return true;
  }

  std::uint32_t welded_position(const dvec3& at) {
    const auto [known, fresh] = welded_.try_emplace({at.x, at.y, at.z}, std::uint32_t(positions_.size()));
    if (fresh) positions_.push_back(at);
    return known->second;
  }

  std::uint32_t position(const dvec3& at) {
    positions_.push_back(at);
    return std::uint32_t(positions_.size() - 1);
  }

  std::uint32_t position_of(const TopoDS_Vertex& vertex, const dvec3& at) {
    std::uint32_t& known = at_vertex_[std::size_t(vertices_.FindIndex(vertex) - 1)];
    return known = known == core::kNone ? position(at) : known;
  }

  /// Gives a face's nodes along an edge the positions that the first face at this edge gave them.
  void share(const TopoDS_Edge& edge, const Handle(Poly_Triangulation) & of, const TopLoc_Location& location,
             const std::vector<dvec3>& nodes, std::vector<std::uint32_t>& positions) {
    const Handle(Poly_PolygonOnTriangulation) polygon = BRep_Tool::PolygonOnTriangulation(edge, of, location);
    const TopoDS_Vertex begin = TopExp::FirstVertex(edge), end = TopExp::LastVertex(edge);
    if (polygon.IsNull() || begin.IsNull() || end.IsNull()) return;
    const int count = polygon->NbNodes();
    std::vector<std::uint32_t>& known = along_edge_[std::size_t(edges_.FindIndex(edge) - 1)];
    const bool fresh = known.empty();
    if (fresh) known.resize(std::size_t(count), core::kNone);
    if (int(known.size()) != count) return;  // the mesher never divides an edge in two ways
    for (int i = 1; i <= count; ++i) {
      const std::size_t node = std::size_t(polygon->Node(i)) - 1;
      std::uint32_t& at = known[std::size_t(i) - 1];
      if (at == core::kNone) {
        const bool degenerated = BRep_Tool::Degenerated(edge);
        at = i == 1 || degenerated ? position_of(begin, nodes[node])
             : i == count          ? position_of(end, nodes[node])
                                   : position(nodes[node]);
      }
      positions[node] = at;
    }
  }

  /// Normals of the nodes, and the deviation of the triangles.
  void examine(const TopoDS_Face& face, const Poly_Triangulation& from, MeshedFace& made) {
    const BRepAdaptor_Surface surface(face);
    const double side = face.Orientation() == TopAbs_REVERSED ? -1.0 : 1.0;
    const bool has_places = from.HasUVNodes();
    const auto place = [&](std::uint32_t node) { return from.UVNode(int(node) + 1); };
    std::vector<dvec3> normals(made.positions.size(), dvec3(0.0));
    std::vector<Free> free(has_places ? normals.size() : 0);
    if (has_places)
      for (std::uint32_t i = 0; i < normals.size(); ++i) {
        gp_Pnt point;
        gp_Vec du, dv;
        surface.D1(place(i).X(), place(i).Y(), point, du, dv);
        const dvec3 across = from_occt(du.Crossed(dv));
        const double length = glm::length(across);
        if (length > 1e-9 * du.Magnitude() * dv.Magnitude() && std::isfinite(length))
          normals[i] = side / length * across;
        free[i] = {du.Magnitude() <= kNoSpeed * dv.Magnitude(), dv.Magnitude() <= kNoSpeed * du.Magnitude()};
      }
    const std::vector<dvec3> exact = normals;
    const bool curved = has_places && surface.GetType() != GeomAbs_Plane;
    for (const auto& [a, b, c] : made.triangles) {
      const dvec3 p = positions_[made.positions[a]], q = positions_[made.positions[b]],
                  r = positions_[made.positions[c]];
      const dvec3 across = glm::cross(q - p, r - p);
      const double area2 = glm::length(across);
      if (!(area2 > 0.0)) continue;
      // Where the surface has no normal, as at a cone's apex, that of the triangles stands in.
      for (const std::uint32_t node : {a, b, c})
        if (exact[node] == dvec3(0.0)) normals[node] += across;
      if (!curved) continue;
      const std::array<Place, 3> places{
          Place{place(a).XY(), free[a]}, {place(b).XY(), free[b]}, {place(c).XY(), free[c]}};
      const gp_XY u = seen_from(places, 0), v = seen_from(places, 1), w = seen_from(places, 2);
      for (const gp_XY& at : {0.5 * (u + v), 0.5 * (v + w), 0.5 * (w + u), (u + v + w) / 3.0}) {
        const dvec3 on = from_occt(surface.Value(at.X(), at.Y()));
        deviation_ = std::max(deviation_, std::abs(glm::dot(on - p, across)) / area2);
      }
    }
    made.normals.reserve(normals.size());
    for (const dvec3& n : normals) {
      const double length = glm::length(n);
      made.normals.emplace_back(length > 0.0 ? n / length : dvec3(0.0, 0.0, 1.0));
    }
  }

  /// The distance of an edge's curve from the chords between its points.
  void measure_rim(int index) {
    const TopoDS_Edge& edge = TopoDS::Edge(edges_(index));
    const std::vector<std::uint32_t>& points = along_edge_[std::size_t(index) - 1];
    if (points.size() < 2 || BRep_Tool::Degenerated(edge)) return;
    const BRepAdaptor_Curve curve(edge);
    if (!curve.Is3DCurve() || curve.GetType() == GeomAbs_Line) return;
    Handle(Poly_Triangulation) of;
    Handle(Poly_PolygonOnTriangulation) polygon;
    TopLoc_Location location;
    BRep_Tool::PolygonOnTriangulation(edge, polygon, of, location, 1);
    if (polygon.IsNull() || !polygon->HasParameters() || polygon->NbNodes() != int(points.size())) return;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const double middle = 0.5 * (polygon->Parameter(int(i) + 1) + polygon->Parameter(int(i) + 2));
      deviation_ = std::max(deviation_, distance_to_segment(from_occt(curve.Value(middle)), positions_[points[i]],
                                                            positions_[points[i + 1]]));
    }
  }

  double area_of(const MeshedFace& face) const {
    double area = 0.0;
    for (const auto& [a, b, c] : face.triangles) {
      const dvec3& p = positions_[face.positions[a]];
      area += 0.5 * glm::length(glm::cross(positions_[face.positions[b]] - p, positions_[face.positions[c]] - p));
    }
    return area;
  }

  double rim_length(const TopoDS_Face& face) const {
    double length = 0.0;
    for (TopExp_Explorer edge(face, TopAbs_EDGE); edge.More(); edge.Next()) {
      const std::vector<std::uint32_t>& points = along_edge_[std::size_t(edges_.FindIndex(edge.Current())) - 1];
      for (std::size_t i = 1; i < points.size(); ++i)
        length += glm::length(positions_[points[i]] - positions_[points[i - 1]]);
    }
    return length;
  }

  /// For each position the first one at the same place.
  std::vector<std::uint32_t> welded() const {
    std::map<std::array<double, 3>, std::uint32_t> numbers;
    std::vector<std::uint32_t> first;
    for (const dvec3& p : positions_)
      first.push_back(numbers.try_emplace({p.x, p.y, p.z}, std::uint32_t(first.size())).first->second);
    return first;
  }

  /// Edges of triangles that are not there as often in one direction as in the other, by numbers of positions.
  std::size_t open_edges(const std::vector<std::uint32_t>& numbers) const {
    std::vector<std::array<std::uint32_t, 3>> edges;  // both ends, and the direction
    for (const MeshedFace& face : faces_)
      for (const auto& triangle : face.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
          const std::uint32_t a = numbers[face.positions[triangle[k]]],
                              b = numbers[face.positions[triangle[(k + 1) % 3]]];
          if (a != b) edges.push_back({std::min(a, b), std::max(a, b), a < b});
        }
    std::sort(edges.begin(), edges.end());
    std::size_t open = 0;
    for (auto at = edges.begin(); at != edges.end();) {
      const auto end =
          std::find_if(at, edges.end(), [&](const auto& e) { return e[0] != (*at)[0] || e[1] != (*at)[1]; });
      open += 2 * std::count_if(at, end, [](const auto& e) { return e[2] == 1; }) != end - at;
      at = end;
    }
    return open;
  }

  void add(const MeshedFace& face, const dvec3& centre, double tolerance, Building& to) const {
    std::vector<core::vec3> corners;
    to.first.resize(positions_.size(), core::kNone);
    const auto vertex_of = [&](std::uint32_t node) {
      constexpr float kSame = 1.0f - 1e-6f;  // cosine
      const std::uint32_t position = face.positions[node];
      const core::vec3 normal = face.normals[node];
      std::uint32_t* at = &to.first[position];
      while (*at != core::kNone && glm::dot(to.mesh.normals[*at], normal) < kSame) at = &to.next[*at];
      if (*at != core::kNone) return *at;
      const auto fresh = std::uint32_t(to.mesh.positions.size());
      *at = fresh;
      to.next.push_back(core::kNone);
      to.mesh.positions.emplace_back(positions_[position] - centre);
      to.mesh.normals.push_back(normal);
      return fresh;
    };
    for (const auto& [a, b, c] : face.triangles) {
      const std::array<core::vec3, 3> p{core::vec3(positions_[face.positions[a]] - centre),
                                        core::vec3(positions_[face.positions[b]] - centre),
                                        core::vec3(positions_[face.positions[c]] - centre)};
      if (p[0] == p[1] || p[1] == p[2] || p[2] == p[0]) continue;  // its other two edges close the gap
      for (const std::uint32_t node : {a, b, c}) to.mesh.indices.push_back(vertex_of(node));
      corners.insert(corners.end(), p.begin(), p.end());
    }
    to.surfaces.push_back(surface_at(face.face, centre, corners, tolerance));
    to.surfaces.back().end_triangle = std::uint32_t(to.mesh.indices.size() / 3);
  }

  TopTools_IndexedMapOfShape edges_, vertices_;
  std::vector<std::uint32_t> at_vertex_;                // positions
  std::vector<std::vector<std::uint32_t>> along_edge_;  // positions
  std::vector<dvec3> positions_;
  std::map<std::array<double, 3>, std::uint32_t> welded_;  // positions of faces without edges
  std::vector<MeshedFace> faces_;
  std::uint64_t failed_ = 0;
  double deviation_ = 0.0;
};

void triangulate(const TopoDS_Shape& shape, double tolerance, double angle) {
  IMeshTools_Parameters parameters;
  parameters.Deflection = tolerance;
  parameters.Angle = angle;
  parameters.AllowQualityDecrease = Standard_True;  // what a file brought along says nothing of its tolerance
  BRepMesh_IncrementalMesh(shape, parameters);
}

BodyMesh mesh_within(const Body& body, const MeshQuality& quality) {
  constexpr int kTries = 4;
  constexpr double kBelow = 0.7;  // of the tolerance, that the next try aims at
  constexpr double kFiner = 0.1;  // at most, from one try to the next: triangles grow by the inverse
  constexpr double kHelps = 0.8;  // of the deviation before; what is above does not get better
  double wanted = quality.tolerance, before = std::numeric_limits<double>::infinity();
  for (int i = 1;; ++i) {
    BRepTools::Clean(body.shape);
    triangulate(body.shape, wanted, quality.angle);
    const Collection found(body);
    if (found.deviation() <= quality.tolerance || found.deviation() > kHelps * before || i == kTries) {
      BodyMesh made = found.meshes(quality.tolerance);
      found.judge(body, quality.tolerance, made);
      BRepTools::Clean(body.shape);
      return made;
    }
    before = found.deviation();
    wanted *= std::max(kFiner, kBelow * quality.tolerance / before);
  }
}

}  // namespace

Body changed(const Body& body, BRepBuilderAPI_ModifyShape& change) {
  Body made{change.Shape(), {}};
  TopTools_IndexedMapOfShape faces;  // with the orientation that they have in the body, unlike ModifiedShape()'s
  TopExp::MapShapes(made.shape, TopAbs_FACE, faces);
  for (const StyledFace& face : body.faces)
    if (const int at = faces.FindIndex(change.ModifiedShape(face.face)); at > 0)
      made.faces.push_back({TopoDS::Face(faces(at)), face.style});
  return made;
}

bool has_surface(const TopoDS_Face& face) {
  TopLoc_Location ignored;
  return !BRep_Tool::Surface(face, ignored).IsNull();
}

bool is_tessellated(const Body& body) {
  return std::none_of(body.faces.begin(), body.faces.end(),
                      [](const auto& styled) { return has_surface(styled.face); });
}

BodyMesh mesh_body(const Body& body, const MeshQuality& quality) {
  if (is_tessellated(body)) return Collection(body).meshes(quality.tolerance);
  BodyMesh made = mesh_within(body, quality);
  const auto faults = [](const BodyMesh& mesh) {
    return mesh.failed_faces + mesh.wrong_faces.size() + (mesh.open_edges > 0 ? 1 : 0);
  };
  if (faults(made) == 0) return made;
  // Open CASCADE 7.6 fails on some sound cones, but not on the same surfaces as splines.
  BRepBuilderAPI_NurbsConvert as_splines(body.shape);
  BodyMesh again = mesh_within(changed(body, as_splines), quality);
  return faults(again) < faults(made) ? again : made;
}

}  // namespace sightline::importers
