"""What Python computes is what the tools compute, bit for bit."""

import json
import unittest

import numpy as np
import sightline
from support import GlCase, plant


class Tools(GlCase):
    def setUp(self):
        super().setUp()
        self.model = self.folder / "plant.rvm"
        plant(5000, 2).write(self.model)
        self.scene = sightline.Scene()
        self.scene.import_file(self.model)

    def test_an_image_is_that_of_render(self):
        view = self.folder / "view.json"
        view.write_text('{"eye":[-30,-25,12],"target":[0,0,3],"fovy_deg":50,"near":0.5,'
                        '"sections":[{"n":[1,0.2,0],"d":4}]}')
        self.tool("render", self.model, "--plain", "--size", "320x200", "--view", view, "--out", self.folder / "a.png", "--ids",
                  self.folder / "ids.png", "--depth", self.folder / "a.pfm")
        with sightline.Engine(self.scene, draw=True, width=320, height=200, ids=True) as engine:
            seen = sightline.View.read(view, aspect=320 / 200)
            engine.frame(seen)
            colour, ids, depth = engine.read_colour(), engine.read_ids(), engine.read_depth(seen)
        np.testing.assert_array_equal(colour, sightline.read_png(self.folder / "a.png"))
        np.testing.assert_array_equal(ids, sightline.ids_of_colours(sightline.read_png(self.folder / "ids.png")))
        sightline.write_pfm(self.folder / "b.pfm", depth)
        self.assertEqual((self.folder / "a.pfm").read_bytes(), (self.folder / "b.pfm").read_bytes())
        self.assertGreater(len(np.unique(ids)), 50)

    def test_the_whole_model_is_that_of_render(self):
        self.tool("render", self.model, "--plain", "--size", "200x160", "--out", self.folder / "a.png")
        np.testing.assert_array_equal(sightline.render(self.scene, width=200, height=160),
                                      sightline.read_png(self.folder / "a.png"))

    def test_comparison_is_that_of_render(self):
        first = sightline.render(self.scene, width=200, height=160)
        self.scene.root.children[0].children[0].children[0].remove()
        second = sightline.render(self.scene, width=200, height=160)
        sightline.write_png(self.folder / "second.png", second)
        self.tool("render", self.model, "--plain", "--size", "200x160", "--compare", self.folder / "second.png", "--max", 255,
                  "--json", self.folder / "out.json")
        said = json.loads((self.folder / "out.json").read_text())["compare"]
        difference, metrics = sightline.compare(second, first), sightline.metrics(second, first)
        self.assertEqual((said["max"], said["pixels"]), (difference.max, difference.pixels))
        self.assertGreater(difference.pixels, 0)
        for name, value in (("mean", difference.mean), ("psnr", metrics.psnr), ("ssim", metrics.ssim)):
            self.assertEqual(said[name], value, name)
        self.assertEqual(said["flip"], {"mean": metrics.flip_mean, "p99": metrics.flip_p99})

    def test_a_flight_is_that_of_replay(self):
        frames = self.folder / "frames"
        self.tool("replay", self.model, "--size", "200x160", "--frames", 9, "--images", frames, "--every", 4,
                  "--save-path", self.folder / "path.json", "--json", self.folder / "out.json", "--csv",
                  self.folder / "out.csv")
        rows = [line.split(",") for line in (self.folder / "out.csv").read_text().splitlines()
                if line and not line.startswith("#")]
        visible = rows[0].index("visible")
        images = {}
        with sightline.Engine(self.scene, draw=True, width=200, height=160) as engine:
            def keep(frame, view):
                if frame % 4 == 0:
                    images[frame] = engine.read_colour()
            tour = engine.tour()
            reports = sightline.replay(engine, tour, 9, after_frame=keep)
        self.assertEqual([report.visible for report in reports], [int(row[visible]) for row in rows[1:]])
        self.assertEqual(tour.format(), (self.folder / "path.json").read_text())
        saved = sorted(frames.glob("*.png"))
        self.assertEqual(len(saved), 3)
        for file, image in zip(saved, images.values()):
            np.testing.assert_array_equal(image, sightline.read_png(file))

    def test_a_pick_is_that_of_trace(self):
        engine = sightline.Engine(self.scene, width=200, height=160)
        x, pick = next((x, hit) for x in range(200) if (hit := engine.pick(engine.fit(), x, 80)))
        self.tool("trace", self.model, "--size", "200x160", "--pick", f"{x},80", "--json", self.folder / "out.json")
        said = json.loads((self.folder / "out.json").read_text())["pick"]
        self.assertEqual(said["item"], pick.item)
        np.testing.assert_array_equal(said["point"], pick.point)


if __name__ == "__main__":
    unittest.main()
