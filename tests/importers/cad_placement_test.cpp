// Placements that scale, mirror, or leave their axes to ISO 10303-42, in STEP and IGES.
#include <cmath>
#include <vector>

#include <BRepPrimAPI_MakeBox.hxx>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/importers/cad/internal/cad_reader.h"
#include "sightline/importers/cad/internal/step_text.h"
#include "sightline/tests/importers/cad_model.h"

namespace sightline::importers::cad_placement_test {
namespace {

using core::AabbD;
using core::dvec3;

/// An angle bracket, 20 long, 10 wide and high: the text of its file, to which entities are added.
class PlacedPart {
 public:
  explicit PlacedPart(const tests::CadFolder& folder, const TopoDS_Shape& shape = bracket(), const char* unit = "MM")
      : file_(folder / "placed.stp") {
    tests::CadModel model;
    const TDF_Label part = model.part(shape, "part");
    model.colour(part, 1, 0, 0);
    model.write_step(file_, unit);
    text_ = tests::text_of_file(file_);
    const std::size_t representation = text_.find("= ADVANCED_BREP_SHAPE_REPRESENTATION(");
    const std::size_t begin = text_.rfind('#', representation), items = text_.find("(#", representation) + 1;
    representation_ = text_.substr(begin, text_.find(' ', begin) - begin);
    axis_ = text_.substr(items, text_.find(',', items) - items);
    const std::size_t context = text_.rfind(",#", text_.find(';', representation)) + 1;
    context_ = text_.substr(context, text_.find(')', context) - context);
  }
  static TopoDS_Shape bracket() {
    return BRepAlgoAPI_Cut(tests::cad_box(20, 10, 10),
                           BRepPrimAPI_MakeBox(gp_Pnt(5, 4, -1), 100.0, 100.0, 100.0).Solid());
  }

  /// `target` holds the entities that place the part, the last of which is #9100. `source`: the part's own placement
  /// unless stated.
  PlacedPart& map(const std::string& target, const std::string& source = "") {
    add(target + fmt::format("#9001 = REPRESENTATION_MAP({},{});\n#9002 = MAPPED_ITEM('',#9001,#9100);\n",
                             source.empty() ? axis_ : source, representation_));
    return top(",#9002");
  }
  /// `reversed`: the relation leads from the assembly to the part.
  PlacedPart& relate(const std::string& transformation, bool reversed = false) {
    const std::string top_one = "#9012";
    add(transformation +
        fmt::format("#9001 = ( REPRESENTATION_RELATIONSHIP('','',{},{}) REPRESENTATION_RELATIONSHIP_WITH_"
                    "TRANSFORMATION(#9100) SHAPE_REPRESENTATION_RELATIONSHIP() );\n"
                    "#9002 = NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','use','',#9014,{},$);\n"
                    "#9003 = PRODUCT_DEFINITION_SHAPE('','',#9002);\n"
                    "#9004 = CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#9001,#9003);\n",
                    reversed ? top_one : representation_, reversed ? representation_ : top_one,
                    number_of("PRODUCT_DEFINITION")));
    return top("");
  }
  const std::filesystem::path& write() {
    tests::write_text(file_, text_);
    return file_;
  }

 private:
  void add(const std::string& entities) { text_.insert(text_.rfind("ENDSEC;"), entities); }
  std::string number_of(const std::string& type) const {
    const std::size_t at = text_.find("= " + type + "("), begin = text_.rfind('#', at);
    return text_.substr(begin, text_.find(' ', begin) - begin);
  }
  PlacedPart& top(const std::string& items) {
    add(
        fmt::format("#9010 = CARTESIAN_POINT('',(0.,0.,0.));\n#9011 = AXIS2_PLACEMENT_3D('',#9010,$,$);\n"
                    "#9012 = SHAPE_REPRESENTATION('',(#9011{}),{});\n#9013 = PRODUCT_DEFINITION_SHAPE('','',#9014);\n"
                    "#9014 = PRODUCT_DEFINITION('design','',#9015,{});\n"
                    "#9015 = PRODUCT_DEFINITION_FORMATION('','',#9016);\n#9016 = PRODUCT('TOP','TOP','',({}));\n"
                    "#9017 = SHAPE_DEFINITION_REPRESENTATION(#9013,#9012);\n",
                    items, context_, number_of("PRODUCT_DEFINITION_CONTEXT"), number_of("PRODUCT_CONTEXT")));
    return *this;
  }

