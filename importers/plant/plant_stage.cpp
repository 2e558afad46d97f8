#include "sightline/importers/plant/internal/plant_stage.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sightline::importers::plant {
namespace {

Share share_of(core::Kind kind) {
  switch (kind) {
    case core::Kind::kCylinder:
      return kCylinders;
    case core::Kind::kCircularTorus:
      return kTori;
    case core::Kind::kSnout:
      return kSnouts;
    default:
      return kOthers;
  }
}

Counts quota_for(std::uint64_t items) {
  Counts quota{};
  for (int s = kTori; s < kShareCount; ++s) quota[s] = std::llround(kFractions[s] * double(items));
  quota[kCylinders] = std::int64_t(items) - quota[kTori] - quota[kSnouts] - quota[kOthers];
  return quota;
}

/// RVM files hold positions in single precision, where multiples of 2^-16 m are exact below 256 m. (A cast to float and
/// back would do as well, were it not that g++ 12 drops the pair of casts when it vectorises them.)
dvec3 to_single(const dvec3& v) {
  constexpr double kGrid = 65536.0;
  return glm::floor(v * kGrid + 0.5) / kGrid;
}

constexpr float kQuarterTurn = float(kPi / 2.0), kEighthTurn = float(kPi / 4.0), kHalfTurn = float(kPi);

}  // namespace

Frame frame_along(const dvec3& origin, const dvec3& direction) {
  const dvec3 aside = std::fabs(direction.z) > 0.9 ? dvec3(1.0, 0.0, 0.0) : kUp;
  const dvec3 across = aside - glm::dot(aside, direction) * direction;
  const dvec3 x = across / std::sqrt(glm::dot(across, across));
  return {dmat3(x, glm::cross(direction, x), direction), origin};
}

Stage::Stage(core::Scene& scene, std::uint64_t items) : scene_(scene), quota_(quota_for(items)) {}

void Stage::allow(double fraction) {
  for (int s = 0; s < kShareCount; ++s)
    limit_[s] = fraction >= 1.0 ? quota_[s] : std::max(limit_[s], std::int64_t(fraction * double(quota_[s])));
}

std::int64_t Stage::room() const {
  std::int64_t sum = 0;
  for (int s = 0; s < kShareCount; ++s) sum += std::max<std::int64_t>(0, room(Share(s)));
  return sum;
}

void Stage::begin(core::NodeId zone, std::string_view prefix, core::MaterialId material) {
  zone_ = zone;
  prefix_ = prefix;
  material_ = material;
  items_.clear();
  branches_.clear();
  staged_ = {};
}

void Stage::add(const core::Primitive& primitive, const Frame& frame) {
  items_.push_back({primitive, {}, frame});
  ++staged_[share_of(core::kind_of(primitive))];
}

void Stage::add_mesh(core::MeshId mesh, const Frame& frame) {
  items_.push_back({core::Box{}, mesh, frame});
  ++staged_[kOthers];
}

void Stage::insert(core::NodeId node, const Item& item) {
  const core::Affine placement{item.frame.axes * 0.001, to_single(item.frame.origin)};
  if (item.mesh.valid()) {
    scene_.add_mesh_instance(node, item.mesh, placement);
  } else {
    scene_.add_primitive(node, item.primitive, placement);
  }
}

bool Stage::finish() {
  bool fits = !items_.empty();
  for (int s = 0; s < kShareCount; ++s) fits = fits && (staged_[s] == 0 || room(Share(s)) >= 0);
  if (fits) {
    const std::string name = prefix_ + "-" + std::to_string(++systems_);
    const core::NodeId system = scene_.add_node(zone_, name);
    scene_.set_material(system, material_);
    core::NodeId node = system;
    std::size_t next = 0;
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const bool opens = next < branches_.size() && branches_[next] == i;
      while (next < branches_.size() && branches_[next] <= i) ++next;
      if (opens) {
        node = scene_.add_node(system, name + "-B" + std::to_string(next));
        scene_.set_material(node, material_);
      }
      insert(node, items_[i]);
    }
    for (int s = 0; s < kShareCount; ++s) used_[s] += staged_[s];
  }
  items_.clear();
  staged_ = {};
  return fits;
}

