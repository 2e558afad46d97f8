// Files of exact surfaces that Open CASCADE writes, and real ones of several programs: the tree, looks and places of
// their parts, in this process and in one of its own.
#include "sightline/importers/cad/internal/cad_reader.h"

#include <cmath>
#include <functional>
#include <thread>

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRep_Builder.hxx>
#include <BinTools.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <IGESControl_Reader.hxx>
#include <STEPControl_Reader.hxx>
#include <TDF_LabelSequence.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <XCAFDoc_GraphNode.hxx>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zip.h>
#include <zlib.h>

#include "sightline/analysis/measure/distances.h"
#include "sightline/analysis/measure/snap.h"
#include "sightline/core/surface_area.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/tests/importers/cad_model.h"
#include "sightline/tests/importers/primitive_distance.h"
#include "sightline/tests/importers/scene_compare.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::cad_reader_test {
namespace {

namespace fs = std::filesystem;
using core::dvec3;
using tests::CadModel;

class CadReader : public testing::Test {
 protected:
  /// In this process.
  const ImportReport& read(const fs::path& file, ImportOptions options = {}) {
    scene_ = core::Scene();
    auto report = read_cad(file, scene_, scene_.root(), options);
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    EXPECT_TRUE(scene_.commit());
    return report_ = report.value_or(ImportReport());
  }
  std::string error_of(const fs::path& file, ImportOptions options = {}) {
    scene_ = core::Scene();
    const auto report = read_cad(file, scene_, scene_.root(), options);
    EXPECT_EQ(scene_.node_count(), report ? scene_.node_count() : 1u);
    return report ? "" : report.error().message;
  }

  /// Below the file's node: "a/b". The n-th of that path.
  core::NodeId node(const std::string& path, int n = 0) const {
    core::NodeId found;
    const core::NodeId file = scene_.first_child(scene_.root());
    scene_.for_each_node(file, [&](core::NodeId at, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
      if (scene_.path(at) == std::string(scene_.name(file)) + "/" + path && n-- == 0) found = at;
    });
    EXPECT_TRUE(found.valid()) << path << " is not among:\n" << tree();
    return found.valid() ? found : file;
  }
  std::string tree() const {
    std::string all;
    scene_.for_each_node(scene_.root(), [&](core::NodeId at, const core::Affine&, bool, std::uint32_t,
                                            core::MaterialId) { all += scene_.path(at) + "\n"; });
    return all;
  }
  std::vector<core::ItemId> items(core::NodeId of) const {
    std::vector<core::ItemId> all;
    for (core::ItemId i = scene_.first_item(of); i != core::kNoItem; i = scene_.next_item(i)) all.push_back(i);
    return all;
  }
  core::ItemId item(const std::string& path) const {
    const auto all = items(node(path));
    EXPECT_EQ(all.size(), 1u) << path;
    return all.empty() ? core::ItemId{0} : all[0];
  }
  core::Material look(core::ItemId of) const {
    const core::MaterialId material = scene_.material_at(scene_.state(of).material);
    return material.valid() ? scene_.material(material) : core::Material{"none", core::vec3(-1.0f)};
  }
  std::string attribute(const std::string& path, const std::string& key) const {
    for (const auto& [k, value] : scene_.attributes(node(path)))
      if (k == key) return value;
    return "";
  }
  void expect_colour(core::ItemId of, const core::vec3& colour, float alpha = 1.0f) const {
    const core::Material found = look(of);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(found.colour[k], colour[k], 2e-3) << scene_.path(scene_.node_of(of));
    EXPECT_NEAR(found.alpha, alpha, 1e-3);
  }
  void expect_bounds(const core::AabbD& found, const dvec3& min, const dvec3& max, double within) const {
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(found.min[k], min[k], within);
      EXPECT_NEAR(found.max[k], max[k], within);
    }
  }

  tests::CadFolder folder_;
  core::Scene scene_;
  ImportReport report_;
};

/// An assembly with one below, a box and a drilled box, each used twice.
struct Plant {
  CadModel model;
  TDF_Label box, drilled, plant, rack, left, right, racked, upper;
  Plant() {
    box = model.part(tests::cad_box(100, 200, 300), "box");
    drilled = model.part(tests::cad_drilled_box(), "drilled");
    rack = model.assembly("rack");
    racked = model.use(rack, box, "racked box", tests::moved(0, 0, 1000));
    upper = model.use(rack, drilled, "upper", tests::moved(0, 0, 2000));
    plant = model.assembly("plant");
    left = model.use(plant, rack, "left rack", tests::moved(-3000, 0, 0));
    gp_Trsf turned;
    turned.SetRotation(gp::OZ(), 1.5707963267948966);
    right = model.use(plant, rack, "right rack", tests::moved(3000, 0, 0) * turned);
    model.use(plant, drilled, "single", tests::moved(0, 500, 0));
  }
};

TEST_F(CadReader, AssembliesPlacesAndSharedParts) {
  const Plant plant;
  for (const char* schema : {"AP203", "AP214IS", "AP242DIS"}) {
    SCOPED_TRACE(schema);
    plant.model.write_step(folder_ / "plant.stp", "MM", schema);
    const ImportReport& report = read(folder_ / "plant.stp");
    EXPECT_TRUE(report.warnings.empty()) << report.warnings[0].message;
    EXPECT_EQ(report.surfaces.parts, 2u);
    EXPECT_EQ(report.surfaces.instances, 5u);
    EXPECT_EQ(report.surfaces.analytic_solids, 1u);
    EXPECT_EQ(report.surfaces.meshed_bodies, 1u);
    EXPECT_EQ(report.shared_meshes, 2u);
    EXPECT_EQ(scene_.item_count(), 5u);
    EXPECT_EQ(scene_.mesh_slots(), 1u) << "shared";
    const core::ItemId box = item("plant/left rack/racked box"), drilled = item("plant/right rack/upper");
    EXPECT_EQ(scene_.kind(box), core::Kind::kBox);
    EXPECT_EQ(scene_.kind(drilled), core::Kind::kMesh);
    EXPECT_EQ(scene_.mesh_of(drilled), scene_.mesh_of(item("plant/single")));
    EXPECT_EQ(attribute("plant/left rack/racked box", "product"), "box");
    EXPECT_EQ(attribute("plant/left rack", "part number"), "rack");
    expect_bounds(scene_.bounds(node("plant/left rack/racked box")), dvec3(-3, 0, 1), dvec3(-2.9, 0.2, 1.3), 1e-7);
    expect_bounds(scene_.bounds(node("plant/right rack/racked box")), dvec3(2.8, 0, 1), dvec3(3, 0.1, 1.3), 1e-7);
    expect_bounds(scene_.bounds(node("plant/right rack/upper")), dvec3(2.98, 0, 2), dvec3(3, 0.02, 2.01), 1e-7);
    EXPECT_EQ(report.metres_per_unit, 1e-3);
  }
}

/// A block of 40 x 40 x 10 with a hole of 6, a countersunk one of 8 whose cone has 45 degrees, and a ball's and a
/// ring's mark in its upper face.
TopoDS_Shape machined() {
  TopoDS_Shape made = tests::cad_box(40, 40, 10);
  const auto at = [](double x, double y, double z) { return gp_Ax2(gp_Pnt(x, y, z), gp_Dir(0, 0, 1)); };
  for (const TopoDS_Shape& tool :
       {BRepPrimAPI_MakeCylinder(at(10, 10, -1), 3, 12).Shape(),
        BRepPrimAPI_MakeCylinder(at(30, 10, -1), 4, 12).Shape(), BRepPrimAPI_MakeCone(at(30, 10, 7), 4, 8, 4).Shape(),
        BRepPrimAPI_MakeSphere(gp_Pnt(10, 30, 10), 5).Shape(), BRepPrimAPI_MakeTorus(at(30, 30, 10), 6, 2).Shape()})
    made = BRepAlgoAPI_Cut(made, tool).Shape();
  return made;
}

