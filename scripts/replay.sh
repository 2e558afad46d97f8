#!/usr/bin/env bash
# Set-up, build, and a culled, rendered camera flight with figures, in one command.
#   scripts/replay.sh                  generates a plant of 100,000 items and flies through it
#   scripts/replay.sh MODEL…           flies through your own models (.rvm, .obj)
# FRAMES (300), SIZE (640x360), EVERY (25) and OUT (out) may be set in the environment.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh release sightline-generate sightline-render sightline-replay
bin=build/release/bin
out=${OUT:-out}
mkdir -p "$out"
models=("$@")
if [ ${#models[@]} -eq 0 ]; then
  models=("$out/plant.rvm")
  [ -e "${models[0]}" ] || "$bin/sightline-generate" --items 100000 "${models[0]}"
fi
"$bin/sightline-render" "${models[@]}" --size 1280x720 --out "$out/overview.png"
"$bin/sightline-replay" "${models[@]}" --frames "${FRAMES:-300}" --size "${SIZE:-640x360}" --images "$out/frames" \
  --every "${EVERY:-25}" --plot "$out/replay.svg" --json "$out/replay.json" --csv "$out/replay.csv" \
  --save-path "$out/path.json" --explain
echo
echo "Written to $out: overview.png, frames/, replay.svg, replay.json, replay.csv, path.json"
