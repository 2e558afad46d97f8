// Two drivers draw the same images: llvmpipe, and zink on lavapipe, which translates shaders and state another way
// (scripts/with_driver.sh). A process has one driver, so sightline-render draws each image twice.
#include <cmath>
#include <map>

#include "sightline/importers/import.h"
#include "sightline/render/image/image.h"
#include "sightline/tests/apps/render_test.h"
#include "sightline/tests/lod/mesh_samples.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::tests::driver_images_test {
namespace {

constexpr double kMostApart =
    1.2e-5;  // of the distance, where both show the same item; 10^-5 but for one pixel at grazing sight
constexpr double kCoincident = 2e-6;  // of the distance: where surfaces of two items are no further apart, either shows
constexpr int kColourStep = 1;        // of 255, in each channel

struct Drawn {
  image::Image colours;
  image::IdImage ids;
  image::DepthImage depth;
};

/// Numbers of pixels.
struct Differences {
  int shown = 0, coincident = 0;                        // what may be
  int covered = 0, items = 0, depths = 0, colours = 0;  // what must not be
  double apart = 0.0;                                   // at most, of the distance, where the items are the same

  bool none() const { return covered == 0 && items == 0 && depths == 0 && colours == 0; }
};
std::ostream& operator<<(std::ostream& to, const Differences& d) {
  return to << d.shown << " pixels shown, " << d.coincident << " of coincident surfaces, depths at most " << d.apart
            << " apart; differing: coverage " << d.covered << ", items " << d.items << ", depths " << d.depths
            << ", colours " << d.colours;
}

/// The difference as a share of the lesser distance; 0 where both are infinite.
double apart(float a, float b) {
  return a == b ? 0.0 : std::abs(double(a) - double(b)) / std::min(a, b);
}

int colour_step(const Drawn& a, const Drawn& b, std::size_t pixel) {
  int most = 0;
  for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i)
    most = std::max(most, std::abs(int(a.colours.pixels[i]) - int(b.colours.pixels[i])));
  return most;
}

Differences compare(const Drawn& a, const Drawn& b) {
  Differences d;
  for (std::size_t i = 0; i < a.ids.ids.size(); ++i) {
    const std::uint32_t item = a.ids.ids[i], other = b.ids.ids[i];
    const double by = apart(a.depth.metres[i], b.depth.metres[i]);
    d.shown += item != 0;
    if ((item == 0) != (other == 0)) {
      ++d.covered;
    } else if (item != other) {
      ++(by <= kCoincident ? d.coincident : d.items);
    } else {
      d.apart = std::max(d.apart, by);
      d.depths += !(by <= kMostApart);
      d.colours += colour_step(a, b, i) > kColourStep;
    }
  }
  return d;
}

/// The views by name, as JSON.
const std::map<std::string, std::string> kViews = [] {
  const std::string near = R"("eye":[-30,-12,6],"target":[5,2,3],"up":[0,0,1],"fovy_deg":60,"near":0.1,"far":1000)";
  const std::string planes = R"("sections":[{"n":[0,1,0.1],"d":-0.5},{"n":[0.2,0,-1],"d":8}])";
  return std::map<std::string, std::string>{
      {"near", "{" + near + "}"},
      {"cut", "{" + near + "," + planes + "}"},
      {"union", "{" + near + R"(,"section_mode":"union",)" + planes + "}"},
      {"above", R"({"eye":[-40,-60,50],"target":[0,0,4],"up":[0,0,1],"ortho_height":30,"near":0.1,"far":1000})"},
      {"torus", R"({"eye":[5,-4,3],"target":[0,0,0],"up":[0,0,1],"fovy_deg":50,"near":0.1,"far":100})"}};
}();

/// How the names of each driver's renderers begin.
const std::map<std::string, std::string> kRenderers = {{"llvmpipe", "llvmpipe"}, {"zink", "zink (llvmpipe"}};