  std::filesystem::path file_;
  std::string text_, representation_, axis_, context_;
};

/// Directions #9101 to #9103 and a point #9104, for entities that place.
std::string axes(const dvec3& x, const dvec3& y, const dvec3& z, const dvec3& origin) {
  std::string text;
  int id = 9101;
  for (const dvec3& d : {x, y, z}) text += fmt::format("#{} = DIRECTION('',({},{},{}));\n", id++, d.x, d.y, d.z);
  return text + fmt::format("#9104 = CARTESIAN_POINT('',({},{},{}));\n", origin.x, origin.y, origin.z);
}
const dvec3 kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

class CadPlacement : public testing::Test {
 protected:
  const ImportReport& read(const std::filesystem::path& file, const ImportOptions& options = {}) {
    scene_ = core::Scene();
    auto report = read_cad(file, scene_, scene_.root(), options);
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    EXPECT_TRUE(scene_.commit());
    return report_ = report.value_or(ImportReport());
  }
  void expect_bounds(const dvec3& min, const dvec3& max) const {
    const AabbD found = scene_.bounds(scene_.root());
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(found.min[k], 1e-3 * min[k], 1e-7) << k;
      EXPECT_NEAR(found.max[k], 1e-3 * max[k], 1e-7) << k;
    }
  }
  /// The volume of all meshes as they are placed; below 0 where one is inside out.
  double volume() const {
    double six = 0.0;
    for (std::uint32_t i = 0; i < scene_.item_slots(); ++i) {
      const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(core::ItemId{i}));
      const core::Affine world = scene_.state(core::ItemId{i}).world_from_item;
      for (std::size_t k = 0; k + 2 < mesh.indices.size(); k += 3) {
        std::array<dvec3, 3> p;
        for (std::size_t c = 0; c < 3; ++c)
          p[c] = core::transform_point(world, dvec3(mesh.positions[mesh.indices[k + c]]));
        six += glm::dot(p[0], glm::cross(p[1], p[2])) * (glm::determinant(world.linear) < 0.0 ? -1.0 : 1.0);
      }
    }
    return 1e9 * six / 6.0;
  }

  tests::CadFolder folder_;
  core::Scene scene_;
  ImportReport report_;
};
constexpr double kBracket = 1100.0;

TEST_F(CadPlacement, OperatorsScaleAndMirrorInAllTheirSpellings) {
  const char* spellings[] = {
      "#9100 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',#9101,#9102,#9104,{0},#9103);\n",
      "#9100 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('',#9101,#9102,#9104,{0},#9103);\n",  // of older schemas
      "#9100 = /* an operator; */ ( CARTESIAN_TRANSFORMATION_OPERATOR(#9101,#9102,#9104,{0}) "
      "CARTESIAN_TRANSFORMATION_OPERATOR_3D(#9103) FUNCTIONALLY_DEFINED_TRANSFORMATION('','it''s') "
      "GEOMETRIC_REPRESENTATION_ITEM() REPRESENTATION_ITEM('') );\n"};
  for (const char* spelling : spellings)
    for (const bool related : {false, true}) {
      SCOPED_TRACE(std::string(spelling) + (related ? "related" : "mapped"));
      const auto placed = [&](const std::string& entities) {
        PlacedPart bracket(folder_);
        read((related ? bracket.relate(entities) : bracket.map(entities)).write());
        EXPECT_TRUE(report_.warnings.empty()) << report_.warnings[0].message;
      };
      placed(axes(kX, kY, kZ, {100, 0, 0}) + fmt::format(fmt::runtime(spelling), "2."));
      expect_bounds({100, 0, 0}, {140, 20, 20});
      EXPECT_NEAR(volume(), 8 * kBracket, 0.1);
      placed(axes(-kX, kY, kZ, {300, 0, 0}) + fmt::format(fmt::runtime(spelling), "$"));
      expect_bounds({280, 0, 0}, {300, 10, 10});
      EXPECT_NEAR(volume(), kBracket, 0.1);
      placed(axes(kY, kX, kZ, {0, 0, 0}) + fmt::format(fmt::runtime(spelling), "3.E+00"));  // mirrored, in its place
      expect_bounds({0, 0, 0}, {30, 60, 30});
      EXPECT_NEAR(volume(), 27 * kBracket, 1.0);
      placed(axes(kX, kY, kZ, {0, 0, 0}) + fmt::format(fmt::runtime(spelling), "0.5"));
      expect_bounds({0, 0, 0}, {10, 5, 5});
    }
}

