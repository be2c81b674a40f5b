/* Legs planned in the controller: see scdpr_leg.h. The equations are printed from those that
 * Python plans with; this is their search, line for line that of `tuning.plan`. */
#include "scdpr_leg.h"

#include <float.h>
#include <string.h>

/* Where a sum is kept in more digits than a double has, a search goes another way than the
 * one that was planned, tested and expected to arrive. */
#if FLT_EVAL_METHOD != 0
#error "doubles aren't rounded as doubles here; on 32-bit x86 add -msse2 -mfpmath=sse"
#endif

$kernels

/* This robot's numbers. */
#define NUMBERS $numbers
enum { SPLINES = SCDPR_LEG_SPLINES, ROBOTS = SCDPR_LEG_ROBOTS, ACTIVE = 5 };

$tables

#define BEGUN 0x5cd94u
static const double REST = $rest, WIDTH = $spline_width;
static const double ARRIVED = $vibration, RESTING = $resting, SLIDING = $sliding;
static const double TRACKING = $tracking, ALLOWED = $allowed_volts, EXCESS = $voltage;
static const double ROUGHNESS = $roughness, OUTSIDE = $outside;
static const double LOW = $guide_low, HIGH = $guide_high;
static const double COARSE = $coarse, LONGER = $longer, STRETCH = $stretch;
static const double STILL = $still, ON_TARGET = $on_target, MOST_VOLTS = $within_volts;
static const double PLAIN_VOLTS = $plain_volts, SHORTEST = $shortest, NEGLIGIBLE = $negligible;
static const double AFTERWARDS = $afterwards, FALL = $fall, RISE = $rise, FLOOR = $floor;
static const double FIRST_DAMPING = $first_damping, LEAST = $least;
static const double JUST_BEFORE = $just_before, UNFORETOLD = $unforetold;
enum { ATTEMPTS = $attempts, REJECTIONS = $rejections, INSTANTS = $instants };
enum { TRACKED = $tracked, COMMANDED = $commanded };

/* What a search does, one after the other. */
enum { FIRST, GUESS, OTHER_GUESS, EXTREME, SECOND_EXTREME, THIRD_EXTREME, ALL, LAST, JUDGE, DONE };
static const struct {
    int steps;
    double saving;
} STAGES[] = {$stages};

static double largest(double a, double b) { return a > b ? a : b; }

static double smallest(double a, double b) { return a < b ? a : b; }

static bool finite_all(const double *x, int count)
{
    for (int i = 0; i < count; i++)
        if (!(fabs(x[i]) <= 1e9))
            return false;
    return true;
}

/* The leg and its profile. */

static void set_time(scdpr_leg *leg, double time)
{
    leg->time = time;
    leg->moving = time - REST;
    double count = rint(leg->moving / WIDTH);
    leg->splines = (int)smallest(largest(count, $fewest_splines), SPLINES);
    leg->course[0] = leg->place[0] + leg->slope * leg->place[1];
    leg->course[1] = leg->place[1];
    leg->course[2] = leg->end[0];
    leg->course[3] = leg->end[1];
    leg->course[4] = leg->moving;
    leg->course[5] = time;
    leg->course[6] = leg->order;
}

/* Where a robot begins that lies out of the leg's line by so much, and where its lower carriage
 * is then. */
static double begin_at(const scdpr_leg *leg, double more, double state[6])
{
    double slope = leg->slope + more, x = leg->place[0], y = leg->place[1];
    state[0] = x;
    state[1] = atan(slope);
    state[2] = x - slope * (FRAME_HEIGHT - y);
    state[3] = state[4] = state[5] = 0;
    return x + slope * y;
}

static double plain_volts(const scdpr_leg *leg)
{
    double state[6], most = 0;
    begin_at(leg, 0, state);
    for (int i = 0; i < INSTANTS; i++) {
        double time = leg->moving / INSTANTS * i, motion[6], volts[2];
        plain_at(leg->course, &time, motion);
        motion[0] = leg->course[0];
        motion[1] = leg->course[1];
        command(FITTED, state, motion, volts);
        most = largest(most, largest(fabs(volts[0]), fabs(volts[1])));
    }
    return most;
}

/* The first plain profile that the drives can follow, or the one that asks the least of them. */
static double set_pace(scdpr_leg *leg)
{
    static const double orders[] = {$orders};
    int count = (int)(sizeof orders / sizeof *orders), least = 0;
    double volts = 0, fewest = HUGE_VAL;
    for (int i = 0; i < count; i++) {
        leg->order = orders[i];
        set_time(leg, leg->time);
        volts = plain_volts(leg);
        if (volts <= PLAIN_VOLTS)
            return volts;
        if (volts < fewest) {
            fewest = volts;
            least = i;
        }
    }
    leg->order = orders[least];
    set_time(leg, leg->time);
    return fewest;
}

