"""A hand of a user's: what its file may say, and the one line that each fault of it ends in."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from varishold.errors import FormatError, InputError
from varishold.hand import read_hand
from varishold.hand.mjcf import hand_file, hand_files

#: A palm with two fingers that slide, one of them a mesh, as somebody else would write it: degrees, a floor, a key.
MJCF = """<mujoco model="gripper"><compiler angle="degree" meshdir="meshes" autolimits="true"/>
<asset><mesh file="jaw.obj" scale=".001 .001 .001"/></asset>
<worldbody><light pos="0 0 1"/><geom type="plane" size="1 1 .1"/>
<body name="base" pos="0 0 .3" euler="0 90 0"><freejoint/>
 <geom name="box" type="box" size=".04 .05 .02" mass=".4"/>
 <body name="left" pos="0 .06 .02"><joint name="left_slide" type="slide" axis="0 1 0" range="-.055 .01"/>
  <geom name="jaw" type="mesh" mesh="jaw" pos="0 0 .05"/></body>
 <body name="right" pos="0 -.06 .02"><joint name="right_slide" type="slide" axis="0 -1 0" range="-.055 .01"/>
  <geom name="right_jaw" type="box" pos="0 0 .05" size=".012 .006 .05"/><body name="sticker"><geom size=".001"
  contype="0" conaffinity="0"/></body></body>
</body></worldbody>
<equality><joint joint1="left_slide" joint2="right_slide"/></equality>
<actuator><position name="drive" joint="left_slide" kp="500" ctrlrange="-.055 .01" forcerange="-40 40"/></actuator>
<keyframe><key qpos="0 0 .3 1 0 0 0 0 0"/></keyframe><sensor><jointpos joint="left_slide"/></sensor></mujoco>
"""

TOML = """mjcf = "gripper.xml"
[palm]
body = "base"
out = [0, 0, 1]
up = [-1, 0, 0]
[[digits]]
name = "left"
joints = ["left_slide"]
[[digits]]
name = "right"
joints = ["right_slide"]
opposed = true
[[switches]]
name = "l"
part = "left.left"
[[switches]]
name = "r"
part = "right.right"
[[switches]]
name = "p"
part = "palm"
"""


def jaw() -> str:
    """A jaw's mesh in millimetres."""
    corners = [(x, y, z) for x in (-12, 12) for y in (-6, 6) for z in (-50, 50)]
    faces = ("1 2 4", "1 4 3", "5 7 8", "5 8 6", "1 5 6", "1 6 2", "3 4 8", "3 8 7", "1 3 7", "1 7 5", "2 6 8", "2 8 4")
    return "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {face}\n" for face in faces)


def write_gripper(folder: Path, *, toml: str = TOML, mjcf: str = MJCF) -> Path:
    """Write the gripper and return its file."""
    (folder / "meshes").mkdir(exist_ok=True)
    (folder / "meshes" / "jaw.obj").write_text(jaw())
    (folder / "gripper.xml").write_text(mjcf)
    (folder / "gripper.toml").write_text(toml)
    return folder / "gripper.toml"


def test_what_is_not_said_is_taken_from_the_model(tmp_path: Path) -> None:
    hand = read_hand(write_gripper(tmp_path))
    left, right = hand.all_digits
    assert (left.open, left.closed, right.open, right.closed) == ((0.01,), (-0.055,), (0.01,), (-0.055,))
    assert left.torque == (40.0,)
    assert hand.parts == ("left.left", "right.right", "palm")
    assert (hand.pads, hand.tip, hand.supporter, hand.pointer) == ((), None, None, "left")
    assert list(hand.steps) == [1, 2, 5]
    assert hand.name == "gripper"
    for part in hand.limbs:
        assert part.capsule.length_m == pytest.approx(0.1, abs=0.013)
        assert part.capsule.radius_m == pytest.approx(0.006)
        assert part.capsule.half_breadth_m == pytest.approx(0.006)
    open_ = hand.phalanges(hand.opened())
    assert open_.middle_m[:, 1].tolist() == pytest.approx([0.064, -0.064])
    assert open_.inward[:, 1].tolist() == pytest.approx([-1, 1])
    assert hand.sizes_m == pytest.approx((0.035, 0.92 * 0.128))


