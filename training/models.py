"""Reads models (GLB, glTF, Collada) and Gazebo worlds into plain arrays; z up, metres.

A part is a dictionary: positions, triangles, uv, rgb, picture (array or None), transparent.
"""

import base64
import hashlib
import io
import json
import pathlib
import re
import struct
import warnings
import xml.etree.ElementTree as ElementTree

import cv2
import numpy as np

KINDS = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
DECODED = {}  # pictures by the hash of their file; many models share one
Z_UP = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])


def decode(data):
    """An 8-bit picture, RGB or RGBA, at most 512 px; the same object for the same file."""
    key = hashlib.sha1(data).digest()
    if key not in DECODED:
        DECODED[key] = decode_anew(data)
    return DECODED[key]


def decode_anew(data):
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if picture is None:
        return None
    if picture.ndim == 2:
        picture = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
    if picture.dtype != np.uint8:
        picture = (picture / 257).astype(np.uint8)
    code = cv2.COLOR_BGRA2RGBA if picture.shape[2] == 4 else cv2.COLOR_BGR2RGB
    picture = cv2.cvtColor(picture, code)
    side = max(picture.shape[:2])
    if side > 512:
        picture = cv2.resize(
            picture, None, fx=512 / side, fy=512 / side, interpolation=cv2.INTER_AREA
        )
    return picture


def rotation(q):
    x, y, z, w = q / max(np.linalg.norm(q), 1e-12)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