/* Where the motion is at an instant: value, slope and curvature of lower carriage and height. */
static void motion_at(const double course[7], double moving, int count, const double *c,
                      double time, double motion[6])
{
    double about[2] = {moving, count}, active[1 + 3 * ACTIVE];
    plain_at(course, &time, motion);
    splines_at(about, &time, active);
    int first = (int)active[0];
    for (int j = 0; j < ACTIVE; j++)
        if (first + j >= 0 && first + j < count)
            for (int k = 0; k < 3; k++)
                motion[2 * k] += c[first + j] * active[1 + k * ACTIVE + j];
}

/* The grid of a leg: everything but what the coefficients change. */
static void set_grid(scdpr_leg *leg, int grid)
{
    int steps = (int)ceil(leg->time / COARSE) * grid;
    double about[2] = {leg->moving, leg->splines};
    double way[7] = {0, 0, 1, 1, leg->time, leg->time, leg->order};
    leg->grid = grid;
    leg->steps = steps;
    leg->duration = leg->time / steps;
    leg->moves = (int)(leg->moving / leg->duration + 0.5);
    for (int k = 0; k <= 2 * steps; k++) {
        double time = leg->duration / 2 * k, motion[6], active[1 + 3 * ACTIVE];
        plain_at(leg->course, &time, motion);
        splines_at(about, &time, active);
        leg->half[k].lower = motion[0];
        leg->half[k].height = motion[1];
        leg->half[k].first = (int)active[0];
        for (int j = 0; j < ACTIVE; j++)
            leg->half[k].value[j] = active[1 + j];
        if (k % 2 || k == 2 * steps)
            continue;
        for (int i = 0; i < 2; i++) {
            leg->begin[k / 2].slope[i] = motion[2 + i];
            leg->begin[k / 2].curvature[i] = motion[4 + i];
        }
        for (int j = 0; j < ACTIVE; j++) {
            leg->begin[k / 2].slopes[j] = active[1 + ACTIVE + j];
            leg->begin[k / 2].curvatures[j] = active[1 + 2 * ACTIVE + j];
        }
        plain_at(way, &time, motion);
        leg->begin[k / 2].way = leg->place[0] + (leg->end[0] - leg->place[0]) * motion[0];
    }
    double middle = leg->duration / 2;
    servo_over(SERVO, &middle, leg->servo_middle[0], leg->servo_middle[1]);
    servo_over(SERVO, &leg->duration, leg->servo_end[0], leg->servo_end[1]);
}

static double lower_at(const scdpr_leg *leg, const double *c, int k)
{
    double place = leg->half[k].lower;
    for (int j = 0; j < ACTIVE; j++) {
        int spline = leg->half[k].first + j;
        if (spline >= 0 && spline < leg->splines)
            place += c[spline] * leg->half[k].value[j];
    }
    return place;
}

/* What splines do at a half step: a number in a row of `wide` for each. */
static void along_at(const scdpr_leg *leg, int k, int count, double *row, int wide)
{
    for (int j = 0; j < ACTIVE; j++) {
        int spline = leg->half[k].first + j;
        if (spline >= 0 && spline < count)
            row[wide * spline] = leg->half[k].value[j];
    }
}

/* A residual, with its derivatives where they are asked for: the first `count` splines'. */
static void add(scdpr_leg *leg, double residual, const double *slope, int count)
{
    leg->cost += residual * residual;
    if (!leg->linear)
        return;
    for (int i = 0; i < count; i++) {
        if (slope[i] == 0)
            continue;
        leg->gradient[i] += residual * slope[i];
        for (int j = 0; j <= i; j++)
            leg->matrix[i][j] += slope[i] * slope[j];
    }
}

/* A stage's robots: the one whose own dynamics are inverted, and how many there are with it. */
static const double *leader_in(int stage)
{
    return stage == GUESS || stage == OTHER_GUESS ? GUESSES[stage - GUESS] : FITTED;
}

static int robots_in(int stage)
{
    return stage <= OTHER_GUESS ? 1 : stage <= THIRD_EXTREME ? 1 + $farthest : ROBOTS;
}

/* The motion at an instant at which commands are looked at, and the splines' part in it. */
struct instant {
    double motion[6], active[3 * ACTIVE];
    int first;
};

