// Files of exact surfaces in what other programs wrap them in: comments, sections of edition 3, marks of editors, zips,
// text of other encodings, and parameters that are left out.
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zip.h>

#include "sightline/importers/cad/internal/cad_reader.h"
#include "sightline/importers/cad/internal/step_repair.h"
#include "sightline/tests/importers/cad_model.h"

namespace sightline::importers::cad_repair_test {
namespace {

namespace fs = std::filesystem;
using tests::CadModel;

struct Repaired {
  std::string text;
  std::vector<ImportWarning> warnings;
};

Repaired repaired(std::string_view text) {
  core::Scene scene;
  Repaired found;
  const ImportOptions options;
  const auto report = run_import("model.stp", scene, scene.root(), options, {}, [&](ImportJob& job) {
    found.text = repaired_step(job, text);
    found.warnings = job.report().warnings;
    return core::Expected<void>();
  });
  EXPECT_TRUE(report);
  return found;
}

std::string string_as_repaired(const std::string& content) {
  const std::string text = repaired("ISO-10303-21;DATA;#1=A('" + content + "');ENDSEC;END-ISO-10303-21;").text;
  const std::size_t begin = text.find('\'') + 1;
  return text.substr(begin, text.rfind('\'') - begin);
}

TEST(CadRepair, StringsOfStepBecomeAscii) {
  const std::pair<const char*, const char*> strings[] = {
      {"plain; /* no comment */", "plain; /* no comment */"},
      {"it''s", "it''s"},
      {"\\X2\\00DC\\X0\\ \\S\\|", "\\X2\\00DC\\X0\\ \\S\\|"},
      {"Gehäuse", "Geh\\X2\\00E4\\X0\\use"},
      {"Geh\xe4use", "Geh\\X2\\00E4\\X0\\use"},
      {"\x80", "\\X2\\20AC\\X0\\"},
      {"日本1", "\\X2\\65E5672C\\X0\\1"},
      {"\U0001F527", "\\X2\\D83DDD27\\X0\\"},
      {"a\\\\ü", "a\\\\\\X2\\00FC\\X0\\"},
      {"a\\ü", "a\\\\\\X2\\00FC\\X0\\"},
      {"", ""},
  };
  for (const auto& [written, wanted] : strings) EXPECT_EQ(string_as_repaired(written), wanted) << written;
  const Repaired both = repaired("#1=A('\xe4','\xfc');");
  ASSERT_EQ(both.warnings.size(), 1u);
  EXPECT_EQ(both.warnings[0].message, "names are not UTF-8: taken for Windows-1252, the first as 'ä'");
  EXPECT_TRUE(repaired("#1=A('ä');").warnings.empty());
}

TEST(CadRepair, SectionsOfEdition3) {
  const auto file = [](const std::string& middle, const std::string& end = "") {
    return "ISO-10303-21;\nHEADER;\nFILE_NAME('DATA;');\nENDSEC;\n" + middle + "ENDSEC;\nEND-ISO-10303-21;" + end;
  };
  const std::string plain = repaired(file("DATA;\n#1=A('ENDSEC;');\n#2=B();\n")).text;
  EXPECT_EQ(plain, file("DATA;\n#1=A('ENDSEC;');\n#2=B();\n"));
  const auto without_blanks = [](std::string of) {
    std::erase_if(of, [](char c) { return c == ' ' || c == '\n'; });
    return of;
  };
  for (const std::string& text :
       {file("DATA('one',('S'));\n#1=A('ENDSEC;');\nENDSEC;\nDATA ('two;',('S'));\n#2=B();\n"),
        file("DATA;\n#1=A('ENDSEC;');\nENDSEC; /* DATA; */ data/**/('two',('S'));\n#2=B();\n"),
        file("ANCHOR;<a>=#1;<b>='ENDSEC;';ENDSEC;REFERENCE;#9=<#a>;ENDSEC;DATA;\n#1=A('ENDSEC;');\n#2=B();\n"),
        file("SIGNATURE MIIBd0=ENDSEC;DATA;\n#1=A('ENDSEC;');\n#2=B();\n"),
        file("DATA;\n#1=A('ENDSEC;');\n#2=B();\n", "\nSIGNATURE\nMI'IB/*d0=\nENDSEC;")}) {
    const Repaired found = repaired(text);
    EXPECT_EQ(without_blanks(found.text), without_blanks(plain)) << text;
    EXPECT_TRUE(found.warnings.empty());
  }
  const Repaired elsewhere = repaired(file("REFERENCE;#9=<other.stp#a>;#8=<#a>;ENDSEC;DATA;\n"));
  ASSERT_EQ(elsewhere.warnings.size(), 1u);
  EXPECT_EQ(elsewhere.warnings[0].message, "1 references to entities of other files are not read");
}

TEST(CadRepair, CommentsAndDamage) {
  EXPECT_EQ(repaired("/* it's; */#1/*'*/=A/* ; */(1.)/**/;").text, " #1 =A (1.) ;");
  EXPECT_EQ(repaired("#1=A(1./2);").text, "#1=A(1./2);");
  EXPECT_EQ(repaired("#1=A(/* never ends").text, "#1=A( ");
  EXPECT_EQ(repaired("#1=A('never ends;").text, "#1=A('never ends;");
  EXPECT_EQ(repaired("").text, "");
  EXPECT_EQ(repaired(" \n").text, " \n");
}

// --- through the reader ----------------------------------------------------------------------------------------------

class CadRepairFiles : public testing::Test {
 protected:
  /// The items of a file; what it warns of is in `report_`.
  std::size_t items_of(const fs::path& file) {
    scene_ = core::Scene();
    auto report = read_cad(file, scene_, scene_.root(), {});  // in this process
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    report_ = report.value_or(ImportReport());
    EXPECT_TRUE(scene_.commit());
    return scene_.item_count();
  }
  std::size_t items_of(const std::string& name, std::string_view text) {
    tests::write_text(folder_ / name, text);
    return items_of(folder_ / name);
  }
  std::string step() const {
    const CadModel model;
    model.part(tests::cad_box(1, 2, 3), "box");
    model.write_step(folder_ / "made.stp");
    return tests::text_of_file(folder_ / "made.stp");
  }

