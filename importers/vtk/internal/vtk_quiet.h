// Internal to the importers: keeps VTK's messages off the console while an import runs.
#pragma once

namespace sightline::importers {

/// While an object of this class lives, VTK shows no errors and warnings, for the whole process. VTK's logger writes to
/// stderr whatever output window or observer there is, and only this switch comes before both. No information is lost:
/// of VTK, only its decompressors work on a file's bytes, and what they refuse is reported with its position.
class VtkQuiet {
 public:
  VtkQuiet();
  ~VtkQuiet();
  VtkQuiet(const VtkQuiet&) = delete;
  VtkQuiet& operator=(const VtkQuiet&) = delete;
};

}  // namespace sightline::importers
