// Serves the demo page.   node bindings/wasm/demo/serve.mjs [MODEL]
// MODEL: a file (.rvm, .rev, .slc) to show at first, such as one of sightline-generate. The package is that of
// scripts/wasm.sh. Headers make the page cross-origin isolated, so that it may use threads. PORT: 8080 unless set.
import { createReadStream, existsSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { basename, dirname, extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const npm = join(here, '..', '..', '..', 'build', 'npm');
const model = process.argv[2];
const roots = { sightline: join(npm, 'sightline'), three: join(npm, 'tools', 'node_modules', 'three') };
const types = { '.html': 'text/html', '.js': 'text/javascript', '.wasm': 'application/wasm' };

for (const path of [...Object.values(roots), ...(model ? [model] : [])])
  if (!existsSync(path)) {
    console.error(`${path} is not there; scripts/wasm.sh makes the package`);
    process.exit(1);
  }

function fileOf(path) {
  if (path === '/model') return model;
  const [, root, ...rest] = path.split('/');
  return root in roots ? join(roots[root], ...rest) : join(here, path === '/' ? 'index.html' : path);
}

const server = createServer((request, response) => {
  const file = fileOf(normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname)));
  if (!file || !existsSync(file) || !statSync(file).isFile()) return void response.writeHead(404).end();
  response.writeHead(200, {
    'Content-Type': types[extname(file)] ?? 'application/octet-stream',
    'Cross-Origin-Embedder-Policy': 'require-corp',
    'Cross-Origin-Opener-Policy': 'same-origin',
    'X-File-Name': basename(file),
  });
  createReadStream(file).pipe(response);
});
server.listen(Number(process.env.PORT ?? 8080), '127.0.0.1', () =>
  console.log(`http://127.0.0.1:${server.address().port}/`),
);
