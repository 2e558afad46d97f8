// One vertex per command of a record batch: outputs its number of indices. The rest of the command is already written.
#include "search.glsl"

layout(location = 0) flat out uint index_count;

void main() {
  uint command = uint(gl_VertexID), kind = kind_of_command(command);
  uint begin = (command - sections[kind].x) * RECORDS_PER_COMMAND;
  uint end = min(begin + RECORDS_PER_COMMAND, sections[kind].z);
  index_count = (search(kind, begin, end) - begin) * sections[kind].w;
}
