#include "sightline/raytrace/internal/point_image.h"

#include <algorithm>
#include <atomic>
#include <bit>

#include <glm/gtc/matrix_transform.hpp>

#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/raytrace/internal/packed_colour.h"

namespace sightline::raytrace {
namespace {

using core::dmat4;
using core::dvec3;
using core::vec3;
using core::View;
using gpuprims::Background;

constexpr int kRows = 8;             // a job has
constexpr double kFarAway = 1e7;     // metres, where the background of perspective views lies
constexpr float kClearly = 1.03f;    // times as near, in perspective views
constexpr float kClearStep = 3e-3f;  // of the depth range, in orthographic ones

dvec3 place_of_eye(const View& view) {
  return dvec3(glm::inverse(view.eye_from_world())[3]);
}

dmat4 clip_from_place(const View& view, const dvec3& origin) {
  return gpuprims::reversed_clip_from_eye(view) * view.eye_from_world() * glm::translate(dmat4(1.0), origin);
}

/// Calls visit(row) for all rows.
template <class Visit>
void for_rows(core::ThreadPool& threads, int height, const Visit& visit) {
  threads.run(std::uint32_t((height + kRows - 1) / kRows), [&](std::uint32_t job) {
    for (int y = int(job) * kRows; y < std::min(height, int(job + 1) * kRows); ++y) visit(y);
  });
}

}  // namespace

void PointImage::reset(int width, int height, const View& view) {
  width_ = width, height_ = height;
  const std::size_t pixels = std::size_t(width) * std::size_t(height);
  for (Points* points : {&now_, &before_}) {
    points->point.resize(pixels);
    points->colour.resize(pixels);
    points->age.assign(pixels, kNoPoint);
  }
  if (pixels != depths_.size()) nearest_ = std::make_unique<std::atomic<std::uint64_t>[]>(pixels);
  ids_.resize(pixels);
  depths_.resize(pixels);
  origin_ = place_of_eye(view);
  clip_ = glm::mat4(clip_from_place(view, origin_));
  orthographic_ = view.orthographic();
}

void PointImage::take(int width, int height, const View& view, const Pixels& image, core::ThreadPool& threads) {
  reset(width, height, view);
  const dmat4 place_from_clip = glm::inverse(clip_from_place(view, origin_));
  const auto place = [&](int x, int y, double depth) {
    const core::dvec4 p =
        place_from_clip * core::dvec4(2.0 * (x + 0.5) / width - 1.0, 2.0 * (y + 0.5) / height - 1.0, depth, 1.0);
    return dvec3(p) / p.w;
  };
  for_rows(threads, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t pixel = at(x, y);
      const float depth = image.depths[pixel];
      // The background lies midway between the planes, and in perspective views very far away in that direction.
      dvec3 point = place(x, y, depth > 0.0f ? double(depth) : 0.5);
      if (depth == 0.0f && !orthographic_) point *= kFarAway / glm::length(point);
      ids_[pixel] = depth == 0.0f ? 0 : image.ids.empty() ? 1 : image.ids[pixel];
      now_.point[pixel] = {vec3(point), ids_[pixel]};
      now_.colour[pixel] = image.colours[pixel];
      now_.age[pixel] = kNew;
      depths_[pixel] = depth;
    }
  });
}

void PointImage::follow(const View& view, const Background& background, core::ThreadPool& threads) {
  std::swap(now_, before_);
  // X / W and Y / W of its products are places in the image, in pixels.
  const dmat4 to_pixels = glm::scale(dmat4(1.0), dvec3(0.5 * width_, 0.5 * height_, 1.0)) *
                          glm::translate(dmat4(1.0), dvec3(1.0, 1.0, 0.0));
  const glm::mat4 pixels(to_pixels * clip_from_place(view, origin_));
  for_rows(threads, height_, [&](int y) {
    for (int x = 0; x < width_; ++x) nearest_[at(x, y)].store(0, std::memory_order_relaxed);
  });
  for_rows(threads, height_, [&](int y) { project_row(pixels, y); });
  orthographic_ = view.orthographic();
  const dvec3 origin = place_of_eye(view);
  const vec3 step(origin_ - origin);
  origin_ = origin;
  clip_ = glm::mat4(clip_from_place(view, origin_));
  for_rows(threads, height_, [&](int y) { take_row(step, background_of(background, y), y); });
  for_rows(threads, height_, [&](int y) { doubt_row(y); });
}

