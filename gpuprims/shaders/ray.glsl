// A pixel's ray in a primitive's local space and the search for its first visible crossing. Affine maps keep a ray's t, so t is
// eye depth throughout.

struct PixelRay {
  vec3 eye_origin, eye_direction;
};

PixelRay pixel_ray(vec2 pixel) {
  vec2 ndc = pixel * view.pixel_to_ndc.xy - 1.0;
  return PixelRay(view.ray_origin.xyz + ndc.x * view.ray_origin_dx.xyz + ndc.y * view.ray_origin_dy.xyz,
                  view.ray_direction.xyz + ndc.x * view.ray_direction_dx.xyz + ndc.y * view.ray_direction_dy.xyz);
}

const float kNoHit = 3.0e38;

// The nearest crossing found so far that the view keeps.
struct Search {
  PixelRay ray;
  float t_shift;   // eye depth of the moved local origin (see intersect functions)
  float t;         // kNoHit while nothing was found
  vec3 normal;     // local, outward gradient
};

bool view_keeps(PixelRay ray, float t) {
  return t >= view.depth_range.x && t <= view.depth_range.y && sections_keep(ray.eye_origin + t * ray.eye_direction);
}

// Offers a crossing at local parameter `t` (counted from the moved origin).
void offer(inout Search s, float t, vec3 normal) {
  float depth = s.t_shift + t;
  if (depth < s.t && view_keeps(s.ray, depth)) {
    s.t = depth;
    s.normal = normal;
  }
}

// The part of a ray inside a half-space with value v0 + t v1 >= 0 narrows [t0, t1]; `side` says which bound is the half-space's.
void clip_interval(float v0, float v1, int side, inout float t0, inout float t1, inout int side0, inout int side1) {
  if (v1 == 0.0) {
    if (v0 < 0.0) t1 = -kNoHit;
    return;
  }
  float t = -v0 / v1;
  if (v1 > 0.0) {
    if (t > t0) { t0 = t; side0 = side; }
  } else {
    if (t < t1) { t1 = t; side1 = side; }
  }
}
