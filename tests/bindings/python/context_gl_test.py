"""Engines in an application's context: framebuffers of its own, outlines over them, contexts that go and come."""

import ctypes
import gc
import unittest

import numpy as np
import sightline
from application import Application, Framebuffer
from support import GlCase, overview, plant

SIZE = dict(width=320, height=200)


class Contexts(GlCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = plant()
        cls.view = overview(cls.scene)
        cls.expected = sightline.render(cls.scene, cls.view, **SIZE)

    def setUp(self):
        super().setUp()
        self.application = Application()
        self.addCleanup(self.application.close)

    def engine(self, **config):
        config = {"draw": True, "get_proc": self.application.address, **SIZE, **config}
        engine = sightline.Engine(self.scene, **config)
        self.addCleanup(engine.close)
        return engine

    def framebuffer(self):
        made = Framebuffer(self.application, **SIZE)
        return made, sightline.ExternalTarget(made.name, **SIZE)

    def test_functions_are_found_in_any_way(self):
        egl = self.application.egl
        found = egl.eglGetProcAddress
        found.restype = ctypes.c_int  # as ctypes has it unless told: its address counts, not what it returns in Python
        by_name = {}
        def ask(name):
            by_name[name] = self.application.address(name)
            return by_name[name]
        for get_proc in (ask, found, ctypes.cast(found, ctypes.c_void_p).value, ctypes.cast(found, ctypes.c_void_p),
                         lambda name: ctypes.c_void_p(self.application.address(name))):
            engine = self.engine(get_proc=get_proc)
            engine.frame(self.view)
            np.testing.assert_array_equal(engine.read_colour(), self.expected)
            engine.close()
        self.assertGreater(len(by_name), 100)

    def test_what_finds_no_functions_is_an_error(self):
        self.assert_error("", self.engine, get_proc=lambda name: None)
        self.assert_error("address 0", self.engine, get_proc=0)
        for bad in ("glEnable", 1.5, True):
            with self.assertRaises(TypeError):
                self.engine(get_proc=bad)
        def broken(name):
            raise LookupError(name)
        with self.assertRaises(LookupError):
            self.engine(get_proc=broken)
        with self.assertRaises(ValueError):
            self.engine(get_proc=lambda name: "no address")

    def test_a_framebuffer_gets_the_image(self):
        engine = self.engine()
        mine, target = self.framebuffer()
        report = engine.frame_into(self.view, target)
        self.assertTrue(report.drawn)
        shown, own = mine.read(), engine.read_colour()
        np.testing.assert_array_equal(own, self.expected)
        covered = engine.read_depth(self.view) < np.inf
        np.testing.assert_array_equal(shown[covered], own[covered])
        np.testing.assert_array_equal(shown[~covered], np.broadcast_to([255, 0, 0], shown[~covered].shape))
        target.clear_colour = target.clear_depth = True
        engine.frame_into(self.view, target)
        np.testing.assert_array_equal(mine.read(), own)
        target.width, target.height = 64, 48
        engine.frame_into(self.view, target)
        self.assertEqual((engine.width, engine.height), (64, 48))
        self.assert_error("1 or more pixels", setattr_and_draw, engine, self.view, target)
        with sightline.Engine(self.scene, draw=True) as offscreen:
            self.assert_error("context", offscreen.frame_into, self.view, sightline.ExternalTarget(width=8, height=8))

    def test_several_views_have_an_image_each(self):
        engine = self.engine()
        (mine, target), (other, small) = self.framebuffer(), self.framebuffer()
        small.width, small.height = 64, 48
        target.clear_colour = target.clear_depth = small.clear_colour = small.clear_depth = True
        reports = engine.frame_views([self.view, self.view], [target, small])
        self.assertEqual([report.drawn for report in reports], [True, True])
        np.testing.assert_array_equal(mine.read(), self.expected)
        self.assertFalse((other.read() == [255, 0, 0]).all())
        engine.use_image(1)
        self.assertEqual((engine.width, engine.height), (64, 48))
        self.assert_error("not in use", engine.forget_image, 1)
        engine.use_image(0)
        engine.forget_image(1)
        np.testing.assert_array_equal(engine.read_colour(), self.expected)
        self.assert_error("as many targets", engine.frame_views, [self.view], [])

    def test_outlines_are_drawn_over_it(self):
        engine = self.engine(ids=True)
        mine, target = self.framebuffer()
        target.clear_colour = target.clear_depth = True
        engine.frame_into(self.view, target)
        before = mine.read()
        item = int(np.bincount(engine.read_ids().ravel())[1:].argmax())
        engine.draw_outline(self.view, [item], target)
        outlined = mine.read()
        changed = (outlined != before).any(axis=2)
        self.assertTrue(0 < changed.sum() < 320 * 200 / 4)
        engine.set_override([item], outline=True)
        engine.frame_into(self.view, target)
        self.assertLessEqual(np.abs(mine.read().astype(int) - outlined).max(), 1)
        self.assert_error("no item 3000", engine.draw_outline, self.view, [3000], target)
        target.width = 100
        self.assert_error("", engine.draw_outline, self.view, [item], target)

    def test_contexts_go_and_come(self):
        engine = self.engine()
        def draw():
            self.assertTrue(engine.frame(self.view).drawn)
            np.testing.assert_array_equal(engine.read_colour(), self.expected)
        draw()
        self.assert_error("drop or abandon it first", engine.use_context, self.application.address)
        engine.drop_context()
        self.assertFalse(engine.frame(self.view).drawn)
        self.assertEqual(engine.renderer, "")
        self.assert_error("", engine.read_colour)
        with self.assertRaises(TypeError):
            engine.use_context(None)
        self.assertTrue(engine.use_context(self.application.address))
        draw()
        self.application.destroy_context()
        engine.abandon_context()
        self.assertFalse(engine.frame(self.view).drawn)
        self.application.new_context()
        portions = 1
        while not engine.use_context(self.application.address, 0.0):
            self.assertFalse(engine.frame(self.view).drawn)
            portions += 1
        self.assertGreater(portions, 3)
        draw()
        self.assert_error("seconds", engine.use_context, self.application.address, float("nan"))

    def test_a_context_may_come_later(self):
        self.assert_error("context_later", self.engine, context_later=True)
        engine = self.engine(context_later=True, get_proc=None)
        self.assertFalse(engine.frame(self.view).drawn)
        self.assertTrue(engine.config["context_later"])
        self.assertTrue(engine.use_context(self.application.address))
        self.assertFalse(engine.config["context_later"])
        engine.configure(edge_lines=0.0)
        engine.frame(self.view)
        np.testing.assert_array_equal(engine.read_colour(), self.expected)

    def test_an_engine_may_end_after_its_context(self):
        engine = sightline.Engine(self.scene, draw=True, get_proc=self.application.address, **SIZE)
        engine.frame(self.view)
        self.application.destroy_context()
        del engine
        gc.collect()
        self.application.new_context()
        self.engine().frame(self.view)

    def test_state_is_restored_unless_it_may_be_left(self):
        for gl_state, kept in (("restore", True), ("leave", False)):
            engine = self.engine(gl_state=gl_state)
            mine, _ = self.framebuffer()
            self.application.gl("glBindFramebuffer", ctypes.c_uint(0x8D40), ctypes.c_uint(mine.name))
            engine.frame(self.view)
            bound = ctypes.c_int()
            self.application.gl("glGetIntegerv", ctypes.c_uint(0x8CA6), ctypes.byref(bound))
            self.assertEqual(bound.value == mine.name, kept)
            self.assertEqual(engine.config["gl_state"], gl_state)
        self.assert_error("gl_state: expected restore or leave", self.engine, gl_state="x")

    def test_the_drivers_complaints_are_told(self):
        engine = self.engine(gl_state="leave")
        engine.frame(self.view)
        self.assertEqual(engine.take_gl_errors(), [])
        self.application.gl("glEnable", ctypes.c_uint(0xDEAD))
        self.assertEqual(len(engine.take_gl_errors()), 1)
        self.assertEqual(engine.take_gl_errors(), [])

    def test_the_image_is_in_a_framebuffer(self):
        engine = self.engine()
        engine.frame(self.view)
        made = Framebuffer.__new__(Framebuffer)
        made.gl, made.width, made.height, made.name = self.application.gl, 320, 200, engine.framebuffer()
        np.testing.assert_array_equal(made.read(), self.expected)


def setattr_and_draw(engine, view, target):
    target.width = 0
    engine.frame_into(view, target)


if __name__ == "__main__":
    unittest.main()
