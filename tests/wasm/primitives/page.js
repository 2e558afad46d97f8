// Draws each scene in every form of depth buffer and compares every pixel with the reference: whether there is something,
// its depth, and where the surface is smooth its colour, which says what normal and which item there is.
//
// The reference casts five rays in double through and around a pixel (tests/render/image_check.h). Where only some hit,
// the image may do either; where all hit, its depth must lie between theirs.
import * as THREE from 'three';

import {AnalyticPrimitives, RECORD_WORDS} from '/sightline/primitives.js';

const DEPTH_ERROR = 2e-5;        // of the eye depth, or of 1 m if that is more: as for the desktop
const COLOUR_ERROR = 2.5 / 255;  // normals turn by up to two degrees within a pixel
/** Error of a depth buffer's number itself: three steps of 24 bits; reversed: part of the number. */
const BUFFER_ERROR = 2e-7;

const log = (text) => fetch('/log', {method: 'POST', body: text});
const post = (path, content) => fetch(path, {method: 'POST', body: content});

const description = await (await fetch('/made/scenes.json')).json();
const numbers = await (await fetch('/made/scenes.bin')).arrayBuffer();
const {width, height} = description;
const words = new Uint32Array(numbers, 0, description.words);
const pixels = new Float32Array(numbers, 4 * description.words);
const keepImages = location.search.includes('images');

let failed = 0, compared = 0, scenesDrawn = 0, images = 0;
const worst = {depth: 0, colour: 0};
const counts = {clear: 0, edges: 0, silhouettes: 0, cut: 0, meshes: 0};

function check(good, text) {
  ++compared;
  if (good) return;
  if (++failed <= 20) log(`FAILED: ${text}`);
}

// ---- Scenes

/** A perspective camera whose window on the near plane is given, as an application's own would be. */
class WindowCamera extends THREE.PerspectiveCamera {
  updateProjectionMatrix() {
    if (!this.window) return;
    const [left, right, bottom, top, near, far] = this.window;
    this.projectionMatrix.makePerspective(left, right, top, bottom, near, far, this.coordinateSystem, this.reversedDepth);
    this.projectionMatrixInverse.copy(this.projectionMatrix).invert();
  }
}

function makeCamera(scene, placed) {
  const [left, right, bottom, top, near, far] = scene.window;
  let camera;
  if (scene.orthographic) {
    camera = new THREE.OrthographicCamera(left, right, top, bottom, near, far);
  } else {
    camera = new WindowCamera(50, 1, near, far);
    camera.window = scene.window;
  }
  camera.updateProjectionMatrix();
  camera.matrixWorldAutoUpdate = false;
  camera.up.set(0, 0, 1).transformDirection(placed);
  camera.matrixWorldInverse.fromArray(scene.eye_from_world).multiply(placed.clone().invert());
  camera.matrixWorld.copy(camera.matrixWorldInverse).invert();
  return camera;
}

function makePrimitives(scene) {
  const records = {}, items = {};
  for (const kind in scene.records) {
    const [first, count] = scene.records[kind];
    records[kind] = words.subarray(first, first + count);
    items[kind] = Uint32Array.from(scene.items[kind]);
  }
  return new AnalyticPrimitives({
    records,
    items,
    chunkOrigins: Float64Array.from(scene.chunk_origins),
    materials: Float32Array.from(scene.materials),
  });
}

/** What is to be disposed of when a canvas has drawn all: until then other scenes share its programs. */
const made = [];