std::string words_of(const std::vector<measure::Dimension>& dimensions) {
  std::string words;
  for (const measure::Dimension& d : dimensions)
    words += fmt::format("{}{} {:.6g}", words.empty() ? "" : ", ", d.name, d.angle ? glm::degrees(d.value) : d.value);
  return words;
}

/// Faces of meshed bodies keep their surfaces in each format, through the scene cache of a reader's own process and in
/// each use of a part.
TEST_F(CadReader, FacesOfMeshesKeepTheirSurfaces) {
  const CadModel model;
  const TDF_Label part = model.part(machined(), "machined"), plant = model.assembly("plant");
  gp_Trsf turned;
  turned.SetRotation(gp::OX(), 0.5);
  model.use(plant, part, "first");
  model.use(plant, part, "second", tests::moved(100, 0, 0) * turned);
  model.write_step(folder_ / "plant.stp");
  model.write_iges(folder_ / "plant.igs");
  for (const char* file : {"plant.stp", "plant.igs"}) {
    SCOPED_TRACE(file);
    scene_ = core::Scene();
    const auto report = import_file(folder_ / file, scene_, scene_.root());
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_TRUE(scene_.commit());
    std::vector<measure::Item> items;
    for (core::ItemId one{0}; to_index(one) < scene_.item_slots(); ++one)
      items.push_back(*measure::Item::create(scene_.mesh(scene_.mesh_of(one)), scene_.state(one).world_from_item));
    ASSERT_EQ(items.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      const core::Affine place =
          i == 0 ? core::Affine()
                 : core::Affine{core::dmat3(1, 0, 0, 0, std::cos(0.5), std::sin(0.5), 0, -std::sin(0.5), std::cos(0.5)),
                                {0.1, 0, 0}};
      const auto snapped = [&](double x, double y, double z) {
        const dvec3 world = core::transform_point(place, 1e-3 * dvec3(x, y, z));
        return measure::snap(items[i], measure::Aim{world, 2e-4, {}});
      };
      const auto words = [&](double x, double y, double z) {
        const auto found = snapped(x, y, z);
        return found ? words_of(found->dimensions) : "nothing";
      };
      EXPECT_EQ(words(13, 10, 5), "diameter 0.006, radius 0.003, length 0.01");
      EXPECT_EQ(words(30, 6, 3), "diameter 0.008, radius 0.004, length 0.007");
      EXPECT_EQ(words(30, 15.5, 8.5), "half angle 45, largest diameter 0.014, smallest diameter 0.008, length 0.003");
      EXPECT_EQ(words(10 + 3, 30, 6), "diameter 0.01, radius 0.005");
      EXPECT_EQ(words(36, 30, 8), "bend radius 0.006, tube diameter 0.004, tube radius 0.002");
      EXPECT_EQ(words(20, 20, 10), "");
      const auto hole = snapped(13, 10, 5), countersink = snapped(30, 15.5, 8.5);
      ASSERT_TRUE(hole && countersink && hole->axis && countersink->axis);
      EXPECT_EQ(hole->words, "surface of a cylindrical face of a mesh");
      const measure::AxisDistance axes = measure::axis_distance(*hole->axis, *countersink->axis);
      EXPECT_TRUE(axes.parallel);
      EXPECT_NEAR(axes.shortest.distance, 0.02, 1e-8);
      EXPECT_NEAR(glm::length(hole->point - core::transform_point(place, {0.013, 0.01, 0.005})), 0.0, 1e-8);
    }
  }
}

TEST_F(CadReader, UnitsOfStep) {
  CadModel model;
  model.part(tests::cad_box(1000, 2000, 3000), "box");
  const std::pair<const char*, double> units[] = {
      {"MM", 1e-3}, {"M", 1.0}, {"INCH", 0.0254}, {"FT", 0.3048}, {"CM", 1e-2}};
  for (const auto& [unit, metres] : units) {
    SCOPED_TRACE(unit);
    model.write_step(folder_ / "box.step", unit);
    EXPECT_NEAR(read(folder_ / "box.step").metres_per_unit, metres, 1e-12);
    expect_bounds(scene_.bounds(scene_.root()), dvec3(0), dvec3(1, 2, 3), 1e-6);
    model.write_iges(folder_ / "box.igs", unit);
    EXPECT_NEAR(read(folder_ / "box.igs").metres_per_unit, metres, 1e-12);
    expect_bounds(scene_.bounds(scene_.root()), dvec3(0), dvec3(1, 2, 3), 1e-6);
  }
}

TEST_F(CadReader, NamesInAllTheirWritings) {
  CadModel model;
  model.part(tests::cad_box(1, 2, 3), "PLACEHOLDER");
  model.write_step(folder_ / "name.stp");
  const std::string text = tests::text_of_file(folder_ / "name.stp");
  const std::pair<const char*, const char*> names[] = {
      {"plain", "plain"},    {"it''s", "it's"},      {"\\X2\\00DC\\X0\\ber", "Über"},  {"\\X2\\65E5672C\\X0\\", "日本"},
      {"\\S\\|ber", "über"}, {"\\X\\DCber", "Über"}, {"back\\\\slash", "back\\slash"}, {"Über", "Über"},
      {"a/b", "a/b"},
  };
  for (const auto& [written, meant] : names) {
    SCOPED_TRACE(written);
    tests::write_text(folder_ / "name2.stp", tests::replaced(text, "PLACEHOLDER", written));
    read(folder_ / "name2.stp");
    const core::NodeId part = scene_.first_child(scene_.first_child(scene_.root()));
    ASSERT_TRUE(part.valid());
    EXPECT_EQ(scene_.name(part), meant);
  }
  CadModel other;
  other.part(tests::cad_box(1, 2, 3), "Bügel 日本 'x'");
  other.write_step(folder_ / "other.stp");
  read(folder_ / "other.stp");
  EXPECT_EQ(scene_.name(scene_.first_child(scene_.first_child(scene_.root()))), "Bügel 日本 'x'");
}

/// Programs write letters without the escapes of the standard, too.
TEST_F(CadReader, NamesWithoutEscapes) {
  CadModel model;
  const TDF_Label part = model.part(tests::cad_box(1, 2, 3), "PART"), top = model.assembly("TOP");
  model.use(top, part, "");
  model.write_step(folder_ / "names.stp");
  std::string text = tests::text_of_file(folder_ / "names.stp");
  const std::string id_and_name = "','";
  text.insert(text.find(id_and_name, text.find("NEXT_ASSEMBLY_USAGE")) + id_and_name.size(), "USE");
  const auto named = [&](const std::string& name) {
    std::string all = tests::replaced(text, "'PART'", "'P" + name + "'");
    for (const std::string of : {"TOP", "USE"})
      all = tests::replaced(all, "'" + of + "'", "'" + of.substr(0, 1) + name + "'");
    return all;
  };
  for (const auto& [written, meant] :
       {std::pair("äöü", "äöü"), {"日本", "日本"}, {"\xe4\xf6\x80", "äö€"}, {"\U0001F527", "\U0001F527"}}) {
    SCOPED_TRACE(meant);
    tests::write_text(folder_ / "names.stp", named(written));
    read(folder_ / "names.stp");
    const std::string use = fmt::format("T{0}/U{0}", meant);
    item(use);
    EXPECT_EQ(attribute(use, "product"), fmt::format("P{}", meant));
    EXPECT_EQ(attribute(use, "part number"), fmt::format("P{}", meant));
    EXPECT_EQ(report_.warnings.size(), written == std::string(meant) ? 0u : 1u);
  }
}

