// Tessellated geometry of STEP files, as programs write it for AP242.
#include <cmath>
#include <random>
#include <vector>

#include <BRep_Builder.hxx>
#include <TopoDS_Shell.hxx>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/core/surface_area.h"
#include "sightline/importers/cad/internal/cad_reader.h"
#include "sightline/importers/cad/internal/tessellated_step.h"
#include "sightline/tests/importers/cad_model.h"
#include "sightline/tests/support/effort.h"

namespace sightline::importers::cad_tessellated_test {
namespace {

using core::dvec3;

/// The six faces of a block of 20 x 10 x 5: corners and normal.
struct BlockFace {
  const char *corners, *normal;
};
constexpr BlockFace kBlock[] = {{"1,4,3,2", "0.,0.,-1."}, {"5,6,7,8", "0.,0.,1."}, {"1,2,6,5", "0.,-1.,0."},
                                {"2,3,7,6", "1.,0.,0."},  {"3,4,8,7", "0.,1.,0."}, {"4,1,5,8", "-1.,0.,0."}};

constexpr const char* kOfManyTypes =
    "( GEOMETRIC_REPRESENTATION_ITEM() REPRESENTATION_ITEM('f') TESSELLATED_FACE(#20,4,(({1})),{2}) TESSELLATED_ITEM() "
    "TESSELLATED_STRUCTURED_ITEM() TRIANGULATED_FACE(({0}),((1,2,3),(1,3,4))) )";

/// Writings of one face: {0} corners, {1} a normal, {2} the link.
const char* const kFaces[] = {
    "TRIANGULATED_FACE('f',#20,4,(({1})),{2},({0}),((1,2,3),(1,3,4)))",
    "TRIANGULATED_FACE('f',#20,4,(({1}),({1}),({1}),({1})),{2},({0}),((1,2,3),(1,3,4)))",
    "TRIANGULATED_FACE('f',#20,4,(),{2},({0}),((1,2,3),(1,3,4)))",
    "COMPLEX_TRIANGULATED_FACE('f',#20,4,(({1})),{2},({0}),((1,2,4,3)),())",
    "COMPLEX_TRIANGULATED_FACE('f',#20,4,(({1})),{2},({0}),(),((1,2,3,4)))",
    kOfManyTypes,
    "TRIANGULATED_SURFACE_SET('f',#20,4,(({1})),({0}),((1,2,3),(1,3,4)))",
    "COMPLEX_TRIANGULATED_SURFACE_SET('f',#20,4,(({1})),({0}),((1,2,4,3)),())",
};
constexpr const char* kGroup = "(#31,#32,#33,#34,#35,#36)";

/// Faces #31 to #36 in a writing of kFaces.
std::string block(const char* face, const char* link = "$") {
  std::string text =
      "#20 = COORDINATES_LIST('',8,((0.,0.,0.),(20.,0.,0.),(20.,10.,0.),(0.,10.,0.),(0.,0.,5.),(20.,0.,5.),"
      "(20.,10.,5.),(0.,10.,5.)));\n";
  for (int i = 0; i < 6; ++i)
    text +=
        fmt::format("#{} = {};\n", 31 + i, fmt::format(fmt::runtime(face), kBlock[i].corners, kBlock[i].normal, link));
  return text;
}

/// A product whose representation has items, in a unit of length.
std::string file_of(const std::string& entities, const std::string& items, const char* prefix = ".MILLI.",
                    const char* representation = "TESSELLATED_SHAPE_REPRESENTATION('',({}),#4)") {
  return fmt::format(
      "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
      "FILE_SCHEMA(('AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF'));\nENDSEC;\nDATA;\n"
      "#1 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT({},.METRE.) );\n"
      "#2 = ( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) );\n"
      "#3 = ( NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() );\n"
      "#4 = ( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#1,#2,#3)) "
      "REPRESENTATION_CONTEXT('','') );\n#5 = APPLICATION_CONTEXT('');\n#6 = PRODUCT_CONTEXT('',#5,'mechanical');\n"
      "#7 = PRODUCT_DEFINITION_CONTEXT('part definition',#5,'design');\n#8 = PRODUCT('plate','plate','',(#6));\n"
      "#9 = PRODUCT_DEFINITION_FORMATION('','',#8);\n#10 = PRODUCT_DEFINITION('design','',#9,#7);\n"
      "#11 = PRODUCT_DEFINITION_SHAPE('','',#10);\n#12 = {};\n#13 = SHAPE_DEFINITION_REPRESENTATION(#11,#12);\n"
      "{}ENDSEC;\nEND-ISO-10303-21;\n",
      prefix, fmt::format(fmt::runtime(representation), items), entities);
}

/// A style #`id` of a colour for an item.
std::string styled(int id, const char* colour, const char* item) {
  return fmt::format(
      "#{0} = STYLED_ITEM('',(#{1}),{7});\n#{1} = PRESENTATION_STYLE_ASSIGNMENT((#{2}));\n"
      "#{2} = SURFACE_STYLE_USAGE(.BOTH.,#{3});\n#{3} = SURFACE_SIDE_STYLE('',(#{4}));\n"
      "#{4} = SURFACE_STYLE_FILL_AREA(#{5});\n#{5} = FILL_AREA_STYLE('',(#{6}));\n"
      "#{6} = FILL_AREA_STYLE_COLOUR('',#{8});\n#{8} = COLOUR_RGB('',{9});\n",
      id, id + 1, id + 2, id + 3, id + 4, id + 5, id + 6, item, id + 7, colour);
}

class CadTessellated : public testing::Test {
 protected:
  const ImportReport& read(const std::string& text) {
    tests::write_text(folder_ / "file.stp", text);
    return read_file("file.stp");
  }
  const ImportReport& read_file(const char* name) {
    scene_ = core::Scene();
    auto report = read_cad(folder_ / name, scene_, scene_.root(), {});
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    EXPECT_TRUE(scene_.commit());
    return report_ = report.value_or(ImportReport());
  }
  core::NodeId part() const { return scene_.first_child(scene_.first_child(scene_.root())); }
  std::vector<core::ItemId> items() const {
    std::vector<core::ItemId> all;
    for (std::uint32_t i = 0; i < scene_.item_slots(); ++i) all.push_back(core::ItemId{i});
    return all;
  }
  /// One closed mesh whose normals stand on its triangles, as it is placed; millimetres.
  void expect_block(core::ItemId item, const dvec3& min, const dvec3& max) const {
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(item));
    EXPECT_EQ(core::enclosure(mesh), core::Enclosure::kInside);
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const auto p = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]]; };
      const core::vec3 across = glm::normalize(glm::cross(p(1) - p(0), p(2) - p(0)));
      for (std::size_t k = 0; k < 3; ++k) EXPECT_GT(glm::dot(across, mesh.normals[mesh.indices[i + k]]), 0.999f);
    }
    const core::AabbD found = scene_.bounds(scene_.node_of(item));
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(found.min[k], 1e-3 * min[k], 1e-6);
      EXPECT_NEAR(found.max[k], 1e-3 * max[k], 1e-6);
    }
  }
  /// All warnings but the one that triangles are the file's own.
  std::vector<std::string> other_warnings() const {
    std::vector<std::string> all;
    for (const ImportWarning& warning : report_.warnings)
      if (warning.message.find("are tessellated in the file") == std::string::npos) all.push_back(warning.message);
    return all;
  }

  tests::CadFolder folder_;
  core::Scene scene_;
  ImportReport report_;
};

