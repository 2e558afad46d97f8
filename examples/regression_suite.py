# %% [markdown]
# # A regression suite for images of a plant
#
# Renders views of a model, keeps them as references, and compares later images with them: by the largest and the mean
# difference, by FLIP (what somebody sees who flips between both), and by the items that pixels show. The result is one
# HTML page with reference, image and difference of each view.
#
#     python3 regression_suite.py OUTPUT_FOLDER
#
# Editors show the cells of this file ("# %%") as a notebook.

# %%
from __future__ import annotations

import base64
import pathlib
import sys

import numpy as np
import sightline
from numpy.typing import NDArray

WIDTH, HEIGHT = 480, 320
MOST = 8  # of 255: largest difference of a channel that passes

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "regression")
folder.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The model
# Any file that sightline reads would do: `scene.import_file("plant.rvm")`.

# %%
scene = sightline.Scene()
scene.generate_plant(items=20_000, seed=1)
engine = sightline.Engine(scene, draw=True, width=WIDTH, height=HEIGHT, ids=True)
print(scene.item_count, "items, drawn by", engine.renderer)

# %% [markdown]
# ## The views
# An overview, and moments of a flight through the model.

# %%
tour = engine.tour()
views = {"overview": engine.fit()}
for second in (12, 24, 36):
    views[f"tour at {second} s"] = tour.view(second, aspect=WIDTH / HEIGHT)


def render(view: sightline.View) -> tuple[NDArray[np.uint8], NDArray[np.uint32]]:
    """Colours and ids."""
    engine.frame(view)
    return engine.read_colour(), engine.read_ids()


# %% [markdown]
# ## References
# Colours as PNG files, which people can look at; ids as numpy files.

# %%
for name, view in views.items():
    colour, ids = render(view)
    sightline.write_png(folder / f"{name}.png", colour)
    np.save(folder / f"{name}.npy", ids)

# %% [markdown]
# ## The change
# Here an edit that ought to show: a pipe run moves up by a metre. In practice it is a new version of the model, of the
# library, or of a driver.

# %%
item = int(np.bincount(render(views["overview"])[1].ravel())[1:].argmax())  # that covers most pixels
moved = scene.item(item).node
print("moved:", moved.path)
moved.transform = sightline.translation([0, 0, 1]) @ moved.transform
engine.commit()

# %% [markdown]
# ## Comparison

# %%


def figure(image: NDArray[np.uint8]) -> str:
    return f'<img src="data:image/png;base64,{base64.b64encode(sightline.encode_png(image)).decode()}">'


rows, failed = [], []
for name, view in views.items():
    reference, reference_ids = sightline.read_png(folder / f"{name}.png"), np.load(folder / f"{name}.npy")
    colour, ids = render(view)
    difference = sightline.compare(reference, colour)
    flip = sightline.metrics(reference, colour).flip_mean
    wrong = sightline.wrong_ids(reference_ids, ids)
    passed = difference.max <= MOST
    if not passed:
        failed.append(name)
    print(f"{name:12} max {difference.max:3}  mean {difference.mean:.4f}  FLIP {flip:.5f}  other items in {wrong} pixels"
          f"  {'ok' if passed else 'DIFFERS'}")
    images = (reference, colour, sightline.difference_image(reference, colour))
    rows.append(f"<tr><th>{name}<br>max {difference.max}<br>FLIP {flip:.5f}<br>other items in {wrong} pixels"
                f"<td>{'<td>'.join(map(figure, images))}")

page = f"""<!DOCTYPE html><meta charset="utf-8"><title>Regression suite</title>
<h1>{len(failed)} of {len(views)} views differ</h1>
<p>Item {item} ({moved.path}) was moved. Reference, image, and their difference four times amplified.</p>
<table>{"".join(rows)}</table>"""
(folder / "report.html").write_text(page)
print(folder / "report.html")
