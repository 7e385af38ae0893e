#!/usr/bin/env python3
"""Makes reports and lines of --progress json with the tools, and validates them against docs/report.schema.json.

    report_schema_test.py TOOLS_DIRECTORY SOURCE_DIRECTORY
"""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import jsonschema
except ImportError:
    print("skipped: needs python3-jsonschema")
    sys.exit(77)

TOOLS, SOURCE = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
SCHEMA = json.loads((SOURCE / "docs/report.schema.json").read_text())
DISPLAY = ["-c", str(SOURCE / "calibration/portrait-sample.json"), "-q", "2x4", "-r", "80x60"]
EXAMPLES = SOURCE / "docs/examples"
failures = []


def check(holds, what):
    if not holds:
        failures.append(what)
        print("FAILED:", what)


def problem(value, part=""):
    """The first thing that is wrong with a value; empty if it is valid."""
    schema = dict(SCHEMA, **({"oneOf": [{"$ref": part}]} if part else {}))
    error = jsonschema.exceptions.best_match(jsonschema.Draft202012Validator(schema).iter_errors(value))
    return "" if error is None else f"{list(error.absolute_path)}: {error.message}"


def long_numbers(text):
    return [number for number in re.findall(r"-?\d+\.\d+(?:e-?\d+)?", text) if len(number) > 14]


def run(status, *words, stop=None):
    """Runs a tool with a report and progress; checks both. Returns the report and the lines."""
    words = [str(word) for word in words]
    Path("r.json").unlink(missing_ok=True)
    call = [TOOLS / words[0], *DISPLAY, "-y", "--report", "r.json", "--progress", "json", *words[1:]]
    with subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        first = process.stdout.readline() if stop else ""
        if stop:
            process.send_signal(stop)
        out, err = process.communicate(timeout=300)
    name = " ".join(words)
    check(process.returncode == status, f"{name}: status {process.returncode}, expected {status}: {err}")
    lines = [json.loads(line) for line in (first + out).splitlines()]
    for line in lines:
        check(not problem(line, "#/$defs/progress"), f"{name}: {line}: {problem(line, '#/$defs/progress')}")
    text = Path("r.json").read_text() if Path("r.json").exists() else "{}"
    report = json.loads(text)
    check(not report or not problem(report), f"{name}: {problem(report)}")
    check(not long_numbers(text + out), f"{name}: {long_numbers(text + out)}")
    ends = [line for line in lines if line["state"] not in ("running", "finishing")]
    if "videos" in report:  # a line ends each video as well
        ends = [end for end in ends if "videos" in end]
    check([end["state"] for end in ends] == [report.get("state", "failed")], f"{name}: ends with {ends}")
    return report, lines


