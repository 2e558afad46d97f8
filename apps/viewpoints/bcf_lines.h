// Measurements and mark-ups in BCF. Other programs show them as the lines of a viewpoint, and their words in its
// snapshot. What lines do not say is in a file of our own beside the viewpoint: a view file (viewpoint.h) with this
// camera. Internal to apps/viewpoints.
#pragma once

#include <string>

#include "sightline/apps/viewpoints/bcf_topics.h"

namespace sightline::apps {

/// Adds the lines of a view, where it has any.
void add_lines(Node root, const Viewpoint& view);

/// The name of our file for that of a viewpoint.
std::string marks_file(const std::string& viewpoint_file);
/// What that file holds; empty where lines alone say the same.
std::string marks_text(const Viewpoint& view);

/// Gives a view what our file has, but for what has no longer all of its lines, since another program has changed them.
/// Lines that are left become mark-ups, those that join become one. `marks`: our file's text; null where there is none.
/// Where that is damaged, all lines are left.
void take_lines(const Node& root, const std::string* marks, Viewpoint& view);

}  // namespace sightline::apps
