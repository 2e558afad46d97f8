// Computes the draw commands of a batch from the number of records that a culler has found. C++ side and defines:
// gpuscene/gpu_draw_lists.cpp.

// DrawLists::GpuSections. Per batch kind: first command, first place, number of places, indices per record.
layout(location = 0) uniform uvec4 sections[BATCH_KINDS];

// Batch kind of a record batch's command.
uint kind_of_command(uint command) {
  uint kind = 0u;
  for (uint k = 0u; k < MESH_KIND; ++k)
    if (sections[k].z > 0u && command >= sections[k].x) kind = k;  // sections are in rising order
  return kind;
}

uint commands_in_use(uint kind, uint records_found) {
  return kind == MESH_KIND ? records_found : (records_found + RECORDS_PER_COMMAND - 1u) / RECORDS_PER_COMMAND;
}

// Number of records that a record batch's command draws; `command` counts within the batch.
uint records_of_command(uint command, uint records_found) {
  uint begin = command * RECORDS_PER_COMMAND;
  return records_found > begin ? min(records_found - begin, RECORDS_PER_COMMAND) : 0u;
}
