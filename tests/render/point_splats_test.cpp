// Squares of small items against a twin in double: which samples they cover, and what these show.
#include "sightline/render/internal/point_splats.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/render/internal/renderer.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::render::point_splats_test {
namespace {

using core::dvec3;
using core::View;

constexpr int kWidth = 96, kHeight = 64;
constexpr double kAspect = double(kWidth) / kHeight;
constexpr double kUnclear = 2e-3;  // pixels from a square's border: float decides

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * double(engine_()) / 4294967296.0; }
  std::uint32_t below(std::uint32_t count) { return std::uint32_t(engine_()) % count; }

 private:
  std::mt19937 engine_;
};

/// What a square shows, in pixels from the lower left corner.
struct ShownSplat {
  double x, y, half, distance;
  std::uint32_t id;
  dvec3 colour;  // 0 … 255
};

class PointSplatsTest : public tests::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!context) return;
    for (const glm::vec3 colour : {glm::vec3(0.9f, 0.1f, 0.2f), glm::vec3(0.1f, 0.5f, 0.3f)})
      (void)scene_.add_material({.name = "", .colour = colour});
    (void)scene_.add_material({.name = "glass", .alpha = 0.5f});
    scene_.add_primitive(scene_.root(), core::Box{1, 1, 1});
    ASSERT_TRUE(scene_.commit());
    snapshot_.emplace(scene_);
    auto gpu = gpuscene::GpuScene::create(*context, *snapshot_);
    ASSERT_TRUE(gpu);
    gpu_ = std::move(*gpu);
  }
  void TearDown() override {
    gpu_.reset();
    GlTest::TearDown();
  }

  /// A cleared target with the squares.
  RenderTarget draw(const View& view, const TargetFormat& format, std::span<const PointSplat> splats) {
    auto target = RenderTarget::create(*context, kWidth, kHeight, format);
    auto renderer = Renderer::create(*context, *gpu_, format);
    auto lists = gpuscene::DrawLists::create(*context, *gpu_);
    auto points = PointSplats::create(*context, format);
    EXPECT_TRUE(target && renderer && lists && points);
    EXPECT_TRUE(renderer->draw(view, *snapshot_, *gpu_, *lists, *target));
    const auto done = points->draw(view, splats, *gpu_, *target);
    EXPECT_TRUE(done) << done.error().message;
    return std::move(*target);
  }

  static std::vector<PointSplat> random_splats(Random& random, const View& view, int count, std::uint32_t materials) {
    std::vector<PointSplat> splats;
    const core::dmat4 clip_from_eye = gpuprims::reversed_clip_from_eye(view);
    const core::dmat4 eye_from_clip = glm::inverse(clip_from_eye);
    for (int i = 0; i < count; ++i) {
      const double distance = 3.0 + 9.0 * (i + 0.5) / count;  // none are equal
      const core::dvec4 at = clip_from_eye * core::dvec4(0.0, 0.0, -distance, 1.0);
      const core::dvec4 p =
          eye_from_clip * core::dvec4(random.uniform(-0.99, 0.99), random.uniform(-0.99, 0.99), at.z / at.w, 1.0);
      splats.push_back({glm::vec3(dvec3(p) / p.w), float(std::exp(random.uniform(std::log(0.05), std::log(9.0)))),
                        core::ItemId(3 * i), random.below(materials)});
    }
    return splats;
  }

  /// The mean over a ball's disc, seen from afar, of what shading_test.cpp says of a point.
  static dvec3 mean_shading(const dvec3& colour, const dvec3& to_eye, const dvec3& up) {
    dvec3 sum(0.0);
    int count = 0;
    const dvec3 side = glm::normalize(glm::cross(to_eye, std::abs(to_eye.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
    const dvec3 other = glm::cross(to_eye, side);
    constexpr int kSteps = 100;
    for (int i = -kSteps; i < kSteps; ++i)
      for (int j = -kSteps; j < kSteps; ++j) {
        const double x = (i + 0.5) / kSteps, y = (j + 0.5) / kSteps;
        if (x * x + y * y >= 1.0) continue;
        const double head = std::sqrt(1.0 - x * x - y * y);
        const dvec3 n = x * side + y * other + head * to_eye;
        sum += colour * (0.3 + 0.5 * head + 0.25 * (0.5 + 0.5 * glm::dot(n, up))) + 0.12 * std::pow(head, 24.0);
        ++count;
      }
    return 255.0 * glm::min(sum / double(count), dvec3(1.0));
  }

  std::vector<ShownSplat> expected(const View& view, std::span<const PointSplat> splats) const {
    const core::dmat4 clip_from_eye = gpuprims::reversed_clip_from_eye(view);
    const core::dmat4 world_from_eye = glm::inverse(view.eye_from_world());
    const dvec3 up = glm::normalize(core::dmat3(view.eye_from_world()) * dvec3(0, 0, 1));
    std::vector<ShownSplat> squares;
    for (const PointSplat& s : splats) {
      const core::dvec4 eye(dvec3(s.centre), 1.0), clip = clip_from_eye * eye;
      const dvec3 world(world_from_eye * eye);
      bool kept = view.sections.empty() || view.section_mode == core::SectionMode::kIntersection;
      for (const core::Plane& plane : view.sections) {
        const bool inside = glm::dot(plane.normal, world) + plane.offset >= 0.0;
        kept = view.section_mode == core::SectionMode::kIntersection ? kept && inside : kept || inside;
      }
      if (!kept) continue;
      const dvec3 to_eye = view.orthographic() ? dvec3(0, 0, 1) : -glm::normalize(dvec3(s.centre));
      const dvec3 colour = s.material == 0 ? dvec3(double(0.7f)) : dvec3(snapshot_->materials()[s.material - 1]);
      squares.push_back({(0.5 + 0.5 * clip.x / clip.w) * kWidth, (0.5 + 0.5 * clip.y / clip.w) * kHeight, 0.5 * s.side,
                         -double(s.centre.z), to_index(s.item) + 1, mean_shading(colour, to_eye, up)});
    }
    return squares;
  }

  /// The nearest square at a place, or null; `clear`: none has its border there.
  static const ShownSplat* at(const std::vector<ShownSplat>& squares, double x, double y, bool& clear) {
    const ShownSplat* nearest = nullptr;
    for (const ShownSplat& s : squares) {
      const double from = std::max(std::abs(x - s.x), std::abs(y - s.y));
      if (std::abs(from - s.half) < kUnclear) clear = false;
      if (from < s.half && (!nearest || s.distance < nearest->distance)) nearest = &s;
    }
    return nearest;
  }

  static std::vector<View> views() {
    const core::Pose pose{{3, -6, 2}, {0, 0, 0}, {0.5, 0, 1}};
    View cut = *View::perspective(pose, 0.7, kAspect, 0.1);
    cut.sections = {{{0.2, 1, 0.1}, 0.3}, {{-1, 0.1, 0}, 0.6}};
    View united = cut;
    united.section_mode = core::SectionMode::kUnion;
    View no_sections = *View::perspective(pose, 0.5, kAspect, 1.0, 40.0);
    no_sections.section_mode = core::SectionMode::kUnion;
    return {*View::perspective(pose, 0.7, kAspect, 0.1),
            *View::orthographic(pose, 5.0, kAspect, -20.0, 30.0),
            *View::asymmetric(pose, -0.04, 0.06, -0.05, 0.03, 0.1),
            cut,
            united,
            no_sections};
  }

  core::Scene scene_;
  std::optional<core::Snapshot> snapshot_;
  std::optional<gpuscene::GpuScene> gpu_;
};

TEST_F(PointSplatsTest, ShowSquaresOfTheirSizeColourAndDepth) {
  std::uint32_t seed = 1;
  for (const View& view : views()) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed++);
    const std::vector<PointSplat> splats = random_splats(random, view, 500, 3);
    const std::vector<ShownSplat> squares = expected(view, splats);
    EXPECT_EQ(view.sections.empty(), squares.size() == splats.size());
    const RenderTarget target = draw(view, {.ids = true, .normals = true}, splats);
    const image::Image colours = target.read_colour();
    const image::IdImage ids = target.read_ids();
    const image::DepthImage depth = target.read_depth(view);
    const image::NormalImage normals = target.read_normals();
    int shown = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        bool clear = true;
        const ShownSplat* square = at(squares, x + 0.5, y + 0.5, clear);
        if (!clear) continue;
        const std::size_t i = std::size_t((kHeight - 1 - y) * kWidth + x);
        ASSERT_EQ(ids.ids[i], square ? square->id : 0u) << "(" << x << ", " << y << ")";
        if (!square) continue;
        ++shown;
        ASSERT_NEAR(depth.metres[i], square->distance, 2e-5 * (1.0 + std::abs(square->distance)));
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(colours.pixels[3 * i + std::size_t(c)], square->colour[c], 1.0) << "(" << x << ", " << y << ")";
        ASSERT_GT(normals.normals[i][2], 0.0f);
      }
    EXPECT_GT(shown, kWidth * kHeight / 20);
  }
}

