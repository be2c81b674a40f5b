/* A leg planned and driven in simulation: what a controller's program does.
 *
 *     cc -std=c99 -O2 example.c scdpr_leg.c -lm -o example && ./example
 */
#include "scdpr_leg.h"

#include <stdio.h>

static scdpr_leg leg;

int main(void)
{
    /* x_e, delta_e, q_3, q_4, y_e: from the camera, or where the last leg ended. */
    const double state[5] = {$state};
    double worst, vibration, angle[2], feedforward[2];
    int cycles = 0, code = scdpr_leg_begin(&leg, state, $x, $y, $time);
    while (code == 0) {
        /* Here the controller does its cycle; scdpr_leg_at gives a leg at any moment. */
        code = scdpr_leg_work(&leg, 1);
        cycles++;
    }
    if (code < 0) {
        fprintf(stderr, "scdpr_leg: %s\n", scdpr_leg_message(code));
        return 1;
    }
    vibration = scdpr_leg_vibration(&leg, &worst);
    printf("# planned in %d linearisations: %.3f s, %.3f mm, at worst %.3f mm\n", cycles,
           scdpr_leg_time(&leg), 1e3 * vibration, 1e3 * worst);
    printf("t [s],alpha_ref_1 [rad],alpha_ref_2 [rad],feedforward_1 [V],feedforward_2 [V]\n");
    for (long k = 0; k * SCDPR_LEG_PERIOD <= scdpr_leg_time(&leg) + SCDPR_LEG_PERIOD; k++) {
        scdpr_leg_at(&leg, k * SCDPR_LEG_PERIOD, angle, feedforward);
        printf("%.6f,%.9f,%.9f,%.9f,%.9f\n", k * SCDPR_LEG_PERIOD, angle[0], angle[1],
               feedforward[0], feedforward[1]);
    }
    return 0;
}
