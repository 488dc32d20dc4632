"""A background that steps back: what every backdrop does, masks of every kind, and what is found without one."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image
from tests.commands import FAILURE, USAGE, assert_one_sentence, done, native_binary, run
from tests.support import ROOT

import graphstipple as gs

BACKDROPS = ("keep", "soften", "fade", "paper", "ink")
WIDTH, HEIGHT = 240, 180


@pytest.fixture(scope="module")
def mask() -> npt.NDArray[np.bool_]:
    """Return a disc in the middle."""
    row, column = np.mgrid[:HEIGHT, :WIDTH]
    return np.hypot(column + 0.5 - 120, row + 0.5 - 90) < 45


@pytest.fixture(scope="module")
def picture(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint8]:
    """Return a red disc with a pattern, before a ground of coarse leaves of green."""
    rng = np.random.default_rng(3)
    row, column = np.mgrid[:HEIGHT, :WIDTH]
    leaves = cv2.resize(rng.random((18, 24)), (WIDTH, HEIGHT), interpolation=cv2.INTER_CUBIC)
    ground = np.stack([20 + 90 * leaves, 30 + 220 * leaves, 20 + 80 * leaves], axis=2)
    disc = np.stack([190 + 30 * np.sin(column / 4), 40 + 30 * np.cos(row / 5), 60 + 0 * row], axis=2)
    return np.clip(np.where(mask[:, :, np.newaxis], disc, ground), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def drawings(picture: npt.NDArray[np.uint8], mask: npt.NDArray[np.bool_]) -> dict[str, gs.Drawing]:
    """Return a drawing for every backdrop, by a session, and one without a subject."""
    session = gs.Session(picture, subject=mask)
    return {word: session.draw(gs.Options(backdrop=word)) for word in BACKDROPS} | {"none": gs.draw(picture)}


def around(mask: npt.NDArray[np.bool_], by: int) -> npt.NDArray[np.bool_]:
    """Return what is within so many pixels of a mask."""
    return cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) <= by


def inside(points: npt.NDArray[np.float64], mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return which points lie in a mask."""
    column, row = (points.clip(0).astype(int)[:, axis].clip(0, mask.shape[1 - axis] - 1) for axis in (0, 1))
    return mask[row, column]


def test_paper_is_bare_and_ink_is_black(drawings: dict[str, gs.Drawing], mask: npt.NDArray[np.bool_]) -> None:
    outside = ~around(mask, 6)
    assert (drawings["paper"].rasterize()[outside] == 255).all()
    assert (drawings["ink"].rasterize()[outside] == 0).all()
    assert 60 < drawings["none"].rasterize()[outside].mean() < 200


def test_what_is_kept_is_as_without_a_subject(drawings: dict[str, gs.Drawing]) -> None:
    assert (drawings["keep"].rasterize() == drawings["none"].rasterize()).all()
    assert drawings["keep"].options.backdrop == "keep"
    assert b"backdrop" not in drawings["none"].svg().encode()
    assert b'"backdrop":"keep"' in drawings["keep"].svg().encode()


@pytest.mark.parametrize("backdrop", ["soften", "fade", "paper", "ink"])
def test_the_nodes_that_the_rest_saves_go_to_the_subject(
    drawings: dict[str, gs.Drawing], mask: npt.NDArray[np.bool_], backdrop: str
) -> None:
    plain, made = (drawings[name].graph.sites for name in ("none", backdrop))
    assert len(made) == pytest.approx(len(plain), rel=0.02)
    outside = ~around(mask, 20)
    assert np.count_nonzero(inside(made, mask)) > 1.25 * np.count_nonzero(inside(plain, mask))
    assert np.count_nonzero(inside(made, outside)) < 0.75 * np.count_nonzero(inside(plain, outside))