/// Several threads may put points into one pixel, where the nearest one stays.
void PointImage::project_row(const glm::mat4& pixels, int row) {
  constexpr int kMost = 128;  // at once, so that the compiler makes vectors of them
  const auto width = float(width_), height = float(height_);
  for (int left = 0; left < width_; left += kMost) {
    const std::size_t first = at(left, row);
    const int count = std::min(kMost, width_ - left);
    const Point* const points = &before_.point[first];
    float x[kMost], y[kMost], depth[kMost];
    for (int i = 0; i < count; ++i) {
      const vec3& p = points[i].place;
      const auto form = [&](int k) {
        return pixels[0][k] * p.x + pixels[1][k] * p.y + pixels[2][k] * p.z + pixels[3][k];
      };
      const float w = form(3), per_w = 1.0f / w;
      x[i] = w > 0.0f ? form(0) * per_w : -1.0f;
      y[i] = form(1) * per_w;
      depth[i] = points[i].id != 0 ? form(2) * per_w : 0.0f;
    }
    for (int i = 0; i < count; ++i) {
      const bool inside = x[i] >= 0.0f && x[i] < width && y[i] >= 0.0f && y[i] < height;
      const std::size_t from = first + std::size_t(i);
      if (before_.age[from] == kNoPoint || !inside || !(depth[i] >= 0.0f && depth[i] <= 1.0f)) continue;
      const std::uint64_t found = std::uint64_t(std::bit_cast<std::uint32_t>(depth[i])) << 32 | (from + 1);
      std::atomic<std::uint64_t>& nearest = nearest_[at(int(x[i]), int(y[i]))];
      for (std::uint64_t there = nearest.load(std::memory_order_relaxed); there < found;)
        if (nearest.compare_exchange_weak(there, found, std::memory_order_relaxed)) break;
    }
  }
}

/// Takes the points that are nearest in their pixels.
void PointImage::take_row(const vec3& step, std::uint32_t background, int row) {
  const std::size_t first = at(0, row);
  for (std::size_t pixel = first; pixel < first + std::size_t(width_); ++pixel) {
    const std::uint64_t found = nearest_[pixel].load(std::memory_order_relaxed);
    depths_[pixel] = std::bit_cast<float>(std::uint32_t(found >> 32));
    if (found == 0) {
      now_.age[pixel] = kNoPoint;
      continue;
    }
    const std::size_t from = std::size_t(std::uint32_t(found)) - 1;
    const Point point{before_.point[from].place + step, before_.point[from].id};
    now_.point[pixel] = point;
    ids_[pixel] = point.id;
    now_.colour[pixel] = point.id != 0 ? before_.colour[from] : background;
    now_.age[pixel] = std::uint8_t(std::min<int>(before_.age[from] + 1, kOldest));
  }
}

/// Finds points between two that are clearly nearer, beside them or above and below.
void PointImage::doubt_row(int row) {
  if (row == 0 || row + 1 == height_) return;
  const float factor = orthographic_ ? 1.0f : kClearly, more = orthographic_ ? kClearStep : 0.0f;
  const float* const depth = &depths_[at(0, row)];
  const float *const above = depth + width_, *const below = depth - width_;
  std::uint8_t* const age = &now_.age[at(0, row)];
  for (int x = 1; x + 1 < width_; ++x) {
    const float beside = std::min(depth[x - 1], depth[x + 1]), over = std::min(above[x], below[x]);
    const bool doubtful = std::max(beside, over) > factor * depth[x] + more && age[x] != kNoPoint;
    age[x] = doubtful ? kDoubtful : age[x];
  }
}

void PointImage::set(std::size_t pixel, const dvec3& point, std::uint32_t id, std::uint32_t colour) {
  const vec3 place(point - origin_);
  const glm::vec4 clip = clip_ * glm::vec4(place, 1.0f);
  now_.point[pixel] = {place, id};
  now_.colour[pixel] = colour;
  now_.age[pixel] = kNew;
  ids_[pixel] = id;
  depths_[pixel] = std::clamp(clip.z / clip.w, 0.0f, 1.0f);
}

void PointImage::set_background(std::size_t pixel, const core::Ray& ray, const Background& background) {
  const double t = orthographic_ ? 0.5 * (ray.t_min + ray.t_max) : kFarAway;
  now_.point[pixel] = {vec3(ray.origin + t * ray.direction - origin_), 0};
  now_.colour[pixel] = background_of(background, int(pixel / std::size_t(width_)));
  now_.age[pixel] = kNew;
  ids_[pixel] = 0;
  depths_[pixel] = 0.0f;
}

std::uint32_t PointImage::background_of(const Background& background, int row) const {
  return packed_colour(glm::mix(background.bottom, background.top, (float(row) + 0.5f) / float(height_)));
}

// --- pixels without a point ------------------------------------------------------------------------------------------

