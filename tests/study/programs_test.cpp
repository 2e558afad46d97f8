#include <gtest/gtest.h>

#include "sightline/tests/study/study_programs.h"
#include "sightline/tests/support/glslang.h"

namespace sightline::study::programs_test {
namespace {

TEST(StudyPrograms, AreValid) {
  tests::expect_valid(tests::study_programs());
}

}  // namespace
}  // namespace sightline::study::programs_test
