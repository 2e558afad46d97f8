"""The stubs say what the module has, everything has a docstring, and mypy accepts programs."""

import ast
import inspect
import pathlib
import re
import subprocess
import sys
import unittest

import sightline
from sightline import _sightline
from support import SOURCE, Case

STUBS = pathlib.Path(_sightline.__file__).with_name("_sightline.pyi")


def arguments_in_docstring(doc):
    """Names of the arguments of each overload, from what pybind11 writes; without self."""
    lines = re.findall(r"^(?:\d+\. )?\w+\((.*)\) -> ", doc, re.MULTILINE)
    names = []
    for line in lines:
        line = re.sub(r"\[[^\]]*\]", "", line)
        line = re.sub(r"\[[^\]]*\]", "", line)
        found = [part.split(":")[0].split("=")[0].strip() for part in line.split(",")]
        names.append([name for name in found if re.fullmatch(r"[a-z_]\w*", name) and name != "self"])
    return names


def stubbed_arguments(node):
    """(name, kind, whether there is a default) of each argument of a function in the stubs, without self."""
    given, alone = node.args.args, node.args.kwonlyargs
    found = [(a.arg, "positional", i >= len(given) - len(node.args.defaults)) for i, a in enumerate(given)]
    found += [(a.arg, "keyword", default is not None) for a, default in zip(alone, node.args.kw_defaults)]
    return [argument for argument in found if argument[0] != "self"]


def told_arguments(thing):
    """The same as inspect tells it."""
    kinds = {inspect.Parameter.POSITIONAL_OR_KEYWORD: "positional", inspect.Parameter.KEYWORD_ONLY: "keyword"}
    return [(p.name, kinds[p.kind], p.default is not p.empty) for p in inspect.signature(thing).parameters.values()
            if p.name != "self"]


class Stubs(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        tree = ast.parse(STUBS.read_text())
        cls.functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
        cls.classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
        cls.values = {node.target.id for node in tree.body if isinstance(node, ast.AnnAssign)}

    def public(self, names):
        return {name for name in names if not name.startswith("_")}

    def test_names(self):
        stubbed = {f.name for f in self.functions} | set(self.classes) | self.values
        self.assertEqual(stubbed, self.public(vars(_sightline)))
        for name, node in self.classes.items():
            members = {m.name for m in node.body if isinstance(m, ast.FunctionDef)}
            members |= {m.target.id for m in node.body if isinstance(m, ast.AnnAssign)}
            self.assertEqual(self.public(members), self.public(vars(getattr(sightline, name))), name)

    def check_signature(self, thing, nodes, where):
        """Names, kinds and which have defaults: as inspect tells them, and in the docstring those of each overload."""
        stubbed = [stubbed_arguments(node) for node in nodes]
        if len(nodes) == 1:
            self.assertEqual(told_arguments(thing), stubbed[0], where)
        else:
            self.assertEqual(str(inspect.signature(thing)), "(*args, **kwargs)", where)
        doc = thing.__init__.__doc__ if inspect.isclass(thing) else thing.__doc__
        self.assertEqual(arguments_in_docstring(doc), [[name for name, _, _ in each] for each in stubbed], where)

    def test_signatures(self):
        for function in self.functions:
            self.check_signature(getattr(sightline, function.name), [function], function.name)
        for name, node in self.classes.items():
            methods = {}
            for m in node.body:
                if isinstance(m, ast.FunctionDef) and (m.name == "__init__" or not m.name.startswith("_")):
                    decorators = {ast.unparse(d) for d in m.decorator_list}
                    if not any("property" in d or "setter" in d for d in decorators):
                        methods.setdefault(m.name, []).append(m)
            bound = getattr(sightline, name)
            for method, nodes in methods.items():
                thing = bound if method == "__init__" else getattr(bound, method)
                self.check_signature(thing, nodes, f"{name}.{method}")

    def test_signatures_of_bound_methods(self):
        scene = sightline.Scene()
        self.assertEqual(str(inspect.signature(scene.root.add_node)), "(name='', transform=None)")
        self.assertEqual(str(inspect.signature(scene.item)), "(id)")
        self.assertEqual(str(inspect.signature(scene.commit)), "()")
        self.assertEqual(inspect.signature(sightline.View.perspective).parameters["far"].default, float("inf"))
        self.assertIs(inspect.signature(sightline.Engine.configure).parameters["culler"].default, ...)
        with self.assertRaises(ValueError):
            inspect.signature(sightline.Node)  # nobody makes one so
        self.assertEqual(sightline.Engine.__doc__.split(" ")[0], "Culls")

    def test_what_a_star_imports(self):
        public = {name for name, value in vars(sightline).items() if not name.startswith("_") and
                  not inspect.ismodule(value) and getattr(value, "__module__", "sightline") == "sightline"}
        self.assertEqual(set(sightline.__all__), public - {"annotations", "version"})
        self.assertEqual(len(set(sightline.__all__)), len(sightline.__all__))
        names = {}
        exec("from sightline import *", names)
        self.assertEqual(names.keys() - {"__builtins__"}, set(sightline.__all__))

    def test_docstrings(self):
        for name in self.public(dir(sightline)):
            thing = getattr(sightline, name)
            if getattr(thing, "__module__", None) != "sightline" or name in ("annotations",):
                continue
            self.assertTrue(inspect.getdoc(thing), name)
            for member, value in vars(thing).items() if inspect.isclass(thing) else ():
                if not member.startswith("_"):
                    text = re.sub(r"^.* -> .*\n", "", inspect.getdoc(value) or "", count=1).strip()
                    self.assertTrue(text, f"{name}.{member}")

    def test_mypy(self):
        try:
            import mypy.api
        except ImportError:
            self.skipTest("mypy is not installed (package mypy)")
        program = self.folder / "program.py"
        program.write_text(
            "import numpy as np\nimport sightline\n\n"
            "def main() -> None:\n"
            "    scene = sightline.Scene()\n"
            "    item = scene.root.add(sightline.Cylinder(1, 2), sightline.translation([1, 2, 3]))\n"
            "    with sightline.Engine(scene, draw=True, culler='gpu') as engine:\n"
            "        report = engine.frame(engine.fit())\n"
            "        pixels: int = int(engine.read_ids().sum()) + report.items_drawn + item.id\n"
            "        visible = sightline.BoxCuller(np.zeros((1, 6))).visible(engine.fit())\n"
            "        reveal_type(visible)\n"
            "    scene.root.add('no primitive')\n")
        out, err, _ = mypy.api.run(["--strict", f"--cache-dir={self.folder}", str(program),
                                    str(SOURCE / "examples" / "regression_suite.py")])
        lines = [line for line in out.splitlines() if ": note:" in line or ": error:" in line]
        self.assertEqual(len(lines), 2, out + err)
        self.assertIn("numpy.unsignedinteger", lines[0])
        self.assertIn("program.py:12: error: Argument 1 to \"add\"", lines[1])


if __name__ == "__main__":
    unittest.main()
