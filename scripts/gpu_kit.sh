#!/usr/bin/env bash
# Builds build/gpu-kit: a folder that tells how this library works on another machine's GPU (docs/results/gpu.md).
#   scripts/gpu_kit.sh
#   build/gpu-kit/run.sh OUT      there, or here; writes OUT/report.md in at most eight minutes
# The folder has tools, tests with a context, and reference images that llvmpipe draws here. It runs where glibc is 2.36
# or newer, and takes libEGL and all below it from the machine's driver.
set -euo pipefail
cd "$(dirname "$0")/.."
tools=(bench generate info render replay stability)
tree=build/gpu-kit-build kit=build/gpu-kit
newest_glibc=2.36 most_mib=40

scripts/setup.sh gpu-kit-build gpu_kit_tools gpu_kit_tests

fail() { echo "gpu_kit: $*" >&2; exit 1; }

# The tools are one program, which goes by its name.
copy_programs() {
  local tool
  strip -o "$kit/bin/tools" "$tree/bin/gpu_kit_tools"
  for tool in "${tools[@]}"; do ln -s tools "$kit/bin/sightline-$tool"; done
  strip -o "$kit/bin/tests" "$tree/bin/gpu_kit_tests"
}

# Libraries that every machine has with glibc are not copied, and those of drivers and of C++ must not be needed.
copy_libraries() {
  local name path
  while read -r name path; do
    case $name in
      libc.so.6 | libm.so.6 | libdl.so.2 | libpthread.so.0 | librt.so.1 | ld-linux-x86-64.so.2) ;;
      libEGL* | libGL* | libOpenGL* | libgbm* | libdrm* | libOSMesa* | libstdc++* | libgcc_s*)
        fail "the programs need $name, which the kit must not bring" ;;
      *) strip -o "$kit/lib/$name" "$path" ;;
    esac
  done < <(ldd "$kit"/bin/{tools,tests} | awk '$2 == "=>" { print $1, $3 }' | sort -u)
}

check_glibc() {
  local needed
  needed=$(objdump -T "$kit"/bin/{tools,tests} "$kit"/lib/* | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -n 1)
  [ "$(printf '%s\n' "${needed#GLIBC_}" "$newest_glibc" | sort -V | tail -n 1)" = "$newest_glibc" ] ||
    fail "the programs need $needed"
}

copy_data() {
  mkdir -p "$kit/checkout/tests/data"
  cp tests/data/{small_plant.rvm,small_plant.txt,cone_vtk.stl,cone_vtk.ply,box.stl} "$kit/checkout/tests/data/"
  cp scripts/gpu_kit/tests.txt "$kit/bin/"
  cp scripts/gpu_kit/run.sh LICENSE "$kit/"
  echo "Sightline $(git describe --always --dirty 2>/dev/null || echo unknown), built $(date -u +%F) with $(c++ --version | head -n 1)" \
    >"$kit/version.txt"
}

# Eight views of each of three models by llvmpipe, from the models' tours; those that show nothing are left out. The kit's
# machine draws them with all cullers in turns.
draw_references() {
  local model name frame drawn culler=0 frames=16 pixels=480x270
  local cullers=("--culler cpu" "--culler gpu --gpu-variant geometry" "--culler gpu --gpu-variant compute")
  export LIBGL_ALWAYS_SOFTWARE=1 SIGHTLINE_CONTEXT=egl-surfaceless
  "$kit/bin/sightline-generate" --items 3000 "$kit/refs/generated.rvm" >/dev/null
  for model in refs/generated.rvm checkout/tests/data/small_plant.rvm checkout/tests/data/cone_vtk.stl; do
    name=$(basename "${model%.*}") drawn=0
    "$kit/bin/sightline-replay" "$kit/$model" --no-render --frames 2 --save-path "$kit/refs/$name.json" >/dev/null
    for frame in {0..14..2} {1..15..2}; do
      if [ $drawn -eq 8 ]; then break; fi
      "$kit/bin/sightline-render" "$kit/$model" --path "$kit/refs/$name.json" --frame "$frame" --frames $frames --size $pixels \
        --culler cpu --out "$kit/refs/$name-$frame.png" --ids "$kit/refs/$name-$frame.ids.png" \
        --depth "$kit/refs/$name-$frame.pfm" 2>"$kit/refs/log"
      if grep -q 'no pixel shows' "$kit/refs/log"; then rm "$kit/refs/$name-$frame".* && continue; fi
      echo "$name-$frame $model --path refs/$name.json --frame $frame --frames $frames --size $pixels ${cullers[culler % 3]}" \
        >>"$kit/refs/images.txt"
      drawn=$((drawn + 1)) culler=$((culler + 1))
    done
    [ $drawn -eq 8 ] || fail "only $drawn views show $model"
  done
  rm "$kit/refs/log"
}

check_sizes() {
  local large
  [ "$(du -sm --apparent-size "$kit" | cut -f1)" -le "$most_mib" ] || fail "$kit is larger than $most_mib MiB"
  large=$(find "$kit" \( -name '*.rvm' -o -name '*.stl' -o -name '*.ply' \) -size +2M)
  [ -z "$large" ] || fail "larger than 2 MiB: $large"
}

rm -rf "$kit"
mkdir -p "$kit"/{bin,lib,refs}
copy_programs
copy_libraries
check_glibc
copy_data
draw_references
check_sizes
du -sh "$kit"