def test_the_page_tells_a_whole_hand_and_every_key(tmp_path: Path) -> None:
    page = (Path(__file__).parent.parent / "docs" / "hand.md").read_text("utf-8")
    mjcf, toml = (page.split(f"```{kind}\n")[1].split("```")[0] for kind in ("xml", "toml"))
    hand = read_hand(write_gripper(tmp_path, toml=toml, mjcf=mjcf))
    assert hand.parts == ("left.left", "right.right", "palm")
    source = Path(hand_file.__file__).read_text("utf-8")
    keys = {key for said in re.findall(r"\.only\((.*?)\)", source, re.DOTALL) for key in re.findall(r'"(\w+)"', said)}
    assert {"mjcf", "opposed_gain_all", "origin_m", "parts", "pitch_m"} <= keys
    for key in keys:
        assert f"`{key}`" in page or f"[{key}]" in page, key


def test_a_joint_without_a_range_moves_no_farther_than_hands_do(tmp_path: Path) -> None:
    ends = 'name = "left"\nopen = [0.01]\nclosed = [-0.055]\n'
    toml = TOML.replace('name = "left"\n', ends)
    for kind, told in (("slide", "[-1, 1]"), ("hinge", "[-6.28319, 6.28319]")):
        mjcf = MJCF.replace('type="slide" axis="0 1 0" range="-.055 .01"', f'type="{kind}" axis="0 1 0"')
        with pytest.raises(InputError, match=re.escape(f"closed must lie in {told}, where 'left_slide' moves, got 90")):
            read_hand(write_gripper(tmp_path, toml=toml.replace("-0.055", "90"), mjcf=mjcf))
        if kind == "slide":
            assert read_hand(write_gripper(tmp_path, toml=toml, mjcf=mjcf)).all_digits[0].closed == (-0.055,)
            # An end of a range may be rounded.
            assert read_hand(write_gripper(tmp_path, toml=toml.replace("-0.055", "-0.05503"))).all_digits


