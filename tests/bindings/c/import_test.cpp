// Imports in C: reports, progress, cancelling, warnings; and calls from within a callback.
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <unistd.h>

#include "each_setting.h"
#include "sightline/tests/support/test_data.h"
#if __has_include("sightline/importers/import.h")
#include "sightline/core/mesh_extras.h"
#include "sightline/importers/import.h"
#include "sightline/importers/obj/obj_writer.h"
#include "sightline/importers/slc/slc_writer.h"
#include "sightline/importers/write_file.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests::import_test {
namespace {

struct Heard {
  std::vector<double> shares;
  std::vector<std::string> warnings;
  double cancel_at = 2.0;
  sl_scene scene = {0};
  std::vector<sl_status> within;  // of calls from within the callback
};

std::int32_t hear(double share, void* user) {
  Heard& heard = *static_cast<Heard*>(user);
  heard.shares.push_back(share);
  if (heard.scene.id) {
    heard.within.push_back(sl_scene_commit(heard.scene));
    heard.within.push_back(sl_scene_destroy(heard.scene));
    heard.within.push_back(sl_scene_hand_over(heard.scene));
  }
  return share < heard.cancel_at;
}

void hear_warning(const char* file, std::uint64_t, const char* message, void* user) {
  static_cast<Heard*>(user)->warnings.push_back(std::string(file) + ": " + message);
}

sl_import_options listening(Heard& heard) {
  sl_import_options options = SL_IMPORT_OPTIONS_INIT;
  options.progress = hear;
  options.warning = hear_warning;
  options.user = &heard;
  return options;
}

sl_status import(const CScene& c, const std::vector<std::string>& paths, const sl_import_options* options = nullptr,
                 sl_node* nodes = nullptr, sl_import_report* report = nullptr) {
  std::vector<const char*> names;
  for (const std::string& path : paths) names.push_back(path.c_str());
  return sl_import(c.scene, c.root, names.data(), names.size(), options, nodes, report);
}

class CapiImport : public ::testing::Test {
 protected:
  const std::string plant = data_path("small_plant.rvm").string();
  const std::string attributes = data_path("small_plant.txt").string();
  const std::string cone = data_path("cone_vtk.stl").string();
};

TEST_F(CapiImport, GivesWhatCppGives) {
  const CScene c;
  Heard heard;
  const sl_import_options options = listening(heard);
  sl_node nodes[3] = {{0}, {0}, {0}};
  sl_import_report report = SL_IMPORT_REPORT_INIT;
  ASSERT_OK(import(c, {plant, cone, attributes}, &options, nodes, &report));

  core::Scene scene;
  const std::vector<std::filesystem::path> paths = {plant, cone, attributes};
  const auto expected = importers::import_files(paths, scene, scene.root());
  ASSERT_TRUE(expected);
  EXPECT_EQ(report.node_count, 2u);
  EXPECT_NE(nodes[0].id, 0u);
  EXPECT_NE(nodes[1].id, 0u);
  EXPECT_EQ(nodes[2].id, 0u);
  EXPECT_TRUE(std::equal(expected->items.begin(), expected->items.end(), report.items));
  EXPECT_EQ(report.degenerate, expected->degenerate);
  EXPECT_EQ(report.shared_meshes, expected->shared_meshes);
  EXPECT_EQ(report.attributed, expected->attributed);
  EXPECT_EQ(report.bytes, expected->bytes);
  EXPECT_EQ(report.sharing_error, expected->sharing_error);
  EXPECT_EQ(report.metres_per_unit, expected->metres_per_unit);
  ASSERT_EQ(report.warnings, expected->warnings.size());
  ASSERT_EQ(heard.warnings.size(), expected->warnings.size());
  ASSERT_FALSE(heard.shares.empty());
  EXPECT_EQ(heard.shares.back(), 1.0);

  sl_scene_info info = SL_SCENE_INFO_INIT;
  ASSERT_OK(sl_scene_get(c.scene, &info));
  EXPECT_EQ(info.nodes, scene.node_count());
  EXPECT_EQ(info.items, scene.item_count());
  sl_box box;
  ASSERT_OK(sl_scene_bounds(c.scene, c.root, SL_DEFAULT_LAYERS, &box));
  const core::AabbD bounds = scene.bounds(scene.root());
  EXPECT_EQ(std::memcmp(box.min, &bounds.min, sizeof box.min), 0);
}

TEST_F(CapiImport, CancelsAndLeavesTheSceneAlone) {
  const CScene c;
  Heard heard;
  heard.cancel_at = 0.0;
  const sl_import_options options = listening(heard);
  for (const std::vector<std::string>& paths : {std::vector{plant}, {plant, cone}, {cone, plant, plant}}) {
    sl_import_report report = SL_IMPORT_REPORT_INIT;
    report.bytes = 42;
    EXPECT_EQ(import(c, paths, &options, nullptr, &report), SL_ERROR_CANCELLED);
    EXPECT_EQ(report.bytes, 42u);
    sl_scene_info info = SL_SCENE_INFO_INIT;
    ASSERT_OK(sl_scene_get(c.scene, &info));
    EXPECT_EQ(info.nodes, 1u);
    EXPECT_EQ(info.items, 0u);
  }
}

TEST_F(CapiImport, AnExceptionOfTheCallbackCancels) {
  const CScene c;
  sl_import_options options = SL_IMPORT_OPTIONS_INIT;
  options.progress = [](double, void*) -> std::int32_t { throw std::string("the application's own"); };
  EXPECT_EQ(import(c, {plant, cone}, &options), SL_ERROR_CANCELLED);
  EXPECT_OK(sl_scene_commit(c.scene));
}

TEST_F(CapiImport, TheSceneIsBusyMeanwhile) {
  const CScene c;
  Heard heard;
  heard.scene = c.scene;
  const sl_import_options options = listening(heard);
  ASSERT_OK(import(c, {plant}, &options));
  ASSERT_FALSE(heard.within.empty());
  for (const sl_status status : heard.within) EXPECT_EQ(status, SL_ERROR_BUSY);
  EXPECT_OK(sl_scene_commit(c.scene));
}

TEST_F(CapiImport, ErrorsNameTheFile) {
  const CScene c;
  EXPECT_EQ(import(c, {plant, "no_such_file.rvm"}), SL_ERROR_FAILED);
  EXPECT_STREQ(sl_last_error(), "no_such_file.rvm: no such file");
  EXPECT_EQ(sl_import(c.scene, c.root, nullptr, 1, nullptr, nullptr, nullptr), SL_ERROR_ARGUMENT);
  const char* null_path = nullptr;
  EXPECT_EQ(sl_import(c.scene, c.root, &null_path, 1, nullptr, nullptr, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_import(c.scene, {0}, &null_path, 0, nullptr, nullptr, nullptr), SL_ERROR_HANDLE);
  EXPECT_OK(sl_import(c.scene, c.root, nullptr, 0, nullptr, nullptr, nullptr)) << "no files";
  sl_import_options options = SL_IMPORT_OPTIONS_INIT;
  options.metres_per_unit = -1;
  EXPECT_EQ(import(c, {plant}, &options), SL_ERROR_ARGUMENT);
  options = SL_IMPORT_OPTIONS_INIT;
  options.up = 3;
  EXPECT_EQ(import(c, {plant}, &options), SL_ERROR_ARGUMENT);
  options = SL_IMPORT_OPTIONS_INIT;
  options.copies = -1;
  EXPECT_EQ(import(c, {plant}, &options), SL_ERROR_ARGUMENT);
  sl_scene_info info = SL_SCENE_INFO_INIT;
  ASSERT_OK(sl_scene_get(c.scene, &info));
  EXPECT_EQ(info.nodes, 1u);
}

TEST_F(CapiImport, WarningsOfDamageAreHeard) {
  const CScene c;
  const auto damaged = std::filesystem::path(::testing::TempDir()) / "capi_damaged.rvm";
  std::filesystem::copy_file(plant, damaged, std::filesystem::copy_options::overwrite_existing);
  std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) / 2);
  EXPECT_EQ(import(c, {damaged.string()}), SL_ERROR_FAILED);
  Heard heard;
  sl_import_options options = listening(heard);
  options.lenient = 1;
  EXPECT_OK(import(c, {damaged.string()}, &options));
  ASSERT_FALSE(heard.warnings.empty());
  EXPECT_EQ(heard.warnings[0].rfind("capi_damaged.rvm: ", 0), 0u) << heard.warnings[0];
  std::filesystem::remove(damaged);
}

