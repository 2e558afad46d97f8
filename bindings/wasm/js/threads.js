// Threads of a module: workers that share its memory. They are started before the first call, since a page that waits
// for a thread cannot start one. A thread for which no worker is left is not made, and the others do its work.

import { importsOf, isNode } from './imports.js';

const kAgain = 6; // EAGAIN
const kFirstPages = 256;
const kMostPages = 65536;

/**
 * A worker of a browser or of node.
 * @param {(message: any) => void} receive
 */
async function startWorker(receive) {
  if (isNode) {
    const { Worker } = await import(/* @vite-ignore */ /* webpackIgnore: true */ 'node:worker_threads');
    const worker = new Worker(new URL('./thread_worker.js', import.meta.url));
    worker.unref();
    worker.on('message', receive);
    return worker;
  }
  const worker = new Worker(new URL('./thread_worker.js', import.meta.url), { type: 'module' });
  worker.onmessage = (event) => receive(event.data);
  return worker;
}

/** Who waits for whom: workers that are free, and what the workers of others do. */
class Pool {
  /** @type {any[]} */ workers = [];
  /** @type {any[]} */ free = [];
  /** @type {Record<string, any>} */ exports = {};

  /**
   * Starts so many workers, each with an instance of the module.
   * @param {WebAssembly.Module} module
   * @param {WebAssembly.Memory} memory
   * @param {number} count
   */
  async start(module, memory, count) {
    await Promise.all(
      Array.from({ length: count }, async () => {
        /** @type {(worker: any) => void} */
        let ready = () => {};
        const loaded = new Promise((resolve) => (ready = resolve));
        /** @type {any} */
        const worker = await startWorker((message) => {
          if (message.ready) return ready(worker);
          // The thread has ended: its worker may run another one.
          this.exports._emscripten_thread_free_data(message.ended);
          this.free.push(worker);
        });
        worker.postMessage({ module, memory, threads: count + 1 });
        this.workers.push(await loaded);
      }),
    );
    this.free.push(...this.workers);
  }
  /**
   * @param {number} thread
   * @param {number} start
   * @param {number} argument
   */
  run(thread, start, argument) {
    const worker = this.free.pop();
    if (!worker) return kAgain;
    worker.postMessage({ thread, start, argument });
    return 0;
  }
  close() {
    for (const worker of this.workers) worker.terminate();
    this.workers = this.free = [];
  }
}

/**
 * @param {WebAssembly.Module} module
 * @param {number} threads
 * @returns {Promise<import('./instance.js').Instance>}
 */
export async function startThreads(module, threads) {
  const memory = new WebAssembly.Memory({ initial: kFirstPages, maximum: kMostPages, shared: true });
  const pool = new Pool();
  const onPage = typeof document === 'object';
  const imports = importsOf(module, { memory }, threads, {
    __pthread_create_js: (/** @type {number} */ thread, /** @type {number} */ _attributes, /** @type {number} */ start, /** @type {number} */ argument) =>
      pool.run(thread, start, argument),
    __emscripten_init_main_thread_js(/** @type {number} */ thread) {
      exports._emscripten_thread_init(thread, onPage ? 1 : 0, 1, onPage ? 0 : 1);
      exports.emscripten_tls_init();
    },
  });
  const instance = await WebAssembly.instantiate(module, imports);
  const exports = /** @type {Record<string, any>} */ (instance.exports);
  pool.exports = exports;
  exports.__wasm_call_ctors();
  await pool.start(module, memory, threads - 1);
  return { exports, memory, simd: true, threads, close: () => pool.close() };
}