TEST_F(CadTessellated, FacesInAllTheirWritings) {
  const std::string solid = fmt::format("#40 = TESSELLATED_SOLID('body',{},$);\n", kGroup),
                    set = fmt::format("#40 = TESSELLATED_GEOMETRIC_SET('body',{});\n", kGroup);
  for (const char* face : kFaces) {
    SCOPED_TRACE(face);
    const bool of_set = std::string_view(face).find("SURFACE_SET") != std::string_view::npos;
    read(file_of(block(face) + (of_set ? set : solid), "#40"));
    ASSERT_EQ(items().size(), 1u);
    expect_block(items()[0], dvec3(0), {20, 10, 5});
    EXPECT_EQ(scene_.name(part()), "plate");
    EXPECT_EQ(report_.surfaces.triangles, 12u);
    EXPECT_EQ(report_.surfaces.largest_tolerance, 0.0);
    ASSERT_EQ(report_.warnings.size(), 1u);
    EXPECT_EQ(report_.warnings[0].message,
              "1 bodies are tessellated in the file, which does not say how far off their triangles are");
  }
}

TEST_F(CadTessellated, GroupsUnitsAndRepresentations) {
  const std::string faces = block(kFaces[0]);
  const auto expect_one = [&](const std::string& text, double unit) {
    read(text);
    ASSERT_EQ(items().size(), 1u);
    expect_block(items()[0], dvec3(0), unit * dvec3(20, 10, 5));
    EXPECT_TRUE(other_warnings().empty()) << other_warnings()[0];
  };
  const std::string shell = fmt::format("#40 = TESSELLATED_SHELL('',{},$);\n", kGroup);
  expect_one(file_of(faces + shell, "#40"), 1.0);
  expect_one(file_of(faces + shell, "#40", "$"), 1000.0);
  expect_one(file_of(faces, "#31,#32,#33,#34,#35,#36"), 1.0);
  expect_one(file_of(faces + shell + "#41 = TESSELLATED_SOLID('',(#40),$);\n", "#40,#41"), 1.0);
  expect_one(file_of(faces + shell, "#40", ".MILLI.", "SHAPE_REPRESENTATION('',({}),#4)"), 1.0);
  expect_one(file_of(faces + shell, "#40", ".MILLI.",
                     "( REPRESENTATION('',({}),#4) SHAPE_REPRESENTATION() TESSELLATED_SHAPE_REPRESENTATION() )"),
             1.0);
  const std::string related = faces + shell +
                              "#41 = TESSELLATED_SHAPE_REPRESENTATION('',(#40),#4);\n"
                              "#42 = SHAPE_REPRESENTATION_RELATIONSHIP('','',#12,#41);\n"
                              "#43 = AXIS2_PLACEMENT_3D('',#44,$,$);\n#44 = CARTESIAN_POINT('',(0.,0.,0.));\n";
  expect_one(file_of(related, "#43", ".MILLI.", "SHAPE_REPRESENTATION('',({}),#4)"), 1.0);
}

