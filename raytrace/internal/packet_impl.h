// Internal: the packet kernels' common part. Form has lanes for a whole packet (Form::Wide) besides those of
// kernels_impl.h.
#pragma once

#include "sightline/raytrace/internal/kernels_impl.h"
#include "sightline/raytrace/internal/packet.h"
#include "sightline/raytrace/internal/packet_solids.h"

namespace sightline::raytrace {
namespace {

inline bool at_most_one(unsigned rays) {
  return (rays & (rays - 1)) == 0;
}

inline double size_of(double a) {
  return __builtin_fabs(a);
}
inline double root(double a) {
  return __builtin_sqrt(a);
}

// The loops that follow go over all rays, so that the compiler vectorises them.

/// As is_ray() of tracer.cpp.
template <class Form>
unsigned load_lanes(const double* rays, int count, RayLanes& out) {
  double* const columns[] = {out.origin[0],    out.origin[1],    out.origin[2], out.direction[0],
                             out.direction[1], out.direction[2], out.from,      out.to};
  if (count == kPacket) {
    for (int first = 0; first < kPacket; first += 8) Form::transpose(rays + 8 * first, columns, first);
  } else {
    for (int i = 0; i < kPacket; ++i)
      for (int column = 0; column < 8; ++column) columns[column][i] = rays[8 * (i < count ? i : count - 1) + column];
  }
  using Wide = typename Form::Wide;
  alignas(64) float doubt[kPacket];  // 0: none
  for (int i = 0; i < kPacket; ++i) {
    const double ox = out.origin[0][i], oy = out.origin[1][i], oz = out.origin[2][i];
    const double dx = out.direction[0][i], dy = out.direction[1][i], dz = out.direction[2][i];
    const double not_finite = ((0.0 * ox + 0.0 * oy) + 0.0 * oz) + ((0.0 * dx + 0.0 * dy) + 0.0 * dz);
    const double without = larger(size_of(dx), larger(size_of(dy), size_of(dz))) > 0.0 ? 0.0 : 1.0;
    const double from = out.from[i] == out.from[i] ? 0.0 : 1.0, to = out.to[i] == out.to[i] ? 0.0 : 1.0;
    doubt[i] = float(((not_finite + without) + from) + to);
  }
  return equal(Wide::load(doubt), Wide::spread(0.0f)) & ((1u << count) - 1);
}

inline void lanes_to_item(const RayLanes& rays, const LaneMap& m, RayLanes& out) {
  double o[3][kPacket];
  for (int axis = 0; axis < 3; ++axis) {
    const double first = m.shift[0][axis], second = m.shift[1][axis];
    for (int i = 0; i < kPacket; ++i) o[axis][i] = (rays.origin[axis][i] - first) - second;
  }
  for (int i = 0; i < kPacket; ++i) out.from[i] = rays.from[i], out.to[i] = rays.to[i];
  if (m.moves_only) {
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < kPacket; ++i) {
        out.origin[axis][i] = m.scale * (o[axis][i] + 0.0);  // what the map would give: -0 becomes 0
        out.direction[axis][i] = m.scale * (rays.direction[axis][i] + 0.0);
      }
    return;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double x = m.column[axis][0], y = m.column[axis][1], z = m.column[axis][2];
    for (int i = 0; i < kPacket; ++i) {
      const double at = (x * o[0][i] + y * o[1][i]) + z * o[2][i];
      const double along = (x * rays.direction[0][i] + y * rays.direction[1][i]) + z * rays.direction[2][i];
      out.origin[axis][i] = m.scale * (m.inverse * at);
      out.direction[axis][i] = m.scale * (m.inverse * along);
    }
  }
}

/// The power of two in (x / 2, x], and 1 / that.
inline void powers_of_two(const double* x, double* power, double* inverse) {
  union Bits {
    double value[kPacket];
    std::uint64_t bits[kPacket];
  } in, up, down;
  for (int i = 0; i < kPacket; ++i) in.value[i] = x[i];
  for (int i = 0; i < kPacket; ++i) up.bits[i] = in.bits[i] & std::uint64_t(kExponent);
  for (int i = 0; i < kPacket; ++i) down.bits[i] = std::uint64_t(kOneOver) - (in.bits[i] & std::uint64_t(kExponent));
  for (int i = 0; i < kPacket; ++i) power[i] = up.value[i];
  for (int i = 0; i < kPacket; ++i) inverse[i] = down.value[i];
}

/// ray_frame.h, passes_by(), with the same roundings.
template <class Form>
unsigned near_lanes(const RayLanes& rays, unsigned wanted, const LaneSpace& space) {
  using Wide = typename Form::Wide;
  alignas(64) float passes[kPacket];
  const double lost_at_least = 2.0 * kBoxError * space.reach;
  const double middle_x = space.centre[0], middle_y = space.centre[1], middle_z = space.centre[2];
  const double shift_x = space.shift[0], shift_y = space.shift[1], shift_z = space.shift[2];
  const double half_x = space.half[0], half_y = space.half[1], half_z = space.half[2];
  for (int i = 0; i < kPacket; ++i) {
    const double dx = rays.direction[0][i], dy = rays.direction[1][i], dz = rays.direction[2][i];
    const double cx = middle_x - (rays.origin[0][i] - shift_x), cy = middle_y - (rays.origin[1][i] - shift_y);
    const double cz = middle_z - (rays.origin[2][i] - shift_z);
    const double lost = 1e-15 * ((size_of(cx) + size_of(cy)) + size_of(cz)) + lost_at_least;
    const double hx = half_x + lost, hy = half_y + lost, hz = half_z + lost;
    const double sx = size_of(dx), sy = size_of(dy), sz = size_of(dz);
    const double over_x = size_of(cy * dz - dy * cz) > hy * sz + hz * sy ? 1.0 : 0.0;
    const double over_y = size_of(cz * dx - dz * cx) > hz * sx + hx * sz ? 1.0 : over_x;
    passes[i] = float(size_of(cx * dy - dx * cy) > hx * sy + hy * sx ? 1.0 : over_y);
  }
  return wanted & equal(Wide::load(passes), Wide::spread(0.0f));
}

/// ray_frame.h, enter(), with the same roundings.
template <class Form>
unsigned enter_lanes(const RayLanes& rays, unsigned wanted, const LaneSpace& space, PacketFrame& f) {
  using Wide = typename Form::Wide;
  if (space.radius < 0.0) return 0;
  alignas(64) double longest[kPacket], last[kPacket];
  alignas(64) float missed[kPacket], largest[kPacket], d[3][kPacket];
  for (int i = 0; i < kPacket; ++i)
    longest[i] =
        larger(size_of(rays.direction[0][i]), larger(size_of(rays.direction[1][i]), size_of(rays.direction[2][i])));
  powers_of_two(longest, f.per_factor, f.factor);
  const double margin = f.margin = kMargin * space.reach, radius_least = space.radius;
  const double lost_at_least = 2.0 * kBoxError * space.reach, near = kNear * space.radius;
  const double middle_x = space.centre[0], middle_y = space.centre[1], middle_z = space.centre[2];
  const double shift_x = space.shift[0], shift_y = space.shift[1], shift_z = space.shift[2];
  for (int i = 0; i < kPacket; ++i) {
    const double factor = f.factor[i], per_factor = f.per_factor[i];
    const double dx = factor * rays.direction[0][i], dy = factor * rays.direction[1][i];
    const double dz = factor * rays.direction[2][i];
    const double ox = rays.origin[0][i] - shift_x, oy = rays.origin[1][i] - shift_y, oz = rays.origin[2][i] - shift_z;
    const double cx = middle_x - ox, cy = middle_y - oy, cz = middle_z - oz;
    const double square = (dx * dx + dy * dy) + dz * dz, closest = ((cx * dx + cy * dy) + cz * dz) / square;
    const double x = cy * dz - dy * cz, y = cz * dx - dz * cx, z = cx * dy - dx * cy;
    const double away_x = size_of(cx), away_y = size_of(cy), away_z = size_of(cz);
    const double radius = (radius_least + 1e-15 * ((away_x + away_y) + away_z)) + lost_at_least;
    const double from = rays.from[i] * per_factor, to = rays.to[i] * per_factor;
    const bool stays = larger(larger(away_x, away_y), larger(away_z, kNear * size_of(from))) <= near;
    const double first = stays ? from : larger(from, closest - radius);
    last[i] = stays ? to : smaller(to, closest + radius);
    const double begin = first - margin;
    const double aside = (x * x + y * y) + z * z <= radius * radius * square ? 0.0 : 1.0, far = stays ? 0.0 : aside;
    const double over = first <= last[i] ? far : 1.0, without = longest[i] > 0.0 ? over : 1.0;
    missed[i] = float(without);
    f.begin[i] = begin;
    f.direction[0][i] = dx, f.direction[1][i] = dy, f.direction[2][i] = dz;
    f.origin[0][i] = ox + begin * dx, f.origin[1][i] = oy + begin * dy, f.origin[2][i] = oz + begin * dz;
    const double sx = size_of(dx), sy = size_of(dy), sz = size_of(dz);
    const double not_z = sy >= sx ? 1.0 : 0.0, z_or_x = sz >= sx ? 2.0 : not_z, axis = sz >= sy ? z_or_x : not_z;
    largest[i] = float(axis);
  }
  const Wide zero = Wide::spread(0.0f);
  const unsigned entered = wanted & equal(Wide::load(missed), zero);
  if (entered == 0) return 0;

  for (int i = 0; i < kPacket; ++i) {
    const double s = (last[i] - f.begin[i]) * (1.0 + 0x1p-20) + margin;
    f.limit[i] = s < 1e38 ? float(s) : std::numeric_limits<float>::infinity();
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kPacket; ++i) d[axis][i] = float(f.direction[axis][i]);
    for (int i = 0; i < kPacket; ++i) f.start[axis][i] = float(f.origin[axis][i]);
  }
  const Wide error = Wide::spread(float(kBoxError * space.reach)), one = Wide::spread(1.0f);
  for (int axis = 0; axis < 3; ++axis) {
    const Wide along = Wide::load(d[axis]), o = Wide::load(f.start[axis]);
    const Wide e = with_signs(error, along);
    const Wide inverse = with_signs(one / most(magnitude(along), Wide::spread(kLeastDirection)), along);
    (o + e).store(f.near_origin[axis]);
    (o - e).store(f.far_origin[axis]);
    (inverse * Wide::spread(kDown)).store(f.near_scale[axis]);
    (inverse * Wide::spread(kUp)).store(f.far_scale[axis]);
    f.back[axis] = signs(along);
    f.largest[axis] = equal(Wide::load(largest), Wide::spread(float(axis)));
  }
  return entered;
}

