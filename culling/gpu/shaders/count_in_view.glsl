// Counts the items of the view volume, selected or not: as points of a second stream, which nobody captures and a query
// counts.

#ifdef COUNTS_IN_VIEW

layout(location = 1) flat in uint counted[];

void count_in_view() {
  if (counted[0] == 0u) return;
  EmitStreamVertex(1);
  EndStreamPrimitive(1);
}

#else

void count_in_view() {}

#endif
