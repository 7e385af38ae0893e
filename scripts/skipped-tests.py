#!/usr/bin/env python3
"""Tells how many tests ctest skipped, and why, from the file that its --output-junit wrote.

    scripts/skipped-tests.py JUNIT.xml
"""

import argparse
import re
import sys
import xml.etree.ElementTree as ElementTree

# What GoogleTest prints before a message, and what shell tests print before theirs.
REASON = re.compile(r"^.*: Skipped\n(.+)|^skipped: (.+)", re.MULTILINE | re.IGNORECASE)
TEST_DATA = re.compile(r"needs \S+ of (the test data)")


def reason_in(found):
    return TEST_DATA.sub(r"needs \1, which is not in the repository", found[1] or found[2]).strip()


def reason_of(test):
    found = REASON.search(test.findtext("system-out") or "")
    return reason_in(found) if found else "no reason given"


def main():
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="JUNIT.xml")
    file = parser.parse_args().file
    try:
        tests = ElementTree.parse(file).getroot().findall("testcase")
    except (OSError, ElementTree.ParseError) as error:
        print(f"{file}: {error}, expected what ctest --output-junit writes", file=sys.stderr)
        return 1
    names = {}
    for test in tests:
        name = test.get("name")
        if test.get("status") in ("notrun", "disabled"):
            names.setdefault(reason_of(test), []).append(name)
        elif test.get("status") == "run":  # one program with many tests
            for found in REASON.finditer(test.findtext("system-out") or ""):
                names.setdefault(reason_in(found), []).append(f"one of {name}")
    count = sum(map(len, names.values()))
    print(f"{count} tests were skipped{':' if count else '.'}")
    for reason, of_reason in sorted(names.items(), key=lambda item: -len(item[1])):
        few = f" ({', '.join(of_reason)})" if len(of_reason) <= 3 else ""
        print(f"  {len(of_reason)}: {reason}{few}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
