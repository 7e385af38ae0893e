#!/usr/bin/env python3
"""Measures the time from a picture in front of a camera to the same picture on the display.

    camera_delay.py VIDEO2NATIVE CALIBRATION CLIP [OPTIONS OF video2native ...]

A virtual screen (Xvfb) stands for the camera's view: it shows the clip at 30 frames per second, and
the number of each picture as rows of black and white. video2native captures it (x11grab) and shows
Natives on a second virtual screen. The delay of a picture is the time until its number is seen
there. It contains the time until the capture takes the picture, up to 1/30 s.
"""
import json
import mmap
import os
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np

WIDTH, HEIGHT, FPS, PICTURES = 960, 540, 30, 60
SECONDS = float(os.environ.get("CAMERA_DELAY_SECONDS", "20"))
BITS, BAR = 10, 16  # each bit is a bar of so many rows


def screen(number, width, height, folder):
    os.makedirs(folder)
    server = subprocess.Popen(["Xvfb", f":{number}", "-screen", "0", f"{width}x{height}x24", "-fbdir", folder,
                               "-nolisten", "tcp"], stderr=subprocess.DEVNULL)
    path = os.path.join(folder, "Xvfb_screen0")
    while not os.path.exists(path) or os.path.getsize(path) < width * height * 4:
        time.sleep(0.05)
    time.sleep(0.5)
    with open(path, "r+b") as file:
        memory = mmap.mmap(file.fileno(), 0)
    head = np.frombuffer(memory, ">u4", 25)  # an XWD file: header, name, colours, px
    start = int(head[0]) + int(head[19]) * 12
    pixels = np.frombuffer(memory, np.uint8, width * height * 4, start).reshape(height, width, 4)
    return server, pixels


def number_in(pixels, scale):
    column = pixels.shape[1] // 2
    value = 0
    for bit in range(BITS):
        row = int((bit + 0.5) * BAR * scale)
        value |= int(pixels[row, column, 1] > 127) << bit
    for bit in range(BITS, 2 * BITS):  # the complement: a picture that is half drawn is not read
        row = int((bit + 0.5) * BAR * scale)
        if (int(pixels[row, column, 1] > 127) ^ (value >> (bit - BITS))) & 1 == 0:
            return None
    return value


def main():
    tool, calibration, clip, options = sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]
    with open(calibration, encoding="utf-8") as file:
        facts = json.load(file)
    panel = int(facts["screenW"]["value"]), int(facts["screenH"]["value"])
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", clip, "-frames:v", str(PICTURES), "-vf",
                          f"scale={WIDTH}:{HEIGHT}", "-pix_fmt", "bgra", "-f", "rawvideo", "-"],
                         stdout=subprocess.PIPE, check=True).stdout
    pictures = np.frombuffer(raw, np.uint8).reshape(-1, HEIGHT, WIDTH, 4)
    temporary = tempfile.TemporaryDirectory()
    folder = temporary.name
    servers = []
    try:
        server, seen = screen(96, WIDTH, HEIGHT, folder + "/camera")
        servers.append(server)
        server, shown = screen(97, *panel, folder + "/display")
        servers.append(server)
        program = subprocess.Popen(
            [tool, "--show", "--screen", "0", "-c", calibration, "--input-format", "x11grab", "--input-options",
             f"framerate={FPS}", *options, ":96"], env={**os.environ, "DISPLAY": ":97"})
        sent, delays, last, first = {}, [], None, None
        start = due = time.monotonic()
        number = 0
        while time.monotonic() - start < SECONDS and program.poll() is None:
            now = time.monotonic()
            if now >= due:
                number = (number + 1) % (1 << BITS)
                seen[2 * BITS * BAR:] = pictures[number % len(pictures), 2 * BITS * BAR:]
                for bit in range(2 * BITS):
                    value = number >> bit if bit < BITS else ~number >> (bit - BITS)
                    seen[bit * BAR:(bit + 1) * BAR] = 255 * (value & 1)
                sent[number] = time.monotonic()
                due += 1 / FPS
            now = time.monotonic()
            found = number_in(shown, panel[1] / HEIGHT)
            if found is not None and found != last and found in sent:
                last = found
                first = first or now
                if now - first > 3:  # after the start
                    delays.append(now - sent[found])
            time.sleep(0.001)
        program.send_signal(signal.SIGINT)
        program.wait()
        if not delays:
            sys.exit("no picture was seen")
        values = 1000 * np.sort(delays)
        print(f"{len(values) / (SECONDS - 3 - (first - start)):.1f} pictures/s; delay, ms: median {np.median(values):.0f}, "
              f"least {values[0]:.0f}, 95 % within {values[int(0.95 * len(values))]:.0f}, greatest {values[-1]:.0f}")
    finally:
        for server in servers:
            server.terminate()
            server.wait()
        temporary.cleanup()


main()
