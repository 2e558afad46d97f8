// Counts or lists a crossing of a pixel's ray with a closed mesh, behind the point where the kept part begins.
#include "kept_ray.glsl"
#include "section_cells.glsl"

layout(location = 1) flat in uvec2 crossing_words;  // record, and whether a ray leaves the mesh through front faces
layout(location = 3) in vec4 section_value[2];

void main() {
  // What the section keeps is behind the point where the ray enters it.
  int section;
  if (!begins_cut(gl_FragCoord.xy, section) || !(section_value[section >> 2][section & 3] >= 0.0)) discard;
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