struct alignas(64) CornerLanes {
  double at[3][3][kPacket];  // corner, axis

  CornerLanes(const TriangleBlock* blocks, const std::uint32_t* places, unsigned rays) {
    for (int i = 0; i < kPacket; ++i) {
      if ((rays >> i & 1u) == 0) {
        for (auto& corner : at)
          for (auto& axis : corner) axis[i] = 0.0;
        continue;
      }
      const TriangleBlock& block = blocks[places[i] / kLanes];
      for (int corner = 0; corner < 3; ++corner)
        for (int axis = 0; axis < 3; ++axis)
          at[corner][axis][i] = double(block.corners[corner][axis][places[i] % kLanes]);
    }
  }
};

/// ray_frame.cpp, crossing(), with the same roundings.
template <class Form>
unsigned cross_lanes(const PacketFrame& f, const TriangleBlock* blocks, const PacketHits& hits, unsigned rays,
                     double* t) {
  const CornerLanes corners(blocks, hits.place, rays);
  unsigned outside = 0;
  for (int az = 0; az < 3; ++az) {
    const unsigned these = rays & f.largest[az];
    if (these == 0) continue;
    const int ax = (az + 1) % 3, ay = (az + 2) % 3;
    alignas(64) double answer[kPacket];
    alignas(64) float passes[kPacket];  // 0: not outside
    const double *const dx = f.direction[ax], *const dy = f.direction[ay], *const dz = f.direction[az];
    const double *const ox = f.origin[ax], *const oy = f.origin[ay], *const oz = f.origin[az];
    for (int i = 0; i < kPacket; ++i) {
      const double along = 1.0 / dz[i], shear_x = dx[i] * along, shear_y = dy[i] * along;
      const double per_square = 1.0 / ((dx[i] * dx[i] + dy[i] * dy[i]) + dz[i] * dz[i]);
      double x[3], y[3], z[3];
      for (int corner = 0; corner < 3; ++corner) {
        const double to_x = corners.at[corner][ax][i] - ox[i], to_y = corners.at[corner][ay][i] - oy[i];
        const double to_z = corners.at[corner][az][i] - oz[i];
        x[corner] = to_x - shear_x * to_z;
        y[corner] = to_y - shear_y * to_z;
        z[corner] = per_square * ((to_x * dx[i] + to_y * dy[i]) + to_z * dz[i]);
      }
      const double u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
      const double sum = (u + v) + w, s = ((u * z[0] + v * z[1]) + w * z[2]) / sum;
      const double low = smaller(u, smaller(v, w)), high = larger(u, larger(v, w));
      const double not_above = low >= 0.0 ? 0.0 : 1.0, not_inside = high <= 0.0 ? 0.0 : not_above;
      answer[i] = (f.begin[i] + s) * f.factor[i];
      passes[i] = float(sum != 0.0 ? not_inside : 1.0);
    }
    outside |= these & ~equal(Form::Wide::load(passes), Form::Wide::spread(0.0f));
    if (these == rays) {
      for (int i = 0; i < kPacket; ++i) t[i] = answer[i];
      return outside;
    }
    for (unsigned rest = these; rest != 0; rest &= rest - 1) {
      const auto ray = core::lowest_bit(rest);
      t[ray] = answer[ray];
    }
  }
  return outside;
}

