// A box on a grid of 1024 steps across the one around it. What makes it conservative: culling/gpu/compact_box.h, which
// knows these operations one by one.
const uint kVacant = 0x80000000u;

void expand(uvec2 packed_box, vec3 around_low, vec3 around_high, out vec3 low, out vec3 high) {
  const uvec3 shifts = uvec3(0u, 10u, 20u);
  precise vec3 step_size = around_high * (1.0 / 1024.0) - around_low * (1.0 / 1024.0);
  precise vec3 from_low = vec3((uvec3(packed_box.x) >> shifts) & 1023u) * step_size;
  precise vec3 from_high = vec3((uvec3(packed_box.y) >> shifts) & 1023u) * step_size;
  precise vec3 l = around_low + from_low, h = around_high - from_high;
  low = l;
  high = h;
}