std::uint32_t PointImage::farther(std::uint32_t a, std::uint32_t b) const {
  if (a == core::kNone || b == core::kNone) return a == core::kNone ? b : a;
  if (now_.point[a].id == 0 || now_.point[b].id == 0) return now_.point[a].id == 0 ? b : a;
  return depths_[b] < depths_[a] ? b : a;
}

/// A pixel of a cell that has a point, or kNone.
std::uint32_t PointImage::farthest_in(int left, int bottom, int side) const {
  std::uint32_t farthest = core::kNone;
  for (int y = bottom; y < std::min(height_, bottom + side); ++y)
    for (int x = left; x < std::min(width_, left + side); ++x)
      if (now_.age[at(x, y)] != kNoPoint) farthest = farther(farthest, std::uint32_t(at(x, y)));
  return farthest;
}

void PointImage::show(std::size_t pixel, std::uint32_t from, std::uint32_t background) {
  const bool surface = from != core::kNone && now_.point[from].id != 0;
  ids_[pixel] = surface ? now_.point[from].id : 0;
  now_.colour[pixel] = surface ? now_.colour[from] : background;
  depths_[pixel] = surface ? depths_[from] : 0.0f;
}

void PointImage::fill(const Background& background, core::ThreadPool& threads) {
  if (!fill_blocks(background, threads)) fill_empty_blocks(background, threads);
}

/// Fills blocks that have any points. Whether there were no others.
bool PointImage::fill_blocks(const Background& background, core::ThreadPool& threads) {
  std::atomic<bool> all = true;
  threads.run(std::uint32_t(rows()), [&](std::uint32_t row) {
    for (int column = 0; column < columns(); ++column) {
      bool any = false;
      for_each(column, int(row), [&](std::size_t pixel, int, int) { any |= now_.age[pixel] == kNoPoint; });
      if (!any) continue;
      const std::uint32_t of_block = farthest_in(column * kBlock, int(row) * kBlock, kBlock);
      if (of_block == core::kNone) {
        all.store(false, std::memory_order_relaxed);
        continue;
      }
      for_each(column, int(row), [&](std::size_t pixel, int x, int y) {
        if (now_.age[pixel] != kNoPoint) return;
        std::uint32_t from = core::kNone;
        for (int side = 2; side < kBlock && from == core::kNone; side *= 2)
          from = farthest_in(x & -side, y & -side, side);
        show(pixel, from != core::kNone ? from : of_block, background_of(background, y));
      });
    }
  });
  return all;
}

/// Fills blocks without points, by cells of 2 x 2 blocks, of 2 x 2 of these, and so on.
void PointImage::fill_empty_blocks(const Background& background, core::ThreadPool& threads) {
  struct Level {
    int columns, rows;
    std::size_t first;  // in farthest_
    std::size_t cell(int column, int row) const {
      return first + std::size_t(row) * std::size_t(columns) + std::size_t(column);
    }
  };
  std::vector<Level> levels{{columns(), rows(), 0}};
  while (levels.back().columns > 1 || levels.back().rows > 1) {
    const Level& below = levels.back();
    levels.push_back({(below.columns + 1) / 2, (below.rows + 1) / 2, below.cell(0, below.rows)});
  }
  farthest_.resize(levels.back().cell(0, 1));
  threads.run(std::uint32_t(rows()), [&](std::uint32_t row) {
    for (int column = 0; column < columns(); ++column)
      farthest_[levels[0].cell(column, int(row))] = farthest_in(column * kBlock, int(row) * kBlock, kBlock);
  });
  for (std::size_t k = 1; k < levels.size(); ++k)
    for (int row = 0; row < levels[k].rows; ++row)
      for (int column = 0; column < levels[k].columns; ++column) {
        std::uint32_t& cell = farthest_[levels[k].cell(column, row)] = core::kNone;
        for (int y = 2 * row; y < std::min(levels[k - 1].rows, 2 * row + 2); ++y)
          for (int x = 2 * column; x < std::min(levels[k - 1].columns, 2 * column + 2); ++x)
            cell = farther(cell, farthest_[levels[k - 1].cell(x, y)]);
      }
  threads.run(std::uint32_t(rows()), [&](std::uint32_t row) {
    for (int column = 0; column < columns(); ++column) {
      if (farthest_[levels[0].cell(column, int(row))] != core::kNone) continue;
      std::uint32_t from = core::kNone;
      for (std::size_t k = 1; k < levels.size() && from == core::kNone; ++k)
        from = farthest_[levels[k].cell(column >> k, int(row) >> k)];
      for_each(column, int(row),
               [&](std::size_t pixel, int, int y) { show(pixel, from, background_of(background, y)); });
    }
  });
}

}  // namespace sightline::raytrace
