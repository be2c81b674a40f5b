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
 * The schedule blends the regions' shapers, without a jump from one to the next. At rest
 *
 *     scdpr_schedule_init(&schedule, scdpr_setting_at(pretension), reference);
 *
 * and every sample, in place of scdpr_shaper_step,
 *
 *     scdpr_schedule_step(&schedule, place, reference, shaped);
 *
 * where place is the end of the leg that is under way, if it is known: then the shaper stays
 * the same until it has arrived, and leaves as little of the vibration as it can. If it isn't
 * known, place is the reference, and shapers hand over on the way, which itself moves the
 * robot. Give place another value at rest, or follow the reference.
 *
 * The references of plan.csv (`scdpr plan`) need no shaper: give scdpr_pd_step their angles
 * and their feed-forward.
 */
#ifndef SCDPR_CONTROLLER_H
#define SCDPR_CONTROLLER_H

#include <stddef.h>

$constants
#define SCDPR_REGIONS $region_count /* shapers, one for each region */
#define SCDPR_NO_SETTING (-1) /* of a pretension that isn't tuned */
#define SCDPR_SETTING_TOLERANCE $tolerance /* share of a setting that a reading may be off */
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
    int setting;          /* regions of one number are a grid */
    double handover_x[2]; /* widths of the hand-overs about both ends of x [m], 0 for none */
    double handover_y[2]; /* and of y [m] */
    size_t impulses;
    const scdpr_impulse *impulse;
} scdpr_region;

$tables

static const scdpr_region scdpr_regions[SCDPR_REGIONS] = {
$regions
};

/* How far a pretension [N] is from a region's settings [N], 0 within them. */
static inline double scdpr_off_setting(const scdpr_region *region, double pretension)
{
    if (pretension < region->pretension[0])
        return region->pretension[0] - pretension;
    return pretension > region->pretension[1] ? pretension - region->pretension[1] : 0.0;
}

/* The first region of the setting next to a pretension [N]; NULL where none is within
 * SCDPR_SETTING_TOLERANCE of it. A reading of 349.9999 N is the setting of 350 N. */
static inline const scdpr_region *scdpr_next_setting(double pretension)
{
    const scdpr_region *next = NULL;
    for (size_t i = 0; i < SCDPR_REGIONS; ++i) {
        const scdpr_region *region = &scdpr_regions[i];
        double off = scdpr_off_setting(region, pretension);
        if (off <= SCDPR_SETTING_TOLERANCE * region->pretension[0]
            && (next == NULL || off < scdpr_off_setting(next, pretension)))
            next = region;
    }
    return next;
}

/* The first region that contains a pose at the setting next to a pretension, or NULL. */
static inline const scdpr_region *scdpr_region_at(double x, double y, double pretension)
{
    const scdpr_region *next = scdpr_next_setting(pretension);
    for (size_t i = 0; next != NULL && i < SCDPR_REGIONS; ++i) {
        const scdpr_region *region = &scdpr_regions[i];
        if (region->x[0] <= x && x <= region->x[1] && region->y[0] <= y && y <= region->y[1]
            && region->setting == next->setting)
            return region;
    }
    return NULL;
}

/* The latest references {x, y} [m], in a ring. */
typedef struct {
    size_t newest;
    double reference[SCDPR_HISTORY][2];
} scdpr_history;

/* The reference [m] counts as held until now. */
static inline void scdpr_history_init(scdpr_history *history, const double reference[2])
{
    history->newest = 0;
    for (size_t i = 0; i < SCDPR_HISTORY; ++i) {
        history->reference[i][0] = reference[0];
        history->reference[i][1] = reference[1];
    }
}

static inline void scdpr_history_add(scdpr_history *history, const double reference[2])
{
    history->newest = (history->newest + 1) % SCDPR_HISTORY;
    history->reference[history->newest][0] = reference[0];
    history->reference[history->newest][1] = reference[1];
}

