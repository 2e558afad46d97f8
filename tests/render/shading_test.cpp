// Colours as they are drawn, absolutely: a twin of the shading in double, for every kind, material and view; which
// pixels a transparent item shows; lines; and the colours of pixels of several samples.
#include <gtest/gtest.h>

#include "sightline/tests/render/image_check.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::shading_test {
namespace {

using core::Affine;
using core::dmat3;
using core::Material;
using core::Pose;
using core::View;

constexpr int kWidth = 72, kHeight = 56;
constexpr double kAspect = double(kWidth) / kHeight;
/// One for rounding to 8 bits, and as much as the light changes within the tolerances of normals.
constexpr double kLevels = 1.0;

/// From a surface point to the eye, in eye space.
dvec3 towards_eye(const View& view, const PixelRay& ray) {
  return -glm::normalize(dmat3(view.eye_from_world()) * ray.direction);
}

/// A light of half the strength, a sky that lights what looks up, and a highlight around the direction halfway between
/// light and eye, in 0 to 255; without lights the one at the eye. sRGB colours are lit as they are.
dvec3 shade(const dvec3& material, const dvec3& normal, const dvec3& to_eye, const View& view,
            std::span<const gpuprims::DistantLight> lights = {}) {
  // The studio, which alone has several lights, shows black as a grey of 0.25.
  const double dark = 1.0 - std::max({material.r, material.g, material.b}), black = lights.size() > 1 ? 0.25 : 0.0;
  const dvec3 colour = material + black * std::pow(dark, 4.0);
  const dmat3 eye_from_world(view.eye_from_world());
  const dvec3 up = glm::normalize(eye_from_world * dvec3(0, 0, 1));
  dvec3 lit = colour * (0.3 + 0.25 * (0.5 + 0.5 * glm::dot(normal, up)));
  const auto add = [&](const dvec3& towards, double strength) {
    const double cosine = glm::dot(normal, towards);
    if (cosine <= 0.0) return;
    const double gloss = std::max(0.0, glm::dot(normal, glm::normalize(towards + to_eye)));
    lit += strength * (0.5 * cosine * colour + 0.12 * std::pow(gloss, 24.0));
  };
  for (const gpuprims::DistantLight& light : lights)
    add(glm::normalize(eye_from_world * light.towards), light.strength);
  if (lights.empty()) add(to_eye, 1.0);
  return 255.0 * glm::min(lit, dvec3(1.0));
}

dvec3 pixel_of(const image::Image& image, std::size_t pixel) {
  return {image.pixels[3 * pixel], image.pixels[3 * pixel + 1], image.pixels[3 * pixel + 2]};
}

/// What a channel may be.
struct Range {
  dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};

  void add(const dvec3& colour) {
    low = glm::min(low, colour);
    high = glm::max(high, colour);
  }
  bool holds(const dvec3& colour, double slack) const {
    return glm::all(glm::greaterThanEqual(colour, low - slack)) && glm::all(glm::lessThanEqual(colour, high + slack));
  }
};

std::ostream& operator<<(std::ostream& out, const Range& range) {
  for (int c = 0; c < 3; ++c) out << (c ? ", " : "") << range.low[c] << " to " << range.high[c];
  return out;
}

struct Painted : Shape {
  dvec3 colour;
};

