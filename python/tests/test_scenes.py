"""Scenes: what can be added, what is refused, what they are as text."""

from __future__ import annotations

import math
import pickle
import warnings
from datetime import datetime, timezone

import numpy as np
import pytest
from conftest import FRONT, SQUARE, lit, render

import raggio as rg


def test_meshes_of_arrays() -> None:
    """A square that faces the camera, in light of radiance 1, has its material's colour."""
    scene = lit()
    scene.add(SQUARE, material=rg.Material(color=(0.2, 0.4, 0.6)), name="square", id=7)
    image = render(scene, FRONT, size=(16, 16), samples=64, aovs=("object_id", "depth"))
    np.testing.assert_allclose(np.asarray(image)[8, 8], [0.2, 0.4, 0.6], rtol=2e-2)
    assert image["object_id"][8, 8] == 7
    np.testing.assert_allclose(image["depth"][8, 8], 4, rtol=1e-5)


def test_kinds_of_arrays() -> None:
    vertices, faces = SQUARE
    for kind in (vertices, vertices.astype(np.float64), vertices.tolist(), np.asfortranarray(vertices), vertices[::1]):
        scene = lit()
        scene.add((kind, faces.astype(np.int64)))
        assert render(scene, FRONT, size=(4, 4), samples=1, aovs="object_id")["object_id"][2, 2] == 1


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        ((np.zeros((3, 2)), [[0, 1, 2]]), "vertices is of shape"),
        ((np.zeros((3, 3)), [[0, 1]]), "faces is of shape"),
        ((np.zeros((3, 3)), [[0, 1, 3]]), "faces names vertex 3: with 3 vertices"),
        ((np.zeros((3, 3)), [[0, 1, -1]]), "faces names vertex -1"),
        ((np.zeros((3, 3)), [[0.0, 1.0, 2.0]]), "whole numbers"),
        ((np.zeros((3, 3)), [[0, 1, 2]]), "no triangles with an area"),
        ((np.full((3, 3), np.nan), [[0, 1, 2]]), "no triangles with an area"),
    ],
)
def test_meshes_that_are_wrong(mesh, words: str) -> None:
    scene = lit()
    with pytest.raises(ValueError, match=words):
        scene.add(mesh)
    assert scene == lit()


def test_what_is_no_mesh() -> None:
    with pytest.raises(TypeError, match="int is no mesh: give"):
        rg.Scene().add(3)
    with pytest.raises(ValueError, match="a shape that is no mesh keeps its form"):
        rg.Scene().add(rg.Sphere((0, 0, 0), 1), transform=np.diag([1, 2, 1, 1]))
    with pytest.raises(TypeError, match="a group is of shapes such as Sphere or Box, not of Mesh"):
        rg.Group([(rg.Mesh(*SQUARE), rg.Material())])
    with pytest.raises(ValueError, match="radius"):
        rg.Scene().add(rg.Sphere((0, 0, 0), -1))
    with pytest.raises(ValueError, match="transform is of shape"):
        rg.Scene().add(SQUARE, transform=np.eye(3))
    with pytest.raises(ValueError, match="determinant is 0"):
        rg.Scene().add(SQUARE, transform=np.diag([1, 1, 0, 1]))
    with pytest.raises(ValueError, match="the scene has no material 'clay'"):
        rg.Scene().add(rg.Sphere((0, 0, 0), 1), material="clay")


def test_what_fails_leaves_nothing() -> None:
    scene = lit()
    color = rg.Material(color=(0.1, 0.2, 0.3))
    with pytest.raises(ValueError, match="0 is the background"):
        scene.add(rg.Sphere((0, 0, 0), 1), material=color, id=0)
    with pytest.raises(ValueError, match="emission_strength"):
        scene.add(rg.Sphere((0, 0, 0), 1), material=rg.Material(emission_strength=-1))

    class Group:
        """A scene like those of trimesh, whose second mesh is at fault."""

        class graph(dict):  # noqa: N801
            nodes_geometry = ("one", "two")

        graph = graph(one=(np.eye(4), "good"), two=(np.eye(4), "bad"))  # type: ignore[assignment]
        geometry = {"good": rg.Mesh(*SQUARE), "bad": rg.Mesh(np.zeros((3, 3)), [[0, 1, 2]])}

    with pytest.raises(rg.SceneError, match="no triangles with an area"):
        scene.add(Group(), material=color)
    assert scene == lit() and not scene.objects and not scene.materials


