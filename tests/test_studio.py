"""The studio behind its page: looks and the commands that say the same, desks that draw what is wanted last, and forget pages."""

from __future__ import annotations

import io
import json
import shlex
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skimage.data
from numpy.typing import NDArray
from PIL import Image
from tests import commands, support
from tests.studio import CONSOLE_SCRIPT

import graphstipple as gs
from graphstipple import _core
from graphstipple.studio.desk import QUICK, SMALL, Budget, Desk
from graphstipple.studio.look import FORMATS, SETTINGS, Look


class Paper:
    """A page that only listens."""

    def __init__(self) -> None:
        self.messages: list[tuple[dict[str, Any], bytes | None]] = []
        self._came = threading.Condition()

    def __call__(self, message: dict[str, Any], data: bytes | None) -> None:
        json.dumps(message, allow_nan=False)
        with self._came:
            self.messages.append((message, data))
            self._came.notify_all()

    def of(self, kind: str, **values: object) -> list[tuple[dict[str, Any], bytes | None]]:
        """Return the messages of a kind that have these values."""
        found = [it for it in self.messages if it[0]["type"] == kind]
        return [it for it in found if all(it[0].get(name) == value for name, value in values.items())]

    def wait(self, kind: str, **values: object) -> tuple[dict[str, Any], bytes | None]:
        """Return the first such message, when it has come."""
        with self._came:
            assert self._came.wait_for(lambda: self.of(kind, **values), 60), (kind, values, [it[0] for it in self.messages][-5:])
        return self.of(kind, **values)[0]


def file_of(image: NDArray[np.uint8], kind: str = "PNG") -> bytes:
    file = io.BytesIO()
    Image.fromarray(image).save(file, kind)
    return file.getvalue()


class Room:
    """Desks, and the paper on which they write."""

    def __init__(self) -> None:
        self.paper = Paper()
        self.desks: list[Desk] = []

    def begin(self, photo: tuple[str, Any] | None, budget: Budget | None = None) -> Desk:
        """Return a desk that has greeted its page."""
        self.desks.append(Desk(self.paper, photo, budget or Budget(1 << 32, 1 << 24)))
        self.desks[-1].greet()
        return self.desks[-1]


@pytest.fixture
def room() -> Iterator[Room]:
    room = Room()
    yield room
    for desk in room.desks:
        desk.close()
        desk.join(60)


LOOKS: list[dict[str, Any]] = [
    {},
    {"preset": "scratchboard", "suffix": "pdf"},
    {"preset": "scratchboard", "settings": {"only": "black,white"}},
    {"preset": "scratchboard", "settings": {"style": "layered"}},
    {"preset": "portrait", "options": {"fineness": 0.5, "published.k1": 3, "tone_tolerance": None, "seed": 7, "irregularity": 0.5}},
    {
        "options": {
            "white_point": "auto",
            "black_point": 0.125,
            "invert": True,
            "background": "#c0ffee",
            "published.alpha": "dynamic",
        }
    },
    {"importance": "none", "settings": {"width": "120mm", "margin": "5mm", "page": "A4", "paper": "#112233"}, "min_dot": "0.3mm"},
    {"importance": "constant:0.5", "suffix": "png", "settings": {"width": 300, "dpi": "72", "one_bit": True}},
    {"importance": "painted", "suffix": "dxf", "settings": {"curves": "splines", "elements": "marks"}},
    {"suffix": "json", "settings": {"width": "10mm"}, "options": {"nodes": 900}},
    {"suffix": "svgz", "settings": {"dots": "strokes"}},
    {"suffix": "eps", "settings": {"only": "white"}, "preset": "linocut"},
]