TEST_F(CapiImport, FilesThatStandOnYAreTurned) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "capi_standing.obj";
  std::ofstream(file)
      << "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0.5 2 0.5\nf 1 2 3 4\nf 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5\n";
  for (const auto& [up, height] : {std::pair(SL_UP_AUTO, 2.0), {SL_UP_Y, 2.0}, {SL_UP_Z, 1.0}}) {
    const CScene c;
    Heard heard;
    sl_import_options options = listening(heard);
    if (up != SL_UP_AUTO) options.up = up;  // which is the default
    ASSERT_OK(import(c, {file.string()}, &options));
    sl_box bounds;
    ASSERT_OK(sl_scene_bounds(c.scene, c.root, ~0u, &bounds));
    EXPECT_NEAR(bounds.max[2] - bounds.min[2], height, 1e-6);
    EXPECT_EQ(heard.warnings.size(), up == SL_UP_AUTO ? 1u : 0u);
  }
  std::filesystem::remove(file);
}

TEST_F(CapiImport, ACacheGivesTheSameTheSecondTime) {
  if (std::string(sl_import_extensions()).find(".slc") == std::string::npos) GTEST_SKIP() << "built without caches";
  const auto folder = std::filesystem::path(::testing::TempDir()) / "capi_caches";
  std::filesystem::remove_all(folder);
  const std::string name = folder.string();
  sl_import_options options = SL_IMPORT_OPTIONS_INIT;
  options.cache_folder = name.c_str();
  sl_scene_info first = SL_SCENE_INFO_INIT, second = SL_SCENE_INFO_INIT;
  sl_import_report report = SL_IMPORT_REPORT_INIT;
  for (sl_scene_info* info : {&first, &second}) {
    const CScene c;
    ASSERT_OK(import(c, {plant, attributes}, &options, nullptr, &report));
    EXPECT_EQ(report.warnings, 0u);
    EXPECT_EQ(report.from_cache, info == &second);
    ASSERT_OK(sl_scene_get(c.scene, info));
  }
  EXPECT_EQ(first.nodes, second.nodes);
  EXPECT_EQ(first.items, second.items);
  std::filesystem::remove_all(folder);
}