inline void find_normals(const TriangleBlock* blocks, const std::uint32_t* places, unsigned rays,
                         double (*normals)[kPacket]) {
  const CornerLanes corners(blocks, places, rays);
  const auto& c = corners.at;
  double *const nx = normals[0], *const ny = normals[1], *const nz = normals[2];
  for (int i = 0; i < kPacket; ++i) {
    const double ax = c[1][0][i] - c[0][0][i], ay = c[1][1][i] - c[0][1][i], az = c[1][2][i] - c[0][2][i];
    const double bx = c[2][0][i] - c[0][0][i], by = c[2][1][i] - c[0][1][i], bz = c[2][2][i] - c[0][2][i];
    nx[i] = ay * bz - by * az, ny[i] = az * bx - bz * ax, nz[i] = ax * by - bx * ay;
  }
}

/// tracer.cpp, world_normal(), with the same roundings.
inline void turn_normals(const double (*columns)[3], bool mirrored, double (*normals)[kPacket]) {
  const double xx = columns[0][0], xy = columns[0][1], xz = columns[0][2];
  const double yx = columns[1][0], yy = columns[1][1], yz = columns[1][2];
  const double zx = columns[2][0], zy = columns[2][1], zz = columns[2][2];
  const double sign = mirrored ? -1.0 : 1.0;
  double *const nx = normals[0], *const ny = normals[1], *const nz = normals[2];
  for (int i = 0; i < kPacket; ++i) {
    const double x = nx[i], y = ny[i], z = nz[i];
    const double wx = sign * ((xx * x + yx * y) + zx * z), wy = sign * ((xy * x + yy * y) + zy * z);
    const double wz = sign * ((xz * x + yz * y) + zz * z);
    const double inverse = 1.0 / root((wx * wx + wy * wy) + wz * wz);
    nx[i] = wx * inverse, ny[i] = wy * inverse, nz[i] = wz * inverse;
  }
}