/// Operators of two dimensions place in the plane of x and y.
TEST_F(CadPlacement, OperatorsInAPlane) {
  const char* spellings[] = {
      "#9100 = CARTESIAN_TRANSFORMATION_OPERATOR_2D('','','',#9101,#9102,#9104,2.);\n",
      "#9100 = CARTESIAN_TRANSFORMATION_OPERATOR_2D('',#9101,#9102,#9104,2.);\n",
      "#9100 = ( CARTESIAN_TRANSFORMATION_OPERATOR(#9101,#9102,#9104,2.) CARTESIAN_TRANSFORMATION_OPERATOR_2D() "
      "FUNCTIONALLY_DEFINED_TRANSFORMATION('','') GEOMETRIC_REPRESENTATION_ITEM() REPRESENTATION_ITEM('') );\n"};
  const char* in_plane =
      "#9101 = DIRECTION('',(0.,3.));\n#9102 = DIRECTION('',({}1.,0.));\n"
      "#9104 = CARTESIAN_POINT('',(100.,50.));\n";
  for (const char* spelling : spellings)
    for (const bool related : {false, true}) {
      SCOPED_TRACE(std::string(spelling) + (related ? "related" : "mapped"));
      const auto placed = [&](const char* sign) {
        PlacedPart bracket(folder_);
        const std::string entities = fmt::format(fmt::runtime(in_plane), sign) + spelling;
        read((related ? bracket.relate(entities) : bracket.map(entities)).write());
        EXPECT_TRUE(report_.warnings.empty()) << report_.warnings[0].message;
        EXPECT_NEAR(volume(), 8 * kBracket, 0.1);
      };
      placed("-");
      expect_bounds({80, 50, 0}, {100, 90, 20});
      placed("");  // mirrored
      expect_bounds({100, 50, 0}, {120, 90, 20});
    }
}

