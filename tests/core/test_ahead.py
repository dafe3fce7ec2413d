"""What is made ahead: in order, one at a time, beside what is used, with its errors in place."""

from __future__ import annotations

import threading
from functools import partial

import pytest

from paint3d.core.ahead import ahead, beside

PATIENCE_S = 300.0


def test_all_come_in_order() -> None:
    assert list(ahead(partial(int, k) for k in range(20))) == list(range(20))
    assert list(ahead([])) == []


def test_one_alone_takes_no_thread() -> None:
    assert list(ahead([threading.current_thread])) == [threading.current_thread()]


def test_the_next_is_made_while_one_is_used() -> None:
    made = threading.Event()
    makers = [lambda: None, made.set, lambda: threading.current_thread().name]
    found = ahead(makers)
    next(found)
    assert made.wait(PATIENCE_S)  # though nobody has asked for it
    assert [name for name in found if name] == ["ahead_0"]


def test_no_more_than_one_is_made_ahead() -> None:
    asked = []
    found = ahead(partial(asked.append, k) for k in range(5))
    for k in range(5):
        next(found)
        assert set(asked) <= set(range(k + 2))
    assert asked == list(range(5))


def test_an_error_comes_where_it_would_have_been_raised() -> None:
    found = ahead([lambda: 1, lambda: 2, lambda: 1 // 0, lambda: 4])
    assert [next(found), next(found)] == [1, 2]
    with pytest.raises(ZeroDivisionError):
        next(found)
    assert not [one for one in threading.enumerate() if one.name.startswith("ahead")]


def test_what_is_made_beside_is_there_when_the_rest_is_done() -> None:
    began, goes_on, made = threading.Event(), threading.Event(), []

    def make() -> None:
        began.set()
        assert goes_on.wait(PATIENCE_S)
        made.append(threading.current_thread().name)

    with beside(make):
        assert began.wait(PATIENCE_S)  # it does not wait for the rest
        assert not made
        goes_on.set()
    assert made == ["beside_0"]


def test_an_error_beside_is_left_to_who_asks() -> None:
    with beside(lambda: 1 // 0):
        pass
