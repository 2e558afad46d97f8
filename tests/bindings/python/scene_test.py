"""Scenes: nodes, items, meshes, materials, edits; and that no misuse does more than raise sightline.Error."""

import unittest

import numpy as np
import sightline
from support import SOURCE, Case

TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 0, 1]], [[0, 1, 2]])

PRIMITIVES = [
    sightline.Pyramid(4, 4, 1, 1, 0.5, 0, 3),
    sightline.Box(1, 2, 3),
    sightline.RectangularTorus(1, 2, 0.5, 1.5),
    sightline.CircularTorus(2, 0.25, 1.5),
    sightline.EllipticalDish(1, 0.5),
    sightline.SphericalDish(1, 0.5),
    sightline.Snout(1, 0.5, 2, 0.25, 0, 0.1, 0, 0, 0),
    sightline.Cylinder(0.5, 2),
    sightline.Sphere(2),
    sightline.Line(0, 3),
]


class Nodes(Case):
    def test_tree_names_and_attributes(self):
        scene = sightline.Scene()
        site = scene.root.add_node("site")
        pipe = site.add_node("pipe", sightline.translation([1, 2, 3]))
        site.add_node()
        self.assertEqual(pipe.path, "site/pipe")
        self.assertEqual(pipe.parent, site)
        self.assertIsNone(scene.root.parent)
        self.assertEqual(pipe.part, pipe)
        self.assertIsNone(site.part, "it is taken for a file")
        self.assertEqual([child.name for child in site.children], ["pipe", ""])
        self.assertEqual(scene.node_count, 4)
        self.assertEqual(pipe.add_node().add(sightline.Sphere(1)).part, pipe)
        pipe.name = "Röhre"
        pipe.set_attribute("spec", "A1")
        pipe.set_attribute("bore", "100")
        self.assertEqual(pipe.name, "Röhre")
        self.assertEqual(pipe.attributes, {"spec": "A1", "bore": "100"})
        self.assertEqual(scene.root.find("a1"), [pipe])
        self.assertEqual(scene.root.find("a1", key="bore"), [])
        self.assertEqual(scene.root.find("site/Röhre"), [pipe])
        self.assertEqual(scene.root.find("Spec=a1"), [pipe])
        self.assertEqual(scene.root.find("name=Röhre"), [pipe])
        self.assertEqual(scene.root.find("Röh"), [])
        self.assertEqual(scene.root.find("R?hr*"), [pipe])
        self.assertEqual(scene.root.find("site/#1"), [site.children[1]])
        self.assert_error("closing parenthesis", scene.root.find, "re:(")
        self.assertIs(pipe.scene, scene)

    def test_names_that_are_no_utf8_come_back(self):
        scene = sightline.Scene()
        name = b"R\xf6hre".decode("utf-8", "surrogateescape")
        node = scene.root.add_node(name)
        self.assertEqual(node.name, name)
        self.assert_error("Röhre", scene.import_file, "Röhre.xyz")

    def test_transforms(self):
        scene = sightline.Scene()
        turn = np.array([[0.0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]])
        node = scene.root.add_node("n", turn)
        child = node.add_node("c", sightline.translation([1, 0, 0]))
        np.testing.assert_array_equal(node.transform, turn)
        np.testing.assert_array_equal(child.world_from_node, turn @ sightline.translation([1, 0, 0]))
        node.transform = np.eye(4)
        np.testing.assert_array_equal(child.world_from_node, sightline.translation([1, 0, 0]))
        np.testing.assert_array_equal(np.asfortranarray(turn), turn)
        node.transform = np.asfortranarray(turn)
        np.testing.assert_array_equal(node.transform, turn)

    def test_ids_are_reused_on_request_alone(self):
        scene = sightline.Scene()
        self.assertFalse(scene.reuse_ids)
        first = scene.root.add(sightline.Sphere(1))
        scene.commit()
        first.remove()
        scene.commit()
        second = scene.root.add(sightline.Sphere(1))
        self.assertNotEqual(second.id, first.id)
        scene.reuse_ids = True
        scene.commit()
        second.remove()
        scene.commit()
        self.assertEqual(scene.root.add(sightline.Sphere(1)).id, second.id)

    def test_reparent_and_remove(self):
        scene = sightline.Scene()
        a, b = scene.root.add_node("a"), scene.root.add_node("b")
        item = a.add(sightline.Sphere(1))
        a.reparent(b)
        self.assertEqual(a.parent, b)
        self.assert_error("", b.reparent, a)
        b.remove()
        self.assertFalse(a.alive or b.alive or item.alive)
        self.assertEqual(scene.item_count, 0)

    def test_visibility_layers_and_materials_are_inherited(self):
        scene = sightline.Scene()
        red = scene.add_material("red", (1, 0, 0), alpha=0.5, code=7)
        node = scene.root.add_node("n")
        item = node.add(sightline.Sphere(2))
        self.assertIsNone(node.material)
        node.material = red
        self.assertEqual(node.material, red)
        self.assertIsNone(item.material)
        item.material = red
        self.assertEqual((item.material.name, item.material.colour, item.material.code), ("red", (1, 0, 0), 7))
        red.colour = [0, 1, 0]
        red.alpha = 1.0
        self.assertEqual((scene.materials[0].colour, red.alpha), ((0, 1, 0), 1.0))
        red.remove()
        self.assertFalse(red.alive)
        self.assertIsNone(node.material)
        np.testing.assert_allclose(node.bounds(), [[-1, -1, -1], [1, 1, 1]])
        node.layers = 2
        self.assertIsNone(node.bounds())
        self.assertIsNotNone(node.bounds(layers=2))
        node.visible = False
        self.assertIsNone(node.bounds(layers=2))


