// What every item has: its placement, its chunk, its id and its material. Also computes its position in eye space.
#include "view.glsl"
#include "payload.glsl"

layout(binding = 1) uniform usamplerBuffer chunk_origins;  // doubles, two texels each: relative to the eye, in eye space

// Ids of records drawn one by one, for vertex ids that do not name the record itself (see
// gpuscene/internal/draw_lists.h).
layout(binding = 3) uniform usamplerBuffer single_records;
layout(location = 0) uniform uint record_count;

uint record_of(uint vertices_per_record) {
  uint record = uint(gl_VertexID) / vertices_per_record;
  return record < record_count ? record : texelFetch(single_records, int(record - record_count)).x;
}

struct Item {
  mat3 chunk_from_local;  // linear part
  vec3 offset;            // of the local frame, from the chunk's origin
  dvec3 chunk;            // origin, in eye space
  uint id;                // item id
  uint material;          // low 24 bits: row of the material table; high 8 bits: flags
  float extra;            // first shape parameter
};

Item fetch_item(uint record, int texels_per_record) {
  vec4 a = payload_floats(record, texels_per_record, 0);
  vec4 b = payload_floats(record, texels_per_record, 1);
  vec4 c = payload_floats(record, texels_per_record, 2);
  uvec4 d = payload_texel(record, texels_per_record, 3);
  uvec4 xy = texelFetch(chunk_origins, 2 * int(d.x)), z = texelFetch(chunk_origins, 2 * int(d.x) + 1);
  Item item;
  item.chunk_from_local = mat3(a.xyz, vec3(a.w, b.xy), vec3(b.zw, c.x));
  if ((d.z & kVacant) != 0u) item.chunk_from_local = mat3(0.0);  // shrinks to a point, which is not rasterised
  item.offset = c.yzw;
  item.chunk = dvec3(packDouble2x32(xy.xy), packDouble2x32(xy.zw), packDouble2x32(z.xy));
  item.id = d.y;
  item.material = d.z;
  item.extra = uintBitsToFloat(d.w);
  return item;
}

// The local frame's origin in eye space.
vec3 eye_origin(Item item) { return vec3(view.eye_from_world * dvec3(item.offset) + item.chunk); }

// A local point in eye space, in double: even with a far eye it keeps its exact place among its neighbours.
dvec3 eye_position(Item item, vec3 local) {
  dvec3 from_chunk = dvec3(item.offset) + dmat3(item.chunk_from_local) * dvec3(local);
  return view.eye_from_world * from_chunk + item.chunk;
}
