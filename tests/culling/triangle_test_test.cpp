// The sample test for triangles against a rasteriser: corners in float as a shader may compute them, moved to a grid or
// by as much as one may, and then every pixel centre against the moved triangle.
#include "sightline/culling/occlusion/internal/triangle_test.h"

#include <array>
#include <bit>
#include <cmath>

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/tests/support/instruction_sets.h"

namespace sightline::tests::triangle_test_test {
namespace {

using core::dvec2;
using core::dvec3;
using core::vec3;
using core::View;
using culling::ImageSamples;
using culling::TriangleTest;

/// A mesh of triangles without common corners.
struct Soup {
  std::vector<vec3> positions;
  std::vector<std::uint32_t> indices;
  core::Affine world_from_mesh;

  void add(const vec3& a, const vec3& b, const vec3& c) {
    for (const vec3& p : {a, b, c}) {
      indices.push_back(std::uint32_t(positions.size()));
      positions.push_back(p);
    }
  }
  std::size_t triangles() const { return indices.size() / 3; }
};

/// What a shader and a rasteriser make of a triangle.
class Rasteriser {
 public:
  Rasteriser(const View& view, const ImageSamples& samples, const core::Affine& world_from_mesh, Random& random)
      : samples_(samples), random_(random), clip_(view.clip_from_eye()) {
    const glm::mat3 eye_from_world{core::dmat3(view.eye_from_world())}, linear(world_from_mesh.linear);
    eye_from_mesh_ = eye_from_world * linear;
    origin_ = vec3(dvec3(view.eye_from_world() * core::dvec4(world_from_mesh.origin, 1.0)));
  }
  /// Whether a sample is covered. `front`: by a triangle that is counter-clockwise. Only of triangles before the eye.
  bool covers(const vec3& a, const vec3& b, const vec3& c, bool front) {
    const std::array<dvec2, 3> p{place(a), place(b), place(c)};
    const double area = cross(p[1] - p[0], p[2] - p[0]);
    if (area == 0.0 || (front && area < 0.0)) return false;
    for (const auto& offset : samples_.offsets)
      for (int y = 0; y < samples_.height; ++y)
        for (int x = 0; x < samples_.width; ++x) {
          const dvec2 at = dvec2(x, y) + dvec2(offset[0], offset[1]);
          bool inside = true;
          for (std::size_t i = 0; i < 3; ++i) inside &= cross(p[(i + 1) % 3] - p[i], at - p[i]) * area >= 0.0;
          if (inside) return true;
        }
    return false;
  }
  float w(const vec3& position) const { return clip(position).w; }

 private:
  static double cross(const dvec2& a, const dvec2& b) { return a.x * b.y - a.y * b.x; }
  glm::vec4 clip(const vec3& p) const {
    vec3 eye;
    for (int i = 0; i < 3; ++i) {  // in any order of the sum
      const float x = eye_from_mesh_[0][i] * p.x, y = eye_from_mesh_[1][i] * p.y, z = eye_from_mesh_[2][i] * p.z;
      eye[i] = (chance(random_, 0.5) ? (x + y) + z : std::fma(eye_from_mesh_[2][i], p.z, x + y)) + origin_[i];
    }
    return clip_ * glm::vec4(eye, 1.0f);
  }
  /// In pixels, centres at integers; on a grid of 1/256 pixels, or anywhere within the rasteriser's error.
  dvec2 place(const vec3& p) {
    const glm::vec4 at = clip(p);
    const dvec2 size(samples_.width, samples_.height);
    const dvec2 exact = 0.5 * size * (dvec2(at.x, at.y) / double(at.w) + 1.0) - 0.5;
    if (chance(random_, 0.5)) return glm::round(exact * 256.0) / 256.0;
    return exact + double(samples_.snap) * dvec2(uniform(random_, -1, 1), uniform(random_, -1, 1));
  }

