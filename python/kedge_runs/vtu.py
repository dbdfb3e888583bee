"""Reads VTK's XML unstructured grids (.vtu) and their parallel headers (.pvtu).

All encodings of VTK's file formats guide: ascii, base64 (inline or appended) and raw appended data, plain or in zlib
blocks, with 32 or 64 bit headers, of either byte order.
"""
import base64
import pathlib
import re
import xml.etree.ElementTree as ElementTree
import zlib
from dataclasses import dataclass, field

import numpy as np

from . import RunError

_TYPES = {"Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4",
          "Int64": "i8", "UInt64": "u8", "Float32": "f4", "Float64": "f8"}


@dataclass
class Grid:
    """Points (n, 3), cells as lists of point numbers with VTK's cell types, and named data with one row per point or
    cell."""
    points: np.ndarray
    connectivity: np.ndarray
    offsets: np.ndarray
    types: np.ndarray
    point_data: dict = field(default_factory=dict)
    cell_data: dict = field(default_factory=dict)

    def cells(self, cell_type):
        """Point numbers of all cells of one type, one row per cell."""
        wanted = np.flatnonzero(self.types == cell_type)
        if wanted.size == 0:
            return np.empty((0, 0), dtype=int)
        starts = np.concatenate(([0], self.offsets[:-1]))[wanted]
        size = self.offsets[wanted[0]] - starts[0]
        return self.connectivity[starts[:, None] + np.arange(size)]


def read_grid(path):
    """Reads a .vtu, or all pieces of a .pvtu joined to one grid."""
    path = pathlib.Path(path)
    if path.suffix == ".pvtu":
        sources = [piece.get("Source") for piece in _parse(path)[0].iter("Piece")]
        if not sources:
            raise RunError(f"{path}: names no pieces")
        return _join([_read_vtu(path.parent / source) for source in sources])
    return _read_vtu(path)


def _parse(path):
    """The XML tree and the bytes of raw appended data, which no XML parser accepts."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise RunError(f"{path}: cannot be read ({error.strerror})") from error
    raw = None
    opening = re.search(rb"<AppendedData[^>]*encoding=\"raw\"[^>]*>\s*_", content)
    if opening:
        end = content.rfind(b"</AppendedData>")
        raw = content[opening.end():end if end > 0 else len(content)]
        content = content[:opening.start()] + b"</VTKFile>"
    try:
        return ElementTree.fromstring(content), raw
    except ElementTree.ParseError as error:
        raise RunError(f"{path}: damaged XML ({error})") from error


def _read_vtu(path):
    root, raw = _parse(path)
    if root.tag != "VTKFile" or root.get("type") != "UnstructuredGrid":
        raise RunError(f"{path}: not a VTK unstructured grid")
    arrays = _Arrays(root, raw)
    try:
        return _join([_read_piece(piece, arrays) for piece in root.iter("Piece")])
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, zlib.error) as error:
        raise RunError(f"{path}: damaged or truncated data ({error})") from error


def _read_piece(piece, arrays):
    def section(name):
        element = piece.find(name)
        return {} if element is None else {array.get("Name"): arrays.read(array) for array in element}

    cells = section("Cells")
    points = arrays.read(piece.find("Points/DataArray")).reshape(-1, 3)
    return Grid(points, cells["connectivity"].astype(int), cells["offsets"].astype(int), cells["types"].astype(int),
                section("PointData"), section("CellData"))


def _join(grids):
    if len(grids) == 1:
        return grids[0]
    if not grids:
        raise ValueError("no pieces")
    points_before = np.cumsum([0] + [len(grid.points) for grid in grids[:-1]])
    entries_before = np.cumsum([0] + [len(grid.connectivity) for grid in grids[:-1]])

    def joined(data):
        names = set.intersection(*(set(entry) for entry in data))
        return {name: np.concatenate([entry[name] for entry in data]) for name in names}

    return Grid(np.concatenate([grid.points for grid in grids]),
                np.concatenate([grid.connectivity + n for grid, n in zip(grids, points_before)]),
                np.concatenate([grid.offsets + n for grid, n in zip(grids, entries_before)]),
                np.concatenate([grid.types for grid in grids]),
                joined([grid.point_data for grid in grids]),
                joined([grid.cell_data for grid in grids]))


class _Arrays:
    """Decodes the DataArray elements of one file."""

    def __init__(self, root, raw):
        self.order = ">" if root.get("byte_order") == "BigEndian" else "<"
        self.header = np.dtype(self.order + _TYPES[root.get("header_type", "UInt32")])
        self.compressed = root.get("compressor") is not None
        if root.get("compressor") not in (None, "", "vtkZLibDataCompressor"):
            raise RunError(f"compressor {root.get('compressor')} is not supported, only zlib")
        self.raw = raw
        appended = root.find("AppendedData")
        self.base64 = "" if appended is None else "".join(appended.text.split())[1:]  # after the underscore
        offsets = sorted({int(array.get("offset")) for array in root.iter("DataArray") if array.get("offset")})
        self.end = dict(zip(offsets, offsets[1:] + [None]))

    def read(self, element):
        """The array of a DataArray element; a row per entry where it has several components."""
        values = self._flat(element)
        n_components = int(element.get("NumberOfComponents") or 1)
        return values.reshape(-1, n_components) if n_components > 1 else values

    def _flat(self, element):
        kind = np.dtype(self.order + _TYPES[element.get("type")])
        form = element.get("format")
        if form == "ascii":
            return np.array((element.text or "").split(), dtype=kind)
        if form == "appended":
            begin = int(element.get("offset"))
            chunk = slice(begin, self.end[begin])
            data = self.raw[chunk] if self.raw is not None else _decode(self.base64[chunk])
        else:
            data = _decode(element.text or "")
        return np.frombuffer(self._inflate(data) if self.compressed else self._plain(data), dtype=kind)

    def _plain(self, data):
        n_bytes = int(np.frombuffer(data, self.header, 1)[0])
        data = data[self.header.itemsize:]
        if len(data) < n_bytes:
            raise ValueError(f"{len(data)} bytes instead of {n_bytes}")
        return data[:n_bytes]

    def _inflate(self, data):
        """Inflates blocks. The data holds their number, their size, the size of an incomplete last one, the compressed
        sizes, and the blocks."""
        n_blocks = int(np.frombuffer(data, self.header, 1)[0])
        sizes = np.frombuffer(data, self.header, n_blocks, 3 * self.header.itemsize) if n_blocks else []
        at = (3 + n_blocks) * self.header.itemsize
        blocks = []
        for size in sizes:
            blocks.append(zlib.decompress(data[at:at + int(size)]))
            at += int(size)
        return b"".join(blocks)


def _decode(text):
    """Decodes base64 whose header and data may be encoded separately, each with its own padding."""
    text = "".join(text.split())
    return b"".join(base64.b64decode(part) for part in re.findall(r"[^=]+={0,2}", text))