TEST_F(CadTessellated, ColoursOfBodiesAndFaces) {
  const std::string solid = fmt::format("#40 = TESSELLATED_SOLID('',{},$);\n", kGroup);
  read(file_of(block(kFaces[0]) + solid + styled(50, "1.,0.,0.", "#40") + styled(60, "0.,0.,1.", "#32"), "#40"));
  ASSERT_EQ(items().size(), 2u);
  std::map<std::size_t, core::vec3> colours;  // by the number of triangles
  for (const core::ItemId item : items())
    colours[scene_.mesh(scene_.mesh_of(item)).indices.size() / 3] =
        scene_.material(scene_.material_at(scene_.state(item).material)).colour;
  EXPECT_GT(colours[10].x, 0.99f);
  EXPECT_GT(colours[2].z, 0.99f);
}

/// Layers of bodies, visible and not, as of exact ones.
TEST_F(CadTessellated, Layers) {
  const auto read_with = [&](const std::string& items, const std::string& solids, const std::string& layers) {
    read(file_of(block(kFaces[0]) + solids + layers, items));
    std::string found;
    for (const core::ItemId item : this->items()) {
      const core::NodeId at = scene_.node_of(item);
      for (const auto& [key, value] : scene_.attributes(at))
        if (key == "layer") found += value;
      found += scene_.visible(at) ? ";" : " hidden;";
    }
    return found;
  };
  const std::string one = fmt::format("#40 = TESSELLATED_SOLID('',{},$);\n", kGroup);
  const std::string two =
      "#40 = TESSELLATED_SOLID('left',(#31,#32,#33),$);\n"
      "#41 = TESSELLATED_SOLID('right',(#34,#35,#36),$);\n";
  const std::string pipes = "#50 = PRESENTATION_LAYER_ASSIGNMENT('pipes','',(#40));\n";
  const std::string hidden = pipes + "#51 = INVISIBILITY((#50));\n";
  EXPECT_EQ(read_with("#40", one, pipes), "pipes;");
  EXPECT_EQ(read_with("#40", one, hidden), "pipes hidden;");
  EXPECT_EQ(read_with("#40,#41", two, pipes), "pipes;;");
  EXPECT_EQ(read_with("#40,#41", two, hidden), "pipes hidden;;");
  EXPECT_EQ(read_with("#40,#41", two, styled(60, "1.,0.,0.", "#41") + "#51 = INVISIBILITY((#60));\n"), "; hidden;");
}