def test_degenerate_faces_are_a_warning() -> None:
    vertices, faces = SQUARE
    with pytest.warns(rg.SceneWarning, match="1 face without area was left out"):
        lit().add((vertices, np.vstack([faces, [[0, 0, 1]]])))


def test_instances_are_held_once() -> None:
    mesh = rg.Mesh(*SQUARE)
    scene = lit()
    for place in range(20):
        move = np.eye(4)
        move[0, 3] = place
        scene.add(mesh, transform=move)
    assert len(scene._text.text().split("memory:")) == 21 and len(scene._meshes) == 1
    image = render(scene, rg.Camera.look_at((10, 0, 30), (10, 0, 0)), size=(64, 16), samples=1, aovs="object_id")
    assert len(np.unique(image["object_id"])) > 10


def test_textures_and_environments_of_arrays() -> None:
    """The first quadrant of an image lies at its upper left, and light has its directions."""
    vertices, faces = SQUARE
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    picture = np.zeros((2, 2, 3), dtype=np.uint8)
    picture[0, 0], picture[1, 1] = (255, 0, 0), (0, 255, 0)
    texture = rg.Texture(image=picture, filter="nearest", wrap="clamp_to_edge")
    scene = lit()
    scene.add(rg.Mesh(vertices, faces, uvs=uvs), material=rg.Principled(base_color_texture=texture, specular=0))
    albedo = render(scene, FRONT, size=(64, 64), samples=4, aovs="albedo")["albedo"]
    np.testing.assert_allclose(albedo[24, 24], [1, 0, 0], atol=1e-3)
    np.testing.assert_allclose(albedo[40, 40], [0, 1, 0], atol=1e-3)
    # The middle of the image is seen along -Z, its right along +X.
    sky = np.zeros((4, 8, 3), dtype=np.float32)
    sky[:, 4:] = 5
    scene = rg.Scene()
    scene.environment = rg.Environment(image=sky)
    pixels = np.asarray(render(scene, FRONT, size=(16, 8), samples=16))
    assert pixels[:, 12:].min() > 4 and pixels[:, :4].max() < 1
    scene.environment = rg.Environment(image=sky, rotation_degrees=180)
    pixels = np.asarray(render(scene, FRONT, size=(16, 8), samples=16))
    assert pixels[:, :4].min() > 4 and pixels[:, 12:].max() < 1


def test_a_sky_by_day() -> None:
    """The sun stands where the place and the time say, and its sky is read back as it was given."""
    scene = rg.Scene()
    noon = datetime(2026, 6, 21, 12, 0, tzinfo=timezone.utc)
    day = rg.Environment(latitude_degrees=0, longitude_degrees=0, time=noon, turbidity=2)
    scene.environment = day
    assert scene.environment == day
    # The sun is 66.5 degrees high in the north, which is along -Z.
    pixels = np.asarray(render(scene, FRONT, size=(16, 16), samples=16))
    behind = rg.Environment(sun_direction=(0, math.sin(math.radians(66.5)), math.cos(math.radians(66.5))), turbidity=2)
    scene.environment = behind
    away = np.asarray(render(scene, FRONT, size=(16, 16), samples=16))
    assert pixels[2, :, :3].mean() > 1.1 * away[2, :, :3].mean()
    with pytest.raises(rg.SceneError, match="with its offset"):
        scene.environment = rg.Environment(latitude_degrees=0, longitude_degrees=0, time=datetime(2026, 6, 21))


