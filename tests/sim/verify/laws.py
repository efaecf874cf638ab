"""A law that holds, and one that does not, for the test of what runs such tests; pytest takes neither by itself."""

from hypothesis import given
from hypothesis import strategies as st


@given(st.integers())
def test_square(number):
    assert number * number >= 0


@given(st.integers())
def test_every_number_is_small(number):
    assert number <= 100
