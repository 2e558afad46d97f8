#include "sightline/importers/vtk/internal/vtk_quiet.h"

#include <mutex>

#include <vtkObject.h>

namespace sightline::importers {
namespace {

std::mutex mutex;  // guards both variables below
int living = 0;
int shown_before = 1;

}  // namespace

VtkQuiet::VtkQuiet() {
  const std::lock_guard lock(mutex);
  if (living++ > 0) return;
  shown_before = vtkObject::GetGlobalWarningDisplay();
  vtkObject::SetGlobalWarningDisplay(0);
}

VtkQuiet::~VtkQuiet() {
  const std::lock_guard lock(mutex);
  if (--living == 0) vtkObject::SetGlobalWarningDisplay(shown_before);
}

}  // namespace sightline::importers
