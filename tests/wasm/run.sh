#!/usr/bin/env bash
# Runs the tests of the npm package (scripts/wasm.sh) in node and Chromium.
#   tests/wasm/run.sh [NAME …]   all folders here, or these
#   tests/wasm/run.sh --bench    no tests, but the figures of bindings/wasm/bench
# SIGHTLINE_LONG=1 tries as much as the nightly run. Builds the native programs that tests compare with, and installs npm
# packages in build/npm/peers.
set -euo pipefail
cd "$(dirname "$0")/../.."

peers=build/npm/peers
mkdir -p "$peers"
cp tests/wasm/package.json tests/wasm/package-lock.json "$peers/"
if ! cmp -s "$peers/package-lock.json" "$peers/node_modules/.installed"; then
  npm ci --silent --no-audit --no-fund --prefix "$peers"
  cp "$peers/package-lock.json" "$peers/node_modules/.installed"
fi
export SIGHTLINE_NODE_MODULES=$PWD/$peers/node_modules
scripts/setup.sh release wasm_culling_native wasm_primitives_scenes sightline-{convert,generate,info,render,trace}
programs=$PWD/build/release/tests
export SIGHTLINE_WASM_CULLING_NATIVE=$programs/wasm_culling_native
if [ "${1:-}" = --bench ]; then exec node bindings/wasm/bench/bench.mjs "${@:2}"; fi

names=("$@")
if [ ${#names[@]} -eq 0 ]; then
  for folder in tests/wasm/*/; do
    if [ -e "$folder/run.mjs" ] || compgen -G "$folder/*.test.mjs" >/dev/null; then names+=("$(basename "$folder")"); fi
  done
fi
failed=()
for name in "${names[@]}"; do
  folder=tests/wasm/$name
  if compgen -G "$folder/*.test.mjs" >/dev/null; then
    node --test "$folder" || failed+=("$name")
  elif [ -e "$folder/run.mjs" ]; then
    node "$folder/run.mjs" "$programs/wasm_${name}_scenes" "$PWD/build/tests/wasm-$name" || failed+=("$name")
  else
    failed+=("$name (no tests there)")
  fi
done
if [ ${#failed[@]} -gt 0 ]; then
  printf 'wasm tests: failed: %s\n' "${failed[*]}" >&2
  exit 1
fi