inline void shorten_limits(const double* t, PacketFrame& f) {
  const double margin = f.margin;
  for (int i = 0; i < kPacket; ++i) {
    const double s = (t[i] * f.per_factor[i] - f.begin[i]) * (1.0 + 0x1p-20) + margin;
    const float limit = s < 1e38 ? float(s) : std::numeric_limits<float>::infinity();
    const float above = 0.0f < limit ? limit : 0.0f;
    f.limit[i] = above < f.limit[i] ? above : f.limit[i];
  }
}

template <class Form>
struct Packets {
  using Wide = typename Form::Wide;

  /// Rays whose directions have the same signs, as all lanes of a box see them.
  struct Boxes {
    Wide near_origin[3], far_origin[3], near_scale[3], far_scale[3];
    int near_plane[3], far_plane[3];

    Boxes(const PacketFrame& f, int ray) {
      for (int axis = 0; axis < 3; ++axis) {
        near_origin[axis] = Wide::load(f.near_origin[axis]);
        far_origin[axis] = Wide::load(f.far_origin[axis]);
        near_scale[axis] = Wide::load(f.near_scale[axis]);
        far_scale[axis] = Wide::load(f.far_scale[axis]);
        const int shift = int(f.back[axis] >> ray & 1u) * 3;
        near_plane[axis] = axis + shift;
        far_plane[axis] = axis + 3 - shift;
      }
    }
    Wide enter(const WideNode& node, int lane, int axis) const {
      return (Wide::spread(node.bounds[near_plane[axis]][lane]) - near_origin[axis]) * near_scale[axis];
    }
    Wide leave(const WideNode& node, int lane, int axis) const {
      return (Wide::spread(node.bounds[far_plane[axis]][lane]) - far_origin[axis]) * far_scale[axis];
    }
    /// Rays that meet the box of a child. Where they enter it is stored in `t`.
    unsigned meet(const WideNode& node, int lane, const Wide& limit, float* t) const {
      const Wide in =
          most(most(enter(node, lane, 0), enter(node, lane, 1)), most(enter(node, lane, 2), Wide::spread(0.0f)));
      const Wide out = least(least(leave(node, lane, 0), leave(node, lane, 1)), least(leave(node, lane, 2), limit));
      in.store(t);
      return at_most(in, out);
    }
  };

