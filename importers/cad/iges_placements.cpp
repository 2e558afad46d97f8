#include "sightline/importers/cad/internal/iges_placements.h"

#include <algorithm>
#include <cmath>

#include <IGESBasic_SingularSubfigure.hxx>
#include <IGESGeom_TransformationMatrix.hxx>
#include <TColStd_HArray2OfReal.hxx>
#include <fmt/format.h>

namespace sightline::importers {
namespace {

Handle(IGESGeom_TransformationMatrix) identity_matrix() {
  const Handle(TColStd_HArray2OfReal) values = new TColStd_HArray2OfReal(1, 3, 1, 4, 0.0);
  for (int i = 1; i <= 3; ++i) values->SetValue(i, i, 1.0);
  const Handle(IGESGeom_TransformationMatrix) made = new IGESGeom_TransformationMatrix;
  made->Init(values);
  return made;
}

/// Whether a matrix does more than to turn, mirror, move and scale evenly.
bool distorts(const IGESGeom_TransformationMatrix& matrix) {
  const auto product = [&](int i, int j) {
    double sum = 0.0;
    for (int row = 1; row <= 3; ++row) sum += matrix.Data(row, i) * matrix.Data(row, j);
    return sum;
  };
  const double scale = (product(1, 1) + product(2, 2) + product(3, 3)) / 3.0;
  double off = 0.0;
  for (int i = 1; i <= 3; ++i)
    for (int j = 1; j <= 3; ++j) off = std::max(off, std::abs(product(i, j) - (i == j ? scale : 0.0)));
  constexpr double kRounding = 1e-3;  // of directions as files have them
  return !(scale > 0.0 && off <= kRounding * scale);
}

}  // namespace

void prepare_iges_placements(ImportJob& job, const Handle(IGESData_IGESModel) & model) {
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Handle(IGESData_IGESEntity) entity = model->Entity(i);
    if (const auto matrix = Handle(IGESGeom_TransformationMatrix)::DownCast(entity); !matrix.IsNull()) {
      if (distorts(*matrix))
        job.warn(
            0, fmt::format("transformation matrix (entity 124) at D{} distorts and is left out", model->DNum(entity)));
      continue;
    }
    // With a matrix, Open CASCADE scales the geometry; without, it would scale a location, which it forbids.
    const auto instance = Handle(IGESBasic_SingularSubfigure)::DownCast(entity);
    if (!instance.IsNull() && instance->HasScaleFactor() && instance->ScaleFactor() != 1.0 && !instance->HasTransf())
      instance->InitTransf(identity_matrix());
  }
}

}  // namespace sightline::importers
