// Meshes of Open CASCADE's solids: closed, where they should be, as near as they say, and facing outwards.
#include <cmath>
#include <map>
#include <random>
#include <string>

#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepGProp.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Builder.hxx>
#include <GProp_GProps.hxx>
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <STEPControl_Reader.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <gp_Circ.hxx>
#include <gtest/gtest.h>

#include "sightline/importers/cad/internal/body_mesh.h"
#include "sightline/importers/cad/internal/occt_maths.h"
#include "sightline/tests/importers/cad_model.h"
#include "sightline/tests/importers/triangle_distance.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::cad_body_mesh_test {
namespace {

using core::dvec3;

class Numbers {
 public:
  explicit Numbers(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  std::uint32_t below(std::uint32_t n) { return std::uint32_t(engine_() % n); }

 private:
  std::mt19937 engine_;
};

/// Each face with one of `styles` looks, at random.
Body body_of(const TopoDS_Shape& shape, Numbers& numbers, std::uint32_t styles) {
  Body body{shape, {}};
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
    body.faces.push_back({TopoDS::Face(face.Current()), numbers.below(styles)});
  return body;
}

TopoDS_Shape drilled(Numbers& n) {
  TopoDS_Shape made = BRepPrimAPI_MakeBox(100.0, 60.0, 40.0).Solid();
  for (std::uint32_t i = 1 + n.below(4); i > 0; --i) {
    const gp_Dir along(n.between(-1, 1), n.between(-1, 1), n.between(0.2, 1));
    const gp_Pnt at = gp_Pnt(n.between(0, 100), n.between(0, 60), 20).Translated(-200 * gp_Vec(along));
    made = BRepAlgoAPI_Cut(made, BRepPrimAPI_MakeCylinder(gp_Ax2(at, along), n.between(1, 8), 400).Solid()).Shape();
  }
  return made;
}

TopoDS_Shape rounded(Numbers& n) {
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(n.between(20, 50), n.between(20, 50), n.between(20, 50)).Solid();
  BRepFilletAPI_MakeFillet fillet(box);
  const double radius = n.between(1, 9);
  for (TopExp_Explorer edge(box, TopAbs_EDGE); edge.More(); edge.Next())
    fillet.Add(radius, TopoDS::Edge(edge.Current()));
  return fillet.Shape();
}

TopoDS_Shape loft(Numbers& n) {
  BRepOffsetAPI_ThruSections made(Standard_True, Standard_False);
  for (int i = 0; i < 4; ++i) {
    const gp_Ax2 at(gp_Pnt(n.between(-9, 9), n.between(-9, 9), 30.0 * i),
                    gp_Dir(n.between(-0.2, 0.2), n.between(-0.2, 0.2), 1));
    made.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Circ(at, n.between(5, 20)))));
  }
  made.Build();
  return made.Shape();
}

TopoDS_Shape cone_minus_ball(Numbers& n) {
  const TopoDS_Shape cone = BRepPrimAPI_MakeCone(30.0, n.below(2) ? 0.0 : 5.0, 60.0).Solid();
  return BRepAlgoAPI_Cut(cone, BRepPrimAPI_MakeSphere(gp_Pnt(n.between(-5, 5), 20, 10), n.between(8, 15)).Solid());
}

TopoDS_Shape torus_minus_box(Numbers& n) {
  const TopoDS_Shape torus = BRepPrimAPI_MakeTorus(40.0, 12.0).Solid();
  return BRepAlgoAPI_Cut(torus, BRepPrimAPI_MakeBox(gp_Pnt(0, 0, n.between(-9, 9)), 80.0, 80.0, 80.0).Solid());
}

TopoDS_Shape sheet(Numbers& n) {
  TColgp_Array2OfPnt points(1, 6, 1, 6);
  for (int i = 1; i <= 6; ++i)
    for (int j = 1; j <= 6; ++j) points(i, j) = gp_Pnt(10 * i, 10 * j, n.between(0, 8));
  return BRepBuilderAPI_MakeFace(GeomAPI_PointsToBSplineSurface(points).Surface(), 1e-6).Shape();
}

struct Maker {
  const char* name;
  TopoDS_Shape (*make)(Numbers&);
  bool closed = true;
};
const Maker kMakers[] = {{"drilled box", drilled},
                         {"rounded box", rounded},
                         {"loft", loft},
                         {"cone minus a ball", cone_minus_ball},
                         {"torus minus a box", torus_minus_box},
                         {"sheet", sheet, false}};

