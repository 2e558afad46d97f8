#include "sightline/importers/cad/internal/tessellated_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <BRep_Builder.hxx>
#include <StepGeom_Axis2Placement3d.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TransferBRep.hxx>
#include <TransferBRep_ShapeBinder.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <fmt/format.h>

#include "sightline/core/internal/sort_unique.h"
#include "sightline/importers/cad/internal/occt_maths.h"
#include "sightline/importers/cad/internal/step_placements.h"
#include "sightline/importers/cad/internal/step_text.h"
#include "sightline/importers/internal/text_encoding.h"

namespace sightline::importers {
namespace {

using core::dvec3;

constexpr int kDeepest = 50;  // items in items

/// A kind of entity that has triangles.
struct FaceKind {
  std::string_view keyword, parent;  // `parent`: the type that has its points
  bool complex;                      // strips and fans, not triangles
};
constexpr FaceKind kFaceKinds[] = {
    {"TRIANGULATED_FACE", "TESSELLATED_FACE", false},
    {"COMPLEX_TRIANGULATED_FACE", "TESSELLATED_FACE", true},
    {"TRIANGULATED_SURFACE_SET", "TESSELLATED_SURFACE_SET", false},
    {"COMPLEX_TRIANGULATED_SURFACE_SET", "TESSELLATED_SURFACE_SET", true},
};
constexpr std::string_view kGroupKinds[] = {"TESSELLATED_SOLID", "TESSELLATED_SHELL", "TESSELLATED_GEOMETRIC_SET",
                                            "REPOSITIONED_TESSELLATED_GEOMETRIC_SET"};
/// Kinds of items of the border of a solid or shell, whose faces are enough.
constexpr std::string_view kBorderKinds[] = {"TESSELLATED_EDGE", "TESSELLATED_CONNECTING_EDGE",
                                             "CUBIC_BEZIER_TESSELLATED_EDGE", "TESSELLATED_VERTEX", "TESSELLATED_WIRE"};

/// The attributes of an entity: the parameters of a simple one, and those of its types in a complex one.
std::vector<std::string_view> attributes(const std::vector<StepRecord>& records,
                                         std::initializer_list<std::string_view> types) {
  if (records.size() == 1) return records[0].parameters;
  std::vector<std::string_view> all;
  for (const std::string_view type : types)
    if (const StepRecord* record = find_record(records, type))
      all.insert(all.end(), record->parameters.begin(), record->parameters.end());
  return all;
}

using Triangles = std::vector<std::array<std::uint64_t, 3>>;  // of numbers from 1

std::vector<std::uint64_t> indices_of(std::string_view list) {
  std::vector<std::uint64_t> indices;
  for (const double value : step_numbers(list))
    indices.push_back(value >= 1.0 && value <= 4e9 ? std::uint64_t(value) : 0);
  return indices;
}

Triangles plain_triangles(std::string_view list) {
  const std::vector<std::uint64_t> indices = indices_of(list);
  Triangles made;
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) made.push_back({indices[i], indices[i + 1], indices[i + 2]});
  return made;
}

void add_strips(std::string_view strips, Triangles& to) {
  for (const std::string_view strip : step_list(strips)) {
    const std::vector<std::uint64_t> at = indices_of(strip);
    for (std::size_t i = 0; i + 2 < at.size(); ++i) to.push_back({at[i], at[i + 1 + i % 2], at[i + 2 - i % 2]});
  }
}

void add_fans(std::string_view fans, Triangles& to) {
  for (const std::string_view fan : step_list(fans)) {
    const std::vector<std::uint64_t> at = indices_of(fan);
    for (std::size_t i = 1; i + 1 < at.size(); ++i) to.push_back({at[0], at[i], at[i + 1]});
  }
}

/// The points and normals that a face states. Its own points have numbers from 1.
struct FacePoints {
  const std::vector<double>& coordinates;
  std::vector<std::uint64_t> of_own;  // pnindex: points of the list by the face's own; empty: the same
  std::vector<double> normals;        // none, one, or one for each point of its own

