"""Scenes larger than memory: images are those of an engine that has everything, and pages come and go."""

import gc
import math
import pickle
import unittest

import numpy as np
import sightline
from support import GlCase, plant

SIZE = dict(width=160, height=120)
MANY = 8 << 30


class Paged(GlCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        if ".slc" not in sightline.known_extensions():
            raise unittest.SkipTest("built without scene caches")

    def cache(self, file, **options):
        """A scene cache of a model file."""
        folder = self.folder / f"{file.name} {len(options)}"
        sightline.Scene().import_file(file, cache_folder=folder, **options)
        return next(folder.iterdir())

    def plant_cache(self):
        plant(40_000).write(self.folder / "plant.rvm")
        return self.cache(self.folder / "plant.rvm")

    def engine(self, path, **config):
        engine = sightline.PagedEngine(path, memory_limit=MANY, **{**SIZE, **config})
        self.addCleanup(engine.close)
        return engine

    def view(self, engine, distance=1.0):
        low, high = engine.bounds
        centre = (low + high) / 2
        eye = centre + distance * np.linalg.norm(high - low) * np.array([0.6, 0.5, 0.6])
        return sightline.View.perspective(eye, centre, fovy=0.6, aspect=4 / 3, near=0.1)

    def test_settled_images_are_those_of_an_engine(self):
        path = self.plant_cache()
        scene = sightline.Scene()
        scene.import_file(path)
        whole = sightline.Engine(scene, draw=True, ids=True, culler="cpu", **SIZE)
        self.addCleanup(whole.close)
        paged = self.engine(path, ids=True)
        self.assertEqual((paged.items, paged.width, paged.height), (scene.item_count, 160, 120))
        self.assertGreater(paged.pages, 1)
        self.assertEqual(paged.renderer, whole.renderer)
        for distance in (0.8, 0.1):
            view = self.view(paged, distance)
            shares = []
            report = paged.settle(view, progress=shares.append)
            self.assertTrue(report.complete)
            self.assertEqual((report.pending, report.placeholders, report.failed), (0, 0, 0))
            self.assertEqual(shares, sorted(shares))
            self.assertTrue(all(0 <= share < 1 for share in shares))
            whole.frame(view)
            np.testing.assert_array_equal(paged.read_depth(), whole.read_depth(view))
            other = (paged.read_ids() != whole.read_ids()).sum()
            self.assertLess(other, 20, "where two items have the same surface")
            self.assertLessEqual((paged.read_colour() != whole.read_colour()).any(axis=2).sum(), other)
        self.assertGreater(report.resident, 0)
        self.assertTrue(0 < paged.page_bytes <= paged.page_limit < MANY)
        self.assertEqual((paged.take_errors(), paged.take_gl_errors()), ([], []))

    def test_frames_go_on_with_the_image(self):
        paged = self.engine(self.plant_cache(), refine_ms=0, loading_bar=False)
        view = self.view(paged)
        first = report = paged.frame(view)
        while not report.complete:
            self.assertGreater(report.pending, 0)
            paged.wait(1)
            report = paged.frame(view)
        self.assertEqual(pickle.loads(pickle.dumps(report)), report)
        self.assertFalse(first.complete)
        self.assertGreater(first.placeholders, 0)
        self.assertGreater(report.items_drawn, first.items_drawn)
        self.assertFalse(paged.wait(math.inf), "nothing is on its way")
        self.assertIn("0 of", repr(report))

    def test_levels_save_reading_pages(self):
        if ".obj" not in sightline.known_extensions():
            self.skipTest("built without OBJ")
        plant(3000).write(self.folder / "plant.rvm")
        file = self.folder / "plant.obj"
        self.tool("convert", self.folder / "plant.rvm", file, "--tolerance", 0.001)
        plain, levels = self.cache(file), self.cache(file, cached_levels=True)
        if levels.stat().st_size == plain.stat().st_size:
            self.skipTest("no levels in this build")
        exact, coarse = self.engine(levels), self.engine(levels, lod_error=1.0)
        view = self.view(exact, 20.0)
        report = coarse.settle(view)
        self.assertTrue(report.complete)
        self.assertGreater(report.coarse_loaded, 0)
        self.assertLess(report.loaded, exact.settle(view).loaded)

    def test_false_and_exceptions_stop(self):
        path = self.plant_cache()
        self.assert_error("cancelled", self.engine, path, progress=lambda share: False)
        def stop(share):
            raise KeyError("stop")
        paged = self.engine(path, refine_ms=0)  # new ones have no pages yet, so that the first image is not complete
        view = self.view(paged)
        self.assertFalse(paged.settle(view, progress=lambda share: False).complete)
        self.assertTrue(paged.settle(view).complete)
        with self.assertRaises(KeyError):
            self.engine(path, refine_ms=0).settle(view, progress=stop)
        paged = self.engine(path, refine_ms=0)
        self.assert_error("in use by the call that called back", paged.settle, view,
                          progress=lambda share: paged.frame(view))
        self.assertTrue(paged.settle(view).complete)

    def test_what_is_refused(self):
        path = self.plant_cache()
        for text, config in {"memory limit of 1 MiB": dict(memory_limit=1), "lod_error": dict(lod_error=-1.0),
                             "width must be": dict(width=0), "refine_ms": dict(refine_ms=math.nan),
                             "osmesa": dict(context_platform="window")}.items():
            with self.assertRaises(sightline.Error) as caught:
                sightline.PagedEngine(path, **{"memory_limit": MANY, **SIZE, **config})
            self.assertIn(text, str(caught.exception))
        self.assert_error("none.slc", self.engine, self.folder / "none.slc")
        with self.assertRaises(TypeError):
            sightline.PagedEngine(path)
        with self.engine(path) as paged:
            self.assert_error("before the first frame", paged.read_colour)
            paged.frame(self.view(paged))
            self.assert_error("ids", paged.read_ids)
            self.assert_error("seconds", paged.wait, math.nan)
            colour = paged.read_colour()
            before = colour.copy()
        self.assertTrue(paged.closed)
        paged.close()
        for call in (paged.read_colour, paged.take_errors, lambda: paged.items, lambda: paged.wait(0)):
            self.assert_error("closed", call)
        del paged
        gc.collect()
        np.testing.assert_array_equal(colour, before)


if __name__ == "__main__":
    unittest.main()
