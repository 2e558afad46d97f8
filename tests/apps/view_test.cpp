// sightline-view in a window of a virtual display: pictures, keys, sizes. Skipped without Xvfb; keys without xdotool.
#include <array>
#include <csignal>
#include <optional>

#include <png.h>

#include "sightline/tests/apps/window_test.h"

namespace sightline::tests {
namespace {

/// 8-bit RGB, rows top to bottom.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

void write_png(const Picture& picture, const std::string& file) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = png_uint_32(picture.width);
  header.height = png_uint_32(picture.height);
  header.format = PNG_FORMAT_RGB;
  EXPECT_TRUE(png_image_write_to_file(&header, file.c_str(), 0, picture.rgb.data(), 0, nullptr)) << header.message;
}

/// The upper left corner of a screen that Xvfb keeps as a file: an X window dump (XWDFile.h, version 7) of 32 bits per
/// pixel, blue first.
Picture read_screen(const std::string& file, int width, int height) {
  const std::string bytes = read_bytes(file);
  const auto word = [&](std::size_t index) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | std::uint8_t(bytes.at(4 * index + i));
    return std::size_t(value);
  };
  constexpr std::size_t kHeaderBytes = 0, kBytesPerLine = 12, kColours = 19, kBytesPerColour = 12;
  const std::size_t first = word(kHeaderBytes) + kBytesPerColour * word(kColours);
  Picture picture{width, height, {}};
  for (std::size_t y = 0; y < std::size_t(height); ++y)
    for (std::size_t x = 0; x < std::size_t(width); ++x)
      for (const std::size_t channel : {2, 1, 0})
        picture.rgb.push_back(std::uint8_t(bytes.at(first + y * word(kBytesPerLine) + 4 * x + channel)));
  return picture;
}

class View : public WindowTest {
 protected:
  /// sightline-view must succeed.
  Outcome view(const Args& args) const {
    Outcome outcome = run("view", args);
    EXPECT_EQ(outcome.code, 0) << outcome;
    return outcome;
  }
  /// The window's part of the screen, the window being the only one there.
  std::string screen(int width, int height) const {
    std::string file = path("screen.png");
    write_png(read_screen(path("Xvfb_screen0"), width, height), file);
    return file;
  }
  /// Other drivers make the same picture but for a few pixels on edges.
  Outcome compare(const std::string& picture, Args render_args) const {
    render_args.insert(render_args.end(), {"--compare", picture, "--max", "255", "--mean", "0.05"});
    return run("render", render_args);
  }
};

/// Items against the sky: without them the picture would be of one colour.
void expect_not_empty(const std::string& file) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&header, file.c_str())) << header.message;
  header.format = PNG_FORMAT_GRAY;
  std::string grey(PNG_IMAGE_SIZE(header), '\0');
  ASSERT_TRUE(png_image_finish_read(&header, nullptr, grey.data(), 0, nullptr)) << header.message;
  EXPECT_GT(std::count_if(grey.begin(), grey.end(), [&](char c) { return c != grey[0]; }), std::ptrdiff_t(100));
}

TEST_F(View, DrawsWhatRenderDraws) {
  const std::string model = plant(12000), shot = path("shot.png");
  for (const char* culler : {"auto", "linear", "gpu", "hybrid"}) {
    SCOPED_TRACE(culler);
    const Json figures =
        run_json("view", {model, "--size", "320x200", "--frames", "6", "--culler", culler, "--screenshot", shot});
    EXPECT_EQ(figures["frames"], 6);
    EXPECT_EQ(figures["size"], Json::array({320, 200}));
    EXPECT_EQ(figures["items"], 12000);
    EXPECT_GT(figures["visible"], 11000);
    expect_not_empty(shot);
    const Outcome same = compare(shot, {model, "--size", "320x200"});
    EXPECT_EQ(same.code, 0) << same;
  }
}

TEST_F(View, PlaysAPath) {
  const std::string model = plant(3000), shot = path("shot.png"), tour = path("tour.json");
  ASSERT_EQ(run("replay", {model, "--no-render", "--frames", "2", "--save-path", tour}).code, 0);
  for (const Args& moved : {Args{}, Args{"--translate", "3e6,7e6,1e3"}}) {
    Args args = {model, "--size", "200x200", "--path", tour, "--frames", "4", "--screenshot", shot};
    args.insert(args.end(), moved.begin(), moved.end());
    view(args);
    expect_not_empty(shot);
    Args last = {model, "--size", "200x200", "--path", tour, "--frames", "4", "--frame", "3"};
    last.insert(last.end(), moved.begin(), moved.end());
    const Outcome same = compare(shot, last);
    EXPECT_EQ(same.code, 0) << same;
  }
}

TEST_F(View, RefusesWhatItCannotDo) {
  const std::string model = plant(1000);
  expect_usage_error("view", {model, "--frames", "0"}, "--frames");
  expect_usage_error("view", {model, "--size", "0x3"}, "--size");
  expect_failure("view", {model, "--path", path("missing.json")}, "missing.json");
  expect_failure("view", {model, "--frames", "1", "--screenshot", unwritable("a.png")}, "a.png", true);
  for (const char* display : {"", ":54321"}) {
    setenv("DISPLAY", display, 1);
    expect_failure("view", {model, "--frames", "1"}, "no window can be opened");
  }
  unsetenv("DISPLAY");
  expect_failure("view", {model, "--frames", "1"}, "no window can be opened");
}

