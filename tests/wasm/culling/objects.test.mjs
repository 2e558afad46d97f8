// Lifetimes, memory, errors, arrays that lie in the module, and workers.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { setFlagsFromString } from 'node:v8';
import { runInNewContext } from 'node:vm';
import { Worker } from 'node:worker_threads';

import { imported, kForms, lacking, packageFolder } from './native.mjs';

const kIdentity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
/** Shows the cube of -1 to 1. */
const kCube = { view: kIdentity, projection: kIdentity, width: 64, height: 64 };

/** `count` cubes of which every other one is visible. */
function someBoxes(count) {
  const boxes = new Float64Array(6 * count);
  for (let i = 0; i < count; ++i) boxes.set([0, 0, 0, 0.1, 0.1, 0.1].map((x) => x + 5 * (i % 2)), 6 * i);
  return boxes;
}
const expectedOf = (count) => Uint32Array.from({ length: Math.ceil(count / 2) }, (_, i) => 2 * i);
const sorted = (indices) => indices.slice().sort();

for (const [form, options] of Object.entries(kForms)) {
  test(`objects, ${form}`, { skip: lacking }, async (t) => {
    const { load, SightlineError } = await imported('index.js');
    const sightline = await load(options);
    t.after(() => sightline.close());
    const view = sightline.createView(kCube);

    await t.test('errors have words, and nothing is lost', () => {
      const culler = sightline.createBoxCuller(someBoxes(100));
      const fails = (call, type, words) =>
        assert.throws(call, (error) => {
          assert.ok(error instanceof type, `${error.constructor.name}: ${error.message}`);
          assert.match(error.message, words);
          return true;
        });
      const bad = [0, 0, 0, NaN, 1, 1];
      fails(() => sightline.createBoxCuller(bad), SightlineError, /^box 0: expected finite corners$/);
      fails(() => sightline.createBoxCuller([1, 2, 3]), TypeError, /expected six numbers each, got 3/);
      fails(() => culler.update([5], bad), SightlineError, /^box 5: expected finite corners$/);
      fails(() => culler.update([100], someBoxes(1)), SightlineError, /expected indices below 100, found 100/);
      fails(() => culler.update([1, 2], someBoxes(1)), TypeError, /six numbers for each index/);
      fails(() => culler.refit(someBoxes(99)), SightlineError, /expected 100 boxes, found 99/);
      fails(() => culler.refit(Array(600).fill(Infinity)), SightlineError, /^box 0: expected finite corners$/);
      fails(() => culler.visibleIn(kIdentity.slice(1)), TypeError, /sixteen numbers/);
      fails(() => culler.visibleIn(kIdentity.map(() => NaN)), SightlineError, /finite/);
      fails(() => culler.visibleIn(kIdentity, 'backwards'), TypeError, /expected one of reversed/);
      fails(() => sightline.createView({ ...kCube, view: Array(16).fill(1) }), SightlineError, /./);
      fails(() => sightline.createView({ ...kCube, sections: Array(9).fill([1, 0, 0, 0]) }), SightlineError, /at most 8/);
      fails(() => sightline.createView({ ...kCube, sections: [[1, 0, 0]] }), TypeError, /four numbers/);
      const raster = sightline.createOccluderRaster();
      fails(() => raster.begin(sightline.createView({ ...kCube, width: 0 })), SightlineError, /1 to 16384 pixels/);
      fails(() => raster.addMesh([0, 0, 0], [0, 0, 1], kIdentity), SightlineError, /below 1, got 1/);
      fails(() => raster.addMesh([0, 0, 0], [0, 0], kIdentity), SightlineError, /three indices a triangle/);
      const pyramid = sightline.createDepthPyramid();
      fails(() => pyramid.build(new Float32Array(5), 2, 3), TypeError, /2 x 3/);
      const scene = sightline.createScene();
      fails(() => scene.read(new Uint8Array(10), 'a.rvm'), SightlineError, /a\.rvm/);
      fails(() => scene.read(new Uint8Array(10), 'a.step'), SightlineError, /expected a name that ends in/);
      fails(() => scene.visible(view), SightlineError, /commit\(\) first/);
      fails(() => scene.addNode(7, 'x'), SightlineError, /expected a node of this scene, got 7/);
      fails(() => scene.removeItem(3), SightlineError, /expected an item of this scene, got 3/);
      fails(() => scene.addPrimitive(0, { kind: 'cylinder', parameters: [1] }), SightlineError, /expected 2 parameters/);
      fails(() => scene.addPrimitive(0, { kind: 'teapot', parameters: [] }), TypeError, /expected one of/);
      fails(() => scene.addInstance(0, 0), SightlineError, /addMesh/);
      const item = scene.addPrimitive(0, { kind: 'cylinder', parameters: [0.5, 1] });
      scene.commit();
      assert.deepEqual([...scene.visible(view)], [item]);
      fails(() => scene.pick([NaN, 0, 0], [1, 0, 0]), SightlineError, /./);
      fails(() => scene.pick([0, 0], [1, 0, 0]), TypeError, /three numbers/);
      scene.setPlacement(item, kIdentity.map((x) => 1e300 * x));
      fails(() => scene.commit(), SightlineError, /./);
      assert.deepEqual([...scene.visible(view)], [item], 'nothing was published');
      assert.deepEqual(sorted(culler.visible(view)), expectedOf(100), 'nothing has changed');
    });

    await t.test('inverses that are off by rounding are views', () => {
      const culler = sightline.createBoxCuller(someBoxes(10));
      const rounded = sightline.createView({ ...kCube, view: kIdentity.with(15, 1 - 2 ** -53) });
      assert.deepEqual(sorted(culler.visible(rounded)), expectedOf(10));
      assert.throws(() => sightline.createView({ ...kCube, view: kIdentity.with(15, 0.99) }), SightlineError);
      culler.dispose();
    });

    await t.test('what was disposed of says so, once and for all', () => {
      const objects = [
        sightline.createBoxCuller(someBoxes(10)), sightline.createView(kCube), sightline.createDepthPyramid(),
        sightline.createOccluderRaster(), sightline.createScene(), sightline.allocate(Float64Array, 6),
      ];
      for (const object of objects) {
        assert.equal(object.disposed, false);
        object.dispose();
        object.dispose();
        assert.equal(object.disposed, true);
      }
      const [culler, gone, pyramid, raster, scene, array] = objects;
      const kGone = { name: 'SightlineError', message: /it was disposed of/ };
      assert.throws(() => culler.visible(view), kGone);
      assert.throws(() => culler.update([0], someBoxes(1)), kGone);
      assert.throws(() => raster.begin(view), kGone);
      assert.throws(() => scene.commit(), kGone);
      assert.throws(() => array.view, kGone);
      const fresh = sightline.createBoxCuller(someBoxes(10));
      assert.throws(() => fresh.visible(gone), kGone);
      assert.throws(() => fresh.visible(view, { behind: pyramid }), kGone);
      assert.throws(() => sightline.createBoxCuller(array), kGone);
      assert.deepEqual(sorted(fresh.visible(view)), expectedOf(10));
      fresh.dispose();
    });

    await t.test('NativeArray is taken where it lies', () => {
      const count = 200_000;
      const boxes = sightline.allocate(Float64Array, 6 * count);
      boxes.view.set(someBoxes(count));
      const culler = sightline.createBoxCuller(boxes);
      assert.deepEqual(sorted(culler.visible(view)), expectedOf(count));
      boxes.view.copyWithin(0, 6);  // all boxes one place on: the other half is visible
      const before = sightline.memoryBytes;
      for (let i = 0; i < 20; ++i) culler.refit(boxes);
      assert.equal(sightline.memoryBytes, before, 'refit() from it needs no memory');
      assert.deepEqual(sorted(culler.visible(view)).slice(0, 3), Uint32Array.of(1, 3, 5));
      const words = sightline.allocate(Uint32Array, 6);
      assert.throws(() => culler.refit(words), TypeError);
      assert.throws(() => sightline.createBoxCuller(words), TypeError);
      for (const object of [boxes, culler, words]) object.dispose();
    });

    await t.test('memory grows, and objects stay what they are', () => {
      const small = sightline.createBoxCuller(someBoxes(1000));
      const pyramid = sightline.createDepthPyramid();
      pyramid.build(new Float32Array(64 * 64).fill(Infinity), 64, 64);
      const before = sightline.memoryBytes;
      const count = 1_500_000;
      const large = sightline.createBoxCuller(someBoxes(count));
      assert.ok(sightline.memoryBytes > before + 33 * count, `${before} to ${sightline.memoryBytes}`);
      assert.deepEqual(sorted(small.visible(view, { behind: pyramid })), expectedOf(1000));
      assert.equal(large.visible(view).length, count / 2);
      for (const object of [small, pyramid, large]) object.dispose();
    });

    await t.test('memory that was given back is used again', () => {
      const cycle = () => sightline.createBoxCuller(someBoxes(100_000)).dispose();
      for (let i = 0; i < 5; ++i) cycle();
      const before = sightline.memoryBytes;
      for (let i = 0; i < 50; ++i) cycle();
      assert.equal(sightline.memoryBytes, before);
    });

    await t.test('what is dropped is freed', async () => {
      setFlagsFromString('--expose-gc');
      const collect = runInNewContext('gc');
      const boxes = someBoxes(20_000);
      const settle = async () => {
        for (let i = 0; i < 3; ++i) {
          collect();
          await new Promise((resolve) => setTimeout(resolve, 10));
        }
      };
      const drop = async (count) => {
        for (let i = 0; i < count; ++i) {
          sightline.createBoxCuller(boxes);
          if (i % 50 === 49) await settle();
        }
      };
      await drop(100);
      const before = sightline.memoryBytes;
      await drop(1000);  // 660 MB in all
      assert.equal(sightline.memoryBytes, before);
    });

    await t.test('too much memory is an error, and the module goes on', () => {
      assert.throws(() => sightline.allocate(Float64Array, 2 ** 29 - 1), /not enough memory/);
      const culler = sightline.createBoxCuller(someBoxes(10));
      assert.deepEqual(sorted(culler.visible(view)), expectedOf(10));
      culler.dispose();
    });
  });
}

test('works in a worker, with a module that another one has compiled', { skip: lacking }, async () => {
  const module = await WebAssembly.compile(readFileSync(join(packageFolder, 'wasm/sightline-culling.simd.wasm')));
  const worker = new Worker(new URL('./worker.mjs', import.meta.url), {
    workerData: { module, packageFolder, boxes: someBoxes(1000), camera: kCube },
  });
  const indices = await new Promise((resolve, reject) => worker.on('message', resolve).on('error', reject));
  assert.deepEqual(sorted(indices), expectedOf(1000));
});

test('modules are independent of each other', { skip: lacking }, async () => {
  const { load } = await imported('culling-only.js');
  const [one, other] = [await load(), await load({ simd: false })];
  const culler = one.createBoxCuller(someBoxes(10)), view = other.createView(kCube);
  const { length } = other.createBoxCuller(someBoxes(6)).visible(view);
  assert.equal(length, 3);
  assert.equal(culler.visible(one.createView(kCube)).length, 5);
});
