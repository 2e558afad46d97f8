// Which parts of meshes a view draws: those of a cut, in the view volume, that are selected.
//
// Each part decides for itself. No mesh gets a hole and none is drawn twice, since a group's decision is the same for
// all parts that it concerns: it depends on nothing else, and `precise` leaves the compiler no choice. And a group that
// is allowed to replace parts lies around those that made these, with a larger error. Each operation rounds
// monotonically, so these are allowed, too. The C++ side: lod/internal/cut.h.
#include "item_test.glsl"
#include "part_data.glsl"

// What rounding adds to a linear form, relative to the sum of the sizes of its terms: some ten operations of 2^-23 each.
const float kFormRounding = 2e-6;

struct Instance {
  mat3x4 rows;  // of its placement, relative to the origin of all boxes
  float stretch;
  uint record;
};

Instance fetch_instance(uint place) {
  uvec4 last = detail(place + 3u);
  return Instance(mat3x4(uintBitsToFloat(detail(place)), uintBitsToFloat(detail(place + 1u)),
                         uintBitsToFloat(detail(place + 2u))),
                  uintBitsToFloat(last.x), last.y);
}

// A linear form of a mesh's points, and sums of the sizes of what its coefficients are made of.
struct Form {
  vec4 value, size;
};

Form in_mesh(vec4 form, Instance instance) {
  precise vec4 x = form.x * instance.rows[0], y = form.y * instance.rows[1], z = form.z * instance.rows[2];
  precise vec4 value = (x + y) + (z + vec4(0.0, 0.0, 0.0, form.w));
  precise vec4 size = (abs(x) + abs(y)) + (abs(z) + vec4(0.0, 0.0, 0.0, abs(form.w)));
  return Form(value, size);
}

// At most the least value in a box; not more for a box around it.
float least(Form form, vec3 low, vec3 high) {
  precise vec3 terms = form.value.xyz * mix(high, low, greaterThan(form.value.xyz, vec3(0.0)));
  precise vec3 sizes = form.size.xyz * max(abs(low), abs(high));
  precise float value = ((terms.x + terms.y) + terms.z) + form.value.w;
  precise float size = ((sizes.x + sizes.y) + sizes.z) + form.size.w;
  precise float bound = value - kFormRounding * size;
  return bound;
}

bool may_be_cut(vec4 section, Instance instance, vec3 low, vec3 high) {
  Form form = in_mesh(section, instance);
  return least(form, low, high) <= 0.0 && least(Form(-form.value, form.size), low, high) <= 0.0;
}

// Whether the image may show an error in a box of a mesh: lod::MeshError::allowed(), rounded towards more detail.
bool allows(float error, vec3 low, vec3 high, Instance instance) {
  for (int i = 0; i < cull.section_count; ++i)
    if (may_be_cut(cull.sections[i], instance, low, high)) return false;
  float w = max(least(in_mesh(cull.w, instance), low, high), cull.nearest_w);
  precise float moved = error * instance.stretch, allowed = cull.error_per_w * w;
  return cull.error_per_w > 0.0 && w > 0.0 && moved <= allowed;
}

// Whether what a group has made is shown, or something coarser.
bool simplified(uint group, Instance instance) {
  uvec4 low = detail(group), high = detail(group + 1u);
  return allows(uintBitsToFloat(low.w), uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz), instance);
}

// Returns a cluster of parts, or kRejected. Section planes reject none: the caps of cut faces need all that lies behind.
uint test_part_cluster(uint cluster) {
  int at = int(kPartClusterTexels * cluster);
  uvec4 a = texelFetch(part_clusters, at), b = texelFetch(part_clusters, at + 1);
  vec3 low = uintBitsToFloat(a.xyz), high = uintBitsToFloat(uvec3(a.w, b.xy));
  if (any(greaterThan(low, high))) return kRejected;
  if (outside_one_of(cull.frustum_planes, low, high) || !cluster_selected(low, high)) return kRejected;
  uvec4 c = texelFetch(part_clusters, at + 2), last = texelFetch(part_clusters, at + 3);
  if (last.y == kRejected) return cluster;
  vec3 replacing_low = uintBitsToFloat(uvec3(b.zw, c.x)), replacing_high = uintBitsToFloat(c.yzw);
  bool replaced = allows(uintBitsToFloat(last.x), replacing_low, replacing_high, fetch_instance(last.y));
  return replaced ? kRejected : cluster;
}

// Turns the box of a mesh's part into one around what a GPU draws of it, in the coordinates of item boxes.
void place_box(Instance instance, inout vec3 low, inout vec3 high) {
  vec3 mesh_low = low, mesh_high = high, size = max(abs(low), abs(high));
  for (int i = 0; i < 3; ++i) {
    vec4 row = instance.rows[i];
    precise vec3 a = row.xyz * mesh_low, b = row.xyz * mesh_high, s = abs(row.xyz) * size;
    vec3 least = min(a, b), most = max(a, b);
    precise float rounding = kVertexRounding * (((s.x + s.y) + s.z) + abs(row.w));
    precise float from = (((least.x + least.y) + least.z) + row.w) - rounding;
    precise float to = (((most.x + most.y) + most.z) + row.w) + rounding;
    low[i] = from;
    high[i] = to;
  }
}

// Tests part `i` of a cluster that test_part_cluster() has kept. Returns it, or kRejected.
uint test_part(uint cluster, uint i) {
  uint part = kItemsPerCluster * cluster + i;
  uvec2 place = fetch_part(part);
  if (place.x == kRejected) return kRejected;
  Instance instance = fetch_instance(place.x);
  int record = int(instance.record);
  vec3 item_low = texelFetch(item_boxes, 2 * record).xyz, item_high = texelFetch(item_boxes, 2 * record + 1).xyz;
  if (any(greaterThan(item_low, item_high))) return kRejected;  // vacant
  if (cull.section_count > 0 && outside(item_low, item_high)) return kRejected;
  if (cull.use_layers && (texelFetch(item_layers, record).x & cull.view_layers) == 0u) return kRejected;
  uvec2 groups = detail(place.y + 2u).xy;
  if (groups.x != kRejected && !simplified(groups.x, instance)) return kRejected;
  if (groups.y != kRejected && simplified(groups.y, instance)) return kRejected;
  vec3 low = uintBitsToFloat(detail(place.y).xyz), high = uintBitsToFloat(detail(place.y + 1u).xyz);
  place_box(instance, low, high);
  low = max(low, item_low);
  high = min(high, item_high);
  if (outside_one_of(cull.frustum_planes, low, high)) return kRejected;
  return selected(part, low, high) ? part : kRejected;
}
