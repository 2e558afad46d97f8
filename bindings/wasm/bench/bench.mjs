// Boxes in a view volume: sightline's modules beside three.js, three-mesh-bvh and the library in a process of its own, in
// one run of node. Prints tables in Markdown.
//   node bench.mjs [--json FILE] [--items N,N,…] [--rounds N]
// scripts/wasm.sh bench runs it. SIGHTLINE_PACKAGE names the assembled package (build/npm/sightline),
// SIGHTLINE_NODE_MODULES the folder with what tests/wasm/package.json asks for, SIGHTLINE_WASM_CULLING_NATIVE the program of tests/wasm/culling.
import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { cpus } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { parseArgs } from 'node:util';
import { setFlagsFromString } from 'node:v8';
import { runInNewContext } from 'node:vm';
import { brotliCompressSync, constants, gzipSync } from 'node:zlib';

import { bufferOf, imported, inFolder, native, packageFolder } from '../../../tests/wasm/culling/native.mjs';
import { RecordReader, RecordWriter } from '../../../tests/wasm/culling/records.js';

const { values: options } = parseArgs({
  options: {
    json: { type: 'string' },
    items: { type: 'string', default: '100000,713000,1000000' },
    rounds: { type: 'string', default: '5' },
  },
});
const kRounds = Number(options.rounds);
const kCalls = { simd: 60, scalar: 20, threads: 60, three: 5, bvh: 10, native: 100 }; // of a round

const modules = process.env.SIGHTLINE_NODE_MODULES;
if (!modules) throw new Error('SIGHTLINE_NODE_MODULES: expected a folder with three and three-mesh-bvh');
const fromModules = (file) => import(pathToFileURL(join(modules, file)));
const THREE = await fromModules('three/build/three.module.js');
const { BVH, CONTAINED, INTERSECTED, NOT_INTERSECTED } = await fromModules('three-mesh-bvh/src/index.js');
const version = (name) => JSON.parse(readFileSync(join(modules, name, 'package.json'), 'utf8')).version;
const { load } = await imported('culling-only.js');

setFlagsFromString('--expose-gc');
const collect = runInNewContext('gc');
const heapBytes = () => {
  collect();
  const { heapUsed, arrayBuffers } = process.memoryUsage();
  return heapUsed + arrayBuffers;
};
const median = (numbers) => numbers.toSorted((a, b) => a - b)[numbers.length >> 1];

// --- contenders ------------------------------------------------------------------------------------------------------
// Each has `bytes` that it keeps, and find(camera), which returns how many indices it has written to a list.

async function ofSightline(boxes, loadOptions) {
  const sightline = await load(loadOptions);
  const lent = sightline.allocate(Float64Array, boxes.length);
  lent.view.set(boxes);
  const culler = sightline.createBoxCuller(lent);
  lent.dispose();
  const views = new Map();
  const find = ({ view, projection }) => {
    let known = views.get(view);
    if (!known) views.set(view, (known = sightline.createView({ view, projection })));
    return culler.visible(known).length;
  };
  return { find, bytes: sightline.memoryBytes, close: () => sightline.close() };
}

/** The loop that applications write: one Box3 an object. */
function ofThree(boxes) {
  const before = heapBytes();
  const prepared = [];
  for (let i = 0; i < boxes.length; i += 6)
    prepared.push(new THREE.Box3(new THREE.Vector3(...boxes.subarray(i, i + 3)), new THREE.Vector3(...boxes.subarray(i + 3, i + 6))));
  const bytes = heapBytes() - before;
  const indices = new Uint32Array(prepared.length);
  const find = (camera) => {
    const frustum = frustumOf(camera);
    let count = 0;
    for (let i = 0; i < prepared.length; ++i) if (frustum.intersectsBox(prepared[i])) indices[count++] = i;
    return count;
  };
  return { find, bytes, prepared };
}

const frustumOf = ({ matrix }) => new THREE.Frustum().setFromProjectionMatrix(matrix);

