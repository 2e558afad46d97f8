// Which record a vertex belongs to.

// Ids of records drawn one by one, for vertex ids that do not name the record itself (see
// gpuscene/internal/draw_lists.h).
layout(binding = 3) uniform usamplerBuffer single_records;
layout(location = 0) uniform uint record_count;

uint vertex_number() {
#ifdef ADD_BASE_VERTEX
  return uint(gl_VertexID + gl_BaseVertexARB);
#else
  return uint(gl_VertexID);
#endif
}

uint record_of(uint vertices_per_record) {
  uint record = vertex_number() / vertices_per_record;
  return record < record_count ? record : texelFetch(single_records, int(record - record_count)).x;
}
