#include "sightline/engine/traced/internal/edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sightline/core/internal/scratch.h"
#include "sightline/gpuprims/internal/view_block.h"

namespace sightline::engine {
namespace {

// As in the shaders.
constexpr float kGuard = 4.0f, kSteepestSurface = 32.0f, kRound = 3.0f;
constexpr glm::vec2 kBend{0.7f, 1.0f};
constexpr float kHidden = 0.3f, kShown = 0.7f;

constexpr int kBandRows = 16;

/// A part of a line in the image: pixels from the lower left corner, reversed depths.
struct ScreenLine {
  glm::vec2 from, to;
  float from_depth, to_depth, strength;
};

struct EdgeBuffers {
  std::vector<float> cover;  // of a band, row by row
  std::size_t memory_bytes() const { return core::bytes_of(cover); }
};

/// Lines in the image, and in which bands of its rows each lies.
class ScreenLines {
 public:
  ScreenLines(const core::View& view, int width, int height, float reach)
      : clip_from_eye_(gpuprims::reversed_clip_from_eye(view)),
        size_(width, height),
        reach_(reach),
        bands_(std::size_t((height + kBandRows - 1) / kBandRows)) {}

  std::size_t bands() const { return bands_.size(); }
  std::span<const std::uint32_t> in_band(std::size_t band) const { return bands_[band]; }
  const ScreenLine& operator[](std::uint32_t line) const { return lines_[line]; }

  void add(const EdgeLists& lists) {
    for (const render::MeshLines& mesh : lists.meshes()) {
      const glm::mat4 clip_from_mesh = clip_from_eye_ * mesh.eye_from_mesh;
      for (const render::EdgeSegment& s : std::span(lists.segments()).subspan(mesh.first, mesh.count))
        add(clip_from_mesh * glm::vec4(s.from, 1.0f), clip_from_mesh * glm::vec4(s.to, 1.0f), mesh.strength);
    }
    for (const render::CurvedLine& curve : lists.curves()) {
      glm::vec4 last = at(curve, 0);
      for (std::uint32_t part = 1; part <= curve.parts; ++part) {
        const glm::vec4 next = at(curve, part);
        add(last, next, curve.strength);
        last = next;
      }
    }
  }

 private:
  glm::vec4 at(const render::CurvedLine& curve, std::uint32_t part) const {
    const float t = curve.sweep * float(part) / float(curve.parts);
    return clip_from_eye_ * glm::vec4(curve.centre + std::cos(t) * curve.u + std::sin(t) * curve.v, 1.0f);
  }
  static float inside(const glm::vec4& p, int side) {
    return side == 4 ? p.w - p.z : kGuard * p.w + (side < 2 ? p.x : p.y) * ((side & 1) == 0 ? 1.0f : -1.0f);
  }
  glm::vec2 pixels(const glm::vec4& clip) const { return (0.5f + 0.5f * glm::vec2(clip) / clip.w) * size_; }

  void add(const glm::vec4& p, const glm::vec4& q, float strength) {
    float first = 0.0f, last = 1.0f;
    for (int side = 0; side < 5; ++side) {
      const float a = inside(p, side), b = inside(q, side);
      if (a < 0.0f && b < 0.0f) return;
      if (a < 0.0f) first = std::max(first, a / (a - b));
      if (b < 0.0f) last = std::min(last, a / (a - b));
    }
    const glm::vec4 a = glm::mix(p, q, first), b = glm::mix(p, q, last);
    if (!(first <= last) || !(a.w > 0.0f) || !(b.w > 0.0f)) return;
    const ScreenLine line{pixels(a), pixels(b), a.z / a.w, b.z / b.w, strength};
    const float low = std::min(line.from.y, line.to.y) - reach_, high = std::max(line.from.y, line.to.y) + reach_;
    if (!(high >= 0.0f && low < size_.y)) return;
    const auto index = std::uint32_t(lines_.size());
    lines_.push_back(line);
    const auto band_of = [&](float y) { return std::size_t(std::clamp(y, 0.0f, size_.y - 1.0f)) / kBandRows; };
    for (std::size_t band = band_of(low); band <= band_of(high); ++band) bands_[band].push_back(index);
  }

