// What is tested: the records of a batch, and where meshes have levels of detail their parts.
#include "item_test.glsl"

#ifdef PARTS
#include "part_test.glsl"

uint keep_cluster(uint cluster) {
  return of_parts != 0 ? test_part_cluster(cluster) : test_cluster(cluster);
}

uint keep(uint cluster, uint i, out bool in_view) {
  in_view = false;
  return of_parts != 0 ? test_part(cluster, i) : test_item(cluster, i, in_view);
}
#else
uint keep_cluster(uint cluster) {
  return test_cluster(cluster);
}

uint keep(uint cluster, uint i, out bool in_view) {
  return test_item(cluster, i, in_view);
}
#endif
