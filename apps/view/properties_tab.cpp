#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

/// In the order of core::parameters().
std::span<const char* const> parameter_names(core::Kind kind) {
  static constexpr const char* kPyramid[] = {"bottom x", "bottom y", "top x", "top y",
                                             "offset x", "offset y", "height"};
  static constexpr const char* kBox[] = {"size x", "size y", "size z"};
  static constexpr const char* kRectangularTorus[] = {"inner radius", "outer radius", "height", "angle"};
  static constexpr const char* kCircularTorus[] = {"bend radius", "tube radius", "angle"};
  static constexpr const char* kDish[] = {"base radius", "height"};
  static constexpr const char* kSnout[] = {"bottom radius",  "top radius",     "height",      "offset x",   "offset y",
                                           "bottom shear x", "bottom shear y", "top shear x", "top shear y"};
  static constexpr const char* kCylinder[] = {"radius", "height"};
  static constexpr const char* kSphere[] = {"diameter"};
  static constexpr const char* kLine[] = {"from", "to"};
  switch (kind) {
    case core::Kind::kPyramid:
      return kPyramid;
    case core::Kind::kBox:
      return kBox;
    case core::Kind::kRectangularTorus:
      return kRectangularTorus;
    case core::Kind::kCircularTorus:
      return kCircularTorus;
    case core::Kind::kEllipticalDish:
    case core::Kind::kSphericalDish:
      return kDish;
    case core::Kind::kSnout:
      return kSnout;
    case core::Kind::kCylinder:
      return kCylinder;
    case core::Kind::kSphere:
      return kSphere;
    case core::Kind::kLine:
      return kLine;
    case core::Kind::kFacetGroup:
    case core::Kind::kMesh:
      break;
  }
  return {};
}

bool is_angle(std::string_view name) {
  return name.find("angle") != std::string_view::npos || name.find("shear") != std::string_view::npos;
}

/// How much larger a placement makes all lengths; none where it scales some more than others.
std::optional<double> scale_of(const core::Affine& world_from_item) {
  const core::dmat3& m = world_from_item.linear;
  const double x = glm::length(m[0]), least = std::min({x, glm::length(m[1]), glm::length(m[2])}),
               most = std::max({x, glm::length(m[1]), glm::length(m[2])});
  return most - least <= 1e-5 * most ? std::optional(x) : std::nullopt;
}

/// A parameter in the world, or, where an item is stretched, in its own units.
std::string quantity(std::string_view name, double value, const std::optional<double>& scale) {
  char text[60];
  if (is_angle(name))
    std::snprintf(text, sizeof text, "%.6g°", glm::degrees(value));
  else if (scale)
    std::snprintf(text, sizeof text, "%.6g m", value * *scale);
  else
    std::snprintf(text, sizeof text, "%.6g units, stretched", value);
  return text;
}

void shape_rows(const core::Scene& scene, core::ItemId item) {
  const core::Kind kind = scene.kind(item);
  row("kind", std::string(core::name_of(kind)));
  if (int(kind) >= core::kPrimitiveKindCount) {
    row("triangles", grouped(std::int64_t(scene.mesh(scene.mesh_of(item)).indices.size() / 3)));
    return;
  }
  const core::Primitive primitive = scene.primitive(item);
  const auto values = core::parameters(primitive);
  const auto names = parameter_names(kind);
  const std::optional<double> scale = scale_of(scene.state(item).world_from_item);
  for (std::size_t i = 0; i < values.size(); ++i) row(names[i], quantity(names[i], double(values[i]), scale));
}

void item_properties(const core::Scene& scene, core::ItemId item) {
  if (begin_rows("item")) {
    shape_rows(scene, item);
    const core::AabbD box = scene.bounds_under(item, scene.state(item).world_from_item);
    if (!box.empty()) {
      row("from", vector_text(box.min));
      row("to", vector_text(box.max));
    }
    if (const core::MaterialId material = scene.item_material(item); material.valid())
      row("material", scene.material(material).name);
    ImGui::EndTable();
  }
  for (core::NodeId node = scene.node_of(item); node.valid(); node = scene.parent(node)) {
    const std::string name(scene.name(node));
    if (name.empty() && scene.attributes(node).empty()) continue;
    ImGui::PushID(int(node.index));
    if (ImGui::CollapsingHeader(name.empty() ? "(no name)" : name.c_str(), ImGuiTreeNodeFlags_DefaultOpen) &&
        !scene.attributes(node).empty() && begin_rows("attributes")) {
      for (const auto& [key, value] : scene.attributes(node)) row(std::string(key).c_str(), std::string(value));
      ImGui::EndTable();
    }
    ImGui::PopID();
  }
}

void selection_properties(const core::Scene& scene, const Document& document) {
  const auto selection = document.selection();
  std::map<std::string, std::int64_t> kinds;
  for (const core::ItemId item : selection) ++kinds[std::string(core::name_of(scene.kind(item)))];
  if (!begin_rows("kinds")) return;
  for (const auto& [kind, count] : kinds) row(kind.c_str(), grouped(count));
  ImGui::EndTable();
}

}  // namespace

void properties_tab(Viewer& viewer) {
  Session& session = *viewer.session();
  const auto selection = session.document().selection();
  if (selection.empty()) {
    ImGui::TextWrapped("Nothing is selected. Click on something, or press F1 for keys and mouse.");
    return;
  }
  ImGui::Text("%s item%s selected", grouped(std::int64_t(selection.size())).c_str(), selection.size() == 1 ? "" : "s");
  for (const char* name : {"hide", "isolate", "ghost-others", "focus"}) {
    const Command& command = *find_command(name);
    if (std::string_view(name) != "hide") ImGui::SameLine();
    if (ImGui::SmallButton(command.title)) run(viewer, command);
    if (std::string_view(name) == "isolate") ImGui::NewLine();
  }
  ImGui::Separator();
  if (selection.size() == 1)
    item_properties(session.scene(), selection[0]);
  else
    selection_properties(session.scene(), session.document());
}

}  // namespace sightline::apps