static void look_at(const scdpr_leg *leg, const double *c, int k, struct instant *at)
{
    double *motion = at->motion, *active = at->active;
    if (k < 0) { /* Just before the lower carriage holds. */
        double about[2] = {leg->moving, leg->splines}, all[1 + 3 * ACTIVE];
        double time = leg->moving * JUST_BEFORE;
        plain_at(leg->course, &time, motion);
        splines_at(about, &time, all);
        at->first = (int)all[0];
        memcpy(active, all + 1, sizeof at->active);
    } else {
        at->first = leg->half[2 * k].first;
        motion[0] = leg->half[2 * k].lower;
        motion[1] = leg->half[2 * k].height;
        for (int i = 0; i < 2; i++) {
            motion[2 + i] = leg->begin[k].slope[i];
            motion[4 + i] = leg->begin[k].curvature[i];
        }
        for (int j = 0; j < ACTIVE; j++) {
            active[j] = leg->half[2 * k].value[j];
            active[ACTIVE + j] = leg->begin[k].slopes[j];
            active[2 * ACTIVE + j] = leg->begin[k].curvatures[j];
        }
    }
    for (int j = 0; j < ACTIVE; j++)
        if (at->first + j >= 0 && at->first + j < leg->splines)
            for (int i = 0; i < 3; i++)
                motion[2 * i] += c[at->first + j] * active[i * ACTIVE + j];
}

static void commanded(scdpr_leg *leg, const double *robot, const double *c, int k, int count)
{
    scdpr_leg_robot *own = &leg->robot[0];
    double volts[2], along[2][SPLINES], moving[SPLINES][6];
    struct instant at;
    look_at(leg, c, k, &at);
    const double *motion = at.motion;
    command(robot, own->state, motion, volts);
    memset(moving, 0, sizeof moving);
    for (int j = 0; j < ACTIVE; j++)
        if (at.first + j >= 0 && at.first + j < count)
            for (int i = 0; i < 3; i++)
                moving[at.first + j][2 * i] = at.active[i * ACTIVE + j];
    double out = largest(largest(LOW - motion[0], motion[0] - HIGH), 0);
    if (out > 0) {
        double aside[SPLINES];
        for (int i = 0; i < count; i++)
            aside[i] = moving[i][0] * (motion[0] > HIGH ? 1 : -1) / OUTSIDE;
        add(leg, out / OUTSIDE, aside, count);
    }
    if (!(fabs(volts[0]) > ALLOWED || fabs(volts[1]) > ALLOWED))
        return;
    if (leg->linear) {
        double position[SPLINES][3], slopes[SPLINES][2];
        for (int i = 0; i < count; i++)
            memcpy(position[i], own->state_along[i], sizeof position[i]);
        command_along(robot, own->state, motion, position[0], moving[0], volts, slopes[0], count);
        for (int i = 0; i < count; i++)
            for (int d = 0; d < 2; d++)
                along[d][i] = slopes[i][d] * (volts[d] < 0 ? -1 : 1) / EXCESS;
    }
    for (int d = 0; d < 2; d++)
        if (fabs(volts[d]) > ALLOWED)
            add(leg, (fabs(volts[d]) - ALLOWED) / EXCESS, along[d], count);
}

static void tracked(scdpr_leg *leg, int robots, int k, int count)
{
    for (int s = 0; s < robots; s++) {
        double slope[SPLINES], factor = WEIGHT[s] / TRACKING;
        for (int i = 0; i < count; i++)
            slope[i] = leg->robot[s].state_along[i][0] * factor;
        add(leg, (leg->robot[s].state[0] - leg->begin[k].way) * factor, slope, count);
    }
}

static double goal_of(const scdpr_leg *leg, int s, double goal[3])
{
    double shift = SLOPE[leg->told][s] * leg->place[1];
    goal[0] = leg->end[0] + shift + leg->robot[s].aside[0];
    goal[1] = leg->end[0];
    goal[2] = leg->end[1];
    return shift;
}

