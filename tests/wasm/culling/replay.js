// Makes the calls that wasm_culling_native has recorded, and compares every answer with the library's. Runs in node, in
// workers and in pages.

import { RecordReader, kDepths } from './records.js';

/**
 * Solvers of surfaces may end in other last bits with another library's sines and roots. Points of hits may differ by so
 * much of the coordinates involved, those of the ray's origin included; normals by so much as a surface turns on the way
 * that has a centimetre's radius.
 */
const kHitTolerance = 1e-9, kLeastRadius = 0.01;

function sameBits(a, b) {
  if (a.constructor !== b.constructor || a.length !== b.length) return false;
  const x = new Uint8Array(a.buffer, a.byteOffset, a.byteLength), y = new Uint8Array(b.buffer, b.byteOffset, b.byteLength);
  for (let i = 0; i < x.length; ++i) if (x[i] !== y[i]) return false;
  return true;
}

function difference(found, expected) {
  const at = expected.findIndex((value, i) => !Object.is(value, found[i]));
  return `expected ${expected.length} values, got ${found.length}; value ${at}: expected ${expected[at]}, got ${found[at]}`;
}

class Replay {
  constructor(sightline, buffer) {
    this.sightline = sightline;
    this.in = new RecordReader(buffer);
    this.place = '';
    this.answers = 0;
    this.hits = 0;
    this.roundedHits = 0;
    this.raster = sightline.createOccluderRaster();
    this.pyramid = sightline.createDepthPyramid();
    this.culler = this.view = this.camera = this.scene = null;
  }

  same(found, expected, what) {
    ++this.answers;
    if (!sameBits(found, expected)) throw new Error(`${this.place}: ${what}: ${difference(found, expected)}`);
  }
  equal(found, expected, what) {
    ++this.answers;
    if (found !== expected) throw new Error(`${this.place}: ${what}: expected ${expected}, got ${found}`);
  }
  /** Calls what fails with this message, or does not where it is empty. Returns what it returned. */
  failing(message, call) {
    let result, error = '';
    try {
      result = call();
    } catch (thrown) {
      if (thrown.name !== 'SightlineError') throw thrown;
      error = thrown.message;
    }
    this.equal(error, message, 'error');
    return result;
  }

  run() {
    let record = 0;
    while (this.in.more) {
      const call = this.in.text();
      if (call === 'case') {
        this.place = this.in.text();
        record = 0;
        continue;
      }
      const name = this.place;
      this.place = `${name}, call ${++record} (${call})`;
      if (!(call in kCalls)) throw new Error(`${this.place}: unknown call`);
      kCalls[call](this, this.in);
      this.place = name;
    }
    for (const object of [this.raster, this.pyramid, this.culler, this.view, this.scene]) object?.dispose();
    return { answers: this.answers, hits: this.hits, roundedHits: this.roundedHits };
  }

  /**
   * Indices in any order: the library says of none that it is the same with another standard library, whose sort may
   * exchange boxes that are equal.
   */
  sameSet(found, expected, what) {
    this.same(found.slice().sort(), expected.slice().sort(), what);
  }
  /** Hits in order of distance. Of those that are equally far any may come first, and be left out after the last. */
  sameRanking(found, expected, distances) {
    this.same(found.distances, distances, 'distances');
    this.equal(found.indices.length, expected.length, 'indices');
    const last = distances.at(-1);
    const rows = (indices) => Array.from(indices, (index, i) => [distances[i], index]).filter((row) => row[0] !== last);
    const sorted = (indices) => Float64Array.from(rows(indices).sort((a, b) => a[0] - b[0] || a[1] - b[1]).flat());
    this.same(sorted(found.indices), sorted(expected), 'hits');
  }
  limits([behind, leastArea]) {
    return behind ? { behind: this.pyramid, leastArea } : { leastArea };
  }
  /** Each hit is one of the `candidates`, and each of them is met where all are wanted. */
  sameHits(found, candidates, faces, all, origin, direction) {
    const rows = Array.from(faces, (face, i) => ({ face, numbers: candidates.subarray(10 * i, 10 * i + 10) }));
    if (all) this.equal(found.length, rows.length, 'hits');
    else this.equal(found.length, Math.min(rows.length, 1), 'hits');
    for (const hit of found) {
      const { distance, point, normal } = hit;
      const values = [hit.item, hit.node, hit.triangle, distance, ...point, ...normal];
      const at = rows.findIndex(({ face, numbers }) => face === hit.face && nearlySame(values, numbers, origin, direction));
      if (at < 0) throw new Error(`${this.place}: hit: expected one of ${candidates}, got ${values}, ${hit.face}`);
      ++this.hits;
      ++this.answers;
      if (!values.every((value, i) => Object.is(value, rows[at].numbers[i]))) ++this.roundedHits;
      rows.splice(at, 1);
    }
  }
}

/** Whether these are numbers of the same hit: item, node, triangle, distance, point, normal. */
function nearlySame(values, wanted, origin, direction) {
  const off = kHitTolerance * (Math.hypot(...origin) + Math.hypot(...wanted.subarray(4, 7)));
  const allowed = [0, 0, 0, off / Math.hypot(...direction), off, off, off, ...Array(3).fill(off / kLeastRadius)];
  return values.every((value, i) => Math.abs(value - wanted[i]) <= allowed[i]);
}

const asText = (parts) => parts.map((part) => `${part}\0`).join('');

