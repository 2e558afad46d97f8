// Names of files as people have them, and those that Windows keeps for devices; files that others hold open or protect.
#if __has_include(<share.h>)
#include <share.h>
#endif

#include "sightline/core/internal/platform/files.h"
#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests::file_names_test {
namespace {

class FileNames : public ToolTest {
 protected:
  /// Reads and writes a file of this name, beside the test's other files.
  void expect_usable(const std::string& name) const {
    SCOPED_TRACE(name);
    const fs::path file = core::platform::path_of(path(name) + ".rvm"),
                   copy = core::platform::path_of(path(name) + ".obj");
    fs::create_directories(file.parent_path());
    fs::copy_file(model_, file);
    EXPECT_EQ(run_json("replay", {path(name) + ".rvm", "--no-render", "--frames", "2"})["items"], 1000);
    const Outcome written = run("convert", {path(name) + ".rvm", path(name) + ".obj"});
    EXPECT_EQ(written.code, 0) << written;
    EXPECT_TRUE(fs::exists(copy));
  }
  void SetUp() override {
    ToolTest::SetUp();
    model_ = plant(1000);
  }
  std::string model_;
};

TEST_F(FileNames, OfAnyScriptAndLength) {
  for (const char* name : {"Übergrößenträger", "配管モデル", "Ρευστό/Труба", " spaces  within ", "a;b&c%d#e'f",
                           "dots..in.it", "-dash", "folder.rvm/model"})
    expect_usable(name);
  std::string deep = "deep";
  while (path(deep).size() < 280) deep += "/a folder of forty characters, or nearly";
  expect_usable(deep);
}

/// These stand for devices in every folder, whatever their ending. Nothing waits for what somebody types.
TEST_F(FileNames, OfDevicesAreNoModels) {
  if (!names_ignore_case()) GTEST_SKIP() << "names of files here";
  for (const char* name : {"NUL", "CON", "COM1", "NUL.rvm", "CON.rvm"}) {
    expect_failure("info", {name}, name);
    expect_failure("info", {model_, name}, name);
  }
}

/// What is not written leaves what was there.
TEST_F(FileNames, OfProtectedFilesAreToldOrReplaced) {
  const std::string kept = write("kept.obj", "kept");
  fs::permissions(kept, fs::perms::owner_read);
  const Outcome outcome = run("convert", {model_, kept});
  if (outcome.code != 0) {
    EXPECT_EQ(outcome.error_lines().size(), 1u) << outcome;
    EXPECT_NE(outcome.err.find("kept.obj"), std::string::npos) << outcome;
    EXPECT_EQ(read_bytes(kept), "kept");
  }
  fs::permissions(kept, fs::perms::owner_all);
}

#if __has_include(<share.h>)
/// As another program holds a file that it writes to.
TEST_F(FileNames, OfLockedFilesAreTold) {
  const std::string kept = write("kept.obj", "kept");
  for (const std::string& file : {model_, kept}) {
    std::FILE* const held = _fsopen(file.c_str(), "r+b", _SH_DENYRW);
    ASSERT_TRUE(held);
    if (file == model_)
      expect_failure("info", {file}, "plant-1000");
    else
      expect_failure("convert", {model_, file}, "kept.obj");
    std::fclose(held);
  }
  EXPECT_EQ(read_bytes(kept), "kept");
}
#endif

}  // namespace
}  // namespace sightline::tests::file_names_test
