// What the command line says, and what the viewer shows beside the model: switches of panels and of images.
#pragma once

#include <string>

#include "sightline/apps/common/model.h"
#include "sightline/apps/view/settings.h"

namespace sightline::apps {

struct ViewerOptions {
  ModelOptions model;
  std::string size = "1280x720", path, save_path = "path.json", screenshot, json_file, script, settings, theme = "dark";
  engine::CullerChoice culler = engine::CullerChoice::kAutomatic;
  std::optional<culling::GpuVariant> gpu_variant;
  int samples = 1;
  DrawnOptions shown;
  int frames = 0;
  double default_budget_ms = 0.0;  ///< Session::set_default_budget() where a software rasteriser draws
  double scale = 0.0;              ///< of text and panels; 0: as the screen suggests
  bool panels = true, smooth = true;

  /// Whether there are settings to keep: scripts and --frames must do the same for everybody.
  bool remembers() const { return !settings.empty() || (script.empty() && frames == 0); }
};

/// A window in the middle that asks or tells something; there is one at a time.
enum class Dialog {
  kNone,
  kHelp,
  kDriver,
  kOpen,
  kCompare,
  kQuit,
  kImage,
  kPath,
  kReadPath,
  kSavePath,
  kFrames,
  kReadViews,
  kSaveViews,
  kSaveAndQuit,
  kExportModel,
  kExportSelection,
  kSaveSession,
  kAppend,
};
const char* name_of(Dialog dialog);

/// What a click in the image does.
enum class Tool {
  kSelect,
  kMeasure,  ///< sets marks
  kSection,  ///< cuts at a face, once
  kMark,     ///< draws mark-ups
};
const char* name_of(Tool tool);

struct Shown : Settings {
  Dialog dialog = Dialog::kNone;
  Tool tool = Tool::kSelect;
  bool context = false;  ///< the context menu opens next
  bool section_handles = true;
  bool edges = false;                 ///< engine::Edges; not remembered: models have them that came with faces
  std::string image_background = {};  ///< of images that are written, as --background takes it; empty: as shown
  bool image_marks = true;            ///< in images that are written: mark-ups, measurements, the colours' legend
  bool find = false;                  ///< the search field gets the keyboard next
  const char* tab = "Item";           ///< of the right panel, in front; the first where it has no such tab
};

}  // namespace sightline::apps
