"""OpenCV with one thread, so that the same picture gives the same bytes. The only module that imports it."""

from __future__ import annotations

from pickcli.errors import not_installed

try:
    import cv2
except ImportError:
    raise not_installed("opencv-python-headless", "perception", "recognition of prints, by SIFT,") from None

cv2.setNumThreads(1)
VERSION = str(cv2.__version__)

__all__ = ["VERSION", "cv2"]
