#!/usr/bin/env python3
"""Makes an icon for Windows (.ico) that holds one picture (.png), of 256 px at most.

    scripts/make-icon.py PICTURE.png ICON.ico
"""
import struct
import sys
from pathlib import Path

picture = Path(sys.argv[1]).read_bytes()
width, height = struct.unpack(">II", picture[16:24])
header = struct.pack("<HHHBBBBHHII", 0, 1, 1, width % 256, height % 256, 0, 0, 1, 32, len(picture), 22)
Path(sys.argv[2]).write_bytes(header + picture)
