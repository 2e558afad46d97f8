// One instance of a WebAssembly module: which of its files fits, how it is loaded in browsers, workers and node, and
// what the module asks of JavaScript.

import { importsOf, isNode } from './imports.js';

/** @typedef {'culling' | 'scene'} Part */

// Bundlers find files by these expressions.
const kFiles = {
  culling: {
    simd: () => new URL('../wasm/sightline-culling.simd.wasm', import.meta.url),
    threads: () => new URL('../wasm/sightline-culling.threads.wasm', import.meta.url),
    scalar: () => new URL('../wasm/sightline-culling.scalar.wasm', import.meta.url),
  },
  scene: {
    simd: () => new URL('../wasm/sightline.simd.wasm', import.meta.url),
    threads: () => new URL('../wasm/sightline.threads.wasm', import.meta.url),
    scalar: () => new URL('../wasm/sightline.scalar.wasm', import.meta.url),
  },
};

// A module of one function, which makes a vector and drops it.
const kSimdProbe = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 4, 1, 96, 0, 0, 3, 2, 1, 0, 10, 9, 1, 7, 0, 65, 0, 253, 15, 26, 11,
]);

/** Whether this browser or node has SIMD128. */
export function hasSimd() {
  return WebAssembly.validate(kSimdProbe);
}

/** Whether modules may share memory with workers: a page must be cross-origin isolated. */
export function hasThreads() {
  return typeof SharedArrayBuffer === 'function' && (isNode || globalThis.crossOriginIsolated === true) && hasSimd();
}

/**
 * @param {URL | string} url
 * @returns {Promise<WebAssembly.Module>}
 */
async function compile(url) {
  const address = new URL(url, import.meta.url);
  if (address.protocol === 'file:') {
    const fs = await import(/* @vite-ignore */ /* webpackIgnore: true */ 'node:fs/promises');
    return WebAssembly.compile(new Uint8Array(await fs.readFile(address)));
  }
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: expected a WebAssembly module, got status ${response.status}`);
  // Servers that do not know the type of .wasm files send another one, which streaming refuses.
  if (response.headers.get('content-type')?.startsWith('application/wasm'))
    return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}

/**
 * What every function of a module is called through.
 * @typedef {object} Instance
 * @property {Record<string, any>} exports
 * @property {WebAssembly.Memory} memory
 * @property {boolean} simd
 * @property {number} threads the calling one included
 * @property {() => void} close ends the workers
 */

/**
 * @param {Part} part
 * @param {import('./load.js').LoadOptions} options
 * @returns {Promise<Instance>}
 */
export async function instantiate(part, options) {
  const threads = options.threads ?? 1;
  if (!Number.isInteger(threads) || threads < 1) throw new RangeError(`threads: expected 1 or more, got ${threads}`);
  if (threads > 1 && !hasThreads())
    throw new Error('threads: expected SharedArrayBuffer and SIMD, which browsers have on cross-origin isolated pages');
  const simd = threads > 1 || (options.simd ?? hasSimd());
  const form = threads > 1 ? 'threads' : simd ? 'simd' : 'scalar';
  const module = options.module ?? (await compile(options.url ?? kFiles[part][form]()));
  return threads > 1 ? withThreads(module, threads) : alone(module, simd);
}

/**
 * @param {WebAssembly.Module} module
 * @param {boolean} simd
 * @returns {Promise<Instance>}
 */
async function alone(module, simd) {
  /** @type {{ memory: WebAssembly.Memory }} */
  const place = { memory: /** @type {any} */ (null) };
  const instance = await WebAssembly.instantiate(module, importsOf(module, place, 1));
  const exports = /** @type {Record<string, any>} */ (instance.exports);
  place.memory = exports.memory;
  exports.__wasm_call_ctors();
  return { exports, memory: exports.memory, simd, threads: 1, close() {} };
}

/**
 * @param {WebAssembly.Module} module
 * @param {number} threads
 * @returns {Promise<Instance>}
 */
async function withThreads(module, threads) {
  const { startThreads } = await import('./threads.js');
  return startThreads(module, threads);
}
