// Internal to the importers: points and placements of Open CASCADE as ours.
#pragma once

#include <gp_Dir.hxx>
#include <gp_Pnt.hxx>
#include <gp_Trsf.hxx>
#include <gp_Vec.hxx>

#include "sightline/core/affine.h"

namespace sightline::importers {

inline core::dvec3 from_occt(const gp_XYZ& v) {
  return {v.X(), v.Y(), v.Z()};
}
inline core::dvec3 from_occt(const gp_Pnt& p) {
  return from_occt(p.XYZ());
}
inline core::dvec3 from_occt(const gp_Dir& d) {
  return from_occt(d.XYZ());
}
inline core::dvec3 from_occt(const gp_Vec& v) {
  return from_occt(v.XYZ());
}
inline core::Affine from_occt(const gp_Trsf& t) {
  core::Affine map;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) map.linear[column][row] = t.Value(row + 1, column + 1);
    map.origin[row] = t.Value(row + 1, 4);
  }
  return map;
}

/// For maps that turn, mirror, move and scale evenly.
inline gp_Trsf to_occt(const core::Affine& a) {
  const core::dmat3& m = a.linear;
  const core::dvec3& o = a.origin;
  gp_Trsf made;
  made.SetValues(m[0][0], m[1][0], m[2][0], o.x, m[0][1], m[1][1], m[2][1], o.y, m[0][2], m[1][2], m[2][2], o.z);
  return made;
}

inline core::Affine inverse_of(const core::Affine& a) {
  const core::dmat3 back = glm::inverse(a.linear);
  return {back, -(back * a.origin)};
}

}  // namespace sightline::importers