  /// What holds of each of `rays`, whose directions have the same signs. Since rounding keeps order, no ray meets a box
  /// that the hull misses.
  static Hull hull_of(const PacketFrame& f, unsigned rays) {
    Hull hull;
    hull.limit = highest(Wide::load(f.limit), rays);
    for (int axis = 0; axis < 3; ++axis) {
      const bool back = (f.back[axis] >> lowest(rays) & 1u) != 0;
      const Wide near = Wide::load(f.near_origin[axis]), far = Wide::load(f.far_origin[axis]);
      const Wide in = Wide::load(f.near_scale[axis]), out = Wide::load(f.far_scale[axis]);
      hull.near_origin[axis] = back ? lowest_of(near, rays) : highest(near, rays);
      hull.far_origin[axis] = back ? highest(far, rays) : lowest_of(far, rays);
      hull.near_scale[0][axis] = lowest_of(in, rays), hull.near_scale[1][axis] = highest(in, rays);
      hull.far_scale[0][axis] = lowest_of(out, rays), hull.far_scale[1][axis] = highest(out, rays);
      hull.near_plane[axis] = back ? axis + 3 : axis;
      hull.far_plane[axis] = back ? axis : axis + 3;
    }
    return hull;
  }

  static BoxRay box_ray(const PacketFrame& f, int ray) {
    BoxRay r;
    for (int axis = 0; axis < 3; ++axis) {
      r.near_origin[axis] = f.near_origin[axis][ray];
      r.far_origin[axis] = f.far_origin[axis][ray];
      r.near_scale[axis] = f.near_scale[axis][ray];
      r.far_scale[axis] = f.far_scale[axis][ray];
      const int shift = int(f.back[axis] >> ray & 1u) * 3;
      r.near_plane[axis] = axis + shift;
      r.far_plane[axis] = axis + 3 - shift;
    }
    r.t_max = f.limit[ray];
    return r;
  }

  /// Walks on with one ray. Calls meet(leaf, rays), which may shrink the limit of the ray.
  template <class Meet>
  static void walk_alone(const WideNode* nodes, std::uint32_t root, const PacketFrame& f, int ray, const Meet& meet) {
    Tracing<Form>::traverse(nodes, root, box_ray(f, ray), f.limit[ray], [&](std::uint32_t leaf) {
      meet(leaf, 1u << ray);
      return false;
    });
  }

  /// Walks with rays whose directions have the same signs. Calls meet(leaf, rays).
  template <class Meet>
  static void walk_together(const WideNode* nodes, std::uint32_t root, const PacketFrame& f, unsigned rays,
                            const Meet& meet) {
    struct alignas(64) Held {
      float t[kPacket];
    };
    Held enters[kMostEntries];  // where rays enter the box
    std::uint32_t children[kMostEntries];
    unsigned met[kMostEntries];
    const Boxes boxes(f, lowest(rays));
    const Hull hull = hull_of(f, rays);
    std::uint32_t child = root;
    unsigned who = rays;
    int size = 0;
    for (;;) {
      if (at_most_one(who)) {
        walk_alone(nodes, child, f, lowest(who), meet);
      } else if ((child & kLeafBit) != 0) {
        meet(child & ~kLeafBit, who);
      } else {
        const WideNode& node = nodes[child];
        float t[kLanes];
        const unsigned near = Form::meet_hull(node, hull, t);
        if (near != 0 && at_most_one(near)) {
          const std::uint32_t only = node.children[lowest(near)];
          if ((only & kLeafBit) == 0) {  // which rays meet it shows further down
            child = only;
            continue;
          }
        }
        const Wide limit = Wide::load(f.limit);
        Held in[kLanes];
        unsigned meets[kLanes];
        Entry order[kLanes];
        int count = 0;
        for (unsigned rest = near; rest != 0; rest &= rest - 1) {
          const int lane = lowest(rest);
          meets[lane] = who & boxes.meet(node, lane, limit, in[lane].t);
          if (meets[lane] == 0) continue;
          // By the first ray that meets it.
          const Entry entry = entry_of(in[lane].t[lowest(meets[lane])], std::uint32_t(lane));
          int at = count++;
          for (; at > 0 && order[at - 1] < entry; --at) order[at] = order[at - 1];
          order[at] = entry;
        }
        if (count > 0) {
          for (int i = 0; i + 1 < count; ++i, ++size) {
            const auto lane = std::uint32_t(order[i]);
            Wide::load(in[lane].t).store(enters[size].t);
            children[size] = node.children[lane];
            met[size] = meets[lane];
          }
          const auto nearest_lane = std::uint32_t(order[count - 1]);
          child = node.children[nearest_lane];
          who = meets[nearest_lane];
          continue;
        }
      }
      const Wide limit = Wide::load(f.limit);
      do {
        if (size == 0) return;
        --size;
        who = met[size] & at_most(Wide::load(enters[size].t), limit);
      } while (who == 0);
      child = children[size];
    }
  }

