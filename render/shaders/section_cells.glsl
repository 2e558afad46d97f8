// What section passes store per pixel: render/internal/section_caps.h.

struct Cell {
  int winding;   // number of meshes that the point of the cut face is in
  uint records;  // sum of record + 1 over the crossings that leave a mesh, minus those that enter one
  uint head;     // first node of the list of crossings: place + 1; 0 when empty
};

struct Node {
  uint crossing;  // record << 1 | 1 when the ray leaves the mesh there
  uint next;      // as Cell::head
};

layout(std430, binding = 1) restrict coherent buffer Cells { Cell cells[]; };
layout(std430, binding = 2) restrict coherent buffer Nodes {
  uint node_count;
  uint padding;
  Node nodes[];
};

layout(location = 1) uniform int row_length;

int cell_of_pixel() { return int(gl_FragCoord.y) * row_length + int(gl_FragCoord.x); }
