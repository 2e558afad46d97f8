#include "sightline/raytrace/internal/point_image.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <optional>

#include <glm/gtc/matrix_transform.hpp>

#include "sightline/core/internal/prefetch.h"
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
constexpr float kFarAway = 1e7f;     // metres, where the background of perspective views lies
constexpr int kAround = 4;           // pixels: how far surfaces lie from background that they hide
constexpr float kClearly = 1.03f;    // times as near, in perspective views
constexpr float kClearStep = 3e-3f;  // of the depth range, in orthographic ones

dvec3 place_of_eye(const View& view) {
  return dvec3(glm::inverse(view.eye_from_world())[3]);
}

dmat4 clip_from_place(const View& view, const dvec3& origin) {
  return gpuprims::reversed_clip_from_eye(view) * view.eye_from_world() * glm::translate(dmat4(1.0), origin);
}

/// Where the background of an image lies, in places relative to `origin`: very far away; in orthographic views, where
/// that would leave the image with any turn, midway between the near and the far plane.
LinearOverImage places_of_background(const View& view, const dvec3& origin, int width, int height) {
  // Midway between the planes w is the same everywhere in orthographic views, and in others direction alone counts.
  const dmat4 place = glm::inverse(clip_from_place(view, origin)) * glm::translate(dmat4(1.0), dvec3(-1.0, -1.0, 0.5)) *
                      glm::scale(dmat4(1.0), dvec3(2.0 / width, 2.0 / height, 1.0));
  const core::dvec4 middle = place * core::dvec4(0.5 * width, 0.5 * height, 0.0, 1.0);
  const double scale = view.orthographic() ? 1.0 / middle.w : kFarAway / glm::length(dvec3(middle));
  return {vec3(scale * dvec3(place * core::dvec4(0.5, 0.5, 0.0, 1.0))), vec3(scale * dvec3(place[0])),
          vec3(scale * dvec3(place[1]))};
}

/// The pixel at a place, in pixels times W, and W; none outside the image.
std::optional<glm::ivec2> pixel_at(const vec3& place, int width, int height) {
  const float x = place.x / place.z, y = place.y / place.z;
  if (!(place.z > 0.0f && x >= 0.0f && x < float(width) && y >= 0.0f && y < float(height))) return std::nullopt;
  return glm::ivec2(int(x), int(y));
}

/// By pixel of a row of blocks: the reversed depth of the nearest point that comes there, and its pixel before + 1.
struct Nearest {
  std::vector<std::uint64_t> found;
  std::size_t memory_bytes() const { return core::bytes_of(found); }
};

/// Calls visit(row) for all rows.
template <class Visit>
void for_rows(core::ThreadPool& threads, int height, const Visit& visit) {
  threads.run(std::uint32_t((height + kRows - 1) / kRows), [&](std::uint32_t job) {
    for (int y = int(job) * kRows; y < std::min(height, int(job + 1) * kRows); ++y) visit(y);
  });
}

}  // namespace

bool none_around(std::span<const std::uint8_t> flags, int columns, std::size_t block) {
  const int column = int(block % std::size_t(columns)), row = int(block / std::size_t(columns));
  const int rows = int(flags.size() / std::size_t(columns));
  for (int v = std::max(0, row - 1); v <= std::min(rows - 1, row + 1); ++v)
    for (int u = std::max(0, column - 1); u <= std::min(columns - 1, column + 1); ++u)
      if (flags[std::size_t(v) * std::size_t(columns) + std::size_t(u)] != 0) return false;
  return true;
}

void PointImage::reset(int width, int height, const View& view) {
  width_ = width, height_ = height;
  const std::size_t pixels = std::size_t(width) * std::size_t(height);
  for (Points* points : {&now_, &before_}) {
    points->point.resize(pixels);
    points->colour.resize(pixels);
    points->age.assign(pixels, PointAge::kNoPoint);
  }
  ids_.resize(pixels);
  depths_.resize(pixels);
  moves_.resize_for_overwrite(pixels);  // follow() sets these before it reads them
  from_.resize_for_overwrite(pixels);
  moved_rows_.resize(runs() * std::size_t(height));
  surfaces_.resize(surface_words() * std::size_t(height));
  surfaces_before_.resize(surface_words() * std::size_t(height));
  look_from(view);
}

