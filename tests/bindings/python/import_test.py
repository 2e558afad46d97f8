"""Import: progress, cancellation, Ctrl-C; writing; and that a scene stays as it was."""

import math
import subprocess
import sys
import unittest

import sightline
from support import SMALL_PLANT, Case, plant


class Import(Case):
    def test_reads_a_file(self):
        scene = sightline.Scene()
        shares = []
        report = scene.import_file(SMALL_PLANT, progress=shares.append)
        self.assertEqual(sum(report.items.values()), scene.item_count)
        self.assertEqual(report.bytes, SMALL_PLANT.stat().st_size)
        self.assertEqual([n.name for n in report.nodes], [SMALL_PLANT.name])
        self.assertEqual((shares[0], shares[-1], shares), (0.0, 1.0, sorted(shares)))
        self.assertEqual(report.warnings, [])
        self.assertIn(".rvm", sightline.known_extensions())

    def test_several_files_below_a_node(self):
        scene = sightline.Scene()
        site = scene.root.add_node("site")
        report = scene.import_files([SMALL_PLANT, str(SMALL_PLANT)], site, threads=2)
        self.assertEqual(site.children, report.nodes)
        self.assertEqual(len(report.nodes), 2)

    def test_a_cache_gives_the_same_the_second_time(self):
        if ".slc" not in sightline.known_extensions():
            self.skipTest("built without caches")
        caches = self.folder / "caches"
        for files in (lambda scene: scene.import_file(SMALL_PLANT, cache_folder=caches),
                      lambda scene: scene.import_files([SMALL_PLANT, SMALL_PLANT], cache_folder=str(caches))):
            scenes = [sightline.Scene(), sightline.Scene()]
            reports = [files(scene) for scene in scenes]
            self.assertEqual([r.from_cache for r in reports], [False, True])
            self.assertEqual([r.warnings for r in reports], [[], []])
            self.assertEqual(reports[0].items, reports[1].items)
            written = []
            for scene in scenes:
                scene.write(self.folder / "again.rvm")
                written.append((self.folder / "again.rvm").read_bytes())
            self.assertEqual(*written)
        self.assertEqual(len(list(caches.iterdir())), 2)
        self.assertFalse(sightline.Scene().import_file(SMALL_PLANT).from_cache)

    def test_caches_hold_levels_where_that_is_asked_for(self):
        if not {".obj", ".slc"} <= set(sightline.known_extensions()):
            self.skipTest("built without caches or OBJ")
        file, plain, levels = (self.folder / name for name in ("hills.obj", "plain.slc", "levels.slc"))
        side = range(40)
        corners = [f"v {x} {y} {math.sin(0.4 * x) * math.sin(0.3 * y)}" for y in side for x in side]
        cells = [40 * y + x + 1 for y in side[1:] for x in side[1:]]
        file.write_text("\n".join(corners + [f"f {i - 41} {i - 40} {i} {i - 1}" for i in cells]))
        self.tool("convert", file, plain)
        self.tool("convert", "--levels", file, levels)
        of_levels = levels.stat().st_size - plain.stat().st_size
        if of_levels == 0:
            self.skipTest("no levels in this build")
        for name, files in (("one", lambda scene, **options: scene.import_file(file, **options)),
                            ("several", lambda scene, **options: scene.import_files([file], **options))):
            sizes = []
            for asked in ({}, {"cached_levels": True}):
                files(sightline.Scene(), cache_folder=self.folder / name, **asked)
                sizes.append(sum(cache.stat().st_size for cache in (self.folder / name).iterdir()))
            self.assertEqual(sizes[1] - sizes[0], of_levels)
            self.assertTrue(files(sightline.Scene(), cache_folder=self.folder / name).from_cache)

    def test_primitives_are_recognised(self):
        if ".obj" not in sightline.known_extensions():
            self.skipTest("built without OBJ")
        file = self.folder / "box.obj"
        corners = [f"v {x} {y} {z}" for z in (0, 6) for x, y in ((0, 0), (2, 0), (2, 4), (0, 4))]
        faces = ["f 4 3 2 1", "f 5 6 7 8", "f 1 2 6 5", "f 2 3 7 6", "f 3 4 8 7", "f 4 1 5 8"]
        square = ["v 9 0 0", "v 10 0 0", "v 10 1 0", "v 9 1 0", "f 9 10 11 12"]
        file.write_text("\n".join(corners + faces + square))
        for files in (lambda scene, **options: scene.import_file(file, **options),
                      lambda scene, **options: scene.import_files([file], **options)):
            scene = sightline.Scene()
            none = files(scene).recognition
            self.assertEqual((none.meshes, none.items["box"]), (0, 0))
            self.assertEqual([scene.item(i).kind for i in scene.items], ["mesh"] * scene.item_count)
            scene = sightline.Scene()
            found = files(scene, recognise=True, recognise_tolerance=1e-4).recognition
            self.assertEqual((found.meshes, found.items["box"], sum(found.items.values())), (1, 1, 1))
            self.assertEqual((found.triangles_before, found.triangles_after), (14, 2))
            self.assertLess(found.bytes_after, found.bytes_before)
            self.assertLess(found.largest_deviation, 1e-6)
            self.assertEqual((found.refused["open"], sum(found.refused.values())), (1, 1))
            self.assertIn("box", [scene.item(i).kind for i in scene.items])
            for bad in (-1.0, float("nan"), float("inf")):
                self.assert_error("recognise_tolerance", files, scene, recognise=True, recognise_tolerance=bad)

    def test_files_that_stand_on_y_are_turned(self):
        standing = self.folder / "standing.obj"
        standing.write_text("v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0.5 2 0.5\n"
                            "f 1 2 3 4\nf 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5\n")
        for options, height in (({}, 2.0), ({"up": "auto"}, 2.0), ({"up": "y"}, 2.0), ({"up": "z"}, 1.0)):
            scene = sightline.Scene()
            report = scene.import_file(standing, **options)
            self.assertAlmostEqual(scene.root.bounds()[1, 2], height, 6)
            self.assertEqual(len(report.warnings), 0 if options.get("up") in ("y", "z") else 1)

    def test_what_is_written_is_read_again(self):
        scene = plant(2000)
        scene.write(self.folder / "plant.rvm")
        again = sightline.Scene()
        again.import_file(self.folder / "plant.rvm")
        again.write(self.folder / "again.rvm", again.root.children[0])
        self.assertEqual((self.folder / "plant.rvm").read_bytes(), (self.folder / "again.rvm").read_bytes())

    def test_every_format_is_written(self):
        scene = plant(1000)
        for name in ("a.rvm", "a.obj", "a.glb", "a.gltf", "a.slc"):
            written = scene.write(self.folder / name, tolerance=0.01)
            self.assertEqual(written["items"] + written["left_out"], 1000, name)
            self.assertEqual(written["triangles"] > 0, name not in ("a.rvm", "a.slc"), name)
            self.assertLessEqual(written["largest_chord_error"], 0.01)
            again = sightline.Scene()
            again.import_file(self.folder / name)
            self.assertGreater(again.item_count, 0, name)  # OBJ and glTF join what lies in one node
            if name in ("a.rvm", "a.slc"):
                self.assertEqual(again.item_count, written["items"], name)
        scene.write(self.folder / "tiles", tiles=True, compress=False)
        self.assertTrue((self.folder / "tiles" / "tileset.json").exists())
        self.assert_error("a.xyz", scene.write, self.folder / "a.xyz")
        self.assert_error("tolerance: expected above 0", scene.write, self.folder / "b.obj", tolerance=0)
        with self.assertRaises(TypeError):
            scene.write(self.folder / "b.obj", colour=3)

    def test_the_generator_is_the_tools(self):
        plant(2000, 3).write(self.folder / "python.rvm")
        self.tool("generate", "--items", 2000, "--seed", 3, self.folder / "tool.rvm")
        self.assertEqual((self.folder / "python.rvm").read_bytes(), (self.folder / "tool.rvm").read_bytes())

    def test_errors_name_the_file(self):
        scene = sightline.Scene()
        self.assert_error("missing.rvm", scene.import_file, self.folder / "missing.rvm")
        broken = self.folder / "broken.rvm"
        broken.write_bytes(SMALL_PLANT.read_bytes()[:1000])
        self.assert_error("broken.rvm", scene.import_file, broken)
        self.assertEqual(scene.node_count, 1)
        self.assertGreater(len(scene.import_file(broken, lenient=True).warnings), 0)
        self.assert_error("up: expected y, z or auto", scene.import_file, broken, up="x")
        triangle = self.folder / "triangle.obj"
        triangle.write_text("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n")
        self.assert_error("metres_per_unit: expected above 0", scene.import_file, triangle, metres_per_unit=-1.0)
        self.assert_error("threads", scene.import_files, [SMALL_PLANT], threads=-1)


