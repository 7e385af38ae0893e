#!/usr/bin/env bash
# The documents have no dead links and commands; and a document that has them does not pass.
# usage: links_test.sh TOOLS_DIRECTORY SOURCE_DIRECTORY
set -euo pipefail
tools=$1
source=$2
command -v python3 >/dev/null || { echo "skipped: needs python3"; exit 77; }
"$source/scripts/check-links.py" "$tools"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/good.md" <<'TEXT'
# A heading, with `code` & more

[here](#a-heading-with-code--more) [there](bad.md#bad) [web](https://nowhere.invalid/)

    photo2native -k --strength=5 --save-quilt q.png -- -photo.png out.png | quilt2native -m a.map
    altiro3Dimage -n model.onnx -q 6x8 photo.jpg out.png
    native2view --angle -10 native.png out.png
    photo2native --method real [--fit contain] --inpaint-from=behind --fill FILL photo.jpg out.png

`--method layered|fast`, `--fit=cover`, `quilt2native --sampling`, `--invert MODE`.

Not a command: `quilt2native_test`, `--lg`, a drawing:

    photo ─► depth --nothing

TEXT
cat >"$work/bad.md" <<'TEXT'
# Bad

[gone](gone.md) and [no heading](good.md#bad) and <img src="gone.png">, `--no-such-option`.

    photo2native --no-depth photo.png out.png
    LC_ALL=C view2native views out.png
    scripts/gone.sh

```sh
altiro3Dvideo --lg a.mp4 b.mp4
altiro3Dvideo --method slow a.mp4 b.mp4
photo2native --fit=crop photo.jpg out.png
```

`--fill nothing` and `--invert=maybe`.
TEXT
"$source/scripts/check-links.py" "$tools" "$work/good.md"
status=0
"$source/scripts/check-links.py" "$tools" "$work/bad.md" >"$work/found" || status=$?
cat >"$work/wanted" <<'TEXT'
3: --no-such-option: no tool has this option
3: gone.md: leads nowhere
3: gone.png: leads nowhere
3: good.md#bad: good.md has no such heading
5: photo2native: has no option --no-depth
6: view2native: no such command
7: scripts/gone.sh: no such script
10: altiro3Dvideo: has no option --lg
11: altiro3Dvideo: --method has no value 'slow', only fast|layered|real
12: photo2native: --fit has no value 'crop', only auto|contain|cover|stretch
15: --fill has no value 'nothing', only background|continue
15: --invert has no value 'maybe', only auto|off|on
TEXT
sed -n "s|^$work/bad.md:||p" "$work/found" | diff "$work/wanted" -
[[ $status -eq 1 ]]
