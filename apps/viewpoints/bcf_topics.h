// What reading and writing of BCF share: topics as their files have them. Internal to apps/viewpoints.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <pugixml.hpp>

#include "sightline/apps/viewpoints/viewpoint.h"
#include "sightline/apps/viewpoints/zip_archive.h"

namespace sightline::apps {

using Node = pugi::xml_node;

/// All that a file held.
struct BcfArchive {
  ZipEntries entries;
  std::set<std::pair<std::string, std::string>> shown;  ///< folder and file of viewpoints that became views
};

/// Where a view was read, and as what.
struct BcfOrigin {
  std::shared_ptr<const BcfArchive> archive;
  std::string folder;          ///< of the topic, with a slash at its end
  std::string guid;            ///< of the viewpoint
  std::string file, snapshot;  ///< in the folder; may be empty
  bool first = true;           ///< of the topic's viewpoints: stands for the topic
  Viewpoint view;
};

std::optional<double> number_of(const Node& node);
/// The point that X, Y and Z are; none where one is missing.
std::optional<core::dvec3> xyz_of(const Node& node);
/// So that reading gives the same number.
std::string number(double value);
/// XML 1.0 has no control characters but tab and ends of lines.
std::string printable(std::string text);
void add_text(Node parent, const char* name, const std::string& text);
void add_vector(Node parent, const char* name, const core::dvec3& v);

/// Whether a colour stands for a faint component: one of low alpha.
bool is_faint(const Node& colour);
/// In the order of their indices; those without one follow as they stand.
std::vector<Node> viewpoints_of(const Node& markup);
/// Comments with words that name a viewpoint, and for the first viewpoint those that name none.
std::vector<Node> comment_nodes(const Node& markup, const std::string& viewpoint, bool first);

}  // namespace sightline::apps
