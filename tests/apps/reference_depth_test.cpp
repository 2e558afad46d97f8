// Depth images of real plants against an independent double-precision reference.
#include "sightline/tests/apps/render_test.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::tests::reference_depth_test {
namespace {

class ReferenceDepth : public RenderTest, public ::testing::WithParamInterface<ModelView> {};

TEST_P(ReferenceDepth, Agrees) {
  const auto& [model, view] = GetParam();
  const std::string model_file = "huldra/" + model + ".RVM", reference = "reference/" + model + "_" + view;
  const std::string script = "../tools/compare_depth.py";
  for (const std::string& name : {model_file, reference + ".json", reference + ".pfm.gz", script})
    SIGHTLINE_NEED_DATA(name);
  if (run_program("python3", {"--version"}).code != 0) GTEST_SKIP() << "needs python3";
  const std::string depth = path("depth.pfm");
  render({data_path(model_file).string(), "--view", data_path(reference + ".json").string(), "--size", "480x270",
          "--depth", depth});
  // The tool's defaults, and the tighter bound of an exact renderer: 99 % of the pixels within 1e-4 of their depth.
  const Outcome compared = run_program(
      "python3", {data_path(script).string(), depth, data_path(reference + ".pfm.gz").string(), "--min-1e-4", ".99"});
  EXPECT_EQ(compared.code, 0) << compared;
  RecordProperty("compared", compared.out);
}

INSTANTIATE_TEST_SUITE_P(Huldra, ReferenceDepth, huldra_views(), name_of_view);

}  // namespace
}  // namespace sightline::tests::reference_depth_test