static void arrived(scdpr_leg *leg, const double *robot, int s)
{
    scdpr_leg_robot *own = &leg->robot[s];
    double goal[3], row[6], slopes[SPLINES][6], goals[SPLINES][3], slope[SPLINES];
    int count = leg->splines;
    goal_of(leg, s, goal);
    if (leg->linear) {
        for (int i = 0; i < count; i++) {
            goals[i][0] = own->aside_along[i][0];
            goals[i][1] = goals[i][2] = 0;
        }
        arrive_along(robot, own->state, goal, own->state_along[0], goals[0], row, slopes[0],
                     count);
    } else {
        arrive(robot, own->state, goal, row);
    }
    for (int k = 0; k < 6; k++) {
        double factor = k < 4 ? WEIGHT[s] / ARRIVED : k < 5 ? WEIGHT[s] / SLIDING : RESTS[s] / RESTING;
        for (int i = 0; i < count; i++)
            slope[i] = leg->linear ? slopes[i][k] * factor : 0;
        add(leg, row[k] * factor, slope, count);
    }
}

/* Robots led along the leg, with their residuals. */
static double misfit(scdpr_leg *leg, const double *c, int stage, bool linear)
{
    const double *fitted = leader_in(stage);
    int robots = robots_in(stage), count = leg->splines;
    leg->cost = 0;
    leg->linear = linear;
    if (linear) {
        memset(leg->matrix, 0, sizeof leg->matrix);
        memset(leg->gradient, 0, sizeof leg->gradient);
    }
    for (int s = 0; s < robots; s++) {
        memset(&leg->robot[s], 0, sizeof leg->robot[s]);
        begin_at(leg, SLOPE[leg->told][s], leg->robot[s].state);
    }
    for (int k = 0; k < leg->steps; k++) {
        double lower[3], height[3], rate = leg->begin[k].slope[0], pull;
        double along[SPLINES][3], pull_along[SPLINES];
        /* Splines that have begun by the end of the step. */
        int began = leg->half[2 * k + 1].first + ACTIVE + 1;
        int active = 2 * k + 2 >= 2 * leg->moves || began > count ? count : began;
        for (int i = 0; i < 3; i++) {
            lower[i] = lower_at(leg, c, 2 * k + i);
            height[i] = leg->half[2 * k + i].height;
        }
        if (k < leg->moves && k % TRACKED == 0)
            tracked(leg, robots, k, active);
        if (k < leg->moves && k % COMMANDED == 0)
            commanded(leg, fitted, c, k, active);
        if (k == (int)(leg->moving / leg->duration))
            commanded(leg, fitted, c, -1, count);
        if (linear) {
            memset(along, 0, sizeof along[0] * (size_t)active);
            for (int i = 0; i < 3; i++)
                along_at(leg, 2 * k + i, active, &along[0][i], 3);
        }
        if (robots > 1) {
            scdpr_leg_robot *own = &leg->robot[0];
            double place[2] = {lower[0], height[0]};
            int first = leg->half[2 * k].first;
            for (int j = 0; j < ACTIVE; j++)
                if (first + j >= 0 && first + j < count)
                    rate += c[first + j] * leg->begin[k].slopes[j];
            if (linear) {
                double position[SPLINES][3], places[SPLINES][2];
                for (int i = 0; i < active; i++) {
                    memcpy(position[i], own->state_along[i], sizeof position[i]);
                    places[i][0] = along[i][0];
                    places[i][1] = 0;
                }
                force_along(fitted, own->state, place, &rate, position[0], places[0], &pull,
                            pull_along, active);
            } else {
                force(fitted, own->state, place, &rate, &pull);
            }
        }
        for (int s = 0; s < robots; s++) {
            scdpr_leg_robot *own = &leg->robot[s];
            double shift = SLOPE[leg->told][s] * leg->place[1], place[3];
            for (int i = 0; i < 3; i++)
                place[i] = lower[i] + shift;
            if (s == 0 && linear)
                lead_along(fitted, &leg->duration, own->state, place, height,
                           own->state_along[0], along[0], own->state, own->state_along[0],
                           active);
            else if (s == 0)
                lead(fitted, &leg->duration, own->state, place, height, own->state);
            else if (linear)
                deviate_along(OTHERS[s - 1], &leg->duration, SERVO, leg->servo_middle[0],
                              leg->servo_middle[1], leg->servo_end[0], leg->servo_end[1],
                              own->state, own->aside, place, height, &rate, &pull,
                              own->state_along[0], own->aside_along[0], along[0],
                              pull_along, own->state, own->aside, own->state_along[0],
                              own->aside_along[0], active);
            else
                deviate(OTHERS[s - 1], &leg->duration, SERVO, leg->servo_middle[0],
                        leg->servo_middle[1], leg->servo_end[0], leg->servo_end[1], own->state,
                        own->aside, place, height, &rate, &pull, own->state, own->aside);
        }
    }
    for (int s = 0; s < robots; s++)
        arrived(leg, s ? OTHERS[s - 1] : fitted, s);
    for (int i = 0; i + 2 < count; i++) {
        double slope[SPLINES] = {0};
        slope[i] = slope[i + 2] = 1 / ROUGHNESS;
        slope[i + 1] = -2 / ROUGHNESS;
        add(leg, (c[i] - 2 * c[i + 1] + c[i + 2]) / ROUGHNESS, slope, i + 3);
    }
    return isfinite(leg->cost) ? leg->cost : HUGE_VAL;
}

