// Solids that Open CASCADE makes: what becomes primitives has the same surface and volume, and what is of no primitive
// stays what it is.
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_GTransform.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepGProp.hxx>
#include <BRepOffsetAPI_MakePipe.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepPrimAPI_MakeWedge.hxx>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <GProp_GProps.hxx>
#include <ShapeUpgrade_ShapeDivideAngle.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Solid.hxx>
#include <gp_Circ.hxx>
#include <gp_GTrsf.hxx>
#include <gtest/gtest.h>

#include "sightline/importers/cad/internal/analytic_solid.h"
#include "sightline/importers/cad/internal/occt_maths.h"
#include "sightline/importers/cad/internal/solid_surfaces.h"
#include "sightline/tests/importers/primitive_distance.h"
#include "sightline/tests/support/effort.h"

namespace sightline::importers::cad_analytic_solid_test {
namespace {

using core::dvec3;
using core::Kind;

constexpr double kPi = std::numbers::pi;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double real(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  int below(int n) { return int(engine_() % unsigned(n)); }
  bool one_in(int n) { return below(n) == 0; }
  /// Exact as a float, and so are sums of some.
  double length(double low = 1.0, double high = 50.0) { return std::round(64.0 * real(low, high)) / 64.0; }
  gp_Dir direction() {
    for (;;) {
      const gp_XYZ v(real(-1, 1), real(-1, 1), real(-1, 1));
      if (v.Modulus() > 0.1 && v.Modulus() < 1.0) return gp_Dir(v);
    }
  }

 private:
  std::mt19937 engine_;
};

TopoDS_Shape only_solid(const TopoDS_Shape& shape) {
  TopExp_Explorer solid(shape, TopAbs_SOLID);
  const TopoDS_Shape found = solid.More() ? solid.Current() : TopoDS_Shape();
  if (solid.More()) solid.Next();
  return solid.More() ? TopoDS_Shape() : found;
}

gp_Ax2 at_height(double z, double x = 0.0) {
  return {gp_Pnt(x, 0, z), gp_Dir(0, 0, 1)};
}
TopoDS_Shape cylinder(double radius, double height, double z = 0.0, double x = 0.0) {
  return BRepPrimAPI_MakeCylinder(at_height(z, x), radius, height).Solid();
}
TopoDS_Shape fused(const TopoDS_Shape& a, const TopoDS_Shape& b) {
  return only_solid(BRepAlgoAPI_Fuse(a, b).Shape());
}
TopoDS_Shape cut(const TopoDS_Shape& a, const TopoDS_Shape& b) {
  return only_solid(BRepAlgoAPI_Cut(a, b).Shape());
}

TopoDS_Face rectangle(double x0, double x1, double z0, double z1) {
  BRepBuilderAPI_MakePolygon made(gp_Pnt(x0, 0, z0), gp_Pnt(x1, 0, z0), gp_Pnt(x1, 0, z1), gp_Pnt(x0, 0, z1),
                                  Standard_True);
  return BRepBuilderAPI_MakeFace(made.Wire()).Face();
}
TopoDS_Face disc(const gp_Ax2& at, double radius) {
  return BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Circ(at, radius))).Wire()).Face();
}

/// What lies below a plane through (0, 0, z) that leans by an angle.
TopoDS_Shape below_slanted(const TopoDS_Shape& of, double z, double angle, double direction) {
  constexpr double kFar = 1e4;
  const gp_Dir normal(std::sin(angle) * std::cos(direction), std::sin(angle) * std::sin(direction), std::cos(angle));
  const gp_Pnt at(0, 0, z);
  const TopoDS_Shape face = BRepBuilderAPI_MakeFace(gp_Pln(at, normal), -kFar, kFar, -kFar, kFar).Shape();
  return cut(of, BRepPrimAPI_MakePrism(face, kFar * gp_Vec(normal)).Shape());
}

