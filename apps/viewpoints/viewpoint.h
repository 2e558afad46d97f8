// Places to come back to: camera, sections, what is hidden, faint and selected, as the view files that all tools read
// (importers/view_json.h) with keys of the viewer's own:
//
//   {view …, "name":"…", "comment":"…", "author":"…", "date":"2026-01-31T12:00:00Z", "guid":"…",
//    "hidden":PARTS, "ghosts":PARTS, "selection":PARTS}
// "measurements":[{"from":[X,Y,Z], "to":[X,Y,Z], "words":"…"}], "markups":[…] (markup.h) and "colour_by":"KEY"
// (analysis/query/colouring.h).
//
//   {first view …, "views":[view, …]}                         a list, which other tools read as its first view
//
// PARTS is an array of part names (item_names.h), or {"all_but":[…]}. A view without any of these three keys leaves
// visibility as it is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/viewpoints/item_names.h"
#include "sightline/apps/viewpoints/markup.h"
#include "sightline/core/error.h"
#include "sightline/core/view.h"

namespace sightline::apps {

/// A distance that was measured, between two points of the world.
struct Measurement {
  core::dvec3 from{0.0}, to{0.0};
  std::string words;  ///< what was measured

  double distance() const { return glm::length(to - from); }
  friend bool operator==(const Measurement&, const Measurement&) = default;
};

struct BcfOrigin;  // of bcf_topics.h

struct Viewpoint {
  core::Pose pose;
  double fovy = 1.0;  ///< radians; of orthographic views as Camera has it
  bool orthographic = false;
  double near = 0.1;  ///< of perspective views; 0: as the camera has it
  std::vector<core::Plane> sections;
  std::vector<Measurement> measurements;
  std::vector<Markup> markups;
  bool has_target = true;  ///< false: the pose's target only tells the direction

  struct Shown {
    PartSet hidden, ghosts, selection;
  };
  std::optional<Shown> shown;  ///< none: visibility and selection stay as they are

  std::optional<std::string> colour_by;  ///< key of query::colour_by(), empty: the model's own; none: colours stay
  std::string name, comment, author;
  std::string status, type;            ///< of the topic that it is: "Open", "Clash"
  std::string guid;                    ///< of 32 lower-case digits in five groups
  std::string date;                    ///< when it was made, as in XML
  std::vector<std::uint8_t> snapshot;  ///< PNG; not in JSON
  /// The BCF topic that it was read from, whose other contents are written with it; null: none. Not in JSON.
  std::shared_ptr<const BcfOrigin> origin;
};

std::string format_viewpoint(const Viewpoint& viewpoint);
std::string format_viewpoints(std::span<const Viewpoint> viewpoints);
/// The views of a list, or the one view that the text is. Fails as importers::parse_view() does. `source` names the
/// text in errors.
core::Expected<std::vector<Viewpoint>> parse_viewpoints(const std::string& json, const std::string& source);

/// Whose views those are that this process makes: SIGHTLINE_AUTHOR, else the user's name.
std::string author_name();
/// The present time as in XML, in UTC.
std::string date_now();

/// What a file of views holds.
struct ViewFile {
  std::vector<Viewpoint> views;
  std::size_t left_out = 0;  ///< topics and viewpoints without a camera that can be shown
};

/// The viewpoint of a model that was moved by `offset`.
Viewpoint translated(const Viewpoint& viewpoint, const core::dvec3& offset);

}  // namespace sightline::apps
