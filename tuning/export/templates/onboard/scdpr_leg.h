/* Legs that arrive at rest, planned in the controller.$about
 *
 *     scdpr_leg leg;                        (static: it takes some $kilobytes kB)
 *     int code = scdpr_leg_begin(&leg, state, x, y, time);
 *     while ((code = scdpr_leg_work(&leg, 1)) == 0) { ... }     from cycle to cycle
 *     scdpr_leg_at(&leg, t, angle, feedforward);                every $period s
 *
 * The controller adds its PD on the driver pulleys' angles, V = Kp e + Kd de/dt + feedforward,
 * within the drives' limit. C99, no allocation, no library but libm, no global state; SI units.
 * A leg is one caller's at a time, and it isn't worked on once it is being driven.
 */
#ifndef SCDPR_LEG_H
#define SCDPR_LEG_H

#include <stdbool.h>

#define SCDPR_LEG_SPLINES $splines    /* splines of a leg, at the most */
#define SCDPR_LEG_ROBOTS $robots     /* robots that a leg is planned for */
#define SCDPR_LEG_JUDGED $judged      /* robots that it is judged on */
#define SCDPR_LEG_STEPS $steps    /* steps of the fine grid, at the most */
#define SCDPR_LEG_SAMPLES $samples /* controller's periods in a leg, at the most */
#define SCDPR_LEG_PERIOD $period  /* [s], the controller's */
#define SCDPR_LEG_MOST_TIME $most_time   /* [s], of a leg */

#define SCDPR_LEG_E_NUMBER (-1)   /* a number isn't finite */
#define SCDPR_LEG_E_PLACE (-2)    /* out of the frame */
#define SCDPR_LEG_E_TIME (-3)     /* no positive time, or a leg that takes too long */
#define SCDPR_LEG_E_START (-4)    /* not at rest between the carriages */
#define SCDPR_LEG_E_NOWHERE (-5)  /* the leg leads to where it starts */
#define SCDPR_LEG_E_UNBEGUN (-6)  /* no leg was begun */

/* A motion as it is driven. */
typedef struct {
    double course[7];  /* begin and end of lower carriage and height, their times, the pace */
    double time;       /* of the leg [s] */
    double moving;     /* until the lower carriage holds [s] */
    int splines;
    double coefficient[SCDPR_LEG_SPLINES];
    long samples;
    double feedforward[SCDPR_LEG_SAMPLES][2]; /* [V] */
    double ahead[SCDPR_LEG_SAMPLES + 1];      /* of the lower carriage, as cables give [m] */
} scdpr_leg_motion;

/* A robot on its leg: state, deviation of its drives, and their tangents. */
typedef struct {
    double state[6], aside[2];
    double state_along[SCDPR_LEG_SPLINES][6], aside_along[SCDPR_LEG_SPLINES][2];
} scdpr_leg_robot;

/* All of it is the planner's own. */
typedef struct scdpr_leg {
    unsigned begun;
    /* The leg. */
    double place[2], slope, end[2], asked, time, order;
    bool told;
    int splines;
    double course[7], moving;
    /* The grid at hand. */
    int grid, steps, moves;
    double duration;
    struct {
        double lower, height, value[5];
        int first;
    } half[2 * SCDPR_LEG_STEPS + 1];
    struct {
        double slope[2], curvature[2], slopes[5], curvatures[5], way;
    } begin[SCDPR_LEG_STEPS];
    double servo_middle[2][3], servo_end[2][3];
    /* The search. */
    int stage, attempt, steps_done;
    bool linear;
    double damping, cost;
    double point[SCDPR_LEG_SPLINES], first[SCDPR_LEG_SPLINES], best[SCDPR_LEG_SPLINES];
    double guess[3][SCDPR_LEG_SPLINES];
    double best_cost, first_cost;
    double matrix[SCDPR_LEG_SPLINES][SCDPR_LEG_SPLINES], gradient[SCDPR_LEG_SPLINES];
    double factor[SCDPR_LEG_SPLINES][SCDPR_LEG_SPLINES];
    scdpr_leg_robot robot[SCDPR_LEG_ROBOTS];
    /* What is expected. */
    int judged;
    double vibration[2][SCDPR_LEG_JUDGED], worst, fitted;
    /* Driven, in the making, and the plain profile. */
    scdpr_leg_motion driven, made, plainly;
    bool plain;
} scdpr_leg;

/* state: x_e, delta_e, q_3, q_4, y_e at rest, as the camera or the last leg's end tells it. One
 * that is in line to the bit is taken for what nobody measured: the plan is then made for any
 * start that friction holds. 0, or one of SCDPR_LEG_E... */
int scdpr_leg_begin(scdpr_leg *leg, const double state[5], double x, double y, double time);

/* Up to so many linearisations; 1 done, 0 more to do, < 0 an error. Can be called from cycle to
 * cycle: at any moment scdpr_leg_at gives a leg that can be driven, the best so far. */
int scdpr_leg_work(scdpr_leg *leg, int linearisations);

/* What is expected once it has arrived: peak-to-peak x_e of the robot as fitted, and of the
 * worst that the fit leaves open [m]. NaN where no leg was begun; worst may be null. */
double scdpr_leg_vibration(const scdpr_leg *leg, double *worst);

/* Reference angles [rad] and feed-forward [V] at a time since the begin [s]; the last ones are
 * held. */
void scdpr_leg_at(const scdpr_leg *leg, double t, double angle[2], double feedforward[2]);

/* Time of the leg as planned [s]: longer than asked for where the drives can't do it. */
double scdpr_leg_time(const scdpr_leg *leg);

const char *scdpr_leg_message(int code);

#endif
