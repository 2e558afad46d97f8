#include "sightline/raytrace/internal/item_boxes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "sightline/raytrace/internal/item_walk.h"
#include "sightline/raytrace/internal/packet.h"
#include "sightline/raytrace/internal/tracer_impl.h"

namespace sightline::raytrace {
namespace {

/// The entry of a ray into a box that it meets; else, or where it begins within, false.
bool enter_box(const core::AabbD& box, const core::Ray& ray, double from, ItemBoxes::Entry& entry) {
  double in = -kInfinity, out = kInfinity;
  int side = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    if (d == 0.0) {
      if (o < box.min[axis] || o > box.max[axis]) return false;
      continue;
    }
    double near = (box.min[axis] - o) / d, far = (box.max[axis] - o) / d;
    if (near > far) std::swap(near, far);
    if (near > in) in = near, side = axis;
    if (far < out) out = far;
  }
  if (!(in >= from && in <= out)) return false;
  entry.t = in;
  entry.normal = dvec3(0.0);
  entry.normal[side] = ray.direction[side] > 0.0 ? -1.0 : 1.0;
  return true;
}

constexpr double kLost = 1e-14;  // of the numbers of which a distance is made, more than what it is rounded by

}  // namespace

Beam::Beam(const std::array<core::Ray, 4>& corners)
    : corner_(corners[0]), parallel_(corners[0].origin != corners[2].origin) {
  const dvec3 within =
      0.5 * (corners[0].origin + corners[0].direction) + 0.5 * (corners[2].origin + corners[2].direction);
  for (std::size_t i = 0; i < 4; ++i) {
    const core::Ray &a = corners[i], &b = corners[(i + 1) % 4];
    const dvec3 across = glm::cross(a.direction, (b.origin - a.origin) + b.direction);
    sides_[i] = {across, -glm::dot(across, a.origin)};
    if (core::evaluate(sides_[i], within) < 0.0) sides_[i] = {-sides_[i].normal, -sides_[i].offset};
  }
}

bool Beam::may_meet(const core::AabbD& box) const {
  for (const core::Plane& side : sides_) {
    double most = side.offset, size = std::fabs(side.offset);
    for (int axis = 0; axis < 3; ++axis) {
      const double product = side.normal[axis] * (side.normal[axis] > 0.0 ? box.max : box.min)[axis];
      most += product;
      size += std::fabs(product);
    }
    if (most < -1e-14 * size) return false;
  }
  return true;
}

double Beam::first(const core::AabbD& box) const {
  double t = 0.0;
  if (parallel_)
    for (int axis = 0; axis < 3; ++axis)
      t += corner_.direction[axis] * ((corner_.direction[axis] > 0.0 ? box.min : box.max)[axis] - corner_.origin[axis]);
  else
    t = glm::length(glm::max(glm::max(box.min - corner_.origin, corner_.origin - box.max), dvec3(0.0)));
  const dvec3 size = magnitude(corner_.origin) + glm::max(magnitude(box.min), magnitude(box.max));
  t -= kLost * (t + size.x + size.y + size.z);
  return t > 0.0 ? t : -kInfinity;
}

void ItemBoxes::look_into(const WideNode& node, const Beam& beam, std::vector<Ahead>& ahead) const {
  const auto& b = node.bounds;
  for (int lane = 0; lane < kLanes && node.children[lane] != core::kNone; ++lane) {
    const core::AabbD box{bounds_.origin + dvec3(b[0][lane], b[1][lane], b[2][lane]),
                          bounds_.origin + dvec3(b[3][lane], b[4][lane], b[5][lane])};
    if (!beam.may_meet(box)) continue;
    ahead.push_back({beam.first(box), node.children[lane]});
    std::push_heap(ahead.begin(), ahead.end());
  }
}

void ItemBoxes::find(const core::Ray& ray, const std::function<void(Slot)>& visit) const {
  RayFilter all;
  all.layers = ~0u;
  walk_items({items_, bounds_, ray, ray.t_min, ray.t_max, all}, [&](Slot slot) {
    visit(slot);
    return ray.t_max;
  });
}