TEST_F(CadPlacement, TransformationsBetweenItems) {
  const std::string source = "#9105 = CARTESIAN_POINT('',(5.,0.,0.));\n#9106 = AXIS2_PLACEMENT_3D('',#9105,$,$);\n";
  const std::string transformation = "#9100 = ITEM_DEFINED_TRANSFORMATION('','',#9106,#9107);\n";
  const std::string placement = "#9107 = AXIS2_PLACEMENT_3D('',#9104,#9103,#9101);\n";
  const std::string by_operator =
      "#9107 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',#9101,#9102,#9104,2.,#9103);\n";
  const auto placed = [&](const std::string& entities, bool reversed) {
    PlacedPart bracket(folder_);
    read(bracket.relate(source + transformation + entities, reversed).write());
    EXPECT_TRUE(report_.warnings.empty()) << report_.warnings[0].message;
  };
  const std::string moved = axes(kX, kY, kZ, {100, 0, 0}), mirrored = axes(-kX, kY, kZ, {100, 0, 0});
  placed(moved + placement, false);
  expect_bounds({95, 0, 0}, {115, 10, 10});
  placed(moved + placement, true);
  expect_bounds({-95, 0, 0}, {-75, 10, 10});
  placed(moved + by_operator, false);
  expect_bounds({90, 0, 0}, {130, 20, 20});
  EXPECT_NEAR(volume(), 8 * kBracket, 0.1);
  placed(moved + by_operator, true);
  expect_bounds({-45, 0, 0}, {-35, 5, 5});
  EXPECT_NEAR(volume(), kBracket / 8, 0.1);
  placed(mirrored + by_operator, false);
  expect_bounds({70, 0, 0}, {110, 20, 20});
  EXPECT_NEAR(volume(), 8 * kBracket, 0.1);
  placed(mirrored + by_operator, true);
  expect_bounds({45, 0, 0}, {55, 5, 5});
  EXPECT_NEAR(volume(), kBracket / 8, 0.1);
  const std::string turned = axes(-kX, kY, kZ, {100, 0, 0});
  placed(turned + placement, false);
  expect_bounds({85, -10, 0}, {105, 0, 10});
  placed(turned + placement, true);
  expect_bounds({85, -10, 0}, {105, 0, 10});
}

/// The source of a mapping and its target have axes of their own.
TEST_F(CadPlacement, MappingsFromAnyPlacement) {
  const auto mapped = [&](const std::string& target) {
    PlacedPart bracket(folder_);
    bracket.map(axes(-kX, -kY, kZ, {100, 0, 0}) + "#9105 = CARTESIAN_POINT('',(5.,0.,0.));\n" +
                    "#9106 = AXIS2_PLACEMENT_3D('',#9105,#9103,#9107);\n#9107 = DIRECTION('',(0.,1.,0.));\n" + target,
                "#9106");
    read(bracket.write());
    EXPECT_TRUE(report_.warnings.empty()) << report_.warnings[0].message;
  };
  mapped("#9100 = AXIS2_PLACEMENT_3D('',#9104,#9103,#9101);\n");
  expect_bounds({90, -5, 0}, {100, 15, 10});
  mapped("#9100 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',#9101,#9102,#9104,2.,#9103);\n");
  expect_bounds({80, -10, 0}, {100, 30, 20});
}

TEST_F(CadPlacement, OperatorsCountInTheirUnit) {
  PlacedPart bracket(folder_, PlacedPart::bracket(), "INCH");
  read(bracket
           .map(axes(kX, kY, kZ, {10, 0, 0}) +
                "#9100 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',$,$,#9104,2.,$);\n")
           .write());
  expect_bounds({254, 0, 0}, {294, 20, 20});
}

TEST_F(CadPlacement, OperatorsScaleToleranceAndDeviation) {
  const std::string hundredfold =
      axes(kX, kY, kZ, {10, 0, 0}) + "#9100 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',$,$,#9104,100.,$);\n";
  PlacedPart drilled(folder_, tests::cad_drilled_box());
  read(drilled.map(hundredfold).write(), {.chord_tolerance = 1e-4});
  EXPECT_NEAR(report_.surfaces.largest_tolerance, 1e-4, 1e-12);
  EXPECT_LE(report_.surfaces.deviation, 1e-4);
  EXPECT_GT(report_.surfaces.deviation, 1e-6);
  EXPECT_GT(report_.surfaces.triangles, 200u);
  PlacedPart cylinder(folder_, BRepPrimAPI_MakeCylinder(5.0, 20.0).Shape());
  read(cylinder.map(hundredfold).write());
  EXPECT_EQ(report_.surfaces.analytic_solids, 1u);
  expect_bounds({-490, -500, 0}, {510, 500, 2000});
}

