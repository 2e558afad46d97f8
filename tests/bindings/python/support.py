"""What the tests of the Python module share."""

import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
import sightline

SOURCE = pathlib.Path(os.environ["SIGHTLINE_SOURCE_DIR"])
TOOLS = pathlib.Path(os.environ.get("SIGHTLINE_BIN_DIR", ""))
SMALL_PLANT = SOURCE / "tests" / "data" / "small_plant.rvm"


def plant(items=3000, seed=1):
    scene = sightline.Scene()
    scene.generate_plant(items, seed)
    return scene


def box_rows(count, seed=1, reach=100.0):
    """Boxes of 0 to 5 units, (count, 6)."""
    random = np.random.default_rng(seed)
    low = random.uniform(-reach, reach, (count, 3))
    return np.hstack([low, low + random.uniform(0.0, 5.0, (count, 3))])


def overview(scene, aspect=1.6):
    return sightline.View.fit(scene.root.bounds(), sightline.OVERVIEW_DIRECTION, aspect=aspect)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def assert_error(self, text, call, *args, **kwargs):
        """The call raises sightline.Error, which says `text`."""
        with self.assertRaises(sightline.Error) as caught:
            call(*args, **kwargs)
        self.assertIn(text, str(caught.exception))

    def tool(self, name, *args):
        """Runs a tool, which must succeed."""
        done = subprocess.run([TOOLS / f"sightline-{name}", *map(str, args)], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout


class GlCase(Case):
    """Skips, with the library's words, where there is no way to a context; as tests/support/no_gl.h."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        try:
            sightline.Engine(sightline.Scene(), draw=True, width=8, height=8).close()
        except sightline.Error as error:
            required = os.environ.get("SIGHTLINE_REQUIRE_GL", "0") not in ("", "0")
            if required or not ("EGL: " in str(error) or "OSMesa: " in str(error)):
                raise
            raise unittest.SkipTest(str(error))