class Shading : public GlTest {
 protected:
  /// Solids and meshes around the origin, in colours of their own; one has no material.
  void add_solids() {
    const core::Primitive kinds[] = {core::Cylinder{0.5f, 1.2f},
                                     core::Snout{0.6f, 0.3f, 1, 0.2f, 0, 0, 0, 0, 0},
                                     core::CircularTorus{0.5f, 0.25f, 4},
                                     core::Sphere{1.1f},
                                     core::EllipticalDish{0.6f, 0.4f},
                                     core::SphericalDish{0.6f, 0.3f},
                                     core::RectangularTorus{0.3f, 0.7f, 0.5f, 4},
                                     core::Pyramid{1, 1, 0.5f, 0.4f, 0.1f, 0, 1},
                                     core::Box{0.9f, 0.8f, 1}};
    ball_ = gpuprims::tessellate(core::Sphere{1.2f}, {.fixed_segments = 16});
    facets_ = gpuprims::tessellate(core::Cylinder{0.5f, 1.0f}, {.fixed_segments = 7});
    facets_.normals.clear();
    const core::vec3 colours[] = {{1, 0, 0},          {0, 1, 0},          {0, 0, 1},          {1, 1, 1},
                                  {0, 0, 0},          {0.9f, 0.5f, 0.1f}, {0.2f, 0.3f, 0.8f}, {0.1f, 0.6f, 0.5f},
                                  {0.0f, 0.0f, 0.0f}, {0.1f, 0.1f, 0.2f}};
    for (int i = 0; i < 12; ++i) {
      Painted item;
      const double turned = 0.7 * i;
      item.world_from_item = {
          dmat3(std::cos(turned), 0.2, std::sin(turned), 0, 1, -0.3, -std::sin(turned), 0.1, std::cos(turned)),
          {1.5 * (i % 4) - 2.2, 1.5 * (i / 4 % 3) - 1.5, 0.8 * (i % 3) - 0.8}};
      Material material;
      material.colour = colours[std::size_t(i) % std::size(colours)];
      const bool plain = i == 4;
      item.colour = plain ? dvec3(double(0.7f)) : dvec3(material.colour);
      const core::MaterialId id = plain ? core::MaterialId{} : scene_.add_material(material);
      if (i < 9) item.primitive = kinds[i];
      if (i == 9) item.primitive = core::Box{0.5f, 1.2f, 0.3f};
      if (i > 9) item.mesh = i == 10 ? &ball_ : &facets_;
      item.item = item.mesh ? scene_.add_mesh_instance(scene_.root(), scene_.add_mesh(*item.mesh).value(),
                                                       item.world_from_item, id)
                            : scene_.add_primitive(scene_.root(), item.primitive, item.world_from_item, id);
      shapes_.push_back(item);
      colours_.push_back(item.colour);
    }
  }

  Range colours_around(const PixelHits& around, const View& view, const dvec3& to_eye, const dvec3& background,
                       std::span<const gpuprims::DistantLight> lights) const {
    Range range;
    for (const RayHit& seen_hit : around.hits_around)
      range.add(seen_hit.hit()
                    ? shade(colours_[to_index(seen_hit.items.front())], seen_hit.normal, to_eye, view, lights)
                    : background);
    return range;
  }

  static std::vector<View> views() {
    View cut = *View::perspective({{3, -6, 2}, {0, 0, 0}, {0.5, 0, 1}}, 0.7, kAspect, 0.1);
    cut.sections = {{{0.2, 1, 0.1}, 0.3}, {{-1, 0.1, 0}, 1.6}};
    return {*View::perspective({{4, -5, 3}, {0, 0, 0}, {0, 0, 1}}, 0.7, kAspect, 0.1),
            *View::perspective({{-5, -3, -4}, {0, 0, 0}, {1, 0.3, -0.2}}, 0.7, kAspect, 0.1, 20.0),
            *View::perspective({{0.5, 0.3, 7}, {0, 0, 0}, {0, 1, 0}}, 0.9, kAspect, 0.1),
            *View::orthographic({{3, 6, 1}, {0, 0, 0}, {0, 0, -1}}, 5.0, kAspect, -20.0, 30.0),
            *View::asymmetric({{-6, 2, 2}, {0, 0, 0}, {0, 1, 1}}, -0.04, 0.06, -0.05, 0.03, 0.1),
            cut};
  }

  core::Scene scene_;
  core::Mesh ball_, facets_;
  std::vector<Shape> shapes_;
  std::vector<dvec3> colours_;
};

class ShadingByLights : public Shading, public testing::WithParamInterface<gpuprims::Lighting> {};
INSTANTIATE_TEST_SUITE_P(, ShadingByLights,
                         testing::Values(gpuprims::Lighting::kHeadLight, gpuprims::Lighting::kStudio,
                                         gpuprims::Lighting::kSun),
                         [](const auto& tried) { return std::string(name_of(tried.param), 0, 4); });

