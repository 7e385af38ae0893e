#!/usr/bin/env python3
"""Makes a Native of each photo that appears in a folder, until Ctrl-C.

    watch_folder.py visual.json photos/ natives/
"""
import sys
import time
from pathlib import Path

import altiro3d


class Watcher:
    """Photos of one folder, Natives in another."""

    def __init__(self, calibration, photos, natives):
        options = altiro3d.NativeOptions()
        options.show_as(altiro3d.Detail.Lens)
        self.maker = altiro3d.NativeMaker(altiro3d.read_display(calibration), options=options)
        self.depth = altiro3d.stored_depth_or(altiro3d.estimated_depth())
        self.photos, self.natives = Path(photos), Path(natives)
        self.sizes = {}

    def look(self):
        """Converts what is new and has stopped growing since the last look. Returns the Natives."""
        made = []
        for photo in altiro3d.list_images(self.photos):
            native = self.natives / (photo.stem + ".png")
            size = photo.stat().st_size
            has_settled = self.sizes.get(photo) == size
            self.sizes[photo] = size
            if not has_settled or native.exists():
                continue
            try:
                scene = self.depth.read_scene(self.depth.read_photo(photo))
                picture = self.maker.make_native(scene)
                altiro3d.write_image(native, picture, mark=altiro3d.ImageMark.Native)
                made.append(native)
            except altiro3d.Error as error:
                print(error, file=sys.stderr)
                self.sizes[photo] = None  # again when it has changed
        return made


if __name__ == "__main__":
    watcher = Watcher(*sys.argv[1:])
    try:
        while True:
            for made_now in watcher.look():
                print(made_now, flush=True)
            time.sleep(1)
    except KeyboardInterrupt:
        pass
