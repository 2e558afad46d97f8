// One vertex per batch kind: outputs the number of commands in use and of records that the culler has found.
#include "search.glsl"

layout(location = 0) flat out uint command_count;
layout(location = 1) flat out uint record_count;

void main() {
  uint kind = uint(gl_VertexID);
  record_count = search(kind, 0u, sections[kind].z);
  command_count = commands_in_use(kind, record_count);
}
