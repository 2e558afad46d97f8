// How large items look. Internal to culling and engine.
#pragma once

#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"

namespace sightline::culling {

/// How many pixels items are large in the mean, as the diagonals of their boxes say, in an image of `height` rows: the
/// diagonal's square as it looks from the side. An estimate: some 128 of the items are looked at, evenly spaced in the
/// set, and one of more than 10,000 pixels counts as that many. 0: there are none.
double mean_area(const core::View& view, const core::ItemBounds& bounds, const core::VisibleSet& set, int height);

}  // namespace sightline::culling
