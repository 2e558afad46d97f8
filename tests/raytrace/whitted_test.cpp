// Images by rays against colours that are known, and against single rays.
#include "sightline/raytrace/whitted.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include "sightline/raytrace/exact_visibility.h"
#include "sightline/raytrace/internal/supersampling.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::raytrace::whitted_test {
namespace {

using core::dvec3;
using core::vec3;

/// Looks down on the square 0 … 8, one metre a pixel in an image of 8 x 8.
core::View from_above() {
  return *core::View::orthographic({{4, 4, 10}, {4, 4, 0}, {0, 1, 0}}, 8.0, 1.0, 1.0, 100.0);
}

/// A scene of plates, and its tracer.
struct Plates {
  core::Scene scene;
  std::optional<core::Snapshot> snapshot;
  std::optional<Tracer> tracer;

  core::MaterialId material(const vec3& colour, float alpha = 1.0f) {
    return scene.add_material({"", colour, alpha, 0});
  }
  core::ItemId add(const vec3& size, const dvec3& centre, core::MaterialId material) {
    return scene.add_primitive(scene.root(), core::Box{size.x, size.y, size.z}, core::translation(centre), material);
  }
  void build() {
    ASSERT_TRUE(scene.commit());
    snapshot.emplace(scene);
    tracer.emplace(std::move(*Tracer::create(*snapshot)));
  }
  WhittedImage render(const core::View& view, int size, const WhittedOptions& options) const {
    auto image = render_whitted(*tracer, view, size, size, options);
    EXPECT_TRUE(image);
    return image ? *image : WhittedImage();
  }
  WhittedImage render(const WhittedOptions& options) const { return render(from_above(), 8, options); }
};

std::array<int, 3> rgb(const WhittedImage& image, int x, int y) {
  const std::uint8_t* p = image.rgb.data() + 3 * (y * image.width + x);
  return {p[0], p[1], p[2]};
}
std::array<int, 3> rgb(const vec3& colour) {
  return {int(std::lround(255 * colour.x)), int(std::lround(255 * colour.y)), int(std::lround(255 * colour.z))};
}

/// A surface that looks up, lit from above: ambient, sky and head-light at their most.
vec3 lit_from_above(const vec3& colour) {
  return glm::min(colour * (0.30f + 0.25f + 0.50f) + 0.12f, vec3(1.0f));
}
vec3 in_shadow(const vec3& colour) {
  return colour * (0.30f + 0.25f);
}

const vec3 kRed{0.6f, 0.2f, 0.1f}, kBlue{0.1f, 0.2f, 0.5f};

TEST(Whitted, ShadesAsTheRenderer) {
  Plates plates;
  const core::ItemId red = plates.add({4, 8, 1}, {2, 4, 0}, plates.material(kRed));
  plates.build();
  const WhittedImage image = plates.render({});
  EXPECT_EQ(rgb(image, 1, 1), rgb(lit_from_above(kRed)));
  EXPECT_EQ(rgb(image, 6, 1), rgb(WhittedOptions().background));
  EXPECT_EQ(image.ids[1], to_index(red) + 1);
  EXPECT_EQ(image.ids[6], 0u);
  EXPECT_FLOAT_EQ(image.depths[1], 9.5f);
  EXPECT_TRUE(std::isinf(image.depths[6]));
  EXPECT_EQ(image.samples, 64u);
}

TEST(Whitted, AddsUpLights) {
  Plates plates;
  plates.add({8, 8, 1}, {4, 4, 0}, plates.material(kBlue));
  plates.build();
  const double slant = std::sqrt(0.5);
  WhittedOptions options;
  options.lights = {{{1, 0, 1}, true}, {{4.5, 4.5, 8.5}, false, {0, 1, 0}}, {{0, 0, -1}, true}};  // the last is below
  const auto gloss = [](double cosine) { return 0.12f * float(std::pow(cosine, 24.0)); };
  const float sun_gloss = gloss(std::cos(std::acos(slant) / 2));
  const vec3 sun = kBlue * float(0.5 * slant) + sun_gloss, lamp = vec3(0, 0.5f * kBlue.y + 0.12f, 0);
  EXPECT_EQ(rgb(plates.render(options), 4, 3), rgb(in_shadow(kBlue) + sun + lamp));  // right below the lamp
}

TEST(Whitted, CastsShadowsOnRequest) {
  Plates plates;
  plates.add({8, 8, 1}, {4, 4, 0}, plates.material(kRed));
  plates.add({2, 8, 1}, {3, 4, 3}, plates.material(kBlue));         // over columns 2 and 3
  plates.add({2, 8, 1}, {7, 4, 3}, plates.material(kBlue, 0.75f));  // over columns 6 and 7
  plates.build();
  WhittedOptions options;
  options.lights = {{{0, 0, 1}, true}};
  const auto left_of = [&](const WhittedImage& p) { return rgb(p, 0, 4); };
  EXPECT_EQ(left_of(plates.render(options)), rgb(lit_from_above(kRed)));
  options.lights = {{{2.0, 0.0, 2.5}, true}};  // shadows fall 2 m to the left, on columns 0, 1, 4 and 5
  const vec3 free = [&] {
    const WhittedImage lit = plates.render(options);
    return vec3(left_of(lit)[0], left_of(lit)[1], left_of(lit)[2]) / 255.0f;
  }();
  options.shadows = true;
  const WhittedImage image = plates.render(options);
  EXPECT_EQ(left_of(image), rgb(in_shadow(kRed)));
  // Both surfaces of the transparent plate take three quarters of the light.
  const vec3 dim = in_shadow(kRed) + (free - in_shadow(kRed)) / 16.0f;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb(image, 4, 4)[std::size_t(c)], 255.0f * dim[c], 1.0f);
}

