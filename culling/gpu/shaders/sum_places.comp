// One work group: turns the counts of visible records into the places where they go (prefix sums), and writes the
// counts that the draw lists need.
#include "draw_commands.glsl"

layout(local_size_x = SCAN_INVOCATIONS) in;

layout(std430, binding = 1) coherent restrict buffer Places {
  uint places[];  // as in blocks.glsl; the sum of all follows them
};
layout(std430, binding = 2) writeonly restrict buffer Counts {
  uvec2 counts[];  // per batch kind: commands in use, records found
};
layout(std430, binding = 3) writeonly restrict buffer Commands {
  uint commands[];  // gpuscene::ElementsCommand, of record batches
};
layout(std430, binding = 4) restrict buffer Results {
  uint results[];  // for the CPU, per probe: items in the view volume, where they were counted, and items written
};
layout(location = BATCH_KINDS) uniform uint first_place[BATCH_KINDS + 1];  // of each batch, and the end of the last
layout(location = 2 * BATCH_KINDS + 1) uniform uint record_commands;
layout(location = 2 * BATCH_KINDS + 2) uniform uint result;
layout(location = 2 * BATCH_KINDS + 3) uniform uint first_part_place;  // where places of records end

shared uint sums[SCAN_INVOCATIONS];

uint records_found(uint kind) {
  return places[first_place[kind + 1u]] - places[first_place[kind]];
}

void main() {
  uint i = gl_LocalInvocationIndex, count = first_place[BATCH_KINDS];
  uint run = (count + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
  uint begin = min(i * run, count), end = min(begin + run, count);
  uint sum = 0u;
  for (uint p = begin; p < end; ++p) sum += places[p];
  sums[i] = sum;
  barrier();
  for (uint reach = 1u; reach < gl_WorkGroupSize.x; reach *= 2u) {
    uint before = i >= reach ? sums[i - reach] : 0u;
    barrier();
    sums[i] += before;
    barrier();
  }
  uint place = sums[i] - sum;
  for (uint p = begin; p < end; ++p) {
    uint found = places[p];
    places[p] = place;
    place += found;
  }
  if (i == gl_WorkGroupSize.x - 1u) places[count] = place;
  memoryBarrierBuffer();
  barrier();
  if (i < BATCH_KINDS) counts[i] = uvec2(commands_in_use(i, records_found(i)), records_found(i));
  if (i == 0u) results[2u * result + 1u] += places[first_part_place];
  for (uint command = i; command < record_commands; command += gl_WorkGroupSize.x) {
    uint kind = kind_of_command(command);
    uint records = records_of_command(command - sections[kind].x, records_found(kind));
    commands[COMMAND_WORDS * command] = records * sections[kind].w;
  }
}