/// Along x, through a bend, and on; joined of three solids, or swept.
TopoDS_Shape pipe_run(Random& random, bool swept) {
  const double tube = random.length(1, 5), bend = random.length(6, 30), first = random.length(), last = random.length();
  const double angle = swept ? 0.5 * kPi : random.real(0.2, 3.0);
  const gp_Pnt centre(first, bend, 0), corner(first, 0, 0), begin(0, 0, 0);
  const gp_Dir along(std::cos(angle), std::sin(angle), 0);
  const gp_Pnt after(first + bend * std::sin(angle), bend - bend * std::cos(angle), 0);
  const gp_Pnt end = after.Translated(last * gp_Vec(along));
  const TopoDS_Face profile = disc(gp_Ax2(begin, gp_Dir(1, 0, 0)), tube);
  if (swept) {
    const gp_Pnt middle(first + bend * std::sin(0.5 * angle), bend - bend * std::cos(0.5 * angle), 0);
    BRepBuilderAPI_MakeWire path(BRepBuilderAPI_MakeEdge(begin, corner),
                                 BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(corner, middle, after).Value()),
                                 BRepBuilderAPI_MakeEdge(after, end));
    return only_solid(BRepOffsetAPI_MakePipe(path.Wire(), profile).Shape());
  }
  const TopoDS_Shape torus =
      BRepPrimAPI_MakeRevol(disc(gp_Ax2(corner, gp_Dir(1, 0, 0)), tube), gp_Ax1(centre, gp_Dir(0, 0, 1)), angle)
          .Shape();
  return fused(fused(BRepPrimAPI_MakeCylinder(gp_Ax2(begin, gp_Dir(1, 0, 0)), tube, first).Solid(), torus),
               BRepPrimAPI_MakeCylinder(gp_Ax2(after, along), tube, last).Solid());
}

/// A solid, and the relative error that float parameters make in its volume: none where all lengths are exact.
struct Made {
  TopoDS_Shape solid;
  double volume_bound = 1e-9;
  std::vector<Kind> kinds = {};  ///< of its primitives; empty: not stated
};
constexpr double kRounded = 1e-6;