/** A hierarchy of boxes, by the library's base class for primitives of any kind. */
class BoxBVH extends BVH {
  constructor(boxes) {
    super();
    this.boxes = boxes;
    this.primitiveBuffer = Uint32Array.from({ length: boxes.length / 6 }, (_, i) => i);
    this.primitiveBufferStride = 1;
    this.init({});
  }
  getRootRanges() {
    return [{ offset: 0, count: this.primitiveBuffer.length }];
  }
  writePrimitiveBounds(i, target, at) {
    const from = 6 * this.primitiveBuffer[i];
    for (let k = 0; k < 6; ++k) target[at + k] = this.boxes[from + k];
  }
}

/** shapecast() with nodes that lie within the volume taken as wholes. */
function ofBvh(boxes, prepared) {
  const before = heapBytes();
  const bvh = new BoxBVH(boxes);
  const bytes = heapBytes() - before;
  const indices = new Uint32Array(prepared.length);
  const corner = new THREE.Vector3();
  const contains = (frustum, { min, max }) =>
    frustum.planes.every(({ normal, constant }) => {
      corner.set(normal.x > 0 ? min.x : max.x, normal.y > 0 ? min.y : max.y, normal.z > 0 ? min.z : max.z);
      return normal.dot(corner) + constant >= 0;
    });
  const find = (camera) => {
    const frustum = frustumOf(camera);
    const { primitiveBuffer } = bvh;
    let count = 0;
    bvh.shapecast({
      intersectsBounds(box) {
        if (!frustum.intersectsBox(box)) return NOT_INTERSECTED;
        return contains(frustum, box) ? CONTAINED : INTERSECTED;
      },
      intersectsRange(offset, number, contained) {
        for (let i = offset; i < offset + number; ++i) {
          const index = primitiveBuffer[i];
          if (contained || frustum.intersectsBox(prepared[index])) indices[count++] = index;
        }
        return false;
      },
    });
    return count;
  };
  return { find, bytes };
}

// --- what is looked at -----------------------------------------------------------------------------------------------

function cameraAt(eye, target) {
  const camera = new THREE.PerspectiveCamera(60, 16 / 9, 0.1, 2000);
  camera.up.set(0, 0, 1);
  camera.position.set(...eye);
  camera.lookAt(...target);
  camera.updateMatrixWorld();
  const { projectionMatrix: projection, matrixWorldInverse: view } = camera;
  view.elements[15] = 1; // but for rounding, which the native program does not expect
  const matrix = new THREE.Matrix4().multiplyMatrices(projection, view);
  return { view: view.elements, projection: projection.elements, matrix };
}

/** From within along the plant, from outside, and from where a third is seen. */
function camerasOf(boxes, find) {
  const all = new THREE.Box3();
  for (let i = 0; i < boxes.length; i += 6) {
    all.expandByPoint(new THREE.Vector3(...boxes.subarray(i, i + 3)));
    all.expandByPoint(new THREE.Vector3(...boxes.subarray(i + 3, i + 6)));
  }
  const { x, y, z } = all.getCenter(new THREE.Vector3()), size = all.getSize(new THREE.Vector3());
  const along = (share) => cameraAt([all.min.x + share * size.x, y, z], [all.max.x + 1e4, y, z]);
  let low = -1, high = 1;
  for (let i = 0; i < 40; ++i) {
    const middle = 0.5 * (low + high);
    if (find(along(middle)) > boxes.length / 18) low = middle;
    else high = middle;
  }
  return {
    'from within': cameraAt([x, y, z], [x + 0.1 * size.x, y + size.y, z - 0.5 * size.z]),
    'a third': along(low),
    'all': cameraAt([x - size.length(), y - size.length(), z + size.length()], [x, y, z]),
  };
}

// --- measuring -------------------------------------------------------------------------------------------------------

