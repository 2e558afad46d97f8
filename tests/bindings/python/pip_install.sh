#!/usr/bin/env bash
# pip_install.sh PYTHON SOURCE VENV BUILD_TREE [CMAKE_ARGUMENTS]: installs the module with pip into a new virtual
# environment and uses it there. With CMAKE_ARGUMENTS the tree is built from nothing and these are added to pip's own.
# Exits 77 where Python has no pip or venv.
set -euo pipefail
python=$1 source=$2 venv=$3 tree=$4
settings=(--config-settings "build-dir=$tree")
if [ $# -gt 4 ]; then
  rm -rf "$tree"
  settings+=(--config-settings "cmake-args=$5")
fi
"$python" -c "import ensurepip, venv" 2>/dev/null || { echo "skipped: no python3-venv"; exit 77; }
rm -rf "$venv"
"$python" -m venv --system-site-packages "$venv"
export PIP_NO_INDEX=1 PIP_DISABLE_PIP_VERSION_CHECK=1
"$venv/bin/pip" install --quiet "${settings[@]}" "$source"
cd "$venv"  # not the source tree, whose folder sightline/ would be found
bin/python - <<'END'
import sightline, sys
assert sightline.__file__.startswith(sys.prefix), sightline.__file__
scene = sightline.Scene()
scene.generate_plant(1000)
print(sightline.__version__, sightline.Engine(scene).fit(aspect=1.5).eye)
END
bin/pip uninstall --quiet --yes sightline
! bin/python -c "import sightline" 2>/dev/null