class Items(Case):
    def test_every_primitive_comes_back(self):
        scene = sightline.Scene()
        node = scene.root.add_node("n")
        for primitive in PRIMITIVES:
            item = node.add(primitive, sightline.translation([10, 0, 0]))
            self.assertEqual(item.primitive, primitive)
            self.assertEqual(item.kind, primitive.kind)
            self.assertIn(item.kind, sightline.KINDS)
            self.assertIsNone(item.mesh)
            np.testing.assert_array_equal(item.bounds, primitive.bounds(sightline.translation([10, 0, 0])))
            self.assertEqual(type(primitive)(*map(float, primitive.parameters)), primitive)
        self.assertEqual(len({p.kind for p in PRIMITIVES}), 10)
        np.testing.assert_array_equal(node.items, np.arange(10, dtype=np.uint32))
        self.assertEqual(len(scene.commit().inserted), 10)

    def test_many_at_once_are_the_same_as_one_by_one(self):
        random = np.random.default_rng(5)
        sizes = random.uniform(0.1, 2.0, (50, 2))
        places = np.tile(np.eye(4), (50, 1, 1))
        places[:, :3, 3] = random.uniform(-50, 50, (50, 3))
        scene = sightline.Scene()
        ids = scene.root.add_node("many").add_primitives("cylinder", sizes, places)
        one_by_one = scene.root.add_node("one")
        for size, place, many in zip(sizes, places, ids):
            one = one_by_one.add(sightline.Cylinder(*size), place)
            self.assertEqual(one.primitive, scene.item(many).primitive)
            np.testing.assert_array_equal(one.placement, scene.item(many).placement)

    def test_edits_and_commits(self):
        scene = sightline.Scene()
        node = scene.root.add_node("n")
        first, second = node.add(sightline.Sphere(1)), node.add(sightline.Sphere(1))
        scene.commit()
        first.placement = sightline.translation([0, 0, 9])
        second.remove()
        delta = scene.commit()
        self.assertEqual((list(delta.changed), list(delta.removed), len(delta)), ([first.id], [1], 2))
        self.assertEqual(int(first), first.id)
        self.assertEqual([10, 20][first], 10)
        first.visible = False
        self.assertFalse(first.visible)

    def test_a_commit_is_all_or_nothing(self):
        scene = sightline.Scene()
        scene.root.add_node("bad").add(sightline.Sphere(float("nan")))
        self.assert_error("bad", scene.commit)