/* A step of Levenberg and Marquardt's; false where its matrix has no root. */
static bool damped_step(scdpr_leg *leg, double damping, double *step)
{
    int n = leg->splines;
    double trace = 0, scale[SPLINES];
    for (int i = 0; i < n; i++)
        trace += leg->matrix[i][i];
    for (int i = 0; i < n; i++) {
        double diagonal = leg->matrix[i][i] + FLOOR * trace;
        if (!(diagonal > 0) || !isfinite(diagonal))
            return false;
        scale[i] = 1 / sqrt(diagonal);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            double sum = leg->matrix[i][j] * scale[i] * scale[j] + (i == j ? damping : 0);
            for (int k = 0; k < j; k++)
                sum -= leg->factor[i][k] * leg->factor[j][k];
            if (i == j && !(sum > 0))
                return false;
            leg->factor[i][j] = i == j ? sqrt(sum) : sum / leg->factor[j][j];
        }
    for (int i = 0; i < n; i++) {
        double sum = -leg->gradient[i] * scale[i];
        for (int k = 0; k < i; k++)
            sum -= leg->factor[i][k] * step[k];
        step[i] = sum / leg->factor[i][i];
    }
    for (int i = n - 1; i >= 0; i--) {
        double sum = step[i];
        for (int k = i + 1; k < n; k++)
            sum -= leg->factor[k][i] * step[k];
        step[i] = sum / leg->factor[i][i];
    }
    for (int i = 0; i < n; i++)
        step[i] *= scale[i];
    return true;
}

/* One linearisation and the step that follows; true where the stage has ended. */
static bool descend(scdpr_leg *leg)
{
    int n = leg->splines;
    double step[SPLINES], candidate[SPLINES];
    double before = misfit(leg, leg->point, leg->stage, true);
    if (leg->steps_done == 0)
        leg->damping = FIRST_DAMPING;
    for (int k = 0; k < REJECTIONS; k++) {
        if (!damped_step(leg, leg->damping, step))
            break;
        for (int i = 0; i < n; i++)
            candidate[i] = leg->point[i] + step[i];
        double after = misfit(leg, candidate, leg->stage, false);
        if (after < before) {
            memcpy(leg->point, candidate, sizeof candidate[0] * (size_t)n);
            leg->damping = largest(leg->damping / FALL, LEAST);
            leg->steps_done++;
            leg->cost = after;
            return before - after < STAGES[leg->stage].saving * after ||
                   leg->steps_done >= STAGES[leg->stage].steps;
        }
        leg->damping *= RISE;
    }
    leg->cost = before;
    return true;
}

/* A motion as the controller is told it. */
static void tell(const scdpr_leg *leg, const double *c, scdpr_leg_motion *made)
{
    double period = SCDPR_LEG_PERIOD, state[6], half = period / 2;
    memcpy(made->course, leg->course, sizeof made->course);
    memset(made->coefficient, 0, sizeof made->coefficient);
    memcpy(made->coefficient, c, sizeof *c * (size_t)leg->splines);
    made->time = leg->time;
    made->moving = leg->moving;
    made->splines = leg->splines;
    made->samples = (long)ceil(leg->time / period - 1e-9);
    begin_at(leg, 0, state);
    for (long k = 0; k < 2 * made->samples; k++) {
        double lower[3], height[3], motion[6];
        for (int i = 0; i < 3; i++) {
            motion_at(made->course, made->moving, made->splines, c, half * (k + i / 2.0),
                      motion);
            lower[i] = motion[0];
            height[i] = motion[1];
        }
        motion_at(made->course, made->moving, made->splines, c, half * k, motion);
        if (k % 2)
            command(FITTED, state, motion, made->feedforward[k / 2]);
        else
            stretch(FITTED, state, motion, &made->ahead[k / 2]);
        lead(FITTED, &half, state, lower, height, state);
    }
    double motion[6];
    motion_at(made->course, made->moving, made->splines, c, period * made->samples, motion);
    stretch(FITTED, state, motion, &made->ahead[made->samples]);
    made->ahead[0] = 0;
}

