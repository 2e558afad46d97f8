// Parts of meshes, as culling/gpu/internal/mesh_parts.h writes them.
#include "cull_limits.glsl"

layout(location = 3) uniform int of_parts;  // the parts of the batch's records are looked at, not the records

// By cluster: box, and the box of the groups that its parts go into, twelve floats; the largest error of these groups,
// and the instance that all parts are of, or kRejected; two words not in use. Then its parts: details of the instance,
// or kRejected, and of the part.
layout(binding = 1) uniform usamplerBuffer part_clusters;
// Texels of a part: least corner, first index; greatest corner, number of indices; the groups that it is made by and goes into.
// Texels of a group: least corner, error; greatest corner.
// Texels of an instance: its placement's rows; stretch, record, base vertex.
layout(binding = 4) uniform usamplerBuffer details;

uvec4 detail(uint place) {
  return texelFetch(details, int(place));
}

// Details of the instance and of the part.
uvec2 fetch_part(uint part) {
  uint cluster = part / kItemsPerCluster, i = part % kItemsPerCluster;
  uvec4 two = texelFetch(part_clusters, int(kPartClusterTexels * cluster + 4u + i / 2u));
  return i % 2u == 0u ? two.xy : two.zw;
}

uint[COMMAND_WORDS] command_of_part(uint part) {
  uvec2 place = fetch_part(part);
  uvec4 instance = detail(place.x + 3u);
  return uint[COMMAND_WORDS](detail(place.y + 1u).w, 1u, detail(place.y).w, instance.z, instance.y);
}
