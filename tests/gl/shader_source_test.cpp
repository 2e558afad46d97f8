#include "sightline/gl/internal/shader_source.h"

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/tests/gl/test_shaders.h"
#include "sightline/tests/support/places.h"

namespace sightline::gl::shader_source_test {
namespace {

using Table = std::vector<ShaderFile>;

core::Expected<StageSource> assemble(const Table& table, const std::vector<std::string>& files) {
  ShaderContext context;
  context.tables = {table};
  return assemble_stage(context, files);
}

std::string failure(const Table& table, const std::string& file) {
  auto source = assemble(table, {file});
  EXPECT_FALSE(source);
  return source ? "" : source.error().message;
}

TEST(ShaderSource, PutsTheProlog) {
  const Table table = {{"a", "void main() {}\n"}};
  ShaderContext context;
  context.tables = {table};
  context.extensions = {"GL_ARB_shader_draw_parameters"};
  context.defines = {"CAPPED", "COUNT 3"};
  const auto source = assemble_stage(context, std::vector<std::string>{"a"});
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ(source->text,
            "#version 450 core\n"
            "#extension GL_ARB_shader_draw_parameters : require\n"
            "#define CAPPED\n"
            "#define COUNT 3\n"
            "#line 100001 1\n"
            "void main() {}\n");
  EXPECT_EQ(source->files, (std::vector<std::string>{"prolog", "a"}));
}

TEST(ShaderSource, NestsIncludesAndKeepsLineNumbers) {
  const Table table = {{"a", "a1\n#include \"b\"\na3\n"}, {"b", "b1\n  #  include \"c\" // why\nb3"}, {"c", "c1\r\n"}};
  const auto source = assemble(table, {"a"});
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ(source->text,
            "#version 450 core\n#line 100001 1\na1\n#line 200001 2\nb1\n#line 300001 3\nc1\r\n#line 200003 "
            "2\nb3\n#line 100003 1\na3\n");
}

TEST(ShaderSource, IncludesOnce) {
  const Table table = {
      {"a", "#include \"b\"\n#include \"c\"\n#include \"b\"\na4\n"}, {"b", "b1\n"}, {"c", "#include \"b\"\n"}};
  const auto source = assemble(table, {"a"});
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ(source->text.find("b1"), source->text.rfind("b1"));
  EXPECT_NE(source->text.find("#line 100003 1\n\na4\n"), std::string::npos) << source->text;
}

TEST(ShaderSource, JoinsFilesAndPrefersTheFirstTable) {
  const Table first = {{"a", "first\n"}};
  const Table second = {{"a", "second\n"}, {"b", "b1\n"}};
  ShaderContext context;
  context.tables = {first, second};
  const auto source = assemble_stage(context, std::vector<std::string>{"a", "b"});
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ(source->text, "#version 450 core\n#line 100001 1\nfirst\n#line 200001 2\nb1\n");
}

TEST(ShaderSource, RefusesCycles) {
  const Table table = {{"a", "x\n#include \"b\"\n"}, {"b", "#include \"c\"\n"}, {"c", "\n\n#include \"a\"\n"}};
  EXPECT_EQ(failure(table, "a"), "c:3: include cycle: a -> b -> c -> a");
  EXPECT_EQ(failure({{"a", "#include \"a\""}}, "a"), "a:1: include cycle: a -> a");
}

TEST(ShaderSource, RefusesBadDirectives) {
  EXPECT_EQ(failure({{"a", "x\n#include \"b\"\n"}}, "a"), "a:2: no shader file is named 'b'");
  EXPECT_EQ(failure({}, "a"), "stage: no shader file is named 'a'");
  for (const char* text : {"#include <b>", "#include", "#include \"b", "#include \"b\" x", "#include \"\""}) {
    EXPECT_EQ(failure({{"a", text}, {"b", ""}}, "a"), "a:1: expected #include \"name\"") << text;
  }
  EXPECT_EQ(failure({{"a", "\n#version 330\n"}}, "a"), "a:2: #version is the builder's to write");
}

TEST(ShaderSource, DeepNestingIsAnOrdinaryInput) {
  constexpr int kDepth = 5000;
  std::vector<std::string> texts;
  for (int i = 0; i <= 2 * kDepth; ++i) {
    texts.push_back(i % 2 ? "#include \"" + std::to_string(i / 2 + 1) + "\"\n" : std::to_string(i / 2));
  }
  Table table;
  for (std::size_t i = 0; i + 1 < texts.size(); i += 2) table.emplace_back(texts[i], texts[i + 1]);
  table.emplace_back(texts.back(), "end\n");
  const auto source = assemble(table, {"0"});
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ(source->files.size(), kDepth + 2u);
}

TEST(ShaderSource, NamesFilesInLogs) {
  const std::vector<std::string> files = {"prolog", "a.vert", "b.glsl"};
  EXPECT_EQ(
      name_files_in_log("0:100012(3): error: oops\n2(200007) : error C1: no\nERROR: 0:200004: bad\n\n0:2(1): x", files),
      "a.vert:12(3): error: oops\nb.glsl:7 : error C1: no\nERROR: b.glsl:4: bad\nprolog:2(1): x");
  EXPECT_EQ(name_files_in_log("WARNING: 1:100002: odd\nWARNING: no place", files),
            "WARNING: a.vert:2: odd\nWARNING: no place");
  EXPECT_EQ(name_files_in_log("0:900001: x\nno numbers\n1 2\n1:\n1(", files), "0:900001: x\nno numbers\n1 2\n1:\n1(");
}

TEST(ShaderSource, EmbeddedFilesAreTheFiles) {
  ASSERT_EQ(tests::shaders().size(), 4u);
  EXPECT_EQ(tests::shaders()[3].first, "odd_text.glsl");
  for (const auto& [name, text] : tests::shaders()) {
    std::ifstream file(tests::in_checkout("tests/gl/shaders") / name, std::ios::binary);
    ASSERT_TRUE(file) << name;
    std::stringstream contents;
    contents << file.rdbuf();
    EXPECT_EQ(contents.str(), text) << name;
  }
}

}  // namespace
}  // namespace sightline::gl::shader_source_test
