// Objects that live in a module's memory, arrays that go in and out, and errors.

/** What a module's function failed with, in its own words. */
export class SightlineError extends Error {
  /** @param {string} message */
  constructor(message) {
    super(message);
    this.name = 'SightlineError';
  }
}

/** @typedef {Float64Array | Float32Array | Uint32Array | Uint8Array} TypedArray */
/** @typedef {Float64ArrayConstructor | Float32ArrayConstructor | Uint32ArrayConstructor | Uint8ArrayConstructor} ArrayType */

const kMostBytes = 2 ** 32; // addresses have 32 bits

/** Calls functions of one module. @internal */
export class Bridge {
  /** @param {import('./instance.js').Instance} instance */
  constructor(instance) {
    this.instance = instance;
    this.exports = instance.exports;
    /** What was dropped without dispose(). */
    this.registry = new FinalizationRegistry((/** @type {() => void} */ destroy) => destroy());
    this.scratch = { address: 0, size: 0, used: 0 };
    this.text = new TextDecoder();
  }

  /**
   * An array of the module's memory. It is detached when that memory grows: read it before anything is called again.
   * @template {ArrayType} T
   * @param {T} Type
   * @param {number} address
   * @param {number} length
   * @returns {InstanceType<T>}
   */
  view(Type, address, length) {
    return /** @type {any} */ (new Type(/** @type {any} */ (this.instance.memory.buffer), address >>> 0, length));
  }

  /**
   * The last answer.
   * @template {ArrayType} T
   * @param {T} Type
   * @returns {InstanceType<T>}
   */
  answer(Type) {
    const [address, count] = this.view(Uint32Array, this.exports.sl_answer(), 2);
    return this.view(Type, address, count);
  }
  /** The last answer as text. */
  answerText() {
    return this.text.decode(this.answer(Uint8Array).slice());
  }

  /** @returns {never} */
  fail() {
    this.exports.sl_error();
    throw new SightlineError(this.answerText());
  }
  /**
   * What a function returned that returns 0 where it failed.
   * @template T
   * @param {T} result
   */
  checked(result) {
    return result || this.fail();
  }

  /**
   * Calls `work` with memory that is free again afterwards. `size`: bytes at most, for all that lend() copies.
   * @template T
   * @param {number} size
   * @param {() => T} work
   * @returns {T}
   */
  withScratch(size, work) {
    const scratch = this.scratch;
    if (scratch.size < size) {
      this.freeScratch();
      Object.assign(scratch, { address: this.allocate(size), size });
    }
    scratch.used = 0;
    return work();
  }

  /** Gives back scratch memory, after something large. */
  freeScratch() {
    this.exports.sl_free(this.scratch.address);
    Object.assign(this.scratch, { address: 0, size: 0, used: 0 });
  }

  /**
   * The address of so many bytes.
   * @param {number} size
   */
  allocate(size) {
    const address = size < kMostBytes ? this.exports.sl_allocate(size) >>> 0 : 0;
    if (address === 0) throw new SightlineError(`not enough memory for ${size} bytes`);
    return address;
  }

  /**
   * The address of an array's numbers: of a NativeArray its own, of another a copy in scratch memory.
   * @param {ArrayType} Type
   * @param {ArrayLike<number> | NativeArray} values
   */
  lend(Type, values) {
    if (values instanceof NativeArray) {
      if (!(values.view instanceof Type)) throw new TypeError(`expected a NativeArray of ${Type.name}`);
      return values.address;
    }
    const address = this.scratch.address + this.scratch.used;
    this.view(Type, address, values.length).set(values);
    this.scratch.used += (values.length * Type.BYTES_PER_ELEMENT + 15) & ~15;
    return address;
  }
}

/**
 * Bytes of scratch memory that lend() needs.
 * @param {...[ArrayType, ArrayLike<number> | NativeArray]} arrays
 */
export function sizeOf(...arrays) {
  let size = 0;
  for (const [Type, values] of arrays)
    if (!(values instanceof NativeArray)) size += values.length * Type.BYTES_PER_ELEMENT + 16;
  return size;
}

/**
 * Something in a module's memory. It is freed by dispose(), or some time after nothing refers to it any more: browsers
 * do not see how large it is, so large ones should be disposed of.
 */
export class NativeObject {
  /** @type {Bridge} */ #bridge;
  /** @type {number} */ #address;
  #destroy;

  /**
   * @internal
   * @param {Bridge} bridge
   * @param {number} address
   * @param {string} destroy the function that frees it
   */
  constructor(bridge, address, destroy) {
    this.#bridge = bridge;
    this.#address = address >>> 0;
    this.#destroy = destroy;
    bridge.registry.register(this, () => bridge.exports[destroy](address), this);
  }

  /** @internal */
  get bridge() {
    return this.#bridge;
  }
  /** @internal */
  get address() {
    if (this.#address === 0) throw new SightlineError(`${this.constructor.name}: it was disposed of`);
    return this.#address;
  }
  /** Whether dispose() was called. */
  get disposed() {
    return this.#address === 0;
  }
  /** Frees the memory. The object must not be used afterwards. Calling it twice is fine. */
  dispose() {
    if (this.#address === 0) return;
    this.#bridge.registry.unregister(this);
    this.#bridge.exports[this.#destroy](this.#address);
    this.#address = 0;
  }
  /** For `using`. */
  [/** @type {any} */ (Symbol).dispose ?? Symbol.for('dispose')]() {
    this.dispose();
  }
}

/**
 * An array in the module's memory: what is written to it is not copied when it is handed to a function. Get `view` anew
 * after every call, since the module's memory may have grown, which detaches older views.
 */
export class NativeArray extends NativeObject {
  #Type;
  #length;

  /**
   * @internal
   * @param {Bridge} bridge
   * @param {ArrayType} Type
   * @param {number} length
   */
  constructor(bridge, Type, length) {
    if (!Number.isInteger(length) || length < 0) throw new RangeError(`length: expected 0 or more, got ${length}`);
    super(bridge, bridge.allocate(length * Type.BYTES_PER_ELEMENT), 'sl_free');
    this.#Type = Type;
    this.#length = length;
  }
  get length() {
    return this.#length;
  }
  /** @returns {TypedArray} */
  get view() {
    return this.bridge.view(this.#Type, this.address, this.#length);
  }
}
