"""XLA's foreign function interface, as the C header beside jaxlib describes it.

The header is read for where fields are, so that neither it nor a compiler is needed to speak
to the XLA that is installed.
"""

import functools
import pathlib
import re
from collections.abc import Mapping

import jax

Layout = Mapping[str, Mapping[str, int]]

_SIZES = {"size_t": 8, "int64_t": 8, "int": 4, "int32_t": 4, "uint32_t": 4}


@functools.cache
def header() -> str:
    """The C header of the installed jaxlib.

    Returns:
        Its text without comments.

    Raises:
        OSError: If there is none.
    """
    file = pathlib.Path(jax.ffi.include_dir()) / "xla" / "ffi" / "api" / "c_api.h"
    return re.sub(r"//.*", "", file.read_text())


def layout(text: str) -> Layout:
    """Places of fields in structs, as C has them on 64 bits.

    Args:
        text: The header.

    Returns:
        For each struct the place of each field, and `bytes`, the size that XLA says.

    Raises:
        NotImplementedError: If the header has a type that isn't known here.
    """
    text = re.sub(r"_XLA_FFI_API_STRUCT_FIELD\((\w+)\);", r"void* \1;", text)
    text = re.sub(r"\(\*(\w+)\)\(.*?\)", r"* \1", text)
    sizes = dict(_SIZES)
    sizes |= dict.fromkeys(re.findall(r"typedef enum \{[^}]*\} (\w+);", text), 4)
    sizes |= dict.fromkeys(re.findall(r"typedef uint32_t (\w+);", text), 4)
    structs: dict[str, dict[str, int]] = {}
    for name, body in re.findall(r"struct (\w+) \{(.*?)\n\}", text, re.DOTALL):
        places, ends = _fields(body, sizes, structs)
        whole = max(ends.values(), default=0)
        sizes[name] = -(-whole // 8) * 8
        last = re.search(rf"STRUCT_TRAITS\({name}, (\w+)\)", text)
        structs[name] = places | {"bytes": ends[last[1]] if last else sizes[name]}
    return structs


def _fields(
    body: str, sizes: Mapping[str, int], structs: Layout
) -> tuple[dict[str, int], dict[str, int]]:
    """Where a struct's fields begin, those of structs inside it too, and where they end."""
    place, places, ends = 0, {}, {}
    for field in filter(None, map(str.strip, body.split(";"))):
        kind, name = re.fullmatch(r"(?:const |struct )*(.*?)(\w+)", field, re.DOTALL).groups()
        kind = kind.strip()
        if "*" not in kind and kind not in sizes:
            raise NotImplementedError(f"XLA's header has a field of an unknown type: {field}.")
        size = 8 if "*" in kind else sizes[kind]
        alignment = min(size, 8)
        place = -(-place // alignment) * alignment
        inner = {f"{name}.{own}": place + n for own, n in structs.get(kind, {}).items()}
        places |= {name: place, **inner}
        place = ends[name] = place + size
    return places, ends


def version(text: str, name: str) -> int:
    """A part of the interface's version.

    Args:
        text: The header.
        name: `MAJOR` or `MINOR`.

    Returns:
        The number that the header defines.

    Raises:
        NotImplementedError: If it defines none.
    """
    defined = re.search(rf"#define XLA_FFI_API_{name} (\d+)", text)
    if defined is None:
        raise NotImplementedError(f"XLA's header defines no `XLA_FFI_API_{name}`.")
    return int(defined[1])
