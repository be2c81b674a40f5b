"""A unit of a sweep: points that follow each other, computed wherever it is asked for."""

from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.runtime.parcel import Parcel
from experiments.runtime.robot_parcel import robot_arrays, robot_of
from experiments.sweep.axes import Axis
from experiments.sweep.grid import Grid
from experiments.sweep.measure import Compute, Measure, Values
from experiments.sweep.measures import MEASURES
from scdpr_jax.numerics.batches import in_chunks
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import QUANTITIES, replace

_ROBOT = frozenset(quantity.name for quantity in QUANTITIES)


class Point(eqx.Module):
    """A measure at one point of a sweep."""

    robot: Robot
    """The robot, as far as it isn't swept."""
    fixed: Values
    """The measure's variables that aren't swept."""
    names: tuple[str, ...] = eqx.field(static=True)
    """What is swept."""
    compute: Compute = eqx.field(static=True)
    """From a robot and a measure's variables to its outputs."""

    def __call__(self, values: Float[Array, " axes"]) -> tuple[Array, ...]:
        """The outputs where what is swept has some values."""
        swept = dict(zip(self.names, values, strict=True))
        robot = replace(self.robot, {n: v for n, v in swept.items() if n in _ROBOT})
        return self.compute(robot, {**self.fixed, **swept})


class Sweep(NamedTuple):
    """What is swept: everything that the points' results follow from."""

    measure: Measure
    """What is computed."""
    grid: Grid
    """The points."""
    robot: Robot
    """The robot; its leaves' dtype is the sweep's."""

    @property
    def values(self) -> dict[str, float]:
        """The variables that aren't swept [in their units]."""
        known = self.measure.known
        swept = self.grid.names
        return {v.name: float(v.default(self.robot)) for v in known if v.name not in swept}

    @property
    def dtype(self) -> np.dtype:
        """Of what it computes with."""
        return np.dtype(self.robot.frame.width.dtype)

    @property
    def units(self) -> int:
        """Number of units."""
        return -(-self.grid.count // self.measure.unit)

    def ends(self, number: int) -> tuple[int, int]:
        """Index of a unit's first point, and the one after its last."""
        first = number * self.measure.unit
        return first, min(first + self.measure.unit, self.grid.count)

    @property
    def point(self) -> Point:
        """What computes a point."""
        fixed = {n: v for n, v in self.values.items() if n not in _ROBOT}
        return Point(
            robot=self.robot,
            fixed={n: jnp.asarray(v, self.dtype) for n, v in fixed.items()},
            names=self.grid.names,
            compute=self.measure.compute(self.grid.axes),
        )

    @property
    def record(self) -> np.dtype:
        """What is kept of a point, from the function's own result."""
        point = self.point
        one = jax.ShapeDtypeStruct((len(point.names),), self.dtype)
        leaves = jax.eval_shape(point, one)
        outputs = zip(self.measure.outputs, leaves, strict=True)
        return np.dtype([(output.name, leaf.dtype, leaf.shape) for output, leaf in outputs])

    def parcel(self) -> Parcel:
        """The sweep as plain data.

        Raises:
            ValueError: If the robot isn't of the prototype's kind, exact friction and all.
        """
        return Parcel(
            {
                "measure": self.measure.name,
                "unit": self.measure.unit,
                "axes": list(self.grid.names),
                "values": self.values,
            },
            {
                **{f"axis {axis.variable.name}": axis.values for axis in self.grid.axes},
                **robot_arrays(self.robot),
            },
        )


def _unpacked(parcel: Parcel) -> Sweep:
    facts, arrays = parcel
    measure = next(own for own in MEASURES if own.name == facts["measure"])
    variables = {variable.name: variable for variable in measure.known}
    axes = tuple(Axis(variables[name], arrays[f"axis {name}"]) for name in facts["axes"])
    return Sweep(measure._replace(unit=facts["unit"]), Grid(axes), robot_of(arrays))


def begin(parcel: Parcel) -> Callable[[int, bytes], bytes]:
    """What computes the units of a sweep.

    Args:
        parcel: The sweep.

    Returns:
        From a unit's number to its points' records, one after the other.
    """
    double = parcel.arrays["robot 0"].dtype == np.float64
    with jax.enable_x64(double):
        swept = _unpacked(parcel)
        point, record = swept.point, swept.record

    def computed(number: int, payload: bytes) -> bytes:
        points = swept.grid.points(*swept.ends(number)).astype(swept.dtype)
        with jax.enable_x64(double):
            leaves = in_chunks(point, points, size=swept.measure.chunk)
        records = np.empty(len(points), record)
        for output, values in zip(swept.measure.outputs, leaves, strict=True):
            records[output.name] = values
        return records.tobytes()

    return computed


def named_inputs(swept: Sweep) -> dict[str, Any]:
    """What a sweep's results follow from, by names for a message.

    Args:
        swept: The sweep.

    Returns:
        The inputs.
    """
    return {
        "measure": swept.measure.name,
        "axes": {axis.variable.name: axis.values.tolist() for axis in swept.grid.axes},
        "values": swept.values,
        "robot": [np.asarray(leaf).tolist() for leaf in jax.tree.leaves(swept.robot)],
    }
