// Internal to the importers: which axis points up in files of formats that do not say.
#pragma once

#include <optional>
#include <string_view>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// The axis that a comment names: "z up", "Y-up", "up axis: Z", "up = +y". Nothing where it names none.
std::optional<UpAxis> up_axis_in_comment(std::string_view text);

/// Whether the meshes below a file's node stand on a base if its y points up, and on none as they are. The base of a
/// direction is what faces away from it within 3 % of the extent from its lowest place, as a share of the rectangle
/// about all. That of y must be 5 % and three times those of -y, z and -z, which keeps machine parts with equal faces
/// on opposite sides as they are. Reads each triangle near the ends once.
bool seems_to_have_y_up(const core::Scene& scene, core::NodeId file_node);

}  // namespace sightline::importers
