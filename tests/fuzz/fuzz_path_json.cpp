// Camera paths as JSON; what was read is written and read again, and must be the same.
#include "sightline/importers/view_json.h"
#include "sightline/tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const auto path = importers::parse_path(fuzz::text_of(data, size), "fuzz.json");
  if (!path) {
    fuzz::require(!path.error().message.empty(), "a message");
    return 0;
  }
  for (const int frame : {0, 1, 4, 9}) {
    const auto view = path->view(path->time_of(frame, 10), 1.5);
    fuzz::require(view.has_value() || !view.error().message.empty(), "a view or a message");
  }
  const auto again = importers::parse_path(importers::format_path(*path), "again.json");
  fuzz::require(again.has_value(), again ? "" : again.error().message);
  fuzz::require(again->keys().size() == path->keys().size(), "as many keys after writing and reading");
  for (std::size_t i = 0; i < path->keys().size(); ++i) {
    const core::CameraKey &a = path->keys()[i], &b = again->keys()[i];
    fuzz::require(
        a.time == b.time && a.pose.eye == b.pose.eye && a.pose.target == b.pose.target && a.pose.up == b.pose.up,
        "the same keys after writing and reading");
  }
  return 0;
}
