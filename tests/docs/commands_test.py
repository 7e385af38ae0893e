#!/usr/bin/env python3
"""Runs the commands of a document, from top to bottom, as somebody who copies each of them.

    commands_test.py TOOLS_DIRECTORY SOURCE_DIRECTORY DOCUMENT.md
    commands_test.py TOOLS_DIRECTORY SOURCE_DIRECTORY    tests that faults are found

Commands are the indented blocks, and the fenced blocks without a language or with sh. All run in one
shell, which begins in a clone of the source with TOOLS_DIRECTORY as its build; the home directory is
empty. The first command that fails ends the test. NOT_RUN says which commands are left out, and why;
each of them is listed.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

NOT_RUN = [
    (r"^(sudo |git clone )|^scripts/(?!get-models)", "installs packages, downloads or builds"),
    (r"get-models\.sh", "downloads"),
    (r"^altiro3Dview (?!--list-displays$)| --show\b", "needs a screen"),
    (r"/media/", "needs a display"),
    (r"/dev/video", "needs a camera"),
    (r"^slide2native slide\.mp4 ", "needs a clip of a slid camera"),
    (r" (-n|--network|-l|--large) |\.onnx", "needs a depth network"),
]
if not shutil.which("ffmpeg"):
    NOT_RUN.append((r"^ffmpeg ", "needs ffmpeg"))


def commands_of(text):
    """The commands of a document, with the number of their first line."""
    fence, in_block, before_blank, going_on = None, False, True, False
    for number, line in enumerate(text.splitlines(), 1):
        mark = re.match(r"```(\w*)", line)
        if mark:
            fence = None if fence is not None else mark[1]
            continue
        in_block = fence is None and line.startswith("    ") and (before_blank or in_block)
        before_blank = not line.strip()
        if not before_blank and (in_block or fence in ("", "sh", "bash")):
            if not going_on:
                first, command = number, []
            command.append(line.strip())
            going_on = line.endswith("\\")
            if not going_on:
                yield first, "\n".join(command)


def reason_not_to_run(command):
    return next((reason for rule, reason in NOT_RUN if re.search(rule, command)), None)


def run(tools, source, text, work):
    """Runs the commands of a document; returns how many ran, those that did not, and the fault."""
    clone, home = work / "altiro3D", work / "home"
    (clone / "build/package").mkdir(parents=True)
    (clone / "build/package/tools").symlink_to(tools)
    home.mkdir()
    for entry in source.iterdir():
        if not entry.name.startswith((".", "build")):
            (clone / entry.name).symlink_to(entry)
    left_out, script = [], ["set -o pipefail"]
    for number, command in commands_of(text):
        reason = reason_not_to_run(command)
        if reason:
            left_out.append((number, command, reason))
        else:
            script += [f"echo {number} >&3; {command}", 'status=$?; [ "$status" = 0 ] || exit "$status"']
    (work / "script").write_text("\n".join(script) + "\n")
    environment = {key: os.environ[key] for key in ("PATH", "LANG", "USER") if key in os.environ}
    environment.update(HOME=str(home), QT_QPA_PLATFORM="offscreen")
    with open(work / "log", "w") as log:
        status = subprocess.run(["bash", "-c", f". '{work}/script' 3>'{work}/lines'"], cwd=clone,
                                env=environment, stdin=subprocess.DEVNULL, stdout=log,
                                stderr=subprocess.STDOUT, check=False).returncode
    lines = (work / "lines").read_text().split()
    fault = None
    if status:
        command = dict((str(number), command) for number, command in commands_of(text))[lines[-1]]
        end = "".join((work / "log").read_text().splitlines(keepends=True)[-10:])
        fault = f"{lines[-1]}: status {status}: {command}\n{end}"
    return len(lines), left_out, fault


def run_document(tools, source, document):
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as work:
        count, left_out, fault = run(tools, source, document.read_text(), Path(work))
        keep = os.environ.get("ALTIRO3D_KEEP_DOCUMENTS")  # to look at what was made
        if keep:
            shutil.copytree(Path(work) / "home", Path(keep) / document.stem, dirs_exist_ok=True)
    for number, command, reason in left_out:
        print(f"{document}:{number}: not run, {reason}: {command}")
    print(f"{document}: {count} commands run in {time.monotonic() - begin:.0f} s, {len(left_out)} not")
    if fault:
        print(f"{document}:{fault}")
    return 1 if fault or not count else 0


def test_faults(tools, source):
    """A document passes whose commands depend on each other, and one with a fault does not."""
    good = ("    export PATH=$PWD/build/package/tools:$PATH\n    mkdir ~/a\n    cd ~/a\n\n"
            "    sudo false\n    photo2native --version >b\n\n```sh\ncat b | \\\n    grep -q 0\n```\n"
            "```python\nno shell\n```\n    text after text\n")
    wanted = [
        (good, 5, None),
        ("    true\n    photo2native none.jpg out.png\n    true\n", 2, "2: status "),
        ("    cat quilt.png\n    touch quilt.png\n", 1, "1: status 1: cat quilt.png\n"),
        ("    true\n    false | true\n", 2, "2: status 1"),
        ("    true\n    echo 'open\n", 1, "1: status "),
    ]
    for text, count, fault in wanted:
        with tempfile.TemporaryDirectory() as work:
            found = run(tools, source, text, Path(work))
        fine = found[2] is None if fault is None else (found[2] or "").startswith(fault)
        if found[0] != count or not fine:
            print(f"FAILED: {text}\nfound {found}, expected {count} commands, {fault}")
            return 1
    print("faults are found")
    return 0


def main():
    if len(sys.argv) not in (3, 4):
        print(__doc__, file=sys.stderr)
        return 2
    tools, source = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    if len(sys.argv) == 3:
        return test_faults(tools, source)
    return run_document(tools, source, Path(sys.argv[3]))


if __name__ == "__main__":
    sys.exit(main())
