// Internal: the part of simd128.h for NEON, which also has doubles.
#pragma once

#include <cstdint>

#include <arm_neon.h>

namespace sightline::core {
namespace {

inline constexpr std::uint32_t kLaneBits[] = {1, 2, 4, 8};
inline constexpr std::uint16_t kHalfBits[2][8] = {{1, 2, 4, 8, 16, 32, 64, 128},
                                                  {256, 512, 1024, 2048, 4096, 8192, 16384, 32768}};

/// Lanes whose bits are all set, or none.
struct Mask4 {
  static constexpr int kLanes = 4;
  static constexpr bool kIsMask = true;
  uint32x4_t v;
  static Mask4 of_bits(unsigned bits) { return {vtstq_u32(vdupq_n_u32(bits), vld1q_u32(kLaneBits))}; }

  friend Mask4 operator&(Mask4 a, Mask4 b) { return {vandq_u32(a.v, b.v)}; }
  friend Mask4 operator|(Mask4 a, Mask4 b) { return {vorrq_u32(a.v, b.v)}; }
  friend Mask4 operator~(Mask4 a) { return {vmvnq_u32(a.v)}; }
};
/// A bit per lane.
inline uint16x8_t bits_by_lane(Mask4 a, Mask4 b, const std::uint16_t (&bits)[8]) {
  return vandq_u16(vuzp1q_u16(vreinterpretq_u16_u32(a.v), vreinterpretq_u16_u32(b.v)), vld1q_u16(bits));
}
inline unsigned bits_of(Mask4 a, Mask4 b) {
  return vaddvq_u16(bits_by_lane(a, b, kHalfBits[0]));
}
inline unsigned bits_of(Mask4 a, Mask4 b, Mask4 c, Mask4 d) {
  return vaddvq_u16(vorrq_u16(bits_by_lane(a, b, kHalfBits[0]), bits_by_lane(c, d, kHalfBits[1])));
}

struct Int4 {
  static constexpr int kLanes = 4;
  static constexpr bool kIsMask = false;
  int32x4_t v;
  static Int4 load(const std::uint32_t* a) { return {vreinterpretq_s32_u32(vld1q_u32(a))}; }
  static Int4 spread(std::int32_t a) { return {vdupq_n_s32(a)}; }
  void store(std::uint32_t* out) const { vst1q_u32(out, vreinterpretq_u32_s32(v)); }

  friend Int4 operator+(Int4 a, Int4 b) { return {vaddq_s32(a.v, b.v)}; }
  friend Int4 operator-(Int4 a, Int4 b) { return {vsubq_s32(a.v, b.v)}; }
  friend Int4 operator*(Int4 a, Int4 b) { return {vmulq_s32(a.v, b.v)}; }
  friend Int4 least(Int4 a, Int4 b) { return {vminq_s32(a.v, b.v)}; }
  friend Int4 most(Int4 a, Int4 b) { return {vmaxq_s32(a.v, b.v)}; }
  friend Mask4 equal(Int4 a, Int4 b) { return {vceqq_s32(a.v, b.v)}; }
  friend Mask4 share_bits(Int4 a, Int4 b) { return {vtstq_s32(a.v, b.v)}; }
};
inline Int4 shifted(Int4 a, Int4 count) {
  return {vshlq_s32(a.v, vnegq_s32(count.v))};
}
inline Int4 pick(const std::int32_t* table, Int4 at) {
  uint8x16x4_t bytes;
  for (int i = 0; i < 4; ++i) bytes.val[i] = vreinterpretq_u8_s32(vld1q_s32(table + 4 * i));
  const int32x4_t places = vmlaq_n_s32(vdupq_n_s32(0x03020100), at.v, 0x04040404);
  return {vreinterpretq_s32_u8(vqtbl4q_u8(bytes, vreinterpretq_u8_s32(places)))};
}
inline Int4 float_exponents(Int4 a) {
  return {vreinterpretq_s32_u32(vshrq_n_u32(vreinterpretq_u32_f32(vcvtq_f32_s32(a.v)), 23))};
}
inline void widen(const std::uint8_t* bytes, Int4& low, Int4& high) {
  const uint16x8_t places = vmovl_u8(vld1_u8(bytes));
  low.v = vreinterpretq_s32_u32(vmovl_u16(vget_low_u16(places)));
  high.v = vreinterpretq_s32_u32(vmovl_high_u16(places));
}

struct Float4 {
  static constexpr int kLanes = 4;
  static constexpr bool kIsMask = false;
  float32x4_t v;
  static Float4 load(const float* a) { return {vld1q_f32(a)}; }
  static Float4 spread(float a) { return {vdupq_n_f32(a)}; }
  void store(float* out) const { vst1q_f32(out, v); }