class Gltf:
    """One GLB or glTF file."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        data = self.path.read_bytes()
        self.buffers = []
        if data[:4] == b"glTF":
            size = struct.unpack("<I", data[12:16])[0]
            self.json = json.loads(data[20 : 20 + size])
            rest = data[20 + size :]
            if len(rest) > 8:
                self.buffers.append(rest[8 : 8 + struct.unpack("<I", rest[:4])[0]])
        else:
            self.json = json.loads(data)
            for b in self.json["buffers"]:
                self.buffers.append(self.resource(b["uri"]))
        if "KHR_draco_mesh_compression" in self.json.get("extensionsRequired", []):
            raise ValueError("compressed")

    def resource(self, uri):
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (self.path.parent / uri.replace("%20", " ")).read_bytes()

    def accessor(self, index):
        a = self.json["accessors"][index]
        kind, width = np.dtype(KINDS[a["componentType"]]), WIDTHS[a["type"]]
        if "bufferView" not in a:
            return np.zeros((a["count"], width), kind)
        view = self.json["bufferViews"][a["bufferView"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        stride = view.get("byteStride", 0) or kind.itemsize * width
        raw = np.frombuffer(self.buffers[view.get("buffer", 0)], np.uint8)
        rows = np.lib.stride_tricks.as_strided(
            raw[start:], (a["count"], kind.itemsize * width), (stride, 1)
        )
        out = np.ascontiguousarray(rows).view(kind).reshape(a["count"], width)
        return out / np.iinfo(kind).max if a.get("normalized") else out

    def picture(self, texture):
        image = self.json["images"][self.json["textures"][texture]["source"]]
        if "uri" in image:
            return decode(self.resource(image["uri"]))
        view = self.json["bufferViews"][image["bufferView"]]
        start = view.get("byteOffset", 0)
        return decode(self.buffers[view.get("buffer", 0)][start : start + view["byteLength"]])

    def matrices(self, animation, moment, turns=None):
        """The matrix of each node in the world, in the pose of an animation (None: at rest).

        turns: rotations about the node's own place, 3 x 3, by the names of nodes."""
        nodes = self.json["nodes"]
        poses = [
            {k: np.array(n[k], float) for k in ("translation", "rotation", "scale") if k in n}
            for n in nodes
        ]
        if animation is not None:
            for c in animation["channels"]:
                path = c["target"]["path"]
                if path not in ("translation", "rotation", "scale") or "node" not in c["target"]:
                    continue
                sampler = animation["samplers"][c["sampler"]]
                times = self.accessor(sampler["input"]).ravel()
                values = self.accessor(sampler["output"])
                step = 3 if sampler.get("interpolation") == "CUBICSPLINE" else 1
                k = int(
                    np.clip(
                        np.searchsorted(times, times[0] + moment * (times[-1] - times[0])),
                        0,
                        len(times) - 1,
                    )
                )
                poses[c["target"]["node"]][path] = np.array(values[k * step + (step == 3)], float)
        local = []
        for n, p in zip(nodes, poses):
            if "matrix" in n:
                local.append(np.array(n["matrix"], float).reshape(4, 4).T)
                continue
            m = np.eye(4)
            m[:3, :3] = rotation(p.get("rotation", np.array([0, 0, 0, 1.0]))) * p.get(
                "scale", np.ones(3)
            )
            m[:3, 3] = p.get("translation", np.zeros(3))
            local.append(m)
        world = [None] * len(nodes)

        def walk(index, parent):
            world[index] = parent @ local[index]
            turn = (turns or {}).get(nodes[index].get("name"))
            if turn is not None:
                world[index][:3, :3] = turn @ world[index][:3, :3]
            for child in nodes[index].get("children", []):
                walk(child, world[index])

        for root in self.json["scenes"][self.json.get("scene", 0)]["nodes"]:
            walk(root, np.eye(4))
        return world

    def parts(self, animation=None, moment=0.0, turns=None):
        world = self.matrices(animation, moment, turns)
        out = []
        for index, node in enumerate(self.json["nodes"]):
            if "mesh" not in node or world[index] is None:
                continue
            for p in self.json["meshes"][node["mesh"]]["primitives"]:
                if p.get("mode", 4) != 4:
                    continue
                at = p["attributes"]
                positions = self.accessor(at["POSITION"]).astype(float)
                one = np.hstack([positions, np.ones((len(positions), 1))])
                if "skin" in node and "JOINTS_0" in at:
                    skin = self.json["skins"][node["skin"]]
                    inverse = (
                        self.accessor(skin["inverseBindMatrices"])
                        .reshape(-1, 4, 4)
                        .transpose(0, 2, 1)
                    )
                    bones = np.stack([world[j] @ inverse[k] for k, j in enumerate(skin["joints"])])
                    weights = self.accessor(at["WEIGHTS_0"]).astype(float)
                    weights = weights / np.maximum(weights.sum(1, keepdims=True), 1e-9)
                    mixed = np.einsum(
                        "nk,nkij->nij", weights, bones[self.accessor(at["JOINTS_0"]).astype(int)]
                    )
                    positions = np.einsum("nij,nj->ni", mixed, one)[:, :3]
                else:
                    positions = one @ world[index].T[:, :3]
                triangles = (
                    self.accessor(p["indices"]).astype(int)
                    if "indices" in p
                    else np.arange(len(positions))
                ).reshape(-1, 3)
                m = self.json["materials"][p["material"]] if "material" in p else {}
                pbr = m.get("pbrMetallicRoughness", {})
                picture = (
                    self.picture(pbr["baseColorTexture"]["index"])
                    if "baseColorTexture" in pbr
                    else None
                )
                uv = (
                    self.accessor(at["TEXCOORD_0"]).astype(float)
                    if "TEXCOORD_0" in at
                    else np.zeros((len(positions), 2))
                )
                out.append(
                    {
                        "positions": positions @ Z_UP[:3, :3].T,
                        "triangles": triangles,
                        "uv": uv,
                        "rgb": np.array(pbr.get("baseColorFactor", [0.8, 0.8, 0.8])[:3]),
                        "picture": picture,
                        "transparent": m.get("alphaMode") in ("MASK", "BLEND")
                        and picture is not None
                        and picture.shape[2] == 4,
                    }
                )
        return out


