// One camera: where it stands, how it projects, and what it cuts away.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/core/api.h"
#include "sightline/core/error.h"

namespace sightline::core {

/// Where a camera stands and looks, in world metres.
struct Pose {
  dvec3 eye{0.0, 0.0, 0.0};
  dvec3 target{0.0, 1.0, 0.0};
  dvec3 up{0.0, 0.0, 1.0};
};

/// How section planes combine: a point is kept when it is inside all of them, or inside any.
enum class SectionMode : std::uint8_t { kIntersection, kUnion };

inline constexpr std::size_t kMaxSectionPlanes = 8;
inline constexpr double kInfiniteFar = std::numeric_limits<double>::infinity();

/// A view keeps eye_from_world and clip_from_eye apart and in double precision, so that the large world translation
/// never meets the small clip range in float. Eye space looks down -z with y up. Sections and layers may be set freely
/// after construction.
class SIGHTLINE_API View {
 public:
  /// fovy in radians, in (0, pi); aspect = width / height > 0; 0 < near < far; far may be kInfiniteFar. The pose must
  /// be finite. When `up` is parallel to the line of sight, another axis takes its place. Fails on eye == target and on
  /// bad numbers.
  static Expected<View> perspective(const Pose& pose, double fovy, double aspect, double near,
                                    double far = kInfiniteFar);
  /// height in metres > 0; near < far, both finite, either may be negative.
  static Expected<View> orthographic(const Pose& pose, double height, double aspect, double near, double far);
  /// Off-axis perspective: left < right and bottom < top on the near plane.
  static Expected<View> asymmetric(const Pose& pose, double left, double right, double bottom, double top, double near,
                                   double far = kInfiniteFar);
  /// The perspective view along `direction` in which the box fills the image; see fitting_pose(). Near is a thousandth
  /// of the box's diagonal, far is infinite. Fails where fitting_pose() has no answer: for a zero direction, and for
  /// arguments that are not finite or out of range.
  static Expected<View> fit(const AabbD& bounds, const dvec3& direction, double fovy, double aspect,
                            double filled = 1.0);
  /// A view from an application's own matrices. Culling uses clip_from_eye * eye_from_world. Pass a combined projection
  /// * view matrix as clip_from_eye, with the identity as eye_from_world. Such a view can cull but not be drawn, since
  /// drawing needs the two parts. Entries must be finite. Fails when eye_from_world is not affine (last row 0 0 0 1),
  /// for example when it is a combined matrix, and when the projection's depth falls with distance where `depth` says
  /// that it grows, or grows where it falls. Matrices that do not tell pass: combined parallel projections, oblique
  /// near planes, and those of no camera.
  static Expected<View> from_matrices(const dmat4& eye_from_world, const dmat4& clip_from_eye, ClipDepth depth);

  const dmat4& eye_from_world() const { return eye_from_world_; }
  const dmat4& clip_from_eye() const { return clip_from_eye_; }
  /// The product as this class rounds it: the view volume is defined by these sixteen numbers.
  dmat4 clip_from_world() const;
  ClipDepth clip_depth() const { return clip_depth_; }
  bool orthographic() const {
    return clip_from_eye_[0][3] == 0.0 && clip_from_eye_[1][3] == 0.0 && clip_from_eye_[2][3] == 0.0;
  }
  /// Eye position in world coordinates (perspective views).
  dvec3 eye() const;

  /// Kept half-spaces, at most kMaxSectionPlanes. A plane with zero normal is ignored. Planes are moved outwards by the
  /// rounding of items, so that what touches one is whole, wherever in the world it lies.
  std::vector<Plane> sections;
  SectionMode section_mode = SectionMode::kIntersection;
  std::uint32_t layers = kDefaultLayerMask;

 private:
  View(const dmat4& eye_from_world, const dmat4& clip_from_eye, ClipDepth depth)
      : eye_from_world_(eye_from_world), clip_from_eye_(clip_from_eye), clip_depth_(depth) {}
  dmat4 eye_from_world_, clip_from_eye_;
  ClipDepth clip_depth_;
};

/// Whether both show the same of a scene: equal in every number.
SIGHTLINE_API bool same_image(const View& a, const View& b);

/// The six planes of a clip_from_world matrix in the order of FrustumPlane, not normalised (G. Gribb, K. Hartmann,
/// "Fast extraction of viewing frustum planes", 2001). An infinite far plane comes out with a zero normal and a
/// positive offset.
SIGHTLINE_API std::array<Plane, kFrustumPlaneCount> frustum_planes(const dmat4& clip_from_world, ClipDepth depth);

/// eye_from_world of a pose: right-handed, looking down -z.
SIGHTLINE_API Expected<dmat4> look_at(const Pose& pose);

/// The pose that looks along `direction` from as near as possible. All eight corners of the box lie inside a
/// perspective image of `fovy` radians and width / height `aspect`. The corners touch two opposite borders of the
/// image, left and right or bottom and top, and are centred between the other two. They touch no border only where the
/// eye would otherwise come nearer to the box than a hundredth of its diagonal. The target lies at the depth of the
/// box's centre. Up is z, or the top of the image where the line of sight is nearly vertical.
///
/// An empty box counts as the cube of ±1 m about the origin. A point counts as that cube about the point.
/// `filled`: the box fits the middle of the image, of so much of its width and height, and the borders of that count.
/// Preconditions: bounds finite or empty, direction finite and not zero, 0 < fovy < pi, aspect positive and finite,
/// 0 < filled <= 1.
SIGHTLINE_API Pose fitting_pose(const AabbD& bounds, const dvec3& direction, double fovy, double aspect,
                                double filled = 1.0);

/// What images of the whole leave room around: the share that is filled.
inline constexpr double kOverviewFilled = 0.9;

/// View direction of an overview: from above and the south-west, z up.
inline const dvec3 kOverviewDirection{0.55, 0.85, -0.55};

}  // namespace sightline::core
