// Internal: sixteen lanes with WebAssembly's SIMD128, in four registers. For files that are compiled for it; lies in
// the anonymous namespace of each, so that every instance of a kernel is local to its file.
//
// Minimum and maximum are the pseudo-minimum and -maximum, which answer as a comparison does. The plain ones treat NaN
// and the signs of zero otherwise, and are slower.
#pragma once

#include <cstdint>

#include <wasm_simd128.h>

#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/frustum/internal/compress_table.h"

namespace sightline::culling {
namespace {

struct Simd128 {
  struct Plane {
    v128_t x, y, z, d, band, minus_band;
  };
  struct Lanes {
    v128_t q[4];
  };
  using Values = Lanes;
  struct Places {
    v128_t q[4];
  };

  template <class Result = Lanes, class Of>
  static Result each(const Of& of) {
    return {{of(0), of(1), of(2), of(3)}};
  }
  /// A bit per lane, of masks of whole lanes.
  static unsigned join(v128_t a, v128_t b, v128_t c, v128_t d) {
    return unsigned(
        wasm_i8x16_bitmask(wasm_i8x16_narrow_i16x8(wasm_i16x8_narrow_i32x4(a, b), wasm_i16x8_narrow_i32x4(c, d))));
  }
  template <class Of>
  static unsigned bits(const Of& of) {
    return join(of(0), of(1), of(2), of(3));
  }
  /// Masks of the lanes whose bits are set, of four from bit 4 i on.
  static v128_t mask_of(unsigned bits, int i) {
    const v128_t own = wasm_i32x4_const(1, 2, 4, 8);
    return wasm_i32x4_eq(wasm_v128_and(wasm_i32x4_splat(int(bits >> 4 * i)), own), own);
  }

  static Plane spread(const FloatPlane& p) {
    return {wasm_f32x4_splat(p.normal[0]), wasm_f32x4_splat(p.normal[1]), wasm_f32x4_splat(p.normal[2]),
            wasm_f32x4_splat(p.offset),    wasm_f32x4_splat(p.band),      wasm_f32x4_splat(-p.band)};
  }
  static Values evaluate(const Plane& p, const float* x, const float* y, const float* z) {
    return each([&](int i) {
      const v128_t xy = wasm_f32x4_add(wasm_f32x4_mul(p.x, wasm_v128_load(x + 4 * i)),
                                       wasm_f32x4_mul(p.y, wasm_v128_load(y + 4 * i)));
      return wasm_f32x4_add(wasm_f32x4_add(xy, wasm_f32x4_mul(p.z, wasm_v128_load(z + 4 * i))), p.d);
    });
  }
  static unsigned below(const Values& s, const Plane& p) {
    return bits([&](int i) { return wasm_f32x4_lt(s.q[i], p.minus_band); });
  }
  static unsigned above(const Values& s, const Plane& p) {
    return bits([&](int i) { return wasm_f32x4_ge(s.q[i], p.band); });
  }

