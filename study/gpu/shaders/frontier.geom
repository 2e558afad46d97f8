// Walks the subtree of one node of the cut by escape index and writes what is visible as ranges of places, neighbours
// in one. A subtree of more than MAX_RANGES ranges ends with one that holds all that was not looked at any more.
#include "box_test.glsl"

layout(points) in;
layout(points, max_vertices = MAX_RANGES) out;

layout(binding = 6) uniform usamplerBuffer nodes;  // two texels each: min and escape index, max and first place

const uint kNotLookedAt = 0x80000000u;  // study::Frontier's

layout(location = 0) flat in uint node[];
layout(location = 0) flat out uvec2 range;  // first place, and how many

struct Node {
  vec3 low, high;
  uint escape, first;
};

Node fetch_node(uint i) {
  uvec4 a = texelFetch(nodes, int(2u * i)), b = texelFetch(nodes, int(2u * i + 1u));
  return Node(uintBitsToFloat(a.xyz), uintBitsToFloat(b.xyz), a.w, b.w);
}

uint first_of(uint i) { return texelFetch(nodes, int(2u * i + 1u)).w; }

uint open_first = 0u, open_end = 0u, written = 0u, subtree_end = 0u;

void write(uint first, uint count) {
  range = uvec2(first, count);
  EmitVertex();
  ++written;
}

// Appends places; false when that was the end of the room.
bool add(uint first, uint end) {
  if (first != open_end && open_first < open_end) {
    if (written + 1u == uint(MAX_RANGES)) {
      write(open_first, (subtree_end - open_first) | kNotLookedAt);
      return false;
    }
    write(open_first, open_end - open_first);
  }
  if (first != open_end || open_first == open_end) open_first = first;
  open_end = end;
  return true;
}

bool add_items(uint first, uint end) {
  for (uint i = first; i < end; ++i) {
    vec3 low = texelFetch(boxes, int(2u * i)).xyz, high = texelFetch(boxes, int(2u * i + 1u)).xyz;
    if (!is_empty(low, high) && !outside(low, high) && !add(i, i + 1u)) return false;
  }
  return true;
}

void main() {
  uint stop = fetch_node(node[0]).escape;
  subtree_end = first_of(stop);
  for (uint i = node[0]; i < stop;) {
    Node n = fetch_node(i);
    uint next = n.escape;
    if (!outside(n.low, n.high)) {
      bool room = true;
      if (inside(n.low, n.high)) room = add(n.first, first_of(n.escape));
      else if (n.escape == i + 1u) room = add_items(n.first, first_of(n.escape));
      else next = i + 1u;
      if (!room) return;
    }
    i = next;
  }
  if (open_first < open_end) write(open_first, open_end - open_first);
}
