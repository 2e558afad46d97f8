// Internal: eight rays side by side against one solid, with the steps and roundings of the reference intersectors in
// gpuprims. The packet kernels' part; Form::Eight has eight doubles, Form::Mask a bit for each.
#pragma once

#include "sightline/raytrace/internal/kernels_impl.h"
#include "sightline/raytrace/internal/packet.h"

namespace sightline::raytrace {
namespace {

inline double larger(double a, double b) {
  return a < b ? b : a;
}
inline double smaller(double a, double b) {
  return b < a ? b : a;
}

constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kTiny = 1024.0 * std::numeric_limits<double>::min();  // squares below have underflowed

// Parts of doubles as whole numbers: the exponent, and that of 1; of their upper half: 2^32 / 3, and two thirds of the
// exponent of 1.
constexpr std::int64_t kExponent = 0x7ff0000000000000, kOneOver = 0x7fe0000000000000;
constexpr std::int64_t kThird = 0x55555556, kTwoThirds = 715094163;

union DoubleBits {
  double value;
  std::uint64_t bits;
};
/// The power of two in (x / 2, x], and 1 / that.
inline double power_of_two(double x) {
  DoubleBits u;
  u.value = x;
  u.bits &= std::uint64_t(kExponent);
  return u.value;
}
inline double inverse_power_of_two(double x) {
  DoubleBits u;
  u.value = x;
  u.bits = std::uint64_t(kOneOver) - (u.bits & std::uint64_t(kExponent));
  return u.value;
}
inline double weight_of(double a, double b) {
  const double ratio = a / larger(b, 1e-12 * a);
  return ratio * ratio;
}

template <class Form>
struct Solids {
  using Eight = typename Form::Eight;
  using Mask = typename Form::Mask;

  static Eight all(double x) { return Eight::spread(x); }
  static Eight max(Eight a, Eight b) { return Form::max(a, b); }
  static Eight min(Eight a, Eight b) { return Form::min(a, b); }
  static Eight select(Mask m, Eight a, Eight b) { return Form::select(m, a, b); }
  static Eight root(Eight a) { return Form::root(a); }
  static Eight size_of(Eight a) { return Form::magnitude(a); }
  static Eight with_sign(Eight a, Eight sign) { return Form::with_sign(a, sign); }

