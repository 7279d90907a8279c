"""SHA-256 digests of each dataset and of a whole archive, which any program can compute again.

The digest of a dataset is that of a header and of its values as they are stored. The header is UTF-8 text, each line
ended by a line feed: path, type (f8, i8, i1, or S and the bytes of a text), lengths of the axes with a space between
them, then NAME=VALUE of those attributes of axes, coordinate, coordinates, dimensions, finite, flag_meanings,
flag_values (with a space between them), long_name, meanings, reference and units that are there, in this order. The
values follow row by row, numbers little-endian, texts filled up with NUL.

The dataset /about/digests lists them: for each other dataset a line of its digest, two spaces and its path, sorted by
path. The root digest is that of the lines NAME=VALUE of those of the root's attributes Conventions, format,
format_version, history, source and title that are there, followed by this list; it is the root's attribute
content_sha256. Noted elsewhere it shows any change of the archive; by itself it is no signature.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import numpy as np

__all__ = ["DIGESTS", "ROOT_DIGEST", "dataset_digest", "digest_list", "root_digest"]

DIGESTS = "about/digests"
ROOT_DIGEST = "content_sha256"
Attribute = str | int | tuple[int, ...]


def dataset_digest(path: str, values: np.ndarray, attributes: Mapping[str, Attribute]) -> str:
    """Return the SHA-256 digest of one dataset.

    The hash is SHA-256 [1]_; what is hashed is defined in `apesim.archive.digests`.

    Parameters
    ----------
    path : str
        Path in the file, such as "/speed".
    values : ndarray
        Values as stored: little-endian numbers, or texts as UTF-8 in bytes of fixed length.
    attributes : mapping of str to str, int or tuple of int
        Attributes of the dataset, those of dimension scales left out.

    Returns
    -------
    str
        64 hexadecimal digits.

    References
    ----------
    .. [1] "Secure Hash Standard (SHS)", NIST FIPS 180-4, 2015, doi 10.6028/NIST.FIPS.180-4.

    Examples
    --------
    >>> import numpy as np
    >>> dataset_digest("/speed", np.array([600.0]), {"units": "min^-1"})[:8]
    '7b37db1d'
    """
    lines = [path, values.dtype.str[1:], " ".join(map(str, values.shape)), *_lines(attributes)]
    digest = hashlib.sha256("".join(f"{line}\n" for line in lines).encode())
    digest.update(np.ascontiguousarray(values).data)
    return digest.hexdigest()


def digest_list(digests: Mapping[str, str]) -> str:
    r"""Return the text of the dataset `DIGESTS`, from the digest of each other dataset by its path.

    Each line is digest, two spaces and path, sorted by path.
    """
    return "".join(f"{digests[path]}  {path}\n" for path in sorted(digests))


def root_digest(attributes: Mapping[str, Attribute], listed: str) -> str:
    """Return the SHA-256 digest of a whole archive.

    The hash is SHA-256 [1]_; what is hashed is defined in `apesim.archive.digests`.

    Parameters
    ----------
    attributes : mapping of str to str, int or tuple of int
        Attributes of the root, the digest left out.
    listed : str
        Text that `digest_list` returns.

    Returns
    -------
    str
        64 hexadecimal digits.

    References
    ----------
    .. [1] "Secure Hash Standard (SHS)", NIST FIPS 180-4, 2015, doi 10.6028/NIST.FIPS.180-4.

    Examples
    --------
    >>> len(root_digest({"format": "apesim archive", "format_version": 3}, digest_list({"/run": "34cd"})))
    64
    """
    return hashlib.sha256(("".join(f"{line}\n" for line in _lines(attributes)) + listed).encode()).hexdigest()


def _lines(attributes: Mapping[str, Attribute]) -> list[str]:
    return [f"{name}={_text(attributes[name])}" for name in sorted(attributes)]


def _text(value: Attribute) -> str:
    return " ".join(map(str, value)) if isinstance(value, tuple) else str(value)
