"""What a press looks like: the same wherever it lies and however hard it is pressed."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.touch.course.image import image_names, image_shape, press_images

SHAPES = [(4, 4), (8, 8), (9, 5), (16, 16), (28, 50)]


def drawn(shape: tuple[int, int], seed: int) -> np.ndarray:
    """Frames of something in the upper left part of a pad."""
    rng = np.random.default_rng(seed)
    frames = np.zeros((3, *shape))
    rows, cols = -(-shape[0] // 2), -(-shape[1] // 2)
    frames[:, :rows, :cols] = rng.uniform(0.1, 5, (rows, cols)) * rng.uniform(0.9, 1.1, (3, 1, 1))
    return frames


@pytest.mark.parametrize("shape", SHAPES)
def test_a_press_looks_the_same_elsewhere_and_harder(shape: tuple[int, int]) -> None:
    frames = drawn(shape, 3)
    moved = np.roll(frames, (shape[0] // 2, shape[1] // 2), axis=(1, 2))
    here, elsewhere, harder = press_images([frames, moved, 1e6 * frames])
    np.testing.assert_allclose(elsewhere, here, atol=1e-7)
    np.testing.assert_allclose(harder, here, atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_press_seen_the_other_way_round_has_its_image_so(shape: tuple[int, int]) -> None:
    frames = drawn(shape, 4)
    here, turned = press_images([frames, frames[:, ::-1, ::-1]])
    np.testing.assert_allclose(turned, here[::-1], atol=1e-7)


@pytest.mark.parametrize("shape", SHAPES)
def test_cells_lie_between_0_and_1_and_nothing_has_none(shape: tuple[int, int]) -> None:
    something, nothing = press_images([drawn(shape, 5), np.zeros((2, *shape))])
    assert something.min() >= 0
    assert something.max() == 1
    assert not nothing.any()
    assert max(image_shape(shape)) <= 12
    assert len(image_names(shape)) == len(something) == len(nothing)


def test_forms_with_the_same_sums_look_different() -> None:
    cross, saltire = np.zeros((2, 1, 5, 5))
    cross[0, 2, :] = cross[0, :, 2] = 1.0
    saltire[0] = np.maximum(np.eye(5), np.eye(5)[::-1])
    one, other = press_images([cross, saltire])
    assert np.abs(one - other).max() == 1


@pytest.mark.parametrize("shape", [(1, 12), (7, 3)])
def test_a_pad_of_few_lines_has_no_image(shape: tuple[int, int]) -> None:
    assert image_shape(shape) == (0, 0)
    assert image_names(shape) == []
    assert press_images([np.ones((2, *shape))] * 3).shape == (3, 0)
