// Items of a cluster that test_cluster() has kept, whose boxes are there in one of several forms (GpuBoundsForm).
#include "cull_test.glsl"

layout(binding = 3) uniform usamplerBuffer item_layers;

// item_present(): whether there is an item at a place of a cluster. item_box(): its box, or one around it.
#if defined(BOUNDS_FLOAT)
layout(binding = 2) uniform samplerBuffer item_boxes;  // two texels each: min, max

void item_box(uint cluster, uint i, out vec3 low, out vec3 high) {
  int place = 2 * int(cluster * kItemsPerCluster + i);
  low = texelFetch(item_boxes, place).xyz;
  high = texelFetch(item_boxes, place + 1).xyz;
}

// Vacant places hold the inverted box.
bool item_present(uint cluster, uint i) {
  vec3 low, high;
  item_box(cluster, i, low, high);
  return !any(greaterThan(low, high));
}

#elif defined(BOUNDS_COMPACT)
#include "compact_box.glsl"

layout(binding = 2) uniform usamplerBuffer item_boxes;  // culling::CompactBox

bool item_present(uint cluster, uint i) {
  return (texelFetch(item_boxes, int(cluster * kItemsPerCluster + i)).x & kVacant) == 0u;
}

void item_box(uint cluster, uint i, out vec3 low, out vec3 high) {
  expand(texelFetch(item_boxes, int(cluster * kItemsPerCluster + i)).xy, texelFetch(cluster_boxes, 2 * int(cluster)).xyz,
         texelFetch(cluster_boxes, 2 * int(cluster) + 1).xyz, low, high);
}

#else
#include "record_box.glsl"

layout(binding = 2) uniform usamplerBuffer item_boxes;  // per cluster a bit for each item: it is there (two words),
                                                        // its record gives a box (two words)

bool item_bit(uvec2 words, uint i) {
  return ((i < 32u ? words.x : words.y) >> (i & 31u) & 1u) != 0u;
}

bool item_present(uint cluster, uint i) {
  return item_bit(texelFetch(item_boxes, int(cluster)).xy, i);
}

void item_box(uint cluster, uint i, out vec3 low, out vec3 high) {
  if (item_bit(texelFetch(item_boxes, int(cluster)).zw, i)) {
    record_box(cluster * kItemsPerCluster + i, low, high);
  } else {
    low = texelFetch(cluster_boxes, 2 * int(cluster)).xyz;
    high = texelFetch(cluster_boxes, 2 * int(cluster) + 1).xyz;
  }
}
#endif

// Item `i` of what test_cluster() has kept: its record, or kRejected.
uint test_item(uint tested, uint i) {
  uint cluster = tested & ~kInside, record = cluster * kItemsPerCluster + i;
  if (!item_present(cluster, i)) return kRejected;
  if (cull.use_layers && (texelFetch(item_layers, int(record)).x & cull.view_layers) == 0u) return kRejected;
  if ((tested & kInside) != 0u) return record;
  vec3 low, high;
  item_box(cluster, i, low, high);
  return outside(low, high) ? kRejected : record;
}
