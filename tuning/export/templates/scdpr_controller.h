/* The controller and the input shapers of a scdpr-jax tuning, for a sampled loop.
 *
 * Written by scdpr-jax: write it anew rather than change it. C99; allocates nothing and
 * keeps nothing, every state is the caller's. SI units and radians.
 *
 * Before a leg, at rest, with the reference held for at least the last shaper's duration:
 *
 *     scdpr_shaper_init(&shaper, scdpr_region_at(x_end, y_end, pretension), reference);
 *     scdpr_pd_init(&pd, angle_reference, angle);
 *
 * Then every SCDPR_PERIOD seconds, in this order:
 *
 *     scdpr_shaper_step(&shaper, reference, shaped);
 *     scdpr_angle_reference(shaped, origin, angle_reference);
 *     scdpr_pd_step(&pd, angle_reference, angle, feedforward, voltage);
 *
 * The references of plan.csv (`scdpr plan`) need no shaper: give scdpr_pd_step their angles
 * and their feed-forward.
 */
#ifndef SCDPR_CONTROLLER_H
#define SCDPR_CONTROLLER_H

#include <stddef.h>

$constants
#define SCDPR_REGIONS $region_count /* shapers, one for each region */
#define SCDPR_HISTORY $history /* samples that the longest shaper looks back on */

/* One impulse of a shaper. */
typedef struct {
    size_t delay;     /* whole samples until it */
    double fraction;  /* share of a further sample until it [1] */
    double amplitude; /* [1]; those of a shaper sum to 1 */
} scdpr_impulse;

/* A part of the workspace, both ends included, and the shaper for legs that end in it. */
typedef struct {
    double x[2];          /* horizontal position of the end-effector [m] */
    double y[2];          /* its height [m] */
    double pretension[2]; /* nominal setting of the cable loop [N] */
    size_t impulses;
    const scdpr_impulse *impulse;
} scdpr_region;

$tables

static const scdpr_region scdpr_regions[SCDPR_REGIONS] = {
$regions
};

/* The first region that contains a pose at a setting, or NULL. */
static inline const scdpr_region *scdpr_region_at(double x, double y, double pretension)
{
    for (size_t i = 0; i < SCDPR_REGIONS; ++i) {
        const scdpr_region *region = &scdpr_regions[i];
        if (region->x[0] <= x && x <= region->x[1] && region->y[0] <= y && y <= region->y[1]
            && region->pretension[0] <= pretension && pretension <= region->pretension[1])
            return region;
    }
    return NULL;
}

/* A shaper at work on both coordinates: the latest references in a ring. */
typedef struct {
    const scdpr_region *region;
    size_t newest;
    double history[SCDPR_HISTORY][2];
} scdpr_shaper;

/* Start at rest: the reference [m] counts as held until now. With a region of NULL the
 * references pass as they are. */
static inline void scdpr_shaper_init(scdpr_shaper *shaper, const scdpr_region *region,
                                     const double reference[2])
{
    shaper->region = region;
    shaper->newest = 0;
    for (size_t i = 0; i < SCDPR_HISTORY; ++i) {
        shaper->history[i][0] = reference[0];
        shaper->history[i][1] = reference[1];
    }
}

/* One sample: the reference {x, y} [m] in, the shaped one out; both may be one array. */
static inline void scdpr_shaper_step(scdpr_shaper *shaper, const double reference[2],
                                     double shaped[2])
{
    const scdpr_region *region = shaper->region;
    shaper->newest = (shaper->newest + 1) % SCDPR_HISTORY;
    shaper->history[shaper->newest][0] = reference[0];
    shaper->history[shaper->newest][1] = reference[1];
    if (region == NULL) {
        shaped[0] = reference[0];
        shaped[1] = reference[1];
        return;
    }
    shaped[0] = 0.0;
    shaped[1] = 0.0;
    for (size_t i = 0; i < region->impulses; ++i) {
        const scdpr_impulse *impulse = &region->impulse[i];
        size_t after = (shaper->newest + SCDPR_HISTORY - impulse->delay) % SCDPR_HISTORY;
        size_t before = (after + SCDPR_HISTORY - 1) % SCDPR_HISTORY;
        /* Straight between two samples. */
        for (size_t axis = 0; axis < 2; ++axis)
            shaped[axis] += impulse->amplitude
                            * ((1.0 - impulse->fraction) * shaper->history[after][axis]
                               + impulse->fraction * shaper->history[before][axis]);
    }
}

/* Angles [rad] of the driver pulleys from those at the origin {x, y} [m], Eq. (3). */
static inline void scdpr_angle_reference(const double position[2], const double origin[2],
                                         double angle[2])
{
    const double horizontal = position[0] - origin[0];
    const double vertical = position[1] - origin[1];
    angle[0] = (horizontal + vertical) / SCDPR_EFFECTIVE_RADIUS;
    angle[1] = (horizontal - vertical) / SCDPR_EFFECTIVE_RADIUS;
}

/* The PD control law of both drives, Eq. (23), with a filtered backward difference. */
typedef struct {
    double error[2];      /* of the sample before [rad] */
    double derivative[2]; /* its filtered derivative [rad/s] */
} scdpr_pd;

/* Switch on at rest: the first sample has no derivative. */
static inline void scdpr_pd_init(scdpr_pd *pd, const double reference[2],
                                 const double measured[2])
{
    for (size_t i = 0; i < 2; ++i) {
        pd->error[i] = reference[i] - measured[i];
        pd->derivative[i] = 0.0;
    }
}

/* One sample: angles [rad] and feed-forward [V] in, the command within the limit [V] out. */
static inline void scdpr_pd_step(scdpr_pd *pd, const double reference[2],
                                 const double measured[2], const double feedforward[2],
                                 double voltage[2])
{
    for (size_t i = 0; i < 2; ++i) {
        const double error = reference[i] - measured[i];
        const double kept = SCDPR_FILTER_TIME * pd->derivative[i];
        const double derivative
            = (kept + error - pd->error[i]) / (SCDPR_FILTER_TIME + SCDPR_PERIOD);
        const double command = SCDPR_PROPORTIONAL_GAIN * error
                               + SCDPR_DERIVATIVE_GAIN * derivative + feedforward[i];
        pd->error[i] = error;
        pd->derivative[i] = derivative;
        voltage[i] = command > SCDPR_VOLTAGE_LIMIT    ? SCDPR_VOLTAGE_LIMIT
                     : command < -SCDPR_VOLTAGE_LIMIT ? -SCDPR_VOLTAGE_LIMIT
                                                      : command;
    }
}

#endif
