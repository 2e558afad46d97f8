"""Engines without drawing: configuration, culling, queries, picks, plans."""

import unittest

import numpy as np
import sightline
from support import Case, overview, plant


class Engines(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = plant()
        cls.engine = sightline.Engine(cls.scene, width=400, height=250)
        cls.view = overview(cls.scene)
        cls.near = sightline.View.perspective((0, -30, 3), (0, 0, 3), fovy=0.6, aspect=1.6)

    def test_what_is_visible_is_what_boxes_say(self):
        report = self.engine.frame(self.near)
        ids = self.engine.visible_items()
        self.assertEqual((report.visible, report.drawn, report.shown), (len(ids), False, -1))
        self.assertTrue(0 < len(ids) < 3000)
        rows = np.array([self.scene.item(i).bounds.reshape(6) for i in self.scene.items])
        by_box = sightline.BoxCuller(rows).visible(self.near)
        np.testing.assert_array_equal(ids, np.sort(by_box))

    def test_queries_agree(self):
        everything = self.engine.items_in(self.view, (0, 0, 400, 250))
        np.testing.assert_array_equal(everything, self.scene.items)
        rectangle = (150, 90, 250, 160)
        crossing = self.engine.items_in(self.view, rectangle)
        wholly = self.engine.items_in(self.view, rectangle, "wholly")
        shown = self.engine.visible_items_in(self.view, rectangle, samples=4)
        self.assertTrue(set(wholly) < set(crossing) < set(everything))
        self.assertTrue(0 < len(shown) and set(shown["item"]) <= set(crossing))
        self.assertTrue((shown["samples"] >= 1).all() and shown["samples"].sum() <= 4 * 100 * 70)
        planes = self.engine.items_in_planes([[1, 0, 0, 0]], "wholly")
        by_bounds = [i for i in self.scene.items if self.scene.item(i).bounds[0, 0] >= 1e-6]
        self.assertLessEqual(len(set(planes) ^ set(by_bounds)), 3)

    def test_picks_and_rays(self):
        hit = None
        for x in range(5, 400, 10):
            hit = hit or self.engine.pick(self.view, x, 125)
        ray = self.engine.pick_ray(hit.point + hit.normal, -hit.normal)
        self.assertLessEqual(ray.t, 1 + 1e-9)
        self.assertIsInstance(ray.face, str)
        self.assertIsNone(self.engine.pick_ray((0, 0, 1e4), (0, 0, 1)))
        self.assertIsNone(self.engine.pick_ray(hit.point + hit.normal, -hit.normal, layers=4))

    def test_a_pick_is_of_the_last_commit(self):
        scene = sightline.Scene()
        item = scene.root.add_node("n").add(sightline.Sphere(2))
        engine = sightline.Engine(scene)
        view = sightline.View.perspective((0, -9, 0), (0, 0, 0), fovy=1, aspect=1280 / 720)
        pick = engine.pick(view, 640, 360)
        self.assertEqual((pick.item, pick.node.name, pick.triangle, pick.face), (item.id, "n", None, "side"))
        np.testing.assert_allclose(pick.point, [0, -1, 0], atol=1e-9)
        np.testing.assert_allclose(pick.normal, [0, -1, 0], atol=1e-9)
        self.assertAlmostEqual(pick.t, 8)
        item.remove()
        self.assertEqual(engine.pick(view, 640, 360).node.name, "n")
        engine.commit()
        self.assertIsNone(engine.pick(view, 640, 360))

    def test_the_configuration_is_checked(self):
        for text, config in (("culler: expected automatic, linear, cpu, gpu or hybrid, found \"x\"", dict(culler="x")),
                             ("occlusion: expected off, on or auto", dict(occlusion="x")),
                             ("contribution_way", dict(contribution_way="x")), ("gpu_pass", dict(gpu_pass="x")),
                             ("policy", dict(policy="x")), ("contribution must be", dict(contribution=-1)),
                             ("budget_ms must be", dict(budget_ms=float("nan"))),
                             ("1 or more pixels", dict(width=0)), ("1 or more pixels", dict(draw=True, height=-5)),
                             ("hidden_colour", dict(hidden_colour=(1, 2)))):
            self.assert_error(text, sightline.Engine, self.scene, **config)
        with self.assertRaises(TypeError):
            sightline.Engine(self.scene, colour="red")
        with self.assertRaises(TypeError):
            sightline.Engine(None)

    def test_arguments_are_checked(self):
        engine = self.engine
        self.assert_error("rectangle: expected numbers of shape (4,)", engine.items_in, self.view, (0, 0, 1))
        self.assert_error("", engine.items_in, self.view, (0, 0, 1, np.nan))
        self.assert_error("rule: expected crossing or wholly", engine.items_in, self.view, (0, 0, 1, 1), "x")
        self.assert_error("at most 8 planes", engine.items_in_planes, np.ones((9, 4)))
        self.assert_error("", engine.pick, self.view, np.nan, 0)
        self.assert_error("", engine.pick_ray, (0, 0, 0), (0, 0, 0))
        self.assert_error("samples", engine.visible_items_in, self.view, (0, 0, 9, 9), samples=0)
        self.assert_error("duration", engine.tour, 0)
        self.assert_error("", engine.fit, (0, 0, 0))
        self.assert_error("draw", engine.read_colour)

    def test_a_bad_scene_makes_no_engine(self):
        scene = sightline.Scene()
        scene.root.add_node("bad").add(sightline.Sphere(float("inf")))
        self.assert_error("bad", sightline.Engine, scene)

    def test_reports(self):
        self.assertEqual(self.engine.culler, "cpu")
        self.assertIn(True, [entry.used for entry in self.engine.plan])
        memory = self.engine.memory
        self.assertGreater(min(memory.scene, memory.snapshot, memory.bvh), 0)
        self.assertEqual(memory.gpu, 0)
        self.engine.rebuild()
        self.assertFalse(self.engine.rebuilding)

    def test_replay_reports_every_frame(self):
        flown = []
        path = self.engine.tour(20)
        reports = sightline.replay(self.engine, path, 12, after_frame=lambda i, view: flown.append((i, view)))
        self.assertEqual([i for i, _ in flown], list(range(12)))
        self.assertEqual(flown[-1][1], path.view(20, aspect=1.6))
        for report, (_, view) in zip(reports, flown):
            self.assertEqual(self.engine.frame(view).visible, report.visible)


if __name__ == "__main__":
    unittest.main()
