"""OpenCV, which is an extra: named with its install line where it is missing."""

from types import ModuleType


def opencv() -> ModuleType:
    """The module `cv2`.

    Returns:
        It, with one thread of its own: pictures are small, and the cores have work.

    Raises:
        ValueError: If it isn't installed.
    """
    try:
        import cv2
    except ImportError:
        raise ValueError(
            "OpenCV is missing, expected the extra `video`. Install it with "
            "`pip install 'scdpr-jax[video]'` or `pip install opencv-python-headless`."
        ) from None
    cv2.setNumThreads(1)
    return cv2
