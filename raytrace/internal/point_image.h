// An image whose pixels keep the points that they show, so that it can follow a moving camera. Internal to raytrace
// and engine.
//
// After B. Walter, G. Drettakis and S. Parker, "Interactive Rendering using the Render Cache" (1999): the image of the
// next view shows each point where that view has it, and of several in a pixel the nearest.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/internal/scratch.h"
#include "sightline/core/large_array.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/gpuprims/surroundings.h"

namespace sightline::raytrace {

/// In views since a point was found: of the present view; the oldest that are told apart; of a point between nearer
/// ones, as cracks in a surface show that comes nearer; of a pixel without a point. The background has moved past the
/// surfaces before it, so where these lie around, its age is increased by kHidden, and the pixel shows one of them.
/// Assumed background has not been found by a ray of its own.
struct PointAge {
  static constexpr std::uint8_t kNew = 0, kOldest = 63, kDoubtful = 64, kAssumed = 65, kHidden = 128, kNoPoint = 255;

  /// Views for which a pixel of that age has waited, as it counts: doubtful points and none at all are the oldest.
  static constexpr std::uint32_t waited(std::uint8_t age) {
    constexpr std::uint32_t kOfAssumed = 16;
    return age == kAssumed ? kOfAssumed : std::min<std::uint32_t>(age & ~kHidden, kDoubtful);
  }
  /// The age of a point in the next view.
  static constexpr std::uint8_t following(std::uint8_t age) {
    return std::uint8_t(std::min<std::uint32_t>(waited(age) + 1, kOldest));
  }
  /// Whether a pixel of that age shows its own point.
  static constexpr bool shows_own(std::uint8_t age) { return age < kHidden; }
};

/// A sum over the pixels of a block: how long they have waited; how many have no point, show their own, show one of
/// this view, or assumed background; and whether any shows a surface, or background, of its own.
struct PointBlock {
  std::uint32_t waited = 0, missing = 0, own = 0, found = 0, assumed = 0, pixels = 0;
  bool surface = false, background = false;
  PointBlock& operator+=(const PointBlock& other);
};

/// Whether neither a block nor any beside it has a flag. `flags`: by block, row by row, in so many columns.
bool none_around(std::span<const std::uint8_t> flags, int columns, std::size_t block);

/// A vector that changes linearly over an image.
struct LinearOverImage {
  core::vec3 first{0.0f}, right{0.0f}, up{0.0f};  // of the lowest, leftmost pixel, and by pixel
  core::vec3 at(int x, int y) const { return first + float(x) * right + float(y) * up; }
};

/// Rows are counted from the bottom up.
class PointImage {
 public:
  static constexpr int kBlock = 16;  // pixels a side
  static constexpr std::size_t kPixels = std::size_t(kBlock) * kBlock;
  static constexpr std::size_t kBytes = 62;  // that a pixel costs

  /// An image, row by row from the bottom up.
  struct Pixels {
    std::span<const std::uint32_t> colours;  ///< red in the lowest byte, then g, b, 255
    std::span<const float> depths;           ///< reversed, 0 to 1; 0: the background
    std::span<const std::uint32_t> ids;      ///< item + 1; 0: the background
  };

  PointBlock block(int column, int row) const;

