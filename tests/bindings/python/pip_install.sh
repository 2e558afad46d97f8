#!/usr/bin/env bash
# pip_install.sh PYTHON SOURCE BUILD_TREE VENV: installs the module with pip into a new virtual environment, from a tree
# that is built, and uses it there. Exits 77 where Python has no pip or venv.
set -euo pipefail
python=$1 source=$2 tree=$3 venv=$4
"$python" -c "import ensurepip, venv" 2>/dev/null || { echo "skipped: no python3-venv"; exit 77; }
rm -rf "$venv"
"$python" -m venv --system-site-packages "$venv"
export PIP_NO_INDEX=1 PIP_DISABLE_PIP_VERSION_CHECK=1
"$venv/bin/pip" install --quiet --no-build-isolation --config-settings "build-dir=$tree" "$source"
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
