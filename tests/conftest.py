"""Settings for all tests."""

from hypothesis import settings

# The first example compiles a kernel; how long examples take says nothing about right or wrong.
settings.register_profile("bearing_twin", deadline=None)
settings.load_profile("bearing_twin")
