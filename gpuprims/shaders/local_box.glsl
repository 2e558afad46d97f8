// The bounding box of a ray-cast primitive in its record's frame, and the axis along which its rays may be shifted. It
// handles all kinds, so that one program sets up all of them. Each kind's own file describes its record.
#include "payload.glsl"
#include "wedge.glsl"

layout(location = 1) uniform uint batch_kind;  // gpuscene::BatchKind; its values come as defines
layout(location = 2) uniform int texels_per_record;

struct LocalBox {
  vec3 low, high;
  vec3 axis;  // shift per z; 0 for kinds that are not shifted
};

vec4 shape_texel(uint record, int texel) { return payload_floats(record, texels_per_record, min(texel, texels_per_record - 1)); }

vec3 leaning_axis(vec2 offset, float height) { return vec3(height > 0.0 ? offset / height : vec2(0.0), 1.0); }

// The cone's circles at the lowest and highest z bound everything between.
LocalBox snout_box(vec4 ends, vec2 range, float height) {
  vec2 part = height > 0.0 ? range / height : vec2(0.0);
  vec2 c0 = ends.zw * part.x, c1 = ends.zw * part.y;
  float mean = 0.5 * (ends.x + ends.y), widening = ends.y - ends.x;
  float r0 = max(0.0, mean + widening * part.x), r1 = max(0.0, mean + widening * part.y);
  return LocalBox(vec3(min(c0 - r0, c1 - r1), range.x), vec3(max(c0 + r0, c1 + r1), range.y), leaning_axis(ends.zw, height));
}

// Box of a sweep between two distances from the axis, `reach` above and below.
LocalBox swept_box(vec4 sweep, float inner, float outer, float reach, vec3 axis) {
  vec4 box = sweep.y > 0.0 ? vec4(-outer, -outer, outer, outer) : sweep_box(sweep.zw, inner, outer);
  return LocalBox(vec3(box.xy, -reach), vec3(box.zw, reach), axis);
}

// `extra`: the shape's first parameter, from the record's head.
LocalBox local_box(uint record, float extra) {
  const vec3 along_z = vec3(0.0, 0.0, 1.0);
  vec4 first = shape_texel(record, 4);
  float half_height = 0.5 * extra;
  switch (batch_kind) {
    case CYLINDER_KIND:
      return LocalBox(vec3(-1.0, -1.0, -half_height), vec3(1.0, 1.0, half_height), along_z);
    case SNOUT_KIND:
      return snout_box(first, shape_texel(record, 6).xy, extra);
    case CIRCULAR_TORUS_KIND:
      return swept_box(first, max(first.x - extra, 0.0), first.x + extra, extra, vec3(0.0));
    case SPHERE_CAP_KIND:
      return LocalBox(vec3(-1.0, -1.0, extra < 1.0 ? 0.0 : 1.0 - extra), vec3(1.0, 1.0, min(extra, 1.0)), vec3(0.0));
    case RECTANGULAR_TORUS_KIND:
      return swept_box(first, first.x, 1.0, half_height, along_z);
    case PYRAMID_KIND:
      vec2 offset = shape_texel(record, 5).xy, end = 0.5 * offset;
      return LocalBox(vec3(min(-end - first.xy, end - first.zw), -half_height), vec3(max(first.xy - end, end + first.zw), half_height),
                      leaning_axis(offset, extra));
    default:  // BOX_KIND
      return LocalBox(vec3(-0.5), vec3(0.5), vec3(0.0));
  }
}