def test_softened_has_less_contrast(drawings: dict[str, gs.Drawing], mask: npt.NDArray[np.bool_]) -> None:
    outside = ~around(mask, 20)
    spread = {}
    for name in ("none", "soften"):
        tone = cv2.GaussianBlur(drawings[name].rasterize().astype(np.float32), (0, 0), 5)
        spread[name] = tone[outside].std()
    assert 0.3 * spread["none"] < spread["soften"] < 0.7 * spread["none"]


def test_faded_dots_grow_smaller_to_nothing(drawings: dict[str, gs.Drawing], mask: npt.NDArray[np.bool_]) -> None:
    drawing = drawings["fade"]
    dots = drawing.stipples[drawing.stipples["ink"] == 0]
    away = np.hypot(dots["x"] - 120, dots["y"] - 90) - 45
    # The reach is 0.4 of the root of the area: 32 pixels.
    rings = [dots["radius"][(away > low) & (away <= low + 6)] for low in (4, 10, 16, 22)]
    assert all(len(ring) > 5 for ring in rings)
    ink = [float((ring**2).sum()) for ring in rings]
    assert ink == sorted(ink, reverse=True)
    assert rings[0].mean() > rings[2].mean()
    assert (drawing.rasterize()[~around(mask, 38)] == 255).all()
    # Dots, and no shapes.
    pale = around(mask, 28) & ~around(mask, 8)
    assert not any(inside(region.exterior, pale).all() for region in drawing.regions if region.ink == 0)


def test_every_kind_of_mask_is_one(
    picture: npt.NDArray[np.uint8], mask: npt.NDArray[np.bool_], tmp_path: Path, drawings: dict[str, gs.Drawing]
) -> None:
    grey = mask.astype(np.uint8) * 255
    Image.fromarray(grey).save(tmp_path / "mask.png")
    seen: list[npt.NDArray[np.uint8]] = []

    def made(rgb: npt.NDArray[np.uint8]) -> npt.NDArray[np.bool_]:
        seen.append(rgb)
        return mask

    kinds = (
        mask,
        grey,
        mask.astype(np.float64),
        Image.fromarray(grey),
        tmp_path / "mask.png",
        str(tmp_path / "mask.png"),
        (tmp_path / "mask.png").read_bytes(),
        made,
    )
    expected = drawings["paper"].svg()
    for kind in kinds:
        assert gs.draw(picture, subject=kind, backdrop="paper").svg() == expected
    assert len(seen) == 1
    np.testing.assert_array_equal(seen[0], picture)
    options = gs.Options(backdrop="paper")
    assert gs.draw(picture, options=options, subject=mask).svg() == expected
    # Of another size and shape it is resampled, as importance maps are.
    coarse = cv2.resize(grey, (80, 45), interpolation=cv2.INTER_AREA)
    rough = gs.draw(picture, subject=coarse, backdrop="paper")
    assert (rough.rasterize()[~around(mask, 12)] == 255).all()
    assert rough.svg() != expected
    # All of it is the subject: nothing steps back.
    whole = gs.draw(picture, subject=np.ones((3, 4)), backdrop="ink")
    assert (whole.rasterize() == drawings["none"].rasterize()).all()


def test_grey_and_transparent_photos_have_colours_too(picture: npt.NDArray[np.uint8], tmp_path: Path) -> None:
    seen: list[npt.NDArray[np.uint8]] = []
    opacity = np.full((HEIGHT, WIDTH, 1), 255, np.uint8)
    opacity[:, :100] = 0
    turned = Image.fromarray(picture)
    turned.getexif()[0x0112] = 6
    turned.save(tmp_path / "turned.jpg", exif=turned.getexif(), quality=100, subsampling=0)
    deep = picture.astype(np.uint16) * 257
    for photo in (picture[:, :, 0], np.concatenate([picture, opacity], axis=2), tmp_path / "turned.jpg", deep, picture / 255.0):
        gs.draw(photo, options=gs.Options(nodes=200), subject=lambda rgb: seen.append(rgb) or np.ones(rgb.shape[:2], bool))  # type: ignore[func-returns-value]
    np.testing.assert_array_equal(seen[0], np.repeat(picture[:, :, :1], 3, axis=2))
    np.testing.assert_array_equal(seen[1][:, 100:], picture[:, 100:])
    assert (seen[1][:, :100] == 255).all()
    assert np.abs(seen[2].astype(int) - np.rot90(picture, -1)).mean() < 3
    np.testing.assert_array_equal(seen[3], picture)
    np.testing.assert_array_equal(seen[4], picture)