with tempfile.TemporaryDirectory() as work:
    os.chdir(work)
    os.environ.update(HOME=work, ALTIRO3D_MODELS=str(SOURCE / "models"))
    os.mkdir("photos")
    for name in ["a", "b"]:
        os.symlink(EXAMPLES / "sample.jpg", f"photos/{name}.jpg")
    photo, depth = EXAMPLES / "sample.jpg", EXAMPLES / "sample-depth.png"

    report, _ = run(0, "photo2native", "--lg", "s.mp4", "--save-quilt", "q.png", "--save-depth", "d.png",
                    "--save-views", "v", "--seconds", "0.5", "--turns", "1", "--budget", "5000", photo, "n.png")
    check(report["state"] == "done" and report["pictures"][0]["native"] == "n.png", "one photo")
    report, _ = run(0, "photo2native", "--lg", "s.mp4", "--seconds", "0.5", "--turns", "1", "-d", photo, depth)
    check("native" not in report["pictures"][0], "no Native")
    Path("photos/c.jpg").write_text("noise")
    report, lines = run(1, "photo2native", "photos", "natives")
    check([picture.get("code") for picture in report["pictures"]] == [None, None, "BadFormat"], "the code of an error")
    check([line["photos"] for line in lines] == [0, 1, 2, 2], f"photos are counted: {lines}")
    report, _ = run(1, "photo2native", "photos/c.jpg", "n.png")
    check(report["state"] == "failed" and report["pictures"][0]["code"] == "BadFormat", "one that fails")
    os.mkdir("many")  # so that a run outlasts a delay of the signal
    for number in range(60):
        os.symlink(EXAMPLES / "sample.jpg", f"many/{number}.jpg")
    for end, status in [(signal.SIGINT, 130), (signal.SIGTERM, 143)]:
        report, lines = run(status, "photo2native", "many", "natives", stop=end)
        check(report["state"] == "stopped" and len(report["pictures"]) < 60, f"stopped by {end}: {report}")

    subprocess.run([TOOLS / "quilt2video", "-q", "2x4", "--seconds", "2", "--turns", "1", "--fps", "10",
                    "q_qs4x2a0.75.png", "clip.mp4"], check=True, capture_output=True)
    report, _ = run(0, "video2native", "clip.mp4", "n.mp4")
    check(report["frames"] > 10 and isinstance(report["bytes"], int), "a video")
    Path("bad.mp4").write_bytes(Path("clip.mp4").read_bytes()[:500])
    os.mkdir("clips")
    os.rename("bad.mp4", "clips/bad.mp4")
    os.rename("clip.mp4", "clips/clip.mp4")
    report, _ = run(1, "video2native", "clips", "native-clips")
    check(report["state"] == "failed" and "code" in report["videos"][0], f"a folder of videos: {report}")
    report, _ = run(1, "video2native", "clips/clip.mp4", "n.mp4", "--from", "1:00:00")
    check(report["code"] == "BadFormat", f"a video that fails: {report}")

    os.mkdir("scans")
    subprocess.run([TOOLS / "photo2native", "--save-splats", "scans/a.ply", "--splat-side", "60", "-d", photo, depth],
                   check=True, capture_output=True)
    report, _ = run(0, "splat2native", "--save-depth", "d.png", "--save-page", "s.html", "scans/a.ply", "n.png")
    check(report["scenes"][0]["native"] == "n.png", "a scene of splats")
    Path("scans/b.ply").write_text("noise")
    report, lines = run(1, "splat2native", "scans", "scan-natives")
    check([scene.get("code") for scene in report["scenes"]] == [None, "BadFormat"], f"scenes of a folder: {report}")
    report, _ = run(1, "splat2native", "scans/b.ply", "n.png")
    check(report["scenes"][0]["code"] == "BadFormat", "a scene that fails")

    for tool, name in [("photo2native", photo), ("video2native", "clips/clip.mp4"), ("splat2native", "scans/a.ply")]:
        output = "n.mp4" if tool == "video2native" else "n.png"
        report, lines = run(1, tool, "-c", "missing.json", name, output)
        check(not report and lines[0]["code"] == "NotFound", f"a run that does not begin: {lines}")

        # the report of an earlier run does not pass for its own
        for status, more in [(1, ["-c", "missing.json"]), (2, ["--strength", "many"])]:
            Path("old.json").write_text(json.dumps({"tool": tool, "state": "done"}))
            ended = subprocess.run([TOOLS / tool, "-y", "--report", "old.json", *more, name, output],
                                   capture_output=True)
            outdated = json.loads(Path("old.json").read_text())
            check(ended.returncode == status and outdated["state"] == "failed" and "error" in outdated, f"{outdated}")
            check(not problem(outdated), problem(outdated))

    # what is not described must be refused
    report, _ = run(0, "photo2native", "-d", photo, depth, "n.png")
    check(problem(dict(report, more=1)), "an unknown key is valid")
    check(problem(dict(report, state="complete")), "an unknown state is valid")

if not failures:
    print("ok")
sys.exit(1 if failures else 0)
