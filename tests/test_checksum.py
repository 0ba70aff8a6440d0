"""The CRC of logs against zlib's."""

import random
import zlib

import pytest

from bearing_twin.log import checksum
from bearing_twin.log.folding import can_fold

SIZES = (0, 1, 63, 64, checksum.LEAST - 1, checksum.LEAST, checksum.LEAST + 1, checksum.LEAST + 63, 3 * checksum.LEAST)


@pytest.mark.parametrize("size", SIZES)
def test_the_crc_is_that_of_zlib(size):
    data = random.Random(size).randbytes(size)
    for value in (0, 1, 0xFFFFFFFF, zlib.crc32(b"before")):
        assert checksum.crc32(data, value) == zlib.crc32(data, value)
        assert checksum.crc32(memoryview(bytearray(b"x" + data))[1:], value) == zlib.crc32(data, value)


def test_the_crc_goes_on_where_it_was():
    data = random.Random(7).randbytes(5 * checksum.LEAST + 11)
    for cut in (3, checksum.LEAST, len(data) - 1):
        assert checksum.crc32(data[cut:], checksum.crc32(data[:cut])) == zlib.crc32(data)


@pytest.mark.skipif(not can_fold(), reason="this processor does not multiply polynomials")
def test_large_data_is_folded_and_small_is_not(monkeypatch):
    seen = []
    monkeypatch.setattr(checksum.zlib, "crc32", lambda data, value=0: seen.append(len(data)) or 0)
    checksum.crc32(bytes(checksum.LEAST + 5))
    assert seen == [2, 5]  # the folded pair of words, and what is no whole stride
    checksum.crc32(bytes(checksum.LEAST - 1))
    assert seen[2:] == [checksum.LEAST - 1]
