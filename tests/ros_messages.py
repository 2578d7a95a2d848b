"""Messages of robots made with rosbags, the reference library: types that only their text defines among them."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

LINE = "=" * 80
HEADER = f"""{LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""

#: Texts of types that are in no standard package, as their drivers define them.
TEXTS = {
    "tactile_msgs/msg/TactileState": f"""std_msgs/Header header
sensor_msgs/ChannelFloat32[] sensors
{LINE}
MSG: sensor_msgs/ChannelFloat32
string name
float32[] values
{HEADER}""",
    "xela_server_ros2/msg/SensStream": f"""SensorFull[] sensors
{LINE}
MSG: xela_server_ros2/SensorFull
uint32 message
float64 time
string model
uint8 sensor_pos
Taxel[] taxels
Forces[] forces
{LINE}
MSG: xela_server_ros2/Taxel
uint16 x
uint16 y
uint16 z
{LINE}
MSG: xela_server_ros2/Forces
float32 x
float32 y
float32 z
""",
    "papillarray_ros2_v2/msg/SensorState": f"""std_msgs/Header header
int64 tus
PillarState[] pillars
float32 gfX
bool is_contact
{LINE}
MSG: papillarray_ros2_v2/PillarState
int32 id
float32 dX
float32 dY
float32 dZ
float32 fX
float32 fY
float32 fZ
bool in_contact
int32 slip_state
{HEADER}""",
    "sr_robot_msgs/msg/BiotacAll": f"""std_msgs/Header header
Biotac[2] tactiles
{LINE}
MSG: sr_robot_msgs/Biotac
int16 pac0
int16 pac1
int16 pdc
int16 tac
int16 tdc
int16[] electrodes
{HEADER}""",
    "sr_robot_msgs/msg/MST": f"""builtin_interfaces/Time timestamp
geometry_msgs/Point[] magnetic_data
float32[] temperature_data
int8 status
{LINE}
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
{LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
""",
    "schunk_sdh/msg/TactileSensor": f"""std_msgs/Header header
TactileMatrix[] tactile_matrix
{LINE}
MSG: schunk_sdh/TactileMatrix
uint32 matrix_id
int16 cells_x
int16 cells_y
int16[] tactile_array
{HEADER}""",
    "schunk_sdh/msg/PressureArrayList": f"""std_msgs/Header header
PressureArray[] pressure_list
{LINE}
MSG: schunk_sdh/PressureArray
string sensor_name
uint16 cells_x
uint16 cells_y
float64[] pressure
{HEADER}""",
    "robotis_interfaces/msg/HandPressures": f"""std_msgs/Header header
string hand_name
TactileSensor[] sensors
{LINE}
MSG: robotis_interfaces/TactileSensor
string sensor_name
string[9] pressure_names
uint8[9] pressure_values
{HEADER}""",
    "wujihand_msgs/msg/TactileFrame": f"""std_msgs/Header header
uint8 hand              # 0=left, 1=right
uint16 sequence
uint32 device_timestamp # Milliseconds
int16[768] pressure
{HEADER}""",
    "wujihand_tactile_msgs/msg/TactileFrame": f"""std_msgs/Header header
uint8 hand
uint16 sequence
uint32 device_timestamp_ms
float32[768] pressure
{HEADER}""",
    "unitree_hg/msg/HandState": f"""PressSensorState[9] press_sensor_state
float32 power_v
{LINE}
MSG: unitree_hg/PressSensorState
float32[12] pressure
float32[12] temperature
uint32 lost
uint32 reserve
""",
    "tactile_msgs/msg/TactileMsg": f"""std_msgs/Header header
Frame left
Frame right
{LINE}
MSG: tactile_msgs/Frame
string SN
uint32 index
float64 sendTimestamp
float64 recvTimestamp
float64[1200] Positions
float64[1200] Displacements
float64[1200] Forces
float64[3] ResultantForce
float64[3] ResultantMoment
{HEADER}""",
    "inspire/msg/inspire_hand_touch": """int16[] fingerone_tip_touch
int16[] fingerone_top_touch
int16[] fingerone_palm_touch
int16[] palm_touch
""",
    "somebody/msg/Skin": """uint8 FOO = 3
string what
float32[] skin
""",
}
STANDARD = get_typestore(Stores.LATEST)


def text_of(name: str) -> str:
    """Return the whole text of a type, as bags and bridges hold it."""
    return TEXTS[name] if name in TEXTS else STANDARD.generate_msgdef(name, ros_version=2)[0]


@cache
def store_of(name: str) -> Any:
    """Return a type store with a type and all that it holds."""
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text_of(name), name))
    return store


def made(name: str, store: Any, /, **values: Any) -> Any:
    """Return a message of a type: fields that are not given are nothing, and dicts become messages."""
    kind = store.types[name]
    filled = {}
    for field, description in store.fielddefs[name][1]:
        given = next((value for key, value in values.items() if key == field), None)
        filled[field] = _filled(description, given, store)
    known = {field.name for field in dataclasses.fields(kind)}
    assert set(filled) <= known
    assert set(values) <= set(filled), "no such field"
    return kind(**filled)


def _filled(description: Any, given: Any, store: Any) -> Any:
    kind, inner = int(description[0]), description[1]
    if kind == 1:
        return given if given is not None else ("" if inner[0] == "string" else 0)
    if kind == 2:
        return made(inner, store, **(given or {}))
    (within, what), count = inner
    if int(within) == 2:
        items = list(given or [])
        items += [{}] * (count - len(items)) if kind == 3 else []
        return [made(what, store, **item) for item in items]
    if what[0] == "string":
        return list(given or []) + [""] * (count - len(given or []) if kind == 3 else 0)
    dtype = np.dtype({"byte": "int8", "char": "uint8", "bool": "bool"}.get(what[0], what[0]))
    return np.asarray(given if given is not None else np.zeros(count if kind == 3 else 0), dtype)


def bytes_of(message: Any, store: Any, encoding: str = "cdr", *, little_endian: bool = True) -> bytes:
    """Return a message as it stands on the wire."""
    name = message.__msgtype__
    if encoding == "ros1":
        return bytes(store.serialize_ros1(message, name))
    return bytes(store.serialize_cdr(message, name, little_endian=little_endian))


def as_dict(message: Any) -> Any:
    """Return a message as JSON would hold it."""
    if isinstance(message, np.ndarray):
        return message.tolist()
    if isinstance(message, list):
        return [as_dict(item) for item in message]
    if dataclasses.is_dataclass(message):
        names = [field.name for field in dataclasses.fields(message) if not field.name.startswith("__")]
        return {name.rstrip("_"): as_dict(getattr(message, name)) for name in names}
    return message
