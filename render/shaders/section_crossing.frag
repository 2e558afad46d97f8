// Counts or lists a crossing of a pixel's ray with a closed mesh, behind the point where the kept part begins.
#include "kept_ray.glsl"
#include "section_cells.glsl"

layout(location = 0) in vec3 p_eye;
layout(location = 1) flat in uvec2 crossing_words;  // record, and whether a ray leaves the mesh through front faces

void main() {
  int section;
  float entry = section_entry(gl_FragCoord.xy, section);
  if (!(entry < kNoHit) || !(-p_eye.z > entry)) discard;
  uint record = crossing_words.x;
  bool leaves = gl_FrontFacing == (crossing_words.y != 0u);
  int cell = cell_of_pixel();
#ifdef COUNT_CROSSINGS
  atomicAdd(cells[cell].winding, leaves ? 1 : -1);
  atomicAdd(cells[cell].records, leaves ? record + 1u : ~record);
#else
  if (cells[cell].winding < 2) discard;
  uint place = atomicAdd(node_count, 1u);
  if (place >= uint(nodes.length())) discard;
  nodes[place] = Node(record << 1 | uint(leaves), atomicExchange(cells[cell].head, place + 1u));
#endif
}