/** The scene in three.js; `placed`: where its frame lies in the world. */
function build(scene, placed) {
  const root = new THREE.Scene(), frame = new THREE.Group();
  frame.matrixAutoUpdate = false;
  frame.matrix.copy(placed);
  root.add(frame);
  const primitives = makePrimitives(scene);
  primitives.setVisible([...(scene.drawn ?? []), 1000000]);
  const planes = scene.sections.map(([x, y, z, offset]) => new THREE.Plane(new THREE.Vector3(x, y, z), offset).normalize());
  for (const plane of planes) plane.applyMatrix4(placed);
  primitives.clippingPlanes = planes;
  primitives.clipIntersection = scene.unite;
  frame.add(primitives);
  for (const {size, matrix, item} of scene.meshes) {
    const colour = new THREE.Color().setRGB(...scene.colours[item], THREE.SRGBColorSpace);
    const mesh = new THREE.Mesh(new THREE.BoxGeometry(...size), new THREE.MeshBasicMaterial({color: colour}));
    mesh.matrixAutoUpdate = false;
    mesh.matrix.fromArray(matrix);
    mesh.material.side = THREE.DoubleSide;
    frame.add(mesh);
  }
  made.push(primitives);
  return {root, primitives};
}

// ---- Renderers

/** Copies a depth texture to floats that can be read. */
const copyMaterial = new THREE.RawShaderMaterial({
  glslVersion: THREE.GLSL3,
  depthTest: false,
  depthWrite: false,
  uniforms: {depth: {value: null}},
  vertexShader: `void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }`,
  fragmentShader: `precision highp float; uniform highp sampler2D depth; out vec4 colour;
    void main() { colour = vec4(texelFetch(depth, ivec2(gl_FragCoord.xy), 0).x); }`,
});
const copyGeometry = new THREE.BufferGeometry();
copyGeometry.setIndex([0, 1, 2]);
const copyMesh = new THREE.Mesh(copyGeometry, copyMaterial);
copyMesh.frustumCulled = false;
const copyCamera = new THREE.OrthographicCamera();

class Canvas {
  constructor(name, options) {
    this.name = name;
    this.renderer = new THREE.WebGLRenderer({antialias: false, preserveDrawingBuffer: true, ...options});
    this.renderer.debug.onShaderError = (gl, program, vertex, fragment) => {
      check(false, `${name}: ${gl.getShaderInfoLog(vertex)} ${gl.getShaderInfoLog(fragment)} ${gl.getProgramInfoLog(program)}`);
    };
    this.renderer.setSize(width, height);
    this.renderer.setClearColor(0x000000, 0.0);
    this.target = this.makeTarget(width, height);
    this.depths = new THREE.WebGLRenderTarget(width, height, {type: THREE.FloatType, depthBuffer: false});
  }

  makeTarget(wide, high) {
    const target = new THREE.WebGLRenderTarget(wide, high, {type: THREE.FloatType});
    target.depthTexture = new THREE.DepthTexture(wide, high, THREE.FloatType);
    return target;
  }

  /** Colours (light, RGBA) and depth numbers, row by row from the bottom. */
  draw(root, camera, target = this.target, x = 0, y = 0) {
    const colours = new Float32Array(4 * width * height), depths = new Float32Array(4 * width * height);
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.renderer.render(root, camera);
    this.renderer.readRenderTargetPixels(target, x, y, width, height, colours);
    if (target !== this.target) return {colours};
    copyMaterial.uniforms.depth.value = target.depthTexture;
    this.renderer.setRenderTarget(this.depths);
    this.renderer.render(copyMesh, copyCamera);
    this.renderer.readRenderTargetPixels(this.depths, 0, 0, width, height, depths);
    return {colours, depths: depths.filter((_, i) => i % 4 === 0)};
  }
}

/** The number that a depth buffer holds of an eye depth, and the change per metre. */
function depthNumber(canvas, scene, t) {
  const [, , , , near, far] = scene.window;
  const reversed = scene.orthographic ? (far - t) / (far - near) : near / (far - near) * (far / t - 1.0);
  const slope = scene.orthographic ? 1.0 / (far - near) : near * far / (far - near) / (t * t);
  if (canvas.name === 'reversed') return {number: reversed, slope, rounding: BUFFER_ERROR * Math.max(reversed, 1e-3)};
  if (canvas.name === 'logarithmic' && !scene.orthographic)
    return {number: Math.log2(1.0 + t) / Math.log2(1.0 + far), slope: 1.0 / ((1.0 + t) * Math.log(1.0 + far)), rounding: BUFFER_ERROR};
  return {number: 1.0 - reversed, slope, rounding: BUFFER_ERROR};
}