void PointImage::look_from(const View& view) {
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
      ids_[pixel] = depth == 0.0f ? 0 : image.ids.empty() ? 1 : image.ids[pixel];
      now_.point[pixel] = {depth == 0.0f ? vec3(0.0f) : vec3(place(x, y, double(depth))), ids_[pixel]};
      now_.colour[pixel] = image.colours[pixel];
      now_.age[pixel] = PointAge::kNew;
      depths_[pixel] = depth;
    }
  });
}

void PointImage::follow(const View& view, const Background& background, core::ThreadPool& threads) {
  std::swap(now_, before_);
  // X / W and Y / W of its products are places in the image, in pixels.
  const dmat4 to_pixels = glm::scale(dmat4(1.0), dvec3(0.5 * width_, 0.5 * height_, 1.0)) *
                          glm::translate(dmat4(1.0), dvec3(1.0, 1.0, 0.0));
  const glm::mat4 pixels(to_pixels * clip_from_place(view, origin_)), pixels_before(to_pixels * dmat4(clip_));
  for_rows(threads, height_, [&](int y) { project_row(pixels, y); });
  const dvec3 origin = origin_;
  look_from(view);
  const vec3 step(origin - origin_);
  const auto form = [&](const vec3& place, float one) {
    const glm::vec4 there = pixels_before * glm::vec4(place, one);
    return vec3(there.x, there.y, there.w);
  };
  const LinearOverImage places = places_of_background(view, origin_, width_, height_);
  const LinearOverImage before{form(places.first - step, 1.0f), form(places.right, 0.0f), form(places.up, 0.0f)};
  threads.run(std::uint32_t(rows()), [&](std::uint32_t row) { take_block_row(step, before, background, int(row)); });
  for_rows(threads, height_, [&](int y) { doubt_row(y); });
  for_rows(threads, height_, [&](int y) { hide_background_row(y); });
}

/// Finds where surfaces move to. The background is found from where it comes to.
void PointImage::project_row(const glm::mat4& pixels, int row) {
  const auto width = float(width_), height = float(height_);
  std::uint64_t* const surfaces = &surfaces_before_[surface_words() * std::size_t(row)];
  std::fill_n(surfaces, surface_words(), 0);
  for (int left = 0; left < width_; left += kRun) {
    const std::size_t first = at(left, row);
    const int count = std::min(kRun, width_ - left);
    Rows& moved = moved_rows_[std::size_t(row) * runs() + std::size_t(left / kRun)] = {height_, -1};
    std::uint32_t any = 0;
    for (int i = 0; i < count; ++i) any |= ids_[first + std::size_t(i)];
    if (any == 0) continue;
    const Point* const points = &before_.point[first];
    float x[kRun], y[kRun], depth[kRun];
    for (int i = 0; i < count; ++i) {  // without branches, so that the compiler makes vectors of it
      const vec3& p = points[i].place;
      const auto form = [&](int k) {
        return pixels[0][k] * p.x + pixels[1][k] * p.y + pixels[2][k] * p.z + pixels[3][k];
      };
      const float w = form(3), per_w = 1.0f / w, to = form(0) * per_w;
      x[i] = w > 0.0f ? to : -1.0f;
      y[i] = form(1) * per_w;
      depth[i] = form(2) * per_w;
    }
    for (int i = 0; i < count; ++i) {
      const std::size_t from = first + std::size_t(i);
      const bool surface = before_.age[from] != PointAge::kNoPoint && points[i].id != 0;
      surfaces[(left + i) / 64] |= std::uint64_t(surface) << (left + i) % 64;
      moves_[from] = {core::kNone, depth[i]};
      if (!(surface && x[i] >= 0.0f && x[i] < width && y[i] >= 0.0f && y[i] < height && depth[i] >= 0.0f &&
            depth[i] <= 1.0f))
        continue;
      const int v = int(y[i]);
      moves_[from].to = std::uint32_t(at(int(x[i]), v));
      moved = {std::min(moved.first, v), std::max(moved.last, v)};
    }
  }
}

