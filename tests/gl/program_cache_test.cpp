// Programs that are kept on disk: what is linked from there does what its source says, and whatever is wrong with a
// file or folder, programs are made.
#include "sightline/gl/internal/program_cache.h"

#include <fstream>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/program.h"
#include "sightline/tests/gl/test_shaders.h"
#include "sightline/tests/support/environment.h"
#include "sightline/tests/support/full_disk.h"
#include "sightline/tests/support/gl_test.h"
#include "sightline/tests/support/system_gl.h"

namespace sightline::gl::program_cache_test {
namespace {

namespace fs = std::filesystem;

/// Mesa has program binaries only where it has a cache of its own, and it looks when the first context is made.
const bool kMesaCache = [] {
  core::platform::set_environment("MESA_SHADER_CACHE_DISABLE", "false");
  return true;
}();

ProgramDescription square(const std::string& define = {}) {
  ProgramDescription description;
  description.name = "square";
  description.stages = {{GL_COMPUTE_SHADER, {"square.comp"}}};
  description.shaders.tables = {tests::shaders()};
  if (!define.empty()) description.shaders.defines = {define};
  return description;
}

ProgramDescription multiply(int factor) {
  ProgramDescription description;
  description.name = "multiply";
  description.stages = {{GL_VERTEX_SHADER, {"double.vert"}}};
  description.shaders.tables = {tests::shaders()};
  description.shaders.defines = {"FACTOR " + std::to_string(factor) + "u"};
  description.feedback_varyings = {"v_doubled"};
  return description;
}

class ProgramCacheTest : public tests::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!context) return;
    fs::remove_all(folder);
    if (!ProgramCache(gl(), folder).enabled()) GTEST_SKIP() << "the driver has no program binaries";
    context->cache_programs(folder);
    real = gl();
    table().CompileShader = [](GLuint shader) {
      ++compiled;
      real.CompileShader(shader);
    };
    compiled = 0;
  }
  void TearDown() override {
    GlTest::TearDown();
    fs::remove_all(root);
  }
  Functions& table() { return const_cast<Functions&>(gl()); }

  /// How many shaders that compiles; checks what the program does.
  int make_square(const std::string& define = {}) {
    const int before = compiled;
    const auto program = Program::create(gl(), square(define));
    EXPECT_TRUE(program) << program.error().message;
    if (program) expect_squares(*program);
    return compiled - before;
  }
  void expect_squares(const Program& program) {
    std::vector<std::uint32_t> values(100);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::uint32_t(i);
    const auto input = Buffer::create(gl(), std::span(values), 0, "input");
    const auto output = Buffer::create(gl(), 4 * values.size(), nullptr, 0, "output");
    const auto view = TextureBuffer::create(gl(), *input, GL_R32UI, "view");
    program.use();
    gl().BindTextureUnit(0, view->id());
    gl().BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, output->id());
    gl().DispatchCompute(2, 1, 1);
    gl().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    std::vector<std::uint32_t> squares(values.size());
    output->read(0, output->size(), squares.data());
    for (std::size_t i = 0; i < squares.size(); ++i) ASSERT_EQ(squares[i], i * i);
  }

  static std::string read(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  static void write(const fs::path& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }
  static std::vector<fs::path> files() {
    std::vector<fs::path> found;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder, none)) found.push_back(entry.path());
    return found;
  }
  fs::path only_file() const {
    EXPECT_EQ(files().size(), 1u);
    return files().empty() ? fs::path() : files()[0];
  }

  static inline const fs::path root =
      fs::path(testing::TempDir()) / ("sightline-program-cache-" + std::to_string(getpid()));
  static inline const fs::path folder = root / "programs";
  static inline Functions real;
  static inline int compiled = 0;
};

TEST_F(ProgramCacheTest, WhatIsThereIsNotCompiled) {
  EXPECT_EQ(make_square(), 1);
  EXPECT_EQ(make_square(), 0);
  EXPECT_EQ(make_square("OTHER"), 1);
  EXPECT_EQ(make_square("OTHER"), 0);
  context->cache_programs({});
  EXPECT_EQ(make_square(), 1);
  EXPECT_EQ(files().size(), 2u);
  if (tests::kSystemPlatform != ContextPlatform::kWgl) {  // Windows has other rights
    EXPECT_EQ(fs::status(folder).permissions(), fs::perms::owner_all);
  }
}

