// The nearest hits of many rays: Tracer::Impl::nearest() for packets, with the same answers bit for bit.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "sightline/core/internal/intrinsics.h"
#include "sightline/gpuprims/internal/dome.h"
#include "sightline/raytrace/internal/packet.h"
#include "sightline/raytrace/internal/tracer_impl.h"

namespace sightline::raytrace {
/// How packets meet a solid: ray by ray, by vectors of rays, or never, since it has no surface.
enum class PacketForm { kSingle, kVectors, kNothing };

namespace {

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

static_assert(kNoSlot == core::kNone);

void set_sweep(float parameter, Sweep& sweep) {
  const double angle = core::sweep_angle(parameter), c = std::cos(0.5 * angle), s = std::sin(0.5 * angle);
  sweep.whole = angle == core::kFullTurn;
  sweep.convex = angle <= std::numbers::pi;
  sweep.flat = angle == 0.0;
  sweep.needs_chord = sweep.convex && !(angle > 0.01 && angle < 3.13);
  sweep.middle[0] = c, sweep.middle[1] = s;
  sweep.end[0] = (c - s) * (c + s), sweep.end[1] = 2.0 * s * c;
}

/// The conditions are those of the reference intersectors.
PacketForm shape_of(Kind kind, const float* parameters, SolidShape& shape) {
  double p[5];
  double sum = 0.0;
  const int count = std::min(5, core::parameter_count(kind));
  for (int i = 0; i < count; ++i) sum += p[i] = std::fabs(double(parameters[i]));
  const auto takes = [&](SolidShape::Kind as, double x, double y, double z = 0.0) {
    shape.kind = as;
    shape.size[0] = x, shape.size[1] = y, shape.size[2] = z;
    return PacketForm::kVectors;
  };
  const auto disc = [&](double radius) {
    return radius > 0.0 ? takes(SolidShape::kCylinder, radius, 0.0) : PacketForm::kNothing;
  };
  if (!std::isfinite(sum)) return PacketForm::kNothing;
  switch (kind) {
    case Kind::kCylinder:
      return p[0] > 0.0 ? takes(SolidShape::kCylinder, p[0], 0.5 * p[1]) : PacketForm::kNothing;
    case Kind::kBox:
      if ((p[0] == 0.0) + (p[1] == 0.0) + (p[2] == 0.0) > 1) return PacketForm::kNothing;
      return takes(SolidShape::kBox, 0.5 * p[0], 0.5 * p[1], 0.5 * p[2]);
    case Kind::kSphere:
      shape.whole = true;
      return p[0] > 0.0 ? takes(SolidShape::kDome, 0.5 * p[0], 0.5 * p[0], 0.5 * p[0]) : PacketForm::kNothing;
    case Kind::kEllipticalDish:
      if (!(p[0] > 0.0) || p[1] <= gpuprims::kFlatDome * p[0]) return disc(p[0]);
      return takes(SolidShape::kDome, p[0], p[0], p[1]);
    case Kind::kSphericalDish:
      if (p[1] <= gpuprims::kFlatDome * p[0]) return disc(p[0]);
      return takes(SolidShape::kDome, p[0], p[1], p[1]);
    case Kind::kSnout:
      for (int i = 5; i < 9; ++i)
        if (parameters[i] != 0.0f) return PacketForm::kSingle;  // slanted, or not finite
      if (p[2] == 0.0) return PacketForm::kSingle;
      shape.offset[0] = double(parameters[3]), shape.offset[1] = double(parameters[4]);
      return std::max(p[0], p[1]) > 0.0 ? takes(SolidShape::kSnout, p[0], p[1], p[2]) : PacketForm::kNothing;
    case Kind::kRectangularTorus:
      set_sweep(parameters[3], shape.sweep);
      return std::max(p[0], p[1]) > 0.0
                 ? takes(SolidShape::kRectangularTorus, std::min(p[0], p[1]), std::max(p[0], p[1]), 0.5 * p[2])
                 : PacketForm::kNothing;
    case Kind::kCircularTorus:
      set_sweep(parameters[2], shape.sweep);
      return p[1] > 0.0 ? takes(SolidShape::kCircularTorus, p[0], p[1]) : PacketForm::kNothing;
    default:
      return PacketForm::kSingle;
  }
}

/// At most two: one by one is faster.
bool few(unsigned rays) {
  rays &= rays - 1;
  return (rays & (rays - 1)) == 0;
}

}  // namespace

/// A solid and its placement, for the rays of several packets.
struct PreparedSolid {
  Slot slot = core::kNone;
  PacketForm form = PacketForm::kSingle;
  SolidShape shape;
  LaneMap map;
};

/// A packet on its way through the items.
class Tracer::Impl::Packet {
 public:
  /// `any`: rays stop at the first hit that is found.
  Packet(const Impl& impl, const RayFilter& filter, PreparedSolid& prepared, bool any = false)
      : impl_(impl), filter_(filter), kernels_(packet_kernels()), prepared_(prepared), any_(any) {}

