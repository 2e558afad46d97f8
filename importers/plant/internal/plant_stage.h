// Internal to the plant generator: random numbers, the budget that makes its statistics exact, and basic parts.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/scene.h"

namespace sightline::importers::plant {

using core::dmat3;
using core::dvec3;

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kHalfSqrt2 = 0.70710678118654752440;  // cos and sin of 45 degrees
inline constexpr dvec3 kUp{0.0, 0.0, 1.0};

/// SplitMix64 (G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators", 2014). The standard
/// library's distributions differ from one implementation to the next; these do not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  double unit() { return double(next() >> 11) * 0x1p-53; }  ///< [0, 1)
  double between(double low, double high) { return low + (high - low) * unit(); }
  int below(int count) { return int(((next() >> 32) * std::uint64_t(count)) >> 32); }
  bool chance(double probability) { return unit() < probability; }

 private:
  std::uint64_t state_;
};

/// The classes of items that the statistics distinguish.
enum Share : int { kCylinders, kTori, kSnouts, kOthers, kShareCount };
using Counts = std::array<std::int64_t, kShareCount>;
inline constexpr std::array<double, kShareCount> kFractions{0.65, 0.20, 0.05, 0.10};

/// Right-handed orthonormal axes and an origin, in metres.
struct Frame {
  dmat3 axes{1.0};
  dvec3 origin{0.0};
};

/// z along the unit vector `direction`; x as near to up as possible.
Frame frame_along(const dvec3& origin, const dvec3& direction);

/// Stages one system (a pipe, a vessel, a structure) at a time and counts its items against what the statistics still
/// allow. The system then enters the scene as a whole or not at all.
class Stage {
 public:
  Stage(core::Scene& scene, std::uint64_t items);

  /// Sets how far each share may be used up now, as a fraction of the whole plant.
  void allow(double fraction);
  std::int64_t room(Share share) const { return limit_[share] - used_[share] - staged_[share]; }
  std::int64_t room() const;
  std::int64_t staged() const { return std::int64_t(items_.size()); }

  void begin(core::NodeId zone, std::string_view prefix, core::MaterialId material);
  /// Items added from now on belong to the next branch.
  void branch() { branches_.push_back(items_.size()); }
  void add(const core::Primitive& primitive, const Frame& frame);
  void add_mesh(core::MeshId mesh, const Frame& frame);
  /// True when the staged system had items and fitted into the shares.
  bool finish();

  core::Scene& scene() { return scene_; }

 private:
  struct Item {
    core::Primitive primitive;
    core::MeshId mesh;
    Frame frame;
  };
  void insert(core::NodeId node, const Item& item);

  core::Scene& scene_;
  Counts quota_{}, limit_{}, used_{}, staged_{};
  core::NodeId zone_;
  core::MaterialId material_;
  std::string prefix_;
  std::vector<Item> items_;
  std::vector<std::size_t> branches_;
  std::uint64_t systems_ = 0;
};

// --- parts: all lengths in metres ------------------------------------------------------------------------------------

inline float mm(double metres) {
  return float(metres * 1000.0);
}

void add_cylinder(Stage& stage, const dvec3& from, const dvec3& to, double radius);
void add_box(Stage& stage, const dvec3& centre, const dvec3& size);
void add_box(Stage& stage, const Frame& frame, const dvec3& size);
/// Box with the given corners.
void add_block(Stage& stage, const dvec3& low, const dvec3& high);
void add_dish(Stage& stage, const dvec3& base, const dvec3& axis, double radius, double height, bool spherical = false);
/// A snout from `from` along the axis `direction`, except for an eccentric offset along the frame's x. Radii: at its
/// bottom and top.
void add_snout(Stage& stage, const dvec3& from, const dvec3& direction, double length, const core::dvec2& radii,
               double offset = 0.0);
/// A full ring about `axis` in two halves.
void add_ring(Stage& stage, const dvec3& centre, const dvec3& axis, double major, double tube);

/// Lays pipe piece by piece, each beginning where the last one ended.
class PipeRun {
 public:
  PipeRun(Stage& stage, const dvec3& at, const dvec3& direction, double radius)
      : stage_(stage), at_(at), direction_(direction), radius_(radius) {}

  void straight(double length);
  /// A disc of flange.
  void flange(double thickness, double radius);
  /// Elbow towards the unit vector `to`, at 45 or 90 degrees to the present direction.
  void turn(const dvec3& to);
  /// Changes to `radius`; eccentric reducers keep the underside of a horizontal pipe level.
  void reduce(double radius, double length, bool eccentric);
  /// A cone that does not change the pipe's own size: half a valve body.
  void cone(double from, double to, double length);
  void cap();  ///< dished end

  const dvec3& at() const { return at_; }
  const dvec3& direction() const { return direction_; }
  double radius() const { return radius_; }
  double bend() const { return 3.0 * radius_; }  ///< long-radius elbow: 1.5 diameters

 private:
  Stage& stage_;
  dvec3 at_, direction_;
  double radius_;
};

}  // namespace sightline::importers::plant
