"""Writes `python/armident/_fields.pyi`, the types of the results, from the schemas that the library has.

    python python/tests/fields.py
"""

import json
from pathlib import Path

from armident import _armident

TARGET = Path(__file__).parents[1] / "armident" / "_fields.pyi"
HEAD = '''"""Fields of the results, made by `python/tests/fields.py` from the schemas of the library."""

from typing import Any, Literal

from ._results import Fields
'''
#: Classes of the results, by the `schema` of their JSON without its version.
RESULTS = {
    "armident.check": "CheckReport",
    "armident.identify": "IdentifyReport",
    "armident.diagnosis": "DiagnoseReport",
    "armident.validate": "ValidateReport",
    "armident.fleet": "FleetReport",
}
#: Fields that every result has as a property.
OF_RESULT = {"warnings", "notes"}
SIMPLE = {"string": "str", "number": "float", "integer": "int", "boolean": "bool", "null": "None"}


def kind(schema):
    """The type of a value."""
    if not isinstance(schema, dict):
        return "Any"
    if "$ref" in schema:
        return schema["$ref"].removeprefix("#/$defs/")
    for choice in ("anyOf", "oneOf"):
        if choice in schema:
            return " | ".join(dict.fromkeys(kind(one) for one in schema[choice]))
    if "const" in schema:
        return f"Literal[{schema['const']!r}]".replace("'", '"')
    if "enum" in schema:
        return f"Literal[{', '.join(json.dumps(one) for one in schema['enum'])}]"
    types = schema.get("type", [])
    types = [types] if isinstance(types, str) else types
    return " | ".join(of_type(one, schema) for one in types) or "Any"


def of_type(name, schema):
    if name == "array":
        return f"list[{kind(schema.get('items'))}]"
    if name == "object":
        return f"dict[str, {kind(schema.get('additionalProperties'))}]"
    return SIMPLE[name]


def text(schema):
    return " ".join(schema.get("description", "").replace("\\[", "[").replace("\\]", "]").split())


def class_of(name, schema, base, without=()):
    lines = [f"class {name}({base}):" if base else f"class {name}:"]
    if text(schema):
        lines.append(f'    """{text(schema)}"""\n')
    for field, of in schema["properties"].items():
        if field in without:
            continue
        # a keyword of Python is a key only
        lines.append(f"    {field}: {kind(of)}" if field.isidentifier() and field != "from" else f"    # {field!r}")
        if text(of):
            lines.append(f'    """{text(of)}"""')
    return "\n".join(lines)


def stub():
    """The text of the file."""
    parts, classes = [], {}
    for name, schema in _armident.schemas():
        result = RESULTS.get(name.split("/")[0])
        if result is None:
            # of the command line alone
            continue
        schema = json.loads(schema)
        parts.append(class_of(result, schema, None, OF_RESULT))
        for row, of in schema.get("$defs", {}).items():
            if "properties" in of:
                classes[row] = class_of(row, of, "Fields")
            else:
                classes[row] = f"{row} = {kind(of)}"
    rows = [classes[row] for row in sorted(classes)]
    return HEAD + "\n" + "\n\n".join(parts + rows) + "\n"


if __name__ == "__main__":
    TARGET.write_text(stub(), encoding="utf-8")
