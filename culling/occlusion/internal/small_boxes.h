// Internal: boxes of few pixels against the rays of all these pixels, sixteen boxes at a time. See ray_spans.h for
// what is compared; here a lane is a box, in unoccluded_blocks() it is a block of pixels.
//
// Rounding, beside what ray_spans.h says: a face's place relative to the eye, or to the rays' start, and the
// reciprocal are computed in float. Each is off by a few units of its own size, since the eye is known in twice the
// digits of float. So are the products with D. Together that is below 2^-20 of the sizes of D's terms.
#pragma once

#include "sightline/core/internal/intrinsics.h"
#include "sightline/culling/occlusion/internal/kernels.h"

namespace sightline::culling {

/// Keys of sixteen faces, linear in the place in the image.
template <class Simd>
struct FaceKeys {
  using Lanes = typename Simd::Lanes;
  Lanes at(const Lanes& x, const Lanes& y) const {
    return Simd::add(Simd::add(constant, Simd::multiply(per_y, y)), Simd::multiply(per_x, x));
  }
  Lanes constant, per_x, per_y;
};

/// Where sixteen boxes lie along the rays: BoxSpan of each.
template <class Simd>
class SmallBoxSpans {
 public:
  using Lanes = typename Simd::Lanes;

  SmallBoxSpans(const RayField& rays, const SmallBoxes& boxes, float snap) {
    for (int axis = 0; axis < 3; ++axis)
      rays.parallel ? cross_parallel(rays, boxes, axis, snap) : cross(rays, boxes, axis, snap);
    judged_ &= bounded_;
  }
  /// Bit i: something is known of box i.
  unsigned judged() const { return judged_; }

  /// The least key of near faces, and the greatest of far ones.
  Lanes entry(const Lanes& x, const Lanes& y) const {
    return Simd::least(Simd::least(near_[0].at(x, y), near_[1].at(x, y)), near_[2].at(x, y));
  }
  Lanes exit(const Lanes& x, const Lanes& y) const {
    Lanes most = Simd::most(Simd::most(far_[0].at(x, y), far_[1].at(x, y)), far_[2].at(x, y));
    for (int axis = 0; axis < 3; ++axis)
      if (between_[axis] != 0) most = Simd::most(most, beside_[axis].at(x, y));
    return most;
  }

 private:
  static constexpr float kLargestKey = 1e30f, kAlong = 1e-3f;
  static constexpr unsigned kAll = 0xffffu;

  /// A box's faces, from `start`, apart by what may be lost of them.
  struct Faces {
    Faces(const RayField& rays, const SmallBoxes& boxes, int axis, float start, float rest) {
      const Lanes a = Simd::load(boxes.coordinates[axis]), b = Simd::load(boxes.coordinates[axis + 3]);
      const Lanes sizes = Simd::most(Simd::magnitude(a), Simd::magnitude(b));
      const Lanes grown =
          Simd::add(Simd::add(Simd::spread(0x1p-18f + rays.grown[axis]), Simd::multiply(Simd::spread(0x1p-22f), sizes)),
                    Simd::multiply(Simd::spread(0x1p-20f), Simd::subtract(b, a)));
      const auto from_start = [&](const Lanes& at) {
        return Simd::subtract(Simd::subtract(at, Simd::spread(start)), Simd::spread(rest));
      };
      low = Simd::subtract(from_start(a), grown);
      high = Simd::add(from_start(b), grown);
    }
    Lanes low, high;
  };

  /// per_metre * (constant + x * per_x + y * per_y), made larger (sign 1) or smaller by all that is lost.
  static FaceKeys<Simd> keys(const Lanes& per_metre, const Lanes& constant, const RayField& rays, int axis, float snap,
                             float sign) {
    const auto size = [](float a) { return a < 0.0f ? -a : a; };
    const float error = 1.00001f * (rays.error[axis] + snap * (size(rays.per_x[axis]) + size(rays.per_y[axis])));
    const Lanes c = Simd::multiply(per_metre, constant);
    const Lanes lost = Simd::add(Simd::multiply(Simd::magnitude(per_metre), Simd::spread(error)),
                                 Simd::multiply(Simd::spread(0x1p-20f), Simd::magnitude(c)));
    return {Simd::add(c, Simd::multiply(Simd::spread(sign), lost)),
            Simd::multiply(per_metre, Simd::spread(rays.per_x[axis])),
            Simd::multiply(per_metre, Simd::spread(rays.per_y[axis]))};
  }
  static FaceKeys<Simd> none(float sign) {
    return {Simd::spread(sign * kLargestKey), Simd::spread(0.0f), Simd::spread(0.0f)};
  }
  static FaceKeys<Simd> choose(unsigned bits, const FaceKeys<Simd>& a, const FaceKeys<Simd>& b) {
    return {Simd::choose(bits, a.constant, b.constant), Simd::choose(bits, a.per_x, b.per_x),
            Simd::choose(bits, a.per_y, b.per_y)};
  }
  static unsigned bounded(const FaceKeys<Simd>& keys) {
    return Simd::less(Simd::magnitude(keys.constant), Simd::spread(kLargestKey));
  }

