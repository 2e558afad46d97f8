// An entry of most stacks: a node, and the part of the ray in it.
struct Entry {
  uint node;
  vec2 t;
};
