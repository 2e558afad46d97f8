// How long the window's thread may work on something before it looks at its events again.
#pragma once

namespace sightline::apps {

constexpr double kPortion = 0.016;  ///< seconds

}  // namespace sightline::apps