@pytest.mark.parametrize("said", LOOKS, ids=[str(i) for i in range(len(LOOKS))])
def test_a_file_is_that_of_the_copied_command_and_of_the_copied_lines(
    said: dict[str, Any], tmp_path: Path, small: NDArray[np.uint8], room: Room, monkeypatch: pytest.MonkeyPatch
) -> None:
    name, photo = "my photo.png", file_of(small)
    map_ = file_of(np.linspace(0, 255, 40 * 30).astype(np.uint8).reshape(30, 40))
    (tmp_path / name).write_bytes(photo)
    (tmp_path / "importance.png").write_bytes(map_)
    desk = room.begin((name, photo))
    room.paper.wait("photo")
    desk.receive({"type": "importance"}, map_)
    desk.receive({"type": "draw", "id": 1, "look": said})
    told, _ = room.paper.wait("drawn", id=1)
    desk.receive({"type": "save", "id": 2, "look": said})
    header, data = room.paper.wait("file", id=2)
    assert data is not None
    assert header["name"] == f"my photo-drawing.{said.get('suffix', 'svg')}"
    words = shlex.split(told["command"])
    assert words[:4] == ["graphstipple", name, "-o", header["name"]]
    result = commands.done(CONSOLE_SCRIPT, *words[1:], cwd=tmp_path)
    assert (tmp_path / header["name"]).read_bytes() == data, result.stderr
    (tmp_path / header["name"]).unlink()
    monkeypatch.chdir(tmp_path)
    exec(compile(told["python"], "copied", "exec"), {})
    assert (tmp_path / header["name"]).read_bytes() == data
    size, _ = room.paper.wait("size", id=1)
    assert size["bytes"] == len(data)


def test_names_that_look_like_something_else() -> None:
    look = Look.of({})
    assert shlex.split(look.as_command("-rf.png"))[1:4] == ["./-rf.png", "-o", "./-rf-drawing.svg"]
    assert shlex.split(look.as_command("studio"))[1] == "./studio"
    hostile = 'a "b" $(c)\'\n\x1b\x03\\.jpg'
    assert (
        shlex.split(look.as_command(hostile.replace("\n", "").replace("\x1b", "").replace("\x03", "")))[1] == 'a "b" $(c)\'\\.jpg'
    )
    # What is pasted into a terminal does nothing by itself, and means the same.
    copied = look.as_command(hostile)
    assert copied.isprintable()
    shown = subprocess.run(
        ["bash", "-c", copied.replace("graphstipple", "printf %s", 1)], capture_output=True, text=True, check=True
    )
    assert shown.stdout.startswith(f"{hostile}-o")
    lines: dict[str, Any] = {}
    assert all(line.isprintable() for line in look.as_python(hostile).splitlines())
    source = look.as_python(hostile).replace("gs.draw", "taken").replace("import graphstipple as gs", "")
    exec(source.partition("\ndrawing.save")[0], {"taken": lambda path: lines.setdefault("path", path)})
    assert lines["path"] == hostile
    assert look.output("photos/x.y.jpg") == "x.y-drawing.svg"


def test_no_preset_has_a_switch_on() -> None:
    # A command line has no word to turn one off.
    for preset in gs.presets():
        assert all(value is not True for value in _core.preset(preset.name).values().values())


@pytest.mark.parametrize(
    ("said", "sentence"),
    [
        (5, "the look is of type int, but it must be a table"),
        ({"preset": "vermeer"}, "preset is vermeer, but it must be default,"),
        ({"preset": 3}, "preset is 3, but it must be a short text"),
        ({"preset": "a" * 999}, "preset is 'aaaa"),
        ({"options": {"nodex": 3}}, "there is no option nodex; did you mean nodes?"),
        ({"options": {"fineness": "much"}}, 'fineness is "much", but it must be a number above 0'),
        ({"options": {"fineness": float("nan")}}, "fineness is NaN, but it must be above 0"),
        ({"options": []}, "options is of type list, but it must be a table"),
        ({"options": {"published": {}}}, "published"),
        ({"importance": "/etc/passwd"}, "importance is '/etc/passwd', but it must be saliency, none, constant:V,"),
        ({"importance": "the path of an image file"}, "importance is 'the path of"),
        ({"importance": "constant:0"}, "importance is 'constant:0', but"),
        ({"importance": "constant:nan"}, "importance is 'constant:nan', but"),
        ({"importance": None}, "importance is None, but it must be a short text"),
        ({"settings": {"width": "200"}}, "width is '200', but it must have a unit: 200mm, or 200px"),
        ({"settings": {"page": "300x200"}}, "page is '300x200', but it must have a unit"),
        ({"settings": {"wide": 1}}, "there is no setting 'wide': there are style,"),
        ({"settings": {"width": ["200mm"]}}, "width is ['200mm'], but it must be a short text"),
        ({"settings": {"dpi": "many"}, "suffix": "png"}, "dpi is 'many', but it must be a number"),
        ({"min_dot": "3"}, "min_dot is '3', but it must have a unit"),
        ({"min_dot": 3}, "min_dot is 3, but it must be a length"),
        ({"suffix": "../../x"}, "suffix is '../../x', but it must be one of svg, svgz, pdf"),
    ],
)
def test_what_is_no_look(said: object, sentence: str, room: Room) -> None:
    with pytest.raises(gs.InvalidInputError) as error:
        Look.of(said)
    assert sentence in str(error.value)
    assert len(str(error.value)) < 300
    room.begin(None).receive({"type": "draw", "id": 4, "look": said})
    assert room.paper.wait("refused", of="draw", id=4)[0]["sentence"] == str(error.value)


