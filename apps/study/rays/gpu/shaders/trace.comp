// An invocation a ray; a work group, as wide as a warp, has a tile of the image. With PERSISTENT there are as many
// groups as the caller wants, and each takes tiles from one counter until there are no more, or it had its share
// (T. Aila, S. Laine, "Understanding the Efficiency of Ray Traversal on GPUs", 2009).
layout(local_size_x = 32) in;

struct Answer {  // GpuAnswer of ray_batch.h
  double t;
  uint triangle, nodes, triangles, unused;
};
layout(std430, binding = 1) writeonly restrict buffer Answers {
  Answer answers[];
};
layout(location = 0) uniform uvec3 image;  // width and height in tiles, and in rays the width
layout(location = 1) uniform uvec2 tile;   // size in rays; 32 in all
layout(location = 2) uniform uint ray_count;

void trace(uvec2 of_tile) {
  uvec2 place = of_tile * tile + uvec2(gl_LocalInvocationIndex % tile.x, gl_LocalInvocationIndex / tile.x);
  uint index = place.y * image.z + place.x;
  if (place.x >= image.z || index >= ray_count) return;
  ray = rays[index];
  ray_exit = ray.unit_origin.w;
  hit_t = ray.start.w;
  hit_triangle = kNone;
  nearest = uintBitsToFloat(0x7f800000u);  // infinity
  nodes_visited = triangles_tested = 0u;
  if (ray_exit >= 0.0) walk();
  answers[index] = Answer(hit_t, hit_triangle, nodes_visited, triangles_tested, 0u);
}

#ifdef PERSISTENT
layout(std430, binding = 7) coherent restrict buffer Next {
  uint next_tile;
};
layout(location = 3) uniform uint most_tiles;  // of a group
shared uint taken;

void main() {
  for (uint had = 0u; had < most_tiles; ++had) {
    if (gl_LocalInvocationIndex == 0u) taken = atomicAdd(next_tile, 1u);
    barrier();
    uint number = taken;
    barrier();
    if (number >= image.x * image.y) return;
    trace(uvec2(number % image.x, number / image.x));
  }
}
#else
void main() { trace(gl_WorkGroupID.xy); }
#endif
