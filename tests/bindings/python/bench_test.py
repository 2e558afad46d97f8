"""apps/bench/python_calls.py does in Python what sightline-bench calls does in C++: the same counts."""

import subprocess
import sys
import unittest

from support import SOURCE, TOOLS, Case


class Calls(Case):
    def test_the_same_work(self):
        program = SOURCE / "apps" / "bench" / "python_calls.py"
        done = subprocess.run([sys.executable, program, TOOLS / "sightline-bench", "1000"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in ("frame", "pick", "boxes"):
            self.assertRegex(done.stdout, rf"(?m)^{name} +\d+\.\d+ +\d+\.\d+ +-?\d+\.\d+$")


if __name__ == "__main__":
    unittest.main()
