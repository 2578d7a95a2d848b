"""A small valid file for every reader, and the reader."""

from __future__ import annotations

import io
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import h5py
import numcodecs
import numpy as np
import pyarrow as pa
import zarr
from mcap.writer import Writer
from pyarrow import parquet
from rosbags.rosbag1 import Writer as BagWriter1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter2
from rosbags.typesys import Stores, get_typestore
from scipy.io import savemat

from hostile.meshes import meshes
from varishold import TactileClassifier
from varishold import open as open_recording
from varishold.circuit.interchange import read_netlist, write_netlist
from varishold.errors import InputError, VarisholdError
from varishold.grasp import fit_model, read_model, write_model
from varishold.learning import read_model as read_learned
from varishold.learning import write_model as write_learned
from varishold.perceive import Evidence, Library, Perceiver, read_library, read_prior, write_library
from varishold.recording import GraspTable, Pad, Recording, Signals, read, read_grasp_table, read_height_map, write
from varishold.recording.mcap import PadFacts, TopicWriter
from varishold.recording.mcap.topics import MARKS
from varishold.sensor import Sensor, read_sensor, read_skin
from varishold.solids.mesh_file import read_mesh
from varishold.touch import find_contacts

__all__ = ["Specimen", "specimens"]


@dataclass(frozen=True)
class Specimen:
    """A valid file: its name and content, and what reads it."""

    name: str
    content: bytes
    read: Callable[[Path], object]


def _recording(path: Path) -> object:
    got = read(path)
    with open_recording(path) as opened:
        for block in opened.blocks(2):
            assert block.n_frames in (1, 2)
    return got.remarks, got.totals()


def _shaped(path: Path) -> object:
    return read(path, shape=(3, 4)).remarks


def _beside(path: Path) -> object:
    """A sensor file that names the map."""
    sensor = path.with_name("beside.toml")
    sensor.write_text(f'gain_map = "{path.name}"\n')
    return _sensor(sensor)


def _sensor(path: Path) -> object:
    """A sensor file, and what lies behind its readings."""
    sensor = read_sensor(path)
    with _told_of(path):
        return _undone(sensor)


def _undone(sensor: Sensor) -> object:
    rows, cols = sensor.readings_shape or (3, 4)
    readings = np.asarray(sensor.rest) + np.linspace(0.0, 200.0, rows * cols).reshape(rows, cols)
    return find_contacts(readings, 4, sensor=sensor)


def _learned(path: Path) -> object:
    """A model of presses, and what it says of some."""
    learned = read_learned(path)
    with _told_of(path):
        return learned.explain(_PRESSES)


def _grasps(path: Path) -> object:
    """A model of grasps, and what it says of some."""
    model = read_model(path)
    cells: dict[str, Any] = {"object": np.array(["cone", "cube"])}
    cells |= {name: np.array([0.0, 1.0]) for name in (*(f"switch.{k}" for k in range(5)), *_numbers(_rng()))} | cells
    with _told_of(path):
        return list(model.answer(GraspTable(cells), why=True))


def _felt(path: Path) -> object:
    """A library, and what it makes of two touches."""
    library = read_library(path)
    with _told_of(path):
        perceiver = Perceiver(library)
        perceiver.feel(Evidence("grasp", {"form.0": 0.1, "form.1": 0.2, "size.circle": 0.3, "switch.x": 1.0}))
        perceiver.failed("tip")
        return perceiver.plan(), perceiver.answer()


@contextmanager
def _told_of(path: Path) -> Iterator[None]:
    """What was read is used: an error of that need not name the file."""
    try:
        yield
    except VarisholdError as error:
        raise InputError(f"{path}: {error}") from error


def _rng() -> np.random.Generator:
    return np.random.default_rng(0)