  /// Forgets all points.
  void reset(int width, int height, const core::View& view);
  /// Takes the points of an image of this view that is there, in the form in which this one has them. Without ids what
  /// has a depth is a surface.
  void take(int width, int height, const core::View& view, const Pixels& image, core::ThreadPool& threads);
  /// Puts points of surfaces where another view has them. Where none comes to and the background lay there before, this
  /// shows on, in the colour of its new row.
  void follow(const core::View& view, const gpuprims::Background& background, core::ThreadPool& threads);
  /// Lets a pixel show a point. `id`: item + 1. Several threads may set different pixels.
  void set(std::size_t pixel, const core::dvec3& point, std::uint32_t id, std::uint32_t colour);
  /// Lets it show the background, which its ray has found by missing everything, or is assumed to.
  void set_background(int x, int y, const gpuprims::Background& background, std::uint8_t age = PointAge::kNew);
  /// Points for whose ids (item + 1) doubts(id) is true become as doubtful as those between nearer ones.
  template <class Doubts>
  void doubt(const Doubts& doubts) {
    for (std::size_t i = 0; i < ids_.size(); ++i)
      if (PointAge::shows_own(now_.age[i]) && doubts(ids_[i])) now_.age[i] = PointAge::kDoubtful;
  }
  /// Lets pixels without a point show that of a neighbour: of the smallest cell of 2 x 2 pixels, 4 x 4, and so on that
  /// has any, the farthest, since what a near thing uncovers lies behind it; the background only where there is no
  /// other. They stay without a point. Returns the sum of all blocks.
  PointBlock fill(const gpuprims::Background& background, core::ThreadPool& threads);

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
    return now_.memory_bytes() + before_.memory_bytes() +
           core::bytes_of(ids_, depths_, moves_, moved_rows_, from_, surfaces_, surfaces_before_, farthest_);
  }
  Pixels pixels() const { return {now_.colour, depths_, ids_}; }
  std::span<const std::uint8_t> ages() const { return now_.age; }  ///< by pixel

 private:
  static constexpr int kRun = 128;  // points of a row that are projected at once
  static constexpr std::uint64_t kNowhere = ~std::uint64_t(0), kNotAsked = kNowhere - 1;  // for distance_of()
  struct Point {
    core::vec3 place;  // in the world, relative to origin_
    std::uint32_t id;
  };
  struct Points {
    core::LargeArray<Point> point;
    core::LargeArray<std::uint32_t> colour;
    core::LargeArray<std::uint8_t> age;
    std::size_t memory_bytes() const { return core::bytes_of(point, colour, age); }
  };
  /// Where the next view has a point: its pixel, or kNone, and its reversed depth.
  struct Move {
    std::uint32_t to;
    float depth;
  };
  struct Rows {
    int first, last;
  };
  void look_from(const core::View& view);
  void project_row(const glm::mat4& pixels, int row);
  void take_block_row(const core::vec3& step, const LinearOverImage& before, const gpuprims::Background& background,
                      int row);
  void take_row(const core::vec3& step, int row, const std::uint64_t* nearest);
  void doubt_row(int row);
  bool moved_past(std::size_t surface, std::size_t background, int distance) const;
  bool passed_by(int x, int y, int dx, int dy) const;
  void hide_background_row(int row);
  void show_background(std::size_t pixel, std::uint32_t colour, std::uint8_t age);
  void keep_background(const LinearOverImage& before, std::uint32_t colour, int left, int row);
  bool copy_background(const LinearOverImage& before, std::uint32_t colour, int left, int row);
  std::size_t runs() const { return (std::size_t(width_) + kRun - 1) / kRun; }
  std::size_t surface_words() const { return std::size_t(width_) / 64 + 1; }
  std::uint64_t surfaces_from(const std::vector<std::uint64_t>& bits, int row, std::ptrdiff_t first) const;
  std::uint64_t distance_of(std::size_t pixel) const;
  void show(std::size_t pixel, std::uint64_t farthest, const gpuprims::Background& background, int row);
  std::uint64_t fill_block(int column, int row, const gpuprims::Background& background);
  void fill_empty_blocks(const gpuprims::Background& background, core::ThreadPool& threads);

  int width_ = 0, height_ = 0;
  core::dvec3 origin_{0.0};
  glm::mat4 clip_{1.0f};  // reversed clip space from places
  bool orthographic_ = false;
  Points now_, before_;
  core::LargeArray<std::uint32_t> ids_;
  core::LargeArray<float> depths_;
  // follow() fills these.
  core::LargeArray<Move> moves_;                           // by pixel before
  std::vector<Rows> moved_rows_;                           // first and last rows that each kRun points of a row move to
  core::LargeArray<std::uint32_t> from_;                   // by pixel: the one before
  std::vector<std::uint64_t> surfaces_, surfaces_before_;  // a bit per pixel with a surface, surface_words() a row
  std::vector<std::uint64_t> farthest_;  // of fill(), by block and by larger cell: distance_of() its farthest point
};

}  // namespace sightline::raytrace