  static int lowest(unsigned rays) { return int(core::lowest_bit(rays)); }

  /// Bits of those `rays` that share the signs of the first one's direction.
  static unsigned same_signs(const PacketFrame& f, unsigned rays) {
    const int first = lowest(rays);
    for (const unsigned back : f.back) rays &= (back >> first & 1u) != 0 ? back : ~back;
    return rays;
  }

  static void walk(const WideNode* nodes, std::uint32_t root, const PacketFrame& f, unsigned rays,
                   PacketVisitor& visitor) {
    while (rays != 0) {
      const unsigned same = same_signs(f, rays);
      walk_together(nodes, root, f, same,
                    [&](std::uint32_t leaf, unsigned who) { visitor.visit(visitor, leaf, &who); });
      rays &= ~same;
    }
  }

  /// False: the signs of directions differ.
  static bool hull_of_all(const PacketPart* packets, int count, Hull& hull) {
    hull = hull_of(*packets[0].frame, packets[0].rays);
    for (int i = 0; i < count; ++i) {
      const PacketFrame& f = *packets[i].frame;
      const Hull other = hull_of(f, packets[i].rays);
      hull.limit = hull.limit < other.limit ? other.limit : hull.limit;
      for (int axis = 0; axis < 3; ++axis) {
        const bool back = hull.near_plane[axis] != axis;
        if ((f.back[axis] & packets[i].rays) != (back ? packets[i].rays : 0u)) return false;
        const auto low = [](float& a, float b) { a = b < a ? b : a; };
        const auto high = [](float& a, float b) { a = a < b ? b : a; };
        (back ? low(hull.near_origin[axis], other.near_origin[axis])
              : high(hull.near_origin[axis], other.near_origin[axis]));
        (back ? high(hull.far_origin[axis], other.far_origin[axis])
              : low(hull.far_origin[axis], other.far_origin[axis]));
        low(hull.near_scale[0][axis], other.near_scale[0][axis]);
        high(hull.near_scale[1][axis], other.near_scale[1][axis]);
        low(hull.far_scale[0][axis], other.far_scale[0][axis]);
        high(hull.far_scale[1][axis], other.far_scale[1][axis]);
      }
    }
    return true;
  }

