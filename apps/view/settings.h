// What the viewer remembers from run to run, and the file that holds it.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "sightline/apps/common/numbers.h"
#include "sightline/apps/view/selection_level.h"
#include "sightline/core/error.h"

namespace sightline::apps {

struct Settings {
  static constexpr std::size_t kMostRecent = 10, kMostSets = 100;
  static constexpr double kLargestDensity = 1e6;

  bool light = false;                       ///< colours
  bool smooth = true;                       ///< edges at rest
  bool panels = true;                       ///< shown
  bool triad = true;                        ///< shown
  bool depth_shading = true;                ///< engine::DepthShading
  bool hatching = true;                     ///< engine::Hatching
  bool lower = true;                        ///< resolution while the view moves and frames come late
  bool levels = true;                       ///< of detail of meshes, while the view moves
  float tree_width = 0.0f;                  ///< of the left panel, in lines of text; 0: as the window's size suggests
  float side_width = 0.0f;                  ///< of the right panel
  std::vector<std::string> recent;          ///< files opened, the last one first, with absolute paths
  std::array<int, 2> window = {1280, 720};  ///< screen units
  std::string cache;                        ///< folder of scene caches, with an absolute path; empty: none
  Units units = Units::kAutomatic;          ///< of lengths
  bool diagnostics = false;                 ///< the tab is shown
  bool recognise = false;                   ///< primitives, in meshes of files that are opened
  SelectionLevel level = SelectionLevel::kPart;  ///< of clicks
  double density = 7850.0;                       ///< kg a cubic metre, of what is weighed: steel
  std::vector<std::string> sets;                 ///< searches that are kept, in the order kept

  /// Puts a file that was opened first.
  void add_recent(const std::string& file);

  friend bool operator==(const Settings&, const Settings&) = default;
};

/// A JSON object. Keys that it does not know stay as they are. Several viewers may share a file: each writes only what
/// was changed in it.
class SettingsFile {
 public:
  /// Remembers nothing.
  SettingsFile() = default;
  /// A file that is missing is no error; one that is damaged, or a value in it, counts as missing and is in damage().
  explicit SettingsFile(std::filesystem::path file);

  /// sightline/view.json in XDG_CONFIG_HOME, otherwise in .config in HOME; empty where neither is set.
  static std::filesystem::path default_place();

  const std::filesystem::path& file() const { return file_; }  ///< empty: it remembers nothing
  /// As the file said when it was opened.
  const Settings& settings() const { return kept_; }
  /// What is wrong with the file, with its name; empty where nothing is.
  const std::string& damage() const { return damage_; }

  /// What holds now without being remembered, such as what a command line says.
  void begin(const Settings& settings) { kept_ = settings; }
  /// Writes what has changed since begin() or the last call, if anything; the file appears whole or not at all. What
  /// could not be written is not tried again.
  core::Expected<void> keep(Settings settings);

 private:
  std::filesystem::path file_;
  Settings kept_;
  std::string damage_;
};

}  // namespace sightline::apps