def turn_about(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def natural_pose(rng):
    """Arms down, a step, a bend: for bodies that stand with their arms stretched out (y up)."""
    step = rng.normal(0, 0.35)
    out = {
        "Chest": turn_about("x", rng.normal(0, 0.08)),
        "Neck": turn_about("x", rng.normal(0, 0.15)),
    }
    for side, sign in (("L", 1), ("R", -1)):
        down = rng.uniform(1.0, 1.5) if rng.random() < 0.85 else rng.uniform(-0.9, 0.9)
        out[f"UpperArm.{side}"] = turn_about("x", rng.normal(0, 0.3) - sign * step) @ turn_about(
            "z", -sign * down
        )
        out[f"LowerArm.{side}"] = turn_about("x", -abs(rng.normal(0, 0.7)))
        out[f"UpperLeg.{side}"] = turn_about("x", sign * step)
        out[f"LowerLeg.{side}"] = turn_about("x", abs(rng.normal(0, 0.25)))
    return out


def read_gltf(path, poses=0, rng=None):
    """The parts of a file, once or in some poses of its animations."""
    g = Gltf(path)
    animations = [
        a
        for a in g.json.get("animations", [])
        if not any(w in a.get("name", "").lower() for w in ("death", "die", "lie"))
    ]
    if not poses or not g.json.get("skins"):
        return [g.parts()]
    if not animations:
        return [g.parts(turns=natural_pose(rng)) for _ in range(poses)]
    return [
        g.parts(animations[int(rng.integers(len(animations)))], rng.random()) for _ in range(poses)
    ]


def read_collada(path):
    import collada

    path = pathlib.Path(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        text = re.sub(
            rb"<!--.*?-->", b"", path.read_bytes().strip(), flags=re.S
        )  # the reader stumbles over comments
        mesh = collada.Collada(io.BytesIO(text), ignore=[collada.DaeError])
    up = Z_UP if mesh.assetInfo.upaxis == "Y_UP" else np.eye(4)
    if mesh.assetInfo.upaxis == "X_UP":
        up = np.array([[0, -1, 0, 0], [0, 0, -1.0, 0], [1, 0, 0, 0], [0, 0, 0, 1]])
    unit = mesh.assetInfo.unitmeter or 1.0
    pictures, out = {}, []
    for geometry in mesh.scene.objects("geometry"):
        for p in geometry.primitives():
            kind = type(p).__name__
            if kind == "BoundPolylist" or kind == "BoundPolygons":
                p = p.triangleset()
            elif kind != "BoundTriangleSet":
                continue
            if p.vertex is None or len(p.vertex_index) == 0:
                continue
            positions = np.asarray(p.vertex)[p.vertex_index].reshape(-1, 3).astype(float) * unit
            has_uv = len(p.texcoordset) > 0
            uv = (
                np.asarray(p.texcoordset[0])[p.texcoord_indexset[0]].reshape(-1, 2)
                if has_uv
                else np.zeros((len(positions), 2))
            )
            uv = np.stack([uv[:, 0], 1 - uv[:, 1]], 1).astype(float)
            rgb, picture = np.array([0.7, 0.7, 0.7]), None
            effect = p.material.effect if p.material is not None else None
            diffuse = getattr(effect, "diffuse", None)
            if isinstance(diffuse, tuple):
                rgb = np.array(diffuse[:3], float)
            elif diffuse is not None:
                rgb = np.ones(3)
                name = diffuse.sampler.surface.image.path
                if name not in pictures:
                    pictures[name] = find_picture(path, name)
                picture = pictures[name]
                if picture is None:
                    rgb = np.array([0.6, 0.58, 0.55])
            seen = (
                picture is not None
                and picture.shape[2] == 4
                and (picture[..., 3] < 128).mean() > 0.02
            )
            out.append(
                {
                    "positions": positions @ up[:3, :3].T,
                    "triangles": np.arange(len(positions)).reshape(-1, 3),
                    "uv": uv,
                    "rgb": rgb,
                    "picture": picture,
                    "transparent": bool(seen),
                }
            )
    return out


def find_picture(path, name):
    name = name.replace("file://", "").replace("\\", "/").replace("%20", " ")
    base = pathlib.Path(name).name
    for folder in (
        path.parent,
        path.parent / pathlib.Path(name).parent,
        path.parent.parent / "materials" / "textures",
        path.parent / "textures",
        path.parent.parent / "textures",
    ):
        if (folder / base).is_file():
            return decode((folder / base).read_bytes())
    return None


def pose_matrix(text):
    """Six numbers of SDF: position, roll, pitch, yaw."""
    x, y, z, r, p, w = ([float(t) for t in (text or "").split()] + [0] * 6)[:6]
    cr, sr, cp, sp, cy, sy = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(w), np.sin(w)
    m = np.eye(4)
    m[:3, :3] = (
        np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    )
    m[:3, 3] = [x, y, z]
    return m


def moved(parts, matrix, scale=1.0):
    matrix = matrix.copy()
    matrix[:3, :3] = matrix[:3, :3] * scale
    return [dict(p, positions=p["positions"] @ matrix[:3, :3].T + matrix[:3, 3]) for p in parts]


def read_sdf_model(folder):
    """All visuals of a Gazebo model in its frame."""
    folder = pathlib.Path(folder)
    files = sorted(folder.glob("model*.sdf"), key=lambda f: f.name != "model.sdf")
    root = ElementTree.parse(files[0]).getroot()
    out = []
    for link in root.iter("link"):
        at = pose_matrix(link.findtext("pose"))
        for visual in link.findall("visual"):
            here = at @ pose_matrix(visual.findtext("pose"))
            uri = visual.findtext("geometry/mesh/uri")
            if not uri:
                continue
            path = folder.parent / uri.replace("model://", "").replace("file://models/", "")
            if path.suffix.lower() != ".dae" or not path.is_file():
                continue
            scale = np.array(
                [float(t) for t in (visual.findtext("geometry/mesh/scale") or "1 1 1").split()]
            )
            out += moved(read_collada(path), here, scale)
    return out


def read_world(path):
    """The placements of a Gazebo world: (name of the model, 4 x 4 matrix)."""
    out = []
    root = ElementTree.parse(path).getroot().find("world")
    for node in root:
        if node.tag not in ("model", "include"):
            continue
        uri = node.findtext("uri") or node.findtext("include/uri")
        if uri and uri.startswith("model://"):
            pose = pose_matrix(node.findtext("pose"))
            if node.tag == "model" and node.find("include/pose") is not None:
                pose = pose @ pose_matrix(node.findtext("include/pose"))
            out.append((uri.replace("model://", "").strip("/"), pose))
    return out


def save(parts, path):
    """Stores parts as one file; the renderer's triangles with one number of a material each."""
    arrays, info = {}, []
    for k, p in enumerate(parts):
        arrays[f"p{k}"], arrays[f"t{k}"] = p["positions"].astype(np.float32), p["triangles"].astype(
            np.int32
        )
        arrays[f"u{k}"] = p["uv"].astype(np.float32)
        if p["picture"] is not None:
            arrays[f"i{k}"] = p["picture"]
        info.append({"rgb": [float(c) for c in p["rgb"]], "transparent": p["transparent"]})
    buffer = io.BytesIO()
    np.savez(buffer, info=np.frombuffer(json.dumps(info).encode(), np.uint8), **arrays)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_bytes(buffer.getvalue())
    part.rename(path)


def load(path):
    data = np.load(path)
    info = json.loads(bytes(data["info"]))
    return [
        dict(
            i,
            rgb=np.array(i["rgb"]),
            positions=data[f"p{k}"],
            triangles=data[f"t{k}"],
            uv=data[f"u{k}"],
            picture=data[f"i{k}"] if f"i{k}" in data.files else None,
        )
        for k, i in enumerate(info)
    ]