TEST_F(CadReader, ColoursFromTheNearest) {
  Plant plant;
  plant.model.colour(plant.box, 1, 0, 0);
  plant.model.colour(plant.drilled, 0, 1, 0, 0.25f);
  plant.model.colour(plant.upper, 0, 0, 1);
  plant.model.write_step(folder_ / "plant.stp");
  read(folder_ / "plant.stp");
  expect_colour(item("plant/left rack/racked box"), {1, 0, 0});
  expect_colour(item("plant/single"), {0, 1, 0}, 0.25f);
  expect_colour(item("plant/left rack/upper"), {0, 0, 1});
  expect_colour(item("plant/right rack/upper"), {0, 0, 1});
}

TEST_F(CadReader, ColoursOfOneUseSeenFromAbove) {
  Plant plant;
  plant.model.colour(plant.box, 1, 0, 0);
  plant.model.shapes->UpdateAssemblies();
  TDF_LabelSequence path;
  path.Append(plant.right);
  path.Append(plant.racked);
  Handle(XCAFDoc_GraphNode) use;
  ASSERT_TRUE(plant.model.shapes->SetSHUO(path, use));
  plant.model.colour(use->Label(), 0.5, 0.25, 1);
  plant.model.write_step(folder_ / "plant.stp");
  read(folder_ / "plant.stp");
  expect_colour(item("plant/left rack/racked box"), {1, 0, 0});
  expect_colour(item("plant/right rack/racked box"), {0.5f, 0.25f, 1});
}

TEST_F(CadReader, ColouredFacesDivideAMeshAndShareItsEdges) {
  CadModel model;
  const TopoDS_Shape shape = tests::cad_drilled_box();
  const TDF_Label part = model.part(shape, "part");
  model.colour(part, 0, 0, 1);
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(shape, TopAbs_FACE, faces);
  model.face_colour(part, faces(1), 1, 0, 0);
  model.face_colour(part, faces(2), 1, 0, 0);
  model.write_step(folder_ / "faces.stp");
  read(folder_ / "faces.stp");
  const auto all = items(node("part"));
  ASSERT_EQ(all.size(), 2u);
  std::size_t triangles = 0;
  core::Mesh whole;
  for (const core::ItemId i : all) {
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(i));
    EXPECT_EQ(core::enclosure(mesh), core::Enclosure::kNothing);
    EXPECT_EQ(scene_.placement(i).origin, scene_.placement(all[0]).origin);
    for (const std::uint32_t index : mesh.indices)
      whole.indices.push_back(index + std::uint32_t(whole.positions.size()));
    whole.positions.insert(whole.positions.end(), mesh.positions.begin(), mesh.positions.end());
    triangles += mesh.indices.size() / 3;
  }
  EXPECT_EQ(core::enclosure(whole), core::Enclosure::kInside);
  EXPECT_EQ(triangles, report_.surfaces.triangles);
  const bool red_first = look(all[0]).colour.x > 0.5f;
  expect_colour(all[red_first ? 0 : 1], {1, 0, 0});
  expect_colour(all[red_first ? 1 : 0], {0, 0, 1});
}

TEST_F(CadReader, OneColouredFaceKeepsABoxAMesh) {
  CadModel model;
  const TopoDS_Shape shape = tests::cad_box(1, 2, 3);
  const TDF_Label part = model.part(shape, "part");
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(shape, TopAbs_FACE, faces);
  model.face_colour(part, faces(1), 1, 0, 0);
  model.write_step(folder_ / "faces.stp");
  read(folder_ / "faces.stp");
  EXPECT_EQ(items(node("part")).size(), 2u);
  EXPECT_EQ(report_.surfaces.analytic_solids, 0u);
}

TEST_F(CadReader, LayersAndHiddenParts) {
  Plant plant;
  plant.model.layers->SetLayer(plant.box, TCollection_ExtendedString("steel"));
  plant.model.layers->SetLayer(plant.drilled, TCollection_ExtendedString("off"));
  plant.model.layers->SetVisibility(plant.model.layers->FindLayer(TCollection_ExtendedString("off")), Standard_False);
  plant.model.write_step(folder_ / "plant.stp");
  read(folder_ / "plant.stp");
  EXPECT_EQ(attribute("plant/left rack/racked box", "layer"), "steel");
  EXPECT_TRUE(scene_.visible(node("plant/left rack/racked box")));
  EXPECT_EQ(attribute("plant/single", "layer"), "off");
  EXPECT_FALSE(scene_.visible(node("plant/single")));
}

/// Layers and invisible styles of one body among several of a part.
TEST_F(CadReader, LayersAndHiddenBodies) {
  CadModel model;
  TopoDS_Compound both;
  BRep_Builder().MakeCompound(both);
  for (const double x : {0.0, 100.0}) BRep_Builder().Add(both, tests::cad_drilled_box().Moved(tests::moved(x, 0, 0)));
  const TDF_Label part = model.part(both, "part");
  int body = 0;
  for (TopoDS_Iterator at(both); at.More(); at.Next()) model.face_colour(part, at.Value(), 1, body++, 0);
  model.write_step(folder_ / "part.stp");
  const std::string text = tests::text_of_file(folder_ / "part.stp");
  std::vector<std::string> solids, styles;
  for (const auto& [type, numbers] : {std::pair("= MANIFOLD_SOLID_BREP(", &solids), {"= STYLED_ITEM(", &styles}})
    for (std::size_t at = text.find(type); at != text.npos; at = text.find(type, at + 1)) {
      const std::size_t begin = text.rfind('#', at);
      numbers->push_back(text.substr(begin, text.find(' ', begin) - begin));
    }
  ASSERT_EQ(solids.size(), 2u);
  ASSERT_EQ(styles.size(), 2u);
  std::string layers;
  const auto read_with = [&](const std::string& entities) {
    std::string changed = text;
    tests::write_text(folder_ / "changed.stp", changed.insert(changed.rfind("ENDSEC;"), entities));
    read(folder_ / "changed.stp");
    layers.clear();
    std::vector<bool> visible;
    for (std::uint32_t i = 0; i < scene_.item_slots(); ++i) {
      const core::NodeId at = scene_.node_of(core::ItemId{i});
      for (const auto& [key, value] : scene_.attributes(at))
        if (key == "layer") layers += value + ";";
      visible.push_back(scene_.visible(at));
    }
    return visible;
  };
  using Visible = std::vector<bool>;
  EXPECT_EQ(read_with(""), (Visible{true, true}));
  EXPECT_EQ(layers, "");
  EXPECT_EQ(read_with("#9001 = INVISIBILITY((" + styles[1] + "));\n"), (Visible{true, false}));
  const std::string layer = "#9001 = PRESENTATION_LAYER_ASSIGNMENT('pipes','',(" + solids[0] + "));\n";
  EXPECT_EQ(read_with(layer), (Visible{true, true}));
  EXPECT_EQ(layers, "pipes;");
  const std::string hidden = layer + "#9002 = INVISIBILITY((#9001));\n";
  EXPECT_EQ(read_with(hidden), (Visible{false, true}));
  EXPECT_EQ(
      read_with(hidden + "#9003 = PRESENTATION_LAYER_ASSIGNMENT('all','',(" + styles[0] + "," + solids[1] + "));\n"),
      (Visible{true, true}));
  EXPECT_EQ(layers, "pipes, all;all;");
}

TEST_F(CadReader, HiddenComponents) {
  Plant plant;
  plant.model.colours->SetVisibility(plant.left, Standard_False);
  plant.model.colour(plant.left, 1, 1, 0);
  plant.model.write_step(folder_ / "plant.stp");
  read(folder_ / "plant.stp");
  EXPECT_FALSE(scene_.visible(node("plant/left rack")));
  EXPECT_TRUE(scene_.visible(node("plant/right rack")));
}

/// Adds entities at the end of a STEP file's data. '@' is the number of the entity that `after` ends with.
std::string with_entities(std::string text, const std::string& entities) {
  const std::size_t end = text.rfind("ENDSEC;");
  return text.insert(end, entities);
}