/* The curve of section 6.2 in the time that was asked for, without feed-forward. */
static void tell_plainly(const scdpr_leg *leg, scdpr_leg_motion *made)
{
    double course[7] = {leg->place[0], leg->place[1], leg->end[0], leg->end[1],
                        leg->asked, leg->asked, 2};
    memcpy(made->course, course, sizeof course);
    memset(made->coefficient, 0, sizeof made->coefficient);
    made->time = leg->asked;
    made->moving = leg->asked;
    made->splines = $fewest_splines;
    made->samples = (long)ceil(leg->asked / SCDPR_LEG_PERIOD - 1e-9);
    memset(made->feedforward, 0, sizeof made->feedforward[0] * (size_t)made->samples);
    memset(made->ahead, 0, sizeof made->ahead);
}

/* `gives`: 1, or the share of the cables' give that leads the closed loop in simulation astray,
 * where they don't give. */
static void drive_at(const scdpr_leg_motion *motion, double t, double gives, double angle[2],
                     double feedforward[2])
{
    double place[6], begin[2] = {motion->course[0], motion->course[1]};
    double time = t > 0 ? smallest(t, motion->time) : 0;
    motion_at(motion->course, motion->moving, motion->splines, motion->coefficient, time, place);
    double sample = t > 0 ? floor(t / SCDPR_LEG_PERIOD + 1e-6) : 0, ahead;
    bool over = !(sample < motion->samples);
    if (over) {
        ahead = motion->ahead[motion->samples];
    } else {
        const double *now = &motion->ahead[(long)sample];
        double part = largest(time / SCDPR_LEG_PERIOD - sample, 0);
        ahead = now[0] + smallest(part, 1) * (now[1] - now[0]);
    }
    place[0] += gives * ahead;
    angle[0] = ((place[0] - begin[0]) + (place[1] - begin[1])) / RADIUS;
    angle[1] = ((place[0] - begin[0]) - (place[1] - begin[1])) / RADIUS;
    feedforward[0] = over ? 0 : motion->feedforward[(long)sample][0];
    feedforward[1] = over ? 0 : motion->feedforward[(long)sample][1];
}

/* Peak to peak of a robot under a motion, by the whole closed loop. */
static double judged(const scdpr_leg *leg, const scdpr_leg_motion *motion, int s)
{
    const double *robot = s ? OTHERS[s - 1] : FITTED;
    double undriven[6], state[10] = {0}, memory[4] = {0}, low = HUGE_VAL, high = -HUGE_VAL;
    double begin[2] = {begin_at(leg, SLOPE[leg->told][s], undriven), leg->place[1]};
    long after = (long)rint(AFTERWARDS / SCDPR_LEG_PERIOD);
    state[0] = undriven[0];
    state[1] = undriven[1];
    state[2] = begin[0];
    state[3] = undriven[2];
    state[4] = begin[1];
    for (long k = 0; k <= motion->samples + after; k++) {
        double angle[2], feedforward[2];
        if (k >= motion->samples) {
            low = smallest(low, state[0]);
            high = largest(high, state[0]);
        }
        drive_at(motion, k * SCDPR_LEG_PERIOD, UNFORETOLD, angle, feedforward);
        loop(robot, CONTROLLER, begin, state, memory, angle, feedforward, state, memory);
    }
    return high - low;
}

/* The reduced model's own word on coefficients: vibration, rest and commands of the fitted
 * robot, and the largest vibration of all. */
static bool is_good(scdpr_leg *leg, const double *c)
{
    double goal[3], vibration, row[6], most = 0;
    misfit(leg, c, FIRST, false);
    goal_of(leg, 0, goal);
    vibrate(FITTED, leg->robot[0].state, goal, &vibration);
    arrive(FITTED, leg->robot[0].state, goal, row);
    begin_at(leg, 0, leg->robot[0].state);
    for (int k = 0; k < leg->steps; k++) {
        double lower[3], height[3], volts[2];
        struct instant at;
        for (int i = 0; i < 3; i++) {
            lower[i] = lower_at(leg, c, 2 * k + i);
            height[i] = leg->half[2 * k + i].height;
        }
        if (k < leg->moves && k % COMMANDED == 0) {
            look_at(leg, c, k, &at);
            command(FITTED, leg->robot[0].state, at.motion, volts);
            most = largest(most, largest(fabs(volts[0]), fabs(volts[1])));
        }
        if (k == (int)(leg->moving / leg->duration)) {
            look_at(leg, c, -1, &at);
            command(FITTED, leg->robot[0].state, at.motion, volts);
            most = largest(most, largest(fabs(volts[0]), fabs(volts[1])));
        }
        lead(FITTED, &leg->duration, leg->robot[0].state, lower, height, leg->robot[0].state);
    }
    return vibration <= STILL && fabs(row[5]) <= ON_TARGET && most <= MOST_VOLTS;
}

