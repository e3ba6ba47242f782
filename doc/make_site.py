#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# The site of `./run doc`: the Markdown pages as they are in the sources, with a search, and the classes. Doxygen knows neither
# GitHub's anchors nor links between folders nor an order of pages. Therefore this script writes the pages once more to
# build/doc/pages, with names for headings and links by these names, and a layout with the pages by folder; then it runs Doxygen,
# copies what pages link to beside the site, and looks at each link of the site.

import html
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

top = Path(__file__).resolve().parent.parent
built = top / "build/doc"
site = built / "html"
mathjax = Path("/usr/share/javascript/mathjax")  # of the package libjs-mathjax; else from the network

# The tabs in their order: title and pages. The first page of a folder is its README; it gives the order of the pages that it links.
TABS = (
    ("User guide", ["doc/user_guide"]),
    ("Tutorials", ["prm/tutorials"]),
    ("Gallery", ["doc/gallery.md"]),
    ("How to", ["doc/how_to"]),
    ("Theory", ["doc/theory"]),
    ("All entries", ["doc/parameters.md"]),
    ("Scenes and benchmarks", ["prm", "meshes"]),
    ("Development", ["doc"]),
)
HEADING = re.compile(r"^(#{1,6}) +(.*?) *$")
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")


def pages():
    """All Markdown pages, relative to the top."""
    found = [Path("README.md")]
    for folder in ("doc", "prm", "meshes"):
        found += sorted(page.relative_to(top) for page in (top / folder).rglob("*.md"))
    return [page for page in found if not str(page).startswith("doc/changes/")]


def name_of(page):
    return "page_" + re.sub(r"\W", "_", str(page.with_suffix("")))


def anchor_of(title):
    """As GitHub makes it."""
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).replace("`", "").lower()
    return re.sub(r"[^\w\- ]", "", words).replace(" ", "-")


def lines_of(page):
    """Line and whether it is text, not code, of each line; blocks of code become fenced ones."""
    previous, code, fence = "", False, False
    for line in (top / page).read_text().splitlines():
        if line.startswith("```"):
            fence = not fence
            yield line, False
            continue
        if not fence:
            if not code and line.startswith("    ") and not previous.strip():
                code = True
                yield "```", False
            elif code and line.strip() and not line.startswith("    "):
                code = False
                yield "```", False
                yield "", False
        yield (line[4:] if code else line), not (code or fence)
        previous = line
    if code:
        yield "```", False


def anchors_of(page):
    return [anchor_of(match[2]) for line, is_text in lines_of(page) if is_text for match in [HEADING.match(line)] if match]


def target_of(page, link):
    """What a link of the page leads to: a path relative to the top, and an anchor."""
    path, _, anchor = link.partition("#")
    return (Path(os.path.normpath(page.parent / unquote(path))) if path else page), anchor


def title_of(page):
    for line, is_text in lines_of(page):
        if is_text and HEADING.match(line):
            return HEADING.match(line)[2].replace("`", "")
    return str(page)


class Writer:
    """Writes the pages for Doxygen, and remembers the files to which they link."""

    def __init__(self):
        self.all = pages()
        self.linked, self.broken = set(), []

    def link(self, page, match):
        is_picture, text, where = match[1], re.sub(r"\s+", " ", match[2]), match[3]
        if re.match(r"\w+:", where):
            return match[0]
        target, anchor = target_of(page, where)
        if not (top / target).exists():
            self.broken.append(f"{page}: {where} leads nowhere")
            return text
        if is_picture:
            self.linked.add(target)
            return f'<img src="files/{target}" alt="{html.escape(text)}" style="max-width: 100%"/>'
        if (top / target / "README.md").exists():
            target = target / "README.md"
        if target in self.all:
            if anchor and anchor not in anchors_of(target):
                self.broken.append(f"{page}: {where} has no such heading")
            name = name_of(target)
            if anchor and anchor != anchor_of(title_of(target)):
                name += "_" + re.sub(r"\W", "_", anchor)
            return f"[{text}](@ref {name})"
        self.linked.add(target)
        return f'<a href="files/{target}">{text}</a>'

    def write(self, page):
        result, names, paragraph = [], set(), []

        def end_paragraph():  # links may go on over the end of a line
            if paragraph:
                result.append(LINK.sub(lambda match: self.link(page, match), "\n".join(paragraph)))
                paragraph.clear()

        for line, is_text in lines_of(page):
            if not names and not (is_text and HEADING.match(line)):
                continue  # what stands above the title: the licence
            heading = HEADING.match(line) if is_text else None
            if heading:
                name = name_of(page) + ("_" + re.sub(r"\W", "_", anchor_of(heading[2])) if names else "")
                if name not in names:
                    line += " {#" + name + "}"
                names.add(name)
            if is_text:
                paragraph.append(line)
            else:
                end_paragraph()
                result.append(line)
        end_paragraph()
        path = built / "pages" / page
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(result) + "\n")

    def broken_links_of(self, page):
        """Line and link of all that lead nowhere."""
        for number, line in enumerate((top / page).read_text().splitlines(), 1):
            if not line.startswith("    "):
                self.broken = []
                re.sub(r"(!?)\[?([^\[\]]*)\]\(([^()\s]+)\)", lambda match: self.link(page, match), line)
                yield from ((number, what.split(": ", 1)[1]) for what in self.broken)

    def copy_linked(self):
        for target in sorted(self.linked):
            place = site / "files" / target
            place.parent.mkdir(parents=True, exist_ok=True)
            if (top / target).is_dir():
                place.mkdir(exist_ok=True)
                names = sorted(child.name for child in (top / target).iterdir() if child.is_file())
                for name in names:
                    shutil.copy(top / target / name, place / name)
                items = "".join(f'<li><a href="{name}">{name}</a></li>' for name in names)
                (place / "index.html").write_text(f"<!DOCTYPE html><title>{target}</title><h1>{target}</h1><ul>{items}</ul>")
            else:
                shutil.copy(top / target, place)


