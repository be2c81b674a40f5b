"""The exported C header, compiled and run against scdpr_jax's own controller and shaper."""

import pathlib
import shutil
import subprocess

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tunings import HEIGHT, NAMES, TUNINGS, WIDTH

from scdpr_jax.command.controller import saturate
from scdpr_jax.command.shaper import shape_samples
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.engines.closed_loop import joint_references
from tuning.export.c_header import c_header
from tuning.export.description import describe
from tuning.regions.schedule import schedule_of, scheduled_samples

CAMPAIGNS = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "campaigns"
COMPILER = shutil.which("cc")
DRIVER = r"""
#include <stdio.h>
#include "scdpr_controller.h"

/* Poses in, the number of their region out; -1 for none. */
static int regions(void)
{
    double x, y, pretension;
    while (scanf("%lf %lf %lf", &x, &y, &pretension) == 3) {
        const scdpr_region *region = scdpr_region_at(x, y, pretension);
        printf("%d\n", region == NULL ? -1 : (int)(region - scdpr_regions));
    }
    return 0;
}

/* References and the places whose shapers count in, scheduled references out. */
static int scheduled(double pretension)
{
    static scdpr_schedule schedule;
    double in[4], shaped[2];
    int samples = 0;
    while (scanf("%lf %lf %lf %lf", in, in + 1, in + 2, in + 3) == 4) {
        if (samples++ == 0)
            scdpr_schedule_init(&schedule, scdpr_setting_at(pretension), in);
        scdpr_schedule_step(&schedule, in + 2, in, shaped);
        printf("%.17g %.17g\n", shaped[0], shaped[1]);
    }
    return 0;
}

/* References, angles and feed-forward in; shaped reference, its angles and commands out. */
int main(int count, char **arguments)
{
    static scdpr_shaper shaper;
    scdpr_pd pd;
    double in[6], origin[2], shaped[2], wanted[2], voltage[2], pretension;
    int number, samples = 0;
    if (count == 3 && sscanf(arguments[2], "%lf", &pretension) == 1)
        return scheduled(pretension);
    if (count != 2 || sscanf(arguments[1], "%d", &number) != 1)
        return regions();
    while (scanf("%lf %lf %lf %lf %lf %lf", in, in + 1, in + 2, in + 3, in + 4, in + 5) == 6) {
        if (samples == 0) {
            scdpr_shaper_init(&shaper, number < 0 ? NULL : &scdpr_regions[number], in);
            origin[0] = in[0];
            origin[1] = in[1];
        }
        scdpr_shaper_step(&shaper, in, shaped);
        scdpr_angle_reference(shaped, origin, wanted);
        if (samples == 0)
            scdpr_pd_init(&pd, wanted, in + 2);
        scdpr_pd_step(&pd, wanted, in + 2, in + 4, voltage);
        printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", shaped[0], shaped[1], wanted[0],
               wanted[1], voltage[0], voltage[1]);
        fflush(stdout);
        ++samples;
    }
    return 0;
}
"""

pytestmark = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler, `cc`, here")


@pytest.fixture(scope="module", params=TUNINGS, ids=NAMES)
def tuning(request):
    return request.param