  std::optional<dvec3> point(std::uint64_t own) const {
    if (!of_own.empty()) own = own >= 1 && own <= of_own.size() ? of_own[own - 1] : 0;
    if (own < 1 || own > coordinates.size() / 3) return std::nullopt;
    const dvec3 at(coordinates[3 * own - 3], coordinates[3 * own - 2], coordinates[3 * own - 1]);
    return core::is_finite(at) ? std::optional(at) : std::nullopt;
  }
  dvec3 normal(std::uint64_t own) const {
    const std::size_t at = normals.size() <= 3 ? 0 : std::size_t(3 * own - 3);
    const dvec3 n = at + 2 < normals.size() ? dvec3(normals[at], normals[at + 1], normals[at + 2]) : dvec3(0.0);
    const double length = glm::length(n);
    return length > 0.0 && std::isfinite(length) ? n / length : dvec3(0.0);
  }
};

/// The points that triangles use, with their normals. Null without triangles; `missing` counts those without a point.
Handle(Poly_Triangulation) triangulation(const FacePoints& points, const Triangles& triangles, std::size_t& missing) {
  Triangles sound;
  std::vector<std::uint64_t> used;
  for (const auto& [a, b, c] : triangles) {
    if (a == b || b == c || c == a) continue;  // strips turn by them
    if (!points.point(a) || !points.point(b) || !points.point(c)) {
      ++missing;
      continue;
    }
    sound.push_back({a, b, c});
    used.insert(used.end(), {a, b, c});
  }
  if (sound.empty()) return {};
  core::sort_unique(used);
  const bool has_normals =
      std::all_of(used.begin(), used.end(), [&](std::uint64_t own) { return points.normal(own) != dvec3(0.0); });
  const Handle(Poly_Triangulation) made =
      new Poly_Triangulation(int(used.size()), int(sound.size()), Standard_False, has_normals);
  for (std::size_t i = 0; i < used.size(); ++i) {
    const dvec3 p = *points.point(used[i]), n = points.normal(used[i]);
    made->SetNode(int(i) + 1, gp_Pnt(p.x, p.y, p.z));
    if (has_normals) made->SetNormal(int(i) + 1, gp_Dir(n.x, n.y, n.z));
  }
  const auto node = [&](std::uint64_t own) {
    return int(std::lower_bound(used.begin(), used.end(), own) - used.begin()) + 1;
  };
  for (std::size_t i = 0; i < sound.size(); ++i)
    made->SetTriangle(int(i) + 1, Poly_Triangle(node(sound[i][0]), node(sound[i][1]), node(sound[i][2])));
  return made;
}

/// The name, items and context of a representation of shapes, or none.
std::vector<std::string_view> shape_representation(const std::vector<StepRecord>& records) {
  const bool of_shape = std::any_of(records.begin(), records.end(), [](const StepRecord& record) {
    return record.keyword.find("SHAPE_REPRESENTATION") != std::string_view::npos &&
           record.keyword.find("RELATION") == std::string_view::npos;
  });
  std::vector<std::string_view> found = of_shape ? attributes(records, {"REPRESENTATION"}) : decltype(found)();
  if (found.size() < 3 || !found[1].starts_with('(')) return {};
  found.resize(3);
  return found;
}

/// Parts of a text with what takes their places.
class Replacements {
 public:
  void add(std::string_view part, std::string by) { all_.emplace_back(part, std::move(by)); }

  std::string apply(std::string_view text) {
    std::sort(all_.begin(), all_.end(), [](const auto& a, const auto& b) { return a.first.data() < b.first.data(); });
    std::string made;
    made.reserve(text.size());
    const char* at = text.data();
    for (const auto& [part, by] : all_) {
      made.append(at, part.data()).append(by);
      at = part.data() + part.size();
    }
    return made.append(at, text.data() + text.size());
  }

 private:
  std::vector<std::pair<std::string_view, std::string>> all_;
};

}  // namespace

/// Reads the items of a text.
class TessellatedStep::Reading {
 public:
  Reading(ImportJob& job, const StepText& text, TessellatedStep& to) : job_(job), text_(text), to_(to) {}

  void run(std::string& whole) {
    for (const StepText::Entity& entity : text_.entities()) {
      if (entity.text.find("SHAPE_REPRESENTATION") == std::string_view::npos) continue;
      const std::vector<StepRecord> records = step_records(entity.text);
      const auto representation = shape_representation(records);
      if (representation.empty()) continue;
      const std::size_t before = to_.tops_.size();
      for (const std::string_view item : step_list(representation[1]))
        if (const auto id = step_reference(item); id && read(*id, 0)) to_.tops_.push_back(*id);
      const bool unknown = std::any_of(records.begin(), records.end(), [](const StepRecord& record) {
        return record.keyword.starts_with("TESSELLATED_SHAPE_REPRESENTATION");
      });
      if (unknown || to_.tops_.size() > before)
        replacements_.add(entity.text, fmt::format("SHAPE_REPRESENTATION({},{},{})", representation[0],
                                                   representation[1], representation[2]));
    }
    for (const auto& [keyword, ids] : unread_)
      job_.warn(0, fmt::format("{} not read: {} items, first #{}", keyword, ids.size(), ids[0]));
    whole = replacements_.apply(whole);
  }