  /// Takes at most kPacket rays. Returns the first one that is none, or their number.
  std::size_t load(std::span<const Ray> rays) {
    static_assert(sizeof(Ray) == 8 * sizeof(double));
    const int count = int(rays.size());
    all_ = (1u << count) - 1;
    rays_ = rays;
    const unsigned good = kernels_.load(&rays[0].origin.x, count, world_);
    return good == all_ ? rays.size() : std::size_t(lowest(~good));
  }

  std::span<const Ray> rays() const { return rays_; }

  /// The nearest hits of packets without sections. Answer: Hit or FirstHit.
  template <class Answer>
  static void nearest(std::span<Packet* const> packets, std::span<Answer> hits) {
    for (Packet* const packet : packets) packet->start();
    walk(packets);
    for (Packet* const packet : packets) {
      packet->finish(packet->all_, hits.first(packet->rays_.size()));
      hits = hits.subspan(packet->rays_.size());
    }
  }

  /// Whether rays hit anything, without sections.
  static void any(std::span<Packet* const> packets, std::span<bool> hit) {
    for (Packet* const packet : packets) packet->start();
    walk(packets);
    for (const Packet* const packet : packets) {
      for (std::size_t i = 0; i < packet->rays_.size(); ++i) hit[i] = packet->best_.slot[i] != kNoSlot;
      hit = hit.subspan(packet->rays_.size());
    }
  }

 private:
  void start() {
    for (int i = 0; i < kPacket; ++i) best_.t[i] = world_.to[i], best_.slot[i] = kNoSlot;
  }

  /// The lanes whose nearest hit so far is with this item; kNone: that have none.
  unsigned rays_with(Slot slot) const {
    unsigned rays = 0;
    for (int i = 0; i < kPacket; ++i) rays |= unsigned(best_.slot[i] == slot) << i;
    return rays;
  }

  /// Writes the hits of all rays.
  void finish(unsigned, std::span<FirstHit> hits) const {
    for (std::size_t i = 0; i < hits.size(); ++i) hits[i] = {best_.slot[i], best_.t[i]};
  }

  /// Writes hits. Returns the rays that have none.
  unsigned finish(unsigned rays, std::span<Hit> hits) {
    const unsigned missing = rays & rays_with(core::kNone);
    for (unsigned rest = missing; rest != 0; rest &= rest - 1) hits[std::size_t(lowest(rest))].slot = core::kNone;
    unsigned hit = rays & ~missing;
    while (hit != 0) {
      const Slot slot = best_.slot[lowest(hit)];
      const unsigned same = rays_with(slot);
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
      kernels_.normals(mesh->blocks.data(), best_.place, rays, normals);
    else
      std::memcpy(normals, best_.normal, sizeof normals);
    kernels_.turn(columns, map.determinant < 0.0, normals);
    double points[3][kPacket];
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < kPacket; ++i)
        points[axis][i] = world_.origin[axis][i] + best_.t[i] * world_.direction[axis][i];
    const core::ItemId item = impl_.snapshot_->item(slot);
    for (; rays != 0; rays &= rays - 1) {
      const int ray = lowest(rays);
      hits[std::size_t(ray)] = {slot,
                                item,
                                best_.t[ray],
                                {points[0][ray], points[1][ray], points[2][ray]},
                                {normals[0][ray], normals[1][ray], normals[2][ray]},
                                mesh ? mesh->triangle(best_.place[ray]) : core::kNone,
                                mesh ? Face::kTriangle : Face(int(best_.face[ray]))};
    }
  }

