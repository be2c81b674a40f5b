/* Whether this compiler and this processor plan as Python did: exit status 0.
 *
 *     cc -std=c99 -O2 selftest.c scdpr_leg.c -lm -o selftest && ./selftest
 */
#include "scdpr_leg.h"

#include <math.h>
#include <stdio.h>

static scdpr_leg leg;

/* State, target, time that is asked for; time, and angles and commands at some instants. */
static const struct {
    double state[5], x, y, asked, time;
    double row[$instants][5];
} LEGS[] = {
$legs
};

int main(void)
{
    int count = (int)(sizeof LEGS / sizeof *LEGS), wrong = 0;
    for (int i = 0; i < count; i++) {
        double angle[2], feedforward[2], off = 0, volts = 0;
        int code = scdpr_leg_begin(&leg, LEGS[i].state, LEGS[i].x, LEGS[i].y, LEGS[i].asked);
        while (code == 0)
            code = scdpr_leg_work(&leg, 10);
        for (int k = 0; k < $instants; k++) {
            const double *row = LEGS[i].row[k];
            scdpr_leg_at(&leg, row[0], angle, feedforward);
            for (int j = 0; j < 2; j++) {
                off = fmax(off, fabs(angle[j] - row[1 + j]));
                volts = fmax(volts, fabs(feedforward[j] - row[3 + j]));
            }
        }
        bool same = code == 1 && fabs(scdpr_leg_time(&leg) - LEGS[i].time) < 1e-9 &&
                    off < 1e-6 && volts < 1e-3;
        printf("leg %d: %s (%.1e rad, %.1e V)\n", i + 1, same ? "as Python plans it" : "DIFFERS",
               off, volts);
        wrong += !same;
    }
    /* A kink may turn a search to another minimum on another processor: one leg in twenty. */
    return wrong > 1;
}
