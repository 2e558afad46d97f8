// Viewpoints as BCF 2.1 (BIM Collaboration Format, buildingSMART): a zip archive with a topic for each view.
//
// A view's name is the topic's title, its comment the topic's comment. Components are named by node paths: their
// AuthoringToolId is to_text() of the part (item_names.h), their OriginatingSystem "Sightline", and their IfcGuid that
// of the node's attributes, if there is one. Measurements and mark-ups are lines (bcf_lines.h). Faint items are
// components with a colour of low alpha. BCF keeps no target and no near plane of cameras.
//
// A view that was read keeps all of its topic (Viewpoint::origin): what this library does not show, such as labels,
// bitmaps, documents and comments of others, is written with it again, and so are topics without a view. Words below a
// comment are another comment. Files that have views of one archive alone keep its version of BCF; in others all
// is 2.1.
//
// Without libzip or pugixml both functions fail, and say so.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "sightline/apps/viewpoints/viewpoint.h"

namespace sightline::apps {

/// The bytes of a file.
core::Expected<std::string> format_bcf(std::span<const Viewpoint> views);

/// A view for each viewpoint of each topic, also of BCF 2.0 and 3.0. Any bytes are safe to read: an archive that is cut
/// off, holds more than 256 MiB, or names paths outside itself is an error, which begins with `source`.
core::Expected<ViewFile> parse_bcf(std::string_view bytes, const std::string& source);

}  // namespace sightline::apps