/// A program made before there was the option does not get levels: what lies behind its struct is not looked at.
TEST_F(CapiImport, CachesHoldLevelsWhereThatIsAskedFor) {
  const std::string known = sl_import_extensions();
  if (known.find(".slc") == std::string::npos || known.find(".obj") == std::string::npos)
    GTEST_SKIP() << "built without caches or OBJ";
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  core::Scene scene;
  scene.add_mesh_instance(scene.root(), scene.add_mesh(bumpy_torus(20, 0.1)).value());
  ASSERT_TRUE(scene.commit());
  const auto model = std::filesystem::path(::testing::TempDir()) / "capi_torus.obj";
  ASSERT_TRUE(importers::write_obj(scene, scene.root(), model));
  const auto folder = std::filesystem::path(::testing::TempDir()) / "capi_levels";
  std::filesystem::remove_all(folder);
  const std::string name = folder.string();
  sl_import_options options = SL_IMPORT_OPTIONS_INIT;
  options.cache_folder = name.c_str();
  const auto cached_with_levels = [&] {
    EXPECT_OK(import(CScene(), {model.string()}, &options));
    core::Scene read;
    EXPECT_TRUE(importers::import_file(std::filesystem::directory_iterator(folder)->path(), read, read.root()));
    return core::bytes_stored_with(read.mesh(read.mesh_at(0))) != nullptr;
  };
  EXPECT_FALSE(cached_with_levels());
  options.cached_levels = 1;
  EXPECT_TRUE(cached_with_levels());
  std::filesystem::remove_all(folder);
  std::filesystem::remove(model);
}

