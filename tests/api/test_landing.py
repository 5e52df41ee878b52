"""The environment to learn in: it passes Gymnasium's own check, is the same for a seed, and can be won."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="gymnasium is not installed: pip install 'planetfall[games]'")

from gymnasium.utils.env_checker import check_env

from planetfall.games.landing.lander import Lander
from planetfall.games.landing.main import control

pytestmark = pytest.mark.gpu


@pytest.fixture(scope="module")
def lander():
    made = Lander()
    yield made
    made.close()


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_gymnasiums_own_check(lander):
    check_env(lander, skip_render_check=True)


def episode(lander, seed, action):
    seen, told = lander.reset(seed=seed)
    frames, over = [seen], False
    while not over:
        seen, _, down, late, told = lander.step(action(seen["state"]))
        frames.append(seen)
        over = down or late
    return frames, told


def test_the_controller_lands_and_the_seed_says_where(lander):
    one, told = episode(lander, 5, control)
    two, again = episode(lander, 5, control)
    assert told["landed"] and told == again and len(one) == len(two)
    for a, b in zip(one, two, strict=True):
        for name in a:
            np.testing.assert_array_equal(a[name], b[name])
    # What it sees is what it is told: the middle of the picture lies below it.
    height, middle = one[0]["state"][0], one[0]["depth"][23:25, 31:33].mean()
    assert abs(middle - height) < 0.1 * height
    assert one[0]["image"].std() > 2.0


def test_without_thrust_it_crashes(lander):
    _, told = episode(lander, 5, lambda state: np.array([0.0, 0.0, -1.0], np.float32))
    assert not told["landed"] and told["speed_m_s"] > 20.0