/* Add a region's shaped reference, times its weight [1]. */
static inline void scdpr_add_shaped(const scdpr_history *history, const scdpr_region *region,
                                    double weight, double shaped[2])
{
    for (size_t i = 0; i < region->impulses; ++i) {
        const scdpr_impulse *impulse = &region->impulse[i];
        size_t after = (history->newest + SCDPR_HISTORY - impulse->delay) % SCDPR_HISTORY;
        size_t before = (after + SCDPR_HISTORY - 1) % SCDPR_HISTORY;
        /* Straight between two samples. */
        for (size_t axis = 0; axis < 2; ++axis)
            shaped[axis] += weight * impulse->amplitude
                            * ((1.0 - impulse->fraction) * history->reference[after][axis]
                               + impulse->fraction * history->reference[before][axis]);
    }
}

/* A shaper at work on both coordinates. */
typedef struct {
    const scdpr_region *region;
    scdpr_history history;
} scdpr_shaper;

/* Start at rest: the reference [m] counts as held until now. With a region of NULL the
 * references pass as they are. */
static inline void scdpr_shaper_init(scdpr_shaper *shaper, const scdpr_region *region,
                                     const double reference[2])
{
    shaper->region = region;
    scdpr_history_init(&shaper->history, reference);
}

/* One sample: the reference {x, y} [m] in, the shaped one out; both may be one array. */
static inline void scdpr_shaper_step(scdpr_shaper *shaper, const double reference[2],
                                     double shaped[2])
{
    scdpr_history_add(&shaper->history, reference);
    if (shaper->region == NULL) {
        shaped[0] = reference[0];
        shaped[1] = reference[1];
        return;
    }
    shaped[0] = 0.0;
    shaped[1] = 0.0;
    scdpr_add_shaped(&shaper->history, shaper->region, 1.0, shaped);
}

/* From 0 to 1 with two continuous derivatives, 10 u^3 - 15 u^4 + 6 u^5; held beyond. */
static inline double scdpr_smoothstep(double u)
{
    if (u <= 0.0)
        return 0.0;
    if (u >= 1.0)
        return 1.0;
    return u * u * u * (10.0 + u * (6.0 * u - 15.0));
}

/* How much a stretch of an axis counts at a place [1]. */
static inline double scdpr_stretch_weight(double place, const double stretch[2],
                                          const double handover[2])
{
    double weight = 1.0;
    if (handover[0] > 0.0)
        weight *= scdpr_smoothstep(0.5 + (place - stretch[0]) / handover[0]);
    if (handover[1] > 0.0)
        weight *= scdpr_smoothstep(0.5 - (place - stretch[1]) / handover[1]);
    return weight;
}

/* How much a region's shaper counts at a place {x, y} [m]; those of a setting sum to 1. */
static inline double scdpr_weight(const scdpr_region *region, const double place[2])
{
    return scdpr_stretch_weight(place[0], region->x, region->handover_x)
           * scdpr_stretch_weight(place[1], region->y, region->handover_y);
}

/* The setting next to a pretension [N], or SCDPR_NO_SETTING. */
static inline int scdpr_setting_at(double pretension)
{
    const scdpr_region *next = scdpr_next_setting(pretension);
    return next == NULL ? SCDPR_NO_SETTING : next->setting;
}

/* All shapers of a setting at work on both coordinates. */
typedef struct {
    int setting;
    scdpr_history history;
} scdpr_schedule;

/* Start at rest: the reference [m] counts as held until now. With SCDPR_NO_SETTING the
 * references pass as they are. */
static inline void scdpr_schedule_init(scdpr_schedule *schedule, int setting,
                                       const double reference[2])
{
    schedule->setting = setting;
    scdpr_history_init(&schedule->history, reference);
}

/* One sample: the place {x, y} [m] whose shaper counts and the reference in, the shaped one
 * out; all may be one array. */
static inline void scdpr_schedule_step(scdpr_schedule *schedule, const double place[2],
                                       const double reference[2], double shaped[2])
{
    double blend[2] = {0.0, 0.0};
    scdpr_history_add(&schedule->history, reference);
    if (schedule->setting == SCDPR_NO_SETTING) {
        shaped[0] = reference[0];
        shaped[1] = reference[1];
        return;
    }
    for (size_t i = 0; i < SCDPR_REGIONS; ++i) {
        const scdpr_region *region = &scdpr_regions[i];
        const double weight
            = region->setting == schedule->setting ? scdpr_weight(region, place) : 0.0;
        if (weight > 0.0)
            scdpr_add_shaped(&schedule->history, region, weight, blend);
    }
    shaped[0] = blend[0];
    shaped[1] = blend[1];
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