  /// Nodes are tested with the hull alone, leaves with all rays.
  static bool walk_as_one(const WideNode* nodes, std::uint32_t root, const PacketPart* packets, int count,
                          PacketVisitor& visitor) {
    Hull hull;
    if (!hull_of_all(packets, count, hull)) return false;
    int patience = 32;  // left for nodes and leaves that the hull meets in vain
    Entry stack[kMostEntries];
    int size = 0;
    Entry entry = root;
    for (;;) {
      const auto child = std::uint32_t(entry);
      bool useful = false;
      if ((child & kLeafBit) != 0) {
        const WideNode& node = nodes[(child & ~kLeafBit) / kLanes];
        const int lane = int(child % kLanes);
        unsigned who[kTogether];
        for (int i = 0; i < count; ++i) {
          const PacketFrame& f = *packets[i].frame;
          alignas(64) float t[kPacket];
          who[i] = packets[i].rays & Boxes(f, lowest(packets[i].rays)).meet(node, lane, Wide::load(f.limit), t);
          useful |= who[i] != 0;
        }
        if (useful) {
          patience += 4;
          visitor.visit(visitor, node.children[lane] & ~kLeafBit, who);
          hull.limit = 0.0f;
          for (int i = 0; i < count; ++i) {
            const float limit = highest(Wide::load(packets[i].frame->limit), packets[i].rays);
            hull.limit = hull.limit < limit ? limit : hull.limit;
          }
        }
      } else {
        const WideNode& node = nodes[child];
        float t[kLanes];
        unsigned met = Form::meet_hull(node, hull, t);
        useful = met != 0;
        Entry* const first = stack + size;
        for (; met != 0; met &= met - 1) {
          const int lane = lowest(met);
          const std::uint32_t next = node.children[lane];
          // A leaf by its place, where its box is.
          const std::uint32_t code = (next & kLeafBit) != 0 ? kLeafBit | (child * kLanes + std::uint32_t(lane)) : next;
          const Entry added = entry_of(t[lane], code);
          Entry* place = stack + size++;
          for (; place > first && place[-1] < added; --place) *place = place[-1];
          *place = added;
        }
      }
      if (!useful && --patience < 0) return false;
      do {
        if (size == 0) return true;
        entry = stack[--size];
      } while (t_of(entry) > hull.limit);
    }
  }

  // --- triangles -----------------------------------------------------------------------------------------------------

  /// What TriangleRay holds, of rays whose directions share the largest axis.
  struct Shears {
    int axes[3];
    alignas(64) float shear[3][kPacket];

    Shears(const PacketFrame& f, int largest) : axes{(largest + 1) % 3, (largest + 2) % 3, largest} {
      alignas(64) double along[kPacket], x[kPacket], y[kPacket];
      const double *const dx = f.direction[axes[0]], *const dy = f.direction[axes[1]], *const dz = f.direction[largest];
      for (int i = 0; i < kPacket; ++i) along[i] = 1.0 / dz[i];
      for (int i = 0; i < kPacket; ++i) x[i] = dx[i] * along[i];
      for (int i = 0; i < kPacket; ++i) y[i] = dy[i] * along[i];
      for (int i = 0; i < kPacket; ++i) shear[0][i] = float(x[i]);
      for (int i = 0; i < kPacket; ++i) shear[1][i] = float(y[i]);
      for (int i = 0; i < kPacket; ++i) shear[2][i] = float(along[i]);
    }
    TriangleRay of(const PacketFrame& f, int ray) const {
      return {{axes[0], axes[1], axes[2]},
              {f.start[axes[0]][ray], f.start[axes[1]][ray], f.start[axes[2]][ray]},
              {shear[0][ray], shear[1][ray], shear[2][ray]}};
    }
  };

  /// Takes a hit unless there is a nearer one.
  static void take(const PacketQuery& query, PacketFrame& f, PacketHits& hits, int ray, TriangleHit found) {
    TriangleHit best{hits.t[ray], hits.lost[ray], hits.triangle[ray], hits.place[ray]};
    if (is_nearer(found, best, query.t_sure, f.limit[ray],
                  [&](std::uint32_t place) { return query.filter->crossed(*query.filter, ray, place); }))
      best = found;
    hits.t[ray] = best.t;
    hits.lost[ray] = best.lost;
    hits.triangle[ray] = best.triangle;
    hits.place[ray] = best.place;
    if (best.t + best.lost < f.limit[ray]) f.limit[ray] = best.t + best.lost;
  }

  /// One ray and all triangles of a block.
  static void meet_block(const PacketQuery& query, PacketFrame& f, const Shears& shears, PacketHits& hits,
                         std::uint32_t index, int ray) {
    const TriangleBlock& block = query.blocks[index];
    typename Form::Areas areas;
    unsigned hit, unsure;
    Form::shear(shears.of(f, ray), block, areas, hit, unsure);
    if ((hit | unsure) == 0) return;
    float t[kLanes], lost[kLanes];
    unsure |= hit & Form::distances(areas, query.across, t, lost);
    hit &= ~unsure;
    for (; unsure != 0; unsure &= unsure - 1) {
      const unsigned lane = core::lowest_bit(unsure);
      Sheared corners;
      Form::corners(areas, lane, corners);
      if (hit_exactly(corners, t[lane])) hit |= 1u << lane;
    }
    for (; hit != 0; hit &= hit - 1) {
      const unsigned lane = core::lowest_bit(hit);
      take(query, f, hits, ray, {t[lane], lost[lane], block.triangles[lane], index * kLanes + lane});
    }
  }

