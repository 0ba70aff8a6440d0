"""Columns of a ball's state, and of the state of ring, cage and shaft: as the compiled core has them."""

import numpy as np

# Velocity and angular velocity: radial, tangential, axial, in the frame that turns with the ball about the axis.
AXIS_DISTANCE, ORBIT_ANGLE, HEIGHT, RADIAL_VELOCITY, TANGENTIAL_VELOCITY, AXIAL_VELOCITY = np.arange(6)
RADIAL_SPIN, TANGENTIAL_SPIN, AXIAL_SPIN, DRIVE_WORK, DISSIPATED, GROSS_WORK = np.arange(6, 12)
VELOCITY, SPIN = RADIAL_VELOCITY, RADIAL_SPIN
MOTION = 9  # the columns before this one are the motion; the rest only listen
COLUMNS = 12
CARRIED_COLUMNS = 8  # what a law carries: P/Q and three states at each of a ball's contacts

# Inner ring and cage: places (the ring's centre, its tilt about x and y, the cage's angle), their velocities, and
# integrals that only listen: work of the loads on the ring, what is lost, work of the drive through the cage's land.
PLACES = 6
RING_X, RING_Y, RING_Z, TILT_X, TILT_Y, CAGE = np.arange(PLACES)
CAGE_X, CAGE_Y = TILT_X, TILT_Y  # a cage whose centre moves has its places there, and the ring does not tilt
CAGE_SPEED = PLACES + CAGE
WORK_DONE, LOST, LAND_WORK = 12, 13, 14
SHAFT_ANGLE, SHAFT_SPEED, SHAFT_WORK = 15, 16, 17  # of a shaft that a torque turns: angle, speed, work of the torque
BORDER = 18
