// A plant in three.js: what each frame shows of it and costs, and what a click hits. In the address, ?model=URL names
// the file (.rvm, .rev, .slc), ?threads=N asks for threads, and ?fly=FRAMES flies once around and keeps its figures.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { load } from 'sightline';
import { Plant } from 'sightline/three';

const kFrames = 120; // of which figures are shown
const kSky = 0xd9dfe8;

const options = new URLSearchParams(location.search);
const element = (id) => document.getElementById(id);
const isOn = (id) => element(id).checked;
const say = (text) => (element('message').textContent = text);

/** The last times of something, in milliseconds. */
class Times {
  #last = [];
  add(time) {
    this.#last.push(time);
    if (this.#last.length > kFrames) this.#last.shift();
  }
  clear() {
    this.#last.length = 0;
  }
  get median() {
    return [...this.#last].sort((a, b) => a - b)[this.#last.length >> 1] ?? 0;
  }
  get worst() {
    return Math.max(0, ...this.#last);
  }
}

const sightline = await load({ threads: Number(options.get('threads') ?? 1) });
const renderer = new THREE.WebGLRenderer({ antialias: false, reversedDepthBuffer: true });
renderer.setClearColor(kSky);
renderer.localClippingEnabled = true;
document.body.prepend(renderer.domElement);

const root = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(50, 1, 0.1, 1000);
camera.up.set(0, 0, 1);
const controls = new OrbitControls(camera, renderer.domElement);
const bounds = new THREE.Box3();
const culling = new Times();
const frames = new Times();

let scene = null;
let plant = null;
let parents = [];
let names = [];

/** Reads files in the order of their kinds: models before their attributes. */
function open(files) {
  const isModel = ({ name }) => /\.(rvm|rev|slc)$/i.test(name);
  const next = sightline.createScene();
  try {
    for (const { name, bytes } of [...files].sort((a, b) => isModel(b) - isModel(a))) next.read(bytes, name);
    next.commit();
  } catch (error) {
    next.dispose();
    say(error.message);
    return;
  }
  plant?.removeFromParent().dispose();
  scene?.dispose();
  scene = next;
  plant = new Plant(sightline, scene);
  root.add(plant);
  parents = scene.parents();
  names = scene.names();
  element('name').textContent = files.map(({ name }) => name).join(', ');
  element('picked').textContent = '';
  say('');
  look();
}

/** Shows the whole. */
function look() {
  bounds.makeEmpty();
  const boxes = scene.boxes();
  const low = new THREE.Vector3();
  const high = new THREE.Vector3();
  for (let i = 0; i < boxes.length; i += 6)
    if (boxes[i] <= boxes[i + 3]) bounds.union(new THREE.Box3(low.fromArray(boxes, i), high.fromArray(boxes, i + 3)));
  const size = bounds.getSize(high).length();
  bounds.getCenter(controls.target);
  camera.near = size / 1e4;
  camera.far = 4 * size;
  camera.updateProjectionMatrix();
  camera.position.set(-0.3, -0.42, 0.22).multiplyScalar(size).add(controls.target);
  controls.update();
}

function sectionPlanes() {
  if (!isOn('section')) return null;
  const height = THREE.MathUtils.lerp(bounds.min.z, bounds.max.z, Number(element('height').value));
  return [new THREE.Plane(new THREE.Vector3(0, 0, -1), height)];
}

function showCounts() {
  const milliseconds = (time) => `${time.toFixed(2)} ms`;
  const rows = {
    Items: plant.stats.items.toLocaleString('en'),
    Drawn: (isOn('culling') ? plant.stats.visible : plant.stats.items).toLocaleString('en'),
    'Culling, median': milliseconds(culling.median),
    'Culling, worst': milliseconds(culling.worst),
    'Frame, median': milliseconds(frames.median),
    'Module memory': `${(sightline.memoryBytes / 2 ** 20).toFixed(0)} MiB`,
    SIMD: sightline.simd ? 'yes' : 'no',
    Threads: sightline.threads,
  };
  element('counts').replaceChildren(
    ...Object.entries(rows).map(([name, value]) => {
      const row = document.createElement('tr');
      row.append(...[name, value].map((text) => Object.assign(document.createElement('td'), { textContent: text })));
      return row;
    }),
  );
}

let flown = 0;
const flight = Number(options.get('fly') ?? 0);
const measured = [];

/** One step of the flight: around, and from afar to within. */
function fly() {
  const turn = (2 * Math.PI * flown) / flight;
  const size = bounds.getSize(new THREE.Vector3()).length();
  const distance = size * (0.27 + 0.25 * Math.cos(turn));
  bounds.getCenter(controls.target);
  camera.position.set(Math.cos(turn), Math.sin(turn), 0.4).multiplyScalar(distance).add(controls.target);
  ++flown;
}

let last = 0;
function frame(now) {
  if (!plant) return;
  if (last > 0) frames.add(now - last);
  last = now;
  if (flown < flight) fly();
  controls.update();
  plant.options.occlusion = isOn('occlusion');
  plant.options.leastArea = isOn('least') ? 1 : 0;
  plant.clippingPlanes = sectionPlanes();
  camera.updateMatrixWorld();
  plant.update(camera, renderer);
  culling.add(plant.stats.milliseconds);
  if (!isOn('culling')) plant.showAll();
  renderer.render(root, camera);
  showCounts();
  if (flown > 0 && measured.length < flight)
    measured.push({ culling: plant.stats.milliseconds, drawn: plant.stats.visible, frame: frames.median });
  if (flight > 0 && measured.length === flight) globalThis.flight = measured;
}

/** Names from the root to what is below it. */
function pathOf(node) {
  const path = [];
  for (let at = node; at !== 0 && at < parents.length; at = parents[at]) path.unshift(names[at]);
  return path.filter((name) => name.length > 0).join(' / ');
}

function pick(event) {
  const raycaster = new THREE.Raycaster();
  const x = (2 * event.clientX) / innerWidth - 1;
  const y = 1 - (2 * event.clientY) / innerHeight;
  raycaster.setFromCamera(new THREE.Vector2(x, y), camera);
  const start = performance.now();
  const hit = plant.pick(raycaster.ray);
  const time = performance.now() - start;
  const lines = [];
  if (hit) {
    const kind = scene.kinds[scene.itemKinds()[hit.item]];
    const point = hit.worldPoint.toArray().map((value) => value.toFixed(3));
    lines.push(pathOf(hit.node), `${kind}, item ${hit.item}, ${hit.face}`, `${point.join(', ')} m, in ${time.toFixed(1)} ms`);
    for (let node = hit.node; node !== 0; node = parents[node])
      for (const [key, value] of scene.attributes(node)) lines.push(`${key}: ${value}`);
  }
  element('picked').replaceChildren(
    ...lines.slice(0, 24).map((text) => Object.assign(document.createElement('div'), { textContent: text })),
  );
}

let pressed = { x: 0, y: 0 };
renderer.domElement.addEventListener('pointerdown', ({ clientX: x, clientY: y }) => (pressed = { x, y }));
renderer.domElement.addEventListener('pointerup', (event) => {
  if (scene && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < 3) pick(event);
});

async function openFiles(list) {
  say('Reading …');
  const files = [...list].map(async (file) => ({ name: file.name, bytes: await file.arrayBuffer() }));
  open(await Promise.all(files));
}
element('file').addEventListener('change', ({ target }) => openFiles(target.files));
addEventListener('dragover', (event) => event.preventDefault());
addEventListener('drop', (event) => {
  event.preventDefault();
  openFiles(event.dataTransfer.files);
});
for (const id of ['culling', 'occlusion', 'least', 'section'])
  element(id).addEventListener('change', () => {
    culling.clear();
    frames.clear();
  });

function resize() {
  renderer.setPixelRatio(devicePixelRatio);
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}
addEventListener('resize', resize);
resize();
renderer.setAnimationLoop(frame);

const url = options.get('model') ?? '/model';
say('Loading …');
const response = await fetch(url);
if (response.ok) {
  const name = response.headers.get('x-file-name') ?? url.split('/').pop();
  open([{ name, bytes: await response.arrayBuffer() }]);
} else {
  say('Drop a plant here: .rvm or .slc, with .txt or .att for attributes');
}
