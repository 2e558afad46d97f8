// The examples as they stand in examples/: each draws a picture.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests {
namespace {

class Examples : public RenderTest {
 protected:
  void expect_picture(const std::string& example, Args args) const {
    const std::string picture = path("picture.png");
    args.push_back(picture);
    const Outcome outcome = run_program(std::string(SIGHTLINE_BIN_DIR) + "/" + example, args);
    EXPECT_EQ(outcome.code, 0) << outcome;
    EXPECT_EQ(read_bytes(picture).rfind("\x89PNG", 0), 0u) << outcome;
  }
};

TEST_F(Examples, Embed) {
  expect_picture("embed", {plant(3000)});
}

#ifdef SIGHTLINE_HAVE_VTK_EXAMPLE
TEST_F(Examples, VtkImport) {
  expect_picture("vtk_import", {});
}
#endif

}  // namespace
}  // namespace sightline::tests
