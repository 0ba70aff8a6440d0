"""Names of the methods that follow an impact step by step, for those who only read a scene and for the steps alike."""

FIXED_STEP = ("rk4", "symplectic_euler")
