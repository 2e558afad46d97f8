// The self-test against this driver, and against the same one with faults that a changed function table makes.
#include "sightline/gl/internal/driver_test.h"

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "sightline/gl/internal/program_cache.h"
#include "sightline/tests/support/environment.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::gl::driver_test_test {
namespace {

const Functions* real = nullptr;  // the entry points behind the faulty ones

std::map<DriverCheck, std::function<void(Functions&)>> faults() {
  return {
      {DriverCheck::kClipControl,
       [](Functions& gl) { gl.ClipControl = [](GLenum origin, GLenum) { real->ClipControl(origin, GL_NEGATIVE_ONE_TO_ONE); }; }},
      {DriverCheck::kConservativeDepth, [](Functions& gl) { gl.DepthFunc = [](GLenum) { real->DepthFunc(GL_ALWAYS); }; }},
      {DriverCheck::kBaseVertex,
       [](Functions& gl) {
         gl.MultiDrawElementsIndirect = [](GLenum mode, GLenum type, const void*, GLsizei, GLsizei) {
           real->DrawElements(mode, 3, type, nullptr);
         };
       }},
      {DriverCheck::kFeedback,
       [](Functions& gl) {
         gl.TransformFeedbackVaryings = [](GLuint program, GLsizei, const GLchar* const* names, GLenum mode) {
           real->TransformFeedbackVaryings(program, 1, names, mode);
         };
       }},
      {DriverCheck::kIndirectCount,
       [](Functions& gl) {
         gl.MultiDrawElementsIndirectCountARB = [](GLenum mode, GLenum type, const void* indirect, GLintptr, GLsizei most,
                                                   GLsizei stride) {
           real->BindBuffer(GL_PARAMETER_BUFFER_ARB, 0);  // Mesa 22.3 reads the count of any draw from it
           real->MultiDrawElementsIndirect(mode, type, indirect, most, stride);
         };
       }},
      {DriverCheck::kPreciseSums,
       [](Functions& gl) {
         gl.ProgramUniform2f = [](GLuint program, GLint place, GLfloat a, GLfloat) {
           real->ProgramUniform2f(program, place, a, 0.0f);
         };
       }},
      {DriverCheck::kTimer,
       [](Functions& gl) { gl.GetQueryiv = [](GLenum, GLenum, GLint* value) { *value = 0; }; }},
  };
}

class DriverTestTest : public tests::GlTest {
 protected:
  void SetUp() override {
    tests::GlTest::SetUp();
    if (context) real = &gl();
  }
};

TEST_F(DriverTestTest, ThisDriverPasses) {
  const DriverTest test = run_driver_test(gl(), context->capabilities());
  for (std::size_t i = 0; i < kDriverCheckCount; ++i) {
    const auto check = DriverCheck(i);
    EXPECT_NE(test[check], CheckResult::kFailed) << name_of(check);
    const bool optional = check == DriverCheck::kIndirectCount || check == DriverCheck::kSamples ||
                          check == DriverCheck::kStorageBlocks || check == DriverCheck::kGeometryStage;
    if (!optional) {
      EXPECT_EQ(test[check], CheckResult::kPassed) << name_of(check);
    }
  }
  EXPECT_GT(test.ms, 0.0);
}

TEST_F(DriverTestTest, EachFaultFailsItsCheckAlone) {
  for (const auto& [faulty, make] : faults()) {
    SCOPED_TRACE(name_of(faulty));
    if (faulty == DriverCheck::kIndirectCount && !context->capabilities().indirect_count) continue;
    Functions table = gl();
    make(table);
    const DriverTest test = run_driver_test(table, context->capabilities());
    for (std::size_t i = 0; i < kDriverCheckCount; ++i) {
      const auto check = DriverCheck(i);
      EXPECT_EQ(test[check] == CheckResult::kFailed, check == faulty) << name_of(check);
    }
  }
}

/// What a clock shows that goes on by so many nanoseconds with each draw of boxes.
std::uint64_t fake_now = 0, points_ns = 0, triangles_ns = 0;
std::map<GLuint, std::uint64_t> fake_stamps;

/// A check that measures: decided by times alone, and never made on software rasterisers.
TEST_F(DriverTestTest, TheGeometryStageFailsByItsTimeAlone) {
  Functions table = gl();
  table.DrawArraysInstanced = [](GLenum, GLint, GLsizei, GLsizei) { fake_now += points_ns; };
  table.DrawElementsInstanced = [](GLenum, GLsizei, GLenum, const void*, GLsizei) { fake_now += triangles_ns; };
  table.QueryCounter = [](GLuint query, GLenum target) {
    fake_stamps[query] = fake_now;
    real->QueryCounter(query, target);
  };
  table.GetQueryObjectui64v = [](GLuint query, GLenum, GLuint64* value) { *value = fake_stamps[query]; };
  const auto result = [&](std::uint64_t points, std::uint64_t triangles, bool software) {
    points_ns = points;
    triangles_ns = triangles;
    Capabilities has = context->capabilities();
    has.software = software;
    has.max_storage_block_bytes = 0;
    return run_driver_test(table, has)[DriverCheck::kGeometryStage];
  };
  EXPECT_EQ(result(1000, 1000, false), CheckResult::kPassed);
  EXPECT_EQ(result(1400, 1000, false), CheckResult::kPassed);
  EXPECT_EQ(result(1600, 1000, false), CheckResult::kFailed);
  EXPECT_EQ(result(1600, 0, false), CheckResult::kNotRun) << "the clock stands still";
  EXPECT_EQ(result(0, 1000, false), CheckResult::kNotRun);
  EXPECT_EQ(result(1600, 1000, true), CheckResult::kNotRun);
}

/// A driver that cannot make objects or programs is not judged, and keeps no error.
TEST_F(DriverTestTest, WhatCannotBeTriedIsNotRun) {
  Functions table = gl();
  table.LinkProgram = [](GLuint) {};
  const DriverTest test = run_driver_test(table, context->capabilities());
  for (std::size_t i = 0; i < kDriverCheckCount; ++i)
    if (DriverCheck(i) != DriverCheck::kTimer) {
      EXPECT_EQ(test.results[i], CheckResult::kNotRun) << name_of(DriverCheck(i));
    }
}

TEST_F(DriverTestTest, IsRememberedWithThePrograms) {
  const auto folder = std::filesystem::temp_directory_path() / ("driver_test_" + std::to_string(::getpid()));
  {
    auto without_memory = Context::create_offscreen();
    ASSERT_TRUE(without_memory);
    const_cast<Functions&>(without_memory->functions()).CreateTextures = [](GLenum, GLsizei, GLuint* names) { *names = 0; };
    without_memory->cache_programs(folder);
    without_memory->test_driver();
  }
  ASSERT_TRUE(context->make_current());
  context->cache_programs(folder);
  context->test_driver();
  EXPECT_FALSE(context->driver_test().remembered);
  if (gl().program_cache->enabled()) {
    auto other = Context::create_offscreen();
    ASSERT_TRUE(other);
    other->cache_programs(folder);
    other->test_driver();
    EXPECT_TRUE(other->driver_test().remembered);
    EXPECT_EQ(other->driver_test().results, context->driver_test().results);
    ASSERT_TRUE(context->make_current());
  }
  std::filesystem::remove_all(folder);
}

TEST_F(DriverTestTest, SwitchesOfTheContextAndOfTheUserCount) {
  const auto made = [](const char* option) { return Context::create_offscreen({.workarounds = option}); };
  const tests::Variable switches("SIGHTLINE_GL_WORKAROUNDS", "no-indirect-count=on,no-timer=on");
  auto both = made("four-samples=on,no-timer=off");
  switches.set("nonsense");
  const auto refused = made("");
  switches.set(std::nullopt);
  const auto wrong = made("four-samples");
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_FALSE(both->capabilities().indirect_count);
  EXPECT_EQ(both->functions().MultiDrawElementsIndirectCountARB, nullptr);
  EXPECT_LE(both->capabilities().max_samples, 4);
  EXPECT_TRUE(both->functions().workarounds[Workaround::kNoTimer]) << "the environment counts for every context";
  EXPECT_FALSE(both->functions().workarounds[Workaround::kPlainDepth]);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("SIGHTLINE_GL_WORKAROUNDS"), std::string::npos) << refused.error().message;
  EXPECT_FALSE(wrong);
  ASSERT_TRUE(context->make_current());
}

}  // namespace
}  // namespace sightline::gl::driver_test_test