  struct Vec {
    Eight x, y, z;
  };
  static Eight dot(const Vec& a, const Vec& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
  static Vec along(const Vec& o, const Vec& u, Eight s) { return {o.x + s * u.x, o.y + s * u.y, o.z + s * u.z}; }

  /// gpuprims::LocalRay.
  struct Local {
    Vec o, u;
    Eight start, scale;
    Mask valid;
  };

  /// gpuprims::ScaledRay.
  struct Scaled {
    Vec o, d;
    Eight factor;

    Scaled(const Vec& origin, const Vec& direction) : o(origin) {
      factor = Form::inverse_power_of_two(max(size_of(direction.x), max(size_of(direction.y), size_of(direction.z))));
      d = {factor * direction.x, factor * direction.y, factor * direction.z};
    }
  };
  static Eight closest_approach(const Vec& o, const Vec& d, double wx, double wy, double wz) {
    const Vec w{all(wx) * d.x, all(wy) * d.y, all(wz) * d.z};
    return -dot(w, o) / dot(w, d);
  }
  static Local move_to(const Scaled& ray, Eight start, double size) {
    const Eight x = Form::fused(start, ray.d.x, ray.o.x), y = Form::fused(start, ray.d.y, ray.o.y);
    const Eight z = Form::fused(start, ray.d.z, ray.o.z), per_unit = all(inverse_power_of_two(size));
    const Mask valid = less(((x * x + y * y) + z * z) + size_of(start), all(kForever));
    return {{x * per_unit, y * per_unit, z * per_unit},
            ray.d,
            start * ray.factor,
            all(power_of_two(size)) * ray.factor,
            valid};
  }
  static Local local_ray(const Vec& o, const Vec& d, double wx, double wy, double wz, double size) {
    const Scaled scaled(o, d);
    return move_to(scaled, closest_approach(scaled.o, scaled.d, wx, wy, wz), size);
  }

  /// gpuprims::Span. Faces are numbers.
  struct Span {
    Eight from = all(-kForever), to = all(kForever), from_face = all(-1.0), to_face = all(-1.0);

    void enter(Eight s, Eight face) {
      from_face = select(less(from, s), face, from_face);
      from = max(from, s);
    }
    void leave(Eight s, Eight face) {
      to_face = select(less(s, to), face, to_face);
      to = min(to, s);
    }
    void keep(Mask kept) {
      from = select(kept, from, all(1.0));
      to = select(kept, to, all(0.0));
    }
    void clip(Eight value, Eight slope, double face) {
      const Eight zero = all(0.0), at = -value / slope;
      const Mask up = less(zero, slope), down = less(slope, zero);
      enter(select(up, at, all(-kForever)), all(face));
      leave(select(down, at, all(kForever)), all(face));
      keep(up | down | at_most(zero, value));
    }
    void clip_slab(Eight value, Eight slope, double half, double low_face, double high_face) {
      const Eight zero = all(0.0), low = all(low_face), high = all(high_face);
      const Eight inverse = all(1.0) / slope, middle = -value * inverse, extent = all(half) * size_of(inverse);
      const Mask level = equal(slope, zero), up = less(zero, slope);
      const Mask within = at_most(size_of(value), all(half == 0.0 ? -1.0 : half));
      enter(select(level, all(-kForever), middle - extent), select(up, low, high));
      leave(select(level, all(kForever), middle + extent), select(up, high, low));
      keep(~level | within);
    }
    /// gpuprims::subtract().
    void subtract(const Span& gap, Span& after) {
      after = *this;
      const Mask is_gap = less(gap.from, gap.to);
      leave(select(is_gap, gap.from, all(kForever)), gap.from_face);
      after.enter(select(is_gap, gap.to, all(-kForever)), gap.to_face);
      after.keep(is_gap);
    }
    Mask any() const { return at_most(from, to); }
  };

  static Span cylinder_span(const Vec& o, const Vec& u, double radius, double face) {
    const Eight a = u.x * u.x + u.y * u.y, b = o.x * u.x + o.y * u.y, moment = o.x * u.y - o.y * u.x;
    const Eight square = all(radius * radius), discriminant = square * a - moment * moment;
    const Eight half = root(max(discriminant, all(0.0))), inverse = all(1.0) / a;
    const Mask across = less(all(kTiny), a), met = at_most(all(0.0), discriminant);
    Span span;
    span.from = select(across, (-b - half) * inverse, all(-kForever));
    span.to = select(across, (-b + half) * inverse, all(kForever));
    span.from_face = select(across, all(face), all(-1.0)), span.to_face = span.from_face;
    span.keep((across & met) | (~across & at_most(o.x * o.x + o.y * o.y, square)));
    return span;
  }

  /// The first crossings at or after `from`. Spans come in rising order.
  struct First {
    Eight begin, start, scale;
    Mask open;
    Eight t = all(kForever), s = all(0.0), face = all(0.0);

    First(const Local& local, Eight from) : begin(from), start(local.start), scale(local.scale), open(local.valid) {}
    void take(const Span& span) {
      const Mask here = open & span.any() & less(all(-kForever), span.from) & less(span.to, all(kForever));
      const Eight first = start + span.from * scale, last = start + span.to * scale;
      const Mask early = here & at_most(begin, first), late = here & ~early & at_most(begin, last);
      t = select(early, first, select(late, last, t));
      s = select(early, span.from, select(late, span.to, s));
      face = select(early, span.from_face, select(late, span.to_face, face));
      open = open & ~(early | late);
    }
  };

  struct Crossing {
    Eight t, face;
    Vec normal;
  };
  static Mask is(Eight face, double number) { return equal(face, all(number)); }

  // --- solids ---

  static Crossing box(const SolidShape& shape, const Vec& o, const Vec& d, Eight from) {
    const double* const half = shape.size;
    const double size = larger(half[0], larger(half[1], half[2])), per_unit = inverse_power_of_two(size);
    const Local local =
        local_ray(o, d, weight_of(size, half[0]), weight_of(size, half[1]), weight_of(size, half[2]), size);
    Span span;
    span.clip_slab(local.o.x, local.u.x, half[0] * per_unit, kBoxFaces[0], kBoxFaces[0] + 1);
    span.clip_slab(local.o.y, local.u.y, half[1] * per_unit, kBoxFaces[1], kBoxFaces[1] + 1);
    span.clip_slab(local.o.z, local.u.z, half[2] * per_unit, kBoxFaces[2], kBoxFaces[2] + 1);
    First hit(local, from);
    hit.take(span);
    const auto side = [&](int low) {
      return select(is(hit.face, low), all(-1.0), select(is(hit.face, low + 1), all(1.0), all(0.0)));
    };
    return {hit.t, hit.face, {side(kBoxFaces[0]), side(kBoxFaces[1]), side(kBoxFaces[2])}};
  }

  static Crossing cylinder(const SolidShape& shape, const Vec& o, const Vec& d, Eight from) {
    const double radius = shape.size[0], half = shape.size[1], per_unit = inverse_power_of_two(radius);
    const Local local = local_ray(o, d, 1.0, 1.0, weight_of(radius, half), radius);
    Span span = cylinder_span(local.o, local.u, radius * per_unit, 0.0);
    span.clip_slab(local.o.z, local.u.z, half * per_unit, 1.0, 2.0);
    First hit(local, from);
    hit.take(span);
    const Mask lateral = is(hit.face, 0.0);
    const Eight across = select(lateral, all(1.0), all(0.0));
    const Vec p = along(local.o, local.u, hit.s);
    return {hit.t,
            hit.face,
            {across * p.x, across * p.y, select(lateral, all(0.0), select(is(hit.face, 1.0), all(-1.0), all(1.0)))}};
  }

  /// gpuprims/dome.cpp: of the sphere and both dishes.
  static Crossing dome(const SolidShape& shape, const Vec& given_o, const Vec& d, Eight from) {
    const double radius = shape.size[0], widest = larger(radius, shape.size[1]), height = shape.size[2];
    const double unit = inverse_power_of_two(widest), scaled_radius = unit * radius, side = unit * shape.size[1];
    const Local local = local_ray(given_o, d, 1.0, 1.0, weight_of(widest, height), widest);
    const Eight base = all(scaled_radius * scaled_radius), bulge = all(side * side);
    const Eight stretch = all(1.0 / (unit * height)), middle = (base - bulge) / all(2.0), zero = all(0.0);
    const Vec &o = local.o, &u = local.u;
    const Eight g = stretch * o.z, climb = stretch * u.z;
    const Eight a = (u.x * u.x + u.y * u.y) + (bulge * climb) * climb;
    const Eight b = (o.x * u.x + o.y * u.y) + climb * (middle + bulge * g);
    const Eight c = (o.x * o.x + o.y * o.y) - (all(1.0) - g) * (base + bulge * g);
    const Eight discriminant = b * b - a * c;
    const Eight q = -(b + with_sign(root(max(discriminant, zero)), b));
    const Eight near = select(equal(q, zero), zero, c / q), far = q / a;
    Span span;
    span.from = min(near, far), span.to = max(near, far);
    span.from_face = span.to_face = zero;
    span.keep(at_most(zero, discriminant));
    if (!shape.whole) span.clip(o.z, u.z, 1.0);
    First hit(local, from);
    hit.take(span);
    const Mask lateral = is(hit.face, 0.0);
    const Vec p = along(o, u, hit.s);
    return {hit.t,
            hit.face,
            {select(lateral, p.x, zero), select(lateral, p.y, zero),
             select(lateral, stretch * (middle + (bulge * stretch) * p.z), all(-1.0))}};
  }

  /// A snout with level ends.
  static Crossing snout(const SolidShape& shape, const Vec& given_o, const Vec& d, Eight from) {
    const double widest = larger(shape.size[0], shape.size[1]), unit = inverse_power_of_two(widest);
    const double per_height = 1.0 / shape.size[2], half = (0.5 * unit) * shape.size[2];
    const double radius = (0.5 * unit) * (shape.size[0] + shape.size[1]);
    const double widening = (shape.size[1] - shape.size[0]) * per_height;
    const Eight lean_x = all(shape.offset[0] * per_height), lean_y = all(shape.offset[1] * per_height);
    const Eight zero = all(0.0), wide = all(widening);
    const Scaled scaled(given_o, d);
    const auto from_axis = [&](const Vec& v) { return Vec{v.x - lean_x * v.z, v.y - lean_y * v.z, v.z}; };
    const Eight close =
        closest_approach(from_axis(scaled.o), from_axis(scaled.d), 1.0, 1.0, weight_of(widest, half / unit));
    Local local = move_to(scaled, close, widest);
    const auto dot2 = [](const Vec& v, const Vec& w) { return v.x * w.x + v.y * w.y; };

    const Vec w1 = from_axis(local.u);
    const Eight r1 = wide * local.u.z;
    Vec w0 = from_axis(local.o);
    Eight r0 = all(radius) + wide * local.o.z;
    {  // approach_apex()
      const Eight shift = -(dot2(w0, w1) + r0 * r1) / (dot2(w1, w1) + r1 * r1);
      const Eight lean = (all(1.0) + size_of(lean_x)) + size_of(lean_y);
      const Mask moves = at_most(size_of(shift), all(4.0) * (all(1.0) + all(half - -half) * lean));
      const Vec moved = along(local.o, local.u, shift);
      local.o = {select(moves, moved.x, local.o.x), select(moves, moved.y, local.o.y),
                 select(moves, moved.z, local.o.z)};
      local.start = select(moves, local.start + shift * local.scale, local.start);
    }
    const Vec &o = local.o, &u = local.u;
    w0 = from_axis(o);
    r0 = all(radius) + wide * o.z;
    const Eight speed = dot2(w1, w1), b = dot2(w0, w1) - r0 * r1, c = dot2(w0, w0) - r0 * r0;
    const Eight a = speed - r1 * r1, moment = w0.x * w1.y - w0.y * w1.x;
    const Eight reach_x = r0 * w1.x - r1 * w0.x, reach_y = r0 * w1.y - r1 * w0.y;
    Eight discriminant = (reach_x * reach_x + reach_y * reach_y) - moment * moment;
    discriminant = select(less(a, zero), max(zero, discriminant), discriminant);
    const Mask real = at_most(zero, discriminant), moving = less(all(kTiny), speed + r1 * r1);
    const Eight q = -(b + with_sign(root(max(discriminant, zero)), b));
    const Eight near = select(equal(q, zero), zero, c / q), far = q / a;
    const Eight low = min(near, far), high = max(near, far);
    const Mask parallel = equal(a, zero), two = less(zero, a), grows = less(zero, r1), shrinks = less(r1, zero);
    const Mask begins = parallel & less(zero, q) & grows, ends = parallel & less(q, zero) & shrinks;
    // From where, up to where; the rest of a < 0.
    const Mask from_near = begins, to_near = ends, other = ~parallel & ~two;
    const Mask has_from = moving & (two | from_near | (other & grows));
    const Mask has_to = moving & (two | to_near | (other & ~grows));
    Span span;
    span.from = select(has_from, select(two, low, select(from_near, near, high)), all(-kForever));
    span.to = select(has_to, select(two, high, select(to_near, near, low)), all(kForever));
    span.from_face = select(has_from, zero, all(-1.0));
    span.to_face = select(has_to, zero, all(-1.0));
    const Mask same_nappe = ~two | at_most(zero, r0 * a - b * r1);
    span.keep((moving & real & same_nappe & (~parallel | begins | ends)) |
              (~moving & at_most(c, zero) & at_most(zero, r0)));
    span.clip_slab(o.z, u.z, half, 1.0, 2.0);
    First hit(local, from);
    hit.take(span);

    const Vec p = along(o, u, hit.s), w = from_axis(p);
    const Eight square = dot2(w, w);
    const Mask apex = at_most(square, all((1e-24 * radius) * radius));
    const Eight slope = -(lean_x * w.x + lean_y * w.y) - wide * root(square);
    const Mask lateral = is(hit.face, 0.0);
    const Eight share = select(lateral, all(1.0), zero);
    const Eight up = select(lateral, zero, select(is(hit.face, 1.0), all(-1.0), all(1.0)));
    return {
        hit.t,
        hit.face,
        {share * select(apex, zero, w.x), share * select(apex, zero, w.y), share * select(apex, -wide, slope) + up}};
  }

  /// gpuprims::Wedge: takes the parts of a span within it, in rising order.
  static void cut(const Sweep& sweep, const Vec& o, const Vec& u, const Span& span, First& hit) {
    if (sweep.whole) return hit.take(span);
    const Eight zero = all(0.0), end_x = all(sweep.end[0]), end_y = all(sweep.end[1]);
    const Eight end = end_y * o.x - end_x * o.y, end_slope = end_y * u.x - end_x * u.y;
    if (!sweep.convex) {
      const Mask inside = (equal(u.y, zero) & at_most(zero, o.y)) | (equal(end_slope, zero) & at_most(zero, end));
      Span gap, before = span, after;
      gap.clip(-o.y, -u.y, 1.0);
      gap.clip(-end, -end_slope, 2.0);
      gap.keep(~inside);
      before.subtract(gap, after);
      hit.take(before);
      hit.take(after);
      return;
    }
    Span piece = span;
    piece.clip(o.y, u.y, 1.0);
    piece.clip(end, end_slope, 2.0);
    if (sweep.flat) piece.keep(~equal(u.y, zero));
    const Eight s = all(0.5) * (piece.from + piece.to);
    piece.keep(piece.any() &
               at_most(zero, (o.x + s * u.x) * all(sweep.middle[0]) + (o.y + s * u.y) * all(sweep.middle[1])));
    hit.take(piece);
  }
  /// The normal of an end, or else `other`.
  static Vec end_normal(const Sweep& sweep, Eight face, const Vec& other) {
    const Mask begin = is(face, 1.0), end = is(face, 2.0);
    return {select(begin, all(0.0), select(end, all(-sweep.end[1]), other.x)),
            select(begin, all(-1.0), select(end, all(sweep.end[0]), other.y)), select(begin | end, all(0.0), other.z)};
  }

  static Crossing rectangular_torus(const SolidShape& shape, const Vec& given_o, const Vec& d, Eight from) {
    const double inner = shape.size[0], outer = shape.size[1], half = shape.size[2];
    const double unit = inverse_power_of_two(outer);
    const Local local = local_ray(given_o, d, 1.0, 1.0, weight_of(outer, half), outer);
    const Vec &o = local.o, &u = local.u;
    Span before = cylinder_span(o, u, unit * outer, 0.0), after;
    before.clip_slab(o.z, u.z, unit * half, 6.0, 7.0);
    First hit(local, from);
    if (inner > 0.0) {
      before.subtract(cylinder_span(o, u, unit * inner, 5.0), after);
      cut(shape.sweep, o, u, before, hit);
      if (any(hit.open & after.any())) cut(shape.sweep, o, u, after, hit);
    } else {
      cut(shape.sweep, o, u, before, hit);
    }
    const Vec p = along(o, u, hit.s);
    const Mask below = is(hit.face, 6.0), above = is(hit.face, 7.0), hole = is(hit.face, 5.0), level = below | above;
    const Eight zero = all(0.0);
    const Vec wall{select(level, zero, select(hole, -p.x, p.x)), select(level, zero, select(hole, -p.y, p.y)),
                   select(below, all(-1.0), select(above, all(1.0), zero))};
    return {hit.t, hit.face, end_normal(shape.sweep, hit.face, wall)};
  }

  // --- the circular torus; see gpuprims/circular_torus.cpp ---

  struct Tube {
    Vec o, u;
    double major, tube_radius, inner, outer;

    struct Value {
      Eight g, slope, rho;
    };
    Value distance(Eight s) const {
      const Eight x = o.x + s * u.x, y = o.y + s * u.y, z = o.z + s * u.z;
      const Eight rho = root(x * x + y * y), off = rho - all(major);
      return {(rho - all(outer)) * (rho - all(inner)) + z * z, all(2.0) * ((rho * z) * u.z + off * (x * u.x + y * u.y)),
              rho};
    }
  };

  /// gpuprims::cube_root().
  static Eight cube_root(Eight x) {
    const Eight two = all(2.0);
    Eight y = Form::rough_cube_root(x);
    for (int i = 0; i < 2; ++i) {
      const Eight cube = (y * y) * y;
      y = y * ((cube + two * x) / (two * cube + x));
    }
    return select(equal(x, all(0.0)), x, y);
  }

  struct Extremes {
    Eight root[3];
    Mask three;  // otherwise one
  };
  static Extremes depressed_cubic(Eight p, Eight q) {
    const Eight zero = all(0.0), one = all(1.0), two = all(2.0), three = all(3.0), four = all(4.0);
    const Eight third = -p / three, discriminant = (q * q) / four - (third * third) * third;
    const Mask single = less(zero, discriminant) | ~less(p, zero);
    Extremes result{{zero, zero, zero}, ~single};
    if (any(single)) {
      const Eight a = -with_sign(cube_root(size_of(q) / two + root(max(zero, discriminant))), q);
      const Eight t = select(equal(a, zero), zero, a + third / a), derivative = (three * t) * t + p;
      result.root[0] = select(equal(derivative, zero), t, t - ((t * t + p) * t + q) / derivative);
    }
    if (any(result.three)) {
      const Eight half = root(third), x = min(one, size_of(q) / ((two * third) * half));
      Eight c = all(0.8664) + x * (all(0.1598) - all(0.0265) * x);
      for (int i = 0; i < 2; ++i) c = c - (((four * c) * c - three) * c - x) / ((all(12.0) * c) * c - three);
      const Eight largest = -with_sign((two * half) * c, q);
      const Eight apart = half * root(max(zero, (three * (one - c)) * (one + c)));
      const Eight low = -largest / two - apart, high = -largest / two + apart;
      const Mask negative = Form::negative(q);
      result.root[0] = select(single, result.root[0], select(negative, low, largest));
      result.root[1] = select(negative, high, low);
      result.root[2] = select(negative, largest, high);
    }
    return result;
  }

  /// Guesses the roots of the rays in `wanted`; compare bracketed_root().
  static Eight guess_root(Eight depth, Eight e, Eight p, Eight bound, Mask wanted) {
    const Eight two = all(2.0), three = all(3.0), four = all(4.0), twelve = all(12.0);
    const Eight curvature = two * ((three * e) * e + p), reach = bound - e;
    Eight h = with_sign(min(root(-depth / curvature), size_of(reach)), reach);
    for (int i = 0; i < 4; ++i) {
      const Eight value = depth + (h * h) * (curvature + h * (four * e + h));
      const Eight step = value / (h * (two * curvature + h * (twelve * e + four * h)));
      h = select(wanted, h - step, h);
      wanted = wanted & less(all(1e-4) * size_of(h), size_of(step));
      if (!any(wanted)) break;
    }
    return e + h;
  }
  static Eight bracketed_root(const Tube& tube, Eight low, Eight high, Mask outside_at_low, Eight guess, Mask wanted) {
    const Eight two = all(2.0), least = all(kEpsilon), chord = high - low, near = all(kEpsilon * 0.01) * chord;
    Eight s = select(less(low, guess) & less(guess, high), guess, (low + high) / two);
    for (int i = 0; i < 100; ++i) {
      const auto value = tube.distance(s);
      const Mask at_low = ~(less(all(0.0), value.g) ^ outside_at_low);
      low = select(at_low, s, low);
      high = select(at_low, high, s);
      Eight next = s - (value.g * value.rho) / value.slope;
      const Mask newton = at_most(low, next) & at_most(next, high);
      next = select(newton, next, (low + high) / two);
      const Eight step = size_of(next - s);
      s = select(wanted, next, s);
      const Mask done =
          (newton & at_most(step * step, near * min(chord, value.rho))) | (~newton & at_most(step, least));
      wanted = wanted & ~done;
      if (!any(wanted)) break;
    }
    return s;
  }

  static Crossing circular_torus(const SolidShape& shape, const Vec& given_o, const Vec& d, Eight from) {
    const double major = shape.size[0], tube_radius = shape.size[1], size = major + tube_radius;
    const double per_unit = inverse_power_of_two(size);
    const Eight zero = all(0.0), one = all(1.0);
    Local local = local_ray(given_o, d, 1.0, 1.0, 1.0, size);
    {  // recentre()
      const Eight square = dot(local.u, local.u), length = root(square), shift = -dot(local.o, local.u) / square;
      local.o = along(local.o, local.u, shift);
      local.start = local.start + shift * local.scale;
      local.u = {local.u.x / length, local.u.y / length, local.u.z / length};
      local.scale = local.scale / length;
    }
    const Tube tube{local.o,        local.u, major * per_unit, tube_radius * per_unit, (major - tube_radius) * per_unit,
                    size * per_unit};
    const Vec &o = tube.o, &u = tube.u;
    First hit(local, from);

    // tube_crossings() and monotone_pieces()
    const double reach = tube.major + tube.tube_radius, r2 = tube.major * tube.major;
    const Eight square = dot(o, o), room = all(reach * reach) - square;
    hit.open = hit.open & less(all(((-4.0 * kEpsilon) * reach) * reach), room) & may_meet(tube);
    if (!any(hit.open)) return {hit.t, hit.face, {zero, zero, one}};
    const Eight end = root(max(zero, room) + all(reach * reach / 1024.0));
    const Eight k = square + all((tube.major - tube.tube_radius) * (tube.major + tube.tube_radius));
    const Eight across = u.x * u.x + u.y * u.y, along_disc = o.x * u.x + o.y * u.y;
    const Eight p = k - all(2.0 * r2) * across, q = all(-2.0 * r2) * along_disc;
    const Extremes extremes = depressed_cubic(p, q);

    Eight low = -end, depth = zero;
    Mask outside = Form::every();
    Span span;
    span.from_face = span.to_face = zero;
    for (int i = 0; i < 4; ++i) {
      const bool last = i == 3;
      const Eight high = last ? end : extremes.root[i];
      Mask here = hit.open;
      if (!last) here = here & less(low, high) & less(high, end);
      if (i == 1 || i == 2) here = here & extremes.three;
      if (!any(here)) continue;
      const auto value = last ? typename Tube::Value{one, zero, zero} : tube.distance(high);
      const Eight next_depth = value.g * (value.g + all(4.0 * tube.major) * value.rho);
      const Mask next_outside = less(zero, value.g), crosses = here & (next_outside ^ outside);
      if (any(crosses)) {
        const Eight guess = guess_root(select(outside, next_depth, depth), select(outside, high, low), p,
                                       select(outside, low, high), crosses);
        const Eight s = bracketed_root(tube, low, high, outside, guess, crosses);
        const Mask enters = crosses & outside, leaves = crosses & ~outside;
        if (any(enters)) {
          span.from = select(enters, s, span.from);
          // A ray that enters the solid here needs no more than this crossing.
          Span point = span;
          point.to = point.from;
          point.keep(enters & at_most(from, local.start + s * local.scale));
          if (!shape.sweep.needs_chord) cut(shape.sweep, o, u, point, hit);
        }
        if (any(leaves & hit.open)) {
          span.to = select(leaves, s, span.to);
          Span chord = span;
          chord.keep(leaves);
          cut(shape.sweep, o, u, chord, hit);
        }
      }
      outside = (here & next_outside) | (~here & outside);
      depth = select(here, next_depth, depth);
      low = select(here, high, low);
    }
    const Vec at = along(o, u, hit.s);
    const Eight rho = root(at.x * at.x + at.y * at.y);
    const Eight factor = select(less(zero, rho), (rho - all(tube.major)) / rho, zero);
    return {hit.t, hit.face, end_normal(shape.sweep, hit.face, {factor * at.x, factor * at.y, at.z})};
  }
  /// Whether rays meet a cylinder a little larger than the torus, and do not pass through its hole.
  static Mask may_meet(const Tube& tube) {
    constexpr double kMore = 1.0 + 1e-6;
    Span span = cylinder_span(tube.o, tube.u, tube.outer * kMore, 0.0);
    span.clip_slab(tube.o.z, tube.u.z, tube.tube_radius * kMore + 1e-9, 1.0, 2.0);
    const double hole = tube.inner * (2.0 - kMore) - 1e-9;
    if (hole <= 0.0) return span.any();
    const Eight x0 = tube.o.x + span.from * tube.u.x, y0 = tube.o.y + span.from * tube.u.y;
    const Eight x1 = tube.o.x + span.to * tube.u.x, y1 = tube.o.y + span.to * tube.u.y;
    return span.any() & ~less(max(x0 * x0 + y0 * y0, x1 * x1 + y1 * y1), all(hole * hole));
  }

  static Crossing meet(const SolidShape& shape, const Vec& o, const Vec& d, Eight from) {
    switch (shape.kind) {
      case SolidShape::kBox:
        return box(shape, o, d, from);
      case SolidShape::kCylinder:
        return cylinder(shape, o, d, from);
      case SolidShape::kDome:
        return dome(shape, o, d, from);
      case SolidShape::kSnout:
        return snout(shape, o, d, from);
      case SolidShape::kRectangularTorus:
        return rectangular_torus(shape, o, d, from);
      default:
        return circular_torus(shape, o, d, from);
    }
  }

  /// See PacketKernels::solid.
  static unsigned nearest(const SolidShape& shape, const LaneMap& map, const RayLanes& rays, unsigned who,
                          std::uint32_t slot, NearestLanes& best) {
    unsigned taken = 0;
    for (int half = 0; half < kPacket; half += 8) {
      const unsigned these = who >> half & 0xffu;
      if (these == 0) continue;
      Eight at[3], way[3];
      for (int axis = 0; axis < 3; ++axis) {
        at[axis] = (Eight::load(rays.origin[axis] + half) - all(map.shift[0][axis])) - all(map.shift[1][axis]);
        way[axis] = Eight::load(rays.direction[axis] + half);
      }
      const Vec o{at[0], at[1], at[2]}, d{way[0], way[1], way[2]};
      const Eight inverse = all(map.inverse);
      const auto row = [&](int axis, const Vec& v) {
        const double* const c = map.column[axis];
        return inverse * ((all(c[0]) * v.x + all(c[1]) * v.y) + all(c[2]) * v.z);
      };
      const Crossing found = meet(shape, {row(0, o), row(1, o), row(2, o)}, {row(0, d), row(1, d), row(2, d)},
                                  Eight::load(rays.from + half));
      const Eight former = Eight::load(best.t + half);
      unsigned nearer = these & Form::bits(less(found.t, former));
      for (unsigned ties = these & Form::bits(equal(found.t, former) & less(found.t, all(kForever))); ties != 0;
           ties &= ties - 1) {
        const unsigned ray = core::lowest_bit(ties);
        if (slot < best.slot[half + int(ray)]) nearer |= 1u << ray;
      }
      if (nearer == 0) continue;
      Form::store(best.t + half, nearer, found.t);
      Form::store(best.face + half, nearer, found.face);
      Form::store(best.normal[0] + half, nearer, found.normal.x);
      Form::store(best.normal[1] + half, nearer, found.normal.y);
      Form::store(best.normal[2] + half, nearer, found.normal.z);
      for (unsigned rest = nearer; rest != 0; rest &= rest - 1) best.slot[half + int(core::lowest_bit(rest))] = slot;
      taken |= nearer << half;
    }
    return taken;
  }
};

}  // namespace
}  // namespace sightline::raytrace
