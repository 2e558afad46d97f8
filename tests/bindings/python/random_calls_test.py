"""Random calls with random arguments end in a result or in an exception, never in a crash.

SIGHTLINE_RANDOM_CALLS: how many; 3000 unless set. SIGHTLINE_RANDOM_SEED: the first seed.
"""

import inspect
import math
import os
import random
import unittest

import numpy as np
import sightline
from support import SMALL_PLANT, Case, overview, plant

CALLS = int(os.environ.get("SIGHTLINE_RANDOM_CALLS", 3000))
SEED = int(os.environ.get("SIGHTLINE_RANDOM_SEED", 1))
# Makes more items with each call; takes addresses, which nobody can check.
LEFT_OUT = ("generate_plant", "use_context")
TYPES = [t for t in vars(sightline).values() if inspect.isclass(t) and t.__module__ == "sightline" and
         not issubclass(t, Exception)]


class RandomCalls(Case):
    def setUp(self):
        super().setUp()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, "/")

    def first_things(self):
        scene = plant(1000)
        engine = sightline.Engine(scene, width=64, height=48)
        view = overview(scene)
        mesh = scene.add_mesh([[0, 0, 0], [1, 0, 0], [0, 0, 1]], [[0, 1, 2]])
        things = [scene, sightline.Scene(), scene.root, scene.root.add_node("n"), scene.root.add(mesh), mesh,
                  scene.add_material("m"), engine, view, engine.tour(), sightline.BoxCuller(np.zeros((3, 6))),
                  engine.pick(view, 32, 24), sightline.Cylinder(1, 2), sightline.Snout(*[1] * 9), scene.commit(),
                  engine.frame(view), scene.import_file(SMALL_PLANT), engine.cull_states(view),
                  sightline.image_tiles(64, 48, 80), sightline.ImageTile(64, 48, 0, 0),
                  sightline.ExternalTarget(width=8, height=8), sightline.ControllerConfig(margin=0.5),
                  sightline.OccluderRaster()]
        return [thing for thing in things if thing is not None]

    def value(self, chance, things):
        pick = chance.randrange(8)
        if pick < 3:
            return chance.choice(things)
        if pick == 3:
            return chance.choice([None, True, -1, 0, 1, 7, 2**31, 2**32, 10**20, 0.0, 1.5, -1e300, math.nan, math.inf])
        if pick == 4:
            return chance.choice(["", "x", "cylinder", "gpu", "cpu", "wholly", "classic", "a.rvm", "a.png", "\udcff", b"y"])
        shape = chance.choice([(), (0,), (2,), (3,), (4,), (6,), (4, 4), (3, 3), (0, 6), (5, 6), (2, 4), (9, 4), (3, 4, 4),
                               (12, 13), (12, 13, 3)])
        kind = chance.choice([np.float64, np.float32, np.uint8, np.int64, np.uint32, object, bool, "<U2", complex])
        array = np.full(shape, chance.choice([0, 1, 2, 40]), dtype=kind)
        if array.ndim == 2 and array.shape[0] == array.shape[1] and chance.random() < 0.7:
            array = np.eye(array.shape[0])
        return array if chance.random() < 0.8 else array.tolist()

    def call(self, chance, things):
        """Calls something. Returns what it was, for messages, and its result."""
        if chance.random() < 0.1:
            target = chance.choice([t for t in vars(sightline).values() if callable(t) and t is not sightline.Error and
                                    getattr(t, "__module__", "") == "sightline"])
            name = target.__name__
        else:
            thing = chance.choice(things)
            name = chance.choice(dir(type(thing)))
            if (name.startswith("__") and name not in ("__len__", "__eq__", "__hash__", "__repr__")) or name in LEFT_OUT:
                return name, None
            if chance.random() < 0.2:
                setattr(thing, name, self.value(chance, things))
                return name, None
            target = getattr(thing, name)
            name = f"{type(thing).__name__}.{name}"
        if not callable(target) or name.endswith(LEFT_OUT):
            return name, target
        words = {}
        doc = inspect.getdoc(target) or ""
        if chance.random() < 0.4 and "aspect" in doc:
            words["aspect"] = chance.choice([1.0, 0.0, math.nan])
        return name, target(*[self.value(chance, things) for _ in range(chance.choice([0, 0, 1, 1, 2, 2, 3, 4]))], **words)

    def test_random_calls(self):
        print("seed", SEED)
        chance = random.Random(SEED)
        done = 0
        for i in range(CALLS):
            if i % 500 == 0:
                things = self.first_things()
            try:
                _, result = self.call(chance, things)
                done += 1
            except (sightline.Error, TypeError, ValueError, OverflowError, AttributeError, IndexError, OSError):
                continue
            except MemoryError:
                continue
            if isinstance(result, tuple(TYPES)) and len(things) < 60:
                things.append(result)
        self.assertGreater(done, CALLS // 10)


if __name__ == "__main__":
    unittest.main()