TEST_F(ProgramCacheTest, KeepsFeedback) {
  std::vector<ProgramDescription> all{multiply(3), multiply(5), multiply(3)};
  all[2].feedback_varyings = {"gl_SkipComponents1", "v_doubled"};
  for (int round = 0; round < 2; ++round) {
    SCOPED_TRACE(round);
    const auto programs = Program::create_all(gl(), all);
    ASSERT_TRUE(programs) << programs.error().message;
    EXPECT_EQ(compiled, 3);
    for (std::size_t i = 0; i < all.size(); ++i) {
      GLint varyings = 0;
      gl().GetProgramiv((*programs)[i].id(), GL_TRANSFORM_FEEDBACK_VARYINGS, &varyings);
      EXPECT_EQ(varyings, int(all[i].feedback_varyings.size()));
    }
  }
  EXPECT_EQ(files().size(), 3u);
}

TEST_F(ProgramCacheTest, DamagedEntriesAreWrittenAnew) {
  EXPECT_EQ(make_square(), 1);
  const fs::path file = only_file();
  const std::string whole = read(file);
  const auto expect_mended = [&](const std::string& bytes) {
    write(file, bytes);
    EXPECT_EQ(make_square(), 1);
    EXPECT_EQ(make_square(), 0);
    EXPECT_EQ(files().size(), 1u);
  };
  for (std::size_t length = 0; length < whole.size(); length += 1 + length / 3) {
    SCOPED_TRACE(testing::Message() << length << " of " << whole.size() << " bytes");
    expect_mended(whole.substr(0, length));
  }
  expect_mended(whole + "x");
  expect_mended(std::string(whole.size(), '\xff'));
  for (std::size_t place = 0; place < whole.size(); place += 1 + place / 3) {
    SCOPED_TRACE(testing::Message() << "byte " << place);
    std::string other = whole;
    other[place] = char(other[place] ^ 0x10);
    expect_mended(other);
  }
}

TEST_F(ProgramCacheTest, EntriesOfOthersAreNotTaken) {
  EXPECT_EQ(make_square("FIRST"), 1);
  const fs::path first = only_file();
  const std::string bytes = read(first);
  fs::remove(first);
  EXPECT_EQ(make_square("SECOND"), 1);
  write(only_file(), bytes);  // as if both had one hash
  EXPECT_EQ(make_square("SECOND"), 1);
  EXPECT_EQ(make_square("SECOND"), 0);

  table().GetString = [](GLenum name) {
    return name == GL_VERSION ? reinterpret_cast<const GLubyte*>("4.5 another") : real.GetString(name);
  };
  context->cache_programs(folder);
  EXPECT_EQ(make_square("SECOND"), 1);
  EXPECT_EQ(make_square("SECOND"), 0);
}

TEST_F(ProgramCacheTest, WhatTheDriverRefusesIsCompiled) {
  EXPECT_EQ(make_square(), 1);
  table().ProgramBinary = [](GLuint, GLenum, const void*, GLsizei) {};
  EXPECT_EQ(make_square(), 1);
  table().ProgramBinary = real.ProgramBinary;
  EXPECT_EQ(make_square(), 0);
  // A format that the driver does not list would be an error.
  table().GetIntegerv = [](GLenum name, GLint* values) {
    real.GetIntegerv(name, values);
    if (name == GL_PROGRAM_BINARY_FORMATS) values[0] ^= 1;
  };
  context->cache_programs(folder);
  EXPECT_EQ(make_square(), 1);
}

TEST_F(ProgramCacheTest, DriversWithoutBinariesKeepNothing) {
  table().GetIntegerv = [](GLenum name, GLint* values) {
    real.GetIntegerv(name, values);
    if (name == GL_NUM_PROGRAM_BINARY_FORMATS) values[0] = 0;
  };
  context->cache_programs(folder);
  EXPECT_EQ(make_square(), 1);
  EXPECT_EQ(make_square(), 1);
  EXPECT_FALSE(fs::exists(folder));
}

TEST_F(ProgramCacheTest, WorksWhereNothingCanBeWritten) {
  fs::create_directories(folder);
  write(folder / "file", "");
  context->cache_programs(folder / "file" / "below");
  EXPECT_EQ(make_square(), 1);
  context->cache_programs(folder / "file");
  EXPECT_EQ(make_square(), 1);
  EXPECT_EQ(files().size(), 1u);
  EXPECT_EQ(fs::file_size(folder / "file"), 0u);
}

#ifdef SIGHTLINE_HAS_FULL_DISK
TEST_F(ProgramCacheTest, AFullDiskTakesNoPartOfAnEntry) {
  {
    const tests::FullDisk full(100);
    EXPECT_EQ(make_square(), 1);
  }
  EXPECT_EQ(files().size(), 0u);
  EXPECT_EQ(make_square(), 1);
  EXPECT_EQ(make_square(), 0);
}
#endif

