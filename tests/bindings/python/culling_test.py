"""Culling of boxes without a scene, against numpy."""

import unittest

import numpy as np
import sightline
from support import Case, box_rows

VIEW = sightline.View.perspective((0, -150, 30), (0, 0, 0), fovy=0.6, aspect=1.5, near=1, far=300)


def brute_force(rows, clip_from_world):
    """Boxes that no plane of the frustum has wholly outside, with the margins of the planes."""
    x, y, z, w = clip_from_world
    margins = []
    for plane in (w + x, w - x, w + y, w - y, w - z, z):  # reversed depth: near at 1, far at 0
        corner = np.where(plane[:3] >= 0, rows[:, 3:], rows[:, :3])
        margins.append((corner @ plane[:3] + plane[3]) / np.linalg.norm(plane[:3]))
    return np.min(margins, axis=0)


class Culling(Case):
    def check(self, visible, rows):
        margin = brute_force(rows, VIEW.clip_from_world)
        got = np.zeros(len(rows), dtype=bool)
        got[visible] = True
        self.assertTrue(got[margin >= 0].all(), "a visible box is missing")
        self.assertFalse(got[margin < -1e-3].any(), "a box far outside is reported")
        self.assertEqual(len(visible), len(set(visible.tolist())))

    def test_against_numpy(self):
        rows = box_rows(20000, seed=11)
        culler = sightline.BoxCuller(rows)
        self.assertEqual(len(culler), 20000)
        visible = culler.visible(VIEW)
        self.assertEqual(visible.dtype, np.uint32)
        self.assertTrue(0 < len(visible) < 20000)
        self.check(visible, rows)
        np.testing.assert_array_equal(culler.visible(VIEW.clip_from_world), visible)

    def test_layouts_do_not_matter(self):
        rows = box_rows(500).astype(np.float32)
        expected = sightline.BoxCuller(rows.astype(np.float64)).visible(VIEW)
        wide = np.zeros((500, 8))
        wide[:, 1:7] = rows
        packed = np.zeros(500 * 48 + 1, dtype=np.uint8)
        unaligned = packed[1:].view(np.float64).reshape(500, 6)
        unaligned[:] = rows
        for layout in (rows, np.asfortranarray(rows), wide[:, 1:7], unaligned, rows.astype(">f8"), rows.tolist()):
            np.testing.assert_array_equal(sightline.BoxCuller(layout).visible(VIEW), expected)

    def test_classic_depth(self):
        rows = box_rows(5000, seed=2)
        to_classic = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -2, 1], [0, 0, 0, 1.0]])
        classic = sightline.BoxCuller(rows).visible(to_classic @ VIEW.clip_from_world, depth="classic")
        self.check(classic, rows)

    def test_sections_count(self):
        rows = box_rows(5000, seed=4)
        culler = sightline.BoxCuller(rows)
        view = sightline.View.from_matrices(VIEW.eye_from_world, VIEW.clip_from_eye)
        view.sections = [[0, 0, 1, 0]]
        kept = culler.visible(view)
        np.testing.assert_array_equal(np.sort(kept), np.sort([i for i in culler.visible(VIEW) if rows[i, 5] >= 0]))

    def test_queries(self):
        rows = box_rows(5000, seed=12)
        culler = sightline.BoxCuller(rows)
        low, high = np.array([-40, -40, -10.0]), np.array([60, 50, 40.0])
        box = np.concatenate([low, high])
        touching = np.flatnonzero((rows[:, :3] <= high).all(axis=1) & (rows[:, 3:] >= low).all(axis=1))
        within = np.flatnonzero((rows[:, :3] >= low).all(axis=1) & (rows[:, 3:] <= high).all(axis=1))
        self.assertGreater(len(touching), len(within))
        np.testing.assert_array_equal(culler.in_box(box), touching)
        self.assertLessEqual(set(culler.in_box(box, inside=True)), set(within))
        point = np.array([5.0, -3, 2])
        distances = np.linalg.norm(np.clip(point, rows[:, :3], rows[:, 3:]) - point, axis=1)
        np.testing.assert_array_equal(culler.around(point, 30), np.flatnonzero(distances <= 30))
        nearest = culler.nearest(point, 7)
        np.testing.assert_allclose(nearest["distance"], np.sort(distances)[:7], atol=1e-4)
        np.testing.assert_allclose(distances[nearest["index"]], nearest["distance"], atol=1e-4)
        self.assertEqual(len(culler.nearest(point)), 1)
        hits = culler.along(rows[3, :3], (0, 0, 1))
        self.assertIn(3, hits["index"])
        self.assertTrue((np.diff(hits["distance"]) >= 0).all())
        np.testing.assert_array_equal(culler.along(rows[3, :3], (0, 0, 1), count=1), hits[:1])
        self.assert_error("box", culler.in_box, (1, 2))

    def test_updates(self):
        culler = sightline.BoxCuller([[0, 0, 0, 1, 1, 1], [1, 1, 1, 0, 0, 0]])
        self.assertEqual(list(culler.visible(VIEW)), [0])
        culler.update(0, [900, 0, 0, 901, 1, 1])
        culler.update(1, [0, 0, 0, 1, 1, 1])
        self.assertEqual(list(culler.visible(VIEW)), [1])
        self.assert_error("index: expected less than 2, found 2", culler.update, 2, [0, 0, 0, 1, 1, 1])
        self.assert_error("", culler.update, 0, [np.nan, 0, 0, 1, 1, 1])
        self.assert_error("box: expected numbers of shape (6,)", culler.update, 0, [[0, 0, 0, 1, 1, 1]])

    def test_updates_of_many(self):
        rows = box_rows(20000, seed=12)
        culler = sightline.BoxCuller(rows)
        random = np.random.default_rng(13)
        for dtype in (np.uint32, np.int64):
            indices = random.integers(0, len(rows), 5000).astype(dtype)  # some of them twice
            boxes = box_rows(5000, seed=14) + 7
            culler.update(indices, boxes)
            for index, box in zip(indices, boxes):
                rows[index] = box
            self.check(culler.visible(VIEW), rows)
        culler.update(np.zeros(0, dtype=np.uint32), np.zeros((0, 6)))
        for index in ([3], (3,), np.array([3])):
            culler.update(index, [[0, 0, 0, 1, 1, 1]])
            self.assertIn(3, culler.visible(VIEW))
        culler.update(np.int64(3), [900, 0, 0, 901, 1, 1])
        self.assertNotIn(3, culler.visible(VIEW))
        rows = rows[::-1].copy()
        culler.refit(rows)
        self.check(culler.visible(VIEW), rows)
        np.testing.assert_array_equal(np.sort(culler.visible(VIEW)), np.sort(sightline.BoxCuller(rows).visible(VIEW)))

    def test_refused_updates_change_nothing(self):
        rows = box_rows(1000, seed=15)
        culler = sightline.BoxCuller(rows)
        before = culler.visible(VIEW)
        moved = np.tile([9000.0, 0, 0, 9001, 1, 1], (1000, 1))
        moved[998, 2] = np.nan
        indices = np.arange(1000)
        self.assert_error("box 998: expected finite corners", culler.update, indices, moved)
        self.assert_error("box 998: expected finite corners", culler.refit, moved)
        self.assert_error("boxes: expected numbers of shape (999, 6)", culler.update, indices[1:], moved)
        self.assert_error("boxes: expected numbers of shape (1000, 6)", culler.refit, moved[1:])
        self.assert_error("indices: expected less than 1000, found 1000", culler.update, indices + 1, moved)
        self.assert_error("indices: expected whole numbers from 0 to 4294967295, found -1", culler.update, indices - 1,
                          moved)
        self.assert_error("indices", culler.update, indices * 1.0, moved)
        np.testing.assert_array_equal(culler.visible(VIEW), before)

    def test_misuse(self):
        self.assert_error("boxes: expected numbers of shape (N, 6), found float64 of shape (3, 4)", sightline.BoxCuller,
                          np.zeros((3, 4)))
        self.assert_error("boxes: expected numbers of shape (N, 6), found object", sightline.BoxCuller,
                          np.zeros((3, 6), dtype=object))
        rows = box_rows(3)
        rows[1, 5] = np.inf
        self.assert_error("1", sightline.BoxCuller, rows)
        culler = sightline.BoxCuller(np.zeros((0, 6)))
        self.assertEqual(len(culler.visible(VIEW)), 0)
        self.assert_error("finite", culler.visible, np.full((4, 4), np.nan))



