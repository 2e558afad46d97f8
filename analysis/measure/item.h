// An item prepared for measurement: do this once, and measure often.
#pragma once

#include <memory>
#include <span>

#include "sightline/analysis/measure/features.h"
#include "sightline/core/error.h"
#include "sightline/core/mesh.h"
#include "sightline/core/scene.h"

namespace sightline::measure {

/// A primitive or a mesh with its placement. Cheap to copy: copies share what was prepared. Immutable, so any number of
/// threads may use it.
class SIGHTLINE_API Item {
 public:
  /// Fails when a parameter or the placement is not finite.
  static core::Expected<Item> create(const core::Primitive& primitive, const core::Affine& world_from_item);
  /// Copies what it needs of the mesh: a hierarchy over its triangles and its sharp edges, in about 1 us a triangle.
  /// Triangles with a corner that is not finite are left out. Fails on a mesh that fails validate(), and when the
  /// placement is not finite.
  static core::Expected<Item> create(const core::Mesh& mesh, const core::Affine& world_from_item);
  /// One of these two, as the item lies in the world.
  static core::Expected<Item> create(const core::Scene& scene, core::ItemId item);

  core::Kind kind() const;
  /// As features() gives them. Empty for meshes, whose features snap() finds about a point.
  std::span<const Feature> features() const;

  struct Data;  ///< private to the library
  const Data& data() const { return *data_; }

 private:
  explicit Item(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  std::shared_ptr<const Data> data_;
};

}  // namespace sightline::measure
