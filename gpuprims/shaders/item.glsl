// What every item has: its placement, its chunk, its id and its material. Also computes its position in eye space.
#include "view.glsl"
#include "payload.glsl"
#include "pairs.glsl"

layout(binding = 1) uniform samplerBuffer chunk_origins;  // relative to the eye, along world axes: two texels of a pair

#include "record.glsl"

struct Item {
  mat3 chunk_from_local;  // linear part
  vec3 offset;            // of the local frame, from the chunk's origin
  Pair3 chunk;            // origin, relative to the eye, along world axes
  uint id;                // item id
  uint material;          // low 24 bits: row of the material table; high 8 bits: flags
  float extra;            // first shape parameter
};

Item fetch_item(uint record, int texels_per_record) {
  uvec4 d = payload_texel(record, texels_per_record, 3);
  Item item;
  item.chunk_from_local = chunk_from_local(record, texels_per_record, item.offset);
  if ((d.z & kVacant) != 0u) item.chunk_from_local = mat3(0.0);  // shrinks to a point, which is not rasterised
  item.chunk = Pair3(texelFetch(chunk_origins, 2 * int(d.x)).xyz, texelFetch(chunk_origins, 2 * int(d.x) + 1).xyz);
  item.id = d.y;
  item.material = d.z;
  item.extra = uintBitsToFloat(d.w);
  return item;
}

// Sums are taken along world axes and relative to the eye. So what is near the eye loses nothing, however far away its
// chunk's origin is.
Pair3 turn_to_eye(Pair3 from_eye) {
  return pair_transform(view.eye_from_world_parts[0], view.eye_from_world_parts[1], from_eye);
}

// The local frame's origin in eye space.
vec3 eye_origin(Item item) {
  Pair3 p = turn_to_eye(pair_sum(item.chunk, item.offset));
  return p.high + p.low;
}

// A local point in eye space, in pairs: even with a far eye it keeps its exact place among its neighbours. The point's
// coordinates must have leading bits alone.
Pair3 eye_position(Item item, vec3 local) {
  Pair3 p = pair_sum(item.chunk, item.offset);
  for (int i = 0; i < 3; ++i) {
    vec3 leading = leading_bits(item.chunk_from_local[i]);
    precise vec3 rest = item.chunk_from_local[i] - leading;
    p = pair_sum(p, leading * local[i]);
    p.low += rest * local[i];
  }
  return turn_to_eye(p);
}