  /// Rays from the eye. Where that is between two faces, none is near.
  void cross(const RayField& rays, const SmallBoxes& boxes, int axis, float snap) {
    const Lanes one = Simd::spread(1.0f), none_at = Simd::spread(0.0f), constant = Simd::spread(rays.constant[axis]);
    const Faces faces(rays, boxes, axis, rays.from[axis], rays.from_rest[axis]);
    const Lanes tiny = Simd::multiply(Simd::spread(1e-9f), Simd::subtract(faces.high, faces.low));
    const unsigned beyond = Simd::less(tiny, faces.low);
    const unsigned before = Simd::less(faces.high, Simd::subtract(none_at, tiny));
    const auto of_face = [&](const Lanes& face, float sign) {
      return keys(Simd::divide(one, face), constant, rays, axis, snap, sign);
    };
    const Lanes first = Simd::choose(beyond, faces.low, faces.high), last = Simd::choose(beyond, faces.high, faces.low);
    const unsigned outside = beyond | before;
    near_[axis] = of_face(first, 1.0f);
    far_[axis] = of_face(last, -1.0f);
    between_[axis] = ~outside & kAll;
    if (between_[axis] != 0) {
      // A face so near to the eye bounds nothing.
      const unsigned last_known = Simd::less(tiny, Simd::magnitude(last)),
                     first_known = Simd::less(tiny, Simd::magnitude(first));
      near_[axis] = choose(outside, near_[axis], none(1.0f));
      far_[axis] = choose(last_known, far_[axis], none(-1.0f));
      beside_[axis] = choose(first_known & ~outside, of_face(first, -1.0f), none(-1.0f));
      bounded_ &= (bounded(beside_[axis]) | ~first_known | outside) & (bounded(far_[axis]) | ~last_known);
      bounded_ &= bounded(near_[axis]) | ~outside;
    } else {
      bounded_ &= bounded(near_[axis]) & bounded(far_[axis]);
    }
    judged_ |= outside;
  }

  /// Along a direction that leaves one slab aside, the rectangle bounds the box.
  void cross_parallel(const RayField& rays, const SmallBoxes& boxes, int axis, float snap) {
    const float along = rays.along[axis];
    between_[axis] = 0;
    if (-kAlong < along && along < kAlong) {
      near_[axis] = none(1.0f);
      far_[axis] = none(-1.0f);
      return;
    }
    const Lanes per_metre = Simd::spread(1.0f / along), zero = Simd::spread(0.0f);
    const Faces faces(rays, boxes, axis, rays.constant[axis], rays.constant_rest[axis]);
    const Lanes &first = along > 0.0f ? faces.low : faces.high, &last = along > 0.0f ? faces.high : faces.low;
    near_[axis] = keys(per_metre, Simd::subtract(zero, first), rays, axis, snap, 1.0f);
    far_[axis] = keys(per_metre, Simd::subtract(zero, last), rays, axis, snap, -1.0f);
    bounded_ &= bounded(near_[axis]) & bounded(far_[axis]);
    judged_ = kAll;
  }

  FaceKeys<Simd> near_[3], far_[3], beside_[3];  // beside: the other far face of boxes with the eye between two faces
  unsigned between_[3];
  unsigned judged_ = 0, bounded_ = kAll;
};

/// Distances less their margins.
template <class Simd>
typename Simd::Lanes in_front(const typename Simd::Lanes& distance, const DistanceMargin& margin) {
  return Simd::subtract(distance, Simd::add(Simd::multiply(Simd::spread(margin.share), Simd::magnitude(distance)),
                                            Simd::spread(margin.metres)));
}

template <class Simd>
void note_entries(unsigned met, const typename Simd::Lanes& x, const typename Simd::Lanes& y,
                  const typename Simd::Lanes& distance, PixelEntries& entries) {
  alignas(64) float at_x[kLanes], at_y[kLanes], distances[kLanes];
  Simd::store(at_x, x);
  Simd::store(at_y, y);
  Simd::store(distances, distance);
  for (; met != 0; met &= met - 1) {
    const int box = int(core::lowest_bit(met));
    entries.of[entries.count++] = {box, int(at_x[box]), int(at_y[box]), distances[box]};
  }
}

/// OcclusionKernels::unoccluded_boxes. `entries` gets the pixels and distances at which rays enter the boxes of which
/// something is known.
template <class Simd>
unsigned unoccluded_boxes(const RayField& rays, const SmallBoxes& boxes, float snap, const PyramidBlocks& pyramid,
                          const DistanceMargin& margin, PixelEntries* entries) {
  using Lanes = typename Simd::Lanes;
  const SmallBoxSpans<Simd> spans(rays, boxes, snap);
  const unsigned used = (1u << boxes.count) - 1u;
  const unsigned judged = spans.judged() & used;
  if (entries) entries->judged = judged, entries->count = 0;
  const Lanes one = Simd::spread(1.0f), left = Simd::load(boxes.left), right = Simd::load(boxes.right);
  const Lanes top = Simd::load(boxes.top);
  Lanes x = left, y = Simd::load(boxes.bottom);
  unsigned unoccluded = 0, left_over = judged;
  while (left_over != 0) {
    const Lanes entry = spans.entry(x, y);
    const Lanes distance = rays.parallel ? Simd::subtract(Simd::spread(0.0f), entry) : Simd::divide(one, entry);
    unsigned met = Simd::at_most(spans.exit(x, y), entry) & left_over;
    if (pyramid.farthest) {
      const typename Simd::Places pixel =
          Simd::plus(Simd::place_below(x), Simd::times(Simd::place_below(y), Simd::spread_place(pyramid.widths[0])));
      met &= ~Simd::less(Simd::look_up(pyramid.farthest, pixel), in_front<Simd>(distance, margin));
    }
    unoccluded |= met;
    if (entries)
      note_entries<Simd>(met, x, y, distance, *entries);
    else
      left_over &= ~met;
    const Lanes next = Simd::add(x, one);
    const unsigned row_ends = Simd::less(right, next);
    x = Simd::choose(row_ends, left, next);
    y = Simd::choose(row_ends, Simd::add(y, one), y);
    left_over &= Simd::at_most(y, top);
    y = Simd::least(y, top);
  }
  return unoccluded | (used & ~judged);
}

}  // namespace sightline::culling
