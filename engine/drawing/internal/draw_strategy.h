// The strategies by which a frame's opaque items are drawn. Internal to engine.
#pragma once

#include <vector>

#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/solid_occluders.h"
#include "sightline/engine/drawing/internal/contribution_culling.h"
#include "sightline/engine/drawing/internal/draw_context.h"

namespace sightline::engine {

/// Clears the image of a context and draws candidates into it. A strategy owns the sets that it needs, and keeps their
/// memory from frame to frame; what it learns of one image lies in ImageState.
class DrawStrategy {
 public:
  virtual ~DrawStrategy() = default;
  virtual core::Expected<DrawCounts> draw(DrawContext& context, const Frame& frame,
                                          const core::VisibleSet& candidates) = 0;
};

/// Draws all candidates that cover a sample of the image in one pass.
class DrawAtOnce : public DrawStrategy {
 public:
  core::Expected<DrawCounts> draw(DrawContext& context, const Frame& frame,
                                  const core::VisibleSet& candidates) override;

 private:
  core::VisibleSet sampled_;
};

/// Tests occlusion in several passes, each against the depth of those before: see culling::OcclusionPasses, and
/// ClusterPasses, whose second pass has one of its own. The depth is read back between passes.
class DrawInPasses : public DrawStrategy {
 public:
  core::Expected<DrawCounts> draw(DrawContext& context, const Frame& frame,
                                  const core::VisibleSet& candidates) override;

 private:
  core::VisibleSet again_;  // items of the first pass of which clusters were left out
};

/// Tests occlusion before anything is drawn: in the passes of the test, occluder polygons in the solids take the place
/// of the solids. The CPU rasterises them in a small part of the time that drawing the solids takes. The items that
/// they do not occlude are drawn in the end.
class OcclusionPrepass : public DrawStrategy {
 public:
  /// Whether the image is the same as by DrawInPasses, and most of the items are solids. The candidates must be all
  /// visible items of the view.
  bool suits(const Frame& frame);
  core::Expected<DrawCounts> draw(DrawContext& context, const Frame& frame,
                                  const core::VisibleSet& candidates) override;

 private:
  core::Expected<void> rasterise(DrawContext& context, const Frame& frame, const core::VisibleSet& candidates,
                                 const culling::OcclusionTest& test);
  core::Expected<void> draw_meshes(DrawContext& context, const Frame& frame, std::uint64_t generation);
  core::Expected<DrawCounts> draw_visible(DrawContext& context, const Frame& frame, const culling::OcclusionTest& test);
  template <class Beside>
  void leave_out_occluded(DrawContext& context, const Frame& frame, const culling::OcclusionTest& test,
                          core::VisibleSet& set, const Beside& beside);
  core::Expected<std::int64_t> draw_solids(DrawContext& context, const Frame& frame, const core::VisibleSet& set);

  culling::SolidOccluders solids_;
  core::VisibleSet meshes_;           // items of the first pass that are no solids; they are drawn before the prepass
  core::VisibleSet visible_, drawn_;  // items that are not occluded in the end; those of them that are drawn then
  std::vector<core::Slot> at_near_plane_;
  culling::SetParts halves_, parts_;
};

/// Draws the largest items first until the deadline: see culling::BudgetPasses. It refines images at rest, and on GPUs
/// draws moving ones. While the view moves, candidates far smaller than the smallest of the last frame are not even
/// measured. The first frame of a view that stays begins anew with all of them, and the next ones go on. They do so
/// beside the image where the image has more in it (splats, depth shading, overlays), and then it gets a copy; or where
/// it shows all items with fewer pixels, and then once the copy is complete.
class DrawInBudget : public DrawStrategy {
 public:
  explicit DrawInBudget(ContributionCulling& contribution_culling) : contribution_culling_(contribution_culling) {}
  core::Expected<DrawCounts> draw(DrawContext& context, const Frame& frame,
                                  const core::VisibleSet& candidates) override;

 private:
  void begin(DrawContext& context, const Frame& frame, const core::VisibleSet& visible, bool stays);
  core::Expected<double> draw_passes(DrawContext& context, const Frame& frame, const render::RenderTarget& canvas,
                                     double deadline);
  core::Expected<double> draw_pass(DrawContext& context, const Frame& frame, const render::RenderTarget& canvas,
                                   bool read_back);
  core::Expected<void> draw_splats(DrawContext& context, const Frame& frame, const core::VisibleSet& visible);

  ContributionCulling& contribution_culling_;
  std::vector<std::uint64_t> without_splats_;  // a bit per slot
  double splats_ms_ = 0.0;                     // time that copying and splats of a frame take
  double readback_ms_ = 0.0;                   // time that the last read-back of depth took, of an idle device
  int readback_pixels_ = 0;                    // size of the image that it is known for
  bool distances_known_ = false;               // those of the image are of all that is drawn
};

}  // namespace sightline::engine
