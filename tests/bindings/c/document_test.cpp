// The program in docs/reference/c.md is the one that is built.
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "sightline/tests/support/places.h"

namespace sightline::tests::document_test {
namespace {

std::string text_of(const std::string& file) {
  std::ifstream in(in_checkout(file));
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(CapiDocument, ShowsTheExample) {
  const std::string program = text_of("examples/c_cull.c");
  ASSERT_FALSE(program.empty());
  EXPECT_NE(text_of("docs/reference/c.md").find("```c\n" + program + "```\n"), std::string::npos);
}

}  // namespace
}  // namespace sightline::tests::document_test