/// The number of the first entity of a type.
std::string number_of(const std::string& text, const std::string& type) {
  const std::size_t at = text.find("= " + type + "("), begin = text.rfind('#', at);
  return text.substr(begin, text.find(' ', begin) - begin);
}

TEST_F(CadReader, PropertiesOfParts) {
  CadModel model;
  model.part(tests::cad_box(1, 2, 3), "valve");
  model.write_step(folder_ / "valve.stp");
  std::string text = tests::text_of_file(folder_ / "valve.stp");
  text = tests::replaced(text, "PRODUCT('valve','valve','',", "PRODUCT('4711','valve','a \\X2\\00DC\\X0\\',");
  const std::string definition = number_of(text, "PRODUCT_DEFINITION"),
                    context = text.substr(text.rfind('#', text.find("= ( GEOMETRIC_REPRESENTATION_CONTEXT")), 4);
  text = with_entities(text,
                       fmt::format("#9001 = PROPERTY_DEFINITION('supplier','',{0});\n"
                                   "#9002 = DESCRIPTIVE_REPRESENTATION_ITEM('supplier','ACME M\\X2\\00FC\\X0\\ller');\n"
                                   "#9003 = REPRESENTATION('',(#9002,#9005),{1});\n"
                                   "#9004 = PROPERTY_DEFINITION_REPRESENTATION(#9001,#9003);\n"
                                   "#9005 = MEASURE_REPRESENTATION_ITEM('mass',MASS_MEASURE(12.5),#9006);\n"
                                   "#9006 = ( MASS_UNIT() NAMED_UNIT(*) SI_UNIT(.KILO.,.GRAM.) );\n",
                                   definition, context.substr(0, context.find(' '))));
  tests::write_text(folder_ / "valve.stp", text);
  read(folder_ / "valve.stp");
  EXPECT_EQ(attribute("valve", "part number"), "4711");
  EXPECT_EQ(attribute("valve", "description"), "a Ü");
  EXPECT_EQ(attribute("valve", "supplier"), "ACME Müller");
  EXPECT_EQ(attribute("valve", "mass").substr(0, 4), "12.5");
}

TEST_F(CadReader, UnknownItemsCostThemselvesAlone) {
  CadModel model;
  model.part(tests::cad_drilled_box(), "part");
  model.write_step(folder_ / "part.stp");
  std::string text = tests::text_of_file(folder_ / "part.stp");
  const std::string items = "ADVANCED_BREP_SHAPE_REPRESENTATION('',(", body = "MANIFOLD_SOLID_BREP('',";
  const std::string shell = text.substr(text.find(body) + body.size(), 8);
  text = with_entities(tests::replaced(text, body, "MANIFOLD_SOLID_BREP('First',"),
                       "#9009 = MANIFOLD_SOLID_BREP('Second'," + shell.substr(0, shell.find(')')) + ");\n");
  text = tests::replaced(text, items, items + "#9009,");
  const std::pair<const char*, const char*> damage[] = {
      {"#9001,", "#9001 = LEADER_DIRECTED_CALLOUT('',());\n"},
      {"#9001,", "#9001 = !ACME_NOTE('x');\n"},
      {"#9001,", ""},
      {"$,", ""},
      {"#9001,", "#9001 = MANIFOLD_SOLID_BREP('',#9002);\n"},
      {"#9001,", "#9001 = SHELL_BASED_SURFACE_MODEL('',(#9002));\n"},
      {"#9001,", "#9001 = SHELL_BASED_SURFACE_MODEL('',(#9002));\n#9002 = OPEN_SHELL('',(#9003));\n"},
  };
  for (const auto& [item_of_shape, entities] : damage)
    for (const bool in_process : {true, false}) {
      SCOPED_TRACE(fmt::format("{} {}", item_of_shape, entities));
      tests::write_text(folder_ / "more.stp",
                        with_entities(tests::replaced(text, items, items + item_of_shape), entities));
      scene_ = core::Scene();
      const auto report = import_file(folder_ / "more.stp", scene_, scene_.root(), {.in_process = in_process});
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_EQ(scene_.item_count(), 2u);
      item("part/First");
      item("part/Second");
      ASSERT_EQ(report->warnings.size(), 1u);
      EXPECT_TRUE(report->warnings[0].message.starts_with("1 items of shapes are not read"))
          << report->warnings[0].message;
    }
}

TEST_F(CadReader, ShapesAloneAreTriangles) {
  Plant plant;
  plant.model.colour(plant.box, 1, 0, 0);
  plant.model.write_step(folder_ / "plant.stp");
  plant.model.write_iges(folder_ / "plant.igs");
  BRepTools::Write(tests::cad_box(1, 2, 3), (folder_ / "box.brep").c_str());
  for (const auto& [name, count] : {std::pair("plant.stp", 5u), {"plant.igs", 5u}, {"box.brep", 1u}}) {
    SCOPED_TRACE(name);
    scene_ = core::Scene();
    const auto report = read_cad(folder_ / name, scene_, scene_.root(), {}, CadDetail::kShapesAlone);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(scene_.commit());
    EXPECT_EQ(scene_.item_count(), count);
    EXPECT_EQ(report->surfaces.analytic_solids, 0u);
    EXPECT_EQ(scene_.material_slots(), 0u);
    if (count > 1) expect_bounds(scene_.bounds(scene_.root()), dvec3(-3, 0, 0), dvec3(3, 0.52, 2.01), 1e-5);
  }
}

TEST_F(CadReader, CurvesAndAnnotationsAreCounted) {
  CadModel model;
  TopoDS_Compound both;
  BRep_Builder().MakeCompound(both);
  BRep_Builder().Add(both, tests::cad_box(1, 2, 3));
  BRep_Builder().Add(both, BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(5, 5, 5)).Edge());
  BRep_Builder().Add(both, BRepBuilderAPI_MakeEdge(gp_Pnt(1, 0, 0), gp_Pnt(5, 5, 5)).Edge());
  model.part(both, "both");
  model.write_step(folder_ / "both.stp");
  std::string text = tests::text_of_file(folder_ / "both.stp");
  text = with_entities(text,
                       "#9001 = DIMENSIONAL_SIZE(#9002,'diameter');\n"
                       "#9002 = SHAPE_ASPECT('','',#9003,.T.);\n"
                       "#9003 = PRODUCT_DEFINITION_SHAPE('','',#5);\n");
  tests::write_text(folder_ / "both.stp", text);
  read(folder_ / "both.stp");
  EXPECT_EQ(report_.surfaces.curves, 2u);
  EXPECT_EQ(report_.surfaces.annotations, 1u);
  ASSERT_EQ(report_.warnings.size(), 2u);
  EXPECT_EQ(report_.warnings[0].message, "2 curves are not read");
  EXPECT_EQ(report_.warnings[1].message, "1 dimensions, tolerances and notes are not read");
}

TEST_F(CadReader, BrepSharesMovedAndMirroredShapes) {
  const TopoDS_Shape part = tests::cad_drilled_box();
  TopoDS_Compound all;
  BRep_Builder().MakeCompound(all);
  gp_Trsf mirror;
  mirror.SetMirror(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(1, 0, 0)));
  BRep_Builder().Add(all, part);
  BRep_Builder().Add(all, part.Moved(TopLoc_Location(tests::moved(100, 0, 0))));
  BRep_Builder().Add(all, BRepBuilderAPI_Transform(part, mirror, Standard_False).Shape());
  ASSERT_TRUE(BRepTools::Write(all, (folder_ / "all.brep").c_str()));
  read(folder_ / "all.brep");
  EXPECT_EQ(scene_.item_count(), 3u);
  expect_bounds(scene_.bounds(scene_.root()), dvec3(-0.02, 0, 0), dvec3(0.12, 0.02, 0.01), 1e-8);
  std::ofstream binary(folder_ / "all2.brep", std::ios::binary);
  BinTools::Write(all, binary);
  binary.close();
  const std::size_t meshes = scene_.mesh_slots();
  read(folder_ / "all2.brep");
  EXPECT_EQ(scene_.item_count(), 3u);
  EXPECT_EQ(scene_.mesh_slots(), meshes);
  EXPECT_LE(meshes, 2u);
  for (std::size_t i = 0; i < 3; ++i) {
    const core::ItemId at{std::uint32_t(i)};
    EXPECT_EQ(core::enclosure(scene_.mesh(scene_.mesh_of(at))), core::Enclosure::kInside);
  }
}