TEST_F(CadPlacement, AnOperatorThatMakesNoSenseIsNamed) {
  PlacedPart bracket(folder_);
  read(bracket
           .map(axes(kX, kY, kZ, {100, 0, 0}) +
                "#9100 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',$,$,#9104,-2.,$);\n")
           .write());
  ASSERT_EQ(report_.warnings.size(), 1u);
  EXPECT_EQ(report_.warnings[0].message,
            "MAPPED_ITEM #9002 places nothing: expected an origin and a scale above 0 in "
            "CARTESIAN_TRANSFORMATION_OPERATOR #9100");
  expect_bounds({0, 0, 0}, {20, 10, 10});
}

TEST_F(CadPlacement, AxesThatAreNotStatedAreTheStandards) {
  const auto placed = [&](const dvec3& z, const char* parameters) {
    PlacedPart bracket(folder_);
    read(bracket.map(axes(z, kY, z, {100, 0, 0}) + "#9100 = AXIS2_PLACEMENT_3D('',#9104," + parameters + ");\n")
             .write());
    EXPECT_TRUE(report_.warnings.empty());
  };
  placed(kZ, "#9103,$");
  expect_bounds({100, 0, 0}, {120, 10, 10});
  placed(kX, "#9103,$");  // local x along y
  expect_bounds({100, 0, 0}, {110, 20, 10});
  placed(-kX, "#9103,$");
  expect_bounds({90, 0, -10}, {100, 20, 0});
  placed(kY, "#9103,$");
  expect_bounds({100, 0, -10}, {120, 10, 0});
  placed(kY, "#9103,#9101");  // parallel
  expect_bounds({100, 0, -10}, {120, 10, 0});
  placed(kZ, "$,$");
  expect_bounds({100, 0, 0}, {120, 10, 10});
}

// --- IGES ------------------------------------------------------------------------------------------------------------

/// A file of a patch of 10 x 20 mm, its subfigure (308) and an instance of that (408), or the patch alone. `matrix`: of
/// entity 124, row by row with the translation.
std::string iges_of_patch(bool instance, const std::string& scale, const std::string& matrix) {
  struct Entity {
    int kind;
    std::string parameters;
    int matrix;
  };
  std::vector<Entity> entities = {{128,
                                   "1,1,1,1,0,0,1,0,0,0.,0.,1.,1.,0.,0.,1.,1.,1.,1.,1.,1.,0.,0.,0.,10.,0.,0.,0.,20.,0.,"
                                   "10.,20.,0.,0.,1.,0.,1.",
                                   instance || matrix.empty() ? 0 : 3}};
  if (instance) {
    entities.push_back({308, "0,4Hpart,1,1", 0});
    entities.push_back({408, "3,100.,0.,0." + scale, matrix.empty() ? 0 : 7});
  }
  if (!matrix.empty()) entities.push_back({124, matrix, 0});
  std::string directory, parameters;
  int line = 0;
  for (std::size_t i = 0; i < entities.size(); ++i) {
    const auto& [kind, values, matrix_at] = entities[i];
    const int first = line + 1, at = 2 * int(i) + 1;
    std::string rest = fmt::format("{},{};", kind, values);
    while (!rest.empty()) {
      const std::size_t end = rest.size() <= 64 ? rest.size() : rest.rfind(',', 63) + 1;
      parameters += fmt::format("{:<64}{:>8}P{:>7}\n", rest.substr(0, end), at, ++line);
      rest.erase(0, end);
    }
    directory += fmt::format("{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}D{:>7}\n", kind, first, 0, 0, 0, 0,
                             matrix_at, 0, kind == 308 ? "00000201" : "00000000", at);
    directory += fmt::format("{:>8}{:>8}{:>8}{:>8}{:>8}{:>32}D{:>7}\n", kind, 0, 0, line - first + 1, 0, 0, at + 1);
  }
  return fmt::format("{:<72}S      1\n", "made by a test") +
         fmt::format("{:<72}G      1\n", "1H,,1H;,1Hp,1Hp,1Ht,1Ht,32,38,6,308,15,1Hp,1.,2,2HMM,1,0.01,") +
         fmt::format("{:<72}G      2\n", "15H20240101.000000,1.E-06,1000.,1Ha,1Hb,11,0,15H20240101.000000;") +
         directory + parameters +
         fmt::format("S{:>7}G{:>7}D{:>7}P{:>7}{:>40}T      1\n", 1, 2, 2 * entities.size(), line, "");
}

