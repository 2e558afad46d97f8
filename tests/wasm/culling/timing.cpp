#include "timing.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "recorded_view.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/box_culler.h"
#include "sightline/importers/plant/plant_generator.h"

namespace sightline::tests {

bool write_plant_boxes(const std::filesystem::path& file, std::uint64_t items) {
  core::Scene scene;
  if (!importers::generate_plant({.items = items, .seed = 1}, scene) || !scene.commit()) return false;
  const core::Snapshot snapshot(scene);
  const core::ItemBounds& bounds = snapshot.bounds();
  std::vector<core::AabbD> boxes;
  for (std::uint32_t item = 0; item < scene.item_slots(); ++item) {
    const core::Slot slot = snapshot.slot(core::ItemId(item));
    if (slot == core::kNone || snapshot.vacant(slot)) continue;
    const core::Aabb box = bounds.box(slot);
    boxes.push_back({core::dvec3(box.min) + bounds.origin, core::dvec3(box.max) + bounds.origin});
  }
  RecordWriter out(file);
  out.array(numbers_of(boxes));
  return out.close();
}

bool time_culling(const std::filesystem::path& file, int calls) {
  RecordReader in(file);
  const std::vector<double> numbers = in.array<double>();
  const auto culler = culling::BoxCuller::create(boxes_of(numbers));
  if (!culler || culler->size() == 0) return false;
  std::vector<std::uint32_t> indices;
  std::printf("[");
  for (const char* comma = ""; in.more(); comma = ",") {
    const auto view = read_view(in);
    if (!view) return false;
    std::vector<double> times;
    for (int i = 0; i < calls; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      culler->visible(*view, indices);
      const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begin;
      times.push_back(taken.count());
    }
    std::nth_element(times.begin(), times.begin() + calls / 2, times.end());
    std::printf("%s{\"ms\":%.6f,\"visible\":%zu}", comma, times[std::size_t(calls / 2)], indices.size());
  }
  std::printf("]\n");
  return true;
}

}  // namespace sightline::tests