// ---- Comparison

const light = (srgb) => srgb <= 0.04045 ? srgb / 12.92 : ((srgb + 0.055) / 1.055) ** 2.4;
const srgbOf = (value) => value <= 0.0031308 ? value * 12.92 : 1.055 * value ** (1.0 / 2.4) - 0.055;

/** The colour of a surface as shading.glsl has it, sRGB. */
function shaded(colour, normal, direction, up) {
  const head = -normal.dot(direction), sky = 0.5 + 0.5 * normal.dot(up);
  return colour.map((c) => Math.min(c * (0.30 + 0.50 * head + 0.25 * sky) + 0.12 * head ** 24, 1.0));
}

/** Direction of a pixel's ray in eye space. */
function rayOf(scene, x, y) {
  if (scene.orthographic) return new THREE.Vector3(0, 0, -1);
  const [left, right, bottom, top, near] = scene.window;
  return new THREE.Vector3(left + (right - left) * (x + 0.5) / width, top - (top - bottom) * (y + 0.5) / height, -near).normalize();
}

function compare(canvas, scene, name, {colours, depths}) {
  const up = new THREE.Vector3(0, 0, 1).transformDirection(new THREE.Matrix4().fromArray(scene.eye_from_world));
  const meshItems = new Set(scene.meshes.map(({item}) => item));
  const before = failed;
  let shown = 0;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const at = scene.pixels + description.numbers * (y * width + x), i = (height - 1 - y) * width + x;
      const [hits, smooth, low, high, nx, ny, nz, item, cut] = pixels.subarray(at, at + description.numbers);
      const where = `${name}, pixel ${x}, ${y}: `, hit = colours[4 * i + 3] > 0.5;
      shown += hit;
      if (hits === 0 || hits === 5) check(hit === (hits === 5), `${where}${hit ? 'something' : 'nothing'}, ${hits} of 5 rays hit`);
      if (!hit || hits < 5) {
        counts.silhouettes += hits > 0 && hits < 5;
        continue;
      }
      counts[smooth ? 'clear' : 'edges'] += 1;
      counts.cut += cut;
      counts.meshes += meshItems.has(item);
      if (depths) {
        const slack = DEPTH_ERROR * Math.max(1.0, Math.abs(high)) + (smooth ? 0.0 : high - low);
        const one = depthNumber(canvas, scene, low), other = depthNumber(canvas, scene, high);
        const least = Math.min(one.number, other.number), most = Math.max(one.number, other.number);
        const off = Math.max(least - depths[i], depths[i] - most, 0.0);
        const allowed = slack * Math.max(one.slope, other.slope) + Math.max(one.rounding, other.rounding);
        worst.depth = Math.max(worst.depth, off / allowed);
        check(off <= allowed, `${where}depth ${depths[i]}, not ${least} to ${most}, ${allowed} allowed`);
      }
      if (!smooth) continue;
      const plain = scene.colours[item];
      const expected = meshItems.has(item) ? plain : shaded(plain, new THREE.Vector3(nx, ny, nz), rayOf(scene, x, y), up);
      const seen = [0, 1, 2].map((c) => srgbOf(colours[4 * i + c]));
      const off = Math.max(...expected.map((value, c) => Math.abs(value - seen[c])));
      worst.colour = Math.max(worst.colour, off);
      check(off <= COLOUR_ERROR, `${where}colour ${seen}, not ${expected} of item ${item}`);
    }
  }
  check(shown > 50, `${name}: shows nothing`);
  if (keepImages || (failed > before && ++images <= 8)) sent.push(keep(name, colours));
}

const sent = [];