def test_a_photo_that_is_reduced_has_its_subject(tmp_path: Path) -> None:
    row, column = np.mgrid[:1200, :1600]
    large = np.where(np.hypot(column - 800, row - 600) < 300, 90, 200).astype(np.uint8)
    options = gs.Options(nodes=1500, backdrop="ink")
    session = gs.Session(large, subject=np.hypot(column - 800, row - 600) < 300)
    drawing = session.draw(options)
    assert drawing.stats["reduction"] > 1
    assert drawing.svg() == gs.draw(large, options=options, subject=np.hypot(column - 800, row - 600) < 300).svg()
    assert (drawing.rasterize(400)[np.hypot(column - 800, row - 600)[::4, ::4] > 340] == 0).all()
    again = pickle.loads(pickle.dumps(session))
    assert again.draw(options).svg() == drawing.svg()
    assert again.draw(gs.Options(nodes=20_000)).svg() == session.draw(gs.Options(nodes=20_000)).svg()


def test_sessions_know_the_subject(picture: npt.NDArray[np.uint8], mask: npt.NDArray[np.bool_]) -> None:
    session = gs.Session(picture, subject=mask)
    first = session.draw(gs.Options(backdrop="ink"))
    session.draw(gs.Options(backdrop="soften"))
    assert session.draw(gs.Options(backdrop="ink")).svg() == first.svg()
    assert gs.draw(picture, subject=mask, backdrop="ink").svg() == first.svg()
    expected = gs.draw(picture, importance="none", subject=mask, backdrop="ink").svg()
    assert session.with_importance("none").draw(gs.Options(backdrop="ink")).svg() == expected
    small = gs.draw(picture, subject=mask, max_bytes="40kB")
    assert len(small.svg()) <= 40_000
    assert (small.rasterize()[~around(mask, 45)] == 255).all()
    called = pickle.loads(pickle.dumps(gs.Session(picture, subject=lambda _: mask)))
    assert called.draw(gs.Options(backdrop="ink")).svg() == first.svg()


@pytest.mark.parametrize(
    ("subject", "told"),
    [
        ("aut", 'subject is "aut", but it must be "auto" or the path of an image file'),
        (np.full((4, 4), np.nan), "the subject is nan at column 0, row 0"),
        (np.full((4, 4), 1.5), "the subject is 1.5 at column 0"),
        (np.ones((4, 4, 3)), "the subject has the shape (4, 4, 3), but it must be (height, width)"),
        (np.ones((0, 4)), "the subject has no pixels"),
        (np.ones((4, 4), np.int32), "the subject has values of type int32"),
        (7, "the subject is of type int"),
        (lambda _: np.ones((2, 2, 5)), "the subject has the shape (2, 2, 5)"),
        (lambda _: [1, 2], "the subject is of type list"),
    ],
)
def test_what_is_no_mask_is_told(picture: npt.NDArray[np.uint8], subject: object, told: str) -> None:
    for draw in (gs.draw, gs.Session):
        with pytest.raises(gs.InvalidInputError) as raised:
            draw(picture, subject=subject)  # type: ignore[operator]
        assert str(raised.value).startswith(told)


