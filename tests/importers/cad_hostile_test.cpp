// Damaged and malicious files of exact surfaces, read in processes of their own: each import ends with a result or an
// error, whatever becomes of the process, and leaves a scene that can be committed.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "sightline/importers/import.h"
#include "sightline/tests/hostile/attack.h"
#include "sightline/tests/importers/cad_model.h"
#include "sightline/tests/support/effort.h"

namespace sightline::importers::cad_hostile_test {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  bool imported = false;
  std::string error;
  std::size_t nodes = 0;
};

/// Imports a file, and checks what must be true whatever the file holds. Open CASCADE never ends with some: these are
/// cancelled, as people would, long before the reader's own limit.
Outcome import_of(const fs::path& file, bool lenient, const std::string& what) {
  constexpr std::chrono::seconds kPatience(4);
  const auto end = std::chrono::steady_clock::now() + kPatience;
  core::Scene scene;
  ImportOptions options{.lenient = lenient, .threads = 1};
  options.progress = [&](double) { return std::chrono::steady_clock::now() < end; };
  const auto report = import_file(file, scene, scene.root(), options);
  Outcome outcome{report.has_value(), report ? "" : report.error().message, scene.node_count()};
  if (!report) {
    EXPECT_TRUE(outcome.error.starts_with(file.string() + ": ") || outcome.error == kCancelled)
        << what << ": " << outcome.error;
    EXPECT_EQ(scene.node_count(), 1u) << what;
    EXPECT_EQ(scene.item_slots(), 0u) << what;
    EXPECT_EQ(scene.mesh_slots(), 0u) << what;
  }
  const auto committed = scene.commit();
  EXPECT_TRUE(committed) << what << ": " << (committed ? "" : committed.error().message);
  return outcome;
}

/// A model like as1-oc-214.stp: assemblies of assemblies, half of its parts primitives.
std::string model_text() {
  static const std::string text = [] {
    const tests::CadFolder folder;
    const tests::CadModel model;
    const TDF_Label bolt = model.part(tests::cad_box(5, 5, 30), "bolt"),
                    plate = model.part(tests::cad_drilled_box(), "plate"), pair = model.assembly("pair"),
                    top = model.assembly("top");
    model.use(pair, bolt, "one");
    model.use(pair, bolt, "two", tests::moved(20, 0, 0));
    model.use(top, pair, "left");
    model.use(top, pair, "right", tests::moved(0, 100, 0));
    model.use(top, plate, "plate", tests::moved(0, 0, 50));
    model.colour(bolt, 1, 0, 0);
    model.write_step(folder / "model.stp");
    return tests::text_of_file(folder / "model.stp");
  }();
  return text;
}

/// Imports the texts with two threads, strict and lenient in turn. Returns how many were read.
int import_all(const std::vector<std::string>& texts, const std::string& extension) {
  const tests::CadFolder folder;
  std::atomic<std::size_t> next{0};
  std::atomic<int> imported{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < texts.size(); i = next++) {
      const fs::path file = folder / (std::to_string(i) + extension);
      tests::write_text(file, texts[i]);
      imported += import_of(file, i % 2 == 1, fmt::format("{} of {} bytes", i, texts[i].size())).imported;
      fs::remove(file);
    }
  };
  std::thread other(work);
  work();
  other.join();
  return imported;
}

TEST(CadHostile, Truncated) {
  const std::string whole = model_text();
  std::vector<std::string> texts;
  const std::size_t count = tests::long_run() ? 500 : 16;
  for (std::size_t i = 0; i < count; ++i) texts.push_back(whole.substr(0, 1 + i * whole.size() / count));
  EXPECT_LT(import_all(texts, ".stp"), int(count));
}

TEST(CadHostile, Mutated) {
  const std::string whole = model_text();
  std::vector<std::string> texts;
  std::mt19937 random(1);
  for (int i = 0; i < (tests::long_run() ? 3000 : 40); ++i) texts.push_back(hostile::mutated(whole, random));
  EXPECT_GT(import_all(texts, ".stp"), 0);
}

TEST(CadHostile, MutatedIgesAndBrep) {
  const tests::CadFolder folder;
  const tests::CadModel model;
  const TopoDS_Shape shape = tests::cad_drilled_box();
  model.part(shape, "part");
  model.write_iges(folder / "part.igs");
  BRepTools::Write(shape, (folder / "part.brep").c_str());
  for (const char* extension : {".igs", ".brep"}) {
    const std::string whole = tests::text_of_file(folder / (std::string("part") + extension));
    std::vector<std::string> texts;
    std::mt19937 random(2);
    for (int i = 0; i < tests::repeated(300, 25); ++i) texts.push_back(hostile::mutated(whole, random));
    for (std::size_t i = 0; i < 10; ++i) texts.push_back(whole.substr(0, i * whole.size() / 10));
    import_all(texts, extension);
  }
}

