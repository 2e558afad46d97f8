// A thread of a module with threads. First it gets the module and its memory, then threads to run, one after the other.

import { importsOf, isNode } from './imports.js';

// Places in the thread's own data, of Emscripten 3.1.6: the upper end of its stack, and the stack's size.
const kStackEnd = 44;
const kStackSize = 48;

/** @type {Record<string, any>} */
let exports;
/** @type {WebAssembly.Memory} */
let memory;
/** @type {(message: any) => void} */
let send;

/** @param {{ module: WebAssembly.Module, memory: WebAssembly.Memory, threads: number }} message */
function load(message) {
  memory = message.memory;
  const imports = importsOf(message.module, message, message.threads, {
    __emscripten_thread_cleanup: (/** @type {number} */ thread) => send({ ended: thread }),
  });
  exports = new WebAssembly.Instance(message.module, imports).exports;
  send({ ready: true });
}

/** @param {{ thread: number, start: number, argument: number }} message */
function run({ thread, start, argument }) {
  exports._emscripten_thread_init(thread, 0, 0, 1);
  const view = new DataView(memory.buffer);
  const end = view.getUint32(thread + kStackEnd, true);
  exports.emscripten_stack_set_limits(end, end - view.getUint32(thread + kStackSize, true));
  exports.stackRestore(end);
  exports.emscripten_tls_init();
  exports._emscripten_thread_exit(exports.__indirect_function_table.get(start)(argument));
}

/** @param {any} message */
function receive(message) {
  if (message.module) load(message);
  else run(message);
}

if (isNode) {
  const { parentPort } = await import(/* @vite-ignore */ /* webpackIgnore: true */ 'node:worker_threads');
  send = (message) => parentPort?.postMessage(message);
  parentPort?.on('message', receive);
} else {
  send = (message) => postMessage(message);
  onmessage = (event) => receive(event.data);
}