/// All styles as one mesh.
core::Mesh whole_of(const BodyMesh& body) {
  core::Mesh all;
  for (const auto& [style, mesh] : body.meshes) {
    for (const std::uint32_t index : mesh.indices) all.indices.push_back(index + std::uint32_t(all.positions.size()));
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    all.normals.insert(all.normals.end(), mesh.normals.begin(), mesh.normals.end());
  }
  return all;
}

std::array<dvec3, 3> corners(const core::Mesh& mesh, std::size_t first, const dvec3& centre) {
  std::array<dvec3, 3> all;
  for (std::size_t k = 0; k < 3; ++k) all[k] = centre + dvec3(mesh.positions[mesh.indices[first + k]]);
  return all;
}

double to_mesh(const core::Mesh& mesh, const dvec3& centre, const dvec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    least = std::min(least, tests::distance_to_triangle(p, corners(mesh, i, centre)));
  return least;
}

/// The largest distance of random points of the faces from the triangles.
double dense_deviation(const Body& body, const core::Mesh& mesh, const dvec3& centre, Numbers& numbers, int samples) {
  double most = 0.0;
  for (int i = 0; i < samples; ++i) {
    const TopoDS_Face& face = body.faces[numbers.below(std::uint32_t(body.faces.size()))].face;
    const BRepAdaptor_Surface surface(face);
    double u0, u1, v0, v1;
    BRepTools::UVBounds(face, u0, u1, v0, v1);
    const gp_Pnt2d at(numbers.between(u0, u1), numbers.between(v0, v1));
    if (BRepTopAdaptor_FClass2d(face, 1e-9).Perform(at) != TopAbs_IN) continue;
    most = std::max(most, to_mesh(mesh, centre, from_occt(surface.Value(at.X(), at.Y()))));
  }
  return most;
}

double volume_of_triangles(const core::Mesh& mesh) {
  double six = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto [a, b, c] = corners(mesh, i, dvec3(0));
    six += glm::dot(a, glm::cross(b, c));
  }
  return six / 6.0;
}

/// Vertices' normals are on the side of their triangles, and long.
void expect_normals(const core::Mesh& mesh, const MeshQuality& quality) {
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const core::vec3& normal : mesh.normals) ASSERT_NEAR(glm::length(normal), 1.0f, 1e-5f);
  std::size_t against = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto [a, b, c] = corners(mesh, i, dvec3(0));
    const dvec3 across = glm::cross(b - a, c - a);
    // Slivers of rounded corners face anywhere.
    const double longest = std::max({glm::length(b - a), glm::length(c - a), glm::length(c - b)});
    if (glm::length(across) < quality.tolerance * longest) continue;
    dvec3 sum(0.0);
    for (std::size_t k = 0; k < 3; ++k) sum += dvec3(mesh.normals[mesh.indices[i + k]]);
    against += glm::dot(sum, across) < 0.0;
  }
  EXPECT_EQ(against, 0u);
}

TEST(CadBodyMesh, ClosedNearAndOutwards) {
  double worst = 0.0;
  for (const Maker& maker : kMakers)
    for (int seed = 1; seed <= tests::repeated(80); ++seed) {
      SCOPED_TRACE(std::string(maker.name) + ", seed " + std::to_string(seed));
      Numbers numbers(static_cast<unsigned>(seed));
      const TopoDS_Shape shape = maker.make(numbers);
      ASSERT_FALSE(shape.IsNull());
      const Body body = body_of(shape, numbers, 3);
      const MeshQuality quality{numbers.between(0.02, 0.5), 0.35};
      const BodyMesh made = mesh_body(body, quality);
      EXPECT_EQ(made.failed_faces, 0u);
      for (std::size_t i = 1; i < made.meshes.size(); ++i) EXPECT_LT(made.meshes[i - 1].style, made.meshes[i].style);
      for (const auto& [style, mesh] : made.meshes) EXPECT_TRUE(core::validate(mesh));
      const core::Mesh whole = whole_of(made);
      EXPECT_EQ(core::enclosure(whole), maker.closed ? core::Enclosure::kInside : core::Enclosure::kNothing);
      EXPECT_LE(made.deviation, quality.tolerance);
      expect_normals(whole, quality);
      // Four points of each triangle are measured: between them a surface goes at most half as far again.
      const double rounding = 1e-5;
      const double dense = dense_deviation(body, whole, made.centre, numbers, tests::repeated(1000));
      EXPECT_LE(dense, 1.5 * made.deviation + rounding);
      worst = std::max(worst, dense / (made.deviation + rounding));
      GProp_GProps volume, area;
      BRepGProp::VolumeProperties(shape, volume, 1e-4);
      BRepGProp::SurfaceProperties(shape, area, 1e-4);
      if (maker.closed) {
        EXPECT_NEAR(volume_of_triangles(whole), volume.Mass(), area.Mass() * quality.tolerance + 1e-4 * volume.Mass());
      }
    }
  RecordProperty("worst", std::to_string(worst));
}