TEST_F(CadReader, IgesHasPlacesNamesAndColours) {
  Plant plant;
  plant.model.colour(plant.box, 1, 0, 0);
  plant.model.write_iges(folder_ / "plant.IGS");
  read(folder_ / "plant.IGS");
  EXPECT_EQ(scene_.item_count(), 5u) << tree();
  expect_bounds(scene_.bounds(scene_.root()), dvec3(-3, 0, 0), dvec3(3, 0.52, 2.01), 1e-6);
  std::size_t boxes = 0;
  for (std::uint32_t i = 0; i < scene_.item_slots(); ++i) {
    if (scene_.kind(core::ItemId{i}) != core::Kind::kBox) continue;
    ++boxes;
    expect_colour(core::ItemId{i}, {1, 0, 0});
  }
  EXPECT_EQ(boxes, 2u);
  EXPECT_NE(tree().find("box"), std::string::npos) << tree();
}

TEST_F(CadReader, FacesThatFailAreCountedAndTheirPartNamed) {
  BRepBuilderAPI_MakePolygon crossed(gp_Pnt(5, 0, 0), gp_Pnt(6, 1, 0), gp_Pnt(6, 0, 0), gp_Pnt(5, 1, 0), Standard_True);
  TopoDS_Compound both;
  BRep_Builder().MakeCompound(both);
  BRep_Builder().Add(both, tests::cad_drilled_box());
  BRep_Builder().Add(both, BRepBuilderAPI_MakeFace(gp_Pln(), crossed.Wire(), Standard_False).Face());
  BRepTools::Write(both, (folder_ / "broken.brep").c_str());  // STEP would mend it
  read(folder_ / "broken.brep");
  EXPECT_EQ(report_.surfaces.failed_faces, 1u);
  ASSERT_EQ(report_.warnings.size(), 1u);
  EXPECT_EQ(report_.warnings[0].message, "1 faces could not be meshed and are left out, most (1) of part 'FACE'");
  EXPECT_EQ(scene_.item_count(), 1u);
}

TEST_F(CadReader, FaultsOfMeshesAreNamed) {
  TopoDS_Shell shell;
  BRep_Builder().MakeShell(shell);
  TopExp_Explorer face(tests::cad_drilled_box(), TopAbs_FACE);
  for (face.Next(); face.More(); face.Next()) BRep_Builder().Add(shell, face.Current());
  TopoDS_Solid solid;
  BRep_Builder().MakeSolid(solid);
  BRep_Builder().Add(solid, shell);
  BRepTools::Write(solid, (folder_ / "open.brep").c_str());
  read(folder_ / "open.brep");
  ASSERT_EQ(report_.warnings.size(), 1u);
  EXPECT_TRUE(report_.warnings[0].message.starts_with("1 solids do not close, first ")) << report_.warnings[0].message;
  EXPECT_TRUE(report_.warnings[0].message.ends_with(" edges of part 'SOLID'")) << report_.warnings[0].message;

  BRepBuilderAPI_MakePolygon outer(gp_Pnt(0, 0, 0), gp_Pnt(9, 0, 0), gp_Pnt(9, 9, 0), gp_Pnt(0, 9, 0), Standard_True);
  BRepBuilderAPI_MakePolygon inner(gp_Pnt(1, 1, 0), gp_Pnt(8, 1, 0), gp_Pnt(8, 8, 0), gp_Pnt(1, 8, 0), Standard_True);
  BRepBuilderAPI_MakeFace wrong(outer.Wire());
  wrong.Add(inner.Wire());
  BRepTools::Write(wrong.Face(), (folder_ / "wrong.brep").c_str());
  read(folder_ / "wrong.brep");
  ASSERT_EQ(report_.warnings.size(), 2u);
  EXPECT_EQ(report_.warnings[0].message,
            "1 faces are meshed with another area than their borders enclose, first face 1 of part 'FACE'");
  EXPECT_NE(report_.warnings[1].message.find("m off their surfaces in part 'FACE'"), std::string::npos);
  EXPECT_GT(report_.surfaces.deviation, report_.surfaces.largest_tolerance);
}

// --- compressed, and other files -------------------------------------------------------------------------------------

void write_gzip(const fs::path& path, const std::string& text) {
  gzFile file = gzopen(path.c_str(), "wb");
  gzwrite(file, text.data(), unsigned(text.size()));
  gzclose(file);
}
void write_zip(const fs::path& path, const std::string& text) {
  int error = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
  zip_file_add(archive, "model.stp", zip_source_buffer(archive, text.data(), text.size(), 0), 0);
  zip_close(archive);
}

TEST_F(CadReader, CompressedFilesAndUpperCase) {
  const Plant plant;
  plant.model.write_step(folder_ / "plant.STEP");
  read(folder_ / "plant.STEP");
  core::Scene whole = std::move(scene_);
  const std::string text = tests::text_of_file(folder_ / "plant.STEP");
  write_gzip(folder_ / "gzip.stpz", text);
  write_zip(folder_ / "zip.StpZ", text);
  for (const char* name : {"gzip.stpz", "zip.StpZ"}) {
    read(folder_ / name);
    EXPECT_EQ(
        tests::scene_difference(whole, whole.first_child(whole.root()), scene_, scene_.first_child(scene_.root())), "")
        << name;
  }
  const std::string gzip = tests::text_of_file(folder_ / "gzip.stpz"), zip = tests::text_of_file(folder_ / "zip.StpZ");
  tests::write_text(folder_ / "cut.stpz", std::string_view(gzip).substr(0, gzip.size() / 2));
  EXPECT_EQ(error_of(folder_ / "cut.stpz"), "cut.stpz: is no whole gzip file");
  tests::write_text(folder_ / "cut.stpz", std::string_view(zip).substr(0, zip.size() / 2));
  EXPECT_EQ(error_of(folder_ / "cut.stpz"), "cut.stpz: is no whole zip file");
}

TEST_F(CadReader, WhatIsNoModel) {
  for (const char* extension : {".stp", ".igs", ".brep", ".stpz"}) {
    SCOPED_TRACE(extension);
    const std::string name = std::string("no") + extension;
    for (const std::string text : {"", "no model at all\n", "ISO-10303-21;\n", "\x1f\x8b", "PK"}) {
      tests::write_text(folder_ / name, text);
      const std::string error = error_of(folder_ / name);
      EXPECT_NE(error.find(name + ": "), std::string::npos) << error;
    }
  }
  core::Scene scene;
  fs::create_directory(folder_ / "folder.stp");
  const auto folder = import_file(folder_ / "folder.stp", scene, scene.root());
  ASSERT_FALSE(folder);
  EXPECT_NE(folder.error().message.find("is a directory"), std::string::npos);
  tests::write_text(folder_ / "empty.stp", "");
  const auto empty = import_file(folder_ / "empty.stp", scene, scene.root());
  ASSERT_FALSE(empty);
  EXPECT_TRUE(empty.error().message.starts_with((folder_ / "empty.stp").string())) << empty.error().message;
  EXPECT_EQ(scene.node_count(), 1u);
}

TEST_F(CadReader, OptionsOutOfRange) {
  CadModel model;
  model.part(tests::cad_box(1, 2, 3), "box");
  model.write_step(folder_ / "box.stp");
  for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_NE(error_of(folder_ / "box.stp", {.chord_tolerance = bad}).find("chord_tolerance"), std::string::npos);
    EXPECT_NE(error_of(folder_ / "box.stp", {.chord_angle = bad}).find("chord_angle"), std::string::npos);
  }
}

