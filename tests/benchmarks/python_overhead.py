#!/usr/bin/env python3
"""What the Python module costs per Native: C++ and Python in turn, in one run.

    PYTHONPATH=build/dev/bindings/python tests/benchmarks/python_overhead.py build/dev/tests/benchmarks
"""
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy

import altiro3d

ROOT = Path(__file__).resolve().parents[2]
FILES = [ROOT / "calibration/portrait-sample.json", ROOT / "docs/examples/sample.jpg",
         ROOT / "docs/examples/sample-depth.png"]
SECONDS = 3
ROUNDS = 4


def in_cpp(preset, threads):
    """Milliseconds per Native, Natives per second."""
    output = subprocess.run([Path(sys.argv[1]) / "native_times", *FILES, preset, str(threads),
                             str(SECONDS)], check=True, capture_output=True, text=True).stdout
    return tuple(map(float, output.split()))


def in_python(preset, threads, order):
    """The same."""
    source = altiro3d.depth_from_file(FILES[2])
    scene = source.read_scene(source.read_photo(FILES[1]))
    options = altiro3d.NativeOptions()
    options.show_live() if preset == "live" else options.show_as(altiro3d.Detail.Lens)
    display = altiro3d.read_display(FILES[0])
    times = [[] for _ in range(threads)]

    def work(own):
        maker = altiro3d.NativeMaker(display, options=options)
        width, height = maker.panel_size()
        native = numpy.empty((height, width, 3), numpy.uint8)
        end = time.perf_counter() + SECONDS
        while time.perf_counter() < end:
            start = time.thread_time()
            maker.make_native(scene, out=native, order=order)
            own.append((time.thread_time() - start) * 1e3)

    workers = [threading.Thread(target=work, args=(own,)) for own in times]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return min(times[0]), sum(map(len, times)) / SECONDS


def main():
    altiro3d.set_num_threads(1)
    print("preset  order  C++ ms  Python ms  overhead")
    for preset in ("live", "lens"):
        for order in ("bgr", "rgb"):
            pairs = [(in_cpp(preset, 1)[0], in_python(preset, 1, order)[0]) for _ in range(ROUNDS)]
            cpp, python = (min(times) for times in zip(*pairs))
            print(f"{preset:6}  {order:5}  {cpp:6.2f}  {python:9.2f}  {python / cpp - 1:+8.1%}")
    for name, rate in (("C++", in_cpp), ("Python", lambda *a: in_python(*a, "bgr"))):
        one, two = (rate("lens", threads)[1] for threads in (1, 2))
        print(f"two threads with two makers, {name}: {two / one:.2f} times the Natives of one")


if __name__ == "__main__":
    main()
