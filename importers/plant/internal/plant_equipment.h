// Internal to the plant generator: everything that is not a pipe run. Each function adds parts to the system being
// staged.
#pragma once

#include <span>

#include "sightline/core/aabb.h"
#include "sightline/importers/plant/internal/plant_stage.h"

namespace sightline::importers::plant {

/// Columns on a grid over the footprint, beams at the levels, all of box profiles.
struct SteelGrid {
  core::AabbD block;
  int bays_x = 1, bays_y = 1;
};
std::int64_t steel_frame_cost(const SteelGrid& grid, std::size_t levels);
void add_steel_frame(Stage& stage, const SteelGrid& grid, std::span<const double> levels);

/// Grating panels with a handrail around: corners of the rectangle at height low.z; high.z is ignored.
void add_platform(Stage& stage, const dvec3& low, const dvec3& high);
/// Top and knee rail with rounded corners, and posts.
void add_handrail(Stage& stage, const dvec3& low, const dvec3& high);
/// A flight along +x or -x (`sign`) from the foot, three metres up for four along.
void add_stairs(Stage& stage, const dvec3& foot, double sign, double width, double rise);
/// Rungs and stringers up from the foot, facing `outwards`.
void add_ladder(Stage& stage, const dvec3& foot, const dvec3& outwards, double height);
void add_cable_tray(Stage& stage, const dvec3& from, const dvec3& along, double length);
/// Air duct with a rectangular bend in the middle.
void add_duct(Stage& stage, const dvec3& from, double length, double size);

/// Upright vessel on a skirt, with dished ends and nozzles; tall and wide ones get ring platforms and a ladder.
void add_column(Stage& stage, Random& random, const dvec3& foot, double radius, double height);
/// Horizontal vessel on saddles along +x.
void add_drum(Stage& stage, Random& random, const dvec3& foot, double radius, double length);
void add_tank(Stage& stage, Random& random, const dvec3& foot, double radius, double height);
void add_sphere_tank(Stage& stage, const dvec3& foot, double radius);
void add_pump(Stage& stage, const dvec3& foot, double size);
void add_hopper(Stage& stage, const dvec3& foot, double size);
/// Paved ground as a facet group with an opening, and its edges as lines.
void add_paving(Stage& stage, const dvec3& low, const dvec3& high);

}  // namespace sightline::importers::plant