def test_its_own_actuators_and_parts_of_geoms(tmp_path: Path) -> None:
    own = 'actuators = ["drive"]\nopen = [0.01]\nclosed = [-0.055]\n'
    toml = TOML.replace('joints = ["left_slide"]\n', f'joints = ["left_slide"]\n{own}parts = {{ jaw = ["jaw"] }}\n')
    toml = toml.replace('joints = ["right_slide"]\n', f'joints = ["right_slide"]\n{own}').replace(
        "left.left", "left.jaw"
    )
    hand = read_hand(write_gripper(tmp_path, toml=f'pads = "all"\n{toml}'))
    assert hand.parts == ("left.jaw", "right.right", "palm") == hand.pads
    assert hand.driven("left")
    for said, odd in (
        (own.replace("-0.055", "-0.1"), "closed must lie in [-0.055, 0.01], where 'drive' moves, got -0.1"),
        (f"{own}straight = [0]\n", "straight says nothing of a digit with actuators"),
        (f"{own}torque = [3]\n", "torque says nothing of a digit with actuators"),
    ):
        with pytest.raises(InputError, match=re.escape(odd)):
            read_hand(write_gripper(tmp_path, toml=toml.replace(own, said)))
    assert hand.closing("left").tolist() == [-0.055]
    assert hand.pad_size_m("palm") == pytest.approx((0.08, 0.1))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('mjcf = "gripper.xml"', 'mjcf = "none.xml"', "none.xml: there is no such file"),
        ('mjcf = "gripper.xml"', "", "mjcf is missing"),
        ('mjcf = "gripper.xml"', 'mjfc = "gripper.xml"', "unknown key 'mjfc'; known are name, mjcf"),
        ('[palm]\nbody = "base"', '[palm]\nbody = "hand"', "has no body 'hand'; it has base, left, right, sticker"),
        ('[palm]\nbody = "base"', '[palm]\nbody = "world"', "the palm cannot be the world"),
        ("out = [0, 0, 1]", "out = [0, 0, 0]", "out must be a direction"),
        ("out = [0, 0, 1]", "out = [0, 0, nan]", "out must be a number in [-1, 1], got nan"),
        ("up = [-1, 0, 0]", "up = [0, 0, 1]", "up points the same way as out"),
        ("up = [-1, 0, 0]", "up = [1, 0, 0]", "turn up of [palm] round"),
        ('joints = ["left_slide"]', 'joints = ["slide"]', "'slide', which .* has not beyond its palm; it has "),
        ('joints = ["left_slide"]', "joints = []", "joints must name 1 to 12 joints"),
        ('joints = ["left_slide"]', 'joints = ["right_slide"]', "names 'right_slide', which is one of left already"),
        ("opposed = true", "", "no digit is opposed"),
        ("opposed = true", 'opposed = "yes"', "opposed must be true or false, got 'yes'"),
        ('name = "left"', 'name = "right"', "two digits are called 'right'"),
        ('name = "left"', 'name = "palm"', "must be another than 'palm'"),
        ('name = "left"\n', 'name = "left"\nopposed = true\n', "every digit is opposed"),
        ('name = "left"\n', 'name = "left"\nparts = { a = "nothing" }\n', "'nothing', and the MJCF has no such body"),
        ('name = "left"\n', 'name = "left"\nparts = { a = ["nothing"] }\n', "'nothing', and the MJCF has no such geom"),
        ('name = "left"\n', 'name = "left"\nparts = { a = "sticker" }\n', "'a' has no geom that touches anything"),
        ('name = "left"\n', 'name = "left"\nparts = { a = ["jaw"], "left.a" = "left" }\n', "names 'left.a' twice"),
        ('name = "left"\n', 'name = "left"\nactuators = ["motor"]\n', "names 'motor', which .* has not; it has drive"),
        ('name = "left"\n', 'name = "left"\nactuators = ["drive"]\n', "open and closed are needed with actuators"),
        ('name = "left"\n', 'name = "left"\nopen = [0.0]\nclosed = [0.0]\n', "'left' cannot close"),
        ('name = "left"\n', 'name = "left"\nopen = [0.0, 1.0]\n', "open must be a list of 1 number"),
        ('name = "left"\n', 'name = "left"\nclosed = [5]\n', "closed must lie in [-0.055, 0.01], where 'left_slide'"),
        ('name = "left"\n', 'name = "left"\nopen = [-0.06]\n', "open must lie in [-0.055, 0.01], where 'left_slide'"),
        ('name = "left"\n', 'name = "left"\nopen = [0]\nstraight = [1]\n', "straight must lie in [-0.055, 0], where"),
        ('name = "left"\n', 'name = "left"\ntorque = [-1]\n', "torque must be a number in [0, 10000], got -1"),
        ('name = "left"\n', 'name = "left"\ntorque = [9000]\n', "opposed_gain would be 600 by the torques and sizes"),
        ('part = "left.left"', 'part = "left"', "part must be one of left.left, right.right, palm; got 'left'"),
        ('part = "left.left"', 'part = "palm"', "no switch is on a finger"),
        ('part = "left.left"', 'part = "left.left"\non_n = 0', "on_n must be a number in [0.0001, 1000], got 0"),
        ('part = "palm"', 'part = "palm"\ny_m = 12', "y_m must be a number in .*; metres, got 12"),
        ('name = "p"', 'name = "l"', "'l' is another switch's already"),
        ('part = "palm"', 'part = "palm"\n[grip]\npointer = "right"', "must be one of the fingers left, got 'right'"),
        ('part = "palm"', 'part = "palm"\n[grip]\nsizes_m = [0.1, 0.05]', "the least and the largest size"),
        ('part = "palm"', 'part = "palm"\n[[pads]]\npart = "nail"', "part must be one of left.left"),
        ('part = "palm"', 'part = "palm"\n[[pads]]\npart = "palm"\npitch_m = 2', "pitch_m must be a number .*; metres"),
        ('part = "palm"', 'part = "palm"\n[[pads]]\npart = "palm"\npitch_m = 0.0002', "makes more than 256 taxels"),
        ("[[switches]]", "[[switch]]", "unknown key 'switch'"),
    ],
)  # fmt: skip
def test_a_fault_of_the_file_is_one_line(tmp_path: Path, old: str, new: str, says: str) -> None:
    assert old in TOML
    with pytest.raises(InputError) as error:
        read_hand(write_gripper(tmp_path, toml=TOML.replace(old, new)))
    assert re.search(says.replace("[", r"\[").replace("(", r"\("), str(error.value)), str(error.value)
    assert "\n" not in str(error.value)


