#!/usr/bin/env python3
"""Checks that the includes of the library follow its rooms (docs/architecture.md).

A room may include itself and the rooms before it, and no chain of includes returns to where it began.
A header and its sources count as one node; a public header belongs to the room of its source. Tools
include public headers, and inner ones that need no symbols. Only base/system_* and the tools' cli/system_*
call the system.

    scripts/check-includes.py [ROOT]      default: the project
"""
import argparse
import re
import sys
from pathlib import Path

ROOMS = ["base", "display", "image", "media",
         "depth/map", "depth/refine", "depth/network", "depth/source", "depth/stereo", "slide",
         "views", "views/fast", "views/real", "views/layered", "scene", "splats", "native", "recipe",
         "video/motion", "video/conversion", "video/chunks"]
# Public headers without a source of their name.
HEADER_ROOMS = {"export": "base", "enum_table": "base", "version": "base", "image_io": "image",
                "video_io": "media",
                "scene": "depth/map", "splats": "splats", "video_conversion": "video/conversion"}
UMBRELLA = "altiro3D"
# What only the sources of system_* have, one for each system.
SYSTEM = re.compile(r"^\s*#\s*(?:include <((?:unistd|fcntl|poll|dlfcn|malloc|sched|spawn|termios|pwd|windows|io|"
                    r"(?:sys|linux|net|netinet)/\w+)\.h)>|if.*\b(__linux__|_WIN32|__APPLE__|__unix__)\b)", re.MULTILINE)
FOR_TOOLS = ["base/text", "base/image_format"]  # inner headers of which tools need no symbols


def node_of(file):
    """Returns the name of the node that a file belongs to."""
    return re.sub("_(posix|windows)$", "", file.stem)


def read_nodes(root):
    """Returns {node: room} and {node: {included node: "file:line"}}."""
    rooms, includes, problems = {}, {}, []
    sources = sorted((root / "libaltiro3D/src").rglob("*.[ch]pp"))
    headers = sorted((root / "libaltiro3D/include/altiro3D").glob("*.hpp"))
    for file in sources:
        room = file.parent.relative_to(root / "libaltiro3D/src").as_posix()
        if room not in ROOMS:
            problems.append(f"{file.relative_to(root)}: is in no room, expected one of {', '.join(ROOMS)}")
            continue
        if rooms.setdefault(node_of(file), room) != room:
            problems.append(f"{file.relative_to(root)}: another file of this name is in {rooms[node_of(file)]}")
    for file in headers:
        if file.stem == UMBRELLA or file.stem in rooms:
            continue
        if file.stem not in HEADER_ROOMS:
            problems.append(f"{file.relative_to(root)}: has no source and no room, expected a line in "
                            "HEADER_ROOMS of scripts/check-includes.py")
            continue
        rooms[file.stem] = HEADER_ROOMS[file.stem]
    for file in sources + headers + sorted((root / "tools").rglob("*.[ch]pp")):
        if not node_of(file).startswith("system") and file.stem != "export":
            for match in SYSTEM.finditer(file.read_text()):
                problems.append(f"{file.relative_to(root)}: has {match[1] or match[2]}, expected a function of "
                                "base/system_*.hpp or cli/system.hpp, whose sources know the system")
    for file in sources + headers:
        node = node_of(file)
        if node not in rooms:
            continue
        edges = includes.setdefault(node, {})
        for number, line in enumerate(file.read_text().splitlines(), 1):
            match = re.match(r'\s*#include "([\w/]+)\.hpp"', line)
            if not match:
                continue
            target = match[1].split("/")[-1]
            place = f"{file.relative_to(root)}:{number}"
            if target == UMBRELLA:
                problems.append(f"{place}: includes the umbrella header, expected the header that it needs")
            elif target in rooms and target != node:
                edges.setdefault(target, place)
    return rooms, includes, problems


def find_cycles(includes):
    """Returns the sets of nodes that include each other (Tarjan)."""
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for target in includes.get(node, {}):
            if target not in index:
                visit(target)
                low[node] = min(low[node], low[target])
            elif target in stack:
                low[node] = min(low[node], index[target])
        if low[node] == index[node]:
            group = set()
            while node not in group:
                group.add(stack.pop())
            if len(group) > 1:
                found.append(sorted(group))

    for node in sorted(includes):
        if node not in index:
            visit(node)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", metavar="ROOT", nargs="?", type=Path, default=Path(__file__).parent.parent)
    root = parser.parse_args().root.resolve()
    rooms, includes, problems = read_nodes(root)
    if len(rooms) < 10:
        sys.exit(f"{root}: has {len(rooms)} files of the library, expected the project")
    for node, edges in sorted(includes.items()):
        for target, place in sorted(edges.items()):
            if ROOMS.index(rooms[target]) > ROOMS.index(rooms[node]):
                problems.append(f"{place}: {rooms[node]} includes {target} of {rooms[target]}, expected a "
                                f"header of {' or '.join(ROOMS[:ROOMS.index(rooms[node]) + 1])}")
    for group in find_cycles(includes):
        places = [includes[a][b] for a in group for b in group if b in includes[a]]
        problems.append(f"cycle of {', '.join(group)}: " + "; ".join(places))
    for file in sorted((root / "tools").rglob("*.[ch]pp")):
        for target in re.findall(r'^\s*#include "([\w/]+)\.hpp"', file.read_text(), re.MULTILINE):
            if (root / f"libaltiro3D/src/{target}.hpp").exists() and target not in FOR_TOOLS:
                problems.append(f"{file.relative_to(root)}: includes {target}.hpp, expected a public header or "
                                f"{' or '.join(FOR_TOOLS)}")
    for problem in problems:
        print(problem, file=sys.stderr)
    if problems:
        sys.exit(1)
    print(f"includes: {len(rooms)} files in {len(ROOMS)} rooms, no wrong direction, no cycle")


if __name__ == "__main__":
    main()