/// A window that stays open, and somebody at its keyboard.
class ViewKeys : public View {
 protected:
  void SetUp() override {
    View::SetUp();
    if (!IsSkipped() && !HasFatalFailure()) need("xdotool", {"version"});
  }
  void TearDown() override {
    if (child_.pid != 0) {
      kill(child_.pid, SIGTERM);
      wait_for(child_);
    }
    View::TearDown();
  }

  void open(const Args& args) {
    child_ = start_program(program_of("view"), args, "view");
    ASSERT_TRUE(comes_true([&] {
      const Outcome found = xdotool({"search", "--name", "items visible"});
      window_ = found.out.substr(0, found.out.find('\n'));
      return !window_.empty();
    })) << read_bytes(child_.err);
    ASSERT_EQ(xdotool({"windowfocus", "--sync", window_}).code, 0);
  }
  Outcome xdotool(const Args& args) const { return run_program("xdotool", args); }
  void press(const std::string& key) const { EXPECT_EQ(xdotool({"key", key}).code, 0); }
  /// Waits for the title to hold `text`, or no longer to hold it; not for a window that is gone.
  testing::AssertionResult title_comes_to(const std::string& text, bool holds = true) const {
    Outcome title;
    comes_true([&] {
      title = xdotool({"getwindowname", window_});
      return title.code != 0 || (title.out.find(text) != std::string::npos) == holds;
    });
    if (title.code == 0 && (title.out.find(text) != std::string::npos) == holds) return testing::AssertionSuccess();
    return testing::AssertionFailure() << title << "does not" << (holds ? "" : " cease to") << " hold " << text << "; "
                                       << read_bytes(child_.err);
  }
  /// Of the window's part of the screen.
  int magenta_pixels(int width, int height) const {
    const Picture picture = read_screen(path("Xvfb_screen0"), width, height);
    int count = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
      const int red = picture.rgb[i], green = picture.rgb[i + 1], blue = picture.rgb[i + 2];
      count += red > 60 && 5 * green < 2 * blue && 5 * blue > 2 * red && red > blue;
    }
    return count;
  }
  Outcome close() {
    press("Escape");
    Outcome outcome = wait_for(child_);
    child_.pid = 0;
    return outcome;
  }

  Child child_;
  std::string window_;
};

TEST_F(ViewKeys, TheWindowShowsThePictureAtAnySize) {
  const std::string model = plant(3000), figures = path("figures.json");
  open({model, "--size", "320x200", "--json", figures});
  for (const std::array<int, 2>& wanted : {std::array{320, 200}, {200, 300}, {500, 400}}) {
    const int width = wanted[0], height = wanted[1];
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    SCOPED_TRACE(size);
    ASSERT_EQ(xdotool({"windowsize", window_, std::to_string(width), std::to_string(height)}).code, 0);
    press("f");
    Outcome same;
    ASSERT_TRUE(comes_true([&] {
      same = compare(screen(width, height), {model, "--size", size});
      return same.code == 0;
    })) << same;
  }
  EXPECT_EQ(close().code, 0);
  EXPECT_EQ(Json::parse(read_bytes(figures), nullptr, false)["size"], Json::array({500, 400}));
}

TEST_F(ViewKeys, KeysDoWhatTheHelpSays) {
  const std::string model = plant(12000), saved = path("walk.json");
  open({model, "--size", "200x150", "--save-path", saved});
  press("2");
  ASSERT_TRUE(title_comes_to("gpu: gpu"));
  press("3");
  ASSERT_TRUE(title_comes_to("hybrid: "));
  press("1");
  ASSERT_TRUE(title_comes_to("cpu: cpu"));
  press("space");
  ASSERT_TRUE(title_comes_to("frozen"));
  press("o");
  ASSERT_TRUE(title_comes_to("orbit"));
  press("r");
  ASSERT_TRUE(title_comes_to("recording"));
  xdotool({"keydown", "w"});
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  xdotool({"keyup", "w"});
  EXPECT_TRUE(comes_true([&] { return magenta_pixels(200, 150) > 0; })) << "what the frozen camera sees nothing of";
  press("r");
  ASSERT_TRUE(title_comes_to("recording", false));
  press("c");
  ASSERT_TRUE(title_comes_to("frozen", false));
  EXPECT_TRUE(comes_true([&] { return magenta_pixels(200, 150) == 0; }));
  press("h");
  const Outcome outcome = close();
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_NE(outcome.out.find("W A S D"), std::string::npos) << outcome;
  EXPECT_NE(outcome.out.find("path: " + saved), std::string::npos) << outcome;

  const Json walk = Json::parse(read_bytes(saved), nullptr, false);
  ASSERT_TRUE(walk.is_object());
  ASSERT_GE(walk["keys"].size(), 2u);
  EXPECT_EQ(walk["keys"].front()["t"], 0.0);
  EXPECT_NE(walk["keys"].front()["eye"], walk["keys"].back()["eye"]);
  EXPECT_EQ(run("replay", {model, "--no-render", "--frames", "3", "--path", saved}).code, 0);
}

}  // namespace
}  // namespace sightline::tests