def test_a_hand_without_switches_or_digits_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"has no switch, and a hand feels with them; add \[\[switches\]\]"):
        read_hand(write_gripper(tmp_path, toml=TOML[: TOML.index("[[switches]]")]))
    with pytest.raises(InputError, match=r"needs 2 to 12 \[\[digits\]\]"):
        read_hand(write_gripper(tmp_path, toml=TOML[: TOML.index("[[digits]]")]))
    with pytest.raises(InputError, match=r"\[palm\] is missing"):
        read_hand(write_gripper(tmp_path, toml='mjcf = "gripper.xml"\n'))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("<mujoco model", "<robot model", "is no XML"),
        ("</mujoco>", "", "is no XML"),
        ('type="box" size=".04', 'type="cube" size=".04', "MuJoCo cannot read it"),
        ('size=".04 .05 .02"', 'size="-.04 .05 .02"', "MuJoCo cannot compile it"),
        ('pos="0 .06 .02"', 'pos="nan .06 .02"', "pos of body 'left' is no number"),
        ('pos="0 0 .05" size=', 'pos="0 nan .05" size=', "pos of geom 'right_jaw' is no number"),
        ('file="jaw.obj"', 'file="none.obj"', r"names a file that cannot be used: .*none.obj: there is no such file"),
        ('file="jaw.obj"', 'file="../../jaw.obj"', "lies outside of its folder"),
        ('file="jaw.obj"', 'file="/etc/passwd"', "lies outside of its folder"),
        ('meshdir="meshes"', 'meshdir="/etc"', "lies outside of its folder"),
        ('range="-.055 .01"/>\n  <geom name="jaw"', '/>\n  <geom name="jaw"', "joint 'left_slide' has no range"),
        ("<asset>", '<asset><model file="gripper.xml"/>', "names another model"),
        ("<worldbody>", '<include file="gripper.xml"/><worldbody>', "or itself"),
        ("<worldbody>", '<include file="none.xml"/><worldbody>', "includes a file that cannot be used"),
        ("<mujoco", "<!DOCTYPE a><mujoco", "declares a document type"),
        ('type="slide" axis="0 1 0" range="-.055 .01"', 'type="ball"', "only HINGE and SLIDE joint allowed"),
    ],
)  # fmt: skip
def test_a_fault_of_the_model_is_one_line(tmp_path: Path, old: str, new: str, says: str) -> None:
    assert old in MJCF
    with pytest.raises(InputError, match=says) as error:
        read_hand(write_gripper(tmp_path, mjcf=MJCF.replace(old, new, 1)))
    assert "\n" not in str(error.value)


def test_what_lies_beyond_a_link_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "secret.obj").write_text(jaw())
    (tmp_path / "hand").mkdir()
    path = write_gripper(tmp_path / "hand")
    (tmp_path / "hand" / "meshes" / "jaw.obj").unlink()
    (tmp_path / "hand" / "meshes" / "jaw.obj").symlink_to(tmp_path / "secret.obj")
    with pytest.raises(InputError, match="lies outside of its folder"):
        read_hand(path)


def test_another_root_is_no_mjcf(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="begins with <robot>; a hand needs an MJCF"):
        read_hand(write_gripper(tmp_path, mjcf="<robot/>"))


@pytest.mark.parametrize(("factor", "says"), [(1000, "are these millimetres"), (0.05, "was it scaled twice")])
def test_lengths_that_are_no_metres_are_told(tmp_path: Path, factor: float, says: str) -> None:
    def scaled(found: re.Match[str]) -> str:
        numbers = " ".join(f"{factor * float(each):g}" for each in found[2].split())
        return f'{found[1]}="{numbers}"'

    mjcf = re.sub(r'\b(pos|size|scale|range)="([-.\d ]+)"', scaled, MJCF)
    with pytest.raises(InputError, match=says):
        read_hand(write_gripper(tmp_path, mjcf=mjcf))


def run(*words: str) -> subprocess.CompletedProcess[str]:
    """Run the program."""
    return subprocess.run([sys.executable, "-m", "varishold", *words], capture_output=True, text=True, timeout=300)


