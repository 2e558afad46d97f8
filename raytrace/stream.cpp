// The nearest hits of many rays: Tracer::Impl::nearest() for packets, with the same answers bit for bit.
#include <algorithm>
#include <bit>
#include <cstring>

#include "sightline/core/internal/intrinsics.h"
#include "sightline/raytrace/internal/packet.h"
#include "sightline/raytrace/internal/tracer_impl.h"

namespace sightline::raytrace {
namespace {

LaneSpace lanes_of(const TreeSpace& space, const dvec3& shift) {
  return {{shift.x, shift.y, shift.z}, {space.centre.x, space.centre.y, space.centre.z}, space.radius, space.reach};
}

RayFrame ray_frame(const PacketFrame& f, int ray) {
  RayFrame frame;
  frame.origin = {f.origin[0][ray], f.origin[1][ray], f.origin[2][ray]};
  frame.direction = {f.direction[0][ray], f.direction[1][ray], f.direction[2][ray]};
  frame.begin = f.begin[ray];
  frame.factor = f.factor[ray];
  frame.per_factor = f.per_factor[ray];
  frame.margin = f.margin;
  return frame;
}

static_assert(int(Face::kMinX) == kBoxFaces[0] && int(Face::kMinY) == kBoxFaces[1] &&
              int(Face::kBottom) == kBoxFaces[2]);

int lowest(unsigned rays) {
  return std::countr_zero(rays);
}

/// At most two: one by one is faster.
bool few(unsigned rays) {
  rays &= rays - 1;
  return (rays & (rays - 1)) == 0;
}

}  // namespace

/// A packet on its way through the items.
class Tracer::Impl::Packet {
 public:
  Packet(const Impl& impl, const RayFilter& filter) : impl_(impl), filter_(filter), kernels_(packet_kernels()) {}

  /// At most kPacket rays. Returns the first one that is none, or their number.
  std::size_t nearest(std::span<const Ray> rays, std::span<Hit> hits) {
    static_assert(sizeof(Ray) == 8 * sizeof(double));
    const int count = int(rays.size());
    const unsigned all = (1u << count) - 1, good = kernels_.load(&rays[0].origin.x, count, world_);
    if (good != all) return std::size_t(lowest(~good));
    rays_ = rays;
    if (filter_.sections.empty()) {
      find(all, hits);
      return rays.size();
    }
    KeptParts parts[kPacket];
    for (int i = 0; i < count; ++i) parts[i] = kept_parts(rays[std::size_t(i)], filter_);
    for (Hit& hit : hits) hit.slot = core::kNone;
    unsigned left = all;
    for (std::size_t part = 0; part < 2 && left != 0; ++part) {
      for (int i = 0; i < count; ++i) {
        if (int(part) >= parts[i].count) {
          left &= ~(1u << i);
          continue;
        }
        if ((left >> i & 1u) == 0) continue;
        const Ray& ray = rays[std::size_t(i)];
        const double from = parts[i].part[part].first;
        const core::Plane* const plane = parts[i].cut[part];
        if (const Slot cut = impl_.cut_at(ray, from, plane, filter_); cut != core::kNone) {
          hits[std::size_t(i)] = impl_.cut_hit(ray, from, *plane, cut);
          left &= ~(1u << i);
          continue;
        }
        world_.from[i] = from;
        world_.to[i] = parts[i].part[part].second;
      }
      if (left != 0) left = find(left, hits);
    }
    return rays.size();
  }

 private:
  /// Returns those that hit nothing.
  unsigned find(unsigned rays, std::span<Hit> hits) {
    for (int i = 0; i < kPacket; ++i) t_[i] = world_.to[i], slot_[i] = core::kNone;
    walk(rays);
    unsigned missing = 0, hit = 0;
    for (; rays != 0; rays &= rays - 1) {
      const int ray = lowest(rays);
      (slot_[ray] == core::kNone ? missing : hit) |= 1u << ray;
      hits[std::size_t(ray)].slot = core::kNone;
    }
    while (hit != 0) {
      const Slot slot = slot_[lowest(hit)];
      unsigned same = 0;
      for (int i = 0; i < kPacket; ++i) same |= unsigned(slot_[i] == slot) << i;
      finish(slot, same & hit, hits);
      hit &= ~same;
    }
    return missing;
  }