class Meshes(Case):
    def test_arrays_come_back_as_views(self):
        scene = sightline.Scene()
        random = np.random.default_rng(3)
        positions = random.uniform(-1, 1, (20, 3)).astype(np.float32)
        indices = random.integers(0, 20, (30, 3))
        mesh = scene.add_mesh(positions, indices, normals=positions, name="blob")
        np.testing.assert_array_equal(mesh.positions, positions)
        np.testing.assert_array_equal(mesh.normals, positions)
        np.testing.assert_array_equal(mesh.indices, indices)
        self.assertEqual(mesh.name, "blob")
        self.assertEqual((mesh.positions.dtype, mesh.indices.dtype), (np.float32, np.uint32))
        self.assertEqual(mesh.positions.ctypes.data, mesh.positions.ctypes.data, "no copy is made")
        self.assertFalse(mesh.positions.flags.owndata or mesh.positions.flags.writeable)
        item = scene.root.add(mesh)
        self.assertEqual((item.kind, item.mesh), ("mesh", mesh))
        self.assertIsNone(item.primitive)

    def test_a_mesh_in_use_stays(self):
        scene = sightline.Scene()
        mesh = scene.add_mesh(*TRIANGLE)
        item = scene.root.add(mesh)
        self.assert_error("item 0 still uses it", mesh.remove)
        item.remove()
        positions = mesh.positions
        self.assert_error("arrays still look into it", mesh.remove)
        self.assertEqual(positions[1, 0], 1)
        del positions
        mesh.remove()
        self.assertFalse(mesh.alive)
        self.assert_error("removed", lambda: mesh.positions)

    def test_faces_of_step_have_their_surface(self):
        scene = sightline.Scene()
        own = scene.add_mesh(*TRIANGLE)
        self.assertIsNone(own.surface(0))
        self.assert_error("fewer", own.surface, 1)
        self.assertRaises(TypeError, own.surface, -1)
        if ".stp" not in sightline.known_extensions():
            self.skipTest("built without STEP")
        scene.import_file(SOURCE / "tests" / "data" / "machined.stp")
        mesh = [one for one in scene.meshes if one != own][0]
        found = [mesh.surface(i) for i in range(len(mesh.indices))]
        self.assertEqual({s["kind"] for s in found}, {"plane", "cylinder", "cone", "sphere", "torus"})
        holes = [s for s in found if s["kind"] == "cylinder"]
        self.assertEqual({round(s["radius"], 9) for s in holes}, {3.0, 4.0})
        self.assertAlmostEqual(abs(holes[0]["axis"][2]), 1.0)
        cone = [s for s in found if s["kind"] == "cone"][0]
        self.assertAlmostEqual(abs(cone["slope"]), 1.0)

    def test_broken_meshes_are_refused(self):
        scene = sightline.Scene()
        self.assert_error("3", scene.add_mesh, TRIANGLE[0], [[0, 1, 3]])
        self.assert_error("-1", scene.add_mesh, TRIANGLE[0], [[0, 1, -1]])
        self.assert_error("indices: expected whole numbers", scene.add_mesh, TRIANGLE[0], [[0.0, 1, 2]])
        self.assert_error("normal", scene.add_mesh, *TRIANGLE, [[0, 0, 1]])
        self.assertEqual(scene.meshes, [])