static void start_stage(scdpr_leg *leg, int stage, const double *from)
{
    leg->stage = stage;
    leg->steps_done = 0;
    if (from)
        memcpy(leg->point, from, sizeof leg->point);
    else
        memset(leg->point, 0, sizeof leg->point);
}

static void start_search(scdpr_leg *leg, double time)
{
    set_time(leg, time);
    set_pace(leg);
    set_grid(leg, 1);
    start_stage(leg, FIRST, 0);
}

/* The fitted robot's motion, if it is expected to leave less than the plain profile. */
static void offer_first(scdpr_leg *leg)
{
    tell(leg, leg->first, &leg->made);
    double expected = judged(leg, &leg->made, 0);
    if (expected > leg->fitted && expected > NEGLIGIBLE)
        return;
    memcpy(&leg->driven, &leg->made, sizeof leg->made);
    leg->plain = false;
    leg->fitted = leg->worst = expected;
}

static void end_stage(scdpr_leg *leg)
{
    switch (leg->stage) {
    case FIRST:
        memcpy(leg->first, leg->point, sizeof leg->point);
        if (leg->attempt + 1 < ATTEMPTS && !is_good(leg, leg->first) &&
            leg->time * LONGER <= SCDPR_LEG_MOST_TIME) {
            leg->attempt++;
            start_search(leg, leg->time * LONGER);
            return;
        }
        offer_first(leg);
        start_stage(leg, GUESS, 0);
        return;
    case GUESS:
        memcpy(leg->guess[1], leg->point, sizeof leg->point);
        start_stage(leg, OTHER_GUESS, 0);
        return;
    case OTHER_GUESS:
        memcpy(leg->guess[2], leg->point, sizeof leg->point);
        memset(leg->guess[0], 0, sizeof leg->guess[0]);
        leg->best_cost = HUGE_VAL;
        start_stage(leg, EXTREME, leg->guess[0]);
        return;
    case EXTREME:
    case SECOND_EXTREME:
    case THIRD_EXTREME:
        if (leg->cost < leg->best_cost) {
            leg->best_cost = leg->cost;
            memcpy(leg->best, leg->point, sizeof leg->point);
        }
        if (leg->stage < THIRD_EXTREME)
            start_stage(leg, leg->stage + 1, leg->guess[leg->stage + 1 - EXTREME]);
        else
            start_stage(leg, ALL, leg->best);
        return;
    case ALL:
        memcpy(leg->best, leg->point, sizeof leg->point);
        set_grid(leg, 2);
        start_stage(leg, LAST, leg->best);
        return;
    default:
        leg->best_cost = leg->cost;
        leg->first_cost = misfit(leg, leg->first, LAST, false);
        tell(leg, leg->first_cost < leg->best_cost ? leg->first : leg->point, &leg->made);
        leg->stage = JUDGE;
        leg->judged = 0;
        return;
    }
}

/* The made motion and the plain one on the robots that they are judged on, one at a time. */
static void judge(scdpr_leg *leg)
{
    int s = leg->judged / 2, which = leg->judged % 2;
    if (which == 0) {
        leg->vibration[0][s] = judged(leg, &leg->made, s);
        leg->judged++;
        return;
    }
    leg->vibration[1][s] = judged(leg, &leg->plainly, s);
    if (++leg->judged < 2 * SCDPR_LEG_JUDGED)
        return;
    double mean[2] = {0, 0}, worst[2] = {0, 0};
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < SCDPR_LEG_JUDGED; i++) {
            mean[k] += leg->vibration[k][i] / SCDPR_LEG_JUDGED;
            worst[k] = largest(worst[k], leg->vibration[k][i]);
        }
    leg->plain = mean[1] < mean[0] && mean[0] > NEGLIGIBLE;
    memcpy(&leg->driven, leg->plain ? &leg->plainly : &leg->made, sizeof leg->made);
    leg->fitted = leg->vibration[leg->plain][0];
    leg->worst = worst[leg->plain];
    leg->stage = DONE;
}