async function measure(items, folder) {
  const plant = join(folder, 'plant'), asked = join(folder, 'asked');
  native(['plant', plant, String(items)]);
  const boxes = new RecordReader(bufferOf(plant)).array();
  const simd = await ofSightline(boxes, { simd: true });
  const cameras = camerasOf(boxes, simd.find);
  const three = ofThree(boxes);
  const contenders = {
    simd,
    scalar: await ofSightline(boxes, { simd: false }),
    threads: await ofSightline(boxes, { threads: 2 }),
    three,
    bvh: ofBvh(boxes, three.prepared),
  };
  const out = new RecordWriter();
  out.array(boxes);
  for (const camera of Object.values(cameras)) out.camera(camera);
  writeFileSync(asked, Buffer.concat(out.take()));

  const rows = Object.keys(cameras).map((name) => ({ items, view: name, visible: {}, ms: {} }));
  const times = rows.map(() => ({}));
  const add = (row, name, milliseconds, visible) => {
    (times[row][name] ??= []).push(...milliseconds);
    rows[row].visible[name] = visible;
  };
  for (let round = 0; round < kRounds; ++round) {
    for (const [name, { find }] of Object.entries(contenders)) {
      Object.values(cameras).forEach((camera, row) => {
        find(camera);
        let visible = 0;
        const milliseconds = Array.from({ length: kCalls[name] }, () => {
          const begin = performance.now();
          visible = find(camera);
          return performance.now() - begin;
        });
        add(row, name, milliseconds, visible);
      });
    }
    const env = { ...process.env, SIGHTLINE_ISA: 'avx2' };
    const answers = JSON.parse(native(['time', asked, String(kCalls.native)], { env }));
    answers.forEach(({ ms, visible }, row) => add(row, 'native', [ms], visible));
  }
  rows.forEach((row, i) => {
    for (const [name, list] of Object.entries(times[i])) row.ms[name] = median(list);
  });
  const bytes = Object.fromEntries(Object.entries(contenders).map(([name, { bytes }]) => [name, bytes / items]));
  for (const { close } of Object.values(contenders)) close?.();
  return { rows, bytes };
}

function packageSizes() {
  const folder = join(packageFolder, 'wasm');
  return readdirSync(folder).sort().map((file) => {
    const content = readFileSync(join(folder, file));
    const brotli = brotliCompressSync(content, { params: { [constants.BROTLI_PARAM_QUALITY]: 11 } });
    return { file, bytes: content.length, gzip: gzipSync(content, { level: 9 }).length, brotli: brotli.length };
  });
}

const result = { node: process.version, cpu: cpus()[0].model, processors: cpus().length, rows: [], bytes: {} };
result.three = version('three');
result.threeMeshBvh = version('three-mesh-bvh');
await inFolder(async (folder) => {
  for (const items of options.items.split(',').map(Number)) {
    const { rows, bytes } = await measure(items, folder);
    result.rows.push(...rows);
    result.bytes[items] = bytes;
  }
});
result.sizes = packageSizes();

const print = (cells) => console.log(`| ${cells.join(' | ')} |`);
const number = (value) => value.toLocaleString('en-GB');
const ms = (value) => (value < 1 ? value.toFixed(3) : value.toFixed(2));
console.log(`node ${process.version}, ${result.cpu}, three ${result.three}, three-mesh-bvh ${result.threeMeshBvh}; median ms\n`);
print(['boxes', 'view', 'visible', 'SIMD', 'scalar', '2 threads', 'three.js', 'three-mesh-bvh', 'native AVX2', 'three.js / SIMD', 'SIMD / native']);
print(['---:', '---', ...Array(9).fill('---:')]);
for (const { items, view, visible, ms: t } of result.rows) {
  const counts = new Set([visible.simd, visible.scalar, visible.threads, visible.native]);
  if (counts.size !== 1) throw new Error(`${items} boxes, ${view}: answers differ: ${JSON.stringify(visible)}`);
  print([number(items), view, number(visible.simd), ...['simd', 'scalar', 'threads', 'three', 'bvh', 'native'].map((name) => ms(t[name])),
    (t.three / t.simd).toFixed(0), (t.simd / t.native).toFixed(2)]);
}
console.log('\nBytes a box, of the module’s whole memory or the heap:\n');
print(['boxes', 'SIMD', '2 threads', 'three.js', 'three-mesh-bvh (besides)']);
print(Array(5).fill('---:'));
for (const [items, b] of Object.entries(result.bytes)) print([number(Number(items)), ...['simd', 'threads', 'three', 'bvh'].map((name) => b[name].toFixed(0))]);
console.log('\nkB of the package:\n');
print(['file', 'raw', 'gzip', 'brotli']);
print(['---', '---:', '---:', '---:']);
for (const { file, bytes, gzip, brotli } of result.sizes) print([file, ...[bytes, gzip, brotli].map((n) => (n / 1000).toFixed(0))]);
if (options.json) writeFileSync(options.json, JSON.stringify(result, null, 2));
process.exit(0);