  /// The nearest hit of a ray so far, with those numbers set that its kind has.
  Found found(int ray) const {
    const Slot slot = best_.slot[ray];
    if (slot == kNoSlot) return {best_.t[ray], slot};
    if (is_mesh(impl_.snapshot_->kind(slot))) return {best_.t[ray], slot, best_.place[ray]};
    return {best_.t[ray],
            slot,
            core::kNone,
            {best_.normal[0][ray], best_.normal[1][ray], best_.normal[2][ray]},
            Face(int(best_.face[ray]))};
  }

  static void walk(std::span<Packet* const> packets) {
    const Packet& any = *packets[0];
    const core::ItemBounds& bounds = any.impl_.snapshot_->bounds();
    const WideNode* const nodes = any.impl_.items_.nodes();
    for (const ItemTrees::Tree& tree : any.impl_.items_.trees()) {
      if (tree.only != core::kNone) {
        for (Packet* const packet : packets) {
          packet->walking_ = false;
          if (tree.space.radius < 0.0) continue;
          const LaneSpace space = lanes_of(tree.space, bounds.origin);
          if (const unsigned near = any.kernels_.near(packet->world_, packet->all_, space))
            packet->meet(tree.only, near);
        }
        continue;
      }
      Visitor visitor;
      PacketPart parts[kTogether];
      int count = 0;
      for (Packet* const packet : packets) {
        std::memcpy(packet->world_.to, packet->best_.t, sizeof packet->world_.to);
        packet->walking_ = true;
        const unsigned entered =
            any.kernels_.enter(packet->world_, packet->all_, lanes_of(tree.space, bounds.origin), packet->frame_);
        if (entered == 0) continue;
        visitor.packets[count] = packet;
        parts[count++] = {&packet->frame_, entered};
      }
      visitor.count = count;
      if (count > 1 && any.kernels_.walk_as_one(nodes, tree.root, parts, count, visitor)) continue;
      visitor.count = 1;
      for (int i = 0; i < count; ++i) {
        visitor.packets[0] = visitor.packets[i];
        any.kernels_.walk(nodes, tree.root, *parts[i].frame, parts[i].rays, visitor);
      }
    }
  }
  struct Visitor : PacketVisitor {
    Packet* packets[kTogether];
    int count;
    Visitor() {
      visit = [](PacketVisitor& base, std::uint32_t slot, const unsigned* rays) {
        const auto& self = static_cast<const Visitor&>(base);
        for (int i = 0; i < self.count; ++i)
          if (rays[i] != 0) self.packets[i]->meet(Slot(slot), rays[i]);
      };
    }
  };

  void meet(Slot slot, unsigned who) {
    if ((impl_.snapshot_->bounds().layers(slot) & filter_.layers) == 0 || filter_.passes(slot)) return;
    if ((who & (who - 1)) != 0) {
      if (is_mesh(impl_.snapshot_->kind(slot))) return meet_mesh(slot, who);
      if (meet_solid(slot, who)) return;
    }
    for (; who != 0; who &= who - 1) meet_alone(slot, lowest(who));
  }

  void meet_alone(Slot slot, int ray) {
    Found nearer = found(ray);
    if (!impl_.nearest_of(slot, rays_[std::size_t(ray)], world_.from[ray], nearer)) return;
    for (int axis = 0; axis < 3; ++axis) best_.normal[axis][ray] = nearer.normal[axis];
    take(ray, nearer.t, slot, nearer.place, nearer.face);
  }

  /// False: the placement is singular.
  bool map_of(Slot slot, double scale, LaneMap& out) const {
    const core::Placement& placement = impl_.placement(slot);
    const Cofactors map(placement.linear);
    out.inverse = 1.0 / map.determinant;
    if (!(std::fabs(out.inverse) < kInfinity) || out.inverse == 0.0) return false;
    const dvec3& chunk = impl_.snapshot_->chunk_origins()[placement.chunk];
    for (int axis = 0; axis < 3; ++axis) {
      out.shift[0][axis] = chunk[axis];
      out.shift[1][axis] = double(placement.origin[axis]);
      for (int i = 0; i < 3; ++i) out.column[axis][i] = map.column[axis][i];
    }
    out.scale = scale;
    out.moves_only = is_unity(placement.linear);
    return true;
  }

