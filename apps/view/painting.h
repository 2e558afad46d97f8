// Triangles with smooth edges, painted over an image row by row: what a drawing of marks is where there is no window.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sightline/core/view.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

struct Painting {
  struct Vertex {
    float x, y;                          ///< pixels, from the image's upper left corner
    float u, v;                          ///< 0 … 1 in the texture, from its upper left corner
    std::array<std::uint8_t, 4> colour;  ///< red, green, blue, alpha
  };
  /// How opaque a vertex's colour is at a place; must outlive the painting.
  struct Texture {
    const std::uint8_t* alpha = nullptr;
    int width = 0, height = 0;
  };
  struct Batch {
    std::size_t first, count;        ///< of `indices`, three a triangle
    float left, top, right, bottom;  ///< clips
    Texture texture;
  };

  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<Batch> batches;  ///< in the order in which they are painted

  bool empty() const { return indices.empty(); }
  /// Paints over rows of an image of that width, RGB, of which the first is given.
  void paint(std::span<std::uint8_t> rgb, int width, int first_row) const;
  void paint(image::Image& image) const { paint(image.pixels, image.width, 0); }
};

/// What is painted over an image of a view, of a size in pixels.
using Painter = std::function<Painting(const core::View& view, const std::array<int, 2>& size)>;

}  // namespace sightline::apps
