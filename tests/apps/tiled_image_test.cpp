// Frames of camera paths at a constant rate (apps/common/tiled_image.h). That tiles join is tested with the engine.
#include "sightline/apps/common/tiled_image.h"

#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

namespace sightline::apps::tiled_image_test {
namespace {

core::CameraPath lasting(double seconds) {
  const core::Pose here{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, there{{1, 0, 0}, {1, 1, 0}, {0, 0, 1}};
  if (seconds == 0.0) return *core::CameraPath::create({{5.0, here, 1.0}});
  return *core::CameraPath::create({{5.0, here, 1.0}, {5.0 + seconds, there, 1.0}});
}

TEST(PathFrames, CoverThePathInItsOwnTime) {
  struct Case {
    double seconds, per_second;
    int count;
  };
  for (const Case& c : {Case{4.0, 25.0, 101},
                        {4.0, 0.25, 2},
                        {4.0, 0.2, 1},
                        {0.1, 30.0, 4},
                        {0.0, 25.0, 1},
                        {0.099, 30.0, 3},
                        {10.0, 29.97, 300}}) {
    SCOPED_TRACE(testing::Message() << c.seconds << " s at " << c.per_second);
    const auto frames = PathFrames::create(lasting(c.seconds), c.per_second);
    ASSERT_TRUE(frames) << frames.error().message;
    EXPECT_EQ(frames->count(), c.count);
    EXPECT_EQ(frames->time(0), 5.0);
    EXPECT_LE(frames->time(frames->count() - 1), 5.0 + c.seconds * (1 + 1e-9));
    EXPECT_GT(frames->time(frames->count()), 5.0 + c.seconds);
  }
  EXPECT_EQ(PathFrames::file_name(0), "frame-000001.png");
  EXPECT_EQ(PathFrames::file_name(PathFrames::kMost - 1), "frame-999999.png");
}

TEST(PathFrames, RefuseRatesThatMakeNoSense) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double rate : {0.0, -25.0, 1000.5, infinity, -infinity, std::nan("")})
    EXPECT_FALSE(PathFrames::create(lasting(1.0), rate)) << rate;
  const auto many = PathFrames::create(lasting(1e5), 25.0);
  ASSERT_FALSE(many);
  EXPECT_NE(many.error().message.find("more than 999999 frames"), std::string::npos) << many.error().message;
}

TEST(PathFrames, TakeOnlyAnEmptyFolder) {
  namespace fs = std::filesystem;
  const fs::path base = fs::path(testing::TempDir()) / "sightline_frames";
  fs::remove_all(base);
  EXPECT_TRUE(take_empty_folder((base / "a" / "b").string())) << "made where it is missing";
  EXPECT_TRUE(take_empty_folder((base / "a" / "b").string()));
  const auto used = take_empty_folder((base / "a").string());
  ASSERT_FALSE(used);
  EXPECT_NE(used.error().message.find("is not empty"), std::string::npos) << used.error().message;
  std::ofstream(base / "file") << "text";
  EXPECT_FALSE(take_empty_folder((base / "file").string()));
  EXPECT_FALSE(take_empty_folder((base / "file" / "below").string()));
  EXPECT_FALSE(take_empty_folder(""));
  fs::remove_all(base);
}

}  // namespace
}  // namespace sightline::apps::tiled_image_test
