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
  const core::Mesh& mesh(core::ItemId item = core::ItemId{0}) const { return scene_.mesh(scene_.mesh_of(item)); }
  dvec3 point(std::size_t vertex, core::ItemId item = core::ItemId{0}) const {
    return core::transform_point(scene_.placement(item), dvec3(mesh(item).positions[vertex]));
  }
  core::Scene scene_;
};

TEST_F(StlReader, HeadersThatSaySolidOrColour) {
  // Not of the size that it claims, but with bytes that no text has: binary all the same.
  const auto longer = read(binary(kSquare, {}, "solid but binary") + "x");
  ASSERT_TRUE(longer) << longer.error().message;
  ASSERT_EQ(longer->warnings.size(), 1u);
  EXPECT_EQ(longer->warnings[0].message, "byte 184: 1 bytes after the last facet are ignored");
  const std::vector<std::uint16_t> default_colour = {0x8000, 0x8000};
  ASSERT_TRUE(read(binary(kSquare, default_colour, std::string(70, ' ') + "COLOR=\x01\x02\x03\xff")));
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).name, "#010203");
  ASSERT_TRUE(read(binary(kSquare, default_colour, std::string(71, ' ') + "COLOR=\x01\x02\x03")));
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).name, "#000000");  // cut off, it says nothing
  // A colour for all, of writers that give facets none.
  ASSERT_TRUE(read(binary(kSquare, {}, std::string(70, ' ') + "COLOR=\x01\x02\x03\xff")));
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).name, "#010203");
  // MeshLab's header begins like Magics', and its facets say that they have colours.
  const std::string meshlab = "VCG COLOR=\x7f\x7f\x7f MATERIAL=\x7f\x7f\x7f ";
  ASSERT_TRUE(read(binary(kSquare, {}, meshlab)));
  EXPECT_FALSE(scene_.item_material(core::ItemId{0}).valid());
  ASSERT_TRUE(read(binary(kSquare, {0x801f, 0xfc00}, meshlab)));
  ASSERT_EQ(scene_.item_count(), 2u);
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).name, "#ff0000");
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{1})).name, "#0000ff");
  // Facets without a colour behind one with.
  ASSERT_TRUE(read(binary(kSquare, {0x801f, 0})));
  ASSERT_EQ(scene_.item_count(), 2u);
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).name, "#0000ff");
  EXPECT_FALSE(scene_.item_material(core::ItemId{1}).valid());
}

/// A writer that leaves bytes out displaces the rest, whose numbers then are of any size.
TEST_F(StlReader, RecordsBehindMissingBytesAreNoFacets) {
  std::vector<Facet> facets;
  for (int i = 0; i < 200; ++i) {
    const float x = 1.1f * float(i), y = 0.7f * float(i * i % 97);
    facets.push_back({core::vec3(x, y, 1.3f), {x + 1.7f, y, 2.9f}, {x, y + 1.9f, 3.1f}});
  }
  std::string bytes = binary(facets);
  bytes.erase(84 + 50 * 120 + 12, 26);
  EXPECT_FALSE(read(bytes));
  const auto report = read(bytes, {.lenient = true});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->warnings.size(), 2u);
  EXPECT_EQ(report->warnings[1].message.substr(0, 43), "byte 6084: what follows is no facets: 79 re");
  EXPECT_EQ(mesh().indices.size(), 3u * 120);
  for (const core::vec3& p : mesh().positions) EXPECT_LT(glm::length(p), 1e6f);
}

TEST_F(StlReader, DamageIsToldOnceUntilSomethingBegins) {
  const std::string words = "vertex 1 2 3 lost words\n";
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
    EXPECT_EQ(scene_.node_of(core::ItemId{0}), report->nodes[0]);
    EXPECT_EQ(mesh().positions.size(), 4u);
    EXPECT_EQ(mesh().indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
    EXPECT_EQ(point(2), dvec3(1, 1, 0));
    EXPECT_FALSE(scene_.item_material(core::ItemId{0}).valid());
    EXPECT_TRUE(scene_.commit());
  }
}

