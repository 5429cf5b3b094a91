"""Pages in notebooks, and films."""

import pickle
import struct

import catena
import pytest


@pytest.fixture(scope="module")
def result(robots):
    return catena.Sim(catena.load(robots / "pendulum.urdf")).run(0.5, rate=20)


def size_of_png(path):
    """Width and height of a PNG, by its header."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", data[16:24])


def test_a_film_has_the_pictures_that_were_asked_for(result, tmp_path):
    # 0.5 s at 25 pictures a second begin at 0, and the last is at 0.48 s.
    assert result.film(tmp_path / "run.gif", size=(160, 90)) == 13
    assert (tmp_path / "run.gif").read_bytes()[:6] == b"GIF89a"
    assert result.film(tmp_path / "three.png", size=(160, 90), time=[0, 0.2, 0.4], view=(1, 0, 0.2)) == 3
    assert size_of_png(tmp_path / "three.png") == (3 * 160, 90)
    result.film(tmp_path / "again.gif", size=(160, 90))
    assert (tmp_path / "run.gif").read_bytes() == (tmp_path / "again.gif").read_bytes()


def test_films_that_cannot_be_are_refused(result, tmp_path):
    for options, words in [
        ({"view": "side"}, "give one of corner"),
        ({"size": (2, 2)}, "16 to 4096 pixels"),
        ({"time": [0, 7]}, "the log has samples from 0 to 0.5 s"),
        ({"speed": 0}, "it must be above 0"),
    ]:
        with pytest.raises(catena.InputError, match=words):
            result.film(tmp_path / "run.gif", **options)
    with pytest.raises(catena.InputError, match="none of .gif, .mp4, .png"):
        result.film(tmp_path / "run.avi")
    assert not list(tmp_path.iterdir())


def test_a_notebook_shows_the_page_of_a_result(result, monkeypatch):
    frame = result._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and "&lt;!DOCTYPE html&gt;" in frame
    assert pickle.loads(pickle.dumps(result))._repr_html_() is None
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    path = result.show()
    assert opened == [f"file://{path}"]
    with open(path) as page:
        assert page.read(15) == "<!DOCTYPE html>"
