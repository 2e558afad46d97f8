#include "sightline/importers/cad/internal/cad_parts.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepGProp.hxx>
#include <BRep_Builder.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <Quantity_ColorRGBA.hxx>
#include <TDF_LabelSequence.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include "sightline/importers/cad/internal/occt_maths.h"
#include "sightline/importers/cad/internal/sewing.h"
#include "sightline/importers/cad/internal/solid_surfaces.h"

namespace sightline::importers {
namespace {

constexpr double kMillimetres = 1e3;  // a metre

/// Where a body's location scales or mirrors, its geometry does so instead: nothing of Open CASCADE takes such
/// locations.
Body placed(Body body, const CadDocument& document) {
  const core::Affine place = document.placement(body.shape.Location());
  const double determinant = glm::determinant(place.linear);
  if (std::abs(determinant - 1.0) < 1e-9 || determinant == 0.0) return body;
  const TopLoc_Location back = body.shape.Location().Inverted();
  body.shape.Move(back, Standard_False);
  for (StyledFace& face : body.faces) face.face.Move(back, Standard_False);
  BRepBuilderAPI_Transform change(body.shape, to_occt(place), Standard_True);
  return changed(body, change);
}

/// The looks and names that a part gives to shapes in it.
class ShapeWalk {
 public:
  ShapeWalk(const TDF_Label& part, const CadDocument& document, CadStyles& styles) : document_(document) {
    const Handle(XCAFDoc_ColorTool) colours = XCAFDoc_DocumentTool::ColorTool(document.handle()->Main());
    TDF_LabelSequence labels;
    XCAFDoc_ShapeTool::GetSubShapes(part, labels);
    for (const TDF_Label& label : labels) {
      TopoDS_Shape shape;
      if (!XCAFDoc_ShapeTool::GetShape(label, shape)) continue;
      if (const std::uint32_t style = styles.of(label, document); style != kInherited) styles_.Bind(shape, int(style));
      if (std::string name = name_of(label); !name.empty()) names_.emplace(shape.TShape().get(), std::move(name));
      if (!colours->IsVisible(label)) hidden_.insert(shape.TShape().get());
    }
  }

  CadShape run(const TopoDS_Shape& shape) {
    visit(shape, kInherited, 0);
    for (Body* loose : {&loose_, &loose_triangles_})
      if (!loose->faces.empty()) made_.bodies.push_back({{}, std::move(*loose)});
    for (TopExp_Explorer edge(shape, TopAbs_EDGE, TopAbs_FACE); edge.More(); edge.Next()) ++made_.curves;
    return std::move(made_);
  }

 private:
  static constexpr int kDeepest = 200;  // compounds in compounds

  std::uint32_t style_of(const TopoDS_Shape& shape, std::uint32_t inherited) const {
    const int* own = styles_.Seek(shape);
    return own ? std::uint32_t(*own) : inherited;
  }

  void visit(const TopoDS_Shape& shape, std::uint32_t inherited, int depth) {
    if (shape.IsNull() || depth > kDeepest || document_.doubled.count(shape.TShape()) > 0) return;
    const std::uint32_t style = style_of(shape, inherited);
    switch (shape.ShapeType()) {
      case TopAbs_COMPOUND:
      case TopAbs_COMPSOLID:
        for (TopoDS_Iterator child(shape); child.More(); child.Next()) visit(child.Value(), style, depth + 1);
        return;
      case TopAbs_SOLID:
      case TopAbs_SHELL: {
        CadShape::Named found{facts_of(shape.TShape().get()), {shape, {}}};
        add_faces(shape, style, found.body);
        if (found.body.faces.empty()) return;
        found.body = placed(std::move(found.body), document_);
        made_.bodies.push_back(std::move(found));
        return;
      }
      case TopAbs_FACE:
        for (const StyledFace& face : placed({shape, {{TopoDS::Face(shape), style}}}, document_).faces) add_loose(face);
        return;
      default:
        return;
    }
  }

  CadBodyFacts facts_of(const TopoDS_TShape* body) const {
    CadBodyFacts facts;
    for (const BodyNames* names : {&document_.body_names, &names_})
      if (const auto at = names->find(body); facts.name.empty() && at != names->end()) facts.name = at->second;
    const auto layers = document_.body_layers.find(body);
    if (layers != document_.body_layers.end()) facts.layers = layers->second.names;
    facts.visible = !hidden_.contains(body) && (layers == document_.body_layers.end() || layers->second.visible);
    return facts;
  }

  void add_faces(const TopoDS_Shape& of, std::uint32_t style, Body& body) const {
    for (TopoDS_Iterator child(of); child.More(); child.Next()) {
      const std::uint32_t own = style_of(child.Value(), style);
      if (child.Value().ShapeType() == TopAbs_FACE)
        body.faces.push_back({TopoDS::Face(child.Value()), own});
      else if (child.Value().ShapeType() == TopAbs_SHELL)
        add_faces(child.Value(), own, body);
    }
  }

  /// Faces that belong to no shell become one body.
  void add_loose(const StyledFace& styled) {
    Body& to = has_surface(styled.face) ? loose_ : loose_triangles_;
    if (to.faces.empty()) {
      TopoDS_Compound compound;
      BRep_Builder().MakeCompound(compound);
      to.shape = compound;
    }
    BRep_Builder().Add(to.shape, styled.face);
    to.faces.push_back(styled);
  }

