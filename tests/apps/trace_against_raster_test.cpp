// sightline-trace and sightline-render draw the same, but for what a third of a pixel or the raster's depth decides.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "sightline/render/image/image.h"
#include "sightline/tests/apps/render_test.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::tests::trace_against_raster_test {
namespace {

constexpr int kWidth = 480, kHeight = 270, kPixels = kWidth * kHeight;
constexpr int kFiner = 3;             // odd, so that the middle of a pixel is the middle of one of the finer ones
constexpr double kDepthError = 1e-4;  // of the depth; the raster's depth buffer has about that in orthographic views
constexpr int kColourError = 2;       // of 255

struct Images {
  int width = 0;
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint32_t> ids;
  std::vector<float> depths;
};

/// Rows of the PFM that tools write, which begins at the bottom.
std::vector<float> read_depths(const std::string& file, int width, int height) {
  const std::string bytes = read_bytes(file);
  const std::string header = "Pf\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1.0\n";
  std::vector<float> depths(std::size_t(width * height));
  EXPECT_EQ(bytes.size(), header.size() + 4 * depths.size()) << file;
  if (bytes.size() != header.size() + 4 * depths.size()) return depths;
  for (int row = 0; row < height; ++row)
    std::memcpy(depths.data() + row * width, bytes.data() + header.size() + std::size_t(4 * width * (height - 1 - row)),
                std::size_t(4 * width));
  return depths;
}

class TraceAgainstRaster : public RenderTest,
                           public ::testing::WithParamInterface<std::tuple<std::string, std::string>> {
 protected:
  Images images(const std::string& tool, int finer, const Args& looks) const {
    const int width = kWidth * finer, height = kHeight * finer;
    const std::string out = path("out.png"), ids = path("ids.png"), depth = path("depth.pfm");
    Args args = scene_;
    args.insert(args.end(), looks.begin(), looks.end());
    args.insert(args.end(), {"--size", std::to_string(width) + "x" + std::to_string(height), "--out", out, "--ids", ids,
                             "--depth", depth});
    const Outcome outcome = run(tool, args);
    EXPECT_EQ(outcome.code, 0) << outcome;
    const auto colours = image::read_png(out), id_colours = image::read_png(ids);
    EXPECT_TRUE(colours && id_colours);
    if (!colours || !id_colours) return {};
    return {width, colours->pixels, image::ids_of_colours(*id_colours).ids, read_depths(depth, width, height)};
  }

  /// Model and view.
  Args scene_;
};

/// What the finer image shows within a pixel and one finer pixel around it. `id`: of which item depth and colour
/// are taken.
struct Around {
  bool shows = false;
  float nearest = std::numeric_limits<float>::infinity(), farthest = 0.0f;
  std::array<int, 3> darkest{255, 255, 255}, brightest{0, 0, 0};