  glm::mat4 clip_from_eye_;
  glm::vec2 size_;
  float reach_;  // pixels, of a line beyond its middle
  std::vector<ScreenLine> lines_;
  std::vector<std::vector<std::uint32_t>> bands_;
};

/// Which points of lines an image shows.
class Visibility {
 public:
  Visibility(const ShadedImage& image, const glm::vec2& sample_place, const core::View& view, float surface_error)
      : image_(image),
        sample_place_(sample_place),
        pixel_depth_(gpuprims::pixel_depth(view, image.height)),
        hidden_pixels_(render::kHiddenPixels + surface_error),
        eye_from_clip_(glm::inverse(gpuprims::reversed_clip_from_eye(view))),
        unite_(view.section_mode == core::SectionMode::kUnion) {
    const glm::dmat4 world_from_eye = glm::inverse(view.eye_from_world());
    for (const core::Plane& plane : view.sections)
      if (plane.normal != core::dvec3(0.0))
        sections_.emplace_back(glm::transpose(world_from_eye) * core::dvec4(plane.normal, plane.offset) /
                               glm::length(plane.normal));
  }

  /// 0 … 1.
  float of(const glm::vec2& place, float depth) const {
    if (!(depth > 0.0f) || cut_away(place, depth)) return 0.0f;
    const glm::vec2 at = place - sample_place_, first = glm::floor(at), share = at - first;
    float found = 0.0f;
    for (int i = 0; i < 4; ++i) {
      const int right = i & 1, up = i >> 1;
      const float weight = (right ? share.x : 1.0f - share.x) * (up ? share.y : 1.0f - share.y);
      const int x = std::clamp(int(first.x) + right, 0, image_.width - 1),
                y = std::clamp(int(first.y) + up, 0, image_.height - 1);
      if (!hides(x, y, place, depth)) found += weight;
    }
    return glm::smoothstep(kHidden, kShown, found);
  }

 private:
  float depth_at(int x, int y) const {
    const auto row = std::size_t(std::clamp(y, 0, image_.height - 1)) * std::size_t(image_.width);
    return image_.depths[row + std::size_t(std::clamp(x, 0, image_.width - 1))];
  }
  bool hides(int x, int y, const glm::vec2& place, float depth) const {
    float here = depth_at(x, y);
    const float step = pixel_depth_.x * depth + pixel_depth_.y, reach = depth + hidden_pixels_ * step;
    if (here <= reach) return false;
    if (here > reach + kRound * kSteepestSurface * step) return true;
    const glm::vec2 from_sample = place - glm::vec2(x, y) - sample_place_;
    const float nearest = here;
    here += kindest({x, y}, {1, 0}, nearest, from_sample.x, step) + kindest({x, y}, {0, 1}, nearest, from_sample.y, step);
    return here > reach;
  }
  static float turning(float slope, float next, float ahead) {
    return ahead < 0.0f && std::abs(slope) > 1.1f * std::abs(next) ? kRound : 1.0f;
  }
  float kindest(const glm::ivec2& pixel, const glm::ivec2& axis, float here, float from_sample, float step) const {
    float least = 0.0f;
    for (const int side : {-1, 1}) {
      const glm::ivec2 once = pixel + side * axis, twice = once + side * axis;
      const float beside = depth_at(once.x, once.y), slope = beside - here, next = depth_at(twice.x, twice.y) - beside;
      if (std::abs(slope) <= kSteepestSurface * step &&
          std::abs(next - slope) <= kBend.x * std::abs(slope) + kBend.y * step)
        least = std::min(least, float(side) * slope * from_sample * turning(slope, next, float(side) * from_sample));
    }
    return least;
  }
  bool cut_away(const glm::vec2& place, float depth) const {
    if (sections_.empty()) return false;
    const glm::vec2 clip = place / glm::vec2(image_.width, image_.height) * 2.0f - 1.0f;
    const glm::vec4 at = eye_from_clip_ * glm::vec4(clip, depth, 1.0f);
    const core::vec3 eye = core::vec3(at) / at.w;
    const float margin = render::kSectionShare * glm::length(eye);
    for (const glm::vec4& plane : sections_)
      if ((glm::dot(core::vec3(plane), eye) + plane.w >= -margin) == unite_) return !unite_;
    return unite_;
  }