@pytest.mark.parametrize(
    ("message", "sentence"),
    [
        (None, "a message is of type NoneType, but it must be a table"),
        ([], "a message is of type list, but it must be a table"),
        ({}, "there is no message 'None'"),
        ({"type": "x" * 999}, "there is no message 'xxxx"),
        ({"type": ["draw"]}, "there is no message \"['draw']\""),
        ({"type": "view", "part": [0, 0, 1], "columns": 5}, "the view is [0, 0, 1] in 5 columns, but it must be left, top,"),
        ({"type": "view", "part": [0, 0, 1, 1], "columns": 99999}, "the view is"),
        ({"type": "view", "part": [0, 0, 1, float("nan")], "columns": 9}, "the view is [0, 0, 1, nan], but it must have an area"),
        ({"type": "view", "part": [0, 0, 1, 1e6], "columns": 9}, "the view is [0, 0, 1, 1000000.0], but"),
        ({"type": "open", "name": "a.png"}, "the message open comes without bytes"),
    ],
)
def test_messages_that_say_nothing(message: Any, sentence: str, room: Room) -> None:
    room.begin(None).receive(message)
    told = room.paper.wait("refused")[0]["sentence"]
    assert told.startswith(sentence)
    assert len(told) < 200


def test_every_format_and_setting_is_told_to_the_page(room: Room) -> None:
    room.begin(None)
    ready, _ = room.paper.wait("ready")
    assert ready["photo"] is None
    assert ready["fresh"]
    assert {it["suffix"] for it in ready["formats"]} == set(FORMATS)
    # The paper of the file is that of the options.
    assert {it["name"] for it in ready["settings"]} == set(SETTINGS) - {"paper"}
    assert {it["kind"] for it in ready["settings"]} == {"words", "switch", "length", "page", "number"}
    assert [it["form"] for it in ready["sources"]] == ["saliency", "none", "constant:V"]
    schema = _core.options_schema()
    # A page has no subject that anything could step back from.
    del schema["properties"]["backdrop"]
    assert ready["schema"] == schema
    assert [it["name"] for it in ready["presets"]] == [preset.name for preset in gs.presets()]
    for preset in ready["presets"]:
        assert Look.of({"options": preset["values"]}).options == gs.Options.preset(preset["name"])


def test_the_page_sees_the_drawing_and_its_counts(small: NDArray[np.uint8], room: Room) -> None:
    photo = file_of(small)
    desk = room.begin(("face.png", photo))
    told, seen = room.paper.wait("photo")
    assert (told["name"], told["width"], told["height"], told["mime"]) == ("face.png", 128, 96, "image/png")
    assert seen == photo
    desk.receive({"type": "view", "part": [10.0, -5.0, 60.0, 40.0], "columns": 100})
    desk.receive({"type": "draw", "id": 1, "look": {"settings": {"page": "A6", "margin": "5mm"}}})
    picture, data = room.paper.wait("picture", id=1)
    expected = gs.draw(small)
    assert picture["part"] == (10, 0, 60, 40)
    assert picture["whole"]
    pixels = np.asarray(Image.open(io.BytesIO(data or b"")))
    assert pixels.shape == (picture["rows"], picture["columns"]) == (80, 100)
    assert np.array_equal(pixels, expected._core.rasterize(100, (10, 0, 60, 40)))
    drawn, _ = room.paper.wait("drawn", id=1)
    for count in ("stipples", "regions", "nodes", "coordinates"):
        assert drawn["stats"][count] == expected.stats[count]
    assert drawn["sheet"]["unit"] == "mm"
    assert drawn["sheet"]["page"] == pytest.approx((148, 105))
    assert drawn["sheet"]["drawing"] == pytest.approx((126 + 2 / 3, 95))
    assert desk.seen is not None
    assert desk.seen.drawing.svg() == expected.svg()
    # Each preset, and the map.
    for preset in gs.presets():
        _, data = room.paper.wait("preset", name=preset.name)
        assert Image.open(io.BytesIO(data or b"")).size == (256, 192)
    desk.receive({"type": "saliency"})
    _, data = room.paper.wait("map")
    assert np.array_equal(
        np.asarray(Image.open(io.BytesIO(data or b""))) / 255, gs.saliency(small).astype(np.float64).round(9)
    ) or (np.abs(np.asarray(Image.open(io.BytesIO(data or b""))) / 255 - gs.saliency(small)).max() < 1e-6)


