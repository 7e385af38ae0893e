"""The furnished Gazebo worlds: where their models stand and where a camera may."""

import numpy as np

import models
from library import Model

# world file: repository, height of the ceiling, x and y where a camera may stand, share of frames
WORLDS = {
    "small_house.world": (
        "aws-robotics+aws-robomaker-small-house-world",
        2.95,
        (-9, 9),
        (-5.2, 5.2),
        3,
    ),
    "bookstore.world": (
        "aws-robotics+aws-robomaker-bookstore-world",
        3.65,
        (-7.3, 7.3),
        (-6.8, 6.8),
        2,
    ),
    "small_warehouse.world": (
        "aws-robotics+aws-robomaker-small-warehouse-world",
        9.0,
        (-6.5, 6.5),
        (-10, 10),
        1,
    ),
}
FIXED = (
    "floor",
    "wall",
    "ceiling",
    "roof",
    "window",
    "door",
    "ground",
    "curtain",
    "column",
    "lamp",
    "elevator",
    "carpet",
    "ramp",
    "light",
)


class World:
    def __init__(self, library, file):
        repository, self.ceiling, self.x, self.y, self.share = WORLDS[file]
        folder = library.source / repository
        names = {}
        self.placements = []
        for name, matrix in models.read_world(folder / "worlds" / file):
            path = folder / "models" / name
            if (
                not np.isfinite(matrix).all()
                or np.abs(matrix[:3, 3]).max() > 200
                or not path.is_dir()
            ):
                continue
            if name not in names:
                try:
                    parts = library.parts(str(path.relative_to(library.source)))
                except Exception as error:  # a file that this reader does not know
                    print(f"{name}: left out, {error!r}")
                    parts = None
                names[name] = Model(library.renderer, parts, 0, centred=False) if parts else None
            if names[name] is not None:
                self.placements.append(
                    (names[name], matrix[:3], any(w in name.lower() for w in FIXED))
                )

    def camera(self, rng):
        """A random place and direction at the height of a person's eyes or hands."""
        return np.array(
            [rng.uniform(*self.x), rng.uniform(*self.y), rng.uniform(0.7, 1.9)]
        ), rng.uniform(0, 2 * np.pi)


def read_worlds(library):
    return [World(library, f) for f in WORLDS]
