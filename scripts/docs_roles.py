"""Docstrings as Markdown, for the documentation's site: an extension of griffe.

Roles, such as :class:`Image`, become links, and examples blocks of code.
"""

import re

import griffe

ROLE = re.compile(r":(?:class|data|func|meth):`([\w.]+)`")
EXAMPLE = re.compile(r"^( *>>> .*(?:\n.*\S.*)*)", re.M)


class Roles(griffe.Extension):
    def on_package(self, *, pkg, **_):
        for obj in objects(pkg):
            if obj.docstring:
                obj.docstring.value = markdown(obj, obj.docstring.value)


def markdown(obj, text):
    text = ROLE.sub(lambda role: link(obj, role[1]), text).replace("``", "`")
    return EXAMPLE.sub(r"```pycon\n\1\n```", text)


def objects(obj):
    yield obj
    for member in obj.members.values():
        if not member.is_alias:
            yield from objects(member)


def link(obj, name):
    """Link to what a docstring calls `name`, which is sought as Python does; other packages' names are no links."""
    while obj is not None:
        if name in obj.members:
            found = obj.members[name]
            path = found.target_path if found.is_alias else found.path
            # Users see it in the package, wherever it is defined.
            return f"[`{name}`][{re.sub(r'[.]_[a-z]+', '', path)}]"
        obj = obj.parent
    return f"`{name}`"
