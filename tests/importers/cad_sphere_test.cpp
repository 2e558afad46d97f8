// Spherical faces of STEP files whose border is a spline through the poles lie on the side that the border tells.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "sightline/importers/cad/internal/cad_reader.h"
#include "sightline/tests/importers/cad_model.h"

namespace sightline::importers::cad_sphere_test {
namespace {

using core::dvec3;

/// A file of half hollow balls, each a part: x at least that of the centre, radii 10 and 8.
class HollowHalves {
 public:
  HollowHalves() {
    add("( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )");
    add("( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) )");
    add("( NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() )");
    add("UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-05),#1,'','')");
    add("( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#4)) "
        "GLOBAL_UNIT_ASSIGNED_CONTEXT((#1,#2,#3)) REPRESENTATION_CONTEXT('','') )");
    add("APPLICATION_CONTEXT('')");
    add("PRODUCT_CONTEXT('',#6,'mechanical')");
    add("PRODUCT_DEFINITION_CONTEXT('part definition',#6,'design')");
  }

  /// The spheres' axis is z, with the seam along `seam`; the rims are `arcs` splines, the first from angle `begin`.
  void half(const std::string& name, const dvec3& centre, const dvec3& seam, int arcs, double begin) {
    const auto outer = ring(centre, 10.0, arcs, begin), inner = ring(centre, 8.0, arcs, begin);
    const dvec3 up(0, 0, 1), back(-1, 0, 0);
    const auto sphere = [&](double radius) {
      return add(fmt::format("SPHERICAL_SURFACE('',{},{})", place(centre, up, seam), real(radius)));
    };
    const std::string plane = add(fmt::format("PLANE('',{})", place(centre, back, dvec3(0, 1, 0))));
    const std::string faces[] = {
        add(fmt::format("ADVANCED_FACE('',({}),{},.T.)", bound(outer, true), sphere(10.0))),
        add(fmt::format("ADVANCED_FACE('',({}),{},.F.)", bound(inner, false), sphere(8.0))),
        add(fmt::format("ADVANCED_FACE('',({},{}),{},.T.)", bound(outer, false), bound(inner, true), plane))};
    const std::string shell = add(fmt::format("CLOSED_SHELL('',({}))", fmt::join(faces, ","))),
                      solid = add(fmt::format("MANIFOLD_SOLID_BREP('',{})", shell)),
                      product = add(fmt::format("PRODUCT('{0}','{0}','',(#7))", name)),
                      formation = add(fmt::format("PRODUCT_DEFINITION_FORMATION('','',{})", product)),
                      definition = add(fmt::format("PRODUCT_DEFINITION('design','',{},#8)", formation)),
                      shape = add(fmt::format("PRODUCT_DEFINITION_SHAPE('','',{})", definition)),
                      representation = add(fmt::format("ADVANCED_BREP_SHAPE_REPRESENTATION('',({}),#5)", solid));
    add(fmt::format("SHAPE_DEFINITION_REPRESENTATION({},{})", shape, representation));
  }

  std::string text() const {
    return "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
           "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n" +
           data_ + "ENDSEC;\nEND-ISO-10303-21;\n";
  }

 private:
  std::string add(const std::string& entity) {
    data_ += fmt::format("#{} = {};\n", ++count_, entity);
    return fmt::format("#{}", count_);
  }
  static std::string real(double value) { return fmt::format("{:.16E}", value); }
  static std::string triple(const dvec3& v) { return fmt::format("({},{},{})", real(v.x), real(v.y), real(v.z)); }
  std::string point(const dvec3& p) { return add("CARTESIAN_POINT(''," + triple(p) + ")"); }
  std::string direction(const dvec3& d) { return add("DIRECTION(''," + triple(d) + ")"); }
  std::string place(const dvec3& at, const dvec3& z, const dvec3& x) {
    return add(fmt::format("AXIS2_PLACEMENT_3D('',{},{},{})", point(at), direction(z), direction(x)));
  }

