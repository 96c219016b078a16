"""Draws answers over the picture that they were perceived in: outlines, and a line of text for each item."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from scipy.ndimage import binary_erosion

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array
from pickcli.perception.items.item_observation import FoundBy, ItemObservation, PlaceObservation
from pickcli.perception.items.perceived_file import Perceived
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid

Ink = tuple[int, int, int]
BOUNDED, ANSWERED, REFUSED = (60, 220, 90), (250, 210, 40), (255, 80, 70)  # outlines, by how sure the pose is
_TEXT, _PAPER = (235, 235, 235), (28, 28, 30)
_LINE = 1 / 450  # of the picture's width: half the width of an outline
_DASHES = 8  # lines as wide as the outline, of a dash and its gap
_FONT = 1 / 80  # of the picture's width: size of the text
_MARGIN = 0.6  # of that size


def perceived_picture(
    rgbd: RgbdPicture, known: RenderedScene, perceived: Perceived, coarser: int = 1
) -> NDArray[np.uint8]:
    """Draw answers and refused poses over a picture, numbered, with a line for each item below.

    Outlines are those of the visible parts: answers hide each other, and the known place hides them. A
    refused pose is dashed, as if only the known place hid it.

    Args:
        rgbd: The picture.
        known: What is known without the items: robot, places and obstacles.
        perceived: What was perceived in it.
        coarser: How many pixels of it, along rows and columns, one stands for.

    Returns:
        (h, w, 3) the picture, with as many lines below as there are listed items.
    """
    camera, colour = _coarser(rgbd, coarser)
    listed = [(place, answer) for place in perceived.places for answer in place.items]
    placed = [answer for _, answer in listed if answer.T_world_item is not None]
    T_world_camera = rgbd.T_world_camera
    masks = _visible(camera, T_world_camera, known, [answer for answer in placed if answer.is_answer])
    for answer in placed:
        if not answer.is_answer:
            masks |= _visible(camera, T_world_camera, known, [answer])
    width = max(1, round(_LINE * colour.shape[1]))
    for answer in sorted(placed, key=lambda each: each.is_answer):
        outline = masks[answer.id] & ~binary_erosion(masks[answer.id], iterations=2 * width)
        if not answer.is_answer:
            rows, columns = np.indices(outline.shape)
            outline &= (rows + columns) // (_DASHES * width) % 2 == 0
        colour[outline] = ink_of(answer)
    return _with_text(colour, listed, masks)


def ink_of(answer: ItemObservation) -> Ink:
    """Return the colour of an answer's outline.

    Args:
        answer: The answer, or refused pose.

    Returns:
        Red, green and blue, 0 to 255.
    """
    if not answer.is_answer:
        return REFUSED
    return ANSWERED if answer.bound is None else BOUNDED


def _coarser(rgbd: RgbdPicture, n: int) -> tuple[PinholeCamera, NDArray[np.uint8]]:
    """Intrinsics and colours with one pixel for n in each direction."""
    c = rgbd.sensor.camera
    height, width = c.height // n, c.width // n
    blocks = rgbd.colour[: n * height, : n * width].reshape(height, n, width, n, 3)
    middle = (n - 1) / 2  # of the first pixels that one stands for
    camera = PinholeCamera(c.fx / n, c.fy / n, (c.cx - middle) / n, (c.cy - middle) / n, width, height)
    return camera, np.asarray(blocks.mean(axis=(1, 3)).round().astype(np.uint8))


def _visible(
    camera: PinholeCamera, T_world_camera: Array, known: RenderedScene, answers: list[ItemObservation]
) -> dict[str, NDArray[np.bool_]]:
    """The pixels (h, w) in which each answer is seen, by id."""
    solids = tuple(
        RenderedSolid(OwnerKind.ITEM, answer.id, answer.item.shape, answer.T_world_item, answer.item)
        for answer in answers
        if answer.T_world_item is not None
    )
    first = len(known.solids)
    view = replace(known, solids=known.solids + solids).seen_by(camera, T_world_camera)
    return {solid.owner: view.index == first + k for k, solid in enumerate(solids)}


def _with_text(
    colour: NDArray[np.uint8],
    listed: list[tuple[PlaceObservation, ItemObservation]],
    masks: dict[str, NDArray[np.bool_]],
) -> NDArray[np.uint8]:
    height, width = colour.shape[:2]
    size = max(10, round(_FONT * width))
    font, tag = ImageFont.load_default(size), ImageFont.load_default(2 * size)
    step, margin = round(1.5 * size), round(_MARGIN * size)
    sheet = Image.new("RGB", (width, height + step * len(listed) + 2 * margin), _PAPER)
    sheet.paste(Image.fromarray(colour))
    draw = ImageDraw.Draw(sheet)
    for number, (place, answer) in enumerate(listed, 1):
        ink, at = ink_of(answer), height + margin + (number - 1) * step
        draw.text((margin, at), f"{number:2}", font=font, fill=ink)
        draw.text((margin + 2 * size, at), "   ".join(_words(place, answer)), font=font, fill=_TEXT)
        mask = masks.get(answer.id)
        if mask is not None and mask.any():
            row, column = np.argwhere(mask).mean(axis=0)
            middle = (float(column), float(row))
            draw.text(middle, str(number), ink, tag, "mm", stroke_width=2, stroke_fill=_PAPER)
    return np.asarray(sheet)


def _words(place: PlaceObservation, answer: ItemObservation) -> Iterator[str]:
    yield f"{place.place}: {answer.id}"
    yield f"confidence {answer.confidence:.2f}"
    if answer.found_by is FoundBy.PRINT:
        yield "by its print"
    if answer.bound is not None:
        bound = answer.bound
        yield f"within {1e3 * bound.position:.1f} mm and {np.degrees(bound.angle):.1f} degrees"
        if bound.displacement is not None:
            yield f"surface within {1e3 * bound.displacement:.1f} mm"
    elif answer.is_answer:
        yield "no bounds"
    if answer.refusal:
        yield f"refused: {answer.refusal}"