/// A triangle of a face has its surface, another one none.
TEST_F(CapiImport, FacesOfMeshesHaveTheirSurfaces) {
  if (std::string(sl_import_extensions()).find(".slc") == std::string::npos) GTEST_SKIP() << "built without caches";
  core::Mesh made;
  made.positions = {{2, 0, 0}, {0, 2, 0}, {0, 2, 1}, {5, 5, 5}};
  made.indices = {0, 1, 2, 0, 1, 3};
  core::MeshSurface hole;
  hole.kind = core::MeshSurface::Kind::kCylinder, hole.end_triangle = 2, hole.radius = 2.0, hole.gap = 1e-6;
  made.extras = core::MeshExtrasSlot({nullptr, std::make_shared<const std::vector<core::MeshSurface>>(1, hole)});
  core::Scene scene;
  scene.add_mesh_instance(scene.add_node(scene.root(), "part"), scene.add_mesh(std::move(made)).value());
  ASSERT_TRUE(scene.commit());
  const auto file = std::filesystem::path(::testing::TempDir()) / "capi_surfaces.slc";
  ASSERT_TRUE(importers::write_slc(scene, file));
  const CScene c;
  ASSERT_OK(import(c, {file.string()}));
  std::filesystem::remove(file);
  sl_item_info item = SL_ITEM_INFO_INIT;
  ASSERT_OK(sl_item_get(c.scene, 0, &item));
  sl_mesh_surface surface = SL_MESH_SURFACE_INIT;
  ASSERT_OK(sl_mesh_get_surface(c.scene, item.mesh, 0, &surface));
  EXPECT_EQ(surface.kind, SL_SURFACE_CYLINDER);
  EXPECT_EQ(surface.radius, 2.0);
  EXPECT_EQ(surface.axis[2], 1.0);
  ASSERT_OK(sl_mesh_get_surface(c.scene, item.mesh, 1, &surface));
  EXPECT_EQ(surface.kind, SL_SURFACE_OTHER) << "its corners do not lie on it";
  EXPECT_EQ(sl_mesh_get_surface(c.scene, item.mesh, 2, &surface), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_mesh_get_surface(c.scene, item.mesh, 0, nullptr), SL_ERROR_ARGUMENT);
}

/// A program that was made before there were caches knows less of reports; its settings are others.
TEST_F(CapiImport, ReportsGrowAndSettingsAreOfOneVersion) {
  const CScene c;
  sl_import_report report = SL_IMPORT_REPORT_INIT;
  report.size = std::uint32_t(offsetof(sl_import_report, from_cache));
  report.from_cache = 42;
  EXPECT_OK(import(c, {plant}, nullptr, nullptr, &report));
  EXPECT_EQ(report.from_cache, 42);
  sl_import_options options = SL_IMPORT_OPTIONS_INIT;
  options.size -= 8;
  EXPECT_EQ(import(c, {plant}, &options), SL_ERROR_ARGUMENT);
  options.size += 16;
  EXPECT_EQ(import(c, {plant}, &options), SL_ERROR_UNSUPPORTED);
}

TEST_F(CapiImport, DefaultsAreThoseOfCpp) {
  const sl_import_options c = SL_IMPORT_OPTIONS_INIT;
  const importers::ImportOptions cpp;
#define SIGHTLINE_SETTING(path, name, ...) EXPECT_TRUE(same_setting(c.path, cpp.path)) << #name;
#include "sightline/importers/internal/settings.inc"
}

/// A box of 2 x 4 x 6 m, an open square, and nothing else.
constexpr const char* kBoxAndSquare =
    "v 0 0 0\nv 2 0 0\nv 2 4 0\nv 0 4 0\nv 0 0 6\nv 2 0 6\nv 2 4 6\nv 0 4 6\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
    "v 9 0 0\nv 10 0 0\nv 10 1 0\nv 9 1 0\nf 9 10 11 12\n";

