// Where a fragment's ray goes through the image, and the reversed zero-to-one depth that the rasteriser has there.
vec2 fragment_place() { return gl_FragCoord.xy - view.viewport.zw; }

float fragment_depth(vec2 place) {
#if defined(LOGARITHMIC_DEPTH)
  return 1.0;  // its depth buffer has other numbers, which rounding cannot mix up with the rasteriser's
#elif defined(REVERSED_DEPTH)
  return gl_FragCoord.z;
#else
  return 1.0 - gl_FragCoord.z;
#endif
}