class Cancel(Case):
    def check_untouched(self, scene):
        self.assertEqual((scene.node_count, scene.item_count, scene.materials), (1, 0, []))

    def test_false_cancels(self):
        scene = sightline.Scene()
        self.assert_error("cancelled", scene.import_file, SMALL_PLANT, progress=lambda share: False)
        self.check_untouched(scene)

    def test_an_exception_cancels_and_comes_through(self):
        scene = sightline.Scene()
        def stop(share):
            raise KeyError("stop")
        with self.assertRaises(KeyError):
            scene.import_file(SMALL_PLANT, progress=stop)
        self.check_untouched(scene)
        with self.assertRaises(KeyError):
            plant(20000).write(self.folder / "out.rvm", progress=stop)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_the_scene_cannot_be_used_meanwhile(self):
        scene = sightline.Scene()
        for use in (lambda: scene.root, lambda: scene.item_count, scene.commit,
                    lambda: scene.import_file(SMALL_PLANT), lambda: scene.add_material("m")):
            def progress(share):
                use()
            self.assert_error("in use by the call that called back", scene.import_file, SMALL_PLANT, progress=progress)
            self.check_untouched(scene)
        self.assert_error("progress: expected a function", scene.import_file, SMALL_PLANT, progress=3)

    def test_ctrl_c_cancels(self):
        # Enough files that the signal comes first; without a callback, which would be stopped anyway.
        plant(20000).write(self.folder / "plant.rvm")
        program = """if True:
            import os, signal, sys, threading, sightline
            scene = sightline.Scene()
            threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
            try:
                scene.import_files([sys.argv[1]] * 400)
            except KeyboardInterrupt:
                print("interrupted", scene.node_count, scene.item_count)
        """
        done = subprocess.run([sys.executable, "-c", program, self.folder / "plant.rvm"], capture_output=True, text=True)
        self.assertEqual((done.stdout, done.stderr), ("interrupted 1 0\n", ""))


if __name__ == "__main__":
    unittest.main()