TEST(Whitted, ShowsWhatIsBehindTransparentItems) {
  Plates plates;
  plates.add({8, 8, 1}, {4, 4, 0}, plates.material(kRed));
  const core::ItemId pane = plates.add({4, 8, 1}, {2, 4, 3}, plates.material(kBlue, 0.25f));
  plates.build();
  const WhittedImage image = plates.render({});
  // Two surfaces of the pane, both lit on the side that the eye sees.
  const vec3 behind = glm::mix(lit_from_above(kRed), lit_from_above(kBlue), 0.25f);
  const vec3 expected = glm::mix(behind, lit_from_above(kBlue), 0.25f);
  EXPECT_EQ(rgb(image, 1, 1), rgb(expected));
  EXPECT_EQ(image.ids[1], to_index(pane) + 1);
}

TEST(Whitted, Reflects) {
  // The view looks along y at a mirror that stands at 45 degrees, and sees in it a red plate to the right.
  Plates plates;
  const core::MaterialId mirror = plates.material(kBlue);
  const core::Affine turned{core::dmat3(glm::rotate(core::dmat4(1.0), 0.25 * std::numbers::pi, dvec3(0, 0, 1))),
                            {0, 10, 0}};
  plates.scene.add_primitive(plates.scene.root(), core::Box{8, 0.1f, 8}, turned, mirror);
  plates.add({0.1f, 8, 8}, {10, 10, 0}, plates.material(kRed));
  plates.build();
  const auto view = *core::View::orthographic({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 2.0, 1.0, 1.0, 100.0);
  WhittedOptions options;
  options.material_optics = {{1.0f, 1.0f}};  // of the first material alone
  // The head-light's sun comes along y, so it grazes the plate: ambient and half the sky are left.
  EXPECT_EQ(rgb(plates.render(view, 1, options), 0, 0), rgb(kRed * (0.30f + 0.125f)));
  options.max_depth = 1;
  EXPECT_EQ(rgb(plates.render(view, 1, options), 0, 0), rgb(options.background));
}

TEST(Whitted, RefractsByTheIndex) {
  // A slab of 2 m, met at 45 degrees, displaces rays sideways; a wall behind it ends half a metre to the right.
  for (const float index : {1.0f, 1.5f, 3.0f}) {
    Plates plates;
    const double angle = 0.25 * std::numbers::pi;
    const core::Affine turned{core::dmat3(glm::rotate(core::dmat4(1.0), angle, dvec3(0, 0, 1))), {0, 10, 0}};
    plates.scene.add_primitive(plates.scene.root(), core::Box{40, 2, 8}, turned, plates.material(kBlue, 0.0f));
    plates.add({100, 1, 8}, {-50 + 0.5, 30, 0}, plates.material(kRed));
    plates.build();
    const auto view = *core::View::orthographic({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 8.0, 1.0, 1.0, 100.0);
    WhittedOptions options;
    options.optics.refractive_index = index;
    const WhittedImage image = plates.render(view, 64, options);
    const vec3 facing = glm::min(kRed * (0.30f + 0.125f + 0.50f) + 0.12f, vec3(1.0f));
    int columns = 0;
    for (int x = 0; x < 64; ++x) columns += rgb(image, x, 32) == rgb(facing);
    // d sin(a - b) / cos(b), where sin a = index * sin b.
    const double inside = std::asin(std::sin(angle) / index);
    const double shift = 2.0 * std::sin(angle - inside) / std::cos(inside);
    EXPECT_NEAR(std::abs(columns / 8.0 - 4.5), shift, 0.13) << index;
  }
}

TEST(Whitted, MirrorsWhatCannotLeave) {
  // From inside glass, a ray that meets the surface at more than the critical angle goes back: here down to a floor.
  Plates plates;
  plates.add({100, 100, 10}, {0, 0, 0}, plates.material(kBlue, 0.0f));
  plates.add({100, 100, 1}, {0, 0, -2}, plates.material(kRed));
  plates.build();
  const auto view = *core::View::perspective({{-20, 0, 0}, {0, 0, 8}, {0, 0, 1}}, 0.01, 1.0, 0.1);
  WhittedOptions options;
  EXPECT_EQ(rgb(plates.render(view, 1, options), 0, 0), rgb(options.background));
  options.optics.refractive_index = 1.5f;
  const auto seen = rgb(plates.render(view, 1, options), 0, 0);
  EXPECT_GT(seen[0], 2 * seen[1]) << "the floor is red";
}

/// Cylinders in all directions, some of them transparent.
void fill(Plates& plates, unsigned seed) {
  tests::Random random(seed);
  const core::MaterialId materials[] = {plates.material(kRed), plates.material(kBlue), plates.material(kBlue, 0.5f)};
  for (int i = 0; i < 200; ++i)
    plates.scene.add_primitive(plates.scene.root(), core::Cylinder{0.3f, 2.0f},
                               {tests::random_rotation(random), 5.0 * tests::random_direction(random)},
                               materials[i % 3]);
  plates.build();
}
core::View from_outside() {
  return *core::View::perspective({{0, -20, 3}, {0, 0, 0}, {0, 0, 1}}, 0.6, 1.0, 0.1);
}

TEST(Whitted, ShowsTheMeanOfItsSamples) {
  Plates plates;
  plates.add({2.6f, 8, 1}, {1.3, 4, 0}, plates.material(kRed));
  plates.build();
  for (const int samples : {1, 2, 7, 16}) {
    int covered = 0;
    for (const core::dvec2& at : sample_positions(samples)) covered += at.x < 0.6;
    const vec3 mean = glm::mix(WhittedOptions().background, lit_from_above(kRed), float(covered) / float(samples));
    const WhittedImage image = plates.render({.samples = samples});
    EXPECT_EQ(rgb(image, 2, 3), rgb(mean)) << samples;
    EXPECT_EQ(image.samples, 64u * unsigned(samples));
  }
}

TEST(Whitted, AdaptivePixelsAreThoseOfOneSampleOrOfAll) {
  Plates plates;
  fill(plates, 2);
  constexpr int kSize = 48;
  const auto once = plates.render(from_outside(), kSize, {});
  const auto all = plates.render(from_outside(), kSize, {.samples = 4});
  for (const double threshold : {0.0, 0.1, 0.5, 1.0}) {
    const auto adaptive = plates.render(from_outside(), kSize, {.samples = 4, .edge_threshold = threshold});
    std::vector<vec3> colours(once.rgb.size() / 3);
    for (std::size_t i = 0; i < colours.size(); ++i)
      colours[i] = vec3(once.rgb[3 * i], once.rgb[3 * i + 1], once.rgb[3 * i + 2]) / 255.0f;
    const auto edges = mark_edges(colours, kSize, kSize, threshold);
    std::size_t refined = 0, doubtful = 0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const auto at = [&](const WhittedImage& p) { return rgb(p, int(i % kSize), int(i / kSize)); };
      const bool is_once = at(adaptive) == at(once), is_all = at(adaptive) == at(all);
      EXPECT_TRUE(is_once || is_all) << i;
      doubtful += edges[i] ? !is_all : !is_once;  // rounding to bytes moves gradients across the threshold
      refined += edges[i];
    }
    EXPECT_LT(doubtful, edges.size() / 50) << threshold;
    EXPECT_NEAR(double(adaptive.samples), double(edges.size() + 4 * refined), 0.1 * double(edges.size()));
    EXPECT_EQ(adaptive.ids, once.ids);
    EXPECT_EQ(adaptive.depths, once.depths);
  }
}

TEST(Whitted, DoesNotDependOnTheNumberOfThreads) {
  Plates plates;
  fill(plates, 3);
  WhittedOptions options{.samples = 3, .edge_threshold = 0.1, .shadows = true, .optics = {0.3f, 1.4f}, .threads = 1};
  const auto one = plates.render(from_outside(), 50, options);
  options.threads = 4;
  const auto four = plates.render(from_outside(), 50, options);
  EXPECT_EQ(one.rgb, four.rgb);
  EXPECT_EQ(one.ids, four.ids);
  EXPECT_EQ(one.samples, four.samples);
}

TEST(Whitted, TellsProgressAndStopsOnRequest) {
  Plates plates;
  fill(plates, 4);
  std::vector<double> shares;
  std::vector<std::vector<std::uint8_t>> previews;
  WhittedOptions options{.samples = 3, .threads = 1};
  options.progress = [&](double share) {
    shares.push_back(share);
    return true;
  };
  options.preview = [&](const WhittedImage& image) { previews.push_back(image.rgb); };
  const auto whole = plates.render(from_outside(), 40, options);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GT(shares.front(), 0.0);
  EXPECT_DOUBLE_EQ(shares.back(), 1.0);
  ASSERT_EQ(previews.size(), 2u);
  EXPECT_NE(previews[0], previews[1]);
  EXPECT_NE(previews[1], whole.rgb);
  int calls = 0;
  options.progress = [&](double) { return ++calls < 3; };
  const auto stopped = render_whitted(*plates.tracer, from_outside(), 40, 40, options);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().message, "cancelled");
  EXPECT_EQ(calls, 3);
}