ItemBoxes::Entry ItemBoxes::nearest(const core::Ray& ray, const RayFilter& filter) const {
  Entry found;
  const KeptParts parts = kept_parts(ray, filter);
  for (int i = 0; i < parts.count && found.slot == core::kNone; ++i) {
    const KeptPart& part = parts.part[std::size_t(i)];
    found.t = part.to;
    walk_items({items_, bounds_, ray, part.from, part.to, filter}, [&](Slot slot) {
      const core::Aabb box = bounds_.box(slot);
      Entry entry{slot};
      if (enter_box({bounds_.origin + dvec3(box.min), bounds_.origin + dvec3(box.max)}, ray, part.from, entry) &&
          (entry.t < found.t || (entry.t == found.t && slot < found.slot)))
        found = entry;
      return found.t;
    });
  }
  return found;
}

/// Sixteen rays on their way, as Tracer::Impl::Packet is.
class ItemBoxes::Packet : PacketVisitor {
 public:
  Packet(const ItemBoxes& boxes, const RayFilter& filter) : boxes_(boxes), filter_(filter), kernels_(packet_kernels()) {
    visit = [](PacketVisitor& base, std::uint32_t slot, const unsigned* who) {
      static_cast<Packet&>(base).meet(Slot(slot), *who);
    };
    for (int axis = 0; axis < 3; ++axis) map_.shift[0][axis] = boxes.bounds_.origin[axis];
  }

  /// Takes kPacket rays at most.
  void trace(std::span<const core::Ray> rays, std::span<Entry> entries) {
    const unsigned good = kernels_.load(&rays[0].origin.x, int(rays.size()), world_);
    for (int i = 0; i < kPacket; ++i) best_.t[i] = world_.to[i], best_.slot[i] = kNoSlot;
    for (const ItemTrees::Tree& tree : boxes_.items_.trees()) {
      std::memcpy(world_.to, best_.t, sizeof world_.to);
      const LaneSpace space = lanes_of(tree.space, boxes_.bounds_.origin);
      if (const unsigned entered = kernels_.enter(world_, good, space, frame_))
        kernels_.walk(boxes_.items_.nodes(), tree.root, frame_, entered, *this);
    }
    for (std::size_t i = 0; i < rays.size(); ++i)
      entries[i] = {best_.slot[i], best_.t[i], {best_.normal[0][i], best_.normal[1][i], best_.normal[2][i]}};
  }

 private:
  void meet(Slot slot, unsigned who) {
    if (filter_.passes(slot)) return;
    const core::Aabb box = boxes_.bounds_.box(slot);
    SolidShape shape;
    for (int axis = 0; axis < 3; ++axis) {
      map_.shift[1][axis] = 0.5 * (double(box.min[axis]) + double(box.max[axis]));
      shape.size[axis] = 0.5 * (double(box.max[axis]) - double(box.min[axis]));
    }
    if ((shape.size[0] == 0.0) + (shape.size[1] == 0.0) + (shape.size[2] == 0.0) > 1) return;
    who &= ~within(shape);
    if (who != 0 && kernels_.solid(shape, map_, world_, who, slot, best_) != 0) kernels_.shorten(best_.t, frame_);
  }
  /// The rays that begin in the box.
  unsigned within(const SolidShape& shape) const {
    unsigned rays = 0;
    for (int i = 0; i < kPacket; ++i) {
      bool in = true;
      for (int axis = 0; axis < 3; ++axis)
        in &= std::fabs((world_.origin[axis][i] - map_.shift[0][axis]) - map_.shift[1][axis]) <= shape.size[axis];
      rays |= unsigned(in) << i;
    }
    return rays;
  }

  const ItemBoxes& boxes_;
  const RayFilter& filter_;
  const PacketKernels& kernels_;
  LaneMap map_{{}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.0, 1.0, true};
  RayLanes world_;
  NearestLanes best_;
  PacketFrame frame_;
};

void ItemBoxes::nearest(std::span<const core::Ray> rays, const RayFilter& filter, std::span<Entry> entries) const {
  if (!filter.sections.empty()) {
    std::transform(rays.begin(), rays.end(), entries.begin(),
                   [&](const core::Ray& ray) { return nearest(ray, filter); });
    return;
  }
  Packet packet(*this, filter);
  for (std::size_t first = 0; first < rays.size(); first += kPacket) {
    const std::size_t count = std::min(rays.size() - first, std::size_t(kPacket));
    packet.trace(rays.subspan(first, count), entries.subspan(first, count));
  }
}

}  // namespace sightline::raytrace
