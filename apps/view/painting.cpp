#include "sightline/apps/view/painting.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sightline::apps {
namespace {

/// Opacity at a place between four texels, 0 … 1.
double opacity(const Painting::Texture& texture, double u, double v) {
  const double x = u * texture.width - 0.5, y = v * texture.height - 0.5;
  const auto texel = [&](double column, double row) {
    const auto at = [](double index, int count) { return std::size_t(std::clamp(int(index), 0, count - 1)); };
    return double(texture.alpha[at(row, texture.height) * std::size_t(texture.width) + at(column, texture.width)]);
  };
  const double left = std::floor(x), top = std::floor(y), across = x - left, down = y - top;
  const double above = texel(left, top) * (1.0 - across) + texel(left + 1.0, top) * across,
               below = texel(left, top + 1.0) * (1.0 - across) + texel(left + 1.0, top + 1.0) * across;
  return (above * (1.0 - down) + below * down) / 255.0;
}

/// One triangle. A pixel is painted where its middle is inside; edges of neighbours paint none twice.
class Triangle {
 public:
  Triangle(const Painting::Vertex& a, const Painting::Vertex& b, const Painting::Vertex& c)
      : corners_{&a, &b, &c}, area_(double(b.x - a.x) * (c.y - a.y) - double(b.y - a.y) * (c.x - a.x)) {}

  bool flat() const { return !(std::abs(area_) > 0.0); }
  std::pair<float, float> rows() const { return std::minmax({corners_[0]->y, corners_[1]->y, corners_[2]->y}); }
  /// From where to where the triangle crosses a row; an empty span where it does not.
  std::pair<double, double> span(double y) const {
    double low = 0.0, high = 0.0;
    bool any = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const Painting::Vertex *from = corners_[i], *to = corners_[(i + 1) % 3];
      if ((double(from->y) <= y) == (double(to->y) <= y)) continue;
      if (from->y > to->y) std::swap(from, to);  // so that neighbours compute the same
      const double x = from->x + (y - from->y) * (double(to->x) - from->x) / (double(to->y) - from->y);
      low = any ? std::min(low, x) : x;
      high = any ? std::max(high, x) : x;
      any = true;
    }
    return {low, high};
  }
  /// The mean of the corners' colours over a pixel.
  void paint(double x, double y, const Painting::Texture& texture, std::uint8_t* rgb) const {
    const Painting::Vertex &a = *corners_[0], &b = *corners_[1], &c = *corners_[2];
    const double of_b = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / area_,
                 of_c = ((y - a.y) * (b.x - a.x) - (x - a.x) * (b.y - a.y)) / area_, of_a = 1.0 - of_b - of_c;
    const auto mean = [&](double at_a, double at_b, double at_c) { return of_a * at_a + of_b * at_b + of_c * at_c; };
    const double alpha = mean(a.colour[3], b.colour[3], c.colour[3]) / 255.0 *
                         opacity(texture, mean(a.u, b.u, c.u), mean(a.v, b.v, c.v));
    for (std::size_t i = 0; i < 3; ++i) {
      const double colour = mean(a.colour[i], b.colour[i], c.colour[i]);
      rgb[i] = std::uint8_t(std::clamp(std::lround(rgb[i] + alpha * (colour - rgb[i])), 0L, 255L));
    }
  }

 private:
  std::array<const Painting::Vertex*, 3> corners_;
  double area_;  // twice, with its sign
};

/// The first pixel whose middle is not before a place, between two limits.
int first_pixel(double at, int least, int most) {
  return int(std::clamp(std::ceil(at - 0.5), double(least), double(most)));
}

struct PaintedRows {
  std::span<std::uint8_t> rgb;
  int width, first;
  int count() const { return int(rgb.size() / (3 * std::size_t(width))); }
};

void paint(const Triangle& triangle, const Painting::Batch& batch, const PaintedRows& rows) {
  if (triangle.flat()) return;
  const auto [top, bottom] = triangle.rows();
  const int begin = rows.first, end = rows.first + rows.count();
  const int last = first_pixel(std::min(bottom, batch.bottom), begin, end),
            left = first_pixel(batch.left, 0, rows.width), right = first_pixel(batch.right, 0, rows.width);
  for (int y = first_pixel(std::max(top, batch.top), begin, end); y < last; ++y) {
    const auto [low, high] = triangle.span(y + 0.5);
    const int stop = first_pixel(high, left, right);
    for (int x = first_pixel(low, left, right); x < stop; ++x)
      triangle.paint(x + 0.5, y + 0.5, batch.texture,
                     &rows.rgb[3 * (std::size_t(y - begin) * std::size_t(rows.width) + std::size_t(x))]);
  }
}

}  // namespace

void Painting::paint(std::span<std::uint8_t> rgb, int width, int first_row) const {
  for (const Batch& batch : batches)
    for (std::size_t i = batch.first; i + 2 < batch.first + batch.count; i += 3)
      apps::paint({vertices[indices[i]], vertices[indices[i + 1]], vertices[indices[i + 2]]}, batch,
                  {rgb, width, first_row});
}

}  // namespace sightline::apps
