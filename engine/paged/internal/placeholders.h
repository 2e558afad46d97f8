// Splats for leaves whose pages are not in memory. Internal to engine.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "sightline/core/paged_scene.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/render/internal/point_splats.h"

namespace sightline::engine {

class Placeholders {
 public:
  static core::Expected<Placeholders> create(const gl::Context& context, const render::TargetFormat& format);

  /// Takes the memory that images of this size need.
  void forget(int width, int height) {
    nearest_.assign(std::size_t(width) * std::size_t(height), {kFarthest, core::kNone, 0.0f});
  }
  /// Draws a splat of the leaf's mean colour for each of these leaves, at most one a pixel: the nearest. Large ones
  /// are as large as points can be.
  core::Expected<void> draw(const core::PagedScene& scene, const core::View& view, const core::VisibleSet& leaves,
                            const render::RenderTarget& target);
  std::size_t drawn() const { return splats_.size(); }

 private:
  static constexpr float kFarthest = std::numeric_limits<float>::infinity();
  struct Nearest {
    float distance;
    core::Slot leaf;
    float area;
  };
  struct Palette {
    core::Scene scene;
    core::Snapshot snapshot{scene};
  };
  Placeholders(render::PointSplats points, std::unique_ptr<Palette> palette, gpuscene::GpuScene colours)
      : points_(std::move(points)), palette_(std::move(palette)), colours_(std::move(colours)) {}
  void find(const core::PagedScene& scene, const core::View& view, const core::VisibleSet& leaves,
            const render::RenderTarget& target);

  render::PointSplats points_;
  std::unique_ptr<Palette> palette_;
  gpuscene::GpuScene colours_;  // materials alone
  culling::SetParts parts_;
  std::vector<culling::ContributionTest::Splat> found_;
  std::vector<Nearest> nearest_;  // by pixel
  std::vector<render::PointSplat> splats_;
};

}  // namespace sightline::engine
