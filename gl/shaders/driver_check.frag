// Writes a lesser depth than the triangle's into pixels below `less_below`, as ray-cast solids do.
layout(location = 4) uniform float less_below;
layout(location = 5) uniform float less_depth;

#ifdef WRITES_DEPTH
layout(depth_less) out float gl_FragDepth;
#endif
layout(location = 0) flat in uint number;
layout(location = 0) out uint drawn;

void main() {
#ifdef WRITES_DEPTH
  gl_FragDepth = gl_FragCoord.x < less_below ? min(less_depth, gl_FragCoord.z) : gl_FragCoord.z;
#endif
  drawn = number + 1u;
}
