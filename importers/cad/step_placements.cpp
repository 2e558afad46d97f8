#include "sightline/importers/cad/internal/step_placements.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <Interface_EntityIterator.hxx>
#include <STEPConstruct_Assembly.hxx>
#include <StepBasic_ProductDefinitionRelationship.hxx>
#include <StepGeom_Axis2Placement3d.hxx>
#include <StepGeom_CartesianPoint.hxx>
#include <StepGeom_Direction.hxx>
#include <StepRepr_CharacterizedDefinition.hxx>
#include <StepRepr_ItemDefinedTransformation.hxx>
#include <StepRepr_MappedItem.hxx>
#include <StepRepr_ProductDefinitionShape.hxx>
#include <StepRepr_RepresentationMap.hxx>
#include <StepRepr_ShapeRepresentationRelationshipWithTransformation.hxx>
#include <StepRepr_Transformation.hxx>
#include <StepShape_ContextDependentShapeRepresentation.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <fmt/format.h>

#include "sightline/importers/cad/internal/occt_maths.h"
#include "sightline/importers/cad/internal/step_model.h"
#include "sightline/importers/cad/internal/step_text.h"

namespace sightline::importers {
namespace {

using core::Affine;
using core::dvec3;

constexpr double kParallel = 1e-9;  // sine of an angle

// --- axes as ISO 10303-42 builds them, from unit vectors -------------------------------------------------------------

/// The component of `v` across `axes`, or zero where there is none.
dvec3 across(dvec3 v, std::initializer_list<dvec3> axes) {
  for (const dvec3& axis : axes) v -= glm::dot(v, axis) * axis;
  const double length = glm::length(v);
  return length > kParallel ? v / length : dvec3(0.0);
}

dvec3 default_x(const dvec3& z) {
  return across({1.0, 0.0, 0.0}, {z}) == dvec3(0.0) ? dvec3(0.0, 1.0, 0.0) : dvec3(1.0, 0.0, 0.0);
}

/// Function first_proj_axis.
dvec3 first_proj_axis(const dvec3& z, const std::optional<dvec3>& wanted) {
  const dvec3 x = across(wanted.value_or(default_x(z)), {z});
  return x == dvec3(0.0) ? across(default_x(z), {z}) : x;
}

/// Function base_axis; left-handed where the directions are.
core::dmat3 base_axis(const std::optional<dvec3>& x, const std::optional<dvec3>& y, const std::optional<dvec3>& z) {
  const dvec3 third = z.value_or(dvec3(0.0, 0.0, 1.0)), first = first_proj_axis(third, x);
  const dvec3 second = across(y.value_or(dvec3(0.0, 1.0, 0.0)), {third, first});
  return {first, second == dvec3(0.0) ? glm::cross(third, first) : second, third};
}

// --- operators -------------------------------------------------------------------------------------------------------

/// Three coordinates, or two in a plane, of a point or a direction; nothing where there is none.
std::optional<dvec3> coordinates(const StepText& text, std::string_view parameter) {
  const auto id = step_reference(parameter);
  if (!id) return std::nullopt;
  for (const StepRecord& record : text.records(*id)) {
    if (record.keyword != "CARTESIAN_POINT" && record.keyword != "DIRECTION") continue;
    if (record.parameters.empty()) continue;
    const std::vector<double> values = step_numbers(record.parameters.back());
    if (values.size() == 2 || values.size() == 3)
      return dvec3(values[0], values[1], values.size() == 3 ? values[2] : 0.0);
  }
  return std::nullopt;
}

std::optional<dvec3> direction(const StepText& text, std::string_view parameter) {
  const auto found = coordinates(text, parameter);
  if (!found || !(glm::length(*found) > 0.0) || !core::is_finite(*found)) return std::nullopt;
  return glm::normalize(*found);
}

/// CARTESIAN_TRANSFORMATION_OPERATOR, _2D or _3D.
struct Operator {
  core::dmat3 axes{1.0};
  dvec3 origin{0.0};  // in the unit of its representation
  double scale = 1.0;
};

constexpr std::string_view kOperator = "CARTESIAN_TRANSFORMATION_OPERATOR";

std::set<std::uint64_t> all_operators(const StepText& text) {
  std::set<std::uint64_t> found;
  for (const StepText::Entity& entity : text.entities()) {
    if (entity.text.find(kOperator) == std::string_view::npos) continue;
    for (const StepRecord& record : step_records(entity.text))
      if (record.keyword.starts_with(kOperator)) found.insert(entity.id);
  }
  return found;
}

std::optional<Operator> operator_of(const StepText& text, std::uint64_t id) {
  const std::vector<StepRecord> records = text.records(id);
  // First axis, second axis, origin, scale and third axis: the last parameters of a simple entity; a complex one has
  // the third axis apart.
  std::vector<std::string_view> parameters;
  bool in_space = false;
  for (const char* suffix : {"", "_2D", "_3D"}) {
    const StepRecord* record = find_record(records, std::string(kOperator) + suffix);
    if (!record) continue;
    parameters.insert(parameters.end(), record->parameters.begin(), record->parameters.end());
    in_space = std::string_view(suffix) == "_3D";
  }
  const std::size_t count = in_space ? 5 : 4;
  if (parameters.size() < count) return std::nullopt;
  parameters.erase(parameters.begin(), parameters.end() - std::ptrdiff_t(count));
  const auto origin = coordinates(text, parameters[2]);
  const std::vector<double> scale = step_numbers(parameters[3]);
  const Operator made{base_axis(direction(text, parameters[0]), direction(text, parameters[1]),
                                in_space ? direction(text, parameters[4]) : std::nullopt),
                      origin.value_or(dvec3(0.0)), scale.empty() ? 1.0 : scale[0]};
  if (!origin || !core::is_finite(*origin) || !(made.scale > 0.0 && std::isfinite(made.scale))) return std::nullopt;
  return made;
}

// --- in Open CASCADE's model -----------------------------------------------------------------------------------------

Handle(StepGeom_Axis2Placement3d) step_placement(const Affine& at) {
  const Handle(TCollection_HAsciiString) no_name = new TCollection_HAsciiString("");
  const Handle(StepGeom_CartesianPoint) origin = new StepGeom_CartesianPoint;
  origin->Init3D(no_name, at.origin.x, at.origin.y, at.origin.z);
  const Handle(StepGeom_Axis2Placement3d) made = new StepGeom_Axis2Placement3d;
  made->Init(no_name, origin, Standard_True, step_direction(at.linear[2]), Standard_True, step_direction(at.linear[0]));
  return made;
}

std::optional<dvec3> direction_of(const Handle(StepGeom_Direction) & stated) {
  if (stated.IsNull() || stated->DirectionRatios().IsNull() || stated->NbDirectionRatios() != 3) return std::nullopt;
  const dvec3 v(stated->DirectionRatiosValue(1), stated->DirectionRatiosValue(2), stated->DirectionRatiosValue(3));
  const double length = glm::length(v);
  if (!(length > 0.0 && std::isfinite(length))) return std::nullopt;
  return v / length;
}

dvec3 third_axis(const StepGeom_Axis2Placement3d& at) {
  return (at.HasAxis() ? direction_of(at.Axis()) : std::nullopt).value_or(dvec3(0.0, 0.0, 1.0));
}

bool same(const Affine& a, const Affine& b) {
  double apart = glm::length(a.origin - b.origin);
  for (int k = 0; k < 3; ++k) apart = std::max(apart, glm::length(a.linear[k] - b.linear[k]));
  return apart < 1e-9;
}

Affine scaled(Affine at, double factor) {
  at.origin *= factor;
  return at;
}

/// ISO 10303-43 places by target * source^-1, Open CASCADE 7.6 by source^-1 * target. So it gets source * wanted.
Affine target_for(const Affine& wanted, const Affine& source) {
  return source * wanted;
}

/// An operator's axes without scale and mirror, as Open CASCADE can place by them, and what is then left to do.
/// Millimetres.
struct Divided {
  Affine target;
  Affine correction;  // after Open CASCADE's placement
};

Divided divided(const Operator& of, const Affine& source, double millimetres) {
  const dvec3 origin = millimetres * of.origin;
  Affine rigid{of.axes, origin};
  if (glm::determinant(of.axes) < 0.0) rigid.linear[1] = -rigid.linear[1];
  const Affine whole{of.scale * of.axes, origin};
  Affine wanted = rigid * inverse_of(source);
  if (same(whole, rigid)) return {target_for(wanted, source), {}};
  // A location that moves nothing has no datum which could stand for the whole.
  if (same(wanted, {})) wanted.origin.x += 1.0;
  return {target_for(wanted, source), whole * inverse_of(source) * inverse_of(wanted)};
}

using Uses = std::vector<StepOperators::Use>;

void replace_target(const Handle(StepRepr_MappedItem) & item, const Operator& by, const Interface_Graph& graph,
                    Uses& uses) {
  const Handle(StepRepr_RepresentationMap) source = item->MappingSource();
  if (source.IsNull()) return;
  auto origin = Handle(StepGeom_Axis2Placement3d)::DownCast(source->MappingOrigin());
  if (origin.IsNull()) source->SetMappingOrigin(origin = step_placement({}));
  const double unit = millimetres_per_unit(representation_of(item, graph));
  const Divided parts = divided(by, scaled(frame_of(*origin), unit), unit);
  item->SetMappingTarget(step_placement(scaled(parts.target, 1.0 / unit)));
  uses.push_back({Handle(Standard_Transient)(item), parts.correction, false});
}

/// Uses of a relation in assemblies, and itself.
void add_uses(const Handle(Standard_Transient) & relation, const Affine& correction, const Interface_Graph& graph,
              Uses& uses) {
  uses.push_back({relation, correction, false});
  Interface_EntityIterator users = graph.Sharings(relation);
  for (users.Start(); users.More(); users.Next()) {
    const auto use = Handle(StepShape_ContextDependentShapeRepresentation)::DownCast(users.Value());
    if (use.IsNull()) continue;
    const bool reversed = STEPConstruct_Assembly::CheckSRRReversesNAUO(graph, use);
    uses.push_back({Handle(Standard_Transient)(use), correction, reversed});
    if (const auto product = use->RepresentedProductRelation(); !product.IsNull())
      uses.push_back({product->Definition().ProductDefinitionRelationship(), correction, reversed});
  }
}

using Relation = StepRepr_ShapeRepresentationRelationshipWithTransformation;

/// Lets a relation place from a source to a target, which is in millimetres.
void place(Relation& relation, const Handle(StepGeom_Axis2Placement3d) & source, const Affine& target) {
  const Handle(TCollection_HAsciiString) no_name = new TCollection_HAsciiString("");
  const Handle(StepRepr_ItemDefinedTransformation) items = new StepRepr_ItemDefinedTransformation;
  const double unit = millimetres_per_unit(relation.Rep2());
  items->Init(no_name, no_name, source, step_placement(scaled(target, 1.0 / unit)));
  StepRepr_Transformation transformation;
  transformation.SetValue(items);
  relation.SetTransformationOperator(transformation);
}

/// `by` takes the place of the whole transformation, or of its second item.
void replace_transformation(const Handle(Relation) & relation, const Handle(StepRepr_ItemDefinedTransformation) & items,
                            const Operator& by, const Interface_Graph& graph, Uses& uses) {
  auto source = items.IsNull() ? Handle(StepGeom_Axis2Placement3d)()
                               : Handle(StepGeom_Axis2Placement3d)::DownCast(items->TransformItem1());
  if (source.IsNull()) source = step_placement({});
  const Divided parts = divided(by, scaled(frame_of(*source), millimetres_per_unit(relation->Rep1())),
                                millimetres_per_unit(relation->Rep2()));
  place(*relation, source, parts.target);
  add_uses(relation, parts.correction, graph, uses);
}

void replace_operator(const Handle(Standard_Transient) & user, const Operator& by, const Interface_Graph& graph,
                      Uses& uses) {
  if (const auto item = Handle(StepRepr_MappedItem)::DownCast(user); !item.IsNull())
    replace_target(item, by, graph, uses);
  if (const auto relation = Handle(Relation)::DownCast(user); !relation.IsNull())
    replace_transformation(relation, {}, by, graph, uses);
  const auto items = Handle(StepRepr_ItemDefinedTransformation)::DownCast(user);
  if (items.IsNull()) return;
  Interface_EntityIterator users = graph.Sharings(items);
  for (users.Start(); users.More(); users.Next())
    if (const auto relation = Handle(Relation)::DownCast(users.Value()); !relation.IsNull())
      replace_transformation(relation, items, by, graph, uses);
}

/// The target that Open CASCADE needs; none where the order of source and target does not matter.
std::optional<Affine> ordered(const Affine& source, const Affine& target) {
  const Affine wanted = target * inverse_of(source);
  return same(wanted, inverse_of(source) * target) ? std::nullopt : std::optional(target_for(wanted, source));
}

bool has_item(const Handle(StepRepr_Representation) & representation, const Handle(Standard_Transient) & item) {
  for (int i = 1; !representation.IsNull() && i <= representation->NbItems(); ++i)
    if (representation->ItemsValue(i) == item) return true;
  return false;
}

}  // namespace

void complete_axes(StepGeom_Axis2Placement3d& placement) {
  const dvec3 z = third_axis(placement);
  const auto x = placement.HasRefDirection() ? direction_of(placement.RefDirection()) : std::nullopt;
  if (!x || across(*x, {z}) == dvec3(0.0)) placement.SetRefDirection(step_direction(default_x(z)));
}

void order_mapping(StepRepr_MappedItem& item) {
  if (item.MappingSource().IsNull()) return;
  const auto source = Handle(StepGeom_Axis2Placement3d)::DownCast(item.MappingSource()->MappingOrigin());
  const auto target = Handle(StepGeom_Axis2Placement3d)::DownCast(item.MappingTarget());
  if (source.IsNull() || target.IsNull()) return;
  if (const auto other = ordered(frame_of(*source), frame_of(*target))) item.SetMappingTarget(step_placement(*other));
}

void order_transformation(StepRepr_ShapeRepresentationRelationshipWithTransformation& relation) {
  const auto items = relation.TransformationOperator().ItemDefinedTransformation();
  if (items.IsNull()) return;
  auto source = Handle(StepGeom_Axis2Placement3d)::DownCast(items->TransformItem1());
  auto target = Handle(StepGeom_Axis2Placement3d)::DownCast(items->TransformItem2());
  if (source.IsNull() || target.IsNull()) return;
  // Some writers exchange them, which shows where they are items.
  if (has_item(relation.Rep2(), source) && has_item(relation.Rep1(), target)) std::swap(source, target);
  if (const auto other = ordered(scaled(frame_of(*source), millimetres_per_unit(relation.Rep1())),
                                 scaled(frame_of(*target), millimetres_per_unit(relation.Rep2()))))
    place(relation, source, *other);
}

core::Affine frame_of(const StepGeom_Axis2Placement3d& at) {
  const dvec3 z = third_axis(at), x = first_proj_axis(z, direction_of(at.RefDirection()));
  Affine frame{{x, glm::cross(z, x), z}, dvec3(0.0)};
  const Handle(StepGeom_CartesianPoint) origin = at.Location();
  if (!origin.IsNull() && !origin->Coordinates().IsNull() && origin->NbCoordinates() == 3)
    frame.origin = {origin->CoordinatesValue(1), origin->CoordinatesValue(2), origin->CoordinatesValue(3)};
  return frame;
}

StepOperators::StepOperators(ImportJob& job, std::string_view whole, STEPCAFControl_Reader& reader) {
  if (whole.find(kOperator) == whole.npos) return;
  const StepText text(whole);
  const std::set<std::uint64_t> operators = all_operators(text);
  const StepEntities entities = step_entities(reader);
  const Interface_Graph& graph = reader.Reader().WS()->Graph();
  for (const StepText::Entity& entity : text.entities()) {
    if (entity.text.find("MAPPED_ITEM") == whole.npos && entity.text.find("TRANSFORMATION") == whole.npos) continue;
    const auto user = entities.find(entity.id);
    if (user == entities.end()) continue;
    for (const StepRecord& record : step_records(entity.text))
      for (const std::string_view parameter : record.parameters) {
        const auto id = step_reference(parameter);
        if (!id || !operators.contains(*id)) continue;
        const auto found = operator_of(text, *id);
        if (!found)
          job.warn(0, fmt::format("{} #{} places nothing: expected an origin and a scale above 0 in {} #{}",
                                  record.keyword, entity.id, kOperator, *id));
        replace_operator(user->second, found.value_or(Operator()), graph, uses_);
      }
  }
}

void StepOperators::note(STEPCAFControl_Reader& reader, CadDocument& document) const {
  const Handle(Transfer_TransientProcess) process = reader.Reader().WS()->TransferReader()->TransientProcess();
  for (const Use& use : uses_) {
    if (use.entity.IsNull()) continue;
    const TopoDS_Shape shape = TransferBRep::ShapeResult(process, use.entity);
    if (shape.IsNull() || shape.Location().IsIdentity()) continue;
    TopLoc_Location outermost = shape.Location();
    while (!outermost.NextLocation().IsIdentity()) outermost = outermost.NextLocation();
    const Handle(TopLoc_Datum3D) datum = outermost.FirstDatum();
    const Affine moved = from_occt(datum->Transformation());
    document.placements[datum] = use.reversed ? moved * inverse_of(use.correction) : use.correction * moved;
  }
}

}  // namespace sightline::importers