TEST_P(ShadingByLights, IsThatOfTheTwin) {
  add_solids();
  Camera camera(*context, scene_, kWidth, kHeight);
  const dvec3 sun(2.0, -1.0, 0.5);
  camera.renderer().lighting = GetParam();
  camera.renderer().sun = sun;
  const auto& b = camera.background();
  const dvec3 background = 255.0 * dvec3(b[0], b[1], b[2]);
  EXPECT_EQ(background, 255.0 * dvec3(0.86f, 0.88f, 0.91f));
  int number = 0;
  for (const View& view : views()) {
    SCOPED_TRACE(testing::Message() << "view " << number++);
    const Image image = camera.draw(view, shapes_);
    const std::vector<PixelHits> seen = look_at(shapes_, view, kWidth, kHeight);
    const Compared compared = compare(image, seen, {1e-5, 0.1});
    EXPECT_GT(compared.clear, kWidth * kHeight / 16);
    const auto lights = gpuprims::distant_lights(view, GetParam(), sun);
    std::vector<int> shown(shapes_.size());
    for (std::size_t pixel = 0; pixel < seen.size(); ++pixel) {
      const int x = int(pixel) % kWidth, y = int(pixel) / kWidth;
      const dvec3 to_eye = towards_eye(view, pixel_ray(view, kWidth, kHeight, x, y));
      Range range;
      if (seen[pixel].clear()) {  // elsewhere between what is near
        const RayHit& seen_hit = seen[pixel].centre();
        range.add(seen_hit.hit() ? shade(colours_[to_index(seen_hit.items[0])], seen_hit.normal, to_eye, view, lights)
                                 : background);
        if (seen_hit.hit()) ++shown[to_index(seen_hit.items[0])];
      } else {
        range = colours_around(seen[pixel], view, to_eye, background, lights);
      }
      const double slack = seen[pixel].clear() ? kLevels : 4.0 * kLevels;
      ASSERT_TRUE(range.holds(pixel_of(image.colour, pixel), slack))
          << "(" << x << ", " << y << "): " << testing::PrintToString(image.ids.ids[pixel]) << " "
          << pixel_of(image.colour, pixel).x << ", " << pixel_of(image.colour, pixel).y << ", "
          << pixel_of(image.colour, pixel).z << ", not " << range;
    }
    if (view.sections.empty()) {
      EXPECT_GE(std::count_if(shown.begin(), shown.end(), [](int n) { return n > 10; }), 8) << "items shown";
    }
  }
}

/// Order in which the pixels of a 4 x 4 pattern fill: Bayer's, of two 2 x 2 ones.
int filled(int x, int y) {
  constexpr int kOf2x2[2][2] = {{0, 2}, {3, 1}};
  return 4 * kOf2x2[y & 1][x & 1] + kOf2x2[y >> 1 & 1][x >> 1 & 1];
}

/// x, y from the bottom left. Patterns are shifted from item to item.
bool shown(double alpha, core::ItemId item, int x, int y) {
  return alpha >= (filled((x + 7 * int(item)) & 3, (y + 3 * int(item)) & 3) + 0.5) / 16.0;
}

/// Solids and meshes, whole and cut, in front of a wall.
TEST_F(Shading, ShowsTransparentItemsInTheirPatternOfPixels) {
  const core::Mesh block = gpuprims::tessellate(core::Box{4, 4, 4});
  const core::MeshId mesh = scene_.add_mesh(block).value();
  const core::ItemId wall = scene_.add_primitive(scene_.root(), core::Box{20, 1, 20}, core::translation({0, 8, 0}));
  std::vector<float> alphas = {0.0f, 0.1f, 1.0f};
  for (int level = 0; level < 16; ++level)
    alphas.push_back((float(level) + 0.5f) / 16.0f);  // shows one pixel more each
  struct Pane {
    core::ItemId item;
    float alpha;
  };
  std::vector<Pane> panes;
  for (const float alpha : alphas) {
    Material material{"", {0.2f, 0.4f, 0.6f}, alpha};
    const core::MaterialId id = scene_.add_material(material);
    panes.push_back({scene_.add_primitive(scene_.root(), core::Box{4, 4, 4}, {}, id), alpha});
    panes.push_back({scene_.add_primitive(scene_.root(), core::Cylinder{2, 4}, {}, id), alpha});
    panes.push_back({scene_.add_mesh_instance(scene_.root(), mesh, {}, id), alpha});
  }
  Camera camera(*context, scene_, kWidth, kHeight);
  View view = *View::perspective({{0, -6, 0}, {0, 0, 0}, {0, 0, 1}}, 0.25, kAspect, 0.1);
  for (const bool cut : {false, true}) {
    if (cut) view.sections = {{{0, 1, 0}, 1.0}};
    for (const Pane& pane : panes) {
      SCOPED_TRACE(testing::Message() << "item " << to_index(pane.item) << ", alpha " << pane.alpha
                                      << (cut ? ", cut" : ""));
      std::vector<Shape> both(2);
      both[0].item = pane.item;
      both[1].item = wall;
      const Image image = camera.draw(view, both);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const core::ItemId expected = shown(pane.alpha, pane.item, x, kHeight - 1 - y) ? pane.item : wall;
          ASSERT_EQ(image.ids.ids[std::size_t(y * kWidth + x)], to_index(expected) + 1) << "(" << x << ", " << y << ")";
        }
    }
  }
}

