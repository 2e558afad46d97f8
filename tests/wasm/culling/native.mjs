// Where the package and the program lie that these tests compare: in the environment, or where builds put them.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const checkout = fileURLToPath(new URL('../../..', import.meta.url));
export const packageFolder = process.env.SIGHTLINE_PACKAGE ?? join(checkout, 'build/npm/sightline');
const program = process.env.SIGHTLINE_WASM_CULLING_NATIVE ?? join(checkout, 'build/release/tests/wasm_culling_native');

/** Why nothing can be tested here, or false. */
export const lacking = [packageFolder, program].filter((path) => !existsSync(path)).map((path) => `no ${path}`)[0] ?? false;

export const isLong = process.env.SIGHTLINE_LONG === '1';

/** A module of the package by its file in js/. */
export function imported(file) {
  return import(pathToFileURL(join(packageFolder, 'js', file)));
}

/** The forms of the package's modules that this node can run, as options of load(). */
export const kForms = { simd: { simd: true }, scalar: { simd: false }, threads: { threads: 2 } };

/** What the program prints. */
export function native(args, options = {}) {
  return execFileSync(program, args, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'], ...options });
}

/** Calls `work` with a folder that is removed afterwards. */
export async function inFolder(work) {
  const parent = join(checkout, 'build/tests');
  mkdirSync(parent, { recursive: true });
  const folder = mkdtempSync(join(parent, 'wasm-'));
  try {
    return await work(folder);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

/** A file's bytes in a buffer of their own. */
export function bufferOf(file) {
  return new Uint8Array(readFileSync(file)).buffer;
}