  void finish(Slot slot, unsigned rays, std::span<Hit> hits) {
    if (few(rays)) {
      for (; rays != 0; rays &= rays - 1) {
        const auto ray = std::size_t(lowest(rays));
        hits[ray] = impl_.finish(rays_[ray], found(int(ray)));
      }
      return;
    }
    const MeshTree* const mesh =
        is_mesh(impl_.snapshot_->kind(slot)) ? impl_.meshes_[impl_.mesh_index(slot)].get() : nullptr;
    const Cofactors map(impl_.placement(slot).linear);
    double columns[3][3], normals[3][kPacket];
    for (int i = 0; i < 3; ++i)
      for (int axis = 0; axis < 3; ++axis) columns[i][axis] = map.column[i][axis];
    if (mesh)
      kernels_.normals(mesh->blocks.data(), place_, rays, normals);
    else
      std::memcpy(normals, normal_, sizeof normals);
    kernels_.turn(columns, map.determinant < 0.0, normals);
    for (; rays != 0; rays &= rays - 1) {
      const int ray = lowest(rays);
      hits[std::size_t(ray)] =
          impl_.answer(rays_[std::size_t(ray)], found(ray), mesh ? mesh->triangle(place_[ray]) : core::kNone,
                       {normals[0][ray], normals[1][ray], normals[2][ray]});
    }
  }

  Found found(int ray) const {
    return {t_[ray], slot_[ray], place_[ray], {normal_[0][ray], normal_[1][ray], normal_[2][ray]}, face_[ray]};
  }

  void walk(unsigned rays) {
    struct Visitor : PacketVisitor {
      Packet* packet;
    } visitor;
    visitor.visit = [](PacketVisitor& base, std::uint32_t slot, unsigned who) {
      static_cast<Visitor&>(base).packet->meet(Slot(slot), who);
    };
    visitor.packet = this;
    const core::ItemBounds& bounds = impl_.snapshot_->bounds();
    for (const ItemTrees::Tree& tree : impl_.items_.trees()) {
      if (tree.only != core::kNone) {
        walking_ = false;
        if (tree.space.radius >= 0.0) meet(tree.only, rays);
        continue;
      }
      for (int i = 0; i < kPacket; ++i) world_.to[i] = t_[i];
      const unsigned entered = kernels_.enter(world_, rays, lanes_of(tree.space, bounds.origin), frame_);
      walking_ = true;
      if (entered != 0) kernels_.walk(impl_.items_.nodes(), tree.root, frame_, entered, visitor);
    }
  }

  void meet(Slot slot, unsigned who) {
    if ((impl_.snapshot_->bounds().layers(slot) & filter_.layers) == 0) return;
    if ((who & (who - 1)) != 0) {
      if (is_mesh(impl_.snapshot_->kind(slot))) return meet_mesh(slot, who);
      if (meet_solid(slot, who)) return;
    }
    for (; who != 0; who &= who - 1) meet_alone(slot, lowest(who));
  }

  void meet_alone(Slot slot, int ray) {
    Found nearer = found(ray);
    if (!impl_.nearest_of(slot, rays_[std::size_t(ray)], world_.from[ray], nearer)) return;
    for (int axis = 0; axis < 3; ++axis) normal_[axis][ray] = nearer.normal[axis];
    take(ray, nearer.t, slot, nearer.place, nearer.face);
  }

