// What a fragment of one sample is told about its place.
layout(location = 0) out vec4 o_coordinate;  // gl_FragCoord, and the number of the sample
layout(location = 1) out vec4 o_sample;      // gl_SamplePosition

void main() {
  gl_SampleMask[0] = 1 << gl_SampleID;
  o_coordinate = vec4(gl_FragCoord.xyz, float(gl_SampleID));
  o_sample = vec4(gl_SamplePosition, 0.0, 1.0);
}
