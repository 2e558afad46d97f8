// Views made in C are those of C++ in every number.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <glm/gtc/type_ptr.hpp>

#include "c_scene.h"
#include "sightline/bindings/c/internal/values.h"

namespace sightline::tests::views_test {
namespace {

const sl_pose kPose = {{1, -20, 3}, {4, 5, 6}, {0, 0, 1}};
const core::Pose kSamePose{{1, -20, 3}, {4, 5, 6}, {0, 0, 1}};

void expect_same(const sl_view& view, const core::Expected<core::View>& expected) {
  ASSERT_TRUE(expected) << expected.error().message;
  EXPECT_TRUE(core::same_image(capi::view_of(&view), *expected));
}

TEST(CapiViews, AreThoseOfCpp) {
  sl_view view = SL_VIEW_INIT;
  ASSERT_OK(sl_view_perspective(&kPose, 0.7, 1.5, 0.1, 1e3, &view));
  expect_same(view, core::View::perspective(kSamePose, 0.7, 1.5, 0.1, 1e3));
  ASSERT_OK(sl_view_perspective(&kPose, 0.7, 1.5, 0.1, HUGE_VAL, &view));
  expect_same(view, core::View::perspective(kSamePose, 0.7, 1.5, 0.1));
  ASSERT_OK(sl_view_orthographic(&kPose, 30, 2, -5, 100, &view));
  expect_same(view, core::View::orthographic(kSamePose, 30, 2, -5, 100));
  ASSERT_OK(sl_view_asymmetric(&kPose, -0.1, 0.2, -0.3, 0.1, 0.5, 50, &view));
  expect_same(view, core::View::asymmetric(kSamePose, -0.1, 0.2, -0.3, 0.1, 0.5, 50));
  const sl_box box = {{-1, -2, -3}, {4, 5, 6}};
  const core::AabbD same_box{{-1, -2, -3}, {4, 5, 6}};
  const double direction[3] = {1, 2, -1};
  ASSERT_OK(sl_view_fit(&box, direction, 0.7, 1.5, &view));
  expect_same(view, core::View::fit(same_box, {1, 2, -1}, 0.7, 1.5));
  ASSERT_OK(sl_view_fit(&box, nullptr, 0.7, 1.5, &view));
  expect_same(view, core::View::fit(same_box, core::kOverviewDirection, 0.7, 1.5));
}

TEST(CapiViews, FromMatrices) {
  const core::View cpp = *core::View::perspective(kSamePose, 0.7, 1.5, 0.1, 1e3);
  const double* eye = glm::value_ptr(cpp.eye_from_world());
  const double* clip = glm::value_ptr(cpp.clip_from_eye());
  sl_view view = SL_VIEW_INIT;
  ASSERT_OK(sl_view_from_matrices(eye, clip, SL_DEPTH_REVERSED_ZERO_TO_ONE, &view));
  expect_same(view, cpp);
  const core::dmat4 product = cpp.clip_from_world();
  ASSERT_OK(sl_view_from_matrices(nullptr, glm::value_ptr(product), SL_DEPTH_REVERSED_ZERO_TO_ONE, &view));
  expect_same(view, core::View::from_matrices(core::dmat4(1.0), product, core::ClipDepth::kReversedZeroToOne));
  core::dmat4 plain = cpp.clip_from_eye();
  for (int c = 0; c < 4; ++c) plain[c][2] = plain[c][3] - plain[c][2];
  ASSERT_OK(sl_view_from_matrices(eye, glm::value_ptr(plain), SL_DEPTH_ZERO_TO_ONE, &view));
  expect_same(view, core::View::from_matrices(cpp.eye_from_world(), plain, core::ClipDepth::kZeroToOne));
  EXPECT_EQ(capi::view_of(&view).clip_depth(), core::ClipDepth::kZeroToOne);
  sl_view untouched = view;
  EXPECT_EQ(sl_view_from_matrices(glm::value_ptr(product), clip, 0, &view), SL_ERROR_FAILED) << "not affine";
  EXPECT_EQ(sl_view_from_matrices(eye, nullptr, 0, &view), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_view_from_matrices(eye, clip, 3, &view), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_view_from_matrices(eye, clip, SL_DEPTH_ZERO_TO_ONE, &view), SL_ERROR_FAILED) << "another depth";
  EXPECT_EQ(std::memcmp(&view, &untouched, sizeof view), 0);
}

TEST(CapiViews, SectionsAndLayersAreTakenOver) {
  sl_view view = SL_VIEW_INIT;
  ASSERT_OK(sl_view_perspective(&kPose, 0.7, 1.5, 0.1, 1e3, &view));
  EXPECT_EQ(view.layers, SL_DEFAULT_LAYERS);
  view.layers = 5;
  view.section_mode = SL_SECTIONS_UNION;
  view.section_count = 2;
  view.sections[0] = {{0, 0, 1}, 2};
  view.sections[1] = {{1, 0, 0}, -3};
  core::View cpp = *core::View::perspective(kSamePose, 0.7, 1.5, 0.1, 1e3);
  cpp.layers = 5;
  cpp.section_mode = core::SectionMode::kUnion;
  cpp.sections = {{{0, 0, 1}, 2}, {{1, 0, 0}, -3}};
  expect_same(view, cpp);
  view.section_count = 9;
  EXPECT_THROW((void)capi::view_of(&view), capi::Failure);
  view.section_count = 2;
  view.sections[1].offset = std::nan("");
  EXPECT_THROW((void)capi::view_of(&view), capi::Failure);
}

TEST(CapiViews, BadNumbersAreErrors) {
  sl_view view = SL_VIEW_INIT;
  EXPECT_EQ(sl_view_perspective(&kPose, 4, 1.5, 0.1, 1e3, &view), SL_ERROR_FAILED);
  EXPECT_STREQ(sl_last_error(), "perspective view: fovy must lie between 0 and pi");
  EXPECT_EQ(sl_view_perspective(nullptr, 0.7, 1.5, 0.1, 1e3, &view), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_view_perspective(&kPose, 0.7, 1.5, 0.1, 1e3, nullptr), SL_ERROR_ARGUMENT);
  const double nowhere[3] = {0, 0, 0};
  const sl_box box = {{-1, -2, -3}, {4, 5, 6}};
  EXPECT_EQ(sl_view_fit(&box, nowhere, 0.7, 1.5, &view), SL_ERROR_FAILED);
}

TEST(CapiViews, FromAFile) {
  if (!(sl_features() & SL_FEATURE_IMPORTING)) GTEST_SKIP() << "without importers";
  const auto file = std::filesystem::path(::testing::TempDir()) / "capi_view.json";
  std::ofstream(file) << R"({"eye":[1,-20,3],"target":[4,5,6],"fovy_deg":60,"near":0.5})";
  sl_view view = SL_VIEW_INIT;
  ASSERT_OK(sl_view_read(file.string().c_str(), 2.0, &view));
  expect_same(view, core::View::perspective(kSamePose, std::acos(-1.0) / 3.0, 2.0, 0.5));
  std::filesystem::remove(file);
  EXPECT_EQ(sl_view_read(file.string().c_str(), 2.0, &view), SL_ERROR_FAILED);
  EXPECT_EQ(sl_view_read(nullptr, 2.0, &view), SL_ERROR_ARGUMENT);
}

}  // namespace
}  // namespace sightline::tests::views_test