  /// Edges about the x axis, as rational splines of quarter turns at most.
  std::vector<std::string> ring(const dvec3& centre, double radius, int arcs, double begin) {
    std::vector<std::string> vertices, edges;
    const auto at = [&](double angle, double stretch) {
      return centre + radius * stretch * dvec3(0, std::cos(angle), std::sin(angle));
    };
    const double step = 2.0 * std::numbers::pi / arcs;
    for (int i = 0; i < arcs; ++i) vertices.push_back(add("VERTEX_POINT(''," + point(at(begin + i * step, 1.0)) + ")"));
    for (int i = 0; i < arcs; ++i) {
      const int pieces = std::max(1, 4 / arcs);
      const double first = begin + i * step, half = 0.5 * step / pieces;
      std::vector<std::string> points{point(at(first, 1.0))}, weights{"1."}, knots{"0."}, multiplicities{"3"};
      for (int k = 0; k < pieces; ++k) {
        points.push_back(point(at(first + (2 * k + 1) * half, 1.0 / std::cos(half))));
        points.push_back(point(at(first + (2 * k + 2) * half, 1.0)));
        weights.insert(weights.end(), {real(std::cos(half)), "1."});
        knots.push_back(real(k + 1));
        multiplicities.push_back(k + 1 == pieces ? "3" : "2");
      }
      const std::string curve = add(fmt::format(
          "( BOUNDED_CURVE() B_SPLINE_CURVE(2,({}),.UNSPECIFIED.,.F.,.F.) B_SPLINE_CURVE_WITH_KNOTS(({}),({}),"
          ".UNSPECIFIED.) CURVE() GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_CURVE(({})) "
          "REPRESENTATION_ITEM('') )",
          fmt::join(points, ","), fmt::join(multiplicities, ","), fmt::join(knots, ","), fmt::join(weights, ",")));
      edges.push_back(add(fmt::format("EDGE_CURVE('',{},{},{},.T.)", vertices[std::size_t(i)],
                                      vertices[std::size_t((i + 1) % arcs)], curve)));
    }
    return edges;
  }

  std::string bound(std::vector<std::string> edges, bool forward) {
    if (!forward) std::reverse(edges.begin(), edges.end());
    for (std::string& edge : edges)
      edge = add(fmt::format("ORIENTED_EDGE('',*,*,{},{})", edge, forward ? ".T." : ".F."));
    return add(fmt::format("FACE_BOUND('',{},.T.)", add(fmt::format("EDGE_LOOP('',({}))", fmt::join(edges, ",")))));
  }

  std::string data_;
  int count_ = 0;
};

/// Where the balls stand decides how longitudes of the rim are rounded.
TEST(CadSphere, HalvesWithRimsThroughThePolesLieOnTheirSide) {
  HollowHalves file;
  std::vector<dvec3> centres;
  const dvec3 seams[] = {{1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {-1, 0, 0}};
  for (int i = 0; i < 30; ++i) {
    centres.emplace_back(30.0 * i, 0.0, 0.0);
    file.half(fmt::format("{}", i), centres.back(), dvec3(0, 1, 0), 4, 0.3);
  }
  for (int i = 0; i < 24; ++i) {
    centres.emplace_back(30.0 * i, 17.3 * i, 100.0);
    file.half(fmt::format("{}", i + 30), centres.back(), seams[i % 4], 1 << i % 3, 0.5 * std::numbers::pi * (i % 2));
  }
  const tests::CadFolder folder;
  tests::write_text(folder / "halves.stp", file.text());
  core::Scene scene;
  const auto report =
      read_cad(folder / "halves.stp", scene, scene.root(), {.chord_tolerance = 2e-4, .chord_angle = 0.5});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
  ASSERT_TRUE(scene.commit());
  std::size_t found = 0;
  for (core::NodeId part = scene.first_child(scene.first_child(scene.root())); part.valid();
       part = scene.next_sibling(part), ++found) {
    const dvec3 centre = 1e-3 * centres.at(std::stoul(std::string(scene.name(part))));
    const core::AabbD box = scene.bounds(part);
    EXPECT_NEAR(box.min.x, centre.x, 4e-4) << scene.name(part);
    EXPECT_NEAR(box.max.x, centre.x + 0.01, 4e-4) << scene.name(part);
  }
  EXPECT_EQ(found, centres.size());
}

}  // namespace
}  // namespace sightline::importers::cad_sphere_test
