// What every item carries: its placement, its chunk, its id and its material. Mirrors gpuprims::PackedHead.

layout(binding = 0) uniform usamplerBuffer payload;
layout(binding = 1) uniform samplerBuffer chunk_origins;  // relative to the eye, in eye space

#ifdef VERTEX_STAGE
// Records drawn one by one, where the vertex id does not name the record itself (see gpuscene/draw_lists.h).
layout(binding = 3) uniform usamplerBuffer single_records;
layout(location = 0) uniform uint record_count;

uint record_of(uint vertices_per_record) {
  uint record = uint(gl_VertexID) / vertices_per_record;
  return record < record_count ? record : texelFetch(single_records, int(record - record_count)).x;
}
#endif

struct Item {
  mat3 eye_from_local;   // linear part
  vec3 origin;           // of the local frame, in eye space
  uint id;               // item id
  uint material;         // low 24 bits: row of the material table; high 8 bits: flags
  float extra;           // first shape parameter
};

const uint kBottomOpen = 1u << 24;
const uint kTopOpen = 1u << 25;
const uint kFlatShaded = 1u << 26;

uvec4 payload_texel(uint instance, int texels_per_item, int texel) {
  return texelFetch(payload, int(instance) * texels_per_item + texel);
}

vec4 payload_floats(uint instance, int texels_per_item, int texel) {
  return uintBitsToFloat(payload_texel(instance, texels_per_item, texel));
}

Item fetch_item(uint instance, int texels_per_item) {
  vec4 a = payload_floats(instance, texels_per_item, 0);
  vec4 b = payload_floats(instance, texels_per_item, 1);
  vec4 c = payload_floats(instance, texels_per_item, 2);
  uvec4 d = payload_texel(instance, texels_per_item, 3);
  mat3 chunk_from_local = mat3(a.xyz, vec3(a.w, b.xy), vec3(b.zw, c.x));
  Item item;
  item.eye_from_local = view.eye_from_world * chunk_from_local;
  item.origin = view.eye_from_world * c.yzw + texelFetch(chunk_origins, int(d.x)).xyz;
  item.id = d.y;
  item.material = d.z;
  item.extra = uintBitsToFloat(d.w);
  return item;
}
