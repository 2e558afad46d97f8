"""docs/reference/python.md and the example do what they say."""

import contextlib
import io
import os
import re
import subprocess
import sys
import unittest

import sightline
from support import SOURCE, GlCase, plant


class Docs(GlCase):
    def test_the_page_runs(self):
        page = (SOURCE / "docs" / "reference" / "python.md").read_text()
        blocks = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
        self.assertGreater(len(blocks), 8)
        names = {}
        os.chdir(self.folder)
        self.addCleanup(os.chdir, SOURCE)
        for block in blocks:
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(block, "docs/reference/python.md", "exec"), names)
        self.assertTrue((self.folder / "plant.png").exists())
        names["engine"].close()

    def test_the_readme_runs(self):
        block = re.search(r"^```python\n(.*?)^```", (SOURCE / "README.md").read_text(), re.MULTILINE | re.DOTALL)
        os.chdir(self.folder)
        self.addCleanup(os.chdir, SOURCE)
        plant(1000).write("plant.rvm")
        exec(compile(block.group(1), "README.md", "exec"), {})
        self.assertEqual(sightline.read_png("plant.png").shape, (720, 1280, 3))

    def test_the_example_makes_its_report(self):
        example = SOURCE / "examples" / "regression_suite.py"
        done = subprocess.run([sys.executable, example, self.folder], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"overview +max +[1-9]\d* .*DIFFERS")
        self.assertRegex(done.stdout, r"max +0 .*  ok")
        page = (self.folder / "report.html").read_text()
        self.assertEqual(page.count("<img "), 12)
        plant(20000, 1).write(self.folder / "plant.rvm")
        self.tool("render", self.folder / "plant.rvm", "--plain", "--size", "480x320", "--out", self.folder / "tool.png")
        difference = sightline.compare(sightline.read_png(self.folder / "overview.png"),
                                       sightline.read_png(self.folder / "tool.png"))
        self.assertLessEqual(difference.max, 1)  # colours in files have 8 bits


if __name__ == "__main__":
    unittest.main()
