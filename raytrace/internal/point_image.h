// An image whose pixels keep the points that they show, so that it can follow a moving camera. Internal to raytrace
// and engine.
//
// After B. Walter, G. Drettakis and S. Parker, "Interactive Rendering using the Render Cache" (1999): the image of the
// next view shows each point where that view has it, and of several in a pixel the nearest.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sightline/core/internal/scratch.h"
#include "sightline/core/ray.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/gpuprims/surroundings.h"

namespace sightline::raytrace {

/// Rows are counted from the bottom up. Costs 58 bytes a pixel.
class PointImage {
 public:
  static constexpr int kBlock = 16;  // pixels a side
  static constexpr std::size_t kPixels = std::size_t(kBlock) * kBlock;

  /// In views since a point was found: of the present view; the oldest that are told apart; of a point between nearer
  /// ones, as cracks in a surface show that comes nearer; of a pixel without a point. The background has moved past the
  /// surfaces before it, so where these lie around, its age is increased by kHidden, and the pixel shows one of them.
  /// Assumed background has not been found by a ray of its own.
  static constexpr std::uint8_t kNew = 0, kOldest = 63, kDoubtful = 64, kAssumed = 65, kHidden = 128, kNoPoint = 255;

  /// An image, row by row from the bottom up.
  struct Pixels {
    std::span<const std::uint32_t> colours;  ///< red in the lowest byte, then g, b, 255
    std::span<const float> depths;           ///< reversed, 0 to 1; 0: the background
    std::span<const std::uint32_t> ids;      ///< item + 1; 0: the background
  };

  /// Forgets all points.
  void reset(int width, int height, const core::View& view);
  /// Takes the points of an image of this view that is there, in the form in which this one has them. Without ids what
  /// has a depth is a surface.
  void take(int width, int height, const core::View& view, const Pixels& image, core::ThreadPool& threads);
  /// Puts the points where another view has them. What shows the background gets that of its new row.
  void follow(const core::View& view, const gpuprims::Background& background, core::ThreadPool& threads);
  /// Lets a pixel show a point. `id`: item + 1. Several threads may set different pixels.
  void set(std::size_t pixel, const core::dvec3& point, std::uint32_t id, std::uint32_t colour);
  /// Lets it show the background, which its ray has found by missing everything, or is assumed to. It lies very far
  /// away; in orthographic views, where that would leave the image with any turn, midway between the near and the far
  /// plane.
  void set_background(std::size_t pixel, const core::Ray& ray, const gpuprims::Background& background,
                      std::uint8_t age = kNew);
  /// Lets pixels without a point show that of a neighbour: of the smallest cell of 2 x 2 pixels, 4 x 4, and so on that
  /// has any, the farthest, since what a near thing uncovers lies behind it; the background only where there is no
  /// other. They stay without a point.
  void fill(const gpuprims::Background& background, core::ThreadPool& threads);

  int width() const { return width_; }
  int height() const { return height_; }
  int columns() const { return (width_ + kBlock - 1) / kBlock; }  ///< of blocks
  int rows() const { return (height_ + kBlock - 1) / kBlock; }
  std::size_t at(int x, int y) const { return std::size_t(y) * std::size_t(width_) + std::size_t(x); }
  /// Calls visit(pixel, x, y) for the pixels of a block, by 4 x 4 of them, which are traced together.
  template <class Visit>
  void for_each(int column, int row, const Visit& visit) const {
    const int right = std::min(width_, (column + 1) * kBlock), top = std::min(height_, (row + 1) * kBlock);
    for (int bottom = row * kBlock; bottom < top; bottom += 4)
      for (int left = column * kBlock; left < right; left += 4)
        for (int y = bottom; y < std::min(top, bottom + 4); ++y)
          for (int x = left; x < std::min(right, left + 4); ++x) visit(at(x, y), x, y);
  }

  std::size_t memory_bytes() const {
    return now_.memory_bytes() + before_.memory_bytes() + depths_.size() * sizeof(nearest_[0]) +
           core::bytes_of(ids_, depths_, surfaces_, farthest_);
  }
  Pixels pixels() const { return {now_.colour, depths_, ids_}; }
  std::span<const std::uint8_t> ages() const { return now_.age; }  ///< by pixel
  /// Views for which a pixel of that age has waited, as it counts: doubtful points and none at all are the oldest.
  static constexpr std::uint32_t waited(std::uint8_t age) {
    constexpr std::uint32_t kOfAssumed = 16;
    if (age == kAssumed) return kOfAssumed;
    return std::min<std::uint32_t>(age == kNoPoint ? age : age & ~kHidden, kDoubtful);
  }
  /// Whether a pixel of that age shows its own point.
  static constexpr bool shows_own(std::uint8_t age) { return age < kHidden; }

 private:
  struct Point {
    core::vec3 place;  // in the world, relative to origin_
    std::uint32_t id;
  };
  struct Points {
    std::vector<Point> point;
    std::vector<std::uint32_t> colour;
    std::vector<std::uint8_t> age;
    std::size_t memory_bytes() const { return core::bytes_of(point, colour, age); }
  };
  void project_row(const glm::mat4& pixels, int row);
  void take_row(const core::vec3& step, std::uint32_t background, int row);
  void doubt_row(int row);
  bool moved_past(std::size_t surface, std::size_t background, int distance) const;
  bool passed_by(int x, int y, int dx, int dy) const;
  void hide_background_row(int row);
  std::size_t surface_words() const { return std::size_t(width_) / 64 + 1; }
  std::uint64_t surfaces_from(int row, std::ptrdiff_t first) const;
  std::uint32_t background_of(const gpuprims::Background& background, int row) const;
  std::uint32_t farther(std::uint32_t a, std::uint32_t b) const;
  void show(std::size_t pixel, std::uint32_t from, std::uint32_t background);
  bool fill_block(int column, int row, const gpuprims::Background& background);
  void fill_empty_blocks(const gpuprims::Background& background, core::ThreadPool& threads);

  int width_ = 0, height_ = 0;
  core::dvec3 origin_{0.0};
  glm::mat4 clip_{1.0f};  // reversed clip space from places
  bool orthographic_ = false;
  Points now_, before_;
  std::vector<std::uint32_t> ids_;
  std::vector<float> depths_;
  // By pixel: the reversed depth of the nearest point there, and its pixel before + 1.
  std::unique_ptr<std::atomic<std::uint64_t>[]> nearest_;
  std::vector<std::uint64_t> surfaces_;  // of follow(): a bit per pixel with a surface, surface_words() a row
  std::vector<std::uint32_t> farthest_;  // of fill(), by block and by larger cell: a pixel with a point, or kNone
};

}  // namespace sightline::raytrace