TEST_F(CadPlacement, IgesInstancesWithAScale) {
  const auto placed = [&](bool instance, const std::string& scale, const std::string& matrix) {
    tests::write_text(folder_ / "patch.igs", iges_of_patch(instance, scale, matrix));
    read(folder_ / "patch.igs");
  };
  placed(true, "", "");
  expect_bounds({100, 0, 0}, {110, 20, 0});
  placed(true, ",2.", "");
  expect_bounds({100, 0, 0}, {120, 40, 0});
  placed(true, ",2.", "1.,0.,0.,0.,0.,1.,0.,50.,0.,0.,1.,0.");
  expect_bounds({100, 50, 0}, {120, 90, 0});
  placed(false, "", "-1.,0.,0.,100.,0.,1.,0.,0.,0.,0.,1.,0.");
  expect_bounds({90, 0, 0}, {100, 20, 0});
  EXPECT_TRUE(report_.warnings.empty());
  placed(false, "", "2.,0.,0.,100.,0.,1.,0.,0.,0.,0.,1.,0.");
  ASSERT_EQ(report_.warnings.size(), 1u);
  EXPECT_EQ(report_.warnings[0].message, "transformation matrix (entity 124) at D3 distorts and is left out");
}

// --- the text of STEP files ------------------------------------------------------------------------------------------

TEST(StepText, ListsEntitiesInAnyWriting) {
  const std::string text =
      "HEADER;\nFILE_NAME('#1=NOT(1);');\nENDSEC;\nDATA;\n#30 = A ( 'it''s; (', #2 , (1.,-2.5E-1,.5), $ , .T. ) ;\n"
      "#4=(A('x')B(#3,#4) C());#4=TWICE();\n#7=OPEN(1,(2;\n#8=#9;ENDSEC;\n";
  const StepText found(text);
  ASSERT_EQ(found.entities().size(), 4u);
  const auto records = found.records(30);
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].keyword, "A");
  ASSERT_EQ(records[0].parameters.size(), 5u);
  EXPECT_EQ(records[0].parameters[0], "'it''s; ('");
  EXPECT_EQ(step_reference(records[0].parameters[1]), 2u);
  EXPECT_EQ(step_numbers(records[0].parameters[2]), (std::vector<double>{1.0, -0.25, 0.5}));
  EXPECT_FALSE(step_reference(records[0].parameters[3]));
  const auto complex = found.records(4);
  ASSERT_EQ(complex.size(), 3u);
  ASSERT_NE(find_record(complex, "B"), nullptr);
  EXPECT_EQ(find_record(complex, "B")->parameters.size(), 2u);
  EXPECT_TRUE(find_record(complex, "C")->parameters.empty());
  EXPECT_TRUE(found.records(7).empty());
  EXPECT_TRUE(found.records(8).empty());
  EXPECT_TRUE(found.records(99).empty());
}

/// A text cut or changed anywhere gives other entities, and never reads beyond its end.
TEST(StepText, TakesAnyText) {
  const std::string text = "#1=A('x',(1,(2,3)),\"0F\",#2);#2=(B()C(.T.));";
  for (std::size_t length = 0; length <= text.size(); ++length)
    for (const char c : {'\'', '(', ')', ';', '#', '"', '/', '*', '\0'}) {
      std::string changed = text.substr(0, length);
      if (length > 0) changed[length / 2] = c;
      const StepText found(changed);
      for (const auto& entity : found.entities())
        for (const StepRecord& record : found.records(entity.id))
          for (const std::string_view parameter : record.parameters) {
            step_reference(parameter);
            step_numbers(parameter);
            for (const std::string_view element : step_list(parameter)) EXPECT_LE(element.size(), parameter.size());
          }
    }
}

}  // namespace
}  // namespace sightline::importers::cad_placement_test