def test_the_latest_wins_and_what_nobody_waits_for_is_stopped(room: Room) -> None:
    photo = np.kron(skimage.data.astronaut(), np.ones((2, 2, 1), np.uint8))
    desk = room.begin(("photo.png", photo))
    room.paper.wait("preset", name=gs.presets()[-1].name)
    desk.receive({"type": "view", "part": [0, 0, 1024, 1024], "columns": 256})
    # Its nodes are told as progress while they are drawn: then something else is wanted, ten times.
    options = gs.Options()._checked
    assert options.most_nodes(1024, 1024) > QUICK
    for number in range(1, 10):
        desk.receive({"type": "draw", "id": number, "look": {"options": {"fineness": 6 + number / 100}}, "moving": True})
        if number == 1:
            room.paper.wait("progress", id=1)
    desk.receive({"type": "draw", "id": 10, "look": {"options": {"fineness": 0.9}}})
    room.paper.wait("drawn", id=10)
    drawn = [message["id"] for message, _ in room.paper.of("drawn")]
    assert drawn[-1] == 10
    assert 1 not in drawn
    # While it moved, a small version was seen first.
    first = room.paper.of("picture")[0][0]
    assert (first["id"], first["whole"]) == (1, False)
    assert room.paper.of("picture")[-1][0]["whole"]
    expected = gs.Session(photo).draw(gs.Options(fineness=0.9))
    assert desk.seen is not None
    assert desk.seen.drawing.json() == expected.json()
    small = gs.Options._of(options.with_at_most(SMALL, 1024, 1024))
    assert gs.Session(photo).draw(small).stats["nodes"] == pytest.approx(SMALL, rel=0.01)


def test_a_painted_map_is_drawn_and_changes(small: NDArray[np.uint8], room: Room) -> None:
    desk = room.begin(("face.png", file_of(small)))
    room.paper.wait("photo")
    look = {"importance": "painted"}
    desk.receive({"type": "draw", "id": 1, "look": look})
    assert "nothing was painted yet" in room.paper.wait("refused", of="draw", id=1)[0]["sentence"]
    maps = [np.full((3, 4), 128, np.uint8), np.repeat(np.uint8([[0, 255]]), 20, 0)]
    for number, map_ in enumerate(maps, 2):
        desk.receive({"type": "importance"}, file_of(map_))
        desk.receive({"type": "draw", "id": number, "look": look})
        room.paper.wait("drawn", id=number)
        assert desk.seen is not None
        assert desk.seen.drawing.json() == gs.draw(small, importance=map_).json()
    desk.receive({"type": "importance"}, b"no image")
    desk.receive({"type": "draw", "id": 9, "look": look})
    sentence = room.paper.wait("refused", of="draw", id=9)[0]["sentence"]
    assert sentence.startswith("importance: ")
    assert desk.seen is not None


@pytest.mark.parametrize(
    ("name", "data", "sentence"),
    [
        ("notes.txt", b"not an image\n" * 9, "notes.txt: "),
        ("../../etc/x.png", b"", "x.png: "),
        ("C:\\x\\half.png", file_of(np.zeros((50, 50), np.uint8))[:60], "half.png: "),
        ("", b"GIF", "photo: "),
    ],
)
def test_what_is_no_photo_is_told_and_the_last_one_stays(
    name: str, data: bytes, sentence: str, small: NDArray[np.uint8], room: Room
) -> None:
    desk = room.begin(("face.png", file_of(small)))
    room.paper.wait("photo")
    desk.receive({"type": "open", "name": name}, data)
    told = room.paper.wait("refused", of="photo")[0]["sentence"]
    assert told.startswith(sentence)
    assert "\n" not in told
    desk.receive({"type": "draw", "id": 1, "look": {}})
    room.paper.wait("drawn", id=1)
    assert len(room.paper.of("photo")) == 1


