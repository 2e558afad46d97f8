// Models written in the background, read back.
#include "sightline/apps/view/model_export.h"

#include <filesystem>
#include <fstream>
#include <future>

#include <gtest/gtest.h>

#include "sightline/apps/common/tree_walk.h"
#include "sightline/importers/import.h"
#include "sightline/tests/support/links.h"

namespace sightline::apps::model_export_test {
namespace {

namespace fs = std::filesystem;

/// Groups of boxes in a row, "part0" and so on: each group a primitive and a mesh.
Model row_of_parts(int count, const std::string& file, int first = 0) {
  Model model;
  model.scene = std::make_unique<core::Scene>();
  core::Scene& scene = *model.scene;
  model.report.nodes = {scene.add_node(scene.root(), file)};
  core::Mesh triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
  triangle.indices = {0, 1, 2};
  const core::MeshId mesh = scene.add_mesh(triangle).value();
  const core::MaterialId red = scene.add_material({"red", {1, 0, 0}, 1.0f, 2});
  for (int i = first; i < first + count; ++i) {
    const auto node = scene.add_node(model.report.nodes[0], "part" + std::to_string(i), core::translation({i, 0, 0}));
    scene.set_material(node, red);
    scene.add_primitive(node, core::Box{0.5f, 0.5f, 0.5f + 0.001f * float(i)});
    scene.add_mesh_instance(node, mesh);
  }
  EXPECT_TRUE(scene.commit());
  return model;
}

class ModelExportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::path(testing::TempDir()) /
             ("model_export_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
  std::string path(const std::string& name) const { return (folder / name).string(); }

  void open(Model model) { session = std::move(*Session::open(std::move(model), {})); }
  void select(const std::vector<int>& parts) {
    std::vector<core::ItemId> items;
    for (const int part : parts) {
      items.push_back(core::ItemId(2 * part));
      items.push_back(core::ItemId(2 * part + 1));
    }
    ASSERT_TRUE(session->document.select(items));
  }
  static core::Expected<std::string> written(core::Expected<ModelExport::Job> job) {
    if (!job) return tl::unexpected(job.error());
    std::promise<void> ready;
    ModelExport running(std::move(*job), [&] { ready.set_value(); });
    ready.get_future().wait();
    auto done = running.take();
    EXPECT_TRUE(done);
    EXPECT_FALSE(running.take()) << "only once";
    return std::move(*done);
  }
  core::Expected<ModelExport::Job> model(const std::string& file) const { return ModelExport::model(*session, file); }
  core::Expected<ModelExport::Job> selection(const std::string& file) const {
    return ModelExport::selection(*session, file);
  }
  /// Names of nodes with items, and the bounds of all.
  static std::pair<std::vector<std::string>, core::AabbD> read(const std::string& file) {
    core::Scene scene;
    EXPECT_TRUE(importers::import_file(file, scene, scene.root())) << file;
    std::vector<std::string> names;
    scene.for_each_node(scene.root(), [&](core::NodeId node, const auto&...) {
      if (scene.first_item(node) != core::kNoItem) names.emplace_back(scene.name(node));
    });
    return {names, scene.bounds(scene.root())};
  }

  fs::path folder;
  std::unique_ptr<Session> session;
};

TEST_F(ModelExportTest, HiddenItemsAreWrittenAndOthersThanTheSelectedAreNot) {
  open(row_of_parts(5, "row.rvm"));
  select({0});
  ASSERT_TRUE(session->document.hide(session->document.selection()));
  select({1, 3});
  for (const std::string extension : {".rvm", ".obj"}) {
    EXPECT_TRUE(written(model(path("all" + extension))));
    EXPECT_EQ(read(path("all" + extension)).first.size(), 5u) << extension;
    const auto words = written(selection(path("some" + extension)));
    ASSERT_TRUE(words);
    EXPECT_NE(words->find("some" + extension + ": 4 of 4 items, "), std::string::npos) << *words;
    const auto [names, bounds] = read(path("some" + extension));
    ASSERT_EQ(names.size(), 2u) << extension;
    EXPECT_NE(names[0].find("part1"), std::string::npos);
    EXPECT_NE(names[1].find("part3"), std::string::npos);
    EXPECT_NEAR(bounds.min.x, 0.75, 1e-5);
    EXPECT_NEAR(bounds.max.x, 4.0, 1e-5) << "the triangle's end";
  }
}

/// As all that the viewer tells of places.
TEST_F(ModelExportTest, AMovedModelIsWrittenInItsOwnFrame) {
  Model moved = row_of_parts(2, "row.rvm");
  moved.scene->set_transform(moved.scene->root(), core::translation({1000, 0, 0}));
  ASSERT_TRUE(moved.scene->commit());
  moved.offset = {1000, 0, 0};
  open(std::move(moved));
  ASSERT_TRUE(written(model(path("all.rvm"))));
  EXPECT_NEAR(read(path("all.rvm")).second.min.x, -0.25, 1e-5);
}

TEST_F(ModelExportTest, RemovedItemsOfAComparisonAreNotWritten) {
  open(row_of_parts(2, "row.rvm", 2));
  Model before = row_of_parts(4, "row.rvm");  // part0 and part1 are gone
  auto found = compare_models(before, session->model(), {});
  ASSERT_TRUE(found);
  ASSERT_TRUE(
      session->begin_comparison(std::make_unique<ChangeList>(path("old.rvm"), std::move(before), std::move(*found))));
  ASSERT_EQ(session->scene().item_count(), 8u);
  ASSERT_TRUE(session->document.select(apps::items_below(session->scene(), session->scene().root())));
  ASSERT_EQ(session->document.selection().size(), 8u);
  for (const auto& job : {model(path("all.rvm")), selection(path("all.rvm"))}) {
    ASSERT_TRUE(written(job));
    EXPECT_EQ(read(path("all.rvm")).first, (std::vector<std::string>{"part2", "part3"}));
  }
  std::ofstream(path("old.rvm")) << "older";
  EXPECT_FALSE(model(path("old.rvm"))) << "the older revision would be lost";
}

TEST_F(ModelExportTest, NoFileThatWasReadIsWrittenOver) {
  Model named = row_of_parts(2, "row.obj");
  named.report.side_files = {path("row.mtl")};
  open(std::move(named));
  session->files = {path("row.obj")};
  std::ofstream(path("row.obj")) << "model";
  std::ofstream(path("row.mtl")) << "materials";
  std::vector<std::string> names = {"row.obj", "row.vtk", "row"};
  if (tests::make_link(path("row.obj"), path("link.obj")) && tests::make_link(path("row.mtl"), path("other.mtl")))
    names.insert(names.end(), {"link.obj", "other.obj"});
  for (const std::string& name : names) {
    const auto job = model(path(name));
    ASSERT_FALSE(job) << name;
    EXPECT_NE(job.error().message.find(name.find(".obj") == std::string::npos ? "expected a name ending in"
                                                                              : "would be lost"),
              std::string::npos)
        << job.error().message;
  }
  EXPECT_TRUE(model(path("new.obj")));
}

/// What was there before stays.
TEST_F(ModelExportTest, ACancelledExportLeavesTheFileAlone) {
  open(row_of_parts(20000, "row.rvm"));
  std::optional<core::Expected<std::string>> done;
  for (int attempts = 0; attempts < 100 && (!done || *done); ++attempts) {  // it may be done before it is cancelled
    std::ofstream(path("all.glb")) << "before";
    std::promise<void> ready;
    ModelExport running(*model(path("all.glb")), [&] { ready.set_value(); });
    running.cancel();
    ready.get_future().wait();
    done = running.take();
  }
  ASSERT_TRUE(done && !*done);
  EXPECT_EQ(done->error().message, importers::kCancelled);
  EXPECT_EQ(fs::file_size(path("all.glb")), 6u);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1) << "no other file is left";
  const auto failed = written(model(path("no/such/folder/all.rvm")));
  ASSERT_FALSE(failed);
}

}  // namespace
}  // namespace sightline::apps::model_export_test