struct Recipe {
  const char* name;
  Made (*make)(Random&);
};
const Recipe kRecipes[] = {
    {"box",
     [](Random& r) -> Made {
       return {BRepPrimAPI_MakeBox(r.length(), r.length(), r.length()).Solid(), 1e-9, {Kind::kBox}};
     }},
    {"extruded rectangle",
     [](Random& r) -> Made {
       const TopoDS_Face face = rectangle(-r.length(), r.length(), -r.length(), r.length());
       return {BRepPrimAPI_MakePrism(face, gp_Vec(0, r.length(), 0)).Shape(), 1e-9, {Kind::kBox}};
     }},
    {"cylinder",
     [](Random& r) -> Made {
       return {cylinder(r.length(), r.length()), 1e-9, {Kind::kCylinder}};
     }},
    {"extruded disc",
     [](Random& r) -> Made {
       const TopoDS_Face face = disc(at_height(0), r.length());
       return {BRepPrimAPI_MakePrism(face, gp_Vec(0, 0, r.length())).Shape(), 1e-9, {Kind::kCylinder}};
     }},
    {"frustum of a cone",
     [](Random& r) -> Made {
       const double radius = r.length();
       const TopoDS_Shape made = BRepPrimAPI_MakeCone(radius, radius + r.length(1, 20), r.length()).Solid();
       return {made, 1e-9, {Kind::kSnout}};
     }},
    {"cone",
     [](Random& r) -> Made {
       return {BRepPrimAPI_MakeCone(r.length(), 0.0, r.length()).Solid(), 1e-9, {Kind::kSnout}};
     }},
    {"revolved cone",
     [](Random& r) -> Made {
       BRepBuilderAPI_MakePolygon made(gp_Pnt(0, 0, 0), gp_Pnt(r.length(), 0, 0), gp_Pnt(0, 0, r.length()),
                                       Standard_True);
       const TopoDS_Face face = BRepBuilderAPI_MakeFace(made.Wire()).Face();
       return {BRepPrimAPI_MakeRevol(face, gp::OZ()).Shape(), 1e-9, {Kind::kSnout}};
     }},
    {"sphere",
     [](Random& r) -> Made {
       return {BRepPrimAPI_MakeSphere(r.length()).Solid(), 1e-9, {Kind::kSphere}};
     }},
    {"dome",
     [](Random& r) -> Made {
       const double radius = r.length(), below = r.real(-0.95, 0.95) * radius;
       const TopoDS_Shape ball = BRepPrimAPI_MakeSphere(radius).Solid();
       return {below_slanted(ball, below, 0.0, 0.0), kRounded, {Kind::kSphericalDish}};
     }},
    {"leaning dome",
     [](Random& r) -> Made {
       const double radius = r.length(), below = r.real(-0.6, 0.6) * radius;
       const TopoDS_Shape ball = BRepPrimAPI_MakeSphere(radius).Solid();
       return {below_slanted(ball, below, r.real(0.0, 0.7), r.real(0, 6)), kRounded, {Kind::kSphericalDish}};
     }},
    {"torus",
     [](Random& r) -> Made {
       const double tube = r.length();
       const TopoDS_Shape made = BRepPrimAPI_MakeTorus(tube + r.length(), tube).Solid();
       return {made, 1e-9, {Kind::kCircularTorus}};
     }},
    {"slice of a torus",
     [](Random& r) -> Made {
       const double tube = r.length();
       const TopoDS_Shape made = BRepPrimAPI_MakeTorus(tube + r.length(), tube, r.real(0.1, 6.2)).Solid();
       return {made, kRounded, {Kind::kCircularTorus}};
     }},
    {"wedge",
     [](Random& r) -> Made {
       const double dx = r.length(), dz = r.length();
       const double x0 = r.length(-20, 20), x1 = x0 + r.length(1, 20), z0 = r.length(-20, 20),
                    z1 = z0 + r.length(1, 20);
       return {BRepPrimAPI_MakeWedge(dx, r.length(), dz, x0, z0, x1, z1).Solid(), 1e-9, {Kind::kPyramid}};
     }},
    {"pyramid",
     [](Random& r) -> Made {
       const double dx = r.length(), dz = r.length(), x = r.length(-9, 20), z = r.length(-9, 20);
       return {BRepPrimAPI_MakeWedge(dx, r.length(), dz, x, z, x, z).Solid(), 1e-9, {Kind::kPyramid}};
     }},
    {"roof",
     [](Random& r) -> Made {
       const double dx = r.length(), dz = r.length(), z = r.length(-9, 20);
       return {BRepPrimAPI_MakeWedge(dx, r.length(), dz, 0.0, z, dx, z).Solid(), 1e-9, {Kind::kPyramid}};
     }},
    {"stepped shaft",
     [](Random& r) -> Made {
       TopoDS_Shape shaft;
       double z = 0.0, before = 0.0;
       for (int i = 2 + r.below(4); i > 0; --i) {
         double radius = r.length();
         if (std::abs(radius - before) < 0.5) radius += 1.0;
         const double height = r.length();
         const TopoDS_Shape step = cylinder(before = radius, height, z);
         shaft = shaft.IsNull() ? step : fused(shaft, step);
         z += height;
       }
       return {shaft};
     }},
    {"shaft with a cone and a rounded end",
     [](Random& r) -> Made {
       const double radius = r.length(3, 20), top = radius - r.length(1, 2), low = r.length(), high = r.length(4, 20);
       const TopoDS_Shape body = fused(cylinder(radius, low), BRepPrimAPI_MakeCone(at_height(low), radius, top, high));
       const TopoDS_Shape ball = BRepPrimAPI_MakeSphere(at_height(low + high), top).Solid();
       return {fused(body, ball), kRounded};
     }},
    {"tube",
     [](Random& r) -> Made {
       const double inner = r.length(), height = r.length();
       return {
           cut(cylinder(inner + r.length(), height), cylinder(inner, height + 2, -1)), 1e-9, {Kind::kRectangularTorus}};
     }},
    {"flange with a counterbore",
     [](Random& r) -> Made {
       const double bore = r.length(1, 10), wide = bore + r.length(1, 5), hub = wide + r.length(1, 5),
                    rim = hub + r.length(5, 20), thick = r.length(8, 12), high = r.length(15, 30);
       const TopoDS_Shape body = fused(cylinder(rim, thick), cylinder(hub, high));
       return {cut(cut(body, cylinder(bore, high + 2, -1)), cylinder(wide, r.length(1, 7) + 1, -1))};
     }},
    {"blind hole",
     [](Random& r) -> Made {
       const double inner = r.length(), height = r.length(10, 50);
       return {cut(cylinder(inner + r.length(), height), cylinder(inner, height, r.length(1, 9)))};
     }},
    {"sector of a ring",
     [](Random& r) -> Made {
       const double inner = r.length(), low = r.length();
       const TopoDS_Face face = rectangle(inner, inner + r.length(), low, low + r.length());
       return {BRepPrimAPI_MakeRevol(face, gp::OZ(), r.real(0.1, 6.2)).Shape(), kRounded, {Kind::kRectangularTorus}};
     }},
    {"sector of a disc",
     [](Random& r) -> Made {
       const TopoDS_Shape made =
           BRepPrimAPI_MakeCylinder(at_height(0), r.length(), r.length(), r.real(0.1, 2.9)).Solid();
       return {made, kRounded, {Kind::kRectangularTorus}};
     }},
    {"swept pipe",
     [](Random& r) -> Made {
       return {pipe_run(r, true), kRounded};
     }},
    {"fused pipe",
     [](Random& r) -> Made {
       return {pipe_run(r, false), kRounded};
     }},
    {"cylinder with a slanted end",
     [](Random& r) -> Made {
       const double radius = r.length(), lean = r.real(0.01, 1.4), height = radius * std::tan(lean) + r.length();
       return {below_slanted(cylinder(radius, 2 * height), height, lean, r.real(0, 6)), kRounded, {Kind::kSnout}};
     }},
    {"cylinder with two slanted ends",
     [](Random& r) -> Made {
       const double radius = r.length(), one = r.real(-1, 1), other = r.real(-1, 1),
                    height = radius * (std::abs(std::tan(one)) + std::abs(std::tan(other))) + r.length();
       const TopoDS_Shape whole = cylinder(radius, 3 * height, -height);
       gp_Trsf upside_down;
       upside_down.SetRotation(gp::OX(), kPi);
       const TopoDS_Shape half = below_slanted(whole, height, one, r.real(0, 6));
       const TopoDS_Shape turned = BRepBuilderAPI_Transform(half, upside_down, Standard_True).Shape();
       return {below_slanted(turned, 0.0, other, r.real(0, 6)), kRounded, {Kind::kSnout}};
     }},
    {"cone with a slanted end",
     [](Random& r) -> Made {
       const double radius = r.length(10, 40), height = r.length(30, 50);
       const TopoDS_Shape cone = BRepPrimAPI_MakeCone(radius, radius * r.real(0.0, 0.2), height).Solid();
       return {below_slanted(cone, 0.5 * height, r.real(0.01, 0.4), r.real(0, 6)), kRounded, {Kind::kSnout}};
     }},
};

