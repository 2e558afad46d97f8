"""Visibility for CAD viewers: scenes, culling, drawing offscreen, picks, and comparing images.

    import sightline

    scene = sightline.Scene()
    scene.import_file("plant.rvm")
    image = sightline.render(scene, width=1280, height=720)  # (720, 1280, 3) uint8
    sightline.write_png("plant.png", image)

Coordinates are metres, right-handed, z up; angles radians. Matrices are 4 x 4 for column vectors: world = m @ local.
What goes wrong is a sightline.Error, whose text says where, what was expected and what was found. Calls that take long
release the GIL. Of several threads that use one scene or engine, one at a time edits it; the others wait.
"""

from __future__ import annotations

from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

from . import _sightline
from ._sightline import *

__version__: str = _sightline.version

__all__ = [
    "Box", "BoxCuller", "CameraPath", "CircularTorus", "compare", "ControllerConfig", "ControllerReport",
    "CULL_STATES", "CullStates", "Cylinder", "DEFAULT_LAYERS", "difference_image", "EllipticalDish", "encode_png",
    "Engine", "Error", "ExactSurfaces", "ExternalTarget", "flip", "FrameReport", "id_colours", "ids_of_colours", "ImageDifference",
    "ImageMetrics", "ImportReport", "ImportWarning", "Item", "KINDS", "known_extensions", "LateReport", "Line",
    "LossReport", "Material", "MemoryReport", "Mesh", "metrics", "Node", "OccluderRaster", "OVERVIEW_DIRECTION", "PagedEngine",
    "PagedReport", "Pick",
    "image_tiles", "ImageTile", "CroppedTile", "ImageTiles", "PlanEntry", "Pyramid", "read_png",
    "Recognition", "RectangularTorus", "render", "replay", "Scene", "SceneDelta", "Snout", "Sphere",
    "SphericalDish", "translation", "View", "write_pfm", "write_png", "wrong_ids",
]


def render(
    scene: Scene, view: View | None = None, width: int = 1280, height: int = 720, **config: Any
) -> NDArray[np.uint8]:
    """An image of the scene, (height, width, 3) uint8, with an engine made for it.

    Without a view the whole model, as sightline-render --plain shows it. `config`: keyword arguments of Engine. For
    more than one image of a scene keep an Engine: it builds what it needs once.
    """
    with Engine(scene, draw=True, width=width, height=height, **config) as engine:
        if view is None:
            view = engine.fit()
        if not engine.frame(view).drawn:
            raise Error("render: the GL context was lost before the image was drawn")
        return engine.read_colour()


def replay(
    engine: Engine,
    path: CameraPath,
    frames: int = 300,
    *,
    aspect: float | None = None,
    after_frame: Callable[[int, View], object] | None = None,
) -> list[FrameReport]:
    """Flies a camera path in evenly spaced frames, as sightline-replay does. Returns the report of each frame.

    `after_frame` is called with the frame's number and view; there images may be read. Of frames that the GPU culls,
    counts arrive late: with engine.take_late_report(). `aspect`: width / height; None: the engine's.
    """
    if aspect is None:
        aspect = engine.width / engine.height
    reports = []
    for frame in range(frames):
        view = path.view(path.time_of(frame, frames), aspect=aspect)
        reports.append(engine.frame(view))
        if after_frame is not None:
            after_frame(frame, view)
    engine.finish()
    return reports
