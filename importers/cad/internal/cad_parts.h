// Internal to the importers: the parts of a document, each once, as primitives and meshes.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <TDF_Label.hxx>

#include "sightline/importers/cad/internal/analytic_solid.h"
#include "sightline/importers/cad/internal/body_mesh.h"
#include "sightline/importers/cad/internal/cad_document.h"

namespace sightline::importers {

/// A colour, sRGB 0 to 1.
struct CadStyle {
  core::vec3 colour{0.0f};
  float alpha = 1.0f;
  friend bool operator==(const CadStyle&, const CadStyle&) = default;
};
/// The number of no style: that of the node above.
inline constexpr std::uint32_t kInherited = core::kNone;

/// Each style once.
class CadStyles {
 public:
  std::uint32_t number(const CadStyle& style);
  /// The style that a label has been given itself, or kInherited.
  std::uint32_t of(const TDF_Label& label, const CadDocument& document);
  const std::vector<CadStyle>& all() const { return all_; }

 private:
  std::vector<CadStyle> all_;
};

/// A solid, a shell or loose faces, apart from the geometry.
struct CadBodyFacts {
  std::string name;    ///< of a solid, where the file gives one
  std::string layers;  ///< its own; empty: none
  bool visible = true;
};

/// A part, in millimetres.
struct CadPart {
  struct Content : CadBodyFacts {
    std::uint32_t style = kInherited;
    std::vector<AnalyticPart> primitives;  ///< if empty, meshed
    BodyMesh mesh;
    bool tessellated = false;  ///< in the file itself
  };
  std::string name;
  std::vector<Content> contents;
  std::uint64_t curves = 0;  ///< edges that belong to no face, which are not read
  double tolerance = 0.0;    ///< of its meshes; 0 where all are the file's own
  double analytic_deviation = 0.0;
};

/// The bodies of one shape with the looks of their faces.
struct CadShape {
  struct Named : CadBodyFacts {
    Body body;
  };
  std::vector<Named> bodies;
  std::uint64_t curves = 0;
};
CadShape shape_of(const TDF_Label& part, const CadDocument& document, CadStyles& styles);

/// Analytic solids as primitives, all else meshed, to be used at a scale of up to `scale`. Several threads may do so
/// for parts that share no face. With `all_meshes`, solids are meshed too, and loose faces are not sewn.
CadPart make_part(const CadShape& shape, const ImportOptions& options, double scale, bool all_meshes = false);

}  // namespace sightline::importers