/// Another form, place or size of a solid, which is as analytic as it was.
struct Variant {
  std::string name;
  bool rounded = false;       ///< parameters are no longer exact
  double spline_bound = 0.0;  ///< relative error of the volume, where surfaces are splines
  gp_Trsf by = {};            ///< from the plain solid
};

TopoDS_Shape transformed(const TopoDS_Shape& shape, const gp_Trsf& by) {
  return BRepBuilderAPI_Transform(shape, by, Standard_True).Shape();
}

TopoDS_Shape varied(const TopoDS_Shape& shape, Random& random, Variant& variant) {
  TopoDS_Shape made = shape;
  if (random.one_in(3)) {
    ShapeUpgrade_ShapeDivideAngle divide(random.one_in(2) ? kPi : 0.5 * kPi, made);
    divide.Perform();
    made = only_solid(divide.Result());
    variant.name += ", split";
  }
  if (random.one_in(3)) {
    made = only_solid(BRepBuilderAPI_NurbsConvert(made, Standard_True).Shape());
    variant.name += ", splines";
    variant.spline_bound = 1e-6;
  }
  gp_Trsf& by = variant.by;
  if (random.one_in(2)) {
    const int power = random.below(31) - 10;  // 1e-3 to 1e6, exact
    by.SetScale(gp::Origin(), std::ldexp(1.0, power));
    variant.name += ", scaled by 2^" + std::to_string(power);
  }
  if (random.one_in(3)) {
    gp_Trsf mirror;
    mirror.SetMirror(gp_Ax2(gp::Origin(), random.direction()));
    by = mirror * by;
    variant.name += ", mirrored";
  }
  if (random.one_in(2)) {
    gp_Trsf turn;
    turn.SetRotation(gp_Ax1(gp::Origin(), random.direction()), random.real(0, 6));
    by = turn * by;
    variant.name += ", turned";
    variant.rounded = true;  // boxes are measured from corner to corner
  }
  if (random.one_in(3)) {
    gp_Trsf move;
    move.SetTranslation(gp_Vec(1e7 * random.direction().XYZ()));
    by = move * by;
    variant.name += ", far away";
    variant.rounded = true;
  }
  return by.Form() == gp_Identity ? made : transformed(made, by);
}

