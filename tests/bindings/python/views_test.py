"""Views and camera paths."""

import copy
import math
import pickle
import unittest

import numpy as np
import sightline
from sightline import CameraPath, View
from support import Case

EYE, TARGET = (10, -20, 5), (0, 0, 0)


class Views(Case):
    def test_a_perspective_view_projects_its_target_to_the_middle(self):
        view = View.perspective(EYE, TARGET, fovy=1.0, aspect=2.0, near=0.5)
        x, y, z, w = view.clip_from_world @ [0, 0, 0, 1]
        np.testing.assert_allclose([x / w, y / w], [0, 0], atol=1e-12)
        np.testing.assert_allclose(z / w, 0.5 / np.linalg.norm(EYE))
        np.testing.assert_allclose(view.eye, EYE)
        np.testing.assert_array_equal(view.clip_from_world, view.clip_from_eye @ view.eye_from_world)
        np.testing.assert_allclose(view.clip_from_eye[1, 1], 1 / math.tan(0.5))
        self.assertFalse(view.is_orthographic)

    def test_other_projections(self):
        ortho = View.orthographic(EYE, TARGET, height=10, aspect=1.5, near=-100, far=100)
        self.assertTrue(ortho.is_orthographic)
        half = math.tan(0.5)
        self.assertEqual(View.asymmetric(EYE, TARGET, left=-half, right=half, bottom=-half, top=half, near=1.0),
                         View.perspective(EYE, TARGET, fovy=1.0, aspect=1.0, near=1.0))
        fitted = View.fit([[-1, -1, -1], [1, 1, 1]], (0, 1, 0), aspect=1.0)
        corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1], [1])).reshape(4, 8)
        clip = fitted.clip_from_world @ corners
        self.assertLessEqual(np.abs(clip[:2] / clip[3]).max(), 1 + 1e-9)

    def test_matrices_come_back(self):
        view = View.perspective(EYE, TARGET, fovy=1.0, aspect=2.0)
        self.assertEqual(View.from_matrices(view.eye_from_world, view.clip_from_eye), view)
        self.assert_error("depth: expected reversed, classic or zero_to_one", View.from_matrices, np.eye(4), np.eye(4),
                          depth="x")

    def test_depths(self):
        view = View.perspective(EYE, TARGET, fovy=1.0, aspect=2.0)
        plain = view.clip_from_eye
        plain[2] = plain[3] - plain[2]
        same = View.from_matrices(view.eye_from_world, plain, depth="zero_to_one")
        self.assertEqual(copy.deepcopy(same), same)
        self.assertEqual(pickle.loads(pickle.dumps(same)), same)
        culler = sightline.BoxCuller(np.random.default_rng(1).uniform(-20, 20, (500, 3)).repeat(2, 0).reshape(500, 6))
        np.testing.assert_array_equal(culler.visible(same), culler.visible(view))
        np.testing.assert_array_equal(culler.visible(same.clip_from_world, depth="zero_to_one"), culler.visible(view))
        self.assert_error("depth grows with distance", View.from_matrices, view.eye_from_world, plain)
        self.assert_error("depth grows with distance", culler.visible, same.clip_from_world)

    def test_sections(self):
        view = View.perspective(EYE, TARGET, fovy=1.0, aspect=2.0)
        self.assertEqual(view.sections.shape, (0, 4))
        view.sections = [[0, 0, 1, -2]]
        view.section_mode = "union"
        twin = copy.deepcopy(view)
        np.testing.assert_array_equal(twin.sections, [[0, 0, 1, -2]])
        self.assertEqual((twin.section_mode, twin), ("union", view))
        twin.layers = 2
        self.assertNotEqual(twin, view)
        self.assert_error("at most 8 planes, found 9", setattr, view, "sections", np.ones((9, 4)))
        self.assert_error("finite", setattr, view, "sections", [[0, 0, np.nan, 1]])
        self.assert_error("shape (N, 4)", setattr, view, "sections", [0, 0, 1, 2])
        self.assert_error("intersection or union", setattr, view, "section_mode", "x")

    def test_bad_numbers(self):
        for bad in (dict(fovy=0), dict(fovy=4), dict(aspect=-1), dict(near=0), dict(near=5, far=1), dict(aspect=math.nan)):
            with self.subTest(**bad), self.assertRaises(sightline.Error):
                View.perspective(EYE, TARGET, **{"fovy": 1.0, "aspect": 1.0, **bad})
        with self.assertRaises(sightline.Error):
            View.perspective(EYE, EYE, fovy=1, aspect=1)
        self.assert_error("eye: expected numbers of shape (3,), found int64 of shape (2,)", View.perspective, (1, 2),
                          TARGET, fovy=1, aspect=1)
        self.assert_error("eye", View.perspective, None, TARGET, fovy=1, aspect=1)

    def test_json(self):
        text = '{"eye":[10,-20,5],"target":[0,0,0],"fovy_deg":57.29577951308232,"near":0.5}'
        self.assertEqual(View.parse(text, aspect=1.5), View.perspective(EYE, TARGET, fovy=1.0, aspect=1.5, near=0.5))
        (self.folder / "view.json").write_text(text)
        self.assertEqual(View.read(self.folder / "view.json", aspect=1.5), View.parse(text, aspect=1.5))
        self.assert_error("expected", View.parse, "{}", aspect=1.0)


class Paths(Case):
    def path(self):
        return CameraPath([0, 2, 5], [[0, 0, 0], [1, 0, 0], [2, 1, 0]], [[0, 9, 0]] * 3, fovys=[1, 1.1, 1])

    def test_keys_come_back(self):
        path = self.path()
        np.testing.assert_array_equal(path.times, [0, 2, 5])
        np.testing.assert_array_equal(path.eyes, [[0, 0, 0], [1, 0, 0], [2, 1, 0]])
        np.testing.assert_array_equal(path.targets, [[0, 9, 0]] * 3)
        np.testing.assert_array_equal(path.ups, [[0, 0, 1]] * 3)
        np.testing.assert_array_equal(path.fovys, [1, 1.1, 1])
        self.assertEqual((path.begin, path.end), (0, 5))

    def test_views_between_keys(self):
        path = self.path()
        self.assertEqual(path.time_of(0, 11), 0)
        self.assertEqual(path.time_of(10, 11), 5)
        np.testing.assert_allclose(path.view(2, aspect=1.5).eye, [1, 0, 0], atol=1e-12)
        self.assert_error("frame: expected 0 to frames - 1, found 3 of 3", path.time_of, 3, 3)

    def test_files(self):
        path = self.path()
        path.near = 0.25
        path.write(self.folder / "path.json")
        again = CameraPath.read(self.folder / "path.json")
        np.testing.assert_array_equal(again.eyes, path.eyes)
        self.assertEqual(again.near, 0.25)
        self.assertEqual(CameraPath.parse(path.format()).format(), path.format())

    def test_bad_keys(self):
        self.assert_error("1", CameraPath, [0, -1], [[0, 0, 0], [1, 0, 0]], [[0, 9, 0]] * 2)
        self.assert_error("eyes: expected numbers of shape (2, 3)", CameraPath, [0, 1], [[0, 0, 0]], [[0, 9, 0]] * 2)
        self.assert_error("key", CameraPath, [], np.zeros((0, 3)), np.zeros((0, 3)))


if __name__ == "__main__":
    unittest.main()
