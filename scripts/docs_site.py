"""Pages of the documentation's site, a hook of mkdocs: `make docs`.

The site is laid out like the project, so that links mean there what they mean in the project: Markdown files and notebooks
are pages, and so is every other text, highlighted, and every folder, as a list. The gallery, the reference of the Python
module and the list of all sources are made here.
"""

import posixpath
import subprocess
from pathlib import Path

import nbconvert
from mkdocs.structure.files import File, Files, InclusionLevel
from pygments.lexers import get_lexer_for_filename
from pygments.util import ClassNotFound

import gallery
from check_links import ROOT, slug

# Longer than any fence in a text that is shown.
FENCE = "~" * 12
# Sources stand apart: found by links alone, and as wide as they are.
APART = "---\nsearch:\n  exclude: true\nhide: [navigation, toc]\n---\n"

REFERENCE = """# Reference of the Python module

::: raggio
    options:
      heading_level: 2
      filters: ["!^_", "^__version__$"]
      show_root_heading: false
      show_root_toc_entry: false

::: raggio._view.View
    options:
      show_root_full_path: false

::: raggio.cluster

::: raggio.datasets
"""

# Pictures of docs/images that scripts/gallery.py does not render, and how each is made.
OTHERS = {
    "helmet": "Flight Helmet of the glTF sample models, 94,722 triangles and 15 textures, 4,096 samples.",
    "viewer": "The [window](docs/viewer.md), which `raggio view` opens.",
    "convergence": "How the error falls with samples, drawn by `make curves`: [performance](docs/performance.md).",
}


class Source(File):
    """A page about a file or folder of any name, which links find under that name."""

    def is_documentation_page(self):
        return True


def on_config(config):
    """Gives headings the anchors that they have everywhere else."""
    config.mdx_configs["toc"] = {"slugify": lambda heading, separator: slug(heading), "permalink": True}
    return config


def on_files(files, config):
    """Puts the project's files in the place of those of docs/."""
    made = [file for file in files if file.src_dir != config.docs_dir]

    def show(source, target, text):
        page = Source.generated(config, source, content=text, inclusion=InclusionLevel.NOT_IN_NAV)
        page.dest_uri = target
        made.append(page)

    paths = tracked()
    shown = set()
    for path in paths:
        if path.endswith(".md") or path.startswith("docs/images/"):
            made.append(File.generated(config, path, abs_src_path=str(ROOT / path)))
        elif path.endswith(".ipynb"):
            made.extend(notebook(path, config))
        elif (text := text_of(path)) is not None:
            show(path, f"{path}.html", source_page(path, text))
        else:
            continue
        shown.add(path)
    for folder, names in folders(paths).items():
        if folder:
            show(folder, f"{folder}/index.html", folder_page(folder, names, shown))
        else:
            made.append(File.generated(config, "sources.md", content=folder_page(folder, names, shown)))
    made.append(File.generated(config, "gallery.md", content=gallery_page()))
    made.append(File.generated(config, "reference.md", content=REFERENCE))
    return Files(made)


def tracked():
    """Paths of the files that git tracks, and of new ones that it does not ignore."""
    listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listing, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.split("\0")
    return sorted(name for name in set(names) if name and (ROOT / name).is_file())


def folders(paths):
    """Names in each folder, those of its folders with a slash; the project's root is ""."""
    found = {"": set()}
    for path in paths:
        name = posixpath.basename(path)
        while path:
            path = posixpath.dirname(path)
            found.setdefault(path, set()).add(name)
            name = posixpath.basename(path) + "/"
    return found


def notebook(path, config):
    """A notebook as a page, and the pictures in it."""
    text, resources = nbconvert.MarkdownExporter().from_filename(
        str(ROOT / path), resources={"output_files_dir": f"{Path(path).stem}-files"})
    page = Source.generated(config, path, content=text)
    page.dest_uri = path.replace(".ipynb", ".html")
    pictures = resources["outputs"].items()
    return [page, *(File.generated(config, f"{posixpath.dirname(path)}/{name}", content=data) for name, data in pictures)]


def folder_page(folder, names, shown):
    """A list of what is in a folder, its folders first."""
    lines = [f"{APART}# {folder or 'Sources'}\n"]
    for name in sorted(names, key=lambda name: (not name.endswith("/"), name)):
        path = posixpath.join(folder, name)
        link = posixpath.relpath(path, posixpath.dirname(folder) or ".")
        lines.append(f"- [{name}]({link})" if name.endswith("/") or path in shown else f"- {name}")
    return "\n".join(lines)


def text_of(path):
    """Text of a file; nothing where it is none."""
    try:
        text = (ROOT / path).read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return None
    return None if "\0" in text else text


def source_page(path, text):
    return f"{APART}# {posixpath.basename(path)}\n\n{fenced(path, text)}"


def fenced(path, text):
    return f'{FENCE} {{ .{language(path)} title="{path}" }}\n{text.rstrip()}\n{FENCE}\n'


def language(path):
    """Name of the highlighter for a file."""
    if path.endswith(".slang"):
        # Its syntax is HLSL's, and more.
        return "hlsl"
    try:
        return get_lexer_for_filename(path).aliases[0]
    except (ClassNotFound, IndexError):
        return "text"


def gallery_page():
    """Each picture of docs/images with the scene that it is of and the command that rendered it."""
    parts = ["# Gallery\n\n`make gallery` renders these pictures anew, `python scripts/gallery.py NAME` some of them.\n"]
    for scene, name, extra in gallery.PICTURES:
        path = f"scenes/{scene}.toml"
        picture = f"docs/images/{name}.png"
        command = " ".join(["raggio", *gallery.render(scene, picture, []), "\\\n   ", *extra])
        scene_text = indented(fenced(path, text_of(path)))
        text = f"```sh\n{command}\n```\n\n??? note \"The scene\"\n\n{scene_text}"
        parts.append(f"## {name}\n\n![{name}]({picture})\n\n{text}")
    for path in sorted((ROOT / "docs/images").rglob("*.png")):
        name = path.relative_to(ROOT / "docs/images").with_suffix("").as_posix()
        if all(name != rendered for _, rendered, _ in gallery.PICTURES):
            parts.append(f"## {name}\n\n![{name}](docs/images/{name}.png)\n\n{OTHERS[name]}\n")
    return "\n".join(parts)


def indented(text):
    return "".join(f"    {line}\n" if line else "\n" for line in text.split("\n"))