class Misuse(Case):
    def test_wrong_arrays_say_what_was_expected(self):
        scene = sightline.Scene()
        node = scene.root.add_node("n")
        self.assert_error("transform: expected numbers of shape (4, 4), found float64 of shape (3, 3)", setattr, node,
                          "transform", np.eye(3))
        self.assert_error("transform: expected 0 0 0 1 as the last row", setattr, node, "transform", np.ones((4, 4)))
        self.assert_error("<U1", setattr, node, "transform", [list("abcd")] * 4)
        self.assert_error("transform: expected numbers of shape (4, 4), found complex128", setattr, node, "transform",
                          np.eye(4) * 1j)
        self.assert_error("placements: expected numbers of shape (2, 4, 4)", node.add_primitives, "sphere", [[1], [2]],
                          np.eye(4))
        self.assert_error("parameters: expected numbers of shape (N, 1)", node.add_primitives, "sphere", [1, 2])
        self.assert_error('found "mesh"', node.add_primitives, "mesh", [[1.0]])
        self.assert_error("colour", scene.add_material, "m", (1, 2))
        self.assertEqual(scene.item_count, 0)

    def test_ragged_lists_are_refused(self):
        scene = sightline.Scene()
        with self.assertRaises((sightline.Error, ValueError)):
            scene.root.add_primitives("sphere", [[1], [2, 3]])

    def test_other_types_are_type_errors(self):
        scene = sightline.Scene()
        for wrong in (None, 3, "node", object()):
            with self.assertRaises(TypeError):
                scene.root.add(wrong)
        with self.assertRaises(TypeError):
            sightline.Cylinder("a", 1)
        with self.assertRaises(TypeError):
            scene.root.name = 3

    def test_stale_handles(self):
        scene = sightline.Scene()
        node = scene.root.add_node("n")
        item = node.add(sightline.Sphere(1))
        material = scene.add_material("m")
        mesh = scene.add_mesh(*TRIANGLE)
        node.remove()
        material.remove()
        mesh.remove()
        for stale in (node, item, material, mesh):
            self.assertFalse(stale.alive)
            for name in dir(type(stale)):
                if name.startswith("_") or name in ("alive", "scene", "id"):
                    continue
                with self.subTest(type=type(stale).__name__, name=name):
                    def use():
                        value = getattr(stale, name)
                        if name in ("add", "reparent"):
                            value(sightline.Sphere(1) if name == "add" else scene.root)
                        elif name == "add_primitives":
                            value("sphere", [[1.0]])
                        elif name == "find":
                            value("x")
                        elif name == "set_attribute":
                            value("k", "v")
                        elif name == "surface":
                            value(0)
                        elif callable(value):
                            value()
                    self.assert_error("it has been removed from its scene", use)
        for stale, name, value in ((node, "name", ""), (node, "visible", True), (node, "layers", 1),
                                   (node, "material", None), (node, "transform", np.eye(4)), (item, "visible", True),
                                   (item, "placement", np.eye(4)), (item, "material", None), (material, "alpha", 1.0),
                                   (material, "name", ""), (material, "code", 1), (material, "colour", (0, 0, 0))):
            self.assert_error("it has been removed", setattr, stale, name, value)
        other = scene.root.add(sightline.Sphere(1))
        self.assert_error("it has been removed", setattr, other, "material", material)
        self.assert_error("it has been removed", scene.root.add, mesh)
        self.assert_error("none with id 0", scene.item, 0)
        self.assertIn("removed", repr(node))

    def test_the_root_stays(self):
        scene = sightline.Scene()
        self.assert_error("the root stays", scene.root.remove)
        self.assert_error("the root stays", scene.root.reparent, scene.root)

    def test_other_scenes_objects(self):
        scene, other = sightline.Scene(), sightline.Scene()
        self.assert_error("another scene", scene.root.add, other.add_mesh(*TRIANGLE))
        self.assert_error("another scene", scene.root.add, sightline.Sphere(1), None, other.add_material())
        self.assert_error("another scene", scene.root.add_node().reparent, other.root)
        self.assert_error("another scene", scene.import_file, "a.rvm", other.root)
        self.assertNotEqual(scene.root, other.root)

    def test_plants_of_wrong_size(self):
        self.assert_error("items", sightline.Scene().generate_plant, 7)
        with self.assertRaises(TypeError):
            sightline.Scene().generate_plant(-1)


if __name__ == "__main__":
    unittest.main()