TEST(Whitted, LightsMeshesByTheirNormals) {
  // A triangle whose corners' normals lean to x, under a sun from there.
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}};
  mesh.indices = {0, 1, 2};
  Plates plates;
  const auto brightness = [&](const std::vector<vec3>& normals) {
    Plates own;
    mesh.normals = normals;
    const auto added = own.scene.add_mesh(mesh);
    EXPECT_TRUE(added);
    own.scene.add_mesh_instance(own.scene.root(), *added);
    own.build();
    return rgb(own.render({.lights = {{{1, 0, 0}, true}}}), 1, 6);
  };
  const vec3 grey = core::Material().colour, up{0, 0, 1}, leaning = glm::normalize(vec3(1, 0, 1));
  EXPECT_EQ(brightness({}), rgb(in_shadow(grey)));
  EXPECT_EQ(brightness({up, up, up}), rgb(in_shadow(grey)));
  const float z = leaning.z, gloss = 0.12f;  // midway between sun and viewer
  EXPECT_EQ(brightness({leaning, leaning, leaning}),
            rgb(grey * (0.30f + 0.25f * (0.5f + 0.5f * z) + 0.5f * leaning.x) + gloss));
  const auto mixed = brightness({up, leaning, up});
  EXPECT_GT(mixed[0], rgb(in_shadow(grey))[0]);
}

