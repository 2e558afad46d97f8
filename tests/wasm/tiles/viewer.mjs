// The page: shows a tileset from one view, shaded as sightline-render --plain does, and tells what it shows.
import * as THREE from 'three';
import { TilesRenderer } from '3d-tiles-renderer/three';
import { GLTFExtensionsPlugin } from '/modules/3d-tiles-renderer/src/three/plugins/GLTFExtensionsPlugin.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

// A light at the eye and a hemisphere of sky, computed in sRGB as the tools do (render/shaders/shading.glsl).
const background = new THREE.Color().setRGB(0.86, 0.88, 0.91, THREE.SRGBColorSpace);  // of --plain

const shading = `
  vec3 facing = normalize( normal );
  vec3 to_viewer = isOrthographic ? vec3( 0.0, 0.0, 1.0 ) : normalize( vViewPosition );
  if ( dot( facing, to_viewer ) < 0.0 ) facing = - facing;
  float head = dot( facing, to_viewer );
  float sky = 0.5 + 0.5 * dot( facing, normalize( ( viewMatrix * vec4( 0.0, 0.0, 1.0, 0.0 ) ).xyz ) );
  vec3 paint = sRGBTransferOETF( vec4( diffuseColor.rgb, 1.0 ) ).rgb;
  vec3 lit = min( paint * ( 0.30 + 0.50 * head + 0.25 * sky ) + 0.12 * pow( head, 24.0 ), vec3( 1.0 ) );
  gl_FragColor = vec4( lit, 1.0 );
`;

function shade(material) {
  material.side = THREE.DoubleSide;
  material.transparent = false;
  material.toneMapped = false;
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace('#include <opaque_fragment>', shading)
      .replace('#include <colorspace_fragment>', '');
  };
}

function cameraOf(view, width, height) {
  const eye = new THREE.Vector3(...view.eye), target = new THREE.Vector3(...view.target);
  const near = view.near ?? 0.1, far = view.far ?? Math.max(near * 1e5, 4 * eye.distanceTo(target));
  let camera;
  if (view.ortho_height) {
    const half = 0.5 * view.ortho_height, across = half * width / height;
    camera = new THREE.OrthographicCamera(-across, across, half, -half, near, far);
  } else {
    camera = new THREE.PerspectiveCamera(view.fovy_deg, width / height, near, far);
  }
  camera.up.set(...(view.up ?? [0, 0, 1]));
  camera.position.copy(eye);
  camera.lookAt(target);
  camera.updateMatrixWorld(true);
  return camera;
}

/** How far positions lie outside the boxes of their tile and of those above, metres, and how many were looked at. */
function outside(model, tile) {
  const of = new THREE.Matrix4(), one = new THREE.Matrix4(), point = new THREE.Vector3();
  let most = 0, count = 0;
  model.updateMatrixWorld(true);
  model.traverse((object) => {
    const positions = object.geometry?.getAttribute('position');
    for (let i = 0; positions && i < (object.isInstancedMesh ? object.count : 1); ++i) {
      of.copy(object.matrixWorld);
      if (object.isInstancedMesh) {
        object.getMatrixAt(i, one);
        of.multiply(one);
      }
      for (let k = 0; k < positions.count; ++k, ++count) {
        point.fromBufferAttribute(positions, k).applyMatrix4(of);
        for (let box = tile; box; box = box.parent)
          most = Math.max(most, box.engineData.boundingVolume.distanceToPoint(point));
      }
    }
  });
  return { most, count };
}

/** Name, attributes and the names of the nodes above of each feature of a mesh. */
function featureOf(mesh, point) {
  const { meshFeatures, structuralMetadata } = mesh.userData;
  if (!meshFeatures || !structuralMetadata) return null;
  const [id] = meshFeatures.getFeatures(point.faceIndex, point.barycoord);
  const names = [];
  const row = (of) => ({ ...structuralMetadata.getPropertyTableData([0], [of])[0] });
  const properties = row(id);
  for (let at = id, data = properties; ; at = data.parent, data = row(at)) {
    names.unshift(data.name);
    if (data.parent === at || names.length > 64) break;
  }
  return { path: names.join('/'), properties };
}

window.show = async ({ tileset, view, width, height, error }) => {
  // Coordinates far from the origin: the scene is moved to the eye's neighbourhood in doubles.
  const origin = new THREE.Vector3(...view.target).round();
  const here = { ...view, eye: view.eye.map((x, i) => x - origin.getComponent(i)),
    target: view.target.map((x, i) => x - origin.getComponent(i)) };

  const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true, reversedDepthBuffer: true });
  renderer.setPixelRatio(1);
  renderer.setSize(width, height);
  renderer.setClearColor(background, 1);
  document.body.appendChild(renderer.domElement);
  const scene = new THREE.Scene();
  const camera = cameraOf(here, width, height);

  const tiles = new TilesRenderer(tileset);
  tiles.registerPlugin(new GLTFExtensionsPlugin({ meshoptDecoder: MeshoptDecoder }));
  tiles.errorTarget = error;
  tiles.lruCache.maxBytesSize = 4e9;
  tiles.lruCache.minBytesSize = 3e9;
  tiles.setCamera(camera);
  tiles.setResolution(camera, width, height);
  tiles.group.position.copy(origin).negate();
  scene.add(tiles.group);
  const contained = { most: 0, count: 0 };
  tiles.addEventListener('load-model', ({ scene: model, tile }) => {
    model.traverse((of) => of.isMesh && shade(of.material));
    const { most, count } = outside(model, tile);
    contained.most = Math.max(contained.most, most);
    contained.count += count;
  });
  const failures = [];
  tiles.addEventListener('load-error', ({ error: why, url }) => failures.push(`${url}: ${why}`));

  // Until nothing is loading in several frames.
  const began = performance.now();
  let quiet = 0;
  while (quiet < 5 && performance.now() - began < 240e3) {
    tiles.group.updateMatrixWorld(true);
    camera.updateMatrixWorld(true);
    tiles.update();
    const { downloading, parsing, queued } = tiles.stats;
    quiet = tiles.root && !(downloading || parsing || queued) ? quiet + 1 : 0;
    await new Promise((next) => setTimeout(next, 30));
  }
  const loaded = performance.now() - began;
  renderer.render(scene, camera);
  renderer.getContext().finish();

  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2(0, 0), camera);
  const hit = ray.intersectObjects(scene.children, true).find(({ object, barycoord }) => object.isMesh && barycoord);
  return {
    shown: tiles.visibleTiles.size, loaded: tiles.stats.loaded ?? tiles.lruCache.itemList.length, failures, outside: contained,
    load_ms: Math.round(loaded), triangles: renderer.info.render.triangles, draw_calls: renderer.info.render.calls,
    middle: hit ? { distance: hit.distance, feature: featureOf(hit.object, hit) } : null,
  };
};
window.ready = true;
