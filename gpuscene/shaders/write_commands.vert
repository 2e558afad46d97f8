// One vertex per command of a record batch: the number of indices it draws, all else of it being there already.
#include "search.glsl"

flat out uint index_count;

void main() {
  uint command = uint(gl_VertexID), kind = 0u;
  for (uint k = 0u; k < MESH_KIND; ++k)
    if (sections[k].z > 0u && command >= sections[k].x) kind = k;  // they follow each other
  uint begin = (command - sections[kind].x) * RECORDS_PER_COMMAND;
  uint end = min(begin + RECORDS_PER_COMMAND, sections[kind].z);
  index_count = (search(kind, begin, end) - begin) * sections[kind].w;
}
