// Files of texts and arrays in turn, as records.h writes them.

const kTypes = [Uint8Array, Uint32Array, Float32Array, Float64Array];

export class RecordReader {
  /** @param {ArrayBuffer} buffer */
  constructor(buffer) {
    this.buffer = buffer;
    this.at = 0;
  }
  get more() {
    return this.at + 8 <= this.buffer.byteLength;
  }
  array() {
    const [type, count] = new Uint32Array(this.buffer, this.at, 2);
    const values = new kTypes[type](this.buffer, this.at + 8, count);
    this.at += 8 + ((values.byteLength + 7) & ~7);
    return values;
  }
  text() {
    return new TextDecoder().decode(this.array());
  }
  /** What write_view() writes, as createView() takes it. */
  camera() {
    const [view, projection, [depth, width, height, any], planes] = [this.array(), this.array(), this.array(), this.array()];
    const sections = Array.from({ length: planes.length / 4 }, (_, i) => planes.subarray(4 * i, 4 * i + 4));
    return { view, projection, depth: kDepths[depth], width, height, sections, anySection: any !== 0 };
  }
}
export const kDepths = ['reversed', 'minusOneToOne', 'zeroToOne'];

export class RecordWriter {
  #parts = [];

  array(values) {
    const bytes = new Uint8Array(8 + ((values.byteLength + 7) & ~7));
    new Uint32Array(bytes.buffer, 0, 2).set([kTypes.indexOf(values.constructor), values.length]);
    bytes.set(new Uint8Array(values.buffer, values.byteOffset, values.byteLength), 8);
    this.#parts.push(bytes);
  }
  camera({ view, projection, depth = 'minusOneToOne', width = 1, height = 1 }) {
    this.array(Float64Array.from(view));
    this.array(Float64Array.from(projection));
    this.array(Float64Array.of(kDepths.indexOf(depth), width, height, 0));
    this.array(new Float64Array(0));
  }
  /** All so far, which is forgotten. */
  take() {
    const parts = this.#parts;
    this.#parts = [];
    return parts;
  }
}
