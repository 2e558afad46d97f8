"""Who keeps whom alive, and what several threads may do."""

import gc
import sys
import threading
import time
import unittest
import weakref

import numpy as np
import sightline
from support import SMALL_PLANT, Case, box_rows, overview, plant

TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 0, 1]], [[0, 1, 2]])


class Lifetimes(Case):
    def watch(self, thing):
        gc.collect()
        return weakref.ref(thing)

    def assert_freed(self, watched):
        gc.collect()
        self.assertIsNone(watched())

    def test_a_scene_ends_with_its_last_user(self):
        for make in (lambda s: s.root, lambda s: s.root.add(sightline.Sphere(1)), lambda s: s.add_material(),
                     lambda s: s.add_mesh(*TRIANGLE), lambda s: s.add_mesh(*TRIANGLE).positions,
                     lambda s: s.import_file(SMALL_PLANT), lambda s: sightline.Engine(s)):
            scene = sightline.Scene()
            user = make(scene)
            used = scene.memory_bytes  # the C++ scene
            watched = self.watch(scene)
            del scene
            if hasattr(user, "scene"):
                self.assertEqual(user.scene.memory_bytes, used)
            del user
            self.assert_freed(watched)

    def test_handles_keep_the_scene(self):
        scene = sightline.Scene()
        node = scene.root.add_node("n")
        item = node.add(sightline.Sphere(1))
        del scene
        gc.collect()
        self.assertEqual((node.name, item.kind, item.node), ("n", "sphere", node))
        self.assertEqual(node.scene.item_count, 1)

    def test_an_array_of_a_mesh_keeps_the_scene(self):
        scene = sightline.Scene()
        positions = scene.add_mesh(*TRIANGLE).positions[1:]
        for _ in range(1000):  # the scene's arrays move
            scene.add_mesh(*TRIANGLE)
        del scene
        gc.collect()
        junk = [np.ones((1000, 3), np.float32) for _ in range(100)]
        np.testing.assert_array_equal(positions, TRIANGLE[0][1:])
        del junk

    def test_an_engine_keeps_its_scene(self):
        scene = plant()
        view = overview(scene)
        engine = sightline.Engine(scene)
        del scene
        gc.collect()
        self.assertEqual(engine.frame(view).visible, 3000)
        pick = engine.pick(view, 640, 360)
        del engine
        gc.collect()
        self.assertIsNotNone(pick.node.path)

    def test_arrays_in_are_not_kept(self):
        rows = box_rows(100)
        before = sys.getrefcount(rows)
        culler = sightline.BoxCuller(rows)
        self.assertEqual(sys.getrefcount(rows), before)
        rows[:] = np.nan  # the culler has its own
        self.assertEqual(len(culler), 100)

    def test_results_own_themselves(self):
        culler = sightline.BoxCuller(box_rows(1000))
        view = sightline.View.perspective((0, -300, 0), (0, 0, 0), fovy=1.5, aspect=1)
        visible = culler.visible(view)
        copy = visible.copy()
        culler.visible(view)
        del culler
        gc.collect()
        visible[0] += 0  # writable
        np.testing.assert_array_equal(visible, copy)

    def test_a_closed_engine_says_so(self):
        scene = plant(1000)
        with sightline.Engine(scene) as engine:
            self.assertFalse(engine.closed)
        self.assertTrue(engine.closed)
        engine.close()
        view = overview(scene)
        for call in (lambda: engine.frame(view), engine.commit, engine.visible_items, lambda: engine.plan,
                     lambda: engine.pick(view, 1, 1), lambda: engine.resize(8, 8), engine.read_colour,
                     lambda: engine.set_culler("gpu"), engine.__enter__().finish, lambda: engine.renderer):
            self.assert_error("engine: it is closed", call)
        self.assertIs(engine.scene, scene)

    def test_a_constructor_may_not_be_skipped(self):
        class Child(sightline.Scene):
            def __init__(self):
                pass
        with self.assertRaises(TypeError):
            Child()