/// A pixel in each column (or row) that a line runs through, the nearest to it, and lit as if it faced the viewer.
TEST_F(Shading, OfLinesIsThatOfWhatFacesTheViewer) {
  const dvec3 from(-1.3, 0.2, -0.7), to(1.1, -0.4, 0.9);
  const dmat3 steep(dvec3(to.z - from.z, 0.3, to.x - from.x), dvec3(0.0, 1.0, 0.0), dvec3(0.0, 0.0, 1.0));
  const Affine flat{dmat3(to - from, dvec3(0, 1, 0), dvec3(0, 0, 1)), from};
  Material material;
  material.colour = {0.8f, 0.1f, 0.4f};
  const core::MaterialId id = scene_.add_material(material);
  std::vector<Shape> lines(3);
  lines[0].world_from_item = flat;
  lines[1].world_from_item = {steep, {-0.5, 0.1, -1.2}};
  lines[2].world_from_item = {dmat3(dvec3(3, 1, -2), dvec3(0, 1, 0), dvec3(0, 0, 1)), {-1.5, 0, 1.0}};
  const core::Line kinds[] = {{0, 1}, {0.1f, 0.9f}, {-0.3f, 0.4f}};
  for (std::size_t i = 0; i < 3; ++i)
    lines[i].item = scene_.add_primitive(scene_.root(), kinds[i], lines[i].world_from_item, id);
  Camera camera(*context, scene_, kWidth, kHeight);
  std::vector<View> from_here = {*View::perspective({{0.5, -4, 0.3}, {0, 0, 0}, {0, 0, 1}}, 0.9, kAspect, 0.1),
                                 *View::orthographic({{-1, -5, 1}, {0, 0, 0}, {0.2, 0, 1}}, 3.6, kAspect, 0.0, 20.0)};
  from_here.push_back(from_here[0]);
  from_here.back().sections = {{{1, 0.1, 0.2}, 0.21}};
  for (const View& view : from_here)
    for (std::size_t i = 0; i < 3; ++i) {
      SCOPED_TRACE(testing::Message() << "view " << &view - from_here.data() << ", line " << i);
      const Image image = camera.draw(view, {&lines[i], 1});
      // In steps along its longer axis on the screen.
      const auto at = [&](double s) {
        return lines[i].world_from_item.origin + s * lines[i].world_from_item.linear[0];
      };
      const auto on_screen = [&](double s) {
        const dvec4 clip = view.clip_from_world() * dvec4(at(s), 1.0);
        return core::dvec2((0.5 + 0.5 * clip.x / clip.w) * kWidth - 0.5, (0.5 - 0.5 * clip.y / clip.w) * kHeight - 0.5);
      };
      const core::dvec2 a = on_screen(kinds[i].from), b = on_screen(kinds[i].to);
      const int major = std::abs(b.x - a.x) > std::abs(b.y - a.y) ? 0 : 1;
      // Implementations differ in where along the line they take a pixel's depth.
      const double half_a_pixel = 0.5 / std::abs(b[major] - a[major]) *
                                  std::abs((view.eye_from_world() * dvec4(at(kinds[i].to) - at(kinds[i].from), 0.0)).z);
      std::vector<int> steps(std::size_t(std::max(kWidth, kHeight)));
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const std::size_t pixel = std::size_t(y * kWidth + x);
          if (image.ids.ids[pixel] == 0) continue;
          ASSERT_EQ(image.ids.ids[pixel], to_index(lines[i].item) + 1);
          const core::dvec2 p(x, y);
          ++steps[std::size_t(p[major])];
          double low = kinds[i].from, high = kinds[i].to;  // of the line's point nearest to the pixel
          for (int k = 0; k < 60; ++k) {
            const double middle = 0.5 * (low + high);
            (glm::dot(on_screen(middle) - p, b - a) < 0.0 ? low : high) = middle;
          }
          ASSERT_LE(glm::length(on_screen(low) - p), 0.5 + kReach) << "(" << x << ", " << y << ")";
          const dvec3 eye(view.eye_from_world() * dvec4(at(low), 1.0));
          ASSERT_NEAR(image.depth.metres[pixel], -eye.z, half_a_pixel + 1e-5) << "(" << x << ", " << y << ")";
          ASSERT_TRUE(sections_keep(view, at(low)) || sections_keep(view, at(low + 0.01)) ||
                      sections_keep(view, at(low - 0.01)));
          Range range;
          range.add(shade(dvec3(material.colour), {0, 0, 1}, towards_eye(view, pixel_ray(view, kWidth, kHeight, x, y)),
                          view));
          ASSERT_TRUE(range.holds(pixel_of(image.colour, pixel), 1.5 * kLevels))
              << "(" << x << ", " << y << "): " << range;
        }
      for (int step = 0; step < int(steps.size()); ++step) {
        const double within = std::min(step - std::min(a[major], b[major]), std::max(a[major], b[major]) - step);
        if (within < -1.0 || step >= (major == 0 ? kWidth : kHeight)) {
          EXPECT_EQ(steps[std::size_t(step)], 0);
        } else if (within > 1.0 && view.sections.empty()) {
          EXPECT_EQ(steps[std::size_t(step)], 1) << "step " << step;
        }
      }
      if (view.sections.empty()) {
        EXPECT_GT(std::count(steps.begin(), steps.end(), 1), 10);
      }
    }
}

