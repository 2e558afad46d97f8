// What an item looks like, ready to be compared. Internal.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sightline/core/scene.h"

namespace sightline::compare {

using core::dmat3;
using core::dvec3;

/// Properties of a shape in its own coordinates.
struct LocalShape {
  core::AabbD box;
  dvec3 centre{0.0};                        ///< of the box of a primitive; the mean of a mesh's vertices
  dmat3 spread{0.0};                        ///< second moments about the centre
  std::uint64_t topology = 0, content = 0;  ///< hashes of a mesh's indices, and of its positions with them
};

/// An item as it lies in the world.
struct Geometry {
  core::Affine world_from_item;
  dvec3 centre{0.0};
  double size = 0.0;  ///< the root of the sum of second moments: the same however the shape is turned
  std::uint64_t topology = 0;
  core::Kind kind = core::Kind::kMesh;
};

/// How two items lie. `same_place` of items of different shape means their centres.
struct Likeness {
  bool same_shape = false, same_place = false;
};

/// Shapes of the items of a scene.
class Shapes {
 public:
  explicit Shapes(const core::Scene& scene) : scene_(&scene), meshes_(scene.mesh_slots()) {}

  Geometry geometry(core::ItemId item, const core::Affine& world_from_item);
  LocalShape local(core::ItemId item) const;  ///< of an item that geometry() was asked for

  const core::Scene& scene() const { return *scene_; }

 private:
  const core::Scene* scene_;
  std::vector<std::optional<LocalShape>> meshes_;
};

/// An item of one scene.
struct Shown {
  const Shapes& shapes;
  core::ItemId item;
  const Geometry& geometry;
};

/// `tolerance` and what rounding adds to it for this item: metres.
double allowance(const Geometry& geometry, double tolerance);

Likeness likeness(const Shown& a, const Shown& b, double tolerance);

/// The angle of the rotation from one placement to the other of items of the same shape, 0 … pi.
double turn_between(const core::Affine& from, const core::Affine& to);

}  // namespace sightline::compare
