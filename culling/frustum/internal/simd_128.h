// Internal: sixteen lanes in four registers of 128 bits, for NEON and WebAssembly's SIMD128. For files that are
// compiled for them; lies in the anonymous namespace of each, so that every instance of a kernel is local to its file.
#pragma once

#include <cstdint>

#include "sightline/core/internal/simd128.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/frustum/internal/compress_table.h"

namespace sightline::culling {
namespace {

struct Simd128 {
  // Sixteen floats, for screen_boxes.h.
  using Lanes = core::Registers<core::Float4, 4>;
  using Values = Lanes;
  struct Plane {
    Lanes x, y, z, d, band, minus_band;
  };

  static Plane spread(const FloatPlane& p) {
    return {spread(p.normal[0]), spread(p.normal[1]), spread(p.normal[2]),
            spread(p.offset),    spread(p.band),      spread(-p.band)};
  }
  static Values evaluate(const Plane& p, const float* x, const float* y, const float* z) {
    return ((p.x * load(x) + p.y * load(y)) + p.z * load(z)) + p.d;
  }
  static unsigned below(const Values& s, const Plane& p) { return core::less(s, p.minus_band); }
  static unsigned above(const Values& s, const Plane& p) { return core::at_most(p.band, s); }

  static Lanes load(const float* a) { return Lanes::load(a); }
  static void store(float* out, const Lanes& a) { a.store(out); }
  static void raise(float* at, const Lanes& a, unsigned bits) {
    const Lanes old = load(at);
    store(at, choose(bits, core::most(a, old), old));
  }
  static Lanes spread(float a) { return Lanes::spread(a); }
  static Lanes ramp() {
    static constexpr float kRamp[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    return load(kRamp);
  }
  static Lanes add(const Lanes& a, const Lanes& b) { return a + b; }
  static Lanes subtract(const Lanes& a, const Lanes& b) { return a - b; }
  static Lanes multiply(const Lanes& a, const Lanes& b) { return a * b; }
  static Lanes divide(const Lanes& a, const Lanes& b) { return a / b; }
  static Lanes root(const Lanes& a) { return core::root(a); }
  static Lanes least(const Lanes& a, const Lanes& b) { return core::least(a, b); }
  static Lanes most(const Lanes& a, const Lanes& b) { return core::most(b, a); }
  static Lanes most_of_pairs(const Lanes& a, const Lanes& b) {
    const Lanes first{{even(a.q[0], a.q[1]), even(a.q[2], a.q[3]), even(b.q[0], b.q[1]), even(b.q[2], b.q[3])}};
    const Lanes second{{odd(a.q[0], a.q[1]), odd(a.q[2], a.q[3]), odd(b.q[0], b.q[1]), odd(b.q[2], b.q[3])}};
    return most(first, second);
  }
  static Lanes magnitude(const Lanes& a) { return core::magnitude(a); }
  static Lanes whole(const Lanes& a) {
    return Lanes::each([&](int i) { return rounded_down(a.q[i]); });
  }
  static unsigned less(const Lanes& a, const Lanes& b) { return core::less(a, b); }
  static unsigned at_most(const Lanes& a, const Lanes& b) { return core::at_most(a, b); }
  /// a where bits are set, else b.
  static Lanes choose(unsigned bits, const Lanes& a, const Lanes& b) {
    return core::choose(core::Registers<core::Mask4, 4>::of_bits(bits), a, b);
  }

  // Sixteen whole numbers: places of pixels, blocks and table entries.
  using Places = core::Registers<core::Int4, 4>;
  static Places place_above(const Lanes& a) {
    return Lanes::each([&](int i) { return to_int(rounded_up(a.q[i])); });
  }
  static Places place_below(const Lanes& a) {
    return Lanes::each([&](int i) { return to_int(rounded_down(a.q[i])); });
  }
  static Places spread_place(int a) { return Places::spread(a); }
  static Places plus(const Places& a, const Places& b) { return a + b; }
  static Places minus(const Places& a, const Places& b) { return a - b; }
  static Places times(const Places& a, const Places& b) { return a * b; }
  static Places smaller(const Places& a, const Places& b) { return core::least(a, b); }
  static Places larger(const Places& a, const Places& b) { return core::most(a, b); }
  static unsigned equal(const Places& a, const Places& b) { return core::equal(a, b); }
  static Places bit_width(const Places& a) {
    const Places exponents = Places::each([&](int i) { return float_exponents(a.q[i]); });
    return larger(exponents - spread_place(126), spread_place(0));
  }
  static Places shifted(const Places& a, const Places& count) {
    return Places::each([&](int i) { return core::shifted(a.q[i], count.q[i]); });
  }
  /// Entries of sixteen.
  static Places pick(const std::int32_t* table, const Places& at) {
    return Places::each([&](int i) { return core::pick(table, at.q[i]); });
  }
  static Lanes look_up(const float* table, const Places& at) {
    return Places::each([&](int i) { return core::look_up(table, at.q[i]); });
  }

  /// Minimum and maximum of the 32 floats of a leaf, none of them NaN.
  static float least(const float* a) { return lowest_of(core::least(load(a), load(a + kLanes)), 0xffff); }
  static float most(const float* a) { return highest(core::most(load(a), load(a + kLanes)), 0xffff); }

  static unsigned share(const std::uint32_t* layers, std::uint32_t mask) {
    return core::share_bits(Places::load(layers), Places::spread(int(mask)));
  }
  static std::uint32_t* append_half(std::uint32_t* out, std::uint32_t base, unsigned bits) {
    core::Registers<core::Int4, 2> places;
    core::widen(kCompress.rows[bits], places.q[0], places.q[1]);
    (places + places.spread(int(base))).store(out);
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