def test_environments_that_are_wrong() -> None:
    scene = lit()
    with pytest.raises(rg.SceneError, match="needs `zenith`"):
        scene.environment = rg.Environment(horizon=(1, 1, 1))
    with pytest.raises(ValueError, match="at row 1, column 2"):
        image = np.ones((3, 4, 3), dtype=np.float32)
        image[1, 2, 0] = np.nan
        scene.environment = rg.Environment(image=image)
    with pytest.raises(ValueError, match="the image is of shape"):
        scene.environment = rg.Environment(image=np.ones((3, 4)))
    assert scene == lit()


def test_colors() -> None:
    """A colour is the same in each of the ways to write it."""
    linear = np.array([1, 0.5 / 255 / 12.92 * 2, ((136 / 255 + 0.055) / 1.055) ** 2.4])
    for color in (linear, linear.tolist(), "#ff0188", {"srgb": (1, 1 / 255, 136 / 255)}):
        scene = lit()
        scene.add(SQUARE, material=rg.Material(color=color))
        assert scene.materials["material-1"] == rg.Material(color=color)
        albedo = render(scene, FRONT, size=(8, 8), samples=4, aovs="albedo")["albedo"]
        np.testing.assert_allclose(albedo[4, 4], linear, rtol=1e-5)
    with pytest.raises(ValueError, match="must be a colour"):
        scene.add(SQUARE, material=rg.Material(color="orange"))


