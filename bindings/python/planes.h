// Arguments of views: section planes as rows of numbers, and the name of a depth range.
#pragma once

#include "sightline/bindings/python/convert.h"
#include "sightline/core/view.h"

namespace sightline::python {

/// (N, 4), at most core::kMaxSectionPlanes, finite: normal and offset.
std::vector<core::Plane> section_planes(py::handle value, const char* argument);
Numbers<double> planes_to_array(const std::vector<core::Plane>& planes);

core::ClipDepth depth_of(const std::string& name);

}  // namespace sightline::python
