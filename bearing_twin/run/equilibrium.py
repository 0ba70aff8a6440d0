"""Equilibria of a bearing under arrays of loads and of its scene's keys: the public function `equilibrium`."""

from collections.abc import Mapping
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from bearing_twin.base.errors import SceneError, echo
from bearing_twin.kinds.bearing.equilibrium import Equilibria, azimuths_on, solve_scenes
from bearing_twin.run.scene import Scene, choose, load_scene, require_bearing


def equilibrium(
    scene: Scene | str | PathLike | Mapping,
    loads: ArrayLike,
    *,
    ball_angle: ArrayLike | None = None,
    **changes: ArrayLike,
) -> Equilibria:
    """Equilibria of a ball bearing (Jones, Harris) under any number of loads, in one call.

    Centrifugal loads and gyroscopic moments of the balls count at the scene's speed, friction and the balls' weights do
    not. Under forces alone the ring's tilts stay as `drive.tilt` holds them; under moments, too, they are free.

    Parameters
    ----------
    scene : Scene, str, path or mapping
        A scene of a bearing, as `load_scene` takes it: a designation such as "6308", a name, a YAML file.
    loads : array_like (..., 3) or (..., 5)
        Force on the inner ring at its centre along x, y, z [N], and moments about x and y [N m], in `bearing_link`: z
        is the axis, the moments count right-handed.
    ball_angle : array_like, optional
        Azimuths of ball 0 from +x towards +y [rad], which broadcast against the cases; without, on the load line.
    **changes : array_like
        Keys of the scene, written with `__` for each dot, and their values in SI units, or words: numbers broadcast
        against the cases, as in `geometry__radial_clearance=np.linspace(0.0, 4e-5, 9)`. A key that is a list is set
        in the scene: `load_scene("6308", ["gravity=[0,0,0]"])`.

    Returns
    -------
    Equilibria
        Arrays whose first axes are those of the cases: displacement, ball loads, contact angles, stiffness; for a case
        without an equilibrium `converged` is False, `reason` says why, and its numbers are NaN.

    Raises
    ------
    SceneError
        The scene is impossible or of another kind, a key is unknown, or loads are not finite or have another shape.

    Notes
    -----
    Cases are solved independently. Those with equal changes share a scene, which takes about a millisecond to read and
    check; a case of 8 balls then takes some microseconds.

    Sources: Jones, A General Theory for Elastically Constrained Ball and Radial Roller Bearings (1960); Harris, Rolling
    Bearing Analysis.

    Examples
    --------
    >>> import numpy as np, bearing_twin
    >>> found = bearing_twin.equilibrium("6308", [[0, -1000, 0], [0, -3000, 0]])
    >>> np.round(1e6 * found.displacement[:, 1], 1)
    array([-19.9, -33.1])
    """
    given_loads = _finite_array(loads)
    if given_loads is None or given_loads.ndim == 0 or given_loads.shape[-1] not in (3, 5):
        raise SceneError(
            f"loads must be finite numbers, (..., 3) in N or (..., 5) with moments in N m, not {echo(loads)}"
        )
    angle = _finite_array(0.0 if ball_angle is None else ball_angle)
    if angle is None:
        raise SceneError(f"ball_angle must be finite numbers in rad, not {echo(ball_angle)}")
    keys = [name.replace("__", ".") for name in changes]
    values = [_key_values(key, value) for key, value in zip(keys, changes.values(), strict=True)]
    try:
        shape = np.broadcast_shapes(given_loads.shape[:-1], angle.shape, *(array.shape for array in values))
    except ValueError as error:
        shapes = ", ".join(str(array.shape) for array in (angle, *values))
        raise SceneError(
            f"loads of {given_loads.shape}, ball_angle and changes of {shapes} do not broadcast to one array of cases"
        ) from error
    forces = np.zeros((*shape, 5))
    forces[..., : given_loads.shape[-1]] = given_loads
    forces = forces.reshape(-1, 5)
    columns = [np.broadcast_to(array, shape).ravel() for array in values]
    scenes, scene_of_case = _distinct_scenes(scene, keys, columns, len(forces))
    if len({scene.parameters.geometry.balls for scene in scenes}) > 1:
        raise SceneError("geometry.balls must be one number for all cases: call once for each")
    first_angles = azimuths_on(forces) if ball_angle is None else np.broadcast_to(angle, shape).ravel()
    laws = [choose(scene).law for scene in scenes]
    parameters, free_tilt = [scene.parameters for scene in scenes], given_loads.shape[-1] == 5
    solved = solve_scenes(parameters, laws, scene_of_case, forces, free_tilt, first_angles)
    return Equilibria(*(array.reshape((*shape, *array.shape[1:])) for array in vars(solved).values()))


def _finite_array(numbers) -> np.ndarray | None:
    """An array of finite numbers; None for other values."""
    try:
        array = np.asarray(numbers, float)
    except (TypeError, ValueError):
        return None
    return array if np.isfinite(array).all() else None


def _key_values(key: str, value) -> np.ndarray:
    """The values of a key as an array; raises SceneError for values that are neither numbers nor words."""
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different length
        array = np.asarray(None)
    if array.dtype.kind not in "biufU":
        raise SceneError(f"{key} = {echo(value)} must be numbers or words, one for each case")
    return array


def _distinct_scenes(scene, keys, columns, cases: int) -> tuple[list[Scene], np.ndarray]:
    """The scenes with distinct values of the keys, and the index of each case's scene; one scene without a case."""
    rows, scene_of_case = [()], np.zeros(cases, np.intp)
    if keys and cases:
        codes = np.stack([np.unique(column, return_inverse=True)[1].ravel() for column in columns], axis=1)
        _, firsts, scene_of_case = np.unique(codes, axis=0, return_index=True, return_inverse=True)
        rows = [tuple(column[first].item() for column in columns) for first in firsts]
    elif isinstance(scene, Scene):
        return [require_bearing(scene)], scene_of_case
    source = scene.resolved() if isinstance(scene, Scene) else scene
    overrides = [[f"{key}={value}" for key, value in zip(keys, row, strict=False)] for row in rows]
    return [require_bearing(load_scene(source, row)) for row in overrides], scene_of_case.ravel()