  const ImageSamples& samples_;
  Random& random_;
  glm::mat4 clip_;
  glm::mat3 eye_from_mesh_;
  vec3 origin_;
};

ImageSamples random_image(Random& random) {
  ImageSamples samples{whole(random, 1, 9), whole(random, 1, 7), {{0, 0}}, culling::rasteriser_snap(8, 9, 9)};
  if (chance(random, 0.2)) samples.offsets = {{-0.375f, 0.125f}, {0.125f, 0.375f}, {0.375f, -0.125f}};
  return samples;
}

/// Triangles of all sizes and shapes about the pixels of an image.
Soup random_soup(Random& random, const View& view, const dvec3& origin, double half) {
  Soup soup;
  soup.world_from_mesh.origin = origin + point(random, half);
  for (int i = 0; i < 3; ++i) soup.world_from_mesh.linear[i] = dvec3(vec3(point(random, 1.0)));
  const core::dmat4 clip = view.clip_from_world();
  const core::dmat3 back = glm::inverse(soup.world_from_mesh.linear);
  const double pixel = magnitude(random, 1e-3, 3.0) / 4.0;
  for (int i = 0; i < 40; ++i) {
    const core::dvec4 at = clip * core::dvec4(origin + point(random, half), 1.0);
    const dvec2 centre(uniform(random, -1.2, 1.2), uniform(random, -1.2, 1.2));
    vec3 corners[3];
    for (vec3& corner : corners) {
      const dvec2 place = centre + pixel * dvec2(uniform(random, -1, 1), uniform(random, -1, 1));
      const double depth = std::abs(at.w) * uniform(random, 0.99, 1.01);
      const core::dvec4 world = glm::inverse(clip) * core::dvec4(place * depth, at.z, depth);
      corner = vec3(back * (dvec3(world) / world.w - soup.world_from_mesh.origin));
    }
    if (chance(random, 0.1)) corners[2] = 0.5f * (corners[0] + corners[1]);
    if (chance(random, 0.05)) corners[1] = corners[0];
    soup.add(corners[0], corners[1], corners[2]);
  }
  return soup;
}

std::vector<std::uint32_t> shown(const Soup& soup, const View& view, const ImageSamples& samples, bool front) {
  std::vector<std::uint32_t> result, first;
  for_each_instruction_set([&] {
    result.assign(soup.indices.size(), core::kNone);
    const TriangleTest test(view, samples);
    result.resize(
        TriangleTest::filter(test.of(soup.world_from_mesh, front), soup.positions, soup.indices, result.data()));
    if (first.empty()) first = result;
    ASSERT_EQ(result, first);
  });
  return result;
}

/// Whether the corners' places in the image are known within a hundredth of a pixel.
bool known_well(const culling::TriangleView& view, const vec3* corners) {
  double w = std::numeric_limits<double>::infinity(), lost_w = 0.0, lost = 0.0;
  for (int i = 0; i < 3; ++i) {
    const auto value = [&](const float(&f)[4], const vec3& p) {
      return double(f[0]) * p.x + double(f[1]) * p.y + double(f[2]) * p.z + double(f[3]);
    };
    w = std::min(w, value(view.w, corners[i]));
    lost_w = std::max(lost_w, value(view.lost_w, glm::abs(corners[i])));
    lost = std::max(lost, value(view.lost_place, glm::abs(corners[i])));
  }
  return w > 10.0 * lost_w && lost + 10.0 * lost_w < 0.01 * w;
}

TEST(TriangleTest, NeverRejectsATriangleThatASampleSees) {
  std::size_t covered = 0, kept = 0, judged = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = magnitude(random, 1e-2, 1e3);
    const dvec3 origin = chance(random, 0.5) ? dvec3(0.0) : point(random, 1e4 * half);
    const View view = random_view(random, origin, half);
    const ImageSamples samples = random_image(random);
    const Soup soup = random_soup(random, view, origin, half);
    const bool front = chance(random, 0.5);
    const TriangleTest test(view, samples);
    const std::vector<std::uint32_t> left = shown(soup, view, samples, front);
    Rasteriser rasteriser(view, samples, soup.world_from_mesh, random);
    std::size_t next = 0;
    for (std::size_t i = 0; i < soup.triangles(); ++i) {
      const vec3* p = &soup.positions[3 * i];
      const bool is_kept = next < left.size() && left[next] == soup.indices[3 * i];
      next += is_kept ? 3 : 0;
      if (!(std::min({rasteriser.w(p[0]), rasteriser.w(p[1]), rasteriser.w(p[2])}) > 0.0f)) {
        ASSERT_TRUE(is_kept) << "triangle " << i << " reaches behind the eye";
        continue;
      }
      const bool covers = rasteriser.covers(p[0], p[1], p[2], front);
      ASSERT_TRUE(is_kept || !covers) << "triangle " << i;
      covered += covers;
      if (samples.offsets.size() > 1 || !known_well(test.of(soup.world_from_mesh, front), p)) continue;
      kept += is_kept && !covers;
      ++judged;
    }
    ASSERT_EQ(next, left.size()) << "what is left is in order";
  }
  EXPECT_GT(covered, 2000u);
  EXPECT_GT(judged, 10'000u);
  EXPECT_LT(kept, judged / 20);
}

/// Coordinates that are not finite, and corners at and behind the eye.
TEST(TriangleTest, KeepsWhatItCannotJudge) {
  const View view = *View::perspective({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  Soup soup;
  const float infinite = std::numeric_limits<float>::infinity();
  soup.add({0, 0, 0}, {infinite, 0, 0}, {0, 0, 1});
  soup.add({0, 0, 0}, {std::nanf(""), 0, 0}, {0, 0, 1});
  soup.add({0, -10, 0}, {1, -10, 0}, {0, -10, 1});
  soup.add({0, -11, 0}, {1, -11, 0}, {0, -12, 1});
  soup.add({3e38f, 3e38f, 0}, {-3e38f, 0, 0}, {0, 0, 3e38f});
  EXPECT_EQ(shown(soup, view, {32, 32}, true), soup.indices);
}

TEST(TriangleTest, LeavesOutWhatLiesBetweenSamplesAndBackFaces) {
  const View view = *View::perspective({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  const auto pixel = float(20.0 * std::tan(0.5) / 100.0);
  const auto place = [&](float x, float y) { return vec3(x * pixel, 0.0f, y * pixel); };
  Soup soup;
  soup.add(place(0, 0), place(0.9f, 0), place(0, 0.9f));             // holds the centre at 0.5, 0.5: diagonal at 0.9
  soup.add(place(0, 0), place(1.1f, 0), place(0, 1.1f));             // holds it
  soup.add(place(0, 0), place(0, 1.1f), place(1.1f, 0));             // the same from behind
  soup.add(place(0.6f, 0.6f), place(1.4f, 0.6f), place(1, 1.4f));    // between four centres
  soup.add(place(0.1f, 0.3f), place(40, 0.4f), place(0.1f, 0.45f));  // between rows
  soup.add(place(-40, 0), place(40, 0), place(0, 40));
  soup.add(place(60, 0), place(90, 0), place(60, 40));  // outside
  const ImageSamples samples{100, 100, {{0, 0}}, culling::rasteriser_snap(8, 100, 100)};
  EXPECT_EQ(shown(soup, view, samples, false), (std::vector<std::uint32_t>{3, 4, 5, 6, 7, 8, 15, 16, 17}));
  EXPECT_EQ(shown(soup, view, samples, true), (std::vector<std::uint32_t>{3, 4, 5, 15, 16, 17}));
}

}  // namespace
}  // namespace sightline::tests::triangle_test_test
