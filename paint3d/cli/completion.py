"""Print a script by which a shell completes commands, options, choices and files.

It is made from the parsers, so it knows what this version knows.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import NamedTuple

from paint3d.cli.options import BUILT_IN_OBJECTS, Parser
from paint3d.mesh.sheets import FORMS

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d completion bash > ~/.local/share/bash-completion/completions/paint3d
paint3d completion zsh > ~/.zfunc/_paint3d
paint3d completion fish > ~/.config/fish/completions/paint3d.fish
"""


_NAMES = {"--on": (*BUILT_IN_OBJECTS, *FORMS)}  # that stand for files


class _Option(NamedTuple):
    name: str
    choices: tuple[str, ...]
    takes_value: bool
    about: str
    is_file: bool


class _Command(NamedTuple):
    """A command, or an action of one: the words before it, its options, what may follow."""

    words: tuple[str, ...]
    about: str
    options: tuple[_Option, ...]
    actions: tuple[str, ...]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("shell", metavar="SHELL", choices=tuple(_SHELLS), help="bash, zsh or fish")


def run(options: argparse.Namespace) -> None:
    """Print the script."""
    from paint3d.cli.main import make_parser

    sys.stdout.write(_SHELLS[options.shell](list(_commands(make_parser(), (), ""))))


def _commands(parser: Parser, words: tuple[str, ...], about: str) -> Iterator[_Command]:
    known = []
    for action in parser.option_actions():
        choices, name = tuple(map(str, action.choices or ())), action.option_strings[-1]
        is_file = not choices
        choices = choices or _NAMES.get(name, ())
        about_it = (action.help or "") % vars(action) if action.help else ""
        for name in action.option_strings:
            known.append(_Option(name, choices, action.nargs != 0, _in_short(about_it), is_file))
    below = parser.actions()
    yield _Command(words, _in_short(about), tuple(known), tuple(below))
    for name, one in below.items():
        yield from _commands(one, (*words, name), one.description or "")


def _in_short(text: str) -> str:
    """Return the beginning of a text, as shells can quote it."""
    first = text.strip().split("\n\n")[0].split("; ")[0].split(" (default")[0]
    return " ".join(first.split()).rstrip(".")


def _bash(commands: list[_Command]) -> str:
    cases = []
    for one in commands:
        words = " ".join((*one.actions, *(option.name for option in one.options)))
        cases.append(f'    "{" ".join(one.words)}") words="{words}" ;;')
    values = []
    for one in commands:
        for option in one.options:
            if option.takes_value:
                key = " ".join((*one.words, option.name))
                known = " ".join(option.choices)
                files = " files=1;" * option.is_file
                values.append(f'    "{key}") values="{known}";{files} takes=1 ;;')
    of_two = " ".join(f'"{key}"' for key in _two_words(commands))
    return f"""# bash completion of paint3d; made by: paint3d completion bash
_paint3d() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}"
  local command="" words="" values="" takes=0 files=0 known
  (( COMP_CWORD > 1 )) && command="${{COMP_WORDS[1]}}"
  if (( COMP_CWORD > 2 )); then
    for known in {of_two}; do
      [[ "$command ${{COMP_WORDS[2]}}" == "$known" ]] && command="$known" && break
    done
  fi
  case "$command $before" in
{chr(10).join(values)}
  esac
  if (( takes )); then
    COMPREPLY=($(compgen -W "$values" -- "$word"))
    (( files )) && COMPREPLY+=($(compgen -f -- "$word"))
    return
  fi
  case "$command" in
{chr(10).join(cases)}
  esac
  COMPREPLY=($(compgen -W "$words" -- "$word"))
  [[ "$word" != -* && -n "$command" ]] && COMPREPLY+=($(compgen -f -- "$word"))
}}
complete -o filenames -F _paint3d paint3d
"""


def _two_words(commands: list[_Command]) -> list[str]:
    return [" ".join(one.words) for one in commands if len(one.words) == 2]


def _quoted(text: str) -> str:
    """A text in single quotes, as zsh and fish read it."""
    return text.replace("\\", "\\\\").replace("'", "’")


def _zsh(commands: list[_Command]) -> str:
    parts = []
    for one in commands:
        lines = []
        for option in one.options:
            about = _quoted(option.about).replace("[", "(").replace("]", ")").replace(":", " ")
            value = f":value:({' '.join(option.choices)})" if option.choices else ":value:_files"
            if option.choices and option.is_file:
                value = f""":value:{{_alternative "names:name:({" ".join(option.choices)})" """
                value += '"files:file:_files"}'
            lines.append(f"'{option.name}[{about}]{value if option.takes_value else ''}'")
        if one.actions:
            lines.append(f"'1: :({' '.join(one.actions)})'")
        lines.append("'*:: :_files'")
        spec = " \\\n      ".join(lines)
        parts.append(f'    "{" ".join(one.words)}") _arguments \\\n      {spec} ;;')
    two = " ".join(f'"{key}"' for key in _two_words(commands))
    return f"""#compdef paint3d
# zsh completion of paint3d; made by: paint3d completion zsh
_paint3d() {{
  local command="" known
  (( CURRENT > 2 )) && command="$words[2]"
  if (( CURRENT > 3 )); then
    for known in {two}; do
      [[ "$command $words[3]" == "$known" ]] && command="$known"
    done
  fi
  local -i skip=${{#${{=command}}}}
  words=("$words[1]" "${{(@)words[2+skip,-1]}}")
  (( CURRENT -= skip ))
  case "$command" in
{chr(10).join(parts)}
    *) _files ;;
  esac
}}
compdef _paint3d paint3d
"""


def _fish(commands: list[_Command]) -> str:
    lines = ["# fish completion of paint3d; made by: paint3d completion fish"]
    for one in commands:
        if not one.words:
            when = "__fish_use_subcommand"
        else:
            when = "; and ".join(f"__fish_seen_subcommand_from {word}" for word in one.words)
        abouts = {c.words[-1]: c.about for c in commands if c.words[:-1] == one.words and c.words}
        rest = ""
        if one.words and one.actions:
            rest = f"; and not __fish_seen_subcommand_from {' '.join(one.actions)}"
        for name in one.actions:
            about = _quoted(abouts.get(name, ""))
            lines.append(f"complete -c paint3d -f -n '{when}{rest}' -a {name} -d '{about}'")
        for option in one.options:
            if not option.name.startswith("--"):
                continue
            line = (
                f"complete -c paint3d -n '{when}' -l {option.name[2:]} -d '{_quoted(option.about)}'"
            )
            if option.choices:
                only = " -r" if option.is_file else " -x"
                line += f"{only} -a '{' '.join(option.choices)}'"
            elif option.takes_value:
                line += " -r"
            lines.append(line)
    return "\n".join(lines) + "\n"


_SHELLS = {"bash": _bash, "zsh": _zsh, "fish": _fish}
