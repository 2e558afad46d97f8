// Well-formed STL files, and what the reader says of damage. hostile_test.cpp has damage in numbers.
#include "sightline/importers/stl/internal/stl_reader.h"

#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/internal/face_colours.h"
#include "sightline/importers/internal/vertex_welder.h"
#include "sightline/tests/importers/hostile.h"
#include "sightline/tests/support/places.h"

namespace sightline::importers::stl_reader_test {
namespace {

using core::dvec3;
using Facet = std::array<core::vec3, 3>;

std::string little(std::uint32_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out += char(value >> 8 * i & 0xff);
  return out;
}

std::string binary(const std::vector<Facet>& facets, const std::vector<std::uint16_t>& attributes = {},
                   std::string header = "made by hand") {
  header.resize(80, '\0');
  std::string out = header + little(std::uint32_t(facets.size()), 4);
  for (std::size_t f = 0; f < facets.size(); ++f) {
    out += std::string(12, '\0');
    for (const core::vec3& corner : facets[f])
      for (int k = 0; k < 3; ++k) out += little(std::bit_cast<std::uint32_t>(corner[k]), 4);
    out += little(f < attributes.size() ? attributes[f] : 0, 2);
  }
  return out;
}

std::string text_facet(const std::string& a, const std::string& b, const std::string& c) {
  return "  facet normal 0 0 1\n    outer loop\n      vertex " + a + "\n      vertex " + b + "\n      vertex " + c +
         "\n    endloop\n  endfacet\n";
}

const std::vector<Facet> kSquare = {{core::vec3(0, 0, 0), {1, 0, 0}, {1, 1, 0}},
                                    {core::vec3(-0.0f, 0, 0), {1, 1, 0}, {0, 1, -0.0f}}};
const std::string kTextFacet = text_facet("0 0 0", "1 0 0", "0 1 0");
const std::string kText = "solid first part\n" + kTextFacet + text_facet("0 0 -0.0", "0 1 0", "-1 0 0") +
                          "endsolid first part\nsolid\n" + kTextFacet + "endsolid\nSOLID third\nFACET" +
                          kTextFacet.substr(7) + "EndSolid\n";

class StlReader : public testing::Test {
 protected:
  core::Expected<ImportReport> read(const std::string& bytes, const ImportOptions& options = {}) {
    scene_ = core::Scene();
    return read_stl(std::as_bytes(std::span(bytes)), "model.stl", scene_, scene_.root(), options);
  }
  const core::Mesh& mesh(core::ItemId item = 0) const { return scene_.mesh(scene_.mesh_of(item)); }
  dvec3 point(std::size_t vertex, core::ItemId item = 0) const {
    return core::transform_point(scene_.placement(item), dvec3(mesh(item).positions[vertex]));
  }
  core::Scene scene_;
};

TEST_F(StlReader, HeadersThatSaySolidOrColour) {
  // Not of the size that it claims, but with bytes that no text has: binary all the same.
  const auto damaged = read(binary(kSquare, {}, "solid but binary") + "x");
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().message.find("expected 2 facets of 50 bytes"), std::string::npos)
      << damaged.error().message;
  const std::vector<std::uint16_t> default_colour = {0x8000, 0x8000};
  ASSERT_TRUE(read(binary(kSquare, default_colour, std::string(70, ' ') + "COLOR=\x01\x02\x03\xff")));
  EXPECT_EQ(scene_.material(scene_.item_material(0)).name, "#010203");
  ASSERT_TRUE(read(binary(kSquare, default_colour, std::string(71, ' ') + "COLOR=\x01\x02\x03")));
  EXPECT_EQ(scene_.material(scene_.item_material(0)).name, "#000000");  // cut off, it says nothing
  // Facets without a colour behind one with.
  ASSERT_TRUE(read(binary(kSquare, {0x801f, 0})));
  ASSERT_EQ(scene_.item_count(), 2u);
  EXPECT_EQ(scene_.material(scene_.item_material(0)).name, "#0000ff");
  EXPECT_FALSE(scene_.item_material(1).valid());
}

TEST_F(StlReader, DamageIsToldOnceUntilSomethingBegins) {
  EXPECT_FALSE(read("solid a\n" + kTextFacet + "endsolid\nendsolid\n"));
  const std::string words = "three lost words\n";
  const auto report = read(
      "solid a\n" + words + kTextFacet + words + "endsolid\n" + words + "solid b\n" + words + kTextFacet + "endsolid\n",
      {.lenient = true});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->warnings.size(), 3u);
  EXPECT_EQ(scene_.item_count(), 2u);
}

TEST_F(StlReader, Binary) {
  // The first word says nothing: many writers of binary files begin with "solid".
  for (const char* header : {"made by hand", "solid but binary"}) {
    const auto report = read(binary(kSquare, {}, header));
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty());
    ASSERT_EQ(scene_.item_count(), 1u);
    EXPECT_EQ(scene_.node_of(0), report->nodes[0]);
    EXPECT_EQ(mesh().positions.size(), 4u);
    EXPECT_EQ(mesh().indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
    EXPECT_EQ(point(2), dvec3(1, 1, 0));
    EXPECT_FALSE(scene_.item_material(0).valid());
    EXPECT_TRUE(scene_.commit());
  }
}