/// Takes the points that come into a row of blocks: no other thread writes there.
void PointImage::take_block_row(const vec3& step, const LinearOverImage& before, const Background& background,
                                int row) {
  const int bottom = row * kBlock, top = std::min(height_, bottom + kBlock);
  const std::size_t first = at(0, bottom), pixels = at(0, top) - first;
  const core::Scratch<Nearest> nearest;
  nearest->found.assign(pixels, 0);
  std::uint64_t* const found = nearest->found.data();
  for (std::size_t run = 0; run < moved_rows_.size(); ++run) {
    if (moved_rows_[run].first >= top || moved_rows_[run].last < bottom) continue;
    const std::size_t left = run % runs() * kRun, begin = at(int(left), int(run / runs()));
    for (std::size_t from = begin; from < begin + std::min(std::size_t(kRun), std::size_t(width_) - left); ++from) {
      const std::size_t to = moves_[from].to - first;
      if (to >= pixels) continue;
      found[to] =
          std::max(found[to], std::uint64_t(std::bit_cast<std::uint32_t>(moves_[from].depth)) << 32 | (from + 1));
    }
  }
  for (int y = bottom; y < top; ++y) {
    take_row(step, y, found + std::size_t(y - bottom) * std::size_t(width_));
    const std::uint32_t colour = background_of(background, y, height_);
    for (int left = 0; left < width_; left += kBlock) keep_background(before, colour, left, y);
  }
}

/// Takes the points that are nearest in their pixels.
void PointImage::take_row(const vec3& step, int row, const std::uint64_t* nearest) {
  const std::size_t first = at(0, row), width = std::size_t(width_);
  const Point* const points = before_.point.data();
  const std::uint32_t* const colours = before_.colour.data();
  const std::uint8_t* const ages = before_.age.data();
  Point* const point = &now_.point[first];
  std::uint32_t *const colour = &now_.colour[first], *const id = &ids_[first], *const from = &from_[first];
  std::uint8_t* const age = &now_.age[first];
  float* const depth = &depths_[first];
  std::uint64_t* const surfaces = &surfaces_[surface_words() * std::size_t(row)];
  std::fill_n(surfaces, surface_words(), 0);
  for (std::size_t left = 0; left < width; left += kBlock) {
    const std::size_t right = std::min(left + kBlock, width);
    std::uint64_t any = 0;
    for (std::size_t x = left; x < right; ++x) any |= nearest[x];
    for (std::size_t x = left; x < right; ++x) depth[x] = std::bit_cast<float>(std::uint32_t(nearest[x] >> 32));
    std::fill(age + left, age + right, PointAge::kNoPoint);
    if (any == 0) continue;
    for (std::size_t x = left; x < right; ++x) {
      if (x + core::kPrefetchAhead < width) core::prefetch(points[std::uint32_t(nearest[x + core::kPrefetchAhead])]);
      if (nearest[x] == 0) continue;
      from[x] = std::uint32_t(nearest[x]) - 1;
      const Point& before = points[from[x]];
      point[x] = {before.place + step, before.id};
      id[x] = before.id;
      colour[x] = colours[from[x]];
      age[x] = PointAge::following(ages[from[x]]);
      surfaces[x / 64] |= std::uint64_t(1) << x % 64;
    }
  }
}

/// Lets those of some pixels of a row that have no point show the background if it lay there before. `before`: pixels
/// before, times W, and W of the places of the background.
void PointImage::keep_background(const LinearOverImage& before, std::uint32_t colour, int left, int row) {
  const int right = std::min(width_, left + kBlock);
  if (copy_background(before, colour, left, row)) return;
  for (int x = left; x < right; ++x) {
    const std::size_t pixel = at(x, row);
    if (now_.age[pixel] != PointAge::kNoPoint) continue;
    const auto from = pixel_at(before.at(x, row), width_, height_);
    if (!from) continue;
    from_[pixel] = std::uint32_t(at(from->x, from->y));
    const std::uint8_t age = before_.age[from_[pixel]];
    if (age == PointAge::kNoPoint || (surfaces_from(surfaces_before_, from->y, from->x) & 1u) != 0) continue;
    show_background(pixel, colour, PointAge::following(age));
  }
}

