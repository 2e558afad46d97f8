// Tests the items of a cluster that test_cluster() has kept.
#include "cull_test.glsl"

layout(binding = 2) uniform samplerBuffer item_boxes;  // two texels each: least and greatest corner
layout(binding = 3) uniform usamplerBuffer item_layers;

// Tests item `i` of a cluster that test_cluster() has kept. Returns its record, or kRejected; `in_view`: whether it is
// in the view volume, selected or not.
uint test_item(uint tested, uint i, out bool in_view) {
  in_view = false;
  uint cluster = tested & ~kInsideBit, record = cluster * kItemsPerCluster + i;
  vec3 low = texelFetch(item_boxes, 2 * int(record)).xyz, high = texelFetch(item_boxes, 2 * int(record) + 1).xyz;
  if (any(greaterThan(low, high))) return kRejected;  // entries without an item hold the inverted box
  if (cull.use_layers && (texelFetch(item_layers, int(record)).x & cull.view_layers) == 0u) return kRejected;
  if ((tested & kInsideBit) == 0u && outside(low, high)) return kRejected;
  in_view = true;
  return selected(record, low, high) ? record : kRejected;
}