/// Open CASCADE alone would read on for ever.
TEST(CadHostile, BrepThatEndsEarly) {
  const tests::CadFolder folder;
  BRepTools::Write(tests::cad_drilled_box(), (folder / "whole.brep").c_str());
  const std::string whole = tests::text_of_file(folder / "whole.brep");
  for (std::size_t i = 1; i < 12; ++i) {
    const fs::path file = folder / "part.brep";
    tests::write_text(file, std::string_view(whole).substr(0, i * whole.size() / 12));
    const Outcome outcome = import_of(file, i % 2 == 1, "part");
    EXPECT_FALSE(outcome.imported);
    EXPECT_NE(outcome.error, kCancelled) << "it went on";
  }
}

/// All numbers of one kind of entity as an absurd one.
std::string with_numbers(std::string text, const std::string& entity, const std::string& number) {
  for (std::size_t at = text.find(entity); at != std::string::npos; at = text.find(entity, at + 1)) {
    const std::size_t open = text.find('(', text.find(',', at));
    const std::size_t end = std::min(text.find_first_of(",)", open), text.size());
    if (open < end && end - open < 40) text.replace(open + 1, end - open - 1, number);
  }
  return text;
}

TEST(CadHostile, AbsurdNumbersAndReferences) {
  const std::string whole = model_text();
  std::vector<std::string> texts;
  for (const char* number : {"1.E308", "-1.E308", "1.E400", "nan", "1.E37", "1.E-320", "99999999999999999999", "*", ""})
    for (const char* entity : {"CARTESIAN_POINT", "DIRECTION"}) texts.push_back(with_numbers(whole, entity, number));
  for (const char* radius : {"0.)", "-5.)", "1.E300)", "nan)", "1.E-300)"})
    texts.push_back(tests::replaced(whole, ",5.)", std::string(",") + radius));
  texts.push_back(tests::replaced(whole, "ENDSEC;", "#4294967296 = CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;"));
  texts.push_back(tests::replaced(whole, "ENDSEC;", "#99999999999999999999 = DIRECTION('',(0.,0.,1.));\nENDSEC;"));
  texts.push_back(tests::replaced(whole, "#10)", "#99999)"));
  texts.push_back(tests::replaced(whole, "#11 =", "#12 ="));
  import_all(texts, ".stp");
}

TEST(CadHostile, DeepBracketsAndLongStrings) {
  const std::string whole = model_text();
  const auto with = [&](const std::string& entity) {
    return tests::replaced(whole, "ENDSEC;\nEND-ISO", entity + "ENDSEC;\nEND-ISO");
  };
  import_all({with("#90000 = DIRECTION('',(" + std::string(200000, '(') + "0." + std::string(200000, ')') + "));\n"),
              with("#90000 = PRODUCT('" + std::string(5000000, 'x') + "','','',());\n"),
              with("#90000 = PRODUCT('" + hostile::repeated("\\X2\\", 100000) + "','','',());\n"),
              with("#90000 = DIRECTION('',(" + hostile::repeated("0.", 500000, ",") + "));\n"),
              with(hostile::repeated("/* ", 100000)), with("'"), std::string(1000000, '\0'),
              "ISO-10303-21;\nHEADER;\n" + hostile::repeated("FILE_NAME('','',(''),(''),'','','');\n", 20000)},
             ".stp");
}

/// The number of a file's first entity of a type, with '#'.
std::string number_of(const std::string& text, const std::string& type) {
  const std::size_t at = text.find(" = " + type + "("), begin = text.rfind('#', at);
  return text.substr(begin, at - begin);
}