class DriverImages : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    const Outcome probe = draw_by("zink", {data_path("box.stl").string(), "--size", "8x8"});
    const std::string why = probe.code != 0                                         ? probe.err
                            : renderer_of(probe).starts_with(kRenderers.at("zink")) ? ""
                                                                                    : renderer_of(probe);
    if (why.empty()) return;
    if (gl_required()) FAIL() << "expected zink on lavapipe (mesa-vulkan-drivers): " << why;
    GTEST_SKIP() << "no zink on lavapipe (mesa-vulkan-drivers): " << why;
  }

  Outcome draw_by(const std::string& driver, const Args& args) const {
    Args all = {driver, program_of("render")};
    all.insert(all.end(), args.begin(), args.end());
    all.insert(all.end(), {"--json", "-"});
    return run_program(in_checkout("scripts/with_driver.sh").string(), all);
  }
  static std::string renderer_of(const Outcome& drawn) {
    const auto results = json::parse(drawn.out);
    return results && results->contains("renderer") ? (*results)["renderer"].get<std::string>() : "";
  }

  /// A failed test, and empty images, where the driver draws none or is another one.
  Drawn draw(const std::string& driver, Args args) const {
    const std::string colours = path(driver + ".png"), ids = path(driver + ".ids.png"), depth = path(driver + ".pfm");
    args.insert(args.end(),
                {"--plain", "--size", "320x180", "--gl-debug", "--out", colours, "--ids", ids, "--depth", depth});
    const Outcome drawn = draw_by(driver, args);
    EXPECT_EQ(drawn.code, 0) << drawn;
    EXPECT_TRUE(renderer_of(drawn).starts_with(kRenderers.at(driver))) << drawn;
    if (HasFailure()) return {};
    return {image::read_png(colours).value(), image::ids_of_colours(image::read_png(ids).value()),
            image::read_pfm(depth).value()};
  }

  void expect_equal(const Args& args) const {
    const Drawn one = draw("llvmpipe", args), other = draw("zink", args);
    ASSERT_FALSE(HasFailure());
    const Differences found = compare(one, other);
    EXPECT_TRUE(found.none()) << found;
    EXPECT_GT(found.shown, 1000) << "hardly anything is drawn";
    std::cout << found << '\n';
  }
};

/// "plant": solids. "meshes": their triangles, a mesh an item. "torus": a mesh so large that it is drawn by clusters.
struct Shot {
  const char* name;
  const char* model;
  const char* view;
  const char* options;
};
std::ostream& operator<<(std::ostream& to, const Shot& shot) {
  return to << shot.name;
}
const Shot kShots[] = {
    {"Solids", "plant", "near", "--culler cpu"},
    {"SolidsOccluded", "plant", "near", "--culler cpu --occlusion on"},
    {"SolidsByGeometryShaders", "plant", "near", "--culler gpu --gpu-variant geometry --occlusion on"},
    {"SolidsByComputeShaders", "plant", "above", "--culler gpu --gpu-variant compute --occlusion on"},
    {"SolidsByTheHybrid", "plant", "above", "--culler hybrid"},
    {"SolidsCut", "plant", "cut", "--culler cpu"},
    {"SolidsCutByAUnion", "plant", "union", "--culler gpu --gpu-variant geometry --hatching 0.5"},
    {"SolidsShaded", "plant", "near", "--culler cpu --depth-shading 0.5 --edge-lines 0.5"},
    {"SolidsAsGhosts", "plant", "near", "--culler cpu --ghost PIPE --transparency blended"},
    {"SolidsAsPoints", "plant", "near", "--culler cpu --min-projected-area 20 --contribution-mode points"},
    {"MeshesOccluded", "meshes", "near", "--culler cpu --occlusion on"},
    {"MeshesByGeometryShaders", "meshes", "above", "--culler gpu --gpu-variant geometry --occlusion on"},
    {"MeshesCut", "meshes", "cut", "--culler gpu --gpu-variant compute"},
    {"MeshesCutByAUnion", "meshes", "union", "--culler hybrid --hatching 0.5"},
    {"Clusters", "torus", "torus", "--culler cpu --occlusion on"},
    {"ClustersByGeometryShaders", "torus", "torus", "--culler gpu --gpu-variant geometry --occlusion on"},
    {"Levels", "torus", "torus", "--culler cpu --lod-error 3"},
    {"LevelsByComputeShaders", "torus", "torus", "--culler gpu --gpu-variant compute --lod-error 3"}};