  void prepare(Slot slot) const {
    prepared_.slot = slot;
    prepared_.shape = {};
    prepared_.form = shape_of(impl_.snapshot_->kind(slot), impl_.parameters(slot), prepared_.shape);
    if (prepared_.form == PacketForm::kVectors && !map_of(slot, 1.0, prepared_.map))
      prepared_.form = PacketForm::kNothing;
  }

  /// nearest_of() for the kinds that have a form for packets.
  bool meet_solid(Slot slot, unsigned who) {
    if (prepared_.slot != slot) prepare(slot);
    if (prepared_.form != PacketForm::kVectors) return prepared_.form == PacketForm::kNothing;
    unsigned taken = kernels_.solid(prepared_.shape, prepared_.map, world_, who, slot, best_);
    if (any_)
      for (; taken != 0; taken &= taken - 1) stop(lowest(taken));
    else if (taken != 0 && walking_)
      kernels_.shorten(best_.t, frame_);
    return true;
  }

  void take(int ray, double t, Slot slot, std::uint32_t place, Face face) {
    best_.t[ray] = t;
    best_.slot[ray] = slot;
    best_.place[ray] = place;
    best_.face[ray] = double(face);
    any_ ? stop(ray) : shorten(ray);
  }

  /// Nothing is of interest to a ray from now on.
  void stop(int ray) {
    best_.t[ray] = -kInfinity;
    if (walking_) frame_.limit[ray] = -1.0f;
  }

  /// Nothing beyond the hit is of interest from now on.
  void shorten(int ray) {
    if (!walking_) return;
    const float limit = frame_limit(best_.t[ray] * frame_.per_factor[ray], frame_.begin[ray], frame_.margin);
    frame_.limit[ray] = std::min(frame_.limit[ray], std::max(0.0f, limit));
  }

  /// nearest_of() and nearest_triangle().
  void meet_mesh(Slot slot, unsigned who) {
    const MeshTree& tree = *impl_.meshes_[impl_.mesh_index(slot)];
    RayLanes local;
    LaneMap map;
    if (tree.empty || !map_of(slot, tree.per_unit, map)) return;
    kernels_.to_item(world_, map, local);
    for (int i = 0; i < kPacket; ++i) local.to[i] = best_.t[i];
    struct Filter : PacketFilter {
      PacketFrame frame;
      const MeshTree* tree;
      const RayLanes* parts;
      double s(const RayFrame& of_ray, std::uint32_t place) const {
        dvec3 corners[3];
        tree->corners(place, corners);
        return crossing(of_ray, corners);
      }
      double t(int ray, std::uint32_t place) const {
        const RayFrame of_ray = ray_frame(frame, ray);
        return of_ray.t(s(of_ray, place));
      }
    } filter;
    who = kernels_.enter(local, who, lanes_of(tree.space, dvec3(0.0)), filter.frame);
    if (who == 0) return;
    filter.crossed = [](const PacketFilter& base, int ray, std::uint32_t place) {
      const auto& self = static_cast<const Filter&>(base);
      const RayFrame of_ray = ray_frame(self.frame, ray);
      const double s = self.s(of_ray, place), t = of_ray.t(s);
      return t >= self.parts->from[ray] && t <= self.parts->to[ray] ? float(s) : kNotCrossed;
    };
    filter.tree = &tree;
    filter.parts = &local;
    PacketHits hits;
    for (int i = 0; i < kPacket; ++i) {
      hits.t[i] = std::numeric_limits<float>::infinity();
      hits.lost[i] = 0.0f;
      hits.triangle[i] = kNoTriangle;
    }
    kernels_.nearest({tree.nodes.data(), tree.blocks.data(), tree.root, float(2.0 * filter.frame.margin),
                      float(filter.frame.margin * (kBoxError / kMargin)), &filter},
                     who, filter.frame, hits);
    for (unsigned rest = who; rest != 0; rest &= rest - 1)
      if (hits.triangle[lowest(rest)] == kNoTriangle) who &= ~(1u << lowest(rest));
    alignas(64) double crossed[kPacket];
    const unsigned by_itself =
        few(who) ? who : kernels_.crossings(filter.frame, tree.blocks.data(), hits, who, crossed);
    for (; who != 0; who &= who - 1) {
      const int ray = lowest(who);
      const double t = (by_itself >> ray & 1u) != 0 ? filter.t(ray, hits.place[ray]) : crossed[ray];
      if (!(t >= local.from[ray] && t <= local.to[ray])) {
        meet_alone(slot, ray);  // float has taken one beyond an end
        continue;
      }
      if (t < best_.t[ray] || (t == best_.t[ray] && slot < best_.slot[ray]))
        take(ray, t, slot, hits.place[ray], Face::kTriangle);
    }
  }