  /// The rays in an item's coordinates. False: its placement is singular.
  bool to_item(Slot slot, double scale, RayLanes& local) const {
    const core::Placement& placement = impl_.placement(slot);
    const Cofactors map(placement.linear);
    const double inverse = 1.0 / map.determinant;
    if (!(std::fabs(inverse) < kInfinity) || inverse == 0.0) return false;
    LaneMap lane_map;
    const dvec3& chunk = impl_.snapshot_->chunk_origins()[placement.chunk];
    for (int axis = 0; axis < 3; ++axis) {
      lane_map.shift[0][axis] = chunk[axis];
      lane_map.shift[1][axis] = double(placement.origin[axis]);
      for (int i = 0; i < 3; ++i) lane_map.column[axis][i] = map.column[axis][i];
    }
    lane_map.inverse = inverse;
    lane_map.scale = scale;
    kernels_.to_item(world_, lane_map, local);
    return true;
  }

  /// nearest_of() for the kinds that have a form for packets. `who` keeps the rays that are left to do.
  bool meet_solid(Slot slot, unsigned& who) {
    const Kind kind = impl_.snapshot_->kind(slot);
    const float* const parameters = impl_.parameters(slot);
    RayLanes local;
    SolidLanes crossings;
    if (kind == Kind::kCylinder) {
      const double radius = std::fabs(parameters[0]), half = 0.5 * std::fabs(parameters[1]);
      if (!(radius > 0.0 && std::isfinite(radius + half)) || !to_item(slot, 1.0, local)) return true;
      kernels_.cylinder(local, radius, half, crossings);
    } else if (kind == Kind::kBox) {
      double half[3];
      for (int axis = 0; axis < 3; ++axis) half[axis] = 0.5 * std::fabs(double(parameters[axis]));
      const int flat = (half[0] == 0.0) + (half[1] == 0.0) + (half[2] == 0.0);
      if (flat > 1 || !std::isfinite(half[0] + half[1] + half[2]) || !to_item(slot, 1.0, local)) return true;
      kernels_.box(local, half, crossings);
    } else if (kind == Kind::kCircularTorus) {
      return !may_meet_torus(slot, parameters, who);
    } else {
      return false;
    }
    for (; who != 0; who &= who - 1) {
      const int ray = lowest(who);
      const double t = crossings.t[ray];
      if (!(t < t_[ray] || (t == t_[ray] && slot < slot_[ray])) || t == kInfinity) continue;
      for (int axis = 0; axis < 3; ++axis) normal_[axis][ray] = crossings.normal[axis][ray];
      take(ray, t, slot, core::kNone, Face(int(crossings.face[ray])));
    }
    return true;
  }

  /// Removes rays that miss the cylinder about a torus. False: none is left.
  bool may_meet_torus(Slot slot, const float* parameters, unsigned& who) const {
    constexpr double kMore = 1.0 + 1e-6;
    core::CircularTorus torus;
    std::memcpy(&torus, parameters, sizeof torus);
    const double tube = std::fabs(double(torus.tube_radius)) * kMore,
                 radius = (std::fabs(double(torus.major_radius)) + tube) * kMore;
    if (!(radius > 0.0 && std::isfinite(radius))) return true;
    RayLanes local;
    if (!to_item(slot, 1.0, local)) return false;
    for (double& from : local.from) from = -kInfinity;
    SolidLanes crossings;
    kernels_.cylinder(local, radius, tube, crossings);
    for (unsigned rest = who; rest != 0; rest &= rest - 1)
      if (crossings.t[lowest(rest)] == kInfinity) who &= ~(1u << lowest(rest));
    return who != 0;
  }

  void take(int ray, double t, Slot slot, std::uint32_t place, Face face) {
    t_[ray] = t;
    slot_[ray] = slot;
    place_[ray] = place;
    face_[ray] = face;
    shorten(ray);
  }

  /// Nothing beyond the hit is of interest from now on.
  void shorten(int ray) {
    if (!walking_) return;
    const float limit = frame_limit(t_[ray] * frame_.per_factor[ray], frame_.begin[ray], frame_.margin);
    frame_.limit[ray] = std::min(frame_.limit[ray], std::max(0.0f, limit));
  }

