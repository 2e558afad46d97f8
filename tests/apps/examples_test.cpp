// The examples as they stand in examples/: each draws an image, which is compared with one that was looked at
// (tests/data/examples).
#include <sstream>

#include "sightline/render/image/image.h"
#include "sightline/tests/apps/window_test.h"
#include "sightline/tests/support/places.h"

namespace sightline::tests::examples_test {
namespace {

struct Example {
  const char* name;
  const char* model = nullptr;   // below tests/data; "plant": a generated one
  const char* folder = nullptr;  // for a program that writes several images: the one to compare
  int max = 96;                  // other drivers make the same image but for a few pixels on edges
  double mean = 0.05;
};
std::ostream& operator<<(std::ostream& to, const Example& example) {
  return to << example.name;
}

constexpr Example kOffscreen[] = {
    {"cull_only", nullptr, nullptr, 0, 0.0},
    {"c_embed", "small_plant.rvm"},
    {"embed", "plant"},
    {"offscreen_batch", "small_plant.rvm", "view-1.png"},
    {"edit_while_flying"},
    {"own_renderer"},
    {"vtk_import"},
};
constexpr Example kInWindows[] = {
    {"own_window", "small_plant.rvm"},
    {"vtk_window", "small_plant.rvm"},
    {"osg_viewer", "small_plant.rvm"},
    {"qt_widget", "small_plant.rvm"},
};

/// The examples that this build has.
template <std::size_t N>
std::vector<Example> built(const Example (&all)[N]) {
  std::istringstream names(SIGHTLINE_EXAMPLES);
  const std::vector<std::string> known{std::istream_iterator<std::string>(names), {}};
  std::vector<Example> found;
  for (const Example& example : all)
    if (std::find(known.begin(), known.end(), example.name) != known.end()) found.push_back(example);
  return found;
}

template <class Fixture>
class ExampleTest : public Fixture, public testing::WithParamInterface<Example> {
 protected:
  void draws_its_image() const {
    const Example& example = GetParam();
    const std::string folder = this->path(""), written = this->path(example.folder ? example.folder : "image.png");
    Args args;
    if (example.model)
      args.push_back(example.model == std::string("plant")
                         ? this->plant(3000)
                         : in_checkout(std::string("tests/data/") + example.model).string());
    args.push_back(example.folder ? folder : written);
    const Outcome outcome = this->run_program(in_bin(example.name).string(), args);
    ASSERT_EQ(outcome.code, 0) << outcome;
    const std::string looked_at = in_checkout(std::string("tests/data/examples/") + example.name + ".png").string();
    const auto is = image::read_png(written), expected = image::read_png(looked_at);
    ASSERT_TRUE(is) << is.error().message;
    ASSERT_TRUE(expected) << expected.error().message;
    const auto difference = image::compare(*is, *expected);
    ASSERT_TRUE(difference) << difference.error().message;
    EXPECT_LE(difference->max, example.max) << difference->pixels << " pixels differ";
    EXPECT_LE(difference->mean, example.mean) << difference->pixels << " pixels differ";
  }
};

using Examples = ExampleTest<RenderTest>;
using ExamplesInWindows = ExampleTest<WindowTest>;
const auto name_of = [](const testing::TestParamInfo<Example>& info) { return std::string(info.param.name); };

TEST_P(Examples, DrawsItsImage) {
  draws_its_image();
}
INSTANTIATE_TEST_SUITE_P(All, Examples, testing::ValuesIn(built(kOffscreen)), name_of);

TEST_P(ExamplesInWindows, DrawsItsImage) {
  draws_its_image();
}
INSTANTIATE_TEST_SUITE_P(All, ExamplesInWindows, testing::ValuesIn(built(kInWindows)), name_of);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ExamplesInWindows);

}  // namespace
}  // namespace sightline::tests::examples_test
