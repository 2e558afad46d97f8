// descend() of kd_traversals.h. Who includes this defines before it what to do where all of the interval lies in one
// child, and where it is cut:
//   void in_one(uint child)
//   void in_both(uint far, vec2 t)    the far child, and the interval there
//
// The loop ends by its condition: llvmpipe of Mesa 22.3 takes a `return` within it for one of the caller's loop.

uint descend(uint node, inout vec2 t) {
  visit();
  for (uvec2 n = nodes[node]; !is_leaf(n); n = nodes[node]) {
    uint axis = axis_of(n);
    float split = at(axis, split_of(n));
    uint near = left_of(n) + uint(negative(axis)), far = left_of(n) + uint(!negative(axis));
    if (split >= t.y) {
      node = near;
      in_one(near);
    } else if (split <= t.x) {
      node = far;
      in_one(far);
    } else {
      in_both(far, vec2(split, t.y));
      node = near;
      t.y = split;
    }
    visit();
  }
  return node;
}