int scdpr_leg_begin(scdpr_leg *leg, const double state[5], double x, double y, double time)
{
    const double asked[3] = {x, y, time};
    leg->begun = 0;
    if (!finite_all(state, 5) || !finite_all(asked, 3))
        return SCDPR_LEG_E_NUMBER;
    if (!(time > 0) || time > SCDPR_LEG_MOST_TIME)
        return SCDPR_LEG_E_TIME;
    /* The line through the three places, by least squares: see `resting_start`. */
    const double heights[3] = {state[4], 0, FRAME_HEIGHT};
    const double places[3] = {state[0], state[2], state[3]};
    double middle = (heights[0] + heights[1] + heights[2]) / 3, sum = 0, squares = 0;
    for (int i = 0; i < 3; i++) {
        sum += (heights[i] - middle) * places[i];
        squares += (heights[i] - middle) * (heights[i] - middle);
    }
    bool in_line = state[0] == state[2] && state[2] == state[3];
    leg->told = !in_line;
    leg->slope = in_line ? 0 : -sum / squares;
    leg->place[0] = in_line ? state[0]
                            : (places[0] + places[1] + places[2]) / 3 -
                                  leg->slope * (heights[0] - middle);
    leg->place[1] = state[4];
    leg->end[0] = x;
    leg->end[1] = y;
    for (int i = 0; i < 2; i++) {
        const double *own = i ? leg->end : leg->place;
        if (!(own[0] >= 0 && own[0] <= FRAME_WIDTH && own[1] > LOWEST && own[1] < HIGHEST))
            return SCDPR_LEG_E_PLACE;
    }
    double away = fabs(leg->place[0] - leg->slope * (0 - leg->place[1]) - state[2]);
    if (fabs(leg->slope) > STEEPEST || away > 5e-3 || fabs(state[1] - leg->slope) > 2e-2)
        return SCDPR_LEG_E_START;
    if (leg->place[0] == x && leg->place[1] == y)
        return SCDPR_LEG_E_NOWHERE;
    leg->asked = time;
    leg->attempt = 0;
    set_time(leg, largest(time, SHORTEST));
    while (set_pace(leg) > PLAIN_VOLTS && leg->time * STRETCH <= SCDPR_LEG_MOST_TIME)
        set_time(leg, leg->time * STRETCH);
    tell_plainly(leg, &leg->plainly);
    memcpy(&leg->driven, &leg->plainly, sizeof leg->plainly);
    leg->plain = true;
    leg->fitted = leg->worst = judged(leg, &leg->driven, 0);
    start_search(leg, leg->time);
    leg->begun = BEGUN;
    return 0;
}

int scdpr_leg_work(scdpr_leg *leg, int linearisations)
{
    if (leg->begun != BEGUN)
        return SCDPR_LEG_E_UNBEGUN;
    for (int k = 0; k < linearisations && leg->stage != DONE; k++) {
        if (leg->stage == JUDGE)
            judge(leg);
        else if (descend(leg))
            end_stage(leg);
    }
    return leg->stage == DONE;
}

double scdpr_leg_vibration(const scdpr_leg *leg, double *worst)
{
    bool begun = leg->begun == BEGUN;
    if (worst)
        *worst = begun ? leg->worst : NAN;
    return begun ? leg->fitted : NAN;
}

void scdpr_leg_at(const scdpr_leg *leg, double t, double angle[2], double feedforward[2])
{
    angle[0] = angle[1] = feedforward[0] = feedforward[1] = 0;
    if (leg->begun == BEGUN)
        drive_at(&leg->driven, t, 1, angle, feedforward);
}

double scdpr_leg_time(const scdpr_leg *leg)
{
    return leg->begun == BEGUN ? leg->driven.time : 0;
}

const char *scdpr_leg_message(int code)
{
    switch (code) {
    case 1:
        return "the leg is planned";
    case 0:
        return "there is more to do";
    case SCDPR_LEG_E_NUMBER:
        return "a number isn't finite: give metres, radians and seconds";
    case SCDPR_LEG_E_PLACE:
        return "a place is out of the frame: give x_e and y_e within it, in metres";
    case SCDPR_LEG_E_TIME:
        return "the leg's time isn't positive, or longer than SCDPR_LEG_MOST_TIME";
    case SCDPR_LEG_E_START:
        return "the state isn't one at rest: give x_e, delta_e, q_3, q_4, y_e in this order";
    case SCDPR_LEG_E_NOWHERE:
        return "the leg leads to where it starts";
    case SCDPR_LEG_E_UNBEGUN:
        return "no leg was begun: call scdpr_leg_begin first";
    default:
        return "an unknown code";
    }
}
