"""Engines that draw: pictures as arrays, picks, queries, edits, threads."""

import gc
import threading
import unittest

import numpy as np
import sightline
from support import GlCase, overview, plant

SIZE = dict(width=320, height=200)


class Drawing(GlCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = plant()
        cls.view = overview(cls.scene)

    def engine(self, **config):
        engine = sightline.Engine(self.scene, **{"draw": True, **SIZE, **config})
        self.addCleanup(engine.close)
        return engine

    def test_pictures_are_arrays(self):
        engine = self.engine(ids=True)
        report = engine.frame(self.view)
        self.assertTrue(report.drawn and engine.covered())
        self.assertEqual((report.visible, report.frame, report.culler), (3000, 0, engine.culler))
        self.assertTrue(0 < report.shown <= report.visible)
        colour, ids, depth = engine.read_colour(), engine.read_ids(), engine.read_depth(self.view)
        self.assertEqual((colour.shape, colour.dtype), ((200, 320, 3), np.uint8))
        self.assertEqual((ids.shape, ids.dtype), ((200, 320), np.uint32))
        self.assertEqual((depth.shape, depth.dtype), ((200, 320), np.float32))
        np.testing.assert_array_equal(ids == 0, np.isinf(depth))
        self.assertLessEqual(ids.max(), 3000)
        self.assertFalse(colour.flags.owndata, "the array views what the library made")
        self.assertTrue(colour.flags.writeable)
        before = colour.copy()
        engine.frame(sightline.View.perspective((0, 0, 1000), (0, 0, 2000), fovy=1, aspect=1))
        engine.read_colour()
        engine.close()
        del engine
        gc.collect()
        np.testing.assert_array_equal(colour, before)

    def test_depth_is_where_the_pick_is(self):
        engine = self.engine(ids=True)
        engine.frame(self.view)
        ids, depth = engine.read_ids(), engine.read_depth(self.view)
        for y, x in np.argwhere(ids)[::1500]:
            pick = engine.pick(self.view, x + 0.5, y + 0.5)
            self.assertIsNotNone(pick)
            if pick.item + 1 != ids[y, x]:
                continue  # two surfaces nearer to each other than the depth buffer tells
            eye = self.view.eye_from_world @ np.append(pick.point, 1)
            np.testing.assert_allclose(-eye[2], depth[y, x], rtol=1e-3)
            self.assertIn(pick.item, pick.node.items)
            self.assertAlmostEqual(float(np.linalg.norm(pick.normal)), 1)
        self.assertIsNone(engine.pick(self.view, 0.5, 0.5))

    def test_render_in_one_call(self):
        engine = self.engine()
        engine.frame(engine.fit())
        np.testing.assert_array_equal(sightline.render(self.scene, **SIZE), engine.read_colour())
        engine.frame(self.view)
        np.testing.assert_array_equal(sightline.render(self.scene, self.view, **SIZE), engine.read_colour())

    def test_every_culler_draws_the_same(self):
        engine = self.engine()
        pictures = []
        for culler in ("automatic", "linear", "cpu", "gpu", "hybrid"):
            engine.set_culler(culler)
            engine.frame(self.view)
            pictures.append(engine.read_colour())
            np.testing.assert_array_equal(pictures[-1], pictures[0])
        with self.engine(culler="gpu", gpu_pass="compute") as gpu:
            report = gpu.frame(self.view)
            gpu.finish()
            self.assertEqual((report.visible, gpu.take_late_report().visible, gpu.take_late_report()), (-1, 3000, None))
            np.testing.assert_array_equal(gpu.read_colour(), pictures[0])

    def test_the_gpu_may_cull_without_drawing(self):
        engine = self.engine(draw=False)
        self.assertEqual(engine.renderer, "")
        engine.set_culler("gpu")
        self.assertNotEqual(engine.renderer, "")
        engine.frame(self.view)
        engine.finish()
        self.assertEqual(engine.take_late_report().visible, 3000)
        self.assert_error("draw", engine.read_colour)

    def test_edits_show_after_a_commit(self):
        scene = plant(1000)
        with sightline.Engine(scene, draw=True, **SIZE) as engine:
            view = engine.fit()
            engine.frame(view)
            before = engine.read_colour()
            scene.root.children[0].visible = False
            engine.frame(view)
            np.testing.assert_array_equal(engine.read_colour(), before)
            engine.commit()
            engine.frame(view)
            self.assertFalse(engine.covered())
            self.assertEqual(len(engine.visible_items()), 0)

    def test_sizes(self):
        engine = self.engine()
        engine.resize(64, 32)
        self.assertEqual((engine.width, engine.height), (64, 32))
        engine.frame(self.view)
        self.assertEqual(engine.read_colour().shape, (32, 64, 3))
        self.assert_error("", engine.resize, 10**6, 10)
        self.assertEqual(engine.width, 64)
        self.assert_error("1 or more pixels, found 0 and 10", engine.resize, 0, 10)
        self.assert_error("", self.engine, samples=1000)

    def test_sections_cut_the_picture(self):
        engine = self.engine(ids=True)
        cut = sightline.View.from_matrices(self.view.eye_from_world, self.view.clip_from_eye)
        cut.sections = [[1, 0, 0, 0]]
        engine.frame(cut)
        ids = np.unique(engine.read_ids())
        self.assertTrue(all(self.scene.item(i - 1).bounds[1, 0] >= -1e-6 for i in ids[1:]))
        self.assertLess(len(ids), 3000)

    def test_overrides(self):
        engine = self.engine(ids=True)
        engine.frame(self.view)
        plain, ids = engine.read_colour(), engine.read_ids()
        most = int(np.bincount(ids.ravel())[1:].argmax())
        item, node = self.scene.item(most), self.scene.item(most).node

        def shown():
            engine.frame(self.view)
            return engine.read_colour(), engine.read_ids()

        engine.set_override([item], colour=(1, 0, 1))
        colour, _ = shown()
        self.assertTrue((ids == most + 1)[(colour != plain).any(axis=2)].all())
        red, green, blue = colour[ids == most + 1].mean(axis=0)
        self.assertLess(green, min(red, blue))
        engine.clear_override(np.array([most]))
        np.testing.assert_array_equal(shown()[0], plain)
        engine.hide([most])
        self.assertNotIn(most + 1, shown()[1])
        self.assertNotIn(most, engine.items_in(self.view, (0, 0, 320, 200)))
        engine.show([item])
        engine.isolate([node])
        left = set(np.unique(shown()[1])) - {0}
        self.assertIn(most + 1, left)
        self.assertLessEqual(left, set(node.items + 1))
        engine.show_all()
        engine.set_override(self.scene.items, alpha=0.25)
        engine.clear_overrides()
        np.testing.assert_array_equal(shown()[0], plain)
        self.assert_error("3000", engine.hide, [3000])
        self.assert_error("items: expected", engine.hide, [1.5])
        self.assert_error("items: expected", engine.hide, 7)
        self.assert_error("whole numbers", engine.hide, np.array([1.5]))
        self.assert_error("alpha", engine.set_override, [1], alpha=2)
        self.assert_error("colour", engine.set_override, [1], colour=(1, 0))
        self.assert_error("another scene", engine.isolate, [plant(1000).root])
        np.testing.assert_array_equal(shown()[0], plain)

    def test_other_ways_to_a_context(self):
        expected = sightline.render(self.scene, self.view, **SIZE)
        np.testing.assert_array_equal(sightline.render(self.scene, self.view, context="egl", **SIZE), expected)
        self.assert_error("osmesa", sightline.render, self.scene, self.view, context="x", **SIZE)
        try:
            picture = sightline.render(self.scene, self.view, context="osmesa", **SIZE)
        except sightline.Error as error:
            self.skipTest(str(error))
        np.testing.assert_array_equal(picture, expected)

    def test_any_thread_may_draw_and_free(self):
        expected = sightline.render(self.scene, self.view, **SIZE)
        engine = self.engine()
        pictures = [None] * 4
        def draw(i):
            for _ in range(5):
                engine.frame(self.view)
            pictures[i] = engine.read_colour()
            other = sightline.Engine(self.scene, draw=True, **SIZE)
            other.frame(self.view)
            np.testing.assert_array_equal(other.read_colour(), expected)
            keep.append(other)
        keep = []
        threads = [threading.Thread(target=draw, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for picture in pictures:
            np.testing.assert_array_equal(picture, expected)
        self.assertEqual(len(keep), 4)
        keep.clear()  # made on other threads

    def test_no_complaint_of_the_driver(self):
        engine = self.engine(gl_debug=True, ids=True)
        engine.frame(self.view)
        engine.read_ids()
        engine.set_culler("gpu")
        engine.frame(self.view)
        engine.finish()
        self.assertEqual(engine.take_gl_errors(), [])


class Aside(GlCase):
    def test_what_another_view_culls_is_drawn_from_aside(self):
        scene = plant()
        with sightline.Engine(scene, draw=True, hidden_colour=(1, 0, 1), **SIZE) as engine:
            view = engine.fit()
            engine.frame(view)
            plain = engine.read_colour()
            engine.frame(view, sightline.View.perspective((0, -60, 2), (0, 0, 2), fovy=0.5, aspect=1.6))
            self.assertGreater(sightline.compare(plain, engine.read_colour()).pixels, 0)


if __name__ == "__main__":
    unittest.main()
