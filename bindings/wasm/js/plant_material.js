// The material of a plant's meshes: lit as its ray-cast primitives are (shading.glsl), by no lights of the scene.

import { DoubleSide, ShaderMaterial, Vector3 } from 'three';

const vertexShader = `
#include <common>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
attribute vec4 colour;    // sRGB, alpha
attribute float pattern;  // of dithering: the item's number modulo 4
flat varying vec4 surface;
flat varying uint shift;
varying vec3 to_eye;
#ifndef FLAT
varying vec3 eye_normal;
#endif

void main() {
  surface = colour;
  shift = uint(pattern);
  #include <begin_vertex>
  #include <project_vertex>
  #include <logdepthbuf_vertex>
  #include <clipping_planes_vertex>
  to_eye = -mvPosition.xyz;
#ifndef FLAT
  eye_normal = (modelViewMatrix * vec4(transpose(inverse(mat3(instanceMatrix))) * normal, 0.0)).xyz;
#endif
}
`;

const fragmentShader = `
#include <common>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
uniform vec3 up;
flat varying vec4 surface;
flat varying uint shift;
varying vec3 to_eye;
#ifndef FLAT
varying vec3 eye_normal;
#endif

// As dithered_away() of shading.glsl.
bool is_dithered_away() {
  uvec2 pixel = uvec2(gl_FragCoord.xy) + uvec2(shift * 7u, shift * 3u);
  uint across = pixel.x ^ pixel.y;
  uint rank = (across & 1u) << 3 | (pixel.y & 1u) << 2 | (across & 2u) | (pixel.y & 2u) >> 1;
  return surface.a < (float(rank) + 0.5) / 16.0;
}

vec3 light_of(vec3 srgb) {
  return mix(pow((srgb + 0.055) / 1.055, vec3(2.4)), srgb / 12.92, lessThanEqual(srgb, vec3(0.04045)));
}

void main() {
  #include <clipping_planes_fragment>
  #include <logdepthbuf_fragment>
  if (surface.a < 1.0 && is_dithered_away()) discard;
  vec3 to_viewer = isOrthographic ? vec3(0.0, 0.0, 1.0) : normalize(to_eye);
#ifdef FLAT
  vec3 n = normalize(cross(dFdx(to_eye), dFdy(to_eye)));
#else
  vec3 n = normalize(eye_normal);
#endif
  if (dot(n, to_viewer) < 0.0) n = -n;  // both sides are lit
  float head = dot(n, to_viewer);
  float light = 0.30 + 0.50 * head + 0.25 * (0.5 + 0.5 * dot(n, up));
  vec3 lit = min(surface.rgb * light + 0.12 * pow(head, 24.0), vec3(1.0));
  gl_FragColor = vec4(light_of(lit), 1.0);
  #include <colorspace_fragment>
}
`;

/** @param {boolean} flat whether meshes have no normals */
export function plantMaterial(flat) {
  return new ShaderMaterial({
    name: flat ? 'flat meshes of a plant' : 'meshes of a plant',
    side: DoubleSide,
    clipping: true,
    defines: flat ? { FLAT: '' } : {},
    uniforms: { up: { value: new Vector3() } },
    vertexShader,
    fragmentShader,
  });
}

/**
 * Sets what depends on the camera, as Object3D.onBeforeRender.
 * @param {any} _renderer
 * @param {any} _scene
 * @param {import('three').Camera} camera
 * @param {any} _geometry
 * @param {any} material
 */
export function followCamera(_renderer, _scene, camera, _geometry, material) {
  material.uniforms.up.value.copy(camera.up).transformDirection(camera.matrixWorldInverse);
  material.uniformsNeedUpdate = true;
}