/// As Lighting::kStudio does it, and no light alone.
TEST(Whitted, ShowsBlackAsAGreyInTheStudio) {
  Plates plates;
  plates.add({4, 8, 1}, {2, 4, 0}, plates.material(vec3(0.0f)));
  plates.add({4, 8, 1}, {6, 4, 0}, plates.material({1.0f, 0.0f, 0.2f}));
  plates.build();
  const WhittedImage plain = plates.render({}), studio = plates.render({.studio = true});
  EXPECT_EQ(rgb(plain, 1, 4), rgb(lit_from_above(vec3(0.0f))));
  EXPECT_EQ(rgb(studio, 1, 4), rgb(lit_from_above(vec3(0.25f))));
  EXPECT_EQ(rgb(studio, 6, 4), rgb(plain, 6, 4));
}

TEST(Whitted, RefusesOptionsOutOfRange) {
  Plates plates;
  plates.build();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<WhittedOptions> bad(9);
  bad[0].samples = 0;
  bad[1].max_depth = 0;
  bad[2].edge_threshold = -0.1;
  bad[3].edge_threshold = nan;
  bad[4].optics.reflectivity = 1.1f;
  bad[5].material_optics = {{0.0f, 0.0f}};
  bad[6].lights = {{{0, 0, 0}, true}};
  bad[7].lights = {{{nan, 0, 0}}};
  bad[8].lights = {{{0, 0, 1}, true, {-1, 0, 0}}};
  for (std::size_t i = 0; i < bad.size(); ++i)
    EXPECT_FALSE(render_whitted(*plates.tracer, from_above(), 8, 8, bad[i])) << i;
  EXPECT_FALSE(render_whitted(*plates.tracer, from_above(), 0, 8, {}));
  EXPECT_TRUE(render_whitted(*plates.tracer, from_above(), 8, 8, {}));
}

TEST(Supersampling, MarksEdges) {
  constexpr int kSize = 6;
  std::vector<vec3> step(kSize * kSize, vec3(0.5f));
  for (int y = 0; y < kSize; ++y)
    for (int x = 3; x < kSize; ++x) step[std::size_t(y * kSize + x)].z = 0.6f;
  for (const double threshold : {0.0, 0.39, 0.41}) {
    const auto edges = mark_edges(step, kSize, kSize, threshold);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        EXPECT_EQ(edges[std::size_t(y * kSize + x)], threshold < 0.4 && (x == 2 || x == 3)) << x << " " << y;
  }
  step[14] = vec3(100.0f);
  for (const std::uint8_t edge : mark_edges(step, kSize, kSize, 1.0)) EXPECT_EQ(edge, 0);
}

}  // namespace
}  // namespace sightline::raytrace::whitted_test
