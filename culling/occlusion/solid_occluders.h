// Occluders within the analytic solids of a snapshot: a depth image of pipes, vessels, elbows and beams before anything
// is drawn, in a fraction of the time that drawing them takes.
//
//   culling::SolidOccluders solids;
//   solids.begin(snapshot, view, 640, 360);
//   solids.add(visible, &threads);
//   solids.build(pyramid);
//
// A round solid hides what the flat polygons in it hide that face the eye: a cylinder or a snout its section along the
// axis, and its end where that is seen; a torus a strip along its centre line; a sphere or a dish a polygon. Boxes and
// pyramids are rasterised as wholes. An occluder polygon within a solid lies behind its surface. So the image is
// nowhere nearer than the solids. Sections cover outlines up to a few thousandths of the radius, strips up to a tenth,
// octagons nine tenths of a disc.
//
// Promise: inner-conservative, as OccluderRaster, for solids that are drawn opaque, by rays through the pixel centres.
// Figures are smaller than the solids by more than a renderer loses whose rays are float: by kLostPixels, kLostOfBox of
// the box's diagonal, and kLostOfRadius of the radius (for thin tori more). Items that are no solids, are not opaque,
// or that the near plane or a section plane cuts, hide nothing, except for boxes: the near plane clips these, and of
// those that a section plane cuts by less than they are smaller, the occluder polygons are whole, and lie behind the
// caps.
//
// Solids are narrower than their boxes, so some are hidden whose boxes are not. A cylinder is seen through a rectangle
// in the plane that touches it along the line nearest to the eye; an elbow through those of cylinders about its chords.
// Where these lie behind what their pixels hold, the solid is hidden. Promise of leave_out_occluded(): conservative at
// the pixel centres, also where a solid is drawn larger, by as much as occluder polygons are smaller.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/thread_pool.h"
#include "sightline/culling/occlusion/occluder_raster.h"

namespace sightline::culling {

template <class T>
class ObjectPool;

/// Reuse one from frame to frame: it keeps its memory.
class SIGHTLINE_API SolidOccluders {
 public:
  SolidOccluders();
  ~SolidOccluders();

  static constexpr double kLostPixels = 0x1p-12, kLostOfBox = 1e-5, kLostOfRadius = 1e-3;
  /// Pixels by which a renderer must draw the proxies larger in which it casts rays. A rasteriser that moves corners by
  /// less takes no pixel from a solid.
  static constexpr double kProxyMargin = 0x1p-6;

  /// Empties the image. Borrows the snapshot until the last of the other calls. The rest is as for
  /// OccluderRaster::begin().
  void begin(const core::Snapshot& snapshot, const core::View& view, int width, int height, float snap = kCoarsestSnap);
  /// Adds items of the snapshot. Large sets are shared out among `threads`, if there are any.
  void add(const core::VisibleSet& items, core::ThreadPool* threads = nullptr);
  /// Hands the image to the pyramid, which has its size then. `drawn`: distances of what is drawn already, as
  /// DepthPyramid::build() takes them, or none; where they are nearer, they count. More items may follow. `threads`
  /// share in it, if there are any.
  void build(DepthPyramid& pyramid, std::span<const float> drawn = {}, core::ThreadPool* threads = nullptr);
  /// Leaves out cylinders, straight snouts and circular tori that are hidden by what a pyramid holds, of an image of
  /// this view and size. Other items stay: their boxes should have been tested (OcclusionTest). `error`: as there.
  /// Several threads may call it at once.
  void leave_out_occluded(core::VisibleSet& items, const DepthPyramid& pyramid, double error = 0.0) const;

 private:
  struct Solid;
  struct AddBuffers;
  struct HiddenBuffers;
  struct Placed {
    core::Affine eye_from_item;
    core::AabbD box;  // relative to the eye
    double size;      // its diagonal
  };
  void add(std::span<const core::Slot> slots, OccluderRaster& raster) const;
  void look_up(std::span<const core::Slot> slots, std::vector<Solid>& solids) const;
  Placed place(const Solid& solid) const;
  WholeSolid find_inner_occluders(const Solid& solid, std::vector<OccluderPolygon>& polygons) const;

  const core::Snapshot* snapshot_ = nullptr;
  int width_ = 0, height_ = 0;
  core::dvec3 eye_{0.0}, forward_{0.0};
  bool perspective_ = true;
  OccluderRaster empty_;  // of this view
  std::unique_ptr<ObjectPool<OccluderRaster>> of_threads_;
  std::vector<const OccluderRaster*> rasters_;
};

}  // namespace sightline::culling
