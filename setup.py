"""Builds the package altiro3d with CMake: the module, the library that it needs, and their data."""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).resolve().parent
VERSION = re.search(r"project\(altiro3D VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


class CMakeBuild(build_ext):
    """The package's folder is the prefix of an installation of its own."""

    def build_extension(self, ext):
        package = Path(self.get_ext_fullpath(ext.name)).resolve().parent
        build = Path(self.build_temp).resolve()
        off = [f"-DALTIRO3D_BUILD_{part}=OFF" for part in ("TOOLS", "QT", "TESTS", "BENCHMARKS")]
        subprocess.run(["cmake", "-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release", *off,
                        "-DALTIRO3D_DATA_FROM_SOURCE=OFF", f"-DPython3_EXECUTABLE={sys.executable}",
                        "-DCMAKE_INSTALL_LIBDIR=lib", "-DALTIRO3D_PYTHON_PACKAGE=.",
                        *os.environ.get("CMAKE_ARGS", "").split()], check=True)
        subprocess.run(["cmake", "--build", build, "--parallel", str(os.cpu_count())], check=True)
        for component in ("library", "runtime", "python"):
            subprocess.run(["cmake", "--install", build, "--prefix", package, "--strip",
                            "--component", component], check=True)
        shutil.rmtree(package / "share/doc")
        for link in (package / "lib").iterdir():  # wheels hold no links
            if link.is_symlink():
                link.resolve().rename(link)
        if not list(package.glob("__init__.*.so")):
            sys.exit("the module was not built: it needs NumPy, pybind11-dev and python3-dev")


setup(version=VERSION, packages=[], cmdclass={"build_ext": CMakeBuild},
      ext_modules=[Extension("altiro3d.__init__", sources=[])])
