// core::Aabb in an array.
struct Box {
  float low_x, low_y, low_z, high_x, high_y, high_z;
};
vec3 low_of(Box b) { return vec3(b.low_x, b.low_y, b.low_z); }
vec3 high_of(Box b) { return vec3(b.high_x, b.high_y, b.high_z); }
