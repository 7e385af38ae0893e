#!/usr/bin/env bash
# Runs the Python of docs/map-format.md on a table that altiro3Dnative has just written.
# usage: map_format_test.sh ALTIRO3DNATIVE SOURCE_DIRECTORY
set -euo pipefail
tool=$1
source=$2
python=
for candidate in python3 /usr/bin/python3; do
    ! "$candidate" -c 'import numpy' 2>/dev/null || { python=$candidate; break; }
done
if [[ -z $python ]]; then
    echo "skipped: needs python3 with numpy"
    exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$tool" -m "$work/a.map" "$source/calibration/portrait-sample.json" >/dev/null
sed -n '/^```python$/,/^```$/p' "$source/docs/map-format.md" | sed '/^```/d' >"$work/read.py"
[[ -s $work/read.py ]]
# and a quilt whose pixels know their view must come out as the views that the reader computes
cat >>"$work/read.py" <<'PYTHON'

quilt = np.zeros((quilt_h, quilt_w, 3), np.uint8)
for i in range(views):
    y = (rows - 1 - i // columns) * tile_h
    x = (i % columns) * tile_w
    quilt[y:y + tile_h, x:x + tile_w] = i
assert (native(quilt) == view.transpose(1, 2, 0)).all()
print("native agrees")
PYTHON
"$python" "$work/read.py" "$work/a.map" | tee "$work/out"
grep -q '^panel 1536 x 2048, 8 columns x 6 rows, 48 views$' "$work/out"
grep -q '^native agrees$' "$work/out"
