// What the modules import: memory that grows, clocks, and an end for broken contracts.

/** Whether this is node and no browser. */
export const isNode = typeof process === 'object' && typeof process.versions?.node === 'string';

const kPage = 65536;
const kMostPages = 65536;
const kEnosys = 52;

/**
 * Functions by name, of those that the module asks for.
 * @param {WebAssembly.Module} module
 * @param {{ memory: WebAssembly.Memory }} place whose memory is set before the first call
 * @param {number} threads
 * @param {Record<string, Function>} more functions that this thread adds
 * @returns {WebAssembly.Imports}
 */
export function importsOf(module, place, threads, more = {}) {
  const bytes = () => new Uint8Array(place.memory.buffer);
  /** @type {Record<string, any>} */
  const known = {
    emscripten_memcpy_big(/** @type {number} */ to, /** @type {number} */ from, /** @type {number} */ count) {
      bytes().copyWithin(to >>> 0, from >>> 0, (from >>> 0) + (count >>> 0));
    },
    /** Grows by a fifth and at most 96 MiB more than is asked for, or by what is asked for. */
    emscripten_resize_heap(/** @type {number} */ wanted) {
      const size = place.memory.buffer.byteLength;
      const pages = Math.ceil((wanted >>> 0) / kPage);
      const generous = Math.ceil(Math.min(size * 1.2, (wanted >>> 0) + 96 * 2 ** 20) / kPage);
      for (const target of [Math.min(Math.max(pages, generous), kMostPages), pages]) {
        try {
          place.memory.grow(Math.max(0, target - place.memory.buffer.byteLength / kPage));
          return 1;
        } catch {
          continue;
        }
      }
      return 0;
    },
    emscripten_get_heap_max: () => 2 ** 32 - kPage,
    emscripten_get_now: () => performance.timeOrigin + performance.now(),
    emscripten_num_logical_cores: () => threads,
    clock_gettime(/** @type {number} */ _clock, /** @type {number} */ to) {
      const now = performance.timeOrigin + performance.now();
      const view = new DataView(place.memory.buffer);
      view.setInt32(to, Math.floor(now / 1e3), true);
      view.setInt32(to + 4, Math.floor((now % 1e3) * 1e6), true);
      return 0;
    },
    environ_sizes_get(/** @type {number} */ count, /** @type {number} */ size) {
      const view = new DataView(place.memory.buffer);
      view.setUint32(count, 0, true);
      view.setUint32(size, 0, true);
      return 0;
    },
    environ_get: () => 0,
    _emscripten_default_pthread_stack_size: () => 2 ** 21,
    emscripten_check_blocking_allowed() {},
    abort() {
      throw new Error('sightline: the module has ended, by a broken contract or for want of memory');
    },
    ...more,
  };
  /** @type {WebAssembly.Imports} */
  const imports = {};
  for (const { module: from, name, kind } of WebAssembly.Module.imports(module)) {
    imports[from] ??= {};
    if (kind === 'memory') imports[from][name] = place.memory;
    // What is left are calls of a system that browsers do not have: files, the environment.
    else imports[from][name] = known[name] ?? (() => kEnosys);
  }
  return imports;
}