/** By the names in the file: reads arguments and the answer, in the order of wasm_culling_native. */
const kCalls = {
  create(t, from) {
    const boxes = from.array();
    const culler = t.failing(from.text(), () => t.sightline.createBoxCuller(boxes));
    if (!culler) return;
    t.culler?.dispose();
    t.culler = culler;
    t.equal(culler.size, boxes.length / 6, 'size');
  },
  update(t, from) {
    const indices = from.array(), boxes = from.array();
    t.failing(from.text(), () => t.culler.update(indices, boxes));
  },
  refit(t, from) {
    const boxes = from.array();
    t.failing(from.text(), () => t.culler.refit(boxes));
  },
  view(t, from) {
    t.view?.dispose();
    t.camera = from.camera();
    t.view = t.sightline.createView(t.camera);
  },
  visible(t, from) {
    t.sameSet(t.culler.visible(t.view), from.array(), 'indices');
  },
  visibleIn(t, from) {
    const matrix = from.array(), [depth] = from.array();
    t.sameSet(t.culler.visibleIn(matrix, kDepths[depth]), from.array(), 'indices');
  },
  visibleWithin(t, from) {
    const limits = t.limits(from.array());
    t.sameSet(t.culler.visible(t.view, limits), from.array(), 'indices');
  },

  raster(t) {
    t.raster.begin(t.view);
  },
  addBoxes(t, from) {
    const boxes = from.array(), [, added] = from.array();
    t.equal(t.raster.addBoxes(boxes), added, 'added');
  },
  addLargest(t, from) {
    const boxes = from.array(), [most, added] = from.array();
    t.equal(t.raster.addLargest(boxes, most), added, 'added');
  },
  addPlaced(t, from) {
    const placement = from.array(), [sides, added] = from.array();
    const found = sides === 0 ? t.raster.addCube(placement) : t.raster.addCylinder(placement, sides);
    t.equal(found, added !== 0, 'added');
  },
  addMesh(t, from) {
    const positions = from.array(), indices = from.array();
    t.raster.addMesh(positions, indices, from.array());
  },
  build(t, from) {
    const { width, height } = t.camera;
    t.same(t.raster.distances(width, height), from.array(), 'distances');
    t.raster.build(t.pyramid);
  },
  pyramid(t, from) {
    const { width, height } = t.camera;
    t.pyramid.build(from.array(), width, height);
  },
  hides(t, from) {
    const boxes = from.array();
    t.same(t.pyramid.hides(t.view, boxes), from.array(), 'hidden');
  },

  inBox(t, from) {
    const box = from.array(), [inside] = from.array();
    t.same(t.culler.inBox(box, { inside: inside !== 0 }), from.array(), 'indices');
  },
  around(t, from) {
    const [x, y, z, radius] = from.array();
    t.same(t.culler.around([x, y, z], radius), from.array(), 'indices');
  },
  along(t, from) {
    const numbers = from.array(), [start, end, most] = numbers.subarray(6);
    const found = t.culler.along(numbers.subarray(0, 3), numbers.subarray(3, 6), { from: start, to: end, most });
    t.sameRanking(found, from.array(), from.array());
  },
  nearest(t, from) {
    const [x, y, z, count] = from.array();
    const found = t.culler.nearest([x, y, z], count);
    t.sameRanking(found, from.array(), from.array());
  },

  scene(t) {
    t.scene?.dispose();
    t.scene = t.sightline.createScene();
  },
  read(t, from) {
    const name = from.text(), bytes = from.array(), message = from.text();
    const report = t.failing(message, () => t.scene.read(bytes, name));
    if (message !== '') return;
    const { metresPerUnit, degenerate, attributed, warnings, items } = report;
    const numbers = [metresPerUnit, degenerate, attributed, warnings.length, ...Object.values(items)];
    t.same(Float64Array.from(numbers), from.array(), 'report');
  },
  commit(t) {
    t.scene.commit();
  },
  content(t, from) {
    t.equal(asText(t.scene.names()), from.text(), 'names');
    t.same(t.scene.parents(), from.array(), 'parents');
    t.same(t.scene.itemNodes(), from.array(), 'nodes of items');
    t.same(t.scene.itemKinds(), from.array(), 'kinds of items');
    t.same(t.scene.boxes(), from.array(), 'boxes');
  },
  attributes(t, from) {
    const [node] = from.array();
    t.equal(asText(t.scene.attributes(node).flat()), from.text(), 'attributes');
  },
  find(t, from) {
    const text = from.text(), message = from.text(), numbers = from.array();
    const found = t.failing(message, () => t.scene.find(text));
    if (message === '') t.same(found, numbers, 'found');
  },
  edit(t, from) {
    const [what, item] = from.array(), matrix = from.array();
    if (what === 0) t.scene.removeItem(item);
    if (what === 1) t.scene.setItemVisible(item, false);
    if (what === 2) t.scene.setPlacement(item, matrix);
  },
  sceneVisible(t, from) {
    const limits = t.limits(from.array());
    t.sameSet(t.scene.visible(t.view, limits), from.array(), 'items');
  },
  occlude(t, from) {
    const [leastArea] = from.array();
    t.scene.occlude(t.view, t.pyramid, { leastArea });
  },
  pick(t, from) {
    const numbers = from.array(), [start, end, all, inView] = numbers.subarray(6);
    const options = { from: start, to: end, view: inView ? t.view : undefined };
    const ray = [numbers.subarray(0, 3), numbers.subarray(3, 6), options];
    const found = all ? t.scene.pickAll(...ray) : [t.scene.pick(...ray)].filter((hit) => hit !== null);
    t.sameHits(found, from.array(), from.text().split('\0').slice(0, -1), all !== 0, ray[0], ray[1]);
  },
};

/**
 * Throws where an answer differs, with the place in words: the case and its seed, the call.
 * @param {import('sightline').Sightline} sightline
 * @param {ArrayBuffer} buffer of wasm_culling_native
 */
export function replay(sightline, buffer) {
  return new Replay(sightline, buffer).run();
}