def test_photos_that_browsers_do_not_show_are_shown_in_grey(room: Room) -> None:
    room.begin(("face.tif", file_of(support.photo("astronaut", 60, 40), "TIFF")))
    told, seen = room.paper.wait("photo")
    assert (told["mime"], told["width"], told["height"]) == ("image/png", 60, 40)
    shown = np.asarray(Image.open(io.BytesIO(seen or b"")))
    assert np.abs(shown / 255 - support.photo_luma("astronaut", 60, 40)).max() <= 0.5 / 255 + 1e-6


def test_memory_is_shared_and_given_back(small: NDArray[np.uint8], room: Room) -> None:
    budget = Budget(18_000_000, 1 << 20)
    desk = room.begin(("face.png", file_of(small)), budget)
    room.paper.wait("photo")
    desk.receive({"type": "draw", "id": 1, "look": {"options": {"nodes": 40_000}}})
    sentence = room.paper.wait("refused", of="draw", id=1)[0]["sentence"]
    assert sentence.startswith("this would take 24.3 MB of memory, but the studio has 18 MB left for it")
    desk.receive({"type": "draw", "id": 2, "look": {"options": {"nodes": 20_000}}})
    room.paper.wait("drawn", id=2)
    other = Paper()
    second = Desk(other, ("face.png", file_of(small)), budget)
    second.greet()
    other.wait("photo")
    second.receive({"type": "draw", "id": 1, "look": {"options": {"nodes": 20_000}}})
    assert "left for it" in other.wait("refused", of="draw", id=1)[0]["sentence"]
    desk.close()
    desk.join(60)
    second.receive({"type": "draw", "id": 2, "look": {"options": {"nodes": 20_000}}})
    other.wait("drawn", id=2)
    second.close()
    second.join(60)
    budget.take("anybody", budget.memory)
    room.begin(None, budget).receive({"type": "open", "name": "x"}, b"x" * (budget.upload + 1))
    assert room.paper.wait("refused", of="photo")[0]["sentence"] == "the file has 1.05 MB, but at most 1.05 MB are taken"


def test_sizes_that_do_not_fit_are_told_beside_the_drawing(small: NDArray[np.uint8], room: Room) -> None:
    desk = room.begin(("face.png", file_of(small)))
    room.paper.wait("photo")
    look = {"settings": {"page": "A6", "margin": "90mm"}}
    desk.receive({"type": "draw", "id": 1, "look": look})
    assert room.paper.wait("drawn", id=1)[0]["sheet"] is None
    assert "leaves nothing of the page" in room.paper.wait("refused", of="save", id=1)[0]["sentence"]
    desk.receive({"type": "save", "id": 2, "look": look})
    assert "leaves nothing of the page" in room.paper.wait("refused", of="save", id=2)[0]["sentence"]
    desk.receive({"type": "save", "id": 3, "look": {}})
    assert (room.paper.wait("file", id=3)[1] or b"").endswith(b"</svg>\n")


def test_nothing_is_drawn_without_a_photo(room: Room) -> None:
    desk = room.begin(None)
    desk.receive({"type": "draw", "id": 1, "look": {}})
    desk.receive({"type": "save", "id": 2, "look": {}})
    assert room.paper.wait("refused", of="save", id=2)[0]["sentence"] == "there is no photo yet: open one"
    desk.receive({"type": "example"})
    assert room.paper.wait("photo")[0]["name"] == "example.jpg"
    assert not room.paper.of("drawn")


def test_a_part_of_a_drawing_as_pixels(small: NDArray[np.uint8]) -> None:
    drawing = gs.draw(small)
    whole = drawing.rasterize(3 * drawing.width)
    part = drawing.rasterize(90, part=(20, 30, 50, 40))
    assert part.shape == (30, 90)
    assert np.abs(part.astype(int) - whole[90:120, 60:150]).max() <= 16
    assert drawing.rasterize(part=(20, 30, 50, 40)).shape == (10, 30)
    for wrong in [(0, 0, 0, 5), (0, 0, 129, 5), (-1, 0, 5, 5), (0, 0, float("nan"), 5)]:
        with pytest.raises(gs.InvalidInputError, match=r"part is \(.*on the canvas of 128 x 96 pixels"):
            drawing.rasterize(part=wrong)
    with pytest.raises(gs.InvalidInputError, match="part is 'all', but it must be four numbers"):
        drawing.rasterize(part="all")  # type: ignore[arg-type]