TEST_F(StlReader, SolidsOfTextBecomeNodes) {
  const auto report = read(kText);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  ASSERT_EQ(scene_.item_count(), 3u);
  EXPECT_EQ(scene_.name(scene_.node_of(core::ItemId{0})), "first part");
  EXPECT_EQ(scene_.node_of(core::ItemId{1}), report->nodes[0]);
  EXPECT_EQ(scene_.name(scene_.node_of(core::ItemId{2})), "third");
  EXPECT_EQ(mesh(core::ItemId{0}).positions.size(), 4u);
  EXPECT_EQ(mesh(core::ItemId{0}).indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(mesh(core::ItemId{2}).indices.size(), 3u);
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
  EXPECT_FALSE(scene_.item_material(core::ItemId{0}).valid());
  EXPECT_EQ(colour(core::ItemId{1}), core::vec3(0, 0, 255));
  EXPECT_EQ(colour(core::ItemId{2}), core::vec3(255, 0, 0));
  EXPECT_EQ(mesh(core::ItemId{1}).indices.size(), 6u);
  // Magics: red lowest, bit 15 says that there is none.
  ASSERT_TRUE(read(binary(facets, {0x8000, 0x001f, 0x7c00, 0xffff}, "COLOR=\x10\x20\x30\xff,MATERIAL=")));
  ASSERT_EQ(scene_.item_count(), 3u);
  EXPECT_EQ(colour(core::ItemId{0}), core::vec3(16, 32, 48));
  EXPECT_EQ(colour(core::ItemId{1}), core::vec3(255, 0, 0));
  EXPECT_EQ(colour(core::ItemId{2}), core::vec3(0, 0, 255));
  EXPECT_EQ(mesh(core::ItemId{0}).indices.size(), 6u);
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
      {more + "x", "byte 80: expected 3 facets of 50 bytes, found 101 bytes", 1, 2},
      {binary(kSquare).substr(0, 150), "byte 80: expected 2 facets", 1, 1},
      {binary({}) + "x", "byte 80: expected 0 facets of 50 bytes, found 1 bytes", 0, 0},
      {solid + kTextFacet, "line 9: expected endsolid, found the file's end", 1, 1},
      {solid + kTextFacet.substr(0, 90), "expected", 0, 0},
      {solid + text_facet("0 0 0", "1 x 0", "0 1 0") + kTextFacet + end, "line 5: expected three numbers", 1, 1},
      {solid + text_facet("0 0 0", "1 0", "0 1 0") + kTextFacet + end, "line 6: expected three numbers", 1, 1},
      {solid + text_facet("0 0 0", "1 0 0", "0 1 0\nvortex 1 1 1") + kTextFacet + end,
       "line 7: expected vertex or endloop, found 'vortex'", 1, 1},
      {solid + "facet normal 1 0 outer loop\n" + kTextFacet + end, "line 3: expected vertex or endloop, found 'facet'",
       1, 1},
      {solid + "vertex 1 2 3\n" + kTextFacet + end, "line 2: expected facet or endsolid, found 'vertex'", 1, 1},
      {"solid\n\x80 is no facet\n", "expected endsolid, found the file's end", 0, 0},
      {"solid\nwords and words\nendsolid\n", "expected facets, found none", 0, 0},
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
  std::string utf16;
  for (const char c : kText) utf16 += {c, '\0'};
  for (const std::string& bytes : {std::string(""), std::string("so"), std::string("what is this"),
                                   std::string("v 0 0 0\n"), std::string(500, 'x'), utf16})
    EXPECT_FALSE(read(bytes, {.lenient = true})) << bytes;
}

/// Two facets of text that are the square's triangles, with a change.
struct Habit {
  std::string what, with, warning;
};

TEST_F(StlReader, TextAsOthersWriteIt) {
  const std::string kEnds = "an end that is misspelt or in two words is understood";
  const std::string square =
      "solid s\n" + text_facet("0 0 0", "1 0 0", "1 1 0") + text_facet("0 0 0", "1 1 0", "0 1 0") + "endsolid s\n";
  const Habit habits[] = {
      {"solid s\n", "\xef\xbb\xbfsolid s\n", "line 1: a byte order mark is skipped"},
      {"solid s\n", "# made by\n// someone\nsolid s\n", "line 1: comments are skipped (2 times)"},
      {"solid s\n", "made by someone\nsolid s\n", "line 1: a line that is not understood is skipped"},
      {"solid s\n", "solid s\n; a comment of vertex 1 2 3\n", "line 2: comments are skipped"},
      {"1 0 0\n", "1 0 0 # the second\n", "line 5: comments are skipped"},
      {"1 0 0\n", "1 0 0 1.0\n", "line 5: numbers after a vertex's three are ignored"},
      {"normal 0 0 1", "", "line 3: a facet without a normal is read"},
      {"normal 0 0 1", "0 0 1", "line 2: a facet without a normal is read"},
      {"normal 0 0 1", "normal", "line 3: a normal of fewer than three numbers is ignored"},
      {"normal 0 0 1", "normal 0 0 1 0", "line 2: numbers after a normal's three are ignored"},
      {"normal 0 0 1", "normal -1.#IND -nan(ind) nan", ""},
      {"outer loop", "loop", "line 3: 'outer loop' is missing or misspelt"},
      {"outer loop", "outerloop", "line 3: 'outer loop' is missing or misspelt"},
      {"outer loop", "", "line 4: 'outer loop' is missing or misspelt"},
      {"facet normal 0 0 1\n", "", "line 2: a loop without a facet before it is read as one"},
      {"outer loop", "colour 1 0 0\nouter loop", "line 3: a line that is not understood is skipped"},
      {"endloop", "end loop", "line 7: " + kEnds},
      {"endloop", "End Loop", "line 7: " + kEnds},
      {"endloop", "end_loop", "line 7: " + kEnds},
      {"endloop", "endlop", "line 7: " + kEnds},
      {"endloop", "end", "line 7: " + kEnds},
      {"endloop", "", "line 8: an endloop is missing"},
      {"endfacet", "end facet", "line 8: " + kEnds},
      {"endfacet", "ENDFACETS", "line 8: " + kEnds},
      {"endfacet", "", "line 9: an endfacet is missing"},
      {"endfacet", "colour 1 0 0\nendfacet", "line 8: a line that is not understood is skipped"},
      {"endfacet", "endfacet\nendfacet", "line 9: an end of what had not begun is ignored"},
      {"endfacet", "endfacet\nend facet", "line 9: an end of what had not begun is ignored"},
      {"endfacet", "endfacet\n\ncolour 1 0 0", "line 10: a line that is not understood is skipped"},
      {"endfacet", "endfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet",
       "line 13: a facet of fewer than three vertices is left out"},
      {"endsolid s", "end solid s", "line 16: " + kEnds},
      {"endsolid s", "end", "line 16: " + kEnds},
      {"endsolid s", "endsolids", "line 16: " + kEnds},
      {"endsolid s\n", "endsolid s\nendsolid s\n", "line 17: an endsolid line without a solid is ignored"},
      {"endsolid s\n", "endsolid s\n" + std::string("\0\0\0", 3), "line 17: a line that is not understood is skipped"},
      {"endsolid s\n", "endsolid s\ntrailing words", "line 17: a line that is not understood is skipped"},
      {"solid s\n", "solid s\nsolid s\n", "line 2: a solid line that follows another counts alone"},
      {"solid s\n", "", "line 1: facets outside a solid are read"},
  };
  for (const Habit& habit : habits)
    for (const bool lenient : {false, true}) {
      SCOPED_TRACE(habit.with);
      std::string text = square;
      text.replace(text.find(habit.what), habit.what.size(), habit.with);
      if (habit.with.empty() && habit.what == "solid s\n") text = text.substr(0, text.find("endsolid"));
      const auto report = read(text, {.lenient = true});
      ASSERT_TRUE(report) << report.error().message;
      if (habit.warning.empty()) {
        EXPECT_TRUE(report->warnings.empty());
      } else {
        ASSERT_FALSE(report->warnings.empty());
        EXPECT_EQ(report->warnings.back().message, habit.warning);
      }
      if (!habit.what.starts_with("solid s") || !habit.with.empty()) {
        EXPECT_LE(report->warnings.size(), 1u);
        EXPECT_TRUE(read(text));
      }
      ASSERT_EQ(scene_.item_count(), 1u);
      EXPECT_EQ(mesh().indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
      EXPECT_TRUE(lenient || scene_.commit());
    }
}

TEST_F(StlReader, PolygonsOfText) {
  const std::string polygon = text_facet("0 0 0", "1 0 0", "1 1 0\nvertex 0 1 0"), triangle = kTextFacet;
  for (const std::string& facets : {polygon + triangle, triangle + polygon}) {
    const auto report = read("solid a\n" + facets + "endsolid\nsolid b\n" + triangle + "endsolid\n");
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->warnings.size(), 1u);
    EXPECT_NE(report->warnings[0].message.find("a facet of more than three vertices becomes triangles"),
              std::string::npos);
    ASSERT_EQ(scene_.item_count(), 2u);
    EXPECT_EQ(mesh(core::ItemId{0}).indices.size(), 9u);
    EXPECT_EQ(mesh(core::ItemId{0}).positions.size(), 4u);
    EXPECT_EQ(mesh(core::ItemId{1}).indices.size(), 3u);
  }
}

TEST_F(StlReader, SolidsWithoutAnEnd) {
  const auto report =
      read("solid a\n" + kTextFacet + "solid b\n" + kTextFacet + "endsolid\n" + kTextFacet + "endsolid\n");
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->warnings.size(), 2u);
  EXPECT_EQ(report->warnings[0].message, "line 9: an endsolid is missing before the next solid");
  EXPECT_EQ(report->warnings[1].message, "line 18: facets outside a solid are read");
  EXPECT_EQ(scene_.item_count(), 3u);
}

