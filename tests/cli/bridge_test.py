#!/usr/bin/env python3
"""Tests --bridge of the tools against servers that behave as Looking Glass Bridge does, well or badly.

    bridge_test.py TOOLS_DIRECTORY SOURCE_DIRECTORY [TEST...]    (default: all)
"""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

TOOLS, SOURCE = (Path(word).resolve() for word in sys.argv[1:3])
CALIBRATION = (SOURCE / "calibration/portrait-sample.json").read_text()
QUILT = {"quiltX": 90, "quiltY": 80, "tileX": 3, "tileY": 2, "quiltAspect": 0.75}


def value(of):
    return {"name": "x", "type": "WSTRING", "value": of}


def device(name, index=0, calibration=CALIBRATION, version="portrait"):
    fields = {"hardwareVersion": version, "hwid": name, "calibration": calibration,
              "defaultQuilt": json.dumps(QUILT), "index": index, "state": "ok"}
    return value({key: value(of) for key, of in fields.items()})


class Bridge(ThreadingHTTPServer):
    """A healthy one by default. `answers` replaces what an endpoint answers."""

    daemon_threads = True

    def __init__(self, devices=None, answers=None):
        super().__init__(("127.0.0.1", 0), Handler)
        self.devices = [device("LKG-P00655")] if devices is None else devices
        self.answers = answers or {}
        self.calls = []
        self.address = f"127.0.0.1:{self.server_port}"
        threading.Thread(target=self.serve_forever, args=(0.02,), daemon=True).start()

    def handle_error(self, request, client_address):
        pass  # the tool has left

    def payload(self, endpoint):
        if endpoint == "enter_orchestration":
            return "token-1"
        if endpoint == "available_output_devices":
            return {str(i): entry for i, entry in enumerate(self.devices)}
        return ""

    def names(self):
        return [endpoint for endpoint, _ in self.calls]


class Handler(BaseHTTPRequestHandler):
    def do_PUT(self):
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        endpoint = self.path[1:]
        self.server.calls.append((endpoint, body))
        answer = self.server.answers.get(endpoint)
        if callable(answer):
            answer = answer(self)
            if answer is None:
                return
        if answer is None:
            answer = json.dumps({"name": "value", "status": value("Completion"),
                                 "payload": value(self.server.payload(endpoint))})
        self.send_response(200)
        self.send_header("Content-Length", str(len(answer)))
        self.end_headers()
        self.wfile.write(answer.encode())

    def log_message(self, *words):
        pass


def never(handler):
    time.sleep(20)


def trickle(handler):
    handler.send_response(200)
    handler.send_header("Content-Length", "1000")
    handler.end_headers()
    for _ in range(20):
        handler.wfile.write(b" ")
        time.sleep(1)


def slowly(handler):
    time.sleep(2)
    return json.dumps({"status": value("Pending"), "payload": value("token-1")})


def die(handler):
    handler.server.socket.close()
    handler.connection.close()


class BridgeTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name) / "work"
        self.work.mkdir()
        self.home = Path(folder.name) / "home"
        self.environment = dict(os.environ, HOME=str(self.home), QT_QPA_PLATFORM="offscreen",
                                LSAN_OPTIONS="detect_leaks=0")
        for name in ("XDG_CACHE_HOME", "LKG_CALIBRATION", "http_proxy"):
            self.environment.pop(name, None)
        shutil.copy(SOURCE / "docs/examples/sample.jpg", self.work / "a.jpg")
        shutil.copy(SOURCE / "docs/examples/sample-depth.png", self.work / "a-depth.png")

    def bridge(self, **options):
        bridge = Bridge(**options)
        self.addCleanup(bridge.server_close)
        self.addCleanup(bridge.shutdown)
        return bridge

    def run_tool(self, tool, *words):
        return subprocess.run([TOOLS / tool, *map(str, words)], cwd=self.work, env=self.environment,
                              text=True, capture_output=True, timeout=120)

    def good(self, tool, *words):
        run = self.run_tool(tool, *words)
        self.assertEqual((run.returncode, run.stderr), (0, ""), run)
        return run.stdout

    def bad(self, part, bridge, *words, status=1):
        run = self.run_tool("quilt2native", "--bridge", bridge, *(words or ["q_qs3x2a0.75.png"]))
        self.assertEqual(run.returncode, status, run)
        self.assertIn(part, run.stderr)
        self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)

    def make_quilt(self, name="q.png"):
        self.good("photo2native", "-c", SOURCE / "calibration/portrait-sample.json", "-q", "2x3",
                  "-r", "40x30", "--save-quilt", name, "a.jpg")

    def entries(self, bridge):
        return [body for endpoint, body in bridge.calls if endpoint == "insert_playlist_entry"]

    def test_a_healthy_bridge_gets_a_new_playlist_each_time(self):
        self.make_quilt()
        shutil.copy(self.work / "q_qs3x2a0.75.png", self.work / "r_qs3x2a0.75.png")
        bridge = self.bridge()
        for _ in range(2):
            out = self.good("quilt2native", "--bridge", bridge.address, "--each", 7.5,
                            "q_qs3x2a0.75.png", "r_qs3x2a0.75.png")
            self.assertIn(f"Looking Glass Bridge at {bridge.address}: shows 2 files", out)
        order = ["enter_orchestration", "available_output_devices", "show_window",
                 "instance_playlist", "insert_playlist_entry", "insert_playlist_entry",
                 "play_playlist"]
        self.assertEqual(bridge.names()[-7:], order)
        self.assertNotIn("delete_playlist", bridge.names())
        playlists = {body["name"] for endpoint, body in bridge.calls if endpoint == "play_playlist"}
        self.assertEqual(len(playlists), 2)
        first = self.entries(bridge)[0]
        self.assertEqual(first["uri"], str((self.work / "q_qs3x2a0.75.png").resolve()))
        self.assertEqual({key: first[key] for key in ("rows", "cols", "aspect", "view_count", "isRGBD",
                                                      "durationMS", "index", "orchestration")},
                         {"rows": 2, "cols": 3, "aspect": 0.75, "view_count": 6, "isRGBD": 0,
                          "durationMS": 7500, "index": 0, "orchestration": "token-1"})
        self.assertEqual(self.entries(bridge)[1]["index"], 1)
        show = next(body for endpoint, body in bridge.calls if endpoint == "show_window")
        self.assertEqual((show["show_window"], show["head_index"]), (True, -1))

    def test_photos_leave_their_quilts_for_the_bridge(self):
        bridge = self.bridge()
        self.good("photo2native", "--bridge", bridge.address, "a.jpg", "out.png")
        self.assertEqual(Path(self.entries(bridge)[0]["uri"]), self.work.resolve() / "a_qs3x2a0.75.png")
        self.assertTrue((self.work / "a_qs3x2a0.75.png").exists())
        cache = self.home / ".cache/altiro3D/bridge"
        cache.mkdir(parents=True)
        for i in range(25):
            (cache / f"{i:02}.png").touch()
            os.utime(cache / f"{i:02}.png", (i, i))
        self.good("photo2native", "--bridge", bridge.address, "a.jpg")
        uri = Path(self.entries(bridge)[-1]["uri"])
        self.assertEqual(uri.parent.resolve(), cache.resolve())
        self.assertTrue(uri.exists())
        names = sorted(file.name for file in cache.iterdir())
        self.assertEqual(names, sorted([f"{i:02}.png" for i in range(6, 25)] + [uri.name]))

    def test_scenes_of_splats_are_shown_as_quilts(self):
        self.good("photo2native", "--save-splats", "a.ply", "--splat-side", 60, "a.jpg")
        bridge = self.bridge()
        self.good("splat2native", "--bridge", bridge.address, "--each", 3, "a.ply", "out.png")
        self.good("splat2native", "--bridge", bridge.address, "--save-quilt", "b.png", "a.ply")
        first, second = self.entries(bridge)
        self.assertEqual([first[key] for key in ("cols", "rows", "durationMS")], [3, 2, 3000])
        self.assertEqual(Path(first["uri"]).parent.name, "bridge")
        self.assertEqual((Path(second["uri"]).name, second["durationMS"]),
                         ("b_qs3x2a0.75.png", 20000))

    def test_rgbd_pictures_say_where_their_depth_is(self):
        bridge = self.bridge()
        self.good("photo2native", "--bridge", bridge.address, "--save-rgbd", "a_RGBD.png", "a.jpg")
        entry = self.entries(bridge)[0]
        self.assertEqual((entry["isRGBD"], entry["depth_loc"], entry["depth_inversion"]), (1, 2, 0))
        self.assertAlmostEqual(entry["aspect"], 3 / 4, 2)
        self.good("altiro3Dview", "--bridge", bridge.address, "--show", "a_RGBD.png")
        self.assertEqual(self.entries(bridge)[1]["aspect"], entry["aspect"])

    def test_the_viewer_shows_and_lists(self):
        self.make_quilt()
        bridge = self.bridge(devices=[device("LKG-P00655"), device("LG", version="thirdparty"),
                                      device("odd", 2, "{}")])
        out = self.good("altiro3Dview", "--bridge", bridge.address, "--list-displays")
        self.assertIn(f"display LKG-P00655, Looking Glass Bridge at {bridge.address}, panel 1536 x 2048", out)
        self.assertNotIn("display LG", out)
        listed = json.loads(self.good("altiro3Dview", "--bridge", bridge.address, "--list-displays", "--json"))
        self.assertEqual([d["name"] for d in listed["displays"]], ["LKG-P00655", "odd"])
        self.assertTrue(listed["displays"][1]["problems"])
        self.good("altiro3Dview", "-c", SOURCE / "calibration/portrait-sample.json", "--bridge",
                  bridge.address, "--show", "q_qs3x2a0.75.png")
        self.assertEqual(len(self.entries(bridge)), 1)
        run = self.run_tool("altiro3Dview", "--bridge", bridge.address, "-c",
                            SOURCE / "calibration/portrait-sample.json", "--show", "a.jpg")
        self.assertIn("a.jpg: is neither named as a quilt nor as an RGB-D file", run.stderr)

    def test_the_calibration_is_used_and_saved(self):
        other = CALIBRATION.replace("LKG-PORT-SAMPLE", "LKG-PORT-OTHER")
        bridge = self.bridge(devices=[device("LKG-P1"), device("LKG-P2", 1, other)])
        out = self.good("altiro3Dnative", "--bridge", bridge.address, "--serial", "lkg-p2", "--info", "bridge")
        self.assertIn("serial LKG-PORT-OTHER", out)
        self.good("altiro3Dnative", "--bridge", bridge.address, "--serial", "LKG-P2", "--read-bridge", "v.json")
        self.assertEqual((self.work / "v.json").read_text(), other)
        run = self.run_tool("altiro3Dnative", "--bridge", bridge.address, "--read-bridge", "w.json")
        self.assertIn("has several displays, expected --serial with one of LKG-P1, LKG-P2", run.stderr)
        out = self.good("altiro3Dnative", "--bridge", bridge.address, "--serial", "LKG-P1", "-m", "a.map", "bridge")
        self.assertTrue((self.work / "a.map").exists(), out)

    def test_a_quilt_video_is_shown_when_it_is_made(self):
        bridge = self.bridge()
        self.make_quilt()
        self.good("quilt2video", "--seconds", 1, "--fps", 4, "--turns", 1, "--size", "64x48",
                  "q_qs3x2a0.75.png", "c.mp4")
        run = self.run_tool("video2native", "--bridge", bridge.address, "--method", "fast", "--quilt-out",
                            "c.mp4", "d.mp4")
        self.assertEqual(run.returncode, 0, run)
        entry = self.entries(bridge)[0]
        self.assertEqual(Path(entry["uri"]).name, "d_qs3x2a0.75.mp4")
        self.assertEqual((entry["cols"], entry["durationMS"]), (3, 1000))
        for name in ("in/a.mp4", "in/b.mp4"):
            (self.work / name).parent.mkdir(exist_ok=True)
            shutil.copy(self.work / "c.mp4", self.work / name)
        (self.work / "in/c.mp4").write_text("no video")
        run = self.run_tool("video2native", "--bridge", bridge.address, "--method", "fast", "--quilt-out",
                            "in", "out")
        self.assertEqual(run.returncode, 1, run)
        self.assertEqual([Path(entry["uri"]).name for entry in self.entries(bridge)[-2:]],
                         ["a_qs3x2a0.75.mp4", "b_qs3x2a0.75.mp4"])
        run = self.run_tool("video2native", "--bridge", bridge.address, "c.mp4", "e.mp4")
        self.assertEqual(run.returncode, 2, run)

    def test_bad_answers_end_in_one_sentence(self):
        self.make_quilt()
        big = "x" * (4 << 20)
        cases = [
            ("has no light-field display", {"devices": []}),
            ("has no light-field display", {"devices": [device("LG", version="thirdparty")]}),
            ("answers with nothing", {"answers": {"enter_orchestration": ""}}),
            ("gives no token", {"answers": {"enter_orchestration": json.dumps(
                {"status": value("Completion"), "payload": value("")})}}),
            ("is not valid JSON", {"answers": {"enter_orchestration": "<html>"}}),
            ("nests too deep", {"answers": {"enter_orchestration": "[" * 100000}}),
            ("more than 4 MB", {"answers": {"enter_orchestration": '"' + big + '"'}}),
            ("more than 64 kB", {"devices": [device("LKG-P1", 0, CALIBRATION + " " * 65536)]}),
            ("has no calibration", {"devices": [device("LKG-P1", 0, "")]}),
            ("(play_playlist): answers with nothing", {"answers": {"play_playlist": ""}}),
            ("answers Failure, expected Completion", {"answers": {"show_window": json.dumps(
                {"status": value("Failure")})}}),
            ("cannot be reached", {"answers": {"instance_playlist": die}}),
        ]
        for part, options in cases:
            with self.subTest(part):
                self.bad(part, self.bridge(**options).address)
        with socket.socket() as unused:
            unused.bind(("127.0.0.1", 0))
            self.bad("cannot be reached", f"127.0.0.1:{unused.getsockname()[1]}")
        for address in ("a/b", "user@host", "host:port", " ", "http://x"):
            self.bad("expected auto or HOST:PORT", address, status=2)

    def test_a_slow_bridge_is_waited_for_and_a_silent_one_is_not(self):
        self.make_quilt()
        self.good("quilt2native", "--bridge",
                  self.bridge(answers={"enter_orchestration": slowly}).address, "q_qs3x2a0.75.png")
        for endpoint, behaviour in (("enter_orchestration", never), ("available_output_devices", trickle)):
            start = time.monotonic()
            self.bad("does not answer", self.bridge(answers={endpoint: behaviour}).address)
            self.assertLess(time.monotonic() - start, 12)

    def test_a_bridge_elsewhere_fetches_from_one_address_only(self):
        self.make_quilt()
        bridge = self.bridge()
        tool = subprocess.Popen([TOOLS / "quilt2native", "--bridge", bridge.address, "--serve",
                                 "127.0.0.1", "q_qs3x2a0.75.png"], cwd=self.work,
                                env=self.environment, text=True, stdout=subprocess.PIPE)
        self.addCleanup(tool.stdout.close)
        self.addCleanup(tool.kill)
        while "Ctrl-C ends this" not in tool.stdout.readline():
            self.assertIsNone(tool.poll())
        uri = self.entries(bridge)[0]["uri"]
        expected = (self.work / "q_qs3x2a0.75.png").read_bytes()
        with urllib.request.urlopen(uri, timeout=10) as answer:
            self.assertEqual(answer.read(), expected)
        with urllib.request.urlopen(urllib.request.Request(uri, method="HEAD"), timeout=10) as answer:
            self.assertEqual((int(answer.headers["Content-Length"]), answer.read()), (len(expected), b""))
        root = uri[:uri.index("/", 8)]
        for request in (root + "/", root + "/../a.jpg", uri + "x",
                        urllib.request.Request(uri, method="POST", data=b"x")):
            with self.assertRaises(urllib.error.HTTPError):
                urllib.request.urlopen(request, timeout=10)
        host, port = root[7:].split(":")
        with socket.create_connection((host, int(port)), 10, ("127.0.0.2", 0)) as stranger:
            with self.assertRaises(ConnectionError):  # never an answer
                stranger.sendall(f"GET {uri[len(root):]} HTTP/1.1\r\n\r\n".encode())
                if stranger.recv(100) == b"":
                    raise ConnectionError
        with socket.create_connection((host, int(port)), 10) as endless:
            with self.assertRaises(ConnectionError):
                for _ in range(1000):
                    endless.sendall(b"GET " + b"x" * 1000)
                    time.sleep(0.001)
        tool.send_signal(signal.SIGINT)
        self.assertEqual(tool.wait(10), 0)

    def test_an_address_that_is_not_ours_is_refused(self):
        self.make_quilt()
        bridge = self.bridge()
        self.bad("expected an address of this computer", bridge.address, "--serve", "203.0.113.7", "q_qs3x2a0.75.png")
        self.bad("--serve is x y", bridge.address, "--serve", "x y", "q_qs3x2a0.75.png", status=2)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