TEST_F(CapiImport, PrimitivesAreRecognised) {
  if (std::string(sl_import_extensions()).find(".obj") == std::string::npos) GTEST_SKIP() << "built without OBJ";
  const auto file = std::filesystem::path(::testing::TempDir()) / "capi_box.obj";
  std::ofstream(file) << kBoxAndSquare;
  sl_import_options options = SL_IMPORT_OPTIONS_INIT;
  sl_import_report report = SL_IMPORT_REPORT_INIT;
  const auto items_of_kind = [&](sl_kind kind) {
    const CScene c;
    EXPECT_OK(import(c, {file.string()}, &options, nullptr, &report));
    int count = 0;
    for (sl_item item = 0; item < 10; ++item) {
      sl_item_info info = SL_ITEM_INFO_INIT;
      count += sl_item_get(c.scene, item, &info) == SL_OK && info.primitive.kind == kind;
    }
    return count;
  };
  EXPECT_EQ(items_of_kind(SL_BOX), 0);
  EXPECT_EQ(report.meshes_examined, 0u);
  EXPECT_EQ(report.recognised[SL_BOX], 0u);
  options.recognise = 1;
  EXPECT_EQ(items_of_kind(SL_BOX), 1);
  EXPECT_EQ(report.recognised[SL_BOX], 1u);
  EXPECT_EQ(report.meshes_examined, 1u);
  EXPECT_EQ(report.triangles_before, 14u);
  EXPECT_EQ(report.triangles_after, 2u);
  EXPECT_LT(report.mesh_bytes_after, report.mesh_bytes_before);
  EXPECT_LT(report.largest_deviation, 1e-6);
  EXPECT_EQ(report.refused[SL_REFUSED_OPEN], 1u);
  for (const double bad : {-1.0, std::nan(""), double(INFINITY)}) {
    options.recognise_tolerance = bad;
    EXPECT_EQ(import(CScene(), {file.string()}, &options), SL_ERROR_ARGUMENT) << bad;
    EXPECT_NE(std::string(sl_last_error()).find("recognise_tolerance"), std::string::npos) << sl_last_error();
  }
  std::filesystem::remove(file);
}

TEST_F(CapiImport, EveryFormatIsWritten) {
  const CScene c;
  sl_node top = {0};
  sl_import_options options = SL_IMPORT_OPTIONS_INIT;
  ASSERT_OK(import(c, {plant}, &options, &top));
  core::Scene scene;
  ASSERT_TRUE(importers::import_file(plant, scene, scene.root()));
  const auto folder = std::filesystem::path(::testing::TempDir()) / ("capi_written_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder / "cpp");
  sl_write_options writing = SL_WRITE_OPTIONS_INIT;
  writing.tolerance = 0.01;
  std::vector<const char*> names{"a.rvm", "a.obj", "a.glb", "a.gltf", "tiles"};
#ifdef SIGHTLINE_HAVE_SLC
  names.push_back("a.slc");
#endif
  for (const char* name : names) {
    SCOPED_TRACE(name);
    writing.tiles = std::string(name) == "tiles";
    const std::string path = (folder / name).string(), twin = (folder / "cpp" / name).string();
    sl_write_report report = SL_WRITE_REPORT_INIT;
    ASSERT_OK(sl_scene_write(c.scene, top, path.c_str(), &writing, &report));
    const auto expected = importers::write_file(scene, scene.first_child(scene.root()), twin,
                                                {.tolerance = 0.01, .tiles = writing.tiles != 0});
    ASSERT_TRUE(expected) << expected.error().message;
    std::uint64_t items = 0;
    for (const std::uint64_t of_kind : expected->items) items += of_kind;
    EXPECT_GT(items, 0u);
    EXPECT_EQ(report.items, items);
    EXPECT_EQ(report.left_out, expected->left_out);
    EXPECT_EQ(report.bytes, expected->bytes);
    EXPECT_EQ(report.triangles, expected->triangles ? expected->triangles->triangles : 0);
    EXPECT_TRUE(std::filesystem::exists(path));
  }
  const std::string nameless = (folder / "a.xyz").string(), good = (folder / "b.obj").string();
  EXPECT_EQ(sl_scene_write(c.scene, top, nameless.c_str(), nullptr, nullptr), SL_ERROR_FAILED);
  writing.tolerance = 0.0;
  EXPECT_EQ(sl_scene_write(c.scene, top, good.c_str(), &writing, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_NE(std::string(sl_last_error()).find("tolerance to be above 0"), std::string::npos) << sl_last_error();
  writing = SL_WRITE_OPTIONS_INIT;
  writing.progress = [](double, void*) -> std::int32_t { return 0; };
  EXPECT_EQ(sl_scene_write(c.scene, top, good.c_str(), &writing, nullptr), SL_ERROR_CANCELLED);
  std::filesystem::remove_all(folder);
}

TEST_F(CapiImport, ExtensionsAreListed) {
  std::string expected;
  for (const std::string_view extension : importers::known_extensions())
    expected.append(expected.empty() ? "" : " ").append(extension);
  EXPECT_EQ(sl_import_extensions(), expected);
}

}  // namespace
}  // namespace sightline::tests::import_test

#endif