  tests::CadFolder folder_;
  core::Scene scene_;
  ImportReport report_;
};

std::string utf16(const std::string& ascii) {
  std::string wide = "\xff\xfe";
  for (const char c : ascii) wide.append({c, '\0'});
  return wide;
}

void write_zip(const fs::path& path, const std::vector<std::pair<std::string, std::string>>& entries) {
  int error = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
  for (const auto& [name, text] : entries)
    if (name.ends_with('/'))
      zip_dir_add(archive, name.c_str(), 0);
    else
      zip_file_add(archive, name.c_str(), zip_source_buffer(archive, text.data(), text.size(), 0), 0);
  zip_close(archive);
}

TEST_F(CadRepairFiles, MarksOfEditors) {
  const std::string mark = "\xef\xbb\xbf", text = step();
  EXPECT_EQ(items_of("mark.stp", mark + text), 1u);
  EXPECT_EQ(items_of("wide.stp", utf16(text)), 1u);
  CadModel model;
  model.part(tests::cad_box(1, 2, 3), "box");
  model.write_iges(folder_ / "made.igs");
  const std::string iges = tests::text_of_file(folder_ / "made.igs");
  EXPECT_EQ(items_of("mark.igs", mark + iges), 1u);
  EXPECT_EQ(items_of("wide.igs", utf16(iges)), 1u);
  BRepTools::Write(tests::cad_box(1, 2, 3), (folder_ / "made.brep").c_str());
  EXPECT_EQ(items_of("mark.brep", mark + tests::text_of_file(folder_ / "made.brep")), 1u);
}

TEST_F(CadRepairFiles, ZipsWithMoreThanTheModel) {
  const std::string text = step();
  const std::vector<std::pair<std::string, std::string>> packed[] = {
      {{"part/", ""}, {"part/part.stp", text}},
      {{"__MACOSX/._part.stp", std::string("\0\5\26\7", 4) + std::string(80, '\0')}, {"part.stp", text}},
      {{"readme.txt", "by hand"}, {"a/b/part.STEP", "\xef\xbb\xbf" + text}, {"image.png", "\x89PNG"}},
      {{"model", text}},
  };
  for (const auto& entries : packed) {
    write_zip(folder_ / "packed.stpz", entries);
    EXPECT_EQ(items_of(folder_ / "packed.stpz"), 1u) << entries[0].first;
  }
  const auto error_of = [&](const std::vector<std::pair<std::string, std::string>>& entries) {
    write_zip(folder_ / "packed.stpz", entries);
    core::Scene scene;
    const auto report = read_cad(folder_ / "packed.stpz", scene, scene.root(), {});
    return report ? "" : report.error().message;
  };
  EXPECT_EQ(error_of({{"a.stp", text}, {"b.stp", text}}),
            "packed.stpz: is no zip file with one STEP file: 2 of 2 entries are, the first 'a.stp', 'b.stp'");
  EXPECT_EQ(error_of({{"a.txt", "text"}}),
            "packed.stpz: is no zip file with one STEP file: 0 of 1 entries are, the first 'a.txt'");
}

TEST_F(CadRepairFiles, TwoDataSectionsAndComments) {
  const std::string text = step(), mark = "\n#10 = ";
  const std::size_t at = text.find(mark);
  ASSERT_NE(at, text.npos);
  EXPECT_EQ(
      items_of("two.stp", text.substr(0, at) + "\nENDSEC;\nDATA('more',('AUTOMOTIVE_DESIGN'));" + text.substr(at)), 1u);
  EXPECT_EQ(items_of("comment.stp", tests::replaced(text, mark, "/* it's #10 = ; */\n#10 /*'*/ = ")), 1u);
}

// --- IGES ------------------------------------------------------------------------------------------------------------

/// Entities with their parameters, in the fixed format.
class IgesText {
 public:
  /// `more`: comments behind the parameters.
  void add(int type, const std::string& parameters, int form = 0, const std::string& more = "") {
    const int pointer = 2 * int(count_++) + 1, first = lines_ + 1;
    std::string text = fmt::format("{},{};{}", type, parameters, more);
    while (!text.empty()) {
      std::size_t end = std::min<std::size_t>(64, text.size());
      if (end < text.size() && text.rfind(',', end - 1) != text.npos) end = text.rfind(',', end - 1) + 1;
      parameters_ += fmt::format("{:<64}{:8}P{:7}\n", text.substr(0, end), pointer, ++lines_);
      text.erase(0, end);
    }
    directory_ +=
        fmt::format("{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:8}00000000D{:7}\n", type, first, 0, 0, 0, 0, 0, 0, pointer);
    directory_ += fmt::format("{:8}{:8}{:8}{:8}{:8}{:32}D{:7}\n", type, 0, 0, lines_ - first + 1, form, 0, pointer + 1);
  }
  std::string text() const {
    return fmt::format("{:<72}S      1\n", "made") +
           fmt::format("{:<72}G      1\n", "1H,,1H;,4Hpart,8Hpart.igs,1Ha,1Ha,32,38,6,308,15,4Hpart,1.,2,2HMM,1,") +
           fmt::format("{:<72}G      2\n", "0.01,15H20240101.000000,1.E-06,1000.,1Ha,1Ha,11,0,15H20240101.000000;") +
           directory_ + parameters_ +
           fmt::format("{:<72}T      1\n", fmt::format("S{:7}G{:7}D{:7}P{:7}", 1, 2, 2 * count_, lines_));
  }

