#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <sstream>
#include <tuple>
#include <vector>

#include "sightline/apps/viewpoints/bcf.h"
#include "sightline/apps/viewpoints/bcf_lines.h"
#include "sightline/apps/viewpoints/bcf_topics.h"
#include "sightline/core/internal/ascii_case.h"
#include "sightline/core/internal/hash.h"

namespace sightline::apps {
namespace {

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

void put_view(Node root, const Viewpoint& view) {
  if (view.shown) add_shown(root, *view.shown);
  add_camera(root, view);
  add_lines(root, view);
  add_planes(root, view.sections);
}

std::string viewpoint_text(const Viewpoint& view, const std::string& guid) {
  pugi::xml_document document;
  Node root = document.append_child("VisualizationInfo");
  root.append_attribute("Guid") = guid.c_str();
  put_view(root, view);
  return text_of(document);
}

void set_attribute(Node node, const char* name, const std::string& value) {
  pugi::xml_attribute attribute = node.attribute(name);
  if (value.empty()) return void(node.remove_attribute(attribute));
  if (!attribute) attribute = node.append_attribute(name);
  attribute = printable(value).c_str();
}

void add_comment(Node parent, const std::string& guid, const std::string& author, const std::string& date,
                 const std::string& words, const std::string& viewpoint) {
  const Node viewpoints = parent.child("Viewpoints");  // which come behind
  Node comment = viewpoints ? parent.insert_child_before("Comment", viewpoints) : parent.append_child("Comment");
  comment.append_attribute("Guid") = guid.c_str();
  add_text(comment, "Date", date);
  add_text(comment, "Author", author);
  add_text(comment, "Comment", words);
  comment.append_child("Viewpoint").append_attribute("Guid") = viewpoint.c_str();
}

std::string markup_text(const Viewpoint& view, const std::string& guid, std::size_t index) {
  const std::string date = view.date.empty() ? kNoDate : view.date,
                    author = view.author.empty() ? "unknown" : view.author;
  const std::string viewpoint_guid = derived_guid(guid, "viewpoint");
  pugi::xml_document document;
  Node root = document.append_child("Markup"), topic = root.append_child("Topic");
  topic.append_attribute("Guid") = guid.c_str();
  set_attribute(topic, "TopicType", view.type);
  set_attribute(topic, "TopicStatus", view.status);
  add_text(topic, "Title", view.name);
  add_text(topic, "Index", std::to_string(index));
  add_text(topic, "CreationDate", date);
  add_text(topic, "CreationAuthor", author);
  if (!view.comment.empty())
    add_comment(root, derived_guid(guid, "comment"), author, date, view.comment, viewpoint_guid);
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

// --- writing again what was read
// --------------------------------------------------------------------------------------

/// The text of a child, which is made where there is none, behind another one: elements of BCF have an order.
void set_text(Node parent, const char* name, const std::string& text, const char* behind = "") {
  Node node = parent.child(name);
  const Node before = parent.child(behind);
  if (!node) node = before ? parent.insert_child_after(name, before) : parent.append_child(name);
  node.text().set(printable(text).c_str());
}

/// BCF 3.0 has lists within elements of their own, where 2.1 repeats elements; viewpoints and comments lie outside of
/// the topic there.
void make_2_1(Node markup) {
  Node topic = markup.child("Topic");
  for (const auto& [list, element] :
       {std::pair("Labels", "Label"), std::pair("ReferenceLinks", "ReferenceLink"),
        std::pair("RelatedTopics", "RelatedTopic"), std::pair("DocumentReferences", "DocumentReference")}) {
    Node nodes = topic.child(list);
    if (!nodes || !nodes.child(element)) continue;
    for (const Node& node : nodes.children(element))
      topic.insert_copy_before(node, nodes).set_name(std::string(list) == "Labels" ? list : element);
    topic.remove_child(nodes);
  }
  for (const auto& [list, element, name] :
       {std::tuple("Comments", "Comment", "Comment"), std::tuple("Viewpoints", "ViewPoint", "Viewpoints")}) {
    Node nodes = topic.child(list);
    for (const Node& node : nodes.children(element)) markup.append_copy(node).set_name(name);
    topic.remove_child(nodes);
  }
}

/// Puts topics of archives that were read together with what was changed and what is new.
class Rewriter {
 public:
  /// `keep_version`: all topics are of one archive, and stay as its version has them.
  Rewriter(ZipEntries& entries, bool keep_version) : entries_(&entries), keep_version_(keep_version) {}

  core::Expected<void> add(const Viewpoint& view) {
    const BcfOrigin& origin = *view.origin;
    pugi::xml_document& document = markup_of(*origin.archive, origin.folder);
    Node markup = document.child("Markup");
    if (!markup) return core::fail("a topic that was read has no markup");
    if (origin.first) put_topic(view, markup.child("Topic"));
    put_comment(view, markup);
    put_viewpoint(view);
    if (view.snapshot != origin.view.snapshot) put_snapshot(view, markup);
    present_[{origin.archive.get(), origin.folder}].insert(origin.file);
    archives_.insert(origin.archive);
    return {};
  }

  /// Adds all else that the archives held, but for views that are no longer there.
  void finish() {
    for (const auto& archive : archives_) finish(*archive);
    for (auto& [key, document] : markups_) {
      std::ostringstream out;
      document.save(out, " ");
      (*entries_)[key.second + "markup.bcf"] = out.str();
    }
  }

 private:
  using Key = std::pair<const BcfArchive*, std::string>;

  pugi::xml_document& markup_of(const BcfArchive& archive, const std::string& folder) {
    const auto [found, fresh] = markups_.try_emplace({&archive, folder});
    if (!fresh) return found->second;
    for (const auto& [path, bytes] : archive.entries)
      if (core::lower_case(path) == core::lower_case(folder) + "markup.bcf")
        found->second.load_buffer(bytes.data(), bytes.size());
    if (!keep_version_) make_2_1(found->second.child("Markup"));
    return found->second;
  }

  static void put_topic(const Viewpoint& view, Node topic) {
    const Viewpoint& read = view.origin->view;
    bool changed = false;
    const auto differs = [&](std::string Viewpoint::*text) {
      const bool other = view.*text != read.*text;
      changed = changed || other;
      return other;
    };
    if (differs(&Viewpoint::name)) {
      if (!topic.child("Title")) topic.prepend_child("Title");
      set_text(topic, "Title", view.name);
    }
    if (differs(&Viewpoint::status)) set_attribute(topic, "TopicStatus", view.status);
    if (differs(&Viewpoint::type)) set_attribute(topic, "TopicType", view.type);
    if (!changed) return;
    set_text(topic, "ModifiedDate", date_now(), "CreationAuthor");
    set_text(topic, "ModifiedAuthor", author_name(), "ModifiedDate");
  }

  /// What was written below the comments that there were is another comment; other edits are of the first one.
  static void put_comment(const Viewpoint& view, Node markup) {
    const BcfOrigin& origin = *view.origin;
    const std::string &read = origin.view.comment, &now = view.comment;
    if (now == read) return;
    std::vector<Node> nodes = comment_nodes(markup, origin.guid, origin.first);
    Node comments = markup.child("Topic").child("Comments");
    if (nodes.empty() || now.starts_with(read + "\n")) {
      const std::string words = nodes.empty() ? now : now.substr(read.size() + 1);
      return add_comment(comments ? comments : markup, derived_guid(origin.guid, now), author_name(), date_now(), words,
                         origin.guid);
    }
    for (std::size_t i = 1; i < nodes.size(); ++i) nodes[i].parent().remove_child(nodes[i]);
    if (now.empty()) return void(nodes[0].parent().remove_child(nodes[0]));
    set_text(nodes[0], "Comment", now);
    set_text(nodes[0], "ModifiedDate", date_now());
    set_text(nodes[0], "ModifiedAuthor", author_name());
  }

  /// What the view does not hold, such as bitmaps, stays.
  void put_viewpoint(const Viewpoint& view) {
    const BcfOrigin& origin = *view.origin;
    const auto raw = origin.archive->entries.find(origin.folder + origin.file);
    if (raw == origin.archive->entries.end()) return;
    std::string& out = (*entries_)[raw->first] = raw->second;
    if (format_viewpoint(seen(view)) == format_viewpoint(seen(origin.view))) return;
    pugi::xml_document document;
    document.load_buffer(raw->second.data(), raw->second.size());
    Node root = document.child("VisualizationInfo");
    pugi::xml_document before;
    const Node components = before.append_copy(root.child("Components"));
    for (const char* name : {"Components", "PerspectiveCamera", "OrthogonalCamera", "Lines", "ClippingPlanes"})
      while (root.remove_child(name)) {
      }
    put_view(root, view);
    keep_components(components, root.child("Components"));
    const auto bitmaps = root.children("Bitmap");  // they come last
    for (const Node& bitmap : std::vector<Node>(bitmaps.begin(), bitmaps.end())) root.append_move(bitmap);
    std::ostringstream text;
    document.save(text, " ");
    out = text.str();
    put_marks(view);
  }

  void put_marks(const Viewpoint& view) {
    const std::string path = view.origin->folder + marks_file(view.origin->file), text = marks_text(view);
    if (text.empty())
      outdated_.insert(path);
    else
      (*entries_)[path] = text;
  }

  /// Hints and colours of components, but for those of faint ones, which the view has.
  static void keep_components(const Node& before, Node now) {
    if (!now) return;
    if (const Node hints = before.child("ViewSetupHints")) now.prepend_copy(hints);
    for (const Node& colour : before.child("Coloring").children("Color")) {
      if (is_faint(colour)) continue;
      Node list = now.child("Coloring");
      if (!list) list = now.append_child("Coloring");
      list.append_copy(colour);
    }
  }

  /// The view alone, without words about it.
  static Viewpoint seen(Viewpoint view) {
    for (const auto text : {&Viewpoint::name, &Viewpoint::comment, &Viewpoint::author, &Viewpoint::guid,
                            &Viewpoint::date, &Viewpoint::status, &Viewpoint::type})
      (view.*text).clear();
    view.colour_by.reset();
    return view;
  }

  void put_snapshot(const Viewpoint& view, Node markup) {
    const BcfOrigin& origin = *view.origin;
    std::string name = origin.snapshot;
    if (name.empty()) {
      name = derived_guid(origin.guid, "snapshot") + ".png";
      for (Node node : viewpoints_of(markup))
        if (node.child("Viewpoint").text().get() == origin.file) set_text(node, "Snapshot", name);
    }
    (*entries_)[origin.folder + name].assign(view.snapshot.begin(), view.snapshot.end());
  }

  void finish(const BcfArchive& archive) {
    std::set<std::string> topics, dropped;
    for (const auto& [path, bytes] : archive.entries)
      if (core::lower_case(path).ends_with("/markup.bcf")) topics.insert(path.substr(0, path.rfind('/') + 1));
    for (const std::string& folder : topics) {
      bool was_shown = false;
      const auto present = present_.find({&archive, folder});
      for (const auto& [of, file] : archive.shown)
        if (of == folder) {
          was_shown = true;
          if (present != present_.end() && !present->second.contains(file)) take_view(archive, folder, file, dropped);
        }
      if (was_shown && present == present_.end())
        dropped.insert(folder);
      else
        markup_of(archive, folder);
    }
    for (const auto& [path, bytes] : archive.entries) {
      const bool gone = std::any_of(dropped.begin(), dropped.end(), [&](const std::string& what) {
        return what.ends_with('/') ? path.starts_with(what) : path == what;
      });
      const bool version = path == "bcf.version" && !keep_version_;
      if (!gone && !version && !outdated_.contains(path)) entries_->try_emplace(path, bytes);
    }
  }

  /// A view that is no longer in the list, of a topic that is.
  void take_view(const BcfArchive& archive, const std::string& folder, const std::string& file,
                 std::set<std::string>& dropped) {
    dropped.insert(folder + file);
    dropped.insert(folder + marks_file(file));
    for (Node node : viewpoints_of(markup_of(archive, folder).child("Markup")))
      if (node.child("Viewpoint").text().get() == file) {
        dropped.insert(folder + node.child("Snapshot").text().get());
        node.parent().remove_child(node);
      }
  }

  ZipEntries* entries_;
  bool keep_version_;
  std::map<Key, pugi::xml_document> markups_;
  std::map<Key, std::set<std::string>> present_;
  std::set<std::string> outdated_;  // files of marks that views no longer have
  std::set<std::shared_ptr<const BcfArchive>> archives_;
};

}  // namespace

core::Expected<std::string> format_bcf(std::span<const Viewpoint> views) {
  std::set<const BcfArchive*> archives;
  for (const Viewpoint& view : views) archives.insert(view.origin ? view.origin->archive.get() : nullptr);
  const bool keep_version = archives.size() == 1 && !archives.contains(nullptr);
  ZipEntries entries;
  if (!keep_version) entries["bcf.version"] = version_text();
  Rewriter rewriter(entries, keep_version);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].origin) {
      if (auto done = rewriter.add(views[i]); !done) return tl::unexpected(done.error());
      continue;
    }
    std::string guid = is_guid(views[i].guid) ? views[i].guid : derived_guid(views[i].guid, std::to_string(i));
    if (entries.contains(guid + "/markup.bcf")) guid = derived_guid(guid, std::to_string(i));
    entries[guid + "/markup.bcf"] = markup_text(views[i], guid, i);
    entries[guid + "/viewpoint.bcfv"] = viewpoint_text(views[i], derived_guid(guid, "viewpoint"));
    if (const std::string marks = marks_text(views[i]); !marks.empty())
      entries[guid + "/" + marks_file("viewpoint.bcfv")] = marks;
    if (!views[i].snapshot.empty())
      entries[guid + "/snapshot.png"].assign(views[i].snapshot.begin(), views[i].snapshot.end());
  }
  rewriter.finish();
  return zip(entries);
}

}  // namespace sightline::apps