/// keep_background() amid the background, where all pixels come from as far away as the one in the middle, but for one
/// pixel. False: not there.
bool PointImage::copy_background(const LinearOverImage& before, std::uint32_t colour, int left, int row) {
  constexpr std::uint64_t kThese = (std::uint64_t(1) << (kBlock + 2)) - 1;
  const auto middle = pixel_at(before.at(left + kBlock / 2, row), width_, height_);
  if (!middle) return false;
  const int from = middle->x - kBlock / 2, from_row = middle->y;
  if (left + kBlock > width_ || from < 0 || from + kBlock > width_ || from_row < 1 || from_row + 1 >= height_)
    return false;
  std::uint64_t surfaces = surfaces_from(surfaces_, row, left);
  for (int y = from_row - 1; y <= from_row + 1; ++y) surfaces |= surfaces_from(surfaces_before_, y, from - 1);
  if ((surfaces & kThese) != 0) return false;
  const std::size_t first = at(left, row), first_before = at(from, from_row);
  for (std::size_t i = 0; i < kBlock; ++i) {
    const std::uint8_t age = before_.age[first_before + i];
    show_background(first + i, colour, age == PointAge::kNoPoint ? age : PointAge::following(age));
    from_[first + i] = std::uint32_t(first_before + i);
  }
  return true;
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
    const bool doubtful = std::max(beside, over) > factor * depth[x] + more && age[x] != PointAge::kNoPoint;
    age[x] = doubtful ? PointAge::kDoubtful : age[x];
  }
}

/// Surfaces of 64 pixels of a row, as bits.
std::uint64_t PointImage::surfaces_from(const std::vector<std::uint64_t>& bits, int row, std::ptrdiff_t first) const {
  const std::uint64_t* const words = &bits[surface_words() * std::size_t(row)];
  const std::ptrdiff_t word = first >= 0 ? first / 64 : -1, count = std::ptrdiff_t(surface_words());
  const auto shift = unsigned(first & 63);
  const auto at = [&](std::ptrdiff_t w) { return w >= 0 && w < count ? words[w] : 0; };
  return shift == 0 ? at(word) : at(word) >> shift | at(word + 1) << (64 - shift);
}

/// Whether the point of a pixel has moved farther past that of a pixel of the background, which is `distance` away,
/// than that: then it lay beyond, or hid it.
bool PointImage::moved_past(std::size_t surface, std::size_t background, int distance) const {
  const auto moved = [&](std::size_t pixel) {
    const std::size_t from = from_[pixel], width = std::size_t(width_);
    return glm::ivec2(int(pixel % width) - int(from % width), int(pixel / width) - int(from / width));
  };
  const glm::ivec2 past = glm::abs(moved(surface) - moved(background));
  return std::max(past.x, past.y) > distance;
}

/// Whether the next surface in a direction, if it is near, has moved past the background of a pixel.
bool PointImage::passed_by(int x, int y, int dx, int dy) const {
  for (int k = 1; k <= kAround; ++k) {
    const int u = x + k * dx, v = y + k * dy;
    if (u < 0 || u >= width_ || v < 0 || v >= height_) return false;
    if ((surfaces_from(surfaces_, v, u) & 1u) != 0) return moved_past(at(u, v), at(x, y), k);
  }
  return false;
}

/// Hides the background that has surfaces on both sides, or above and below, which have moved past it.
void PointImage::hide_background_row(int row) {
  for (int left = 0; left < width_; left += 64) {
    std::uint64_t before = 0, after = 0, above = 0, below = 0;
    for (int k = 1; k <= kAround; ++k) {
      before |= surfaces_from(surfaces_, row, left - k);
      after |= surfaces_from(surfaces_, row, left + k);
      if (row + k < height_) above |= surfaces_from(surfaces_, row + k, left);
      if (row - k >= 0) below |= surfaces_from(surfaces_, row - k, left);
    }
    std::uint64_t enclosed = ((before & after) | (above & below)) & ~surfaces_from(surfaces_, row, left);
    for (; enclosed != 0; enclosed &= enclosed - 1) {
      const int x = left + std::countr_zero(enclosed);
      if (x >= width_ || !PointAge::shows_own(now_.age[at(x, row)])) continue;
      if (passed_by(x, row, -1, 0) || passed_by(x, row, 1, 0) || passed_by(x, row, 0, 1) || passed_by(x, row, 0, -1))
        now_.age[at(x, row)] |= PointAge::kHidden;
    }
  }
}