def test_other_mistakes_are_told(picture: npt.NDArray[np.uint8], mask: npt.NDArray[np.bool_], tmp_path: Path) -> None:
    with pytest.raises(gs.ImageFileNotFoundError, match=r"none\.png: the file does not exist"):
        gs.draw(picture, subject=tmp_path / "none.png")
    with pytest.raises(gs.InvalidInputError, match=r'^backdrop is "papr", but it must be .*; did you mean "paper"'):
        gs.draw(picture, subject=mask, backdrop="papr")
    with pytest.raises(gs.InvalidInputError, match=r'^backdrop is "ink", but it must be left out without a subject'):
        gs.draw(picture, backdrop="ink")
    with pytest.raises(ZeroDivisionError):
        gs.draw(picture, subject=lambda _: 1 / 0)  # type: ignore[return-value,arg-type]


def test_without_a_subject_the_photo_is_as_it_is(picture: npt.NDArray[np.uint8], drawings: dict[str, gs.Drawing]) -> None:
    for subject in (np.zeros((5, 5)), lambda _: np.zeros((5, 5)), np.full((5, 5), 0.4)):
        with pytest.warns(gs.GraphStippleWarning, match="mask is below a half everywhere, so the photo is drawn as it is"):
            assert gs.draw(picture, subject=subject).svg() == drawings["none"].svg()
    with pytest.warns(gs.GraphStippleWarning, match="no subject was found, so the photo is drawn as it is"):
        assert gs.draw(picture, subject=lambda _: None).svg() == drawings["none"].svg()


def overlap(found: npt.NDArray[np.bool_], mask: npt.NDArray[np.bool_]) -> float:
    """Return the intersection over union."""
    return float(np.count_nonzero(found & mask) / np.count_nonzero(found | mask))


def test_a_subject_is_found(picture: npt.NDArray[np.uint8], mask: npt.NDArray[np.bool_]) -> None:
    found = gs.find_subject(picture)
    assert found is not None
    assert (found.shape, found.dtype) == (mask.shape, np.float32)
    assert overlap(found >= 0.5, mask) > 0.9
    drawing = gs.draw(picture, subject="auto", backdrop="paper")
    assert (drawing.rasterize()[~around(mask, 12)] == 255).all()


def test_a_cup_is_found(photos: dict[str, npt.NDArray[np.uint8]]) -> None:
    found = gs.find_subject(photos["coffee"])
    assert found is not None
    row, column = np.mgrid[:400, :600]
    saucer = np.hypot((column - 275) / 205, (row - 205) / 185) < 1
    assert overlap(found >= 0.5, saucer) > 0.75


@pytest.mark.parametrize("kind", ["flat", "across", "down", "tiny", "thin"])
def test_where_there_is_none_a_warning_says_so(kind: str) -> None:
    across = np.tile(np.linspace(60, 200, 240).astype(np.uint8), (180, 1))
    photo = {
        "flat": np.full((180, 240), 90, np.uint8),
        "across": across,
        "down": across.T,
        "tiny": across[:8, :8],
        "thin": across[:9],
    }
    assert gs.find_subject(photo[kind]) is None
    with pytest.warns(gs.GraphStippleWarning, match="no subject was found"):
        made = gs.draw(photo[kind], subject="auto")
    assert made.svg() == gs.draw(photo[kind]).svg()


def test_what_is_found_depends_on_the_photo_alone(picture: npt.NDArray[np.uint8]) -> None:
    threads = cv2.getNumThreads()
    try:
        found = []
        for number in (1, 4):
            cv2.setNumThreads(number)
            cv2.setRNGSeed(number)
            found.append(gs.find_subject(picture))
            assert cv2.getNumThreads() == number
    finally:
        cv2.setNumThreads(threads)
    np.testing.assert_array_equal(found[0], found[1])
    made = [gs.draw(picture, options=gs.Options(threads=number), subject="auto").svg() for number in (1, 2)]
    assert made[0] == made[1]


@pytest.fixture
def files(tmp_path: Path, picture: npt.NDArray[np.uint8], mask: npt.NDArray[np.bool_]) -> Path:
    """Return a folder with a photo and its mask."""
    Image.fromarray(picture).save(tmp_path / "photo.png")
    Image.fromarray(mask.astype(np.uint8) * 255).save(tmp_path / "mask.png")
    return tmp_path


