"""Every function of the module, and every method and property of every class, called with wrong types, shapes, sizes and
numbers and with each protocol of pickles: it works or raises. Some classes at a time are called in a process of their own,
since what this looks for ends it.

    python hostile_calls_test.py CLASS …   calls classes, or "functions", and prints each name first
"""

import contextlib
import copy
import faulthandler
import inspect
import math
import os
import pickle
import random
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import sightline
from support import SMALL_PLANT, box_rows, overview, plant

SEED = 60
PROCESSES = 6  # that the classes are shared by
# Makes as many items, or frames, as it is told; takes addresses, which nobody can check.
LEFT_OUT = {"generate_plant", "replay", "use_context", "__class__"}
CLASSES = {name: thing for name, thing in vars(sightline).items()
           if inspect.isclass(thing) and thing.__module__ == "sightline" and not issubclass(thing, BaseException)}
FUNCTIONS = {name: thing for name, thing in vars(sightline).items()
             if not name.startswith("_") and inspect.isroutine(thing) and name not in LEFT_OUT}


def hostile_values():
    nan = np.full((4, 4), math.nan)
    return [None, True, -1, 0, 1, 3, 2**31, 2**32 - 1, 2**62, 10**30, 0.5, math.nan, math.inf, 1e300, "", "x", "\udcff", "a\0b",
            b"x", object(), [], {}, (), [[1], [2, 3]], nan, nan[0], nan[:3], np.eye(4), np.eye(4)[::-1, ::-1],
            np.zeros((0, 6)), np.zeros((0, 3)), np.zeros((5, 6)), np.zeros((5, 3)), np.full((5, 3), 2**31),
            np.full((5, 3), 4, np.uint32), np.zeros((3, 3), complex), np.zeros((3, 3), object), np.zeros((4, 4), ">f8"),
            np.zeros((2, 2, 2, 2)), np.zeros((12, 13, 3), np.uint8), np.zeros((12, 13), np.float32), np.zeros(()),
            np.full(7, 1e300), np.array(["a"]), lambda *_: None]


def things():
    """An object of each class that can be had without a context, by its name."""
    scene = plant(1000)
    engine = sightline.Engine(scene, width=64, height=48)
    view = overview(scene)
    node = scene.root.add_node("n")
    mesh = scene.add_mesh([[0, 0, 0], [1, 0, 0], [0, 0, 1]], [[0, 1, 2]])
    item = node.add(mesh)
    report = scene.import_file(SMALL_PLANT, recognise=True)
    tiles = sightline.image_tiles(64, 48, 80)
    made = [scene, engine, view, node, mesh, item, scene.add_material("m"), report, report.recognition, scene.commit(), engine.tour(),
            sightline.BoxCuller(box_rows(20)), sightline.OccluderRaster(), engine.frame(view), engine.memory, engine.loss(view),
            engine.cull_states(view), tiles, tiles.tiles[0], sightline.ImageTile(64, 48, 0, 0), engine.plan[0],
            sightline.ExternalTarget(width=8, height=8), sightline.ControllerConfig(), sightline.Box(1, 2, 3),
            sightline.Cylinder(1, 2), sightline.CircularTorus(2, 1, 1), sightline.RectangularTorus(1, 2, 1, 1),
            sightline.Snout(*[1] * 9), sightline.Pyramid(*[1] * 7), sightline.Sphere(1), sightline.Line(0, 1),
            sightline.EllipticalDish(1, 1), sightline.SphericalDish(1, 1)]
    image = np.zeros((12, 13, 3), np.uint8)
    made += [sightline.compare(image, image), sightline.metrics(image, image)]
    return {type(thing).__name__: thing for thing in made}


def attempt(call, *args, **words):
    # What a call warns of is not looked for here, nor is memory that it asks for.
    with contextlib.suppress(Exception):
        return call(*args, **words)
    return None


def keywords_of(call, chance, values):
    """For arguments that have no place."""
    try:
        parameters = inspect.signature(call).parameters.values()
    except (TypeError, ValueError):
        return {}
    return {p.name: chance.choice(values) for p in parameters
            if p.kind is p.KEYWORD_ONLY and (p.default is p.empty or chance.random() < 0.3)}


def attack(call, values, chance, several=0):
    """With one argument of each kind, and so many times with several."""
    attempt(call)
    for value in values:
        attempt(call, value, **keywords_of(call, chance, values))
    for _ in range(several):
        some = [chance.choice(values) for _ in range(chance.choice([2, 2, 2, 3, 3, 4, 5, 6, 9]))]
        attempt(call, *some, **keywords_of(call, chance, values))


def copies(thing):
    attempt(copy.copy, thing)
    attempt(copy.deepcopy, thing)
    for protocol in range(-2, pickle.HIGHEST_PROTOCOL + 2):
        attempt(thing.__reduce_ex__, protocol)
        attempt(object.__reduce_ex__, thing, protocol)
        again = attempt(lambda: pickle.loads(pickle.dumps(thing, protocol)))
        if again is not None:
            attempt(repr, again)


def attack_members(cls, make, values, chance, several=0):
    for name in dir(cls):
        descriptor = inspect.getattr_static(cls, name)
        if name in LEFT_OUT or descriptor is inspect.getattr_static(object, name, None):
            continue
        print(f"{cls.__name__}.{name}", flush=True)
        for call in getattr(cls, name), getattr(descriptor, "fget", None), getattr(descriptor, "fset", None):
            if callable(call):
                attack(call, values, chance)
        thing = make()
        if thing is None:
            continue
        member = attempt(getattr, thing, name)
        if callable(member):
            attack(member, values, chance, several)
        for value in values if not name.startswith("__") else ():
            attempt(setattr, thing, name, value)
        attempt(repr, thing)


def attack_class(name):
    chance = random.Random(SEED)
    cls = CLASSES[name]
    values = hostile_values() + list(things().values())
    thing = things().get(name)
    value = attempt(copy.copy, thing) is not None
    make = lambda: copy.copy(thing) if value else things().get(name)  # values are made several times as fast
    if thing is not None:
        copies(thing)
    for base in cls.__mro__[1:-1]:  # what all instances are, in the eyes of Python's own functions
        attempt(base)
        attempt(base, thing)
        attempt(base.__new__, base)
    attack(cls, values, chance, 80)
    attack_members(cls, make, values, chance, 60)
    empty = attempt(cls.__new__, cls)
    if empty is not None:
        copies(empty)
        attack_members(cls, lambda: cls.__new__(cls), values, chance)
        for function in FUNCTIONS.values():
            attempt(function, empty)


def attack_functions():
    chance = random.Random(SEED)
    values = hostile_values() + list(things().values())
    for name, function in FUNCTIONS.items():
        print(name, flush=True)
        attack(function, values, chance, 80)


class HostileCalls(unittest.TestCase):
    def check(self, *names):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, os.path.abspath(__file__), *names], cwd=folder, capture_output=True, text=True,
                                  errors="replace", timeout=500)
        last = done.stdout.strip().splitlines()[-1:]
        self.assertEqual(done.returncode, 0, f"{names}, seed {SEED}, within {last}: {done.stderr[-3000:]}")
        self.assertTrue(last, "nothing was called")

    def test_functions(self):
        self.check("functions")


    def test_classes(self):
        names = sorted(CLASSES)
        for first in range(PROCESSES):
            with self.subTest(first=first):
                self.check(*names[first::PROCESSES])


if __name__ == "__main__":
    if len(sys.argv) < 2:
        unittest.main()
    faulthandler.enable()
    for argument in sys.argv[1:]:
        attack_functions() if argument == "functions" else attack_class(argument)
    print("done", flush=True)