class Threads(Case):
    def run_all(self, *works):
        """Each work runs 30 times in a thread of its own. Raises what they raise."""
        errors = []
        def repeat(work):
            try:
                for i in range(30):
                    work(i)
            except BaseException as error:
                errors.append(error)
        threads = [threading.Thread(target=repeat, args=(work,)) for work in works]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if errors:
            raise errors[0]

    def test_edits_frames_and_imports_of_one_scene(self):
        scene = plant(2000)
        view = overview(scene)
        engines = [sightline.Engine(scene), sightline.Engine(scene, culler="cpu")]
        node = scene.root.add_node("edited")
        item = node.add(sightline.Sphere(1))

        def edit(i):
            item.placement = sightline.translation([i, 0, 0])
            node.add(sightline.Cylinder(0.1, 1)).remove()
            mesh = scene.add_mesh(*TRIANGLE)
            mesh.remove()
            scene.commit()

        def show(engine):
            engine.commit()
            self.assertGreaterEqual(engine.frame(view).visible, 2000)
            engine.pick(view, 640, 360)
            engine.visible_items()

        def load(_):
            scene.import_file(SMALL_PLANT).nodes[0].remove()

        self.run_all(edit, load, lambda i: show(engines[0]), lambda i: show(engines[1]), lambda i: show(engines[0]))
        engines[0].commit()
        self.assertEqual(engines[0].frame(view).visible, sightline.Engine(scene).frame(view).visible)

    def test_others_wait_while_a_scene_is_imported_into(self):
        scene = sightline.Scene()
        engine = sightline.Engine(scene, width=8, height=8)
        view = sightline.View.perspective((0, -9, 0), (0, 0, 0), fovy=1, aspect=1)
        done = []
        users = {"edit": lambda: scene.root.add_node("n"), "read": lambda: scene.item_count,
                 "commit": scene.commit, "frame": lambda: engine.frame(view), "engine": lambda: sightline.Engine(scene)}
        def use(name, call):
            call()
            done.append(name)
        threads = [threading.Thread(target=use, args=user) for user in users.items()]

        def progress(share):
            if share == 0:
                for thread in threads:
                    thread.start()
                for thread in threads:
                    thread.join(0.05)
            done.append(share)

        scene.import_file(SMALL_PLANT, progress=progress)
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(done[-5:]), sorted(users))
        self.assertEqual(done[:-5], sorted(done[:-5]))

    def test_a_pick_that_waits_comes_before_the_next_frame(self):
        scene = plant(2000)
        view = overview(scene)
        engine = sightline.Engine(scene, width=64, height=40)
        engine.pick(view, 32, 20)
        frames, between = [], []
        done = threading.Event()

        def draw():
            while not done.is_set() and len(frames) < 2000:
                engine.commit()
                engine.frame(view)
                frames.append(None)

        interval = sys.getswitchinterval()
        sys.setswitchinterval(60)  # the GIL changes hands in long calls alone
        self.addCleanup(sys.setswitchinterval, interval)
        drawing = threading.Thread(target=draw)
        drawing.start()
        for _ in range(20):
            before = len(frames)
            engine.pick(view, 32, 20)
            between.append(len(frames) - before)
            time.sleep(0)
        done.set()
        drawing.join()
        self.assertLessEqual(max(between), 2)
        self.assertGreater(len(frames), 10, "frames come between picks, too")

    def test_a_callback_reads_what_its_call_reads_while_an_edit_waits(self):
        scene = plant(20_000)
        view = overview(scene)
        engine = sightline.Engine(scene, width=8, height=8)
        waiting = [threading.Thread(target=call) for call in (lambda: scene.root.add_node("n"), engine.commit,
                                                              lambda: engine.frame(view))]
        counts = []

        def progress(_):
            for thread in waiting if not counts else ():
                thread.start()
                thread.join(0.05)
            counts.append(scene.item_count)
            engine.frame(view)
            self.assert_error("in use by the call that called back", scene.root.add_node, "m")

        scene.write(self.folder / "plant.rvm", progress=progress)
        for thread in waiting:
            thread.join()
        self.assertEqual(set(counts), {20_000})

    def test_a_culler_is_updated_while_others_ask(self):
        rows = box_rows(20000)
        culler = sightline.BoxCuller(rows)
        view = sightline.View.perspective((0, -150, 30), (0, 0, 0), fovy=0.6, aspect=1.5)
        def ask(_):
            culler.visible(view)
        some = np.arange(6000)
        self.run_all(ask, ask, lambda i: culler.update(i, rows[i + 1]), lambda i: culler.update(some, rows[some + i]),
                     lambda i: culler.refit(rows))

    def test_engines_end_on_any_thread(self):
        scene = plant(1000)
        view = overview(scene)
        self.run_all(*[lambda i: sightline.Engine(scene).frame(view)] * 3)

    def test_other_threads_run_during_long_calls(self):
        scene = sightline.Scene()
        ticks = []
        stop = threading.Event()
        def tick():
            while not stop.wait(0.001):
                ticks.append(1)
        ticking = threading.Thread(target=tick)
        ticking.start()
        before = len(ticks)
        scene.generate_plant(300_000)
        during = len(ticks) - before
        stop.set()
        ticking.join()
        self.assertGreater(during, 2)


if __name__ == "__main__":
    unittest.main()
