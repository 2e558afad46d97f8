#include "sightline/importers/rvm/internal/rvm_attributes.h"

#include <algorithm>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "sightline/core/find_nodes.h"
#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/tests/importers/rvm_bytes.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::rvm_attributes_test {
namespace {

using core::NodeId;

constexpr std::string_view kHeader = "CADC_Attributes_File v1.0 , start: NEW , end: END , name_end: := , sep: &end&\n";

std::vector<NodeId> nodes_with(const core::Scene& scene, const char* key, const char* value) {
  const core::NodeCondition condition{key, value};
  return core::find_nodes(scene, scene.root(), {&condition, 1})->nodes;
}

class RvmAttributes : public testing::Test {
 protected:
  void SetUp() override {
    tests::RvmBytes rvm;
    rvm.head();
    rvm.group("/SITE", 1).group("/ZONE", 1).group("BRANCH", 1).group_end().group("BRANCH", 1).group_end().group_end();
    rvm.group_end().begin("END:").end();
    const auto report = read_rvm(rvm.bytes, "plant.rvm", scene_, scene_.root());
    ASSERT_TRUE(report) << report.error().message;
  }

  core::Expected<ImportReport> read(std::string_view text, bool lenient = false, const char* file = "plant.txt") {
    // From a buffer of its exact size, so that a read beyond it shows.
    const auto exact = std::make_unique<std::byte[]>(text.size());
    std::copy_n(reinterpret_cast<const std::byte*>(text.data()), text.size(), exact.get());
    return read_rvm_attributes({exact.get(), text.size()}, file, scene_, scene_.root(), {.lenient = lenient});
  }
  core::Expected<ImportReport> read_body(const std::string& body, bool lenient = false) {
    return read(std::string(kHeader) + body, lenient);
  }
  std::string of(std::string_view path, std::string_view key) const {
    std::string value = "none";
    scene_.for_each_node(scene_.root(), [&](NodeId n, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
      if (scene_.path(n) != path) return;
      for (const auto& [k, v] : scene_.attributes(n))
        if (k == key) value = v;
    });
    return value;
  }
  std::size_t attributed_nodes() const { return nodes_with(scene_, "A", "").size(); }
  core::Scene scene_;
};

TEST_F(RvmAttributes, GoToTheGroupsOfTheirPath) {
  const auto report = read_body(
      "NEW Header Information\n  Source:= PDMS\nEND\n"
      "NEW /SITE\n  Type:= 'SITE'\r\n\n  NEW /ZONE\n    Bore:= 100 &end& Spec:= \"A 1\" &end& Empty:=\n"
      "    NEW BRANCH\n      No:= 1\n    END\n    NEW BRANCH\n      No:= 2\n    END\n"
      "    NEW BRANCH\n      No:= 3\n    END\n    NEW TEXT\n      NEW BRANCH\n        No:= 4\n      END\n    END\n"
      "  END\nEND\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->nodes.empty());
  EXPECT_EQ(report->attributed, 4u) << "elements without a group are left out";
  EXPECT_EQ(of("plant.rvm//SITE", "Type"), "SITE");
  EXPECT_EQ(of("plant.rvm//SITE//ZONE", "Bore"), "100");
  EXPECT_EQ(of("plant.rvm//SITE//ZONE", "Spec"), "A 1");
  EXPECT_EQ(of("plant.rvm//SITE//ZONE", "Empty"), "");
  std::vector<std::string> numbers;
  for (const NodeId n : nodes_with(scene_, "No", "")) numbers.push_back(scene_.attributes(n)[0].second);
  EXPECT_EQ(numbers, (std::vector<std::string>{"1", "2"})) << "siblings of one name in order";
  EXPECT_EQ(scene_.node_count(), 6u);
}

TEST_F(RvmAttributes, LinesMayEndWithReturnsAlone) {
  std::string text = std::string(kHeader) + "NEW /SITE\n  Type:= 'SITE'\n  NEW /ZONE\n    Bore:= 100\n  END\nEND\n";
  std::replace(text.begin(), text.end(), '\n', '\r');
  const auto report = read(text);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->attributed, 2u);
}

TEST_F(RvmAttributes, OtherEncodingsAreDecoded) {
  const auto report = read_body("NEW /SITE\n  Ort:= H\xF6he\nEND\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->warnings.size(), 1u);
  bool found = false;
  scene_.for_each_node(scene_.root(), [&](NodeId node, const auto&...) {
    for (const auto& [key, value] : scene_.attributes(node)) found |= key == "Ort" && value == "Höhe";
  });
  EXPECT_TRUE(found);
}

TEST_F(RvmAttributes, LevelsAboveTheModelLeadToIt) {
  const auto report = read_body("NEW /WORLD\n  A:= 1\n  NEW /SITE\n    A:= 2\n  END\nEND\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(of("plant.rvm//SITE", "A"), "2");
}

TEST_F(RvmAttributes, TheHeaderSaysTheWords) {
  const auto report = read(
      "\xef\xbb\xbf"
      "CADC_Attributes_File v2 , start: <+ , end: +> , name_end: = , sep: ;\n"
      "<+ /SITE\nA = 1 ; B='2'\n+>\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(of("plant.rvm//SITE", "A"), "1");
  EXPECT_EQ(of("plant.rvm//SITE", "B"), "2");
}

TEST_F(RvmAttributes, GoToTheModelOfTheirStem) {
  tests::RvmBytes rvm;
  rvm.head().group("/SITE", 1).group_end().begin("END:").end();
  ASSERT_TRUE(read_rvm(rvm.bytes, "other.rvm", scene_, scene_.root()));
  const std::string text = std::string(kHeader) + "NEW /SITE\nA:= 1\nEND\n";
  ASSERT_TRUE(read(text, false, "folder/other.att"));
  EXPECT_EQ(of("other.rvm//SITE", "A"), "1");
  EXPECT_EQ(of("plant.rvm//SITE", "A"), "none");
}

TEST_F(RvmAttributes, ErrorsSayWhere) {
  const auto message = [&](const std::string& text) {
    const auto report = read(text);
    EXPECT_FALSE(report);
    EXPECT_EQ(attributed_nodes(), 0u) << "nothing is set by a file with an error";
    EXPECT_EQ(scene_.node_count(), 6u);
    return report ? std::string() : report.error().message;
  };
  const std::string header(kHeader);
  EXPECT_EQ(message("v 0 0 0\n"),
            "plant.txt: line 1: not an attribute file: expected 'CADC_Attributes_File' at its begin");
  EXPECT_EQ(message(header + "NEW /SITE\nA:= 1\nnonsense\nEND\n"),
            "plant.txt: line 4: expected 'key:= value' within an element");
  EXPECT_EQ(message(header + "NEW /SITE\nA:= 1\nEND\nEND\n"), "plant.txt: line 5: 'END' without 'NEW'");
  EXPECT_EQ(message(header + "NEW /SITE\nA:= 1\n"), "plant.txt: line 3: expected 1 more 'END'");
  EXPECT_EQ(message(header + "NEW /ELSEWHERE\nA:= 1\nEND\n"),
            "plant.txt: none of its 1 elements is a group of a model read before");
  const auto lenient = read_body("END\nNEW /SITE\nA:= 1\nnonsense\n", true);
  ASSERT_TRUE(lenient) << lenient.error().message;
  EXPECT_EQ(lenient->warnings.size(), 3u);
  EXPECT_EQ(of("plant.rvm//SITE", "A"), "1");
}

TEST_F(RvmAttributes, CanBeCancelled) {
  const std::string text = std::string(kHeader) + "NEW /SITE\nA:= 1\nEND\n";
  for (int until = 0; until < 3; ++until) {
    int asked = 0;
    ImportOptions options;
    options.progress = [&](double) { return asked++ < until; };
    const auto report =
        read_rvm_attributes(std::as_bytes(std::span(text)), "plant.txt", scene_, scene_.root(), options);
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().message, kCancelled);
    EXPECT_EQ(attributed_nodes(), 0u);
  }
}

TEST(RvmAttributesOfRealFiles, EveryGroupHasSome) {
  SIGHTLINE_NEED_DATA("huldra/WD1-PSUP.RVM");
  SIGHTLINE_NEED_DATA("huldra/WD1-PSUP.txt");
  core::Scene scene;
  const std::vector<std::filesystem::path> paths{tests::data_path("huldra/WD1-PSUP.txt"),
                                                 tests::data_path("huldra/WD1-PSUP.RVM")};  // attributes wait
  const auto report = import_files(paths, scene, scene.root());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  EXPECT_EQ(report->attributed, 4084u);
  EXPECT_EQ(scene.node_count(), 4086u) << "root, file, groups";
  const auto zones = nodes_with(scene, "Type", "ZONE");
  ASSERT_FALSE(zones.empty());
  EXPECT_EQ(scene.name(zones[0]), "/PS/WD1/0001");
}

TEST_F(RvmAttributes, QuotesAndWordsAtTheEdge) {
  ASSERT_TRUE(read_body("NEW\t/SITE\nA:= 'x\nB:= '\nC:= ''\nD:= 'x\"\nNEWS:= 5\nEND\n"));
  EXPECT_EQ(of("plant.rvm//SITE", "A"), "'x");
  EXPECT_EQ(of("plant.rvm//SITE", "B"), "'");
  EXPECT_EQ(of("plant.rvm//SITE", "C"), "");
  EXPECT_EQ(of("plant.rvm//SITE", "D"), "'x\"");
  EXPECT_EQ(of("plant.rvm//SITE", "NEWS"), "5");
  EXPECT_FALSE(read_body("NEW /SITE\nNEW\nEND\n"));
  EXPECT_FALSE(read_body("NEW /SITE\n:= value\nEND\n"));
}

TEST_F(RvmAttributes, FilesOfAnotherNameSpeakOfAllModels) {
  ASSERT_TRUE(read(std::string(kHeader) + "NEW /SITE\nA:= 1\nEND\n", false, "other.txt"));
  EXPECT_EQ(of("plant.rvm//SITE", "A"), "1");
}

TEST_F(RvmAttributes, LimitsAreReached) {
  const auto nested = [](std::size_t depth) {
    std::string text = "NEW /SITE\nA:= 1\n";
    for (std::size_t i = 1; i < depth; ++i) text += "NEW x\n";
    text += "A:= 2\n";
    for (std::size_t i = 1; i < depth; ++i) text += "END\n";
    return text + "B:= 3\nEND\n";
  };
  EXPECT_TRUE(read_body(nested(kMaxAttributeDepth)));
  EXPECT_FALSE(read_body(nested(kMaxAttributeDepth + 1)));
  SetUp();
  const auto deep = read_body(nested(kMaxAttributeDepth + 3), true);
  ASSERT_TRUE(deep) << deep.error().message;
  EXPECT_EQ(of("plant.rvm//SITE", "B"), "3");  // what was too deep has been left again
  const auto many = [](std::size_t count) {
    std::string text = "NEW /SITE\n";
    for (std::size_t i = 0; i < count; ++i) text += "k" + std::to_string(i) + ":= 1\n";
    return text + "END\n";
  };
  EXPECT_TRUE(read_body(many(kMaxAttributesPerElement)));
  EXPECT_FALSE(read_body(many(kMaxAttributesPerElement + 1)));
}

TEST(RvmAttributesOfRealFiles, TheSmallPlantHasThemAll) {
  core::Scene scene;
  const std::vector<std::filesystem::path> paths{tests::data_path("small_plant.rvm"),
                                                 tests::data_path("small_plant.txt")};
  const auto report = import_files(paths, scene, scene.root());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  EXPECT_EQ(report->attributed, 7u);
  EXPECT_EQ(nodes_with(scene, "Type", "PIPE").size(), 4u);
}

}  // namespace
}  // namespace sightline::importers::rvm_attributes_test