/// An assembly whose parts are in files of their own.
class CadReaderParts : public CadReader {
 protected:
  void SetUp() override {
    const Plant plant;
    plant.model.shapes->UpdateAssemblies();
    STEPCAFControl_Controller::Init();
    Interface_Static::SetCVal("write.step.schema", "AP214IS");
    Interface_Static::SetCVal("write.step.unit", "MM");
    STEPCAFControl_Writer writer;
    ASSERT_TRUE(writer.Transfer(plant.model.document, STEPControl_AsIs, ""));
    const fs::path before = fs::current_path();
    fs::current_path(folder_.path());
    const auto status = writer.Write("plant.stp");
    fs::current_path(before);
    ASSERT_EQ(status, IFSelect_RetDone);
  }
  std::string text() const { return tests::text_of_file(folder_ / "plant.stp"); }
};

TEST_F(CadReaderParts, AreFoundInTheFolder) {
  ASSERT_TRUE(fs::exists(folder_ / "box.stp"));
  read(folder_ / "plant.stp");
  EXPECT_TRUE(report_.warnings.empty()) << report_.warnings[0].message;
  EXPECT_EQ(scene_.item_count(), 5u) << tree();
  expect_bounds(scene_.bounds(scene_.root()), dvec3(-3, 0, 0), dvec3(3, 0.52, 2.01), 1e-7);
  EXPECT_EQ(report_.side_files.size(), 2u);
}

TEST_F(CadReaderParts, ThatAreMissingAreDamage) {
  fs::remove(folder_ / "box.stp");
  const std::string error = error_of(folder_ / "plant.stp");
  EXPECT_NE(error.find("box.stp"), std::string::npos) << error;
  read(folder_ / "plant.stp", {.lenient = true});
  ASSERT_FALSE(report_.warnings.empty());
  EXPECT_NE(report_.warnings[0].message.find("box.stp"), std::string::npos);
  EXPECT_EQ(scene_.item_count(), 3u) << tree();
}

TEST_F(CadReaderParts, OutsideTheFolderAreNotRead) {
  fs::create_directory(folder_ / "models");
  fs::copy(folder_ / "drilled.stp", folder_ / "models/drilled.stp");
  for (const std::string& name :
       {std::string("../box.stp"), (folder_ / "box.stp").string(), std::string("models/../../box.stp")}) {
    SCOPED_TRACE(name);
    tests::write_text(folder_ / "models/plant.stp", tests::replaced(text(), "'box.stp'", "'" + name + "'"));
    EXPECT_NE(error_of(folder_ / "models/plant.stp"), "");
    read(folder_ / "models/plant.stp", {.lenient = true});
    EXPECT_EQ(scene_.item_count(), 3u) << tree();
    EXPECT_FALSE(report_.warnings.empty());
  }
}

TEST_F(CadReaderParts, AreFoundFromAnyFolder) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_.path().parent_path());
  const fs::path relative = folder_.path().filename() / "plant.stp";
  for (const fs::path& file : {relative, "." / relative, folder_ / "plant.stp"}) {
    read(file);
    EXPECT_TRUE(report_.warnings.empty()) << report_.warnings[0].message;
    EXPECT_EQ(scene_.item_count(), 5u) << tree();
  }
  fs::current_path(before);
}

TEST_F(CadReaderParts, AreFoundByWhatOtherSystemsWrite) {
  fs::create_directory(folder_ / "sub");
  fs::rename(folder_ / "box.stp", folder_ / "sub/Bo x.stp");
  for (const auto& [name, guessed] : {std::pair(std::string("sub/Bo x.stp"), false),
                                      {"./sub/Bo x.stp", false},
                                      {"sub\\\\Bo x.stp", false},
                                      {"sub/Bo%20x.stp", false},
                                      {"file:sub/Bo%20x.stp", false},
                                      {"file://" + (folder_ / "sub/Bo%20x.stp").string(), false},
                                      {"sub/Bo x", false},
                                      {"SUB/bo X.STP", true},
                                      {"Sub\\\\BO x.stp", true}}) {
    SCOPED_TRACE(name);
    tests::write_text(folder_ / "other.stp", tests::replaced(text(), "'box.stp'", fmt::format("'{}'", name)));
    read(folder_ / "other.stp");
    EXPECT_EQ(scene_.item_count(), 5u) << tree();
    EXPECT_EQ(report_.warnings.size(), guessed ? 1u : 0u);
  }
  // The last part of a path of another machine is looked for in the folder.
  fs::rename(folder_ / "sub/Bo x.stp", folder_ / "box.stp");
  for (const char* name : {"C:\\\\work\\\\parts\\\\box.stp", "file:///C:/work/box.stp", "/home/someone/box.stp"}) {
    SCOPED_TRACE(name);
    tests::write_text(folder_ / "other.stp", tests::replaced(text(), "'box.stp'", fmt::format("'{}'", name)));
    read(folder_ / "other.stp");
    EXPECT_EQ(scene_.item_count(), 5u) << tree();
    EXPECT_EQ(report_.warnings.size(), 1u);
  }
}

/// Each file in a folder of its own, the outer naming the inner by its own folder; and with what wraps other files.
TEST_F(CadReaderParts, MayBeAssembliesOfParts) {
  fs::create_directories(folder_ / "models/parts");
  fs::create_directory(folder_ / "common");
  fs::rename(folder_ / "plant.stp", folder_ / "models/plant.stp");
  fs::rename(folder_ / "drilled.stp", folder_ / "models/parts/drilled.stp");
  tests::write_text(folder_ / "common/box.stp", "\xef\xbb\xbf" + tests::text_of_file(folder_ / "box.stp"));
  const auto inner = tests::text_of_file(folder_ / "models/plant.stp");
  tests::write_text(folder_ / "models/plant.stp",
                    tests::replaced(tests::replaced(inner, "'drilled.stp'", "'parts/drilled.stp'"), "'box.stp'",
                                    "'..\\\\Common\\\\box.stp'"));
  tests::write_text(folder_ / "top.stp", tests::replaced(tests::replaced(inner, "'drilled.stp'", "'models/plant.stp'"),
                                                         "'box.stp'", "'common/box.stp'"));
  read(folder_ / "top.stp");
  EXPECT_EQ(scene_.item_count(), 2u + 3u * 5u) << tree();
  EXPECT_EQ(scene_.mesh_slots(), 1u) << "each file is read once";
  item("plant/left rack/upper/right rack/upper");
}

TEST_F(CadReaderParts, WithinThemselvesAreDamage) {
  tests::write_text(folder_ / "box.stp", text());
  EXPECT_EQ(error_of(folder_ / "plant.stp"), "plant.stp: part 'box.stp' is used within itself");
  read(folder_ / "plant.stp", {.lenient = true});
  EXPECT_GT(scene_.item_count(), 3u);
}

TEST_F(CadReaderParts, NothingReadAtAllIsAnError) {
  fs::remove(folder_ / "box.stp");
  fs::remove(folder_ / "drilled.stp");
  EXPECT_EQ(error_of(folder_ / "plant.stp", {.lenient = true}),
            "plant.stp: none of its parts in other files could be read: part 'box.stp' not found");
}

TEST_F(CadReaderParts, OfOtherFormatsAreSaid) {
  tests::write_text(folder_ / "plant.stp", tests::replaced(text(), "'box.stp'", "'box.jt'"));
  tests::write_text(folder_ / "box.jt", "Version 8.1 JT");
  read(folder_ / "plant.stp");
  EXPECT_EQ(scene_.item_count(), 3u) << tree();
  ASSERT_EQ(report_.warnings.size(), 1u);
  EXPECT_EQ(report_.warnings[0].message, "part 'box.jt' is not read: it is no STEP file, or not there");
}

// --- in a process of its own -----------------------------------------------------------------------------------------