void add_cylinder(Stage& stage, const dvec3& from, const dvec3& to, double radius) {
  const dvec3 axis = to - from;
  const double length = std::sqrt(glm::dot(axis, axis));
  stage.add(core::Cylinder{mm(radius), mm(length)}, frame_along(0.5 * (from + to), axis / length));
}

void add_box(Stage& stage, const Frame& frame, const dvec3& size) {
  stage.add(core::Box{mm(size.x), mm(size.y), mm(size.z)}, frame);
}

void add_box(Stage& stage, const dvec3& centre, const dvec3& size) {
  add_box(stage, Frame{dmat3(1.0), centre}, size);
}

void add_block(Stage& stage, const dvec3& low, const dvec3& high) {
  add_box(stage, 0.5 * (low + high), high - low);
}

void add_dish(Stage& stage, const dvec3& base, const dvec3& axis, double radius, double height, bool spherical) {
  const Frame frame = frame_along(base, axis);
  if (spherical) {
    stage.add(core::SphericalDish{mm(radius), mm(height)}, frame);
  } else {
    stage.add(core::EllipticalDish{mm(radius), mm(height)}, frame);
  }
}

void add_snout(Stage& stage, const dvec3& from, const dvec3& direction, double length, const core::dvec2& radii,
               double offset) {
  Frame frame = frame_along(from, direction);
  frame.origin += 0.5 * (length * direction + offset * frame.axes[0]);
  stage.add(core::Snout{mm(radii.x), mm(radii.y), mm(length), mm(offset), 0, 0, 0, 0, 0}, frame);
}

void add_ring(Stage& stage, const dvec3& centre, const dvec3& axis, double major, double tube) {
  const Frame half = frame_along(centre, axis);
  const Frame other{dmat3(-half.axes[0], -half.axes[1], half.axes[2]), centre};
  stage.add(core::CircularTorus{mm(major), mm(tube), kHalfTurn}, half);
  stage.add(core::CircularTorus{mm(major), mm(tube), kHalfTurn}, other);
}

void PipeRun::straight(double length) {
  const dvec3 end = at_ + length * direction_;
  add_cylinder(stage_, at_, end, radius_);
  at_ = end;
}

void PipeRun::flange(double thickness, double radius) {
  const dvec3 end = at_ + thickness * direction_;
  add_cylinder(stage_, at_, end, radius);
  at_ = end;
}

void PipeRun::turn(const dvec3& to) {
  const double along = glm::dot(direction_, to);
  const bool square = along < 0.5;
  const double cosine = square ? 0.0 : kHalfSqrt2, sine = square ? 1.0 : kHalfSqrt2;
  const dvec3 inward = (to - cosine * direction_) / sine;
  // The arc's local frame: x from the centre to the start, y along the pipe there.
  const dmat3 axes(-inward, direction_, glm::cross(-inward, direction_));
  stage_.add(core::CircularTorus{mm(bend()), mm(radius_), square ? kQuarterTurn : kEighthTurn},
             Frame{axes, at_ + bend() * inward});
  at_ += bend() * ((1.0 - cosine) * inward + sine * direction_);
  direction_ = to;
}

void PipeRun::reduce(double radius, double length, bool eccentric) {
  const double offset = eccentric ? radius - radius_ : 0.0;
  add_snout(stage_, at_, direction_, length, {radius_, radius}, offset);
  at_ += length * direction_ + offset * frame_along(at_, direction_).axes[0];
  radius_ = radius;
}

void PipeRun::cone(double from, double to, double length) {
  add_snout(stage_, at_, direction_, length, {from, to});
  at_ += length * direction_;
}

void PipeRun::cap() {
  add_dish(stage_, at_, direction_, radius_, 0.5 * radius_);
}

}  // namespace sightline::importers::plant