COMMAND = Path(sys.executable).with_name("graphstipple")


def test_the_command_line_gives_the_same_bytes(files: Path) -> None:
    for program in (native_binary(), COMMAND):
        done(program, "photo.png", "-o", "out.svg", "--subject", "./mask.png", "--backdrop", "ink", cwd=files)
        expected = gs.draw(files / "photo.png", subject=files / "mask.png", backdrop="ink").svg()
        assert (files / "out.svg").read_text() == expected
    done(COMMAND, "photo.png", "-o", "out.svg", "--subject", "auto", cwd=files)
    assert (files / "out.svg").read_text() == gs.draw(files / "photo.png", subject="auto").svg()
    piped = subprocess.run(
        [COMMAND, "-", "-o", "-", "--subject", "auto"], input=(files / "photo.png").read_bytes(), capture_output=True, check=True
    )
    assert piped.stdout.decode() == (files / "out.svg").read_text()


def test_the_command_line_tells_mistakes_in_one_sentence(files: Path) -> None:
    Image.new("L", (5, 5)).save(files / "empty.png")
    mistakes = [
        (["--subject", "aut"], USAGE, "--subject is aut, but it must be auto or the path of an image file"),
        (["--subject", "none.png"], FAILURE, "none.png: the file does not exist"),
        (["--backdrop", "ink"], USAGE, "--backdrop is ink, but it must be left out without a --subject"),
        (["--subject", "mask.png", "--backdrop", "in"], USAGE, '--backdrop is "in", but it must be'),
    ]
    binary = native_binary()
    for program in (binary, COMMAND):
        for words, code, told in mistakes:
            result = run(program, "photo.png", "-o", "out.svg", *words, cwd=files)
            assert_one_sentence(result, code)
            assert told in result.stderr.decode()
        result = run(program, "photo.png", "-o", "mask.png", "--subject", "mask.png", cwd=files)
        assert_one_sentence(result, USAGE)
        result = done(program, "photo.png", "-o", "out.svg", "--subject", "empty.png", cwd=files)
        assert "warning: the subject's mask is below a half everywhere" in result.stderr.decode()
    result = run(binary, "photo.png", "-o", "out.svg", "--subject", "auto", cwd=files)
    assert_one_sentence(result, USAGE)
    assert "pip install graphstipple" in result.stderr.decode()
    Image.new("L", (80, 60), 90).save(files / "flat.png")
    result = done(COMMAND, "flat.png", "-o", "out.svg", "--subject", "auto", cwd=files)
    assert "warning: flat.png: no subject was found" in result.stderr.decode()


def test_batches_take_auto_alone(files: Path) -> None:
    (files / "photos").mkdir()
    (files / "photo.png").rename(files / "photos" / "photo.png")
    results = list(gs.batch(files / "photos", files / "out", subject="auto", processes=1))
    assert [result.error for result in results] == [None]
    expected = gs.draw(files / "photos" / "photo.png", subject="auto").svg()
    assert (files / "out" / "photo.svg").read_text() == expected
    with pytest.raises(gs.InvalidInputError, match="of many photos it must be auto: each has a subject of its own"):
        next(iter(gs.batch(files / "photos", files / "out", subject=str(files / "mask.png"), processes=1)))


def test_the_bench_tells_how_well_subjects_are_found(files: Path) -> None:
    folder = files / "folder"
    folder.mkdir()
    Image.open(files / "photo.png").save(folder / "a.jpg", quality=95)
    (files / "mask.png").rename(folder / "a.png")
    told = subprocess.run([sys.executable, ROOT / "benches" / "subjects.py", folder], capture_output=True, text=True, check=True)
    assert "a: 0.9" in told.stdout
    assert "mean over 1: 0.9" in told.stdout