 private:
  /// Whether an entity is a tessellated item that has been read now, with all below it. An item in several others
  /// belongs to the first.
  bool read(std::uint64_t id, int depth) {
    if (depth > kDeepest || !seen_.insert(id).second) return false;
    const std::vector<StepRecord> records = text_.records(id);
    Item item;
    if (const StepRecord* place = find_record(records, "REPOSITIONED_TESSELLATED_ITEM"))
      if (!place->parameters.empty()) item.place = step_reference(place->parameters.back());
    for (const FaceKind& kind : kFaceKinds)
      if (find_record(records, kind.keyword)) {
        carry_along(id, records);
        read_face(id, records, kind, to_.items_[id] = std::move(item));
        return true;
      }
    for (const std::string_view kind : kGroupKinds)
      if (find_record(records, kind)) {
        carry_along(id, records);
        read_group(id, records, kind, to_.items_[id] = std::move(item), depth);
        return true;
      }
    note_unread(id, records);
    return false;
  }

  /// Puts a point in an item's place, since Open CASCADE leaves out representations without any geometry.
  void carry_along(std::uint64_t id, const std::vector<StepRecord>& records) {
    const auto values = attributes(records, {"REPRESENTATION_ITEM"});
    const std::uint64_t point = text_.entities().back().id + 1;
    std::string item = fmt::format("GEOMETRIC_SET({},(#{}))", values.empty() ? "''" : values[0], point);
    if (!has_point_) item += fmt::format(";\n#{}=CARTESIAN_POINT('',(0.,0.,0.))", point);
    has_point_ = true;
    replacements_.add(text_.find(id)->text, std::move(item));
  }

  void read_face(std::uint64_t id, const std::vector<StepRecord>& records, const FaceKind& kind, Item& item) {
    auto values = attributes(records, {"REPRESENTATION_ITEM", kind.parent, kind.keyword});
    const bool linked = kind.parent == "TESSELLATED_FACE";
    const std::size_t count = 6u + linked + kind.complex;
    if (values.size() < count) {
      warn(id, kind.keyword, fmt::format("has {} attributes of {}", values.size(), count));
      return;
    }
    if (linked) item.link = step_reference(values[4]);
    if (linked) values.erase(values.begin() + 4);
    const FacePoints points{coordinates(values[1]), indices_of(values[4]), step_numbers(values[3])};
    Triangles triangles;
    if (kind.complex) {
      add_strips(values[5], triangles);
      add_fans(values[6], triangles);
    } else {
      triangles = plain_triangles(values[5]);
    }
    std::size_t missing = 0;
    item.face = triangulation(points, triangles, missing);
    if (missing > 0) warn(id, kind.keyword, fmt::format("has {} triangles without points", missing));
  }

  void read_group(std::uint64_t id, const std::vector<StepRecord>& records, std::string_view kind, Item& item,
                  int depth) {
    const auto values = attributes(records, {"REPRESENTATION_ITEM", kind});
    if (values.size() < 2) return warn(id, kind, "has no items");
    if (values.size() > 2) (kind.starts_with("REPOSITIONED") ? item.place : item.link) = step_reference(values[2]);
    for (const std::string_view child : step_list(values[1]))
      if (const auto at = step_reference(child); at && read(*at, depth + 1)) item.children.push_back(*at);
  }

  const std::vector<double>& coordinates(std::string_view list) {
    const auto id = step_reference(list);
    const auto [known, fresh] = lists_.try_emplace(id.value_or(0));
    if (!fresh || !id) return known->second;
    const std::vector<StepRecord> records = text_.records(*id);
    const StepRecord* record = find_record(records, "COORDINATES_LIST");
    if (record && !record->parameters.empty()) known->second = step_numbers(record->parameters.back());
    return known->second;
  }

  /// Borders of solids and shells need no word.
  void note_unread(std::uint64_t id, const std::vector<StepRecord>& records) {
    for (const StepRecord& record : records) {
      const std::string_view keyword = record.keyword;
      const bool tessellated =
          keyword.find("TESSELLATED_") != keyword.npos || keyword.find("TRIANGULATED_") != keyword.npos;
      if (!tessellated || keyword == "TESSELLATED_ITEM" || keyword == "TESSELLATED_STRUCTURED_ITEM") continue;
      const bool border =
          std::find(std::begin(kBorderKinds), std::end(kBorderKinds), keyword) != std::end(kBorderKinds);
      if (!border) unread_[keyword].push_back(id);
      return carry_along(id, records);
    }
  }