class ShotsByDrivers : public DriverImages, public ::testing::WithParamInterface<Shot> {
 protected:
  std::string model(const std::string& name) const {
    if (name == "torus") return write("torus.obj", obj_of(bumpy_torus(100, 0.05)));
    const std::string solids = plant(3000);
    if (name == "plant") return solids;
    const Outcome converted = run("convert", {solids, path("plant.glb"), "--tolerance", "0.005"});
    EXPECT_EQ(converted.code, 0) << converted;
    return path("plant.glb");
  }

 private:
  static std::string obj_of(const core::Mesh& mesh) {
    std::ostringstream text;
    for (const auto& p : mesh.positions) text << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
      text << "f " << mesh.indices[i] + 1 << ' ' << mesh.indices[i + 1] + 1 << ' ' << mesh.indices[i + 2] + 1 << '\n';
    return text.str();
  }
};

TEST_P(ShotsByDrivers, AreEqual) {
  const Shot& shot = GetParam();
  const auto known = importers::known_extensions();
  if (shot.model == std::string("meshes") && std::find(known.begin(), known.end(), ".glb") == known.end())
    GTEST_SKIP() << "a build without glTF";
  Args args = {model(shot.model), "--view", write("view.json", kViews.at(shot.view))};
  std::istringstream options(shot.options);
  for (std::string option; options >> option;) args.push_back(option);
  expect_equal(args);
}
INSTANTIATE_TEST_SUITE_P(, ShotsByDrivers, ::testing::ValuesIn(kShots),
                         [](const auto& shot) { return std::string(shot.param.name); });

class RealModelsByDrivers : public DriverImages, public ::testing::WithParamInterface<ModelView> {};

TEST_P(RealModelsByDrivers, AreEqual) {
  const auto& [model, view] = GetParam();
  const std::string file = "huldra/" + model + ".RVM", from = "reference/" + model + "_" + view + ".json";
  for (const std::string& name : {file, from}) SIGHTLINE_NEED_DATA(name);
  expect_equal({data_path(file).string(), "--view", data_path(from).string()});
}
INSTANTIATE_TEST_SUITE_P(Huldra, RealModelsByDrivers, huldra_views(), name_of_view);

/// Two items side by side, and background.
Drawn three_pixels() {
  return {{3, 1, {10, 20, 30, 40, 50, 60, 0, 0, 0}}, {3, 1, {5, 6, 0}}, {3, 1, {10.0f, 20.0f, INFINITY}}};
}

TEST(DifferencesOfDrivers, AreFound) {
  const Drawn drawn = three_pixels();
  const auto after = [&](const auto& change) {
    Drawn changed = drawn;
    change(changed);
    return compare(drawn, changed);
  };
  const Differences same = compare(drawn, drawn);
  EXPECT_TRUE(same.none() && same.shown == 2 && same.coincident == 0) << same;
  EXPECT_EQ(after([](Drawn& d) { d.ids.ids[2] = 7; }).covered, 1);
  EXPECT_EQ(after([](Drawn& d) { d.ids.ids[0] = 0; }).covered, 1);
  EXPECT_EQ(after([](Drawn& d) { d.depth.metres[1] = 20.001f; }).depths, 1);
  EXPECT_EQ(after([](Drawn& d) { d.depth.metres[1] = NAN; }).depths, 1);
  EXPECT_EQ(after([](Drawn& d) { d.colours.pixels[4] += 2; }).colours, 1);
  EXPECT_EQ(after([](Drawn& d) { d.colours.pixels[7] += 2; }).colours, 1) << "of the background";
  EXPECT_EQ(after([](Drawn& d) { d.ids.ids[0] = 7, d.depth.metres[0] = 10.0005f; }).items, 1);
  const Differences tie = after([](Drawn& d) { d.ids.ids[0] = 7, d.colours.pixels[0] = 200; });
  EXPECT_TRUE(tie.none() && tie.coincident == 1) << tie << ": either surface may show";
  const Differences rounded = after([](Drawn& d) { d.depth.metres[1] = 20.0001f, d.colours.pixels[3] += 1; });
  EXPECT_TRUE(rounded.none() && rounded.apart > 1e-6) << rounded;
}

}  // namespace
}  // namespace sightline::tests::driver_images_test
