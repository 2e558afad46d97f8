// Where a fragment's ray goes through the image, and the depth that the rasteriser has there. SAMPLES: through the
// fragment's sample, else through the pixel's centre. With samples some drivers (llvmpipe) have gl_FragCoord tell the
// place of the sample, and others (NVIDIA's) that of the centre, depth included.
#ifdef SAMPLES
vec2 fragment_place() { return floor(gl_FragCoord.xy) + gl_SamplePosition; }
// Before any discard, since it takes derivatives.
float fragment_depth(vec2 place) {
  vec2 slope = vec2(dFdx(gl_FragCoord.z), dFdy(gl_FragCoord.z));
  return gl_FragCoord.z + dot(slope, place - gl_FragCoord.xy);
}
#else
vec2 fragment_place() { return gl_FragCoord.xy; }
float fragment_depth(vec2 place) { return gl_FragCoord.z; }
#endif