/// A pixel's colour is the mean of its samples'.
TEST_F(PointSplatsTest, CoverTheSamplesInside) {
  const View view = views()[0];
  Random random(7);
  const std::vector<PointSplat> splats = random_splats(random, view, 500, 3);
  const std::vector<ShownSplat> squares = expected(view, splats);
  const RenderTarget target = draw(view, {.samples = 4}, splats);
  const image::Image colours = target.read_colour();
  const dvec3 background = 255.0 * dvec3(0.86, 0.88, 0.91);
  int mixed = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      bool clear = true;
      int covered = 0;
      dvec3 sum(0.0);
      for (const glm::vec2& offset : target.sample_offsets()) {
        const ShownSplat* square = at(squares, x + 0.5 + double(offset.x), y + 0.5 + double(offset.y), clear);
        covered += square != nullptr;
        sum += square ? square->colour : background;
      }
      if (!clear) continue;
      mixed += covered > 0 && covered < 4;
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(colours.pixels[std::size_t(((kHeight - 1 - y) * kWidth + x) * 3 + c)], sum[c] / 4.0, 1.5)
            << "(" << x << ", " << y << ")";
    }
  EXPECT_GT(mixed, 200);
}

/// Half the pixels, in the pattern that the item has when it is drawn in full (shading_test.cpp).
TEST_F(PointSplatsTest, AreTransparentAsTheirMaterial) {
  const View view = *View::orthographic({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 10.0, kAspect, 0.0, 20.0);
  const PointSplat glass{{0, 0, -10}, 32.0f, core::ItemId{4}, 3};
  const RenderTarget target = draw(view, {.ids = true}, {&glass, 1});
  const image::IdImage ids = target.read_ids();
  EXPECT_EQ(std::count(ids.ids.begin(), ids.ids.end(), 5u), 32 * 32 / 2);
}

TEST_F(PointSplatsTest, DoNotHideWhatIsNearer) {
  const View view = *View::orthographic({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 10.0, kAspect, 0.0, 20.0);
  const PointSplat both[] = {{{0, 0, -5}, 4.0f, core::ItemId{1}, 0}, {{0, 0, -10}, 8.0f, core::ItemId{2}, 0}};
  const RenderTarget target = draw(view, {.ids = true}, both);
  const image::IdImage ids = target.read_ids();
  EXPECT_EQ(std::count(ids.ids.begin(), ids.ids.end(), 2u), 4 * 4);
  EXPECT_EQ(std::count(ids.ids.begin(), ids.ids.end(), 3u), 8 * 8 - 4 * 4);
}

}  // namespace
}  // namespace sightline::render::point_splats_test