 private:
  std::string directory_, parameters_;
  std::size_t count_ = 0;
  int lines_ = 0;
};

/// A bilinear patch of 10 x 20 at a height, whose knots run from 1 to 3 and from -2 to 5.
std::string patch(double z, const std::string& ranges = ",1.,3.,-2.,5.") {
  return fmt::format(
      "1,1,1,1,0,0,1,0,0,1.,1.,3.,3.,-2.,-2.,5.,5.,1.,1.,1.,1.,"
      "0.,0.,{0},10.,0.,{0},0.,20.,{0},10.,20.,{0}{1}",
      z, ranges);
}

TEST_F(CadRepairFiles, IgesCommentsBehindParameters) {
  for (const char* comment :
       {" made by hand; 3 patches, 1.5 mm",
        " words of a first line, more words of it, and more; 1,2,3; 5Hwords; 128,0,0,0; in a second"}) {
    IgesText text;
    text.add(128, patch(0), 0, comment);
    text.add(128, patch(5), 0, comment);
    EXPECT_EQ(items_of("comments.igs", text.text()), 2u) << comment;
    EXPECT_TRUE(report_.warnings.empty());
    EXPECT_NEAR(scene_.bounds(scene_.root()).max.z, 0.005, 1e-9);
  }
}

TEST_F(CadRepairFiles, IgesSplinesWithoutTheirLastParameters) {
  for (const char* ranges : {"", ",1.", ",1.,3.", ",1.,3.,-2.", ",,,,", ",1.,,,5.", ",1.,3.,-2.,5."}) {
    SCOPED_TRACE(ranges);
    IgesText text;
    text.add(128, patch(0, ranges));
    text.add(128, patch(5, ranges), 0, " and a comment");
    EXPECT_EQ(items_of("patches.igs", text.text()), 2u);
    EXPECT_TRUE(report_.warnings.empty());
    const core::AabbD bounds = scene_.bounds(scene_.root());
    EXPECT_NEAR(bounds.max.x, 0.01, 1e-9);
    EXPECT_NEAR(bounds.max.y, 0.02, 1e-9);
  }
  IgesText curve;
  curve.add(128, patch(0));
  curve.add(126, "1,1,0,0,1,0,0.,0.,1.,1.,1.,1.,0.,0.,0.,5.,5.,5.");
  EXPECT_EQ(items_of("curve.igs", curve.text()), 1u);
  EXPECT_EQ(report_.surfaces.curves, 1u);
}

TEST_F(CadRepairFiles, IgesEntitiesThatAreDamagedAreSaid) {
  IgesText text;
  text.add(128, patch(0));
  text.add(128, "1,1,1,1,0,0,1,0,0,1.,1.");
  EXPECT_EQ(items_of("damaged.igs", text.text()), 1u);
  ASSERT_FALSE(report_.warnings.empty());
  EXPECT_EQ(report_.warnings[0].message, "entity D3 (type 128) has too few parameters and is not read");
}

TEST_F(CadRepairFiles, IgesNames) {
  for (const std::string name : {"Gehäuse", "Geh\xe4use", "1H;1H,"}) {
    IgesText text;
    text.add(128, patch(0) + ",0,1,3");
    text.add(406, fmt::format("1,{}H{}", name.size(), name), 15, "a comment");
    EXPECT_EQ(items_of("names.igs", text.text()), 1u);
    const core::NodeId part = scene_.first_child(scene_.first_child(scene_.root()));
    EXPECT_EQ(scene_.name(part), name.starts_with("G") ? "Gehäuse" : name);
    EXPECT_EQ(report_.warnings.size(), name.size() == 7 ? 1u : 0u);
  }
}

}  // namespace
}  // namespace sightline::importers::cad_repair_test
