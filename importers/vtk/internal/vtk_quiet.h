// Internal to the importers: VTK prints what it does not like. While an import runs, nothing of that reaches a console.
#pragma once

namespace sightline::importers {

/// While one lives VTK shows no errors and warnings, for the whole process: its logger writes to stderr whatever output
/// window or observer there is, and only this switch of VTK's comes before both. Nothing is lost by it: on a file's
/// bytes work VTK's decompressors alone, and what they refuse is told with its place.
class VtkQuiet {
 public:
  VtkQuiet();
  ~VtkQuiet();
  VtkQuiet(const VtkQuiet&) = delete;
  VtkQuiet& operator=(const VtkQuiet&) = delete;
};

}  // namespace sightline::importers
