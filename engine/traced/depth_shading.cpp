#include "sightline/engine/traced/internal/depth_shading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sightline/core/internal/scratch.h"

namespace sightline::engine {
namespace {

struct Step {
  int x, y;
};
constexpr std::array<Step, 4> kAxes{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}}, kWideAxes{{{5, 2}, {2, 5}, {-2, 5}, {-5, 2}}};
// As in the shader.
constexpr float kWide = 5.4f, kSteepest = 4.0f, kJump = 12.0f, kCreaseBegins = 0.7f, kCreaseIsFull = 1.4f, kFine = 0.2f;
constexpr int kThin = 4;
constexpr int kReach = 5;  // pixels: of the widest axis

struct RowBuffers {
  std::vector<float> per_pixel, dark;
  std::vector<std::uint8_t> lined;
  std::size_t memory_bytes() const { return core::bytes_of(per_pixel, dark, lined); }
};

float reach_of(std::size_t axis) {
  return axis < 2 ? 1.0f : 1.41421356f;
}

/// 0 on planes, towards 1 in corners and behind edges.
float hollow(float slope_sum) {
  const float h = std::max(0.0f, slope_sum);
  return h / (1.0f + h);
}

float smoothstep(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

class Shading {
 public:
  Shading(const ShadedImage& image, const glm::vec2& pixel_depth, const DepthShading& looks)
      : image_(image), pixel_depth_(pixel_depth), looks_(looks) {}

  void shade_row(int y) const {
    const core::Scratch<RowBuffers> buffers;
    find_slopes(y, *buffers);
    for (int x = 0; x < image_.width; ++x) {
      const float here = depth(x, y);
      float factor = 1.0f;
      if (here == 0.0f) {
        factor = 1.0f - looks_.edge_lines * outline(x, y);
      } else {
        const float line = buffers->lined[std::size_t(x)] ? line_at(x, y, buffers->per_pixel[std::size_t(x)]) : 0.0f;
        factor = (1.0f - looks_.strength * buffers->dark[std::size_t(x)] / 8.0f) * (1.0f - looks_.edge_lines * line);
      }
      if (factor < 1.0f) darken(image_.colours[at(x, y)], factor);
    }
  }

 private:
  std::size_t at(int x, int y) const { return std::size_t(y) * std::size_t(image_.width) + std::size_t(x); }
  float depth(int x, int y) const { return image_.depths[at(x, y)]; }
  float depth_near(int x, int y) const {
    return depth(std::clamp(x, 0, image_.width - 1), std::clamp(y, 0, image_.height - 1));
  }
  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < image_.width && y < image_.height; }

  /// Differences of depth to two opposite neighbours; none at the image's border, where one of them is missing.
  glm::vec2 steps(int x, int y, Step axis, float here) const {
    if (!inside(x + axis.x, y + axis.y) || !inside(x - axis.x, y - axis.y)) return {0.0f, 0.0f};
    return glm::vec2(depth(x + axis.x, y + axis.y), depth(x - axis.x, y - axis.y)) - here;
  }

  /// How dark each pixel of a row is, and whether a line may pass it. Within the image compilers make vectors of this.
  void find_slopes(int y, RowBuffers& row) const {
    const auto width = std::size_t(image_.width);
    row.per_pixel.resize(width);
    row.dark.assign(width, 0.0f);
    row.lined.assign(width, 0);
    for (int x = 0; x < image_.width; ++x)
      row.per_pixel[std::size_t(x)] = 1.0f / (pixel_depth_.x * depth(x, y) + pixel_depth_.y);
    const bool rows_inside = y >= kReach && y + kReach < image_.height;
    const int begin = rows_inside ? std::min(kReach, image_.width) : image_.width;
    const int end = std::max(begin, image_.width - kReach);
    for (int x = 0; x < begin; ++x) add_slopes(x, y, row);
    for (int x = end; x < image_.width; ++x) add_slopes(x, y, row);
    for (std::size_t i = 0; i < kAxes.size(); ++i) add_slopes(at(0, y), begin, end, i, row);
  }
  void add_slopes(int x, int y, RowBuffers& row) const {
    const float here = depth(x, y), per_pixel = row.per_pixel[std::size_t(x)];
    for (std::size_t i = 0; i < kAxes.size(); ++i) {
      const glm::vec2 near = steps(x, y, kAxes[i], here) * per_pixel / reach_of(i),
                      wide = steps(x, y, kWideAxes[i], here);
      add_slopes(near.x, near.y, (wide.x + wide.y) * per_pixel / kWide, row.dark[std::size_t(x)],
                 row.lined[std::size_t(x)]);
    }
  }
  void add_slopes(std::size_t first, int begin, int end, std::size_t axis, RowBuffers& row) const {
    const float* const z = image_.depths.data() + first;
    const auto offset = [&](Step step) { return std::ptrdiff_t(step.y) * image_.width + step.x; };
    const std::ptrdiff_t near = offset(kAxes[axis]), wide = offset(kWideAxes[axis]);
    const float reach = reach_of(axis);
    for (int x = begin; x < end; ++x) {
      const float here = z[x], per_pixel = row.per_pixel[std::size_t(x)];
      const float wide_sum = (z[x + wide] - here) + (z[x - wide] - here);
      add_slopes((z[x + near] - here) * per_pixel / reach, (z[x - near] - here) * per_pixel / reach,
                 wide_sum * per_pixel / kWide, row.dark[std::size_t(x)], row.lined[std::size_t(x)]);
    }
  }
  static void add_slopes(float a, float b, float wide, float& dark, std::uint8_t& lined) {
    const float change = a + b;
    const bool gap = std::min(a, b) > kJump;  // a pixel between two surfaces: detail too fine to be shaded
    dark += (gap ? 0.0f : hollow(change)) + hollow(wide);
    lined = std::uint8_t(lined | std::uint8_t(std::abs(change) > kCreaseBegins) | std::uint8_t(std::max(a, b) > kJump));
  }

  float line_at(int x, int y, float per_pixel) const {
    const float here = depth(x, y);
    float line = 0.0f;
    for (std::size_t i = 0; looks_.edge_lines > 0.0f && i < kAxes.size(); ++i) {
      const glm::vec2 slopes = steps(x, y, kAxes[i], here) * per_pixel / reach_of(i);
      const float change = slopes.x + slopes.y;
      float drawn = 0.0f;
      if (std::max(slopes.x, slopes.y) > kJump && std::abs(std::min(slopes.x, slopes.y)) < kSteepest)
        drawn = 1.0f;  // on a surface that begins behind another one
      else if (std::max(std::abs(slopes.x), std::abs(slopes.y)) < kSteepest)
        drawn = smoothstep(kCreaseBegins, kCreaseIsFull, std::abs(change));
      if (drawn > line) line = std::max(line, drawn * alone(x, y, kAxes[i], per_pixel / reach_of(i), change));
    }
    return line;
  }

  /// How strong a line is: fainter where slopes change as much two pixels off.
  float alone(int x, int y, Step axis, float to_slope, float change) const {
    float other = 0.0f;
    for (const int side : {-2, 2}) {
      const int beside_x = x + side * axis.x, beside_y = y + side * axis.y;
      const glm::vec2 around = steps(beside_x, beside_y, axis, depth_near(beside_x, beside_y));
      other = std::max(other, std::abs((around.x + around.y) * to_slope));
    }
    return glm::mix(1.0f, kFine, smoothstep(0.5f, 1.0f, other / std::min(std::abs(change), 2.0f * kJump)));
  }

  /// How strong an outline is where nothing is drawn: fainter beside what is thin.
  float outline(int x, int y) const {
    float drawn = 0.0f;
    for (const Step& step : {Step{1, 0}, Step{0, 1}, Step{-1, 0}, Step{0, -1}}) {
      if (depth_near(x + step.x, y + step.y) == 0.0f) continue;
      drawn = std::max(drawn, depth_near(x + kThin * step.x, y + kThin * step.y) > 0.0f ? 1.0f : kFine);
    }
    return drawn;
  }

  /// As blending does: of a factor and a result in bytes.
  static void darken(std::uint32_t& colour, float factor) {
    const auto share = std::uint32_t(255.0f * std::max(0.0f, factor) + 0.5f);
    const auto channel = [&](int shift) { return ((colour >> shift & 255u) * share + 127u) / 255u << shift; };
    colour = channel(0) | channel(8) | channel(16) | (colour & 0xff000000u);
  }

  const ShadedImage& image_;
  const glm::vec2 pixel_depth_;
  const DepthShading& looks_;
};

}  // namespace

void shade(const ShadedImage& image, const glm::vec2& pixel_depth, const DepthShading& looks,
           core::ThreadPool& threads) {
  const Shading shading(image, pixel_depth, looks);
  threads.run(std::uint32_t(image.height), [&](std::uint32_t row) { shading.shade_row(int(row)); });
}

}  // namespace sightline::engine
