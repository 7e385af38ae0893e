"""The models by what they are and how large. A model is read when a scene first asks for it."""

import hashlib
import pathlib
import re

import numpy as np

import models
from render import FLOATS, UV, SOLID, TRANSPARENT, material

# pattern on the path below the sources, kind, smallest and largest height in metres (0: the file's)
KINDS = [
    (r"glb/nature_pack/.*(Tree_|Willow_)", "tree", 3, 12),
    (r"glb/nature_pack/(Bush|Plant|Cactus|Flowers|Grass|Corn|Wheat)", "bush", 0.25, 1.3),
    (r"glb/nature_pack/Rock", "rock", 0.2, 2),
    (r"glb/nature_pack/(TreeStump|WoodLog)", "rock", 0.25, 0.6),
    (r"glb/simple_nature_pack/.*Tree", "tree", 3, 9),
    (r"glb/animals_pack/(Alpaca|Bull|Cow|Deer|Donkey|Horse)", "animal", 1.3, 1.8),
    (r"glb/animals_pack/Stag", "animal", 1.6, 2),
    (r"glb/animals_pack/(Fox|Husky|Shiba)", "animal", 0.45, 0.7),
    (r"glb/animals_pack/Wolf", "animal", 0.75, 0.95),
    (r"glb/dinosaurs_pack", "animal", 1.5, 4),
    (r"glb/modular_(wo)?men/", "person", 1.55, 1.95),
    (r"Character-Pack.*/(Knight|Barbarian|Mage|Rogue|Rogue_Hooded)\.glb", "person", 1.2, 1.8),
    (r"glb/house_interior_pack/(Bed_|Couch)", "couch", 0.7, 1.05),
    (
        r"glb/house_interior_pack/(Bookshelf|Kitchen_Fridge|Shelf_Large|Door_[1-9])",
        "tall",
        1.8,
        2.1,
    ),
    (r"glb/house_interior_pack/Chair", "chair", 0.8, 1.05),
    (r"glb/house_interior_pack/Stool", "chair", 0.45, 0.7),
    (
        r"glb/house_interior_pack/(Drawer|Kitchen_[123]D|Kitchen_Cabinet|Kitchen_Oven|"
        r"Kitchen_Sink|Bathroom_W|Fireplace)",
        "cabinet",
        0.75,
        1.1,
    ),
    (
        r"glb/house_interior_pack/(NightStand|Bathroom_Toilet[.2]|Bathroom_Bathtub|Trashcan)",
        "low",
        0.4,
        0.75,
    ),
    (r"glb/house_interior_pack/Houseplant", "plant", 0.25, 1.4),
    (r"glb/house_interior_pack/Light_(Floor|Stand)", "lamp", 1.3, 1.8),
    (r"glb/house_interior_pack/Light_(Ceiling|Chandelier)", "hanging", 0.2, 0.7),
    (
        r"glb/house_interior_pack/(Light_Desk|Light_Cube|Light_Small|Light_Icosahedron)",
        "small",
        0.15,
        0.45,
    ),
    (r"glb/house_interior_pack/Table", "table", 0.45, 0.8),
    (r"glb/house_interior_pack/(Plate|Fork|Knife|Spoon)", "flat", 0.02, 0.04),
    (r"glb/house_interior_pack/Curtains", "curtain", 1.8, 2.4),
    (
        r"glb/(buildings_pack_\d|medieval_village_pack)/(?!.*(Fence|Path|Cart|Barrel|Bag|"
        r"Crate|Well|Hay|Bonfire|Bench|Gazebo|Market|Package|Rock|Smoke|Stairs|Door|"
        r"Window|Wheat))",
        "house",
        5,
        14,
    ),
    (r"City-Builder.*gltf/building_", "house", 5, 22),
    (r"City-Builder.*gltf/car_", "car", 1.35, 1.75),
    (
        r"City-Builder.*gltf/(bench|dumpster|firehydrant|streetlight|trafficlight|trash|"
        r"watertower|bush)",
        "street",
        0.7,
        4,
    ),
    (r"glb/street_pack/(Sign|Streetlight|TrafficLight)", "post", 2.2, 6),
    (r"glb/(rpg_items_pack|survival_pack|crops_pack)/", "small", 0.06, 0.35),
    (r"glb/platformer_game_pack/.*(Tree|Bush|Rock)", "bush", 0.4, 2),
    (
        r"Restaurant-Bits.*gltf/(food_|plate|bowl|pot|pan|jar|bottle|ketchup|mustard|"
        r"crate|lid|cutting|menu|knife|napkin|oven_dish|dishrack|stew|papertowel|"
        r"pillar_cap)",
        "small",
        0.06,
        0.35,
    ),
    (r"Restaurant-Bits.*gltf/(chair|stool)", "chair", 0.6, 1.0),
    (
        r"Restaurant-Bits.*gltf/(kitchencounter|kitchencabinet|oven|stove|fridge)",
        "cabinet",
        0.9,
        1.2,
    ),
    (r"Restaurant-Bits.*gltf/table", "table", 0.6, 0.8),
    (r"Furniture-Bits.*gltf/(armchair|bed_|couch)", "couch", 0.75, 1.0),
    (r"Furniture-Bits.*gltf/cabinet", "cabinet", 0.6, 1.1),
    (r"Furniture-Bits.*gltf/(cactus|lamp_table|pictureframe_standing|book_)", "small", 0.12, 0.45),
    (r"Furniture-Bits.*gltf/chair", "chair", 0.75, 1.0),
    (r"Furniture-Bits.*gltf/lamp_standing", "lamp", 1.4, 1.8),
    (r"Furniture-Bits.*gltf/table_(small|medium|low)", "table", 0.45, 0.78),
    (r"Furniture-Bits.*gltf/pillow", "small", 0.12, 0.25),
    (
        r"gazebo_models/(house_[123]|law_office|salon|thrift_shop|post_office|"
        r"police_station|fire_station|school|gas_station|grocery_store|office_building|"
        r"apartment|collapsed_house|collapsed_industrial|collapsed_police_station)$",
        "house",
        0,
        0,
    ),
    (r"gazebo_models/(oak_tree|pine_tree)$", "tree", 0, 0),
    (r"gazebo_models/pickup$", "car", 0, 0),
    (
        r"gazebo_models/(bus_stop|dumpster|fire_hydrant|jersey_barrier|mailbox|postbox|"
        r"construction_cone|construction_barrel|fountain|drc_practice_ladder|playground|"
        r"warehouse_robot)$",
        "street",
        0,
        0,
    ),
    (r"gazebo_models/(lamp_post|telephone_pole|speed_limit_sign|stop_sign)$", "post", 0, 0),
    (
        r"gazebo_models/(radio_tower|water_tower|tower_crane|powerplant|truss_bridge|"
        r"reactor|pier)$",
        "tower",
        0,
        0,
    ),
    (
        r"gazebo_models/(cardboard_box|grey_tote|euro_pallet|first_2015_trash_can|"
        r"control_console|pr2|cinder_block|nist_stairs_120|cafe_table)$",
        "low",
        0,
        0,
    ),
    (
        r"gazebo_models/(bowl|coke_can|plastic_cup|hammer|cordless_drill|monkey_wrench|"
        r"saucepan|parrot_bebop_2)$",
        "small",
        0.05,
        0.25,
    ),
    (r"(residential_(Bed|Sofa|SofaB|SofaC|FitnessEquipment)_0\d)$", "couch", 0, 0),
    (r"(residential_(Wardrobe|Refrigerator|AirconditionerB)_0\d|retail_BookC_01)$", "tall", 0, 0),
    (r"(residential_Chair[AD]_01|retail_ChairB_01)$", "chair", 0, 0),
    (
        r"(residential_(NightStand|ShoeRack|Trash)_01|retail_(BookD|BookF|BookshelfC)_01|"
        r"warehouse_(Cluttering|Bucket|PalletJack|TrashCan).*)$",
        "low",
        0,
        0,
    ),
    (r"(residential_(KitchenTable|BalconyTable|CoffeeTable|ReadingDesk)_01)$", "table", 0, 0),
    (
        r"(residential_(Vase|Tableware|KitchenUtensils|DeskPortrait[ABC]|Tablet)_0\d|"
        r"retail_(BookE|Computer|Holder|SmartSpeakerTall|MagicCube)_01)$",
        "small",
        0.08,
        0.4,
    ),
    (r"(warehouse_(ShelfD|ShelfE|DeskC)_01)$", "tall", 0, 0),
]
HELD_OUT_SHARE = 7


