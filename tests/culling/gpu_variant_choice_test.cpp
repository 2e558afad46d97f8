// Which variant of the GPU culler is taken for given times.
#include "sightline/culling/gpu/internal/gpu_variant_choice.h"

#include <gtest/gtest.h>

namespace sightline::culling::gpu_variant_choice_test {
namespace {

TEST(GpuVariantChoice, TakesTheCheaperVariant) {
  const FormTimes quick{1.0, 0.25, 0.25}, slow{2.0, 0.25, 0.25};
  EXPECT_EQ(cheaper_variant({quick, slow}), 0u);
  EXPECT_EQ(cheaper_variant({slow, quick}), 1u);
  EXPECT_EQ(cheaper_variant({quick, quick}), 0u);
}

TEST(GpuVariantChoice, CountsHowLongSubmissionBlocks) {
  const FormTimes free{2.0, 0.25, 0.25}, blocking{1.0, 0.25, 2.75};
  EXPECT_EQ(blocking.cost(), 3.5);
  EXPECT_EQ(cheaper_variant({blocking, free}), 1u);
  const FormTimes blocked_less{2.0, 0.5, 0.25};  // by chance: no gain
  EXPECT_EQ(blocked_less.cost(), 2.0);
}

TEST(GpuVariantChoice, TakesTheLeastOfEachTime) {
  FormTimes times;
  times.take_least({3.0, 1.0, 4.0});
  times.take_least({2.0, 2.0, 5.0});
  times.take_least({4.0, 3.0, 2.0});
  EXPECT_EQ(times.alone, 2.0);
  EXPECT_EQ(times.submitted, 1.0);
  EXPECT_EQ(times.blocked, 2.0);
}

}  // namespace
}  // namespace sightline::culling::gpu_variant_choice_test
