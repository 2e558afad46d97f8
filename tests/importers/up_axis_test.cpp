// Which axis points up in files that do not say: by a comment, by what the meshes stand on, or by the caller.
#include "sightline/importers/internal/up_axis.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "sightline/importers/obj/obj_writer.h"

namespace sightline::importers::up_axis_test {
namespace {

namespace fs = std::filesystem;
using core::dvec3;

/// A pyramid of height 2 that stands on a square of side 1 in the plane y = 0.
const std::string kPoints = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0.5 2 0.5\n";
const std::string kFaces = "f 1 2 3 4\nf 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5\n";
const std::string kPly =
    "element vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement face 5\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 0 1\n0 0 1\n0.5 2 0.5\n"
    "4 0 1 2 3\n3 1 0 4\n3 2 1 4\n3 3 2 4\n3 0 3 4\n";

class UpAxisOfFiles : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("sightline_up_axis_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return (folder_ / name).string();
  }
  /// Bounds are rounded outwards.
  static dvec3 rounded(const dvec3& size) { return glm::round(1e6 * size) / 1e6; }
  /// The model's height, and whether the import told that it turned the file.
  struct Read {
    double height = 0.0;
    bool told = false;
    friend bool operator==(const Read&, const Read&) = default;
  };
  static Read read(const std::string& file, const ImportOptions& options = {}) {
    core::Scene scene;
    const fs::path path = file;
    const auto report = import_files(std::span(&path, 1), scene, scene.root(), options);
    EXPECT_TRUE(report) << report.error().message;
    if (!report) return {};
    const auto& warnings = report->warnings;
    const bool told = std::any_of(warnings.begin(), warnings.end(),
                                  [](const ImportWarning& warning) { return warning.message == kSeemsYUp; });
    return {rounded(scene.bounds(scene.root()).size()).z, told};
  }

  fs::path folder_;
};

TEST_F(UpAxisOfFiles, IsYWhereMeshesStandOnIt) {
  const std::string standing = write("standing.obj", kPoints + kFaces);
  EXPECT_EQ(read(standing), (Read{2.0, true}));
  EXPECT_EQ(read(write("standing.ply", "ply\nformat ascii 1.0\n" + kPly)), (Read{2.0, true}));
  EXPECT_EQ(read(standing, {.up = UpAxis::kZ}), (Read{1.0, false}));
  EXPECT_EQ(read(standing, {.up = UpAxis::kY}), (Read{2.0, false}));
  EXPECT_EQ(read(standing, {.metres_per_unit = 0.5}), (Read{1.0, true}));
  EXPECT_EQ(read(write("lying.obj", "v 0 0 0\nv 0 1 0\nv 1 1 0\nv 1 0 0\nv 0.5 0.5 3\n" + kFaces)), (Read{3.0, false}));
  // Equal faces on opposite sides, as machine parts have them, say nothing.
  EXPECT_EQ(read(write("box.obj",
                       "v 0 0 0\nv 5 0 0\nv 5 2 0\nv 0 2 0\nv 2 0 1\nv 3 0 1\nv 3 2 1\nv 2 2 1\n"
                       "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n")),
            (Read{1.0, false}));
  EXPECT_EQ(read(write("sheet.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 3 4\n")), (Read{1.0, false}));
}

/// Else parts of one model would no longer fit together.
TEST_F(UpAxisOfFiles, IsTheSameOfFilesThatAreReadTogether) {
  const std::string faces = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  const fs::path standing = write("standing.obj", kPoints + kFaces),
                 again = write("again.ply", "ply\nformat ascii 1.0\n" + kPly),
                 box = write("box.obj",
                             "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n" + faces);
  const auto height = [](const std::vector<fs::path>& files) {
    core::Scene scene;
    const auto report = import_files(files, scene, scene.root(), {.metres_per_unit = 0.5});
    EXPECT_TRUE(report) << report.error().message;
    return rounded(scene.bounds(scene.root()).size()).z;
  };
  EXPECT_EQ(height({standing, again}), 1.0);
  EXPECT_EQ(height({standing, box}), 0.5);
  EXPECT_EQ(height({box, standing, again}), 0.5);
  EXPECT_EQ(height({box}), 0.5);
}

TEST_F(UpAxisOfFiles, TurnsBelowATurnedParent) {
  core::Scene scene;
  core::Affine turned;
  turned.linear = core::dmat3(0, 2, 0, 0, 0, 2, 2, 0, 0);
  const core::NodeId parent = scene.add_node(scene.root(), "turned", turned);
  ASSERT_TRUE(import_file(write("standing.obj", kPoints + kFaces), scene, parent));
  EXPECT_EQ(rounded(scene.bounds(scene.root()).size()), dvec3(4, 2, 2));
}

TEST_F(UpAxisOfFiles, IsThatOfAComment) {
  EXPECT_EQ(read(write("z.obj", "# made by hand\n# Z up\n" + kPoints + kFaces)), (Read{1.0, false}));
  EXPECT_EQ(read(write("y.obj", "# up axis: Y\nv 0 0 0\nv 0 1 0\nv 1 1 0\nv 1 0 0\nv 0.5 0.5 3\n" + kFaces)),
            (Read{1.0, false}));
  EXPECT_EQ(read(write("late.obj", kPoints + "# z up\n" + kFaces)), (Read{2.0, true})) << "no comment on the file";
  EXPECT_EQ(read(write("z.ply", "ply\nformat ascii 1.0\ncomment z-up\n" + kPly)), (Read{1.0, false}));
  EXPECT_EQ(read(write("both.obj", "# z up\n" + kPoints + kFaces), {.up = UpAxis::kY}), (Read{2.0, false}));
}

TEST_F(UpAxisOfFiles, IsThatOfTheSceneInWhatIsWritten) {
  core::Scene scene;
  ASSERT_TRUE(import_file(write("standing.obj", kPoints + kFaces), scene, scene.root(), {.up = UpAxis::kZ}));
  ASSERT_TRUE(write_obj(scene, scene.root(), folder_ / "written.obj"));
  EXPECT_EQ(read((folder_ / "written.obj").string()), (Read{1.0, false}));
}

TEST_F(UpAxisOfFiles, IsTheSameFromASceneCache) {
  const std::string standing = write("standing.obj", kPoints + kFaces);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(read(standing, {.cache_folder = folder_ / "caches"}), (Read{2.0, true}));
    EXPECT_EQ(read(standing, {.up = UpAxis::kZ, .cache_folder = folder_ / "caches"}), (Read{1.0, false}));
  }
}

TEST(UpAxisInComments, ComesInManyWords) {
  for (const char* text :
       {"z up", "# Z-up, metres", "up: z", "Up Axis = +Z", "axis: Z_UP", "the z axis is up", "UpAxis Z"})
    EXPECT_EQ(up_axis_in_comment(text), UpAxis::kZ) << text;
  for (const char* text : {"y up", "Y_UP", "up=y", "up axis is Y"})
    EXPECT_EQ(up_axis_in_comment(text), UpAxis::kY) << text;
  for (const char* text : {"", "up", "x up", "fuzzy upper", "made by Y", "backup zone", "z", "up zebra"})
    EXPECT_FALSE(up_axis_in_comment(text)) << text;
}

}  // namespace
}  // namespace sightline::importers::up_axis_test
