"""Small runs for tests, written without Kedge."""
import base64
import contextlib
import io
import json
import pathlib
import struct
import sys
import tempfile
import unittest
import zlib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from kedge_plot.command import main  # noqa: E402  (found only after the line above)

_NAMES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u1": "UInt8"}


class VtuWriter:
    """Writes a grid in any of VTK's encodings."""

    def __init__(self, form, zipped=False, header="UInt32", order="<", block=64):
        self.form, self.zipped, self.header, self.order, self.block = form, zipped, header, order, block
        self.appended = b""

    def encoded(self, values):
        """Header and data in VTK's layout, in base64 unless raw."""
        word = self.order + ("Q" if self.header == "UInt64" else "I")
        data = values.astype(values.dtype.newbyteorder(self.order)).tobytes()
        if not self.zipped:
            parts = [struct.pack(word, len(data)) + data]
        else:
            blocks = [data[i:i + self.block] for i in range(0, len(data), self.block)]
            rest = len(data) % self.block
            packed = [zlib.compress(block) for block in blocks]
            head = [len(blocks), self.block, rest] + [len(block) for block in packed]
            parts = [b"".join(struct.pack(word, number) for number in head), b"".join(packed)]
        return b"".join(parts if self.form == "raw" else map(base64.b64encode, parts))

    def array(self, name, values):
        values = np.ascontiguousarray(values)
        tag = (f'<DataArray type="{_NAMES[values.dtype.str[1:]]}" Name="{name}" '
               f'NumberOfComponents="{values.shape[1] if values.ndim > 1 else 1}" ').encode()
        if self.form == "ascii":
            return tag + b'format="ascii">' + " ".join(map(str, values.ravel())).encode() + b"</DataArray>"
        if self.form == "inline":
            return tag + b'format="binary">\n' + self.encoded(values) + b"\n</DataArray>"
        offset = len(self.appended)
        self.appended += self.encoded(values)
        return tag + f'format="appended" offset="{offset}"/>'.encode()

    def write(self, path, points, cells, cell_type, cell_data):
        cells = np.asarray(cells, dtype=np.int32)
        body = (f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}"><Points>'.encode() +
                self.array("Points", np.asarray(points, dtype=float)) + b"</Points><Cells>" +
                self.array("connectivity", cells.ravel()) +
                self.array("offsets", np.arange(1, len(cells) + 1, dtype=np.int32) * cells.shape[1]) +
                self.array("types", np.full(len(cells), cell_type, dtype=np.uint8)) + b"</Cells><CellData>" +
                b"".join(self.array(name, values) for name, values in cell_data.items()) + b"</CellData></Piece>")
        order = "LittleEndian" if self.order == "<" else "BigEndian"
        zipped = ' compressor="vtkZLibDataCompressor"' if self.zipped else ""
        tail = b""
        if self.appended:
            encoding = "raw" if self.form == "raw" else "base64"
            tail = f'<AppendedData encoding="{encoding}">\n_'.encode() + self.appended + b"\n</AppendedData>"
        path.write_bytes(f'<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="1.0" byte_order="{order}" '
                         f'header_type="{self.header}"{zipped}><UnstructuredGrid>'.encode() + body +
                         b"</UnstructuredGrid>" + tail + b"</VTKFile>")


def boxes(n=3):
    """A block of n^3 boxes of side 1 from the origin: points, cells and their lower corners."""
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    lower = np.stack(np.meshgrid(*3 * [np.arange(n)], indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    return (lower[:, None] + corner).reshape(-1, 3), np.arange(8 * len(lower)).reshape(-1, 8), lower


def cube(lower, upper):
    """Points and triangles of a closed box."""
    points = [[(lower, upper)[v >> d & 1][d] for d in range(3)] for v in range(8)]
    return points, [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
                    [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]


def write_run(folder, step=12, writer=None):
    """A run with a block of soil, a body in it and its history."""
    (folder / "vtk").mkdir()
    (folder / "csv").mkdir()
    points, cells, lower = boxes()
    stress = np.zeros((len(lower), 6), dtype=np.float32)
    stress[:, 0] = -1000. * lower[:, 0]
    writer = writer or VtuWriter("raw", zipped=True, header="UInt64")
    writer.write(folder / "vtk" / f"mps_1_{step:05d}.vtu", points, cells, 12,
                 {"displacement": lower.astype(np.float32), "stress": stress})
    VtuWriter("inline").write(folder / "vtk" / f"surface_{step:05d}.vtu", *cube((1., 1., 1.), (2., 2., 2.)), 5,
                              {"body": np.ones(12, dtype=np.int32)})
    d = np.linspace(0., 0.05, 60)
    rows = ["time,body1_position_x,body1_position_y,body1_position_z,body1_reaction force_x,body1_reaction force_y,"
            "body1_reaction force_z,stage,step"]
    rows += [f"{x},{3. - x},0,0,{-x / (1e-5 + x / 500.)},0,0,1,{i}" for i, x in enumerate(d)]
    (folder / "csv" / "rigid_body.csv").write_text("\n".join(rows) + "\n0.1,2.9", encoding="utf-8")  # cut off
    (folder / "summary.json").write_text(json.dumps({"version": "0.1.0", "input": "/tmp/pull.json"}), encoding="utf-8")


class TemporaryFolder(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_command(self, *arguments):
        """Exit code, standard output and standard error."""
        out, error = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
            code = main([str(self.folder), *arguments])
        return code, out.getvalue(), error.getvalue()
