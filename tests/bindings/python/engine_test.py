"""Engines without drawing: configuration, culling, queries, picks, plans."""

import inspect
import os
import signal
import threading
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
        self.assertEqual((report.visible, report.drawn, report.items_drawn), (len(ids), False, -1))
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
        for text, config in (("culler: expected auto, linear, cpu, gpu or hybrid, found \"x\"", dict(culler="x")),
                             ("occlusion: expected off, on or auto", dict(occlusion="x")),
                             ("contribution_mode", dict(contribution_mode="x")), ("gpu_variant", dict(gpu_variant="x")),
                             ("min_projected_area must be", dict(min_projected_area=-1)), ("transparency", dict(transparency="x")),
                             ("part must have", dict(part=(2, 2))), ("outline_colour", dict(outline_colour=(1, 2))),
                             ("depth_shading must be 0 to 1", dict(depth_shading=1.5)), ("hatching_spacing must be 2", dict(hatching_spacing=1)),
                             ("hatching must be 0 to 1", dict(hatching=-1)), ("gl_state", dict(gl_state="x")),
                             ("budget_ms must be", dict(budget_ms=float("nan"))),
                             ("lod_error must be", dict(lod_error=-1.0)),
                             ("width must be 1 to 65536 pixels", dict(width=0)), ("height must be", dict(draw=True, height=-5)),
                             ("culled_colour", dict(culled_colour=(1, 2)))):
            self.assert_error(text, sightline.Engine, self.scene, **config)
        with self.assertRaises(TypeError):
            sightline.Engine(self.scene, colour="red")
        with self.assertRaises(TypeError):
            sightline.Engine(None)
        for text, config in (("draw: expected True or False, found str", dict(draw="x")),
                             ("width: expected a whole number, found float", dict(width=1.5)),
                             ("budget_ms: expected a number, found str", dict(budget_ms="x")),
                             ("part: expected two whole numbers, found int", dict(part=3)),
                             ("culler: expected a text, found int", dict(culler=3)),
                             ("program_cache: expected a path or None, found int", dict(program_cache=3)),
                             ("controller: expected a ControllerConfig or None, found str", dict(controller="x"))):
            with self.assertRaisesRegex(TypeError, text):
                sightline.Engine(self.scene, **config)

    def test_controllers_are_checked(self):
        for text, config in (("margin must be 0 or more", dict(margin=float("nan"))),
                             ("probe_share must be 0 or more", dict(probe_share=-1))):
            self.assert_error(text, sightline.ControllerConfig, **config)
        with self.assertRaisesRegex(TypeError, "ControllerConfig\\(\\) has no argument policy"):
            sightline.ControllerConfig(policy="2009")
        controller = sightline.ControllerConfig()
        self.assert_error("probe_cost must be", setattr, controller, "probe_cost", float("inf"))
        with self.assertRaisesRegex(TypeError, "dwell_frames: expected a whole number"):
            controller.dwell_frames = "x"
        self.assertEqual(controller, sightline.ControllerConfig())
        controller.probe_cost, controller.dwell_frames = 0.5, 9
        self.assertEqual(controller, sightline.ControllerConfig(probe_cost=0.5, dwell_frames=9))
        self.assertIsNone(self.engine.controller, "no hybrid")

    def test_settings_come_back(self):
        chosen = dict(width=30, height=20, threads=3, renderer="auto", ids=True, samples=4, transparency="blended", part=(1, 3),
                      rebuild_share=0.25, gpu_variant="compute", context_platform="osmesa", context_later=True, gl_state="leave", gl_debug=True,
                      program_cache=self.folder, culler="linear", sample_test=False, occlusion="off", min_projected_area=2.5,
                      contribution_mode="points", budget_ms=7.0, lod_error=1.5, culled_colour=(0, 0.25, 1), outline_colour=(1, 0, 0.5),
                      depth_shading=0.5, edge_lines=0.25, hatching=0.75, hatching_spacing=9.0,
                      edges="all", edge_width=2.5, edge_colour=(0.25, 0.5, 0.75),
                      lighting="sun", sun=(1, 2, 3), background_bottom=(0, 0.5, 1), background_top=(1, 0.5, 0),
                      controller=sightline.ControllerConfig(margin=0.25, silent_frames=9))
        engine = sightline.Engine(self.scene, **chosen)
        self.assertEqual(engine.config, {"draw": False, **chosen})
        defaults = sightline.Engine(self.scene).config
        names = inspect.signature(sightline.Engine).parameters
        self.assertEqual(set(defaults), set(names) - {"scene", "get_proc", "progress"})
        for name, value in defaults.items():
            told = sightline.ControllerConfig() if name == "controller" else names[name].default
            self.assertEqual(value, told, name)
            if name in chosen:
                self.assertNotEqual(value, chosen[name], name)
        self.assertEqual(sightline.Engine(self.scene, **engine.config).config, engine.config)

    def test_settings_change_while_it_lives(self):
        engine = sightline.Engine(self.scene, width=400, height=250)
        before = engine.config
        engine.configure(budget_ms=12, culler="linear", culled_colour=(1, 0, 0),
                         controller=sightline.ControllerConfig(margin=0.5))
        changed = {**before, "budget_ms": 12, "culler": "linear", "culled_colour": (1, 0, 0),
                   "controller": sightline.ControllerConfig(margin=0.5)}
        self.assertEqual(engine.config, changed)
        self.assertEqual((engine.culler, engine.frame(self.near).culler), ("linear", "linear"))
        engine.configure()
        self.assertEqual(engine.config, changed)
        engine.resize(30, 20)
        engine.configure(culled_colour=None, controller=None)
        self.assertEqual((engine.config["culled_colour"], engine.config["width"]), (None, 30))
        self.assertEqual(engine.config["controller"], before["controller"])
        self.assert_error("edge_lines must be 0 to 1", engine.configure, edge_lines=2, budget_ms=1)
        self.assertEqual(engine.config["budget_ms"], 12)
        self.assert_error("culler: expected", engine.configure, culler="x")
        with self.assertRaises(TypeError):
            engine.configure(width=100)
        with self.assertRaises(TypeError):
            engine.configure(budget_ms=None)

    def test_creation_tells_its_progress_and_stops(self):
        scene = plant(1000)
        shares = []
        sightline.Engine(scene, progress=shares.append).close()
        self.assertEqual(shares, sorted(shares))
        self.assertTrue(len(shares) >= 2 and shares[-1] == 1.0)
        self.assert_error("cancelled", sightline.Engine, scene, progress=lambda share: False)
        self.assert_error("progress: expected a function", sightline.Engine, scene, progress=3)
        def use(share):
            scene.root.add_node("n")
        self.assert_error("in use by the call that called back", sightline.Engine, scene, progress=use)
        def broken(share):
            raise LookupError(share)
        with self.assertRaises(LookupError):
            sightline.Engine(scene, progress=broken)
        def broken_at_the_end(share):
            if share == 1.0:
                raise LookupError(share)
        with self.assertRaises(LookupError):
            sightline.Engine(scene, progress=broken_at_the_end)
        scene.root.add_node("n").add(sightline.Sphere(1))
        self.assertEqual(sightline.Engine(scene).frame(overview(scene)).visible, 1001, "the scene still serves")

    def test_ctrl_c_ends_creation(self):
        scene = plant(1000)
        def interrupt(share):
            signal.raise_signal(signal.SIGINT)
        with self.assertRaises(KeyboardInterrupt):
            sightline.Engine(scene, progress=interrupt)
        self.assertEqual(sightline.Engine(scene).frame(overview(scene)).visible, 1000)

    def test_ctrl_c_ends_creation_without_a_function(self):
        scene = plant(200_000)
        timer = threading.Timer(0.01, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        made = None
        with self.assertRaises(KeyboardInterrupt):
            made = sightline.Engine(scene)
            timer.join()
        self.assertIsNone(made)
        self.assertEqual(sightline.Engine(scene).frame(overview(scene)).visible, 200_000)

    def test_parts_are_together_the_scene(self):
        self.engine.frame(self.near)
        parts = [sightline.Engine(self.scene, part=(i, 3)) for i in range(3)]
        for engine in parts:
            engine.frame(self.near)
        found = [engine.visible_items() for engine in parts]
        self.assertGreater(min(map(len, found)), 0)
        np.testing.assert_array_equal(np.sort(np.concatenate(found)), self.engine.visible_items())

    def test_states_of_items(self):
        report = self.engine.frame(self.near)
        states = self.engine.cull_states(self.near)
        names = np.array(sightline.CULL_STATES)[states.of_item]
        self.assertEqual(len(names), 3000)
        self.assertEqual({name: int((names == name).sum()) for name in sightline.CULL_STATES}, states.items)
        self.assertEqual(set(np.flatnonzero(names != "outside")), set(self.engine.visible_items()))
        self.assertEqual(states.items["inside"] + states.items["intersecting"], report.visible)
        self.assertEqual(states.box_items.sum(), 3000)
        self.assertEqual(states.boxes.shape, (len(states.box_states), 6))
        kept = states.boxes[states.box_states != sightline.CULL_STATES.index("outside")]
        for item in self.engine.visible_items():
            low, high = self.scene.item(item).bounds
            inside = (kept[:, :3] <= low + 1e-3) & (kept[:, 3:] >= high - 1e-3)
            self.assertTrue(inside.all(axis=1).any(), item)

    def test_parts_of_images_are_culled_apart(self):
        engine = sightline.Engine(self.scene, width=400, height=250)
        whole = set(engine.items_in(self.near, (0, 0, 400, 250)))
        tiles = sightline.image_tiles(400, 250, 130)
        engine.resize(tiles.width, tiles.height)
        taken, seen = np.zeros((250, 400), int), set()
        for tile in tiles.tiles:
            engine.frame_tile(self.near, tile.tile)
            found = set(engine.visible_items())
            self.assertLess(len(found), len(whole))
            seen |= found
            taken[tile.y0:tile.y1, tile.x0:tile.x1] += 1
        self.assertTrue((taken == 1).all())
        self.assertLessEqual(whole, seen)
        self.assertLess(len(seen - whole), 5, "but for rounding, boxes that touch a border")
        self.assert_error("too small", sightline.image_tiles, 400, 250, 30)
        self.assert_error("at most 262144 pixels", sightline.image_tiles, 10**6, 250, 300)
        self.assert_error("", engine.frame_tile, self.near, sightline.ImageTile(0, 0, 0, 0))

    def test_the_tracer_is_made_ahead(self):
        engine = sightline.Engine(self.scene, width=400, height=250)
        self.assertFalse(engine.preparing_picks)
        self.assertEqual(engine.memory.tracer, 0)
        engine.prepare_picks()
        while engine.preparing_picks:
            pass
        first = engine.pick(self.view, 200, 125)
        self.assertGreater(engine.memory.tracer, 0)
        self.assertEqual(first and first.item, (self.engine.pick(self.view, 200, 125) or first).item)

    def test_ghosts_are_hit_on_request(self):
        engine = sightline.Engine(self.scene, width=400, height=250)
        x = next(x for x in range(5, 400, 10) if engine.pick(self.view, x, 125))
        solid = engine.pick(self.view, x, 125)
        engine.set_override([solid.item], ghost=True)
        behind = engine.pick(self.view, x, 125)
        self.assertNotEqual(behind and behind.item, solid.item)
        self.assertEqual(engine.pick(self.view, x, 125, ghosts=True).item, solid.item)
        ray = (solid.point + solid.normal, -solid.normal)
        through = engine.pick_ray(*ray)
        self.assertNotEqual(through and through.item, solid.item)
        self.assertEqual(engine.pick_ray(*ray, ghosts=True).item, solid.item)

    def test_sections_cut_what_rays_hit(self):
        scene = sightline.Scene()
        scene.root.add(sightline.Sphere(2))
        engine = sightline.Engine(scene)
        def hit(**how):
            return engine.pick_ray((0, -9, 0), (0, 1, 0), **how)
        cut = [[0, 1, 0, 0.5], [1, 0, 0, 9]]  # keeps y > -0.5
        self.assertEqual((hit().t, hit().face), (8, "side"))
        self.assertEqual((hit(sections=cut).t, hit(sections=cut).face), (8.5, "cut"))
        self.assertEqual((hit(sections=cut, cuts=False).t, hit(sections=cut, cuts=False).face), (10, "side"))
        self.assertEqual(hit(sections=cut, section_mode="union").t, 8)
        self.assert_error("at most 8 planes", hit, sections=np.ones((9, 4)))
        self.assert_error("section_mode", hit, section_mode="x")

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
        self.engine.frame(self.near)  # a view of a part needs scratch memory
        memory = self.engine.memory
        self.assertGreater(min(memory.scene, memory.snapshot, memory.bvh, memory.scratch), 0)
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
