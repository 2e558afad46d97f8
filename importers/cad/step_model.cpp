#include "sightline/importers/cad/internal/step_model.h"

#include <Interface_EntityIterator.hxx>
#include <STEPConstruct_UnitContext.hxx>
#include <StepData_StepModel.hxx>
#include <StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx.hxx>
#include <StepGeom_GeometricRepresentationContextAndGlobalUnitAssignedContext.hxx>
#include <StepRepr_GlobalUnitAssignedContext.hxx>
#include <StepRepr_RepresentationContext.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TCollection_HAsciiString.hxx>

namespace sightline::importers {

StepEntities step_entities(STEPCAFControl_Reader& reader) {
  const Handle(StepData_StepModel) model = reader.Reader().StepModel();
  StepEntities found;
  for (int i = 1; i <= model->NbEntities(); ++i)
    if (const int number = model->IdentLabel(model->Value(i)); number > 0)
      found.emplace(std::uint64_t(number), model->Value(i));
  return found;
}

Handle(StepRepr_Representation)
    representation_of(const Handle(Standard_Transient) & item, const Interface_Graph& graph) {
  Interface_EntityIterator users = graph.Sharings(item);
  for (users.Start(); users.More(); users.Next())
    if (const auto found = Handle(StepRepr_Representation)::DownCast(users.Value()); !found.IsNull()) return found;
  return {};
}

Handle(StepGeom_Direction) step_direction(const core::dvec3& v) {
  const Handle(TColStd_HArray1OfReal) ratios = new TColStd_HArray1OfReal(1, 3);
  for (int k = 0; k < 3; ++k) ratios->SetValue(k + 1, v[k]);
  const Handle(StepGeom_Direction) made = new StepGeom_Direction;
  made->Init(new TCollection_HAsciiString(""), ratios);
  return made;
}

double millimetres_per_unit(const Handle(StepRepr_Representation) & representation) {
  if (representation.IsNull()) return 1.0;
  const Handle(StepRepr_RepresentationContext) context = representation->ContextOfItems();
  auto units = Handle(StepRepr_GlobalUnitAssignedContext)::DownCast(context);
  if (const auto with_tolerance =
          Handle(StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx)::DownCast(context);
      !with_tolerance.IsNull())
    units = with_tolerance->GlobalUnitAssignedContext();
  if (const auto geometric =
          Handle(StepGeom_GeometricRepresentationContextAndGlobalUnitAssignedContext)::DownCast(context);
      !geometric.IsNull())
    units = geometric->GlobalUnitAssignedContext();
  if (units.IsNull()) return 1.0;
  STEPConstruct_UnitContext factors;
  factors.ComputeFactors(units);
  return factors.LengthDone() ? factors.LengthFactor() : 1.0;
}

}  // namespace sightline::importers