  Around(const Images& finer, int x, int y, std::uint32_t id) {
    for (int row = std::max(0, kFiner * y - 1); row < std::min(kFiner * kHeight, kFiner * (y + 1) + 1); ++row)
      for (int column = std::max(0, kFiner * x - 1); column < std::min(kFiner * kWidth, kFiner * (x + 1) + 1);
           ++column) {
        const std::size_t i = std::size_t(row * finer.width + column);
        if (finer.ids[i] != id) continue;
        shows = true;
        nearest = std::min(nearest, finer.depths[i]);
        farthest = std::max(farthest, finer.depths[i]);
        for (std::size_t c = 0; c < 3; ++c) {
          darkest[c] = std::min(darkest[c], int(finer.rgb[3 * i + c]));
          brightest[c] = std::max(brightest[c], int(finer.rgb[3 * i + c]));
        }
      }
  }
};

/// Arguments of sightline-render and of sightline-trace for the same light.
std::pair<Args, Args> looks_of(const std::string& model) {
  if (model == "small_plant in the sun") return {{"--plain", "--sun", "2,-1,3"}, {"--sun", "2,-1,3"}};
  if (model == "small_plant in a studio") return {{"--samples", "1", "--depth-shading", "0", "--edge-lines", "0"}, {}};
  return {{"--plain"}, {"--plain"}};
}

TEST_P(TraceAgainstRaster, Agrees) {
  const auto& [model, view] = GetParam();
  scene_ = {data_path("small_plant.rvm").string()};
  if (model == "small_plant as meshes") {
    const std::string meshes = path("small_plant.obj");
    const Outcome converted = run("convert", {scene_[0], meshes, "--tolerance", "0.005"});
    ASSERT_EQ(converted.code, 0) << converted;
    scene_ = {meshes};
  }
  if (model.starts_with("small_plant") && !view.empty()) {
    const std::string file = path("view.json");
    std::ofstream(file) << view;
    scene_.insert(scene_.end(), {"--view", file});
  } else if (!view.empty()) {
    const std::string file = "huldra/" + model + ".RVM", from = "reference/" + model + "_" + view + ".json";
    SIGHTLINE_NEED_DATA(file);
    SIGHTLINE_NEED_DATA(from);
    scene_ = {data_path(file).string(), "--view", data_path(from).string()};
  }
  const std::string names = path("names.json");
  Args naming = scene_;
  naming.insert(naming.end(), {"--size", "480x270", "--ids-json", names});
  render(naming);
  const Json items = json::parse(read_bytes(names)).value();
  ASSERT_TRUE(items.is_object());

  const auto [of_raster, of_tracer] = looks_of(model);
  const Images raster = images("render", 1, of_raster), traced = images("trace", 1, of_tracer),
               finer = images("trace", kFiner, of_tracer);
  ASSERT_EQ(raster.ids.size(), std::size_t(kPixels));
  ASSERT_EQ(traced.ids.size(), raster.ids.size());
  ASSERT_EQ(finer.ids.size(), std::size_t(kPixels * kFiner * kFiner));

  int shown = 0, lines = 0, coincident = 0, silhouettes = 0, edges = 0, slivers = 0;
  double worst = 0.0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const std::size_t i = std::size_t(y * kWidth + x);
      const std::uint32_t id = raster.ids[i];
      ASSERT_EQ(traced.ids[i],
                finer.ids[std::size_t((kFiner * y + kFiner / 2) * finer.width + kFiner * x + kFiner / 2)]);
      const auto close = [](float a, float b) { return std::abs(a - b) <= kDepthError * b; };
      const Around around(finer, x, y, id);
      if (id != traced.ids[i]) {
        if (id != 0 && items[std::to_string(id - 1)]["kind"] == "line")
          ++lines;  // the tracer has none
        else if (close(raster.depths[i], traced.depths[i]))
          ++coincident;
        else if (around.shows)
          ++silhouettes;
        else
          ADD_FAILURE() << "pixel " << x << " " << y << ": items " << id << " and " << traced.ids[i] << " at "
                        << raster.depths[i] << " and " << traced.depths[i] << " m";
        continue;
      }
      if (id == 0) continue;
      ++shown;
      bool same = close(raster.depths[i], traced.depths[i]);
      if (same) worst = std::max(worst, std::abs(double(raster.depths[i]) / double(traced.depths[i]) - 1.0));
      bool within = raster.depths[i] >= around.nearest * (1.0 - kDepthError) &&
                    raster.depths[i] <= around.farthest * (1.0 + kDepthError);
      for (std::size_t c = 0; c < 3; ++c) {
        const int value = raster.rgb[3 * i + c];
        same &= std::abs(value - traced.rgb[3 * i + c]) <= kColourError;
        within &= value >= around.darkest[c] - kColourError && value <= around.brightest[c] + kColourError;
      }
      edges += !same;  // of an item's own faces
      if (same || within) continue;
      ++slivers;  // faces between the finer image's samples, or too near to each other for the raster's depth
      std::printf("pixel %d %d of item %u: depths %.6f and %.6f m\n", x, y, id, raster.depths[i], traced.depths[i]);
    }
  std::printf(
      "%s %s: %d pixels show an item; another one: %d silhouette, %d coincident, %d line; %d at own edges, %d more at "
      "slivers; depth "
      "within %.1e\n",
      model.c_str(), view.c_str(), shown, silhouettes, coincident, lines, edges, slivers, worst);
  EXPECT_GT(shown, kPixels / 20);
  EXPECT_LE(silhouettes, kPixels * 3 / 1000);
  EXPECT_LE(edges, kPixels * 3 / 1000);
  EXPECT_LE(slivers, kPixels / 10000);
}

const char* const kCutByBoth =
    R"({"eye":[400020,6499990,40],"target":[400001,6500002,31],"up":[0,0,1],"fovy_deg":30,"near":0.1,"far":1000,
        "sections":[{"n":[-1,0.2,0],"d":-899999.3},{"n":[0,0,-1],"d":33.1}]})";
const char* const kCutByEither =
    R"({"eye":[400020,6499990,40],"target":[400001,6500002,31],"up":[0,0,1],"fovy_deg":30,"near":0.1,"far":1000,
        "sections":[{"n":[-1,0.2,0],"d":-899999.3},{"n":[0,0,-1],"d":29.8}],"section_mode":"union"})";
std::string name_of_cut(const ::testing::TestParamInfo<std::tuple<std::string, std::string>>& info) {
  constexpr const char* kNames[] = {"whole", "cut_by_both", "cut_by_either", "meshes_cut_by_both", "sun", "studio"};
  return kNames[info.index];
}
INSTANTIATE_TEST_SUITE_P(SmallPlant, TraceAgainstRaster,
                         ::testing::Values(std::tuple("small_plant", ""), std::tuple("small_plant", kCutByBoth),
                                           std::tuple("small_plant", kCutByEither),
                                           std::tuple("small_plant as meshes", kCutByBoth),
                                           std::tuple("small_plant in the sun", kCutByBoth),
                                           std::tuple("small_plant in a studio", "")),
                         name_of_cut);
INSTANTIATE_TEST_SUITE_P(Huldra, TraceAgainstRaster, huldra_views(), name_of_view);

}  // namespace
}  // namespace sightline::tests::trace_against_raster_test