  /// All rays, whose directions share the largest axis, and the triangles of a block in turn: Form::shear() for rays in
  /// lanes.
  static void meet_block_together(const PacketQuery& query, PacketFrame& f, const Shears& shears, PacketHits& hits,
                                  std::uint32_t index, unsigned rays) {
    const TriangleBlock& block = query.blocks[index];
    const int ax = shears.axes[0], ay = shears.axes[1], az = shears.axes[2];
    const Wide ox = Wide::load(f.start[ax]), oy = Wide::load(f.start[ay]), oz = Wide::load(f.start[az]);
    const Wide sx = Wide::load(shears.shear[0]), sy = Wide::load(shears.shear[1]), sz = Wide::load(shears.shear[2]);
    const Wide zero = Wide::spread(0.0f);
    for (std::uint32_t lane = 0; lane < kLanes && block.triangles[lane] != kNoTriangle; ++lane) {
      Wide x[3], y[3], z[3];
      for (int corner = 0; corner < 3; ++corner) {
        const float(*place)[kLanes] = block.corners[corner];
        z[corner] = Wide::spread(place[az][lane]) - oz;
        x[corner] = (Wide::spread(place[ax][lane]) - ox) - sx * z[corner];
        y[corner] = (Wide::spread(place[ay][lane]) - oy) - sy * z[corner];
      }
      const Wide u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
      const Wide low = least(least(u, v), w), high = most(most(u, v), w);
      unsigned hit = rays & (less(zero, low) | less(high, zero));
      unsigned unsure = rays & (equal(low, zero) | equal(high, zero));
      if ((hit | unsure) == 0) continue;
      alignas(64) float t[kPacket], lost[kPacket];
      for (Wide& along : z) along = sz * along;
      const Wide sum = (u + v) + w;
      (((u * z[0] + v * z[1]) + w * z[2]) / sum).store(t);
      const Wide wide = extent(x), tall = extent(y), size = wide + tall, off = Wide::spread(query.across);
      const Wide area = most(magnitude(sum) - Wide::spread(kAreaLost * query.across) * size, zero);
      (off + off * ((Wide::spread(kSlope) * range(z)) * size / area)).store(lost);
      unsure |= hit & less(magnitude(sum), Wide::spread(kSlim) * (wide * tall));
      hit &= ~unsure;
      for (; unsure != 0; unsure &= unsure - 1) {
        const int ray = lowest(unsure);
        Sheared corners;
        for (int corner = 0; corner < 3; ++corner) {
          alignas(64) float of_ray[3][kPacket];
          x[corner].store(of_ray[0]), y[corner].store(of_ray[1]), z[corner].store(of_ray[2]);
          corners.x[corner] = of_ray[0][ray], corners.y[corner] = of_ray[1][ray], corners.z[corner] = of_ray[2][ray];
        }
        if (hit_exactly(corners, t[ray])) hit |= 1u << ray;
      }
      for (; hit != 0; hit &= hit - 1) {
        const int ray = lowest(hit);
        take(query, f, hits, ray, {t[ray], lost[ray], block.triangles[lane], index * kLanes + lane});
      }
    }
  }

  static void nearest(const PacketQuery& query, unsigned rays, PacketFrame& f, PacketHits& hits) {
    for (int axis = 0; axis < 3; ++axis) {
      unsigned left = rays & f.largest[axis];
      if (left == 0) continue;
      const Shears shears(f, axis);
      while (left != 0) {
        const unsigned same = same_signs(f, left);
        walk_together(query.nodes, query.root, f, same, [&](std::uint32_t block, unsigned who) {
          if (!at_most_one(who & (who - 1))) return meet_block_together(query, f, shears, hits, block, who);
          for (; who != 0; who &= who - 1) meet_block(query, f, shears, hits, block, lowest(who));
        });
        left &= ~same;
      }
    }
  }
};

template <class Form>
constexpr PacketKernels make_packet_kernels() {
  return {load_lanes<Form>,           lanes_to_item,          near_lanes<Form>,  enter_lanes<Form>, Packets<Form>::walk,
          Packets<Form>::walk_as_one, Packets<Form>::nearest, cross_lanes<Form>, find_normals,      turn_normals,
          Solids<Form>::nearest,      shorten_limits};
}
}  // namespace
}  // namespace sightline::raytrace
