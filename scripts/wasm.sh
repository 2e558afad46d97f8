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

packages=(emscripten ninja-build cmake libglm-dev libexpected-dev libfmt-dev nlohmann-json3-dev libxxhash-dev)
if [ "${1:-}" = test ]; then packages+=(chromium); fi
missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
command -v npm >/dev/null || missing+=(npm)
if [ ${#missing[@]} -gt 0 ]; then
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then as_root=(sudo); fi
  echo "Installing ${missing[*]}"
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
fi

# Emscripten's own scripts look for node's modules where Debian installs them.
export NODE_PATH=/usr/share/nodejs${NODE_PATH:+:$NODE_PATH}
if command -v ccache >/dev/null && [ -z "$(ccache --get-config base_dir)" ]; then
  export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
fi

package=build/npm/sightline
rm -rf "$package"
mkdir -p "$package"/{js,wasm}
for form in $forms; do
  preset=wasm-$form
  if [ "$form" = simd ]; then preset=wasm; fi
  launcher=()
  if [ ! -e "build/$preset/CMakeCache.txt" ] && command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi
  cmake --preset "$preset" -DSIGHTLINE_UNITY=ON "${launcher[@]}" >/dev/null
  cmake --build --preset "$preset" -j "$(nproc)"
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
[ -d "$tools/node_modules/typescript" ] || npm ci --silent --no-audit --no-fund --prefix "$tools"
ln -sfn ../tools/node_modules "$package/node_modules"
"$tools/node_modules/.bin/tsc" --project "$tools" --rootDir "$package/js" --outDir "$package/types"
rm "$package/node_modules"
(cd build/npm && npm pack --silent ./sightline)

case ${1:-} in
  test) exec tests/wasm/run.sh "${@:2}" ;;
  demo) exec node bindings/wasm/demo/serve.mjs "${@:2}" ;;
  bench) exec tests/wasm/run.sh --bench "${@:2}" ;;
esac
