#!/usr/bin/env python3
"""Checks the relative links and images of all Markdown files: the file is there, and so is the heading named after #.

Anchors follow GitHub's rules. Links to other sites are not followed. Exits with 1 after listing `file:line: problem`.
"""

import re
import subprocess
import sys
from functools import cache
from html import escape, unescape
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parent.parent

INLINE_LINK = re.compile(r"\]\(\s*(<[^<>]*>|(?:[^\s()<>]|\([^\s()]*\))+)(?:\s+(?:\"[^\"]*\"|'[^']*'|\([^)]*\)))?\s*\)")
LINK_DEFINITION = re.compile(r"^ {0,3}\[(?!\^)[^\]]+\]:\s+(<[^<>]*>|\S+)")
HTML_LINK = re.compile(r"<(?:a|img|source|video)\b[^>]*?\b(?:href|src|srcset)\s*=\s*[\"']([^\"']+)[\"']", re.I)
HTML_ANCHOR = re.compile(r"<[a-z][^>]*?\b(?:id|name)\s*=\s*[\"']([^\"']+)[\"']", re.I)
OTHER_SITE = re.compile(r"[a-z][a-z0-9+.-]*:|//", re.I)


def markdown_files() -> list[Path]:
    """Files that git tracks, and new ones that it does not ignore."""
    listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", "*.md"]
    names = subprocess.run(listing, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.split("\0")
    return sorted(path for name in set(names) if name and (path := ROOT / name).is_file())


def prose(path: Path) -> list[str]:
    """The file's lines; those of fenced code blocks and HTML comments are blank, so that numbers stay right."""
    text = path.read_text(encoding="utf-8")
    text = re.sub(r"<!--.*?-->", lambda comment: "\n" * comment[0].count("\n"), text, flags=re.S)
    lines, fence = [], ""
    for line in text.split("\n"):
        mark = re.match(r"[\s>]*(?:(?:[-*+]|\d+[.)])\s+)*(`{3,}|~{3,})([^`]*)$", line)
        if not fence:
            lines.append("" if mark else line)
            fence = mark[1] if mark else ""
        else:
            lines.append("")
            if mark and mark[1].startswith(fence) and not mark[2].strip():
                fence = ""
    return lines


def without_code(line: str) -> str:
    return re.sub(r"(?<!`)(`+)(?!`).*?(?<!`)\1(?!`)", "``", line)


def slug(heading: str) -> str:
    """GitHub's anchor of a heading: its visible text in lower case, without punctuation, spaces turned into hyphens."""
    heading = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", heading)
    heading = re.sub(r"\[([^\]]*)\](?:\([^)]*\)|\[[^\]]*\])", r"\1", heading)
    heading = re.sub(r"`+([^`]*)`+", lambda code: escape(code[1]), heading)
    heading = unescape(re.sub(r"<[^>]+>", "", heading))
    heading = re.sub(r"(?<!\w)(_+)(\S(?:.*?\S)?)\1(?!\w)", r"\2", heading)
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


@cache
def anchors(path: Path) -> set[str]:
    found: set[str] = set()
    counts: dict[str, int] = {}
    previous = ""
    for line in prose(path):
        atx = re.match(r" {0,3}#{1,6}[ \t]+(.*?)(?:[ \t]+#+)?[ \t]*$", line)
        setext = re.match(r" {0,3}(?:=+|-+)[ \t]*$", line) and re.match(r" {0,3}[^\s#>|*+-]", previous)
        if atx or setext:
            name = slug(atx[1] if atx else previous)
            repeated = counts.get(name, 0)
            counts[name] = repeated + 1
            found.add(f"{name}-{repeated}" if repeated else name)
        found.update(HTML_ANCHOR.findall(without_code(line)))
        previous = line
    return found


def problem(source: Path, link: str) -> str | None:
    link = link.strip("<>")
    if OTHER_SITE.match(link):
        return None
    name, _, anchor = unquote(link).partition("#")
    name = name.partition("?")[0]
    # A leading slash is the repository's root, as on GitHub.
    target = ROOT / name.lstrip("/") if name.startswith("/") else source.parent / name if name else source
    target = target.resolve()
    if not target.is_relative_to(ROOT):
        return f"{link} leaves the repository"
    if not target.exists():
        return f"{link} does not exist"
    if anchor and target.suffix == ".md" and anchor not in anchors(target):
        return f"{link}: {target.relative_to(ROOT)} has no heading #{anchor}"
    return None


def main() -> int:
    problems = []
    files = markdown_files()
    for path in files:
        for number, line in enumerate(map(without_code, prose(path)), start=1):
            links = [link for pattern in (INLINE_LINK, LINK_DEFINITION, HTML_LINK) for link in pattern.findall(line)]
            found = filter(None, (problem(path, link) for link in links))
            problems += [f"{path.relative_to(ROOT)}:{number}: {text}" for text in found]
    print("\n".join(problems) or f"check_links: the links of {len(files)} Markdown files are good")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