def test_a_file_as_bytes_and_another_importance(small: NDArray[np.uint8]) -> None:
    photo, map_ = file_of(small), file_of(np.linspace(0, 255, 1200).astype(np.uint8).reshape(30, 40))
    drawing = gs.draw(photo, importance=map_)
    assert drawing.json() == gs.draw(small, importance=np.asarray(Image.open(io.BytesIO(map_)))).json()
    session = gs.Session(photo)
    assert session.draw().json() == gs.draw(small).json()
    other = session.with_importance(map_)
    assert repr(other) == "<graphstipple.Session 128 x 96: importance map>"
    assert other.draw().json() == drawing.json()
    assert other.with_importance("none").draw().json() == gs.draw(small, importance="none").json()
    assert session.draw().json() == gs.draw(small).json()
    for wrong in (b"", b"text"):
        with pytest.raises(gs.ImageFileError, match=r"^image: "):
            gs.draw(wrong)
        with pytest.raises(gs.ImageFileError, match=r"^importance: "):
            session.with_importance(wrong)


@pytest.mark.parametrize(
    "message",
    [
        {"type": "view", "part": [0, 0, 10**400, 5], "columns": 10},
        {"type": "draw", "look": {"preset": "\ud800"}},
        {"type": "draw", "look": {"options": {"\ud800": 1}}},
        {"type": "save", "look": {"suffix": "\ud800"}},
    ],
)
def test_what_nothing_can_be_made_of_is_refused_too(message: dict[str, Any], room: Room, small: NDArray[np.uint8]) -> None:
    desk = room.begin(("face.png", file_of(small)))
    room.paper.wait("photo")
    desk.receive(message)
    room.paper.wait("refused")
    desk.receive({"type": "draw", "id": 5, "look": {}})
    room.paper.wait("drawn", id=5)


def test_a_desk_that_is_closed_while_it_reads_keeps_nothing(room: Room) -> None:
    budget = Budget(1 << 32, 1 << 30)
    desk = room.begin(("large.png", file_of(np.zeros((3000, 4000), np.uint8))), budget)
    desk.close()
    desk.join(60)
    budget.take("anybody", budget.memory)


def test_files_that_wait_are_few_and_of_their_photo(room: Room, small: NDArray[np.uint8]) -> None:
    desk = room.begin(("photo.png", np.kron(skimage.data.astronaut(), np.ones((2, 2, 1), np.uint8))))
    room.paper.wait("photo")
    # So much to draw that the files wait.
    desk.receive({"type": "draw", "id": 1, "look": {"options": {"fineness": 6}}})
    room.paper.wait("progress", id=1)
    for number in range(2, 12):
        desk.receive({"type": "save", "id": number, "look": {}})
    assert "files are being made already" in room.paper.wait("refused", of="save", id=11)[0]["sentence"]
    desk.receive({"type": "open", "name": "face.png"}, file_of(small))
    assert room.paper.wait("refused", of="save", id=2)[0]["sentence"] == "another photo was opened"
    assert not room.paper.of("file")


def test_names_of_files_are_texts(room: Room, small: NDArray[np.uint8]) -> None:
    desk = room.begin(None)
    desk.receive({"type": "open", "name": "../x/a\x03\nrm -rf x\n\x1b.png"}, file_of(small))
    assert room.paper.wait("photo")[0]["name"] == "a__rm -rf x__.png"


def test_a_view_of_what_lies_beside_the_canvas(room: Room, small: NDArray[np.uint8]) -> None:
    desk = room.begin(("face.png", file_of(small)))
    room.paper.wait("photo")
    desk.receive({"type": "view", "part": [-1e9, 0, 8.1, 1e9], "columns": 8192})
    desk.receive({"type": "draw", "id": 1, "look": {}})
    picture, _ = room.paper.wait("picture", id=1)
    assert max(picture["rows"], picture["columns"]) <= 8192
    desk.receive({"type": "view", "part": [500, 500, 600, 600], "columns": 100})
    assert room.paper.wait("refused", of="view")
