// Runs the built tools as a user does: as child processes, on files in a fresh folder.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>
#if __has_include(<spawn.h>)
#include <cerrno>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
extern char** environ;
#endif

#include "sightline/core/internal/platform/process.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/tests/support/links.h"
#include "sightline/tests/support/places.h"

namespace sightline::tests {

namespace fs = std::filesystem;
using Args = std::vector<std::string>;
using Json = json::Value;

/// The exact bytes; empty when the file cannot be read.
inline std::string read_bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// How a child process ended: its exit code, or -1 when it was killed or could not be started.
struct Outcome {
  int code = -1;
  std::string out, err;

  std::vector<std::string> error_lines() const {
    std::istringstream in(err);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }
};

inline std::ostream& operator<<(std::ostream& to, const Outcome& outcome) {
  return to << "exit " << outcome.code << "\nstdout: " << outcome.out << "\nstderr: " << outcome.err;
}

/// Triangles in the text of STL, which every build reads.
inline std::string stl_text(const std::vector<std::array<std::array<int, 3>, 3>>& triangles) {
  std::string text = "solid\n";
  for (const auto& triangle : triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const auto& [x, y, z] : triangle)
      text += "vertex " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid\n";
}

/// Each test gets an empty folder, removed after it.
class ToolTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "-" + info->name() + "-" + std::to_string(getpid());
    std::replace(name.begin(), name.end(), '/', '-');
    folder_ = fs::path(testing::TempDir()) / ("sightline-" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override {
    std::error_code stays;  // Windows does not find what lies too deep
    fs::remove_all(folder_, stays);
  }

  std::string path(const std::string& name) const { return (folder_ / name).make_preferred().string(); }

  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return path(name);
  }

  /// A path below a regular file: no user can write there, root included.
  std::string unwritable(const std::string& name) const { return write("regular-file", "") + "/" + name; }

  /// Files, there or not, that no tool can read as models.
  Args bad_models() const {
    fs::create_directories(path("folder.rvm"));
    return {path("missing.rvm"),
            path("folder.rvm"),
            write("empty.rvm", ""),
            write("text.rvm", "this is no model\n"),
            write("zeros.rvm", std::string(4096, '\0')),
            write("empty.obj", ""),
            write("text.obj", "this is no model\n"),
            write("model.xyz", "this is no model\n"),
            path("missing"),
            unwritable("below-a-file.rvm")};
  }

#if __has_include(<spawn.h>)
  /// A child process that runs beside the test, and the files that it writes to.
  struct Child {
    pid_t pid = 0;
    std::string out, err;
  };

  /// `program` is searched in PATH unless it holds a slash. pid 0: it cannot be started.
  Child start_program(const std::string& program, const Args& args, const std::string& name = "") const {
    Child child{0, path(name + ".stdout"), path(name + ".stderr")};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    constexpr int kReplace = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, child.out.c_str(), kReplace, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, child.err.c_str(), kReplace, 0600);
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (const std::string& arg : args) argv.push_back(const_cast<char*>(arg.c_str()));
    argv.push_back(nullptr);
    if (posix_spawnp(&child.pid, program.c_str(), &actions, nullptr, argv.data(), environ) != 0) child.pid = 0;
    posix_spawn_file_actions_destroy(&actions);
    return child;
  }

  static Outcome wait_for(const Child& child) {
    int status = 0;
    while (waitpid(child.pid, &status, 0) < 0 && errno == EINTR) {
    }
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_bytes(child.out), read_bytes(child.err)};
  }

#endif

  /// `program` is searched in PATH unless it holds a slash.
  Outcome run_program(const std::string& program, const Args& args) const {
    using Process = core::platform::ChildProcess;
    Args command{program};
    command.insert(command.end(), args.begin(), args.end());
    const fs::path out = folder_ / ".stdout", err = folder_ / ".stderr";
    auto child = Process::start(command, {.output = out, .errors = err});
    if (!child) return {-1, "", program + " cannot be started"};
    const auto end = child->wait();
    const bool exited = end.kind == core::platform::ProcessEnd::Kind::kExited;
    return {exited ? end.code : -1, read_bytes(out), read_bytes(err)};
  }

  /// Where sightline-TOOL lies.
  static std::string program_of(const std::string& tool) {
    return in_bin("sightline-" + tool).string();
  }

  /// Runs sightline-TOOL.
  Outcome run(const std::string& tool, const Args& args) const {
    return run_program(program_of(tool), args);
  }

  /// Runs a tool that must succeed and parses the JSON that it writes to stdout, and nothing else.
  Json run_json(const std::string& tool, Args args) const {
    args.insert(args.end(), {"--json", "-"});
    const Outcome outcome = run(tool, args);
    EXPECT_EQ(outcome.code, 0) << outcome;
    auto parsed = json::parse(outcome.out);
    EXPECT_TRUE(parsed) << outcome;
    return std::move(parsed).value_or(Json());
  }

  /// A plant of so many items.
  std::string plant(int items, int seed = 1) const {
    std::string file = path("plant-" + std::to_string(items) + "-" + std::to_string(seed) + ".rvm");
    const Outcome outcome = run("generate", {file, "--items", std::to_string(items), "--seed", std::to_string(seed)});
    EXPECT_EQ(outcome.code, 0) << outcome;
    return file;
  }

  /// Bad input: exit 1 and one line on stderr that tells the tool and what is wrong. With `drawing`, drivers may have
  /// written lines of their own.
  void expect_failure(const std::string& tool, const Args& args, const std::string& named, bool drawing = false) const {
    expect_refused(tool, args, named, 1, drawing);
  }

  /// Bad usage: exit 2 and one line.
  void expect_usage_error(const std::string& tool, const Args& args, const std::string& named) const {
    expect_refused(tool, args, named, 2, false);
  }

 private:
  void expect_refused(const std::string& tool, const Args& args, const std::string& named, int code,
                      bool drawing) const {
    std::string command = "sightline-" + tool;
    for (const std::string& arg : args) command += " " + arg;
    SCOPED_TRACE(command);
    const Outcome outcome = run(tool, args);
    EXPECT_EQ(outcome.code, code) << outcome;
    std::vector<std::string> lines = outcome.error_lines();
    const std::string prefix = "sightline-" + tool + ": ";
    if (drawing) std::erase_if(lines, [&](const std::string& line) { return line.rfind(prefix, 0) != 0; });
    ASSERT_EQ(lines.size(), 1u) << outcome;
    EXPECT_EQ(lines[0].rfind(prefix, 0), 0u) << outcome;
    EXPECT_NE(lines[0].find(named), std::string::npos) << "expected the line to name " << named << "\n" << outcome;
    EXPECT_EQ(lines[0].find("exception"), std::string::npos) << outcome;
  }

  fs::path folder_;
};

inline std::vector<std::string> built_tools() {
  std::istringstream in(SIGHTLINE_TOOLS);
  std::vector<std::string> tools;
  for (std::string tool; in >> tool;) tools.push_back(tool);
  return tools;
}

inline bool is_built(const std::string& tool) {
  const auto tools = built_tools();
  return std::find(tools.begin(), tools.end(), tool) != tools.end();
}

/// The keys of an object, sorted.
inline std::vector<std::string> keys_of(const Json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

}  // namespace sightline::tests