double volume_of(const TopoDS_Shape& shape) {
  GProp_GProps found;
  BRepGProp::VolumeProperties(shape, found, 1e-10);
  return found.Mass();
}

/// All faces as one shape: the distance to a solid would be 0 within it.
TopoDS_Shape skin_of(const TopoDS_Shape& solid) {
  TopoDS_Compound made;
  BRep_Builder builder;
  builder.MakeCompound(made);
  for (TopExp_Explorer face(solid, TopAbs_FACE); face.More(); face.Next()) builder.Add(made, face.Current());
  return made;
}

/// A random point of a face.
std::optional<dvec3> point_on(const TopoDS_Face& face, Random& random) {
  const BRepAdaptor_Surface surface(face);
  double u0, u1, v0, v1;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  const BRepTopAdaptor_FClass2d inside(face, 1e-9);
  for (int tries = 0; tries < 50; ++tries) {
    const double u = random.real(u0, u1), v = random.real(v0, v1);
    if (inside.Perform(gp_Pnt2d(u, v)) == TopAbs_IN) return from_occt(surface.Value(u, v));
  }
  return std::nullopt;
}

/// The union of a solid's primitives.
class Union {
 public:
  explicit Union(const AnalyticSolid& solid) : solid_(solid) {
    for (const AnalyticPart& part : solid.parts) {
      box_.grow(core::bounds(part.primitive, part.solid_from_primitive));
      primitive_from_solid_.push_back(glm::inverse(part.solid_from_primitive.linear));
    }
  }
  const core::AabbD& box() const { return box_; }

  double outside(const dvec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < solid_.parts.size(); ++i)
      least =
          std::min(least, tests::outside(solid_.parts[i].primitive,
                                         primitive_from_solid_[i] * (p - solid_.parts[i].solid_from_primitive.origin)));
    return least;
  }

  /// A random point of its surface: between one within and one without.
  std::optional<dvec3> point_on_surface(Random& random) const {
    const auto anywhere = [&] {
      const dvec3 low = box_.min - 0.1 * box_.size(), high = box_.max + 0.1 * box_.size();
      return dvec3(random.real(low.x, high.x), random.real(low.y, high.y), random.real(low.z, high.z));
    };
    dvec3 in = anywhere(), out = box_.max + box_.size();
    for (int tries = 0; outside(in) > 0.0; in = anywhere())
      if (++tries > 2000) return std::nullopt;
    for (int tries = 0; tries < 20 && outside(out = anywhere()) < 0.0;) ++tries;
    if (outside(out) < 0.0) return std::nullopt;
    for (int i = 0; i < 60; ++i) {
      const dvec3 middle = 0.5 * (in + out);
      (outside(middle) < 0.0 ? in : out) = middle;
    }
    return in;
  }

 private:
  const AnalyticSolid& solid_;
  core::AabbD box_;
  std::vector<core::dmat3> primitive_from_solid_;
};

std::optional<AnalyticSolid> recognised(const TopoDS_Shape& solid) {
  const auto surfaces = solid_surfaces(solid);
  return surfaces ? analytic_solid(*surfaces) : std::nullopt;
}

