// Nothing is wrong on these lines,
// nor on this one,
#include "broken.glsl"

void main() { gl_Position = vec4(broken()); }
