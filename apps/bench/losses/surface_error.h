// How far the surfaces that an image shows lie from those of a reference. Internal to sightline-bench contribution and
// lod.
#pragma once

#include <vector>

#include "sightline/core/view.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::bench {

/// Both images hold the first surface at each sample; a reference has several samples a pixel along each axis.
/// For each pixel of an image, the distance in space from the point that it shows to the nearest point that the
/// reference shows of the same item, in pixels as they are at that depth. So it holds errors of depth as well as those
/// across the image. Between samples of an item the reference is taken as triangles. Pixels whose item the reference
/// does not show within `radius` pixels are left out: what another item hides there cannot be compared. `view`:
/// perspective and symmetric. The reference is `finer` times as wide and high as the image.
std::vector<double> surface_errors(const core::View& view, const image::ItemDepths& reference, int finer,
                                   const image::ItemDepths& image, double radius);

}  // namespace sightline::bench