TEST_F(CadTessellated, NamesAndPlacesOfBodies) {
  const std::string more = fmt::format(
      "#40 = TESSELLATED_SOLID('\\X2\\00DC\\X0\\ber',(#31,#32,#33),$);\n#41 = "
      "TESSELLATED_SHELL('lower',(#34,#35,#36),$);\n"
      "#42 = AXIS2_PLACEMENT_3D('',#43,#44,$);\n#43 = CARTESIAN_POINT('',(100.,0.,0.));\n"
      "#44 = DIRECTION('',(1.,0.,0.));\n");
  read(file_of(block(kFaces[0]) + more, "#40,#41"));
  ASSERT_EQ(items().size(), 2u);
  EXPECT_EQ(scene_.name(scene_.node_of(items()[0])), "Über");
  EXPECT_EQ(scene_.name(scene_.node_of(items()[1])), "lower");
  const std::string set = fmt::format(
      "#45 = ( GEOMETRIC_REPRESENTATION_ITEM() REPOSITIONED_TESSELLATED_ITEM(#42) REPRESENTATION_ITEM('') "
      "TESSELLATED_GEOMETRIC_SET({}) TESSELLATED_ITEM() );\n",
      kGroup);
  read(file_of(block(kFaces[6]) + more + set, "#45", "$"));
  expect_block(items().at(0), {100e3, 0, 0}, {105e3, 20e3, 10e3});  // x to y, y to z, z to x
}

