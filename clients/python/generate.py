#!/usr/bin/env python3
"""Writes two files of the package: `python3 clients/python/generate.py`. A test holds them against their sources.

- `contract.py` from `api/openapi.json`: each schema becomes a TypedDict or an alias.
- `client.py`, the blocking client, from `aio.py`, the asynchronous one.
"""

import json
import keyword
import pathlib
import re
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = pathlib.Path(__file__).resolve().parent / "src" / "strahl"
HEAD = '''"""Types of the contract. `generate.py` writes this file from `api/openapi.json`."""

from __future__ import annotations

from typing import Any, Literal, NotRequired, TypeAlias, TypedDict

'''
PLAIN = {"string": "str", "integer": "int", "number": "float", "boolean": "bool", "null": "None"}


def type_of(schema):
    """A schema as a Python type."""
    if not isinstance(schema, dict):
        return "Any"
    if "$ref" in schema:
        return schema["$ref"].rsplit("/", 1)[1]
    if "const" in schema:
        return f"Literal[{schema['const']!r}]"
    if "enum" in schema:
        return "Literal[" + ", ".join(repr(one) for one in schema["enum"]) + "]"
    for word in ("anyOf", "oneOf"):
        if word in schema:
            return union(type_of(one) for one in schema[word])
    kind = schema.get("type")
    if isinstance(kind, list):
        return union(type_of({**schema, "type": one}) for one in kind)
    if kind == "array":
        return f"list[{type_of(schema.get('items'))}]"
    if kind == "object":
        more, properties = schema.get("additionalProperties"), schema.get("properties")
        if properties:
            # Such as {"fixed": {...}}: one key that says which of several it is.
            return union(f"dict[Literal[{name!r}], {type_of(one)}]" for name, one in properties.items())
        return f"dict[str, {type_of(more) if isinstance(more, dict) else 'Any'}]"
    return PLAIN.get(kind, "Any")


def union(types):
    return " | ".join(dict.fromkeys(types))


def comment(schema, indent=""):
    text = " ".join(schema.get("description", "").split())
    return "".join(f"{indent}# {line}\n" for line in textwrap.wrap(text, 110)) if text else ""


def definition(name, schema):
    properties = schema.get("properties")
    if schema.get("type") != "object" or not properties:
        return f'{comment(schema)}{name}: TypeAlias = "{type_of(schema)}"\n'
    required = set(schema.get("required", []))

    def member(key, one):
        return type_of(one) if key in required else f"NotRequired[{type_of(one)}]"

    if all(key.isidentifier() and not keyword.iskeyword(key) for key in properties):
        lines = [f"{comment(one, '    ')}    {key}: {member(key, one)}\n" for key, one in properties.items()]
        about = " ".join(schema.get("description", name).split()).replace('"', "'")
        about = "\n    ".join(textwrap.wrap(about, 110))
        return f'class {name}(TypedDict):\n    """{about}"""\n\n' + "".join(lines)
    # A key that is no name. Values are text, for they may name what comes later.
    lines = [f"    {key!r}: {member(key, one)!r},\n" for key, one in properties.items()]
    return f"{comment(schema)}{name} = TypedDict({name!r}, {{\n" + "".join(lines) + "})\n"


def contract():
    schemas = json.loads((ROOT / "api/openapi.json").read_text())["components"]["schemas"]
    return HEAD + "\n\n".join(definition(*one) for one in schemas.items())


# What is written otherwise without asyncio.
BLOCKING = [
    (r"^import anyio\n", ""), (r"\basync (def|for|with)\b", r"\1"), (r"\bawait ", ""), (r"\banyio\.sleep", "time.sleep"),
    (r"\bAsync(Assets|Client|Jobs|Job|Iterator|BaseTransport)\b", r"\1"), (r"\basynccontextmanager\b", "contextmanager"),
    (r"__a(enter|exit)__", r"__\1__"), (r"\baclose\b", "close"), (r"\baread\b", "read"), (r"\baiter_bytes\b", "iter_bytes"),
    (r'^"""The asynchronous client.*"""', '"""The blocking client. `generate.py` makes this file of `aio.py`."""'),
    (r"import Iterator, Callable", "import Callable"), (r"import Callable, Iterable, Mapping", "import Callable, Iterable, Iterator, Mapping"),
]


def blocking():
    text = (PACKAGE / "aio.py").read_text()
    for pattern, by in BLOCKING:
        text = re.sub(pattern, by, text, flags=re.MULTILINE)
    return text


GENERATED = {"contract.py": contract, "client.py": blocking}

if __name__ == "__main__":
    for name, write in GENERATED.items():
        (PACKAGE / name).write_text(write())