  const CadDocument& document_;
  BodyNames names_;  // of labels
  std::set<const TopoDS_TShape*> hidden_;
  TopTools_DataMapOfShapeInteger styles_;
  CadShape made_;
  Body loose_, loose_triangles_;
};

/// In millimetres: what was asked for, or a share of the part's size.
double tolerance_for(const CadShape& shape, const ImportOptions& options, double scale) {
  if (options.chord_tolerance > 0.0) return kMillimetres * options.chord_tolerance / scale;
  constexpr double kOfSize = 5e-4, kLeast = 1e-6;
  Bnd_Box box;
  for (const auto& named : shape.bodies) BRepBndLib::Add(named.body.shape, box, Standard_False);
  return box.IsVoid() ? 1.0 : std::max(kLeast, kOfSize * std::sqrt(box.SquareExtent()));
}

/// All faces of one look, or the first's.
bool one_style(const Body& body) {
  return std::all_of(body.faces.begin(), body.faces.end(),
                     [&](const StyledFace& face) { return face.style == body.faces[0].style; });
}

std::optional<AnalyticSolid> analytic(const SewnBody& whole) {
  if (!whole.solid || !one_style(whole.body)) return std::nullopt;
  const auto surfaces = solid_surfaces(whole.body.shape);
  return surfaces ? analytic_solid(*surfaces) : std::nullopt;
}

/// How large a body is. Triangles of the file itself that are as large as an exact body of their part are its second
/// form, where the file does not say so.
struct Extent {
  core::AabbD box;
  double area;

  bool is_of_any(const std::vector<Extent>& exact) const {
    constexpr double kBoxes = 0.02, kAreas = 0.05;  // as triangles may fall short; of the diagonal, of the area
    return std::any_of(exact.begin(), exact.end(), [&](const Extent& other) {
      const core::dvec3 apart = glm::max(glm::abs(box.min - other.box.min), glm::abs(box.max - other.box.max));
      return std::max({apart.x, apart.y, apart.z}) <= kBoxes * glm::length(other.box.size()) &&
             std::abs(area - other.area) <= kAreas * other.area;
    });
  }
};

Extent extent_of(const Body& body) {
  const bool tessellated = is_tessellated(body);
  Bnd_Box box;
  if (tessellated)
    BRepBndLib::Add(body.shape, box, Standard_False);
  else
    BRepBndLib::AddOptimal(body.shape, box, Standard_False, Standard_False);
  GProp_GProps area;
  BRepGProp::SurfaceProperties(body.shape, area, Standard_False, tessellated);
  if (box.IsVoid()) return {{}, 0.0};
  return {{from_occt(box.CornerMin()), from_occt(box.CornerMax())}, area.Mass()};
}

/// Extents of the exact bodies of a part that has tessellated ones, too.
std::vector<Extent> exact_extents(const CadShape& shape) {
  const auto tessellated = [](const CadShape::Named& named) { return is_tessellated(named.body); };
  std::vector<Extent> found;
  if (std::any_of(shape.bodies.begin(), shape.bodies.end(), tessellated))
    for (const CadShape::Named& named : shape.bodies)
      if (!tessellated(named)) found.push_back(extent_of(named.body));
  return found;
}

/// Solids as they are, and what can be made of shells and loose faces.
std::vector<SewnBody> made_whole(const Body& body) {
  if (is_tessellated(body)) return {{body, false}};
  if (body.shape.ShapeType() == TopAbs_SOLID) return {{body, true}};
  if (body.shape.ShapeType() == TopAbs_SHELL) return {solid_of(body)};
  return sewn(body);
}

}  // namespace

std::uint32_t CadStyles::number(const CadStyle& style) {
  const auto at = std::find(all_.begin(), all_.end(), style);
  if (at != all_.end()) return std::uint32_t(at - all_.begin());
  all_.push_back(style);
  return std::uint32_t(all_.size() - 1);
}

std::uint32_t CadStyles::of(const TDF_Label& label, const CadDocument& document) {
  const Handle(XCAFDoc_ColorTool) colours = XCAFDoc_DocumentTool::ColorTool(document.handle()->Main());
  Quantity_ColorRGBA colour;
  for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen}) {
    if (!colours->GetColor(label, type, colour)) continue;
    double r, g, b;
    colour.GetRGB().Values(r, g, b, Quantity_TOC_sRGB);
    return number({core::vec3(r, g, b), colour.Alpha()});
  }
  return kInherited;
}

CadShape shape_of(const TDF_Label& part, const CadDocument& document, CadStyles& styles) {
  return ShapeWalk(part, document, styles).run(XCAFDoc_ShapeTool::GetShape(part));
}

CadPart make_part(const CadShape& shape, const ImportOptions& options, double scale, bool all_meshes) {
  CadPart made;
  made.curves = shape.curves;
  made.tolerance = tolerance_for(shape, options, scale);
  const std::vector<Extent> exact = exact_extents(shape);
  for (const CadShape::Named& named : shape.bodies) {
    const Body& body = named.body;
    const bool tessellated = is_tessellated(body);
    if (tessellated && !exact.empty() && extent_of(body).is_of_any(exact)) continue;
    for (const SewnBody& whole : all_meshes ? std::vector<SewnBody>{{body, false}} : made_whole(body)) {
      CadPart::Content content{named, kInherited, {}, {}, tessellated};
      if (auto found = analytic(whole)) {
        content.style = whole.body.faces[0].style;
        content.primitives = std::move(found->parts);
        made.analytic_deviation = std::max(made.analytic_deviation, found->deviation);
      } else {
        content.mesh = mesh_body(whole.body, {made.tolerance, options.chord_angle});
      }
      made.contents.push_back(std::move(content));
    }
  }
  const bool measured =
      std::any_of(made.contents.begin(), made.contents.end(), [](const auto& c) { return !c.tessellated; });
  if (!measured) made.tolerance = 0.0;
  return made;
}

}  // namespace sightline::importers