TEST(CadBodyMesh, StylesShareTheirEdgesToTheBit) {
  Numbers numbers(7);
  const TopoDS_Shape shape = rounded(numbers);
  const BodyMesh made = mesh_body(body_of(shape, numbers, 2), {0.1, 0.35});
  ASSERT_EQ(made.meshes.size(), 2u);
  EXPECT_EQ(core::enclosure(made.meshes[0].mesh), core::Enclosure::kNothing);
  EXPECT_EQ(core::enclosure(made.meshes[1].mesh), core::Enclosure::kNothing);
  EXPECT_EQ(core::enclosure(whole_of(made)), core::Enclosure::kInside);
}

TEST(CadBodyMesh, MirroredAndFarAway) {
  for (const bool mirrored : {false, true}) {
    Numbers numbers(3);
    gp_Trsf by;
    if (mirrored) by.SetMirror(gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(1, 2, 3)));
    const TopoDS_Shape placed = BRepBuilderAPI_Transform(rounded(numbers), by, Standard_False).Shape();
    const TopoDS_Shape shape = placed.Moved(TopLoc_Location(tests::moved(1e7, -1e7, 3e6)));
    const BodyMesh made = mesh_body(body_of(shape, numbers, 1), {0.1, 0.35});
    ASSERT_EQ(made.meshes.size(), 1u);
    const core::Mesh& mesh = made.meshes[0].mesh;
    EXPECT_EQ(core::enclosure(mesh), core::Enclosure::kInside) << mirrored;
    expect_normals(mesh, {0.1, 0.35});
    EXPECT_LT(glm::length(mesh.positions[0]), 100.0f);
    EXPECT_GT(glm::length(made.centre), 1e7);
  }
}

TEST(CadBodyMesh, ANarrowToleranceIsKept) {
  Numbers numbers(5);
  const TopoDS_Shape shape = loft(numbers);
  std::size_t before = 0;
  for (const double tolerance : {1.0, 0.1, 0.02}) {
    const BodyMesh made = mesh_body(body_of(shape, numbers, 1), {tolerance, 1.0});
    EXPECT_LE(made.deviation, tolerance);
    const std::size_t triangles = made.meshes.at(0).mesh.indices.size();
    EXPECT_GT(triangles, before);
    before = triangles;
  }
}

/// The longitude at an apex or a pole says nothing: it must not look like a deviation, for which all is meshed finer.
TEST(CadBodyMesh, ApexesAndPolesTakeNoMoreTrianglesThanTheirSurroundings) {
  Numbers numbers(5);
  const auto triangles = [&](const TopoDS_Shape& shape) {
    const BodyMesh made = mesh_body(body_of(shape, numbers, 1), {0.05, 0.35});
    EXPECT_LE(made.deviation, 0.05);
    return made.meshes.at(0).mesh.indices.size() / 3;
  };
  EXPECT_LT(triangles(BRepPrimAPI_MakeCone(30.0, 0.0, 60.0).Solid()),
            2 * triangles(BRepPrimAPI_MakeCone(30.0, 1.0, 60.0).Solid()));
  EXPECT_LT(triangles(BRepPrimAPI_MakeSphere(30.0).Solid()),
            2 * triangles(BRepPrimAPI_MakeSphere(30.0, -1.5, 1.5).Solid()));
}

TEST(CadBodyMesh, LeavesNoTrianglesInTheBody) {
  Numbers numbers(5);
  const TopoDS_Shape shape = drilled(numbers);
  mesh_body(body_of(shape, numbers, 1), {0.1, 0.35});
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) {
    TopLoc_Location ignored;
    EXPECT_TRUE(BRep_Tool::Triangulation(TopoDS::Face(face.Current()), ignored).IsNull());
  }
}