TEST_F(ProgramCacheTest, TheOldestGoWhenThereIsNoRoom) {
  EXPECT_EQ(make_square("A0"), 1);
  const std::uintmax_t bytes = fs::file_size(only_file());
  const ProgramCache cache(gl(), folder, 3 * bytes + bytes / 2);
  table().program_cache = &cache;
  const auto age_the_new = [&](int hours) {  // as if they had been used so long ago
    const auto now = fs::file_time_type::clock::now();
    for (const fs::path& file : files())
      if (fs::last_write_time(file) > now - std::chrono::hours(1))
        fs::last_write_time(file, now - std::chrono::hours(hours));
  };
  age_the_new(9);
  EXPECT_EQ(make_square("A1"), 1);
  age_the_new(8);
  EXPECT_EQ(make_square("A2"), 1);
  age_the_new(7);
  write(folder / "not-ours", std::string(4 * bytes, 'x'));
  EXPECT_EQ(make_square("A0"), 0);  // which makes A1 the oldest
  EXPECT_EQ(make_square("A3"), 1);
  EXPECT_EQ(files().size(), 4u);
  EXPECT_EQ(make_square("A0"), 0);
  EXPECT_EQ(make_square("A3"), 0);
  EXPECT_EQ(make_square("A1"), 1);
  EXPECT_EQ(make_square("A2"), 1) << "dropped for A1";
  EXPECT_TRUE(fs::exists(folder / "not-ours"));
  table().program_cache = nullptr;
}

/// Some drivers forget what shaders declare when they load a binary.
TEST_F(ProgramCacheTest, BindingsAreSetAgain) {
  EXPECT_EQ(make_square(), 1);
  Functions forgetful = gl();
  forgetful.ProgramBinary = [](GLuint program, GLenum format, const void* binary, GLsizei bytes) {
    real.ProgramBinary(program, format, binary, bytes);
    real.ShaderStorageBlockBinding(program, real.GetProgramResourceIndex(program, GL_SHADER_STORAGE_BLOCK, "Output"),
                                   5);
  };
  const auto program = Program::create(forgetful, square());
  ASSERT_TRUE(program) << program.error().message;
  const GLenum what = GL_BUFFER_BINDING;
  GLint binding = -1;
  const GLuint block = gl().GetProgramResourceIndex(program->id(), GL_SHADER_STORAGE_BLOCK, "Output");
  ASSERT_NE(block, GL_INVALID_INDEX);
  gl().GetProgramResourceiv(program->id(), GL_SHADER_STORAGE_BLOCK, block, 1, &what, 1, nullptr, &binding);
  EXPECT_EQ(binding, 0);
}

/// As processes do: each thread has a context of its own, and entries come and go.
TEST_F(ProgramCacheTest, SharesItsFolder) {
  const auto use = [](unsigned seed) {
    auto own = Context::create_offscreen();
    ASSERT_TRUE(own);
    own->cache_programs(folder);
    for (unsigned i = 0; i < 40; ++i) {
      const auto program = Program::create(own->functions(), square("A" + std::to_string(i % 4)));
      EXPECT_TRUE(program) << program.error().message;
      if (i % 5 == seed)
        for (const fs::path& file : files()) {
          std::error_code gone;
          fs::remove(file, gone);
        }
    }
  };
  std::thread other(use, 1u);
  use(2u);
  other.join();
  ASSERT_TRUE(context->make_current());
  for (const char* define : {"A0", "A1", "A2", "A3"}) {
    make_square(define);
    EXPECT_EQ(make_square(define), 0);
  }
  EXPECT_EQ(files().size(), 4u);
}

TEST(ProgramCacheFolder, IsTheUsersCacheFolder) {
  const fs::path a = fs::temp_directory_path() / "a", b = fs::temp_directory_path() / "b";
  const tests::Variable cache("XDG_CACHE_HOME", a.string()), home("HOME", b.string()),
      windows("LOCALAPPDATA", (b / ".cache").string());
  EXPECT_EQ(ProgramCache::default_folder(), a / "sightline");
  cache.set("relative");
  EXPECT_EQ(ProgramCache::default_folder(), b / ".cache/sightline");
  for (const tests::Variable* variable : {&cache, &home, &windows}) variable->set(std::nullopt);
  EXPECT_EQ(ProgramCache::default_folder(), "");
}

}  // namespace
}  // namespace sightline::gl::program_cache_test
