#!/usr/bin/env bash
# Installs the Python package from a clone into a virtual environment, and uses it there.
#
#   python_test.sh SOURCE PYTHON
set -euo pipefail
source=$1
python=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! "$python" -c 'import venv, ensurepip, setuptools, wheel' 2>/dev/null; then
    echo "skipped: needs python3-venv, python3-setuptools and python3-wheel"
    exit 77
fi
mkdir "$work/clone"
(cd "$source" && git ls-files -z | xargs -0 cp --parents -t "$work/clone")
"$python" -m venv --system-site-packages "$work/venv"
"$work/venv/bin/pip" install --no-build-isolation --no-index "$work/clone"
rm -rf "$work/clone"
cd "$work"
cat >use.py <<'PYTHON'
import pathlib
import altiro3d
package = pathlib.Path(altiro3d.__file__).parent
loaded = pathlib.Path("/proc/self/maps").read_text()
assert str(package / "lib/libaltiro3D.so") in loaded, "the library is not the package's own"
display = altiro3d.read_display(altiro3d.data_directories()[0] / "calibration/portrait-sample.json")
photo = altiro3d.read_photo(altiro3d.data_directories()[0] / "examples/sample.jpg")
native = altiro3d.NativeMaker(display).make_native(altiro3d.estimated_depth().read_scene(photo))
altiro3d.write_image("native.tif", native)  # by OpenCV's codecs, in a library of their own
assert altiro3d.read_photo("native.tif").shape == (2048, 1536, 3)
assert (package / "__init__.pyi").stat().st_size > 1000 and (package / "py.typed").exists()
PYTHON
"$work/venv/bin/python" use.py
"$work/venv/bin/pip" show -f altiro3d | grep 'altiro3d/share/altiro3D/models/altiro3d-depth.onnx'
