// Which way up a model is likely to be, for files that do not say.
#pragma once

#include <span>
#include <string>

#include "sightline/core/scene.h"

namespace sightline::apps {

/// Whether all of these files are of formats that do not say which axis points up: OBJ, PLY, STL.
bool leave_up_open(std::span<const std::string> files);

/// Whether the meshes of a scene, read with z up, stand on a base if y pointed up, and on none as they are. A guess:
/// the base of an axis is what faces down within 3 % of its extent from its lowest place, as a share of the rectangle
/// about all. That of y must be 5 % and three times that of z. Reads each triangle once.
bool seems_to_have_y_up(const core::Scene& scene);

}  // namespace sightline::apps