TEST_F(StlReader, SolidsOfTextBecomeNodes) {
  const auto report = read(kText);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  ASSERT_EQ(scene_.item_count(), 3u);
  EXPECT_EQ(scene_.name(scene_.node_of(0)), "first part");
  EXPECT_EQ(scene_.node_of(1), report->nodes[0]);
  EXPECT_EQ(scene_.name(scene_.node_of(2)), "third");
  EXPECT_EQ(mesh(0).positions.size(), 4u);
  EXPECT_EQ(mesh(0).indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(mesh(2).indices.size(), 3u);
}

TEST_F(StlReader, FarCoordinatesKeepTheirDigits) {
  const auto report =
      read("solid\n" + text_facet("10000000.0001 0 5", "10000000.0002 0 5", "10000000 -2e7 5") + "endsolid\n",
           {.metres_per_unit = 0.001, .up = UpAxis::kY});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NEAR(point(1).x - point(0).x, 0.0001, 1e-8);
  const dvec3 world = core::transform_point(scene_.world_from_node(report->nodes[0]), point(2));
  EXPECT_NEAR(world.x, 10000.0, 1e-9);
  EXPECT_NEAR(world.y, -0.005, 1e-9);
  EXPECT_NEAR(world.z, -20000.0, 1e-9);
}

TEST_F(StlReader, Colours) {
  const std::vector<Facet> facets = {kSquare[0], kSquare[1], kSquare[0], kSquare[1]};
  const auto colour = [&](core::ItemId item) { return scene_.material(scene_.item_material(item)).colour * 255.0f; };
  // VisCAM: blue lowest, bit 15 says that there is a colour.
  ASSERT_TRUE(read(binary(facets, {0x7fff, 0x801f, 0xfc00, 0x801f})));
  ASSERT_EQ(scene_.item_count(), 3u);
  EXPECT_FALSE(scene_.item_material(0).valid());
  EXPECT_EQ(colour(1), core::vec3(0, 0, 255));
  EXPECT_EQ(colour(2), core::vec3(255, 0, 0));
  EXPECT_EQ(mesh(1).indices.size(), 6u);
  // Magics: red lowest, bit 15 says that there is none.
  ASSERT_TRUE(read(binary(facets, {0x8000, 0x001f, 0x7c00, 0xffff}, "COLOR=\x10\x20\x30\xff,MATERIAL=")));
  ASSERT_EQ(scene_.item_count(), 3u);
  EXPECT_EQ(colour(0), core::vec3(16, 32, 48));
  EXPECT_EQ(colour(1), core::vec3(255, 0, 0));
  EXPECT_EQ(colour(2), core::vec3(0, 0, 255));
  EXPECT_EQ(mesh(0).indices.size(), 6u);
}

TEST_F(StlReader, NoFacetsNoItem) {
  for (const std::string& bytes :
       {binary({}), std::string("solid\nendsolid\n"), std::string("solid a\nendsolid a\n")}) {
    const auto report = read(bytes);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_FALSE(report->warnings.empty());
    EXPECT_EQ(scene_.item_count(), 0u);
    EXPECT_EQ(scene_.node_count(), 2u);
  }
}

TEST_F(StlReader, DamageNamesThePlace) {
  struct Case {
    std::string bytes, message;
    std::size_t items, triangles;  // when lenient
  };
  std::string more = binary(kSquare);
  more[80] = 3;
  const std::string solid = "solid s\n", end = "endsolid\n";
  const Case cases[] = {
      {more, "byte 80: expected 3 facets of 50 bytes, found 100 bytes", 1, 2},
      {binary(kSquare) + "x", "byte 80: expected 2 facets", 1, 2},
      {binary(kSquare).substr(0, 150), "byte 80: expected 2 facets", 1, 1},
      {solid + kTextFacet, "line 9: expected endsolid, found the file's end", 1, 1},
      {solid + kTextFacet.substr(0, 90), "expected", 0, 0},
      {solid + text_facet("0 0 0", "1 x 0", "0 1 0") + kTextFacet + end, "line 5: expected three numbers", 1, 1},
      {solid + text_facet("0 0 0", "1 0", "0 1 0") + kTextFacet + end, "line 6: expected three numbers", 1, 1},
      {solid + text_facet("0 0 0", "1 0 0", "0 1 0\nvertex 1 1 1") + kTextFacet + end, "expected endloop", 1, 1},
      {solid + "facet normal 1 0 outer loop\n" + kTextFacet + end, "expected outer loop", 1, 1},
      {solid + "faucet\n" + kTextFacet + end, "line 2: expected facet or endsolid, found 'faucet'", 1, 1},
      {solid + kTextFacet + solid + kTextFacet + end, "expected endsolid before another solid", 2, 1},
      {solid + kTextFacet + end + kTextFacet, "line 10: expected solid, found 'facet'", 1, 1},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.message);
    const auto strict = read(c.bytes);
    ASSERT_FALSE(strict);
    EXPECT_NE(strict.error().message.find("model.stl: "), std::string::npos) << strict.error().message;
    EXPECT_NE(strict.error().message.find(c.message), std::string::npos) << strict.error().message;
    EXPECT_EQ(scene_.node_count(), 1u);
    const auto lenient = read(c.bytes, {.lenient = true});
    ASSERT_TRUE(lenient) << lenient.error().message;
    EXPECT_FALSE(lenient->warnings.empty());
    ASSERT_EQ(scene_.item_count(), c.items);
    if (c.items > 0) {
      EXPECT_EQ(mesh().indices.size(), 3 * c.triangles);
    }
  }
  for (const std::string bytes : {"", "so", "what is this", "v 0 0 0\n"})
    EXPECT_FALSE(read(bytes, {.lenient = true})) << bytes;
}