def pages_of(place):
    """Pages of a folder: its README, what this links to in the same folder, and the rest by title; without folders of other tabs."""
    if place.endswith(".md"):
        return [Path(place)]
    others = [p for _, places in TABS for p in places if p != place and p.startswith(place + "/")]
    inside = [page for page in pages() if str(page).startswith(place + "/")
              and not any(str(page) == other or str(page).startswith(other + "/") for other in others)]
    first = Path(place) / "README.md"
    order = [first] if first in inside else []
    guide = first if first in inside else Path("README.md")
    order += [target_of(guide, match[3])[0] for match in LINK.finditer((top / guide).read_text())]
    order = [page for page in dict.fromkeys(order) if page in inside]
    return order + sorted((page for page in inside if page not in order), key=lambda page: title_of(page).lower())


def write_layout():
    def tab(page, indent):
        return f'{indent}<tab type="user" visible="yes" url="@ref {name_of(page)}" title="{html.escape(title_of(page), quote=False)}"/>\n'

    tabs = ""
    for title, places in TABS:
        listed = [page for place in places for page in pages_of(place)]
        if len(listed) == 1:
            tabs += f'    <tab type="user" visible="yes" url="@ref {name_of(listed[0])}" title="{title}"/>\n'
        else:
            tabs += f'    <tab type="usergroup" visible="yes" url="@ref {name_of(listed[0])}" title="{title}">\n'
            tabs += "".join(tab(page, "      ") for page in listed) + "    </tab>\n"
    tabs += '    <tab type="user" visible="yes" url="search_the_text.html" title="Search the text"/>\n'
    subprocess.run(["doxygen", "-l", str(built / "layout.xml")], check=True, stdout=subprocess.DEVNULL)
    layout = (built / "layout.xml").read_text()
    layout = layout.replace('<tab type="pages" visible="yes"', tabs.strip() + '\n    <tab type="pages" visible="no"')
    (built / "layout.xml").write_text(layout)


def sections_of(page):
    """Address, title and text of each section. Markup goes, what stands between back quotes stays."""
    sections = []
    for line, is_text in lines_of(page):
        if is_text and HEADING.match(line):
            title = HEADING.match(line)[2].replace("`", "")
            file = "index.html" if page == Path("README.md") else f"{name_of(page)}.html"
            where = file + (f"#{name_of(page)}_" + re.sub(r"\W", "_", anchor_of(HEADING.match(line)[2])) if sections else "")
            sections.append([where, f"{title_of(page)}: {title}" if sections else title, ""])
        elif sections and not line.startswith("```") and not re.fullmatch(r"[|\- :]*", line):
            sections[-1][2] += re.sub(r"[`|*]|\]\([^)]*\)|!?\[", " ", line).strip() + " "
    return sections


def write_search_page(all_pages):
    """A page that looks for words in the text; Doxygen's own search knows titles and names only. Yields what leads nowhere."""
    sections = [section for page in all_pages for section in sections_of(page)]
    text = json.dumps(sections, ensure_ascii=False).replace("</", "<\\/")
    (site / "search_the_text.html").write_text((top / "doc/search_page.html").read_text().replace("SECTIONS", text))
    for where, title, _ in sections:
        file, _, anchor = where.partition("#")
        if anchor and f'id="{anchor}"' not in (site / file).read_text():
            yield f"search_the_text.html: {title} has no place {where}"


def copy_mathjax():
    """What draws the formulas of the classes, so that the site needs no network."""
    for part in ("MathJax.js", "config", "extensions", "jax/element", "jax/input/TeX", "jax/output/CommonHTML",
                 "fonts/HTML-CSS/TeX/woff"):
        place = site / "mathjax" / part
        place.parent.mkdir(parents=True, exist_ok=True)
        if (mathjax / part).is_dir():
            shutil.copytree(mathjax / part, place)
        elif (mathjax / part).exists():
            shutil.copy(mathjax / part, place)


def broken_links():
    """Links of the site that lead nowhere."""
    ids = {}
    for path in sorted(site.rglob("*.html")):
        text = path.read_text(errors="replace")
        ids[path] = set(re.findall(r'(?:id|name)="([^"]+)"', text)), re.findall(r'(?:href|src)="([^"]+)"', text)
    for path, (_, links) in ids.items():
        for link in dict.fromkeys(links):
            if re.match(r"\w+:", link) or "$" in link or "'" in link:
                continue
            file, _, anchor = html.unescape(link).partition("#")
            target = (path.parent / unquote(file)).resolve() if file else path
            if not target.exists():
                yield f"{path.relative_to(site)}: {link} leads nowhere"
            elif anchor and path.name.startswith(("page_", "index")) and target in ids and unquote(anchor) not in ids[target][0]:
                yield f"{path.relative_to(site)}: {link} has no such place"


def main():
    for old in (built / "pages", site):
        shutil.rmtree(old, ignore_errors=True)
    writer = Writer()
    for page in writer.all:
        writer.write(page)
    write_layout()
    settings = "@INCLUDE = doc/Doxyfile\n"
    if mathjax.exists():
        settings += "MATHJAX_RELPATH = mathjax\n"
        copy_mathjax()
    subprocess.run(["doxygen", "-"], cwd=top, input=settings.encode(), check=True)
    writer.copy_linked()
    wrong = writer.broken + list(write_search_page(writer.all)) + (built / "warnings").read_text().splitlines() + list(broken_links())
    for line in wrong:
        print(line, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