PointBlock PointImage::block(int column, int row) const {
  const int left = column * kBlock, width = std::min(width_ - left, kBlock);
  const int bottom = row * kBlock, top = std::min(height_, bottom + kBlock);
  PointBlock block{.pixels = std::uint32_t(width * (top - bottom))};
  for (int y = bottom; y < top; ++y) {
    const std::uint8_t* const ages = &now_.age[at(left, y)];
    const std::uint32_t* const ids = &ids_[at(left, y)];
    PointBlock sum;  // of a row, without branches, so that the compiler makes vectors of it
    std::uint32_t surfaces = 0, empty = 0;
    for (int x = 0; x < width; ++x) {
      const std::uint32_t own = PointAge::shows_own(ages[x]);
      sum.waited += PointAge::waited(ages[x]);
      sum.missing += ages[x] == PointAge::kNoPoint;
      sum.own += own;
      sum.found += ages[x] == PointAge::kNew;
      sum.assumed += ages[x] == PointAge::kAssumed;
      surfaces |= ids[x] & (own * ~0u);
      empty |= own & std::uint32_t(ids[x] == 0);
    }
    sum.surface = surfaces != 0;
    sum.background = empty != 0;
    block += sum;
  }
  return block;
}

PointBlock& PointBlock::operator+=(const PointBlock& other) {
  waited += other.waited, missing += other.missing, own += other.own, found += other.found, assumed += other.assumed;
  pixels += other.pixels, surface |= other.surface, background |= other.background;
  return *this;
}

void PointImage::set(std::size_t pixel, const dvec3& point, std::uint32_t id, std::uint32_t colour) {
  const vec3 place(point - origin_);
  const glm::vec4 clip = clip_ * glm::vec4(place, 1.0f);
  now_.point[pixel] = {place, id};
  now_.colour[pixel] = colour;
  now_.age[pixel] = PointAge::kNew;
  ids_[pixel] = id;
  depths_[pixel] = std::clamp(clip.z / clip.w, 0.0f, 1.0f);
}

void PointImage::set_background(int x, int y, const Background& background, std::uint8_t age) {
  show_background(at(x, y), background_of(background, y, height_), age);
}

void PointImage::show_background(std::size_t pixel, std::uint32_t colour, std::uint8_t age) {
  now_.point[pixel].id = 0;
  now_.colour[pixel] = colour;
  now_.age[pixel] = age;
  ids_[pixel] = 0;
  depths_[pixel] = 0.0f;
}

// --- pixels without a point ------------------------------------------------------------------------------------------

/// How far the point of a pixel is away, above the pixel's number: the least of several is the farthest surface, or the
/// background where there is none.
std::uint64_t PointImage::distance_of(std::size_t pixel) const {
  constexpr std::uint32_t kBackground = 0x7fffffff;  // above all depths
  const std::uint32_t depth = std::bit_cast<std::uint32_t>(depths_[pixel]) & kBackground;
  const std::uint32_t background = ids_[pixel] != 0 ? 0 : kBackground;
  return std::uint64_t(depth | background) << 32 | pixel;
}

void PointImage::show(std::size_t pixel, std::uint64_t farthest, const Background& background, int row) {
  const std::size_t from = std::uint32_t(farthest);
  const bool surface = farthest != kNowhere && ids_[from] != 0;
  now_.colour[pixel] = surface ? now_.colour[from] : background_of(background, row, height_);
  depths_[pixel] = surface ? depths_[from] : 0.0f;
  ids_[pixel] = surface ? ids_[from] : 0;
}