def smooth_normals(positions, triangles):
    """Normals of all corners of all triangles, averaged where faces meet at flat angles."""
    corners = positions[triangles].reshape(-1, 3)
    face = np.cross(
        positions[triangles[:, 1]] - positions[triangles[:, 0]],
        positions[triangles[:, 2]] - positions[triangles[:, 0]],
    )
    size = np.linalg.norm(face, axis=1, keepdims=True)
    unit = np.repeat(face / np.maximum(size, 1e-20), 3, axis=0)
    extent = np.ptp(corners, axis=0).max() + 1e-9
    keys = np.round(corners / extent * 1e5).astype(np.int64)
    _, which = np.unique(
        keys[:, 0] * 73856093 ^ keys[:, 1] * 19349663 ^ keys[:, 2] * 83492791, return_inverse=True
    )
    total = np.zeros((which.max() + 1, 3))
    np.add.at(total, which, np.repeat(face, 3, axis=0))
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-20)
    mean = total[which]
    return np.where((mean * unit).sum(1, keepdims=True) > 0.75, mean, unit)


class Model:
    """A model in the renderer: its number, extent (z from 0) and parts."""

    def __init__(self, renderer, parts, height, centred=True):
        keep = [p for p in parts if len(p["triangles"])]
        positions, normals, uv, part = [], [], [], []
        for k, p in enumerate(keep):
            t = np.asarray(p["triangles"], int)
            positions.append(np.asarray(p["positions"], float)[t].reshape(-1, 3))
            normals.append(smooth_normals(np.asarray(p["positions"], float), t))
            uv.append(np.asarray(p["uv"], float)[t].reshape(-1, 2))
            part.append(np.full(len(t), k))
        positions = np.vstack(positions)
        low, high = positions.min(0), positions.max(0)
        scale = height / max(high[2] - low[2], 1e-6) if height else 1.0
        if centred:
            positions = (
                positions - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
            ) * scale
        self.low, self.high = positions.min(0), positions.max(0)
        self.size = self.high - self.low
        self.triangles = len(positions) // 3
        self.transparent = any(p["transparent"] for p in keep)
        self.id = renderer.model(
            positions,
            np.arange(len(positions)).reshape(-1, 3),
            np.vstack(uv),
            np.vstack(normals),
            np.concatenate(part),
            self.transparent,
        )
        self.parts = []
        for p in keep:
            texture = renderer.shared_texture(p["picture"]) if p["picture"] is not None else -1
            self.parts.append((np.asarray(p["rgb"], float), texture, p["transparent"]))

    def materials(self, rng, assets, wild=0.25, recolour=0.35):
        """The looks of the parts, varied. wild: how often a plain part shows a photo."""
        tint = np.exp(rng.normal(0, 0.12, 3)) * np.exp(rng.normal(0, 0.15))
        gloss = rng.choice([0, 0.05, 0.3], p=[0.6, 0.25, 0.15])
        hue = rng.random() < recolour
        out = []
        for rgb, texture, transparent in self.parts:
            if texture >= 0:
                out.append(
                    material(
                        np.minimum(rgb * tint, 1.5),
                        texture,
                        paint=UV,
                        gloss=gloss,
                        flags=TRANSPARENT if transparent else 0,
                    )
                )
                continue
            colour = np.clip(rgb, 0.02, 1)
            if hue:
                colour = np.clip(colour.mean() * 0.5 + rng.random(3) * 0.4, 0.02, 1)
            colour = np.clip(colour * tint, 0.01, 1)
            per_metre = 2.0 ** rng.uniform(-1, 1.5) / max(self.size.max(), 0.05)
            if rng.random() < wild:
                out.append(
                    material(
                        np.ones(3) * rng.uniform(0.6, 1.1),
                        assets.any_texture(rng),
                        scale=per_metre,
                        paint=SOLID,
                        gloss=gloss,
                    )
                )
            else:
                out.append(
                    material(
                        colour,
                        paint=SOLID,
                        gloss=gloss,
                        detail=assets.any_stuff(rng),
                        detail_scale=per_metre * 2,
                        detail_strength=rng.uniform(0.0, 0.8),
                    )
                )
        return out


