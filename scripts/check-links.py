#!/usr/bin/env python3
"""Finds what is dead in the documents: links and anchors that lead nowhere, commands that do not
exist, options that the command's --help-all does not name, and values of an option that are none of
those it lists, as in `--method layered|fast|real`; PLACEHOLDERS stand for any.

    scripts/check-links.py TOOLS_DIRECTORY [FILE.md...]    (default: all in the repository)

Commands are looked for in code: indented and fenced blocks, and `spans`. A span that is a long
option alone, or with its value, must be one of any tool or script.
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OPTION = re.compile(r"(?<![\w-])--?[A-Za-z][\w-]*")
# What looks like a command of ours, and so has to be one.
OURS = re.compile(r"altiro3D[a-z]\w*|(?:photo|video|quilt|views?|images?|native)2\w+")
SCRIPT = re.compile(r"(?<![\w./-])(?:scripts/[\w.-]+|\.ci/\w+)")
# An option in the help, with its list of values; what stands for a value in a document.
CHOICE = re.compile(r"(--[a-z][\w-]*) ([a-z][\w-]*(?:\|[\w-]+)+)$")
PLACEHOLDER = re.compile(r"[A-Z][A-Z0-9_.]*|[$<].*|\.\.\.")
# What looks the same: targets and tests.
NOT_COMMANDS = re.compile(r"altiro3D_\w+|\w+_test")


class Commands:
    """Our tools and scripts, the options of each, and the values of those that list them."""

    def __init__(self, tools):
        self.options, self.values = {}, {}
        scripts = ROOT / "tools/original"
        environment = dict(os.environ, QT_QPA_PLATFORM="offscreen")
        for tool in sorted(p for p in Path(tools).iterdir() if p.is_file() and os.access(p, os.X_OK)):
            if not (scripts / tool.name).exists():
                text = subprocess.run([tool, "--help-all"], env=environment, check=True, text=True,
                                      capture_output=True, timeout=60).stdout
                left = [re.split(r"  +", line[2:])[0] for line in text.splitlines()
                        if line.startswith("  -")]
                self.options[tool.name] = set(OPTION.findall(" ".join(left)))
                self.values[tool.name] = {option: set(values.split("|")) for option, values
                                          in (m.groups() for m in map(CHOICE.search, left) if m)}
        for script in (s for s in scripts.iterdir() if (Path(tools) / s.name).exists()):
            called = re.findall(r'"\$here/(\w+)" "\$@"', script.read_text())
            self.options[script.name] = set().union(*(self.options[tool] for tool in called))
            self.values[script.name] = self.values_of(called)
        self.all = set().union(*self.options.values())
        for script in [*(ROOT / "scripts").iterdir(), *(ROOT / ".ci").iterdir(),
                       ROOT / "tools/CMakeLists.txt"]:  # calls what no help names
            self.all |= set(OPTION.findall(script.read_text()))

    def values_of(self, tools):
        """The values of some tools' options, all together."""
        merged = {}
        for tool in tools:
            for option, values in self.values[tool].items():
                merged[option] = merged.get(option, set()) | values
        return merged

    def faults_of_option(self, span):
        """What is wrong with an option that stands alone, perhaps with its value."""
        option, _, value = re.sub("=", " ", span, count=1).partition(" ")
        if option not in self.all:
            yield f"{span}: no tool has this option"
        for word in value.split("|") if value else []:
            yield from fault_of_value(option, word, self.values_of(self.values))

    def faults(self, line):
        """What is wrong with a line of code."""
        for name in SCRIPT.findall(line):
            if not (ROOT / name).exists():
                yield f"{name}: no such script"
        for part in re.split(r"[|;&]+", line):
            try:
                words = shlex.split(part, comments=True)
            except ValueError:  # a quotation of something else
                words = part.split()
            while words and (words[0] in ("$", "sudo", "env") or re.fullmatch(r"\w+=.*", words[0])):
                words = words[1:]
            if words:
                yield from self.faults_of_call(words[0], words[1:])

    def faults_of_call(self, command, arguments):
        path = ROOT / command
        if SCRIPT.fullmatch(command) and path.is_file():
            known, values = set(OPTION.findall(path.read_text())), {}
        else:
            command = Path(command).name
            if not OURS.fullmatch(command) or NOT_COMMANDS.fullmatch(command):
                return
            if command not in self.options:
                yield f"{command}: no such command"
                return
            known, values = self.options[command], self.values[command]
        for argument, following in zip(arguments, [*arguments[1:], ""]):
            if argument == "--":
                return
            option, equals, value = argument.strip("[]").partition("=")
            if OPTION.fullmatch(option) and option not in known:
                yield f"{command}: has no option {option}"
            for fault in fault_of_value(option, value if equals else following.strip("]"), values):
                yield f"{command}: {fault}"


