// Culling alone, for an application with a renderer of its own: world boxes in, indices of the visible ones out. No
// scene, no OpenGL. The renderer here is a painter: it fills a rectangle per visible box, from far to near.
//   cull_only OUT.png
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include "sightline/culling/box_culler.h"
#include "sightline/render/image/image.h"

using namespace sightline;

namespace {

constexpr int kWidth = 480, kHeight = 320;

/// A town: streets along both axes, houses of many heights.
std::vector<core::AabbD> make_town() {
  std::vector<core::AabbD> houses;
  for (int x = 0; x < 300; ++x)
    for (int y = 0; y < 300; ++y) {
      const double height = 4.0 + 22.0 * std::abs(std::sin(0.37 * x) * std::cos(0.23 * y + 0.05 * x));
      const glm::dvec3 corner(20.0 * x, 20.0 * y, 0.0);
      houses.push_back({corner, corner + glm::dvec3(13.0, 13.0, height)});
    }
  return houses;
}

/// What a box covers on the screen, at least; false where it reaches behind the eye.
bool project(const core::AabbD& box, const glm::dmat4& clip_from_world, std::array<int, 4>& rectangle) {
  glm::dvec2 low(1e9), high(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                       corner & 4 ? box.max.z : box.min.z);
    const glm::dvec4 clip = clip_from_world * glm::dvec4(p, 1.0);
    if (clip.w <= 0.1) return false;
    const glm::dvec2 pixel((0.5 + 0.5 * clip.x / clip.w) * kWidth, (0.5 - 0.5 * clip.y / clip.w) * kHeight);
    low = glm::min(low, pixel);
    high = glm::max(high, pixel);
  }
  rectangle = {int(std::clamp(low.x, 0.0, double(kWidth))), int(std::clamp(low.y, 0.0, double(kHeight))),
               int(std::clamp(high.x, 0.0, double(kWidth))), int(std::clamp(high.y, 0.0, double(kHeight)))};
  return true;
}

void fill(image::Image& image, const std::array<int, 4>& rectangle, const glm::dvec3& colour) {
  for (int y = rectangle[1]; y < rectangle[3]; ++y)
    for (int x = rectangle[0]; x < rectangle[2]; ++x)
      for (int c = 0; c < 3; ++c)
        image.pixels[std::size_t(3 * (y * kWidth + x) + c)] = std::uint8_t(std::lround(255.0 * colour[c]));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: cull_only OUT.png\n"), 2;
  const std::vector<core::AabbD> houses = make_town();
  const auto culler = culling::BoxCuller::create(houses);
  if (!culler) return std::fprintf(stderr, "cull_only: %s\n", culler.error().message.c_str()), 1;

  const glm::dvec3 eye(2950.0, 2300.0, 60.0);
  const glm::dmat4 clip_from_world = glm::perspective(0.9, double(kWidth) / kHeight, 1.0, 4000.0) *
                                     glm::lookAt(eye, glm::dvec3(3050.0, 2800.0, 0.0), glm::dvec3(0, 0, 1));
  std::vector<std::uint32_t> visible;
  culler->visible(clip_from_world, core::ClipDepth::kMinusOneToOne, visible);
  std::printf("%zu of %zu houses are in the view\n", visible.size(), houses.size());

  const auto distance = [&](std::uint32_t i) { return glm::distance(eye, 0.5 * (houses[i].min + houses[i].max)); };
  std::sort(visible.begin(), visible.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::pair(distance(a), a) > std::pair(distance(b), b); });
  image::Image image{kWidth, kHeight, std::vector<std::uint8_t>(std::size_t(3 * kWidth * kHeight), 225)};
  for (const std::uint32_t i : visible) {
    std::array<int, 4> rectangle;
    if (!project(houses[i], clip_from_world, rectangle)) continue;
    const double haze = std::min(1.0, distance(i) / 3000.0);
    fill(image, rectangle, glm::mix(glm::dvec3(0.45 + 0.1 * (i % 3), 0.35, 0.3), glm::dvec3(0.88), haze));
  }
  const auto saved = image::write_png(image, argv[1]);
  return saved ? 0 : (std::fprintf(stderr, "cull_only: %s\n", saved.error().message.c_str()), 1);
}
