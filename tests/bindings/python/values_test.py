"""Views, primitives and reports are values: compared, copied and pickled."""

import copy
import pickle
import unittest

import numpy as np
import sightline
from sightline import View
from support import SMALL_PLANT, Case, overview, plant

PRIMITIVES = [
    sightline.Pyramid(1, 2, 3, 4, 5, 6, 7),
    sightline.Box(1, 2, 3),
    sightline.RectangularTorus(1, 2, 3, 0.5),
    sightline.CircularTorus(2, 0.5, 1),
    sightline.EllipticalDish(1, 0.5),
    sightline.SphericalDish(1, 0.25),
    sightline.Snout(1, 2, 3, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
    sightline.Cylinder(0.1, 2),
    sightline.Sphere(3),
    sightline.Line(-1, 1),
]


def some_view():
    view = View.perspective((10, -20, 5), (0, 0, 1), fovy=0.7, aspect=1.3, near=0.3, far=90)
    view.sections = [[0, 0, 1, -2], [1, 0.1, 0, 0.3]]
    view.section_mode = "union"
    view.layers = 5
    return view


class Values(Case):
    def assert_value(self, value):
        """Its copies are equal to it, and not it."""
        copies = [copy.copy(value), copy.deepcopy(value)]
        copies += [pickle.loads(pickle.dumps(value, protocol)) for protocol in range(pickle.HIGHEST_PROTOCOL + 1)]
        for other in copies:
            self.assertIs(type(other), type(value))
            self.assertEqual(other, value)
            self.assertIsNot(other, value)
        self.assertNotEqual(value, 7)
        return copies[-1]

    def attributes(self, value):
        """All of them by name."""
        found = {}
        for name in dir(type(value)):
            if not name.startswith("_") and not callable(getattr(type(value), name)):
                attribute = getattr(value, name)
                found[name] = attribute.tolist() if isinstance(attribute, np.ndarray) else attribute
        return found

    def assert_report(self, report, **known):
        again = self.assert_value(report)
        self.assertEqual(self.attributes(again), self.attributes(report))
        for name, value in known.items():
            self.assertEqual(getattr(report, name), value, name)

    def test_views(self):
        view = some_view()
        twin = self.assert_value(view)
        np.testing.assert_array_equal(twin.eye_from_world, view.eye_from_world)
        np.testing.assert_array_equal(twin.sections, view.sections)
        self.assertEqual((twin.section_mode, twin.layers), ("union", 5))
        for change in ("layers", "section_mode", "sections"):
            other = copy.deepcopy(view)
            setattr(other, change, {"layers": 4, "section_mode": "intersection", "sections": [[0, 0, 1, -3]]}[change])
            self.assertNotEqual(pickle.loads(pickle.dumps(other)), view)
        matrix = np.eye(4)
        matrix[2, 2] = 0.25
        classic = View.from_matrices(np.eye(4), matrix, depth="classic")
        self.assertNotEqual(self.assert_value(classic), View.from_matrices(np.eye(4), matrix))

    def test_paths(self):
        path = sightline.CameraPath([0, 1 / 3, 5], np.eye(3), [[0, 9, 0]] * 3, fovys=[1, 1.1, 0.9], near=0.25)
        again = self.assert_value(path)
        self.assertEqual(again.view(1.234, aspect=1.5), path.view(1.234, aspect=1.5))
        again.near = 0.5
        self.assertNotEqual(again, path)
        self.assertNotEqual(sightline.CameraPath([0, 1 / 3, 5], np.eye(3), [[0, 9, 0]] * 3), path)

    def test_primitives(self):
        self.assertEqual([p.kind for p in PRIMITIVES], list(sightline.KINDS[:len(PRIMITIVES)]))
        for primitive in PRIMITIVES:
            again = self.assert_value(primitive)
            np.testing.assert_array_equal(again.parameters, primitive.parameters)
            for other in PRIMITIVES:
                self.assertEqual(other == primitive, other is primitive)

    def test_reports(self):
        scene = plant(1000)
        engine = sightline.Engine(scene, width=64, height=48)
        view = overview(scene, aspect=64 / 48)
        report = engine.frame(view)
        self.assert_report(report, frame=0, culler="cpu", visible=1000, state=None)
        self.assertNotEqual(engine.frame(view), report)
        self.assert_report(engine.memory)
        self.assert_report(engine.loss(view), items=0, pixels=0)
        for entry in engine.plan:
            self.assert_report(entry)
        states = engine.cull_states(view)
        self.assert_report(states)
        self.assertNotEqual(engine.cull_states(some_view()), states)
        node = scene.root.add_node("n")
        node.add(sightline.Sphere(1))
        delta = scene.commit()
        self.assert_report(delta)
        self.assertEqual(delta.inserted.tolist(), [1000])
        imported = scene.import_file(SMALL_PLANT, recognise=True)
        self.assert_report(imported.recognition)
        with self.assertRaises(TypeError):
            pickle.dumps(imported)  # its nodes belong to a scene

    def test_what_engines_are_told(self):
        target = sightline.ExternalTarget(3, x=1, y=2, width=30, height=40, near_depth=1.0, far_depth=0.0,
                                          clear_colour=True, linear_colour=True)
        self.assert_report(target, framebuffer=3, x=1, y=2, width=30, height=40, near_depth=1.0, far_depth=0.0,
                           clear_colour=True, clear_depth=False, linear_colour=True)
        part = sightline.ImageTile(300, 200, 10.5, 20)
        self.assert_report(part, width=300, height=200, x=10.5, y=20)
        tiles = sightline.image_tiles(400, 300, 128)
        self.assert_report(tiles)
        self.assert_report(tiles.tiles[3])
        self.assertNotEqual(tiles, sightline.image_tiles(400, 300, 96))
        controller = sightline.ControllerConfig(margin=0.5, dwell_frames=7)
        self.assert_report(controller, margin=0.5, dwell_frames=7)
        self.assertNotEqual(controller, sightline.ControllerConfig())

    def test_differences_of_images(self):
        random = np.random.default_rng(1)
        a, b = random.integers(0, 255, (2, 16, 20, 3)).astype(np.uint8)
        self.assert_report(sightline.compare(a, b))
        self.assert_report(sightline.metrics(a, b))

    def test_warnings(self):
        (self.folder / "broken.stl").write_text("solid x\nfacet normal 0 0 1\n")
        report = sightline.Scene().import_file(self.folder / "broken.stl", lenient=True)
        self.assertGreater(len(report.warnings), 0)
        for warning in report.warnings:
            self.assert_report(warning)

    def test_broken_pickles_are_errors(self):
        for value in (some_view(), sightline.Sphere(1), sightline.image_tiles(100, 100, 96),
                      sightline.ControllerConfig(), sightline.Engine(plant(1000)).memory):
            for state in ((), (1,) * 50, ("x",) * len(value.__getstate__())):
                with self.assertRaises((sightline.Error, RuntimeError, TypeError)):
                    type(value).__new__(type(value)).__setstate__(state)
        state = list(sightline.Engine(plant(1000)).frame(some_view()).__getstate__())
        state[1] = 5  # the culler
        self.assert_error("no such value: 5", sightline.FrameReport.__new__(sightline.FrameReport).__setstate__,
                          tuple(state))

    def test_values_may_not_be_hashed(self):
        for value in (some_view(), sightline.Sphere(1), sightline.image_tiles(100, 100, 96)):
            with self.assertRaises(TypeError):
                hash(value)


if __name__ == "__main__":
    unittest.main()