/// `plain`: the solid before it was varied, in which Open CASCADE finds closest points well.
void expect_same_surface(const TopoDS_Shape& solid, const TopoDS_Shape& plain, const gp_Trsf& solid_from_plain,
                         const AnalyticSolid& found, Random& random) {
  const Union all(found);
  const double size = glm::length(all.box().size());
  const double far = std::max(glm::length(all.box().min), glm::length(all.box().max));
  // Rounding of coordinates in double, and of Open CASCADE's search for the closest point.
  const double rounding = 1e-15 * far + 1e-9 * size;
  std::vector<TopoDS_Face> faces;
  for (TopExp_Explorer face(solid, TopAbs_FACE); face.More(); face.Next())
    faces.push_back(TopoDS::Face(face.Current()));
  for (int i = 0; i < 40; ++i)
    if (const auto p = point_on(faces[std::size_t(random.below(int(faces.size())))], random)) {
      EXPECT_LE(std::abs(all.outside(*p)), found.deviation + rounding) << "of the solid, size " << size;
    }
  const TopoDS_Shape skin = skin_of(plain);
  for (int i = 0; i < 8; ++i)
    if (const auto p = all.point_on_surface(random)) {
      const gp_Pnt at = gp_Pnt(p->x, p->y, p->z).Transformed(solid_from_plain.Inverted());
      BRepExtrema_DistShapeShape distance(BRepBuilderAPI_MakeVertex(at).Vertex(), skin);
      EXPECT_LE(std::abs(solid_from_plain.ScaleFactor()) * distance.Value(), found.deviation + rounding)
          << "of the primitives, size " << size;
    }
}

TEST(CadAnalyticSolid, IsTheSameSolid) {
  const int rounds = tests::repeated(60);
  int of_splines = 0, refused = 0;
  for (const Recipe& recipe : kRecipes)
    for (int round = 0; round < rounds; ++round) {
      Random random(unsigned(round) + 1);
      Variant variant;
      const Made plain = recipe.make(random);
      ASSERT_FALSE(plain.solid.IsNull()) << recipe.name;
      const TopoDS_Shape solid = round == 0 ? plain.solid : varied(plain.solid, random, variant);
      SCOPED_TRACE(recipe.name + variant.name + ", seed " + std::to_string(round + 1));
      ASSERT_FALSE(solid.IsNull());
      const auto found = recognised(solid);
      // Conversion to splines moves borders, and integrals over splines are rougher: some stay as they are.
      of_splines += variant.spline_bound > 0.0;
      refused += variant.spline_bound > 0.0 && !found;
      EXPECT_TRUE(found || variant.spline_bound > 0.0);
      if (!found) continue;
      for (std::size_t i = 0; i < plain.kinds.size(); ++i) {
        ASSERT_EQ(found->parts.size(), plain.kinds.size());
        EXPECT_EQ(core::kind_of(found->parts[i].primitive), plain.kinds[i]);
      }
      double volume = 0.0;
      for (const AnalyticPart& part : found->parts) {
        volume += tests::volume(part.primitive);
        EXPECT_NEAR(glm::determinant(part.solid_from_primitive.linear), 1.0, 1e-12);
      }
      const double bound = std::max({plain.volume_bound, variant.spline_bound, variant.rounded ? kRounded : 0.0});
      const double expected = volume_of(solid);
      EXPECT_NEAR(volume, expected, bound * expected);
      const double size = std::cbrt(expected);
      EXPECT_LE(found->deviation, 1e-4 * size) << "or it is no tolerance";
      expect_same_surface(solid, plain.solid, variant.by, *found, random);
    }
  EXPECT_LT(5 * refused, of_splines);
}

// --- what is of no primitive -----------------------------------------------------------------------------------------

struct Refused {
  const char* name;
  TopoDS_Shape (*make)();
};

TopoDS_Shape boxed(double x, double y, double z, double dx, double dy, double dz) {
  return BRepPrimAPI_MakeBox(gp_Pnt(x, y, z), dx, dy, dz).Solid();
}

/// Six faces with four corners each, of which one is moved.
TopoDS_Shape bent_box(const gp_Vec& moved) {
  std::array<gp_Pnt, 8> p;
  for (int i = 0; i < 8; ++i) p[std::size_t(i)] = gp_Pnt(10 * (i & 1), 20 * (i >> 1 & 1), 30 * (i >> 2 & 1));
  p[7].Translate(moved);
  constexpr std::array<std::array<std::size_t, 3>, 12> kTriangles = {{{0, 2, 3},
                                                                      {0, 3, 1},
                                                                      {4, 5, 7},
                                                                      {4, 7, 6},
                                                                      {0, 1, 5},
                                                                      {0, 5, 4},
                                                                      {2, 6, 7},
                                                                      {2, 7, 3},
                                                                      {0, 4, 6},
                                                                      {0, 6, 2},
                                                                      {1, 3, 7},
                                                                      {1, 7, 5}}};
  BRepBuilderAPI_Sewing sewing(1e-7);
  for (const auto& [a, b, c] : kTriangles)
    sewing.Add(BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakePolygon(p[a], p[b], p[c], Standard_True).Wire()).Face());
  sewing.Perform();
  BRepBuilderAPI_MakeSolid made(TopoDS::Shell(sewing.SewedShape()));
  return made.Solid();
}

