"""What calls cost from Python beside C++: python_calls.py SIGHTLINE_STUDY [ITEMS]

Runs `sightline-study calls` and makes the same calls: a frame that is only culled, a pick, a query of boxes, each for 200
views of the tour. Rounds of both take turns; medians of 5. Prints microseconds a call.
"""

import json
import statistics
import subprocess
import sys
import time

import numpy as np
import sightline

study, items = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100_000
FRAMES, ROUNDS, TURNS = 200, 20, 5

scene = sightline.Scene()
scene.generate_plant(items, 1)
engine = sightline.Engine(scene)
path = engine.tour()
views = [path.view(path.time_of(i, FRAMES), aspect=1280 / 720) for i in range(FRAMES)]
culler = sightline.BoxCuller(np.array([scene.item(i).bounds.reshape(6) for i in scene.items]))
engine.pick(views[0], 640, 360)

CALLS = {
    "frame": (engine.frame, lambda report: report.visible, "visible"),
    "pick": (lambda view: engine.pick(view, 640, 360), lambda pick: pick is not None, "hits"),
    "boxes": (culler.visible, len, "boxes"),
}


def microseconds(call):
    rounds = []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for view in views:
            call(view)
        rounds.append(1e6 * (time.perf_counter() - begin) / FRAMES)
    return statistics.median(rounds)


cpp, python = [], []
for _ in range(TURNS):
    out = subprocess.run([study, "calls", "--items", str(items), "--frames", str(FRAMES), "--rounds", str(ROUNDS),
                          "--json", "-"], check=True, capture_output=True, text=True).stdout
    cpp.append(json.loads(out))
    python.append({name: microseconds(call) for name, (call, _, _) in CALLS.items()})
print(f"{items} items, {FRAMES} views: microseconds a call")
print(f"{'':8} {'C++':>9} {'Python':>9} {'more':>9}")
for name, (call, count, counted) in CALLS.items():
    assert sum(count(call(view)) for view in views) == cpp[0][counted], f"{name}: not the same work"
    a = statistics.median(run[f"{name}_us"] for run in cpp)
    b = statistics.median(run[name] for run in python)
    print(f"{name:8} {a:9.2f} {b:9.2f} {b - a:9.2f}")