PointBlock PointImage::fill(const Background& background, core::ThreadPool& threads) {
  farthest_.resize(std::size_t(columns()) * std::size_t(rows()));
  const auto count = std::size_t(rows());
  std::vector<PointBlock> sums(count);  // of the blocks of a row
  std::atomic<bool> empty = false;
  threads.run(std::uint32_t(rows()), [&](std::uint32_t row) {
    PointBlock sum;
    for (int column = 0; column < columns(); ++column) {
      std::uint64_t& farthest = farthest_[std::size_t(row) * std::size_t(columns()) + std::size_t(column)];
      const PointBlock block = this->block(column, int(row));
      farthest = block.own == block.pixels ? kNotAsked
                 : block.own > 0           ? fill_block(column, int(row), background)
                                           : kNowhere;
      if (block.own == 0) empty.store(true, std::memory_order_relaxed);
      sum += block;
    }
    sums[row] = sum;
  });
  if (empty) fill_empty_blocks(background, threads);
  PointBlock all;
  for (const PointBlock& sum : sums) all += sum;
  return all;
}

/// Fills a block that has any points. Returns the distance of the farthest.
std::uint64_t PointImage::fill_block(int column, int row, const Background& background) {
  constexpr std::size_t kLevels = std::countr_zero(unsigned(kBlock)) + 1;
  std::array<std::array<std::uint64_t, kPixels>, kLevels> cells;  // pixels, cells of 2 x 2 pixels, of 4 x 4, and so on
  cells[0].fill(kNowhere);
  for_each(column, row, [&](std::size_t pixel, int x, int y) {
    const std::uint64_t nowhere = PointAge::shows_own(now_.age[pixel]) ? 0 : kNowhere;
    cells[0][std::size_t(y % kBlock * kBlock + x % kBlock)] = distance_of(pixel) | nowhere;
  });
  for (std::size_t level = 1; level < kLevels; ++level) {
    const std::size_t side = std::size_t(kBlock) >> level;
    for (std::size_t cell = 0; cell < side * side; ++cell) {
      const std::uint64_t* const below = &cells[level - 1][2 * (cell / side) * 2 * side + 2 * (cell % side)];
      cells[level][cell] = std::min(std::min(below[0], below[1]), std::min(below[2 * side], below[2 * side + 1]));
    }
  }
  for_each(column, row, [&](std::size_t pixel, int x, int y) {
    if (PointAge::shows_own(now_.age[pixel])) return;
    std::size_t level = 1;
    const auto cell = [&] { return std::size_t((y % kBlock >> level) * (kBlock >> level) + (x % kBlock >> level)); };
    while (cells[level][cell()] == kNowhere) ++level;
    show(pixel, cells[level][cell()], background, y);
  });
  return cells[kLevels - 1][0];
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
    for (int column = 0; column < columns(); ++column) {
      std::uint64_t& farthest = farthest_[levels[0].cell(column, int(row))];
      if (farthest != kNotAsked) continue;
      farthest = kNowhere;
      for_each(column, int(row),
               [&](std::size_t pixel, int, int) { farthest = std::min(farthest, distance_of(pixel)); });
    }
  });
  for (std::size_t k = 1; k < levels.size(); ++k)
    for (int row = 0; row < levels[k].rows; ++row)
      for (int column = 0; column < levels[k].columns; ++column) {
        std::uint64_t& cell = farthest_[levels[k].cell(column, row)] = kNowhere;
        for (int y = 2 * row; y < std::min(levels[k - 1].rows, 2 * row + 2); ++y)
          for (int x = 2 * column; x < std::min(levels[k - 1].columns, 2 * column + 2); ++x)
            cell = std::min(cell, farthest_[levels[k - 1].cell(x, y)]);
      }
  threads.run(std::uint32_t(rows()), [&](std::uint32_t row) {
    for (int column = 0; column < columns(); ++column) {
      if (farthest_[levels[0].cell(column, int(row))] != kNowhere) continue;
      std::uint64_t farthest = kNowhere;
      for (std::size_t k = 1; k < levels.size() && farthest == kNowhere; ++k)
        farthest = farthest_[levels[k].cell(column >> k, int(row) >> k)];
      for_each(column, int(row), [&](std::size_t pixel, int, int y) { show(pixel, farthest, background, y); });
    }
  });
}

}  // namespace sightline::raytrace
