"""`paint3d devices set`: how the hands' devices are read, kept for the studio and for recording."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from typing import Any

from paint3d.cli.hands.options import add_stylus_option
from paint3d.cli.options import parse_number
from paint3d.errors import Paint3DError

__all__ = ["add_set", "set_devices"]

_ON = {"on": True, "off": False}
_NUMBERS = (
    ("--mouse-speed", "speed_mm_s", "MM/S", 5000.0, "how fast the object moves at full deflection"),
    ("--mouse-turn", "turn_deg_s", "DEG/S", 2800.0, "how fast it turns"),
    ("--mouse-dead-zone", "dead_zone", "SHARE", 0.9, "of the deflection, that counts as rest"),
)


def _number(most: float, least: float = 0.0) -> Any:
    expected = f"{least:g} to {most:g}"
    return lambda text: parse_number(text, "a number", expected, lambda n: least <= n <= most)


def _parse_axes(text: str) -> tuple[str, ...]:
    from paint3d.pose.mouse_settings import parse_axes

    axes: tuple[str, ...] = _told(lambda: parse_axes(text))
    return axes


def _parse_button(text: str) -> tuple[int, str]:
    from paint3d.device.button_actions import checked_actions

    number, _, action = text.partition("=")
    if not number.isdecimal() or not 1 <= int(number) <= 31:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no button; expected N=ACTION with N from 1 to 31, or N= for nothing"
        )
    if action:
        _told(lambda: checked_actions({int(number) - 1: action}))
    return int(number) - 1, action


def _told(parse: Any) -> Any:
    try:
        return parse()
    except Paint3DError as cause:
        raise argparse.ArgumentTypeError(str(cause)) from None


def add_set(parser: argparse.ArgumentParser) -> None:
    """Add the options of this deed."""
    parser.add_argument(
        "--mouse-mode", choices=("object", "camera"), help="whether the cap is the object or you"
    )
    for option, name, what, most, told in _NUMBERS:
        parser.add_argument(option, dest=name, metavar=what, type=_number(most), help=told)
    parser.add_argument(
        "--mouse-curve",
        dest="curve",
        metavar="N",
        type=_number(4.0, 1.0),
        help="exponent of the response: 1 is linear, more is finer near rest",
    )
    parser.add_argument(
        "--mouse-axes",
        dest="axes",
        metavar="LIST",
        type=_parse_axes,
        help="which axis of the cap gives each motion (right, away, up, turns about them), - turns "
        "it round: --mouse-axes=x,z,-y,rx,rz,-ry",
    )
    parser.add_argument(
        "--mouse-zoom", dest="zoom_axis", choices=("y", "z"), help="pushed or lifted comes near"
    )
    for option, name, told in (
        ("--mouse-moves", "moving", "whether it moves the object"),
        ("--mouse-turns", "turning", "whether it turns it"),
        ("--mouse-one-axis", "dominant_axis", "follow only the axis that is deflected most"),
    ):
        parser.add_argument(option, dest=name, choices=tuple(_ON), help=told)
    parser.add_argument(
        "--mouse-button",
        dest="buttons",
        metavar="N=ACTION",
        type=_parse_button,
        action="append",
        help="what a button does, from 1; recentre, dip, undo, redo, toggle_turning, "
        "toggle_moving, toggle_dominant_axis, toggle_camera, calibrate_rest, or nothing",
    )
    _add_stylus(parser)
    parser.add_argument("--defaults", action="store_true", help="begin with how it was at first")


def _add_stylus(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--stylus-limit",
        dest="limit_n",
        metavar="N",
        type=_number(7.9),
        help="the stylus never pushes harder, N",
    )
    parser.add_argument(
        "--stylus-anticipation",
        dest="anticipation_mm",
        metavar="MM",
        type=_number(20.0),
        help="so far before the surface a gentle force begins; 0: none",
    )
    parser.add_argument(
        "--stylus-click",
        dest="click_n",
        metavar="N",
        type=_number(1.0),
        help="force of the click when the brush is dipped; 0: none",
    )
    parser.add_argument(
        "--stylus-texture",
        dest="texture",
        metavar="SHARE",
        type=_number(1.0),
        help="how much of the surface's grain is felt; 0: nothing, 1: all (at first)",
    )
    add_stylus_option(parser, "")


def set_devices(options: argparse.Namespace) -> None:
    """Keep what was said, and say all of it.

    Raises
    ------
    Paint3DError
        If the settings cannot be written.
    """
    import dataclasses

    from paint3d.app.model.persistence.settings import load_settings, save_settings
    from paint3d.device.button_actions import DEFAULT_ACTIONS
    from paint3d.haptics.settings import Feel
    from paint3d.pose.mouse_settings import MouseSettings

    settings, problem = load_settings()
    if problem is not None:
        sys.stderr.write(f"{problem}\n")
    before = settings
    if options.defaults:
        settings = dataclasses.replace(
            settings, mouse={}, feel={}, stylus="auto", buttons=dict(DEFAULT_ACTIONS)
        )
    mouse = dataclasses.replace(
        MouseSettings.from_words(settings.mouse), **_said(options, MouseSettings)
    )
    feel = dataclasses.replace(Feel.from_words(settings.feel), **_said(options, Feel))
    buttons = {**settings.buttons, **dict(options.buttons or ())}
    settings = dataclasses.replace(
        settings,
        mouse=mouse.as_words(),
        feel=feel.as_words(),
        buttons={number: action for number, action in buttons.items() if action},
        stylus=options.stylus or settings.stylus,
    )
    if settings != before:
        save_settings(settings)
    _show(mouse.as_words(), settings.buttons, {"stylus": settings.stylus, **feel.as_words()})


def _said(options: argparse.Namespace, kind: type) -> dict[str, Any]:
    """What was said of these choices."""
    import dataclasses

    found = {"mode": options.mouse_mode}
    for own in dataclasses.fields(kind):
        found.setdefault(own.name, getattr(options, own.name, None))
    words = {name: _ON.get(value, value) if isinstance(value, str) else value
             for name, value in found.items()}  # fmt: skip
    known = {own.name for own in dataclasses.fields(kind)}
    return {name: value for name, value in words.items() if value is not None and name in known}


def _show(mouse: Mapping[str, Any], buttons: Mapping[int, str], feel: Mapping[str, Any]) -> None:
    for name, value in mouse.items():
        told = ",".join(value) if isinstance(value, list) else value
        sys.stdout.write(f"mouse {name}: {round(told, 3) if isinstance(told, float) else told}\n")
    for number, action in sorted(buttons.items()):
        sys.stdout.write(f"mouse button {number + 1}: {action}\n")
    for name, value in feel.items():
        sys.stdout.write(f"{name if name == 'stylus' else f'stylus {name}'}: {value}\n")
