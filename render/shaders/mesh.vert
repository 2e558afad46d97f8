// Instance of a triangle mesh.
#include "item.glsl"
#include "sections.glsl"

invariant gl_Position;  // passes of several programs meet at equal depths

layout(location = 0) in uint instance;
layout(location = 1) in uvec4 vertex;  // gpuscene::MeshPool

layout(location = 0) out vec3 p_eye;
#if defined(COUNT_CROSSINGS) || defined(LIST_CROSSINGS)
#define CROSSINGS
layout(binding = 4) uniform usamplerBuffer enclosures;  // core::Enclosure
layout(location = 1) flat out uvec2 crossing_words;  // record, and whether a ray leaves the mesh through front faces
#else
layout(location = 1) centroid out vec3 n_eye;
layout(location = 2) flat out uvec2 item_words;
#endif

#ifdef SECTIONS
layout(location = 3) out vec4 section_value[2];
#endif

// Inverse of gpuscene::pack_normal.
vec3 unpack_normal(uint word) {
  vec2 p = unpackSnorm2x16(word);
  float z = 1.0 - abs(p.x) - abs(p.y), fold = max(-z, 0.0);
  return word == 0x80008000u ? vec3(0.0) : normalize(vec3(p.x + (p.x < 0.0 ? fold : -fold), p.y + (p.y < 0.0 ? fold : -fold), z));
}

void main() {
  Item item = fetch_item(instance, 4);
  mat3 eye_from_local = view.eye_from_world * item.chunk_from_local;
  vec3 p = uintBitsToFloat(vertex.xyz);
  p_eye = eye_from_local * p + eye_origin(item);
  gl_Position = view.clip_from_eye * vec4(p_eye, 1.0);
#ifdef SECTIONS
  mat3 placed = mat3(item.chunk_from_local[0] * p.x, item.chunk_from_local[1] * p.y, item.chunk_from_local[2] * p.z);
  float size = size_of(item.offset) + size_of(placed[0]) + size_of(placed[1]) + size_of(placed[2]);
  section_values(turn_to_eye(pair_sum(item.chunk, item.offset)), eye_from_local * p, size, section_value);
#endif
#ifdef CROSSINGS
  uint enclosure = texelFetch(enclosures, int(instance)).x;
  if (enclosure == 0u) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // open meshes have no inside
  crossing_words = uvec2(instance, uint((enclosure == 2u) != (determinant(eye_from_local) < 0.0)));
#else
  // Uses cofactors, since the inverse transpose is not defined for singular placements. Mirrored placements flip the
  // normal, which does not matter: shading lights both sides.
  mat3 m = eye_from_local;
  n_eye = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * unpack_normal(vertex.w);
  item_words = uvec2(item.id, item.material);
#endif
}
