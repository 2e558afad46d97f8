// core: what the model is. Conventions and maths, scene graph, primitive parameters and bounds, snapshot, hierarchy
// builder, view, visible set, camera path. Depends on GLM and tl-expected alone.
//
// This header fixes the conventions of the whole library; tests/core/conventions_test.cpp pins each line.
//   world        right-handed, metres, Z up for plant models; importers scale and record the file's unit
//   matrices     column vectors, named by their ends: clip_from_world * world_from_node
//   planes       dot(n, p) + d >= 0 is inside; order left, right, bottom, top, near, far
//   depth        reverse-Z: 1 at the near plane, 0 at the far plane (glClipControl zero-to-one)
//   angles       radians, counter-clockwise seen against the axis; front faces counter-clockwise
//   boxes        closed: a box that touches a plane intersects it
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

namespace sightline::core {

using glm::dmat3;
using glm::dmat4;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using glm::mat3;
using glm::vec3;

/// Order of the six frustum planes wherever they lie in an array.
enum FrustumPlane : int { kLeft, kRight, kBottom, kTop, kNear, kFar, kFrustumPlaneCount };

/// Half-space dot(normal, p) + offset >= 0. The normal need not have unit length; a zero normal is no plane at all.
struct Plane {
  dvec3 normal{0.0};
  double offset = 0.0;
};

/// Signed value of a plane at a point: >= 0 inside, in units of |normal|.
inline double evaluate(const Plane& plane, const dvec3& p) {
  return glm::dot(plane.normal, p) + plane.offset;
}

/// Clip-space depth range that a projection was made for.
enum class ClipDepth : std::uint8_t {
  kReversedZeroToOne,  ///< near at 1, far at 0: what Sightline renders with
  kMinusOneToOne,      ///< near at -1, far at +1: classic OpenGL, accepted from applications
  kZeroToOne,          ///< near at 0, far at 1: Vulkan, Direct3D, WebGPU; accepted from applications
};

/// Depths (z / w in clip space) of the near and of the far plane.
constexpr double near_depth(ClipDepth range) {
  return range == ClipDepth::kReversedZeroToOne ? 1.0 : range == ClipDepth::kMinusOneToOne ? -1.0 : 0.0;
}
constexpr double far_depth(ClipDepth range) {
  return range == ClipDepth::kReversedZeroToOne ? 0.0 : 1.0;
}

inline constexpr std::uint32_t kNone = 0xffffffffu;
/// An item's place in a snapshot's spatial order: internal, changes with every rebuild.
using Slot = std::uint32_t;
/// An item's stable name outside the library: items are numbered in the order of their insertion into the scene. An id
/// is never reused, except after Scene::reuse_ids(). A type of its own, so that no slot is taken for an id or the
/// reverse.
enum class ItemId : std::uint32_t {};
inline constexpr ItemId kNoItem{kNone};
/// The item's number, for arrays by item. Id images hold this number plus 1, and 0 for no item.
constexpr std::uint32_t to_index(ItemId item) {
  return std::uint32_t(item);
}
/// For loops over all ids of a scene.
constexpr ItemId& operator++(ItemId& item) {
  return item = ItemId{to_index(item) + 1};
}

/// Layer bits. An item is drawn when its layers share a bit with the view's mask.
inline constexpr std::uint32_t kLayerModel = 1u << 0;
inline constexpr std::uint32_t kLayerObstruction = 1u << 1;  ///< RVM OBST volumes, hidden unless asked for
inline constexpr std::uint32_t kLayerInsulation = 1u << 2;   ///< RVM INSU volumes, hidden unless asked for
inline constexpr std::uint32_t kDefaultLayerMask = ~(kLayerObstruction | kLayerInsulation);

}  // namespace sightline::core