def specimens() -> tuple[Specimen, ...]:
    """Return one small valid file of every kind."""
    rng = np.random.default_rng(0)
    frames = rng.integers(0, 50, (3, 4, 5))
    made: list[Specimen] = []
    with tempfile.TemporaryDirectory() as folder:

        def add(name: str, write_it: Callable[[Path], object], reader: Callable[[Path], object]) -> None:
            path = Path(folder, name)
            write_it(path)
            made.append(Specimen(name, path.read_bytes(), reader))

        pad = Pad(frames, valid=np.arange(20).reshape(4, 5) != 7, pitch_m=(0.002, 0.003))
        hand = {"thumb": pad, "palm": Pad(frames.astype(np.float32))}
        add("hand.npz", lambda p: write(Recording(hand, time_s=np.arange(3.0), unit="kPa", sensor="s"), p), _recording)
        numbered = Recording({"pad": pad}, press=np.array([0, 0, 1]), press_columns={"thing": np.array(["a", "b"])})
        add("hand.mcap", lambda p: write(Recording(hand, time_s=np.arange(3.0), unit="kPa", sensor="s"), p), _recording)
        add("presses.mcap", lambda p: write(numbered, p), lambda p: read(p).presses)
        add("live.mcap", lambda p: p.write_bytes(_stream(rng)), _recording)
        add("others.mcap", lambda p: p.write_bytes(_of_others()), _recording)
        full = Recording(
            hand,
            time_s=np.arange(3.0),
            press=np.array([-1, 0, 0]),
            press_columns={"thing": np.array(["a"])},
            signals={"shear": Signals(rng.random((3, 2)), ("x", "y"), "N")},
        )
        add("hand.h5", lambda p: write(full, p), _recording)
        add("others.h5", _hdf5_of_others, _recording)
        add("hand.mat", lambda p: write(full, p), _recording)
        mixed = {
            "palm": {"pressure": frames, "unit": "kPa"},
            "time_s": np.arange(3.0),
            "names": np.array(["a"], object),
        }
        add("loose.mat", lambda p: savemat(p, mixed), _recording)
        add("packed.mat", lambda p: savemat(p, mixed, do_compression=True), _recording)
        add("hand.parquet", lambda p: write(full, p), _recording)
        add("others.parquet", _parquet_of_others, _recording)
        add("of1.bag", lambda p: _bag_of_ros_1(p, None), _recording)
        add("packed.bag", lambda p: _bag_of_ros_1(p, BagWriter1.CompressionFormat.BZ2), _recording)
        add("of2.db3", _bag_of_ros_2, _recording)
        add("stored.npz", lambda p: np.savez(p, pressure=frames, time_s=np.arange(3)), _recording)
        add("plain.npy", lambda p: np.save(p, frames), _recording)
        add("flat.npy", lambda p: np.save(p, rng.random((4, 12))), _shaped)
        add("weiss.npz", lambda p: np.savez(p, **_weiss(rng)), _recording)
        add("touch.npz", lambda p: np.savez(p, capacitance=frames, pitch_mm=4.8), _recording)
        shades = (frames * 1000).astype(np.uint16)
        add("depth.png", lambda p: cv2.imwrite(str(p), shades[0]), _recording)
        add("depth.tif", lambda p: cv2.imwrite(str(p), shades[0].astype(np.float32)), _recording)
        add("plain.tif", lambda p: cv2.imwrite(str(p), shades[0], (cv2.IMWRITE_TIFF_COMPRESSION, 1)), _recording)
        add("pages.tif", lambda p: cv2.imwritemulti(str(p), list(shades)), _recording)
        numbered_pictures = {f"{k}.png": cv2.imencode(".png", shade)[1].tobytes() for k, shade in enumerate(shades)}
        made += _parts("pictures", numbered_pictures)
        write(full, Path(folder, "hand.lerobot"))
        # What is never read of a data set is not spoilt.
        held = {n: c for n, c in _files_of(Path(folder, "hand.lerobot")).items() if "stats" not in n and "epi" not in n}
        made += _parts("lerobot", held)
        made += _parts("lerobot-others", {name: held[name] for name in held if "varishold" not in name})
        for version in (2, 3):
            _zarr_of_others(Path(folder, f"{version}.zarr"), frames, version)
            made += _parts(f"zarr{version}", _files_of(Path(folder, f"{version}.zarr")), _OF_ZARR)
        archive = zarr.storage.ZipStore(str(Path(folder, "packed.zarr.zip")), mode="w")
        zarr.create_array(archive, name="tactile", data=frames, chunks=(2, 4, 5))
        archive.close()
        made.append(Specimen("packed.zarr.zip", Path(folder, "packed.zarr.zip").read_bytes(), _recording))
        for name, text in _TEXTS.items():
            add(name, lambda p, text=text: p.write_text(text), _shaped if name.startswith("flat") else _recording)
        add("map.csv", lambda p: p.write_text("0;0,5;1\n2;1,5;0\n"), read_height_map)
        add("map.npy", lambda p: np.save(p, rng.random((4, 5))), read_height_map)
        made += [Specimen(name, content, read_mesh) for name, content in meshes().items()]
        for name, text in _SKINS.items():
            add(name, lambda p, text=text: p.write_text(text), read_skin)
        for name, text in _SENSORS.items():
            add(name, lambda p, text=text: p.write_text(text), _sensor)
        add("gains.csv", lambda p: p.write_text("# gains\n0.9,1.1\n1,nan\n"), _beside)
        add("gains.npy", lambda p: np.save(p, rng.random((2, 2))), _beside)
        add("gains.npz", lambda p: np.savez(p, gains=rng.random((2, 2))), _beside)
        bits = rng.random((12, 5)) < 0.5
        cells: dict[str, Any] = {"object": np.repeat(["cone", "cube", "ball"], 4), "size_m": rng.random(12)}
        cells |= {f"switch.{k}": bits[:, k] for k in range(5)}
        table = GraspTable(cells)
        add("grasps.csv", lambda p: p.write_text(_GRASPS), read_grasp_table)
        model = fit_model(table, label="object")
        add("model.json", lambda p: write_model(model, p), _grasps)
        coded = fit_model(GraspTable(_numbers(rng)), label="object", encode="quantile")
        add("coded.json", lambda p: write_model(coded, p), _grasps)
        add("netlist.json", lambda p: write_netlist(model.netlist, p), read_netlist)
        add("camera.json", _write_prior, read_prior)
        felt = [(1 + k) * frames ** (1 + k % 2) for k in range(6)]
        learned = TactileClassifier(drift=0.0, folds=2).fit(felt, [0, 1] * 3)
        add("things.npz", lambda p: write_learned(learned, p), _learned)
        add("presses.npz", lambda p: write(numbered, p), lambda p: read(p).presses)
        add("library.npz", lambda p: write_library(_small_library(rng), p), _felt)
    return tuple(made)