def test_shapes_and_groups_that_are_placed() -> None:
    """What is seen is where the transforms take it."""
    clay, moss = rg.Material(color=(0.8, 0.2, 0.1)), rg.Material(color=(0.1, 0.6, 0.2))
    group = rg.Group([(rg.Disk((0, 0, 0), (0, 0, 1), 0.5), clay), (rg.Cylinder((1, -1, 0), (1, 1, 0), 0.2), moss)])
    scene = lit()
    turn = np.array([[0, -1, 0, -1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    first = scene.add(group, transform=turn, name="turned")
    second = scene.add(group, material=moss, transform=np.diag([0.5, 0.5, 0.5, 1]))
    down = np.eye(4)
    down[1, 3] = -1.2
    cone = scene.add(rg.Cone((0, 0, 0), (0, 1, 0), 0.3), transform=down)
    assert scene._text.text().count("group-1") == 3
    image = render(scene, FRONT, size=(128, 128), samples=4, aovs=("object_id", "albedo"))
    ids, albedo = image["object_id"], image["albedo"]
    # The camera is at z = 4 and sees 2.9 units of the plane z = 0.
    at = lambda x, y: (int(64 - y * 128 / 2.91), int(64 + x * 128 / 2.91))  # noqa: E731
    assert ids[at(-1, 0)] == first and ids[at(-1.2, 1)] == first and ids[at(0.1, 0)] == second and ids[at(0, -0.9)] == cone
    np.testing.assert_allclose(albedo[at(-1, 0)], clay.color, rtol=1e-3)
    np.testing.assert_allclose(albedo[at(0, 0)], moss.color, rtol=1e-3)


def test_lights() -> None:
    """A square that faces a light has its colour over pi of the irradiance, and a sun is seen where it is."""
    scene = rg.Scene()
    scene.add(SQUARE, material=rg.Material(color=(0.2, 0.4, 0.6)))
    sun = rg.DirectionalLight(direction=(0, 0, -2), angle_degrees=20, intensity=3, color=(1, 0.5, 1))
    point = rg.PointLight(position=(0, 0, 2), intensity=12)
    spot = rg.SpotLight(position=(0, 0, 2), direction=(0, 0, -1), inner_degrees=5, outer_degrees=10, intensity=12)
    for light, irradiance in [(sun, (3, 1.5, 3)), (point, (3, 3, 3)), (spot, (3, 3, 3))]:
        scene.lights = [light]
        assert scene.lights == (light,)
        image = render(scene, FRONT, size=(33, 33), samples=64)
        expected = np.array([0.2, 0.4, 0.6]) * irradiance / np.pi
        np.testing.assert_allclose(np.asarray(image)[16, 16], expected, rtol=2e-2)
    scene.lights += (sun,)
    assert scene.lights == (spot, sun)
    back = rg.Camera.look_at((0, 0, 4), (0, 0, 8))
    pixels = np.asarray(render(scene, back, size=(17, 17), samples=4))
    np.testing.assert_allclose(pixels[8, 8], np.array([3, 1.5, 3]) / (np.pi * np.sin(np.radians(10)) ** 2), rtol=1e-4)
    scene.lights = ()
    assert scene.lights == ()


def test_lights_that_are_wrong() -> None:
    scene = lit()
    with pytest.raises(rg.SceneError, match="`direction` in `directional` of light 1 must not be zero"):
        scene.lights = [rg.DirectionalLight(direction=(0, 0, 0))]
    with pytest.raises(rg.SceneError, match="`inner_degrees` in `spot` of light 1 is 60"):
        scene.lights = [rg.SpotLight(position=(0, 0, 0), direction=(0, 0, 1), inner_degrees=60)]
    with pytest.raises(TypeError, match="a light is a PointLight, a SpotLight or a DirectionalLight, not Sphere"):
        scene.lights = [rg.Sphere((0, 0, 0), 1)]
    assert scene == lit() and scene.lights == ()


def test_images_that_are_replaced_are_forgotten() -> None:
    from conftest import memory

    scene = rg.Scene()
    sky = np.ones((256, 512, 3), dtype=np.float32)
    for _ in range(5):
        scene.environment = rg.Environment(image=sky)
    before = memory()
    for _ in range(50):
        scene.environment = rg.Environment(image=sky)
    assert memory() - before < 20e6, "50 images of 1.5 MB are kept"


def test_materials() -> None:
    scene = lit()
    clay = rg.Material(color=(0.8, 0.4, 0.2))
    scene.add(rg.Sphere((0, 0, 0), 1), material=clay)
    scene.add(rg.Sphere((2, 0, 0), 1), material=rg.Material(color=(0.8, 0.4, 0.2)))
    assert list(scene.materials) == ["material-1"] and scene.materials["material-1"] == clay
    scene.materials["glass"] = rg.Material(refractive_index=1.5)
    scene.add(rg.Box((0, 2, 0), (1, 1, 1)), material="glass")
    scene.materials["gold"] = rg.Principled(base_color=(1, 0.8, 0.3), metallic=1, roughness=0.2)
    assert len(scene.materials) == 3 and "gold" in scene.materials
    with pytest.raises(ValueError, match="roughness"):
        scene.materials["gold"] = rg.Principled(roughness=2)
    with pytest.raises(TypeError, match="materials stay"):
        del scene.materials["gold"]


def test_media(tmp_path) -> None:
    scene = lit()
    fog = rg.Medium(scattering=0.5, absorption=(0.1, 0.2, 0.3), anisotropy=0.4)
    scene.air = rg.Medium(absorption=(0.01, 0.02, 0))
    scene.materials["fog"] = rg.Material(medium=fog)
    scene.materials["milk"] = rg.Material(refractive_index=1.33, medium=fog)
    scene.materials["wax"] = rg.Principled(transmission=1, roughness=0.4, medium=fog)
    for number, name in enumerate(scene.materials):
        scene.add(rg.Sphere((3 * number, 0, 0), 1), material=name)
    with pytest.raises(ValueError, match="anisotropy"):
        scene.materials["fog"] = rg.Material(medium=rg.Medium(anisotropy=1))
    with pytest.raises(ValueError, match="is of a surface, and a body with a `medium` has none"):
        scene.materials["fog"] = rg.Material(color=(1, 1, 1), medium=fog)
    with pytest.raises(ValueError, match="lets no light in: give it a `transmission`"):
        scene.materials["wax"] = rg.Principled(medium=fog)
    with pytest.raises(rg.SceneError, match="scattering"):
        scene.air = rg.Medium(scattering=-1)
    scene.camera = rg.Camera.look_at((0, 1, 9), (3, 0, 0), size=(40, 30))
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    again = rg.load(path)
    assert again.air == rg.Medium(absorption=(0.01, 0.02, 0))
    assert again.materials["milk"] == rg.Material(refractive_index=1.33, medium=fog)
    assert again.materials["wax"] == rg.Principled(transmission=1, roughness=0.4, medium=fog)
    np.testing.assert_array_equal(render(scene, samples=2).pixels, render(again, samples=2).pixels)
    again.air = None
    assert again.air is None and again != scene


def test_text_and_equality(tmp_path) -> None:
    scene = lit()
    scene.add(rg.Sphere((0, 0, 0), 1), material=rg.Material(color=(0.8, 0.4, 0.2)))
    with pytest.raises(rg.SceneError, match="has no camera"):
        scene.to_toml()
    scene.camera = rg.Camera.look_at((0, 1, 4), (0, 0, 0), size=(40, 30))
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    again = rg.load(path)
    assert again.size == (40, 30) and again.camera is not None and again.camera.position == (0, 1, 4)
    assert again.materials["material-1"] == rg.Material(color=(0.8, 0.4, 0.2))
    assert again.environment == rg.Environment(color=(1, 1, 1))
    np.testing.assert_array_equal(render(scene, samples=2).pixels, render(again, samples=2).pixels)
    copy = scene.copy()
    assert copy == scene and copy is not scene
    copy.add(rg.Sphere((3, 0, 0), 1))
    assert copy != scene and scene != "scene"
    assert repr(scene) == "<raggio.Scene 'scene': 1 shape, 1 materials>"
    scene.environment = rg.Environment(image=np.ones((2, 4, 3), dtype=np.float32))
    with pytest.raises(rg.SceneError, match="the image memory:1 in this scene is in memory"):
        scene.to_toml()
    scene.environment = rg.Environment(color=(1, 1, 1))
    path.write_text(scene.to_toml())
    assert rg.load(path)._text.equals(scene._text)
    scene.add(SQUARE, name="cup")
    with pytest.raises(rg.SceneError, match="the mesh cup in this scene is in memory"):
        scene.to_toml()


def test_equal_scenes_with_meshes() -> None:
    def made(height: float) -> rg.Scene:
        scene = lit()
        scene.add((SQUARE[0] + np.float32([0, height, 0]), SQUARE[1]))
        return scene

    assert made(1) == made(1) and made(1) != made(2)


def test_loading(file, tmp_path) -> None:
    scene = rg.load(file)
    assert scene.size == (48, 32) and list(scene.materials) == ["clay"]
    # Inline lists are added to as they are.
    inline = tmp_path / "inline.toml"
    inline.write_text(
        "version = 1\ncamera = { position = [0, 0, 4], look_at = [0, 0, 0], vertical_fov_degrees = 40 }\n"
        "environment = { color = [1, 1, 1] }\nmaterials.clay = { color = [1, 0, 0] }\n"
        'shapes = [\n    { material = "clay", sphere = { center = [0, 0, 0], radius = 1 } },\n]\n'
    )
    scene = rg.load(inline)
    scene.add(rg.Sphere((2, 0, 0), 1), material=rg.Material(color=(0, 1, 0)))
    assert "2 shapes, 2 materials" in repr(scene)
    inline.write_text(scene.to_toml())
    assert rg.load(inline)._text.equals(scene._text)
    with pytest.raises(rg.SceneError, match="nowhere.toml: there is no such file"):
        rg.load(tmp_path / "nowhere.toml")
    file.write_text(file.read_text().replace("radius", "radios"))
    with pytest.raises(rg.SceneError, match=r"scene.toml:16:.*did you mean `radius`"):
        rg.load(file)


def test_models_and_their_place(tmp_path) -> None:
    """A model of a file is where its mesh is when it comes as arrays."""
    path = tmp_path / "square.obj"
    vertices, faces = SQUARE
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n")
    turn = np.eye(4)
    a, b = np.radians(30), np.radians(-50)
    about_y = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    about_x = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    turn[:3, :3] = about_y @ about_x @ np.diag([0.5, -1, 2])
    turn[:3, 3] = (0.2, -0.1, 0.3)
    grey = rg.Material()
    one, two = lit(), lit()
    one.add(path, material=grey, transform=turn)
    two.add(SQUARE, material=grey, transform=turn)
    depths = [render(scene, FRONT, size=(32, 32), samples=4, aovs="depth")["depth"] for scene in (one, two)]
    covered = [np.isfinite(depth) for depth in depths]
    assert covered[0].any() and (covered[0] != covered[1]).mean() < 0.01
    both = covered[0] & covered[1]
    np.testing.assert_allclose(depths[0][both], depths[1][both], rtol=1e-3)
    shear = np.eye(4)
    shear[0, 1] = 1
    with pytest.raises(ValueError, match="shears"):
        one.add(path, material=grey, transform=shear)
    before = one.copy()
    with pytest.raises(rg.SceneError, match="there is no such file"):
        one.add(tmp_path / "missing.obj", material=grey)
    assert one == before


def test_dark_scenes_are_warned_of() -> None:
    scene = rg.Scene()
    scene.add(rg.Sphere((0, 0, 0), 1))
    with pytest.warns(rg.SceneWarning, match="nothing in the scene shines"):
        render(scene, FRONT, size=(4, 4), samples=1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        render(lit(), FRONT, size=(4, 4), samples=1)


class Open3dLike:
    """What open3d's TriangleMesh has."""

    def __init__(self) -> None:
        self.vertices, self.triangles = SQUARE
        self.vertex_colors = np.tile([1.0, 0.0, 0.0], (4, 1))

    def has_vertex_normals(self) -> bool:
        return False

    def has_vertex_colors(self) -> bool:
        return True


class PyvistaLike:
    """What pyvista's PolyData of triangles has."""

    is_all_triangles = True
    point_data: dict[str, np.ndarray] = {}

    def __init__(self) -> None:
        self.points = SQUARE[0]
        self.faces = np.insert(SQUARE[1], 0, 3, axis=1).ravel()


@pytest.mark.parametrize("kind", [Open3dLike, PyvistaLike])
def test_objects_of_other_libraries(kind) -> None:
    scene = lit()
    scene.add(kind())
    image = render(scene, FRONT, size=(8, 8), samples=8, aovs=("object_id", "albedo"))
    assert image["object_id"][4, 4] == 1
    if kind is Open3dLike:
        np.testing.assert_allclose(image["albedo"][4, 4], [1, 0, 0], atol=1e-3)


def seen(mesh: object, **options: object) -> rg.Image:
    scene = lit()
    scene.add(mesh, **options)
    return render(scene, FRONT, size=(33, 33), samples=16, aovs=("albedo", "depth", "normal"))


def test_open3d() -> None:
    open3d = pytest.importorskip("open3d", reason="open3d is not installed")
    ball = open3d.geometry.TriangleMesh.create_sphere(1.0, resolution=20)
    flat, smooth = seen(ball), seen(ball, smooth=True)
    np.testing.assert_allclose(flat["depth"][16, 16], 3, atol=0.01)
    assert (flat["depth"] == smooth["depth"]).all() and (flat["normal"] != smooth["normal"]).any()
    ball.compute_vertex_normals()
    ball.paint_uniform_color([1, 0, 0])
    red = seen(ball)
    np.testing.assert_allclose(red["albedo"][16, 16], [1, 0, 0], atol=1e-3)
    np.testing.assert_allclose(red["normal"], smooth["normal"], atol=0.05)
    # Those of tensors are the same mesh.
    tensors = seen(open3d.t.geometry.TriangleMesh.from_legacy(ball))
    for layer in ("albedo", "depth", "normal"):
        np.testing.assert_allclose(tensors[layer], red[layer], atol=1e-5)
    points = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(np.zeros((3, 3))))
    with pytest.raises(TypeError, match="PointCloud is no mesh"):
        lit().add(points)


def test_pyvista() -> None:
    pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed")
    # As pyvista shows it, a box is flat though it has normals at its corners.
    box = pyvista.Cube(x_length=2, y_length=2, z_length=2)
    image = seen(box)
    np.testing.assert_allclose(image["depth"][8:25, 8:25], 3, atol=1e-4)
    np.testing.assert_allclose(image["normal"][10:23, 10:23], np.broadcast_to([0, 0, 1], (13, 13, 3)), atol=1e-3)
    ball = pyvista.Sphere(radius=1.0)
    assert (seen(ball)["normal"] != seen(ball, smooth=True)["normal"]).any()
    # Grids show their surface, and several meshes are one.
    grid = pyvista.ImageData(dimensions=(3, 3, 3), spacing=(1, 1, 1), origin=(-1, -1, -1))
    pair = pyvista.MultiBlock([box, pyvista.Cube(center=(30, 0, 0))])
    for same in (grid, grid.cast_to_unstructured_grid(), pair, box.triangulate().strip()):
        np.testing.assert_allclose(seen(same)["depth"], image["depth"], atol=1e-4)
    # Colours, under the names that its readers give them.
    ball.point_data["RGB"] = np.tile(np.array([255, 0, 0], dtype=np.uint8), (ball.n_points, 1))
    np.testing.assert_allclose(seen(ball)["albedo"][16, 16], [1, 0, 0], atol=1e-3)
    for nothing in (pyvista.PolyData(np.zeros((3, 3))), pyvista.Line()):
        with pytest.raises(rg.SceneError, match="there are no triangles"):
            lit().add(nothing)


def test_trimesh() -> None:
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    ball = trimesh.creation.icosphere(subdivisions=3)
    scene = lit()
    scene.add(ball, material=rg.Material(color=(0.5, 0.5, 0.5)), smooth=True)
    depth = render(scene, FRONT, size=(16, 16), samples=8, aovs="depth")["depth"]
    np.testing.assert_allclose(depth[8, 8], 3, atol=0.05)
    # Colours of vertices, and of faces.
    box = trimesh.creation.box()
    box.visual.face_colors = [0, 0, 255, 255]
    ball.visual.vertex_colors = [255, 0, 0, 255]
    for mesh, color in ((box, [0, 0, 1]), (ball, [1, 0, 0])):
        scene = lit()
        scene.add(mesh)
        albedo = render(scene, FRONT, size=(16, 16), samples=4, aovs="albedo")["albedo"]
        np.testing.assert_allclose(albedo[8, 8], color, atol=1e-3)


def test_trimesh_scenes() -> None:
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    pillow = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    group = trimesh.Scene()
    square = trimesh.Trimesh(*SQUARE, process=False)
    picture = pillow.fromarray(np.full((2, 2, 3), (0, 255, 0), dtype=np.uint8))
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=picture, metallicFactor=0.0, roughnessFactor=1.0)
    square.visual = trimesh.visual.TextureVisuals(uv=np.array([[0, 0], [1, 0], [1, 1], [0, 1]]), material=material)
    moved = trimesh.transformations.translation_matrix([2, 0, 0])
    group.add_geometry(square, geom_name="square")
    group.add_geometry(square, geom_name="square", transform=moved)
    scene = lit()
    number = scene.add(group, id=5)
    camera = rg.Camera.look_at((1, 0, 8), (1, 0, 0))
    image = render(scene, camera, size=(64, 32), samples=4, aovs=("object_id", "albedo"))
    assert number == 5 and set(np.unique(image["object_id"]).tolist()) == {0, 5}
    assert (image["object_id"][16] == 5).sum() > 20
    np.testing.assert_allclose(image["albedo"][16, 26], [0, 1, 0], atol=1e-3)


def test_scenes_can_be_pickled(file) -> None:
    """With what is in memory, numbers and edits; files have to be where they were."""
    scene = rg.load(file)
    scene.add(SQUARE, material=rg.Principled(base_color_texture=np.full((2, 2, 3), 9, np.uint8)), name="square", id=7)
    scene.environment = rg.Environment(image=np.ones((4, 8, 3), np.float32))
    scene.materials["clay"] = rg.Material(color=(0, 1, 0))
    other = pickle.loads(pickle.dumps(scene))
    assert other == scene and other.objects == scene.objects and other.materials["clay"] == scene.materials["clay"]
    assert np.array_equal(render(other, samples=2), render(scene, samples=2))
    other.add(SQUARE)
    assert other != scene
    with pytest.raises(rg.SceneError, match="is in memory"):
        other.to_toml()