TopoDS_Shape elliptic_cylinder(double stretch) {
  gp_GTrsf by;
  by.SetAffinity(gp::OX(), stretch);
  return only_solid(BRepBuilderAPI_GTransform(cylinder(10, 30), by, Standard_True).Shape());
}

TopoDS_Shape slice_of_a_torus() {
  return BRepPrimAPI_MakeTorus(20.0, 4.0, 2.0).Solid();
}

const Refused kRefused[] = {
    {"a cylinder cut along its axis", [] { return cut(cylinder(10, 20), boxed(4, -20, -1, 20, 40, 30)); }},
    {"a box with a hole", [] { return cut(boxed(-10, -10, 0, 20, 20, 20), cylinder(4, 30, -5)); }},
    {"a box with a step", [] { return cut(boxed(0, 0, 0, 20, 20, 20), boxed(10, -1, 10, 20, 40, 20)); }},
    {"a prism with five sides",
     [] {
       BRepBuilderAPI_MakePolygon made;
       for (int i = 0; i < 5; ++i) made.Add(gp_Pnt(std::cos(0.4 * kPi * i), std::sin(0.4 * kPi * i), 0));
       made.Close();
       return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(made.Wire()).Face(), gp_Vec(0, 0, 3)).Shape();
     }},
    {"a leaning box",
     [] {
       BRepBuilderAPI_MakePolygon made(gp_Pnt(0, 0, 0), gp_Pnt(4, 0, 0), gp_Pnt(5, 3, 0), gp_Pnt(1, 3, 0),
                                       Standard_True);
       return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(made.Wire()).Face(), gp_Vec(1, 2, 3)).Shape();
     }},
    {"a cylinder with a keyway", [] { return cut(cylinder(10, 20), boxed(8, -1, 5, 5, 2, 10)); }},
    {"a cylinder with a blind keyway", [] { return cut(cylinder(10, 20), boxed(8, -1, 5, 5, 2, 20)); }},
    {"a cylinder with a bore across",
     [] {
       const TopoDS_Shape bore = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-20, 0, 10), gp_Dir(1, 0, 0)), 2, 40).Solid();
       return cut(cylinder(10, 20), bore);
     }},
    {"a tube of cones",
     [] {
       return cut(BRepPrimAPI_MakeCone(10, 6, 20).Solid(), BRepPrimAPI_MakeCone(at_height(-1), 8.2, 3.8, 22).Solid());
     }},
    {"a cylinder with a hollow end",
     [] { return cut(cylinder(10, 20), BRepPrimAPI_MakeSphere(gp_Pnt(0, 0, 25), 13.0).Solid()); }},
    {"a cylinder that ends at one across",
     [] {
       const TopoDS_Shape across =
           BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-50, 0, 20), gp_Dir(1, 0, 0)), 15, 100).Solid();
       return cut(cylinder(10, 20), across);
     }},
    {"two cylinders that meet",
     [] {
       const TopoDS_Shape across = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, 20), gp_Dir(1, 0, 0)), 6, 30).Solid();
       return fused(cylinder(10, 40), across);
     }},
    {"an elliptic cylinder", [] { return elliptic_cylinder(1.3); }},
    {"a slightly elliptic cylinder", [] { return elliptic_cylinder(1.0 + 3e-5); }},
    {"a box with a moved corner", [] { return bent_box(gp_Vec(0.0, 0.0, 0.01)); }},
    {"a box with a corner a little off", [] { return bent_box(gp_Vec(2e-5, 1e-5, 0.0)); }},
    {"a box inside out", [] { return boxed(0, 0, 0, 10, 20, 30).Reversed(); }},
    {"a cylinder inside out", [] { return cylinder(10, 20).Reversed(); }},
    {"a box with a void", [] { return cut(boxed(0, 0, 0, 30, 30, 30), boxed(10, 10, 10, 5, 5, 5)); }},
    {"a ball with a void",
     [] { return cut(BRepPrimAPI_MakeSphere(10.0).Solid(), BRepPrimAPI_MakeSphere(4.0).Solid()); }},
    {"a hole off the axis", [] { return cut(cylinder(10, 20), cylinder(3, 30, -5, 2.0)); }},
    {"a hole a little off the axis", [] { return cut(cylinder(10, 20), cylinder(3, 30, -5, 1e-4)); }},
    {"two holes", [] { return cut(cut(cylinder(10, 20), cylinder(2, 30, -5, 4)), cylinder(2, 30, -5, -4)); }},
    {"a slice of a torus with a slanted end",
     [] {
       const gp_Pnt at(20 * std::cos(1.0), 20 * std::sin(1.0), 0);
       const gp_Dir along(-std::sin(1.0) + 0.3, std::cos(1.0), 0.2);
       const TopoDS_Shape plane = BRepBuilderAPI_MakeFace(gp_Pln(at, along), -50, 50, -50, 50).Shape();
       return cut(slice_of_a_torus(), BRepPrimAPI_MakePrism(plane, 60 * gp_Vec(along)).Shape());
     }},
    {"a tapered torus", [] { return cut(slice_of_a_torus(), boxed(-50, -50, 2, 100, 100, 10)); }},
    {"a ball cut twice",
     [] {
       return cut(BRepPrimAPI_MakeSphere(10.0).Solid(),
                  fused(boxed(5, -20, -20, 20, 40, 40), boxed(-20, -20, 5, 40, 40, 20)));
     }},
    {"a sector of a ring with a cone",
     [] {
       BRepBuilderAPI_MakePolygon made(gp_Pnt(5, 0, 0), gp_Pnt(9, 0, 0), gp_Pnt(8, 0, 4), gp_Pnt(5, 0, 4),
                                       Standard_True);
       return BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeFace(made.Wire()).Face(), gp::OZ(), 1.0).Shape();
     }},
};

