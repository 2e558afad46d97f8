// Writes an ES module with the text of the shaders that draw analytic primitives in WebGL2, from the files that the
// desktop compiles. No arguments but the module's path:
//   node generate.mjs OUTPUT
//
// The module exports `vertexShader` and `fragmentShader`, GLSL ES 3.00 without the #version line and the defines that
// choose a kind (primitives.js), and without comments.
import {existsSync, mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const root = join(here, '..', '..', '..');

/** Where files are found. The first file of a name wins: a file beside this one stands for the desktop's. */
const folders = [here, join(root, 'render', 'shaders'), join(root, 'gpuprims', 'shaders')];

/** Path of a shader file. */
function find(name, from) {
  const path = folders.map((folder) => join(folder, name)).find((candidate) => existsSync(candidate));
  if (!path) throw new Error(`${from}: no shader file is named '${name}'`);
  return path;
}

/**
 * The file's text with each #include replaced by that file, the first time that a stage includes it. As
 * gl::assemble_stage() does it.
 */
function expand(name, included = new Set(), from = 'stage') {
  included.add(name);
  const lines = readFileSync(find(name, from), 'utf8').split('\n');
  return lines
      .map((line, i) => {
        const found = line.match(/^\s*#\s*include\s+"([^"]+)"/);
        if (!found) return line;
        return included.has(found[1]) ? '' : expand(found[1], included, `${name}:${i + 1}`);
      })
      .join('\n');
}

/** Removes what GLSL ES 3.00 does not have: numbers of uniforms and of what stages hand on, which names link there. */
function withoutNumbers(text) {
  return text.replace(/layout\s*\(\s*(?:location|binding)\s*=\s*\d+\s*\)\s*/g, '');
}

/** Removes comments, blank lines and indents. */
function compact(text) {
  return text.replace(/\/\*[^]*?\*\//g, ' ')
             .replace(/\/\/.*$/gm, '')
             .replace(/^\s+|[ \t]+$/gm, '')
             .replace(/\n{2,}/g, '\n')
             .trim() +
      '\n';
}

/** Text of a stage. */
function stage(name) {
  const text = compact(withoutNumbers(expand(name)));
  if (text.includes('`') || text.includes('${')) throw new Error(`${name}: holds what a template string cannot`);
  return text;
}

const output = process.argv[2];
if (!output) {
  console.error('generate: expected the path of the module to write');
  process.exit(2);
}
mkdirSync(dirname(output), {recursive: true});
writeFileSync(output, `// Generated from shader files: edit those.
export const vertexShader = \`${stage('three.vert')}\`;
export const fragmentShader = \`${stage('three.frag')}\`;
`);
