"""Files that are spoilt: their bytes, or what they mean."""

import hypothesis
from hypothesis import strategies as st

INSERTED = (
    *(b"\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"\r", b"\n", b'"', b"[", b"]", b"=", b"#", b",", b";", b"\t"),
    *(b"nan", b"inf", b"-1", b"1e999", b"9" * 400, b"\x1b[2J", b"\xc3\x28", "½µ‑−".encode(), b"[[", b"'''", b"\\u0000"),
)
"""What is put between bytes."""
DRAWS = 6
"""Examples of a strategy of which the last is taken: the first ones are the simplest."""


def draw(strategy, seed):
    """An example of a strategy that follows from a seed."""
    drawn = []

    @hypothesis.seed(seed)
    @hypothesis.settings(max_examples=DRAWS, database=None, deadline=None, phases=[hypothesis.Phase.generate])
    @hypothesis.given(strategy)
    def catch(example):
        drawn.append(example)

    catch()
    return drawn[-1]


def flip(data, place, length, rng):
    return data[:place] + bytes([data[place] ^ (1 << rng.randrange(8))]) + data[place + 1 :] if data[place:] else data


def put_in(data, place, length, rng):
    return data[:place] + rng.choice(INSERTED) + data[place:]


def take_out(data, place, length, rng):
    return data[:place] + data[place + length :]


def double(data, place, length, rng):
    return data[: place + length] + data[place:]


def fill(data, place, length, rng):
    return data[:place] + rng.choice((b"\x00", b"\xff", b" ")) * length + data[place + length :]


def cut(data, place, length, rng):
    return data[:place]


WAYS = (*(flip, put_in, take_out, double, fill) * 3, cut)
"""What happens to bytes at a place; a cut leaves little to be read, so it is rare."""


def spoil_bytes(data, rng):
    """Bytes that are changed at one place or several.

    Parameters
    ----------
    data : bytes
    rng : random.Random

    Returns
    -------
    bytes
    """
    for _ in range(rng.choice((1, 1, 1, 2, 5, 20))):
        data = rng.choice(WAYS)(data, rng.randrange(len(data) + 1), rng.choice((1, 1, 4, 16, 256)), rng)
    return data


UNITS = ("", "mm", "mm^2", "m", "K", "°C", "MPa gauge", "kPa abs", "ms", "s", "N", "%", "kg", "rpm", "deg", "J/(kg K)")
SCALARS = st.one_of(
    st.builds(lambda value, unit: f'"{value!r} {unit}"', st.floats(), st.sampled_from(UNITS)),
    st.builds(lambda value, unit: f'"{value} {unit}"', st.integers(-1000, 1000), st.sampled_from(UNITS)),
    st.sampled_from(("nan", "inf", "-inf", "true", "false", "1e400", "0x7f", "1979-05-27", "07:32:00", "''", '""')),
    st.integers().map(str),
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.text(st.characters(codec="utf-8", exclude_characters='"\\\n\r'), max_size=30).map(lambda text: f'"{text}"'),
    st.sampled_from(("../x.csv", "/dev/zero", "/etc/passwd", "nothing.csv", ".", "a\\u0000b", "x" * 5000)).map(
        lambda text: f'"{text}"'
    ),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4).map(lambda each: f"[{', '.join(each)}]"),
        st.dictionaries(st.sampled_from(("a", "time", "bore", "x.y")), inner, max_size=3).map(
            lambda pairs: "{ " + ", ".join(f"{key} = {value}" for key, value in pairs.items()) + " }"
        ),
    ),
    max_leaves=6,
)
"""Values of TOML, as text: numbers with units that may be right, and what nobody would write."""


def rename_key(lines, number, rng):
    lines[number] = "x" + lines[number]


def remove(lines, number, rng):
    del lines[number]


def repeat(lines, number, rng):
    lines.insert(rng.randrange(len(lines)), lines[number])


def change_head(lines, number, rng):
    heads = [number for number, line in enumerate(lines) if line.startswith("[")]
    if heads:
        number, other = rng.choice(heads), rng.choice(heads)
        lines[number] = rng.choice((lines[number][1:-1], f"[{lines[number]}]", "[nothing]", lines[other]))


def change_value(lines, number, rng):
    key = lines[number].partition("=")[0]
    lines[number] = f"{key.strip()} = {draw(VALUES, rng.randrange(2**32))}"


CHANGES = rename_key, remove, repeat, change_head, *(change_value,) * 8
"""What happens to a line with a key, or to a head."""


def spoil_toml(text, rng):
    """TOML of which some lines have other values or keys, are gone, or stand twice.

    Parameters
    ----------
    text : str
        A key and its value, or the head of a table, in each line.
    rng : random.Random

    Returns
    -------
    str
    """
    lines = text.splitlines()
    for _ in range(rng.choice((1, 1, 2, 4))):
        keys = [number for number, line in enumerate(lines) if "=" in line and not line.startswith("#")]
        if keys:
            rng.choice(CHANGES)(lines, rng.choice(keys), rng)
    return "\n".join(lines) + "\n"
