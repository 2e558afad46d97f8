#include "sightline/apps/viewpoints/bcf.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <sstream>

#include <pugixml.hpp>

#include "sightline/apps/common/model.h"
#include "sightline/apps/viewpoints/zip_archive.h"
#include "sightline/core/internal/ascii_case.h"
#include "sightline/core/internal/hash.h"

namespace sightline::apps {
namespace {

using Node = pugi::xml_node;

constexpr std::uint64_t kMostArchiveBytes = std::uint64_t(256) << 20;  // of all files of an archive
constexpr std::string_view kPng("\x89PNG\r\n\x1a\n", 8);
constexpr const char *kSystem = "Sightline", *kFaintColour = "40808080";  // alpha, red, green, blue
constexpr const char* kNoDate = "1970-01-01T00:00:00Z";

// --- writing ---------------------------------------------------------------------------------------------------------

/// Another GUID that is always the same for this one, so that who reads a file twice knows its parts again.
std::string derived_guid(const std::string& guid, std::string_view what) {
  std::string derived;
  for (int half = 0; half < 2; ++half) {
    std::uint64_t hash = core::fnv1a(what, core::fnv1a(guid, core::kFnvBasis + std::uint64_t(half)));
    for (int i = 0; i < 16; ++i, hash >>= 4) derived += "0123456789abcdef"[hash & 15];
  }
  derived[12] = '8';  // version 8: made by a rule of one's own
  derived[16] = "89ab"[derived[16] & 3];
  for (const std::size_t at : {20, 16, 12, 8}) derived.insert(at, 1, '-');
  return derived;
}

std::string number(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// XML 1.0 has no control characters but tab and ends of lines.
std::string printable(std::string text) {
  for (char& c : text)
    if (std::uint8_t(c) < 32 && c != '\t' && c != '\n' && c != '\r') c = ' ';
  return text;
}

void add_text(Node parent, const char* name, const std::string& text) {
  parent.append_child(name).text().set(printable(text).c_str());
}

void add_vector(Node parent, const char* name, const core::dvec3& v) {
  Node node = parent.append_child(name);
  add_text(node, "X", number(v.x));
  add_text(node, "Y", number(v.y));
  add_text(node, "Z", number(v.z));
}

void add_components(Node parent, const std::vector<PartName>& parts) {
  for (const PartName& part : parts) {
    Node component = parent.append_child("Component");
    if (!part.guid.empty() && !part.item) component.append_attribute("IfcGuid") = printable(part.guid).c_str();
    add_text(component, "OriginatingSystem", kSystem);
    add_text(component, "AuthoringToolId", to_text(part));
  }
}

void add_shown(Node root, const Viewpoint::Shown& shown) {
  Node components = root.append_child("Components");
  if (!shown.selection.empty()) add_components(components.append_child("Selection"), shown.selection.parts);
  Node visibility = components.append_child("Visibility");
  visibility.append_attribute("DefaultVisibility") = !shown.hidden.all_but;
  if (!shown.hidden.parts.empty()) add_components(visibility.append_child("Exceptions"), shown.hidden.parts);
  if (shown.ghosts.parts.empty()) return;
  Node colour = components.append_child("Coloring").append_child("Color");
  colour.append_attribute("Color") = kFaintColour;
  add_components(colour, shown.ghosts.parts);
}

void add_camera(Node root, const Viewpoint& view) {
  const core::dvec3 ahead = view.pose.target - view.pose.eye;
  Node camera = root.append_child(view.orthographic ? "OrthogonalCamera" : "PerspectiveCamera");
  add_vector(camera, "CameraViewPoint", view.pose.eye);
  add_vector(camera, "CameraDirection", glm::normalize(ahead));
  add_vector(camera, "CameraUpVector", glm::normalize(view.pose.up));
  if (view.orthographic)
    add_text(camera, "ViewToWorldScale", number(2.0 * glm::length(ahead) * std::tan(0.5 * view.fovy)));
  else
    add_text(camera, "FieldOfView", number(glm::degrees(view.fovy)));
}

void add_lines(Node root, const std::vector<Measurement>& measurements) {
  if (measurements.empty()) return;
  Node list = root.append_child("Lines");
  for (const Measurement& one : measurements) {
    Node node = list.append_child("Line");
    add_vector(node, "StartPoint", one.from);
    add_vector(node, "EndPoint", one.to);
  }
}

/// A plane's direction is where it cuts away.
void add_planes(Node root, const std::vector<core::Plane>& planes) {
  if (planes.empty()) return;
  Node list = root.append_child("ClippingPlanes");
  for (const core::Plane& plane : planes) {
    const double square = glm::dot(plane.normal, plane.normal);
    Node node = list.append_child("ClippingPlane");
    add_vector(node, "Location", plane.normal * (-plane.offset / square));
    add_vector(node, "Direction", plane.normal / -std::sqrt(square));
  }
}

std::string text_of(pugi::xml_document& document) {
  Node declaration = document.prepend_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  std::ostringstream out;
  document.save(out, " ");
  return out.str();
}

std::string version_text() {
  pugi::xml_document document;
  Node root = document.append_child("Version");
  root.append_attribute("VersionId") = "2.1";
  add_text(root, "DetailedVersion", "2.1");
  return text_of(document);
}

std::string viewpoint_text(const Viewpoint& view, const std::string& guid) {
  pugi::xml_document document;
  Node root = document.append_child("VisualizationInfo");
  root.append_attribute("Guid") = guid.c_str();
  if (view.shown) add_shown(root, *view.shown);
  add_camera(root, view);
  add_lines(root, view.measurements);
  add_planes(root, view.sections);
  return text_of(document);
}

std::string markup_text(const Viewpoint& view, const std::string& guid, std::size_t index) {
  const std::string date = view.date.empty() ? kNoDate : view.date,
                    author = view.author.empty() ? "unknown" : view.author;
  const std::string viewpoint_guid = derived_guid(guid, "viewpoint");
  pugi::xml_document document;
  Node root = document.append_child("Markup"), topic = root.append_child("Topic");
  topic.append_attribute("Guid") = guid.c_str();
  add_text(topic, "Title", view.name);
  add_text(topic, "Index", std::to_string(index));
  add_text(topic, "CreationDate", date);
  add_text(topic, "CreationAuthor", author);
  if (!view.comment.empty()) {
    Node comment = root.append_child("Comment");
    comment.append_attribute("Guid") = derived_guid(guid, "comment").c_str();
    add_text(comment, "Date", date);
    add_text(comment, "Author", author);
    add_text(comment, "Comment", view.comment);
    comment.append_child("Viewpoint").append_attribute("Guid") = viewpoint_guid.c_str();
  }
  Node viewpoint = root.append_child("Viewpoints");
  viewpoint.append_attribute("Guid") = viewpoint_guid.c_str();
  add_text(viewpoint, "Viewpoint", "viewpoint.bcfv");
  if (!view.snapshot.empty()) add_text(viewpoint, "Snapshot", "snapshot.png");
  return text_of(document);
}

bool is_guid(const std::string& text) {
  if (text.size() != 36) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool dash = i == 8 || i == 13 || i == 18 || i == 23;
    if (dash ? text[i] != '-' : !std::strchr("0123456789abcdef", text[i])) return false;
  }
  return true;
}

// --- reading ---------------------------------------------------------------------------------------------------------

std::optional<double> number_of(const Node& node) {
  std::string_view text = node.text().get();
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '+'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  double value = 0.0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = !text.empty() && read.ec == std::errc() && read.ptr == text.data() + text.size();
  return good && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<core::dvec3> vector_of(const Node& node) {
  const auto x = number_of(node.child("X")), y = number_of(node.child("Y")), z = number_of(node.child("Z"));
  return x && y && z ? std::optional(core::dvec3(*x, *y, *z)) : std::nullopt;
}

std::optional<core::dvec3> direction_of(const Node& node) {
  const auto v = vector_of(node);
  const double length = v ? glm::length(*v) : 0.0;
  return length > 1e-100 && std::isfinite(length) ? std::optional(*v / length) : std::nullopt;
}

/// None where no camera can be made of it.
std::optional<Viewpoint> camera_of(const Node& root) {
  Viewpoint view;
  const Node parallel = root.child("OrthogonalCamera");
  view.orthographic = bool(parallel);
  const Node camera = parallel ? parallel : root.child("PerspectiveCamera");
  const auto eye = vector_of(camera.child("CameraViewPoint"));
  const auto ahead = direction_of(camera.child("CameraDirection"));
  if (!eye || !ahead) return std::nullopt;
  view.fovy = kFovy;
  view.near = 0.0;
  view.has_target = false;
  double distance = 1.0;
  if (view.orthographic) {
    const double height = number_of(parallel.child("ViewToWorldScale")).value_or(0.0);
    if (!(height > 0.0)) return std::nullopt;
    distance = 0.5 * height / std::tan(0.5 * kFovy);
  } else if (const auto degrees = number_of(camera.child("FieldOfView"))) {
    view.fovy = glm::radians(std::clamp(*degrees, 1.0, 170.0));
  }
  view.pose = {*eye, *eye + distance * *ahead, {0, 0, 1}};
  const auto up = direction_of(camera.child("CameraUpVector"));
  for (const core::dvec3& candidate : {up.value_or(core::dvec3(0, 0, 1)), {0, 0, 1}, {0, 1, 0}}) {
    view.pose.up = candidate;
    if (core::View::perspective(view.pose, view.fovy, 1.0, 0.1 * distance, core::kInfiniteFar)) return view;
  }
  return std::nullopt;
}

std::vector<core::Plane> planes_of(const Node& root) {
  std::vector<core::Plane> planes;
  for (const Node& node : root.child("ClippingPlanes").children("ClippingPlane")) {
    const auto location = vector_of(node.child("Location")), direction = direction_of(node.child("Direction"));
    if (!location || !direction || planes.size() == core::kMaxSectionPlanes) continue;
    planes.push_back({-*direction, glm::dot(*direction, *location)});
  }
  return planes;
}

/// Without words: BCF has none for its lines.
std::vector<Measurement> lines_of(const Node& root) {
  std::vector<Measurement> lines;
  for (const Node& node : root.child("Lines").children("Line")) {
    const auto from = vector_of(node.child("StartPoint")), to = vector_of(node.child("EndPoint"));
    if (from && to) lines.push_back({*from, *to, ""});
  }
  return lines;
}

/// None where it has no name at all.
std::optional<PartName> component_of(const Node& node) {
  const std::string id = node.child("AuthoringToolId").text().get();
  PartName part;
  if (!id.empty()) part = part_of(id);
  if (!part.item) part.guid = node.attribute("IfcGuid").value();
  return id.empty() && part.guid.empty() ? std::nullopt : std::optional(part);
}

std::vector<PartName> components_of(const Node& parent) {
  std::vector<PartName> parts;
  for (const Node& node : parent.children("Component"))
    if (auto part = component_of(node)) parts.push_back(std::move(*part));
  return parts;
}

bool is_faint(const Node& colour) {
  const std::string argb = colour.attribute("Color").value();
  return argb.size() == 8 && std::strchr("01234567", argb[0]);
}

/// BCF 2.0 has switches on each component instead.
void add_switched(Viewpoint::Shown& shown, const Node& components) {
  for (const Node& node : components.children("Component")) {
    const auto part = component_of(node);
    if (!part) continue;
    if (!node.attribute("Visible").as_bool(true)) shown.hidden.parts.push_back(*part);
    if (node.attribute("Selected").as_bool(false)) shown.selection.parts.push_back(*part);
  }
}

Viewpoint::Shown shown_of(const Node& root) {
  Viewpoint::Shown shown;
  const Node components = root.child("Components"), visibility = components.child("Visibility");
  shown.selection.parts = components_of(components.child("Selection"));
  shown.hidden.parts = components_of(visibility.child("Exceptions"));
  // Without exceptions nothing would be shown, which no writer means.
  shown.hidden.all_but =
      visibility && !visibility.attribute("DefaultVisibility").as_bool(false) && !shown.hidden.parts.empty();
  for (const Node& colour : components.child("Coloring").children("Color"))
    if (is_faint(colour))
      for (PartName& part : components_of(colour)) shown.ghosts.parts.push_back(std::move(part));
  add_switched(shown, components);
  return shown;
}

/// The text of all comments that name a viewpoint, and for the first viewpoint of those that name none.
std::string comments_of(const Node& markup, const std::string& viewpoint, bool first) {
  std::string text;
  // BCF 3.0 has them below the topic.
  for (const Node& list : {markup, markup.child("Topic").child("Comments")})
    for (const Node& node : list.children("Comment")) {
      const std::string of = node.child("Viewpoint").attribute("Guid").value();
      const std::string words = node.child("Comment").text().get();
      if (!words.empty() && (of.empty() ? first : core::lower_case(of) == core::lower_case(viewpoint)))
        text += (text.empty() ? "" : "\n") + words;
    }
  return text;
}

/// In the order of their indices; those without one follow as they stand.
std::vector<Node> viewpoints_of(const Node& markup) {
  std::vector<Node> nodes;
  const auto topic = markup.child("Topic").child("Viewpoints").children("ViewPoint");  // of BCF 3.0
  for (const auto& list : {markup.children("Viewpoints"), topic}) nodes.insert(nodes.end(), list.begin(), list.end());
  const auto index = [](const Node& node) { return number_of(node.child("Index")).value_or(HUGE_VAL); };
  std::stable_sort(nodes.begin(), nodes.end(), [&](const Node& a, const Node& b) { return index(a) < index(b); });
  return nodes;
}

class Reader {
 public:
  Reader(const ZipEntries& entries, const std::string& source) : entries_(entries), source_(source) {}

  core::Expected<void> topic(const std::string& markup_path, const std::string& markup_bytes);
  /// The views, by the index of their topics.
  ViewFile take() &&;

 private:
  /// A file of the topic's folder; null where there is none.
  const std::string* entry(const std::string& name) const {
    const auto it = name.empty() ? entries_.end() : entries_.find(folder_ + name);
    return it != entries_.end() ? &it->second : nullptr;
  }
  core::Expected<void> parse(pugi::xml_document& document, const std::string& path, const std::string& bytes) const {
    const auto parsed = document.load_buffer(bytes.data(), bytes.size());
    if (parsed) return {};
    return core::fail(source_ + ": " + path + ": byte " + std::to_string(parsed.offset) +
                      ": expected XML: " + parsed.description());
  }
  core::Expected<bool> viewpoint(const Node& markup, const std::string& guid, const std::string& name,
                                 const std::string& snapshot, std::size_t index);

  const ZipEntries& entries_;
  const std::string& source_;
  std::string folder_;
  std::vector<std::pair<double, Viewpoint>> views_;  // with the topic's index
  std::size_t left_out_ = 0;
};

ViewFile Reader::take() && {
  std::stable_sort(views_.begin(), views_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  ViewFile file{{}, left_out_};
  for (auto& [index, view] : views_) file.views.push_back(std::move(view));
  return file;
}

/// False where it has no camera, and is left out. `index`: of the topic's viewpoints.
core::Expected<bool> Reader::viewpoint(const Node& markup, const std::string& guid, const std::string& name,
                                       const std::string& snapshot, std::size_t index) {
  const std::string* bytes = entry(name);
  if (!bytes) return false;
  pugi::xml_document document;
  if (auto parsed = parse(document, folder_ + name, *bytes); !parsed) return tl::unexpected(parsed.error());
  const Node root = document.child("VisualizationInfo"), topic = markup.child("Topic");
  auto view = camera_of(root);
  if (!view) return false;
  view->sections = planes_of(root);
  view->measurements = lines_of(root);
  view->shown = shown_of(root);
  view->name = topic.child("Title").text().get();
  view->author = topic.child("CreationAuthor").text().get();
  view->date = topic.child("CreationDate").text().get();
  view->comment = comments_of(markup, guid, index == 0);
  if (index == 0 && view->comment.empty()) view->comment = topic.child("Description").text().get();
  // A view stands for its topic; further ones of the same topic have only the viewpoint's GUID.
  view->guid = core::lower_case(index == 0 ? topic.attribute("Guid").value() : guid.c_str());
  if (index > 0) view->name += " (" + std::to_string(index + 1) + ")";
  if (const std::string* image = entry(snapshot); image && image->starts_with(kPng))
    view->snapshot.assign(image->begin(), image->end());
  views_.emplace_back(number_of(topic.child("Index")).value_or(HUGE_VAL), std::move(*view));
  return true;
}

core::Expected<void> Reader::topic(const std::string& markup_path, const std::string& markup_bytes) {
  folder_ = markup_path.substr(0, markup_path.rfind('/') + 1);
  pugi::xml_document document;
  if (auto parsed = parse(document, markup_path, markup_bytes); !parsed) return parsed;
  const Node markup = document.child("Markup");
  std::vector<Node> nodes = viewpoints_of(markup);
  if (nodes.empty()) {  // BCF 1.0 names neither
    const Node& node = nodes.emplace_back(document.append_child("Viewpoints"));
    add_text(node, "Viewpoint", "viewpoint.bcfv");
    add_text(node, "Snapshot", "snapshot.png");
  }
  std::size_t index = 0;
  for (const Node& node : nodes) {
    const auto shown = viewpoint(markup, node.attribute("Guid").value(), node.child("Viewpoint").text().get(),
                                 node.child("Snapshot").text().get(), index);
    if (!shown) return tl::unexpected(shown.error());
    *shown ? ++index : ++left_out_;
  }
  return {};
}

}  // namespace

core::Expected<std::string> format_bcf(std::span<const Viewpoint> views) {
  ZipEntries entries{{"bcf.version", version_text()}};
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::string guid = is_guid(views[i].guid) ? views[i].guid : derived_guid(views[i].guid, std::to_string(i));
    if (entries.contains(guid + "/markup.bcf")) guid = derived_guid(guid, std::to_string(i));
    entries[guid + "/markup.bcf"] = markup_text(views[i], guid, i);
    entries[guid + "/viewpoint.bcfv"] = viewpoint_text(views[i], derived_guid(guid, "viewpoint"));
    if (!views[i].snapshot.empty())
      entries[guid + "/snapshot.png"].assign(views[i].snapshot.begin(), views[i].snapshot.end());
  }
  return zip(entries);
}

core::Expected<ViewFile> parse_bcf(std::string_view bytes, const std::string& source) {
  const auto entries = unzip(bytes, kMostArchiveBytes);
  if (!entries) return core::fail(source + ": " + entries.error().message);
  Reader reader(*entries, source);
  bool any = entries->contains("bcf.version");
  for (const auto& entry : *entries)
    if (core::lower_case(entry.first) == "markup.bcf" || core::lower_case(entry.first).ends_with("/markup.bcf")) {
      any = true;
      if (auto done = reader.topic(entry.first, entry.second); !done) return tl::unexpected(done.error());
    }
  if (!any) return core::fail(source + ": expected bcf.version or topics with markup.bcf, found neither");
  return std::move(reader).take();
}

}  // namespace sightline::apps
