"""What a person meets first: helps with examples, hints at what is mistyped, completion."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys

import pytest

from paint3d.cli.main import COMMANDS, main, make_parser
from paint3d.cli.options import Parser


def parsers() -> dict[str, Parser]:
    """Parsers of all commands and actions, by the words that choose them."""
    found = {}
    for name, command in make_parser().actions().items():
        found[name] = command
        found |= {f"{name} {action}": one for action, one in command.actions().items()}
    return found


PARSERS = parsers()


@pytest.mark.parametrize("name", PARSERS)
def test_a_help_says_what_it_does_and_ends_with_examples_that_parse(name: str) -> None:
    parser = PARSERS[name]
    assert parser.description
    told = parser.format_help()
    lines = [line.strip() for line in told[told.rindex("example") :].splitlines()[1:]]
    assert lines
    for line in lines:
        program, *words = shlex.split(line.split(">")[0])
        assert program == "paint3d"
        chosen = make_parser(words[0]).parse_args(words)
        assert callable(chosen.run)
    assert all(len(line) <= 100 for line in told.splitlines())


def test_options_of_one_name_mean_one_thing() -> None:
    """They parse in one way, and say the same but for what stands for one that is not given."""
    kinds: dict[str, set[object]] = {}
    for parser in PARSERS.values():
        for action in parser.option_actions():
            what = (action.metavar, tuple(map(str, action.choices or ())), action.nargs)
            kinds.setdefault(action.option_strings[-1], set()).add(what)
    of_two = {name for name, what in kinds.items() if len(what) > 1}
    assert not of_two & {"--fps", "--unit", "--size", "--seed", "--report", "--pixels", "--at"}
    assert kinds["--size"] == {("MM", (), None)}
    assert kinds["--pixels"] == {("WxH", (), None)}


def test_the_program_by_itself_says_what_it_can_do(capsys) -> None:
    with pytest.raises(SystemExit) as ended:
        main([])
    out, err = capsys.readouterr()
    assert (ended.value.code, err) == (0, "")
    assert all(f"\n    {name}" in out for name in COMMANDS)


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["wrte", "永"], "there is no command 'wrte'; did you mean write?"),
        (["gui"], "there is no command 'gui'; did you mean paint?"),
        (["devices", "lst"], "there is no deed 'lst'; did you mean list?"),
        (["write", "永", "--on", "bowl", "--ot", "a.ply"], "there is no --ot; did you mean --out?"),
        (["write", "永", "--on", "bowl", "--out", "a.ply", "--sise", "3"], "did you mean --size?"),
        (["write", "永", "--on", "bwl", "--out", "a.ply"], "did you mean bowl?"),
        (["picture", "bowl", "--out", "a.png", "--light", "soff"], "did you mean soft?"),
    ],
)
def test_what_is_mistyped_is_answered_with_what_is_like_it(capsys, words, meant) -> None:
    assert main(words) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert meant in err


def test_a_file_that_is_not_there_is_told_before_anything_heavy_is_imported() -> None:
    commands = [
        ["picture", "none.p3d", "--out", "a.png", "--illuminant", "A"],
        ["export", "none.p3d", "a.glb", "--illuminant", "A"],
        ["replay", "none.jsonl", "--on", "bowl", "--out", "a.png"],
        ["write", "永", "--on", "none.obj", "--out", "a.png"],
        ["paint", "none.obj"],
        ["studio", "none.obj"],
        ["score", "none.score.jsonl", "--list"],
    ]
    code = (
        f"import sys\nfrom paint3d.cli.main import main\nfor words in {commands!r}:\n"
        "    assert main(words) == 2, words\n"
        "    heavy = {'numba', 'colour', 'pyvista', 'PySide6'} & set(sys.modules)\n"
        "    assert not heavy, (words, heavy)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = re.findall(r"none\.\S+: there is no such file; expected a", done.stderr)
    assert len(told) == len(commands), done.stderr


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_completion_names_every_command_and_option(shell: str, capsys) -> None:
    assert main(["completion", shell]) == 0
    told = capsys.readouterr().out
    for name in COMMANDS:
        assert name in told
    dashes = "-l {}" if shell == "fish" else "--{}"
    for parser in PARSERS.values():
        for action in parser.option_actions():
            for option in action.option_strings:
                if option.startswith("--"):
                    assert dashes.format(option[2:]) in told


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("wri", {"write"}),
        ("write 永 --tec", {"--technique"}),
        ("write 永 --technique pi", {"pianfeng"}),
        ("devices re", {"record"}),
        ("devices record --smo", {"--smooth"}),
        ("brushes fit --le", {"--length"}),
    ],
)
def test_bash_completes(typed: str, offered: set[str], capsys) -> None:
    assert main(["completion", "bash"]) == 0
    script = capsys.readouterr().out
    words = f"paint3d {typed}".split(" ")
    ask = (
        f"COMP_WORDS=({shlex.join(words)}); COMP_CWORD={len(words) - 1}; _paint3d; "
        'printf "%s\\n" "${COMPREPLY[@]}"'
    )
    done = subprocess.run(["bash", "-c", f"{script}\n{ask}"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) == offered