/// Assemblies each of which uses the one below it `uses` times; the lowest uses a box, or in a cycle the highest.
std::string nested(int levels, int uses, bool cycle = false) {
  const tests::CadFolder folder;
  const tests::CadModel model;
  model.part(tests::cad_box(1, 2, 3), "box");
  model.write_step(folder / "box.stp");
  const std::string box = tests::text_of_file(folder / "box.stp"), product_context = number_of(box, "PRODUCT_CONTEXT"),
                    definition_context = number_of(box, "PRODUCT_DEFINITION_CONTEXT"),
                    shape = number_of(box, "ADVANCED_BREP_SHAPE_REPRESENTATION"),
                    axis = number_of(box, "AXIS2_PLACEMENT_3D");
  const std::size_t end_of_shape = box.find(");", box.find(shape + " = "));
  const std::string context = box.substr(box.rfind('#', end_of_shape), end_of_shape - box.rfind('#', end_of_shape));
  constexpr int kLevel = 1000, kUse = 10;
  const auto base = [](int level) { return 100000 + kLevel * level; };
  std::string all;
  for (int level = 0; level < levels; ++level) {
    const int n = base(level), under = level > 0 ? base(level - 1) : base(levels - 1);
    const bool on_box = level == 0 && !cycle;
    const std::string part = on_box ? number_of(box, "PRODUCT_DEFINITION") : fmt::format("#{}", under + 2),
                      its_shape = on_box ? shape : fmt::format("#{}", under + 5);
    all += fmt::format(
        "#{} = PRODUCT('level{}','level{}','',({}));\n#{} = PRODUCT_DEFINITION_FORMATION('','',#{});\n"
        "#{} = PRODUCT_DEFINITION('design','',#{},{});\n#{} = PRODUCT_DEFINITION_SHAPE('','',#{});\n"
        "#{} = SHAPE_DEFINITION_REPRESENTATION(#{},#{});\n#{} = SHAPE_REPRESENTATION('',({}",
        n, level, level, product_context, n + 1, n, n + 2, n + 1, definition_context, n + 3, n + 2, n + 4, n + 3, n + 5,
        n + 5, axis);
    for (int use = 0; use < uses; ++use) all += fmt::format(",#{}", n + kUse * (use + 1));
    all += fmt::format("),{});\n", context);
    for (int use = 0; use < uses; ++use) {
      const int m = n + kUse * (use + 1);
      all += fmt::format(
          "#{} = AXIS2_PLACEMENT_3D('',#{},$,$);\n#{} = CARTESIAN_POINT('',({}.,{}.,0.));\n"
          "#{} = NEXT_ASSEMBLY_USAGE_OCCURRENCE('{}','use','',#{},{},$);\n#{} = PRODUCT_DEFINITION_SHAPE('','',#{});\n"
          "#{} = ITEM_DEFINED_TRANSFORMATION('','',{},#{});\n"
          "#{} = ( REPRESENTATION_RELATIONSHIP('','',{},#{}) REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{}) "
          "SHAPE_REPRESENTATION_RELATIONSHIP() );\n#{} = CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{},#{});\n",
          m, m + 1, m + 1, level, use, m + 2, m, n + 2, part, m + 3, m + 2, m + 4, axis, m, m + 5, its_shape, n + 5,
          m + 4, m + 6, m + 5, m + 3);
    }
  }
  return tests::replaced(box, "ENDSEC;\nEND-ISO", all + "ENDSEC;\nEND-ISO");
}

TEST(CadHostile, AssembliesOfThemselves) {
  import_all({nested(1, 1, true), nested(3, 2, true), nested(1, 2, true), nested(4, 1, true)}, ".stp");
}

TEST(CadHostile, AssembliesThatGrowWithoutEnd) {
  const tests::CadFolder folder;
  tests::write_text(folder / "few.stp", nested(8, 2));
  const Outcome few = import_of(folder / "few.stp", false, "2^8");
  EXPECT_TRUE(few.imported) << few.error;
  EXPECT_EQ(few.nodes, 1u + 1u + 511u);
  tests::write_text(folder / "many.stp", nested(30, 2));
  const Outcome many = import_of(folder / "many.stp", true, "2^30");
  EXPECT_EQ(many.error, (folder / "many.stp").string() + ": expected at most 50000000 parts in assemblies");
}

TEST(CadHostile, DeepAssemblies) {
  const tests::CadFolder folder;
  tests::write_text(folder / "deep.stp", nested(240, 1));
  const Outcome deep = import_of(folder / "deep.stp", false, "240 levels");
  EXPECT_TRUE(deep.imported) << deep.error;
  tests::write_text(folder / "deeper.stp", nested(300, 1));
  const Outcome strict = import_of(folder / "deeper.stp", false, "300 levels");
  EXPECT_FALSE(strict.imported);
  EXPECT_NE(strict.error.find("nested deeper than 250"), std::string::npos) << strict.error;
  EXPECT_TRUE(import_of(folder / "deeper.stp", true, "300 levels").imported);
}

TEST(CadHostile, CompressionBombs) {
  const tests::CadFolder folder;
  const std::string zeros(64 << 20, ' ');
  gzFile file = gzopen((folder / "bomb.stpz").c_str(), "wb9");
  for (int i = 0; i < (tests::long_run() ? 80 : 4); ++i) gzwrite(file, zeros.data(), unsigned(zeros.size()));
  gzclose(file);
  const Outcome bomb = import_of(folder / "bomb.stpz", false, "bomb");
  EXPECT_FALSE(bomb.imported);
}

}  // namespace
}  // namespace sightline::importers::cad_hostile_test