  friend Float4 operator+(Float4 a, Float4 b) { return {vaddq_f32(a.v, b.v)}; }
  friend Float4 operator-(Float4 a, Float4 b) { return {vsubq_f32(a.v, b.v)}; }
  friend Float4 operator*(Float4 a, Float4 b) { return {vmulq_f32(a.v, b.v)}; }
  friend Float4 operator/(Float4 a, Float4 b) { return {vdivq_f32(a.v, b.v)}; }
  friend Float4 root(Float4 a) { return {vsqrtq_f32(a.v)}; }
  friend Float4 magnitude(Float4 a) { return {vabsq_f32(a.v)}; }
  friend Float4 least(Float4 a, Float4 b) { return {vbslq_f32(vcltq_f32(a.v, b.v), a.v, b.v)}; }
  friend Float4 most(Float4 a, Float4 b) { return {vbslq_f32(vcgtq_f32(a.v, b.v), a.v, b.v)}; }
  friend Mask4 less(Float4 a, Float4 b) { return {vcltq_f32(a.v, b.v)}; }
  friend Mask4 at_most(Float4 a, Float4 b) { return {vcleq_f32(a.v, b.v)}; }
  friend Mask4 equal(Float4 a, Float4 b) { return {vceqq_f32(a.v, b.v)}; }
  friend Mask4 negative(Float4 a) { return {vcltzq_s32(vreinterpretq_s32_f32(a.v))}; }
  friend Float4 with_signs(Float4 a, Float4 b) { return {vbslq_f32(vdupq_n_u32(0x80000000u), b.v, a.v)}; }
  friend Float4 choose(Mask4 m, Float4 a, Float4 b) { return {vbslq_f32(m.v, a.v, b.v)}; }
  friend Float4 rounded_down(Float4 a) { return {vrndmq_f32(a.v)}; }
  friend Float4 rounded_up(Float4 a) { return {vrndpq_f32(a.v)}; }
  friend Int4 to_int(Float4 a) { return {vcvtq_s32_f32(a.v)}; }
  friend Float4 even(Float4 a, Float4 b) { return {vuzp1q_f32(a.v, b.v)}; }
  friend Float4 odd(Float4 a, Float4 b) { return {vuzp2q_f32(a.v, b.v)}; }
  friend float least_lane(Float4 a) { return vminvq_f32(a.v); }
  friend float most_lane(Float4 a) { return vmaxvq_f32(a.v); }
};
inline Float4 look_up(const float* table, Int4 at) {
  float32x4_t v = vdupq_n_f32(table[vgetq_lane_s32(at.v, 0)]);
  v = vld1q_lane_f32(table + vgetq_lane_s32(at.v, 1), v, 1);
  v = vld1q_lane_f32(table + vgetq_lane_s32(at.v, 2), v, 2);
  return {vld1q_lane_f32(table + vgetq_lane_s32(at.v, 3), v, 3)};
}

/// Lanes whose bits are all set, or none.
struct Mask2 {
  static constexpr int kLanes = 2;
  static constexpr bool kIsMask = true;
  uint64x2_t v;
  static Mask2 of_bits(unsigned bits) { return {vtstq_u64(vdupq_n_u64(bits), vmovl_u32(vld1_u32(kLaneBits)))}; }

