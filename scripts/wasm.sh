#!/usr/bin/env bash
# The npm package of bindings/wasm, in build/npm/sightline, and build/npm/sightline-VERSION.tgz of it.
#   scripts/wasm.sh                 installs what is missing (Emscripten, npm packages), builds, packs
#   scripts/wasm.sh test [NAME …]   and runs its tests (tests/wasm) in node and Chromium: all, or these folders
#   scripts/wasm.sh demo [MODEL]    and serves the demo page with this plant (.rvm, .slc)
#   scripts/wasm.sh bench           and prints its figures beside those of three.js, three-mesh-bvh and the native library
# SIGHTLINE_WASM_FORMS names what to build: simd, threads, scalar (default: all).
set -euo pipefail
cd "$(dirname "$0")/.."
forms=${SIGHTLINE_WASM_FORMS:-simd threads scalar}

if [ "${1:-}" = test ]; then export SIGHTLINE_SETUP_BROWSER=1; fi

package=build/npm/sightline
rm -rf "$package"
mkdir -p "$package"/{js,wasm}
for form in $forms; do
  preset=wasm-$form
  if [ "$form" = simd ]; then preset=wasm; fi
  env -u SIGHTLINE_CMAKE_ARGS scripts/setup.sh "$preset"
  for module in sightline sightline-culling; do
    cp "build/$preset/bin/$module.wasm" "$package/wasm/$module.$form.wasm"
  done
done

cp bindings/wasm/js/*.js "$package/js/"
node bindings/wasm/shaders/generate.mjs "$package/js/shaders.js"
cp bindings/wasm/package.json bindings/wasm/README.md LICENSE "$package/"

# Types come from the comments of the sources, which are checked on the way.
tools=build/npm/tools
mkdir -p "$tools"
cp bindings/wasm/tools/*.json "$tools/"
if ! cmp -s "$tools/package-lock.json" "$tools/node_modules/.installed"; then
  npm ci --silent --no-audit --no-fund --prefix "$tools"
  cp "$tools/package-lock.json" "$tools/node_modules/.installed"
fi
ln -sfn ../tools/node_modules "$package/node_modules"
"$tools/node_modules/.bin/tsc" --project "$tools" --rootDir "$package/js" --outDir "$package/types"
rm "$package/node_modules"
(cd build/npm && npm pack --silent ./sightline)

case ${1:-} in
  test) exec tests/wasm/run.sh "${@:2}" ;;
  demo) exec node bindings/wasm/demo/serve.mjs "${@:2}" ;;
  bench) exec tests/wasm/run.sh --bench "${@:2}" ;;
esac