def fault_of_value(option, value, values):
    """What is wrong with the value of an option, if it lists its values."""
    if value and value not in values.get(option, {value}) and not PLACEHOLDER.fullmatch(value):
        yield f"{option} has no value {value!r}, only {'|'.join(sorted(values[option]))}"


def code(text):
    """The lines of code in a document, with their numbers, and the text without the blocks."""
    lines, prose = [], []
    fence, before_blank, in_block = None, True, False
    for number, line in enumerate(text.splitlines(), 1):
        mark = re.match(r"\s*(```+)(\w*)", line)
        if mark:
            fence = None if fence is not None else mark[2]
            prose.append("")
            continue
        # indented, after an empty line: a block, not the rest of a list's entry
        in_block = fence is None and line.startswith("    ") and (before_blank or in_block)
        if fence in ("", "sh", "bash", "console") or in_block:
            lines.append((number, line.strip()))
        prose.append("" if fence is not None or in_block else line)
        before_blank = not line.strip()
    for number, line in enumerate(prose, 1):
        lines += [(number, span) for span in re.findall(r"`([^`]+)`", line)]
    return lines, prose


def anchors(file):
    """The anchors of a document's headings, as GitHub makes them."""
    found = {}
    for line in code(file.read_text(encoding="utf-8"))[1]:
        heading = re.match(r"#+\s+(.*?)\s*#*$", line)
        if heading:
            plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading[1])
            slug = re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")
            count = found.get(slug, 0)
            found[slug] = count + 1
            if count:
                found[f"{slug}-{count}"] = 1
    return set(found)


def faults_of_links(file, prose):
    for number, line in enumerate(prose, 1):
        line = re.sub(r"`[^`]*`", "", line)
        targets = re.findall(r"\]\(([^)\s]+)[^)]*\)", line)
        targets += re.findall(r"(?:src|href)=\"([^\"]+)\"", line)
        targets += re.findall(r"^\[[^]]+\]:\s*(\S+)", line)
        for target in targets:
            if re.match(r"[a-z]+:", target):
                continue  # elsewhere: nothing here uses the network
            path, _, anchor = target.partition("#")
            there = (file.parent / path) if path else file
            if not there.exists():
                yield number, f"{target}: leads nowhere"
            elif anchor and there.suffix == ".md" and anchor not in anchors(there):
                yield number, f"{target}: {there.name} has no such heading"


def main():
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tools", metavar="TOOLS_DIRECTORY")
    parser.add_argument("files", metavar="FILE.md", nargs="*", type=Path)
    given = parser.parse_args()
    commands = Commands(given.tools)
    files = given.files or sorted(
        file for file in ROOT.rglob("*.md")
        if not file.relative_to(ROOT).parts[0].startswith(("build", ".git")))
    count = 0
    for file in files:
        lines, prose = code(file.read_text(encoding="utf-8"))
        faults = list(faults_of_links(file, prose))
        for number, line in lines:
            if re.fullmatch(r"--[a-z][\w-]*([ =]\S+)?", line):
                faults += [(number, fault) for fault in commands.faults_of_option(line)]
            faults += [(number, fault) for fault in commands.faults(line)]
        for number, fault in sorted(set(faults)):
            print(f"{file}:{number}: {fault}")
        count += len(set(faults))
    print(f"{len(files)} documents, {len(commands.options)} commands, {count} faults")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
