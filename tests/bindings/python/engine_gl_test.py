"""Engines that draw: images as arrays, picks, queries, edits, threads."""

import copy
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

    def test_images_are_arrays(self):
        engine = self.engine(ids=True)
        report = engine.frame(self.view)
        self.assertTrue(report.drawn and engine.covered())
        self.assertEqual((report.visible, report.frame, report.culler), (3000, 0, engine.culler))
        self.assertTrue(0 < report.items_drawn <= report.visible)
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

    def test_depth_hides_boxes(self):
        engine = self.engine(ids=True)
        engine.frame(self.view)
        shown = set(np.unique(engine.read_ids())) - {0}
        culler = sightline.BoxCuller(np.array([self.scene.item(i).bounds.reshape(6) for i in self.scene.items]))
        unoccluded_boxes = culler.visible(self.view, engine.read_depth(self.view))
        self.assertLess(len(unoccluded_boxes), len(culler.visible(self.view)))
        self.assertLessEqual({i - 1 for i in shown}, set(unoccluded_boxes), "what is visible in the id image is not hidden")

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
        images = []
        for culler in ("auto", "linear", "cpu", "gpu", "hybrid"):
            engine.set_culler(culler)
            engine.frame(self.view)
            images.append(engine.read_colour())
            np.testing.assert_array_equal(images[-1], images[0])
        with self.engine(culler="gpu", gpu_variant="compute") as gpu:
            report = gpu.frame(self.view)
            gpu.finish()
            self.assertEqual((report.visible, gpu.take_late_report().visible, gpu.take_late_report()), (-1, 3000, None))
            np.testing.assert_array_equal(gpu.read_colour(), images[0])

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

    def test_sections_cut_the_image(self):
        engine = self.engine(ids=True)
        cut = sightline.View.from_matrices(self.view.eye_from_world, self.view.clip_from_eye)
        cut.sections = [[1, 0, 0, 0]]
        engine.frame(cut)
        ids = np.unique(engine.read_ids())
        self.assertTrue(all(self.scene.item(i - 1).bounds[1, 0] >= -1e-6 for i in ids[1:]))
        self.assertLess(len(ids), 3000)

    def test_settings_change_the_image(self):
        cut = copy.copy(self.view)
        cut.sections = [[1, -0.2, 0, 0]]
        faded = self.scene.items[::3]
        def image(engine):
            engine.set_override(faded, alpha=0.5, outline=True)
            engine.frame(cut)
            return engine.read_colour()
        living = self.engine()
        plain = image(living)
        for config in (dict(depth_shading=0.8), dict(edge_lines=0.6), dict(outline_colour=(0, 1, 0)),
                       dict(lighting="studio"), dict(lighting="sun", sun=(1, 0, 0.5)), dict(background_top=(0.5, 0.6, 1))):
            with self.subTest(**config):
                with self.engine(**config) as engine:
                    expected = image(engine)
                self.assertGreater(sightline.compare(plain, expected).pixels, 100)
                living.configure(**config)
                np.testing.assert_array_equal(image(living), expected)
                before = self.engine().config
                living.configure(**{name: before[name] for name in config})
                np.testing.assert_array_equal(image(living), plain)
        with self.engine(transparency="blended") as engine:
            self.assertGreater(sightline.compare(plain, image(engine)).pixels, 100)

    def test_hatching_lies_on_cuts_alone(self):
        scene = sightline.Scene()
        scene.root.add(sightline.Box(4, 4, 4))
        whole = sightline.View.perspective((-6, -9, 5), (0, 0, 0), fovy=0.7, aspect=1.6)
        cut = copy.copy(whole)
        cut.sections = [[0, 1, 0, 0.5]]  # keeps y > -0.5
        def image(view, **config):
            with sightline.Engine(scene, draw=True, **SIZE, **config) as engine:
                engine.frame(view)
                y, x = np.mgrid[:200, :320]
                picks = [engine.pick(view, i + 0.5, j + 0.5) for i, j in zip(x[::8, ::8].ravel(), y[::8, ::8].ravel())]
                faces = np.array([pick.face if pick else "" for pick in picks]).reshape(25, 40)
                return engine.read_colour(), faces
        plain, faces = image(cut)
        hatched, _ = image(cut, hatching=0.9, hatching_spacing=4)
        changed = (hatched != plain).any(axis=2)
        self.assertGreater(changed.sum(), 1000)
        self.assertTrue(changed[::8, ::8].any())
        self.assertEqual(set(faces[changed[::8, ::8]]), {"cut"})
        self.assertIn("cut", faces[~changed[::8, ::8]], "lines, and what lies between them")
        np.testing.assert_array_equal(image(cut, hatching_spacing=4)[0], plain)
        np.testing.assert_array_equal(image(whole, hatching=0.9)[0], image(whole)[0])

    def test_edges_are_lines(self):
        scene = sightline.Scene()
        scene.root.add(sightline.Box(4, 4, 4))
        view = sightline.View.perspective((-6, -9, 5), (0, 0, 0), fovy=0.7, aspect=1.6)
        def image(**config):
            with sightline.Engine(scene, draw=True, **SIZE, **config) as engine:
                engine.frame(view)
                return engine.read_colour()
        plain, lined = image(), image(edges="feature", edge_width=3, edge_colour=(1, 0, 1))
        magenta = (lined == (255, 0, 255)).all(axis=2)
        self.assertGreater(magenta.sum(), 500)
        self.assertLess((lined != plain).any(axis=2).sum(), 4 * magenta.sum())
        np.testing.assert_array_equal(image(edge_width=3), plain)

    def test_tiles_are_the_whole_image(self):
        engine = self.engine(ids=True)
        engine.frame(self.view)
        colour, ids = engine.read_colour(), engine.read_ids()
        tiles = sightline.image_tiles(320, 200, 128)
        self.assertGreater(len(tiles.tiles), 4)
        engine.resize(tiles.width, tiles.height)
        joined, joined_ids = np.zeros_like(colour), np.zeros_like(ids)
        for tile in tiles.tiles:
            self.assertTrue(engine.frame_tile(self.view, tile.tile).drawn)
            rows, columns = slice(tile.y0, tile.y1), slice(tile.x0, tile.x1)
            y, x = tile.y0 - int(tile.tile.y), tile.x0 - int(tile.tile.x)
            of_part = slice(y, y + tile.y1 - tile.y0), slice(x, x + tile.x1 - tile.x0)
            joined[rows, columns] = engine.read_colour()[of_part]
            joined_ids[rows, columns] = engine.read_ids()[of_part]
        # But for rounding at edges.
        self.assertLess((joined_ids != ids).mean(), 0.01)
        self.assertLess((np.abs(joined.astype(int) - colour).max(axis=2) > 2).mean(), 0.02)

    def test_loss_is_what_is_left_out(self):
        engine = self.engine(min_projected_area=20)
        report = engine.frame(self.view)
        loss = engine.loss(self.view)
        self.assertTrue(0 < loss.items <= report.below_min_area)
        self.assertGreater(loss.pixels, 0)
        self.assertEqual((loss.lod_error, loss.triangles, loss.coarser_share), (0.0, report.triangles, 0.0))
        engine.configure(min_projected_area=0)
        engine.frame(self.view)
        self.assertEqual(engine.loss(self.view), sightline.Engine(self.scene).loss(self.view))
        self.assertEqual(engine.loss(self.view).items, 0)

    def test_states_know_what_is_hidden(self):
        engine = self.engine(occlusion="on")
        states = engine.cull_states(self.view)
        self.assertGreater(states.items["occluded"], 0)
        self.assertGreater(states.items["too_small"] + states.items["inside"], 0)
        self.assertEqual(sum(states.items.values()), 3000)

    def test_hybrids_are_told(self):
        scene = plant(12_000)  # a hybrid is made from ten thousand items on
        view = overview(scene)
        with sightline.Engine(scene, draw=True, culler="hybrid", **SIZE) as engine:
            states = [engine.frame(view).state for _ in range(8)]
            told = engine.controller
            self.assertEqual((states[0], told.state, told.frames), ("cpu", states[-1], 8))
            self.assertEqual(states.count("probe"), told.probes)
            self.assertGreater(told.probes, 0)
            engine.configure(controller=sightline.ControllerConfig(margin=0.5))
            self.assertEqual((engine.frame(view).state, engine.controller.frames), ("cpu", 1))

    def test_creation_with_a_context_may_be_cancelled(self):
        self.assert_error("cancelled", self.engine, progress=lambda share: False)
        def interrupt(share):
            raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            self.engine(progress=interrupt)
        self.assertTrue(self.engine().frame(self.view).drawn)

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
        np.testing.assert_array_equal(engine.hidden_items(), np.setdiff1d(self.scene.items, node.items))
        self.assertTrue(engine.is_hidden(int(engine.hidden_items()[0])))
        self.assertFalse(engine.is_hidden(item))
        np.testing.assert_array_equal(engine.items_below([node]), np.sort(node.items))
        np.testing.assert_array_equal(engine.items_below([self.scene.root]), self.scene.items)
        left = set(np.unique(shown()[1])) - {0}
        self.assertIn(most + 1, left)
        self.assertLessEqual(left, set(node.items + 1))
        engine.show_all()
        engine.set_override(self.scene.items, alpha=0.25)
        np.testing.assert_array_equal(engine.overridden_items(), self.scene.items)
        self.assertEqual(engine.override_of(item), {"colour": None, "alpha": 0.25, "outline": False, "ghost": False})
        engine.set_override([item], colour=(1, 0, 0.5), ghost=True)
        style = engine.override_of(item)
        engine.clear_overrides()
        self.assertIsNone(engine.override_of(item))
        engine.set_override([item], **style)
        self.assertEqual(engine.override_of(item), style)
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
        np.testing.assert_array_equal(sightline.render(self.scene, self.view, context_platform="egl", **SIZE), expected)
        self.assert_error("osmesa", sightline.render, self.scene, self.view, context_platform="x", **SIZE)
        try:
            image = sightline.render(self.scene, self.view, context_platform="osmesa", **SIZE)
        except sightline.Error as error:
            self.skipTest(str(error))
        np.testing.assert_array_equal(image, expected)

    def test_any_thread_may_draw_and_free(self):
        expected = sightline.render(self.scene, self.view, **SIZE)
        engine = self.engine()
        images = [None] * 4
        def draw(i):
            for _ in range(5):
                engine.frame(self.view)
            images[i] = engine.read_colour()
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
        for image in images:
            np.testing.assert_array_equal(image, expected)
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
        with sightline.Engine(scene, draw=True, culled_colour=(1, 0, 1), **SIZE) as engine:
            view = engine.fit()
            engine.frame(view)
            plain = engine.read_colour()
            engine.frame(view, sightline.View.perspective((0, -60, 2), (0, 0, 2), fovy=0.5, aspect=1.6))
            self.assertGreater(sightline.compare(plain, engine.read_colour()).pixels, 0)


if __name__ == "__main__":
    unittest.main()