TEST_F(StlReader, TextWithZerosInItsName) {
  const auto report = read("solid " + std::string(100, '\0') + "\n" + kTextFacet + "endsolid\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(scene_.item_count(), 1u);
}

TEST_F(StlReader, CountsThatTheLengthContradicts) {
  std::vector<Facet> facets = {kSquare[0], kSquare[1], kSquare[0], kSquare[1]};
  const auto with_count = [&](std::uint32_t count, const std::string& more) {
    std::string bytes = binary(facets);
    bytes.replace(80, 4, little(count, 4));
    return bytes + more;
  };
  struct Case {
    std::uint32_t count;
    std::string more;
    std::size_t triangles;
    std::vector<std::string> warnings;
  };
  const std::string told = " facets, the file holds 4: all are read";
  const Case cases[] = {
      {4, "", 4, {}},
      {0, "", 4, {"byte 80: the header counts 0" + told}},
      {0xffffffff, "", 4, {"byte 80: the header counts 4294967295" + told}},
      {5, "", 4, {"byte 80: the header counts 5" + told}},
      {3, "", 4, {"byte 80: the header counts 3" + told}},
      {4, "\r\n", 4, {"byte 284: 2 bytes after the last facet are ignored"}},
      {4, std::string(120, '\0'), 4, {"byte 284: 120 bytes after the last facet are ignored"}},
      {4, std::string(100, 'a'), 4, {"byte 284: 100 bytes after the last facet are ignored"}},
      {4, std::string(100, '1'), 4, {"byte 284: 100 bytes after the last facet are ignored"}},
      {2,
       std::string(70, 'M'),
       4,
       {"byte 80: the header counts 2" + told, "byte 284: 70 bytes after the last facet are ignored"}},
  };
  for (const Case& c : cases)
    for (const bool lenient : {false, true}) {
      SCOPED_TRACE(testing::Message() << c.count << " and " << c.more.size() << " bytes");
      const auto report = read(with_count(c.count, c.more), {.lenient = lenient});
      ASSERT_TRUE(report) << report.error().message;
      ASSERT_EQ(report->warnings.size(), c.warnings.size());
      for (std::size_t i = 0; i < c.warnings.size(); ++i) EXPECT_EQ(report->warnings[i].message, c.warnings[i]);
      EXPECT_EQ(mesh().indices.size(), 3 * c.triangles);
    }
  // Records that are no facets are not made facets by a wrong count.
  facets[2][1].x = 1e30f;
  EXPECT_FALSE(read(with_count(5, "")));
  ASSERT_TRUE(read(with_count(2, "")));
  EXPECT_EQ(mesh().indices.size(), 6u);
  // Other files are none, even when lenient.
  std::mt19937 random(1);
  std::string noise(84 + 5 * 50, '\0');
  for (char& c : noise) c = char(random());
  EXPECT_FALSE(read(noise, {.lenient = true}));
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
    EXPECT_EQ(scene_.name(scene_.node_of(core::ItemId{0})),
              std::string(name) == "cone_vtk.stl" ? name : "solid cone by VTK");
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
  // Whole is what ends from within a solid's last word on until another solid begins.
  const std::size_t ends[] = {kText.find("endsolid"), kText.find("endsolid\nSOLID"), kText.find("EndSolid")};
  const std::size_t begins[] = {kText.find("solid\n"), kText.find("SOLID"), kText.size()};
  for (std::size_t size = 0; size <= kText.size(); ++size) {
    SCOPED_TRACE(testing::Message() << "text truncated to " << size);
    const std::string part = kText.substr(0, size);
    bool whole = false;
    for (int solid = 0; solid < 3; ++solid) whole = whole || (size >= ends[solid] + 3 && size < begins[solid] + 5);
    const hostile::Case made = hostile::one_file("model.stl", part);
    ASSERT_EQ(tests::survives(target, made, false, "model.stl"), whole);
    tests::survives(target, made, true, "model.stl");
  }
}

}  // namespace
}  // namespace sightline::importers::stl_reader_test
