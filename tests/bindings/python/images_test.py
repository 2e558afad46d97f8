"""Images as arrays: files and comparison."""

import math
import unittest

import numpy as np
import sightline
from support import Case


def noise(seed, height=40, width=60):
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)


class Images(Case):
    def test_png_comes_back(self):
        image = noise(1)
        sightline.write_png(self.folder / "a.png", image)
        again = sightline.read_png(self.folder / "a.png")
        np.testing.assert_array_equal(again, image)
        (self.folder / "b.png").write_bytes(sightline.encode_png(image[:, ::-1]))
        np.testing.assert_array_equal(sightline.read_png(self.folder / "b.png"), image[:, ::-1])

    def test_compare_is_numpy(self):
        a, b = noise(1), noise(2)
        b[:20] = a[:20]
        difference = np.abs(a.astype(int) - b)
        got = sightline.compare(a, b)
        self.assertEqual((got.max, got.pixels), (difference.max(), (difference.max(axis=2) > 0).sum()))
        self.assertAlmostEqual(got.mean, difference.mean())
        np.testing.assert_array_equal(sightline.difference_image(a, b), np.minimum(4 * difference, 255))

    def test_metrics(self):
        a, b = noise(1), noise(2)
        same = sightline.metrics(a, a)
        self.assertEqual((same.psnr, same.flip_mean), (math.inf, 0))
        other = sightline.metrics(a, b)
        mse = np.mean((a.astype(float) - b) ** 2)
        self.assertAlmostEqual(other.psnr, 10 * math.log10(255**2 / mse), places=9)
        flip = sightline.flip(a, b)
        self.assertEqual((flip.shape, flip.dtype), ((40, 60), np.float32))
        self.assertAlmostEqual(float(flip.mean(dtype=np.float64)), other.flip_mean, places=6)

    def test_ids(self):
        ids = np.arange(24, dtype=np.uint32).reshape(4, 6) * 1000
        np.testing.assert_array_equal(sightline.ids_of_colours(sightline.id_colours(ids)), ids)
        wrong = ids.copy()
        wrong[1, 2:5] = 0
        self.assertEqual(sightline.wrong_ids(ids, wrong), 3)
        self.assert_error("", sightline.id_colours, ids + 0x1000000)

    def test_pfm(self):
        depth = np.array([[1.5, np.inf], [3, 4]], dtype=np.float32)
        sightline.write_pfm(self.folder / "d.pfm", depth)
        data = (self.folder / "d.pfm").read_bytes()
        self.assertTrue(data.startswith(b"Pf\n2 2\n"))
        np.testing.assert_array_equal(np.frombuffer(data[-16:], "<f4").reshape(2, 2), depth[::-1])

    def test_misuse(self):
        a = noise(1)
        self.assert_error("image: expected uint8 of shape (N, N, 3), found float64", sightline.compare, a, a / 255)
        self.assert_error("image: expected uint8, found uint16", sightline.compare, a, a.astype(np.uint16))
        self.assert_error("found uint8 of shape (40, 60, 4)", sightline.write_png, "x.png",
                          np.zeros((40, 60, 4), np.uint8))
        for compare in (sightline.compare, sightline.metrics, sightline.flip, sightline.difference_image):
            self.assert_error("", compare, a, a[1:])
        self.assert_error("", sightline.metrics, a[:5], a[:5])
        self.assert_error("pixels_per_degree: expected 1 to 1000, found nan", sightline.flip, a, a,
                          pixels_per_degree=math.nan)
        empty = np.zeros((0, 5, 3), np.uint8)
        self.assert_error("with pixels", sightline.flip, empty, empty)
        self.assert_error("", sightline.write_png, self.folder / "no" / "folder.png", a)
        self.assert_error("ends in .png", sightline.write_png, self.folder / "a.jpg", a)
        self.assert_error("", sightline.write_png, self.folder / "e.png", empty)
        self.assert_error("missing.png", sightline.read_png, self.folder / "missing.png")
        self.assert_error("", sightline.wrong_ids, np.zeros((2, 2), np.uint32), np.zeros((2, 3), np.uint32))


if __name__ == "__main__":
    unittest.main()