/** Sends an image, sRGB, as a file. */
async function keep(name, colours) {
  const canvas = new OffscreenCanvas(width, height), context = canvas.getContext('2d');
  const image = context.createImageData(width, height);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x)
      for (let c = 0; c < 4; ++c) {
        const value = colours[4 * ((height - 1 - y) * width + x) + c];
        image.data[4 * (y * width + x) + c] = Math.round(255 * (c < 3 ? srgbOf(value) : 1.0));
      }
  context.putImageData(image, 0, 0);
  await post(`/image/${encodeURIComponent(name.replaceAll(/[^a-z0-9]+/gi, '_'))}`, await canvas.convertToBlob());
}

// ---- Tests

for (const [kind, length] of description.kinds)
  check(RECORD_WORDS[kind] === length, `records of ${kind} have ${length} words, not ${RECORD_WORDS[kind]}`);
check(Object.keys(RECORD_WORDS).join() === description.kinds.map(([kind]) => kind).join(), 'kinds and their order');

const identity = new THREE.Matrix4();
/** Turned, moved and mirrored. */
const elsewhere = new THREE.Matrix4().makeRotationFromEuler(new THREE.Euler(0.3, -1.2, 2.0)).setPosition(-300.0, 4000.0, 20.0)
    .scale(new THREE.Vector3(-1.0, 1.0, 1.0));

function drawScenes(canvas, scenes, placed) {
  for (const scene of scenes) {
    const {root} = build(scene, placed);
    const name = `${scene.name}, ${canvas.name}${placed === identity ? '' : ', moved'}`;
    compare(canvas, scene, name, canvas.draw(root, makeCamera(scene, placed)));
    check(canvas.renderer.getContext().getError() === 0, `${name}: an error of WebGL`);
    ++scenesDrawn;
  }
}

/** In part of a larger target, pixels are the same. */
function drawInPart(canvas, scene) {
  const {root} = build(scene, identity), target = canvas.makeTarget(width + 40, height + 30);
  target.viewport.set(23, 11, width, height);
  compare(canvas, scene, `${scene.name}, ${canvas.name}, part of a target`, canvas.draw(root, makeCamera(scene, identity), target, 23, 11));
}

/** On the canvas, colours are sRGB. */
function drawOnCanvas(canvas, scene) {
  const {root} = build(scene, identity), gl = canvas.renderer.getContext();
  canvas.renderer.setRenderTarget(null);
  canvas.renderer.clear();
  canvas.renderer.render(root, makeCamera(scene, identity));
  const bytes = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  const colours = Float32Array.from(bytes, (value, i) => i % 4 === 3 ? value / 255 : light(value / 255));
  compare(canvas, scene, `${scene.name}, ${canvas.name}, on the canvas`, {colours});
}

/** What an application changes after the first frame shows in the next. */
function change(canvas, scene) {
  const name = `${scene.name}, ${canvas.name}, changed`, {root, primitives} = build(scene, identity);
  const camera = makeCamera(scene, identity);
  primitives.setVisible([]);
  check(canvas.draw(root, camera).colours.every((value) => value === 0), `${name}: something shows of nothing`);
  primitives.showAll();
  canvas.draw(root, camera);
  primitives.setVisible(Uint32Array.from([...scene.drawn, 5, 6, 7]), scene.drawn.length);
  compare(canvas, scene, name, canvas.draw(root, camera));
  primitives.clippingPlanes = [new THREE.Plane(new THREE.Vector3(1, 0, 0), -1e6)];
  check(canvas.draw(root, camera).colours.every((value) => value === 0), `${name}: something shows of what is cut off`);
  primitives.clippingPlanes = null;
  compare(canvas, scene, name, canvas.draw(root, camera));
  canvas.renderer.clippingPlanes = [new THREE.Plane(new THREE.Vector3(1, 0, 0), -1e6)];
  check(canvas.draw(root, camera).colours.every((value) => value === 0), `${name}: something shows of what the renderer cuts off`);
  canvas.renderer.clippingPlanes = [];
  primitives.materials.fill(0.0);  // alpha, too
  primitives.updateMaterials();
  check(canvas.draw(root, camera).colours.every((value) => value === 0), `${name}: something shows of alpha 0`);
  primitives.materials.set(scene.materials);
  primitives.updateMaterials();
  compare(canvas, scene, name, canvas.draw(root, camera));
  for (const kind in scene.records) {
    const records = primitives.records(kind);
    for (let at = 0; at < records.length; at += RECORD_WORDS[kind]) records[at + 14] |= 1 << 27;  // vacant
    primitives.updateRecords(kind);
  }
  check(canvas.draw(root, camera).colours.every((value) => value === 0), `${name}: something shows of vacant records`);
}