def _files_of(folder: Path) -> dict[str, bytes]:
    """Return the files of a folder by their names in it."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def _parts(title: str, files: Mapping[str, bytes], only: str = "") -> list[Specimen]:
    """Return the files of a folder that is a recording whose names match, each to be spoilt among the others."""

    def reader(changed: str) -> Callable[[Path], object]:
        def read_it(path: Path) -> object:
            folder = path.with_name(f"{path.name}.folder")
            if not folder.exists():
                for name, content in files.items():
                    (folder / name).parent.mkdir(parents=True, exist_ok=True)
                    (folder / name).write_bytes(content)
            (folder / changed).write_bytes(path.read_bytes())
            return _recording(folder)

        return read_it

    return [
        Specimen(f"{title}-{name.replace('/', '-')}", content, reader(name))
        for name, content in files.items()
        if re.search(only, name)
    ]


def _weiss(rng: np.random.Generator) -> Mapping[str, Any]:
    mask = np.ones((2, 3, 4), np.bool_)
    return {
        "frames": rng.integers(0, 9, (5, 2, 3, 4)),
        "texel_mask": mask,
        "time_ms": np.arange(5),
        "start": np.array([0, 3]),
    }


def _stream(rng: np.random.Generator) -> bytes:
    """What a recorder has written when it is killed: images in two encodings, signals, marks, and no end."""
    made = io.BytesIO()
    writer = TopicWriter(made)
    writer.describe(PadFacts("tip", kind="signals", names=("x", "y")))
    writer.attach("sensor.toml", b"span = 5\n")
    for k in range(4):
        writer.reading({"palm": rng.random((2, 3)) * k, "tip": rng.random(2)}, log_ns=k * 10**7, device_ns=k * 10**7)
        writer.tell(MARKS, {"label": "cone"}, log_ns=k * 10**7)
        writer.flush()
    return made.getvalue()


def _of_others() -> bytes:
    """Topics of another program: an array with a layout, and JSON."""
    store, made = get_typestore(Stores.LATEST), io.BytesIO()
    kind, types = "std_msgs/msg/Float32MultiArray", store.types
    text, _ = store.generate_msgdef(kind, ros_version=2)
    writer = Writer(made)
    writer.start("ros2")
    array = writer.register_channel("/skin", "cdr", writer.register_schema(kind, "ros2msg", text.encode()))
    words = writer.register_channel("/tips", "json", 0)
    dims = [types["std_msgs/msg/MultiArrayDimension"](name, size, 6) for name, size in (("rows", 2), ("cols", 3))]
    for k in range(3):
        said = types[kind](types["std_msgs/msg/MultiArrayLayout"](dims, 0), np.arange(6, dtype=np.float32) * k)
        writer.add_message(array, k, bytes(store.serialize_cdr(said, kind)), k)
        writer.add_message(words, k, b'{"time_s": 1.5, "sensors": [{"name": "tip", "values": [[1, 2], [3, 4]]}]}', k)
    writer.finish()  # type: ignore[no-untyped-call]
    return made.getvalue()


def _hdf5_of_others(path: Path) -> None:
    """Packed pieces, texts of any length, links, names that have to be guessed."""
    frames = np.arange(60, dtype=np.float32).reshape(3, 4, 5)
    with h5py.File(path, "w", libver="latest") as file:
        packed = {"compression": "gzip", "shuffle": True, "fletcher32": True}
        file.create_dataset("arm/tactile", data=frames, chunks=(1, 4, 5), **packed)
        file["arm/tactile"].attrs["unit"] = "kPa"
        file["arm/time"], file["link"] = np.arange(3.0), h5py.SoftLink("/arm")
        file.create_dataset("arm/packed", data=frames, chunks=(2, 4, 5), compression="lzf")


def _zarr_of_others(path: Path, frames: np.ndarray, version: Any) -> None:
    """Groups with attributes, pieces packed in several ways or in shards, axes turned, text."""
    root = zarr.open_group(str(path), mode="w", zarr_format=version)
    root.attrs["unit"] = "kPa"
    last: dict[str, Any] = {"compressors": zarr.codecs.GzipCodec()}
    if version == 3:
        last["filters"] = [zarr.codecs.TransposeCodec(order=(2, 0, 1))]
        packers: tuple[Any, ...] = (zarr.codecs.ZstdCodec(), zarr.codecs.BloscCodec(shuffle="bitshuffle"))
    else:
        packers = (numcodecs.Blosc(), numcodecs.LZ4())
        last = {"compressors": numcodecs.Zstd(), "order": "F", "fill_value": None}
    hows = ({"compressors": packers[0]}, {"compressors": packers[1]}, last)
    for name, how in zip(("a/pressure", "b/pressure", "c/pressure"), hows, strict=True):
        root.create_array(name, data=frames, chunks=(2, 4, 5), **how)
    if version == 3:
        root.create_array("d/pressure", data=frames, chunks=(1, 4, 5), shards=(4, 4, 5))
    root.create_array("time_s", data=np.arange(3.0))
    root.create_array("press", data=np.arange(3))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        root.create_array("presses/label", data=np.array(["a", "b", "c"]))


def _parquet_of_others(path: Path) -> None:
    """Lists in lists, of any length, in several groups of rows, and text."""
    frames = np.arange(60, dtype=np.float32).reshape(3, 4, 5)
    lists = pa.array(frames.tolist(), pa.list_(pa.list_(pa.float32())))
    columns = {"tactile": lists, "timestamp": pa.array([0.0, 0.1, 0.2]), "task": pa.array(["a", None, "b"])}
    parquet.write_table(pa.table(columns), path, row_group_size=2)


def _bag_of_ros_1(path: Path, packing: Any) -> None:
    """Two topics, one of them of arrays with a layout."""
    store = get_typestore(Stores.ROS1_NOETIC)
    types, kind = store.types, "std_msgs/msg/Float32MultiArray"
    writer = BagWriter1(path)
    if packing is not None:
        writer.set_compression(packing)
    with writer:
        skin = writer.add_connection("/skin", "sensor_msgs/msg/Image", typestore=store)
        array = writer.add_connection("/array", kind, typestore=store)
        dims = [types["std_msgs/msg/MultiArrayDimension"](name, size, 6) for name, size in (("rows", 2), ("cols", 3))]
        for k in range(3):
            header = types["std_msgs/msg/Header"](k, types["builtin_interfaces/msg/Time"](k, 5), "skin")
            image = types["sensor_msgs/msg/Image"](header, 2, 3, "mono8", 0, 3, np.arange(6, dtype=np.uint8) * k)
            writer.write(skin, k, store.serialize_ros1(image, "sensor_msgs/msg/Image"))
            said = types[kind](types["std_msgs/msg/MultiArrayLayout"](dims, 0), np.arange(6, dtype=np.float32) * k)
            writer.write(array, k, store.serialize_ros1(said, kind))


def _bag_of_ros_2(path: Path) -> None:
    store, folder = get_typestore(Stores.LATEST), path.with_suffix(".folder")
    types, kind = store.types, "sensor_msgs/msg/Image"
    with BagWriter2(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        skin = writer.add_connection("/skin", kind, typestore=store)
        for k in range(3):
            header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](k, 5), "skin")
            image = types[kind](header, 2, 3, "32FC1", 0, 12, np.arange(6, dtype=np.float32).view(np.uint8))
            writer.write(skin, k, store.serialize_cdr(image, kind))
    (made,) = folder.glob("*.db3")
    made.replace(path)


def _numbers(rng: np.random.Generator) -> dict[str, Any]:
    columns = {f"force_n.{k}": rng.random(12) for k in range(3)}
    return {"object": np.repeat(["cone", "cube"], 6), **columns}


def _write_prior(path: Path) -> None:
    path.write_text('{"source": "camera", "probability": {"cone": 0.7, "ball": 0.3}, "p_value": 0.4, "weight": 0.5}')


def _small_library(rng: np.random.Generator) -> Library:
    """Two objects felt in two ways, eight times each."""

    def felt() -> list[Evidence]:
        numbers = rng.normal(size=(2, 4))
        return [
            Evidence(touch, {"form.0": a, "form.1": b, "size.circle": c, "switch.x": float(d > 0)})
            for touch, (a, b, c, d) in zip(("grasp", "tip"), numbers, strict=True)
        ]

    examples = {name: [felt() for _ in range(8)] for name in ("ball", "cube")}
    return Library.from_examples(
        examples, sizes_m=dict.fromkeys(examples, np.full(8, 0.07)), others=[felt() for _ in range(4)]
    )


# Two presses, as the model of presses knows them.
_PRESSES = [np.random.default_rng(1).integers(0, 50, (3, 4, 5)) for _ in range(2)]
# Of each kind of file of a data set one.
_OF_ZARR = r"pressure/(\.zarray|zarr\.json|0\.0\.0|c/0/0/0)$|^\.zattrs$|^zarr\.json$|label/(\.zarray|zarr\.json)$"
_ROWS = "1,2,3,4\n5,6,7,8\n9,10,11,12\n"
_TEXTS = {
    "flat.csv": "time_ms,"
    + ",".join("abcdefghijkl")
    + "\n"
    + "0,0,0,1,0,4,2,1,2,3,4,5,6\n20,0,1,3,0,9,4,1,2,3,4,5,6\n",
    "rows.csv": "0 0 1\n0 4 2\n\n0 1 3\n0 9 4\n",
    "comma.csv": "0;0;1\n0;4,5;2\n\n0;1;3\n0;9;4,25\n",
    "scan.asf": "DATA_TYPE MOVIE\nROWS 3\nCOLS 4\nROW_SPACING 2 mm\nCOL_SPACING 0.1 inch\nUNITS kPa\n"
    "SECONDS_PER_FRAME 0.01\nSTART_FRAME 1\nEND_FRAME 2\nASCII_DATA @@\n\n"
    "Frame 1\nB,1,2,3\n4,5,6,7\n8,9,1,2\n\nFrame 2\nB,2,2,3\n4,5,6,7\n8,9,1,B\n@@\n".replace("1,B", "1,2"),
    "grasp.txt": "-10000\r\n"
    + 2
    * (
        "20.7 81.1 15.4 0.5 40.4 66.7 36.3 55.5 2.0 \r\n14.0 15.0 11.0 14.0 11.0\r\n"
        + 5 * (" ".join(f"{240 + k}.0" for k in range(12)) + "\r\n")
    ),
    "table.csv": "label,press,tip.0.0,tip.0.1,palm_1_1,palm_1_2,palm_2_1,palm_2_2,joint_0,switch.a\n"
    'cone,0,1,2,3,4,5,6,0.5,1\ncone,0,2,3,4,5,6,7,0.5,1\n"a, b",1,2,3,4,5.5,6,7,0.25,0\n',
    "flat-table.csv": "time_s,tip_0,tip_1,tip_2,tip_3,tip_4,tip_5,tip_6,tip_7,tip_8,tip_9,tip_10,tip_11,label\n"
    "0.5,1,2,3,4,5,6,7,8,9,10,11,12,a\n0.7,2,3,4,5,6,7,8,9,10,11,12,13,b\n",
    "x.csv": f"Sensor:,X3\nRows:,3\nColumns:,4\nUnits:,psi\nTime:,12:00:01.5\n{_ROWS}Time:,12:00:02.5\n{_ROWS}",
}
_SKINS = {
    "layer.toml": '# a cover\n[skin]\nkind = "layer"\nthickness_m = 6e-3\npoisson = 0.45\nsensing_depth_m = 0.001\n'
    "youngs_modulus_pa = 200_000\n",
    "half.toml": '[skin]\nkind = "half-space"\n',
}
_SENSORS = {
    "grid.toml": 'name = "mat"\nshape = [2, 3]\npitch_m = [0.002, 3e-3]\nfield = [[1, 1, 1], [1, 1, 0]]\n'
    'polarity = "down"\nrest = 255\nspan = 255.0\nunit = "kPa"\ncrosstalk = 0.1\nsaturation = 1.0\n'
    "gain_map = [[1, 0.9, nan], [1.1, 0, 1]]\n[response]\nkind = 'table'\nstresses = [0, 0.25, 1]\n"
    "readings = [0, 0.5, 1]\n[calibration]\nframes = 12\n",
    "tip.toml": "span = 1023\npositions_m = [[0, 0], [0.002, 0], [0, 0.002], [0.002, 0.003]]\nrest = [[1, 2, 3, 4]]\n"
    '[response]\nkind = "logarithmic"\na = 5.0\n[skin]\nkind = "half-space"\n',
}
_GRASPS = (
    "object,size_m,seed,step,held,switch.a,switch.b,angle_rad.x\ncone,0.03,1,5,1,1,0,0.52\n"
    'cube,0.03,2,5,1,1,1,0.47\n"a ""b"", c",0.03,2,5,1,1,1,\n'
)
