// Scripts that drive the viewer: a command a line, as the viewer's key list names them, or one of the script's own.
//
//   # a comment
//   fit                         a command of the viewer, with its argument after a space
//   click 320 200 ctrl          moves the cursor there and clicks: left, right, middle; with shift, ctrl, alt
//   drag 100 100 200 150 right  a drag; through more points where there are more
//   menu Edit, Select all       a command by the words of its menus; ": ARGUMENT" may follow
//   move 320 200                moves the cursor
//   wheel 3                     turns the wheel away from the user
//   press ctrl+z                a key
//   hold w 2                    a key held for some seconds
//   type valve                  text
//   resize 800x600              the window, screen units
//   wait 0.5                    seconds
//   window-shot FILE            PNG of the whole window
//   expect /selection/count = 3 a value of the viewer's state (--json): = != < > <= >=, value in JSON or as text
//
// Each line waits until the lines before it have been carried out and the image is complete.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/apps/view/events.h"
#include "sightline/core/error.h"

namespace sightline::apps {

struct ScriptStep {
  int line = 0;
  std::string name, argument;
};

/// Fails where a file cannot be read, and where it would write an image under the name of another format than PNG.
core::Expected<std::vector<ScriptStep>> read_script(const std::filesystem::path& file);
std::vector<ScriptStep> parse_script(std::string_view text);

/// The events of click, drag, move, wheel, press and type; no events for other names. Fails on bad arguments.
core::Expected<std::vector<Event>> events_of(const ScriptStep& step);

/// Whether a value, as JSON text, is as an `expect` demands: "OPERATOR VALUE". Numbers compare as numbers, anything
/// else as text. Fails on bad operators.
core::Expected<bool> fulfils(const std::string& value, std::string_view demand);

}  // namespace sightline::apps