TEST(CadAnalyticSolid, RefusesWhatIsOfNoPrimitive) {
  for (const Refused& refused : kRefused) {
    SCOPED_TRACE(refused.name);
    const TopoDS_Shape solid = refused.make();
    ASSERT_FALSE(solid.IsNull());
    const auto found = recognised(solid);
    EXPECT_FALSE(found) << found->parts.size() << " parts, first "
                        << core::name_of(core::kind_of(found->parts[0].primitive));
  }
}

TEST(CadAnalyticSolid, AreasAndVolumesMustAgree) {
  const TopoDS_Shape ring = BRepPrimAPI_MakeRevol(rectangle(5, 9, 0, 4), gp::OZ(), 1.0).Shape();
  for (const TopoDS_Shape& solid : {cylinder(10, 20), cut(cylinder(10, 20), cylinder(3, 30, -5)), slice_of_a_torus(),
                                    ring, boxed(0, 0, 0, 1, 2, 3), TopoDS_Shape(BRepPrimAPI_MakeSphere(10.0).Solid()),
                                    TopoDS_Shape(BRepPrimAPI_MakeCone(9.0, 4.0, 8.0).Solid())}) {
    const auto sound = solid_surfaces(solid);
    ASSERT_TRUE(sound);
    ASSERT_TRUE(analytic_solid(*sound));
    constexpr double kOther = 1.0 + 1e-5;
    SolidSurfaces other = *sound;
    other.volume *= kOther;
    EXPECT_FALSE(analytic_solid(other));
    for (std::size_t i = 0; i < sound->patches.size(); ++i) {
      if (sound->patches[i].kind == SurfaceKind::kPlane) continue;
      other = *sound;
      other.patches[i].area *= kOther;
      EXPECT_FALSE(analytic_solid(other)) << "patch " << i;
    }
  }
}

/// The solids above, but for what makes them others.
TEST(CadAnalyticSolid, TakesTheSoundOnesOfThese) {
  for (const TopoDS_Shape& solid : {bent_box(gp_Vec(0, 0, 0)), elliptic_cylinder(1.0), boxed(0, 0, 0, 10, 20, 30),
                                    slice_of_a_torus(), cut(cylinder(10, 20), cylinder(3, 30, -5))})
    EXPECT_TRUE(recognised(solid));
}

}  // namespace
}  // namespace sightline::importers::cad_analytic_solid_test