TEST_F(CadReader, ReadsTheSameInAProcessOfItsOwn) {
  Plant plant;
  plant.model.colour(plant.box, 1, 0.5, 0, 0.5f);
  plant.model.layers->SetLayer(plant.drilled, TCollection_ExtendedString("steel"));
  plant.model.write_step(folder_ / "plant.stp");
  read(folder_ / "plant.stp");
  for (const bool in_process : {false, true}) {
    core::Scene apart;
    std::vector<double> shares;
    ImportOptions options;
    options.in_process = in_process;
    options.progress = [&](double share) {
      shares.push_back(share);
      return true;
    };
    const auto report = import_file(folder_ / "plant.stp", apart, apart.root(), options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(tests::scene_difference(scene_, scene_.first_child(scene_.root()), apart, report->nodes.at(0)), "");
    EXPECT_EQ(report->surfaces.parts, report_.surfaces.parts);
    EXPECT_EQ(report->surfaces.instances, report_.surfaces.instances);
    EXPECT_EQ(report->surfaces.analytic_solids, report_.surfaces.analytic_solids);
    EXPECT_EQ(report->surfaces.meshed_bodies, report_.surfaces.meshed_bodies);
    EXPECT_EQ(report->surfaces.triangles, report_.surfaces.triangles);
    EXPECT_EQ(report->surfaces.deviation, report_.surfaces.deviation);
    EXPECT_EQ(report->surfaces.analytic_deviation, report_.surfaces.analytic_deviation);
    EXPECT_EQ(report->surfaces.largest_tolerance, report_.surfaces.largest_tolerance);
    EXPECT_EQ(report->items, report_.items);
    EXPECT_EQ(report->bytes, report_.bytes);
    EXPECT_EQ(report->shared_meshes, report_.shared_meshes);
    EXPECT_EQ(report->metres_per_unit, report_.metres_per_unit);
    EXPECT_FALSE(report->from_cache);
    ASSERT_FALSE(shares.empty());
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    EXPECT_EQ(shares.back(), 1.0);
    EXPECT_TRUE(apart.commit());
  }
}

/// Processes whose parent is this one.
int children() {
  int count = 0;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    if (entry.path().filename().string().find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = tests::text_of_file(entry.path() / "stat");
    const std::size_t name = stat.rfind(") ");
    if (name != std::string::npos && std::atoi(stat.c_str() + name + 4) == getpid()) ++count;
  }
  return count;
}

TEST_F(CadReader, CancellingEndsTheProcess) {
  const Plant plant;
  plant.model.write_step(folder_ / "plant.stp");
  core::Scene scene;
  ImportOptions options;
  int seen = 0;
  options.progress = [&](double) {
    seen = std::max(seen, children());
    return false;
  };
  const auto report = import_file(folder_ / "plant.stp", scene, scene.root(), options);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, kCancelled);
  EXPECT_EQ(seen, 1) << "there was one";
  EXPECT_EQ(children(), 0);
  EXPECT_EQ(scene.node_count(), 1u);
  EXPECT_EQ(scene.item_slots(), 0u);
  EXPECT_EQ(scene.mesh_slots(), 0u);
}

TEST_F(CadReader, CancellingAtAnyTimeLeavesTheScene) {
  const Plant plant;
  plant.model.write_step(folder_ / "plant.stp");
  plant.model.write_iges(folder_ / "plant.igs");
  BRepTools::Write(tests::cad_drilled_box(), (folder_ / "part.brep").c_str());
  for (const char* name : {"plant.stp", "plant.igs", "part.brep"})
    for (const double at : {0.0, 0.01, 0.3, 0.5, 0.9}) {
      SCOPED_TRACE(fmt::format("{} at {}", name, at));
      ImportOptions options;
      options.progress = [&](double share) { return share < at; };
      EXPECT_EQ(error_of(folder_ / name, options), kCancelled);
      EXPECT_EQ(scene_.item_slots(), 0u);
    }
}

/// What an import says when `script` stands where the reader should.
std::string error_with(const std::string& script, const fs::path& reader, const fs::path& file) {
  tests::write_text(reader, "#!/bin/sh\n" + script);
  fs::permissions(reader, fs::perms::owner_all);
  core::Scene scene;
  const auto report = import_file(file, scene, scene.root());
  EXPECT_EQ(scene.node_count(), report ? scene.node_count() : 1u);
  EXPECT_EQ(scene.item_slots(), report ? scene.item_slots() : 0u);
  EXPECT_EQ(children(), 0);
  return report ? "" : report.error().message;
}

/// The reader is found beside the program. So a copy of this one runs the test again in a folder of its own, with
/// scripts in the reader's place.
TEST_F(CadReader, ReadersThatEndBadly) {
  const fs::path self = fs::read_symlink("/proc/self/exe");
  if (!std::getenv("SIGHTLINE_COPIED_TEST")) {
    fs::copy_file(self, folder_ / "test");
    EXPECT_EQ(std::system(("SIGHTLINE_COPIED_TEST=" + self.parent_path().string() + " " + (folder_ / "test").string() +
                           " --gtest_filter=CadReader.ReadersThatEndBadly")
                              .c_str()),
              0);
    return;
  }
  const Plant plant;
  const fs::path file = folder_ / "plant.stp", reader = self.parent_path() / "sightline-cad-reader";
  const std::string real =
      (fs::path(std::getenv("SIGHTLINE_COPIED_TEST")).parent_path() / "libexec/sightline/sightline-cad-reader")
          .string();
  plant.model.write_step(file);
  const std::string name = file.string() + ": ";
  EXPECT_EQ(error_with("exec " + real + " \"$@\"", reader, file), "") << "the real one";
  EXPECT_EQ(error_with("kill -SEGV $$", reader, file),
            name + "Open CASCADE crashed while it read this file (Segmentation fault)");
  EXPECT_EQ(error_with("kill -KILL $$", reader, file), name + "Open CASCADE crashed while it read this file (Killed)");
  EXPECT_EQ(error_with("kill -XCPU $$", reader, file),
            name + "Open CASCADE took more than 120 s of processor time (reading in this process has no limit)");
  // A crash at all that a file holds leaves its shapes.
  const std::string crash_at_more = "case \"$*\" in *shapes_alone=1*) exec " + real + " \"$@\" ;; esac; kill -SEGV $$";
  EXPECT_EQ(error_with(crash_at_more, reader, file), "");
  core::Scene scene;
  const auto shapes = import_file(file, scene, scene.root());
  ASSERT_TRUE(shapes);
  EXPECT_EQ(scene.item_count(), 5u);
  ASSERT_EQ(shapes->warnings.size(), 1u);
  EXPECT_EQ(shapes->warnings[0].message,
            "Open CASCADE crashed while it read this file (Segmentation fault); read again as triangles without names, "
            "colours, layers, properties and parts in other files");
  EXPECT_EQ(error_with("exit 3", reader, file), name + "its reader ended with 3");
  EXPECT_EQ(error_with("echo 'e plant.stp: said so' >&3; exit 1", reader, file), name + "said so");
  EXPECT_NE(error_with("exit 0", reader, file), "") << "without a result";
  EXPECT_NE(error_with("echo no cache > \"$2\"; exit 0", reader, file), "");
  EXPECT_EQ(error_with("i=0; while [ $i -lt 3000 ]; do echo 'p 0.5' >&3; i=$((i+1)); done; exit 3", reader, file),
            name + "its reader ended with 3");
  // A megabyte without a line's end.
  EXPECT_EQ(error_with("head -c 1000000 /dev/zero >&3; exit 3", reader, file), name + "its reader ended with 3");
#ifndef __SANITIZE_ADDRESS__
  const std::string memory = error_with("exec " + real + " \"$@\" memory=60000000", reader, file);
  EXPECT_TRUE(memory.starts_with(name)) << memory;
#endif
  fs::remove(reader);
  EXPECT_EQ(error_with("exec " + real + " \"$@\" seconds=1", reader, file), "") << "time enough";
}

