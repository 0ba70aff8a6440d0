"""Shafts on two bearings, for tests: their motions, outputs and books."""

import numpy as np

from bearing_twin.kinds.shaft.motion import ShaftMotion
from bearing_twin.run.scene import choose, load_scene










