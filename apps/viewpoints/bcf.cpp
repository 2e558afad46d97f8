#include "sightline/apps/viewpoints/bcf.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include <pugixml.hpp>

#include "sightline/apps/common/model.h"
#include "sightline/apps/viewpoints/bcf_lines.h"
#include "sightline/apps/viewpoints/bcf_topics.h"
#include "sightline/core/internal/ascii_case.h"

namespace sightline::apps {
namespace {

constexpr std::uint64_t kMostArchiveBytes = std::uint64_t(256) << 20;  // of all files of an archive
constexpr std::string_view kPng("\x89PNG\r\n\x1a\n", 8);
// --- reading ---------------------------------------------------------------------------------------------------------

std::optional<core::dvec3> direction_of(const Node& node) {
  const auto v = xyz_of(node);
  const double length = v ? glm::length(*v) : 0.0;
  return length > 1e-100 && std::isfinite(length) ? std::optional(*v / length) : std::nullopt;
}

/// None where no camera can be made of it.
std::optional<Viewpoint> camera_of(const Node& root) {
  Viewpoint view;
  const Node parallel = root.child("OrthogonalCamera");
  view.orthographic = bool(parallel);
  const Node camera = parallel ? parallel : root.child("PerspectiveCamera");
  const auto eye = xyz_of(camera.child("CameraViewPoint"));
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
    const auto location = xyz_of(node.child("Location")), direction = direction_of(node.child("Direction"));
    if (!location || !direction || planes.size() == core::kMaxSectionPlanes) continue;
    planes.push_back({-*direction, glm::dot(*direction, *location)});
  }
  return planes;
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

class Reader {
 public:
  Reader(ZipEntries entries, const std::string& source)
      : archive_(std::make_shared<BcfArchive>(std::move(entries))), entries_(archive_->entries), source_(source) {}

  core::Expected<void> topic(const std::string& markup_path, const std::string& markup_bytes);
  /// The views, by the index of their topics.
  ViewFile take() &&;
  const ZipEntries& entries() const { return entries_; }

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

  std::shared_ptr<BcfArchive> archive_;
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
  take_lines(root, entry(marks_file(name)), *view);
  view->shown = shown_of(root);
  view->name = topic.child("Title").text().get();
  view->author = topic.child("CreationAuthor").text().get();
  view->date = topic.child("CreationDate").text().get();
  for (const Node& comment : comment_nodes(markup, guid, index == 0))
    view->comment += (view->comment.empty() ? "" : "\n") + std::string(comment.child("Comment").text().get());
  view->status = topic.attribute("TopicStatus").value();
  view->type = topic.attribute("TopicType").value();
  if (index == 0 && view->comment.empty()) view->comment = topic.child("Description").text().get();
  // A view stands for its topic; further ones of the same topic have only the viewpoint's GUID.
  view->guid = core::lower_case(index == 0 ? topic.attribute("Guid").value() : guid.c_str());
  if (index > 0) view->name += " (" + std::to_string(index + 1) + ")";
  if (const std::string* image = entry(snapshot); image && image->starts_with(kPng))
    view->snapshot.assign(image->begin(), image->end());
  archive_->shown.emplace(folder_, name);
  view->origin = std::make_shared<BcfOrigin>(BcfOrigin{archive_, folder_, guid, name, snapshot, index == 0, *view});
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
    Node node = nodes.emplace_back(document.append_child("Viewpoints"));
    node.append_child("Viewpoint").text().set("viewpoint.bcfv");
    node.append_child("Snapshot").text().set("snapshot.png");
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

core::Expected<ViewFile> parse_bcf(std::string_view bytes, const std::string& source) {
  auto entries = unzip(bytes, kMostArchiveBytes);
  if (!entries) return core::fail(source + ": " + entries.error().message);
  bool any = entries->contains("bcf.version");
  Reader reader(std::move(*entries), source);
  for (const auto& entry : reader.entries())
    if (core::lower_case(entry.first) == "markup.bcf" || core::lower_case(entry.first).ends_with("/markup.bcf")) {
      any = true;
      if (auto done = reader.topic(entry.first, entry.second); !done) return tl::unexpected(done.error());
    }
  if (!any) return core::fail(source + ": expected bcf.version or topics with markup.bcf, found neither");
  return std::move(reader).take();
}

}  // namespace sightline::apps
