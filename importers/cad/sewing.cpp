#include "sightline/importers/cad/internal/sewing.h"

#include <algorithm>

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepGProp.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Vertex.hxx>

namespace sightline::importers {
namespace {

double sewing_tolerance(const TopoDS_Shape& faces) {
  constexpr double kLeast = 1e-6, kMost = 1e-4;  // of the size
  Bnd_Box box;
  BRepBndLib::Add(faces, box, Standard_False);
  if (box.IsVoid()) return 0.0;
  double stated = 0.0;
  for (TopExp_Explorer vertex(faces, TopAbs_VERTEX); vertex.More(); vertex.Next())
    stated = std::max(stated, BRep_Tool::Tolerance(TopoDS::Vertex(vertex.Current())));
  const double size = std::sqrt(box.SquareExtent());
  return std::clamp(stated, kLeast * size, kMost * size);
}

/// The styles of faces that came out of others.
class Styles {
 public:
  Styles(const Body& before, const BRepBuilderAPI_Sewing& sewing) {
    for (const StyledFace& face : before.faces) {
      const TopoDS_Shape& now = sewing.IsModified(face.face) ? sewing.Modified(face.face) : face.face;
      for (TopExp_Explorer part(now, TopAbs_FACE); part.More(); part.Next()) of_.Bind(part.Current(), int(face.style));
    }
  }

  /// All faces of a shape that have a style.
  Body body(const TopoDS_Shape& shape) const {
    Body made{shape, {}};
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
      if (const int* style = of_.Seek(face.Current()))
        made.faces.push_back({TopoDS::Face(face.Current()), std::uint32_t(*style)});
    return made;
  }

 private:
  TopTools_DataMapOfShapeInteger of_;
};

}  // namespace

SewnBody solid_of(const Body& shell) {
  if (shell.shape.ShapeType() != TopAbs_SHELL || !BRep_Tool::IsClosed(shell.shape)) return {shell, false};
  TopoDS_Solid solid;
  BRep_Builder().MakeSolid(solid);
  BRep_Builder().Add(solid, shell.shape);
  GProp_GProps volume;
  BRepGProp::VolumeProperties(solid, volume);
  if (volume.Mass() > 0.0) return {{solid, shell.faces}, true};
  BRep_Builder().MakeSolid(solid);
  BRep_Builder().Add(solid, shell.shape.Reversed());
  SewnBody turned{{solid, shell.faces}, volume.Mass() < 0.0};
  for (StyledFace& face : turned.body.faces) face.face.Reverse();
  return turned;
}

std::vector<SewnBody> sewn(const Body& loose) {
  constexpr std::size_t kMost = 20'000;  // beyond, sewing takes minutes
  const double tolerance = sewing_tolerance(loose.shape);
  if (loose.faces.size() < 2 || loose.faces.size() > kMost || tolerance == 0.0) return {{loose, false}};
  BRepBuilderAPI_Sewing sewing(tolerance);
  for (const StyledFace& face : loose.faces) sewing.Add(face.face);
  sewing.Perform();
  const Styles styles(loose, sewing);
  std::vector<SewnBody> made;
  for (TopExp_Explorer shell(sewing.SewedShape(), TopAbs_SHELL); shell.More(); shell.Next())
    if (Body body = styles.body(shell.Current()); !body.faces.empty()) made.push_back(solid_of(body));
  Body rest;
  TopoDS_Compound compound;
  BRep_Builder().MakeCompound(compound);
  for (TopExp_Explorer face(sewing.SewedShape(), TopAbs_FACE, TopAbs_SHELL); face.More(); face.Next())
    for (const StyledFace& styled : styles.body(face.Current()).faces) {
      BRep_Builder().Add(compound, styled.face);
      rest.faces.push_back(styled);
    }
  rest.shape = compound;
  if (!rest.faces.empty()) made.push_back({std::move(rest), false});
  return made;
}

}  // namespace sightline::importers