TEST_F(CadTessellated, AssembliesScaleAndMirror) {
  const std::string part = block(kFaces[1]) + fmt::format("#40 = TESSELLATED_SOLID('',{},$);\n", kGroup),
                    top =
                        "#70 = PRODUCT('top','top','',(#6));\n#71 = PRODUCT_DEFINITION_FORMATION('','',#70);\n"
                        "#72 = PRODUCT_DEFINITION('design','',#71,#7);\n#73 = PRODUCT_DEFINITION_SHAPE('','',#72);\n"
                        "#74 = SHAPE_DEFINITION_REPRESENTATION(#73,#75);\n#80 = CARTESIAN_POINT('',(0.,0.,0.));\n"
                        "#81 = AXIS2_PLACEMENT_3D('',#80,$,$);\n#82 = CARTESIAN_POINT('',(100.,0.,0.));\n";
  const std::string use =
      "#75 = SHAPE_REPRESENTATION('',(#81),#4);\n#83 = AXIS2_PLACEMENT_3D('',#82,$,$);\n"
      "#84 = ITEM_DEFINED_TRANSFORMATION('','',#81,#83);\n#85 = ( REPRESENTATION_RELATIONSHIP('','',#12,#75) "
      "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#84) SHAPE_REPRESENTATION_RELATIONSHIP() );\n"
      "#86 = NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','left','',#72,#10,$);\n#87 = PRODUCT_DEFINITION_SHAPE('','',#86);\n"
      "#88 = CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#85,#87);\n";
  read(file_of(part + top + use, "#40"));
  ASSERT_EQ(items().size(), 1u);
  expect_block(items()[0], {100, 0, 0}, {120, 10, 5});
  EXPECT_TRUE(scene_.path(scene_.node_of(items()[0])).ends_with("/top/left"));
  const auto mapped = [&](const char* x, const char* scale) {
    read(file_of(part + top +
                     fmt::format("#75 = SHAPE_REPRESENTATION('',(#81,#76),#4);\n#76 = MAPPED_ITEM('',#77,#78);\n"
                                 "#77 = REPRESENTATION_MAP(#81,#90);\n#79 = DIRECTION('',({},0.,0.));\n"
                                 "#78 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',#79,$,#82,{},$);\n"
                                 "#90 = TESSELLATED_SHAPE_REPRESENTATION('',(#40),#4);\n",
                                 x, scale),
                 "#81"));
    ASSERT_EQ(items().size(), 1u);
  };
  mapped("1.", "2.");
  expect_block(items()[0], {100, 0, 0}, {140, 20, 10});
  mapped("-1.", "1.");
  expect_block(items()[0], {80, 0, 0}, {100, 10, 5});
}

/// A drilled plate as Open CASCADE writes it, and a block or a plate of triangles beside it.
TEST_F(CadTessellated, BodiesWithAnExactFormAreNotDoubled) {
  tests::CadModel model;
  model.part(tests::cad_box(20, 10, 5), "plate");
  model.write_step(folder_ / "exact.stp");
  const std::string exact = tests::text_of_file(folder_ / "exact.stp");
  const auto number_of = [&](const std::string& type) {
    const std::size_t at = exact.find("= " + type + "("), begin = exact.rfind('#', at);
    return exact.substr(begin, exact.find(' ', begin) - begin);
  };
  const std::string solid = number_of("MANIFOLD_SOLID_BREP"), face = number_of("ADVANCED_FACE");
  std::string triangles = block(kFaces[0], "FACE") + fmt::format("#40 = TESSELLATED_SOLID('',{},BODY);\n", kGroup);
  for (const int id : {20, 31, 32, 33, 34, 35, 36, 40})
    triangles = tests::replaced(triangles, fmt::format("#{}", id), fmt::format("#90{}", id));
  const auto read_with = [&](const std::string& of_body, const std::string& of_face, const char* move) {
    std::string beside = tests::replaced(tests::replaced(triangles, "BODY", of_body), "FACE,", of_face + ",");
    beside = tests::replaced(beside, "(0.,0.,0.)", std::string("(") + move + ",0.,0.)");
    std::string text = tests::replaced(exact, solid + ")", solid + ",#9040)");
    text.insert(text.rfind("ENDSEC;"), beside);
    read(text);
    return items().size();
  };
  EXPECT_EQ(read_with(solid, "$", "0."), 1u);
  EXPECT_EQ(read_with("$", face, "0."), 1u);
  EXPECT_EQ(read_with("$", "$", "0."), 1u) << "as large as the exact one";
  EXPECT_EQ(read_with("$", "$", "-300."), 2u) << "another body";
  EXPECT_EQ(read_with("#99999", "#99999", "-300."), 2u) << "a link to nothing";
}