/// A pixel of several samples is the mean of what they show. An item's are lit once for all of them, as any of them is.
TEST_F(Shading, OfSamplesIsTheirMean) {
  constexpr int kSamples = 4;
  add_solids();
  Camera camera(*context, scene_, kWidth, kHeight, kSamples);
  const auto& offsets = camera.target().sample_offsets();
  const auto& b = camera.background();
  const dvec3 background = 255.0 * dvec3(b[0], b[1], b[2]);
  View view = views()[0];
  int mixed = 0;
  for (const Shape& shape : shapes_) {  // one by one
    SCOPED_TRACE(testing::Message() << "item " << to_index(shape.item));
    const Image image = camera.draw(view, {&shape, 1});
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const dvec3 to_eye = towards_eye(view, pixel_ray(view, kWidth, kHeight, x, y));
        Range range;
        int surely = 0, perhaps = 0;
        for (const glm::vec2& offset : offsets) {
          const PixelHits around =
              look_around({&shape, 1}, view, kWidth, kHeight, x + double(offset.x), y - double(offset.y));
          surely += around.hits == 5;
          perhaps += around.hits > 0;
          for (const RayHit& seen_hit : around.hits_around)
            if (seen_hit.hit()) range.add(shade(colours_[to_index(shape.item)], seen_hit.normal, to_eye, view));
        }
        Range means;
        for (int covered = surely; covered <= perhaps; ++covered)
          for (const dvec3& colour : {range.low, range.high})
            means.add(covered == 0
                          ? background
                          : (double(covered) * colour + double(kSamples - covered) * background) / double(kSamples));
        mixed += surely > 0 && perhaps < kSamples;
        const std::size_t pixel = std::size_t(y * kWidth + x);
        const dvec3 found = pixel_of(image.colour, pixel);
        ASSERT_TRUE(means.holds(found, 2.0 * kLevels))
            << "(" << x << ", " << y << "): " << found.x << ", " << found.y << ", " << found.z << ", not " << means
            << ", " << surely << " to " << perhaps << " samples";
      }
  }
  EXPECT_GT(mixed, 200);
}

}  // namespace
}  // namespace sightline::tests::shading_test
