// Views as JSON.
#include <array>

#include "sightline/importers/view_json.h"
#include "sightline/tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const auto view = importers::parse_view(fuzz::text_of(data, size), 1.5, "fuzz.json");
  if (!view) {
    fuzz::require(!view.error().message.empty(), "a message");
    return 0;
  }
  for (const core::dmat4* matrix : {&view->eye_from_world(), &view->clip_from_eye()})
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) fuzz::require(core::is_finite(core::dvec3((*matrix)[c][r])), "finite matrices");
  fuzz::require(view->sections.size() <= core::kMaxSectionPlanes, "no more section planes than allowed");
  core::frustum_planes(view->clip_from_world(), view->clip_depth());
  if (const auto moved = importers::translated(*view, {1.0, 2.0, 3.0}))
    fuzz::require(moved->sections.size() == view->sections.size(), "the same sections");
  return 0;
}
