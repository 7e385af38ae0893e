#!/usr/bin/env python3
"""Makes altiro3d.pyi, the types of the module for editors and mypy, from its docstrings; or checks it.

    PYTHONPATH=build/dev/bindings/python make_stubs.py [--check]

Needs mypy 1.0 (Debian 12), as other versions write the same types in other words. --check fails if
the file is not what would be made, or if stubtest finds that it does not describe the module. With
another version of mypy only stubtest is run; without mypy the program exits with 77.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--check", action="store_true")
given = parser.parse_args()  # before anything that may be missing

import altiro3d

STUBS = Path(__file__).resolve().parent / "altiro3d.pyi"
MYPY = "1.0."

try:
    from mypy import stubdoc, stubgen, stubgenc
    from mypy.version import __version__ as mypy_version
except ImportError:
    print("skipped: needs mypy")
    sys.exit(77)


def made():
    """The stubs, as they would be made."""
    stubdoc._ARG_NAME_RE = re.compile(r"\*{0,2}\w*$")  # `*` before keyword-only arguments
    stubgenc.infer_prop_type_from_docstring = lambda doc: None  # pybind11 states it elsewhere
    with tempfile.TemporaryDirectory() as folder:
        stubgen.main(["-q", "-m", altiro3d.__name__, "-o", folder])
        text = next(Path(folder).rglob("*.pyi")).read_text()
    text = re.sub(r"^    __entries: .*\n", "", text, flags=re.M)  # pybind11's own
    text = text.replace("__hash__: ClassVar[None] = ...",
                        "__hash__: ClassVar[None]  # type: ignore[assignment]")
    text = re.sub(r"List\[(\w+)\[\d+\]\]", r"List[\1]", text)  # of a fixed length
    text = text.replace("Optional[function]", "Optional[Callable[..., Any]]")
    text = text.replace("estimator: function", "estimator: Callable[..., Any]")
    text = text.replace("import Any, ", "import Any, Callable, ")
    # what stubgen does not see
    lines, owner = [], None
    for line in text.splitlines():
        if match := re.match(r"class (\w+)", line):
            owner = match[1]
        if "def __array_wrap__" in line:  # NumPy states less than it allows
            line += "  # type: ignore[override]"
        if re.match(r"    def __(deep)?copy__", line):
            line = line.replace("Any", owner)
        if (match := re.match(r"    def (\w+)\(self, \*args, ", line)) and isinstance(
                vars(getattr(altiro3d, owner))[match[1]], staticmethod):
            doc = getattr(getattr(altiro3d, owner), match[1]).__doc__.splitlines()[0]
            line = f"    @staticmethod\n    def {doc.replace('altiro3d.', '')}: ..."
        lines.append(line)
    return "# Made by make_stubs.py.\n" + "\n".join(lines) + "\n"


def main():
    can_make = mypy_version.startswith(MYPY)
    if not given.check:
        if not can_make:
            print(f"{STUBS}: is not made by mypy {mypy_version}, expected mypy {MYPY}x")
            return 1
        STUBS.write_text(made())
        return 0
    text = STUBS.read_text()
    if can_make and text != made():
        print(f"{STUBS}: is not that of the module, expected what {sys.argv[0]} makes")
        return 1
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "altiro3d.pyi").write_text(text)
        # the metaclass, which stubgen does not write, but not the members
        (Path(folder) / "allowed").write_text("".join(
            f"altiro3d.{name}\n" for name, item in vars(altiro3d).items() if isinstance(item, type)))
        return subprocess.run([sys.executable, "-m", "mypy.stubtest", "altiro3d", "--allowlist",
                               "allowed", "--ignore-unused-allowlist"], cwd=folder,
                              env=dict(os.environ, MYPYPATH=folder)).returncode


if __name__ == "__main__":
    sys.exit(main())