class Occluders(Case):
    def setUp(self):
        super().setUp()
        self.view = sightline.View.perspective((0, -90, 5), (0, 0, 0), fovy=0.8, aspect=1.6)
        self.rows = box_rows(20_000)
        self.culler = sightline.BoxCuller(self.rows)
        self.raster = sightline.OccluderRaster()

    def test_a_wall_hides_what_lies_behind_it(self):
        everything = set(self.culler.visible(self.view))
        self.raster.begin(self.view, 320, 200)
        self.assertEqual(self.raster.add_largest([[-60, -31, -60, 60, -30, 60]]), 1)
        seen = set(self.culler.visible(self.view, self.raster))
        self.assertTrue(seen < everything)
        for i in everything - seen:
            self.assertGreater(self.rows[i, 4], -31, "no box wholly before the wall is hidden, but for the smallest")
        before = [i for i in everything if self.rows[i, 4] < -32 and (self.rows[i, 3:] - self.rows[i, :3]).min() > 1]
        self.assertLessEqual(set(before), seen)
        distances = self.raster.distances()
        self.assertEqual((distances.shape, distances.dtype), ((200, 320), np.float32))
        np.testing.assert_allclose(distances[100, 160], 59, rtol=0.02)
        np.testing.assert_array_equal(self.culler.visible(self.view, distances), self.culler.visible(self.view, self.raster))

    def test_all_kinds_of_occluders(self):
        hidden = {}
        placement = sightline.translation([0, -40, 0]) @ np.diag([20, 1, 20, 1])
        corners, triangles = [[-20, -40, -20], [20, -40, -20], [20, -40, 20], [-20, -40, 20]], [[0, 1, 2], [0, 2, 3]]
        for name, add in (("cube", lambda: self.raster.add_cube(placement)),
                          ("cylinder", lambda: self.raster.add_cylinder(placement, sides=16)),
                          ("mesh", lambda: self.raster.add_mesh(corners, triangles)),
                          ("moved mesh", lambda: self.raster.add_mesh(np.array(corners) + [0, 0, 7], triangles,
                                                                      sightline.translation([0, 0, -7])))):
            self.raster.begin(self.view, 320, 200)
            self.assertIn(add(), (None, True))
            hidden[name] = len(self.culler.visible(self.view)) - len(self.culler.visible(self.view, self.raster))
            self.assertTrue(np.isfinite(self.raster.distances()).any(), name)
        self.assertGreater(hidden["cylinder"], 100)
        self.assertEqual(hidden["mesh"], hidden["moved mesh"])
        self.assertGreater(hidden["cube"], hidden["cylinder"])
        self.raster.begin(self.view, 320, 200)
        behind_the_eye = sightline.translation([0, -200, 0])
        self.assertFalse(self.raster.add_cube(behind_the_eye))

    def test_rows_run_from_the_top(self):
        self.raster.begin(self.view, 32, 20)
        self.raster.add_largest([[-60, -31, 10, 60, -30, 60]])
        distances = self.raster.distances()
        self.assertTrue(np.isfinite(distances[0, 5:27]).all() and np.isinf(distances[-1]).all())

    def test_bad_arguments(self):
        self.assert_error("begin() first", self.raster.distances)
        self.assert_error("begin() first", self.raster.add_cube, np.eye(4))
        self.assert_error("begin() first", self.culler.visible, self.view, self.raster)
        self.assert_error("1 to 16384 pixels, found 0 and 3", self.raster.begin, self.view, 0, 3)
        self.raster.begin(self.view, 32, 20)
        self.assert_error("sides: expected 3 to 16, found 2", self.raster.add_cylinder, np.eye(4), 2)
        self.assert_error("boxes: expected numbers of shape (N, 6)", self.raster.add_largest, [1, 2])
        self.assert_error("less than 1, found 1", self.raster.add_mesh, [[0, 0, 0]], [[0, 0, 1]])
        self.assert_error("0 0 0 1", self.raster.add_cube, np.ones((4, 4)))
        self.assert_error("occluders: expected numbers", self.culler.visible, self.view, 3)
        self.assert_error("1 to 16384 pixels", self.culler.visible, self.view, np.zeros((0, 3)))


if __name__ == "__main__":
    unittest.main()