/// An assembly of `instances` uses of `parts` distinct parts, every other one of which is a box.
void write_large_assembly(const fs::path& file, int parts, int instances) {
  const CadModel model;
  const TDF_Label top = model.assembly("hall");
  std::vector<TDF_Label> all;
  for (int i = 0; i < parts; ++i) {
    const double size = 10.0 + 0.1 * i;
    all.push_back(i % 2 == 0 ? model.part(tests::cad_box(size, 20, 30), fmt::format("box {}", i).c_str())
                             : model.part(tests::cad_drilled_box(size), fmt::format("drilled {}", i).c_str()));
  }
  for (int i = 0; i < instances; ++i)
    model.use(top, all[std::size_t(i % parts)], fmt::format("use {}", i).c_str(),
              tests::moved(50.0 * (i % 100), 50.0 * (i / 100 % 100), 50.0 * (i / 10000)));
  model.write_step(file);
}

TEST_F(CadReader, LargeAssembliesShareTheirParts) {
  const int parts = tests::long_run() ? 200 : 50, instances = tests::long_run() ? 10000 : 1000;
  write_large_assembly(folder_ / "hall.stp", parts, instances);
  const std::vector<fs::path> files = {folder_ / "hall.stp"};
  ImportOptions options;
  options.cache_folder = folder_ / "cache";
  core::Scene first;
  for (const bool again : {false, true}) {
    core::Scene scene;
    const auto report = import_files(files, scene, scene.root(), options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
    EXPECT_EQ(report->from_cache, again);
    EXPECT_EQ(report->surfaces.parts, std::uint64_t(parts));
    EXPECT_EQ(report->surfaces.instances, std::uint64_t(instances));
    EXPECT_EQ(report->surfaces.analytic_solids, std::uint64_t(parts / 2));
    EXPECT_EQ(report->surfaces.meshed_bodies, std::uint64_t(parts / 2));
    EXPECT_EQ(report->shared_meshes, std::uint64_t((instances - parts) / 2));
    EXPECT_EQ(scene.item_count(), std::size_t(instances));
    EXPECT_EQ(scene.mesh_slots(), std::size_t(parts / 2)) << "each mesh is there once";
    EXPECT_TRUE(scene.commit());
    if (again) {
      EXPECT_EQ(tests::scene_difference(first, first.first_child(first.root()), scene, report->nodes.at(0)), "");
    }
    first = std::move(scene);
  }
}

// --- other programs' files -------------------------------------------------------------------------------------------

struct Truth {
  core::AabbD bounds;
  double volume = 0.0, area = 0.0;
};

/// Measures all solids and faces by Open CASCADE's plain readers.
Truth truth_of(const fs::path& file) {
  TopoDS_Shape shape;
  const std::string extension = lower_case_extension(file);
  if (extension == ".brep") {
    BRepTools::Read(shape, file.c_str(), BRep_Builder());
  } else if (extension == ".igs") {
    IGESControl_Reader reader;
    reader.ReadFile(file.c_str());
    reader.TransferRoots();
    shape = reader.OneShape();
  } else {
    STEPControl_Reader reader;
    reader.ReadFile(file.c_str());
    reader.TransferRoots();
    shape = reader.OneShape();
  }
  Truth truth;
  Bnd_Box box;
  BRepBndLib::AddOptimal(shape, box, Standard_False, Standard_False);
  double x0, y0, z0, x1, y1, z1;
  box.Get(x0, y0, z0, x1, y1, z1);
  truth.bounds = {dvec3(x0, y0, z0), dvec3(x1, y1, z1)};
  GProp_GProps volume, area;
  for (TopExp_Explorer solid(shape, TopAbs_SOLID); solid.More(); solid.Next()) {
    GProp_GProps of;
    BRepGProp::VolumeProperties(solid.Current(), of, 1e-6);
    truth.volume += of.Mass();
  }
  BRepGProp::SurfaceProperties(shape, area, 1e-6);
  truth.area = area.Mass();
  return truth;
}

double volume_of(const core::Mesh& mesh) {
  double six = 0.0;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
    six += glm::dot(dvec3(mesh.positions[mesh.indices[i]]),
                    glm::cross(dvec3(mesh.positions[mesh.indices[i + 1]]), dvec3(mesh.positions[mesh.indices[i + 2]])));
  return six / 6.0;
}

struct RealFile {
  const char* name;
  std::size_t parts, instances, analytic;
};
const RealFile kRealFiles[] = {
    {"as1-oc-214.stp", 5, 18, 2},      {"as1-tu-203.stp", 5, 18, 2}, {"as1_pe_203.brep", 5, 18, 2},
    {"conical-surface.step", 1, 1, 0}, {"cube-10x10.igs", 1, 1, 1},  {"cube-in.step", 1, 1, 1},
    {"cube-m.step", 1, 1, 1},          {"cube-mm.step", 1, 1, 1},    {"dm1-oc-214.stp", 3, 7, 1},
    {"rounded-cube.step", 1, 1, 0},    {"screw.step", 1, 1, 0}};

/// A long run prints a table of them.
TEST_F(CadReader, FilesOfOtherPrograms) {
  SIGHTLINE_NEED_DATA("step/as1-oc-214.stp");
  std::string table;
  for (const RealFile& real : kRealFiles) {
    SCOPED_TRACE(real.name);
    const fs::path file = tests::data_path(std::string("step/") + real.name);
    const ImportReport& report = read(file);
    const Truth truth = truth_of(file);
    double volume = 0.0, area = 0.0;
    std::size_t colours = 0;
    for (std::size_t i = 0; i < scene_.material_slots(); ++i) ++colours;
    for (std::uint32_t i = 0; i < scene_.item_slots(); ++i) {
      const core::ItemId at{i};
      if (int(scene_.kind(at)) < core::kPrimitiveKindCount) {
        volume += tests::volume(scene_.primitive(at));
        area += core::surface_area(scene_.primitive(at));
      } else {
        volume += volume_of(scene_.mesh(scene_.mesh_of(at)));
        area += core::surface_area(scene_.mesh(scene_.mesh_of(at)));
      }
    }
    const core::AabbD bounds = scene_.bounds(scene_.root());
    EXPECT_EQ(report.surfaces.parts, real.parts);
    EXPECT_EQ(report.surfaces.instances, real.instances);
    EXPECT_EQ(report.surfaces.analytic_solids, real.analytic);
    EXPECT_LE(report.surfaces.deviation, report.surfaces.largest_tolerance);
    const double slack = 1e3 * report.surfaces.largest_tolerance + 1e-6 * glm::length(truth.bounds.size());
    expect_bounds(bounds, 1e-3 * truth.bounds.min, 1e-3 * truth.bounds.max, 1e-3 * slack);
    EXPECT_NEAR(volume, truth.volume, truth.area * slack);
    EXPECT_NEAR(area, truth.area, 0.02 * truth.area);
    table +=
        fmt::format("| {} | {} | {} | {} | {} | {} of {} | {:.2g} | {:.2g} | {:.1g} % | {:.1g} % |\n", real.name,
                    report.surfaces.parts, report.surfaces.instances, colours, report.surfaces.triangles,
                    report.surfaces.analytic_solids, report.surfaces.analytic_solids + report.surfaces.meshed_bodies,
                    1e3 * report.surfaces.largest_tolerance, 1e3 * report.surfaces.deviation,
                    truth.volume > 0.0 ? 100.0 * std::abs(volume / truth.volume - 1.0) : 0.0,
                    100.0 * std::abs(area / truth.area - 1.0));
    for (const ImportWarning& warning : report.warnings) table += "  " + warning.message + "\n";
    EXPECT_LT(scene_.item_count(), 1000u);
  }
  if (tests::long_run()) std::fputs(table.c_str(), stdout);
}

}  // namespace
}  // namespace sightline::importers::cad_reader_test
