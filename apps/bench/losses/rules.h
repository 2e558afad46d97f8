// Rules by which an image is drawn with less than all there is. Internal to sightline-bench contribution and lod.
//
//   drop, points, stochastic   the engine's: area of the solid, at most of its box (culling/occlusion/contribution.h),
//                  and the three ways of drawing what is below the threshold
//   box            projected area of the bounding box alone
//   osg            OpenSceneGraph 3.6, CullingSet::isCulled(BoundingSphere) and computePixelSizeVector(): the sphere's
//                  size in pixels, by default 2
//   occt           Open CASCADE 7.6, Graphic3d_CullingTool::IsTooSmall(): the diagonal's length in pixels
//   levels         meshes by levels of detail whose proven error is at most so many pixels (lod/mesh_levels.h)
//   both           levels within half a pixel, and items below so many pixels dropped: what a budget could do
//   chain          whole meshes by the coarsest of a chain of halvings whose estimated error is (level_chain.h)
//   primitives     analytic primitives in place of the meshes in which they are recognised; no threshold
// osg and occt compare the diagonal with the distance, so they differ only in the scale of their thresholds.
#pragma once

#include <string>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/engine/engine.h"

namespace sightline::bench {

struct Rule {
  enum class Measure { kNone, kSolid, kBox, kOpenSceneGraph, kOpenCascade, kLevels, kBoth, kChain, kPrimitives };
  Measure measure = Measure::kNone;  ///< kNone: the full image
  engine::ContributionMode mode = engine::ContributionMode::kDrop;
  double threshold = 0.0;  ///< pixels, of area or of length

  /// The threshold bounds how far surfaces lie from those of the model.
  bool moves_surfaces() const { return measure == Measure::kLevels || measure == Measure::kChain; }
  /// Settings for the engine, which knows only some of the rules: the others are applied before it draws.
  engine::LossConfig losses() const;
};

/// For tables: "full", "solid, drop", "levels".
std::string name_of(const Rule& rule);

/// Names for command lines, in this order; without the full image.
const std::vector<std::string>& rule_names();
/// The full image, then the rules of these names, each with rising thresholds.
std::vector<Rule> rules_of(const std::vector<std::string>& names);

/// For osg and occt: an item is dropped when the diagonal of its box is below this, times its centre's distance along
/// the view axis.
double least_diagonal(const Rule& rule, const core::View& view, int width, int height);
/// Replaces `kept` by the items of `in` that a least diagonal keeps, and by all lines.
void keep_large(const core::View& view, double least, const core::Snapshot& snapshot, const core::VisibleSet& in,
                core::VisibleSet& kept);

}  // namespace sightline::bench
