"""The sources of the training data: which repository at which commit, and what of it is used."""

import pathlib
import subprocess
import sys

# repository: (commit, folders or files used)
SOURCES = {
    "gkjohnson/3d-demo-data": ("a79b5400ba8ed5bdeffebc10ce5adeecda7c3ebc", ["hdri"]),
    "pmndrs/drei-assets": ("456060a26bbeb8fdf79326f224b6d99b8bcce736", ["hdri"]),
    "lightly-ai/coco128_yolo": ("6d6f7a059ea63efffdbe48aca2d52c04d4c510e9", [""]),
    "Obmutescence/COCO-MINI": (
        "644f29e7c1d2eefd9c4412d39bc5b0ee6fd0afd4",
        ["annotations", "train2017", "val2017"],
    ),
    "zzowenzz/COCO_Tiny": (
        "e7a689f7d6d1a1908df287c3e79eccdadfdba1fe",
        ["annotations", "train2017", "val2017"],
    ),
    "enginbozaba/tiny_coco": (
        "44ee1df5a4f5c3fa6ab7c68d85a0d45590758584",
        ["annotations", "images"],
    ),
    "developer0hye/COCO128": (
        "47a3de30aaf7ad1c02105bd80598fb03ac0d0789",
        ["annotations", "train2017"],
    ),
    "minto5z/coco_yolo": (
        "4715f5ca05a6ffc148d4c4e5b0a131663655f2be",
        ["annotations/instances_val2017.json", "coco/images/val2017"],
    ),
    "trebeljahr/quaternius-showcase": ("eab2e43a7e688dad1cc6be764c1c4ba593e1961c", ["public/glb"]),
    "aws-robotics/aws-robomaker-bookstore-world": (
        "ed542eb41809d5c5f1c67f32d4ba24e0e90886b3",
        [""],
    ),
    "aws-robotics/aws-robomaker-hospital-world": ("39969a9d250135835cf13b480865647d1a87b6f4", [""]),
    "aws-robotics/aws-robomaker-small-house-world": (
        "dd44be6205b2e6577bf641300dacc1699cb2ca81",
        [""],
    ),
    "aws-robotics/aws-robomaker-small-warehouse-world": (
        "3c23a698bf0b4e366ddf8b084af507c519bd3483",
        [""],
    ),
    "KayKit-Game-Assets/KayKit-Furniture-Bits-1.0": (
        "96d5930a8dbdb363409bbc2d3341718b00e17c9c",
        [""],
    ),
    "KayKit-Game-Assets/KayKit-Restaurant-Bits-1.0": (
        "153c8a7535b48237854cb54ff6890679f8c574d1",
        [""],
    ),
    "KayKit-Game-Assets/KayKit-City-Builder-Bits-1.0": (
        "63976910ca04d16f0fc531b9c614244be8128713",
        [""],
    ),
    "KayKit-Game-Assets/KayKit-Character-Pack-Adventures-1.0": (
        "672074b73ba276876a19e8816ecdc5241817ab47",
        [""],
    ),
    "osrf/gazebo_models": ("8163eb4b5e7e21985c6591d1c0bfb56468c0093f", [""]),
}


def extract(mirrors, into):
    """Writes the files of all sources below `into`. A blob that a mirror lacks is left out."""
    for name, (commit, folders) in SOURCES.items():
        git = ["git", f"--git-dir={mirrors}/{name.replace('/', '+')}/repo"]
        if subprocess.run(git + ["cat-file", "-e", commit], capture_output=True).returncode:
            sys.exit(f"{mirrors}: lacks {name} at {commit}, expected a bare mirror OWNER+NAME/repo")
        listing = subprocess.run(
            git + ["ls-tree", "-r", "-z", commit], check=True, capture_output=True
        ).stdout
        files = []
        for entry in listing.decode().split("\0")[:-1]:
            meta, path = entry.split("\t", 1)
            mode, _, blob = meta.split()
            if mode != "120000" and any(
                not f or path == f or path.startswith(f + "/") for f in folders
            ):
                files.append((blob, path))
        target = pathlib.Path(into) / name.replace("/", "+")
        done = target / ".complete"
        if done.exists() and done.read_text() == commit:
            continue
        cat = subprocess.Popen(
            git + ["cat-file", "--batch"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        missing = 0
        for blob, path in files:
            cat.stdin.write(f"{blob}\n".encode())
            cat.stdin.flush()
            header = cat.stdout.readline().split()
            if len(header) != 3 or header[1] != b"blob":
                missing += 1
                continue
            data = cat.stdout.read(int(header[2]))
            cat.stdout.read(1)
            out = target / path
            out.parent.mkdir(parents=True, exist_ok=True)
            out.write_bytes(data)
        cat.stdin.close()
        cat.wait()
        done.write_text(commit)
        print(f"{name}: {len(files) - missing} files, {missing} not in the mirror")