  const Impl& impl_;
  const RayFilter& filter_;
  const PacketKernels& kernels_;
  PreparedSolid& prepared_;
  std::span<const Ray> rays_;
  unsigned all_ = 0;
  RayLanes world_;     // of load()
  NearestLanes best_;  // of start()
  bool any_;
  bool walking_ = false;  // through the items' hierarchy, with
  PacketFrame frame_;
};

/// Calls answer(packets, first ray, rays) for the rays of some packets at a time. Returns the first ray that is none,
/// or their number.
template <class Answer>
std::size_t Tracer::Impl::by_packets(std::span<const Ray> rays, const RayFilter& filter, bool any,
                                     const Answer& answer) const {
  PreparedSolid prepared;
  Packet packets[kTogether] = {{*this, filter, prepared, any},
                               {*this, filter, prepared, any},
                               {*this, filter, prepared, any},
                               {*this, filter, prepared, any}};
  // Packets that walk nothing together only push one another out of the cache.
  const auto single = [](const ItemTrees::Tree& tree) { return tree.only != core::kNone; };
  const std::size_t most = std::all_of(items_.trees().begin(), items_.trees().end(), single) ? 1 : kTogether;
  for (std::size_t first = 0; first < rays.size();) {
    Packet* loaded[kTogether];
    std::size_t end = first, count = 0;
    for (; count < most && end < rays.size(); ++count) {
      const auto these = rays.subspan(end, std::min(std::size_t(kPacket), rays.size() - end));
      for (std::size_t i = end + (most + 1) * kPacket; i < std::min(end + (most + 2) * kPacket, rays.size()); ++i)
        core::prefetch_line<core::CacheLevel::kL1>(&rays[i]);
      const std::size_t good = packets[count].load(these);
      if (good != these.size()) return end + good;
      loaded[count] = &packets[count];
      end += these.size();
    }
    answer(std::span<Packet* const>(loaded, count), first, end - first);
    first = end;
  }
  return rays.size();
}

namespace {

void set(Hit& to, const std::optional<Hit>& hit) {
  to = hit.value_or(Hit());
}
void set(FirstHit& to, const std::optional<Hit>& hit) {
  to = hit ? FirstHit{hit->slot, hit->t} : FirstHit();
}

/// Calls answer(i) for rays that sections cut. Planes are moved for each item by itself, which packets do not do.
/// Returns the first ray that is none, or their number.
template <class Answer>
std::size_t one_by_one(std::span<const Ray> rays, const Answer& answer) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!is_ray(rays[i])) return i;
    answer(i);
  }
  return rays.size();
}

}  // namespace

template <class Answer>
std::size_t Tracer::Impl::nearest(std::span<const Ray> rays, const RayFilter& filter, std::span<Answer> hits) const {
  if (filter.sections.empty())
    return by_packets(rays, filter, false, [&](std::span<Packet* const> packets, std::size_t first, std::size_t count) {
      Packet::nearest(packets, hits.subspan(first, count));
    });
  return one_by_one(rays, [&](std::size_t i) {
    std::optional<Hit> hit;
    nearest_kept(rays[i], filter, hit);
    set(hits[i], hit);
  });
}

template std::size_t Tracer::Impl::nearest(std::span<const Ray>, const RayFilter&, std::span<Hit>) const;
template std::size_t Tracer::Impl::nearest(std::span<const Ray>, const RayFilter&, std::span<FirstHit>) const;

std::size_t Tracer::Impl::any(std::span<const Ray> rays, const RayFilter& filter, std::span<bool> hit) const {
  if (filter.sections.empty())
    return by_packets(rays, filter, true, [&](std::span<Packet* const> packets, std::size_t first, std::size_t count) {
      Packet::any(packets, hit.subspan(first, count));
    });
  return one_by_one(rays, [&](std::size_t i) { hit[i] = any(rays[i], filter); });
}

}  // namespace sightline::raytrace
