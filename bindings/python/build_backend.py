"""Makes a wheel of the package sightline with CMake, for pip (PEP 517). Needs nothing but Python and the build's tools.

Settings, by pip's --config-settings NAME=VALUE:
  build-dir    build tree, which is kept; default build/wheel. One that was configured with SIGHTLINE_PYTHON is used as
               it is.
  cmake-args   more arguments for a new tree
"""

import base64
import hashlib
import os
import pathlib
import re
import shlex
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
VERSION = re.search(r"project\(sightline VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)

METADATA = f"""Metadata-Version: 2.1
Name: sightline
Version: {VERSION}
Summary: Scene-graph visibility middleware for CAD viewers
License: MIT
Requires-Python: >=3.9
Requires-Dist: numpy
Description-Content-Type: text/markdown

{(SOURCE / "docs" / "reference" / "python.md").read_text()}"""


def _run(*command):
    subprocess.run([str(part) for part in command], check=True)


def _build(folder, settings):
    """Configures where needed, builds, and installs into `folder`."""
    tree = pathlib.Path(settings.get("build-dir", SOURCE / "build" / "wheel"))
    if not (tree / "CMakeCache.txt").exists():
        without = [f"-DSIGHTLINE_{part}=OFF" for part in ("APPS", "BENCH", "EXAMPLES", "OCCT", "TESTS", "VTK")]
        _run("cmake", "-S", SOURCE, "-B", tree, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", *without,
             "-DSIGHTLINE_PYTHON=ON", "-DSIGHTLINE_INSTALL=ON", f"-DPython_EXECUTABLE={sys.executable}",
             *shlex.split(settings.get("cmake-args", "")))
    python = re.search(r"^SIGHTLINE_PYTHON:BOOL=(\w+)", (tree / "CMakeCache.txt").read_text(), re.MULTILINE)
    if not python or python.group(1) != "ON":
        raise SystemExit(f"{tree}: configured without SIGHTLINE_PYTHON")
    _run("cmake", "--build", tree, "--target", "sightline_python")
    _run("cmake", "--install", tree, "--component", "python", "--prefix", folder, "--strip")


def _hash(data):
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    tag = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    name = f"sightline-{VERSION}-{tag}-{tag}-{platform}.whl"
    info = f"sightline-{VERSION}.dist-info"
    with tempfile.TemporaryDirectory() as folder:
        _build(folder, config_settings or {})
        (init,) = pathlib.Path(folder).rglob("sightline/__init__.py")
        files = {f"sightline/{path.name}": path.read_bytes() for path in sorted(init.parent.iterdir())}
    files[f"{info}/METADATA"] = METADATA.encode()
    files[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: sightline\nRoot-Is-Purelib: false\n"
                              f"Tag: {tag}-{tag}-{platform}\n").encode()
    files[f"{info}/LICENSE"] = (SOURCE / "LICENSE").read_bytes()
    record = [f"{path},{_hash(data)},{len(data)}" for path, data in files.items()] + [f"{info}/RECORD,,"]
    files[f"{info}/RECORD"] = ("\n".join(record) + "\n").encode()
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            wheel.writestr(path, data)
    return name


def build_sdist(sdist_directory, config_settings=None):
    raise NotImplementedError("sightline is installed from its source tree: pip install .")
