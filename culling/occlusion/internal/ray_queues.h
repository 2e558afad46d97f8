// Internal: boxes of few pixels wait until there are sixteen of about as many pixels. Then their rays are tested
// together (small_boxes.h).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "sightline/culling/occlusion/internal/kernels.h"

namespace sightline::culling {

class RayQueues {
 public:
  /// Which box it is: a lane of a group of for_each_group().
  struct Place {
    std::uint32_t group;
    int lane;
    core::Slot slot;
  };

  static bool takes(const PixelRectangle& pixels) { return pixels_of(pixels) <= SmallBoxes::kMostPixels; }

  /// Calls test(boxes, places) when sixteen boxes wait. The rectangle must not be empty.
  template <class Test>
  void add(const BoxCoordinates& box, const PixelRectangle& pixels, const Place& place, const Test& test) {
    Queue& queue = queues_[std::size_t(std::bit_width(unsigned(pixels_of(pixels) - 1)) / 2)];
    queue.places[std::size_t(queue.boxes.count)] = place;
    put(box, pixels, queue.boxes.count++, queue.boxes);
    if (queue.boxes.count == kLanes) run(queue, test);
  }
  /// Tests all that still wait.
  template <class Test>
  void finish(const Test& test) {
    for (Queue& queue : queues_) {
      if (queue.boxes.count == 0) continue;
      for (int i = queue.boxes.count; i < kLanes; ++i) repeat_first(queue.boxes, i);
      run(queue, test);
    }
  }

  /// One box by itself.
  static SmallBoxes only(const BoxCoordinates& box, const PixelRectangle& pixels) {
    SmallBoxes boxes;
    for (int i = 0; i < kLanes; ++i) put(box, pixels, i, boxes);
    boxes.count = 1;
    return boxes;
  }

 private:
  struct Queue {
    SmallBoxes boxes{};
    std::array<Place, kLanes> places{};
  };

  static int pixels_of(const PixelRectangle& p) { return (p.x1 - p.x0 + 1) * (p.y1 - p.y0 + 1); }
  static void put(const BoxCoordinates& box, const PixelRectangle& pixels, int i, SmallBoxes& boxes) {
    for (std::size_t c = 0; c < 6; ++c) boxes.coordinates[c][i] = box[c];
    boxes.left[i] = float(pixels.x0), boxes.right[i] = float(pixels.x1);
    boxes.bottom[i] = float(pixels.y0), boxes.top[i] = float(pixels.y1);
  }
  static void repeat_first(SmallBoxes& boxes, int i) {
    for (auto& coordinate : boxes.coordinates) coordinate[i] = coordinate[0];
    for (float* const side : {boxes.left, boxes.right, boxes.bottom, boxes.top}) side[i] = side[0];
  }
  template <class Test>
  static void run(Queue& queue, const Test& test) {
    test(queue.boxes, std::span(queue.places).first(std::size_t(queue.boxes.count)));
    queue.boxes.count = 0;
  }

  static_assert(SmallBoxes::kMostPixels == 64);
  std::array<Queue, 4> queues_;  // of 1 or 2, up to 8, up to 32, and up to 64 pixels
};

}  // namespace sightline::culling