TEST_F(CadTessellated, WhatCannotBeReadIsNamed) {
  const std::string bad =
      "#41 = TRIANGULATED_FACE('',#20,8,(),$,(1,2,9),((1,2,3)));\n#42 = TRIANGULATED_FACE('',$,3,(),$,(),((1,2,3)));\n"
      "#43 = TRIANGULATED_FACE('',#20,8,());\n#44 = TESSELLATED_SHELL('',(#41,#42,#43,#44),$);\n"
      "#45 = TESSELLATED_CURVE_SET('',#20,((1,2,3)));\n#46 = CUBIC_BEZIER_TRIANGULATED_FACE('',#20,8,(),$,((1,2,3)));\n"
      "#47 = TESSELLATED_SHELL('empty',(),$);\n#48 = TESSELLATED_EDGE('',#20,$,(1,2));\n"
      "#49 = ( CUBIC_BEZIER_TRIANGULATED_FACE(((1,2,3))) GEOMETRIC_REPRESENTATION_ITEM() REPRESENTATION_ITEM('') "
      "TESSELLATED_FACE(#20,8,(),$) TESSELLATED_ITEM() TESSELLATED_STRUCTURED_ITEM() );\n"
      "#50 = CUBIC_BEZIER_TESSELLATED_EDGE('',#20,$,(1,2,3,4));\n"
      "#40 = TESSELLATED_SOLID('',(#31,#48,#50,#32,#33,#34,#49,#35,#36),$);\n";
  read(file_of(block(kFaces[2]) + bad, "#47,#44,#45,#46,#40"));
  EXPECT_EQ(other_warnings(), (std::vector<std::string>{
                                  "TRIANGULATED_FACE #41 has 1 triangles without points",
                                  "TRIANGULATED_FACE #42 has 1 triangles without points",
                                  "TRIANGULATED_FACE #43 has 4 attributes of 7",
                                  "CUBIC_BEZIER_TRIANGULATED_FACE not read: 2 items, first #46",
                                  "TESSELLATED_CURVE_SET not read: 1 items, first #45",
                              }));
  ASSERT_EQ(items().size(), 1u);
  expect_block(items()[0], dvec3(0), {20, 10, 5});
}

TEST_F(CadTessellated, BrepFilesOfTrianglesAlone) {
  const Handle(Poly_Triangulation) triangles = new Poly_Triangulation(4, 4, Standard_False);
  const gp_Pnt corners[] = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
  for (int i = 0; i < 4; ++i) triangles->SetNode(i + 1, corners[i]);
  const Poly_Triangle faces[] = {{1, 3, 2}, {1, 2, 4}, {1, 4, 3}, {2, 3, 4}};
  for (int i = 0; i < 4; ++i) triangles->SetTriangle(i + 1, faces[i]);
  TopoDS_Face face;
  BRep_Builder().MakeFace(face, triangles);
  TopoDS_Shell shell;
  BRep_Builder().MakeShell(shell);
  BRep_Builder().Add(shell, face);
  ASSERT_TRUE(BRepTools::Write(shell, (folder_ / "mesh.brep").c_str()));
  read_file("mesh.brep");
  EXPECT_EQ(report_.surfaces.failed_faces, 0u);
  ASSERT_EQ(items().size(), 1u);
  expect_block(items()[0], dvec3(0), dvec3(10));
}

/// Texts changed anywhere are read or warned of, and stay texts.
TEST_F(CadTessellated, DamagedTexts) {
  const std::string sound =
      file_of(block(kFaces[3]) + fmt::format("#40 = TESSELLATED_SOLID('',{},#40);\n", kGroup), "#40,#31");
  std::mt19937 random(7);
  for (int i = 0; i < tests::repeated(2000); ++i) {
    std::string text = sound;
    for (int k = 0; k < 3; ++k) text[random() % text.size()] = "#(),;'$=9 "[random() % 10];
    core::Scene scene;
    const auto report = run_import("x.stp", scene, scene.root(), {}, {}, [&](ImportJob& job) -> core::Expected<void> {
      const TessellatedStep ignored(job, text);
      return {};
    });
    ASSERT_TRUE(report) << i;
    EXPECT_LT(text.size(), 2 * sound.size());
  }
}

}  // namespace
}  // namespace sightline::importers::cad_tessellated_test
