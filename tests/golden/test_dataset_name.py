"""golden.dataset: the name of version 0.1 for scripts outside the project."""

import golden.dataset
import golden.pictures.dataset


def test_the_same_objects():
    assert golden.dataset.__all__
    for name in golden.dataset.__all__:
        assert getattr(golden.dataset, name) is getattr(golden.pictures.dataset, name)