  friend Mask2 operator&(Mask2 a, Mask2 b) { return {vandq_u64(a.v, b.v)}; }
  friend Mask2 operator|(Mask2 a, Mask2 b) { return {vorrq_u64(a.v, b.v)}; }
  friend Mask2 operator^(Mask2 a, Mask2 b) { return {veorq_u64(a.v, b.v)}; }
  friend Mask2 operator~(Mask2 a) { return {vreinterpretq_u64_u32(vmvnq_u32(vreinterpretq_u32_u64(a.v)))}; }
};
inline Mask4 narrowed(Mask2 a, Mask2 b) {
  return {vuzp1q_u32(vreinterpretq_u32_u64(a.v), vreinterpretq_u32_u64(b.v))};
}
inline unsigned bits_of(Mask2 a, Mask2 b) {
  return vaddvq_u32(vandq_u32(narrowed(a, b).v, vld1q_u32(kLaneBits)));
}
inline unsigned bits_of(Mask2 a, Mask2 b, Mask2 c, Mask2 d) {
  return bits_of(narrowed(a, b), narrowed(c, d));
}

struct Double2 {
  static constexpr int kLanes = 2;
  static constexpr bool kIsMask = false;
  float64x2_t v;
  static Double2 load(const double* a) { return {vld1q_f64(a)}; }
  static Double2 spread(double a) { return {vdupq_n_f64(a)}; }
  void store(double* out) const { vst1q_f64(out, v); }

  friend Double2 operator+(Double2 a, Double2 b) { return {vaddq_f64(a.v, b.v)}; }
  friend Double2 operator-(Double2 a, Double2 b) { return {vsubq_f64(a.v, b.v)}; }
  friend Double2 operator*(Double2 a, Double2 b) { return {vmulq_f64(a.v, b.v)}; }
  friend Double2 operator/(Double2 a, Double2 b) { return {vdivq_f64(a.v, b.v)}; }
  friend Double2 operator-(Double2 a) { return {vnegq_f64(a.v)}; }
  friend Double2 fused(Double2 a, Double2 b, Double2 c) { return {vfmaq_f64(c.v, a.v, b.v)}; }
  friend Double2 root(Double2 a) { return {vsqrtq_f64(a.v)}; }
  friend Double2 magnitude(Double2 a) { return {vabsq_f64(a.v)}; }
  friend Double2 least(Double2 a, Double2 b) { return {vbslq_f64(vcltq_f64(a.v, b.v), a.v, b.v)}; }
  friend Double2 most(Double2 a, Double2 b) { return {vbslq_f64(vcgtq_f64(a.v, b.v), a.v, b.v)}; }
  friend Mask2 less(Double2 a, Double2 b) { return {vcltq_f64(a.v, b.v)}; }
  friend Mask2 at_most(Double2 a, Double2 b) { return {vcleq_f64(a.v, b.v)}; }
  friend Mask2 equal(Double2 a, Double2 b) { return {vceqq_f64(a.v, b.v)}; }
  friend Mask2 negative(Double2 a) { return {vcltzq_s64(vreinterpretq_s64_f64(a.v))}; }
  friend Double2 with_signs(Double2 a, Double2 b) { return {vbslq_f64(vdupq_n_u64(0x8000000000000000u), b.v, a.v)}; }
  friend Double2 choose(Mask2 m, Double2 a, Double2 b) { return {vbslq_f64(m.v, a.v, b.v)}; }
  friend Double2 firsts(Double2 a, Double2 b) { return {vzip1q_f64(a.v, b.v)}; }
  friend Double2 seconds(Double2 a, Double2 b) { return {vzip2q_f64(a.v, b.v)}; }
};

}  // namespace
}  // namespace sightline::core
