"""CRC-32 of logs, by zlib-ng where it is installed: four to five times as fast as zlib, on which a log would wait."""

try:
    from zlib_ng.zlib_ng import crc32
except ImportError:  # no package of Debian, so that a ROS installed from there lacks it
    from zlib import crc32

__all__ = ["crc32"]
