// How the draw commands of a batch follow from the number of records that a culler has found. C++ side and defines:
// gpuscene/gpu_draw_lists.cpp.

// DrawLists::GpuSections. Per batch kind: first command, first place, places, indices per record.
layout(location = 0) uniform uvec4 sections[BATCH_KINDS];

// Of a record batch's command.
uint kind_of_command(uint command) {
  uint kind = 0u;
  for (uint k = 0u; k < MESH_KIND; ++k)
    if (sections[k].z > 0u && command >= sections[k].x) kind = k;  // they follow each other
  return kind;
}

uint commands_in_use(uint kind, uint records_found) {
  return kind == MESH_KIND ? records_found : (records_found + RECORDS_PER_COMMAND - 1u) / RECORDS_PER_COMMAND;
}

// Records that a record batch's command draws, counted within the batch.
uint records_of_command(uint command, uint records_found) {
  uint begin = command * RECORDS_PER_COMMAND;
  return records_found > begin ? min(records_found - begin, RECORDS_PER_COMMAND) : 0u;
}