  // Sixteen floats, for screen_boxes.h.
  static Lanes load(const float* a) {
    return each([&](int i) { return wasm_v128_load(a + 4 * i); });
  }
  static void store(float* out, const Lanes& a) {
    for (int i = 0; i < 4; ++i) wasm_v128_store(out + 4 * i, a.q[i]);
  }
  static void raise(float* at, const Lanes& a, unsigned bits) {
    for (int i = 0; i < 4; ++i) {
      const v128_t old = wasm_v128_load(at + 4 * i);
      wasm_v128_store(at + 4 * i, wasm_v128_bitselect(wasm_f32x4_pmax(old, a.q[i]), old, mask_of(bits, i)));
    }
  }
  static Lanes spread(float a) {
    return each([&](int) { return wasm_f32x4_splat(a); });
  }
  static Lanes ramp() {
    return {{wasm_f32x4_const(0, 1, 2, 3), wasm_f32x4_const(4, 5, 6, 7), wasm_f32x4_const(8, 9, 10, 11),
             wasm_f32x4_const(12, 13, 14, 15)}};
  }
  static Lanes add(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return wasm_f32x4_add(a.q[i], b.q[i]); });
  }
  static Lanes subtract(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return wasm_f32x4_sub(a.q[i], b.q[i]); });
  }
  static Lanes multiply(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return wasm_f32x4_mul(a.q[i], b.q[i]); });
  }
  static Lanes divide(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return wasm_f32x4_div(a.q[i], b.q[i]); });
  }
  static Lanes root(const Lanes& a) {
    return each([&](int i) { return wasm_f32x4_sqrt(a.q[i]); });
  }
  /// a where it is less, else b.
  static Lanes least(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return wasm_f32x4_pmin(b.q[i], a.q[i]); });
  }
  /// b where a is less, else a.
  static Lanes most(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return wasm_f32x4_pmax(a.q[i], b.q[i]); });
  }
  static v128_t most_of_pairs(v128_t a, v128_t b) {
    return wasm_f32x4_pmax(wasm_i32x4_shuffle(a, b, 0, 2, 4, 6), wasm_i32x4_shuffle(a, b, 1, 3, 5, 7));
  }
  static Lanes most_of_pairs(const Lanes& a, const Lanes& b) {
    return {{most_of_pairs(a.q[0], a.q[1]), most_of_pairs(a.q[2], a.q[3]), most_of_pairs(b.q[0], b.q[1]),
             most_of_pairs(b.q[2], b.q[3])}};
  }
  static Lanes magnitude(const Lanes& a) {
    return each([&](int i) { return wasm_f32x4_abs(a.q[i]); });
  }
  static Lanes whole(const Lanes& a) {
    return each([&](int i) { return wasm_f32x4_floor(a.q[i]); });
  }
  static unsigned less(const Lanes& a, const Lanes& b) {
    return bits([&](int i) { return wasm_f32x4_lt(a.q[i], b.q[i]); });
  }
  static unsigned at_most(const Lanes& a, const Lanes& b) {
    return bits([&](int i) { return wasm_f32x4_le(a.q[i], b.q[i]); });
  }
  /// a where bits are set, else b.
  static Lanes choose(unsigned bits, const Lanes& a, const Lanes& b) {
    return each([&](int i) { return wasm_v128_bitselect(a.q[i], b.q[i], mask_of(bits, i)); });
  }

  // Sixteen whole numbers: places of pixels, blocks and table entries.
  static Places place_above(const Lanes& a) {
    return each<Places>([&](int i) { return wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_ceil(a.q[i])); });
  }
  static Places place_below(const Lanes& a) {
    return each<Places>([&](int i) { return wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_floor(a.q[i])); });
  }
  static Places spread_place(int a) {
    return each<Places>([&](int) { return wasm_i32x4_splat(a); });
  }
  static Places plus(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return wasm_i32x4_add(a.q[i], b.q[i]); });
  }
  static Places minus(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return wasm_i32x4_sub(a.q[i], b.q[i]); });
  }
  static Places times(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return wasm_i32x4_mul(a.q[i], b.q[i]); });
  }
  static Places smaller(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return wasm_i32x4_min(a.q[i], b.q[i]); });
  }
  static Places larger(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return wasm_i32x4_max(a.q[i], b.q[i]); });
  }
  static unsigned equal(const Places& a, const Places& b) {
    return bits([&](int i) { return wasm_i32x4_eq(a.q[i], b.q[i]); });
  }
  static Places bit_width(const Places& a) {
    return each<Places>([&](int i) {
      const v128_t exponent = wasm_u32x4_shr(wasm_f32x4_convert_i32x4(a.q[i]), 23);
      return wasm_i32x4_max(wasm_i32x4_sub(exponent, wasm_i32x4_const_splat(126)), wasm_i32x4_const_splat(0));
    });
  }
  /// SIMD128 has no shift by lanes and no gather.
  template <class Of>
  static v128_t by_lanes(v128_t at, const Of& of) {
    return wasm_i32x4_make(of(0, wasm_i32x4_extract_lane(at, 0)), of(1, wasm_i32x4_extract_lane(at, 1)),
                           of(2, wasm_i32x4_extract_lane(at, 2)), of(3, wasm_i32x4_extract_lane(at, 3)));
  }
  static Places shifted(const Places& a, const Places& count) {
    return each<Places>([&](int i) {
      std::int32_t lanes[4];
      wasm_v128_store(lanes, a.q[i]);
      return by_lanes(count.q[i], [&](int lane, int by) { return lanes[lane] >> by; });
    });
  }
  /// Entries of sixteen.
  static Places pick(const std::int32_t* table, const Places& at) {
    return each<Places>([&](int i) { return by_lanes(at.q[i], [&](int, int place) { return table[place]; }); });
  }
  static Lanes look_up(const float* table, const Places& at) {
    return each([&](int i) {
      const v128_t places = at.q[i];
      return wasm_f32x4_make(table[wasm_i32x4_extract_lane(places, 0)], table[wasm_i32x4_extract_lane(places, 1)],
                             table[wasm_i32x4_extract_lane(places, 2)], table[wasm_i32x4_extract_lane(places, 3)]);
    });
  }

  /// Minimum and maximum of the 32 floats of a leaf, none of them NaN.
  template <class Better>
  static float best(const float* a, const Better& better) {
    v128_t r = wasm_v128_load(a);
    for (std::uint32_t i = 4; i < kLeafSize; i += 4) r = better(r, wasm_v128_load(a + i));
    r = better(r, wasm_i32x4_shuffle(r, r, 2, 3, 0, 1));
    return wasm_f32x4_extract_lane(better(r, wasm_i32x4_shuffle(r, r, 1, 0, 3, 2)), 0);
  }
  static float least(const float* a) {
    return best(a, [](v128_t r, v128_t b) { return wasm_f32x4_pmin(r, b); });
  }
  static float most(const float* a) {
    return best(a, [](v128_t r, v128_t b) { return wasm_f32x4_pmax(r, b); });
  }

  static unsigned share(const std::uint32_t* layers, std::uint32_t mask) {
    const v128_t wanted = wasm_i32x4_splat(int(mask)), none = wasm_i32x4_const_splat(0);
    return bits([&](int i) { return wasm_i32x4_ne(wasm_v128_and(wasm_v128_load(layers + 4 * i), wanted), none); });
  }
  static std::uint32_t* append_half(std::uint32_t* out, std::uint32_t base, unsigned bits) {
    const v128_t places = wasm_u16x8_load8x8(kCompress.rows[bits]), first = wasm_i32x4_splat(int(base));
    wasm_v128_store(out, wasm_i32x4_add(wasm_u32x4_extend_low_u16x8(places), first));
    wasm_v128_store(out + 4, wasm_i32x4_add(wasm_u32x4_extend_high_u16x8(places), first));
    return out + __builtin_popcount(bits);
  }
  static void store_places(std::uint32_t* out, std::uint32_t base) {
    append_half(out, base, 0xff);
    append_half(out + 8, base + 8, 0xff);
  }
  static std::uint32_t* append(std::uint32_t* out, std::uint32_t base, unsigned bits) {
    return append_half(append_half(out, base, bits & 0xffu), base + 8, bits >> 8);
  }
};

}  // namespace

}  // namespace sightline::culling
