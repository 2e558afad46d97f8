// Which record a vertex belongs to: every instance is one, and its eight vertices are numbered by the index buffer.
in uint drawn_record;

uint vertex_number() { return uint(gl_VertexID); }

uint record_of(uint vertices_per_record) { return drawn_record; }