  /// nearest_of() and nearest_triangle().
  void meet_mesh(Slot slot, unsigned who) {
    const MeshTree& tree = *impl_.meshes_[impl_.mesh_index(slot)];
    RayLanes local;
    if (tree.empty || !to_item(slot, tree.per_unit, local)) return;
    for (int i = 0; i < kPacket; ++i) local.to[i] = t_[i];
    struct Filter : PacketFilter {
      PacketFrame frame;
      const MeshTree* tree;
      const RayLanes* parts;
      double crossed(int ray, std::uint32_t place) const {
        dvec3 corners[3];
        tree->corners(place, corners);
        const RayFrame of_ray = ray_frame(frame, ray);
        return of_ray.t(crossing(of_ray, corners));
      }
    } filter;
    who = kernels_.enter(local, who, lanes_of(tree.space, dvec3(0.0)), filter.frame);
    if (who == 0) return;
    filter.accept = [](const PacketFilter& base, int ray, std::uint32_t place) {
      const auto& self = static_cast<const Filter&>(base);
      const double crossed = self.crossed(ray, place);
      return crossed >= self.parts->from[ray] && crossed <= self.parts->to[ray];
    };
    filter.tree = &tree;
    filter.parts = &local;
    PacketHits hits;
    for (int i = 0; i < kPacket; ++i) {
      hits.t[i] = std::numeric_limits<float>::infinity();
      hits.triangle[i] = kNoTriangle;
    }
    kernels_.nearest({tree.nodes.data(), tree.blocks.data(), tree.root, float(2.0 * filter.frame.margin), &filter}, who,
                     filter.frame, hits);
    for (unsigned rest = who; rest != 0; rest &= rest - 1)
      if (hits.triangle[lowest(rest)] == kNoTriangle) who &= ~(1u << lowest(rest));
    alignas(64) double crossed[kPacket];
    const unsigned by_itself =
        few(who) ? who : kernels_.crossings(filter.frame, tree.blocks.data(), hits, who, crossed);
    for (; who != 0; who &= who - 1) {
      const int ray = lowest(who);
      const double t = (by_itself >> ray & 1u) != 0 ? filter.crossed(ray, hits.place[ray]) : crossed[ray];
      if (!(t >= local.from[ray] && t <= local.to[ray])) {
        meet_alone(slot, ray);  // float has taken one beyond an end
        continue;
      }
      if (t < t_[ray] || (t == t_[ray] && slot < slot_[ray])) take(ray, t, slot, hits.place[ray], Face::kTriangle);
    }
  }

  const Impl& impl_;
  const RayFilter& filter_;
  const PacketKernels& kernels_;
  std::span<const Ray> rays_;
  RayLanes world_{};
  double t_[kPacket] = {};  // Found, of each ray
  Slot slot_[kPacket] = {};
  std::uint32_t place_[kPacket] = {};
  Face face_[kPacket] = {};
  double normal_[3][kPacket] = {};  // of solids
  bool walking_ = false;            // through the items' hierarchy, with
  PacketFrame frame_;
};

std::size_t Tracer::Impl::nearest(std::span<const Ray> rays, const RayFilter& filter, std::span<Hit> hits) const {
  Packet packet(*this, filter);
  for (std::size_t first = 0; first < rays.size(); first += kPacket) {
    const std::size_t count = std::min(std::size_t(kPacket), rays.size() - first);
    for (std::size_t i = first + 2 * kPacket; i < std::min(first + 3 * kPacket, rays.size()); ++i)
      core::prefetch_line<core::CacheLevel::kL1>(&rays[i]);
    const std::size_t done = packet.nearest(rays.subspan(first, count), hits.subspan(first, count));
    if (done != count) return first + done;
  }
  return rays.size();
}

}  // namespace sightline::raytrace