@pytest.fixture(scope="module")
def program(tuning, tmp_path_factory):
    """The driver with the exported header; a warning is an error."""
    folder = tmp_path_factory.mktemp("export")
    (folder / "scdpr_controller.h").write_text(c_header(describe(tuning)))
    (folder / "driver.c").write_text(DRIVER)
    strict = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror"]
    call = [COMPILER, *strict, "driver.c", "-o", "driver"]
    made = subprocess.run(call, cwd=folder, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    return folder / "driver"


def run(program, rows, *arguments):
    text = "\n".join(" ".join(repr(float(number)) for number in row) for row in rows)
    done = subprocess.run(
        [program, *arguments], input=text, capture_output=True, text=True, check=True
    )
    return np.array([line.split() for line in done.stdout.splitlines()], dtype=float)


def made_up():
    """A smooth path with corners, angles that stray from it, and feed-forward."""
    random = np.random.default_rng(5)
    reference = 0.5 + np.cumsum(np.cumsum(random.normal(0, 1e-5, (1500, 2)), axis=0), axis=0)
    reference[700:900] = reference[700]
    angle = np.cumsum(random.normal(0, 1e-3, (1500, 2)), axis=0)
    return np.column_stack([reference, angle, random.normal(0, 3.0, (1500, 2))])


def recorded():
    """A logged manoeuvre: commanded positions, and the encoders' angles."""
    path = CAMPAIGNS / "rig-b" / "0005-manoeuvre" / "drive.csv"
    if not path.exists():
        pytest.skip("the shared campaigns are not beside this repository")
    log = np.genfromtxt(path, delimiter=",", names=True)
    counts = np.stack([log["alpha_1_count"], log["alpha_2_count"]], axis=1)
    reference = np.stack([log["x_ref_m"], log["y_ref_m"]], axis=1)
    return np.column_stack([reference, counts * 2 * np.pi / 26624, np.zeros_like(reference)])


@jax.jit
def commands(controller, limit, wanted, measured, feedforward):
    def sample(state, given):
        state, command = controller.step(state, *given[:2])
        return state, saturate(command + given[2], limit)

    state = controller.initial_state(wanted[0], measured[0])
    return jax.lax.scan(sample, state, (wanted, measured, feedforward))[1]


angles_of = jax.jit(joint_references)
shape = jax.jit(lambda shaper, samples, period: shape_samples(shaper, samples, period=period))


@pytest.fixture(scope="module", params=[made_up, recorded])
def rows(request):
    return request.param()


def test_every_shaper_shapes_as_shape_samples_does(program, tuning, rows):
    for number, regional in enumerate(tuning.shapers):
        shaped = run(program, rows, str(number))[:, :2]
        expected = shape(regional.shaper, jnp.asarray(rows[:, :2]), tuning.controller.period)
        assert np.max(np.abs(shaped - np.asarray(expected))) <= 1e-12  # m


@pytest.fixture(scope="module")
def crossing(tuning):
    """A leg through all regions, then rest."""
    leg = rest_to_rest((0.2, 0.1), (2.0, 1.0), duration=0.8)
    return np.asarray(jax.vmap(leg.position)(tuning.controller.period * jnp.arange(1500.0)))


@jax.jit
def schedule_samples(schedule, samples, places, period):
    return scheduled_samples(schedule, samples, places=places, period=period)


@pytest.mark.parametrize("pretension", [350.0, 150.0])
@pytest.mark.parametrize("where", ["on the way", "anywhere", "at the end"])
def test_the_schedule_blends_as_scheduled_samples_does(
    program, tuning, crossing, pretension, where
):
    places = {
        "on the way": crossing,
        "anywhere": np.random.default_rng(3).uniform(-0.3, 2.5, crossing.shape),
        "at the end": np.broadcast_to(np.array([1.0, 0.5]), crossing.shape),
    }[where]
    schedule = schedule_of(tuning.shapers, pretension)
    given = (jnp.asarray(crossing), jnp.asarray(places), tuning.controller.period)
    expected = np.asarray(schedule_samples(schedule, *given))
    rows = np.column_stack([crossing, places])
    found = run(program, rows, "scheduled", str(pretension))
    assert np.max(np.abs(found - expected)) <= 1e-12  # m


def test_the_schedule_of_a_setting_that_was_not_tuned_passes_references(program, crossing):
    rows = np.column_stack([crossing, crossing])
    assert np.array_equal(run(program, rows, "scheduled", "400"), crossing)


def test_commands_are_those_of_the_saturated_pd(program, tuning, rows):
    found = run(program, rows, "0")
    measured, feedforward = jnp.asarray(rows[:, 2:4]), jnp.asarray(rows[:, 4:])
    limit = tuning.robot_at().robot.drive.voltage_limit
    wanted = jnp.asarray(found[:, 2:4])
    expected = commands(tuning.controller, limit, wanted, measured, feedforward)
    assert np.max(np.abs(found[:, 4:] - np.asarray(expected))) <= 1e-12  # V


def test_commands_from_the_unshaped_reference_on_are_ours(program, tuning, rows):
    controller, robot = tuning.controller, tuning.robot_at().robot
    reference, measured, feedforward = (jnp.asarray(rows[:, i : i + 2]) for i in (0, 2, 4))
    shaped = shape(tuning.shapers[0].shaper, reference, controller.period)
    given = (angles_of(robot, shaped), measured, feedforward)
    expected = commands(controller, robot.drive.voltage_limit, *given)
    # Both sums of impulses round, by some 8 eps of the largest position; the derivative
    # divides the difference of two by the period.
    gain = controller.proportional_gain + 2 * controller.derivative_gain / controller.period
    rounding = 8 * np.finfo(float).eps * np.max(np.abs(rows[:, :2]))
    tolerance = float(gain / robot.drive.effective_radius) * rounding
    error = np.max(np.abs(run(program, rows, "0")[:, 4:] - np.asarray(expected)))
    assert error <= tolerance  # V, 1e-10 at most
    assert tolerance <= 1e-10


def test_the_made_up_commands_saturate_and_dont(program, tuning):
    limit = float(tuning.robot_at().robot.drive.voltage_limit)
    share = np.mean(np.abs(run(program, made_up(), "0")[:, 4:]) == limit)
    assert 0.05 < share < 0.95


def test_angles_are_those_of_the_inverse_kinematics(program, tuning, rows):
    found = run(program, rows, "0")
    expected = angles_of(tuning.robot_at().robot, jnp.asarray(found[:, :2]))
    assert np.max(np.abs(found[:, 2:4] - np.asarray(expected))) <= 1e-12  # rad


def test_without_a_region_references_pass_unshaped(program):
    rows = made_up()
    assert np.array_equal(run(program, rows, "-1")[:, :2], rows[:, :2])


def test_the_region_of_a_pose_is_the_one_that_the_tuning_gives(program, tuning):
    random = np.random.default_rng(2)
    poses = random.uniform([-0.2, -0.2, 80.0], [WIDTH + 0.2, HEIGHT + 0.2, 400.0], (300, 3))
    corners = [
        (x, y, pretension)
        for region in (known.region for known in tuning.shapers)
        for x in region.x
        for y in region.y
        for pretension in region.pretension
    ]

    def expected(pose):
        try:
            chosen = tuning.shaper_at(*(float(number) for number in pose))
        except ValueError:
            return -1
        return tuning.shapers.index(chosen)

    every = [*poses, *corners]
    assert run(program, every)[:, 0].tolist() == [expected(pose) for pose in every]


@jax.jit
def pd_sample(controller, limit, state, wanted, measured):
    state, command = controller.step(state, wanted, measured)
    return state, saturate(command, limit)


def under(command, plant, period, samples):
    """Angles of two bare drives, Eq. (24), under `command(sample, angles)`, exactly."""
    gain, pole = float(plant.gain), float(plant.pole)
    kept = np.exp(-pole * period)
    way = (1 - kept) / pole
    angle, velocity, reached = np.zeros(2), np.zeros(2), []
    for sample in range(samples):
        reached.append(angle)
        push = gain * command(sample, angle)
        angle = angle + way * velocity + (period - way) / pole * push
        velocity = kept * velocity + way * push
    return np.stack(reached)


def test_drives_under_the_compiled_controller_turn_as_under_ours(program, tuning):
    controller, robot = tuning.controller, tuning.robot_at().robot
    plant, limit = describe(tuning).plant, robot.drive.voltage_limit
    leg = rest_to_rest((0.3, 0.55), (1.3, 0.75), duration=1.0)
    times = controller.period * jnp.arange(1500.0)
    reference = jax.jit(jax.vmap(leg.position))(times)
    wanted = angles_of(robot, shape(tuning.shapers[0].shaper, reference, controller.period))
    state = controller.initial_state(wanted[0], jnp.zeros(2))

    def ours(sample, angle):
        nonlocal state
        given = (wanted[sample], jnp.asarray(angle))
        state, voltage = pd_sample(controller, limit, state, *given)
        return np.asarray(voltage)

    expected = under(ours, plant, float(controller.period), times.size)
    with subprocess.Popen(
        [program, "0"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as compiled:

        def theirs(sample, angle):
            row = (*np.asarray(reference[sample]), *angle, 0.0, 0.0)
            compiled.stdin.write(" ".join(repr(float(number)) for number in row) + "\n")
            compiled.stdin.flush()
            return np.array(compiled.stdout.readline().split()[4:], dtype=float)

        found = under(theirs, plant, float(controller.period), times.size)
        compiled.stdin.close()
    # They do turn, and saturate on the way.
    assert np.max(np.abs(expected)) > 1
    # Roundings of 1e-15 rad in a reference, and the loop is stable.
    assert np.max(np.abs(found - expected)) <= 1e-12  # rad