  void warn(std::uint64_t id, std::string_view keyword, const std::string& what) {
    job_.warn(0, fmt::format("{} #{} {}", keyword, id, what));
  }

  ImportJob& job_;
  const StepText& text_;
  TessellatedStep& to_;
  Replacements replacements_;
  bool has_point_ = false;  // the one that stands for all items
  std::map<std::uint64_t, std::vector<double>> lists_;
  std::set<std::uint64_t> seen_;
  std::map<std::string_view, std::vector<std::uint64_t>> unread_;  // by keyword
};

TessellatedStep::TessellatedStep(ImportJob& job, std::string& text) {
  if (text.find("TESSELLATED_") == text.npos && text.find("TRIANGULATED_") == text.npos) return;
  const StepText entities(text);
  Reading(job, entities, *this).run(text);
}

void TessellatedStep::bind(STEPCAFControl_Reader& reader) {
  if (tops_.empty()) return;
  const Handle(XSControl_WorkSession) session = reader.Reader().WS();
  session->TransferReader()->BeginTransfer();
  entities_ = step_entities(reader);
  for (const std::uint64_t top : tops_)
    if (const auto found = entities_.find(top); found != entities_.end())
      bind(top, millimetres_per_unit(representation_of(found->second, session->Graph())),
           session->TransferReader()->TransientProcess());
}

TopoDS_Shape TessellatedStep::bind(std::uint64_t id, double millimetres,
                                   const Handle(Transfer_TransientProcess) & process) {
  Item& item = items_.at(id);
  std::vector<TopoDS_Shape> children;
  for (const std::uint64_t child : item.children)
    if (const TopoDS_Shape shape = bind(child, millimetres, process); !shape.IsNull()) children.push_back(shape);
  const bool faces = std::all_of(children.begin(), children.end(),
                                 [](const TopoDS_Shape& shape) { return shape.ShapeType() == TopAbs_FACE; });
  BRep_Builder builder;
  if (!item.face.IsNull()) {
    for (int i = 1; i <= item.face->NbNodes(); ++i)
      item.face->SetNode(i, gp_Pnt(millimetres * item.face->Node(i).XYZ()));
    TopoDS_Face face;
    builder.MakeFace(face, item.face);
    item.shape = face;
  } else if (!children.empty()) {
    TopoDS_Shell shell;
    TopoDS_Compound compound;
    if (faces)
      builder.MakeShell(shell);
    else
      builder.MakeCompound(compound);
    item.shape = faces ? TopoDS_Shape(shell) : TopoDS_Shape(compound);
    for (const TopoDS_Shape& child : children) builder.Add(item.shape, child);
  }
  const auto entity = entities_.find(id);
  if (item.shape.IsNull() || entity == entities_.end()) return item.shape;
  if (item.place) item.shape.Move(location_of(*item.place, millimetres));
  process->Bind(entity->second, new TransferBRep_ShapeBinder(item.shape));
  return item.shape;
}

TopLoc_Location TessellatedStep::location_of(std::uint64_t placement, double millimetres) const {
  const auto entity = entities_.find(placement);
  const auto at = entity == entities_.end() ? Handle(StepGeom_Axis2Placement3d)()
                                            : Handle(StepGeom_Axis2Placement3d)::DownCast(entity->second);
  if (at.IsNull()) return {};
  core::Affine frame = frame_of(*at);
  frame.origin *= millimetres;
  return TopLoc_Location(to_occt(frame));
}

void TessellatedStep::note(STEPCAFControl_Reader& reader, CadDocument& document) const {
  if (tops_.empty()) return;
  const Handle(Transfer_TransientProcess) process = reader.Reader().WS()->TransferReader()->TransientProcess();
  for (const auto& [id, item] : items_) {
    const auto entity = entities_.find(id);
    if (item.shape.IsNull() || entity == entities_.end()) continue;
    const auto named = Handle(StepRepr_RepresentationItem)::DownCast(entity->second);
    if (!named.IsNull() && !named->Name().IsNull())
      document.body_names[item.shape.TShape().get()] = utf8_by_guess(named->Name()->ToCString());
    if (has_exact_form(item, process)) document.doubled.insert(item.shape.TShape());
  }
}

bool TessellatedStep::has_exact_form(const Item& item, const Handle(Transfer_TransientProcess) & process) const {
  const auto exact = item.link ? entities_.find(*item.link) : entities_.end();
  if (exact != entities_.end() && !TransferBRep::ShapeResult(process, exact->second).IsNull()) return true;
  return !item.children.empty() && std::all_of(item.children.begin(), item.children.end(), [&](std::uint64_t child) {
    return has_exact_form(items_.at(child), process);
  });
}

}  // namespace sightline::importers