  const ShadedImage& image_;
  glm::vec2 sample_place_, pixel_depth_;
  float hidden_pixels_;
  glm::mat4 eye_from_clip_;
  bool unite_;
  std::vector<glm::vec4> sections_;
};

class Bands {
 public:
  Bands(const ShadedImage& image, const ScreenLines& lines, const Visibility& visibility,
        const render::LineStyle& style)
      : image_(image), lines_(lines), visibility_(visibility), half_width_(0.5f * style.width), colour_(style.colour) {}

  void draw(std::uint32_t band) const {
    if (lines_.in_band(band).empty()) return;
    const core::Scratch<EdgeBuffers> buffers;
    const int first = int(band) * kBandRows, end = std::min(first + kBandRows, image_.height);
    buffers->cover.assign(std::size_t(end - first) * std::size_t(image_.width), 0.0f);
    for (const std::uint32_t line : lines_.in_band(band)) cover(lines_[line], first, end, buffers->cover);
    const auto colours = image_.colours.subspan(std::size_t(first) * std::size_t(image_.width), buffers->cover.size());
    for (std::size_t i = 0; i < colours.size(); ++i)
      if (buffers->cover[i] > 0.0f) blend(colours[i], buffers->cover[i]);
  }

 private:
  /// Covers pixels of rows `first` … `end` - 1.
  void cover(const ScreenLine& line, int first, int end, std::span<float> covers) const {
    const glm::vec2 along = line.to - line.from;
    const float square = glm::dot(along, along), reach = half_width_ + 0.5f, length = std::sqrt(square);
    const float low = std::min(line.from.y, line.to.y) - reach, high = std::max(line.from.y, line.to.y) + reach;
    const int bottom = std::max(first, int(std::floor(std::max(low, 0.0f)))),
              top = std::min(end - 1, int(std::floor(std::min(high, float(image_.height)))));
    for (int y = bottom; y <= top; ++y) {
      float left = std::min(line.from.x, line.to.x) - reach, right = std::max(line.from.x, line.to.x) + reach;
      if (std::abs(along.y) > 1e-3f * length) {  // within reach of the line that goes on at both ends
        const float middle = line.from.x + (float(y) + 0.5f - line.from.y) * along.x / along.y,
                    half = reach * length / std::abs(along.y);
        left = std::max(left, middle - half), right = std::min(right, middle + half);
      }
      const int begin = int(std::max(0.0f, std::floor(left))), stop = int(std::min(float(image_.width - 1), right));
      for (int x = begin; x <= stop; ++x) {
        const glm::vec2 pixel(float(x) + 0.5f, float(y) + 0.5f);
        const float share = square > 0.0f ? std::clamp(glm::dot(pixel - line.from, along) / square, 0.0f, 1.0f) : 0.0f;
        const glm::vec2 place = line.from + share * along;
        const float full = line.strength * std::clamp(reach - glm::distance(pixel, place), 0.0f, 1.0f);
        float& there = covers[std::size_t(y - first) * std::size_t(image_.width) + std::size_t(x)];
        if (full <= there) continue;
        there = std::max(there, full * visibility_.of(place, glm::mix(line.from_depth, line.to_depth, share)));
      }
    }
  }
  void blend(std::uint32_t& pixel, float cover) const {
    const auto channel = [&](int shift, float colour) {
      const float mixed = float(pixel >> shift & 255u) * (1.0f - cover) + 255.0f * colour * cover;
      return std::uint32_t(std::clamp(mixed, 0.0f, 255.0f) + 0.5f) << shift;
    };
    pixel = channel(0, colour_.r) | channel(8, colour_.g) | channel(16, colour_.b) | (pixel & 0xff000000u);
  }

  const ShadedImage& image_;
  const ScreenLines& lines_;
  const Visibility& visibility_;
  float half_width_;
  core::vec3 colour_;
};

}  // namespace

void draw_edges(const ShadedImage& image, const glm::vec2& sample_place, const core::View& view, const EdgeLists& lists,
                const render::LineStyle& style, core::ThreadPool& threads) {
  ScreenLines lines(view, image.width, image.height, 0.5f * style.width + 0.5f);
  lines.add(lists);
  const Visibility visibility(image, sample_place, view, style.surface_error);
  const Bands bands(image, lines, visibility, style);
  threads.run(std::uint32_t(lines.bands()), [&](std::uint32_t band) { bands.draw(band); });
}

}  // namespace sightline::engine