/** Cameras that shaders do not know show nothing, and do no harm. */
function drawSheared(canvas, scene) {
  const {root} = build(scene, identity), camera = makeCamera(scene, identity);
  camera.projectionMatrix.elements[4] = 0.3;
  camera.updateProjectionMatrix = () => {};
  check(canvas.draw(root, camera).colours.every((value) => value === 0), `${canvas.name}: something shows of a sheared view`);
  compare(canvas, scene, `${scene.name}, ${canvas.name}, after a sheared view`, canvas.draw(root, makeCamera(scene, identity)));
}

function throws(make, text) {
  try {
    make();
  } catch (error) {
    check(error instanceof RangeError && error.message.includes(text), `an error says "${error.message}", not "${text}"`);
    return;
  }
  check(false, `no error says "${text}"`);
}

function refuse() {
  const rest = {chunkOrigins: new Float64Array(3), materials: new Float32Array(4)};
  throws(() => new AnalyticPrimitives({...rest, records: {cone: new Uint32Array(16)}}), "no kind is named 'cone'");
  throws(() => new AnalyticPrimitives({...rest, records: {box: new Uint32Array(17)}}), '16 words each, not 17');
  const records = {box: new Uint32Array(32)};
  throws(() => new AnalyticPrimitives({...rest, records, items: {box: Uint32Array.of(3)}}), 'as many as its records, 2');
  throws(() => new AnalyticPrimitives({...rest, records, items: {box: Uint32Array.of(3, 3)}}), 'two records are item 3');
}

try {
  const {scenes} = description;
  const canvases = [new Canvas('standard', {}), new Canvas('reversed', {reversedDepthBuffer: true, reverseDepthBuffer: true}),
                    new Canvas('logarithmic', {logarithmicDepthBuffer: true})];
  const gl = canvases[0].renderer.getContext();
  log(`three ${THREE.REVISION}, ${gl.getParameter(gl.RENDERER)}, conservative depth: ${gl.getExtension('EXT_conservative_depth') !== null}`);
  check(canvases[1].renderer.state.buffers.depth.getReversed(), 'no reversed depth buffer');
  refuse();
  for (const canvas of canvases) {
    drawScenes(canvas, canvas.name === 'logarithmic' ? scenes.filter((_, i) => i % 3 === 0) : scenes, identity);
    const random = scenes.filter(({name}) => name.startsWith('random'));
    drawScenes(canvas, [...random.slice(0, 4), scenes.find((scene) => scene.unite)], elsewhere);
    for (const scene of [random[0], random[4], scenes.find(({meshes}) => meshes.length > 0)]) {
      drawInPart(canvas, scene);
      drawOnCanvas(canvas, scene);
    }
    change(canvas, random[1]);
    drawSheared(canvas, random[1]);
    made.splice(0).forEach((primitives) => primitives.dispose());
    check(canvas.renderer.info.programs.length <= 3, `${canvas.name}: programs are left`);
    log(`${canvas.name}: ${scenesDrawn} scenes so far, ${failed} failures`);
  }
} catch (error) {
  failed = Math.min(failed, 19);  // so that this is shown
  check(false, `${error.stack}`);
}
await Promise.all(sent);
await post('/result', JSON.stringify({
  failed,
  summary: `${scenesDrawn} scenes, ${compared} checks, ${failed} failed; pixels: ${JSON.stringify(counts)}; ` +
      `worst depth ${worst.depth.toFixed(3)} of what is allowed, worst colour ${(255 * worst.colour).toFixed(2)} of 255`,
}));
