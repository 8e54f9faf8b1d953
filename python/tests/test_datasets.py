"""Files of data sets."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import lit, render

import raggio as rg
from raggio import datasets


# pycocotools is not of NumPy 2 yet.
@pytest.mark.filterwarnings("ignore:__array__ implementation")
def test_coco_masks_are_read_back(tmp_path, capsys) -> None:
    coco = pytest.importorskip("pycocotools.coco", reason="pycocotools is not installed")
    scene = lit()
    left = scene.add(rg.Sphere((-1, 0, 0), 0.6), name="ball")
    right = scene.add(rg.Box((1, 0, 0), (1, 1, 1)), name="box")
    floor = scene.add(rg.Plane((0, -1, 0), (0, 1, 0)), name="floor")
    writer = datasets.CocoWriter({left: "ball", right: "box"})
    cameras = [rg.Camera.look_at((x, 1, 5), (0, 0, 0)) for x in (-1, 0, 3)]
    seen = {}
    for i, image in rg.render_many(scene, cameras, size=(50, 40), samples=1, device="cpu", aovs="object_id"):
        number = writer.add(f"view-{i}.png", image["object_id"])
        seen[number] = image["object_id"]
    writer.write(tmp_path / "instances.json")
    read = coco.COCO(str(tmp_path / "instances.json"))
    assert sorted(read.getImgIds()) == [1, 2, 3] and len(read.getCatIds()) == 2
    for annotation in read.loadAnns(read.getAnnIds()):
        mask = read.annToMask(annotation)
        expected = seen[annotation["image_id"]] == annotation["object_id"]
        np.testing.assert_array_equal(mask.astype(bool), expected)
        assert annotation["area"] == expected.sum() and annotation["object_id"] != floor
        x, y, width, height = annotation["bbox"]
        assert expected[y : y + height, x : x + width].sum() == expected.sum()
        assert expected[y].any() and expected[:, x].any()


@pytest.mark.parametrize(
    "mask", [np.zeros((3, 2), bool), np.ones((3, 2), bool), np.eye(4, dtype=bool), np.zeros((0, 0))]
)
def test_run_lengths(mask) -> None:
    code = datasets.run_length(mask)
    values = np.arange(len(code["counts"])) % 2
    np.testing.assert_array_equal(values.repeat(code["counts"]).reshape(mask.shape, order="F"), mask)


def test_nerfstudio(tmp_path) -> None:
    cameras = [rg.Camera.look_at((x, 1, 5), (0, 0, 0), size=(50, 40)) for x in (-1, 0, 3)]
    datasets.write_transforms(tmp_path / "transforms.json", [(f"images/{i}.png", c) for i, c in enumerate(cameras)])
    stored = json.loads((tmp_path / "transforms.json").read_text())
    assert (stored["w"], stored["h"], stored["camera_model"]) == (50, 40, "OPENCV")
    K = [[stored["fl_x"], 0, stored["cx"]], [0, stored["fl_y"], stored["cy"]], [0, 0, 1]]
    scene = lit()
    scene.add(rg.Sphere((0.4, 0.2, 0), 1))
    for frame, camera in zip(stored["frames"], cameras, strict=True):
        again = rg.Camera.from_matrix(frame["transform_matrix"], K=K, size=(50, 40), convention="opengl")
        ids = [render(scene, c, samples=1, aovs="object_id")["object_id"] for c in (again, camera)]
        assert (ids[0] == ids[1]).mean() > 0.995
    # Sizes that differ stand with their frames.
    views = [("a.png", cameras[0]), ("b.png", cameras[1].with_size(60, 40))]
    datasets.write_transforms(tmp_path / "transforms.json", views)
    stored = json.loads((tmp_path / "transforms.json").read_text())
    assert "w" not in stored and [frame["w"] for frame in stored["frames"]] == [50, 60] and stored["h"] == 40
    with pytest.raises(ValueError, match="size is"):
        datasets.write_transforms(tmp_path / "t.json", [("a.png", rg.Camera.look_at((0, 0, 1), (0, 0, 0)))])