TEST(CadBodyMesh, FacesThatCannotBeMeshedAreCounted) {
  // Next to a sound face one whose border crosses itself.
  BRepBuilderAPI_MakePolygon sound(gp_Pnt(0, 0, 0), gp_Pnt(1, 0, 0), gp_Pnt(1, 1, 0), gp_Pnt(0, 1, 0), Standard_True);
  BRepBuilderAPI_MakePolygon crossed(gp_Pnt(5, 0, 0), gp_Pnt(6, 1, 0), gp_Pnt(6, 0, 0), gp_Pnt(5, 1, 0), Standard_True);
  TopoDS_Compound both;
  BRep_Builder().MakeCompound(both);
  BRep_Builder().Add(both, BRepBuilderAPI_MakeFace(sound.Wire()).Face());
  BRep_Builder().Add(both, BRepBuilderAPI_MakeFace(gp_Pln(), crossed.Wire(), Standard_False).Face());
  Numbers numbers(1);
  const BodyMesh made = mesh_body(body_of(both, numbers, 1), {0.01, 0.35});
  EXPECT_EQ(made.failed_faces, 1u);
  ASSERT_EQ(made.meshes.size(), 1u);
  EXPECT_EQ(made.meshes[0].mesh.indices.size(), 6u);
}

TEST(CadBodyMesh, ASolidThatDoesNotCloseIsFound) {
  Numbers numbers(1);
  const TopoDS_Shape whole = drilled(numbers);
  EXPECT_EQ(mesh_body(body_of(whole, numbers, 1), {0.1, 0.35}).open_edges, 0u);
  TopoDS_Shell shell;
  BRep_Builder().MakeShell(shell);
  bool first = true;
  for (TopExp_Explorer face(whole, TopAbs_FACE); face.More(); face.Next(), first = false)
    if (!first) BRep_Builder().Add(shell, face.Current());
  TopoDS_Solid solid;
  BRep_Builder().MakeSolid(solid);
  BRep_Builder().Add(solid, shell);
  EXPECT_GE(mesh_body(body_of(solid, numbers, 2), {0.1, 0.35}).open_edges, 3u);
}

/// Open CASCADE takes a border within another one as a hole, whichever way it runs.
TEST(CadBodyMesh, AFaceWithAnotherAreaThanItsBordersIsNamedAndFarOff) {
  BRepBuilderAPI_MakePolygon outer(gp_Pnt(0, 0, 0), gp_Pnt(10, 0, 0), gp_Pnt(10, 10, 0), gp_Pnt(0, 10, 0),
                                   Standard_True);
  BRepBuilderAPI_MakePolygon inner(gp_Pnt(1, 1, 0), gp_Pnt(9, 1, 0), gp_Pnt(9, 9, 0), gp_Pnt(1, 9, 0), Standard_True);
  for (const bool hole : {true, false}) {
    BRepBuilderAPI_MakeFace face(outer.Wire());
    face.Add(hole ? TopoDS::Wire(inner.Wire().Reversed()) : inner.Wire());
    TopoDS_Compound both;
    BRep_Builder().MakeCompound(both);
    BRep_Builder().Add(both, BRepBuilderAPI_MakeFace(outer.Wire()).Face());
    BRep_Builder().Add(both, face.Face());
    Numbers numbers(1);
    const BodyMesh made = mesh_body(body_of(both, numbers, 1), {0.01, 0.35});
    EXPECT_EQ(made.wrong_faces, hole ? std::vector<std::size_t>{} : std::vector<std::size_t>{2}) << hole;
    EXPECT_EQ(made.deviation > 0.01, !hole);
  }
}

/// Open CASCADE 7.6 fails on this cone, but not on the same one as a spline.
TEST(CadBodyMesh, ConesThatFailAreMeshedAsSplines) {
  SIGHTLINE_NEED_DATA("step/conical-surface.step");
  STEPControl_Reader reader;
  const tests::CadModel quiet;
  ASSERT_EQ(reader.ReadFile(tests::data_path("step/conical-surface.step").c_str()), IFSelect_RetDone);
  reader.TransferRoots();
  const TopoDS_Shape shape = reader.OneShape();
  Numbers numbers(1);
  const BodyMesh made = mesh_body(body_of(shape, numbers, 2), {0.02, 0.35});
  EXPECT_EQ(made.failed_faces, 0u);
  EXPECT_LE(made.deviation, 0.02);
  const core::Mesh whole = whole_of(made);
  EXPECT_EQ(core::enclosure(whole), core::Enclosure::kInside);
  GProp_GProps volume;
  BRepGProp::VolumeProperties(shape, volume);
  EXPECT_NEAR(volume_of_triangles(whole), volume.Mass(), 1e-3 * volume.Mass());
}

}  // namespace
}  // namespace sightline::importers::cad_body_mesh_test