TEST_F(StlReader, NotFiniteIsDroppedAndListed) {
  for (const float bad : {NAN, INFINITY, 2e36f}) {
    std::vector<Facet> facets = kSquare;
    facets[1][2].y = bad;
    const auto report = read(binary(facets));
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->warnings.size(), 1u);
    EXPECT_EQ(mesh().indices.size(), 3u);
  }
}

TEST_F(StlReader, CancelLeavesTheSceneAlone) {
  const std::vector<Facet> facets(20000, kSquare[0]);
  std::string text = "solid a\n" + kTextFacet + "endsolid\nsolid b\n";
  for (int i = 0; i < 20000; ++i) text += kTextFacet;
  text += "endsolid\n";
  for (const std::string& bytes : {binary(facets), text}) {
    for (const double at : {0.0, 0.3}) {
      const auto report = read(bytes, {.progress = [&](double share) { return share < at; }});
      ASSERT_FALSE(report);
      EXPECT_EQ(report.error().message, kCancelled);
      EXPECT_EQ(scene_.node_count(), 1u);
      EXPECT_EQ(scene_.mesh_slots() + scene_.item_slots(), 0u);
    }
  }
}

TEST_F(StlReader, FilesOfVtk) {
  // Written by vtkSTLWriter of VTK 9.1 from a vtkConeSource of 12 sides, height 2 and radius 0.5, triangulated.
  for (const char* name : {"cone_vtk.stl", "cone_vtk_text.stl"}) {
    SCOPED_TRACE(name);
    scene_ = core::Scene();
    const auto report = import_file(tests::in_checkout("tests/data") / name, scene_, scene_.root());
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty());
    EXPECT_EQ(mesh().positions.size(), 13u);
    EXPECT_EQ(mesh().indices.size(), 3u * 22);
    EXPECT_EQ(core::enclosure(mesh()), core::Enclosure::kInside);
    EXPECT_EQ(scene_.name(scene_.node_of(0)), std::string(name) == "cone_vtk.stl" ? name : "solid cone by VTK");
  }
}

// --- welding
// -----------------------------------------------------------------------------------------------------------

TEST(VertexWelder, NumbersEqualPositionsAsAMapDoes) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    VertexWelder welder(seed % 2 ? 0 : 1000);
    std::map<std::array<double, 3>, std::uint32_t> twin;
    std::vector<std::uint32_t> numbers, expected;
    const int range = 1 << (seed % 12);
    for (int block = 0; block < 5; ++block) {
      std::vector<dvec3> corners(random() % 2000);
      for (dvec3& c : corners) {
        for (int k = 0; k < 3; ++k)
          c[k] = double(int(random() % unsigned(range)) - range / 2) * (seed % 3 ? 0.1 : -0.0);
        expected.push_back(twin.try_emplace({c.x, c.y, c.z}, std::uint32_t(twin.size())).first->second);
      }
      welder.add(corners, numbers);
    }
    EXPECT_EQ(numbers, expected);
    EXPECT_EQ(welder.take_positions().size(), twin.size());
  }
}

TEST(VertexWelder, WhatIsNoNumberEqualsItself) {
  VertexWelder welder;
  std::vector<std::uint32_t> numbers;
  welder.add(std::vector<dvec3>(100000, dvec3(NAN, 0, 1)), numbers);
  EXPECT_EQ(welder.take_positions().size(), 1u);
}

/// The rest of what is expected of truncated files: hostile_test.cpp.
TEST(StlHostile, TextIsWholeAfterEachSolid) {
  const hostile::Target target = hostile::target_of("stl");
  for (std::size_t size = 0; size <= kText.size(); ++size) {
    SCOPED_TRACE(testing::Message() << "text truncated to " << size);
    const std::string part = kText.substr(0, size);
    // Whole is what ends with a solid's last line, or within the name there.
    const std::size_t last = size == kText.size() ? kText.size() - 9 : part.rfind("endsolid");
    const std::string rest = part.substr(std::min(last, size));
    const bool whole = last != std::string::npos && rest.find_first_not_of('\n', rest.find('\n')) >= rest.size();
    const hostile::Case made = hostile::one_file("model.stl", part);
    ASSERT_EQ(tests::survives(target, made, false, "model.stl"), whole || size == kText.size() - 1);
    tests::survives(target, made, true, "model.stl");
  }
}

}  // namespace
}  // namespace sightline::importers::stl_reader_test