def refused(*words: str) -> str:
    """Run what must be refused, and return its one line."""
    done = run(*words)
    assert done.returncode == 1, done.stdout + done.stderr
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    return done.stderr


def test_commands_refuse_what_does_not_fit_together(tmp_path: Path) -> None:
    path = str(write_gripper(tmp_path))
    grasp = ("hand", "grasp", "cylinder", "--size-m")
    touch = ("perceive", "cylinder", "--size-m", "0.06", "--hand", path)
    assert "has no pads, and --pads needs them" in refused(
        *grasp, "0.06", "--hand", path, "--pads", f"{tmp_path}/a.npz"
    )
    assert "has no pads, and --surface needs them" in refused(*touch, "--surface", f"{tmp_path}/a.stl")
    assert "--finger-scale is of the built-in hand" in refused(*grasp, "0.06", "--hand", path, "--finger-scale", "1.1")
    assert "must lie in [0.035, 0.11776] m" in refused(*grasp, "0.12", "--hand", path)
    said = refused(*touch)
    assert "the shipped library: was felt by another hand, 'five-finger'" in said
    assert f"'varishold objects feel --hand {path} -o FILE.npz'" in said
    assert "is neither a file nor a hand that comes with the program (three-finger)" in refused(*touch[:-1], "four")


def test_nothing_that_a_hand_is_read_from_is_written_over(tmp_path: Path) -> None:
    parts = MJCF.replace("<worldbody>", '<include file="more.xml"/><worldbody>')
    path = write_gripper(tmp_path, toml='library = "known.npz"\n' + TOML, mjcf=parts)
    (tmp_path / "more.xml").write_text("<mujocoinclude/>")
    (tmp_path / "known.npz").write_bytes(b"mine")
    path, mjcf, more, jaw_obj, known = map(
        str, (path, *(tmp_path / name for name in ("gripper.xml", "more.xml", "meshes/jaw.obj", "known.npz")))
    )
    assert {str(file) for file in hand_files(path)} == {path, mjcf, more, jaw_obj, known}
    before = {file: Path(file).read_bytes() for file in (path, mjcf, more, jaw_obj, known)}
    for words in (
        ("hand", "collect", "--objects", "cylinder:0.06", "--grasps", "2", "-o", path),
        ("hand", "collect", "--objects", "cylinder:0.06", "--grasps", "2", "-o", mjcf),
        ("hand", "grasp", "cylinder", "--size-m", "0.06", "--pads", jaw_obj),
        ("perceive", "cylinder", "--size-m", "0.06", "--report", known),
        ("objects", "add", "a.stl", "--library", more),
    ):
        assert "is read by this very call" in refused(*words, "--hand", path, "--force")
    assert {file: Path(file).read_bytes() for file in before} == before
    # The hand's own library is what grows.
    assert Path(known) not in hand_files(path, library=False)


def test_a_strangers_gripper_grasps_by_command(tmp_path: Path) -> None:
    path = str(write_gripper(tmp_path))
    done = run("hand", "grasp", "cylinder", "--size-m", "0.06", "--seed", "2", "--hand", path, "--json")
    assert done.returncode == 0, done.stderr
    *steps, end = (json.loads(line) for line in done.stdout.splitlines())
    assert [step["step"] for step in steps] == [1, 2, 5]
    assert end["held"] is True
    assert steps[-1]["switches"] == {"l": 1, "r": 1, "p": 0}
    # The cylinder's breadth is what the jaws leave between them.
    assert sum(steps[-1]["angles_rad"].values()) + 2 * (0.06 - 0.006) == pytest.approx(0.06, abs=0.003)
    table = tmp_path / "grasps.csv"
    done = run(
        "hand", "collect", "--objects", "cylinder:0.06", "--grasps", "2", "--steps", "all", "--hand", path,
        "-o", str(table), "--processes", "1",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    head, *rows = table.read_text().splitlines()
    assert "switch.l,switch.r,switch.p,angle_rad.left_slide,angle_rad.right_slide" in head
    assert len(rows) == 6
    again = run(
        "hand", "collect", "--objects", "cylinder:0.06", "--grasps", "2", "--steps", "all", "-o", str(table),
    )  # fmt: skip
    assert again.returncode == 1
    assert "not the 22 of the layout paper-22" in again.stderr
