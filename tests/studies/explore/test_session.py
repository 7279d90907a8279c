"""One request is answered at a time, the newest is kept, and each answer bears its number."""

import asyncio
import json

import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.explore.session import Session
from tests.studies.explore.conftest import decode


def converse(texts, until, pause=0.0):
    """Headers of the answers to requests, of which each comes after a pause, until one is the last."""
    headers = []

    async def talk():
        over = asyncio.Event()

        async def given():
            for text in texts:
                yield text
                await asyncio.sleep(pause)
            await over.wait()

        async def send(frame):
            header, curves = decode(frame)
            headers.append(header | {"names": set(curves)})
            if until(header):
                over.set()

        await asyncio.wait_for(Session(Machine()).serve(given(), send), 120)

    # In a thread of its own: a browser's driver may have a loop in this one.
    call_in_thread(asyncio.run, talk()).result()
    return headers


def request(number, speed="1000 rpm", **values):
    return json.dumps(
        {
            "number": number,
            "values": {"speed": speed} | {key.replace("__", "."): value for key, value in values.items()},
        }
    )


def is_exact(header):
    return header.get("is_exact", False)


def test_of_sixty_requests_the_newest_is_answered_and_none_is_queued():
    texts = [request(number, f"{800 + 10 * number} rpm") for number in range(1, 61)]
    headers = converse(texts, is_exact)
    numbers = [header["number"] for header in headers if header["kind"] == "point"]
    assert numbers == sorted(numbers) and numbers[-1] == 60
    assert len(numbers) < 10
    assert headers[-1]["own"]["speed_rpm"] == 1400.0
    assert headers[-1]["own"]["brake_torque_Nm"] == pytest.approx(
        apesim.run_engine(Machine(), "1400 rpm")["brake_torque"], rel=1e-9
    )


def test_the_exact_answer_comes_once_and_only_at_rest():
    headers = converse([request(1), request(2, "1010 rpm")], is_exact, pause=0.05)
    kinds = [(header["number"], header["is_exact"]) for header in headers if header["kind"] == "point"]
    assert kinds[-1] == (2, True)
    assert all(not exact for _, exact in kinds[:-1])
    assert {"lift", "ideal_cylinder_pressure"} <= headers[-1]["names"]


def test_a_request_that_cannot_be_is_told_and_the_next_is_answered():
    texts = ["{", request(2, engine__bore="9 km"), request(3)]
    headers = converse(texts, is_exact, pause=0.3)
    refused = [header for header in headers if header["kind"] == "refused"]
    assert [header["number"] for header in refused] == [-1, 2]
    assert refused[1]["faults"][0]["key"] == "engine.bore"
    assert headers[-1]["number"] == 3


def test_the_first_run_of_a_kind_is_announced_and_the_picture_is_sent_once():
    headers = converse(
        [request(1), request(2, "1010 rpm")], lambda header: is_exact(header) and header["number"] == 2, pause=0.4
    )
    assert [header["kind"] for header in headers].count("compiling") == 1
    assert headers[0]["kind"] == "compiling"
    points = [header for header in headers if header["kind"] == "point"]
    assert points[0]["picture"]["html"].startswith("<div") and all(header["picture"] is None for header in points[1:])


def test_a_page_that_goes_away_while_it_is_answered_leaves_its_thread_whole():
    async def leave():
        async def given():
            yield request(1)
            await asyncio.sleep(0.005)

        async def send(_):
            pass

        await Session(Machine()).serve(given(), send)

    for _ in range(5):
        call_in_thread(asyncio.run, leave()).result(timeout=60)
    assert [call_in_thread(pow, 2, number).result(timeout=60) for number in range(8)] == [
        2**number for number in range(8)
    ]