class Library:
    def __init__(self, renderer, cache, held_out):
        self.renderer, self.cache, self.held_out = renderer, pathlib.Path(cache), held_out
        self.source = self.cache / "src"
        self.entries, self.loaded = {}, {}
        files = sorted(self.source.rglob("*.glb")) + sorted(self.source.rglob("gltf/*.gltf"))
        files += sorted({f.parent for f in self.source.rglob("model*.sdf")})
        for path in files:
            name = str(path.relative_to(self.source))
            for pattern, kind, low, high in KINDS:
                if re.search(pattern, name):
                    mine = int(hashlib.sha256(name.encode()).hexdigest(), 16) % HELD_OUT_SHARE == 0
                    if mine == held_out:
                        self.entries.setdefault(kind, []).append((name, low, high))
                    break

    def parts(self, name, pose_seed=0):
        path = self.source / name
        if path.is_dir():
            stored = self.cache / "models" / (name.replace("/", "_") + ".npz")
            if not stored.exists():
                models.save(models.read_sdf_model(path), stored)
            return models.load(stored)
        poses = models.read_gltf(path, 1, np.random.default_rng(pose_seed))
        return poses[0]

    def get(self, rng, kind):
        """A random model of a kind, or None if it cannot be read or is too large."""
        entries = self.entries.get(kind, [])
        if not entries:
            return None
        name, low, high = entries[int(rng.integers(len(entries)))]
        pose = int(rng.integers(4)) if kind in ("animal", "person") else 0
        key = (name, pose)
        if key not in self.loaded:
            try:
                parts = self.parts(name, pose)
                height = (low + high) / 2
                model = Model(self.renderer, parts, height) if parts else None
                if model and kind == "small":  # small things: the largest side counts
                    if model.size.max() > 1.6 * high:
                        model = Model(self.renderer, parts, height * 1.3 * high / model.size.max())
                if model and (
                    model.triangles > 150000
                    or not np.isfinite(model.size).all()
                    or model.size.max() > 130
                ):
                    model = None
            except Exception as error:  # a file that this reader does not know
                print(f"{name}: left out, {error!r}")
                model = None
            self.loaded[key] = model
        return self.loaded[key]
