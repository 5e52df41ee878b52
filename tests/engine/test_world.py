"""World: apart from the host's esper world, in order, and with messages that say what to do."""

import gc
import threading
from dataclasses import dataclass

import esper
import pytest

from planetfall.engine.system import System
from planetfall.engine.world import MissingError, World


@dataclass
class Mass:
    kg: float = 1.0


@dataclass
class Spin:
    rate: float = 0.0


@pytest.fixture
def world():
    world = World("test")
    yield world
    world.close()


def test_host_world_is_untouched_and_restored(world):
    esper.switch_world("host")
    try:
        mine = esper.create_entity(Mass(5.0))
        entity = world.create(Mass(1.0))
        assert esper.current_world == "host"
        assert [m.kg for _, (m,) in esper.get_components(Mass)] == [5.0]
        assert world.get(entity, Mass).kg == 1.0
        with pytest.raises(ZeroDivisionError), world.active():
            assert esper.current_world == world.name
            raise ZeroDivisionError
        assert esper.current_world == "host"
        with pytest.raises(MissingError):
            world.delete(999)
        assert esper.current_world == "host"
        assert esper.entity_exists(mine)
    finally:
        esper.switch_world("default")
        esper.delete_world("host")


def test_several_worlds_at_once_even_with_one_name():
    a, b = World("same"), World("same")
    ea, eb = a.create(Mass(1)), b.create(Mass(2))
    assert (ea, eb) == (1, 1)
    with a.active():
        assert b.get(eb, Mass).kg == 2
        with b.active():
            assert esper.current_world == b.name
        assert esper.current_world == a.name
    a.close()
    assert b.get(eb, Mass).kg == 2
    b.close()
    assert a.name not in esper.list_worlds() and b.name not in esper.list_worlds()


def test_query_is_sorted_and_follows_changes(world):
    entities = [world.create(Mass(i)) for i in range(200)]
    for e in entities[::3]:
        world.add(e, Spin())
    rows = world.query(Mass, Spin)
    assert [e for e, _ in rows] == sorted(entities[::3])
    assert world.query(Mass, Spin) is rows  # cached
    world.remove(entities[0], Spin)
    assert [e for e, _ in world.query(Mass, Spin)] == sorted(entities[3::3])
    assert all(isinstance(m, Mass) and isinstance(s, Spin) for _, (m, s) in world.query(Mass, Spin))
    with pytest.raises(TypeError, match="at least one component type"):
        world.query()


def test_structure_revision_counts_structure_only(world):
    seen = [world.structure_revision]

    def rose():
        seen.append(world.structure_revision)
        return seen[-1] > seen[-2]

    e = world.create(Mass())
    assert rose()
    world.add(e, Spin())
    assert rose()
    world.get(e, Mass).kg = 3.0
    world.query(Mass)
    assert not rose()
    world.remove(e, Spin)
    assert rose()
    world.delete(e)
    assert rose()
    with pytest.raises(MissingError):
        world.delete(e)
    assert not rose()


def test_messages_of_missing_things(world):
    e = world.create(Mass())
    with pytest.raises(MissingError, match=r"entity 1 has no Spin; it has Mass\. Add one with add\(Spin\(\)\)"):
        world.get(e, Spin)
    with pytest.raises(MissingError, match="has no Spin"):
        world.remove(e, Spin)
    with pytest.raises(MissingError, match=r"can't delete entity 77: world planetfall:test#.* has no such entity"):
        world.delete(77)
    with pytest.raises(MissingError, match="can't add a Mass to entity 77"):
        world.add(77, Mass())
    assert world.try_get(77, Mass) is None and world.try_get(e, Spin) is None
    assert world.has(e, Mass) and not world.has(e, Mass, Spin) and not world.has(77, Mass)
    with pytest.raises(TypeError, match=r"got the class Mass, expected a component: write Mass\(\)"):
        world.add(e, Mass)
    with pytest.raises(ValueError, match="two Mass components"):
        world.create(Mass(), Mass())


def test_resources(world):
    world.set_resource("proxy", 3)
    assert world.resource("proxy") == 3
    with pytest.raises(MissingError, match="world resource 'poxy' was not set; set so far: proxy"):
        world.resource("poxy")
    world.remove_resource("proxy")
    assert world.try_resource("proxy") is None


def test_worlds_with_own_resources_share_entities_and_what_the_world_holds(world):
    first, second = world.with_own_resources(), world.with_own_resources()
    first.set_resource("height_field", 1)
    assert world.try_resource("height_field") is None and second.try_resource("height_field") is None
    world.set_resource("weather", "fog")
    second.set_resource("weather", "rain")
    assert [of.resource("weather") for of in (world, first, second)] == ["fog", "fog", "rain"]
    before = world.structure_revision
    entity = first.create(Mass(3.0))
    assert second.get(entity, Mass).kg == 3.0 and [row[0] for row in world.query(Mass)] == [entity]
    assert world.structure_revision == first.structure_revision == second.structure_revision > before
    world.close()
    assert first.closed
    with pytest.raises(RuntimeError, match="is closed"):
        second.create(Mass())


def test_closing():
    world = World()
    world.create(Mass())
    with world.active(), pytest.raises(RuntimeError, match="inside its own active"):
        world.close()
    world.close()
    world.close()
    with pytest.raises(RuntimeError, match="is closed"):
        world.create(Mass())


def test_forgotten_world_is_freed():
    name = World("lost").name
    gc.collect()
    assert name not in esper.list_worlds()


def test_threads_do_not_mix_worlds():
    worlds = [World(f"t{i}") for i in range(4)]
    failures = []

    def work(world, kg):
        for _ in range(200):
            e = world.create(Mass(kg))
            if any(m.kg != kg for _, (m,) in world.query(Mass)):
                failures.append(world.name)
            world.delete(e)

    threads = [threading.Thread(target=work, args=(w, i)) for i, w in enumerate(worlds)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert not failures
    assert esper.current_world == "default"
    for w in worlds:
        w.close()


def test_system_is_active_while_an_entity_has_what_it_needs(world):
    class Spinning(System):
        name = "spinning"
        needs = (Mass, Spin)

    class Always(System):
        name = "always"

    system = Spinning()
    assert Always().active(world) and not system.active(world)
    e = world.create(Mass(), Spin())
    assert system.active(world)
    world.remove(e, Spin)
    assert not system.active(world)
    with pytest.raises(TypeError, match="Nameless needs a class attribute name"):

        class Nameless(System):
            pass
